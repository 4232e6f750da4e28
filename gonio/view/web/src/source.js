// Where models come from: a live server, a saved page, or a notebook.
import { numbersOf } from "./words.js";

/** Base64 of little-endian numbers as a typed array. */
export function unpacked(text, Kind) {
    const bytes = Uint8Array.fromBase64?.(text) ?? Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Kind(bytes.buffer);
}

/** The tables that a model's shaders read, four numbers for each entry. */
export function tableRows({ rows, entries }) {
    const given = unpacked(rows, Float32Array),
        found = new Float32Array(4 * entries);
    for (let i = 0; i < 3 * entries; i++) found[i + Math.floor(i / 3)] = given[i];
    return found;
}

/** Sixteen-bit floats as thirty-two-bit ones. */
export function fromHalf(bits) {
    return Float32Array.from(bits, (h) => {
        const sign = h & 0x8000 ? -1 : 1,
            exponent = (h >> 10) & 31,
            fraction = h & 1023;
        if (exponent === 0) return sign * fraction * 2 ** -24;
        if (exponent === 31) return fraction ? NaN : sign * Infinity;
        return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
    });
}

/** A part of the script that came as text. */
const imported = (text) => import(`data:text/javascript;charset=utf-8,${encodeURIComponent(text)}`);

/** `gonio view`: models are made when they are asked for. */
export class Server {
    live = true;

    constructor(token) {
        this.token = token;
    }

    async #ask(route, body) {
        let answer;
        try {
            answer = await fetch(route, {
                method: "POST",
                body: JSON.stringify(body),
                headers: { "Content-Type": "application/json", "X-Gonio-Token": this.token },
            });
        } catch {
            throw new Error("gonio view is not running any more; start it again and reload this page.");
        }
        const result = await answer.json().catch(() => ({ error: `The server answered ${answer.status}.` }));
        if (!answer.ok) throw Object.assign(new Error(result.error), result);
        return result;
    }

    part(name) {
        return import(`/${name}.js`);
    }
    async file(name) {
        return (await fetch(`/${name}`)).text();
    }

    start() {
        return this.#ask("/api/start", {});
    }
    model(text) {
        return this.#ask("/api/model", { text });
    }
    options(text) {
        return this.#ask("/api/options", { text });
    }
    albedo(text, wo) {
        return this.#ask("/api/albedo", { text, wo }).then((r) => r.albedo);
    }
    code(text, language) {
        return this.#ask("/api/code", { text, language }).then((r) => r.text);
    }

    /** Calls back when a file that a model comes from has changed. */
    watch(changed) {
        // Browsers keep six connections to a server: one of all its tabs listens, and tells the others
        const tabs = new BroadcastChannel("gonio changes");
        tabs.onmessage = ({ data }) => changed(data);
        const listen = () =>
            this.#listen((change) => {
                tabs.postMessage(change);
                changed(change);
            });
        if (navigator.locks) navigator.locks.request("gonio changes", listen);
        else listen();
    }

    async #listen(changed) {
        for (let ended = false; ; ) {
            const answer = await fetch("/api/changes", {
                method: "POST",
                body: "{}",
                headers: { "Content-Type": "application/json", "X-Gonio-Token": this.token },
            }).catch(() => null);
            if (answer && !answer.ok) return;
            // One that breaks may come back; one that nobody takes does not
            if (!answer !== ended) {
                ended = !answer;
                changed({ ended });
            }
            try {
                const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
                for (let rest = ""; ; ) {
                    const { value, done } = await reader.read();
                    if (done) break;
                    const parts = (rest + value).split("\n\n");
                    rest = parts.pop();
                    for (const part of parts) if (part.startsWith("data: ")) changed(JSON.parse(part.slice(6)));
                }
            } catch {
                /* it has ended, or sleeps */
            }
            await new Promise((resolve) => setTimeout(resolve, 1500));
        }
    }
}

/** A saved page: what it holds, and nothing else. */
export class Saved {
    live = false;

    constructor(data) {
        this.data = data;
    }

    async part(name) {
        return imported(await this.file(`${name}.js`));
    }
    async file(name) {
        return this.data.files[name];
    }

