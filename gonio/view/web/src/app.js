// The page's state and what changes it. What is drawn from it stands in ui/, how pictures grow in renderer.js.
import { render } from "lit-html";
import { measure, packRows } from "./passes/measure.js";
import { graphics, Renderer } from "./renderer.js";
import { surface } from "./scene/surface.js";
import { Side } from "./side.js";
import { fragment, History, known, parsed, START } from "./state.js";
import { drawMap } from "./ui/charts.js";
import { keyboard } from "./ui/keys.js";
import { layersOf } from "./ui/layers.js";
import { pageOf, parts } from "./ui/page.js";

const STOPPED =
    "The picture and its sliders go on. New models, choices and code need it: start it again, and paste this page's link behind its address.";

const LATE = 16; // models that are kept
const LOST_AGAIN = 20_000; // milliseconds after a loss, within which a second one means another interface

export class App {
    constructor(root, source, options = {}) {
        Object.assign(this, {
            root,
            source,
            options,
            sizes: {},
            data: {},
            lobes: {},
            statistics: null,
            notes: [],
            code: {},
            language: "wgsl",
        });
        this.state = { ...START };
        this.sides = [new Side("A")];
        this.openColours = new Set();
        this.channel = 3;
        this.lobe = { az: -62, el: 22, log: true, weights: true };
        this.wanted = options.graphics ?? "";
        this.coming = {};
        this.late = new Map(); // payloads by text
        this.looks = 0; // counts what the probe might see change
        this.replaced = []; // shaders that are given back when nothing measures
    }

