"""SZ's temple, "PBR theory, part 1: foundations", 2019."""

from gonio.reproduce.text import Text

TEXT = Text("pbr", "PBR theory, part 1: foundations (SZ's temple)")
