// What `more.js` and its files use of the page, which has it already.
export let albedo, axes, channels, chart, direction, html, layersOf, line, mapCanvases;
export let packRows, path, pick, polar, svg, theta;

export function share(page) {
    ({ albedo, axes, channels, chart, direction, html, layersOf, line, mapCanvases } = page);
    ({ packRows, path, pick, polar, svg, theta } = page);
}
