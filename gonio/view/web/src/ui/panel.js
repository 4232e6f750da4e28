// The chosen layer: its model, parameters and options.
import { html } from "lit-html";
import * as colour from "./colour.js";
import { icon } from "./icons.js";
import { layersOf } from "./layers.js";
import { at, decades, fixed, place, range, read, shown, toUnit, unitOf } from "./numbers.js";

const MEDIA = {
    water: 1.333,
    "soap film": 1.4,
    acrylic: 1.49,
    "clear coat": 1.5,
    polycarbonate: 1.585,
    sapphire: 1.77,
    zirconia: 2.16,
    diamond: 2.417,
};
const SOURCES = {
    mesh: "from the mesh",
    viewer: "from the viewer",
    flakes: "from a flake map",
    texture: "from a texture",
};

const own = (prefix, path) => path.startsWith(prefix) && !path.slice(prefix.length).includes(".");
const last = (path) => path.slice(path.lastIndexOf(".") + 1);
const sentence = (text) => (text ? `${text[0].toUpperCase()}${text.slice(1).replaceAll("=", " = ")}.` : "");

export function layerPanel(app) {
    const side = app.edited(),
        layers = layersOf(side),
        layer = layers[app.layerIndex()];
    const parameters = side.payload.parameters.filter((p) => own(layer.prefix, p.path));
    const options = side.payload.options.filter((o) => own(layer.prefix, o.path));
    const driven = new Map(side.payload.hooks.map((h) => [h.path, h]));
    const name = (l) => (l.prefix ? l.prefix.slice(0, -1) : l.model);
    return html`<div role="tabpanel" aria-label=${`Layer ${layer.number}`}>
        ${side.error ? html`<div class="sec"><div class="note" role="alert">${icon("warn")}<div><b>${side.error.title}</b><p>${side.error.text}</p></div></div></div>` : ""}
        <div class="sec"><div class="hd"><h2>${layers.length > 1 ? html`${layer.number}&ensp;` : ""}${layer.title}</h2><span class="sp"></span>
            <div class="pick">${modelSelect(app, side, layer)}</div>
            <button class="ib" aria-label="Reset layer" title="Reset layer" @click=${() => app.do("resetLayer", layer)}>${icon("reset")}</button></div>
            ${layers.length > 1 ? html`<div class="path">${layers.map((l, i) => html`${i ? " › " : ""}${l === layer ? html`<b>${name(l)}</b>` : name(l)}`)}</div>` : ""}
            ${layer.prefix ? "" : html`<p class="hint about1">${side.payload.description}</p>`}
            ${parameters.map((p) => parameterRow(app, side, layer, p, driven.get(p.path)))}</div>
        ${
            options.length
                ? html`<div class="sec"><div class="hd"><h2>Options</h2><span class="dim xs">${side.busy || "recompile in under 0.5 s"}</span><span class="sp"></span>
            ${options.some((o) => app.differs(o.path)) ? html`<span class="xs dim"><i class="diffdot"></i>&ensp;differs in ${side.letter === "A" ? "B" : "A"}</span>` : ""}</div>
            ${options.map((o) => optionRow(app, side, o))}</div>`
                : ""
        }</div>`;
}

function modelSelect(app, side, layer) {
    const names = app.start.catalogue.filter((m) => m.kind === "model" || !layer.prefix);
    const current = layer.prefix ? layer.model : side.payload.name;
    const group = (kind, label) =>
        html`<optgroup label=${label}>${names.filter((m) => m.kind === kind).map((m) => html`<option value=${m.name} ?selected=${m.name === current}>${m.name}</option>`)}</optgroup>`;
    return html`<select aria-label="Model of this layer" .value=${current} @change=${(e) => app.chooseModel(layer, e.target.value)}>
        ${names.some((m) => m.kind === "file") ? group("file", "Your files") : ""}${group("model", "Models")}${layer.prefix ? "" : group("material", "Materials")}</select>`;
}

function note(p, layer, hook) {
    if (!p.used) return "unused";
    if (hook) return SOURCES[hook.source];
    if (p.kind === "index" && p.width === 1 && p.path.includes(".")) return `over layer ${layer.number - 1}`;
    if (p.kind === "slope" && p.scale === "log") return "log scale";
    return ["factor", "number", "length"].includes(p.kind) ? "" : p.kind;
}

