// The whole page from the app's state.
import { html, svg } from "lit-html";
import { direction, packRows } from "../passes/measure.js";
import { albedo, axes, CHANNELS, chart, line, path, pick, polar } from "./charts.js";
import { icon } from "./icons.js";
import { layersOf, layersPanel } from "./layers.js";
import { fixed } from "./numbers.js";
import { layerPanel } from "./panel.js";

const COMPARE = [
    ["A", "A"],
    ["B", "B"],
    ["wipe", "Wipe"],
    ["side", "Side"],
    ["flick", "Flicker"],
    ["diff", "×10"],
];
const VIEWS = [
    ["picture", "Picture"],
    ["lobe", "Lobe"],
    ["slices", "Slices"],
    ["map", "θh θd"],
    ["albedo", "Albedo"],
    ["weights", "Weights"],
];
const DOCK = [
    ["plots", "Plots"],
    ["code", "Code"],
    ["about", "About"],
];
const PHONE = [
    ["side", "Layers", "layers"],
    ["light", "Light", "light"],
    ["plots", "Plots", "plots"],
    ["code", "Code", "code"],
    ["about", "About", "info"],
];

const themeOf = (app) => app.theme ?? (matchMedia("(prefers-color-scheme:light)").matches ? "light" : "dark");

export function pageOf(app) {
    app.options.themed?.(themeOf(app));
    const side = app.edited(),
        ready = side.payload,
        phone = app.phone ?? "side";
    return html`<div class="page" data-t=${themeOf(app)} @dragover=${(e) => {
        e.preventDefault();
    }} @drop=${(e) => {
        e.preventDefault();
        for (const file of [...e.dataTransfer.files].slice(0, 2)) app.take(file);
    }}>
        <div class="app" data-c=${app.two ? app.state.cmp : "A"} data-d=${app.state.dock} data-p=${["plots", "code", "about"].includes(phone) ? "dock" : phone}>
            ${top(app)}${stage(app)}${lightStrip(app)}${dock(app)}
            <aside class="side" aria-label="Material">${ready ? html`${layersPanel(app)}${layerPanel(app)}` : html`<div class="sec">${side.error ? html`<div class="note" role="alert">${icon("warn")}<div><b>${side.error.title}</b><p>${side.error.text}</p></div></div>` : html`<p class="dim">One moment …</p>`}</div>`}</aside>
            <nav class="ptabs" role="tablist" aria-label="Panels">${PHONE.map(
                ([id, text, sign]) =>
                    html`<button role="tab" aria-selected=${phone === id} @click=${() => {
                        app.phone = id;
                        if (DOCK.some(([d]) => d === id)) app.set({ dock: id });
                        app.update();
                    }}>${icon(sign)}${text}</button>`,
            )}</nav>
        </div>${app.help ? app.more((m) => m.help(app)) : ""}${app.menu ? app.more((m) => m.menu(app)) : ""}${app.picking ? app.more((m) => m.picker(app)) : ""}</div>`;
}

/** What differs from the other side, or from the start, in few words. */
function brief(app, side) {
    if (!side.payload) return "";
    const across = app.two ? app.sides[side.letter === "A" ? 1 : 0] : null,
        parts = [];
    const other = across?.payload?.model === side.payload.model ? across : null;
    for (const [path, value] of side.options)
        if (other?.options ? other.options.get(path) !== value : value !== side.startOf(path, value)) parts.push(value);
    for (const p of side.payload.parameters) {
        const value = side.values.get(p.path),
            theirs = other?.values?.get(p.path);
        if (other ? theirs?.some((v, i) => v !== value[i]) : side.changed(p.path))
            parts.push(`${p.path} ${value.length === 1 ? Number(value[0].toPrecision(3)) : ""}`.trim());
    }
    return parts.slice(0, 3).join(", ") || (side.payload.title || "").split(":")[0];
}

