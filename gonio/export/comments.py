"""Comments of an export: in ASCII, folded to the page, with names as they are in the text around them."""

from __future__ import annotations

import re
import textwrap
import unicodedata
from collections.abc import Iterable, Mapping

# Comments may be as wide as they are in gonio's files; this is what is left of that inside a function.
WIDTH = 105

# A line that is shorter ends where its author wanted it to.
SHORT = 60

ASCII = str.maketrans(
    {"–": "-", "—": "-", "−": "-", "·": "*", "∫": "integral of ", "≤": "<=", "≥": ">=", "²": "^2"}
    | {"³": "^3", "π": "pi", "θ": "theta", "φ": "phi", "α": "alpha", "μ": "mu", "τ": "tau"}
    | {"ω": "omega", "σ": "sigma", "ρ": "rho", "×": "x", "’": "'", "“": '"', "”": '"', "…": "..."}
    | {"Λ": "Lambda", "λ": "lambda", "ε": "eps", "δ": "delta", "β": "beta", "η": "eta", "ß": "ss"}
)


def plain_text(text: str) -> str:
    """Text on one line in ASCII that ends no comment early and swallows no line after it.

    Some compilers stumble over anything but ASCII, in comments as well. A backslash at the end of a line
    joins it with the next one, in old C++ as ??/ too.
    """
    text = unicodedata.normalize("NFKD", text.translate(ASCII))
    text = "".join(c if c.isprintable() else " " for c in text)
    text = text.encode("ascii", "ignore").decode().replace("??/", "? /")
    return re.sub(r"\\+(?=\s|$)", "", text)


def comment(lines: Iterable[str], names: Mapping[str, str] | None = None) -> list[str]:
    """Comment lines: paragraphs folded anew to the width of the page."""
    found: list[str] = []
    for line in reflowed([named(plain_text(line).rstrip(), names or {}) for line in lines]):
        found += [f"// {part}" for part in _folded(line)] or ["//"]
    return found


def _folded(line: str) -> list[str]:
    """A paragraph in lines; narrower ones where a single word would be left for the last."""
    folded: list[str] = []
    for width in range(WIDTH, SHORT, -1):
        folded = textwrap.wrap(
            line,
            width,
            subsequent_indent=" " * _indent(line),
            break_long_words=False,
            break_on_hyphens=False,
        )
        if len(folded) < 2 or len(folded[-1].split()) > 1:
            break
    return folded


def reflowed(lines: list[str]) -> list[str]:
    """Paragraphs as one line each. A line that had room for the next word ends where it should."""
    width = max([SHORT, *(len(line) for line in lines)])
    found: list[str] = []
    last = ""
    for line in lines:
        word = line.split(maxsplit=1)[0] if line.strip() else ""
        same = _indent(line) == _indent(last) and not re.match(r"\s*([-*|>]|\d+[.)])\s", line)
        if found and last.strip() and word and same and len(last) + 1 + len(word) > width:
            found[-1] += " " + line.strip()
        else:
            found.append(line)
        last = line
    return found


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def named(text: str, names: Mapping[str, str]) -> str:
    """Text with names as the file has them: those in backticks, and all that can only be names."""

    def change(match: re.Match[str]) -> str:
        quoted, plain = match[1], match[2]
        if quoted in names:
            return names[quoted]
        name = (quoted or plain).rpartition(".")[2]
        if name not in names or not (quoted or "_" in name.strip("_")):
            return match[0]
        return names[name]

    # Not in quotation marks, which the values of options have
    return re.sub(r"`([\w.]+)`|(?<![\w.'\"])([A-Za-z_]\w*)(?![\w.]*\.py)", change, text)
