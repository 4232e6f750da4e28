// Whole shaders from the passes and a model's export.
import trace from "./trace.wgsl";
import rows from "./rows.wgsl";
import display from "./display.wgsl";
import { glsl } from "./glsl.js";

const TABLES = ["nodes", "places", "looks", "alias_table"];
const common = (text) => glsl(text, TABLES); // the part that both languages share

const HEAD = "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n";
const AT = { wgsl: "fn model_at(uv: vec2f, growth: f32, t: f32) -> Model {\n    var m: Model = model_load(P);\n",
    essl: "Model model_at(vec2 uv, float growth, float t) {\n    Model m = model_load(P);\n" };

/** The parameters at a point: what a material's textures, flakes and growth give in place of the struct's. */
function modelAt(model, language) {
    const placed = (hook) => `uv * ${language === "wgsl" ? "vec2f" : "vec2"}(${hook.scale.map(float).join(", ")})`;
    const bump = model.hooks.find((hook) => hook.source === "normal_map");
    const stored = bump ? `2.0 * map_linear(${placed(bump)}, ${bump.layer}).xyz - 1.0` : language === "wgsl" ? "vec3f(0.0, 0.0, 1.0)" : "vec3(0.0, 0.0, 1.0)";
    const normal = language === "wgsl" ? `fn normal_at(uv: vec2f) -> vec3f { return ${stored}; }\n` : `vec3 normal_at(vec2 uv) { return ${stored}; }\n`;
    const lines = model.hooks.filter((hook) => hook !== bump).map((hook) => {
        const member = `m.${hook.members[language]}`;
        if (hook.source === "mesh") return `    ${member} = growth;`;
        if (hook.source === "viewer") return `    ${member} = t / ${float(hook.unit)};`;
        const sampled = hook.source === "flakes"
            ? `map_nearest(uv * ${float(hook.tiles)}, ${hook.layer})` : `map_linear(${placed(hook)}, ${hook.layer})`;
        return `    ${member} = ${sampled}.${hook.width === 3 ? "rgb" : "xy"[hook.channel]};`;
    });
    return `${normal}${AT[language]}${lines.join("\n")}\n    return m;\n}\n`;
}
const float = (x) => (Number.isInteger(x) ? `${x}.0` : String(x));

const sources = (model, language) => `${model.code[language]}\n${model.load[language]}\n`;

export const members = (model) => Math.max(1, model.members.length);

export function traceWgsl(model) {
    const text = trace.replace("MEMBERS", members(model));
    return text.replace("//MODEL", () => sources(model, "wgsl") + modelAt(model, "wgsl"));
}

export function traceEssl(model) {
    const tables = ["nodes", "places", "looks", "alias_table", "sky", "before"];
    return `${HEAD}precision highp sampler2DArray;
uniform vec4 U[44]; uniform vec4 P[${members(model)}];
uniform sampler2D ${tables.join(", ")}; uniform sampler2DArray maps; out vec4 film;
${TABLE}${common(trace).replace("//MODEL", () => sources(model, "essl") + modelAt(model, "essl"))}
void main() {
    vec4 old = U[0].z < 0.5 ? vec4(0.0) : texelFetch(before, ivec2(gl_FragCoord.xy), 0);
    film = old + pixel(uvec2(gl_FragCoord.xy));
}`;
}
const TABLE = `vec4 row_of(sampler2D table, int i) { return texelFetch(table, ivec2(i & 4095, i >> 12), 0); }
uint reverse_bits(uint x) {
    x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
    return (x << 16) | (x >> 16);
}
`;

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

export function rowsEssl(model) {
    return `${HEAD}uniform vec4 P[${members(model)}]; uniform sampler2D given;
layout(location = 0) out vec4 made; layout(location = 1) out vec4 drawn;
${sources(model, "essl")}${common(rows)}
vec4 row_of(int i) { return texelFetch(given, ivec2(i % 768, i / 768), 0); }
void main() {
    int i = int(gl_FragCoord.y) * 256 + int(gl_FragCoord.x);
    made = values_at(row_of(3 * i).xyz, row_of(3 * i + 1).xyz);
    drawn = drawn_at(row_of(3 * i + 1).xyz, row_of(3 * i + 2).xy);
}`;
}

export function albedoWgsl(model) {
    return `${ROWS_WGSL(members(model))}${sources(model, "wgsl")}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&given)) { return; }
    made[id.x] = vec4f(model_albedo(model_load(P), given[id.x].xyz), 0.0);
}`;
}

export function albedoEssl(model) {
    return `${HEAD}uniform vec4 P[${members(model)}]; uniform sampler2D given; out vec4 made;
${sources(model, "essl")}
void main() { made = vec4(model_albedo(model_load(P), texelFetch(given, ivec2(gl_FragCoord.xy), 0).xyz), 0.0); }`;
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

export const displayEssl = () => `${HEAD}uniform vec4 D[4]; uniform sampler2D film_a, film_b; out vec4 shown;
vec4 film_at(bool second, int x, int y, int w) {
    return second ? texelFetch(film_b, ivec2(x, y), 0) : texelFetch(film_a, ivec2(x, y), 0);
}
${common(display)}
void main() { shown = screen(vec2(gl_FragCoord.x, D[3].y - gl_FragCoord.y) / D[3].xy); }`;

export const cornerEssl = `${HEAD}void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;
