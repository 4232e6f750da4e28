// Words for numbers in gonio's notation, as gonio/materials/notation.py reads them: metal=Cu, eta=water, rho=#c08040.
import { fromHex } from "./ui/colour.js";

/** The numbers that pieces of a text give to parameters, by path. */
export function numbersOf(parameters, pieces, { metals, indices }) {
    const found = new Map(),
        known = new Map(parameters.map((p) => [p.path, p]));
    for (const [path, text] of pieces) {
        const p = known.get(path),
            wrong = new Error(`This saved page does not know ${path}=${text}.`);
        if (p) {
            const colour = p.width === 3 && text[0] === "#" && fromHex(text),
                index = /(eta|ior)$/.test(path) && indices[text.toLowerCase().replace(/[ -]/g, "_")],
                k = path.replace(/eta$/, "k");
            found.set(path, colour || (index ? [index] : text.split("/").map(Number)));
            if (found.get(path).some(Number.isNaN)) throw wrong;
            if (index && known.has(k) && !pieces.has(k)) found.set(k, [0]);
        } else if (/(^|\.)metal$/.test(path)) {
            const outer = path.slice(0, -5),
                prefix = [outer, `${path}_`].find((m) => known.has(`${m}eta`) && known.has(`${m}k`)),
                metal = Object.values(metals).find((m) => m.symbol === text);
            if (prefix === undefined || !metal) throw wrong;
            found.set(`${prefix}eta`, metal.eta).set(`${prefix}k`, metal.k);
        }
    }
    return found;
}
