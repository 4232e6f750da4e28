"""Portsmouth, Kutz, Hill, "EON: A practical energy-preserving rough diffuse BRDF", arXiv:2410.18026."""

from gonio.reproduce.text import Text

TEXT = Text("eon", "EON (Portsmouth, Kutz, Hill)")