function chip(app, side) {
    return html`<button class="chip ${side.letter}" title=${`Choose model ${side.letter}`} aria-label=${`Model ${side.letter}: ${side.text?.call && side.payload ? side.payload.name : ""}. Choose another`} @click=${() => {
        app.picking = side.letter;
        app.search = "";
        app.update();
    }}><b>${side.letter}</b><span>${side.payload?.name.split("/").pop() ?? "…"}<small>${brief(app, side)}</small></span></button>`;
}

function top(app) {
    const s = app.state,
        theme = () => {
            app.theme = themeOf(app) === "light" ? "dark" : "light";
            app.update();
        };
    return html`<header class="top"><div class="logo">gonio <span>view</span></div>${chip(app, app.sides[0])}
        ${
            app.two
                ? html`<button class="ib u" aria-label="Swap A and B" title="Swap A and B (X)" @click=${() => app.swap()}>${icon("swap")}</button>${chip(app, app.sides[1])}<button class="ib u" aria-label="Stop comparing" title="Stop comparing (C)" @click=${() => app.compare(false)}>${icon("close")}</button>`
                : html`<button class="btn u" title="Compare with a copy (C)" @click=${() => app.compare(true)}>Compare</button>`
        }
        <span class="sp"></span>${app.two ? html`<div class="seg" role="group" aria-label="Compare">${COMPARE.map(([id, text]) => html`<button aria-pressed=${s.cmp === id} @click=${() => app.set({ cmp: id })}>${text}</button>`)}</div><span class="sp"></span>` : ""}
        <button class="ib u" aria-label="Undo" title="Undo (Ctrl Z)" ?disabled=${!app.history?.can(-1)} @click=${() => app.step(-1)}>${icon("undo")}</button><button class="ib u" aria-label="Redo" title="Redo (Ctrl Shift Z)" ?disabled=${!app.history?.can(1)} @click=${() => app.step(1)}>${icon("redo")}</button>
        <button class="btn t" @click=${() => app.copy(app.link(), "The link")}>Copy link</button><button class="btn t" @click=${() => app.savePicture()}>Save picture</button><button class="ib more" aria-label="More" title="Copy link, save picture" aria-expanded=${Boolean(app.menu)} @click=${() => {
            app.menu = !app.menu;
            app.update();
        }}>${icon("more")}</button><button class="ib" aria-label="Light or dark" title="Light or dark" @click=${theme}>${icon("light")}</button></header>`;
}

function stage(app) {
    const s = app.state,
        wiping = app.two && s.cmp === "wipe" && s.view === "picture",
        both = app.two && ["wipe", "side"].includes(s.cmp) && s.view === "picture";
    return html`<main class="stage" aria-label="Picture" data-c=${app.two ? s.cmp : "A"} .style=${`--w:${s.cmp === "side" ? 50 : 100 * s.wipe}%`}>
        <div class="canvas" tabindex="0" role="img" aria-label=${`${app.sides.map((side) => side.payload?.name).join(" and ")} under ${s.furnace ? "the furnace" : s.env}. Arrows turn the camera, with Shift they move the probe.`} @pointerdown=${(e) => orbit(app, e)} @pointermove=${(e) => point(app, e)} @pointerleave=${() => {
            app.pointer = null;
        }} @wheel=${(e) => {
            e.preventDefault();
            app.set({ dist: Math.min(40, Math.max(2.5, s.dist * Math.exp(e.deltaY * 0.001))) }, "dist");
        }} @keydown=${(e) => turn(app, e)} @dblclick=${(e) => {
            const p = place(app, e);
            if (p) app.probe(...p);
        }}></div>
        ${s.view !== "picture" ? app.more((m) => m.large(app), html`<div class="large"></div>`) : ""}
        ${
            wiping
                ? html`<div class="wipe" role="slider" tabindex="0" aria-orientation="horizontal" aria-label="Wipe between A and B" aria-valuemin="0" aria-valuemax="100" aria-valuenow=${Math.round(100 * s.wipe)} @pointerdown=${(e) => wipe(app, e)} @keydown=${(
                      e,
                  ) => {
                      const d = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
                      if (d) {
                          e.preventDefault();
                          e.stopPropagation();
                          app.set({ wipe: Math.min(1, Math.max(0, s.wipe + d * (e.shiftKey ? 0.1 : 0.01))) }, "wipe");
                      }
                  }}><i>${icon("wipe")}</i></div>`
                : ""
        }
        ${both ? app.sides.map((side) => html`<div class="glass tag ${side.letter}"><b class="k ${side.letter === "B" ? "kb" : ""}">${side.letter}</b><span>${brief(app, side)}</span></div>`) : ""}
        <div class="glass views" role="tablist" aria-label="View">${VIEWS.map(([id, text]) => html`<button role="tab" aria-selected=${s.view === id} @click=${() => app.set({ view: id })}>${text}</button>`)}</div>
        ${quality(app)}${s.view === "picture" ? probe(app) : ""}${numbers(app)}
        ${app.notes.length ? html`<div class="notes" aria-live="polite">${app.notes.map((n) => html`<div class="glass note1 ${n.kind}">${icon(n.kind === "warn" ? "warn" : "info")}<div><b>${n.title}</b>${n.text ? html`<p>${n.text}</p>` : ""}</div><button class="ib" aria-label="Close message" @click=${() => app.dismiss(n)}>${icon("close")}</button></div>`)}</div>` : ""}
        <div class="glass keys">${app.two ? html`<span><kbd>W</kbd>wipe</span>` : html`<span><kbd>C</kbd>compare</span>`}<span><kbd>F</kbd>furnace</span><button @click=${() => {
            app.help = true;
            app.update();
        }}><kbd>?</kbd>all keys</button></div></main>`;
}

