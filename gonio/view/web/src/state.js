// Everything a link restores, in gonio's own notation: #a=weidlich_wilkie:alpha=0.05,base=eon&env=studio&ev=0.5

export const START = {
    a: "",
    b: "",
    cmp: "A",
    wipe: 0.5,
    env: "studio",
    turn: 0,
    ev: 0,
    tone: "none",
    furnace: false,
    shape: "ball",
    view: "picture",
    az: 0,
    el: 13,
    dist: 9.6,
    theta: 45,
    layer: 0,
    probe: "",
    dock: "plots",
    edit: "A",
};

/** Words that settings can be, and the ends of numbers. */
const WORDS = {
    cmp: ["A", "B", "wipe", "side", "flick", "diff"],
    tone: ["none", "reinhard", "filmic"],
    shape: ["ball", "sphere"],
    view: ["picture", "lobe", "slices", "map", "albedo", "weights"],
    dock: ["plots", "code", "about"],
};
const LIMITS = {
    wipe: [0, 1],
    turn: [-180, 180],
    ev: [-20, 20],
    az: [-180, 180],
    el: [-85, 85],
    dist: [2.5, 40],
    theta: [0, 89],
    layer: [0, 99],
};

/** Settings that a number stands for. */
const numeric = (key) => typeof START[key] === "number";

/** The fragment of a link: what differs from the start. */
export function fragment(state) {
    const parts = [];
    for (const [key, start] of Object.entries(START)) {
        const value = state[key];
        // What was dropped on the page stays in this browser
        if ((value === start && !(key === "cmp" && state.b)) || key === "edit" || value === "own") continue;
        const text = numeric(key) ? String(Math.round(value * 1e4) / 1e4) : value === true ? "1" : value;
        // What the notation needs stays readable
        parts.push(
            `${key}=${encodeURIComponent(String(text).toWellFormed?.() ?? text)
                .replace(/%3A/g, ":")
                .replace(/%3D/g, "=")
                .replace(/%2C/g, ",")
                .replace(/%2F/g, "/")}`,
        );
    }
    return parts.join("&");
}

/** A link's settings; unknown ones and bad numbers are left out, and named. */
export function parsed(text) {
    const state = {},
        bad = [];
    for (const part of text.replace(/^#/, "").split("&").filter(Boolean)) {
        const at = part.indexOf("="),
            key = at < 0 ? part : part.slice(0, at);
        let value = "";
        try {
            value = decodeURIComponent(at < 0 ? "" : part.slice(at + 1));
        } catch {
            bad.push(key);
            continue;
        }
        if (key === "token") continue;
        if (!Object.hasOwn(START, key)) {
            bad.push(key);
            continue;
        }
        if (numeric(key)) {
            if (value.trim() === "" || !Number.isFinite(Number(value))) {
                bad.push(key);
                continue;
            }
            value = Number(value);
        } else if (typeof START[key] === "boolean") value = value === "1";
        state[key] = value;
    }
    return { state, bad };
}

/** Undo and redo over copies of the state; a drag of one control is one step. */
export class History {
    constructor(state) {
        this.steps = [JSON.stringify(state)];
        this.at = 0;
        this.name = "";
    }

    /** Remember a state; changes by the same control within a second are one. */
    add(state, name) {
        const text = JSON.stringify(state),
            now = Date.now();
        if (text === this.steps[this.at]) return;
        if (name && name === this.name && now - this.when < 1000) this.steps[this.at] = text;
        else {
            this.steps.splice(++this.at, Infinity, text);
            if (this.steps.length > 200) {
                this.steps.shift();
                this.at--;
            }
        }
        this.name = name;
        this.when = now;
    }

    step(by) {
        if (!this.can(by)) return null;
        this.at += by;
        this.name = "";
        return JSON.parse(this.steps[this.at]);
    }

    can(by) {
        return this.at + by >= 0 && this.at + by < this.steps.length;
    }
}

/** Whether a probe's text is a place of the picture. */
const isPlace = (text) => {
    const at = text.split(",");
    return at.length === 2 && at.every((x) => x.trim() && x >= 0 && x <= 1);
};

/** A link's settings whose words mean something here; the others are named. */
export function known(state, environments, bad) {
    const words = { ...WORDS, env: Object.keys(environments) };
    for (const [key, allowed] of Object.entries(words))
        if (key in state && !allowed.includes(state[key])) {
            bad.push(key);
            delete state[key];
        }
    if (state.probe && !isPlace(state.probe)) {
        bad.push("probe");
        delete state.probe;
    }
    for (const [key, [low, high]] of Object.entries(LIMITS))
        if (key in state && !(state[key] >= low && state[key] <= high)) {
            bad.push(key);
            delete state[key];
        }
    return state;
}
