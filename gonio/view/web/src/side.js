// One side of a comparison: a model with its values, its shaders and its film.
import { fromHalf, unpacked } from "./source.js";

/** A number as gonio's notation writes it: nine digits, no more zeros than needed. */
export const digits = (x) => String(Number(x.toPrecision(9)));
const written = (value) =>
    Array.isArray(value)
        ? value.every((v) => v === value[0])
            ? digits(value[0])
            : value.map(digits).join("/")
        : typeof value === "number"
          ? digits(value)
          : value;

export class Side {
    constructor(letter) {
        this.letter = letter;
        this.payload = null;
        this.values = new Map(); // numbers by path
        this.samples = 0;
        this.error = "";
        this.busy = "";
        this.hidden = new Set(); // prefixes of layers that are not drawn
        this.active = null; // the model that is drawn, its values, and where its paths are in this one
    }

    /** Take a model that has arrived: its values are those of its text. */
    take(payload) {
        this.payload = payload;
        this.values = new Map(payload.parameters.map((p) => [p.path, p.value.slice()]));
        this.options = new Map(payload.options.map((o) => [o.path, o.value]));
        this.models = new Map(payload.models.map((m) => [m.path, m.value]));
    }

    parameter(path) {
        return this.payload.parameters.find((p) => p.path === path);
    }

    /** The value that "reset" gives back. */
    startOf(path, fallback) {
        const start = this.payload.start[path];
        const at = path.lastIndexOf(".");
        // The start of an inner model that has been replaced means nothing any more
        for (
            let outer = path.slice(0, Math.max(at, 0));
            outer;
            outer = outer.slice(0, Math.max(outer.lastIndexOf("."), 0))
        ) {
            if (this.models.get(outer) !== this.payload.start[outer]) return fallback;
        }
        if (start === undefined) return fallback;
        const width = Array.isArray(fallback) ? fallback.length : 0;
        return width ? (Array.isArray(start) ? start : Array(width).fill(start)) : start;
    }

    changed(path) {
        const p = this.parameter(path);
        const start = p ? this.startOf(path, p.default) : null;
        // What a link holds has nine digits
        return p ? this.values.get(path).some((v, i) => digits(v) !== digits(start[i])) : false;
    }

    /** gonio's notation of this model, with changes on top. */
    text(changes = {}) {
        const parts = [];
        const gone = (path) =>
            Object.keys(changes).some(
                (key) => path.startsWith(`${key}.`) && this.models.has(key) && changes[key] !== this.models.get(key),
            );
        for (const [path, value] of this.models) {
            const now = changes[path] ?? value;
            const declared = this.payload.models.find((m) => m.path === path);
            if (!gone(path) && now !== this.startOf(path, declared.default)) parts.push(`${path}=${now}`);
        }
        for (const o of this.payload.options) {
            const now = changes[o.path] ?? this.options.get(o.path);
            if (!gone(o.path) && now !== this.startOf(o.path, o.default)) parts.push(`${o.path}=${now}`);
        }
        for (const p of this.payload.parameters) {
            if (!gone(p.path) && this.changed(p.path)) parts.push(`${p.path}=${written(this.values.get(p.path))}`);
        }
        return this.payload.name + (parts.length ? `:${parts.join(",")}` : "");
    }

    /** The same as a model of gonio's, for commands that take no material with changes. */
    plainText() {
        const { payload } = this;
        if (payload.name === payload.model || payload.name.endsWith(".py") || payload.foreign) return this.text();
        if (this.text() === payload.name && payload.plain) return payload.name;
        const parts = payload.models
            .filter((m) => this.models.get(m.path) !== m.default)
            .map((m) => `${m.path}=${this.models.get(m.path)}`);
        for (const o of payload.options)
            if (this.options.get(o.path) !== o.default) parts.push(`${o.path}=${this.options.get(o.path)}`);
        for (const p of payload.parameters)
            if (this.values.get(p.path).some((v, i) => v !== p.default[i]))
                parts.push(`${p.path}=${written(this.values.get(p.path))}`);
        return payload.model + (parts.length ? `:${parts.join(",")}` : "");
    }

    /** The parameters as the shaders take them: a vector for each member. */
    packed(overrides = {}) {
        const { payload, path, values } = this.active,
            data = new Float32Array(4 * Math.max(1, payload.members.length));
        payload.members.map(path).forEach((p, i) => data.set(overrides[p] ?? values.get(p), 4 * i));
        return data;
    }

    /** The maps of a material as the graphics take them. */
    maps() {
        const { maps } = this.payload;
        if (!maps) return { size: 1, layers: 1, pixels: new Float32Array(4) };
        const given = fromHalf(unpacked(maps.half, Uint16Array)),
            n = given.length / maps.channels;
        const pixels = new Float32Array(4 * n);
        for (let i = 0; i < n; i++)
            for (let c = 0; c < maps.channels; c++) pixels[4 * i + c] = given[maps.channels * i + c];
        return { size: maps.size, layers: maps.layers, pixels };
    }

    /** A hook's value at a point, on the processor, as the shader has it. For the probe. */
    overrides(uv, growth, t, maps) {
        const found = {};
        for (const hook of this.payload.hooks) {
            if (hook.source === "mesh") found[hook.path] = [growth];
            else if (hook.source === "viewer") found[hook.path] = [t / hook.unit];
            else if (hook.source !== "normal_map") {
                const tiles = hook.source === "flakes" ? [hook.tiles, hook.tiles] : hook.scale,
                    { size, pixels } = maps;
                const at = uv.map((x, c) => x * tiles[c] * size - (hook.source === "flakes" ? 0 : 0.5));
                const texel = (x, y, c) =>
                    pixels[
                        4 * ((hook.layer * size + (((y % size) + size) % size)) * size + (((x % size) + size) % size)) +
                            c
                    ];
                const [x, y] = at.map(Math.floor),
                    [fx, fy] = [at[0] - x, at[1] - y];
                const value = (c) =>
                    hook.source === "flakes"
                        ? texel(x, y, c)
                        : (1 - fy) * ((1 - fx) * texel(x, y, c) + fx * texel(x + 1, y, c)) +
                          fy * ((1 - fx) * texel(x, y + 1, c) + fx * texel(x + 1, y + 1, c));
                found[hook.path] = hook.width === 3 ? [value(0), value(1), value(2)] : [value(hook.channel)];
            }
        }
        return found;
    }
}
