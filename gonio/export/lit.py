"""A whole material function: a model with the light on it, in one text.

    from gonio.export.lit import export_lit
    made = export_lit(gonio.model("ue4"), "ue4", ["directional", "image"], "wgsl")
    made.source, made.entry

`shade` takes a normal, a tangent and directions in the world, and gives the radiance towards the viewer.
"""

from __future__ import annotations

import types
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast, get_type_hints

from gonio.export.coded import Request
from gonio.export.entry import Export, Given
from gonio.export.names import legal
from gonio.export.printer import Printer
from gonio.export.read import Reader
from gonio.export.tabled import with_tables
from gonio.export.targets import Target
from gonio.export.text import (
    FUNCTIONS,
    Text,
    check_lookups,
    check_prefixes,
    supply_of,
    target_named,
)
from gonio.export.tidy import tidy
from gonio.export.tree import (
    SELF,
    Assign,
    Call,
    ExportError,
    Expr,
    Function,
    Operation,
    Return,
    Statement,
    Struct,
    Type,
    Variable,
)
from gonio.export.values import Static
from gonio.lights import frames
from gonio.lights.catalogue import COMMON, Chosen, chosen
from gonio.lights.lookups import Lookups
from gonio.model import Model

# What shade takes of the point, before what its lights take.
POINT = ("normal", "tangent", "view")

# Helpers that every lit export has besides.
HELPERS = (frames.mapped_normal, frames.world_flake_normal)


def export_lit(
    model: Model,
    name: str,
    lights: Sequence[str],
    to: str | Target,
    *,
    only: Sequence[str] = ("eval",),
    prefix: str | None = None,
    embed: bool = False,
    tables: Request | None = None,
    lookups: str = "textures",
) -> Export:
    """Source code of a model with the light on it, in one language.

    Args:
        model: with its options.
        name: that its functions begin with.
        lights: of `gonio.lights`, with their choices: "directional", "harmonics:dc=cheap".
        to: the language, or a table of your own.
        only: which of the model's own functions stand in the text as well.
        prefix: of what is not the model's own; by default its name.
        embed: also write a function that gives the parameters the model has.
        tables: which functions of the model are looked up in tables (`gonio.export.tabled`).
        lookups: with "textures"; or "host": it defines them; or "array": tables of F and D stand in the
            text as arrays.

    Raises:
        ExportError: what cannot be exported, an unknown language or choice.
        ModelError: a light that is not there, or that the model cannot have.
    """
    target = to if isinstance(to, Target) else target_named(to)
    if target.shader:
        raise ExportError(
            f"{target.title} has no --lit: its surfaces return closures, and the renderer lights them; "
            "export the model without --lit, and scale a closure by its values."
        )
    target = check_lookups(target, tables, lookups)
    for function in only:
        if function not in FUNCTIONS:
            raise ExportError(f"no function {function!r}; there are {', '.join(FUNCTIONS)}.")
    taken = chosen(model, lights)
    check_prefixes([name, *([prefix] if prefix else [])])
    name = legal(name).rstrip("_")
    shared = legal(prefix or name).rstrip("_")
    reader = Reader(shared, target.library, [name], differentiable=bool(target.attribute))
    root = reader.model(model, name, title=name)
    wanted = [reader.method(root, f) for f in FUNCTIONS if f in only]
    shade = read_shade(reader, root, taken)
    helpers = [_helper(reader, function) for function in HELPERS]
    made = None
    if tables is not None:
        every = [*wanted, shade.function]
        made = with_tables(reader, [root], every, tables, shade.lights)
    functions = tidy(
        reader.functions,
        [*wanted, *shade.lights, shade.function, *helpers],
        reader.sample,
        target.methods,
    )
    text = _LitText(
        target,
        shared,
        reader,
        functions,
        [root],
        [*wanted, shade.function],
        embed,
        supply_of(lookups, made),
    )
    entry = replace(
        text.entry(root, [*(f for f in FUNCTIONS if f in only), "shade"]),
        given=tuple(_described(text.printer, n, k) for n, k in shade.given),
        lights=tuple(lights),
        **text.supplied(),
    )
    return Export(target.name, text.source, entry, buffer=text.buffer, tables=made)


@dataclass(frozen=True)
class Shade:
    """The function `shade`."""

    function: Function
    lights: list[Function]
    """What it adds up."""
    given: list[tuple[str, Type]]
    """What it takes for them."""


