// GLSL ES 3.00 from the part of WGSL that the passes are written in, so that both interfaces draw by one
// text. Locals have their type, textures are read by textureLoad, tables in storage become textures that
// are 4096 wide. What it does not know, it leaves, and the compiler of the browser complains.

const TYPES = {
    f32: "float",
    i32: "int",
    u32: "uint",
    vec2f: "vec2",
    vec3f: "vec3",
    vec4f: "vec4",
    vec2i: "ivec2",
    vec3i: "ivec3",
    vec2u: "uvec2",
    bool: "bool",
};
const type = (name) => TYPES[name] ?? name;

/** The end of the argument list that begins behind `from`, and its arguments. */
function argumentsOf(text, from) {
    const found = [];
    let depth = 0,
        start = from;
    for (let i = from; ; i++) {
        const c = text[i];
        if (c === "(" || c === "[") depth++;
        else if (c === ")" && depth === 0) {
            found.push(text.slice(start, i));
            return [i, found.map((t) => t.trim())];
        } else if (c === ")" || c === "]") depth--;
        else if (c === "," && depth === 0) {
            found.push(text.slice(start, i));
            start = i + 1;
        }
    }
}

function rewriteCalls(text, name, rewrite) {
    const at = text.search(new RegExp(`\\b${name}\\(`));
    if (at < 0) return text;
    const [end, given] = argumentsOf(text, at + name.length + 1);
    const inner = rewrite(given);
    return text.slice(0, at) + inner + rewriteCalls(text.slice(end + 1), name, rewrite);
}

function rewriteAll(text, name, rewrite) {
    // Inner calls are arguments of outer ones: repeat until nothing changes
    for (let before = ""; before !== text; ) {
        before = text;
        text = rewriteCalls(text, name, rewrite);
    }
    return text;
}

function rewriteTables(text, tables) {
    for (const table of tables) {
        const pattern = new RegExp(`\\b${table}\\[`);
        for (let at = text.search(pattern); at >= 0; at = text.search(pattern)) {
            let depth = 0,
                i = at + table.length + 1;
            for (; text[i] !== "]" || depth > 0; i++) depth += (text[i] === "[") - (text[i] === "]");
            const index = text.slice(at + table.length + 1, i);
            text = `${text.slice(0, at)}row_of(${table}, int(${index}))${text.slice(i + 1)}`;
        }
    }
    return text;
}

/** The functions of a WGSL text between its lines "//BEGIN" and "//END" in GLSL. */
export function glsl(wgsl, tables) {
    let text = wgsl.slice(wgsl.indexOf("//BEGIN") + 7, wgsl.indexOf("//END"));
    text = text.replace(/const (\w+): (\w+) =/g, (_, n, t) => `const ${type(t)} ${n} =`);
    text = text.replace(/fn (\w+)\(([^)]*)\) -> (\w+) \{/g, (_, name, parameters, result) => {
        const given = parameters
            .split(",")
            .filter((p) => p.trim())
            .map((p) => {
                const [n, t] = p.split(":").map((part) => part.trim());
                return `${type(t)} ${n}`;
            });
        return `${type(result)} ${name}(${given.join(", ")}) {`;
    });
    text = text.replace(
        /struct (\w+) \{([^}]*)\}/g,
        (_, name, members) =>
            `struct ${name} { ${[...members.matchAll(/(\w+): (\w+)/g)].map(([, n, t]) => `${type(t)} ${n};`).join(" ")} };`,
    );
    text = text.replace(/var<private> (\w+): (\w+);/g, (_, n, t) => `${type(t)} ${n};`);
    text = text.replace(/var (\w+): array<(\w+),\s*(\d+)>;/g, (_, n, t, count) => `${type(t)} ${n}[${count}];`);
    text = text.replace(/\b(?:let|var) (\w+): (\w+)( =|;)/g, (_, n, t, rest) => `${type(t)} ${n}${rest}`);
    text = text.replace(/\bloop \{/g, "for (;;) {");
    text = rewriteAll(text, "select", ([no, yes, condition]) => `((${condition}) ? (${yes}) : (${no}))`);
    text = rewriteAll(text, "textureLoad", (given) =>
        given.length === 4
            ? `texelFetch(${given[0]}, ivec3(${given[1]}, ${given[2]}), ${given[3]})`
            : `texelFetch(${given[0]}, ${given[1]}, ${given[2]})`,
    );
    text = rewriteAll(text, "textureDimensions", ([name]) => `textureSize(${name}, 0)`);
    text = text
        .replace(/\bbitcast<u32>\(/g, "floatBitsToUint(")
        .replace(/\batan2\(/g, "atan(")
        .replace(/\breverseBits\(/g, "reverse_bits(");
    text = rewriteTables(text, tables);
    return text.replace(/\b(vec[234]f|vec[23][iu]|f32|i32|u32)\(/g, (_, t) => `${type(t)}(`);
}
