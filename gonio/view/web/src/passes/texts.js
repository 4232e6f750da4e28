// Whole shaders in WGSL from the passes and a model's export; `essl.js` has those of WebGL2.

import display from "./display.wgsl";
import foreign from "./foreign.wgsl";
import rows from "./rows.wgsl";
import trace from "./trace.wgsl";

const AT = {
    wgsl: "fn model_at(uv: vec2f, growth: f32, t: f32) -> Model {\n    var m: Model = model_load(P);\n",
    essl: "Model model_at(vec2 uv, float growth, float t) {\n    Model m = model_load(P);\n",
};

/** The parameters at a point: what a material's textures, flakes and growth give in place of the struct's. */
export function modelAt(model, language) {
    const placed = (hook) => `uv * ${language === "wgsl" ? "vec2f" : "vec2"}(${hook.scale.map(float).join(", ")})`;
    const bump = model.hooks.find((hook) => hook.source === "normal_map");
    const stored = bump
        ? `2.0 * map_linear(${placed(bump)}, ${bump.layer}).xyz - 1.0`
        : language === "wgsl"
          ? "vec3f(0.0, 0.0, 1.0)"
          : "vec3(0.0, 0.0, 1.0)";
    const normal =
        language === "wgsl"
            ? `fn normal_at(uv: vec2f) -> vec3f { return ${stored}; }\n`
            : `vec3 normal_at(vec2 uv) { return ${stored}; }\n`;
    const lines = model.hooks
        .filter((hook) => hook !== bump)
        .map((hook) => {
            const member = `m.${hook.members[language]}`;
            if (hook.source === "mesh") return `    ${member} = growth;`;
            if (hook.source === "viewer") return `    ${member} = t / ${float(hook.unit)};`;
            const sampled =
                hook.source === "flakes"
                    ? `map_nearest(uv * ${float(hook.tiles)}, ${hook.layer})`
                    : `map_linear(${placed(hook)}, ${hook.layer})`;
            return `    ${member} = ${sampled}.${hook.width === 3 ? "rgb" : "xy"[hook.channel]};`;
        });
    return `${normal}${AT[language]}${lines.join("\n")}\n    return m;\n}\n`;
}
const float = (x) => (Number.isInteger(x) ? `${x}.0` : String(x));

const PASSES = [trace, rows, display, foreign].join("\n");
// Names of the passes, which code that others wrote may have as well
const taken = new Set(
    [...PASSES.matchAll(/(?:\bfn|\bconst|\bstruct|\bvar<[^>]*>|\) var) (\w+)/g)]
        .map((m) => m[1])
        .concat("P", "given", "made", "drawn", "D", "film_a", "film_b", "shown", "row_of", "reverse_bits", "main")
        .filter((name) => !/^Model|^model_/.test(name)),
);

/** A model's functions and their loader; code that others wrote with its own names, and what its file lacks. */
export function sources(model, language, spelled = (text) => text) {
    let code = model.code[language];
    if (model.foreign)
        code =
            code.replace(/\b[A-Za-z_]\w*/g, (name) => (taken.has(name) ? `${name}_user` : name)) +
            spelled(foreign).replace(/^.*\/\/BEGIN|\/\/END.*$/gs, "");
    return `${code}\n${model.load[language]}\n`;
}

export const members = (model) => Math.max(1, model.members.length);
export { display, rows, trace };

export function traceWgsl(model) {
    const text = trace.replace("MEMBERS", members(model));
    return text.replace("//MODEL", () => sources(model, "wgsl") + modelAt(model, "wgsl"));
}

const ROWS_WGSL = (count) => `@group(0) @binding(0) var<uniform> P: array<vec4f, ${count}>;
@group(0) @binding(1) var<storage, read> given: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> made: array<vec4f>;
`;

export function rowsWgsl(model) {
    return `${ROWS_WGSL(members(model))}${sources(model, "wgsl")}${rows}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if (3u * i + 2u >= arrayLength(&given)) { return; }
    made[2u * i] = values_at(given[3u * i].xyz, given[3u * i + 1u].xyz);
    made[2u * i + 1u] = drawn_at(given[3u * i + 1u].xyz, given[3u * i + 2u].xy);
}`;
}

export function albedoWgsl(model) {
    return `${ROWS_WGSL(members(model))}${sources(model, "wgsl")}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&given)) { return; }
    made[id.x] = vec4f(model_albedo(model_load(P), given[id.x].xyz), 0.0);
}`;
}

export const displayWgsl = `@group(0) @binding(0) var<uniform> D: array<vec4f, 4>;
@group(0) @binding(1) var<storage, read> film_a: array<vec4f>;
@group(0) @binding(2) var<storage, read> film_b: array<vec4f>;
fn film_at(second: bool, x: i32, y: i32, w: i32) -> vec4f {
    if (second) { return film_b[y * w + x]; }
    return film_a[y * w + x];
}
${display}
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.0, 1.0);
}
@fragment fn pixel(@builtin(position) at: vec4f) -> @location(0) vec4f { return screen(at.xy / D[3].xy); }`;
