// Binary glTF meshes (.glb): triangles of all nodes in one mesh. Materials, skins and animations are left out.

const COMPONENTS = {
    5120: Int8Array,
    5121: Uint8Array,
    5122: Int16Array,
    5123: Uint16Array,
    5125: Uint32Array,
    5126: Float32Array,
};
const WIDTHS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

export function readGlb(buffer, trianglesMax) {
    const view = new DataView(buffer);
    if (buffer.byteLength < 20 || view.getUint32(0, true) !== 0x46546c67)
        throw new Error("It does not begin as a binary glTF file does.");
    if (view.getUint32(4, true) !== 2)
        throw new Error(`It is glTF version ${view.getUint32(4, true)}; the page reads version 2.`);
    let json = null,
        binary = null;
    for (let at = 12; at + 8 <= buffer.byteLength; ) {
        const length = view.getUint32(at, true),
            kind = view.getUint32(at + 4, true);
        if (at + 8 + length > buffer.byteLength) throw new Error("The file ends too early.");
        if (kind === 0x4e4f534a) {
            try {
                json = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, at + 8, length)));
            } catch {
                throw new Error("Its description is no JSON.");
            }
        }
        if (kind === 0x004e4942) binary = buffer.slice(at + 8, at + 8 + length);
        at += 8 + length;
    }
    if (!json || !binary) throw new Error("It lacks its description or its data.");
    const needed = (json.extensionsRequired ?? []).filter(
        (name) => name !== "KHR_mesh_quantization" && !name.startsWith("KHR_materials"),
    );
    if (needed.length) throw new Error(`It needs ${needed.join(", ")}, which the page does not read.`);
    const out = { positions: [], normals: [], uvs: [], faces: [] };
    let hasNormals = true,
        hasUvs = true;
    const accessor = (index) => {
        const a = json.accessors?.[index],
            b = json.bufferViews?.[a?.bufferView],
            Kind = COMPONENTS[a?.componentType],
            width = WIDTHS[a?.type];
        if (!a || !b || !Kind || !width || b.buffer) throw new Error("Its data cannot be found.");
        const start = (b.byteOffset ?? 0) + (a.byteOffset ?? 0),
            size = width * Kind.BYTES_PER_ELEMENT,
            stride = b.byteStride ?? size;
        if (!(a.count >= 1 && stride >= size && start >= 0)) throw new Error("Its data cannot be found.");
        if (start + stride * (a.count - 1) + size > binary.byteLength) throw new Error("The file ends too early.");
        const values = new Float64Array(a.count * width),
            data = new DataView(binary);
        const read = {
            5120: "getInt8",
            5121: "getUint8",
            5122: "getInt16",
            5123: "getUint16",
            5125: "getUint32",
            5126: "getFloat32",
        }[a.componentType];
        const most = a.normalized ? { 5120: 127, 5121: 255, 5122: 32767, 5123: 65535 }[a.componentType] : 1;
        for (let i = 0; i < a.count; i++)
            for (let c = 0; c < width; c++)
                values[i * width + c] = data[read](start + i * stride + c * Kind.BYTES_PER_ELEMENT, true) / most;
        return { values, count: a.count, width };
    };
    const add = (primitive, m) => {
        if ((primitive.mode ?? 4) !== 4) return;
        const p = accessor(primitive.attributes.POSITION),
            n = primitive.attributes.NORMAL === undefined ? null : accessor(primitive.attributes.NORMAL),
            t = primitive.attributes.TEXCOORD_0 === undefined ? null : accessor(primitive.attributes.TEXCOORD_0);
        if (p.width !== 3 || [n, t].some((list) => list && list.count !== p.count))
            throw new Error("Its points, normals and texture coordinates do not belong together.");
        const base = out.positions.length / 3,
            cofactor = inverseTransposed(m);
        for (let i = 0; i < p.count; i++) {
            const [x, y, z] = p.values.subarray(3 * i, 3 * i + 3);
            for (let c = 0; c < 3; c++) out.positions.push(m[c] * x + m[4 + c] * y + m[8 + c] * z + m[12 + c]);
            if (n) {
                const q = n.values.subarray(3 * i, 3 * i + 3),
                    r = [0, 1, 2].map((c) => cofactor[c][0] * q[0] + cofactor[c][1] * q[1] + cofactor[c][2] * q[2]),
                    l = Math.hypot(...r) || 1;
                out.normals.push(...r.map((v) => v / l));
            } else {
                hasNormals = false;
                out.normals.push(0, 0, 0);
            }
            if (t) out.uvs.push(t.values[2 * i], t.values[2 * i + 1]);
            else {
                hasUvs = false;
                out.uvs.push(0, 0);
            }
        }
        const order =
            primitive.indices === undefined
                ? { values: Float64Array.from({ length: p.count }, (_, i) => i), count: p.count }
                : accessor(primitive.indices);
        if ((out.faces.length + order.count) / 3 > trianglesMax)
            throw new Error(
                `It has more than ${trianglesMax.toLocaleString("en")} triangles, which is what the page takes.`,
            );
        for (const i of order.values) {
            if (i >= p.count) throw new Error("A triangle names a point that does not exist.");
            out.faces.push(base + i);
        }
    };
    const visited = new Set();
    const visit = (index, parent, depth) => {
        const node = json.nodes?.[index];
        // A node hangs on one other
        if (!node || depth > 64 || visited.has(index)) throw new Error("Its nodes are damaged.");
        visited.add(index);
        const m = times(parent, node.matrix ?? composed(node));
        if (node.mesh !== undefined) for (const primitive of json.meshes[node.mesh].primitives) add(primitive, m);
        for (const child of node.children ?? []) visit(child, m, depth + 1);
    };
    const unit = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
        scene = json.scenes?.[json.scene ?? 0];
    for (const root of scene?.nodes ?? []) visit(root, unit, 0);
    if (!out.faces.length) throw new Error("It has no triangles.");
    return {
        positions: Float32Array.from(out.positions),
        faces: Uint32Array.from(out.faces),
        normals: hasNormals ? Float32Array.from(out.normals) : null,
        uvs: hasUvs ? Float32Array.from(out.uvs) : null,
    };
}

function composed({ translation: t = [0, 0, 0], rotation: [x, y, z, w] = [0, 0, 0, 1], scale: s = [1, 1, 1] }) {
    return [
        (1 - 2 * (y * y + z * z)) * s[0],
        2 * (x * y + z * w) * s[0],
        2 * (x * z - y * w) * s[0],
        0,
        2 * (x * y - z * w) * s[1],
        (1 - 2 * (x * x + z * z)) * s[1],
        2 * (y * z + x * w) * s[1],
        0,
        2 * (x * z + y * w) * s[2],
        2 * (y * z - x * w) * s[2],
        (1 - 2 * (x * x + y * y)) * s[2],
        0,
        ...t,
        1,
    ];
}

function times(a, b) {
    return Array.from({ length: 16 }, (_, i) =>
        [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + (i % 4)] * b[4 * Math.floor(i / 4) + k], 0),
    );
}

/** Cofactors of the upper 3 × 3, rows first: what turns normals. */
function inverseTransposed(m) {
    const a = (r, c) => m[4 * c + r],
        cof = (r, c) => {
            const [r1, r2] = [(r + 1) % 3, (r + 2) % 3],
                [c1, c2] = [(c + 1) % 3, (c + 2) % 3];
            return a(r1, c1) * a(r2, c2) - a(r1, c2) * a(r2, c1);
        };
    return [0, 1, 2].map((r) => [0, 1, 2].map((c) => cof(r, c)));
}
