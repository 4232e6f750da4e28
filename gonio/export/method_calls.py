"""Calls of a model's methods, and of those of classes above it."""

from __future__ import annotations

import ast
import types
from collections.abc import Sequence
from typing import Any, cast

from gonio.export.contract import SIGNATURES, UNTESTED, MissingMethodError, method_of, written
from gonio.export.record_calls import RecordCalls
from gonio.export.tree import SELF, Access, Expr, Struct, Variable
from gonio.export.values import Changed, Method, Value, spoken
from gonio.fields import Parameter
from gonio.model import Model


class MethodCalls(RecordCalls):
    """Reads the calls of a model's methods."""

    def _above(self, node: ast.expr) -> types.FunctionType | None:
        """The method behind super().name, if that is what is called."""
        if not (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Call)
            and isinstance(node.value.func, ast.Name)
            and node.value.func.id == "super"
            and "super" not in self.scope
            and self.owner is not None
        ):
            return None
        if node.value.args or node.value.keywords:
            self.refuse(
                node, "super() takes nothing here; or name the class: EON.eval(self, wi, wo)."
            )
        assert self.owner.model is not None
        classes = self.owner.model.written.__mro__
        # The class whose body the method stands in, which may have other names for it in classes below
        cells = dict(
            zip(self.python.__code__.co_freevars, self.python.__closure__ or (), strict=True)
        )
        here = cells["__class__"].cell_contents
        if here not in classes:
            self.refuse(
                node, f"{self.owner.model.written.__name__} derives not from {here.__name__}."
            )
        for cls in classes[classes.index(here) + 1 :]:
            if cls is Model or node.attr not in vars(cls):
                continue
            found = vars(cls)[node.attr]
            if isinstance(found, types.FunctionType):
                return found
            self.refuse(
                node,
                f"{node.attr!r} of {cls.__name__} is a {type(found).__name__}, which super() cannot call "
                f"in a shader; write a method, or {cls.__name__}.{node.attr} for a static one.",
            )
        self.refuse(node, f"no class above this one has a method {node.attr!r}.")

    def _is_method_of_a_class(self, node: ast.Call, function: types.FunctionType) -> bool:
        """Whether a call is Class.method(self, ...), with a class that the model derives from."""
        first = node.args[0] if node.args else None
        if not (isinstance(first, ast.Name) and first.id == self.self_name):
            return False
        assert self.owner is not None
        assert self.owner.model is not None
        return any(
            found is function
            for cls in self.owner.model.written.__mro__
            for found in vars(cls).values()
        )

    def _inherited_call(
        self,
        node: ast.Call,
        function: types.FunctionType,
        owner: Struct,
        arguments: Sequence[ast.expr],
    ) -> Expr:
        """A method of a class above, for this model: its own function beside the one that replaces it."""
        name = function.__name__
        plain = self._plain_function(node, name, function)
        call = ast.copy_location(ast.Call(node.func, list(arguments), node.keywords), node)
        passed, kinds = self._typed(self._arguments(call, plain, 1))
        guarded = name in SIGNATURES and name not in (UNTESTED, "mean_albedo")
        if guarded:
            self._check_signature(node, name, passed)
        tested = self.tested | (self.upper if name == "albedo" else frozenset())
        same = all(isinstance(e, Variable) and e.name in tested for e in passed)
        return self._called(
            node, plain, kinds, passed, Variable(SELF, owner), name, guarded and not same
        )

    def _method_call(self, node: ast.Call, method: Method) -> Value:
        owner = method.model.type
        assert isinstance(owner, Struct)
        if owner.model is None:
            return self._record_method(node, method)
        if method.name == "at_least_as_rough":
            return self._rougher(node, method.model, owner)
        name = "eval" if method.name == UNTESTED else method.name
        function = self._method_of(node, owner, name)
        passed, kinds = self._typed(self._arguments(node, function, 1))
        if method.name in SIGNATURES:
            self._check_signature(node, method.name, passed)
            given = tuple(kind for _, kind in SIGNATURES[method.name][0])
            return self._called(node, function, given, passed, method.model, method.name)
        return self._called(node, function, kinds, passed, method.model)

    def _check_signature(self, node: ast.Call, name: str, passed: Sequence[Expr]) -> None:
        expected = SIGNATURES[name][0]
        if len(passed) != len(expected):
            self.refuse(node, f"{name} takes {', '.join(n for n, _ in expected)}.")
        for (argument, kind), expr in zip(expected, passed, strict=True):
            if expr.type != kind:
                self.refuse(node, f"{argument} must be a {spoken(kind)}.")

    def _method_of(self, node: ast.AST, owner: Struct, name: str) -> types.FunctionType:
        try:
            return method_of(owner, name)
        except MissingMethodError as error:
            self.refuse(node, str(error))

    def _plain_function(self, node: ast.AST, name: str, found: Any) -> types.FunctionType:
        function = written(name, found)
        if function is None:
            self.refuse(node, f"{name!r} is no plain method.")
        return function

    def _property(self, node: ast.Attribute, model: Expr, found: property) -> Value:
        owner = model.type
        assert isinstance(owner, Struct)
        if not isinstance(found.fget, types.FunctionType):
            self.refuse(node, f"the property {node.attr!r} is no plain function; write a method.")
        return self._called(node, found.fget, [], (), model)

    def _rougher(self, node: ast.Call, model: Expr, owner: Struct) -> Expr:
        """A copy of a model with wider highlights, each parameter by the function that it declares."""
        assert owner.model is not None
        method = cast(types.FunctionType, Model.at_least_as_rough)
        if owner.model.written.at_least_as_rough is not method:
            self.refuse(node, "at_least_as_rough is gonio's own; give the method another name.")
        ((at, value),) = self._arguments(node, method, 1)
        alpha = self._expr(at, value)
        members: dict[str, Expr] = {}
        for name, declared in owner.model.fields.items():
            if isinstance(declared, Parameter) and declared.rougher is not None:
                own = Access(model, name, "float")
                function = cast(types.FunctionType, declared.rougher)
                members[name] = self._called(node, function, ["float", "float"], (own, alpha))
        return Changed(model, owner, members) if members else model