function quality(app) {
    const sides = app.renderer?.settings ? app.renderer.visible() : [],
        spp = Math.min(...sides.map((v) => v.shown || 0), Infinity),
        stats = app.statistics?.sides;
    const noise = stats?.length ? Math.max(...stats.map((v) => v.noise)) : null;
    return html`<div class="glass qual" title="Samples per pixel, noise of the mean, time per pass"><i class="h" .style=${`--q:${Number.isFinite(spp) ? (100 * spp) / app.renderer.limit : 0}%`}></i><span><b>${Number.isFinite(spp) ? spp : 0}</b> <span class="dim">spp</span></span>
        ${noise === null ? "" : html`<span><b>${noise < 0.1 ? fixed(100 * noise, 1) : Math.round(100 * noise)} %</b> <span class="dim">noise</span></span>`}${app.renderer ? html`<span class="h"><b>${app.renderer.ms < 100 ? fixed(app.renderer.ms, 1) : Math.round(app.renderer.ms)}</b> <span class="dim">ms</span></span>` : ""}<span class="dim h" title=${app.gpu?.adapter ?? ""}>${app.gpu?.name ?? "no GPU"}</span></div>`;
}

function numbers(app) {
    const found = app.statistics;
    if (!found || app.state.view !== "picture") return "";
    return html`<div class="glass cmp" title="Linear values, whole picture, no tone curve">${found.rmse === null ? "" : html`<span><span class="dim">RMSE</span><b>${fixed(found.rmse)}</b></span>`}${found.sides.map((side) => html`<span class=${app.two ? "h" : ""}><span class="dim">mean ${app.two ? side.letter : ""}</span><b class="thin">${fixed(side.mean)}</b></span>`)}</div>`;
}

function place(app, e) {
    const box = e.currentTarget.getBoundingClientRect();
    let x = (e.clientX - box.left) / box.width;
    const y = (e.clientY - box.top) / box.height;
    if (app.two && app.state.cmp === "side") x = (x * 2) % 1;
    return x >= 0 && x <= 1 && y >= 0 && y <= 1 ? [x, y] : null;
}

function point(app, e) {
    app.pointer = place(app, e);
}

