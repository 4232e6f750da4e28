"""Cycles of whole shaders on a GPU of today, for the tables of cost in the texts."""

from __future__ import annotations

from gonio.cost import GPUS
from gonio.cost.texts import MADE, measured
from gonio.export.prove.tools import ProofError
from gonio.reproduce.sheet import Sheet

GPU = "navi21"


def show_cycles(sheet: Sheet, key: str, why: str) -> None:
    """Put the text's ratios beside ours, where the compilers are; they depend on the GPU: only shown."""
    sheet.lack(
        f"{why}; beside them cycles of whole shaders on {GPU}, as 'gonio cost --texts' tells"
    )
    try:
        section = measured(MADE[key](), [GPUS[GPU]])
    except ProofError as error:
        sheet.remark(str(error))
        return
    last = section.rows[-1]["row"]
    for row in section.rows[:-1]:
        ours = row[f"{GPU}_ratio"]
        assert isinstance(ours, float)
        sheet.show(f"{row['row']}, over {last}; text {row['text_ratio']:.3g}", ours)
    if len(section.notes) > 1:
        sheet.remark(section.notes[1])
