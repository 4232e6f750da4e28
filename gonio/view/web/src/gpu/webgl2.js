// The page's graphics by WebGL2, where WebGPU is missing. `gpu/webgpu.js` has the same methods.
// It is a part of its own, which a page with WebGPU never loads.
import { albedoEssl, cornerEssl, displayEssl, rowsEssl, share, traceEssl } from "../passes/essl.js";

const WIDE = 4096; // of tables

/** WebGL2 with the texts of the passes, which the page has already, and what makes rows of tables. */
export function create({ tableRows, ...texts }) {
    share(texts);
    return Object.assign(new WebGL2(), { tableRows });
}

class WebGL2 {
    name = "WebGL2";
    language = "essl";

    constructor() {
        this.canvas = document.createElement("canvas");
        const gl = (this.gl = this.canvas.getContext("webgl2", {
            antialias: false,
            alpha: false,
            preserveDrawingBuffer: true,
            powerPreference: "high-performance",
        }));
        if (!gl) throw new Error("This browser has neither WebGPU nor WebGL2.");
        if (!gl.getExtension("EXT_color_buffer_float"))
            throw new Error("This GPU cannot draw into float textures (EXT_color_buffer_float).");
        this.parallel = gl.getExtension("KHR_parallel_shader_compile");
        this.adapter = gl.getParameter(gl.RENDERER);
        this.lost = new Promise((resolve) =>
            this.canvas.addEventListener("webglcontextlost", (e) => {
                e.preventDefault();
                resolve({ message: "The WebGL context was lost.", reason: this.closed ? "destroyed" : "unknown" });
            }),
        );
        gl.bindVertexArray(gl.createVertexArray());
        this.errors = [];
        this.frame = gl.createFramebuffer();
        this.corner = this.#shader(gl.VERTEX_SHADER, cornerEssl);
        this.display = this.#link(this.#shader(gl.FRAGMENT_SHADER, displayEssl()));
        this.#check(this.display);
        const empty = new Float32Array(8);
        this.setScene({ nodes: empty, places: empty, looks: empty });
        this.setSky({ width: 1, height: 1, pixels: new Float32Array(4), alias: new Float32Array(4) });
    }

    close() {
        this.closed = true;
        this.gl.getExtension("WEBGL_lose_context")?.loseContext();
    }