function orbit(app, e) {
    const target = e.currentTarget,
        { az, el } = app.state,
        [x, y] = [e.clientX, e.clientY],
        start = place(app, e);
    let dragged = false;
    target.setPointerCapture(e.pointerId);
    const move = (m) => {
        if (!dragged && Math.hypot(m.clientX - x, m.clientY - y) < 4) return;
        dragged = true;
        const a = ((az - (m.clientX - x) * 0.4 + 540) % 360) - 180;
        app.set(
            {
                az: Math.round(a * 10) / 10,
                el:
                    Math.round(Math.min(85, Math.max(app.state.furnace ? -85 : -2, el + (m.clientY - y) * 0.3)) * 10) /
                    10,
            },
            "camera",
        );
    };
    const up = () => {
        target.removeEventListener("pointermove", move);
        target.removeEventListener("pointerup", up);
        if (!dragged && start && matchMedia("(pointer:coarse)").matches) app.probe(...start);
    };
    target.addEventListener("pointermove", move);
    target.addEventListener("pointerup", up);
}

/** Of the picture: what is probed where no pointer is. */
export const MIDDLE = [0.5, 0.45];

const at01 = (x) => Math.min(1, Math.max(0, x));

function turn(app, e) {
    const d = { ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, 3], ArrowDown: [0, -3] }[e.key];
    if (!d) return;
    e.preventDefault();
    if (e.shiftKey) {
        const [x, y] = app.state.probe ? app.state.probe.split(",").map(Number) : MIDDLE;
        app.probe(at01(x + d[0] / 500), at01(y - d[1] / 200));
        return;
    }
    app.set(
        { az: ((app.state.az + d[0] + 540) % 360) - 180, el: Math.min(85, Math.max(-2, app.state.el + d[1])) },
        "camera",
    );
}

function wipe(app, e) {
    const target = e.currentTarget,
        box = target.parentNode.getBoundingClientRect();
    e.preventDefault();
    target.setPointerCapture(e.pointerId);
    const move = (m) =>
        app.set(
            { wipe: Math.round(Math.min(1, Math.max(0, (m.clientX - box.left) / box.width)) * 1000) / 1000 },
            "wipe",
        );
    target.onpointermove = move;
    target.onpointerup = () => {
        target.onpointermove = null;
    };
}

const degrees = (x) => `${fixed((Math.acos(Math.max(-1, Math.min(1, x))) * 180) / Math.PI, 1)}°`;

function probe(app) {
    const seen = app.probed;
    if (!app.state.probe || !seen) return "";
    const left = app.two && app.state.cmp === "side" ? seen.x / 2 : seen.x;
    return html`<span class="hair" aria-hidden="true" .style=${`left:${100 * left}%;top:${100 * seen.y}%`}></span>${probed(app, `glass probe ${left > 0.6 ? "west" : ""}`)}`;
}

/** The numbers of the probe: on the stage, or in the dock where two pictures or a small screen have no room. */
function probed(app, kind) {
    const seen = app.probed;
    if (!app.state.probe || !seen) return "";
    const [w, h] = app.renderer.pictureSize(app.state);
    const close = html`<button class="xs dim" title="Close (P or Esc)" @click=${() => app.set({ probe: "" })}><kbd>P</kbd>close</button>`;
    const head = html`<h3>Probe <span class="dim">pixel ${Math.floor(seen.x * w)}, ${Math.floor(seen.y * h)}</span><span class="sp"></span>${close}</h3>`;
    if (!seen.found)
        return html`<section class=${kind} aria-label="Probe">${head}<p class="dim">Not on the material.</p></section>`;
    const { wi, wo } = seen.found,
        phi = Math.atan2(wi[1], wi[0]) - Math.atan2(wo[1], wo[0]),
        turned = Math.abs((((phi * 180) / Math.PI + 540) % 360) - 180),
        mark = (v) => (v.letter === "B" ? "isB" : "");
    return html`<section class=${kind} aria-label="Probe">${head}
        <table class="dirs"><tbody>${[
            ["ωi", wi],
            ["ωo", wo],
        ].map(
            ([name, d]) => html`<tr><td>${name}</td>${d.map((x) => html`<td>${fixed(x, 3)}</td>`)}</tr>`,
        )}<tr><td>angles</td><td colspan="3">θi ${degrees(wi[2])}&ensp;θo ${degrees(wo[2])}&ensp;φ ${fixed(turned, 1)}°</td></tr></tbody></table><hr>
        <table><tbody><tr><th scope="col"><span class="sr">Quantity</span></th><th scope="col">R</th><th scope="col">G</th><th scope="col">B</th></tr>
            ${seen.values.map((v) => html`<tr class=${mark(v)} data-probe=${`f${v.letter}`}><td>f${app.two ? html`&ensp;${v.letter}` : ""}</td>${v.f.map((x) => html`<td data-value=${x}>${fixed(x)}</td>`)}</tr>`)}
            ${seen.values.map((v) => html`<tr class=${mark(v)} data-probe=${`albedo${v.letter}`}><td>albedo ${app.two ? v.letter : ""}</td>${v.albedo.map((x) => html`<td data-value=${x}>${fixed(x)}</td>`)}</tr>`)}
            ${
                seen.values.length
                    ? html`<tr data-probe="pdf"><td>pdf</td><td colspan="3">${seen.values
                          .map((v) => fixed(v.pdf))
                          .filter((v, i, all) => all.indexOf(v) === i)
                          .join(
                              ", ",
                          )} /sr${seen.values.length === 2 && fixed(seen.values[0].pdf) === fixed(seen.values[1].pdf) ? ", both" : ""}</td></tr>`
                    : ""
            }</tbody></table></section>`;
}

