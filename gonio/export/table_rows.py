"""What the rows of tables hold, of which functions, and by how much interpolation is off.

A row of F is a Fresnel term of `gonio.parts.fresnel` for one material, over the cosine. A block of D is
that of one kind of facets, over the facet's angle and the width (`gonio.export.table_facets` has the axes).
"""

from __future__ import annotations

import types
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from gonio.export import table_facets
from gonio.export.coded import COSINES, DISTRIBUTION, FRESNEL, Array, CodedTable, Request
from gonio.export.evaluate import Known, Machine
from gonio.export.read import Reader
from gonio.export.stand_ins import ALONG
from gonio.export.tree import Function, Struct, Type
from gonio.export.values import Static
from gonio.images import codes_of
from gonio.lights.lookups import Lookups
from gonio.parts import fresnel
from gonio.parts.distribution import ALPHA_MIN

# What functions call the cosine at which light meets a surface, and the square of its sine.
COSINE = ("cos_theta", "cos_h", "mu", "c")
SINE2 = ("sin2_h", "sin2")

# The host, by which lookups are told from other calls.
HOST = Static(Lookups())

# Methods of facets that are their density, at a normal or along one.
DENSITIES = ("D", "D_narrow", f"D{ALONG}", f"D_narrow{ALONG}")

# Where errors are measured: so many places between two entries; and facets, for D.
BETWEEN = 8
FACETS = 20_000

# Cosine that stands for the horizon, where some quotients have no value; and a difference from 1 likewise.
HORIZON = 1e-9
NEAR = 1e-6


# --- which functions -------------------------------------------------------------------------------------


def angles_of(function: Function, reader: Reader | None = None) -> int:
    """How many arguments of a Fresnel term are the angle; 0 of other functions."""
    origin = reader.origin(function) if reader is not None else None
    if reader is not None and (origin is None or origin.__module__ != fresnel.__name__):
        return 0
    if function.plain.startswith("_") or not function.plain.startswith(
        ("F_", "transmittance", "split")
    ):
        return 0
    names = [name for name, _ in function.parameters]
    if not names or names[0] not in COSINE:
        return 0
    return 2 if names[1:2] and names[1] in SINE2 else 1


def widths_of(function: Function, reader: Reader) -> tuple[str, ...]:
    """The widths of the facets whose D a function is; none of other functions."""
    origin = reader.origin(function)
    if origin is None or origin.__name__ not in DENSITIES or len(function.parameters) != 2:
        return ()
    kind = function.parameters[0][1]
    if not isinstance(kind, Struct) or kind.python is None or kind.fixed:
        return ()
    names = tuple(member.name for member in kind.members)
    return names if names in (("alpha",), ("alpha_x", "alpha_y")) else ()


def row_name(function: Function, index: Sequence[Known], member: str) -> str:
    """A row's name: the function, and the material."""
    names = [name for name, _ in function.parameters[angles_of(function) :]]
    said = [f"{name}={_number(value)}" for name, value in zip(names, index, strict=True)]
    return f"{function.plain}({', '.join(said)}){'.' + member if member else ''}"


def _number(value: Known) -> str:
    numbers = [f"{v:.7g}" for v in np.ravel(value)]
    return numbers[0] if len(set(numbers)) == 1 else "/".join(numbers)


# --- F ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FresnelRow:
    """F, or 1 - F, of one material, or one of the two."""

    function: Function
    index: tuple[Known, ...]
    member: str
    name: str

    def exact(self, cosines: Array) -> Array:
        """Shape (cosines, 3)."""
        c = np.maximum(cosines, HORIZON)
        given = []
        for name, _ in self.function.parameters[: angles_of(self.function)]:
            given.append(c if name in COSINE else (1 - c) * (1 + c))
        made = Machine().call(self.function, [*given, *self.index])
        made = made[self.member] if self.member else made
        made = made[:, None] if made.ndim == 1 else made
        return np.asarray(np.broadcast_to(made, (len(c), 3)))


def fresnel_table(rows: Sequence[FresnelRow], bits: int) -> CodedTable:
    """All rows of F."""
    cosines = np.linspace(0, 1, COSINES)
    exact = np.stack([row.exact(cosines) for row in rows])
    table = CodedTable(FRESNEL, codes_of(exact, bits), (), ())
    fine = np.linspace(0, 1, BETWEEN * (COSINES - 1) + 1)
    errors = [
        float(np.abs(table.look_up(fine, np.full(1, i)) - row.exact(fine)).max())
        for i, row in enumerate(rows)
    ]
    return replace(table, rows=tuple(row.name for row in rows), errors=tuple(errors))