    #shader(kind, source) {
        const shader = this.gl.createShader(kind);
        this.gl.shaderSource(shader, source);
        this.gl.compileShader(shader);
        return shader;
    }

    #link(fragment) {
        const gl = this.gl,
            program = gl.createProgram();
        gl.attachShader(program, this.corner);
        gl.attachShader(program, fragment);
        gl.linkProgram(program);
        return { program, fragment, places: new Map() };
    }

    #check(linked) {
        const gl = this.gl;
        if (gl.getProgramParameter(linked.program, gl.LINK_STATUS)) return linked;
        throw new Error(
            (
                gl.getShaderInfoLog(linked.fragment) ||
                gl.getProgramInfoLog(linked.program) ||
                "The shader does not compile."
            )
                .trim()
                .split("\n")[0],
        );
    }

    async #ready(linked) {
        const gl = this.gl;
        if (this.parallel) {
            while (!gl.isContextLost() && !gl.getProgramParameter(linked.program, this.parallel.COMPLETION_STATUS_KHR))
                await new Promise((r) => setTimeout(r, 8));
        }
        return this.#check(linked);
    }

    #place(linked, name) {
        if (!linked.places.has(name)) linked.places.set(name, this.gl.getUniformLocation(linked.program, name));
        return linked.places.get(name);
    }

    #texture(width, height, data) {
        const gl = this.gl,
            texture = gl.createTexture();
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, width, height);
        if (data) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, data);
        this.#nearest(gl.TEXTURE_2D);
        return texture;
    }

    #nearest(target) {
        const gl = this.gl;
        gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
        gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    }

    #table(data) {
        const count = Math.max(1, data.length / 4),
            width = WIDE,
            height = Math.ceil(count / WIDE);
        const padded = new Float32Array(4 * width * height);
        padded.set(data);
        return this.#texture(width, height, padded);
    }

    setScene(tables) {
        for (const name of ["nodes", "places", "looks"]) {
            this.gl.deleteTexture(this[name]);
            this[name] = this.#table(tables[name]);
        }
    }

    setSky({ width, height, pixels, alias }) {
        this.gl.deleteTexture(this.sky);
        this.gl.deleteTexture(this.alias_table);
        this.sky = this.#texture(width, height, pixels);
        this.alias_table = this.#table(alias);
    }

    makeSide() {
        return {
            films: [],
            front: 0,
            width: 0,
            height: 0,
            maps: this.#maps({ size: 1, layers: 1, pixels: new Float32Array(4) }),
        };
    }

    #maps({ size, layers, pixels }) {
        const gl = this.gl,
            texture = gl.createTexture();
        gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
        gl.texImage3D(gl.TEXTURE_2D_ARRAY, 0, gl.RGBA32F, size, size, layers, 0, gl.RGBA, gl.FLOAT, pixels);
        this.#nearest(gl.TEXTURE_2D_ARRAY);
        return texture;
    }

    setMaps(side, maps) {
        this.gl.deleteTexture(side.maps);
        side.maps = this.#maps(maps);
    }

    async compile(model, { trace: wanted = true } = {}) {
        const make = (source) => this.#link(this.#shader(this.gl.FRAGMENT_SHADER, source));
        const trace = wanted ? await this.#ready(make(traceEssl(model))) : null,
            program = { model, trace, tables: {} };
        // The exporter's texture of its own width
        if (model.tables) {
            const { name, width, entries } = model.tables;
            program.tables[name] = this.#texture(width, entries / width, this.tableRows(model.tables));
        }
        if (!wanted) await this.#numbers(program);
        return program;
    }

    /** The shader of numbers, made when it is first asked for: the picture comes first. */
    async #numbers(program) {
        program.rows ??= await (program.rowsComing ??= this.#ready(
            this.#link(this.#shader(this.gl.FRAGMENT_SHADER, rowsEssl(program.model))),
        ));
    }

    forget(program) {
        for (const part of [program.trace, program.rows, program.albedo]) if (part) this.gl.deleteProgram(part.program);
        for (const texture of Object.values(program.tables)) this.gl.deleteTexture(texture);
    }

    resize(side, width, height) {
        side.wanted = [width, height];
    }

    #bind(linked, textures) {
        const gl = this.gl;
        gl.useProgram(linked.program);
        Object.entries(textures).forEach(([name, texture], unit) => {
            gl.activeTexture(gl.TEXTURE0 + unit);
            gl.bindTexture(name === "maps" ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D, texture);
            gl.uniform1i(this.#place(linked, name), unit);
        });
    }

    async trace(side, program, params, U, y0, y1) {
        const gl = this.gl,
            [width, height] = side.wanted,
            back = 1 - side.front;
        if (side.films[back]?.width !== width || side.films[back]?.height !== height) {
            gl.deleteTexture(side.films[back]?.texture ?? null);
            side.films[back] = { width, height, texture: this.#texture(width, height, null) };
        }
        const before =
            U[2] > 0 ? side.films[side.front].texture : (this.empty ??= this.#texture(1, 1, new Float32Array(4)));
        const { nodes, places, looks, alias_table, sky } = this;
        this.#bind(program.trace, {
            nodes,
            places,
            looks,
            alias_table,
            sky,
            maps: side.maps,
            before,
            ...program.tables,
        });
        gl.uniform4fv(this.#place(program.trace, "U"), U);
        gl.uniform4fv(this.#place(program.trace, "P"), params);
        this.#into([side.films[back].texture], width, height);
        gl.enable(gl.SCISSOR_TEST);
        gl.scissor(0, y0, width, y1 - y0);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        gl.disable(gl.SCISSOR_TEST);
        await this.#done();
    }

    #into(textures, width, height) {
        const gl = this.gl;
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
        for (let k = 0; k < 2; k++)
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + k, gl.TEXTURE_2D, textures[k] ?? null, 0);
        gl.drawBuffers(textures.map((_, k) => gl.COLOR_ATTACHMENT0 + k));
        gl.viewport(0, 0, width, height);
    }

    async #done() {
        const gl = this.gl,
            fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
        gl.flush();
        while (!gl.isContextLost()) {
            const state = gl.clientWaitSync(fence, 0, 0);
            if (state === gl.ALREADY_SIGNALED || state === gl.CONDITION_SATISFIED) break;
            await new Promise((resolve) => setTimeout(resolve, 1));
        }
        gl.deleteSync(fence);
    }

    swap(side) {
        side.front = 1 - side.front;
        Object.assign(side, { width: side.films[side.front].width, height: side.films[side.front].height });
    }

    show(a, b, D) {
        const gl = this.gl,
            film = (side) => side?.films[side.front]?.texture;
        if (!film(a)) return;
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.viewport(0, 0, this.canvas.width, this.canvas.height);
        this.#bind(this.display, { film_a: film(a), film_b: film(b) ?? film(a) });
        gl.uniform4fv(this.#place(this.display, "D"), D);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    async readFilm(side) {
        const film = side.films[side.front];
        this.#into([film.texture], film.width, film.height);
        return this.#pixels(0, film.width, film.height);
    }

    #pixels(index, width, height) {
        const gl = this.gl,
            values = new Float32Array(4 * width * height);
        gl.readBuffer(gl.COLOR_ATTACHMENT0 + index);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, values);
        return values;
    }

    async rows(program, params, given) {
        await this.#numbers(program);
        const gl = this.gl,
            n = given.length / 12,
            height = Math.ceil(n / 256);
        const padded = new Float32Array(4 * 768 * height);
        padded.set(given);
        const source = this.#texture(768, height, padded),
            made = this.#texture(256, height),
            drawn = this.#texture(256, height);
        this.#bind(program.rows, { given: source, ...program.tables });
        gl.uniform4fv(this.#place(program.rows, "P"), params);
        this.#into([made, drawn], 256, height);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        await this.#done();
        this.#into([made, drawn], 256, height);
        const a = this.#pixels(0, 256, height),
            b = this.#pixels(1, 256, height),
            values = new Float32Array(8 * n);
        for (let i = 0; i < n; i++) {
            values.set(a.subarray(4 * i, 4 * i + 4), 8 * i);
            values.set(b.subarray(4 * i, 4 * i + 4), 8 * i + 4);
        }
        for (const texture of [source, made, drawn]) gl.deleteTexture(texture);
        return values;
    }

    async albedo(program, params, given) {
        program.albedo ??= await (program.albedoComing ??= this.#ready(
            this.#link(this.#shader(this.gl.FRAGMENT_SHADER, albedoEssl(program.model))),
        ));
        const gl = this.gl,
            n = given.length / 4;
        const source = this.#texture(n, 1, given),
            made = this.#texture(n, 1);
        this.#bind(program.albedo, { given: source, ...program.tables });
        gl.uniform4fv(this.#place(program.albedo, "P"), params);
        this.#into([made], n, 1);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        await this.#done();
        this.#into([made], n, 1);
        const values = this.#pixels(0, n, 1);
        gl.deleteTexture(source);
        gl.deleteTexture(made);
        return values;
    }
}