const theta = (app) =>
    html`<label class="thetao">θo <b>${Math.round(app.state.theta)}°</b><input type="range" min="0" max="89" step="1" aria-label="Angle of the viewer" .value=${String(app.state.theta)} .style=${`--f:${(100 * app.state.theta) / 89}%`} @input=${(e) => app.set({ theta: e.target.valueAsNumber }, "theta")}></label>`;
const channels = (app) =>
    html`<select class="channel" aria-label="Channel" .value=${String(app.channel)} @change=${(e) => {
        app.channel = Number(e.target.value);
        app.update();
    }}>${CHANNELS.map((name, i) => html`<option value=${i} ?selected=${i === app.channel}>${name}</option>`)}</select>`;

const mapCanvases = (app) =>
    app
        .plots()
        .map(
            (d) =>
                html`<span class="map"><canvas data-map=${d.letter} role="img" aria-label=${`f of ${d.letter} over half and difference angle`}></canvas>${app.two ? html`<b class="k ${d.letter === "B" ? "kb" : ""}">${d.letter}</b>` : ""}<small class="y">90°</small><small class="y0">θd</small><small class="x0">0°</small><small class="xm">θh</small><small class="x1">90°</small></span>`,
        );

function lightStrip(app) {
    const s = app.state,
        envs = app.start.environments,
        pick = () => pickFile(app);
    return html`<section class="light" aria-label="Light"><button class="sw" role="switch" aria-checked=${s.furnace} title="Radiance 1 from everywhere (F)" @click=${() => app.set({ furnace: !s.furnace })}><i></i>Furnace</button>
        <div class="envs w">${Object.keys(envs).map((name) => html`<button class=${`env-${name}`} aria-pressed=${s.env === name} title=${name} @click=${() => app.set({ env: name })}><canvas data-env=${name} aria-hidden="true"></canvas><span>${name}</span></button>`)}${app.renderer?.sky ? html`<button aria-pressed=${s.env === "own"} @click=${() => app.set({ env: "own" })}><span>own</span></button>` : ""}<button class="drop h" aria-label="Open an HDR picture or a mesh" title="Drop .hdr, .exr, .obj or .glb anywhere, or choose a file" @click=${pick}>Drop<br>HDR, OBJ</button></div>
        <div class="g"><label>Turn light<b>${Math.round(s.turn)}°</b></label><input type="range" class="bi" aria-label="Turn light" min="-180" max="180" .value=${String(s.turn)} @input=${(e) => app.set({ turn: e.target.valueAsNumber }, "turn")} @dblclick=${() => app.set({ turn: 0 })}></div>
        <div class="g"><label>Exposure<b>${s.ev < 0 ? "−" : "+"}${Math.abs(s.ev).toFixed(1)} EV</b></label><input type="range" class="bi" aria-label="Exposure" min="-6" max="6" step=".1" .value=${String(s.ev)} @input=${(e) => app.set({ ev: e.target.valueAsNumber }, "ev")} @dblclick=${() => app.set({ ev: 0 })}></div>
        <div class="g tone"><select aria-label="Tone curve" .value=${s.tone} @change=${(e) => app.set({ tone: e.target.value })}>${["none", "reinhard", "filmic"].map((t) => html`<option value=${t} ?selected=${t === s.tone}>Tone: ${t}</option>`)}</select></div>
        <div class="g shape"><select aria-label="Shape" .value=${s.shape} @change=${(e) => (e.target.value === "open" ? pick() : app.set({ shape: e.target.value }))}>${[["ball", "Ball"], ["sphere", "Sphere"], ...(app.renderer?.own ? [["own", "Own mesh"]] : []), ["open", "Open mesh …"]].map(([id, text]) => html`<option value=${id} ?selected=${id === s.shape}>${text}</option>`)}</select></div>
        <div class="phone w" role="group" aria-label="Compare and share">${app.two ? html`<div class="seg">${COMPARE.map(([id, text]) => html`<button aria-pressed=${s.cmp === id} @click=${() => app.set({ cmp: id })}>${text}</button>`)}</div>` : ""}
            <div class="row"><button class="btn" @click=${() => app.compare()}>${app.two ? "Stop comparing" : "Compare"}</button><button class="btn" @click=${() => app.copy(app.link(), "The link")}>Copy link</button><button class="btn" @click=${() => app.savePicture()}>Save picture</button></div></div></section>`;
}

