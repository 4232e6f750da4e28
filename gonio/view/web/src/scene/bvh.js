// A bounding volume hierarchy by the surface area heuristic, as the tables that the trace pass reads.

const BINS = 16,
    LEAF = 4,
    DEPTH_MAX = 36; // the pass has a stack of 40

/** The parts of a scene as tables of vec4: nodes (2 each), places (3 per triangle), looks (5 per triangle).
 *
 * A part has positions, normals, uvs (or null), growth (or null), faces and kind: 0 the material, 1 ground, 2 pedestal. */
export function tables(parts) {
    const total = parts.reduce((sum, part) => sum + part.faces.length / 3, 0);
    const low = new Float32Array(3 * total),
        high = new Float32Array(3 * total),
        middle = new Float32Array(3 * total);
    const places = new Float32Array(12 * Math.max(total, 1)),
        looks = new Float32Array(20 * Math.max(total, 1));
    const order = new Uint32Array(total);
    const source = [];
    let n = 0;
    for (const part of parts) {
        for (let f = 0; f < part.faces.length; f += 3, n++) {
            order[n] = n;
            source.push([part, f]);
            for (let c = 0; c < 3; c++) {
                const [a, b, d] = [0, 1, 2].map((k) => part.positions[3 * part.faces[f + k] + c]);
                low[3 * n + c] = Math.min(a, b, d);
                high[3 * n + c] = Math.max(a, b, d);
                middle[3 * n + c] = (low[3 * n + c] + high[3 * n + c]) / 2;
            }
        }
    }
    const nodes = [];
    const bounds = (from, to) => {
        const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];
        for (let i = from; i < to; i++) grow(box, low, high, order[i]);
        return box;
    };
    const split = (at, from, to, depth) => {
        const box = bounds(from, to);
        nodes[at] = [box, from, to - from];
        if (to - from <= LEAF || depth >= DEPTH_MAX) return;
        const cut = best(low, high, middle, order, from, to);
        let place = from;
        if (cut) {
            for (let i = from; i < to; i++) {
                if (middle[3 * order[i] + cut.axis] < cut.at) {
                    const k = order[i];
                    order[i] = order[place];
                    order[place++] = k;
                }
            }
        }
        if (place === from || place === to) {
            if (to - from <= 4 * LEAF) return;
            place = (from + to) >> 1;
        }
        const child = nodes.length;
        nodes.push(null, null);
        nodes[at] = [box, child, 0];
        split(child, from, place, depth + 1);
        split(child + 1, place, to, depth + 1);
    };
    if (total) {
        nodes.push(null);
        split(0, 0, total, 0);
    }
    const table = new Float32Array(8 * Math.max(nodes.length, 1));
    nodes.forEach(([box, first, count], i) =>
        table.set([box[0], box[1], box[2], first, box[3], box[4], box[5], count], 8 * i),
    );
    for (let i = 0; i < total; i++) triangle(places, looks, i, ...source[order[i]]);
    return { nodes: table, places, looks, count: nodes.length, triangles: total };
}

function grow(box, low, high, i) {
    for (let c = 0; c < 3; c++) {
        box[c] = Math.min(box[c], low[3 * i + c]);
        box[3 + c] = Math.max(box[3 + c], high[3 * i + c]);
    }
}

const area = (b) => {
    const [x, y, z] = [b[3] - b[0], b[4] - b[1], b[5] - b[2]];
    return x < 0 ? 0 : x * y + y * z + z * x;
};
const nothing = () => [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity];

