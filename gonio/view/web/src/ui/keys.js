// The keyboard. Fields keep their keys to themselves.
import { MIDDLE } from "./page.js";

const VIEWS = ["picture", "lobe", "slices", "map", "albedo", "weights"];

export function keyboard(app) {
    const target = app.options.keys ?? document;
    const pressed = (e) => {
        const from = e.composedPath()[0];
        if (
            (from instanceof HTMLInputElement && from.type !== "range") ||
            from instanceof HTMLTextAreaElement ||
            from instanceof HTMLSelectElement ||
            e.altKey
        )
            return;
        const key = e.key.length === 1 ? e.key.toLowerCase() : e.key,
            two = app.two;
        if (e.ctrlKey || e.metaKey) {
            if (key === "z") {
                e.preventDefault();
                app.step(e.shiftKey ? 1 : -1);
            }
            if (key === "y") {
                e.preventDefault();
                app.step(1);
            }
            return;
        }
        const mode = (cmp) => () => two && app.set({ cmp });
        const actions = {
            a: mode("A"),
            b: mode("B"),
            w: mode("wipe"),
            s: mode("side"),
            d: mode("diff"),
            k: mode("flick"),
            x: () => app.swap(),
            c: () => app.compare(),
            f: () => app.set({ furnace: !app.state.furnace }),
            l: () => app.set({ turn: ((app.state.turn + 195) % 360) - 180 }, "turn"),
            "[": () => app.set({ ev: Math.round((app.state.ev - 1 / 3) * 1000) / 1000 }, "ev"),
            "]": () => app.set({ ev: Math.round((app.state.ev + 1 / 3) * 1000) / 1000 }, "ev"),
            p: () => (app.state.probe && !app.pointer ? app.set({ probe: "" }) : app.probe(...(app.pointer ?? MIDDLE))),
            v: () => app.set({ view: VIEWS[(VIEWS.indexOf(app.state.view) + 1) % VIEWS.length] }),
            "?": () => {
                app.help = !app.help;
                app.update();
            },
            Escape: () => {
                app.help = app.menu = false;
                app.picking = "";
                if (app.state.probe) app.set({ probe: "" });
                app.update();
            },
        };
        if (/^[1-9]$/.test(key)) {
            app.set({ layer: Number(key) - 1 });
            return;
        }
        if (actions[key]) {
            e.preventDefault();
            actions[key]();
        }
    };
    target.addEventListener("keydown", pressed);
    return () => target.removeEventListener("keydown", pressed);
}
