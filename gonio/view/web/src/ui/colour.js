// Colours between linear Rec. 709, sRGB's eight bits, and hue, saturation, value.

export const encode = (x) => (x <= 0.0031308 ? 12.92 * Math.max(x, 0) : 1.055 * Math.min(x, 1) ** (1 / 2.4) - 0.055);
export const decode = (y) => (y <= 0.04045 ? y / 12.92 : ((y + 0.055) / 1.055) ** 2.4);
export const css = (linear) => `rgb(${linear.map((x) => Math.round(255 * encode(x))).join(" ")})`;
export const hex = (linear) =>
    `#${linear
        .map((x) =>
            Math.round(255 * encode(x))
                .toString(16)
                .padStart(2, "0"),
        )
        .join("")
        .toUpperCase()}`;

export function fromHex(text) {
    const found = /^#?([0-9a-f]{6}|[0-9a-f]{3})$/i.exec(text.trim());
    if (!found) return null;
    const long = found[1].length === 3 ? [...found[1]].map((c) => c + c).join("") : found[1];
    return [0, 2, 4].map((i) => decode(parseInt(long.slice(i, i + 2), 16) / 255));
}

export function toHsv(linear) {
    const [r, g, b] = linear.map(encode),
        v = Math.max(r, g, b),
        c = v - Math.min(r, g, b);
    const h = c === 0 ? 0 : v === r ? ((g - b) / c + 6) % 6 : v === g ? (b - r) / c + 2 : (r - g) / c + 4;
    return [h * 60, v === 0 ? 0 : c / v, v];
}

export function fromHsv([h, s, v]) {
    const f = (n) => {
        const k = (n + h / 60) % 6;
        return v - v * s * Math.max(0, Math.min(k, 4 - k, 1));
    };
    return [f(5), f(3), f(1)].map(decode);
}
