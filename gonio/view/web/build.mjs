// Builds viewer.js, which is committed: `npm ci && npm run build` in this folder. Nobody needs Node to use it.
import { build, transform } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";

/** Shaders without comments and indents. */
const small = (text) => text.replace(/(^|\s)\/\/(?!MODEL|BEGIN|END).*$/gm, "$1").replace(/^\s+/gm, "").replace(/[ \t]+$/gm, "");

const texts = {
    name: "texts",
    setup(esbuild) {
        esbuild.onLoad({ filter: /\.wgsl$/ }, async ({ path }) => ({ contents: small(await readFile(path, "utf8")), loader: "text" }));
        esbuild.onLoad({ filter: /\.css$/ }, async ({ path }) => {
            const { code } = await transform(await readFile(path, "utf8"), { loader: "css", minify: true });
            return { contents: code, loader: "text" };
        });
        // Markup in templates: indents are nothing that is seen
        esbuild.onLoad({ filter: /src\/ui\/.*\.js$/ }, async ({ path }) => ({ contents: (await readFile(path, "utf8")).replace(/>\n\s+</g, "><"), loader: "js" }));
    },
};

const licence = async (name, file) => `${name}\n${(await readFile(new URL(`node_modules/${name}/${file}`, import.meta.url), "utf8")).trim()}`;
const licences = [await licence("lit-html", "LICENSE"), await licence("parse-exr", "LICENSE.md"), await licence("fflate", "LICENSE")];

const out = process.argv[2] ?? new URL("viewer.js", import.meta.url).pathname;
await build({
    entryPoints: [new URL("src/main.js", import.meta.url).pathname],
    bundle: true, minify: true, format: "esm", target: "es2022", charset: "utf8",
    legalComments: "none", plugins: [texts], outfile: out,
});
const banner = "/* gonio view, built from src/ by build.mjs; Apache-2.0. It contains these works of others:\n\n" +
    `${licences.join("\n\n").replaceAll("*/", "* /")}\n*/\n`;
await writeFile(out, banner + (await readFile(out, "utf8")));
