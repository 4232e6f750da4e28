"""Docstrings as reStructuredText: written for people, in plain text, they need its marks only here."""

from __future__ import annotations

import re
from typing import Any

from sphinx.ext.napoleon import Config, GoogleDocstring

# What napoleon makes of these headings.
SECTION = re.compile(r"(Args|Returns|Raises|Yields):$")


def convert(lines: list[str]) -> list[str]:
    """A docstring's lines, with code in backticks, indented code, and no other markup."""
    out: list[str] = []
    inside = False  # of a section, which napoleon reads
    code = False
    for number, line in enumerate(lines):
        indented = line.startswith("    ")
        if SECTION.match(line):
            inside, code = True, False
        elif line.strip() and not indented:
            inside, code = False, False
        elif indented and not inside and not code and number and not lines[number - 1].strip():
            out += ["::", ""]
            code = True
        out.append(line if code and indented else _escaped(line))
    return _in_code(out)


def _escaped(line: str) -> str:
    pieces = re.split(r"(`[^`]+`)", line)
    # A name in front of a colon in a section is one that napoleon escapes
    pieces[::2] = [re.sub(r"([\\|*]|_\b)", r"\\\1", piece) for piece in pieces[::2]]
    pieces[1::2] = [f"`{piece}`" for piece in pieces[1::2]]
    return "".join(pieces)


def _in_code(lines: list[str]) -> list[str]:
    """Lines without a backtick that has no partner on its line, which is a symbol and not markup."""
    return [
        re.sub(r"(?<!`)`(?!`)", r"\\`", line) if line.count("`") % 2 else line for line in lines
    ]


def process(
    _app: Any, what: str, _name: str, _object: Any, _options: Any, lines: list[str]
) -> None:
    """For Sphinx's event autodoc-process-docstring."""
    converted = convert(lines)
    # Napoleon would take what stands in front of an attribute's colon for its type
    if what != "attribute":
        settings = Config(napoleon_numpy_docstring=False)
        converted = GoogleDocstring(converted, settings, what=what).lines()
    lines[:] = converted
