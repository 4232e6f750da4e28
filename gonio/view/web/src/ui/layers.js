// The layers as a section through the material, in physical order.
import { html, svg } from "lit-html";
import { css } from "./colour.js";
import { icon } from "./icons.js";
import { shown } from "./numbers.js";

/** The layers of a side from the top: prefix of the paths, name of the model, path of the one below. */
export function layersOf(side) {
    const found = [{ prefix: "", model: side.payload.model, child: null }];
    for (const [path, model] of side.models) {
        found[found.length - 1].child = path;
        found.push({ prefix: `${path}.`, model, child: null });
    }
    found.forEach((layer, i) => {
        layer.number = i + 1;
        layer.title = title(side, layer, found.length);
    });
    return found;
}

function title(side, layer, count) {
    const sigma = side.values.get(`${layer.prefix}sigma_a`),
        thickness = side.values.get(`${layer.prefix}thickness`);
    if (layer.child) return sigma?.some((v) => v > 0) && thickness?.[0] !== 0 ? "Tinted coat" : "Clear coat";
    return count > 1 ? "Base" : "Surface";
}

const TELLING = ["eta", "top_eta", "alpha", "roughness", "sigma", "shininess", "metal_alpha", "metallic"];

/** What a row says below its name. */
function summary(side, layer) {
    const parts = layer.child ? [] : [layer.model];
    for (const name of TELLING) {
        const value = side.values.get(layer.prefix + name);
        if (value?.length === 1 && parts.length < 3) parts.push(`${name} ${shown(value[0])}`);
    }
    return parts.join(" · ");
}

/** The true colour of a band: what white light keeps on its way down and up, or the base's reflectance. */
export function bandColour(side, { prefix, child }) {
    const value = (name) => side.values.get(prefix + name);
    const sigma = value("sigma_a"),
        thickness = value("thickness")?.[0] ?? 1;
    if (child) {
        const kept = sigma ? sigma.map((s) => Math.exp(-2 * s * thickness)) : [1, 1, 1];
        return kept.every((v) => v > 0.98) ? "var(--cut1)" : css(kept);
    }
    const colour = value("rho") ?? value("base_color");
    if (colour) return css(colour.map((v) => Math.max(v, 0.02)));
    const eta = value("metal_eta") ?? value("eta"),
        k = value("metal_k") ?? value("k");
    if (eta?.length === 3 && k?.length === 3)
        return css(eta.map((n, c) => ((n - 1) ** 2 + k[c] ** 2) / ((n + 1) ** 2 + k[c] ** 2)));
    return value("f0") ? css(value("f0")) : "var(--edge)";
}

const dice = (seed) => {
    let state = seed;
    return () => (state = (state * 16807) % 2147483647) / 2147483647;
};

/** An edge with slopes like alpha's: always the same heights, scaled. */
function jagged(amount, seed) {
    const random = dice(seed * 7919 + 17);
    return Array.from(
        { length: 19 },
        (_, i) => `${i ? "L" : "M"}${4 * i} ${(9 + amount * 9 * (random() - 0.5)).toFixed(1)}`,
    ).join("");
}

function roughnessOf(side, prefix) {
    for (const name of ["alpha", "roughness", "sigma", "metal_alpha"]) {
        const value = side.values.get(prefix + name);
        if (value) return Math.min(1, value[0]) ** 0.6;
    }
    return 0.35;
}

function band(side, layer, above) {
    const edge = jagged(roughnessOf(side, layer.prefix), layer.number),
        random = dice(99);
    const grains = layer.child
        ? []
        : Array.from(
              { length: 26 },
              () =>
                  svg`<circle cx=${(4 + 64 * random()).toFixed(1)} cy=${(18 + 28 * random()).toFixed(1)} r=${(0.6 + 0.7 * random()).toFixed(1)} fill="#0003"></circle>`,
          );
    return html`<svg viewBox="0 0 72 50" preserveAspectRatio="none" aria-hidden="true">${svg`
        <path d="M0 0H72V50H0Z" fill=${above}></path><path d=${`${edge}L72 50L0 50Z`} fill=${bandColour(side, layer)}></path>${grains}
        <path d=${edge} fill="none" stroke="#fff9" stroke-width="1.25"></path>`}</svg>`;
}

export function layersPanel(app) {
    const side = app.edited(),
        layers = layersOf(side);
    let above = "var(--air)";
    const rows = layers.map((layer, i) => {
        const on = i === app.layerIndex(),
            hidden = side.hidden.has(layer.prefix),
            drawn = band(side, layer, above);
        above = bandColour(side, layer);
        return html`<div class="lay ${hidden ? "off" : ""} ${layers.length > 5 && !on ? "thin" : ""}" ?data-on=${on}>${drawn}
            <button role="tab" aria-selected=${on} @click=${() => app.set({ layer: i })}><b>${layer.number}&ensp;${layer.title}</b><small>${summary(side, layer)}</small></button>
            ${
                layer.child
                    ? html`<button class="ib" aria-pressed=${hidden} aria-label=${`${hidden ? "Show" : "Hide"} layer ${layer.number}`} title=${hidden ? "Show" : "Hide: see what is below"} @click=${() => app.hide(layer.prefix)}>${icon(hidden ? "closed" : "eye")}</button>
            <button class="ib" aria-label=${`Remove layer ${layer.number}`} title="Remove this coat" @click=${() => app.do("removeLayer", layer)}>${icon("close")}</button>`
                    : html`<span></span><span></span>`
            }</div>`;
    });
    return html`<div class="sec"><div class="hd"><h2>Layers</h2>${
        app.two
            ? html`<span class="xs dim">edit</span><div class="seg" role="group" aria-label="Edit">${[
                  "A",
                  "B",
                  "AB",
              ].map(
                  (who) => html`
        <button aria-pressed=${app.state.edit === who} @click=${() => app.set({ edit: who })}>${who === "AB" ? "A + B" : who}</button>`,
              )}</div>`
            : ""
    }
        <span class="sp"></span><button class="btn" title="A clear coat above everything" @click=${() => app.do("addCoat")}>+ Coat</button></div>
        <div class="stack" role="tablist" aria-label="Layers, top first" aria-orientation="vertical">${rows}</div></div>`;
}
