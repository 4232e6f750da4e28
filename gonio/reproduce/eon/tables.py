"""The table of times, and what the text says of it."""

from __future__ import annotations

import gonio
from gonio.reproduce.eon import TEXT
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.timing import COSINE, EVAL, OWN, WAYS, ratio_of, show_times

TABLE_1 = {
    "Lambert": (1.4, 67.2, None),
    "FON": (6.3, 67.2, None),
    "QON": (6.3, 67.4, None),
    "fullON": (141.7, 211.218, None),
    "EON (approx)": (20.8, 105.8, 217.0),
    "EON (exact)": (108.7, 193.5, 297.0),
}


@TEXT.item(
    "tab1",
    "Table 1",
    "nanoseconds per evaluation, with cosine sample, with CLTC sample; one thread of an AMD 3970X",
    *(f"tab1-{n}" for n in ("lambert", "fon", "qon", "fullon", "eon-approx", "eon-exact")),
    "tab1-ratio-exact",
    "tab1-ratio-approx",
    "tab1-ratio-cltc",
    slow=True,
)
def table_1(sheet: Sheet) -> None:
    models = {
        "Lambert": gonio.Lambert(),
        "FON": gonio.FON(),
        "QON": gonio.QON(),
        "fullON": gonio.OrenNayar(),
        "EON (approx)": gonio.EON(albedo_form="fitted", sampler="cltc_uniform"),
        "EON (exact)": gonio.EON(sampler="cltc_uniform"),
    }
    printed = {
        (name, way): value
        for name, row in TABLE_1.items()
        for way, value in zip(WAYS, row, strict=True)
        if value is not None
    }
    why = "times of another processor, library (glm) and code: only shown, as exports in C++ on this one"
    times = show_times(sheet, models, printed, why)
    over, approx, exact = ("fullON", EVAL), ("EON (approx)", EVAL), ("EON (exact)", EVAL)
    ratio_of(sheet, "fullON over exact EON", "1.3", times, over, exact)
    ratio_of(sheet, "fullON over approximate EON", "7", times, over, approx)
    sample = ("EON (approx)", OWN)
    ratio_of(
        sheet,
        "CLTC over cosine sampling, approximate EON",
        "2",
        times,
        sample,
        ("EON (approx)", COSINE),
    )
    ratio_of(
        sheet, "the same over cosine sampling of fullON", "1", times, sample, ("fullON", COSINE)
    )


@TEXT.item("tab1-consistency", "Table 1", "a cosine sample's own cost, which should be one number")
def table_1_consistency(sheet: Sheet) -> None:
    cost = {name: row[1] - row[0] for name, row in TABLE_1.items() if row[1] is not None and row[0]}
    for name, value in cost.items():
        sheet.show(f"{name}: cosine column less eval column [ns]", value)
    spread = max(cost.values()) / min(cost.values())
    sheet.remark(
        f"the text's own numbers: the rows differ by a factor of {spread:.2f}, so that the column "
        "cannot be a sum; gonio computes nothing here"
    )


@TEXT.item("asefficient", "section 1", '"as efficient ... as the existing standard QON model"')
def as_efficient(sheet: Sheet) -> None:
    text = TABLE_1["EON (approx)"][0] / TABLE_1["QON"][0]
    sheet.refute(
        "time of EON over that of QON",
        "=",
        "1",
        text,
        proof=20.8 / 6.3,
        within=1e-9,
        why="Table 1 of the text itself: 20.8 ns against 6.3 ns",
    )
