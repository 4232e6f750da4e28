"""Structs of a user's own, and calls of their methods."""

from __future__ import annotations

import ast
import inspect
import types
from typing import Any, cast

from gonio import lang
from gonio.export import records
from gonio.export.arguments import Arguments
from gonio.export.stand_ins import ALONG
from gonio.export.tree import Call, Construction, Expr, Operation, Struct, Type
from gonio.export.values import Changed, Method, Static, is_number
from gonio.parts.frame import half_vector

# What annotations of members mean.
ANNOTATED: dict[Any, Type] = {
    lang.Vec2: "vec2",
    lang.Vec3: "vec3",
    lang.Color: "vec3",
}


class RecordCalls(Arguments):
    """Reads what makes NamedTuples and dataclasses, and calls of their methods."""

    def _record(self, node: ast.Call, cls: Any) -> Expr:
        """A NamedTuple or dataclass from its members."""
        wrong = records.defect(cls)
        if wrong:
            self.refuse(node, wrong)
        names = records.members(cls) or ()
        for name in (cls.__name__, *names):
            self._check_spelling(node, name)
        arguments = self._arguments(node, records.maker(cls), 1)
        hints = inspect.get_annotations(cls, eval_str=True)
        if cls is lang.Sample:
            (at_wi, wi), (at_pdf, pdf) = arguments
            wi, pdf = self._expr(at_wi, wi), self._expr(at_pdf, pdf)
            parts = (self._coerce(node, wi, "vec3"), self._coerce(node, pdf, "float"))
            return Construction(parts, self.reader.sample)
        values: list[Expr] = []
        given: list[Type | Static] = []
        for name, (at, value) in zip(names, arguments, strict=True):
            if isinstance(value, Static) and not is_number(value.value):
                given.append(value)
                continue
            expr = self._expr(at, value)
            wanted = ANNOTATED.get(hints.get(name))
            if wanted is not None:
                expr = self._coerce(at, expr, wanted)
            if isinstance(expr, Changed):
                self.refuse(at, "give the changed model a name first: rougher = ...")
            values.append(expr)
            given.append(expr.type)
        if not values:
            self.refuse(
                node, f"{cls.__name__} has no value in a shader; give it a number or vector."
            )
        return Construction(tuple(values), self.reader.record(cls, tuple(given)))

    def _record_method(self, node: ast.Call, method: Method) -> Expr:
        """A method of such a class: a function that takes its struct first."""
        if not self._is_ours(method.function) or hasattr(method.function, "__wrapped__"):
            self.refuse(node, f"{method.name!r} is no plain method; write one, or a function.")
        passed, kinds = self._typed(self._arguments(node, method.function, 1))
        function = self._along(method)
        if function is not None and len(passed) == 1 and self._is_half_vector(passed[0]):
            wi, wo = cast(Call, passed[0]).arguments
            passed = [Operation("+", wi, wo, "vec3")]
        else:
            function = method.function
        given = (method.model, *passed)
        kinds = [method.model.type, *kinds]
        return self._called(node, function, kinds, given)

    def _record_property(self, node: ast.Attribute, value: Expr, found: property) -> Expr:
        """A property of such a class: a function that takes its struct."""
        function = found.fget
        if not isinstance(function, types.FunctionType) or not self._is_ours(function):
            self.refuse(node, f"the property {node.attr!r} is no plain function; write a method.")
        return self._called(node, function, [value.type], [value])

    def _along(self, method: Method) -> types.FunctionType | None:
        """The method of the same name that takes a vector of any length: D_along for D.

        Not where derivatives are taken, which leave single precision on the way for the shortest vectors.
        """
        kind = method.model.type
        assert isinstance(kind, Struct)
        found = vars(kind.python).get(f"{method.name}{ALONG}") if kind.python else None
        plain = isinstance(found, types.FunctionType) and not self.reader.differentiable
        return found if plain else None

    def _is_half_vector(self, expr: Expr) -> bool:
        return isinstance(expr, Call) and self.reader.origin(expr.function) is half_vector
