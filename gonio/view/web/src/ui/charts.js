// Plots, drawn for the size they have: text stays 11 px.
import { html, svg } from "lit-html";
import { MAP_SIZE } from "../passes/measure.js";
import { encode } from "./colour.js";
import { fixed } from "./numbers.js";

export const RAD = Math.PI / 180;
export const CHANNELS = ["red", "green", "blue", "luminance"];
export const pick = (f, channel) => (channel === 3 ? 0.2126 * f[0] + 0.7152 * f[1] + 0.0722 * f[2] : f[channel]);

export const path = (points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
export const line = (d, side) =>
    svg`<path d=${d} fill="none" stroke=${side === "A" ? "var(--a)" : "var(--b)"} stroke-width="1.75" stroke-linejoin="round" stroke-dasharray=${side === "A" ? "none" : "5 3"}></path>`;
const power = (e) =>
    e >= -2 && e <= 3
        ? String(Number((10 ** e).toFixed(3)))
        : `10${[...String(e)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("")}`;

/** Data by side, width and height to a picture; `name` is what the page measures it by. */
export function chart(app, name, label, draw) {
    const { width = 300, height = 150 } = app.sizes[name] ?? {};
    return html`<svg class="p" data-chart=${name} viewBox=${`0 0 ${width} ${height}`} role="img" aria-label=${label}>${draw(width, height)}</svg>`;
}

/** f cos theta in the plane of wo and the normal, log radius. */
export function polar(data, channel, w, h) {
    const r = Math.min(w / 2 - 34, h - 30),
        cx = w / 2,
        cy = h - 20;
    const all = data
        .flatMap(({ slice }) => slice.map((s) => pick(s.f, channel) * Math.cos(s.angle * RAD)))
        .filter((v) => v > 0 && Number.isFinite(v));
    const top = Math.ceil(Math.log10(Math.max(1e-6, ...all)) + 1e-9),
        decades = Math.min(4, Math.max(3, top + 2)),
        low = top - decades;
    const radius = (v) => (v > 0 ? Math.max(0, (Math.log10(v) - low) / decades) * r : 0);
    const at = (angle, length) => [cx + length * Math.sin(angle * RAD), cy - length * Math.cos(angle * RAD)];
    const rings = Array.from({ length: decades }, (_, k) => k + 1).map((k) => {
        const q = (k / decades) * r;
        return svg`<path d=${`M${cx - q} ${cy}A${q} ${q} 0 0 1 ${cx + q} ${cy}`} fill="none" stroke="var(--line)"></path>${r / decades > 22 || k % 2 === decades % 2 ? svg`<text x=${cx + q} y=${cy + 14} text-anchor="middle">${power(low + k)}</text>` : ""}`;
    });
    const spokes = [-60, -30, 0, 30, 60].map(
        (a) =>
            svg`<path d=${path([[cx, cy], at(a, r)])} stroke="var(--line)"></path>${a ? svg`<text x=${at(a, r + 14)[0]} y=${at(a, r + 14)[1] + 4} text-anchor="middle">${a < 0 ? "−" : ""}${Math.abs(a)}°</text>` : ""}`,
    );
    const thetaO = data[0]?.thetaO ?? 45,
        [ox, oy] = at(-thetaO, r);
    return svg`${rings}${spokes}<path d=${`M${cx - r} ${cy}H${cx + r}`} stroke="var(--edge)"></path>
        ${data.map(({ letter, slice }) => line(path(slice.map((s) => at(s.angle, radius(pick(s.f, channel) * Math.cos(s.angle * RAD))))), letter))}
        <path d=${path([
            [cx, cy],
            [ox, oy],
        ])} stroke="var(--text)" stroke-width="1.25" stroke-dasharray="2 3"></path><text x=${ox + 16} y=${oy + 4} class="strong">ωo</text>`;
}

export function axes({ x0, x1, y1, ticks, log = false, xs = [0, 30, 60, 90] }, X, Y) {
    return svg`${ticks.map((v) => svg`<path d=${`M${x0} ${Y(v)}H${x1}`} stroke=${v === 1 && !log ? "var(--edge)" : "var(--line)"}></path><text x=${x0 - 8} y=${Y(v) + 4} text-anchor="end">${log ? power(Math.round(Math.log10(v))) : Number(v.toFixed(3))}</text>`)}
        ${xs.map((a) => svg`<text x=${X(a)} y=${y1 + 16} text-anchor="middle">${a < 0 ? "−" : ""}${Math.abs(a)}°</text>`)}`;
}

/** Directional albedo; what is above 1 is shaded and said in words. */
export function albedo(data, channel, w, h, probe) {
    const [x0, x1, y0, y1] = [34, w - 62, 8, h - 22],
        most = Math.max(1, ...data.flatMap((d) => d.albedo.map((p) => pick(p.value, channel))).filter(Number.isFinite));
    const top = most <= 1.02 ? 1.1 : Math.ceil(most * 2 + 0.1) / 2,
        step = top > 4 ? Math.ceil(top / 4) : top > 1.6 ? 1 : 0.5;
    const X = (a) => x0 + ((x1 - x0) * a) / 90,
        Y = (v) => y1 - ((y1 - y0) * Math.min(v, top)) / top;
    const ticks = Array.from({ length: Math.floor(top / step + 1e-6) + 1 }, (_, i) => i * step);
    const ends = [];
    const curves = data.map(({ letter, albedo: points }) => {
        const values = points.map((p) => [p.angle, pick(p.value, channel)]),
            above = values.filter(([, v]) => v > 1.0005);
        const end = values[values.length - 1][1];
        let y = Y(end) + 4;
        for (const other of ends) if (Math.abs(other - y) < 14) y = other + (y >= other ? 14 : -14);
        ends.push(y);
        return svg`${
            above.length
                ? svg`<path fill="var(--warn)" opacity=".28" d=${`${path([[X(above[0][0]), Y(1)], ...above.map(([a, v]) => [X(a), Y(v)]), [X(above[above.length - 1][0]), Y(1)]])}Z`}></path>
            <text x=${Math.min(X(above[0][0]) - 6, x1 - 4)} y=${Math.max(Y(1) - 12, y0 + 10)} text-anchor=${X(above[0][0]) > x0 + 150 ? "end" : "start"} class="warn">${letter} gains energy ${above[0][0] > 0 ? `from ${Math.round(above[0][0])}°` : "everywhere"}</text>`
                : ""
        }
            ${line(path(values.map(([a, v]) => [X(a), Y(v)])), letter)}<text x=${x1 + 8} y=${y} class=${`of${letter}`}>${letter} ${fixed(end, 2)}</text>`;
    });
    return svg`${axes({ x0, x1, y0, y1, ticks }, X, Y)}${curves}
        ${probe === null ? "" : svg`<path d=${`M${X(probe)} ${y0}V${y1}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${X(probe) + (probe > 55 ? -6 : 6)} text-anchor=${probe > 55 ? "end" : "start"} y=${y0 + 10} class="strong">θo ${Math.round(probe)}°</text>`}`;
}

/** Draws f over half and difference angle into a canvas: linear, exposed so that its 95th percentile is white. */
export function drawMap(canvas, map) {
    canvas.width = canvas.height = MAP_SIZE;
    const context = canvas.getContext("2d"),
        image = context.createImageData(MAP_SIZE, MAP_SIZE);
    const sizes = map
        .filter(Boolean)
        .map((f) => Math.max(...f))
        .filter(Number.isFinite)
        .sort((a, b) => a - b);
    const white = Math.max(1e-9, sizes[Math.floor(0.95 * sizes.length)] ?? 1);
    map.forEach((f, i) =>
        image.data.set(
            f ? [...f.map((x) => Math.round(255 * encode(Math.min(1, Math.max(0, x / white))))), 255] : [0, 0, 0, 0],
            4 * i,
        ),
    );
    context.putImageData(image, 0, 0);
}
