// Plots in place of the picture.
import { encode } from "./colour.js";
import { fixed } from "./numbers.js";
import { albedo, axes, channels, chart, html, line, mapCanvases, path, pick, polar, svg, theta } from "./shared.js";

const RAD = Math.PI / 180;

/** A plot in place of the picture. */
export function large(app) {
    const s = app.state,
        plots = app.plots(),
        check = (key, text) =>
            html`<label class="check"><input type="checkbox" .checked=${app.lobe[key]} @change=${(e) => {
                app.lobe[key] = e.target.checked;
                app.update();
            }}>${text}</label>`;
    const turnLobe = (e) => {
        const t = e.currentTarget,
            { az, el } = app.lobe,
            [x, y] = [e.clientX, e.clientY];
        t.setPointerCapture(e.pointerId);
        t.onpointermove = (m) => {
            app.lobe.az = az - (m.clientX - x) * 0.5;
            app.lobe.el = Math.min(90, Math.max(-10, el + (m.clientY - y) * 0.4));
            app.update();
        };
        t.onpointerup = () => {
            t.onpointermove = null;
        };
    };
    const body = {
        lobe: () =>
            html`<canvas class="lobe" role="img" aria-label="The lobe f cos theta for the chosen viewer" @pointerdown=${turnLobe}></canvas><div class="bar">${theta(app)}${check("log", "log radius")}${check("weights", "samples, coloured by f cos θ / pdf")}${legend()}</div>`,
        slices: () =>
            html`<div class="pair">${plots.length ? html`${chart(app, "polar-large", "Polar slice of f cos theta", (w, h) => polar(plots, app.channel, w, h))}${chart(app, "cartesian-large", "f cos theta over theta, log scale", (w, h) => cartesian(plots, app.channel, w, h))}` : ""}</div><div class="bar">${theta(app)}${channels(app)}<span class="dim xs">f cos θi in the plane of ωo and the normal, 1/sr, logarithmic</span></div>`,
        map: () =>
            html`<div class="pair maps">${mapCanvases(app)}</div><div class="bar"><span class="dim xs">f over the half angle θh (across) and the difference angle θd (up), φd = 90°; white is the 95th percentile</span></div>`,
        albedo: () =>
            html`${plots.length ? chart(app, "albedo-large", "Directional albedo", (w, h) => albedo(plots, app.channel, w, h, s.theta)) : ""}<div class="bar">${theta(app)}${channels(app)}</div>`,
        weights: () =>
            html`<canvas class="weights" role="img" aria-label="Samples of the model on the hemisphere, coloured by their weight"></canvas><div class="bar">${theta(app)}${legend()}<span class="dim xs">seen from above; a perfect sampler has one colour</span></div>`,
    };
    return html`<div class="large">${body[s.view]?.() ?? ""}</div>`;
}

const legend = () => html`<span class="heat xs">⅛<i></i>8 × weight</span>`;

