// Radiance pictures (.hdr): run-length coded or flat, with a shared exponent.

export function readRgbe(buffer, pixelsMax) {
    const bytes = new Uint8Array(buffer);
    let at = 0;
    const line = () => {
        let text = "";
        while (at < bytes.length && bytes[at] !== 10) text += String.fromCharCode(bytes[at++]);
        at++;
        return text.trim();
    };
    if (!/^#\?(RADIANCE|RGBE)/.test(line())) throw new Error("Its first line is not #?RADIANCE.");
    let format = "";
    for (let text = line(); text; text = line()) {
        if (text.startsWith("FORMAT=")) format = text.slice(7);
        if (at >= bytes.length) break;
    }
    if (format && format !== "32-bit_rle_rgbe")
        throw new Error(`Its format is ${format}; the page reads 32-bit_rle_rgbe.`);
    const size = /^([-+])Y (\d+) ([-+])X (\d+)$/.exec(line());
    if (!size) throw new Error("The line with its size cannot be read.");
    const height = Number(size[2]),
        width = Number(size[4]);
    if (width * height > pixelsMax || !width || !height)
        throw new Error(
            `It has ${(width * height).toLocaleString("en")} pixels; the page takes ${pixelsMax.toLocaleString("en")}.`,
        );
    const pixels = new Float32Array(4 * width * height),
        row = new Uint8Array(4 * width),
        short = () => new Error("The file ends too early.");
    for (let y = 0; y < height; y++) {
        if (at + 4 > bytes.length) throw short();
        if (
            width >= 8 &&
            width < 32768 &&
            bytes[at] === 2 &&
            bytes[at + 1] === 2 &&
            ((bytes[at + 2] << 8) | bytes[at + 3]) === width
        ) {
            at += 4;
            for (let c = 0; c < 4; c++) {
                for (let x = 0; x < width; ) {
                    if (at >= bytes.length) throw short();
                    let n = bytes[at++];
                    const run = n > 128;
                    if (run) n -= 128;
                    if (!n || x + n > width || at + (run ? 1 : n) > bytes.length)
                        throw new Error("Its runs are damaged.");
                    if (run) {
                        for (const value = bytes[at++]; n--; ) row[4 * x++ + c] = value;
                    } else while (n--) row[4 * x++ + c] = bytes[at++];
                }
            }
        } else {
            if (at + 4 * width > bytes.length) throw short();
            row.set(bytes.subarray(at, at + 4 * width));
            at += 4 * width;
        }
        const line_ = size[1] === "-" ? y : height - 1 - y;
        for (let x = 0; x < width; x++) {
            const scale = row[4 * x + 3] ? 2 ** (row[4 * x + 3] - 136) : 0,
                to = 4 * (line_ * width + (size[3] === "+" ? x : width - 1 - x));
            for (let c = 0; c < 3; c++) pixels[to + c] = row[4 * x + c] * scale;
        }
    }
    return { width, height, pixels };
}
