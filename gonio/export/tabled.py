"""Exports that look F and D up in tables: which calls, which rows, what errors.

The index of a material is known when it is exported, so F of each surface in it is a row over the cosine; D
is a table over the facet's angle and the width for each kind of facets. What `eval` and the lights call is
looked up; `sample`, `pdf` and `albedo` keep the functions, as a sampler's density has to be that of its
samples.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3.1.
"""

from __future__ import annotations

import types
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from gonio.export import table_facets
from gonio.export.evaluate import UNKNOWN, Known, Machine
from gonio.export.read import Reader
from gonio.export.table_axes import COSINES, PLACES
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
    Call,
    Construction,
    ExportError,
    Expr,
    Function,
    Number,
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Statement,
    Struct,
    Type,
    rebuilt,
    walk,
)
from gonio.export.values import Static
from gonio.lights.lookups import Lookups
from gonio.messages import did_you_mean
from gonio.model import Model
from gonio.parts import fresnel
from gonio.parts.distribution import ALPHA_MIN
from gonio.parts.frame import half_vector

Array = NDArray[np.float64]

FRESNEL, DISTRIBUTION = "fresnel", "distribution"
KINDS = (FRESNEL, DISTRIBUTION)
BITS = (8, 16)

# What functions call the cosine at which light meets a surface, and the square of its sine.
COSINE = ("cos_theta", "cos_h", "mu", "c")
SINE2 = ("sin2_h", "sin2")

# The host, by which lookups are told from other calls.
HOST = Static(Lookups())

# Where errors are measured: so many places between two entries; and facets, for D.
BETWEEN = 8
FACETS = 20_000

# Cosine that stands for the horizon, where some quotients have no value; and a difference from 1 likewise.
HORIZON = 1e-9
NEAR = 1e-6


@dataclass(frozen=True)
class Request:
    """Which functions become tables, and how these are stored."""

    kinds: tuple[str, ...]
    """Of KINDS."""
    bits: int = 16
    varying: frozenset[str] = frozenset()
    """Paths of parameters that textures or the mesh give, which no table can know."""
    places: int = PLACES
    """Sines, and widths, of D."""

    def __post_init__(self) -> None:
        """Refuse what there is not."""
        for kind in self.kinds:
            if kind not in KINDS:
                did = did_you_mean(kind, KINDS)
                raise ExportError(f"no table {kind!r}; {did}there are {', '.join(KINDS)}.")
        if self.bits not in BITS:
            raise ExportError(f"bits={self.bits} is out of range; allowed are 8 and 16.")


@dataclass(frozen=True)
class Table:
    """What a texture holds, and by how much it is off."""

    kind: str
    """Of KINDS."""
    codes: NDArray[Any]
    """Whole numbers of the chosen bits, the largest one is 1: (rows, cosines, 3) or (rows, sines)."""
    rows: tuple[str, ...]
    """What each row of F stands for; of D each block of as many rows as there are sines."""
    errors: tuple[float, ...]
    """Largest error of each, interpolated: of F itself; of D over its peak."""

    @property
    def bits(self) -> int:
        """Of a number."""
        return 8 * self.codes.dtype.itemsize

    @property
    def most(self) -> int:
        """The code of 1."""
        return int(np.iinfo(self.codes.dtype).max)

    @property
    def starts(self) -> list[int]:
        """The first row of each."""
        step = 1 if self.kind == FRESNEL else self.codes.shape[1]
        return [step * i for i in range(len(self.rows))]

    def meaning(self) -> list[str]:
        """What the rows are, for the text of a shader."""
        return [f"    row {row}: {name}" for row, name in zip(self.starts, self.rows, strict=True)]

    def said(self) -> list[str]:
        """Each row with its error, for people."""
        what = "" if self.kind == FRESNEL else " of its peak"
        return [
            f"{self.kind} row {row}, {name}: off by at most {error:.2g}{what}, {self.bits} bits"
            for row, name, error in zip(self.starts, self.rows, self.errors, strict=True)
        ]

    def look_up(self, place: Array, row: Array) -> Array:
        """Linear between entries, as a shader reads it; of F `place` is the cosine, of D it is u."""
        values = self.codes.astype(np.float64) / self.most
        last = values.shape[1] - 1
        at = np.clip(np.nan_to_num(np.asarray(place, np.float64)), 0, 1) * last
        left = np.minimum(at.astype(int), last - 1)
        row = np.clip(np.nan_to_num(np.asarray(row, np.float64)), 0, len(values) - 1)
        top = np.minimum(row.astype(int), max(len(values) - 2, 0))
        left, top, at, row = np.broadcast_arrays(left, top, at, row)
        s, t = at - left, row - top
        if values.ndim == 3:
            s, t = s[:, None], t[:, None]
        below = np.minimum(top + 1, len(values) - 1)
        upper = (1 - s) * values[top, left] + s * values[top, left + 1]
        lower = (1 - s) * values[below, left] + s * values[below, left + 1]
        return np.asarray((1 - t) * upper + t * lower)


