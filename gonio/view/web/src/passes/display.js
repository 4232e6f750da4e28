// The settings of the display pass, rows of four numbers:
//  0 mode, wipe (0 to 1), width and height of A's film    1 exposure's factor, tone curve, size of B's film
//  2 1 / samples of A and of B, -, -                      3 width and height of the canvas, -, -

export const MODES = { A: 0, B: 1, wipe: 2, side: 3, diff: 4 };
export const TONES = { none: 0, reinhard: 1, filmic: 2 };

export function screen({ canvas, mode, wipe, exposure, tone, a, b }) {
    const D = new Float32Array(16);
    D.set([MODES[mode], wipe, a.width, a.height], 0);
    D.set([2 ** exposure, TONES[tone], b.width, b.height], 4);
    D.set([1 / a.samples, 1 / b.samples, 0, 0], 8);
    D.set([canvas.width, canvas.height, 0, 0], 12);
    return D;
}
