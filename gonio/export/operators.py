"""Arithmetic and comparisons, and what Python has computed of numbers alone."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from gonio.export.attributes import Attributes
from gonio.export.tree import (
    Constant,
    Expr,
    Negation,
    Number,
    Operation,
    Splat,
    Struct,
    Type,
    Variable,
    inside,
)
from gonio.export.values import (
    COMPARISON,
    SAME,
    Many,
    Static,
    Value,
    exact,
    factor,
    is_number,
    misfit,
    single,
    spoken,
    truth,
)
from gonio.export.vocabulary import widest

OPERATORS: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARED: dict[type, str] = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}
# What Python computes when the shader is made, with what to write where it cannot.
OF_NUMBERS: dict[type, tuple[str, Callable[[Any, Any], Any], str]] = {
    ast.Pow: ("**", operator.pow, "x * x, or power(x, exponent)"),
    ast.FloorDiv: ("//", operator.floordiv, "q - fract(q) with q = x / y"),
    ast.Mod: ("%", operator.mod, "y * fract(x / y)"),
}
STATIC_COMPARISON: dict[type, Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}


class Operators(Attributes):
    """Reads the operations of one function."""

    def _unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            known = self._decided(node.operand, value)
            if known is None:
                self._refuse_undecided(
                    node, value, "'not' is for options; a mask is inverted with ~."
                )
            return Static(not known)
        expr = self._expr(node.operand, value)
        if expr.type == "bool3":
            self.refuse(node, "a mask of a colour cannot be inverted; swap the branches of select.")
        masks = expr.type == "bool"
        wrong = isinstance(expr.type, Struct) or expr.type == "vec2"
        if masks != isinstance(node.op, ast.Invert) or wrong:
            self.refuse(node, f"this cannot be done with a {spoken(expr.type)}.")
        names = {e.name for e in inside(expr) if isinstance(e, Variable)}
        if masks and names <= self.plain:
            self.refuse(
                node,
                "of plain numbers a comparison is True or False in Python, of which ~ makes -2 or -1; "
                "write the opposite comparison, such as >= for <.",
            )
        if isinstance(node.op, ast.UAdd):
            return expr
        if isinstance(expr, Number):
            return Number(-expr.value)
        return Negation(expr, expr.type)

    def _binary(self, node: ast.BinOp) -> Value:
        return self._operation(node, node.op, self.expr(node.left), self.expr(node.right))

    def _operation(self, node: ast.AST, op: ast.operator, left: Expr, right: Expr) -> Expr:
        """Two values joined by an operator."""
        kinds = (left.type, right.type)
        if type(op) in OF_NUMBERS:
            return self._by_python(node, op, left, right)
        if isinstance(op, (ast.BitAnd, ast.BitOr)):
            if kinds != ("bool", "bool"):
                self.refuse(node, "& and | join two masks of numbers.")
            return Operation("&&" if isinstance(op, ast.BitAnd) else "||", left, right, "bool")
        symbol = OPERATORS.get(type(op))
        if symbol is None:
            self.refuse(node, "only + - * / can be exported, and & | ~ for masks; see fract(x).")
        if "vec2" in kinds:
            self.refuse(node, "a Vec2 is a pair of numbers; compute with its x and y.")
        if any(k not in ("float", "vec3") for k in kinds):
            self.refuse(node, f"a {spoken(kinds[0])} {symbol} a {spoken(kinds[1])} has no meaning.")
        self._check_factors(node, symbol, left, right)
        return self._of_numbers(node, simplified(symbol, left, right, widest(kinds)))

    def _check_factors(self, node: ast.AST, symbol: str, left: Expr, right: Expr) -> None:
        """Refuse a product that leaves single precision on its way: a * 1e30 * 1e30 * 1e-60."""
        if symbol not in "*/" or all(isinstance(e, (Number, Constant)) for e in (left, right)):
            return
        size = factor(left) * factor(right) if symbol == "*" else factor(left) / factor(right)
        if misfit(size):
            self.refuse(
                node,
                f"the numbers of this product make {size:.3g} on the way, which single precision does not "
                "hold; multiply them by each other first.",
            )

    def _by_python(self, node: ast.AST, op: ast.operator, left: Expr, right: Expr) -> Number:
        """What only Python computes, of numbers that are known: 2**-24, n // 2."""
        symbol, compute, instead = OF_NUMBERS[type(op)]
        one, other = exact(self._resolved(left)), exact(self._resolved(right))
        if one is None or other is None:
            self._refuse_undecided(
                node,
                Operation("*", left, right, "float"),
                f"{symbol} is for numbers that are known when the shader is made; write {instead}.",
            )
        try:
            if symbol == "**" and abs(other) > 4096:  # else Python may compute for hours
                raise OverflowError
            return self._number(node, compute(one, other))
        except ArithmeticError as error:
            self.refuse(node, f"Python cannot compute this ({error}).")

    def _of_numbers(self, node: ast.AST, expr: Expr) -> Expr:
        """An operation between numbers alone, written out unless single precision would change it."""
        try:
            value = exact(expr)
        except ArithmeticError as error:
            self.refuse(node, f"Python cannot compute this ({error}).")
        if value is None or isinstance(expr, Number):
            return expr
        number = self._number(node, value)
        if abs(single(expr) - value) <= SAME * abs(value):
            return expr
        return number

    @staticmethod
    def _is_missing(left: Value, right: Value) -> bool:
        """Whether None stands beside a value in the shader, which is never None: `if tint is None`."""
        none = [isinstance(v, Static) and v.value is None for v in (left, right)]
        return any(none) and any(isinstance(v, Expr) for v in (left, right))

    def _as_number(self, node: ast.expr, value: Value) -> Value:
        """A number that is known when the shader is made, as one that stands there."""
        number = isinstance(value, Static) and is_number(value.value)
        return self._expr(node, value) if number else value

    def _chain(self, node: ast.Compare) -> Static:
        """0 < n < 5 of numbers that are known; Python joins others by `and`, which masks have not."""
        operands = [node.left, *node.comparators]
        for left, op, right in zip(operands, node.ops, operands[1:], strict=False):
            pair = ast.copy_location(ast.Compare(left, [op], [right]), node)
            value = self._compare(pair)
            known = self._decided(pair, value)
            if known is None:
                self._refuse_undecided(
                    node, value, "one comparison at a time; join two with &: (a < b) & (b < c)."
                )
            if not known:
                return Static(False)
        return Static(True)

    def _compare(self, node: ast.Compare) -> Value:
        if len(node.ops) != 1:
            return self._chain(node)
        left, right = self.value(node.left), self.value(node.comparators[0])
        op = node.ops[0]
        if isinstance(op, (ast.In, ast.NotIn)) and isinstance(right, Many):
            numbers = tuple(exact(e) for e in right.values)
            right = right if None in numbers else Static(numbers)
        if isinstance(op, (ast.Is, ast.IsNot)) and self._is_missing(left, right):
            return Static(isinstance(op, ast.IsNot))
        left, right = self._as_number(node.left, left), self._as_number(node.comparators[0], right)
        if isinstance(left, Static) or isinstance(right, Static):
            one, other = (
                truth(self._resolved(v) if isinstance(v, Expr) else v) for v in (left, right)
            )
            if one is None or other is None:
                shader = right if one is not None else left
                self._refuse_undecided(node, shader, "an option is compared with its values only.")
            single_object = any(v is None or isinstance(v, bool) for v in (one.value, other.value))
            if isinstance(op, (ast.Is, ast.IsNot)) and not single_object:
                self.refuse(node, "'is' compares objects; write == or != to compare values.")
            try:
                return Static(STATIC_COMPARISON[type(op)](one.value, other.value))
            except (TypeError, ValueError) as error:
                self.refuse(node, f"Python cannot compare these ({error}).")
        a = self._expr(node.left, left)
        b = self._expr(node.comparators[0], right)
        if type(op) not in COMPARED:
            self.refuse(node, "'is' and 'in' are for options; numbers are compared by == or <.")
        if any(e.type not in ("float", "vec3") for e in (a, b)):
            self.refuse(node, f"a {spoken(a.type)} and a {spoken(b.type)} cannot be compared.")
        kind = widest((a.type, b.type))
        a, b = self._coerce(node, a, kind), self._coerce(node, b, kind)
        found = Operation(COMPARED[type(op)], a, b, "bool3" if kind == "vec3" else "bool")
        self.places[id(found)] = (found, node)
        known = truth(found)
        if known is not None:
            compare = COMPARISON[found.operator]
            if compare(single(a), single(b)) != known.value:  # 0.1 + 0.2 == 0.3 in single precision
                return Operation(
                    "<", Number(int(not known.value)), Number(int(known.value)), "bool"
                )
        return found


def simplified(symbol: str, left: Expr, right: Expr, kind: Type) -> Expr:
    """An operation without what changes nothing: 0 * x is 0, 1 * x and 0 + x are x."""

    def is_(expr: Expr, value: float) -> bool:
        inner = expr.value if isinstance(expr, Splat) else expr
        return isinstance(inner, Number) and inner.value == value

    def wide(expr: Expr) -> Expr:
        return expr if expr.type == kind else Splat(expr, kind)

    if symbol == "*" and (is_(left, 0) or is_(right, 0)):
        return wide(Number(0))
    if symbol == "*" and (is_(left, 1) or is_(right, 1)):
        return wide(right if is_(left, 1) else left)
    if symbol == "/" and is_(right, 1):
        return wide(left)
    if symbol == "+" and (is_(left, 0) or is_(right, 0)):
        return wide(right if is_(left, 0) else left)
    if symbol == "-" and is_(right, 0):
        return wide(left)
    if symbol == "-" and is_(left, 0) and isinstance(right, Number):
        return wide(Number(-right.value))
    return Operation(symbol, left, right, kind)
