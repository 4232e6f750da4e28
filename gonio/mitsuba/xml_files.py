"""Mitsuba's XML files: where the files they name come from, and what went wrong, in one line."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mitsuba as mi

from gonio.files import is_utf8


@contextmanager
def in_utf8(file: Path) -> Iterator[Path]:
    """The absolute path of a file by which Mitsuba can open it and what lies beside it.

    Mitsuba opens no names that are not UTF-8: such a file and its neighbours get links with other names
    for the time. What the file itself names is UTF-8, as it is text.
    """
    file = file.absolute()
    if is_utf8(file):
        yield file
        return
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        for beside in file.parent.iterdir():
            if is_utf8(Path(beside.name)):
                (folder / beside.name).symlink_to(beside)
        link = folder / file.name
        if not is_utf8(link):
            link = folder / f"gonio-{os.fsencode(file.name).hex()}.xml"
            link.symlink_to(file)
        yield link


@contextmanager
def files_from(folder: Path) -> Iterator[None]:
    """Let Mitsuba look for files in a folder first, and forget about it at the end."""
    resolver = mi.file_resolver()
    before = [resolver[k] for k in range(len(resolver))]
    resolver.prepend(str(folder.absolute()))
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