function parameterRow(app, side, layer, p, hook) {
    const name = last(p.path),
        value = side.values.get(p.path),
        off = !p.used || Boolean(hook),
        text = note(p, layer, hook);
    const reset =
        side.changed(p.path) && !off
            ? html`<button class="rs" aria-label=${`Reset ${p.path}`} title="Reset" @click=${() => app.resetParameter(p.path)}>${icon("reset")}</button>`
            : html`<span></span>`;
    const label = html`<label title=${`${p.doc}; ${range(p)}`} @dblclick=${() => app.resetParameter(p.path)}>${name}${text ? html`<small>${text}</small>` : ""}</label>`;
    const wide = (content, kind = "hint") => html`<span></span><div class="wide ${kind}">${content}</div><span></span>`;
    const wrong =
        app.fieldError?.path === p.path
            ? html`<span></span><div class="wide err" role="alert">${app.fieldError.text} The picture still shows ${value.map((v) => `${shown(toUnit(p, v))}${unitOf(p)}`).join(", ")}.</div><span></span>`
            : "";
    const because = p.unused_because ? wide(sentence(p.unused_because)) : "";
    if (p.width === 1) {
        const v = value[0],
            sigma = side.values.get(`${layer.prefix}sigma_a`),
            beer = name === "thickness" && sigma?.some((s) => s > 0);
        return html`<div class="prm ${off ? "offp" : ""}" title=${p.doc}>${label}${slider(app, p, v, off, beer ? beerTrack(sigma, p) : "")}${field(app, p, v, off, 0)}${reset}
            ${wrong}${p.scale === "log" && !beer && !off ? html`<span></span><div class="tick">${decades(p).map((d) => html`<span .style=${`left:${100 * d.at}%`}>${d.text}</span>`)}</div><span></span><span></span>` : ""}
            ${p.kind === "index" && !off ? wide(mediaSelect(app, side, layer, p, v), "") : ""}${p.kind === "angle" && !off ? wide(`${shown(v)} rad in code and links.`) : ""}
            ${beer ? wide("Track: white light after down and up, seen from above.") : ""}${because}</div>`;
    }
    if (p.kind === "reflectance" && !off) return reflectance(app, p, value, label, reset, wrong);
    const metal = !off && p.kind === "index" && side.parameter(p.path.replace(/eta$/, "k"));
    return html`<div class="prm ${off ? "offp" : ""}" title=${p.doc}>${label}${metal ? html`<div class="wide">${metalSelect(app, side, p)}</div>${reset}<span></span>` : ""}
        <div class="tri wide">${[0, 1, 2].map((c) => html`<span data-c=${"RGB"[c]}>${field(app, p, value[c], off, c)}</span>`)}</div>${metal ? html`<span></span>` : reset}${wrong}${because}</div>`;
}

function slider(app, p, v, disabled, beer) {
    const t = place(p, v),
        move = (to) => app.setParameter(p.path, [to]);
    const keys = (e) => {
        const d = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[e.key];
        if (!d) return;
        e.preventDefault();
        // From the value that is there now: several keys can come before the page is drawn again
        const now = place(p, app.edited().values.get(p.path)[0]);
        move(at(p, Math.min(1, Math.max(0, now + d * (e.shiftKey ? 0.1 : 0.01)))));
    };
    return html`<input type="range" class=${beer ? "beer" : ""} aria-label=${p.path} aria-valuetext=${`${shown(toUnit(p, v))}${unitOf(p)}`} min="0" max="1000" step="1" ?disabled=${disabled}
        .value=${String(Math.round(1000 * t))} .style=${`--f:${100 * t}%;${beer ? `--g:${beer}` : ""}`} @input=${(e) => move(at(p, e.target.valueAsNumber / 1000))} @keydown=${keys}>`;
}

function beerTrack(sigma, p) {
    const stops = Array.from({ length: 9 }, (_, i) => colour.css(sigma.map((s) => Math.exp(-2 * s * at(p, i / 8)))));
    return `linear-gradient(90deg,${stops.join(",")})`;
}

