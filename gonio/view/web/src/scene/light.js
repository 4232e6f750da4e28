// Pictures of light: brightness tables for sampling.

const lum = (p, i) => 0.2126 * p[4 * i] + 0.7152 * p[4 * i + 1] + 0.0722 * p[4 * i + 2];

/** Rows of (share kept, index of the other, density in 1/sr, 0): Walker's alias method over the texels. */
export function aliasTable(pixels, width, height) {
    const n = width * height,
        weight = new Float64Array(n);
    let sum = 0;
    for (let y = 0; y < height; y++) {
        const s = Math.sin(((y + 0.5) / height) * Math.PI);
        for (let x = 0; x < width; x++) {
            // Radiance is interpolated: a dark texel is lit by its neighbours and must be found as well
            let most = 0;
            for (let j = -1; j <= 1; j++) {
                for (let i = -1; i <= 1; i++) {
                    most = Math.max(
                        most,
                        lum(pixels, Math.min(height - 1, Math.max(0, y + j)) * width + ((x + i + width) % width)),
                    );
                }
            }
            sum += weight[y * width + x] = (0.5 * most + 0.5 * lum(pixels, y * width + x)) * s;
        }
    }
    const table = new Float32Array(4 * n);
    if (!(sum > 0)) return table;
    const scaled = weight.map((w) => (w * n) / sum),
        small = [],
        large = [];
    const keep = new Float64Array(n).fill(1),
        other = new Uint32Array(n);
    for (let i = 0; i < n; i++) (scaled[i] < 1 ? small : large).push(i);
    while (small.length && large.length) {
        const a = small.pop(),
            b = large[large.length - 1];
        keep[a] = scaled[a];
        other[a] = b;
        scaled[b] += scaled[a] - 1;
        if (scaled[b] < 1) small.push(large.pop());
    }
    for (let i = 0; i < n; i++) {
        const s = Math.sin(((Math.floor(i / width) + 0.5) / height) * Math.PI);
        table.set([keep[i], other[i], ((weight[i] / sum) * n) / (2 * Math.PI * Math.PI * s), 0], 4 * i);
    }
    return table;
}

/** The direction of the brightest texel, as the trace pass maps them. */
export function brightest(pixels, width, height) {
    let at = 0;
    for (let i = 0; i < width * height; i++) if (lum(pixels, i) > lum(pixels, at)) at = i;
    const th = ((Math.floor(at / width) + 0.5) / height) * Math.PI,
        ph = (((at % width) + 0.5) / width) * 2 * Math.PI;
    return [-Math.sin(th) * Math.sin(ph), Math.cos(th), Math.sin(th) * Math.cos(ph)];
}

/** Albedo of matte ground that looks as the picture does below the horizon behind the object, as gonio render has it. */
export function groundColour({ pixels, width, height }, azimuth, { band, reach, albedo }) {
    const up = [0, 0, 0],
        seen = [0, 0, 0];
    for (let y = 0; y < height; y++) {
        const theta = ((y + 0.5) / height) * Math.PI,
            solid = Math.cos(theta) * Math.sin(theta) * (Math.PI / height) * ((2 * Math.PI) / width);
        if (solid > 0)
            for (let x = 0; x < width; x++)
                for (let c = 0; c < 3; c++) up[c] += pixels[4 * (y * width + x) + c] * solid;
    }
    const [low, high] = band.map((angle) => Math.floor((height * (90 + angle)) / 180)),
        middle = width / 2 + (azimuth / 360) * width,
        half = (width * reach) / 360;
    let n = 0;
    for (let y = low; y < Math.max(high, low + 1); y++)
        for (let x = Math.floor(middle - half); x <= Math.floor(middle + half); x++, n++) {
            for (let c = 0; c < 3; c++) seen[c] += pixels[4 * (y * width + (((x % width) + width) % width)) + c];
        }
    return seen.map((s, c) => Math.min(albedo[1], Math.max(albedo[0], (Math.PI * s) / n / Math.max(up[c], 1e-12))));
}
