// The page's beginning: from `gonio view`, from a saved file, or in a notebook's cell.
import { App } from "./app.js";
import { Notebook, Saved, Server } from "./source.js";
import { parsed } from "./state.js";

/** A viewer inside an element; its styles stay there. */
export async function mount(host, source, options = {}) {
    const root = host.attachShadow({ mode: "open" }),
        sheet = new CSSStyleSheet();
    sheet.replaceSync(await source.file("viewer.css"));
    root.adoptedStyleSheets = [sheet];
    const app = new App(root, source, options);
    return app.open();
}

async function openPage() {
    const data = document.getElementById("gonio-data"),
        host = document.createElement("div");
    document.body.append(host);
    document.documentElement.style.height = document.body.style.height = "100%";
    document.body.style.margin = "0";
    const given = location.hash,
        token = /(?:^#|&)token=([\w-]+)/.exec(given)?.[1];
    let source,
        linked = (text) => history.replaceState(null, "", `#${text}`);
    if (data) {
        const bytes = Uint8Array.from(atob(data.textContent.trim()), (c) => c.charCodeAt(0));
        const text = await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
        source = new Saved(JSON.parse(text));
    } else {
        // The token leaves the address, so that a copied link does not carry it; a reload keeps it
        if (token) sessionStorage.setItem("gonio-token", token);
        source = new Server(token ?? sessionStorage.getItem("gonio-token") ?? "");
    }
    const graphics = new URLSearchParams(location.search).get("graphics") ?? "";
    try {
        const fragment = given.replace(/(^#|&)token=[\w-]+&?/, "$1");
        globalThis.gonio = await mount(host, source, {
            fragment,
            linked,
            graphics,
            // Scroll bars are the document's
            themed: (theme) => {
                document.documentElement.style.colorScheme = theme;
            },
        });
        const title = () => {
            document.title = `${globalThis.gonio.sides
                .map((s) => s.text())
                .join(" | ")
                .slice(0, 120)} – gonio view`;
        };
        title();
        addEventListener("hashchange", () => {
            const { state } = parsed(location.hash);
            if (state.a) location.reload();
        });
    } catch (error) {
        host.textContent = error.message;
        host.style.cssText = "font:15px sans-serif;padding:48px;max-width:60ch";
    }
}

/** The widget of `gonio.view.Viewer`: its texts follow the page's, and the page follows them. */
async function render({ model: widget, el }) {
    const host = document.createElement("div");
    host.className = "embedded";
    host.style.height = `${widget.get("height")}px`;
    el.append(host);
    const texts = () =>
        ["a", "b"]
            .filter((k) => widget.get(k))
            .map((k) => `${k}=${encodeURIComponent(widget.get(k))}`)
            .join("&");
    const told = (app) => {
        for (const [i, key] of ["a", "b"].entries()) widget.set(key, app.sides[i]?.payload ? app.sides[i].text() : "");
        widget.save_changes();
    };
    const app = await mount(host, new Notebook(widget), {
        fragment: `${texts()}&${widget.get("settings")}`,
        keys: host,
        changed: told,
        linked: (text) => {
            widget.set("link", text);
            widget.save_changes();
        },
    });
    const follow = { "change:a": () => app.show(widget.get("a"), "a"), "change:b": () => app.follow(widget.get("b")) };
    for (const [name, call] of Object.entries(follow)) widget.on(name, call);
    return () => {
        for (const [name, call] of Object.entries(follow)) widget.off(name, call);
        app.close();
    };
}

export default { render };

if (document.getElementById("gonio-data") || document.querySelector('script[src="/viewer.js"]')) openPage();
