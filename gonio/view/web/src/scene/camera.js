// The camera: where it is, and what pixel a ray belongs to.
import { cross, scaled, sum, unit } from "./bvh.js";

export const FIELD_OF_VIEW = 20; // degrees of the shorter side, as gonio render has it

/** The frame of a camera that orbits a target: azimuth and elevation in degrees. */
export function camera({ azimuth, elevation, distance, target }, width, height) {
    const a = (azimuth * Math.PI) / 180,
        e = (elevation * Math.PI) / 180;
    const back = [Math.cos(e) * Math.sin(a), Math.sin(e), Math.cos(e) * Math.cos(a)];
    const origin = sum(target, scaled(back, distance)),
        forward = scaled(back, -1);
    const right = unit(cross(forward, [0, 1, 0])),
        up = cross(right, forward);
    const half = Math.tan((FIELD_OF_VIEW * Math.PI) / 360) / Math.min(1, width / height);
    return { origin, forward, right, up, half, aspect: width / height };
}

/** The ray through a place of the picture, x and y from 0 to 1, y down. */
export function ray({ origin, forward, right, up, half, aspect }, x, y) {
    const across = scaled(right, (2 * x - 1) * aspect * half),
        along = scaled(up, (1 - 2 * y) * half);
    return { o: origin, d: unit(sum(forward, sum(across, along))) };
}
