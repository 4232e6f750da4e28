// Builds viewer.js, which is committed: `npm ci && npm run build` in this folder. Nobody needs Node to use it.
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";
import { glsl } from "./glsl.mjs";

const TABLES = ["nodes", "places", "looks", "alias_table"];

/** Shaders without comments and indents; as WGSL and as GLSL. */
const small = (text) => text.replace(/(^|\s)\/\/(?!MODEL|BEGIN|END).*$/gm, "$1").replace(/^\s+/gm, "").replace(/[ \t]+$/gm, "");

const passes = {
    name: "passes",
    setup(esbuild) {
        esbuild.onLoad({ filter: /\.wgsl$/ }, async ({ path }) => {
            const text = await readFile(path, "utf8");
            const common = text.slice(text.indexOf("//BEGIN"), text.indexOf("//END")).replace("//BEGIN", "");
            const es = small(glsl(`//BEGIN${common}`, TABLES)).replace("//BEGIN", "");
            const model = text.includes("//MODEL") ? "//MODEL\n" : "";
            const [before, after] = es.split("//MODEL");
            return {
                contents: `export const wgsl = ${JSON.stringify(small(text).replace(/\/\/(BEGIN|END)/g, ""))};\n` +
                    `export const glsl = ${JSON.stringify(after === undefined ? before : before + model + after)};\n`,
                loader: "js",
            };
        });
    },
};

const licence = async (name, file) => `${name}\n${(await readFile(new URL(`node_modules/${name}/${file}`, import.meta.url), "utf8")).trim()}`;
const licences = [await licence("lit-html", "LICENSE"), await licence("parse-exr", "LICENSE.md"), await licence("fflate", "LICENSE")];

const out = process.argv[2] ?? new URL("viewer.js", import.meta.url).pathname;
await build({
    entryPoints: [new URL("src/main.js", import.meta.url).pathname],
    bundle: true, minify: true, format: "esm", target: "es2022", charset: "utf8",
    legalComments: "none", loader: { ".css": "text", ".svg": "text" }, plugins: [passes], outfile: out,
});
const banner = "/* gonio view, built from src/ by build.mjs; Apache-2.0. It contains these works of others:\n\n" +
    `${licences.join("\n\n").replaceAll("*/", "* /")}\n*/\n`;
await writeFile(out, banner + (await readFile(out, "utf8")));
