// The lobe as a body, and samples of it.
import { direction, packRows } from "../ui/shared.js";

const RAD = Math.PI / 180;

/** A grid about the mirror direction that draws a lobe of any width: rings at angle pi s^3, lifted onto the horizon. */
export function lobeGrid(thetaO, rings, segments) {
    const r = direction(thetaO * RAD),
        t = [r[2], 0, -r[0]],
        b = [0, 1, 0],
        found = [];
    for (let j = 0; j <= rings; j++) {
        const angle = Math.PI * (j / rings) ** 3;
        for (let i = 0; i < segments; i++) {
            const phi = (2 * Math.PI * i) / segments,
                [c, s] = [Math.cos(angle), Math.sin(angle)];
            const w = r.map((x, k) => c * x + s * (Math.cos(phi) * t[k] + Math.sin(phi) * b[k]));
            w[2] = Math.max(w[2], 1e-4);
            const length = Math.hypot(...w);
            found.push(w.map((x) => x / length));
        }
    }
    return found;
}

/** The lobe of a side and samples of it with their weights f cos / pdf. */
export async function lobe(gpu, side, thetaO, rings = 40, segments = 60, samples = 600) {
    const wo = direction(thetaO * RAD, Math.PI),
        grid = lobeGrid(thetaO, rings, segments);
    const list = grid.map((wi) => [wi, wo]);
    for (let k = 0; k < samples; k++)
        list.push([[0, 0, 1], wo, [((k + 0.5) * 0.7548776662) % 1, ((k + 0.5) * 0.5698402909) % 1]]);
    const { program } = side, // and its parameters: another one may take its place meanwhile
        params = side.packed(),
        values = await gpu.rows(program, params, packRows(list));
    const f = grid.map((_, i) => [...values.subarray(8 * i, 8 * i + 3)]);
    const drawn = Array.from({ length: samples }, (_, k) => [
        ...values.subarray(8 * (grid.length + k) + 4, 8 * (grid.length + k) + 8),
    ]);
    const at = await gpu.rows(program, params, packRows(drawn.map((d) => [d[3] > 0 ? d.slice(0, 3) : [0, 0, 1], wo])));
    const points = drawn
        .map((d, k) => ({ wi: d.slice(0, 3), pdf: d[3], f: [...at.subarray(8 * k, 8 * k + 3)] }))
        .filter((p) => p.pdf > 0);
    for (const p of points) p.weight = p.f.map((x) => (x * p.wi[2]) / p.pdf);
    return { thetaO, grid, f, rings, segments, points, wasted: samples - points.length };
}
