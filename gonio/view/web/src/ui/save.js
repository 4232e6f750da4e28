// A picture as a file, with what it shows written below it.

// What two models' picture shows, where it is not plain.
const SHOWN = {
    wipe: "A left, B right",
    side: "A left, B right",
    diff: "10 × |A − B|",
    A: "A",
    B: "B",
    flick: "A or B",
};

export async function savePicture(app) {
    const { canvas } = app.gpu;
    app.renderer.show();
    const source = await createImageBitmap(canvas),
        line = Math.round(canvas.width / 60) + 6,
        out = document.createElement("canvas");
    out.width = canvas.width;
    out.height = canvas.height + 3 * line;
    const g = out.getContext("2d");
    g.fillStyle = "#141415";
    g.fillRect(0, 0, out.width, out.height);
    g.drawImage(source, 0, 0);
    g.fillStyle = "#ededef";
    g.font = `${line - 6}px sans-serif`;
    const s = app.state,
        first = app.sides.map((side) => `${app.two ? `${side.letter} ` : ""}${side.text()}`);
    const last = `gonio ${app.start.gonio} · ${app.two ? `${SHOWN[s.cmp]} · ` : ""}${s.furnace ? "furnace" : s.env} · ${s.ev >= 0 ? "+" : "−"}${Math.abs(s.ev).toFixed(1)} EV · tone ${s.tone} · ${Math.min(...app.renderer.visible().map((v) => v.samples))} spp · ${app.gpu.name}`;
    [...first, last]
        .slice(-3)
        .forEach((text, i, all) =>
            g.fillText(text, 8, canvas.height + line * (i + 1 + (3 - all.length) / 2) - 4, out.width - 16),
        );
    const blob = await new Promise((resolve) => out.toBlob(resolve, "image/png"));
    download(blob, `${app.sides.map((side) => side.payload.name.replace(/\W+/g, "_")).join("_")}.png`);
}

export function download(blob, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