def read_shade(reader: Reader, root: Struct, taken: Sequence[Chosen]) -> Shade:
    """Read the lights, and make the function that adds them up."""
    assert root.model is not None
    follows = root.model.follows_tangents()
    kind = frames.Frame if follows else frames.NormalFrame
    frame_of = _helper(reader, frames.surface_frame if follows else frames.normal_frame)
    frame = frame_of.result
    to_local = reader.function_for(cast(types.FunctionType, kind.to_local), [frame, "vec3"])
    arguments: dict[str, Type] = {}
    parts: list[tuple[Function, list[str]]] = []
    for light in taken:
        own = {n: reader.of_annotation(k) for n, k in light.form.arguments.items()}
        arguments |= own
        given: list[Type | Static] = [frame, "vec3"]
        given += _given(light, own)
        made = reader.function_for(light.form.function, given, owner=root)
        parts.append((made, list(own)))
    first = [Variable(SELF, root), Variable("frame", frame), Variable("wo", "vec3")]
    calls: list[Expr] = [
        Call(f, (*first, *(Variable(n, arguments[n]) for n in own)), f.result) for f, own in parts
    ]
    total = calls[0]
    for call in calls[1:]:
        total = Operation("+", total, call, "vec3")
    normal, tangent, view = (Variable(n, "vec3") for n in POINT)
    axes = (normal, tangent) if follows else (normal,)
    body: tuple[Statement, ...] = (
        Assign("frame", Call(frame_of, axes, frame)),
        Assign("wo", Call(to_local, (Variable("frame", frame), view), "vec3")),
        Return(total),
    )
    doc = (
        "Radiance towards the viewer, linear RGB.",
        "",
        "normal, tangent: as the mesh has them, in the world; view: towards the viewer, unit.",
        *([] if follows else ["The tangent changes nothing of this model."]),
        *_argument_docs(taken),
    )
    point: list[tuple[str, Type]] = [(n, "vec3") for n in POINT]
    parameters: tuple[tuple[str, Type], ...] = ((SELF, root), *point, *arguments.items())
    name = f"{root.prefix}_shade"
    function = Function(name, doc, parameters, "vec3", body, root, "shade", "shade")
    reader.functions.append(function)
    return Shade(function, [f for f, _ in parts], list(arguments.items()))


def _given(light: Chosen, own: Mapping[str, Type]) -> list[Type | Static]:
    """Types of a light's own arguments; what it looks up and what was chosen is known now."""
    found: list[Type | Static] = []
    code = light.form.function.__code__
    for name in code.co_varnames[COMMON : code.co_argcount + code.co_kwonlyargcount]:
        if name in own:
            found.append(own[name])
        else:
            found.append(Static(light.choices[name] if name in light.choices else Lookups()))
    return found


def _argument_docs(taken: Sequence[Chosen]) -> list[str]:
    """What the lights' docstrings say of their arguments, each sentence once."""
    said: dict[str, None] = {}
    for light in taken:
        paragraphs = (light.form.function.__doc__ or "").split("\n\n")[1:]
        for paragraph in paragraphs:
            said[" ".join(paragraph.split())] = None
    return list(said)


def _described(printer: Printer, name: str, kind: Type) -> Given:
    if isinstance(kind, Struct):
        members = tuple(printer.member(kind, m.name) for m in kind.members)
        return Given(name, 3 * len(members), kind.name, members)
    return Given(name, 1 if kind == "float" else 3)


def _helper(reader: Reader, function: Any) -> Function:
    hints = get_type_hints(function, include_extras=True)
    del hints["return"]
    return reader.function_for(function, [reader.of_annotation(kind) for kind in hints.values()])


class _LitText(Text):
    """The text of a lit export."""

    def _purposes(self) -> dict[int, str]:
        found = super()._purposes()
        return {id(f): "light" for f in self.functions} | found

    def _usage(self) -> list[str]:
        root, shade = self.roots[0], self.wanted[-1]
        made = self.target.uninitialized.format(type=root.name, name=SELF)
        scope = f"{self.namespace}::" if self.target.constants_in_file else ""
        arguments = ", ".join(n for n, _ in shade.parameters[1:])
        call = f"{scope}{shade.name}({SELF}, {arguments})"
        if self.target.methods:
            call = f"{SELF}.shade({arguments})"
        return [f"// Usage: {scope}{made} ... {call}"]

    def _conventions(self) -> list[str]:
        return [
            *super()._conventions(),
            "shade gives the radiance towards the viewer; its normal and directions are in the world.",
        ]