/** f cos theta over theta_i, log scale. */
function cartesian(data, channel, w, h) {
    const [x0, x1, y0, y1] = [44, w - 24, 12, h - 26];
    const value = (s) => pick(s.f, channel) * Math.cos(s.angle * RAD);
    const all = data.flatMap((d) => d.slice.map(value)).filter((v) => v > 0);
    const top = Math.ceil(Math.log10(Math.max(1e-5, ...all)) + 1e-9),
        low = Math.max(top - 6, Math.floor(Math.log10(Math.max(1e-9, Math.min(...all, 1)))));
    const X = (a) => x0 + ((x1 - x0) * (a + 90)) / 180,
        Y = (v) => y1 - ((y1 - y0) * Math.max(0, Math.log10(Math.max(v, 1e-12)) - low)) / (top - low);
    const ticks = Array.from({ length: top - low + 1 }, (_, i) => 10 ** (low + i));
    return svg`${axes({ x0, x1, y0, y1, ticks, log: true, xs: [-90, -60, -30, 0, 30, 60, 90] }, X, Y)}${data.map(({ letter, slice }) => line(path(slice.map((s) => [X(s.angle), Y(value(s))])), letter))}
        <path d=${`M${X(-(data[0]?.thetaO ?? 0))} ${y0}V${y1}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${X(-(data[0]?.thetaO ?? 0)) + 6} y=${y0 + 12} class="strong">ωo</text>`;
}

const LOG_RANGE = 3000;

/** Draws lobes as bodies: rings about the mirror direction, seen from a turning camera. */
export function drawLobe(canvas, lobes, { az, el, log, weights }, ratio) {
    const w = (canvas.width = canvas.clientWidth * ratio),
        h = (canvas.height = canvas.clientHeight * ratio),
        g = canvas.getContext("2d");
    g.clearRect(0, 0, w, h);
    const [ca, sa, ce, se] = [Math.cos(az * RAD), Math.sin(az * RAD), Math.cos(el * RAD), Math.sin(el * RAD)];
    const scale = Math.min(w * 0.46, h * 0.72),
        cx = w / 2,
        cy = h * 0.82;
    const turned = ([x, y, z]) => {
        const u = ca * x + sa * y,
            v = ca * y - sa * x;
        return [u, ce * z + se * v, ce * -v + se * z];
    }; // right, up, towards the eye
    const at = (p) => {
        const [x, y] = turned(p);
        return [cx + scale * x, cy - scale * y];
    };
    // The surface with its circles
    g.lineWidth = ratio;
    g.strokeStyle = "#ffffff30";
    for (const r of [0.5, 1]) {
        g.beginPath();
        for (let a = 0; a <= 360; a += 4) g.lineTo(...at([r * Math.cos(a * RAD), r * Math.sin(a * RAD), 0]));
        g.stroke();
    }
    const arrow = (d, text, colour) => {
        g.strokeStyle = g.fillStyle = colour;
        g.beginPath();
        g.moveTo(...at([0, 0, 0]));
        g.lineTo(...at(d.map((x) => 1.1 * x)));
        g.stroke();
        g.font = `${12 * ratio}px sans-serif`;
        const [x, y] = at(d.map((v) => 1.17 * v));
        g.fillText(text, x - 6 * ratio, y);
    };
    const bodies = lobes.filter(Boolean);
    const all = bodies.flatMap((b) => b.f.map((f, i) => Math.max(...f) * b.grid[i][2])),
        most = Math.max(1e-9, ...all);
    const length = (v) => (log ? Math.log1p((v / most) * LOG_RANGE) / Math.log1p(LOG_RANGE) : v / most);
    const quads = [];
    bodies.forEach((body) => {
        const points = body.grid.map((wi, i) => {
            const v = 0.2126 * body.f[i][0] + 0.7152 * body.f[i][1] + 0.0722 * body.f[i][2];
            const r = length(v * wi[2]);
            return wi.map((x) => x * r);
        });
        for (let j = 0; j < body.rings; j++)
            for (let i = 0; i < body.segments; i++) {
                const k = [
                    j * body.segments + i,
                    j * body.segments + ((i + 1) % body.segments),
                    (j + 1) * body.segments + ((i + 1) % body.segments),
                    (j + 1) * body.segments + i,
                ];
                const p = k.map((x) => turned(points[x])),
                    e1 = p[2].map((x, c) => x - p[0][c]),
                    e2 = p[3].map((x, c) => x - p[1][c]);
                const n = [e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]],
                    size = Math.hypot(...n);
                if (size < 1e-12) continue;
                const light = 0.3 + 0.7 * Math.abs((0.3 * n[0] + 0.6 * n[1] + 0.74 * n[2]) / size),
                    f = body.f[k[0]],
                    top = Math.max(...f, 1e-9);
                quads.push({
                    z: p[0][2] + p[1][2] + p[2][2] + p[3][2],
                    p,
                    letter: body.letter,
                    colour: f.map((x) => Math.round(255 * encode((x / top) * 0.8 * light))),
                });
            }
    });
    quads.sort((a, b) => a.z - b.z);
    for (const { p, colour, letter } of quads) {
        g.beginPath();
        for (const [x, y] of p) g.lineTo(cx + scale * x, cy - scale * y);
        g.closePath();
        if (letter === "B" && bodies.length > 1) {
            g.strokeStyle = "#ffae5766";
            g.stroke();
        } else {
            g.fillStyle = g.strokeStyle = `rgb(${colour.join(" ")})`;
            g.fill();
            g.stroke();
        }
    }
    const thetaO = bodies[0]?.thetaO ?? 45;
    arrow([-Math.sin(thetaO * RAD), 0, Math.cos(thetaO * RAD)], "ωo", "#f1f1f3");
    arrow([0, 0, 1], "n", "#b6b6bd");
    if (weights)
        for (const p of bodies[0]?.points ?? []) {
            const weight = Math.max(...p.weight),
                v = 0.2126 * p.f[0] + 0.7152 * p.f[1] + 0.0722 * p.f[2],
                [x, y] = at(p.wi.map((c) => c * (length(v * p.wi[2]) + 0.03)));
            g.fillStyle = heat(weight);
            g.beginPath();
            g.arc(x, y, 1.7 * ratio, 0, 7);
            g.fill();
        }
}

/** Blue below 1, white at 1, red above: a weight that should be near 1. */
export function heat(weight) {
    const t = Math.max(-1, Math.min(1, Math.log2(Math.max(weight, 1e-6)) / 3));
    return t < 0
        ? `rgb(${Math.round(255 * (1 + 0.75 * t))} ${Math.round(255 * (1 + 0.4 * t))} 255)`
        : `rgb(255 ${Math.round(255 * (1 - 0.75 * t))} ${Math.round(255 * (1 - 0.85 * t))})`;
}

/** Draws the hemisphere from above: where samples fall, coloured by f cos / pdf. */
export function drawWeights(canvas, lobes, ratio) {
    const w = (canvas.width = canvas.clientWidth * ratio),
        h = (canvas.height = canvas.clientHeight * ratio),
        g = canvas.getContext("2d");
    g.clearRect(0, 0, w, h);
    lobes.filter(Boolean).forEach((body, k, { length: n }) => {
        const r = Math.min(w / n / 2.4, h / 2.7),
            cx = (w * (k + 0.5)) / n,
            cy = h / 2 + 8 * ratio;
        g.strokeStyle = "#ffffff40";
        g.lineWidth = ratio;
        for (const a of [30, 60, 90]) {
            g.beginPath();
            g.arc(cx, cy, r * Math.sin(a * RAD), 0, 7);
            g.stroke();
        }
        for (const p of body.points) {
            g.fillStyle = heat(Math.max(...p.weight));
            g.beginPath();
            g.arc(cx + r * p.wi[0], cy - r * p.wi[1], 2.4 * ratio, 0, 7);
            g.fill();
        }
        const weights = body.points.map((p) => Math.max(...p.weight)),
            mean = weights.reduce((a, b) => a + b, 0) / (weights.length + body.wasted || 1);
        const variance =
            weights.reduce((a, b) => a + (b - mean) ** 2, body.wasted * mean * mean) /
            (weights.length + body.wasted || 1);
        g.fillStyle = "#f1f1f3";
        g.font = `${12 * ratio}px sans-serif`;
        g.textAlign = "center";
        g.fillText(
            `${n > 1 ? `${body.letter}: ` : ""}weight ${fixed(mean, 3)}, deviation ${fixed(Math.sqrt(variance), 3)}, at most ${fixed(Math.max(0, ...weights), 2)}, ${body.wasted} of ${body.points.length + body.wasted} wasted`,
            cx,
            cy + r + 22 * ratio,
        );
        g.strokeStyle = "#f1f1f3";
        const [ox, oy] = [cx - r * Math.sin(body.thetaO * RAD), cy];
        g.beginPath();
        g.arc(ox, oy, 4 * ratio, 0, 7);
        g.stroke();
        g.fillText("ωo", ox, oy - 8 * ratio);
    });
}
