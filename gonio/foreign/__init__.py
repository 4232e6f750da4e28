"""Judging shader code that others wrote: run it on arrays, check it, compare it, find out what it is.

    from gonio import foreign
    code = foreign.load("brdf.glsl#ggx", mapping=["L=wi V=wo"])
    code.brdf(wi, wo, {"roughness": 0.3})                 # arrays (n, 3)
    foreign.check(code)                                   # energy, reciprocity, finite values ...
    foreign.compare(code, gonio.model("ue4")).lines()     # the largest difference, and where
    foreign.identify(code).lines()                        # which model it is
    foreign.as_model(code)                                # a model for plots and fits

The code is compiled by its own compiler and runs in a process of its own, with limits of time and memory.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from gonio.foreign.function import Foreign, Returns, is_foreign
from gonio.foreign.source import ForeignError

if TYPE_CHECKING:
    from gonio.foreign.compared import Comparison, compare
    from gonio.foreign.identity import Identity, identify
    from gonio.foreign.loading import load
    from gonio.foreign.model import as_model
    from gonio.foreign.verdicts import check

__all__ = [
    "Comparison",
    "Foreign",
    "ForeignError",
    "Identity",
    "Returns",
    "as_model",
    "check",
    "compare",
    "identify",
    "is_foreign",
    "load",
]

# Where the others are: commands ask of every name whether it is code, and most never meet any.
_PLACES = {
    "Comparison": "compared",
    "Identity": "identity",
    "as_model": "model",
    "check": "verdicts",
    "compare": "compared",
    "identify": "identity",
    "load": "loading",
}


def __getattr__(name: str) -> Any:
    """What loads only when it is used."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_PLACES[name]}"), name)
