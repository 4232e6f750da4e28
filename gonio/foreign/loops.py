"""Counts how often the loops of a shader turn, because drivers may end them by themselves.

Mesa's drivers on the processor allow 65535 turns of all loops of a call together, for the eight or so calls
that share a vector, and then go on with what there was. An endless loop would give numbers that mean
nothing, and so would a long one.
"""

from __future__ import annotations

import re

from gonio.foreign.declarations import closing
from gonio.foreign.source import blank_comments

# What Mesa allows to vectors of 256 bits, for each call if its neighbours turn at other times.
TURNS = 65535 // 8

# What stands in the place of a density after more turns. No code computes it.
CUT = -3e38

COUNTER = "gonio_turns"

# The names of drivers that count.
COUNTING = "llvmpipe"


def counted(text: str, language: str) -> str:
    """A shader whose loops count their turns in COUNTER, line by line as it was.

    Args:
        text: GLSL or WGSL.
        language: "wgsl", or one of the others.
    """
    bare = blank_comments(text)
    edits: list[tuple[int, str]] = []
    for match in re.finditer(r"\b(for|while|loop)\b(?=\s*[({]|\s+\S)", bare):
        if language == "wgsl":
            place = _body(bare, match.end(), match[1])
            turn = f" {COUNTER}++;"
        elif match[1] == "loop":
            continue
        else:
            place, turn = _glsl(bare, match.end(), match[1])
        if place > 0:
            edits.append((place, turn))
    for place, turn in sorted(edits, reverse=True):
        text = text[:place] + turn + text[place:]
    return text


def _body(bare: str, position: int, word: str) -> int:
    """Behind the brace that opens a body in WGSL, where every body has one; 0 if it is no loop."""
    begin = re.compile(r"[^{};]*" if word != "for" else r"\s*(?=\()").match(bare, position)
    if begin is None:
        return 0
    position = begin.end()
    if word == "for":
        position = closing(bare, position, "(", ")")
        space = re.compile(r"\s*").match(bare, position)
        assert space is not None
        position = space.end()
    return position + 1 if bare[position : position + 1] == "{" else 0


def _glsl(bare: str, position: int, word: str) -> tuple[int, str]:
    """Where a loop of GLSL counts: in what for does after each turn, or before while's condition."""
    begin = re.compile(r"\s*\(").match(bare, position)
    if begin is None:
        return 0, ""
    if word == "while":
        # A condition that is a declaration, while (bool more = f()), cannot be joined; nobody writes it
        return begin.end(), f"{COUNTER}++ >= 0 && "
    close = closing(bare, begin.end() - 1, "(", ")") - 1
    parts = bare[begin.end() : close].split(";")
    if len(parts) != 3 or "{" in bare[begin.end() : close]:
        return 0, ""
    step = close - len(parts[2])
    return step, f"{COUNTER}++, " if parts[2].strip() else f"{COUNTER}++"
