// What plots and probe show, from the same functions of the model that the picture calls.

const RAD = Math.PI / 180;
export const direction = (theta, phi = 0) => [
    Math.sin(theta) * Math.cos(phi),
    Math.sin(theta) * Math.sin(phi),
    Math.cos(theta),
];

/** Rows for `rows`: wi, wo and two random numbers, each in four. */
export function packRows(list) {
    const data = new Float32Array(12 * list.length);
    list.forEach(([wi, wo, u = [0.5, 0.5]], i) => {
        data.set(wi, 12 * i);
        data.set(wo, 12 * i + 4);
        data.set(u, 12 * i + 8);
    });
    return data;
}

/** Angles of a slice in degrees: even steps, and finer ones about the mirror direction. */
export function sliceAngles(thetaO) {
    const found = new Set();
    for (let a = -90; a <= 90; a += 1.5) found.add(a);
    for (let k = 0, step = 0.02; k < 26; k++, step *= 1.3)
        for (const a of [thetaO - step, thetaO + step]) if (Math.abs(a) < 90) found.add(a);
    found.add(thetaO);
    return [...found].sort((a, b) => a - b);
}

export const ALBEDO_ANGLES = Array.from({ length: 61 }, (_, i) => Math.min(1.5 * i, 89.9));
export const MAP_SIZE = 44;

/** wi and wo of a half and a difference angle (Rusinkiewicz), with phi_d = 90 degrees; null below the horizon. */
export function halfDifference(thetaH, thetaD) {
    const d = direction(thetaD, Math.PI / 2),
        [c, s] = [Math.cos(thetaH), Math.sin(thetaH)];
    const wi = [c * d[0] + s * d[2], d[1], c * d[2] - s * d[0]],
        h = [s, 0, c];
    const k = 2 * (wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2]),
        wo = wi.map((x, i) => k * h[i] - x);
    return wi[2] > 0 && wo[2] > 0 ? [wi, wo] : null;
}

/** Everything that the plots show of a side, for a direction of the viewer. */
export async function measure(gpu, side, thetaO) {
    const { program } = side,
        params = side.packed(),
        wo = direction(thetaO * RAD, Math.PI);
    const angles = sliceAngles(thetaO),
        pairs = [];
    for (let j = 0; j < MAP_SIZE; j++)
        for (let i = 0; i < MAP_SIZE; i++)
            pairs.push(halfDifference(((i + 0.5) / MAP_SIZE) * 90 * RAD, (1 - (j + 0.5) / MAP_SIZE) * 90 * RAD));
    const list = [
        ...angles.map((a) => [direction(a * RAD), wo]),
        ...pairs.map(
            (pair) =>
                pair ?? [
                    [0, 0, -1],
                    [0, 0, 1],
                ],
        ),
    ];
    const values = await gpu.rows(program, params, packRows(list));
    const slice = angles.map((a, i) => ({
        angle: a,
        f: [...values.subarray(8 * i, 8 * i + 3)],
        pdf: values[8 * i + 3],
    }));
    const map = pairs.map((pair, k) =>
        pair ? [...values.subarray(8 * (angles.length + k), 8 * (angles.length + k) + 3)] : null,
    );
    const given = new Float32Array(4 * ALBEDO_ANGLES.length);
    ALBEDO_ANGLES.forEach((a, i) => given.set(direction(a * RAD), 4 * i));
    const albedo = await gpu.albedo(program, params, given);
    return {
        thetaO,
        slice,
        map,
        albedo: ALBEDO_ANGLES.map((a, i) => ({ angle: a, value: [...albedo.subarray(4 * i, 4 * i + 3)] })),
    };
}
