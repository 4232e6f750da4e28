"""Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course."""

from gonio.reproduce.text import Text

TEXT = Text("triace", "Beyond a simple physically based Blinn-Phong model (Gotanda, tri-Ace)")
