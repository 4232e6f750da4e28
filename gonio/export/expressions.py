"""From Python expressions to typed ones: what kind each is, and what has no meaning in a shader.

Names and attributes stand in `gonio.export.attributes`, arithmetic and comparisons in `operators`, what is
called in `calls`, what is around expressions in `statements`.
"""

from __future__ import annotations

import ast
import re
import types
from abc import ABC, abstractmethod
from typing import Any, NoReturn

import numpy as np

from gonio.export.collector import Collector
from gonio.export.instead import INSTEAD
from gonio.export.source import Source, source
from gonio.export.tree import (
    SELF,
    ExportError,
    Expr,
    Number,
    Splat,
    Struct,
    Type,
    Variable,
    inside,
    rebuilt,
)
from gonio.export.values import (
    Many,
    Method,
    Static,
    Value,
    is_number,
    misfit,
    shown,
    shown_kind,
    spoken,
    truth,
)
from gonio.export.worked_out import number
from gonio.fields import is_array

# Terms and brackets of one statement; Python's own stack holds some five times as many.
DEPTH_MAX = 100


class UndecidedError(ExportError):
    """Something has to be known when the shader is made, and is as soon as some arguments are numbers."""

    arguments: frozenset[str]
    source: Source
    node: ast.AST


class Expressions(ABC):
    """Reads the expressions of one function."""

    def __init__(
        self, reader: Collector, function: types.FunctionType, owner: Struct | None
    ) -> None:
        """Begin a function, which may be the method of a model."""
        self.reader = reader
        self.python = function
        self.source: Source = source(function.__code__.co_filename)
        self.owner = owner
        self.self_name = ""  # what the method calls its model or NamedTuple
        self.self_variable = SELF  # what that is called in the shader
        self.scope: dict[str, Type | Static] = {}
        self.parameters: list[tuple[str, Type]] = []
        self.arguments: frozenset[str] = frozenset()  # names of the function's own
        # Arguments that are directions above the horizon, and of these or in it
        self.tested: frozenset[str] = frozenset()
        self.upper: frozenset[str] = frozenset()
        # Names that hold plain numbers of Python, such as the variable of a loop. What functions make of
        # such numbers is not followed.
        self.plain: set[str] = set()
        # Where values and comparisons stand in the file
        self.places: dict[int, tuple[Expr, ast.AST]] = {}
        # Arguments that are exponents, where Python's own numbers mean more than a shader's
        self.exponents: set[str] = set()
        self.in_exponents: set[str] = set()  # and arguments that exponents are computed of
        self.struct_exponents: list[Expr] = []  # and exponents computed of structs
        # Names that get a value once, made of numbers and arguments alone: range(n) may ask for them
        self.given: dict[str, Expr] = {}
        # Whatever names get that are given a value once, and the arguments that others are made of alone
        self.made: dict[str, Expr] = {}
        self.made_of: dict[str, frozenset[str]] = {}

    def refuse(self, node: ast.AST, message: str) -> NoReturn:
        """Raise an error that shows the place."""
        raise self.source.complaint(node, message)

    def _resolved(self, expr: Expr) -> Expr:
        """An expression with what names were given once in their places."""
        if isinstance(expr, Variable):
            return self.given.get(expr.name, expr)
        return rebuilt(expr, self._resolved)

    def _number_of(self, expr: Expr) -> Any:
        """The number that an expression comes to, or whether it holds; None if the shader decides."""
        known = truth(self._resolved(expr))
        return number(expr, self.made) if known is None else known.value

    def _refuse_undecided(self, node: ast.AST, expr: Value, message: str) -> NoReturn:
        """Refuse what is not known when the shader is made, or ask for the numbers of arguments.

        Raises:
            UndecidedError: only arguments are not known, of which the call may have the numbers.
        """
        if isinstance(expr, Expr):
            names = {e.name for e in inside(self._resolved(expr)) if isinstance(e, Variable)}
            if names and all(
                n in self.arguments and self.scope[n] in ("float", "bool") for n in names
            ):
                told = self.source.complaint(node, message)
                error = UndecidedError(*told.args)
                error.place, error.reason = told.place, told.reason
                error.arguments, error.source, error.node = frozenset(names), self.source, node
                raise error
        self.refuse(node, message)

    def _unknown(self, node: ast.AST) -> NoReturn:
        self.refuse(node, self._told(node))

    @staticmethod
    def _told(node: ast.AST) -> str:
        """What is said of Python that no shader has."""
        instead = INSTEAD.get(type(node), "assignments, returns and calls (docs/language.md)")
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(node).__name__).lower()
        return f"this ({kind}) cannot be exported; write {instead}."

    def _check_depth(self, node: ast.AST) -> None:
        """Refuse what is nested so deeply that neither Python nor a shader's compiler can follow."""
        level: list[ast.AST] = [node]
        for _ in range(DEPTH_MAX):
            level = [child for inner in level for child in ast.iter_child_nodes(inner)]
            if not level:
                return
        self.refuse(
            node,
            f"more than {DEPTH_MAX} terms or brackets in one statement; write it as several: "
            "total = total + ...",
        )

    def _coerce(self, node: ast.AST, expr: Expr, wanted: Type) -> Expr:
        if expr.type == wanted:
            return expr
        if wanted in ("vec2", "vec3") and expr.type == "float":
            return Splat(expr, wanted)
        self.refuse(node, f"a {spoken(expr.type)} where a {spoken(wanted)} is expected.")

    def expr(self, node: ast.expr) -> Expr:
        """An expression that has a value in the shader."""
        return self._expr(node, self.value(node))

    def _expr(self, node: ast.expr, value: Value) -> Expr:
        if isinstance(value, Static):
            if not is_number(value.value):
                instead = "write numbers, vectors or masks, and decide with 'if' on an option"
                if isinstance(value.value, (bool, np.number)):
                    instead = f"write {float(value.value)}, or decide with 'if'"
                elif is_array(value.value):
                    instead = "write vec3(...) where it is needed, with numbers; or make it a Table"
                self.refuse(node, f"{shown(value.value)} has no value in a shader; {instead}.")
            return self._number(node, value.value)
        if isinstance(value, Method):
            self.refuse(node, "a method must be called.")
        if isinstance(value, Many):
            self.refuse(node, "several values where one is expected; unpack them first.")
        return value

    def _number(self, node: ast.AST, value: Any) -> Number:
        wrong = misfit(value)
        if wrong:
            self.refuse(node, f"{wrong}.")
        return Number(value)

    def value(self, node: ast.expr) -> Value:
        """Read an expression, which may be something that only the exporter sees."""
        if isinstance(node, ast.Constant):
            return self._number(node, node.value) if is_number(node.value) else Static(node.value)
        if isinstance(node, ast.Name):
            return self._name(node)
        if isinstance(node, ast.Attribute):
            return self._attribute(node)
        if isinstance(node, ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, ast.BinOp):
            return self._binary(node)
        if isinstance(node, ast.BoolOp):
            return self._either(node)
        if isinstance(node, ast.Compare):
            return self._compare(node)
        if isinstance(node, ast.Call):
            return self._call(node)
        if isinstance(node, ast.Tuple):
            values = [self.value(v) for v in node.elts]
            if all(isinstance(v, Static) for v in values):
                return Static(tuple(v.value for v in values if isinstance(v, Static)))
            return Many(tuple(self._expr(n, v) for n, v in zip(node.elts, values, strict=True)))
        if isinstance(node, ast.IfExp):
            condition = self.value(node.test)
            test = self._decided(node.test, condition)
            if test is not None:
                return self.value(node.body if test else node.orelse)
            self._refuse_undecided(node, condition, self._told(node))
        self._unknown(node)

    def _decided(self, node: ast.AST, value: Value) -> bool | None:
        """What Python's `if` makes of a value; None if it is not known when the shader is made."""
        known = truth(self._resolved(value) if isinstance(value, Expr) else value)
        if known is None:
            return None
        try:
            return bool(known.value)
        except (TypeError, ValueError):
            self.refuse(
                node,
                f"Python cannot say whether {shown_kind(known.value)} holds; decide on options and named "
                "numbers.",
            )

    @abstractmethod
    def _name(self, node: ast.Name) -> Value:
        """Read a name."""

    @abstractmethod
    def _attribute(self, node: ast.Attribute) -> Value:
        """Read what stands behind a dot."""

    @abstractmethod
    def _unary(self, node: ast.UnaryOp) -> Value:
        """Read a sign, or an inversion."""

    @abstractmethod
    def _binary(self, node: ast.BinOp) -> Value:
        """Read an operation."""

    @abstractmethod
    def _compare(self, node: ast.Compare) -> Value:
        """Read a comparison."""

    @abstractmethod
    def _call(self, node: ast.Call) -> Value:
        """Read a call."""

    def _either(self, node: ast.BoolOp) -> Value:
        """a or b, a and b: one of the two values, as in Python."""
        for i, operand in enumerate(node.values):
            value = self.value(operand)
            known = self._decided(operand, value)
            last = i == len(node.values) - 1
            if known is None and not (last and i):
                self._refuse_undecided(
                    node, value, "'and' and 'or' are for options; masks are joined with & and |."
                )
            if last or known is None or known is isinstance(node.op, ast.Or):
                return value
        raise AssertionError("no operands")

    def _check_name(self, node: ast.AST, name: str) -> None:
        """Refuse what no shading language takes as a name."""
        if name == SELF:
            self.refuse(node, f"{SELF} is the struct of parameters in shaders; use another name.")
        self._check_spelling(node, name)

    def _check_spelling(self, node: ast.AST, name: str) -> None:
        """Refuse letters and underscores that no name of a shader has."""
        if not name.isascii() or "__" in name:
            plain = re.sub("_+", "_", name.strip("_"))
            such = f", such as {plain}" if plain.isascii() and plain.isidentifier() else ""
            self.refuse(
                node,
                f"shading languages do not take the name {name!r}; use letters of the English alphabet, "
                f"digits and single underscores{such}.",
            )