@dataclass
class Tables:
    """The tables of an export."""

    request: Request
    fresnel: Table | None = None
    distribution: Table | None = None
    fixed: frozenset[str] = frozenset()
    """Paths of the parameters whose values are in F's rows; other values would need other rows."""
    left: tuple[str, ...] = ()
    """Functions that stayed, as their index changes from point to point, or depends on directions."""

    @property
    def all(self) -> tuple[Table, ...]:
        """Those that there are."""
        return tuple(t for t in (self.fresnel, self.distribution) if t is not None)

    def external(self) -> dict[str, Any]:
        """The lookups, for `Machine`."""
        return {f"{t.kind}_table": t.look_up for t in self.all}


def with_tables(
    reader: Reader,
    roots: Sequence[Struct],
    wanted: Sequence[Function],
    request: Request,
    lights: Sequence[Function] = (),
) -> Tables:
    """Change what `eval` and `shade` call, such that it looks up F and D; make the tables.

    Args:
        reader: whose list of functions gets those that look up.
        roots: the models' structs.
        wanted: all functions of these models that are exported; `eval` and `shade` are changed in place.
        request: which tables.
        lights: what `shade` adds up; changed in place as well.

    Raises:
        ExportError: nothing in these models could be looked up.
    """
    changed = [f for f in wanted if f.method == "eval"]
    changed += [*lights, *(f for f in wanted if f.method == "shade")]  # which call eval
    if not changed:
        raise ExportError("tables stand for functions that eval calls; export that as well.")
    fixed = _fixed(reader, changed, request)
    work = _Work(reader, request)
    for function in changed:
        work.change(function, _given(function, request.varying))
    for kind in request.kinds:
        if not (work.rows if kind == FRESNEL else work.blocks):
            names = " and ".join(dict.fromkeys(r.model.name for r in roots if r.model))
            raise ExportError(f"{names} {_missing(kind, work)}")
    _named(reader, work, [*wanted, *lights])
    return Tables(
        request,
        work.fresnel_table() if work.rows else None,
        work.distribution_table() if work.blocks else None,
        fixed,
        tuple(sorted(work.left)),
    )


def _given(function: Function, varying: frozenset[str]) -> list[Known]:
    """What is known of a model's function's arguments: the parameters."""
    assert function.owner is not None
    assert function.owner.model is not None
    known = _parameters(function.owner.model, varying)
    return [known if name == SELF else UNKNOWN for name, _ in function.parameters]


def _fixed(reader: Reader, wanted: Sequence[Function], request: Request) -> frozenset[str]:
    """The parameters that F's rows hold: if one of them were not known, there would be fewer rows."""
    if FRESNEL not in request.kinds:
        return frozenset()

    def rows(varying: frozenset[str]) -> set[str]:
        work = _Work(reader, replace(request, kinds=(FRESNEL,)))
        for function in wanted:
            work.change(replace(function), _given(function, varying))
        return {row.name for row in work.rows}

    every = rows(request.varying)
    owner = wanted[0].owner
    assert owner is not None
    assert owner.model is not None
    paths = [path for path, _, _ in owner.model.parameters()]
    return frozenset(p for p in paths if rows(request.varying | {p}) != every)


def _missing(kind: str, work: _Work) -> str:
    if kind == DISTRIBUTION:
        return (
            "has no distribution of facets with a width (gonio.parts.distribution) in eval, which a table "
            "could stand for; leave out --table distribution."
        )
    if work.left:
        return (
            f"has no Fresnel term whose index is known: {', '.join(sorted(work.left))} takes one that "
            "changes from point to point; leave out --table fresnel."
        )
    return (
        "has no Fresnel term (gonio.parts.fresnel) in eval, which a table could stand for; leave out "
        "--table fresnel."
    )


