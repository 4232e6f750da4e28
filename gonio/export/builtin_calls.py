"""Calls of the vocabulary, gonio.lang."""

from __future__ import annotations

import ast

from gonio import lang
from gonio.export import library
from gonio.export.arguments import Arguments
from gonio.export.operators import simplified
from gonio.export.tree import (
    Access,
    Builtin,
    Call,
    Constant,
    Construction,
    Expr,
    Number,
    Operation,
    Splat,
    Type,
    Variable,
)
from gonio.export.values import Static, Value, exact, spoken
from gonio.export.vocabulary import RULES, widest
from gonio.polynomials import terms_in_single

# Whole powers up to this are products; beyond it, a power of the absolute value.
PRODUCT_MAX = 16

# polynomial(x, bound, c0, c1)
POLYNOMIAL_MIN = 4


class BuiltinCalls(Arguments):
    """Reads the calls of the vocabulary."""

    def _builtin(self, node: ast.Call, name: str) -> Expr:
        rule = RULES[name]
        if name == "polynomial":
            return self._polynomial(node)
        arguments = self._arguments(node, getattr(lang, name), 0)
        if name == "select" and isinstance(arguments[0][1], Static):
            arguments[0] = (arguments[0][0], self._known_mask(arguments[0][1]))
        values = [self._expr(n, v) for n, v in arguments]
        if name in ("vec2", "vec3"):
            kind: Type = "vec2" if name == "vec2" else "vec3"
            if any(v.type != "float" for v in values):
                self.refuse(node, f"{name} takes {rule.count} numbers.")
            return Construction(tuple(values), kind)
        if name == "select":
            return self._select(node, *values)
        kinds = tuple(v.type for v in values)
        for kind in kinds:
            if kind not in rule.takes:
                self.refuse(node, f"{name} cannot take a {spoken(kind)}.")
        if name == "power":
            return self._power(node, *values)
        if name in self.reader.lacking:
            made = self.reader.function_for(getattr(library, name), kinds)
            return Call(made, tuple(values), made.result)
        if rule.splat:
            values = [self._coerce(node, v, widest(kinds)) for v in values]
        return Builtin(name, tuple(values), rule.result(kinds))

    @staticmethod
    def _known_mask(value: Static) -> Value:
        """A comparison that comes out as Python knows."""
        if not isinstance(value.value, bool):
            return value
        holds = int(value.value)
        return Operation("<", Number(1 - holds), Number(holds), "bool")

    def _polynomial(self, node: ast.Call) -> Expr:
        """The first terms of a polynomial, those that single precision can tell, by Horner's rule."""
        starred = any(isinstance(a, ast.Starred) for a in node.args)
        if node.keywords or (len(node.args) < POLYNOMIAL_MIN and not (starred and node.args[2:])):
            self.refuse(node, "write polynomial(x, bound, c0, c1, ...).")
        x = self.expr(node.args[0])
        if x.type != "float":
            self.refuse(node, f"polynomial cannot take a {spoken(x.type)}.")
        if not isinstance(x, (Variable, Access)):
            self.refuse(
                node.args[0], "x stands in the text once for each term; give it a name first."
            )
        given = [self._resolved(e) for argument in node.args[1:] for e in self._numbers(argument)]
        if len(given) < POLYNOMIAL_MIN - 1:
            self.refuse(node, "polynomial has two coefficients or more.")
        values = [exact(e) for e in given]
        for expr, value in zip(given, values, strict=True):
            if value is None:
                self._refuse_undecided(
                    node, expr, "polynomial's bound and coefficients are numbers, not variables."
                )
        count = terms_in_single(values[0], values[1:])
        *below, found = given[1 : count + 1]
        for coefficient in reversed(below):
            found = simplified("+", coefficient, simplified("*", x, found, "float"), "float")
        return found

    def _numbers(self, node: ast.expr) -> list[Expr]:
        """A number, or those of a tuple with a name: *COEFFICIENTS."""
        if not isinstance(node, ast.Starred):
            return [self.expr(node)]
        value = self.value(node.value)
        if not isinstance(value, Static) or not isinstance(value.value, tuple):
            self.refuse(node, "a star is for numbers in a tuple that has a name.")
        return [self._expr(node, Static(number)) for number in value.value]

    def _power(self, node: ast.Call, base: Expr, exponent: Expr) -> Expr:
        """Whole powers by products: for any base, as in Python; a shader's pow knows positive ones."""
        kind = widest((base.type, exponent.type))
        number = self._number_of(exponent)
        if number is None:
            self._exponent(node, exponent)
        if number is None or number != int(number):
            base, exponent = self._coerce(node, base, kind), self._coerce(node, exponent, kind)
            return Builtin("power", (base, exponent), kind)
        whole = int(number)
        if whole < 0:
            over = self._whole_power(base, -whole)
            return self._of_numbers(node, Operation("/", Number(1), over, base.type))
        return self._whole_power(base, whole)

    def _whole_power(self, base: Expr, whole: int) -> Expr:
        if whole == 0:
            return Number(1) if base.type == "float" else Splat(Number(1), base.type)
        if whole == 1:
            return base
        named = isinstance(base, (Variable, Access, Constant, Number))
        if whole == 2 and named:
            return Operation("*", base, base, base.type)
        made = self.reader.power(whole, base.type)
        return Call(made, (base,), base.type)

    def _select(self, node: ast.Call, condition: Expr, yes: Expr, no: Expr) -> Expr:
        if condition.type not in ("bool", "bool3"):
            self.refuse(
                node, "select's condition is a comparison, or comparisons joined by & and |."
            )
        kinds = (yes.type, no.type)
        if kinds == ("bool", "bool"):
            self.refuse(node, "select between numbers or vectors; join masks with & and |.")
        if any(k not in ("float", "vec2", "vec3") for k in kinds):
            self.refuse(node, "select between numbers or vectors.")
        if condition.type == "bool3" and "vec2" in kinds:
            self.refuse(node, "a mask of a colour selects between colours or numbers.")
        kind: Type = "vec3" if condition.type == "bool3" else widest(kinds)
        yes, no = self._coerce(node, yes, kind), self._coerce(node, no, kind)
        return Builtin("select", (condition, yes, no), kind)
