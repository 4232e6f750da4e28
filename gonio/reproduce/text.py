"""A text and its items; each text has a file beside this one, which declares them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from gonio.reproduce.sheet import Sheet, Verdict


class Picture(Protocol):
    """What an item may return besides its numbers: drawn when it is saved."""

    def save(self, output: str | Path) -> Path:
        """Write a PNG."""


Make = Callable[[Sheet], Picture | None]


@dataclass(frozen=True)
class Item:
    """One figure, table, equation or number of a text."""

    text: Text
    name: str
    """Its id within the text."""
    source: str
    """Where it stands: "Figure 11", "Eq. 5 to 8"."""
    states: str
    """What the text shows or says there."""
    covers: tuple[str, ...]
    """Ids of its parts, which stand for the whole: 11-left."""
    slow: bool
    """Whether its numbers take more than a few seconds."""
    make: Make

    @property
    def id(self) -> str:
        """The id that users type, such as "eon:11"."""
        return f"{self.text.name}:{self.name}"


@dataclass
class Text:
    """One of the texts that gonio implements."""

    name: str
    title: str
    items: list[Item] = field(default_factory=list)

    def item(
        self, name: str, source: str, states: str, *covers: str, slow: bool = False
    ) -> Callable[[Make], Make]:
        """Declare an item; the decorated function fills its sheet and may return a picture."""

        def declare(make: Make) -> Make:
            self.items.append(Item(self, name, source, states, covers, slow, make))
            return make

        return declare

    def lacking(self, name: str, source: str, states: str, reason: str) -> None:
        """Declare an item that cannot be had, with the reason."""

        def make(sheet: Sheet) -> None:
            sheet.lack(reason)

        self.items.append(Item(self, name, source, states, (), False, make))


@dataclass(frozen=True)
class Made:
    """An item with its numbers."""

    item: Item
    sheet: Sheet
    picture: Picture | None

    @property
    def verdict(self) -> Verdict:
        """Computed from the numbers; those that need the picture are there once it was saved."""
        return self.sheet.verdict
