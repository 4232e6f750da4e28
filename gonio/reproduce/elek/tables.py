"""The table of cycles."""

from __future__ import annotations

from gonio.reproduce.cycles import show_cycles
from gonio.reproduce.elek import TEXT
from gonio.reproduce.sheet import Sheet

PRINTED_CYCLES = {"full": 436, "precomputed": 236, "Phong": 104}
PRINTED_RATE = {"full": 348, "precomputed": 757, "Phong": 1648}


@TEXT.item(
    "tab1",
    "Table 1",
    "GPU cycles 436, 236, 104; MPix/s 348, 757, 1648",
    "tab1-cycles",
    "tab1-rate",
    slow=True,
)
def table_1(sheet: Sheet) -> None:
    show_cycles(sheet, "elek_1", "cycles of a GeForce 8800 GTX, which nobody here has")
    peak = 128 * 1.35  # stream processors and GHz of that GPU
    for name, cycles in PRINTED_CYCLES.items():
        giga = cycles * PRINTED_RATE[name] / 1000
        sheet.show(f"{name}: cycles times rate [G/s]; {peak:.0f} is the GPU's peak", giga)