    async start() {
        return this.data;
    }

    async model(text) {
        // As it was read in Python, which knows metal=Cu, eta=water and rho=#c08040 as well
        if (Object.hasOwn(this.data.models, text)) return this.data.models[text];
        const [name, rest = ""] = [text.split(":")[0], text.slice(text.indexOf(":") + 1)];
        const base = Object.values(this.data.models).find((m) => m.name === name);
        if (!base) {
            const held = Object.keys(this.data.models);
            throw new Error(
                held.length > 4
                    ? `This saved page holds ${held.length} models and materials, but not this one.`
                    : `This saved page holds ${held.join(" and ")} alone; 'gonio view' has all models.`,
            );
        }
        const pieces = new Map(
            text.includes(":")
                ? rest
                      .split(",")
                      .map((piece) => [piece.slice(0, piece.indexOf("=")), piece.slice(piece.indexOf("=") + 1)])
                : [],
        );
        for (const { path, value, default: first } of base.models)
            if ((pieces.get(path) ?? base.start[path] ?? first) !== value)
                throw new Error("This saved page has its layers as they are; 'gonio view' changes them.");
        const chosen = base.options.map((o) => [o.path, pieces.get(o.path) ?? base.start[o.path] ?? o.default]);
        const found = chosen.every(([, value], i) => base.options[i].value === value)
            ? base
            : this.#variant(base, `${name}|${chosen.map(([path, value]) => `${path}=${value}`).join()}`);
        const numbers = numbersOf(found.parameters, pieces, this.data);
        const paths = [...found.parameters, ...base.options, ...base.models].map((field) => field.path);
        for (const path of pieces.keys())
            if (!paths.includes(path) && !/(^|\.)metal$/.test(path)) throw new Error(`${name} has no '${path}'.`);
        const parameters = found.parameters.map((p) => {
            const start = numbers.get(p.path) ?? [base.start[p.path] ?? p.default].flat();
            return { ...p, value: Array.from({ length: p.width }, (_, c) => start[c] ?? start[0]) };
        });
        return { ...found, parameters };
    }

    #variant(base, key) {
        const variant = this.data.variants?.[key];
        if (!variant) throw new Error("This saved page has no shader for that choice; 'gonio view' has them all.");
        const block = (language) => variant[language].map((i) => this.data.pool[language][i]).join("\n\n");
        return { ...base, ...variant.about, code: { wgsl: block("wgsl"), essl: block("essl") } };
    }

    async code(text, language) {
        const found = (await this.model(text)).code[language];
        if (found === undefined)
            throw new Error("This saved page holds WGSL and GLSL ES only; 'gonio view' has every language.");
        return found;
    }

    watch() {}
}

/** A notebook's kernel, through its widget's messages. */
export class Notebook {
    live = true;
    #waiting = new Map();
    #count = 0;

    constructor(widget) {
        this.widget = widget;
        widget.on("msg:custom", (message) => {
            const waiting = this.#waiting.get(message.id);
            if (!waiting) return;
            this.#waiting.delete(message.id);
            if (message.error) waiting.reject(new Error(message.error));
            else waiting.resolve(message.answer);
        });
    }

    #ask(question, body) {
        const id = ++this.#count;
        this.widget.send({ id, question, body });
        return new Promise((resolve, reject) => {
            this.#waiting.set(id, { resolve, reject });
            setTimeout(() => {
                if (this.#waiting.delete(id)) reject(new Error("The notebook's kernel does not answer; is it busy?"));
            }, 30000);
        });
    }

    async part(name) {
        return imported(await this.file(`${name}.js`));
    }
    async file(name) {
        return (await this.#ask("file", { text: name })).text;
    }

    start() {
        return this.#ask("start", {});
    }
    model(text) {
        return this.#ask("model", { text });
    }
    options(text) {
        return this.#ask("options", { text });
    }
    albedo(text, wo) {
        return this.#ask("albedo", { text, wo }).then((r) => r.albedo);
    }
    code(text, language) {
        return this.#ask("code", { text, language }).then((r) => r.text);
    }
    watch() {}
}
