// How numbers are shown, read and put on sliders.

const DEGREES = 180 / Math.PI;

/** A number for a narrow field. */
export function shown(x) {
    if (x === 0) return "0";
    const size = Math.abs(x);
    if (size < 1e-3 || size >= 1e5)
        return x
            .toExponential(2)
            .replace(/\.?0+e/, "e")
            .replace("e+", "e");
    return String(Number(x.toFixed(size < 0.1 ? 4 : size < 10 ? 3 : size < 100 ? 2 : 1)));
}

/** With a fixed number of digits and a true minus. */
export const fixed = (x, digits = 4) => (Number.isFinite(x) ? x.toFixed(digits).replace("-", "−") : "–");

export const toUnit = (p, x) => (p.kind === "angle" ? x * DEGREES : x);
export const fromUnit = (p, x) => (p.kind === "angle" ? x / DEGREES : x);
export const unitOf = (p) => (p.kind === "angle" ? "°" : "");

/** Where a value is on a slider, 0 to 1. */
export function place(p, x) {
    const t =
        p.scale === "log"
            ? Math.log(Math.max(x, p.soft_low) / p.soft_low) / Math.log(p.soft_high / p.soft_low)
            : (x - p.soft_low) / (p.soft_high - p.soft_low);
    return Math.max(0, Math.min(1, t));
}

/** The value at a place of a slider; at the left end of a logarithm's, the lowest that is allowed. */
export function at(p, t) {
    if (t <= 0) return p.scale === "log" ? p.low : p.soft_low;
    if (t >= 1) return p.soft_high;
    const x =
        p.scale === "log" ? p.soft_low * (p.soft_high / p.soft_low) ** t : p.soft_low + t * (p.soft_high - p.soft_low);
    return Number(x.toPrecision(4));
}

export function range(p) {
    const text = (x) => shown(toUnit(p, x)) + unitOf(p);
    return p.high === null ? `at least ${text(p.low)}` : `${text(p.low)} to ${text(p.high)}`;
}

/** A typed text as a value that is allowed, or why not. */
export function read(p, text) {
    const x = Number(text.replace("−", "-").replace(",", ".").replace("°", "").trim());
    if (text.trim() === "" || !Number.isFinite(x)) return { error: `${text.trim() || "Nothing"} is no number.` };
    const value = fromUnit(p, x);
    const slack = 1e-7 * Math.max(1, Math.abs(value)); // pi / 2 in degrees and back
    if (value < p.low - slack || (p.high !== null && value > p.high + slack))
        return { error: `Allowed is ${range(p)}.` };
    return { value: Math.max(p.low, p.high === null ? value : Math.min(p.high, value)) };
}

/** Marks of a logarithmic slider: decades. */
export function decades(p) {
    const found = [];
    for (let e = Math.ceil(Math.log10(p.soft_low) - 1e-9); e <= Math.log10(p.soft_high) + 1e-9; e++) {
        const small = [...String(e)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c])).join("");
        found.push({
            at: place(p, 10 ** e),
            text: e < -2 || e > 3 ? `10${small}` : String(Number((10 ** e).toFixed(3))).replace(/^0\./, "."),
        });
    }
    return found;
}
