// The dock's other tabs: the exported code, and what is known about the model.

import { download } from "./save.js";
import { html } from "./shared.js";

const SHORT = {
    glsl: "GLSL",
    essl: "GLSL ES",
    hlsl: "HLSL",
    wgsl: "WGSL",
    msl: "Metal",
    slang: "Slang",
    osl: "OSL",
    cpp: "C++",
    cuda: "CUDA",
    mtlx: "MaterialX",
};
const WORDS =
    /(\/\/.*$)|\b(\d+\.?\d*(?:e[-+]?\d+)?[fu]?)\b|\b(struct|fn|let|var|const|return|if|else|for|float|vec2|vec3|vec2f|vec3f|f32|bool|float2|float3|inline|void|color|vector|int|constexpr|namespace|shader|interface)\b/g;

/** A line with its comments, numbers and words marked; text stays text. */
function marked(line) {
    const parts = [];
    let from = 0;
    for (const found of line.matchAll(WORDS)) {
        parts.push(
            line.slice(from, found.index),
            html`<i class=${found[1] ? "co" : found[2] ? "nu" : "kw"}>${found[0]}</i>`,
        );
        from = found.index + found[0].length;
    }
    return [...parts, line.slice(from)];
}

export function codePane(app) {
    const side = app.edited(),
        { text, error } = side.payload?.foreign ?? app.code,
        saved = !app.source.live,
        lines = text?.split("\n") ?? [];
    const { foreign } = side.payload ?? {};
    const command = foreign
        ? `gonio check '${side.payload.name}'`
        : `gonio export '${side.payload ? side.plainText() : ""}' --to ${app.language}`;
    const languages = foreign ? [] : saved ? ["wgsl", "essl"] : Object.keys(SHORT);
    return html`<div class="row"><div class="seg" role="group" aria-label="Language">${foreign ? html`<button aria-pressed="true">${foreign.language}, as it stands in ${side.payload.name.split("#")[0]}</button>` : ""}${languages.map((id) => html`<button aria-pressed=${app.language === id} @click=${() => app.setLanguage(id)}>${SHORT[id]}</button>`)}</div><span class="sp"></span><span class="dim xs">${text ? `${lines.length - 1} lines` : ""}</span>
            <button class="btn" ?disabled=${!text} @click=${() => download(new Blob([text], { type: "text/plain" }), foreign ? side.payload.name.split("#")[0].split("/").pop() : `${side.payload.name.replace(/\W+/g, "_")}.${{ cpp: "h", msl: "metal", cuda: "cuh" }[app.language] ?? app.language}`)}>Download</button><button class="btn" ?disabled=${!text} @click=${() => app.copy(text, "The code")}>Copy</button></div>
        <pre tabindex="0" aria-label="Exported code"><code>${error ? html`<i class="co">${error}</i>` : text ? lines.map((line) => html`${marked(line)}\n`) : "…"}</code></pre>
        <div class="cmd"><code>${command}</code><button class="btn" @click=${() => app.copy(command, "The command")}>Copy command</button></div>`;
}

export function aboutPane(app) {
    const side = app.edited();
    if (!side.payload) return "";
    return html`${side.payload.about.map(
        (
            m,
        ) => html`<div class="about"><div><h3>${m.title || m.name}</h3>${m.description.split("\n\n").map((p) => html`<p>${p.replaceAll("\n", " ")}</p>`)}${m.source ? html`<p class="source">Source: ${m.source}</p>` : ""}</div>
        <div>${m.claims.length ? html`<h3>Promised, and measured by gonio check</h3>` : ""}<ul class="y">${m.claims.filter((c) => c.kind === "promised").map((c) => html`<li>${c.text}</li>`)}</ul></div>
        <div><h3>${side.payload.foreign ? "To know" : "Known to be wrong"}</h3><ul>${[...m.claims.filter((c) => c.kind !== "promised").map((c) => c.text), ...m.caveats].map((c) => html`<li>${c}</li>`)}</ul>${m.caveats.length + m.claims.filter((c) => c.kind !== "promised").length ? "" : html`<p>Nothing.</p>`}</div></div>`,
    )}
        <div class="cmd"><code>gonio view ${app.sides.map((v) => `'${v.payload ? v.plainText() : ""}'`).join(" ")}</code><button class="btn" @click=${() => app.copy(`gonio view ${app.sides.map((v) => `'${v.plainText()}'`).join(" ")}`, "The command")}>Copy command</button></div>`;
}
