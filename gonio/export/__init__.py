"""Exports of models: readable source code in shading languages, and proof that it is right.

`export` makes the text: `gonio.export.read` reads the Python, `gonio.export.printer` writes it in the
language of `gonio.export.targets`. `gonio.export.prove` compiles it, runs it and compares.
"""

from gonio.export.entry import Entry, Export, Member
from gonio.export.text import FUNCTIONS, export
from gonio.export.tree import ExportError

__all__ = ["FUNCTIONS", "Entry", "Export", "ExportError", "Member", "export"]
