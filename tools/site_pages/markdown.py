"""Text as MyST Markdown: what docstrings say, with nothing in it taken for markup."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

# Lexers of Pygments by file extension, for languages that it does not know the nearest one.
LEXERS = {
    "glsl": "glsl",
    "essl": "glsl",
    "hlsl": "hlsl",
    "slang": "hlsl",
    "wgsl": "wgsl",
    "metal": "cpp",
    "h": "cpp",
    "cuh": "cuda",
    "osl": "c",
    "mtlx": "xml",
}


def plain(text: str) -> str:
    """A text whose code in backticks stays code, and whose other characters stand for themselves."""
    pieces = re.split(r"(`[^`]+`)", text)
    pieces[::2] = [re.sub(r"([\\*_\[\]<>$~#|])", r"\\\1", piece) for piece in pieces[::2]]
    return "".join(pieces)


def sentence(text: str) -> str:
    """With a capital letter in front, unless it begins with a symbol or a name, and a full stop behind."""
    if re.match(r"(?:a )?[a-z][a-z-]+[ ,:;]", text):
        text = text[:1].upper() + text[1:]
    return text if text.endswith((".", "?", "!", ":")) else f"{text}."


def fence(text: str, language: str = "text", *options: str) -> str:
    """A block of code, whatever fences stand inside it."""
    longest = max(map(len, re.findall(r"`+", text)), default=0)
    marks = "`" * max(3, longest + 1)
    # The nearest language's lexer may stumble over a word, which is no reason to say so
    lines = [f"{marks}{{code-block}} {language}", ":force:", *options, "", text.rstrip("\n"), marks]
    return "\n".join(lines)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are Markdown already."""

    def row(cells: Sequence[str]) -> str:
        # plain() has escaped the bars outside of code
        cells = [re.sub(r"(?<!\\)\|", r"\\|", cell).replace("\n", " ") for cell in cells]
        return f"| {' | '.join(cells)} |"

    return "\n".join([row(head), row(["---"] * len(head)), *map(row, rows)])


def tabs(items: Iterable[tuple[str, str]], group: str) -> str:
    """Blocks of Markdown behind tabs; all tabs of a group on the site show the same choice."""
    lines = ["::::::{tab-set}", f":sync-group: {group}", ""]
    for title, body in items:
        lines += [f":::::{{tab-item}} {title}", f":sync: {title}", "", body, ":::::", ""]
    return "\n".join([*lines, "::::::"])


def page(*blocks: str | None) -> str:
    """Blocks with blank lines between them; those that are empty are left out."""
    return "\n\n".join(block for block in blocks if block) + "\n"
