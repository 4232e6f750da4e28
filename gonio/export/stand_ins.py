"""Functions that exports call in the place of others, and how they are called there."""

from __future__ import annotations

import types

# Ends the name of a method that takes a vector of any length in the place of a unit one.
ALONG = "_along"

# End the name of the function of gonio.parts that exports call in the place of another with the same value:
# of one whose operations are there for derivatives, or for what arrays share with another function, where
# no derivatives are taken; and everywhere of one whose digits the rearranging compilers of shaders lose.
VALUE, PLAIN = "_value", "_plain"
PARTS = "gonio.parts."


def usual_name(function: types.FunctionType) -> str:
    """What a function is called in an export: one that stands for another has the other's name."""
    found = function.__name__
    if function.__module__.startswith(PARTS):
        return found.removesuffix(VALUE).removesuffix(PLAIN)
    return found