def _parameters(model: Model, varying: frozenset[str], prefix: str = "") -> dict[str, Known]:
    """The values of a model's parameters, inner models as dicts; UNKNOWN where they vary."""
    found: dict[str, Known] = {}
    for name in model.fields:
        value = getattr(model, name)
        if isinstance(value, Model):
            found[name] = _parameters(value, varying, f"{prefix}{name}.")
        elif isinstance(value, tuple):
            found[name] = np.asarray([value], np.float64)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            found[name] = np.full(1, value, np.float64)
        else:
            found[name] = UNKNOWN
        if f"{prefix}{name}" in varying:
            found[name] = UNKNOWN
    return found


@dataclass
class _Row:
    """F, or 1 - F, of one material, or one of the two."""

    function: Function
    index: tuple[Known, ...]
    member: str
    name: str

    def exact(self, cosines: Array) -> Array:
        """Shape (cosines, 3)."""
        c = np.maximum(cosines, HORIZON)
        given = []
        for name, _ in self.function.parameters[: _angles(self.function)]:
            given.append(c if name in COSINE else (1 - c) * (1 + c))
        made = Machine().call(self.function, [*given, *self.index])
        made = made[self.member] if self.member else made
        made = made[:, None] if made.ndim == 1 else made
        return np.asarray(np.broadcast_to(made, (len(c), 3)))


