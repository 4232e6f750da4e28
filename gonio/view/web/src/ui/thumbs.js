// What an environment looks like from where the object stands: all around, from the ground to high above.
import { fromHalf, unpacked } from "../source.js";

const [WIDTH, HEIGHT] = [116, 64];
const [HIGH, LOW] = [80, -40]; // degrees; the name covers what is below
const GLOW = 0.11; // radians, about a lamp that is small
const SMALLEST = 0.05; // radians: a sun would be less than a pixel

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const mix = (a, b, t) => a + (b - a) * t;

/** How far a direction points past a lamp's edge, in radians; 0 on the lamp. */
function past(d, { shape, centre, a, b }) {
    const distance = Math.hypot(...centre),
        along = dot(d, centre) / distance;
    if (along <= 0) return Math.PI;
    const across = [a, b].map((axis) => {
        const length = Math.hypot(...axis),
            reach = Math.max(length / distance, SMALLEST);
        return [dot(d, axis) / length / along, reach];
    });
    return shape === "disk"
        ? Math.max(0, Math.hypot(across[0][0], across[1][0]) - across[0][1])
        : Math.hypot(...across.map(([x, reach]) => Math.max(0, Math.abs(x) - reach)));
}

/** The picture of light's radiance, as the trace pass maps directions; scaled so that its mean is a middle grey. */
function picture({ width, height, half }) {
    const pixels = fromHalf(unpacked(half, Uint16Array)),
        upper = pixels.subarray(0, (3 * width * height) / 2);
    const scale = (0.42 * upper.length) / upper.reduce((sum, x) => sum + Math.min(x, 1e4), 0);
    return (d) => {
        const phi = Math.atan2(-d[0], d[2]) / (2 * Math.PI),
            x = Math.floor((phi - Math.floor(phi)) * width) % width,
            y = Math.min(height - 1, Math.floor((Math.acos(d[1]) / Math.PI) * height));
        return [0, 1, 2].map((c) => pixels[3 * (y * width + x) + c] * scale);
    };
}

export function drawThumb(canvas, env) {
    canvas.width = WIDTH;
    canvas.height = HEIGHT;
    const g = canvas.getContext("2d"),
        made = g.createImageData(WIDTH, HEIGHT),
        sky = env.picture && picture(env.picture);
    const most = Math.max(...env.lamps.map((lamp) => lamp.radiance[1]), 0);
    for (let y = 0; y < HEIGHT; y++) {
        const el = (mix(HIGH, LOW, (y + 0.5) / HEIGHT) * Math.PI) / 180;
        for (let x = 0; x < WIDTH; x++) {
            const az = ((x + 0.5) / WIDTH - 0.5) * 2 * Math.PI,
                d = [Math.cos(el) * Math.sin(az), Math.sin(el), Math.cos(el) * Math.cos(az)];
            const above = sky ? sky([d[0], Math.abs(d[1]), d[2]]) : env.surround.map((v) => v * (1 + 0.4 * d[1]));
            // Ground as bright as what is around it, and lighter on the lamps' side
            let lit = 0.12;
            for (const lamp of env.lamps)
                lit += 0.1 * Math.max(0, dot(d, lamp.centre) / Math.hypot(...lamp.centre)) ** 2;
            const ground = (env.groundColour ?? [0.5, 0.48, 0.46]).map((c, i) => c * (lit + 0.5 * above[i]));
            const edge = Math.min(1, Math.max(0, 0.5 - el / 0.06)),
                colour = above.map((c, i) => mix(c, ground[i], edge));
            for (const lamp of env.lamps) {
                const far = past(d, lamp),
                    share = lamp.radiance[1] / most;
                const light = far === 0 ? 0.35 + share : 0.3 * share * Math.exp(-((far / GLOW) ** 1.2));
                for (let c = 0; c < 3; c++) colour[c] += (light * lamp.radiance[c]) / Math.max(...lamp.radiance);
            }
            const at = 4 * (y * WIDTH + x);
            for (let c = 0; c < 3; c++) made.data[at + c] = 255 * Math.min(1, Math.max(0, colour[c])) ** (1 / 2.2);
            made.data[at + 3] = 255;
        }
    }
    g.putImageData(made, 0, 0);
}
