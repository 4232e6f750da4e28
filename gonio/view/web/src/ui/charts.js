// Plots, drawn for the size they have: text stays 11 px.
import { html, svg } from "lit-html";
import { encode } from "./colour.js";
import { fixed } from "./numbers.js";
import { MAP_SIZE } from "../passes/measure.js";

const RAD = Math.PI / 180;
export const CHANNELS = ["red", "green", "blue", "luminance"];
export const pick = (f, channel) => (channel === 3 ? 0.2126 * f[0] + 0.7152 * f[1] + 0.0722 * f[2] : f[channel]);

const path = (points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
const line = (d, side) => svg`<path d=${d} fill="none" stroke=${side === "A" ? "var(--a)" : "var(--b)"} stroke-width="1.75" stroke-linejoin="round" stroke-dasharray=${side === "A" ? "none" : "5 3"}></path>`;
const power = (e) => (e >= -2 && e <= 3 ? String(Number((10 ** e).toFixed(3))) : `10${[...String(e)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("")}`);

/** Data by side, width and height to a picture; `name` is what the page measures it by. */
export function chart(app, name, label, draw) {
    const { width = 300, height = 150 } = app.sizes[name] ?? {};
    return html`<svg class="p" data-chart=${name} viewBox=${`0 0 ${width} ${height}`} role="img" aria-label=${label}>${draw(width, height)}</svg>`;
}

/** f cos theta in the plane of wo and the normal, log radius. */
export function polar(data, channel, w, h) {
    const r = Math.min(w / 2 - 34, h - 30), cx = w / 2, cy = h - 20;
    const all = data.flatMap(({ slice }) => slice.map((s) => pick(s.f, channel) * Math.cos(s.angle * RAD))).filter((v) => v > 0 && Number.isFinite(v));
    const top = Math.ceil(Math.log10(Math.max(1e-6, ...all)) + 1e-9), decades = Math.min(4, Math.max(3, top + 2)), low = top - decades;
    const radius = (v) => (v > 0 ? Math.max(0, (Math.log10(v) - low) / decades) * r : 0);
    const at = (angle, length) => [cx + length * Math.sin(angle * RAD), cy - length * Math.cos(angle * RAD)];
    const rings = Array.from({ length: decades }, (_, k) => k + 1).map((k) => {
        const q = (k / decades) * r;
        return svg`<path d=${`M${cx - q} ${cy}A${q} ${q} 0 0 1 ${cx + q} ${cy}`} fill="none" stroke="var(--line)"></path>${r / decades > 22 || k % 2 === decades % 2 ? svg`<text x=${cx + q} y=${cy + 14} text-anchor="middle">${power(low + k)}</text>` : ""}`;
    });
    const spokes = [-60, -30, 0, 30, 60].map((a) => svg`<path d=${path([[cx, cy], at(a, r)])} stroke="var(--line)"></path>${a ? svg`<text x=${at(a, r + 14)[0]} y=${at(a, r + 14)[1] + 4} text-anchor="middle">${a < 0 ? "−" : ""}${Math.abs(a)}°</text>` : ""}`);
    const thetaO = data[0]?.thetaO ?? 45, [ox, oy] = at(-thetaO, r);
    return svg`${rings}${spokes}<path d=${`M${cx - r} ${cy}H${cx + r}`} stroke="var(--edge)"></path>
        ${data.map(({ letter, slice }) => line(path(slice.map((s) => at(s.angle, radius(pick(s.f, channel) * Math.cos(s.angle * RAD))))), letter))}
        <path d=${path([[cx, cy], [ox, oy]])} stroke="var(--text)" stroke-width="1.25" stroke-dasharray="2 3"></path><text x=${ox + 16} y=${oy + 4} class="strong">ωo</text>`;
}

function axes({ x0, x1, y0, y1, top, bottom, ticks, log = false, xs = [0, 30, 60, 90] }, X, Y) {
    return svg`${ticks.map((v) => svg`<path d=${`M${x0} ${Y(v)}H${x1}`} stroke=${v === 1 && !log ? "var(--edge)" : "var(--line)"}></path><text x=${x0 - 8} y=${Y(v) + 4} text-anchor="end">${log ? power(Math.round(Math.log10(v))) : Number(v.toFixed(3))}</text>`)}
        ${xs.map((a) => svg`<text x=${X(a)} y=${y1 + 16} text-anchor="middle">${a < 0 ? "−" : ""}${Math.abs(a)}°</text>`)}`;
}

/** Directional albedo; what is above 1 is shaded and said in words. */
export function albedo(data, channel, w, h, probe) {
    const [x0, x1, y0, y1] = [34, w - 62, 8, h - 22], most = Math.max(1, ...data.flatMap((d) => d.albedo.map((p) => pick(p.value, channel))).filter(Number.isFinite));
    const top = most <= 1.02 ? 1.1 : Math.ceil(most * 2 + 0.1) / 2, step = top > 4 ? Math.ceil(top / 4) : top > 1.6 ? 1 : 0.5;
    const X = (a) => x0 + ((x1 - x0) * a) / 90, Y = (v) => y1 - ((y1 - y0) * Math.min(v, top)) / top;
    const ticks = Array.from({ length: Math.floor(top / step + 1e-6) + 1 }, (_, i) => i * step);
    const ends = [];
    const curves = data.map(({ letter, albedo: points }) => {
        const values = points.map((p) => [p.angle, pick(p.value, channel)]), above = values.filter(([, v]) => v > 1.0005);
        const end = values[values.length - 1][1];
        let y = Y(end) + 4;
        for (const other of ends) if (Math.abs(other - y) < 14) y = other + (y >= other ? 14 : -14);
        ends.push(y);
        return svg`${above.length ? svg`<path fill="var(--warn)" opacity=".28" d=${`${path([[X(above[0][0]), Y(1)], ...above.map(([a, v]) => [X(a), Y(v)]), [X(above[above.length - 1][0]), Y(1)]])}Z`}></path>
            <text x=${Math.min(X(above[0][0]) - 6, x1 - 4)} y=${Math.max(Y(1) - 12, y0 + 10)} text-anchor=${X(above[0][0]) > x0 + 150 ? "end" : "start"} class="warn">${letter} gains energy ${above[0][0] > 0 ? `from ${Math.round(above[0][0])}°` : "everywhere"}</text>` : ""}
            ${line(path(values.map(([a, v]) => [X(a), Y(v)])), letter)}<text x=${x1 + 8} y=${y} class=${`of${letter}`}>${letter} ${fixed(end, 2)}</text>`;
    });
    return svg`${axes({ x0, x1, y0, y1, ticks }, X, Y)}${curves}
        ${probe === null ? "" : svg`<path d=${`M${X(probe)} ${y0}V${y1}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${X(probe) + (probe > 55 ? -6 : 6)} text-anchor=${probe > 55 ? "end" : "start"} y=${y0 + 10} class="strong">θo ${Math.round(probe)}°</text>`}`;
}

/** f cos theta over theta_i, log scale. */
export function cartesian(data, channel, w, h) {
    const [x0, x1, y0, y1] = [44, w - 24, 12, h - 26];
    const value = (s) => pick(s.f, channel) * Math.cos(s.angle * RAD);
    const all = data.flatMap((d) => d.slice.map(value)).filter((v) => v > 0);
    const top = Math.ceil(Math.log10(Math.max(1e-5, ...all)) + 1e-9), low = Math.max(top - 6, Math.floor(Math.log10(Math.max(1e-9, Math.min(...all, 1)))));
    const X = (a) => x0 + ((x1 - x0) * (a + 90)) / 180, Y = (v) => y1 - ((y1 - y0) * Math.max(0, Math.log10(Math.max(v, 1e-12)) - low)) / (top - low);
    const ticks = Array.from({ length: top - low + 1 }, (_, i) => 10 ** (low + i));
    return svg`${axes({ x0, x1, y0, y1, ticks, log: true, xs: [-90, -60, -30, 0, 30, 60, 90] }, X, Y)}${data.map(({ letter, slice }) => line(path(slice.map((s) => [X(s.angle), Y(value(s))])), letter))}
        <path d=${`M${X(-(data[0]?.thetaO ?? 0))} ${y0}V${y1}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${X(-(data[0]?.thetaO ?? 0)) + 6} y=${y0 + 12} class="strong">ωo</text>`;
}

/** Draws f over half and difference angle into a canvas: linear, exposed so that its 95th percentile is white. */
export function drawMap(canvas, map) {
    canvas.width = canvas.height = MAP_SIZE;
    const context = canvas.getContext("2d"), image = context.createImageData(MAP_SIZE, MAP_SIZE);
    const sizes = map.filter(Boolean).map((f) => Math.max(...f)).filter(Number.isFinite).sort((a, b) => a - b);
    const white = Math.max(1e-9, sizes[Math.floor(0.95 * sizes.length)] ?? 1);
    map.forEach((f, i) => image.data.set(f ? [...f.map((x) => Math.round(255 * encode(Math.min(1, Math.max(0, x / white))))), 255] : [0, 0, 0, 0], 4 * i));
    context.putImageData(image, 0, 0);
}

const LOG_RANGE = 3000;

/** Draws lobes as bodies: rings about the mirror direction, seen from a turning camera. */
export function drawLobe(canvas, lobes, { az, el, log, weights }, ratio) {
    const w = (canvas.width = canvas.clientWidth * ratio), h = (canvas.height = canvas.clientHeight * ratio), g = canvas.getContext("2d");
    g.clearRect(0, 0, w, h);
    const [ca, sa, ce, se] = [Math.cos(az * RAD), Math.sin(az * RAD), Math.cos(el * RAD), Math.sin(el * RAD)];
    const scale = Math.min(w * 0.46, h * 0.72), cx = w / 2, cy = h * 0.82;
    const turned = ([x, y, z]) => { const u = ca * x + sa * y, v = ca * y - sa * x; return [u, ce * z + se * v, ce * -v + se * z]; }; // right, up, towards the eye
    const at = (p) => { const [x, y] = turned(p); return [cx + scale * x, cy - scale * y]; };
    // The surface with its circles
    g.lineWidth = ratio;
    g.strokeStyle = "#ffffff30";
    for (const r of [0.5, 1]) { g.beginPath(); for (let a = 0; a <= 360; a += 4) g.lineTo(...at([r * Math.cos(a * RAD), r * Math.sin(a * RAD), 0])); g.stroke(); }
    const arrow = (d, text, colour) => { g.strokeStyle = g.fillStyle = colour; g.beginPath(); g.moveTo(...at([0, 0, 0])); g.lineTo(...at(d.map((x) => 1.1 * x))); g.stroke(); g.font = `${12 * ratio}px sans-serif`; const [x, y] = at(d.map((v) => 1.17 * v)); g.fillText(text, x - 6 * ratio, y); };
    const bodies = lobes.filter(Boolean);
    const all = bodies.flatMap((b) => b.f.map((f, i) => Math.max(...f) * b.grid[i][2])), most = Math.max(1e-9, ...all);
    const length = (v) => (log ? Math.log1p((v / most) * LOG_RANGE) / Math.log1p(LOG_RANGE) : v / most);
    const quads = [];
    bodies.forEach((body) => {
        const points = body.grid.map((wi, i) => { const v = 0.2126 * body.f[i][0] + 0.7152 * body.f[i][1] + 0.0722 * body.f[i][2]; const r = length(v * wi[2]); return wi.map((x) => x * r); });
        for (let j = 0; j < body.rings; j++) for (let i = 0; i < body.segments; i++) {
            const k = [j * body.segments + i, j * body.segments + ((i + 1) % body.segments), (j + 1) * body.segments + ((i + 1) % body.segments), (j + 1) * body.segments + i];
            const p = k.map((x) => turned(points[x])), e1 = p[2].map((x, c) => x - p[0][c]), e2 = p[3].map((x, c) => x - p[1][c]);
            const n = [e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]], size = Math.hypot(...n);
            if (size < 1e-12) continue;
            const light = 0.3 + 0.7 * Math.abs((0.3 * n[0] + 0.6 * n[1] + 0.74 * n[2]) / size), f = body.f[k[0]], top = Math.max(...f, 1e-9);
            quads.push({ z: p[0][2] + p[1][2] + p[2][2] + p[3][2], p, letter: body.letter, colour: f.map((x) => Math.round(255 * encode((x / top) * 0.8 * light))) });
        }
    });
    quads.sort((a, b) => a.z - b.z);
    for (const { p, colour, letter } of quads) {
        g.beginPath();
        for (const [x, y] of p) g.lineTo(cx + scale * x, cy - scale * y);
        g.closePath();
        if (letter === "B" && bodies.length > 1) { g.strokeStyle = "#ffae5766"; g.stroke(); } else { g.fillStyle = g.strokeStyle = `rgb(${colour.join(" ")})`; g.fill(); g.stroke(); }
    }
    const thetaO = bodies[0]?.thetaO ?? 45;
    arrow([-Math.sin(thetaO * RAD), 0, Math.cos(thetaO * RAD)], "ωo", "#f1f1f3");
    arrow([0, 0, 1], "n", "#b6b6bd");
    if (weights) for (const p of bodies[0]?.points ?? []) {
        const weight = Math.max(...p.weight), v = 0.2126 * p.f[0] + 0.7152 * p.f[1] + 0.0722 * p.f[2], [x, y] = at(p.wi.map((c) => c * (length(v * p.wi[2]) + 0.03)));
        g.fillStyle = heat(weight);
        g.beginPath();
        g.arc(x, y, 1.7 * ratio, 0, 7);
        g.fill();
    }
}

/** Blue below 1, white at 1, red above: a weight that should be near 1. */
export function heat(weight) {
    const t = Math.max(-1, Math.min(1, Math.log2(Math.max(weight, 1e-6)) / 3));
    return t < 0 ? `rgb(${Math.round(255 * (1 + 0.75 * t))} ${Math.round(255 * (1 + 0.4 * t))} 255)` : `rgb(255 ${Math.round(255 * (1 - 0.75 * t))} ${Math.round(255 * (1 - 0.85 * t))})`;
}

/** Draws the hemisphere from above: where samples fall, coloured by f cos / pdf. */
export function drawWeights(canvas, lobes, ratio) {
    const w = (canvas.width = canvas.clientWidth * ratio), h = (canvas.height = canvas.clientHeight * ratio), g = canvas.getContext("2d");
    g.clearRect(0, 0, w, h);
    lobes.filter(Boolean).forEach((body, k, { length: n }) => {
        const r = Math.min(w / n / 2.4, h / 2.7), cx = (w * (k + 0.5)) / n, cy = h / 2 + 8 * ratio;
        g.strokeStyle = "#ffffff40";
        g.lineWidth = ratio;
        for (const a of [30, 60, 90]) { g.beginPath(); g.arc(cx, cy, r * Math.sin(a * RAD), 0, 7); g.stroke(); }
        for (const p of body.points) {
            g.fillStyle = heat(Math.max(...p.weight));
            g.beginPath();
            g.arc(cx + r * p.wi[0], cy - r * p.wi[1], 2.4 * ratio, 0, 7);
            g.fill();
        }
        const weights = body.points.map((p) => Math.max(...p.weight)), mean = weights.reduce((a, b) => a + b, 0) / (weights.length + body.wasted || 1);
        const variance = weights.reduce((a, b) => a + (b - mean) ** 2, body.wasted * mean * mean) / (weights.length + body.wasted || 1);
        g.fillStyle = "#f1f1f3";
        g.font = `${12 * ratio}px sans-serif`;
        g.textAlign = "center";
        g.fillText(`${n > 1 ? `${body.letter}: ` : ""}weight ${fixed(mean, 3)}, deviation ${fixed(Math.sqrt(variance), 3)}, at most ${fixed(Math.max(0, ...weights), 2)}, ${body.wasted} of ${body.points.length + body.wasted} wasted`, cx, cy + r + 22 * ratio);
        g.strokeStyle = "#f1f1f3";
        const [ox, oy] = [cx - r * Math.sin(body.thetaO * RAD), cy];
        g.beginPath(); g.arc(ox, oy, 4 * ratio, 0, 7); g.stroke();
        g.fillText("ωo", ox, oy - 8 * ratio);
    });
}
