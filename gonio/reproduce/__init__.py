"""Every figure, table, equation and number of the texts that gonio implements, beside what it computes.

    from gonio import reproduce
    item = reproduce.find("eon:11")
    made = reproduce.make(item)                 # numbers, verdict, and a picture that is drawn when saved
    print(reproduce.table(made))
    reproduce.write(item, "reproduced")         # eon-11.png, eon-11.md and eon-11.json
    reproduce.write_all(list(reproduce.items()), "reproduced")      # what is there already is kept

Each text has a folder here, whose files declare its items: what the text states, how gonio computes the
same, and, where the text is wrong, the proof. Verdicts are computed from the numbers, never written down.
"""

from gonio.reproduce.catalogue import find, items, texts
from gonio.reproduce.runner import ReproduceError, counted, make, write, write_all
from gonio.reproduce.sheet import Line, Sheet, Verdict
from gonio.reproduce.table import table
from gonio.reproduce.text import Item, Made, Text

__all__ = [
    "Item",
    "Line",
    "Made",
    "ReproduceError",
    "Sheet",
    "Text",
    "Verdict",
    "counted",
    "find",
    "items",
    "make",
    "table",
    "texts",
    "write",
    "write_all",
]
