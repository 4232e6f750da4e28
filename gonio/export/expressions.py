"""From Python expressions to typed ones: names, arithmetic, comparisons and calls.

An expression is something that has a value in the shader, or something that only the exporter sees:
options, modules, functions. `gonio.export.statements` reads what stands around expressions.
"""

from __future__ import annotations

import ast
import inspect
import operator
import re
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn, Protocol, cast

from gonio import lang
from gonio.export import library
from gonio.export.source import Source, source
from gonio.export.tree import (
    SELF,
    Access,
    Builtin,
    Call,
    Constant,
    Construction,
    ExportError,
    Expr,
    Function,
    Negation,
    Number,
    Operation,
    Splat,
    Struct,
    Type,
    Variable,
)
from gonio.export.vocabulary import RULES, VECTORS, widest
from gonio.fields import Parameter
from gonio.model import Model

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

ARITHMETIC: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
COMPARISON: dict[type, str] = {
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
    ast.IfExp: "select(condition, yes, no), which computes both",
    ast.Lambda: "a function with a name",
    ast.ListComp: "one statement for each element",
    ast.GeneratorExp: "one statement for each element",
    ast.List: "variables, or vec2 and vec3",
    ast.Dict: "variables",
    ast.JoinedStr: "nothing; text has no meaning in a shader",
    ast.Try: "nothing; shaders have no exceptions",
    ast.Raise: "the check in __init__; shaders have no exceptions",
    ast.Assert: "the check in __init__; shaders have no exceptions",
    ast.With: "plain statements",
    ast.FunctionDef: "a function of the module or a method",
    ast.Subscript: "v.x, v.y, v.z, or unpack the results: a, b = f(x)",
    ast.NamedExpr: "an assignment of its own",
    ast.Global: "a named number of the module, which is never changed",
    ast.AugAssign: "x = x + ...",
    ast.AnnAssign: "x = ...",
}


@dataclass(frozen=True)
class Static:
    """A value that is known when the shader is made: an option, a module, a function."""

    value: Any


@dataclass(frozen=True)
class Method:
    """A method of a model that is not called yet."""

    model: Expr
    name: str


@dataclass(frozen=True)
class Many:
    """Several values, as `return a, b` gives them."""

    values: tuple[Expr, ...]


Value = Expr | Static | Method | Many


class Collector(Protocol):
    """Where the functions that an expression calls are collected, each once."""

    lacking: frozenset[str]
    """Functions of the vocabulary that are taken from the library."""
    sample: Struct
    """The struct of a sampled direction."""

    def function_for(
        self,
        function: types.FunctionType,
        arguments: Iterable[Type | Static],
        owner: Struct | None = None,
        method: str = "",
    ) -> Function:
        """A Python function as it is for some types of arguments."""
        ...

    def results(self, function: str, names: tuple[str, ...], given: tuple[Type, ...]) -> Struct:
        """The struct for several results of a function."""
        ...


class Changed(Variable):
    """A copy of a model's struct with other members: only as a whole statement."""

    model: Expr
    members: dict[str, Expr]

    def __init__(self, model: Expr, kind: Type, members: dict[str, Expr]) -> None:
        """Of a model's value, with some members changed."""
        super().__init__("rougher", kind)
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "members", members)