@dataclass
class _Work:
    """What is collected on the way."""

    reader: Reader
    request: Request
    rows: list[_Row] = field(default_factory=list)
    blocks: list[Function] = field(default_factory=list)
    left: set[str] = field(default_factory=set)
    made: dict[int, list[Function]] = field(default_factory=dict)
    """Copies that look up, by the function that they are copies of."""
    _done: dict[Any, Function] = field(default_factory=dict)
    _scales: dict[int, float] = field(default_factory=dict)

    def change(self, function: Function, given: Sequence[Known]) -> list[Any]:
        """Put lookups into a function's body; returns what it calls now, for telling copies apart."""
        picked: list[Any] = []
        names = [name for name, _ in function.parameters]
        values: dict[str, Known] = dict(zip(names, given, strict=True))
        machine = Machine()

        def changed(expr: Expr) -> Expr:
            new = rebuilt(expr, changed)
            if not isinstance(expr, Call) or not isinstance(new, Call):
                return new
            return self._call(new, [machine.value(a, values) for a in expr.arguments], picked)

        def statement(found: Statement) -> Statement:
            if isinstance(found, Repeat):
                for name in (found.variable, *_assigned(found.body)):
                    values[name] = UNKNOWN
                body = tuple(statement(s) for s in found.body)
                for name in _assigned(found.body):
                    values[name] = UNKNOWN
                return replace(found, body=body)
            if isinstance(found, ReturnIf):
                return replace(
                    found, condition=changed(found.condition), value=changed(found.value)
                )
            if isinstance(found, (Assign, SetMember, Return)):
                new = replace(found, value=changed(found.value))
                if not isinstance(found, Return):
                    machine.statement(found, values)
                return new
            return found

        function.body = tuple(statement(s) for s in function.body)
        return picked

    def _call(self, call: Call, given: Sequence[Known], picked: list[Any]) -> Expr:
        function = call.function
        if FRESNEL in self.request.kinds and (angles := _angles(function, self.reader)):
            return self._looked_up_F(call, given, angles, picked)
        if DISTRIBUTION in self.request.kinds and (widths := _widths(function, self.reader)):
            return self._looked_up_D(call, widths, picked)
        if function.external:
            return call
        copy = self._copy(function, given)
        if copy is not function:
            picked.append(id(copy))
        return replace(call, function=copy)

    def _copy(self, function: Function, given: Sequence[Known]) -> Function:
        """A function as it looks up for what is known of its arguments; itself if it looks up nothing."""
        key = (id(function), *(_mark(value) for value in given))
        if key not in self._done:
            copy = replace(function)
            picked = self.change(copy, given)
            same = (id(function), *picked)
            if not picked:
                self._done[key] = function
            else:
                if same not in self._done:
                    self._done[same] = copy
                    self.made.setdefault(id(function), []).append(copy)
                self._done[key] = self._done[same]
        return self._done[key]

    # --- F -------------------------------------------------------------------------------------------

    def _looked_up_F(
        self, call: Call, given: Sequence[Known], angles: int, picked: list[Any]
    ) -> Expr:
        function = call.function
        index = tuple(given[angles:])
        if any(value is UNKNOWN for value in index):
            self.left.add(function.plain)
            return call
        cosine = call.arguments[0]
        if not isinstance(function.result, Struct):
            return self._row(function, index, "", cosine, function.result, picked)
        parts = [
            self._row(function, index, member.name, cosine, member.type, picked)
            for member in function.result.members
        ]
        return Construction(tuple(parts), function.result)

    def _row(
        self,
        function: Function,
        index: tuple[Known, ...],
        member: str,
        cosine: Expr,
        kind: Type,
        picked: list[Any],
    ) -> Expr:
        name = _spoken(function, index, member)
        number = next((i for i, row in enumerate(self.rows) if row.name == name), len(self.rows))
        if number == len(self.rows):
            self.rows.append(_Row(function, index, member, name))
        picked.append(("F", number))
        lookup = self.reader.lookup(vars(Lookups)["fresnel_table"])
        found = Call(lookup, (cosine, Number(number)), "vec3")
        return Access(found, "x", "float") if kind == "float" else found

    def fresnel_table(self) -> Table:
        """All rows of F."""
        cosines = np.linspace(0, 1, COSINES)
        exact = np.stack([row.exact(cosines) for row in self.rows])
        table = Table(FRESNEL, _codes(exact, self.request.bits), (), ())
        fine = np.linspace(0, 1, BETWEEN * (COSINES - 1) + 1)
        errors = [
            float(np.abs(table.look_up(fine, np.full(1, i)) - row.exact(fine)).max())
            for i, row in enumerate(self.rows)
        ]
        return replace(table, rows=tuple(row.name for row in self.rows), errors=tuple(errors))

    # --- D -------------------------------------------------------------------------------------------

    def _looked_up_D(self, call: Call, widths: Sequence[str], picked: list[Any]) -> Expr:
        function = call.function
        if not any(function is block for block in self.blocks):
            self.blocks.append(function)
        number = next(i for i, block in enumerate(self.blocks) if block is function)
        picked.append(("D", number))
        made = self._tabled_D(len(widths))
        facets, m = call.arguments
        alphas = [Access(facets, name, "float") for name in widths]
        numbers = [Number(v) for v in self._numbers(number)]
        where = m if len(widths) > 1 else self._facet_sin2(m)
        return Call(made, (where, *alphas, *numbers), "float")

    def _facet_sin2(self, m: Expr) -> Expr:
        """Of a facet's normal; without making it unit where it is a half vector."""
        if isinstance(m, Call) and self.reader.origin(m.function) is half_vector:
            return self._own(table_facets.half_vector_sin2, m.arguments)
        return self._own(table_facets.facet_sin2, (m,))

    def _own(self, written: Any, vectors: Sequence[Expr]) -> Expr:
        return Call(
            self.reader.function_for(written, ["vec3"] * len(vectors)), tuple(vectors), "float"
        )

    def _tabled_D(self, widths: int) -> Function:
        written = table_facets.tabled_D if widths == 1 else table_facets.tabled_D_anisotropic
        kinds: list[Type | Static] = ["float" if widths == 1 else "vec3"]
        kinds += ["float"] * (widths + 3)
        return self.reader.function_for(cast(types.FunctionType, written), [*kinds, HOST])

    def _numbers(self, number: int) -> tuple[float, ...]:
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
        q = axis / np.maximum(1 - axis, NEAR * NEAR)
        alpha, sine = np.broadcast_arrays(alpha, np.minimum(alpha * np.sqrt(q), 1))
        shape = alpha.shape
        alpha, sine = alpha.ravel(), sine.ravel()
        m = np.stack([sine, 0 * sine, np.sqrt((1 - sine) * (1 + sine))], -1)
        widths = _widths(block, self.reader)
        D = Machine().call(block, [dict.fromkeys(widths, alpha), m])
        return np.asarray(np.pi * alpha * alpha * D).reshape(shape)

    def distribution_table(self) -> Table:
        """The blocks of all kinds of facets."""
        made = [np.sqrt(self._over_round_peak(b) / self._scale(b)) for b in self.blocks]
        table = Table(DISTRIBUTION, _codes(np.concatenate(made), self.request.bits), (), ())
        errors = [self._error(table, number) for number in range(len(self.blocks))]
        return replace(table, rows=tuple(b.plain for b in self.blocks), errors=tuple(errors))

    def _error(self, table: Table, number: int) -> float:
        """Largest error of D over its peak, at random facets and widths."""
        block = self.blocks[number]
        names = _widths(block, self.reader)
        rng = np.random.default_rng(7)
        low = np.log(ALPHA_MIN)
        widths = [np.exp(low * rng.random(FACETS)) for _ in names]
        if len(names) == 2:  # as wide along y as anisotropy makes them
            widths[1] = np.clip(widths[0] * rng.uniform(0.1, 10, FACETS), ALPHA_MIN, 1)
        sine = np.minimum(widths[0] * np.exp(rng.uniform(-4, 4, FACETS)), 1)
        phi = 2 * np.pi * rng.random(FACETS)
        m = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine * sine)], -1)
        exact = Machine().call(block, [dict(zip(names, widths, strict=True)), m])
        machine = Machine({"distribution_table": table.look_up})
        numbers = [np.full(1, v, np.float64) for v in self._numbers(number)]
        where = m if len(names) == 2 else sine * sine
        found = machine.call(self._tabled_D(len(names)), [where, *widths, *numbers])
        peak = 1 / (np.pi * widths[0] * widths[-1])
        return float(np.max(np.abs(found - exact) / peak))