function field(app, p, v, disabled, channel) {
    const label = p.width === 1 ? `${p.path}, value` : `${p.path} ${"RGB"[channel]}`,
        text = `${shown(toUnit(p, v))}${unitOf(p)}`;
    const error = app.fieldError?.path === p.path && app.fieldError.channel === channel ? app.fieldError : null;
    const take = (e) => {
        if (e.target.value === text) return;
        const found = read(p, e.target.value);
        if (found.error) {
            app.fail({ path: p.path, channel, text: found.error, typed: e.target.value });
            return;
        }
        const value = app.edited().values.get(p.path).slice();
        value[channel] = found.value;
        app.setParameter(p.path, value);
    };
    const keys = (e) => {
        e.stopPropagation();
        if (e.key === "Enter") take(e);
        if (e.key === "Escape") {
            e.target.value = text;
            app.fail(null);
            e.target.blur();
        }
    };
    return html`<input class="n ${error ? "bad" : ""}" inputmode="decimal" spellcheck="false" autocomplete="off" aria-label=${label} aria-invalid=${error ? "true" : "false"} ?disabled=${disabled}
        .value=${error ? error.typed : text} title=${String(toUnit(p, v))} @change=${take} @focus=${(e) => e.target.select()} @keydown=${keys}>`;
}

/** The index of what lies above a layer, in air. */
const indexAbove = (side, layer) =>
    layersOf(side)
        .slice(0, layer.number - 1)
        .reduce((eta, l) => eta * (side.values.get(`${l.prefix}eta`)?.[0] ?? 1), 1);

function mediaSelect(app, side, layer, p, v) {
    const above = p.path.includes(".") ? indexAbove(side, layer) : 1;
    const named = Object.entries(MEDIA)
        .map(([name, eta]) => [name, eta / above])
        .filter(([, eta]) => eta >= p.low && (p.high === null || eta <= p.high));
    const now = named.find(([, eta]) => Math.abs(eta - v) < 5e-4)?.[0] ?? "";
    return html`<select aria-label=${`Named index of ${p.path}`} .value=${now} @change=${(e) => e.target.value && app.setParameter(p.path, [named.find(([n]) => n === e.target.value)[1]])}>
        <option value="" ?selected=${!now}>custom${above !== 1 ? `: ${shown(v)} over layer ${layer.number - 1} (${shown(v * above)} in air)` : `, ${fixed(v, 3)}`}</option>
        ${named.map(([name, eta]) => html`<option value=${name} ?selected=${name === now}>${name}, ${fixed(eta * above, 3)}${above !== 1 ? ` (${fixed(eta, 3)} here)` : ""}</option>`)}</select>`;
}

function metalSelect(app, side, p) {
    const kPath = p.path.replace(/eta$/, "k"),
        k = side.parameter(kPath),
        value = side.values.get(p.path),
        kValue = side.values.get(kPath);
    const inside = (q, xs) => xs.every((x) => x >= q.low && x <= (q.high ?? Infinity)),
        near = (xs, ys) => xs.every((x, c) => Math.abs(x - ys[c]) < 1e-4);
    const metals = Object.entries(app.start.metals).filter(([, m]) => inside(p, m.eta) && inside(k, m.k));
    const now = metals.find(([, m]) => near(m.eta, value) && near(m.k, kValue))?.[0] ?? "";
    return html`<select aria-label=${`Named metal of ${p.path}`} .value=${now} @change=${(e) => {
        const m = app.start.metals[e.target.value];
        if (m) app.setParameters({ [p.path]: m.eta, [kPath]: m.k });
    }}>
        <option value="" ?selected=${!now}>custom</option>${metals.map(([name, m]) => html`<option value=${name} ?selected=${name === now}>${name}, ${m.eta.map(shown).join(" ")}</option>`)}</select>`;
}

const inside01 = (x) => Math.min(1, Math.max(0, x));

