// Wavefront meshes (.obj): positions, texture coordinates, normals, polygons. Everything else is left out.

export function readObj(text, trianglesMax) {
    const v = [],
        vt = [],
        vn = [],
        positions = [],
        uvs = [],
        normals = [],
        faces = [],
        known = new Map();
    let hasNormals = true,
        hasUvs = true,
        line = 0;
    const corner = (word) => {
        if (known.has(word)) return known.get(word);
        const [p, t, n] = word.split("/").map((x) => (x ? Number(x) : 0));
        const index = (i, list, width) => (i < 0 ? list.length / width + i : i - 1);
        const at = index(p, v, 3);
        if (!Number.isInteger(p) || p === 0 || at < 0 || 3 * at >= v.length)
            throw new Error(`Line ${line} names a point that does not exist.`);
        positions.push(v[3 * at], v[3 * at + 1], v[3 * at + 2]);
        const ti = t ? 2 * index(t, vt, 2) : -1,
            ni = n ? 3 * index(n, vn, 3) : -1;
        if (ti >= 0 && ti + 1 < vt.length) uvs.push(vt[ti], 1 - vt[ti + 1]);
        else {
            uvs.push(0, 0);
            hasUvs = false;
        }
        if (ni >= 0 && ni + 2 < vn.length) normals.push(vn[ni], vn[ni + 1], vn[ni + 2]);
        else {
            normals.push(0, 0, 0);
            hasNormals = false;
        }
        known.set(word, positions.length / 3 - 1);
        return positions.length / 3 - 1;
    };
    for (const raw of text.split("\n")) {
        line++;
        const words = raw.trim().split(/\s+/),
            numbers = (n) => {
                for (let i = 1; i <= n; i++)
                    if (!Number.isFinite(Number(words[i]))) throw new Error(`Line ${line} is no list of numbers.`);
                return words.slice(1, n + 1).map(Number);
            };
        if (words[0] === "v") v.push(...numbers(3));
        else if (words[0] === "vt") vt.push(...numbers(2));
        else if (words[0] === "vn") vn.push(...numbers(3));
        else if (words[0] === "f") {
            const corners = words.slice(1).map(corner);
            for (let i = 2; i < corners.length; i++) faces.push(corners[0], corners[i - 1], corners[i]);
            if (faces.length / 3 > trianglesMax)
                throw new Error(
                    `It has more than ${trianglesMax.toLocaleString("en")} triangles, which is what the page takes.`,
                );
        }
    }
    if (!faces.length) throw new Error("It has no faces.");
    return {
        positions: Float32Array.from(positions),
        faces: Uint32Array.from(faces),
        uvs: hasUvs ? Float32Array.from(uvs) : null,
        normals: hasNormals ? unitNormals(normals) : null,
    };
}

function unitNormals(list) {
    const normals = Float32Array.from(list);
    for (let i = 0; i < normals.length; i += 3) {
        const n = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
        for (let c = 0; c < 3; c++) normals[i + c] /= n;
    }
    return normals;
}