function best(low, high, middle, order, from, to) {
    let found = null,
        cost = Infinity;
    for (let axis = 0; axis < 3; axis++) {
        let a = Infinity,
            b = -Infinity;
        for (let i = from; i < to; i++) {
            const m = middle[3 * order[i] + axis];
            a = Math.min(a, m);
            b = Math.max(b, m);
        }
        if (!(b > a)) continue;
        const bins = Array.from({ length: BINS }, () => ({ box: nothing(), count: 0 }));
        for (let i = from; i < to; i++) {
            const bin = bins[Math.min(BINS - 1, Math.floor(((middle[3 * order[i] + axis] - a) / (b - a)) * BINS))];
            grow(bin.box, low, high, order[i]);
            bin.count++;
        }
        const right = [];
        let box = nothing(),
            count = 0;
        for (let k = BINS - 1; k > 0; k--) {
            join(box, bins[k].box);
            count += bins[k].count;
            right[k] = area(box) * count;
        }
        box = nothing();
        count = 0;
        for (let k = 1; k < BINS; k++) {
            join(box, bins[k - 1].box);
            count += bins[k - 1].count;
            const c = area(box) * count + right[k];
            if (c < cost) {
                cost = c;
                found = { axis, at: a + ((b - a) * k) / BINS };
            }
        }
    }
    return found;
}

function join(box, other) {
    for (let c = 0; c < 3; c++) {
        box[c] = Math.min(box[c], other[c]);
        box[3 + c] = Math.max(box[3 + c], other[3 + c]);
    }
}

function triangle(places, looks, i, part, f) {
    const k = [0, 1, 2].map((c) => part.faces[f + c]);
    const point = (v) => [0, 1, 2].map((c) => part.positions[3 * k[v] + c]);
    const [p0, p1, p2] = [point(0), point(1), point(2)];
    places.set(
        [
            ...p0,
            part.kind,
            p1[0] - p0[0],
            p1[1] - p0[1],
            p1[2] - p0[2],
            0,
            p2[0] - p0[0],
            p2[1] - p0[1],
            p2[2] - p0[2],
            0,
        ],
        12 * i,
    );
    for (let v = 0; v < 3; v++) {
        const growth = part.growth ? part.growth[k[v]] : 0.5;
        looks.set(
            [part.normals[3 * k[v]], part.normals[3 * k[v] + 1], part.normals[3 * k[v] + 2], growth],
            20 * i + 4 * v,
        );
        if (part.uvs) looks.set([part.uvs[2 * k[v]], part.uvs[2 * k[v] + 1]], 20 * i + 12 + 2 * v);
    }
}

/** The nearest triangle that a ray meets, on the processor: {t, i, u, v}, or null. For the probe. */
export function nearest({ nodes, places, count }, o, d) {
    if (!count) return null;
    let hit = null,
        far = Infinity;
    const inv = d.map((x) => 1 / (Math.abs(x) < 1e-12 ? 1e-12 : x));
    const stack = [0];
    while (stack.length) {
        const at = 8 * stack.pop();
        let t0 = 0,
            t1 = far;
        for (let c = 0; c < 3; c++) {
            const a = (nodes[at + c] - o[c]) * inv[c],
                b = (nodes[at + 4 + c] - o[c]) * inv[c];
            t0 = Math.max(t0, Math.min(a, b));
            t1 = Math.min(t1, Math.max(a, b));
        }
        if (t0 > t1 * (1 + 1e-6)) continue;
        const first = nodes[at + 3],
            n = nodes[at + 7];
        if (!n) {
            stack.push(first, first + 1);
            continue;
        }
        for (let i = first; i < first + n; i++) {
            const k = 12 * i,
                [e1, e2] = [
                    [places[k + 4], places[k + 5], places[k + 6]],
                    [places[k + 8], places[k + 9], places[k + 10]],
                ];
            const h = cross(d, e2),
                a = dot(e1, h);
            if (Math.abs(a) < 1e-14) continue;
            const s = [o[0] - places[k], o[1] - places[k + 1], o[2] - places[k + 2]],
                u = dot(s, h) / a;
            const q = cross(s, e1),
                v = dot(d, q) / a,
                t = dot(e2, q) / a;
            if (u >= 0 && v >= 0 && u + v <= 1 && t > 1e-4 && t < far) {
                far = t;
                hit = { t, i, u, v };
            }
        }
    }
    return hit;
}

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const scaled = (a, s) => a.map((x) => x * s);
export const sum = (a, b) => a.map((x, i) => x + b[i]);
export const unit = (a) => scaled(a, 1 / Math.hypot(...a));
