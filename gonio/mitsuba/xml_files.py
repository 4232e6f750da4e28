"""Mitsuba's XML files: where the files they name come from, and what went wrong, in one line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mitsuba as mi


@contextmanager
def files_from(folder: Path) -> Iterator[None]:
    """Let Mitsuba look for files in a folder first, and forget about it at the end."""
    resolver = mi.file_resolver()
    before = [resolver[k] for k in range(len(resolver))]
    resolver.prepend(str(folder.resolve()))
    try:
        yield
    finally:
        resolver.clear()
        for path in before:
            resolver.append(path)


def reason(error: Exception) -> str:
    """All that Mitsuba says about an error, on one line, without the places in its own source."""
    text = re.sub(r"\[\w+\.(cpp|h):\d+\]\s*", "", str(error))
    return " ".join(text.split()).rstrip("!. ") or type(error).__name__
