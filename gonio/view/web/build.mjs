// Builds viewer.js, viewer.css and the parts that it loads when they are wanted; they are committed: `npm ci && npm run build` in this folder. Nobody needs Node to use it.

import { readFile, writeFile } from "node:fs/promises";
import { build, transform } from "esbuild";

/** Shaders without comments, indents, and spaces around operators. */
const small = (text) =>
    text
        .replace(/(^|\s)\/\/(?!MODEL|BEGIN|END).*$/gm, "$1")
        .replace(/^\s+/gm, "")
        .replace(/[ \t]+$/gm, "")
        .replace(/ (\*|\+|\/|[=<>+*/-]=|<|>|&&|\|\|) /g, "$1")
        .replace(/, /g, ",");

const texts = {
    name: "texts",
    setup(esbuild) {
        esbuild.onLoad({ filter: /\.wgsl$/ }, async ({ path }) => ({
            contents: small(await readFile(path, "utf8")),
            loader: "text",
        }));
        // Markup in templates: indents are nothing that is seen
        esbuild.onLoad({ filter: /src\/ui\/.*\.js$/ }, async ({ path }) => ({
            contents: (await readFile(path, "utf8")).replace(/>\n\s+</g, "><"),
            loader: "js",
        }));
    },
};

// What a page opens with, and its parts by the works of others that they contain.
const PARTS = {
    viewer: ["main.js", "lit-html"],
    more: ["more.js"],
    webgl2: ["gpu/webgl2.js"],
    files: ["scene/files.js", "parse-exr", "fflate"],
};

async function licence(name) {
    const at = (file) => readFile(new URL(`node_modules/${name}/${file}`, import.meta.url), "utf8");
    return `${name}\n${(await at("LICENSE").catch(() => at("LICENSE.md"))).trim()}`;
}

const folder = process.argv[2] ?? new URL(".", import.meta.url).pathname;
for (const [part, [entry, ...others]] of Object.entries(PARTS)) {
    const out = `${folder}/${part}.js`;
    await build({
        entryPoints: [new URL(`src/${entry}`, import.meta.url).pathname],
        bundle: true,
        minify: true,
        format: "esm",
        target: "es2022",
        charset: "utf8",
        legalComments: "none",
        plugins: [texts],
        outfile: out,
    });
    const works = (await Promise.all(others.map(licence))).join("\n\n").replaceAll("*/", "* /");
    const banner = `/* gonio view, built from src/ by build.mjs; Apache-2.0.${works && ` It contains these works of others:\n\n${works}\n`} */\n`;
    await writeFile(out, banner + (await readFile(out, "utf8")));
}
const { code } = await transform(await readFile(new URL("src/ui/style.css", import.meta.url), "utf8"), {
    loader: "css",
    minify: true,
    target: "es2022",
});
await writeFile(`${folder}/viewer.css`, code);
