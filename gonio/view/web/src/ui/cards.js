// Cards above the page: all keys, the choice of a model, and what a narrow top bar has no room for.
import { html } from "./shared.js";

const KEYS = [
    ["1 2 3", "layer, from the top"],
    ["A B X", "show A, show B, swap"],
    ["C", "compare with a copy, or stop"],
    ["W S D K", "wipe, side by side, ×10 difference, flicker"],
    ["F L", "furnace; turn the light"],
    ["P", "probe under the pointer, or the middle"],
    ["[ ]", "exposure, a third of a stop"],
    ["V", "next view"],
    ["Ctrl Z", "undo; with Shift redo"],
    ["?", "all keys"],
];

export function help(app) {
    return html`<div class="sheet1" @click=${(e) => {
        if (e.target === e.currentTarget) {
            app.help = false;
            app.update();
        }
    }}><section class="card" aria-label="All keys"><h2>Keys</h2><table>${KEYS.map(([keys, text]) => html`<tr><td>${keys.split(" ").map((k) => html`<kbd>${k}</kbd>`)}</td><td>${text}</td></tr>`)}</table>
        <p class="dim xs">Drag turns the camera, the wheel moves it, a double click probes. Arrows move a slider by 1 %, with Shift by 10 %; on the picture the camera, with Shift the probe.</p><button class="btn" @click=${() => {
            app.help = false;
            app.update();
        }}>Close</button></section></div>`;
}

export function picker(app) {
    const side = app.sides.find((v) => v.letter === app.picking) ?? app.sides[0],
        words = (app.search ?? "").toLowerCase();
    const found = app.start.catalogue.filter((m) => `${m.name} ${m.summary}`.toLowerCase().includes(words)),
        done = () => {
            app.picking = "";
            app.update();
        };
    const choose = (name) => {
        done();
        const edit = app.state.edit;
        app.state.edit = side.letter;
        app.chooseModel({ prefix: "" }, name);
        app.state.edit = edit;
    };
    return html`<div class="sheet1 left" @click=${(e) => {
        if (e.target === e.currentTarget) done();
    }}><section class="card pick1" aria-label=${`Models for ${side.letter}`}><input class="n left" type="search" placeholder="Search models and materials" aria-label="Search" .value=${app.search ?? ""} @input=${(
        e,
    ) => {
        app.search = e.target.value;
        app.update();
    }} @keydown=${(e) => {
        e.stopPropagation();
        if (e.key === "Escape") done();
        if (e.key === "Enter" && found[0]) choose(found[0].name);
    }}>
        <div class="list">${found.map((m) => html`<button @click=${() => choose(m.name)} aria-current=${m.name === side.payload?.name}><b>${m.name}</b><small>${m.kind === "model" ? "" : `${m.kind} · `}${m.summary}</small></button>`)}${found.length ? "" : html`<p class="dim">Nothing is called “${app.search}”.</p>`}</div></section></div>`;
}

/** What a narrow top bar has no room for. */
export function menu(app) {
    const done = (call) => () => {
        app.menu = false;
        app.update();
        call?.();
    };
    return html`<div class="sheet1 right" @click=${(e) => {
        if (e.target === e.currentTarget) done()();
    }}><section class="card" aria-label="More"><button class="btn" @click=${done(() => app.copy(app.link(), "The link"))}>Copy link</button><button class="btn" @click=${done(() => app.savePicture())}>Save picture</button></section></div>`;
}
