// The progressive picture: films that grow pass by pass, at half resolution while something moves.

import { WebGPU } from "./gpu/webgpu.js";
import { screen } from "./passes/display.js";
import { display, members, modelAt, rows, sources, trace } from "./passes/texts.js";
import { frame, turned } from "./passes/trace.js";
import { tables } from "./scene/bvh.js";
import { camera } from "./scene/camera.js";
import { aliasTable, brightest, groundColour } from "./scene/light.js";
import { fromHalf, tableRows, unpacked } from "./source.js";

const STILL_MS = 220; // without a change, after which the picture is drawn in full
const TILE_MS = 12; // of GPU time between two looks at the mouse
const MOVING_MS = 90; // that a picture may take while something moves; it gets as coarse as that needs
const COARSEST = 8;
const TARGET_Y = 1.14; // what the camera of gonio render looks at

/** WebGPU, or WebGL2 and the reason why; "webgl2" asks for it, and WebGPU is not tried then. */
export async function graphics(source, wanted = "") {
    let reason = "";
    if (wanted !== "webgl2") {
        try {
            return { gpu: await WebGPU.create(), reason };
        } catch (error) {
            reason = error.message;
        }
    }
    const { create } = await source.part("webgl2");
    return { gpu: create({ display, members, modelAt, rows, sources, tableRows, trace }), reason };
}

/** A mesh of the payload as arrays. */
function mesh(packed, kind) {
    const positions = unpacked(packed.positions, Uint16Array),
        normals = unpacked(packed.normals, Int16Array),
        uvs = unpacked(packed.uvs, Int16Array);
    return {
        kind,
        faces: unpacked(packed.faces, Uint16Array),
        positions: Float32Array.from(
            positions,
            (x, i) => packed.low[i % 3] + (x / 65535) * (packed.high[i % 3] - packed.low[i % 3]),
        ),
        normals: Float32Array.from(normals, (x) => x / 32767),
        uvs: Float32Array.from(uvs, (x) => (x / 32767) * packed.uv_reach),
        growth: packed.growth ? Float32Array.from(unpacked(packed.growth, Uint8Array), (x) => x / 255) : null,
    };
}

export class Renderer {
    /** `changed` is called after every pass. */
    constructor(gpu, start, changed) {
        this.gpu = gpu;
        this.start = start;
        this.changed = changed;
        this.sides = [];
        this.limit = 256; // samples per pixel at rest
        this.size = [300, 200];
        this.ms = 0;
        this.epoch = 0;
        this.movedAt = -Infinity;
        this.held = 0; // how many wait for their shaders
        this.own = null; // a dropped mesh
        this.sky = null; // a dropped picture of light
        this.scenes = new Map();
        this.rate = 400; // pixels per millisecond, as measured
        this.settings = null;
    }

    /** Everything again on other graphics: after a loss. */
    replace(gpu) {
        this.gpu = gpu;
        this.sceneName = this.skyName = "";
        for (const side of this.sides) {
            side.film = null;
            side.program = null;
            side.samples = 0;
        }
    }

    light(settings) {
        if (settings.env === "own" && this.sky) {
            const { fade } = this.start,
                azimuth = settings.turn - settings.az;
            if (this.sky.groundFor !== azimuth)
                Object.assign(this.sky, { groundFor: azimuth, ground: groundColour(this.sky, azimuth, fade) });
            return {
                lamps: [],
                surround: [0, 0, 0],
                picture: this.sky,
                ground: null,
                fade: fade.radii,
                groundColour: this.sky.ground,
                turn: settings.turn,
            };
        }
        const found = this.start.environments[settings.env] ?? this.start.environments.studio;
        return { ...found, fade: found.groundColour ? this.start.fade.radii : [0, 0], turn: settings.turn };
    }

