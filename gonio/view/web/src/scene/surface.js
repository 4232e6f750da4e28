// What is seen in a place of the picture, for the probe.
import { cross, dot, nearest, scaled, sum, unit } from "./bvh.js";
import { ray } from "./camera.js";

/** The surface in a place of the picture: directions in its frame, or null for the background. */
export function surface(renderer, state, x, y) {
    const [w, h] = renderer.pictureSize(state),
        view = renderer.view(state, w, h),
        { o, d } = ray(view, x, y);
    const scene = renderer.scenes.get(renderer.sceneName);
    if (!scene) return null;
    let hit = nearest(scene, o, d),
        t = hit?.t ?? Infinity,
        core = false;
    if (scene.core) {
        const c = scene.core.centre.map((v, i) => v - o[i]),
            b = dot(c, d),
            e = sum(c, scaled(d, -b)),
            q = scene.core.radius ** 2 - dot(e, e);
        if (q > 0 && b - Math.sqrt(q) > 0 && b - Math.sqrt(q) < t) {
            t = b - Math.sqrt(q);
            core = true;
        }
    }
    if (!Number.isFinite(t)) return null;
    const p = sum(o, scaled(d, t));
    let n,
        du,
        uv,
        growth = 0.5;
    if (core) {
        n = unit(sum(p, scaled(scene.core.centre, -1)));
        du = [-n[2], 0, n[0]];
        uv = [(Math.atan2(-n[0], -n[2]) / (2 * Math.PI) + 1) % 1, Math.acos(n[1]) / Math.PI];
    } else {
        const i = hit.i,
            { places, looks } = scene;
        if (places[12 * i + 3] !== 0) return null;
        const a = [1 - hit.u - hit.v, hit.u, hit.v],
            mix = (k) => a[0] * looks[20 * i + k] + a[1] * looks[20 * i + 4 + k] + a[2] * looks[20 * i + 8 + k];
        n = unit([mix(0), mix(1), mix(2)]);
        growth = mix(3);
        const T = [0, 1, 2].map((k) => [looks[20 * i + 12 + 2 * k], looks[20 * i + 13 + 2 * k]]);
        uv = [0, 1].map((c) => a[0] * T[0][c] + a[1] * T[1][c] + a[2] * T[2][c]);
        const e1 = [...places.subarray(12 * i + 4, 12 * i + 7)],
            e2 = [...places.subarray(12 * i + 8, 12 * i + 11)];
        const s1 = [T[1][0] - T[0][0], T[1][1] - T[0][1]],
            s2 = [T[2][0] - T[0][0], T[2][1] - T[0][1]];
        du = scaled(sum(scaled(e1, s2[1]), scaled(e2, -s1[1])), Math.sign(s1[0] * s2[1] - s1[1] * s2[0]));
    }
    if (dot(n, d) > 0) n = scaled(n, -1);
    du = sum(du, scaled(n, -dot(du, n)));
    const tx = dot(du, du) > 1e-16 ? unit(du) : unit(cross(Math.abs(n[1]) > 0.99 ? [1, 0, 0] : [0, 1, 0], n)),
        ty = cross(n, tx);
    const local = (v) => [dot(v, tx), dot(v, ty), dot(v, n)],
        wo = local(scaled(d, -1));
    let wi = local(unit(renderer.lightDirection(state, p)));
    if (wi[2] <= 0) wi = [-wo[0], -wo[1], wo[2]]; // in the lamp's shadow: the mirror direction
    return { p, t, uv, growth, wi, wo };
}
