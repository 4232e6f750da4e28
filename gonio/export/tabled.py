"""Exports that look F and D up in tables: which calls change, and how.

The index of a material is known when it is exported, so F of each surface in it is a row over the cosine; D
is a table over the facet's angle and the width for each kind of facets. What `eval` and the lights call is
looked up. `sample` and `pdf` keep the functions, as a sampler's density has to be that of its samples, and
so does an `albedo` in closed form.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3.1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gonio.export import by_row, table_facets
from gonio.export.coded import DISTRIBUTION, FRESNEL, Request, Tables
from gonio.export.evaluate import UNKNOWN, Known, Machine
from gonio.export.read import Reader
from gonio.export.stand_ins import ALONG
from gonio.export.table_rows import (
    Distributions,
    FresnelRow,
    angles_of,
    fresnel_table,
    row_name,
    widths_of,
)
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
    Operation,
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Statement,
    Struct,
    Type,
    Variable,
    rebuilt,
    walk,
)
from gonio.fields import Parameter
from gonio.lights.lookups import Lookups
from gonio.model import Model
from gonio.parts.frame import half_vector, slopes


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
    if request.materials:
        by_row.check(request, [f.method for f in wanted])
    fixed = _fixed(reader, changed, request)
    work = _Work(reader, request)
    for function in changed:
        work.change(function, _given(function, request), root=True)
    for kind in request.kinds:
        if not (work.rows if kind == FRESNEL else work.facets.blocks):
            names = " and ".join(dict.fromkeys(r.model.name for r in roots if r.model))
            raise ExportError(f"{names} {_missing(kind, work)}")
    _named(reader, work, [*wanted, *lights])
    return Tables(
        request,
        reader.prefix,
        fresnel_table(work.rows, request.bits) if work.rows else None,
        work.facets.table() if work.facets.blocks else None,
        fixed,
        tuple(sorted(work.left)),
    )


def _given(function: Function, request: Request) -> list[Known]:
    """What is known of a model's function's arguments: the parameters, of all materials."""
    assert function.owner is not None
    assert function.owner.model is not None
    known = _parameters(function.owner.model, request.varying)
    if request.materials:
        known = by_row.of_all([_parameters(m, request.varying) for _, m in request.materials])
    return [known if name == SELF else UNKNOWN for name, _ in function.parameters]


def _fixed(reader: Reader, wanted: Sequence[Function], request: Request) -> frozenset[str]:
    """The parameters that F's rows hold: if one of them were not known, there would be fewer rows."""
    if FRESNEL not in request.kinds:
        return frozenset()

    def rows(varying: frozenset[str]) -> set[str]:
        work = _Work(reader, replace(request, kinds=(FRESNEL,)))
        for function in wanted:
            given = _given(function, replace(request, varying=varying))
            work.change(replace(function), given, root=True)
        return {row.name for row in work.rows}

    every = rows(request.varying)
    owners = {f.owner for f in wanted}
    models = [owner.model for owner in owners if owner is not None and owner.model is not None]
    paths = {path for model in models for path, _, _ in model.parameters()}
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
    for name, declared in model.fields.items():
        value = getattr(model, name)
        if isinstance(value, Model):
            found[name] = _parameters(value, varying, f"{prefix}{name}.")
        elif isinstance(value, (int, float, tuple)) and isinstance(declared, Parameter):
            shape = (1, 3) if declared.width == 3 else (1,)
            found[name] = np.broadcast_to(np.asarray(value, np.float64), shape)
        else:
            found[name] = UNKNOWN
        if f"{prefix}{name}" in varying:
            found[name] = UNKNOWN
    return found


@dataclass
class _Picked:
    """What a function looks up."""

    row: Variable
    """What it calls the row, where a parameter chooses that."""
    what: list[Any] = field(default_factory=list)
    """Tables, and copies of functions: what tells copies of this one apart."""
    chosen: bool = False
    """Whether it needs the row."""


