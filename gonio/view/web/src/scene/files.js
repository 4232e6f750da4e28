// Files that are dropped on the page: pictures of light (.hdr, .exr) and meshes (.obj, .glb). They never leave it.

import { readGlb } from "./glb.js";
import { readObj } from "./obj.js";
import { readRgbe } from "./rgbe.js";

export const TRIANGLES_MAX = 500_000;
const PIXELS_MAX = 1 << 25,
    SKY_WIDTH_MAX = 2048,
    BYTES_MAX = 1 << 28,
    HALF_MAX = 65504;

const name = (file) => file.name.slice(file.name.lastIndexOf(".")).toLowerCase();
const many = (n) => n.toLocaleString("en");

/** What a file holds: {picture} or {mesh, height}; an error says why it was not taken. */
export async function openFile(file) {
    if (file.size > BYTES_MAX)
        throw new Error(`It has ${many(Math.round(file.size / 2 ** 20))} MB; the page takes ${BYTES_MAX / 2 ** 20}.`);
    const kind = name(file);
    if (kind === ".hdr") return light(readRgbe(await file.arrayBuffer(), PIXELS_MAX));
    if (kind === ".exr") return light(await readExr(await file.arrayBuffer()));
    if (kind === ".obj") return stage(readObj(await file.text(), TRIANGLES_MAX));
    if (kind === ".glb") return stage(readGlb(await file.arrayBuffer(), TRIANGLES_MAX));
    throw new Error("The page takes .hdr and .exr pictures of light, and .obj and .glb meshes.");
}

async function readExr(buffer) {
    const { default: parse } = await import("parse-exr");
    const head = new DataView(buffer);
    if (buffer.byteLength < 8 || head.getUint32(0, true) !== 20000630)
        throw new Error("It does not begin as an OpenEXR file does.");
    let found;
    try {
        found = parse(buffer, 1015);
    } catch (error) {
        // What the reader stumbles over says nothing of the file
        const why = error instanceof TypeError || error instanceof RangeError ? "" : String(error.message ?? error);
        throw new Error(`This EXR cannot be read: ${why.replace(/\.$/, "") || "its header or its data are damaged"}.`);
    }
    const { width, height, data } = found,
        channels = data.length / (width * height);
    if (width * height > PIXELS_MAX)
        throw new Error(`It has ${many(width * height)} pixels; the page takes ${many(PIXELS_MAX)}.`);
    const pixels = new Float32Array(4 * width * height);
    // The reader's first line is the picture's last
    for (let y = 0; y < height; y++)
        for (let x = 0; x < width; x++) {
            const from = ((height - 1 - y) * width + x) * channels,
                to = 4 * (y * width + x);
            for (let c = 0; c < 3; c++) pixels[to + c] = data[from + (channels >= 3 ? c : 0)];
        }
    return { width, height, pixels };
}

/** A picture as light: infinity becomes the largest half float, as in gonio render; nothing else is clamped but below 0. */
function light({ width, height, pixels }) {
    if (width < 2 || height < 2) throw new Error("It has fewer than 2 × 2 pixels.");
    let most = 0;
    for (let i = 0; i < pixels.length; i++) {
        if (i % 4 === 3) continue;
        if (Number.isNaN(pixels[i])) throw new Error("It has NaN pixels; repair it in an image editor.");
        pixels[i] = Math.min(Math.max(pixels[i], 0), pixels[i] === Infinity ? HALF_MAX : 3.4e38);
        most = Math.max(most, pixels[i]);
    }
    if (!(most > 0)) throw new Error("There is no light in it.");
    const picture = { width, height, pixels };
    while (picture.width > SKY_WIDTH_MAX) halve(picture);
    return {
        picture,
        note:
            picture.width < width
                ? `${width} × ${height}, averaged to ${picture.width} × ${picture.height}.`
                : `${width} × ${height}.`,
    };
}

function halve(picture) {
    const w = picture.width >> 1,
        h = Math.max(1, picture.height >> 1),
        to = new Float32Array(4 * w * h),
        from = picture.pixels;
    for (let y = 0; y < h; y++)
        for (let x = 0; x < w; x++)
            for (let c = 0; c < 3; c++) {
                const at = (i, j) =>
                    from[4 * (Math.min(picture.height - 1, 2 * y + j) * picture.width + 2 * x + i) + c];
                to[4 * (y * w + x) + c] = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4;
            }
    Object.assign(picture, { width: w, height: h, pixels: to });
}

let count = 0;

/** A mesh on the stage: on the ground, as large as the ball. */
function stage({ positions, normals, uvs, faces }) {
    if (!faces.length) throw new Error("It has no triangles.");
    const low = [Infinity, Infinity, Infinity],
        high = [-Infinity, -Infinity, -Infinity];
    for (const i of faces)
        for (let c = 0; c < 3; c++) {
            const x = positions[3 * i + c];
            if (!Number.isFinite(x)) throw new Error("It has positions that are no numbers.");
            low[c] = Math.min(low[c], x);
            high[c] = Math.max(high[c], x);
        }
    const size = Math.max(...high.map((x, c) => x - low[c]));
    if (!(size > 0)) throw new Error("All its points are one.");
    const scale = 2 / size,
        middle = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2];
    const placed = Float32Array.from(positions, (x, i) => (x - middle[i % 3]) * scale);
    return {
        id: ++count,
        height: (high[1] - low[1]) * scale,
        note: faces.length === 3 ? "One triangle." : `${many(faces.length / 3)} triangles.`,
        mesh: { kind: 0, positions: placed, faces, uvs, growth: null, normals: normals ?? smooth(placed, faces) },
    };
}

/** Normals of the corners, weighted by area, where a file has none. */
export function smooth(positions, faces) {
    const sums = new Map(),
        key = (i) => `${positions[3 * i]},${positions[3 * i + 1]},${positions[3 * i + 2]}`,
        keys = [];
    for (let i = 0; i < positions.length / 3; i++) keys.push(key(i));
    for (let f = 0; f < faces.length; f += 3) {
        const p = [0, 1, 2].map((k) => [0, 1, 2].map((c) => positions[3 * faces[f + k] + c]));
        const a = p[1].map((x, c) => x - p[0][c]),
            b = p[2].map((x, c) => x - p[0][c]),
            n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        for (let k = 0; k < 3; k++) {
            const at = keys[faces[f + k]],
                sum = sums.get(at) ?? [0, 0, 0];
            sums.set(
                at,
                sum.map((x, c) => x + n[c]),
            );
        }
    }
    const normals = new Float32Array(positions.length);
    keys.forEach((at, i) => {
        const n = sums.get(at) ?? [0, 1, 0],
            length = Math.hypot(...n);
        normals.set(length > 0 ? n.map((x) => x / length) : [0, 1, 0], 3 * i);
    });
    return normals;
}
