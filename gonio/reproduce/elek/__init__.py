"""Elek, "Layered materials in real-time rendering", CESCG 2010."""

from gonio.reproduce.text import Text

TEXT = Text("elek", "Layered materials in real-time rendering (Elek)")
