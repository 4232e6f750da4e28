// The page's graphics by WebGPU. `gpu/webgl2.js` has the same methods.

import { albedoWgsl, displayWgsl, members, rowsWgsl, traceWgsl } from "../passes/texts.js";
import { ROWS } from "../passes/trace.js";
import { tableRows } from "../source.js";

const text = (messages) => messages.filter((m) => m.type === "error").map((m) => `${m.message} (line ${m.lineNum})`)[0];

// Widgets of one notebook share a device; the last one lets go of it.
let shared = null;

async function takeDevice() {
    shared ??= { users: 0, coming: request() };
    const taken = shared;
    taken.users++;
    try {
        return { ...(await taken.coming), taken };
    } catch (error) {
        shared = null;
        throw error;
    }
}

async function request() {
    const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
    if (!adapter) throw new Error("The browser has WebGPU but no adapter: the driver is blocked or there is no GPU.");
    const size = Math.min(adapter.limits.maxStorageBufferBindingSize, 1 << 30);
    const device = await adapter.requestDevice({
        requiredLimits: {
            maxStorageBufferBindingSize: size,
            maxBufferSize: Math.min(adapter.limits.maxBufferSize, 1 << 30),
        },
    });
    device.lost.then(() => {
        shared = null;
    });
    return { device, adapter };
}

export class WebGPU {
    name = "WebGPU";
    language = "wgsl";

    /** Why WebGPU cannot be used here, or a device. */
    static async create() {
        if (!globalThis.isSecureContext) {
            throw new Error(
                "This page came over http:// from another machine, and browsers give WebGPU to secure contexts only.",
            );
        }
        if (!navigator.gpu) throw new Error("This browser has no WebGPU.");
        const { device, adapter, taken } = await takeDevice();
        return Object.assign(new WebGPU(device, adapter), { taken });
    }

