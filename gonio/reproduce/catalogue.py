"""The texts and their items. The folder is the list."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Iterator
from pathlib import Path

from gonio.messages import nearest
from gonio.reproduce.text import Item, Text


@functools.cache
def texts() -> dict[str, Text]:
    """All texts by name: every folder beside this file."""
    found = {}
    for folder in sorted(p.parent for p in Path(__file__).parent.glob("*/__init__.py")):
        package = f"gonio.reproduce.{folder.name}"
        text: Text = importlib.import_module(package).TEXT
        for path in sorted(folder.glob("*.py")):
            if path.stem != "__init__":
                importlib.import_module(f"{package}.{path.stem}")
        found[text.name] = text
    return found


def items() -> Iterator[Item]:
    """The items of all texts."""
    for text in texts().values():
        yield from text.items


def find(name: str) -> Item:
    """The item with this id, or the one that has it for a part.

    Raises:
        ValueError: no such item; says which are near.
    """
    known: dict[str, Item] = {}
    for item in items():
        for alias in (item.name, *item.covers):
            known.setdefault(f"{item.text.name}:{alias}", item)
    wanted = name.lower()
    if wanted in texts():
        raise ValueError(f"{name!r} is a text, not an item; --text {wanted} makes all its items.")
    if wanted not in known:
        near = nearest(wanted, known, most=3)
        did = f"; did you mean {', '.join(near)}?" if near else "."
        raise ValueError(f"no item {name!r}{did} 'gonio reproduce' lists all.")
    return known[wanted]