    #scene(settings, light) {
        const furnace = settings.furnace,
            shape = settings.shape === "own" && !this.own ? "ball" : settings.shape;
        const name = `${shape}/${furnace ? "none" : light.ground}/${this.own?.id}`;
        if (!this.scenes.has(name)) {
            const { shapes } = this.start,
                parts = [];
            let core = null;
            if (shape === "ball") {
                parts.push(mesh(shapes.shell, 0));
                core = shapes.core;
                if (!furnace) parts.push(mesh(shapes.pedestal, 2));
            } else if (shape === "sphere") core = { centre: [0, furnace ? 1.2 : 1, 0], radius: 1 };
            else parts.push(this.own.mesh);
            if (!furnace && light.ground) parts.push(mesh(shapes.grounds[light.ground], 1));
            if (this.scenes.size > 6) this.scenes.clear();
            this.scenes.set(name, { ...tables(parts), core, name });
        }
        const scene = this.scenes.get(name);
        if (this.sceneName !== name) {
            this.gpu.setScene(scene);
            this.sceneName = name;
        }
        return scene;
    }

    /** Have the scene and the light ready before there is a model to draw. */
    prepare(settings) {
        const light = this.light(settings);
        this.#scene(settings, light);
        this.#picture(light);
    }

    #picture(light) {
        if (!light.picture) return null;
        if (!light.picture.pixels) {
            const { width, height, half } = light.picture,
                rgb = fromHalf(unpacked(half, Uint16Array)),
                pixels = new Float32Array(4 * width * height);
            for (let i = 0; i < width * height; i++) pixels.set(rgb.subarray(3 * i, 3 * i + 3), 4 * i);
            light.picture.pixels = pixels;
        }
        light.picture.alias ??= aliasTable(light.picture.pixels, light.picture.width, light.picture.height);
        light.picture.id ??= crypto.randomUUID?.() ?? String(Math.random());
        if (this.skyName !== light.picture.id) {
            this.gpu.setSky(light.picture);
            this.skyName = light.picture.id;
        }
        return light.picture;
    }

    /** Where the strongest light comes from: for the probe. */
    lightDirection(settings, from) {
        const light = this.light(settings);
        if (light.lamps.length) {
            const power = (l) => (l.radiance[1] * l.area) / Math.hypot(...l.centre) ** 2;
            const lamp = light.lamps.reduce((a, b) => (power(b) > power(a) ? b : a));
            return turned(lamp.centre, settings.turn).map((x, i) => x - from[i]);
        }
        if (light.picture) {
            this.#picture(light);
            return turned(brightest(light.picture.pixels, light.picture.width, light.picture.height), settings.turn);
        }
        return [0.4, 1, 0.5];
    }

    target(settings) {
        if (settings.shape === "sphere") return [0, settings.furnace ? 1.2 : 1, 0];
        if (settings.shape === "own" && this.own) return [0, this.own.height / 2, 0];
        return [0, settings.furnace ? 1.2 : TARGET_Y, 0];
    }

    view(settings, width, height) {
        return camera(
            { azimuth: settings.az, elevation: settings.el, distance: settings.dist, target: this.target(settings) },
            width,
            height,
        );
    }

    /** Size of a side's picture on the canvas. */
    pictureSize(settings = this.settings) {
        const [w, h] = this.size;
        return settings.cmp === "side" && this.sides.length > 1 ? [Math.floor(w / 2), h] : [w, h];
    }

    /** Begin the picture again: something has changed. */
    restart(settings, { moving = true } = {}) {
        this.settings = settings;
        this.epoch++;
        this.movedAt = moving ? performance.now() : -Infinity;
        this.#wake?.();
    }

    /** A picture at rest waits for shaders that are compiled: one processor may have to do both. */
    async hold(work) {
        this.held++;
        try {
            return await work;
        } finally {
            this.held--;
            this.#wake?.();
        }
    }

    /** Only how films are shown has changed. */
    refresh(settings) {
        this.settings = settings;
        this.show();
        this.#wake?.();
    }
    #wake = null;

    visible() {
        const { cmp } = this.settings;
        const ready = this.sides.filter((side) => side.program);
        if (cmp === "A" || this.sides.length < 2) return ready.slice(0, 1);
        return cmp === "B" ? ready.slice(1) : ready;
    }

    show() {
        const [a, b] = this.sides,
            s = this.settings;
        if (!s) return;
        const there = (side) => Boolean(side?.film?.width);
        // What is still to come is not shown as the other side's picture; one that failed is
        const needed = !b || s.cmp === "A" ? [a] : s.cmp === "B" ? [b] : [a, b];
        if (needed.some((side) => !there(side) && !side.error)) return;
        const first = there(a) ? a : b;
        if (!there(first)) return;
        const second = there(b) ? b : first;
        const info = (side) => ({ width: side.film.width, height: side.film.height, samples: Math.max(1, side.shown) });
        const mode = this.sides.length < 2 ? "A" : s.cmp === "flick" ? (this.flicker ? "B" : "A") : s.cmp;
        this.gpu.show(
            first.film,
            second.film,
            screen({
                canvas: this.gpu.canvas,
                mode,
                wipe: s.wipe,
                exposure: s.ev,
                tone: s.tone,
                a: info(first),
                b: info(second),
            }),
        );
    }

    async run() {
        while (!this.closed) {
            const now = performance.now(),
                moving = Boolean(this.settings) && now - this.movedAt < STILL_MS;
            const sides = this.settings ? this.visible() : [];
            const scale = moving ? this.#coarse(sides.length) : 1;
            const todo = sides.filter(
                (side) => side.epoch !== this.epoch || side.scale !== scale || side.samples < (moving ? 4 : this.limit),
            );
            if (!todo.length || this.paused || (this.held && !moving)) {
                const wait = moving ? STILL_MS - (now - this.movedAt) + 1 : 0;
                await new Promise((resolve) => {
                    this.#wake = resolve;
                    if (wait > 0 || this.paused) setTimeout(resolve, this.paused ? 200 : wait);
                });
                continue;
            }
            // Both sides keep step and are shown together, so that a comparison never has different noise
            const least = Math.min(...todo.map((s) => (s.epoch === this.epoch && s.scale === scale ? s.samples : 0)));
            const behind = todo.filter(
                    (side) => side.epoch !== this.epoch || side.scale !== scale || side.samples === least,
                ),
                done = [];
            try {
                for (const side of behind) {
                    const finish = await this.#pass(side, scale, moving);
                    if (!finish) break;
                    done.push(finish);
                }
                if (done.length === behind.length) this.#finish(done);
            } catch (error) {
                if (!this.closed) this.failed?.(error);
                await new Promise((resolve) => setTimeout(resolve, 500));
            }
        }
    }

    #coarse(count) {
        const [w, h] = this.pictureSize();
        const held = this.coarse ?? 4,
            wanted = Math.sqrt((w * h * count) / (this.rate * MOVING_MS));
        // One step at a time, and only when it is clear, so that the grain does not flicker
        this.coarse = Math.min(
            COARSEST,
            Math.max(2, wanted > held * 1.3 || wanted < held * 0.6 ? Math.ceil(wanted) : held),
        );
        return this.coarse;
    }

    async #pass(side, scale, moving) {
        const { epoch, settings } = this,
            { program } = side;
        const light = this.light(settings),
            picture = this.#picture(light),
            scene = this.#scene(settings, light);
        const [w, h] = this.pictureSize(settings).map((x) => Math.max(1, Math.floor(x / scale)));
        const fresh =
            side.epoch !== epoch ||
            side.scale !== scale ||
            side.film?.wanted?.[0] !== w ||
            side.film?.wanted?.[1] !== h;
        side.film ??= this.gpu.makeSide();
        if (side.mapsOf !== side.payload || side.mapsOn !== side.film) {
            side.mapData = side.maps();
            this.gpu.setMaps(side.film, side.mapData);
            side.mapsOf = side.payload;
            side.mapsOn = side.film;
        }
        if (fresh) this.gpu.resize(side.film, w, h);
        const sample = fresh ? 0 : side.samples;
        const U = frame({
            width: w,
            height: h,
            sample,
            view: this.view(settings, w, h),
            light: { ...light, picture },
            furnace: settings.furnace,
            scene,
            estimator: this.estimator ?? "both",
        });
        const params = side.packed();
        let spent = 0;
        for (let y = 0; y < h; ) {
            const lines = Math.max(8, Math.round((this.rate * TILE_MS) / w / 8) * 8),
                end = Math.min(h, y + lines);
            const t = performance.now();
            await this.gpu.trace(side.film, program, params, U, y, end);
            const dt = Math.max(performance.now() - t, 0.2);
            spent += dt;
            this.rate += 0.3 * (Math.min((w * (end - y)) / dt, 1e6) - this.rate);
            y = end;
            // A picture in full is given up at once; one of a movement is finished, so that it is seen
            if (this.closed || side.program !== program || (!moving && this.epoch !== epoch)) return null;
        }
        return { side, epoch, scale, samples: sample + 1, spent };
    }

    #finish(passes) {
        for (const { side, epoch, scale, samples } of passes) {
            this.gpu.swap(side.film);
            Object.assign(side, { epoch, scale, samples, shown: samples });
        }
        if (!this.begun) performance.mark("gonio-picture");
        this.begun = true;
        this.ms = passes.reduce((sum, { spent }) => sum + spent, 0);
        this.show();
        this.changed(passes[0].side);
    }

    /** Means, noise and difference of the films on screen, from their numbers. */
    async statistics() {
        const films = [];
        for (const side of this.visible()) {
            if (!side.film?.width || side.shown < 2) return null;
            films.push({ side, n: side.shown, width: side.film.width, data: await this.gpu.readFilm(side.film) });
        }
        const lum = (d, i) => 0.2126 * d[i] + 0.7152 * d[i + 1] + 0.0722 * d[i + 2];
        const found = films.map(({ side, n, data }) => {
            let mean = 0,
                error = 0;
            for (let i = 0; i < data.length; i += 4) {
                const m = lum(data, i) / n;
                mean += m;
                error += Math.sqrt(Math.max(0, data[i + 3] / n - m * m) / n);
            }
            const pixels = data.length / 4;
            return { letter: side.letter, mean: mean / pixels, noise: error / Math.max(mean, 1e-9) };
        });
        let rmse = null;
        if (films.length === 2 && films[0].data.length === films[1].data.length) {
            let sum = 0;
            const [a, b] = films;
            for (let i = 0; i < a.data.length; i += 4)
                for (let c = 0; c < 3; c++) sum += (a.data[i + c] / a.n - b.data[i + c] / b.n) ** 2;
            rmse = Math.sqrt(sum / (0.75 * a.data.length));
        }
        return { sides: found, rmse };
    }

    close() {
        this.closed = true;
        this.#wake?.();
        this.gpu.close();
    }
}
