"""From Python expressions to typed ones: names, attributes, arithmetic and comparisons.

What is called stands in `gonio.export.calls`, what is around expressions in `gonio.export.statements`.
"""

from __future__ import annotations

import ast
import builtins
import functools
import inspect
import operator
import re
import types
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import Any, NoReturn, Protocol

import numpy as np

from gonio.export.source import Source, source
from gonio.export.tree import (
    SELF,
    Access,
    Constant,
    Expr,
    Function,
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
    Method,
    Static,
    Value,
    exact,
    factor,
    is_number,
    misfit,
    shown,
    shown_kind,
    single,
    spoken,
    truth,
)
from gonio.export.vocabulary import VECTORS, widest
from gonio.model import Model
from gonio.table import Table

# `eval` without the test for the horizon.
UNTESTED = "eval_above"

# The types of a model's own methods, which its users call.
SIGNATURES: dict[str, tuple[tuple[tuple[str, Type], ...], Type | None]] = {
    "eval": ((("wi", "vec3"), ("wo", "vec3")), "vec3"),
    UNTESTED: ((("wi", "vec3"), ("wo", "vec3")), "vec3"),
    "sample": ((("wo", "vec3"), ("u", "vec2")), None),
    "pdf": ((("wi", "vec3"), ("wo", "vec3")), "float"),
    "albedo": ((("wo", "vec3"),), "vec3"),
    "mean_albedo": ((), "vec3"),
}

# Methods of `gonio.model.Model` that are exported as they stand there, where a model has none of its own.
OF_ALL = ("sample_leaving", "pdf_leaving")

# What a shader may ask of `gonio.model.Model` itself.
OF_EVERY_MODEL = {*SIGNATURES, *OF_ALL, "at_least_as_rough", "name"}
NO_MEANING = "{!r} has no meaning in a shader; use parameters and options."

# Terms and brackets of one statement; Python's own stack holds some five times as many.
DEPTH_MAX = 100

OPERATORS: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARED: dict[type, str] = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
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

# What people write, and what to write instead.
INSTEAD = {
    ast.While: "a loop over a fixed number of steps: for i in range(8): ...",
    ast.Break: "a loop that makes all its steps, and x = select(condition, new, x) in it",
    ast.Continue: "a loop that makes all its steps, and x = select(condition, new, x) in it",
    ast.IfExp: "select(condition, yes, no), which computes both",
    ast.Lambda: "a function with a name",
    ast.ListComp: "one statement for each element",
    ast.SetComp: "one statement for each element",
    ast.DictComp: "one statement for each element",
    ast.GeneratorExp: "one statement for each element",
    ast.List: "variables, vec2 and vec3, or a tuple of options",
    ast.Set: "a tuple of options, as in self.form in ('a', 'b')",
    ast.Dict: "variables, or 'if' on an option",
    ast.JoinedStr: "the option itself, as in self.form == 'a'; a shader has no text",
    ast.Try: "nothing; shaders have no exceptions",
    ast.Raise: "the check in check_together; shaders have no exceptions",
    ast.Assert: "the check in check_together; shaders have no exceptions",
    ast.With: "plain statements",
    ast.FunctionDef: "a function of the module or a method",
    ast.AsyncFunctionDef: "a function of the module or a method",
    ast.ClassDef: "a class of the module",
    ast.Import: "the import at the top of the file",
    ast.ImportFrom: "the import at the top of the file",
    ast.Match: "if and elif on an option",
    ast.Delete: "nothing; names that are not used cost nothing",
    ast.Subscript: "v.x, v.y, v.z, unpack the results (a, b = f(x)), or decide with 'if' on an option",
    ast.NamedExpr: "an assignment of its own",
    ast.Starred: "each value by its name",
    ast.Yield: "return",
    ast.YieldFrom: "return",
    ast.Await: "the call alone",
    ast.Global: "a named number of the module, which is never changed",
    ast.Nonlocal: "a named number of the module, which is never changed",
}

# The same for Python's own functions.
BUILTINS = {
    "abs": "absolute(x)",
    "min": "minimum(a, b)",
    "max": "maximum(a, b)",
    "pow": "power(x, exponent)",
    "sum": "a + b + c",
    "float": "the value alone; all numbers are floats",
    "int": "x - fract(x) for the whole part",
    "round": "x + 0.5 - fract(x + 0.5)",
    "divmod": "fract, and what is left",
    "bool": "a comparison",
    "tuple": "return a, b",
    "print": "nothing; a shader cannot print",
    "len": "the number itself",
    "zip": "one statement for each element",
    "enumerate": "for i in range(8): ...",
    "super": "super().name(...), which calls a method of a class above; properties and functions have none",
}