class Expressions:
    """Reads the expressions of one function."""

    def __init__(
        self, reader: Collector, function: types.FunctionType, owner: Struct | None
    ) -> None:
        """Begin a function, which may be the method of a model."""
        self.reader = reader
        self.python = function
        self.source: Source = source(function.__code__.co_filename)
        self.owner = owner
        self.self_name = ""  # what the method calls its model
        self.scope: dict[str, Type | Static] = {}

    def refuse(self, node: ast.AST, message: str) -> NoReturn:
        """Raise an error that shows the place."""
        line, start = getattr(node, "lineno", 1), getattr(node, "col_offset", 0)
        text = self.source.lines[line - 1]
        # ast counts bytes
        column = len(text.encode()[:start].decode(errors="ignore"))
        end = getattr(node, "end_col_offset", start + 1)
        same = getattr(node, "end_lineno", line) == line
        width = len(text.encode()[start:end].decode(errors="ignore")) if same else 1
        marked = f"{text.rstrip()}\n{' ' * column}{'^' * max(width, 1)}"
        raise ExportError(f"{self.source.path}:{line}:{column + 1}: {message}\n{marked}")

    def _unknown(self, node: ast.AST) -> NoReturn:
        instead = INSTEAD.get(type(node), "assignments, returns and calls (docs/language.md)")
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(node).__name__).lower()
        self.refuse(node, f"this ({kind}) cannot be exported; write {instead}.")

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
            if isinstance(value.value, bool) or not isinstance(value.value, (int, float)):
                self.refuse(node, f"{shown(value.value)} has no value in a shader.")
            return Number(float(value.value))
        if isinstance(value, Method):
            self.refuse(node, "a method must be called.")
        if isinstance(value, Many):
            self.refuse(node, "several values where one is expected; unpack them first.")
        return value

    def value(self, node: ast.expr) -> Value:
        """Read an expression, which may be something that only the exporter sees."""
        if isinstance(node, ast.Constant):
            if isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
                return Number(float(node.value))
            return Static(node.value)
        if isinstance(node, ast.Name):
            return self._name(node)
        if isinstance(node, ast.Attribute):
            return self._attribute(node)
        if isinstance(node, ast.UnaryOp):
            return self._unary(node)
        if isinstance(node, ast.BinOp):
            return self._binary(node)
        if isinstance(node, ast.BoolOp):
            values = [self.value(v) for v in node.values]
            if not all(isinstance(v, Static) for v in values):
                self.refuse(node, "'and' and 'or' are for options; masks are joined with & and |.")
            known = [v.value for v in values if isinstance(v, Static)]
            return Static(all(known) if isinstance(node.op, ast.And) else any(known))
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
            test = self.value(node.test)
            if isinstance(test, Static):
                return self.value(node.body if test.value else node.orelse)
        self._unknown(node)

    def _static_number(self, node: ast.expr) -> float:
        value = self.value(node)
        if isinstance(value, (Number, Constant)):
            return value.value
        if isinstance(value, Static) and isinstance(value.value, (int, float)):
            return float(value.value)
        self.refuse(node, "this number must be known when the shader is made.")

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.scope:
            known = self.scope[node.id]
            if isinstance(known, Static):
                return known
            return Variable(SELF if node.id == self.self_name else node.id, known)
        names = self.python.__globals__
        if node.id not in names:
            self.refuse(node, f"{node.id!r} is not known here; shaders have no Python builtins.")
        return self._global(node.id, names[node.id], self.source)

    def _global(self, name: str, value: Any, file: Source) -> Value:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            if not name.isascii() or "__" in name:
                raise ExportError(f"{file.path}: shading languages do not take the name {name!r}.")
            return Constant(name, float(value), comments_of(name, file))
        return Static(value)

    def _attribute(self, node: ast.Attribute) -> Value:
        value = self.value(node.value)
        if isinstance(value, Static):
            if not hasattr(value.value, node.attr):
                self.refuse(node, f"{shown(value.value)} has no {node.attr!r}.")
            found = getattr(value.value, node.attr)
            if isinstance(value.value, types.ModuleType):
                return self._global(node.attr, found, source(str(value.value.__file__)))
            return Static(found)
        expr = self._expr(node.value, value)
        kind = expr.type
        if isinstance(kind, Struct):
            for member in kind.members:
                if member.name == node.attr:
                    return Access(expr, member.name, member.type)
            if kind.model is not None:
                return self._of_model(node, expr, kind.model)
        elif kind in ("vec2", "vec3") and node.attr in "xyz"[: VECTORS[str(kind)]]:
            return Access(expr, node.attr, "float")
        self.refuse(node, f"a {spoken(kind)} has no {node.attr!r}.")

    def _of_model(self, node: ast.Attribute, expr: Expr, model: Model) -> Value:
        if not hasattr(model, node.attr):
            self.refuse(node, f"{model.name} has no {node.attr!r}.")
        found = getattr(model, node.attr)
        if callable(found):
            return Method(expr, node.attr)
        if isinstance(found, (int, float)) and not isinstance(found, bool):
            return Constant(node.attr, float(found))
        return Static(found)

    def _unary(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(value, Static) and isinstance(node.op, ast.Not):
            return Static(not value.value)
        if isinstance(node.op, ast.Not):
            self.refuse(node, "'not' is for options; a mask is inverted with ~.")
        expr = self._expr(node.operand, value)
        if isinstance(node.op, ast.UAdd):
            return expr
        masks = expr.type in ("bool", "bool3")
        wrong = isinstance(expr.type, Struct) or expr.type == "vec2"
        if masks != isinstance(node.op, ast.Invert) or wrong:
            self.refuse(node, f"this cannot be done with a {spoken(expr.type)}.")
        if isinstance(expr, Number):
            return Number(-expr.value)
        return Negation(expr, expr.type)

    def _binary(self, node: ast.BinOp) -> Value:
        left, right = self.expr(node.left), self.expr(node.right)
        kinds = (left.type, right.type)
        if isinstance(node.op, ast.Pow):
            if not all(isinstance(e, (Number, Constant)) for e in (left, right)):
                self.refuse(node, "** is for numbers; write x * x, or power(x, exponent).")
            return Number(self._static_number(node.left) ** self._static_number(node.right))
        if isinstance(node.op, (ast.BitAnd, ast.BitOr)):
            if kinds != ("bool", "bool"):
                self.refuse(node, "& and | join two masks of numbers.")
            return Operation("&&" if isinstance(node.op, ast.BitAnd) else "||", left, right, "bool")
        symbol = ARITHMETIC.get(type(node.op))
        if symbol is None:
            self.refuse(node, "only + - * / can be exported, and & | ~ for masks.")
        if "vec2" in kinds:
            self.refuse(node, "a Vec2 is a pair of numbers; compute with its x and y.")
        if any(k not in ("float", "vec3") for k in kinds):
            self.refuse(node, f"a {spoken(kinds[0])} {symbol} a {spoken(kinds[1])} has no meaning.")
        return self._simplified(symbol, left, right, widest(kinds))

    @staticmethod
    def _simplified(symbol: str, left: Expr, right: Expr, kind: Type) -> Expr:
        """0 * x is 0 and 0 + x is x: in Python they give a number the shape of an array."""

        def is_zero(expr: Expr) -> bool:
            inner = expr.value if isinstance(expr, Splat) else expr
            return isinstance(inner, Number) and inner.value == 0

        def wide(expr: Expr) -> Expr:
            return expr if expr.type == kind else Splat(expr, kind)

        if symbol == "*" and (is_zero(left) or is_zero(right)):
            return wide(Number(0))
        if symbol == "+" and (is_zero(left) or is_zero(right)):
            return wide(right if is_zero(left) else left)
        if symbol == "-" and is_zero(right):
            return wide(left)
        if symbol == "-" and is_zero(left) and isinstance(right, Number):
            return wide(Number(-right.value))
        return Operation(symbol, left, right, kind)

    def _compare(self, node: ast.Compare) -> Value:
        if len(node.ops) != 1:
            self.refuse(node, "one comparison at a time; join two with &.")
        left, right = self.value(node.left), self.value(node.comparators[0])
        op = type(node.ops[0])
        if isinstance(left, Static) or isinstance(right, Static):
            if not (isinstance(left, Static) and isinstance(right, Static)):
                self.refuse(node, "an option is compared with its values only.")
            return Static(STATIC_COMPARISON[op](left.value, right.value))
        a = self._expr(node.left, left)
        b = self._expr(node.comparators[0], right)
        if op not in COMPARISON or any(e.type not in ("float", "vec3") for e in (a, b)):
            self.refuse(node, f"a {spoken(a.type)} and a {spoken(b.type)} cannot be compared.")
        kind = widest((a.type, b.type))
        a, b = self._coerce(node, a, kind), self._coerce(node, b, kind)
        return Operation(COMPARISON[op], a, b, "bool3" if kind == "vec3" else "bool")

    # --- calls ---

    def _call(self, node: ast.Call) -> Value:
        above = self._inherited(node.func)
        if above is not None and self.owner is not None:
            return self._inherited_call(node, above, self.owner, node.args)
        callee = self.value(node.func)
        if isinstance(callee, Method):
            return self._method_call(node, callee)
        if not isinstance(callee, Static):
            self.refuse(node, "this cannot be called.")
        function = callee.value
        name = getattr(function, "__name__", "")
        if function is lang.Sample:
            arguments = self._arguments(node, ["wi", "pdf"], {})
            wi, pdf = (self._expr(n, v) for n, v in arguments)
            wi = self._coerce(node, wi, "vec3")
            return Construction((wi, self._coerce(node, pdf, "float")), self.reader.sample)
        if isinstance(function, types.FunctionType):
            if self.owner is not None and self._is_method_of_a_class(node, function):
                return self._inherited_call(node, function, self.owner, node.args[1:])
            if function.__module__ == lang.__name__ and name in RULES:
                return self._builtin(node, name)
            if self._is_ours(function):
                return self._function_call(node, function)
        self.refuse(
            node.func,
            f"{ast.unparse(node.func)} is not in the vocabulary; use the functions of gonio.lang, or "
            "your own functions made of them.",
        )

    def _inherited(self, node: ast.expr) -> types.FunctionType | None:
        """The method behind super().name, if that is what is called."""
        if not (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Call)
            and isinstance(node.value.func, ast.Name)
            and node.value.func.id == "super"
            and self.owner is not None
        ):
            return None
        classes = type(self.owner.model).__mro__
        here = next(
            i
            for i, cls in enumerate(classes)
            if any(inspect.unwrap(f) is self.python for f in vars(cls).values() if callable(f))
        )
        for cls in classes[here + 1 :]:
            if node.attr in vars(cls) and cls is not Model:
                return cast(types.FunctionType, vars(cls)[node.attr])
        self.refuse(node, f"no class above this one has a method {node.attr!r}.")

    def _is_method_of_a_class(self, node: ast.Call, function: types.FunctionType) -> bool:
        """Whether a call is Class.method(self, ...), with a model's class."""
        first = node.args[0] if node.args else None
        is_self = isinstance(first, ast.Name) and first.id == self.self_name
        return is_self and (function.__name__ in SIGNATURES and hasattr(function, "__wrapped__"))

    def _inherited_call(
        self,
        node: ast.Call,
        function: types.FunctionType,
        owner: Struct,
        arguments: Sequence[ast.expr],
    ) -> Expr:
        """A method of a class above, for this model: its own function beside the one that replaces it."""
        plain = cast(types.FunctionType, inspect.unwrap(function))
        names = list(inspect.signature(plain).parameters)[1:]
        call = ast.copy_location(ast.Call(node.func, list(arguments), node.keywords), node)
        passed, kinds = self._typed(self._arguments(call, names, {}))
        made = self.reader.function_for(plain, kinds, owner)
        return Call(made, (Variable(SELF, owner), *passed), made.result)

    @staticmethod
    def _is_ours(function: types.FunctionType) -> bool:
        """Whether it is a function of gonio's parts, or of the model's own files."""
        package = function.__module__.partition(".")[0]
        path = function.__code__.co_filename
        if package == "gonio":
            return (
                ".parts." in function.__module__
                or ".models." in function.__module__
                or (function.__module__ == library.__name__)
            )
        return "site-packages" not in path and "/lib/python" not in path and path.endswith(".py")

    def _arguments(
        self, node: ast.Call, names: list[str], defaults: Mapping[str, Any]
    ) -> list[tuple[ast.expr, Value]]:
        given: dict[str, tuple[ast.expr, Value]] = {}
        if len(node.args) > len(names):
            self.refuse(node, f"{len(names)} arguments are expected: {', '.join(names)}.")
        for name, argument in zip(names, node.args, strict=False):
            if isinstance(argument, ast.Starred):
                self.refuse(argument, "name each argument.")
            given[name] = (argument, self.value(argument))
        for keyword in node.keywords:
            if keyword.arg is None or keyword.arg not in names or keyword.arg in given:
                self.refuse(node, f"the arguments are {', '.join(names)}.")
            given[keyword.arg] = (keyword.value, self.value(keyword.value))
        for name, default in defaults.items():
            if name not in given:
                number = isinstance(default, (int, float)) and not isinstance(default, bool)
                given[name] = (node, Number(float(default)) if number else Static(default))
        missing = [n for n in names if n not in given]
        if missing:
            self.refuse(node, f"{', '.join(missing)} missing.")
        return [given[n] for n in names]

    def _typed(
        self, arguments: list[tuple[ast.expr, Value]]
    ) -> tuple[list[Expr], list[Type | Static]]:
        """Arguments that are passed, and what a function is specialised for."""
        passed: list[Expr] = []
        kinds: list[Type | Static] = []
        for node, value in arguments:
            if isinstance(value, Static) and not isinstance(value.value, (int, float)):
                kinds.append(value)
                continue
            expr = self._expr(node, value)
            passed.append(expr)
            kinds.append(expr.type)
        return passed, kinds

    def _function_call(self, node: ast.Call, function: types.FunctionType) -> Expr:
        signature = inspect.signature(function)
        defaults = {
            n: p.default for n, p in signature.parameters.items() if p.default is not p.empty
        }
        arguments = self._arguments(node, list(signature.parameters), defaults)
        passed, kinds = self._typed(arguments)
        made = self.reader.function_for(function, kinds)
        return Call(made, tuple(passed), made.result)

    def _method_call(self, node: ast.Call, method: Method) -> Value:
        owner = method.model.type
        assert isinstance(owner, Struct)
        if method.name == "at_least_as_rough":
            return self._rougher(node, method.model, owner)
        function = method_of(owner, method.name)
        names = list(inspect.signature(function).parameters)[1:]
        arguments = self._arguments(node, names, {})
        passed, kinds = self._typed(arguments)
        if method.name in SIGNATURES:
            for (name, kind), expr in zip(SIGNATURES[method.name][0], passed, strict=True):
                if expr.type != kind:
                    self.refuse(node, f"{name} must be a {spoken(kind)}.")
            made = self.reader.function_for(function, kinds, owner, method.name)
        else:
            made = self.reader.function_for(function, kinds, owner)
        return Call(made, (method.model, *passed), made.result)

    def _rougher(self, node: ast.Call, model: Expr, owner: Struct) -> Expr:
        """A copy of a model with wider highlights, each parameter by the function that it declares."""
        ((at, value),) = self._arguments(node, ["alpha"], {})
        alpha = self._expr(at, value)
        assert owner.model is not None
        members: dict[str, Expr] = {}
        for name, declared in owner.model.fields.items():
            if isinstance(declared, Parameter) and declared.rougher is not None:
                own = Access(model, name, "float")
                function = cast(types.FunctionType, declared.rougher)
                made = self.reader.function_for(function, ["float", "float"])
                members[name] = Call(made, (own, alpha), made.result)
        return Changed(model, owner, members) if members else model

    def _builtin(self, node: ast.Call, name: str) -> Expr:
        rule = RULES[name]
        arguments = self._arguments(node, _names(name), {})
        if len(arguments) != rule.count:
            self.refuse(node, f"{name} takes {rule.count} arguments.")
        values = [self._expr(n, v) for n, v in arguments]
        if name in ("vec2", "vec3"):
            kind: Type = "vec2" if name == "vec2" else "vec3"
            if any(v.type != "float" for v in values):
                self.refuse(node, f"{name} takes {rule.count} numbers.")
            return Construction(tuple(values), kind)
        if name == "select":
            return self._select(node, *values)
        kinds = tuple(v.type for v in values)
        allowed = ("float", "vec3") if rule.vectors else ("float",)
        for kind in kinds:
            if kind not in allowed:
                self.refuse(node, f"{name} cannot take a {spoken(kind)}.")
        if name in self.reader.lacking:
            made = self.reader.function_for(getattr(library, name), kinds)
            return Call(made, tuple(values), made.result)
        if rule.splat:
            values = [self._coerce(node, v, widest(kinds)) for v in values]
        return Builtin(name, tuple(values), rule.result(kinds))

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
        kind: Type = "vec3" if condition.type == "bool3" else widest(kinds)
        yes, no = self._coerce(node, yes, kind), self._coerce(node, no, kind)
        return Builtin("select", (condition, yes, no), kind)


