// Choices that may be made next.

const GLANCE_MS = 80; // that a pointer only passes over a list

/** Have an option's other choices ready while its list is looked at: one after the other, and of one list at a time. */
export async function expect(app, path, values) {
    const [side] = app.editing(),
        { turn } = side,
        wish = {};
    app.wish = wish;
    for (const value of values) {
        await new Promise((resolve) => setTimeout(resolve, GLANCE_MS));
        const { gpu } = app;
        if (!gpu || app.wish !== wish || side.turn !== turn) return;
        try {
            // Browsers keep what they have compiled, by its text
            gpu.forget(await gpu.compile(await app.payload(side.text({ [path]: value }))));
        } catch {
            /* it is said when it is chosen */
        }
    }
}