# --- D ---------------------------------------------------------------------------------------------------


@dataclass
class Distributions:
    """D of some kinds of facets, a block of rows for each."""

    reader: Reader
    request: Request
    blocks: list[Function] = field(default_factory=list)
    _scales: dict[int, float] = field(default_factory=dict)

    def lookup(self, widths: int) -> Function:
        """What stands for D of facets with so many widths, one or two."""
        written = table_facets.tabled_D if widths == 1 else table_facets.tabled_D_anisotropic
        kinds: list[Type | Static] = ["vec2"]
        kinds += ["float"] * (widths + 3)
        return self.reader.function_for(cast(types.FunctionType, written), [*kinds, HOST])

    def numbers(self, number: int) -> tuple[float, ...]:
        """First and last row of a block, and its largest value."""
        places = self.request.places
        return number * places, places - 1, self._scale(self.blocks[number])

    def _scale(self, block: Function) -> float:
        """The largest pi alpha^2 D."""
        if id(block) not in self._scales:
            largest = self._over_round_peak(block).max()
            self._scales[id(block)] = float(f"{largest:.7g}")
        return self._scales[id(block)]

    def _over_round_peak(self, block: Function) -> Array:
        """pi alpha^2 D of facets of one width, shape (widths, sines)."""
        axis = np.linspace(0, 1, self.request.places)
        # Some norms have no value at a width of exactly 0 or 1, only a limit
        alpha = np.clip(axis, NEAR, 1 - NEAR)[:, None]
        slope = alpha * np.sqrt(axis / np.maximum(1 - axis, NEAR * NEAR))
        alpha, slope = np.broadcast_arrays(alpha, slope)
        shape = alpha.shape
        alpha, cosine = alpha.ravel(), 1 / np.hypot(slope.ravel(), 1)
        m = np.stack([slope.ravel() * cosine, 0 * cosine, cosine], -1)
        widths = widths_of(block, self.reader)
        D = Machine().call(block, [dict.fromkeys(widths, alpha), m])
        return np.asarray(np.pi * alpha * alpha * D).reshape(shape)

    def table(self) -> CodedTable:
        """The blocks of all kinds of facets."""
        made = [np.sqrt(self._over_round_peak(b) / self._scale(b)) for b in self.blocks]
        table = CodedTable(DISTRIBUTION, codes_of(np.concatenate(made), self.request.bits), (), ())
        errors = [self._error(table, number) for number in range(len(self.blocks))]
        return replace(
            table,
            rows=tuple(b.plain.removesuffix(ALONG) for b in self.blocks),
            errors=tuple(errors),
        )

    def _error(self, table: CodedTable, number: int) -> float:
        """Largest error of D over its peak, at random facets and widths."""
        block = self.blocks[number]
        names = widths_of(block, self.reader)
        rng = np.random.default_rng(7)
        low = np.log(ALPHA_MIN)
        widths = [np.exp(low * rng.random(FACETS)) for _ in names]
        if len(names) == 2:  # as wide along y as anisotropy makes them
            widths[1] = np.clip(widths[0] * rng.uniform(0.1, 10, FACETS), ALPHA_MIN, 1)
        slope = widths[0] * np.exp(rng.uniform(-4, 4, FACETS))
        phi = 2 * np.pi * rng.random(FACETS)
        t = slope[:, None] * np.stack([np.cos(phi), np.sin(phi)], -1)
        m = np.concatenate([t, np.ones((FACETS, 1))], -1) / np.hypot(slope, 1)[:, None]
        exact = Machine().call(block, [dict(zip(names, widths, strict=True)), m])
        machine = Machine({"distribution_table": table.look_up})
        numbers = [np.full(1, v, np.float64) for v in self.numbers(number)]
        where = t if len(names) == 2 else np.stack([slope * slope, np.ones(FACETS)], -1)
        found = machine.call(self.lookup(len(names)), [where, *widths, *numbers])
        peak = 1 / (np.pi * widths[0] * widths[-1])
        return float(np.max(np.abs(found - exact) / peak))