function pickFile(app) {
    const input = document.createElement("input");
    input.type = "file";
    input.accept = ".hdr,.exr,.obj,.glb";
    input.onchange = () => input.files[0] && app.take(input.files[0]);
    input.click();
}

function dock(app) {
    const s = app.state,
        plots = app.plots(),
        title = (text, sub, view) =>
            html`<figcaption>${text}<span>${sub}</span><button class="ib" aria-label=${`Show ${text} large`} title="Show large" @click=${() => app.set({ view })}>${icon("large")}</button></figcaption>`;
    const plot =
        () => html`<div class="plots"><figure>${title("Lobe slice", "f cos θi, log radius, 1/sr", "slices")}${plots.length ? chart(app, "polar", "Slice of the lobe, logarithmic radius", (w, h) => polar(plots, app.channel, w, h)) : ""}</figure>
        <figure>${title("Albedo", `over θo, ${CHANNELS[app.channel]}`, "albedo")}${plots.length ? chart(app, "albedo", "Directional albedo", (w, h) => albedo(plots, app.channel, w, h, s.theta)) : ""}</figure>
        <figure>${title("Half and difference angle", "f", "map")}<div class="maps">${mapCanvases(app)}</div></figure>${probed(app, "probe docked")}</div>`;
    return html`<section class="dock"><div class="tabs" role="tablist" aria-label="Dock">${DOCK.map(([id, text]) => html`<button role="tab" aria-selected=${s.dock === id} @click=${() => app.set({ dock: id })}>${text}</button>`)}<span class="sp"></span>${s.dock === "plots" ? html`${theta(app)}${channels(app)}${app.two ? html`<span class="xs dim row lg"><i class="la"></i>A<i class="lb"></i>B</span>` : ""}` : ""}</div>
        <div class="pane ${s.dock === "plots" ? "" : s.dock}">${s.dock === "plots" ? plot() : app.more((m) => (s.dock === "code" ? m.codePane(app) : m.aboutPane(app)))}</div></section>`;
}

/** What `more.js` uses of the page. */
export const parts = {
    albedo,
    axes,
    channels,
    chart,
    direction,
    html,
    layersOf,
    line,
    mapCanvases,
    packRows,
    path,
    pick,
    polar,
    svg,
    theta,
};
