// What is rarely looked at: large plots, code, about, keys, saved pictures, changes of layers. The page loads it when it
// is first wanted.

export { expect } from "./ahead.js";
export { addCoat, removeLayer, resetLayer, visible } from "./layer_texts.js";
export { lobe } from "./passes/lobe.js";
export { help, menu, picker } from "./ui/cards.js";
export { aboutPane, codePane } from "./ui/panes.js";
export { drawLobe, drawWeights, large } from "./ui/plots.js";
export { savePicture } from "./ui/save.js";
export { share } from "./ui/shared.js";
export { drawThumb } from "./ui/thumbs.js";