function reflectance(app, p, value, label, reset, wrong) {
    // A grey has no hue: the last one that was chosen stays
    const kept = app.hue?.path === p.path && colour.hex(colour.fromHsv(app.hue.hsv)) === colour.hex(value);
    const [h, s, v] = kept ? app.hue.hsv : colour.toHsv(value),
        open = app.openColours.has(p.path);
    const set = (hsv) => {
        app.hue = { path: p.path, hsv };
        app.setParameter(
            p.path,
            colour.fromHsv(hsv).map((x) => Number(inside01(x).toPrecision(5))),
        );
    };
    const drag = (e, use) => {
        const target = e.currentTarget,
            box = target.getBoundingClientRect();
        const move = (m) =>
            use(inside01((m.clientX - box.left) / box.width), inside01((m.clientY - box.top) / box.height));
        target.setPointerCapture(e.pointerId);
        target.onpointermove = move;
        target.onpointerup = () => {
            target.onpointermove = null;
        };
        move(e);
    };
    const keys = (e, use) => {
        const d = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
        if (d) {
            e.preventDefault();
            use(d[0] * (e.shiftKey ? 0.1 : 0.01), d[1] * (e.shiftKey ? 0.1 : 0.01));
        }
    };
    const typed = (e) => {
        const found = colour.fromHex(e.target.value);
        if (found) app.setParameter(p.path, found);
        else app.fail({ path: p.path, channel: -1, text: `${e.target.value} is no colour such as #EFCEAD.` });
    };
    return html`<div class="prm" title=${p.doc}>${label}<div class="wide row">
            <button class="swt" .style=${`background:${colour.css(value)}`} aria-expanded=${open} aria-label=${`${open ? "Close" : "Open"} the colours of ${p.path}`} title="Colours" @click=${() => app.toggleColour(p.path)}></button>
            <input class="n m left" aria-label=${`${p.path}, sRGB`} spellcheck="false" .value=${colour.hex(value)} @change=${typed} @keydown=${(
                e,
            ) => {
                e.stopPropagation();
                if (e.key === "Enter") typed(e);
            }}></div>${reset}
        ${
            open
                ? html`<span></span><div class="wide"><div class="sv" role="slider" tabindex="0" aria-label=${`Saturation and value of ${p.path}`} aria-valuetext=${colour.hex(value)} .style=${`--h:${h}`} @pointerdown=${(e) => drag(e, (x, y) => set([h, x, 1 - y]))} @keydown=${(e) => keys(e, (x, y) => set([h, inside01(s + x), inside01(v + y)]))}><i .style=${`left:${100 * s}%;top:${100 * (1 - v)}%`}></i></div>
            <div class="hue" role="slider" tabindex="0" aria-label=${`Hue of ${p.path}`} aria-valuenow=${Math.round(h)} @pointerdown=${(e) => drag(e, (x) => set([360 * Math.min(x, 0.9999), s, v]))} @keydown=${(e) => keys(e, (x) => set([(h + 300 * x + 360) % 360, s, v]))}><i .style=${`left:${h / 3.6}%`}></i></div></div><span></span>`
                : ""
        }
        <label class="c"><small>linear</small></label><div class="tri wide">${[0, 1, 2].map((c) => html`<span data-c=${"RGB"[c]}>${field(app, p, value[c], false, c)}</span>`)}</div><span></span>${wrong}</div>`;
}

function optionRow(app, side, option) {
    const name = last(option.path),
        value = side.options.get(option.path),
        start = side.startOf(option.path, option.default);
    const refused = option.values.filter((v) => !v.allowed),
        trial = app.refused?.path === option.path ? app.refused : null;
    const choose = (e) => {
        const chosen = option.values.find((v) => v.value === e.target.value);
        if (chosen.allowed) {
            app.setOptions({ [option.path]: chosen.value });
            return;
        }
        e.target.value = value;
        app.refuse(option.path, chosen);
    };
    const others = option.values.filter((v) => v.allowed && v.value !== value).map((v) => v.value),
        expect = () => app.do("expect", option.path, others);
    const remedy = Object.entries(trial?.remedy ?? {});
    return html`<div class="opt" title=${option.doc}><span class=${value !== start ? "ch" : ""}>${name}${app.differs(option.path) ? html`<i class="diffdot" role="img" aria-label="differs"></i>` : ""}</span>
        <select aria-label=${option.path} data-value=${value} @change=${choose} @pointerenter=${expect} @focus=${expect}>${option.values.map((v) => html`<option value=${v.value} ?selected=${v.value === value}>${v.value}${v.allowed ? "" : " – refused"}</option>`)}</select>
        ${value !== start ? html`<button class="rs" aria-label=${`Reset ${option.path}`} title="Reset" @click=${() => app.setOptions({ [option.path]: start })}>${icon("reset")}</button>` : html`<span></span>`}
        ${
            trial
                ? html`<div class="why" role="alert"><p><b>${trial.value}</b>: ${trial.reason}</p><div class="row">
            ${remedy.length ? html`<button class="btn" @click=${() => app.setOptions({ ...trial.remedy, [option.path]: trial.value })}>Set ${remedy.map(([k, v]) => `${last(k)} = ${v}`).join(", ")}</button>` : ""}<button class="btn" @click=${() => app.refuse(null)}>Close</button></div></div>`
                : ""
        }
        ${!trial && refused.length ? html`<span></span><button class="hint link" @click=${() => app.refuse(option.path, refused[0])}>${refused.map((v) => v.value).join(", ")} ${refused.length === 1 ? "is" : "are"} refused: why?</button><span></span>` : ""}</div>`;
}