def _codes(values: Array, bits: int) -> NDArray[Any]:
    kind = np.uint8 if bits == 8 else np.uint16
    return np.rint(np.clip(values, 0, 1) * np.iinfo(kind).max).astype(kind)


# --- which functions -------------------------------------------------------------------------------------


def _angles(function: Function, reader: Reader | None = None) -> int:
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


def _widths(function: Function, reader: Reader) -> tuple[str, ...]:
    """The widths of the facets whose D a function is; none of other functions."""
    origin = reader.origin(function)
    if origin is None or origin.__name__ not in ("D", "D_narrow") or len(function.parameters) != 2:
        return ()
    kind = function.parameters[0][1]
    if not isinstance(kind, Struct) or kind.python is None or kind.fixed:
        return ()
    names = tuple(member.name for member in kind.members)
    return names if names in (("alpha",), ("alpha_x", "alpha_y")) else ()


def _spoken(function: Function, index: Sequence[Known], member: str) -> str:
    """A row's name: the function, and the material."""
    names = [name for name, _ in function.parameters[_angles(function) :]]
    said = [f"{name}={_number(value)}" for name, value in zip(names, index, strict=True)]
    return f"{function.plain}({', '.join(said)}){'.' + member if member else ''}"


def _number(value: Known) -> str:
    numbers = [f"{v:.7g}" for v in np.ravel(value)]
    return numbers[0] if len(set(numbers)) == 1 else "/".join(numbers)


def _mark(value: Known) -> Any:
    """What tells known values apart."""
    if value is UNKNOWN:
        return None
    if isinstance(value, dict):
        return tuple((name, _mark(part)) for name, part in value.items())
    return np.asarray(value).tobytes()


def _assigned(statements: Iterable[Statement]) -> list[str]:
    found: list[str] = []
    for statement in statements:
        if isinstance(statement, Assign):
            found.append(statement.name)
        elif isinstance(statement, SetMember):
            found.append(statement.variable)
        elif isinstance(statement, Repeat):
            found += [statement.variable, *_assigned(statement.body)]
    return found


def _named(reader: Reader, work: _Work, wanted: Sequence[Function]) -> None:
    """Put copies behind what they are copies of, under names that no other function has."""
    looked_up = [
        f
        for f in reader.functions
        if (origin := reader.origin(f)) is not None and origin.__module__ == table_facets.__name__
    ]
    used = _reached(wanted)
    placed: list[Function] = list(looked_up)
    taken = {f.name for f in reader.functions}
    for function in reader.functions:
        if function in looked_up:
            continue
        placed.append(function)
        left = id(function) in used
        for copy in work.made.get(id(function), []):
            if left:  # else the copy takes the name over
                ends = (f"_tabled{'' if i == 1 else f'_{i}'}" for i in range(1, 1000))
                end = next(e for e in ends if f"{function.name}{e}" not in taken)
                copy.name = f"{function.name}{end}"
                copy.method = f"{function.method.strip('_')}{end}" if function.method else ""
                taken.add(copy.name)
            left = True
            placed.append(copy)
    reader.functions[:] = placed


def _reached(wanted: Iterable[Function]) -> set[int]:
    found: set[int] = set()
    todo = list(wanted)
    while todo:
        function = todo.pop()
        if id(function) not in found:
            found.add(id(function))
            todo += [e.function for e in walk(function.body) if isinstance(e, Call)]
    return found