def method_of(owner: Struct, name: str) -> types.FunctionType:
    """The function that a model's author wrote, without the contract around it."""
    method = inspect.unwrap(getattr(type(owner.model), "eval" if name == UNTESTED else name))
    if method is inspect.unwrap(Model.albedo):
        return cast(types.FunctionType, library.sampled_albedo)
    if method is inspect.unwrap(Model.mean_albedo) and owner.model is not None:
        raise ExportError(
            f"{owner.model.name} has no closed form of its mean albedo, which shading code cannot "
            "integrate; choose another base, or an option that does not need it."
        )
    if isinstance(method, types.FunctionType):
        return method
    raise ExportError(f"{type(owner.model).__name__}.{name} is no method.")


def _names(builtin: str) -> list[str]:
    return list(inspect.signature(getattr(lang, builtin)).parameters)


def comments_of(name: str, file: Source) -> tuple[str, ...]:
    """The comments of a named number, from the file that defines it."""
    comments = file.constant_comments(name)
    if comments is not None:
        return comments
    module = file.imported_from(name)
    if module is None:
        return ()
    found = inspect.getsourcefile(__import__(module, fromlist=["_"]))
    return () if found is None else comments_of(name, source(found))


def spoken(kind: Type) -> str:
    """A type in words."""
    if isinstance(kind, Struct):
        return kind.name
    return {"float": "number", "bool": "mask", "bool3": "mask of a colour"}.get(kind, kind)


def shown(value: Any) -> str:
    """What only the exporter sees, in words."""
    if isinstance(value, types.ModuleType):
        return f"the module {value.__name__}"
    name = getattr(value, "__name__", None)
    return name if name is not None else repr(value)
