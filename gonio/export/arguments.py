"""Arguments of calls: in the order of the function's own, with their types; and the function for these."""

from __future__ import annotations

import ast
import inspect
import types
from collections.abc import Mapping, Sequence
from typing import Any

from gonio.export import library
from gonio.export.expressions import UndecidedError
from gonio.export.operators import Operators
from gonio.export.tree import Call, ExportError, Expr, Struct, Type, Variable, inside
from gonio.export.values import Changed, Many, Static, Value, exact, is_number, shown_kind, truth
from gonio.export.worked_out import expanded, put


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
            if isinstance(value, Many):
                numbers = tuple(exact(self._resolved(e)) for e in value.values)
                value = value if None in numbers else Static(numbers)
            if isinstance(value, Static) and not is_number(value.value):
                try:
                    hash(value)
                except TypeError:
                    self.refuse(
                        node,
                        f"{shown_kind(value.value)} cannot be passed in a shader; pass numbers, vectors, "
                        "functions and options, and make vectors where they are needed.",
                    )
                kinds.append(value)
                continue
            expr = self._expr(node, value)
            if isinstance(expr, Changed):
                self.refuse(node, "give the changed model a name first: rougher = ...")
            passed.append(expr)
            kinds.append(expr.type)
        return passed, kinds

    def _called(
        self,
        node: ast.AST,
        function: types.FunctionType,
        kinds: Sequence[Type | Static],
        passed: Sequence[Expr],
        model: Expr | None = None,
        method: str = "",
        guarded: bool = True,
    ) -> Call:
        """A call of an exported function, which may be a method of a model, unless it would call itself.

        It is exported for the types of what is passed; where these leave open what has to be known when
        the shader is made, such as a number of steps or a whole exponent, for the numbers that are passed.
        """
        owner = model.type if model is not None else None
        assert owner is None or isinstance(owner, Struct)
        kinds, passed = list(kinds), list(passed)
        while True:
            if self.reader.is_open(function, kinds, owner):
                self.refuse(
                    node,
                    f"{function.__name__} calls itself, which shading languages do not allow; write a loop "
                    "over a fixed number of steps.",
                )
            try:
                made = self.reader.function_for(function, kinds, owner, method, guarded)
            except UndecidedError as error:
                wanted = self._wanted(function, kinds, error)
                for i in wanted:
                    self._check_number(node, function, passed[i], error)
            else:
                wanted = [i for i in made.exponents if self._is_whole(node, passed[i])]
                computed = made.in_exponents - set(wanted)
                wanted += [i for i in computed if self._is_known(node, passed[i])]
                for exponent in made.struct_exponents:
                    names = [name for name, _ in made.parameters]
                    given = (*(() if model is None else (model,)), *passed)
                    values = dict(zip(names, given, strict=True))
                    self._check_struct(node, function.__name__, exponent, values)
                if not wanted:
                    before = () if model is None else (model,)
                    return Call(made, (*before, *passed), made.result)
            of_passed = [i for i, kind in enumerate(kinds) if not isinstance(kind, Static)]
            for i in wanted:
                kinds[of_passed[i]] = Static(self._number_of(passed[i]))
            passed = [expr for i, expr in enumerate(passed) if i not in wanted]

    @staticmethod
    def _wanted(
        function: types.FunctionType, kinds: Sequence[Type | Static], error: UndecidedError
    ) -> list[int]:
        """Which of what is passed has to be a number."""
        names = list(inspect.signature(function, follow_wrapped=False).parameters)[-len(kinds) :]
        passed = [n for n, kind in zip(names, kinds, strict=True) if not isinstance(kind, Static)]
        return [i for i, name in enumerate(passed) if name in error.arguments]

    def _check_number(
        self, node: ast.AST, function: types.FunctionType, passed: Expr, error: UndecidedError
    ) -> None:
        """Refuse what is no number in a call of a function that has to know it."""
        resolved = self._resolved(passed)
        if truth(resolved) is not None:
            return
        line = getattr(node, "lineno", 0)
        place = f"line {line}" if error.source is self.source else f"{self.source.path}:{line}"
        names = " and ".join(sorted(error.arguments))
        told = f"{error.reason[:-1]}; {place} calls {function.__name__} with {names} not known."
        try:
            self._refuse_undecided(node, resolved, told)
        except UndecidedError as further:
            shown = error.source.complaint(error.node, error.reason)
            further.args, further.place, further.reason = shown.args, shown.place, shown.reason
            further.source, further.node = error.source, error.node
            raise
        except ExportError:
            raise error.source.complaint(error.node, told) from None

    def _is_whole(self, node: ast.AST, exponent: Expr) -> bool:
        """Whether an exponent that a function is given is a whole number here, which it has to know."""
        if _whole(self._number_of(exponent)):
            return True
        self._exponent(node, exponent)
        return False

    def _is_known(self, node: ast.AST, passed: Expr) -> bool:
        """Whether what an exponent is computed of is a number here: the exponent may be whole then."""
        if self._number_of(passed) is not None:
            return True
        self._exponent(node, passed, computed=True)
        return False

    def _check_struct(
        self, node: ast.AST, function: str, exponent: Expr, given: Mapping[str, Expr]
    ) -> None:
        """Refuse structs of which the function that is called makes an exponent that is whole here."""
        found = put(exponent, given)
        if _whole(self._number_of(found)):
            names = {e.type.name for e in inside(exponent) if isinstance(e.type, Struct)}
            self.refuse(
                node,
                f"a whole exponent in {function} is made of {' and '.join(sorted(names))}: Python allows "
                "negative bases then, a shader does not; pass the exponent as an argument of its own.",
            )
        self._exponent(node, found, computed=True)

    def _exponent(self, node: ast.AST, exponent: Expr, *, computed: bool = False) -> None:
        """Take note of an exponent that may be a plain number in Python, for which it has products."""
        names = {e.name for e in inside(exponent) if isinstance(e, Variable)}
        resolved = self._resolved(exponent)
        if self._number_of(exponent) is not None:
            return  # and no whole number
        origins = {e.name for e in inside(resolved) if isinstance(e, Variable)}
        found = origins & self.arguments
        found = found.union(*(self.made_of.get(n, ()) for n in origins - found))
        whole = expanded(exponent, self.made)
        leaves = [e for e in inside(whole) if isinstance(e, Variable)]
        ours = {name for name, _ in self.parameters}
        if any(map(self._is_record, leaves)) and all(e.name in ours for e in leaves):
            self.struct_exponents.append(whole)
        if computed or not isinstance(resolved, Variable):
            self.in_exponents |= found
        else:
            self.exponents |= found
        if names and names <= self.plain:
            self.refuse(
                node,
                "this exponent is a whole number in Python, which allows negative bases, and a variable in "
                "a shader, which does not; write it where power is called, or multiply in the loop.",
            )

    @staticmethod
    def _is_record(expr: Expr) -> bool:
        """Whether it is a struct of the user's own."""
        return isinstance(expr.type, Struct) and expr.type.python is not None

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


def _whole(known: Any) -> bool:
    """Whether a number is known, and whole."""
    return known is not None and known == int(known)
