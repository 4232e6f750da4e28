import { svg } from "lit-html";

const PATHS = {
    reset: "M3.5 8a4.5 4.5 0 1 0 1.6-3.4M3.5 2.5v3h3",
    undo: "M3 6h6.5a3.5 3.5 0 0 1 0 7H6M3 6l3-3M3 6l3 3",
    redo: "M13 6H6.5a3.5 3.5 0 0 0 0 7H10M13 6l-3-3M13 6l-3 3",
    swap: "M3 5h10l-2.5-2.5M13 11H3l2.5 2.5",
    light: "M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1",
    large: "M9.5 2.5h4v4M6.5 13.5h-4v-4M13.5 2.5L9 7M2.5 13.5L7 9",
    eye: "M1.5 8s2.4-4.5 6.5-4.5S14.5 8 14.5 8 12.1 12.5 8 12.5 1.5 8 1.5 8zM8 6.2a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6z",
    closed: "M1.5 6.5S4 10.5 8 10.5s6.5-4 6.5-4M3.6 9.2L2.3 11M12.4 9.2l1.3 1.8M8 10.5v2.2",
    warn: "M8 2.2L14.5 13.5h-13zM8 6.5v3.2M8 11.6v.01",
    info: "M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zM8 7.3v3.4M8 5.2v.01",
    layers: "M8 2l6 3.2-6 3.2-6-3.2zM2 8.2l6 3.2 6-3.2M2 11l6 3.2 6-3.2",
    plots: "M2 2v12h12M4.5 10.5l3-4 2.5 2 3.5-5",
    code: "M5.5 4L1.5 8l4 4M10.5 4l4 4-4 4",
    wipe: "M5.5 4.5L2 8l3.5 3.5M10.5 4.5L14 8l-3.5 3.5",
    close: "M4 4l8 8M12 4l-8 8",
    more: "M3 8h.01M8 8h.01M13 8h.01",
    plus: "M8 3v10M3 8h10",
};

export const icon = (name) =>
    svg`<svg class="ic" viewBox="0 0 16 16" aria-hidden="true"><path d=${PATHS[name]}></path></svg>`;
