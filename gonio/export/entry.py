"""What an exported shader offers: the interface between the printer and the proof."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gonio.export.buffer import Buffer

if TYPE_CHECKING:
    from gonio.export.coded import Tables


@dataclass(frozen=True)
class Member:
    """A number or colour in the struct of parameters."""

    path: str
    """Where it is, such as "base.rho" for the rho of the inner model `base`."""
    width: int
    """1 or 3."""
    name: str = ""
    """What it is called in the text, which has names of its own for some words; empty: its path."""

    @property
    def place(self) -> str:
        """Where it is in the text."""
        return self.name or self.path


@dataclass(frozen=True)
class Given:
    """An argument of `shade` that its lights take, after params, normal, tangent and view."""

    name: str
    width: int
    """How many numbers it is made of: 1, 3, or those of its struct."""
    struct: str = ""
    """Its type, if that is a struct of colours."""
    members: tuple[str, ...] = ()
    """Of the struct."""


@dataclass(frozen=True)
class Entry:
    """Names of what an export defines."""

    prefix: str
    """Of all functions, such as "eon" in eon_eval."""
    struct: str
    """Type of the parameters, such as Eon."""
    sample_struct: str
    """Type of what `sample` returns: members wi and pdf."""
    namespace: str
    """Of the C++ header; unused by the other languages."""
    members: tuple[Member, ...]
    """In the order of declaration."""
    functions: tuple[str, ...]
    """Those of "eval", "sample", "pdf" and "albedo" that were exported; "shade" in a lit one."""
    given: tuple[Given, ...] = ()
    """What `shade` takes besides."""
    lookups: tuple[str, ...] = ()
    """Pictures that the host looks up, by their names in the text; methods where there is an object."""
    binds: tuple[str, ...] = ()
    """Textures and samplers that the host binds."""
    lights: tuple[str, ...] = ()
    """The lights of `shade`, with their choices."""
    hosted: tuple[str, ...] = ()
    """Of its functions those that take an object with the lookups as their last argument."""
    reading: tuple[str, ...] = ()
    """Those that read tables, which the host binds."""


@dataclass(frozen=True)
class Export:
    """Source text in one language, with the names it defines."""

    language: str
    source: str
    entry: Entry
    albedo_tolerance: float | None = 0.0
    """What `albedo` may differ from the model's by its own method, absolute, for a white surface;
    0 for closed forms, None where the export says nothing about its error."""
    buffer: Buffer | None = None
    """Tables that the text reads."""
    tables: Tables | None = None
    """What it looks up in the place of functions."""