class Collector(Protocol):
    """Where the functions and structs that an expression needs are collected, each once."""

    lacking: frozenset[str]
    """Functions of the vocabulary that are taken from the library."""
    sample: Struct
    """The struct of a sampled direction."""
    differentiable: bool
    """Whether the language takes derivatives of the text."""

    def origin(self, function: Function) -> types.FunctionType | None:
        """The Python function that an exported one was read from."""
        ...

    def function_for(
        self,
        function: types.FunctionType,
        arguments: Iterable[Type | Static],
        owner: Struct | None = None,
        method: str = "",
        guarded: bool = True,
    ) -> Function:
        """A Python function as it is for some types of arguments."""
        ...

    def is_open(
        self, function: types.FunctionType, arguments: Iterable[Type | Static], owner: Struct | None
    ) -> bool:
        """Whether the function is being read, so that to call it would be to call itself."""
        ...

    def record(self, cls: type, given: tuple[Type | Static, ...]) -> Struct:
        """The struct of a NamedTuple with these types of members."""
        ...

    def results(self, function: str, names: tuple[str, ...], given: tuple[Type, ...]) -> Struct:
        """The struct for several results of a function."""
        ...

    def power(self, exponent: int, kind: Type) -> Function:
        """A function that multiplies a value with itself."""
        ...

    def lookup(self, function: types.FunctionType) -> Function:
        """What the host supplies under this declaration."""
        ...

    def table(self, table: Table, owner: Struct | None) -> Function:
        """What reads an entry of a table, which may be one of a model's class."""
        ...


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

    def refuse(self, node: ast.AST, message: str) -> NoReturn:
        """Raise an error that shows the place."""
        raise self.source.complaint(node, message)

    def _unknown(self, node: ast.AST) -> NoReturn:
        instead = INSTEAD.get(type(node), "assignments, returns and calls (docs/language.md)")
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(node).__name__).lower()
        self.refuse(node, f"this ({kind}) cannot be exported; write {instead}.")

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
                instead = (
                    f"write {float(value.value)}, or decide with 'if'"
                    if isinstance(value.value, (bool, np.number))
                    else "write numbers, vectors or masks, and decide with 'if' on an option"
                )
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
            test = self._decided(node.test, self.value(node.test))
            if test is not None:
                return self.value(node.body if test else node.orelse)
        self._unknown(node)

    def _decided(self, node: ast.AST, value: Value) -> bool | None:
        """What Python's `if` makes of a value; None if it is not known when the shader is made."""
        known = truth(value)
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
    def _call(self, node: ast.Call) -> Value:
        """Read a call."""

    @abstractmethod
    def _property(self, node: ast.Attribute, model: Expr, found: property) -> Value:
        """Read the value of a model's property."""

    def _either(self, node: ast.BoolOp) -> Value:
        """a or b, a and b: one of the two values, as in Python."""
        for i, operand in enumerate(node.values):
            value = self.value(operand)
            known = self._decided(operand, value)
            last = i == len(node.values) - 1
            if known is None and not (last and i):
                self.refuse(node, "'and' and 'or' are for options; masks are joined with & and |.")
            if last or known is None or known is isinstance(node.op, ast.Or):
                return value
        raise AssertionError("no operands")

    # --- names -------------------------------------------------------------------------------------

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
            found = vars(kind.python).get(node.attr) if kind.python is not None else None
            if isinstance(found, types.FunctionType):
                return Method(expr, node.attr, found)
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
        if isinstance(found, property):
            return self._property(node, expr, found)
        if isinstance(found, staticmethod):
            return Static(found.__func__)
        if isinstance(found, types.FunctionType):
            return Method(expr, name, found)
        if isinstance(found, (functools.cached_property, classmethod)) or (
            hasattr(found, "__get__") and not isinstance(found, type)
        ):
            kind = type(found).__name__
            self.refuse(node, f"{name!r} is a {kind}; write a method, or a plain @property.")
        if is_number(found):
            wrong = misfit(found)
            if wrong:
                self.refuse(node, f"{name}: {wrong}.")
            self._check_spelling(node, name)
            return Constant(name, found)
        return Static(found)

    # --- operators ---------------------------------------------------------------------------------

    def _unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            known = self._decided(node.operand, value)
            if known is None:
                self.refuse(node, "'not' is for options; a mask is inverted with ~.")
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
        if isinstance(op, ast.Pow):
            return self._power_of_numbers(node, left, right)
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

    def _power_of_numbers(self, node: ast.AST, left: Expr, right: Expr) -> Number:
        try:
            base, exponent = exact(left), exact(right)
            if base is None or exponent is None:
                self.refuse(node, "** is for numbers; write x * x, or power(x, exponent).")
            if abs(exponent) > 4096:  # else Python may compute for hours
                raise OverflowError
            return self._number(node, base**exponent)
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

    def _compare(self, node: ast.Compare) -> Value:
        if len(node.ops) != 1:
            self.refuse(node, "one comparison at a time; join two with &: (a < b) & (b < c).")
        left, right = self.value(node.left), self.value(node.comparators[0])
        op = node.ops[0]
        if isinstance(left, Static) or isinstance(right, Static):
            one, other = truth(left), truth(right)
            if one is None or other is None:
                self.refuse(node, "an option is compared with its values only.")
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