    /** Something of a part of the script that is loaded when it is first wanted; until then what stands in for it. */
    more(use, instead = "") {
        if (this.loaded) return use(this.loaded);
        this.#shared().then(
            (found) => {
                this.loaded = found;
                this.update();
            },
            (error) => this.say("This view cannot be loaded.", error.message, "warn"),
        );
        return instead;
    }

    /** A change that is rarely made, by its name in that part. */
    async do(name, ...given) {
        return (await this.#shared())[name](this, ...given);
    }

    async #shared() {
        const found = await this.part("more");
        found.share(parts);
        return found;
    }

    part(name) {
        return (this.coming[name] ??= this.source.part(name));
    }

    // --- beginning -----------------------------------------------------------------------------------

    async open() {
        const { state, bad } = parsed(this.options.fragment ?? "");
        const [start, { gpu, reason }] = await Promise.all([
            this.source.start(),
            graphics(this.source, this.wanted).catch((error) => ({ gpu: null, reason: error.message })),
        ]);
        this.start = start;
        Object.assign(this.state, known(state, this.start.environments, bad));
        if (!this.state.a) this.state.a = this.start.show[0] ?? "eon";
        if (!this.state.b && !("a" in state) && this.start.show[1]) this.state.b = this.start.show[1];
        if (!this.state.b) this.state.cmp = "A";
        else if (!("cmp" in state)) this.state.cmp = "wipe";
        if (bad.length)
            this.say(
                "This link was taken in part.",
                `Not understood: ${[...new Set(bad)].filter(Boolean).join(", ") || "a part without a name"}.`,
            );
        if (gpu) this.#use(gpu);
        else this.say("No picture can be drawn here.", reason, "warn");
        if (gpu?.name === "WebGL2" && !this.wanted)
            this.say("WebGL2 is used instead of WebGPU.", `${reason} All views work; shaders compile more slowly.`);
        this.update();
        setTimeout(() => this.renderer?.prepare({ ...this.state })); // while the shader compiles
        await this.#load();
        this.history = new History(this.#remembered());
        this.openColours.add(this.edited().payload?.parameters.find((p) => p.kind === "reflectance")?.path);
        this.#flicker();
        this.source.watch((change) => this.#fileChanged(change));
        this.update();
        return this;
    }

    #use(gpu) {
        if (this.renderer) this.renderer.replace(gpu);
        else {
            this.renderer = new Renderer(gpu, this.start, (side) => this.#passed(side));
            this.renderer.sides = this.sides;
            // Some losses are told by errors alone; each device is given up once, and not without end
            this.renderer.failed = (error) => {
                if (this.failedOn === this.gpu) return;
                this.failedOn = this.gpu;
                this.failures = (this.failures ?? 0) + 1;
                this.say("The picture stopped.", error.message, "warn");
                if (this.failures < 4) this.#lost(this.gpu);
            };
            this.renderer.run();
        }
        this.gpu = gpu;
        gpu.lost.then((info) => {
            if ((gpu === this.gpu && !this.closed && info.reason !== "destroyed") || this.testLoss) this.#lost(gpu);
        });
    }

    async #lost(gpu) {
        if (this.closed || gpu !== this.gpu) return;
        this.testLoss = false;
        this.gpu = null;
        // What is lost again at once does not hold
        const again = gpu.name === "WebGPU" && performance.now() - (this.lostAt ?? -Infinity) < LOST_AGAIN;
        this.lostAt = performance.now();
        if (again) this.wanted = "webgl2";
        const found = await graphics(this.source, this.wanted).catch((error) => ({ reason: error.message }));
        if (!found.gpu) {
            this.say("The GPU was lost.", `${found.reason} The last picture stays.`, "warn");
            return;
        }
        this.#use(found.gpu);
        this.update();
        await Promise.all(this.sides.map((side) => this.#compile(side)));
        this.say(
            again ? "WebGL2 is used instead of WebGPU." : "The GPU was lost and is back.",
            `${again ? "The GPU was lost twice. " : ""}Everything was restored from the page's state; the picture starts again.`,
        );
        this.moved(false);
    }

    get two() {
        return this.sides.length > 1;
    }

    /** The sides that the link or the commands name. */
    async #load() {
        if (Boolean(this.state.b) !== this.two) {
            this.sides.length = 1;
            if (this.state.b) this.sides.push(new Side("B"));
            if (!this.two) Object.assign(this.state, { cmp: "A", edit: "A" });
        }
        await Promise.all(this.sides.map((side) => this.#take(side, this.state[side.letter.toLowerCase()])));
    }

    /** Show another text on a side; the old picture stays until the new one is there, and if there is none. */
    async #take(side, text) {
        const turn = (side.turn = (side.turn ?? 0) + 1),
            busy = setTimeout(() => {
                side.busy = "compiling …";
                this.update();
            }, 200);
        try {
            const payload = await this.payload(text);
            if (side.turn !== turn) return false;
            await this.#suit(side, payload);
            const old = side.payload,
                before = old && {
                    program: side.program,
                    values: side.values,
                    options: side.options,
                    models: side.models,
                };
            const fits =
                old &&
                side.program &&
                ["code", "hooks"].every((part) => same(old[part], payload[part])) &&
                old.tables?.rows === payload.tables?.rows;
            side.take(payload);
            if (fits) side.active.values = side.values;
            else {
                try {
                    await this.#compile(side, turn);
                } catch (error) {
                    if (old) Object.assign(side, { payload: old, ...before });
                    throw new Error(`This GPU's driver refuses the shader: ${error.message}`);
                }
                if (side.turn !== turn) return false;
            }
            side.error = "";
            this.state[side.letter.toLowerCase()] = side.text();
            this.#askOptions(side);
            this.moved();
            return true;
        } catch (error) {
            if (side.turn !== turn) return false;
            side.error = {
                title: text.length > 80 ? `${text.slice(0, 77)}…` : text,
                text: `${error.message} ${side.payload ? "The picture is of the last model that worked." : ""}`,
            };
            if (!side.payload) {
                // A link that names nothing: something has to be shown
                const fallback = this.start.show.find((t) => t !== text) ?? "eon";
                const { error: kept } = side;
                if (text !== fallback && (await this.#take(side, fallback))) {
                    side.error = kept;
                    this.say(
                        `${kept.title} cannot be shown.`,
                        `${error.message} ${fallback} is shown instead.`,
                        "warn",
                    );
                }
            }
            return false;
        } finally {
            clearTimeout(busy);
            if (side.turn === turn) side.busy = "";
            this.update();
        }
    }

    /** A model by its text: those of late are kept, and the one that the page opens with has come already. */
    payload(text) {
        if (!this.source.live) return this.source.model(text);
        const { [text]: first } = this.start.models,
            found = this.late.get(text) ?? (first ? Promise.resolve(first) : this.source.model(text));
        delete this.start.models[text];
        this.late.delete(text);
        this.late.set(text, found);
        found.catch(() => this.late.delete(text));
        if (this.late.size > LATE) this.late.delete(this.late.keys().next().value);
        return found;
    }

    /** Code that others wrote runs in one of the interfaces only: the page changes to that one. */
    async #suit(side, payload) {
        const runs = (found, language) => !found || language in found.code;
        if (!this.gpu || runs(payload, this.gpu.language)) return;
        const other = this.sides.find((s) => s !== side),
            wanted = this.gpu.language === "wgsl" ? "webgl2" : "webgpu",
            language = Object.keys(payload.code)[0];
        if (!runs(other?.payload, language))
            throw new Error(
                `${payload.foreign.language} and ${other.payload.foreign.language} run in different interfaces of the browser and cannot be shown side by side; compare each with a model of gonio's.`,
            );
        const { gpu, reason } = await graphics(this.source, wanted);
        if (gpu.language !== language) {
            gpu.close();
            throw new Error(`${payload.foreign.language} needs WebGPU. ${reason}`);
        }
        this.wanted = wanted;
        const old = this.gpu;
        this.#use(gpu);
        old.close();
        if (other?.payload) await this.#compile(other);
        this.say(
            `${gpu.name} is used now.`,
            `${payload.name} is ${payload.foreign.language} and runs there as it stands.`,
            "info",
            6000,
        );
    }

    async #compile(side, turn = side.turn) {
        if (!this.gpu) return;
        const { gpu } = this,
            active = await this.#active(side),
            program = await this.renderer.hold(gpu.compile(active.payload));
        if (side.turn !== turn || gpu !== this.gpu) return;
        side.active = { ...active, values: side.values };
        const old = side.program;
        side.program = program;
        side.samples = 0;
        side.epoch = -1;
        if (old?.model && side.film) this.replaced.push(() => gpu.forget(old));
    }

    /** The model that is drawn: without the layers that are hidden. */
    async #active(side) {
        if (!side.hidden.size) return { payload: side.payload, path: (p) => p };
        const { text, path } = (await this.#shared()).visible(side),
            payload = await this.source.model(text);
        return { payload: { ...payload, hooks: [] }, path };
    }

    /** Which choices are refused takes the exporter a moment: it comes after the picture. */
    async #askOptions(side) {
        const { payload } = side;
        if (!this.source.live || !payload.options.length) return;
        try {
            const { options, unused } = await this.source.options(side.text());
            if (side.payload === payload) {
                payload.options = options.map((o) => ({ ...o, value: side.options.get(o.path) }));
                for (const p of payload.parameters) p.unused_because ??= unused[p.path];
                this.update();
            }
        } catch {
            /* the picture has its own message */
        }
    }

    async #fileChanged({ file, ended }) {
        if (ended !== undefined) {
            // Once, whichever of the tabs noticed it
            if (this.ended) this.dismiss(this.ended);
            this.ended = ended && this.say("gonio view has stopped.", STOPPED, "warn");
            return;
        }
        this.late.clear();
        for (const side of this.sides) {
            if (side.payload?.name !== file) continue;
            if (await this.#take(side, side.text())) this.say(`${file} was read again.`, "", "info", 3000);
        }
    }

    // --- changes -------------------------------------------------------------------------------------

    /** The side whose values the panel shows. */
    edited() {
        return this.state.edit === "B" && this.two ? this.sides[1] : this.sides[0];
    }

    editing() {
        return this.state.edit === "AB" && this.two ? this.sides : [this.edited()];
    }

    layerIndex() {
        return Math.min(this.state.layer, layersOf(this.edited()).length - 1);
    }

    differs(path) {
        if (!this.two || !this.sides[1].payload || !this.sides[0].payload) return false;
        const [a, b] = this.sides.map((s) => s.options.get(path));
        return a !== undefined && b !== undefined && a !== b;
    }

    set(changes, name = "") {
        Object.assign(this.state, changes);
        const shown = ["furnace", "env", "turn", "shape", "az", "el", "dist"].some((k) => k in changes);
        if (shown) this.moved();
        else this.renderer?.refresh(this.state);
        if ("cmp" in changes) {
            this.moved(false);
            this.#flicker();
        }
        if ("theta" in changes || "view" in changes || "dock" in changes) this.#measureSoon();
        if ("dock" in changes) this.#codeSoon();
        this.#remember(name || Object.keys(changes).join());
        this.update();
    }

    /** A and B in turn, twice a second, while that is chosen. */
    #flicker() {
        clearInterval(this.flickering);
        if (this.state.cmp !== "flick" || !this.renderer) return;
        this.flickering = setInterval(() => {
            this.renderer.flicker = !this.renderer.flicker;
            this.renderer.show();
        }, 500);
    }

    setParameter(path, value) {
        this.setParameters({ [path]: value });
    }

    /** Change numbers; what has one name within a second is one step of undo, and what has none its own. */
    setParameters(values, name = Object.keys(values).join()) {
        this.fieldError = null;
        for (const side of this.editing()) {
            for (const [path, value] of Object.entries(values))
                if (side.values.has(path)) side.values.set(path, value.slice());
            this.state[side.letter.toLowerCase()] = side.text();
        }
        this.moved();
        this.#remember(name);
        this.options.changed?.(this);
        this.update();
    }

    resetParameter(path) {
        const p = this.edited().parameter(path);
        this.setParameters({ [path]: this.edited().startOf(path, p.default) }, "");
    }

    async setOptions(changes) {
        this.refused = null;
        for (const side of this.editing()) {
            const known = Object.fromEntries(
                Object.entries(changes).filter(([path]) => side.options.has(path) || side.models.has(path)),
            );
            if (!Object.keys(known).length || (await this.change(side, side.text(known)))) continue;
            await this.#explain(side, known);
        }
    }

    /** A choice that was refused gets the model's sentence in its row, with what would allow it. */
    async #explain(side, changes) {
        await this.#askOptions(side);
        for (const [path, value] of Object.entries(changes)) {
            const choice = side.payload?.options
                .find((o) => o.path === path)
                ?.values.find((v) => v.value === value && !v.allowed);
            if (choice) {
                side.error = "";
                this.refuse(path, choice);
                return;
            }
        }
    }

    async change(side, text) {
        const taken = await this.#take(side, text);
        if (taken) {
            this.#remember();
            this.options.changed?.(this);
        }
        this.update();
        return taken;
    }

    chooseModel(layer, name) {
        for (const side of this.editing()) {
            side.hidden.clear();
            if (layer.prefix) this.change(side, side.text({ [layer.prefix.slice(0, -1)]: name }));
            else this.change(side, name);
        }
    }

    async hide(prefix) {
        for (const side of this.editing()) {
            if (!side.hidden.delete(prefix)) side.hidden.add(prefix);
            try {
                await this.#compile(side);
            } catch (error) {
                this.say("This layer cannot be hidden.", error.message, "warn");
                side.hidden.clear();
            }
        }
        this.moved(false);
        this.update();
    }

    /** Compare with a copy of A, or stop comparing. */
    async compare(on = !this.two, text = "") {
        if (on && !this.two) {
            this.state.b = text || this.sides[0].text();
            this.state.cmp = "wipe";
            this.state.edit = "B";
        } else if (!on) Object.assign(this.state, { b: "", cmp: "A", edit: "A" });
        await this.#load();
        this.#remember();
        this.moved(false);
        this.options.changed?.(this);
        this.update();
    }

    swap() {
        if (!this.two) return;
        this.sides.reverse();
        this.sides.forEach((side, i) => {
            side.letter = "AB"[i];
            this.state["ab"[i]] = side.text();
        });
        this.renderer?.refresh(this.state);
        this.#measureSoon();
        this.#remember();
        this.update();
    }

    toggleColour(path) {
        if (!this.openColours.delete(path)) this.openColours.add(path);
        this.update();
    }
    refuse(path, choice) {
        this.refused = path && { path, ...choice };
        this.update();
    }
    fail(error) {
        this.fieldError = error;
        this.update();
    }

    say(title, text = "", kind = "info", life = 0) {
        const note = { title, text, kind };
        this.notes = [...this.notes.slice(-2), note];
        if (life) setTimeout(() => this.dismiss(note), life);
        this.update();
        return note;
    }
    dismiss(note) {
        this.notes = this.notes.filter((n) => n !== note);
        this.update();
    }

    /** The picture has to begin again. */
    moved(moving = true) {
        this.looks++;
        this.renderer?.restart({ ...this.state }, { moving });
        this.statistics = null;
        this.#measureSoon();
        this.#codeSoon();
    }

    // --- history and links ---------------------------------------------------------------------------

    #remembered() {
        return { ...this.state };
    }
    #remember(name) {
        this.history?.add(this.#remembered(), name);
        this.options.linked?.(fragment(this.state));
    }

    async step(by) {
        const state = this.history.step(by);
        if (!state) return;
        Object.assign(this.state, state);
        for (const side of this.sides) side.hidden.clear();
        await this.#load();
        this.moved(false);
        this.options.linked?.(fragment(this.state));
        this.options.changed?.(this);
        this.update();
    }

    link() {
        return `${this.options.address ?? location.href.split("#")[0]}#${fragment(this.state)}`;
    }

    /** Set a side's text from outside, such as a notebook's cell. */
    show(text, letter = "a") {
        const side = this.sides[letter === "a" ? 0 : 1];
        return side && side.text() !== text ? this.change(side, text) : null;
    }

    /** Compare with a text from outside; an empty one ends the comparison. */
    async follow(text) {
        if (!text === !this.two) return text ? this.show(text, "b") : null;
        return this.compare(Boolean(text), text);
    }

    async copy(text, what) {
        try {
            await navigator.clipboard.writeText(text);
            this.say(`${what} is copied.`, "", "info", 2500);
        } catch {
            this.say(`${what} could not be copied; here it is.`, text);
        }
    }

    async savePicture() {
        return (await this.part("more")).savePicture(this);
    }

    async take(file) {
        try {
            const { openFile } = await this.part("files"),
                found = await openFile(file);
            if (found.picture) {
                this.renderer.sky = found.picture;
                this.set({ env: "own", furnace: false });
                this.moved(false);
            } else {
                this.renderer.own = found;
                this.renderer.scenes.clear();
                this.set({ shape: "own" });
                this.moved(false);
            }
            this.say(`${file.name} is shown.`, found.note ?? "", "info", 4000);
        } catch (error) {
            const still = /\.(obj|glb|gltf)$/i.test(file.name)
                ? `The shape is still “${this.state.shape}”.`
                : `The light is still “${this.state.env}”.`;
            this.say(`${file.name} was not taken.`, `${error.message} ${still}`, "warn");
        }
    }

    // --- numbers -------------------------------------------------------------------------------------

    #passed(side) {
        const n = side.samples;
        if (n >= 4 && (n & (n - 1)) === 0 && side.scale === 1) this.#statisticsSoon();
        this.#progressSoon();
    }
    #progressSoon() {
        this.progress ??= setTimeout(() => {
            this.progress = null;
            this.update();
        }, 150);
    }

    async #statisticsSoon() {
        const { epoch } = this.renderer;
        try {
            const found = await this.renderer.statistics();
            if (found && this.renderer.epoch === epoch) {
                this.statistics = found;
                this.update();
            }
        } catch {
            /* the device is gone; its message comes */
        }
    }

    #measureSoon() {
        clearTimeout(this.measuring);
        this.measuring = setTimeout(() => this.#measure(), 60);
    }

    async #measure() {
        // The picture comes first
        if (!this.gpu || this.busyMeasuring || !(this.renderer.begun || this.renderer.paused)) {
            if (this.gpu) this.#measureSoon();
            return;
        }
        this.busyMeasuring = true;
        try {
            for (const side of this.sides) {
                if (!side.program) continue;
                const { letter } = side; // sides may be swapped meanwhile
                const key = `${side.active.payload.text}|${JSON.stringify([...side.active.values])}|${this.state.theta}`;
                const needsLobe = ["lobe", "weights"].includes(this.state.view);
                if (this.data[letter]?.key !== key)
                    this.data[letter] = {
                        ...(await measure(this.gpu, side, this.state.theta)),
                        letter,
                        key,
                    };
                const { lobe } = needsLobe ? await this.#shared() : {};
                if (needsLobe && this.lobes[letter]?.key !== key)
                    this.lobes[letter] = {
                        ...(await lobe(this.gpu, side, this.state.theta)),
                        letter,
                        key,
                    };
            }
            await this.#probe();
        } catch (error) {
            if (this.gpu) this.plotError = error.message;
        }
        this.busyMeasuring = false;
        // What measures holds on to its shaders while others take their place
        for (const forget of this.replaced.splice(0)) forget();
        this.update();
    }

    plots() {
        return this.sides.map((s) => this.data[s.letter]).filter(Boolean);
    }
    bodies() {
        return this.sides.map((s) => this.lobes[s.letter]).filter(Boolean);
    }

    /** Look at a place of the picture, x and y from 0 to 1. */
    probe(x, y) {
        this.looks++;
        this.probed = null;
        const changes = { probe: `${x.toFixed(4)},${y.toFixed(4)}` },
            found = this.surface(x, y);
        // The plots show what this point shows
        if (found) changes.theta = Math.min(89, Math.round((Math.acos(Math.min(1, found.wo[2])) * 180) / Math.PI));
        this.set(changes, "probe");
        this.#measureSoon();
    }

    async #probe() {
        const [x, y] = this.state.probe.split(",").map(Number);
        if (!this.state.probe || !Number.isFinite(x) || !Number.isFinite(y)) {
            this.probed = null;
            return;
        }
        const { looks } = this,
            found = this.surface(x, y),
            seen = { x, y, found, values: [] };
        for (const side of found ? this.sides.filter((s) => s.program) : []) {
            const { wi, wo, growth, uv, t } = found,
                plain = growth === undefined || !side.payload.hooks.length;
            const { program } = side,
                params = side.packed(plain ? {} : side.overrides(uv, growth, t, side.mapData ?? side.maps()));
            const rows = await this.gpu.rows(program, params, packRows([[wi, wo]]));
            // Sums of the shader are coarse: gonio's own number stands for them where it can be asked
            const exact = plain && !side.hidden.size && side.payload.sums && this.source.live,
                albedo = exact
                    ? await this.source.albedo(side.text(), wo)
                    : await this.gpu.albedo(program, params, new Float32Array([...wo, 0]));
            const { letter } = side;
            seen.values.push({ letter, f: [...rows.slice(0, 3)], pdf: rows[3], albedo: [...albedo.slice(0, 3)] });
        }
        // Something has changed meanwhile: the next look has it
        if (looks === this.looks) this.probed = seen;
    }

    /** The surface in a place of the picture: directions in its frame, or null for the background. */
    surface(x, y) {
        return surface(this.renderer, this.state, x, y);
    }

    #codeSoon() {
        if (this.state.dock !== "code") return;
        clearTimeout(this.coding);
        this.coding = setTimeout(() => this.#code(), 120);
    }

    async #code() {
        const side = this.edited(),
            { language } = this;
        if (!side.payload) return;
        const text = side.text();
        let found;
        try {
            found = { text: await this.source.code(text, language), of: text };
        } catch (error) {
            found = { error: error.message };
        }
        // Another language or model has been asked for meanwhile
        if (language !== this.language || side !== this.edited() || text !== side.text()) return;
        this.code = found;
        this.update();
    }

    setLanguage(language) {
        this.language = language;
        this.code = {};
        this.#codeSoon();
        this.update();
    }

    // --- drawing -------------------------------------------------------------------------------------

    update() {
        if (this.drawing || this.closed) return;
        this.drawing = true;
        requestAnimationFrame(() => {
            this.drawing = false;
            if (!this.closed) this.draw();
        });
    }

    draw() {
        if (!this.start) return;
        render(pageOf(this), this.root);
        // A choice is set when its values are there, which come after it
        for (const s of this.root.querySelectorAll("[data-value]")) s.value = s.dataset.value;
        const stage = this.root.querySelector(".canvas");
        if (this.gpu && stage && this.gpu.canvas.parentNode !== stage) {
            stage.replaceChildren(this.gpu.canvas);
            this.#watchSize(stage);
        }
        let again = false;
        for (const svg of this.root.querySelectorAll("[data-chart]")) {
            const width = svg.clientWidth || svg.getBoundingClientRect().width,
                height = svg.clientHeight || svg.getBoundingClientRect().height,
                known = this.sizes[svg.dataset.chart];
            if (width && (known?.width !== width || known?.height !== height)) {
                this.sizes[svg.dataset.chart] = { width, height };
                again = true;
            }
        }
        const ratio = Math.min(devicePixelRatio, 2);
        for (const canvas of this.root.querySelectorAll("canvas[data-map]")) {
            const data = this.data[canvas.dataset.map];
            if (data && canvas.drawn !== data.key) {
                drawMap(canvas, data.map);
                canvas.drawn = data.key;
            }
        }
        const lobeCanvas = this.root.querySelector("canvas.lobe"),
            weights = this.root.querySelector("canvas.weights");
        if (lobeCanvas && this.bodies().length) this.loaded.drawLobe(lobeCanvas, this.bodies(), this.lobe, ratio);
        if (weights && this.bodies().length) this.loaded.drawWeights(weights, this.bodies(), ratio);
        // Small pictures of the light can wait for the large one
        if (this.renderer?.begun)
            this.more((m) => {
                for (const canvas of this.root.querySelectorAll("canvas[data-env]:not(.drawn)")) {
                    m.drawThumb(canvas, this.start.environments[canvas.dataset.env]);
                    canvas.className = "drawn";
                }
            });
        // A card that opens takes the keyboard, and gives it back
        const card = this.root.querySelector(".card");
        if (card !== this.card) {
            if (card) this.before ??= this.root.activeElement;
            (card?.querySelector("input, button") ?? this.before)?.focus();
            if (!card) this.before = null;
            this.card = card;
        }
        if (again) this.update();
    }

    #watchSize(stage) {
        this.observer?.disconnect();
        this.observer = new ResizeObserver(([entry]) => {
            const exact = entry.devicePixelContentBoxSize?.[0],
                ratio = Math.min(devicePixelRatio, 2) / devicePixelRatio;
            const w = Math.max(
                    16,
                    Math.round((exact ? exact.inlineSize : entry.contentRect.width * devicePixelRatio) * ratio),
                ),
                h = Math.max(
                    16,
                    Math.round((exact ? exact.blockSize : entry.contentRect.height * devicePixelRatio) * ratio),
                );
            const { canvas } = this.gpu ?? {};
            if (!canvas || (canvas.width === w && canvas.height === h)) return;
            canvas.width = w;
            canvas.height = h;
            this.renderer.size = [w, h];
            this.renderer.show();
            this.moved(false);
        });
        try {
            this.observer.observe(stage, { box: "device-pixel-content-box" });
        } catch {
            this.observer.observe(stage);
        }
        this.unlisten ??= keyboard(this);
    }

    close() {
        this.closed = true;
        this.observer?.disconnect();
        this.unlisten?.();
        clearTimeout(this.measuring);
        clearInterval(this.flickering);
        this.renderer?.close();
    }
}

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