    constructor(device, adapter) {
        this.device = device;
        this.adapter = adapter.info?.description || adapter.info?.vendor || "";
        this.canvas = document.createElement("canvas");
        this.context = this.canvas.getContext("webgpu");
        this.format = navigator.gpu.getPreferredCanvasFormat();
        this.context.configure({ device, format: this.format, alphaMode: "opaque" });
        this.errors = [];
        device.addEventListener("uncapturederror", (event) => this.errors.push(event.error.message));
        this.lost = device.lost;
        const buffer = (type) => ({ buffer: { type } }),
            table = buffer("read-only-storage");
        const kinds = [
            buffer("uniform"),
            buffer("uniform"),
            table,
            table,
            table,
            table,
            { texture: { sampleType: "unfilterable-float" } },
            { texture: { sampleType: "unfilterable-float", viewDimension: "2d-array" } },
            table,
            buffer("storage"),
        ];
        // Said in full: a material without maps does not name them, and one with the default layout would lack them
        this.traceGroup = device.createBindGroupLayout({
            entries: kinds.map((kind, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, ...kind })),
        });
        const numbers = [buffer("uniform"), table, buffer("storage")];
        this.numberGroup = device.createBindGroupLayout({
            entries: numbers.map((kind, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, ...kind })),
        });
        // Where the exporter declares a model's tables
        this.tableGroup = device.createBindGroupLayout({
            entries: [{ binding: 8, visibility: GPUShaderStage.COMPUTE, ...table }],
        });
        this.settings = device.createBuffer({
            size: 16 * ROWS,
            usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST,
        });
        this.screen = device.createBuffer({ size: 64, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
        const empty = new Float32Array(8);
        this.scene = { nodes: this.#storage(empty), places: this.#storage(empty), looks: this.#storage(empty) };
        this.setSky({ width: 1, height: 1, pixels: new Float32Array(4), alias: new Float32Array(4) });
        const module = device.createShaderModule({ code: displayWgsl });
        this.display = device.createRenderPipeline({
            layout: "auto",
            vertex: { module, entryPoint: "corner" },
            fragment: { module, entryPoint: "pixel", targets: [{ format: this.format }] },
        });
    }

    close() {
        if (--this.taken.users === 0) {
            shared = null;
            this.device.destroy();
        }
    }

    #storage(data, usage = GPUBufferUsage.STORAGE) {
        const buffer = this.device.createBuffer({
            size: Math.max(data.byteLength, 16),
            usage: usage | GPUBufferUsage.COPY_DST,
        });
        this.device.queue.writeBuffer(buffer, 0, data);
        return buffer;
    }

    setScene({ nodes, places, looks }) {
        for (const buffer of Object.values(this.scene)) buffer.destroy();
        this.scene = { nodes: this.#storage(nodes), places: this.#storage(places), looks: this.#storage(looks) };
    }

    setSky({ width, height, pixels, alias }) {
        this.sky?.destroy();
        this.alias?.destroy();
        this.sky = this.device.createTexture({
            size: [width, height],
            format: "rgba32float",
            usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
        });
        this.device.queue.writeTexture({ texture: this.sky }, pixels, { bytesPerRow: 16 * width }, [width, height]);
        this.alias = this.#storage(alias);
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
        const texture = this.device.createTexture({
            size: [size, size, layers],
            format: "rgba32float",
            usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
        });
        this.device.queue.writeTexture({ texture }, pixels, { bytesPerRow: 16 * size, rowsPerImage: size }, [
            size,
            size,
            layers,
        ]);
        return texture;
    }

    setMaps(side, maps) {
        side.maps.destroy();
        side.maps = this.#maps(maps);
    }

    /** The shaders of a model; without `trace` those for numbers alone. */
    async compile(model, { trace: wanted = true } = {}) {
        const trace = wanted ? await this.#pipeline(traceWgsl(model), this.traceGroup, model) : null;
        const params = this.device.createBuffer({
            size: 16 * members(model),
            usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST,
        });
        const program = { model, trace, params };
        if (model.tables) {
            program.tables = this.#storage(tableRows(model.tables));
            program.tableGroup = this.device.createBindGroup({
                layout: this.tableGroup,
                entries: [{ binding: 8, resource: { buffer: program.tables } }],
            });
        }
        if (!wanted) await this.#numbers(program);
        return program;
    }

    /** The shader of numbers, made when it is first asked for: the picture comes first. */
    async #numbers(program) {
        program.rows ??= await (program.rowsComing ??= this.#numberPipeline(program, rowsWgsl));
    }

    #numberPipeline({ model }, text) {
        return this.#pipeline(text(model), this.numberGroup, model);
    }

    async #pipeline(code, group, model) {
        const module = this.device.createShaderModule({ code });
        const layout = this.device.createPipelineLayout({
            bindGroupLayouts: model.tables ? [group, this.tableGroup] : [group],
        });
        try {
            return await this.device.createComputePipelineAsync({ layout, compute: { module, entryPoint: "main" } });
        } catch (error) {
            throw new Error(text((await module.getCompilationInfo()).messages) ?? error.message);
        }
    }

    forget(program) {
        program.params.destroy();
        program.tables?.destroy();
    }

    #group(layout, resources) {
        const entries = resources.map((r, binding) => ({
            binding,
            resource: r instanceof GPUBuffer ? { buffer: r } : r,
        }));
        return this.device.createBindGroup({ layout, entries });
    }

    /** Films of another size; the one on screen stays until the first picture of the new size is complete. */
    resize(side, width, height) {
        side.wanted = [width, height];
    }

    /** One more sample for the lines y0 to y1 of a side's picture. */
    trace(side, program, params, U, y0, y1) {
        const [width, height] = side.wanted;
        const back = 1 - side.front;
        if (side.films[back]?.width !== width || side.films[back]?.height !== height) {
            side.films[back]?.buffer.destroy();
            side.films[back] = {
                width,
                height,
                buffer: this.device.createBuffer({
                    size: 16 * width * height,
                    usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC,
                }),
            };
        }
        const before = U[2] > 0 ? side.films[side.front].buffer : this.#nothing();
        U[36] = y0;
        U[37] = y1;
        this.device.queue.writeBuffer(this.settings, 0, U);
        this.device.queue.writeBuffer(program.params, 0, params);
        const { nodes, places, looks } = this.scene;
        const maps = side.maps.createView({ dimension: "2d-array" });
        const group = this.#group(this.traceGroup, [
            this.settings,
            program.params,
            nodes,
            places,
            looks,
            this.alias,
            this.sky.createView(),
            maps,
            before,
            side.films[back].buffer,
        ]);
        const encoder = this.device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        pass.setPipeline(program.trace);
        pass.setBindGroup(0, group);
        if (program.tableGroup) pass.setBindGroup(1, program.tableGroup);
        pass.dispatchWorkgroups(Math.ceil(width / 8), Math.ceil((y1 - y0) / 8));
        pass.end();
        this.device.queue.submit([encoder.finish()]);
        return this.device.queue.onSubmittedWorkDone();
    }

    #nothing() {
        return (this.empty ??= this.#storage(new Float32Array(4)));
    }

    swap(side) {
        side.front = 1 - side.front;
        Object.assign(side, { width: side.films[side.front].width, height: side.films[side.front].height });
    }

    show(a, b, D) {
        const film = (side) => side?.films[side.front]?.buffer;
        if (!film(a)) return;
        this.device.queue.writeBuffer(this.screen, 0, D);
        const encoder = this.device.createCommandEncoder();
        const pass = encoder.beginRenderPass({
            colorAttachments: [
                { view: this.context.getCurrentTexture().createView(), loadOp: "clear", storeOp: "store" },
            ],
        });
        pass.setPipeline(this.display);
        // The same buffer twice is allowed: both are read only
        pass.setBindGroup(
            0,
            this.#group(this.display.getBindGroupLayout(0), [this.screen, film(a), film(b) ?? film(a)]),
        );
        pass.draw(3);
        pass.end();
        this.device.queue.submit([encoder.finish()]);
    }

    async #read(buffer, size) {
        const copy = this.device.createBuffer({ size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ });
        const encoder = this.device.createCommandEncoder();
        encoder.copyBufferToBuffer(buffer, 0, copy, 0, size);
        this.device.queue.submit([encoder.finish()]);
        await copy.mapAsync(GPUMapMode.READ);
        const values = new Float32Array(copy.getMappedRange().slice(0));
        copy.destroy();
        return values;
    }

    readFilm(side) {
        const film = side.films[side.front];
        return this.#read(film.buffer, 16 * film.width * film.height);
    }

    async #compute(pipeline, { params, tableGroup }, values, given, count, out) {
        this.device.queue.writeBuffer(params, 0, values);
        const source = this.#storage(given);
        const made = this.device.createBuffer({
            size: 16 * out,
            usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC,
        });
        const encoder = this.device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, this.#group(this.numberGroup, [params, source, made]));
        if (tableGroup) pass.setBindGroup(1, tableGroup);
        pass.dispatchWorkgroups(Math.ceil(count / 64));
        pass.end();
        this.device.queue.submit([encoder.finish()]);
        const result = await this.#read(made, 16 * out);
        source.destroy();
        made.destroy();
        return result;
    }

    /** (n, 12) rows of wi, wo, u, each padded to four, to (n, 8): f, pdf, sampled wi, its pdf. */
    async rows(program, params, given) {
        await this.#numbers(program);
        const n = given.length / 12;
        return this.#compute(program.rows, program, params, given, n, 2 * n);
    }

    /** (n, 4) directions wo to (n, 4) albedos. Its shader is made when it is first asked for. */
    async albedo(program, params, given) {
        program.albedo ??= await (program.albedoComing ??= this.#numberPipeline(program, albedoWgsl));
        return this.#compute(program.albedo, program, params, given, given.length / 4, given.length / 4);
    }
}
