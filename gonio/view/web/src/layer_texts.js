// Changes of layers as texts in gonio's notation.
import { layersOf } from "./ui/shared.js";

const COAT = "alpha=0.02,transmission=both_ways,solid_angle=compressed";
const joined = (name, parts) => name + (parts.length ? `:${parts.join(",")}` : "");

/** The name and the settings of a text. */
function splitText(text) {
    const at = text.indexOf(":");
    return at < 0 ? [text, []] : [text.slice(0, at), text.slice(at + 1).split(",")];
}

/** The text with a clear coat on top; nothing where none can go. */
function coated(side, catalogue) {
    const [name, rest] = splitText(side.plainText());
    if (!catalogue.some((m) => m.kind === "model" && m.name === name)) return "";
    return joined("weidlich_wilkie", [COAT, `base=${name}`, ...rest.map((part) => `base.${part}`)]);
}

/** The text without a coat; nothing for the base. */
function without(side, layer) {
    const layers = layersOf(side),
        i = layers.findIndex((l) => l.prefix === layer.prefix),
        below = layers[i + 1];
    if (!below) return "";
    const [name, rest] = splitText(side.plainText()),
        child = below.prefix.slice(0, -1);
    const parts = [];
    for (const part of rest) {
        const [path] = part.split("=");
        if (path === child) {
            if (layer.prefix) parts.push(`${layer.prefix.slice(0, -1)}=${below.model}`);
            continue;
        }
        if (path.startsWith(below.prefix)) parts.push(layer.prefix + part.slice(below.prefix.length));
        else if (!path.startsWith(layer.prefix) || (layer.prefix && path === layer.prefix.slice(0, -1))) {
            if (path !== layer.prefix.slice(0, -1)) parts.push(part);
        }
    }
    return joined(layer.prefix ? name : below.model, parts);
}

/** The text without the layers that are hidden, and where its paths are in the whole model. */
export function visible(side) {
    const kept = layersOf(side).filter((l) => !side.hidden.has(l.prefix));
    const parts = [],
        inner = [];
    kept.forEach((layer, i) => {
        const here = kept.slice(1, i + 1).map((l) => l.prefix.slice(0, -1).split(".").pop());
        inner.push(here.join("."));
        if (i) parts.push(`${here.join(".")}=${layer.model}`);
    });
    kept.forEach((layer, i) => {
        const prefix = inner[i] ? `${inner[i]}.` : "";
        for (const o of side.payload.options)
            if (o.path.startsWith(layer.prefix) && !o.path.slice(layer.prefix.length).includes("."))
                parts.push(`${prefix}${o.path.slice(layer.prefix.length)}=${side.options.get(o.path)}`);
    });
    const text = joined(kept[0].model, parts);
    const path = (p) => {
        const at = p.lastIndexOf("."),
            i = inner.indexOf(at < 0 ? "" : p.slice(0, at));
        return kept[i].prefix + p.slice(at + 1);
    };
    return { text, path };
}

/** Every number and choice of a layer as it was. */
export function resetLayer(app, { prefix }) {
    const side = app.edited(),
        inside = (path) => path.startsWith(prefix) && !path.slice(prefix.length).includes(".");
    const numbers = {},
        choices = {};
    for (const p of side.payload.parameters) if (inside(p.path)) numbers[p.path] = side.startOf(p.path, p.default);
    for (const o of side.payload.options) {
        const start = side.startOf(o.path, o.default);
        if (inside(o.path) && side.options.get(o.path) !== start) choices[o.path] = start;
    }
    app.setParameters(numbers, "");
    if (Object.keys(choices).length) app.setOptions(choices);
}

export function addCoat(app) {
    for (const side of app.editing()) {
        const text = coated(side, app.start.catalogue);
        if (!text) {
            app.say(
                "A coat cannot go over this.",
                `${side.payload.name} is a file or a material with textures; coats go over gonio's models.`,
                "warn",
            );
            continue;
        }
        side.hidden.clear();
        app.change(side, text).then(() => app.set({ layer: 0 }));
    }
}

export function removeLayer(app, layer) {
    for (const side of app.editing()) {
        const text = without(side, layer);
        if (!text) continue;
        side.hidden.clear();
        app.change(side, text);
    }
}
