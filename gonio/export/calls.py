"""Calls, by what is called: the vocabulary, functions, methods of models, and what makes structs."""

from __future__ import annotations

import ast
import inspect
import types
from collections.abc import Sequence

from gonio import lang
from gonio.export import records
from gonio.export.builtin_calls import BuiltinCalls
from gonio.export.method_calls import MethodCalls
from gonio.export.stand_ins import PARTS, PLAIN, VALUE
from gonio.export.tree import Call, Expr, Type
from gonio.export.values import Method, Static, Value
from gonio.export.vocabulary import RULES
from gonio.lights.lookups import Lookups
from gonio.table import Table, fetch


class Calls(BuiltinCalls, MethodCalls):
    """Reads the calls of one function."""

    def _call(self, node: ast.Call) -> Value:
        above = self._above(node.func)
        if above is not None and self.owner is not None:
            return self._inherited_call(node, above, self.owner, node.args)
        callee = self.value(node.func)
        if isinstance(callee, Method):
            return self._method_call(node, callee)
        if not isinstance(callee, Static):
            self.refuse(node, "this cannot be called.")
        function = callee.value
        if isinstance(function, types.MethodType) and isinstance(function.__self__, Lookups):
            return self._lookup(node, function)
        if records.members(function) is not None:
            return self._record(node, function)
        if function is fetch:
            return self._fetch(node)
        if isinstance(function, types.FunctionType):
            if function.__module__ == lang.__name__ and function.__name__ in RULES:
                return self._builtin(node, function.__name__)
            if self.owner is not None and self._is_method_of_a_class(node, function):
                return self._inherited_call(node, function, self.owner, node.args[1:])
            if self._is_ours(function):
                return self._function_call(node, function)
        if isinstance(function, type):
            self.refuse(
                node.func,
                f"{function.__name__} makes an object, which no shader has; write a struct as "
                f"class {function.__name__}(NamedTuple), with its members.",
            )
        self.refuse(
            node.func,
            f"{ast.unparse(node.func)} is not in the vocabulary; use the functions of gonio.lang, or "
            "your own functions made of them.",
        )

    def _function_call(self, node: ast.Call, function: types.FunctionType) -> Expr:
        if hasattr(function, "__wrapped__"):
            self.refuse(
                node.func,
                f"{function.__name__} is wrapped by a decorator, which would be left out; write what the "
                "decorator does into the function.",
            )
        arguments = self._arguments(node, function, 0)
        passed, kinds = self._typed(arguments)
        self._check_pairs(arguments, function, kinds)
        function = self._stand_in(function)
        return self._called(node, function, kinds, passed)

    def _check_pairs(
        self,
        arguments: Sequence[tuple[ast.expr, Value]],
        function: types.FunctionType,
        kinds: Sequence[Type | Static],
    ) -> None:
        """Refuse a vector in the place of a pair of numbers, of which Python would take two components."""
        names = list(inspect.signature(function).parameters)
        for (node, _), name, kind in zip(arguments, names, kinds, strict=True):
            wanted = function.__annotations__.get(name)
            pair = wanted == "Vec2" or wanted is lang.Vec2
            if pair != (kind == "vec2") and (pair or wanted in ("Vec3", lang.Vec3)):
                self.refuse(
                    node, f"{name} of {function.__name__} must be a {'Vec2' if pair else 'Vec3'}."
                )

    def _stand_in(self, function: types.FunctionType) -> types.FunctionType:
        """What exports call in its place."""
        if not function.__module__.startswith(PARTS):
            return function
        for ending in (PLAIN,) if self.reader.differentiable else (PLAIN, VALUE):
            found = function.__globals__.get(f"{function.__name__}{ending}")
            if isinstance(found, types.FunctionType):
                return found
        return function

    def _lookup(self, node: ast.Call, method: types.MethodType) -> Expr:
        """A call of what the host supplies."""
        declared = vars(Lookups)[method.__name__]
        made = self.reader.lookup(declared)
        arguments = self._arguments(node, declared, 1)
        passed = tuple(
            self._coerce(at, self._expr(at, value), kind)
            for (at, value), (_, kind) in zip(arguments, made.parameters, strict=True)
        )
        return Call(made, passed, made.result)

    def _fetch(self, node: ast.Call) -> Expr:
        """A call that reads a table."""
        (at, found), (where, index) = self._arguments(node, fetch, 0)
        if not isinstance(found, Static) or not isinstance(found.value, Table):
            self.refuse(
                at, "fetch reads a gonio.table.Table; give one a name in the module or class."
            )
        model = self.owner.model if self.owner is not None else None
        owned = model is not None and any(
            value is found.value for cls in model.written.__mro__ for value in vars(cls).values()
        )
        made = self.reader.table(found.value, self.owner if owned else None)
        place = self._coerce(where, self._expr(where, index), "float")
        known = self._number_of(place)
        if known is not None and not (known == int(known) and 0 <= known < found.value.count):
            self.refuse(where, found.value.misplaced(known))
        return Call(made, (place,), made.result)
