"""Arguments of calls: in the order of the function's own, with their types; and the function for these."""

from __future__ import annotations

import ast
import inspect
import types
from collections.abc import Sequence
from typing import Any

from gonio.export import library
from gonio.export.operators import Operators
from gonio.export.tree import Expr, Struct, Type, Variable, inside
from gonio.export.values import Changed, Static, Value, exact, is_number, shown_kind


class Arguments(Operators):
    """Reads what calls pass."""

    def _arguments(self, node: ast.Call, function: Any, skip: int) -> list[tuple[ast.expr, Value]]:
        """The arguments of a call in the order of the function's own; `skip` of them are given already."""
        for argument in node.args:
            if isinstance(argument, ast.Starred):
                self.refuse(argument, "name each argument.")
        for keyword in node.keywords:
            if keyword.arg is None:
                self.refuse(keyword.value, "name each argument.")
        signature = inspect.signature(function, follow_wrapped=False)
        parameters = list(signature.parameters.values())[skip:]
        names = ", ".join(p.name for p in parameters) or "none"
        if any(p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in parameters):
            self.refuse(node, "*args and **kwargs have no meaning in a shader; name each one.")
        if len(node.args) > sum(p.kind is not p.KEYWORD_ONLY for p in parameters):
            self.refuse(node, f"{len(parameters)} arguments are expected: {names}.")
        named = {str(k.arg): k.value for k in node.keywords}
        try:
            bound = signature.replace(parameters=parameters).bind(*node.args, **named).arguments
        except TypeError as error:
            text = str(error).removeprefix("missing a required argument: ")
            wrong = f"{text} missing" if text != str(error) else text
            self.refuse(node, f"{wrong}; the arguments are {names}.")
        found: list[tuple[ast.expr, Value]] = []
        for parameter in parameters:
            if parameter.name in bound:
                argument = bound[parameter.name]
                found.append((argument, self.value(argument)))
            elif is_number(parameter.default):
                found.append((node, self._number(node, parameter.default)))
            else:
                found.append((node, Static(parameter.default)))
        return found

    def _typed(
        self, arguments: list[tuple[ast.expr, Value]]
    ) -> tuple[list[Expr], list[Type | Static]]:
        """Arguments that are passed, and what a function is specialised for."""
        passed: list[Expr] = []
        kinds: list[Type | Static] = []
        for node, value in arguments:
            if isinstance(value, Static) and not is_number(value.value):
                try:
                    hash(value)
                except TypeError:
                    self.refuse(node, f"{shown_kind(value.value)} cannot be passed in a shader.")
                kinds.append(value)
                continue
            expr = self._expr(node, value)
            if isinstance(expr, Changed):
                self.refuse(node, "give the changed model a name first: rougher = ...")
            passed.append(expr)
            kinds.append(expr.type)
        return passed, kinds

    def _made(
        self,
        node: ast.AST,
        function: types.FunctionType,
        kinds: Sequence[Type | Static],
        owner: Struct | None,
        method: str,
        guarded: bool,
        passed: Sequence[Expr],
    ) -> Any:
        """The exported function, unless it would call itself or takes its exponent from here."""
        if self.reader.is_open(function, kinds, owner):
            self.refuse(
                node,
                f"{function.__name__} calls itself, which shading languages do not allow; write a loop "
                "over a fixed number of steps.",
            )
        made = self.reader.function_for(function, kinds, owner, method, guarded)
        for i in made.exponents:
            self._exponent(node, passed[i])
        return made

    def _exponent(self, node: ast.AST, exponent: Expr) -> None:
        """Take note of an exponent that may be a plain number in Python, for which it has products."""
        names = {e.name for e in inside(exponent) if isinstance(e, Variable)}
        arguments = {n for n in names if n in self.arguments}
        self.exponents |= arguments
        known = exact(exponent)
        plain = bool(names & self.plain) and not (names - self.plain)
        if plain or (known is not None and known == int(known)):
            self.refuse(
                node,
                "this exponent is a whole number in Python, which allows negative bases, and a variable in "
                "a shader, which does not; write it where power is called, or multiply in the loop.",
            )

    @staticmethod
    def _is_ours(function: types.FunctionType) -> bool:
        """Whether it is a function of gonio's parts, or of the model's own files."""
        package = function.__module__.partition(".")[0]
        path = function.__code__.co_filename
        if package == "gonio":
            return (
                ".parts." in function.__module__
                or ".models." in function.__module__
                or ".lights." in function.__module__
                or ".measured." in function.__module__
                or (function.__module__ == library.__name__)
            )
        return "site-packages" not in path and "/lib/python" not in path and "<frozen" not in path
