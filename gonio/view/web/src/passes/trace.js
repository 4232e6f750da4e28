// The settings of the trace pass, rows of four numbers:
//  0 width, height, sample, seed      1 camera, tan of half the height's angle   2 right, aspect
//  3 up, furnace                      4 forward, depth                           5 surround, is there a picture of light
//  6 turn's cosine and sine, lamps, share of the picture's samples               7 -, nodes, radii where ground fades (0: none)
//  8 the core's centre and radius (0: none)    9 first line, last line, estimator, -   10 picture's size
// 11 colour of the fading ground
// 12 + 5 k: lamp k's centre and shape (0 rectangle, 1 disk); half axis, area; half axis; radiance, power; normal

export const ESTIMATORS = { both: 0, model: 1, light: 2 };
const LAMPS = 8;

/** How many rows that are. */
export const ROWS = 12 + 5 * LAMPS;

/** A direction of the light, turned with it by an angle in degrees. */
export function turned([x, y, z], degrees) {
    const angle = (degrees * Math.PI) / 180,
        [c, s] = [Math.cos(angle), Math.sin(angle)];
    return [c * x + s * z, y, c * z - s * x];
}

export function frame({ width, height, sample, seed = 1, view, light, furnace, scene, estimator = "both", depth }) {
    const U = new Float32Array(4 * ROWS);
    const row = (k, ...values) => U.set(values, 4 * k);
    const { origin, forward, right, up, half, aspect } = view;
    row(0, width, height, sample, seed);
    row(1, ...origin, half);
    row(2, ...right, aspect);
    row(3, ...up, furnace ? 1 : 0);
    row(4, ...forward, depth ?? (furnace ? 256 : 12));
    const lamps = furnace ? [] : light.lamps.slice(0, LAMPS);
    const picture = !furnace && light.picture;
    row(
        5,
        ...(furnace ? [1, 1, 1] : picture ? [1, 1, 1].map((x) => x * (light.scale ?? 1)) : light.surround),
        picture ? 1 : 0,
    );
    const turn = ((light.turn ?? 0) * Math.PI) / 180;
    row(6, Math.cos(turn), Math.sin(turn), lamps.length, picture ? (lamps.length ? 0.5 : 1) : 0);
    row(7, 0, scene.count, ...(furnace ? [0, 0] : light.fade));
    row(11, ...(light.groundColour ?? [0, 0, 0]), 0);
    row(8, ...(scene.core?.centre ?? [0, 0, 0]), scene.core?.radius ?? 0);
    row(9, 0, 0, ESTIMATORS[estimator], 0);
    if (picture) row(10, picture.width, picture.height, 0, 0);
    lamps.forEach((lamp, k) => {
        const [centre, a, b] = [lamp.centre, lamp.a, lamp.b].map((v) => turned(v, light.turn ?? 0)),
            n = [0, 1, 2].map((i) => a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3]),
            length = Math.hypot(...n),
            at = 12 + 5 * k;
        row(at, ...centre, lamp.shape === "disk" ? 1 : 0);
        row(at + 1, ...a, lamp.area);
        row(at + 2, ...b, 0);
        row(
            at + 3,
            ...lamp.radiance,
            lamp.area * (0.2126 * lamp.radiance[0] + 0.7152 * lamp.radiance[1] + 0.0722 * lamp.radiance[2]),
        );
        row(at + 4, ...n.map((x) => x / length), 0);
    });
    return U;
}
