// Whole shaders in GLSL ES 3.00 from the same passes. What it shares with `texts.js` comes by `gpu/webgl2.js`.
import { glsl } from "./glsl.js";

let shared; // of texts.js
export const share = (texts) => {
    shared = texts;
};

const TABLES = ["nodes", "places", "looks", "alias_table"];
const common = (text) => glsl(text, TABLES); // the part that both languages share
const sources = (model) => shared.sources(model, "essl", common);

const HEAD = "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n";

export function traceEssl(model) {
    const tables = ["nodes", "places", "looks", "alias_table", "sky", "before"];
    return `${HEAD}precision highp sampler2DArray;
uniform vec4 U[52]; uniform vec4 P[${shared.members(model)}];
uniform sampler2D ${tables.join(", ")}; uniform sampler2DArray maps; out vec4 film;
${TABLE}${common(shared.trace).replace("//MODEL", () => sources(model) + shared.modelAt(model, "essl"))}
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

export function rowsEssl(model) {
    return `${HEAD}uniform vec4 P[${shared.members(model)}]; uniform sampler2D given;
layout(location = 0) out vec4 made; layout(location = 1) out vec4 drawn;
${sources(model)}${common(shared.rows)}
vec4 row_of(int i) { return texelFetch(given, ivec2(i % 768, i / 768), 0); }
void main() {
    int i = int(gl_FragCoord.y) * 256 + int(gl_FragCoord.x);
    made = values_at(row_of(3 * i).xyz, row_of(3 * i + 1).xyz);
    drawn = drawn_at(row_of(3 * i + 1).xyz, row_of(3 * i + 2).xy);
}`;
}

export function albedoEssl(model) {
    return `${HEAD}uniform vec4 P[${shared.members(model)}]; uniform sampler2D given; out vec4 made;
${sources(model)}
void main() { made = vec4(model_albedo(model_load(P), texelFetch(given, ivec2(gl_FragCoord.xy), 0).xyz), 0.0); }`;
}

export const displayEssl = () => `${HEAD}uniform vec4 D[4]; uniform sampler2D film_a, film_b; out vec4 shown;
vec4 film_at(bool second, int x, int y, int w) {
    return second ? texelFetch(film_b, ivec2(x, y), 0) : texelFetch(film_a, ivec2(x, y), 0);
}
${common(shared.display)}
void main() { shown = screen(vec2(gl_FragCoord.x, D[3].y - gl_FragCoord.y) / D[3].xy); }`;

export const cornerEssl = `${HEAD}void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;
