"""Names, and what stands behind a dot: of modules, structs, vectors and models."""

from __future__ import annotations

import ast
import builtins
import functools
import inspect
import types
from abc import abstractmethod
from typing import Any

from gonio.export.contract import NO_MEANING, OF_EVERY_MODEL
from gonio.export.expressions import Expressions
from gonio.export.instead import BUILTINS
from gonio.export.source import Source, source
from gonio.export.tree import Access, Constant, Expr, Struct, Variable
from gonio.export.values import Method, Static, Value, is_number, misfit, shown, spoken
from gonio.export.vocabulary import VECTORS
from gonio.model import Model


class Attributes(Expressions):
    """Reads the names and attributes of one function."""

    @abstractmethod
    def _property(self, node: ast.Attribute, model: Expr, found: property) -> Value:
        """Read the value of a model's property."""

    @abstractmethod
    def _record_property(self, node: ast.Attribute, value: Expr, found: property) -> Value:
        """Read the value of a property of a user's own struct."""

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.scope:
            known = self.scope[node.id]
            if isinstance(known, Static):
                return known
            own = node.id == self.self_name
            return Variable(self.self_variable if own else node.id, known)
        code = self.python.__code__
        if node.id in code.co_freevars:
            self.refuse(
                node,
                f"{node.id!r} belongs to the function around this one; pass it as an argument, or make it "
                "a name of the module.",
            )
        if node.id in code.co_varnames or node.id in code.co_cellvars:
            self.refuse(
                node,
                f"{node.id!r} has no value here, or one that is known inside a loop or another branch "
                "only; give it a value before.",
            )
        names = self.python.__globals__
        mangled = node.id.startswith("__") and not hasattr(builtins, node.id)
        if mangled and node.id not in code.co_names:
            self.refuse(node, f"Python reads {node.id} within a class as another name; rename it.")
        if node.id in names:
            return self._global(node, node.id, names[node.id], self.source)
        if hasattr(builtins, node.id):
            instead = BUILTINS.get(node.id, "the functions of gonio.lang")
            self.refuse(node, f"a shader has no {node.id!r} of Python; write {instead}.")
        self.refuse(
            node, f"{node.id!r} is not known here; import it, or give it a value before this line."
        )

    def _global(self, node: ast.AST, name: str, value: Any, file: Source | None) -> Value:
        if not is_number(value):
            return Static(value)
        wrong = misfit(value)
        if wrong:
            self.refuse(node, f"{name}: {wrong}.")
        self._check_spelling(node, name)
        comments, place = _described(name, file)
        return Constant(name, value, comments, place)

    # --- attributes --------------------------------------------------------------------------------

    def _attribute(self, node: ast.Attribute) -> Value:
        value = self.value(node.value)
        if isinstance(value, Static):
            try:
                found = getattr(value.value, node.attr)
            except AttributeError:
                self.refuse(node, f"{shown(value.value)} has no {node.attr!r}.")
            if isinstance(value.value, types.ModuleType):
                path = str(getattr(value.value, "__file__", ""))
                file = source(path) if path.endswith(".py") else None
                return self._global(node, node.attr, found, file)
            return Static(found)
        expr = self._expr(node.value, value)
        kind = expr.type
        if isinstance(kind, Struct):
            for member in kind.members:
                if member.name == node.attr:
                    return Access(expr, member.name, member.type)
            for name, fixed in kind.fixed:
                if name == node.attr:
                    return Static(fixed)
            if kind.model is not None:
                return self._of_model(node, expr, kind.model)
            if kind.python is not None and node.attr in vars(kind.python):
                return self._of_class(node, expr, vars(kind.python)[node.attr])
        elif kind in ("vec2", "vec3") and node.attr in tuple("xyz")[: VECTORS[str(kind)]]:
            return Access(expr, node.attr, "float")
        if isinstance(kind, Struct):
            names = ", ".join([m.name for m in kind.members] + [n for n, _ in kind.fixed])
            self.refuse(
                node,
                f"{kind.name} has no {node.attr!r}, only {names}; write a function that takes it.",
            )
        has = ", ".join("xyz"[: VECTORS.get(str(kind), 0)])
        instead = f"; write its components, {has}, one by one" if has else ""
        self.refuse(node, f"a {spoken(kind)} has no {node.attr!r} in a shader{instead}.")

    def _of_model(self, node: ast.Attribute, expr: Expr, model: Model) -> Value:
        """What a model has besides its parameters: options, methods, and what its class defines."""
        name = node.attr
        if name in model.fields:
            return Static(getattr(model, name))
        cls = next((c for c in model.written.__mro__ if name in vars(c)), None)
        if cls is None:
            if name in inspect.get_annotations(Model):  # what bound models have, such as float_type
                self.refuse(node, NO_MEANING.format(name))
            if hasattr(model, name):
                self.refuse(
                    node,
                    f"{name!r} is set when a model is made, and unknown in kernels; make it a parameter, "
                    "an option or a name of the class.",
                )
            if name.startswith("__") and not name.endswith("__"):
                self.refuse(node, f"Python reads {name} within a class as another name; rename it.")
            self.refuse(node, f"{model.name} has no {name!r}.")
        found = vars(cls)[name]
        if cls in Model.__mro__ and name not in OF_EVERY_MODEL:
            self.refuse(node, NO_MEANING.format(name))
        return self._of_class(node, expr, found)

    def _of_class(self, node: ast.Attribute, expr: Expr, found: Any) -> Value:
        """What a class has under a name: of a model, or of a struct of the user's own."""
        name, kind = node.attr, expr.type
        if isinstance(found, property):
            assert isinstance(kind, Struct)
            of_model = kind.model is not None
            return (self._property if of_model else self._record_property)(node, expr, found)
        if isinstance(found, staticmethod):
            return Static(found.__func__)
        if isinstance(found, types.FunctionType):
            return Method(expr, name, found)
        if isinstance(found, (functools.cached_property, classmethod)) or (
            hasattr(found, "__get__") and not isinstance(found, type)
        ):
            self.refuse(
                node, f"{name!r} is a {type(found).__name__}; write a method, or a plain @property."
            )
        if is_number(found):
            wrong = misfit(found)
            if wrong:
                self.refuse(node, f"{name}: {wrong}.")
            self._check_spelling(node, name)
            return Constant(name, found)
        return Static(found)


def _described(name: str, file: Source | None) -> tuple[tuple[str, ...], tuple[str, int, int]]:
    """The comments of a named number and its place, from the file that defines it."""
    if file is None:
        return (), ("", 0, 0)
    comments = file.constant_comments(name)
    if comments is not None:
        return comments, (file.path, *file.constant_place(name))
    module = file.imported_from(name)
    found = None
    if module is not None:
        found = inspect.getsourcefile(__import__(module, fromlist=["_"]))
    return ((), ("", 0, 0)) if found is None else _described(name, source(found))