@dataclass
class _Work:
    """What is collected on the way."""

    reader: Reader
    request: Request
    rows: list[FresnelRow] = field(default_factory=list)
    left: set[str] = field(default_factory=set)
    made: dict[int, list[Function]] = field(default_factory=dict)
    """Copies that look up, by the function that they are copies of."""
    _done: dict[Any, Function] = field(default_factory=dict)
    _chosen: dict[int, Function] = field(default_factory=dict)
    """Copies that have the row as their last argument."""

    def __post_init__(self) -> None:
        """Begin without any facets."""
        self.facets = Distributions(self.reader, self.request)

    def change(
        self, function: Function, given: Sequence[Known], *, root: bool = False
    ) -> list[Any]:
        """Put lookups into a function's body; returns what it calls now, for telling copies apart.

        `root`: of those that are changed in place, and have the model's parameters.
        """
        names = [name for name, _ in function.parameters]
        picked = _Picked(_unused([*names, *_assigned(function.body)]))
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
        if picked.chosen:
            self._let_in(function, picked.row, root)
        return picked.what

    def _let_in(self, function: Function, row: Variable, root: bool) -> None:
        """Give a function the row: from the parameters of the model, or as its last argument."""
        if root:
            nearest: Any = table_facets.nearest_row
            read = self.reader.function_for(nearest, ["float", "float"])
            by_row.begin(function, row, read, len(self.request.materials))
        else:
            function.parameters = (*function.parameters, (row.name, "float"))
            self._chosen[id(function)] = function

    def _call(self, call: Call, given: Sequence[Known], picked: _Picked) -> Expr:
        function = call.function
        if FRESNEL in self.request.kinds and (angles := angles_of(function, self.reader)):
            return self._looked_up_F(call, given, angles, picked)
        if DISTRIBUTION in self.request.kinds and (widths := widths_of(function, self.reader)):
            return self._looked_up_D(call, widths, picked)
        if function.external:
            return call
        copy = self._copy(function, given)
        if copy is function:
            return call
        picked.what.append(id(copy))
        if id(copy) not in self._chosen:
            return replace(call, function=copy)
        picked.chosen = True
        return replace(call, function=copy, arguments=(*call.arguments, picked.row))

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
        self, call: Call, given: Sequence[Known], angles: int, picked: _Picked
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
        picked: _Picked,
    ) -> Expr:
        made = self._rows_of(function, index, member)
        step, names = len(made), [row.name for row in made]
        known = (
            [row.name for row in self.rows[i : i + step]] for i in range(0, len(self.rows), step)
        )
        number = step * next(
            (i for i, old in enumerate(known) if old == names), len(self.rows) // step
        )
        if number == len(self.rows):
            self.rows += made
        picked.what.append(("F", number))
        row: Expr = Number(number)
        if self.request.materials:
            row = Operation("+", picked.row, row, "float") if number else picked.row
            picked.chosen = True
        lookup = self.reader.lookup(vars(Lookups)["fresnel_table"])
        found = Call(lookup, (cosine, row), "vec3")
        return Access(found, "x", "float") if kind == "float" else found

    def _rows_of(
        self, function: Function, index: tuple[Known, ...], member: str
    ) -> list[FresnelRow]:
        """The row of one place that looks F up; with materials to choose among, one for each of them."""
        if not self.request.materials:
            return [FresnelRow(function, index, member, row_name(function, index, member))]
        made = []
        for number, (material, _) in enumerate(self.request.materials):
            own = by_row.of_one(index, number)
            name = f"{material}: {row_name(function, own, member)}"
            made.append(FresnelRow(function, own, member, name))
        return made

    # --- D -------------------------------------------------------------------------------------------

    def _looked_up_D(self, call: Call, widths: Sequence[str], picked: _Picked) -> Expr:
        function = call.function
        if not any(function is block for block in self.facets.blocks):
            self.facets.blocks.append(function)
        number = next(i for i, block in enumerate(self.facets.blocks) if block is function)
        picked.what.append(("D", number))
        made = self.facets.lookup(len(widths))
        facets, m = call.arguments
        alphas = [Access(facets, name, "float") for name in widths]
        numbers = [Number(v) for v in self.facets.numbers(number)]
        along = function.plain.endswith(ALONG)  # a vector that need not be unit
        if isinstance(m, Call) and self.reader.origin(m.function) is half_vector:
            wi, wo = m.arguments
            m, along = Operation("+", wi, wo, "vec3"), True
        if len(widths) == 1:
            where = self._own(table_facets.tilt_along if along else table_facets.tilt, m)
        else:
            where = self._own(slopes if along else table_facets.facet_slopes, m)
        return Call(made, (where, *alphas, *numbers), "float")

    def _own(self, written: Any, vector: Expr) -> Expr:
        function = self.reader.function_for(written, ["vec3"])
        return Call(function, (vector,), function.result)


def _unused(names: Sequence[str]) -> Variable:
    """A number that none of the names stands for."""
    own = (by_row.ROW, *(f"{by_row.ROW}_{i}" for i in range(2, 1000)))
    return Variable(next(name for name in own if name not in names), "float")


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
    lookups = [
        f
        for f in reader.functions
        if (origin := reader.origin(f)) is not None and origin.__module__ == table_facets.__name__
    ]
    called = _reached(lookups)
    looked_up = [f for f in reader.functions if id(f) in called]
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
