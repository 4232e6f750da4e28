"""Names, types and expressions of the checked tree as text; statements follow in `gonio.export.printer`."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from gonio.export.names import Names, legal
from gonio.export.targets import Target
from gonio.export.tree import (
    CALLED,
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

# Precedence: a part is bracketed where it binds less tightly than its place asks.
ANY, TERNARY, OR, AND, COMPARED, SUM, PRODUCT, SIGN, POSTFIX = range(9)
LEVELS = {"||": OR, "&&": AND, "+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT}


def number(value: float, suffix: str) -> str:
    """The shortest text that a float32 reads back as the same value."""
    with np.errstate(over="ignore"):
        single = np.float32(value)
    if not np.isfinite(single):
        raise ExportError(
            f"the number {value!r} does not fit into a float32; shaders compute in it."
        )
    if single == 0 and value != 0:
        raise ExportError(
            f"the number {value!r} is 0 in a float32; shaders compute in it. Use at least 1e-38."
        )
    size = abs(float(single))
    if size != 0 and not 1e-4 <= size < 1e7:
        mantissa, _, exponent = np.format_float_scientific(single, unique=True, trim="0").partition(
            "e"
        )
        text = f"{mantissa}e{int(exponent)}"
    else:
        text = np.format_float_positional(single, unique=True, trim="0")
    return text + suffix


class ExpressionPrinter:
    """Writes names, types and expressions in one language."""

    def __init__(
        self,
        target: Target,
        prefix: str,
        functions: Sequence[Function] = (),
        structs: Sequence[Struct] = (),
    ) -> None:
        """Begin a text of some functions and structs; the prefix is that of helpers."""
        self.target = target
        self.prefix = prefix
        self.helpers: dict[str, None] = {}
        self.functions = functions
        self.structs = structs
        spelled = [*target.spellings.values(), target.select, target.select3, target.splat]
        spelled += [*target.comparisons.values(), target.select_computed, target.to_float]
        spelled.append(f"{target.whole}()")
        # What the text calls: a variable of the same name would hide it
        called = set(re.findall(r"(\w+)\(", " ".join(spelled)))
        called |= {f.name for f in functions} | {s.name for s in structs}
        called |= {f"{prefix}_{name}" for name in target.helpers} | {SELF}
        self.reserved = target.reserved | called | set(target.types.values())
        self.members: dict[int, dict[str, str]] = {}
        self.names: dict[str, str] = {}  # of variables in the function at hand
        self.constant_names: dict[tuple[str, float], str] = {}
        self.taken = Names(self.reserved)
        self.inside: Function | None = None
        self.said: set[tuple[str, ...]] = set()  # comments of numbers that are in the text

    # --- types and names ---------------------------------------------------------------------------

    def type(self, kind: Type) -> str:
        """How a type is written."""
        if isinstance(kind, Struct):
            return kind.name
        if kind in ("vec2", "vec3", "bool3"):
            self._need(str(kind))
        return self.target.types[kind]

    def _need(self, helper: str) -> None:
        if helper in self.target.helpers:
            self.helpers[helper] = None
            if helper.endswith("3"):  # a function on colours is made of the one on numbers
                self._need(helper[:-1])

    def name(self, name: str) -> str:
        """A variable's name, changed where the language has a meaning of its own for it."""
        return self.names.get(name) or legal(name, self.reserved)

    def member(self, struct: Struct, name: str) -> str:
        """The name of a struct's member."""
        if id(struct) not in self.members:
            taken = {struct.name}
            if self.target.methods:  # what callers call keeps its name, and members give way
                called = (f for f in self.functions if f.owner is struct)
                taken |= {f.method for f in called if f.method in CALLED}
            names = Names(self.target.reserved | set(self.target.types.values()) | taken)
            self.members[id(struct)] = {m.name: names.give(m.name) for m in struct.members}
        return self.members[id(struct)][name]

    def path(self, struct: Struct, path: str) -> str:
        """A path such as "base.rho" with the names of the members."""
        found = []
        for part in path.split("."):
            found.append(self.member(struct, part))
            kind = next(m.type for m in struct.members if m.name == part)
            struct = kind if isinstance(kind, Struct) else struct
        return ".".join(found)

    def spoken(self) -> dict[str, str]:
        """What comments call functions and numbers, and what these are called in the text."""
        owner = self.inside.owner if self.inside is not None else None
        found: dict[str, str] = {}
        for function in self.functions:
            if self.inside is None or function.owner is None or function.owner is owner:
                methods = self.target.methods and function.owner is not None
                name = self._method(function) if methods else function.name
                if function.owner is owner or function.plain not in found:
                    found[function.plain] = name
        family = self.inside.plain.rpartition(".")[0] if self.inside is not None else ""
        for function in self.functions if family else ():
            of, _, own = function.plain.rpartition(".")
            if of == family:  # a method's comment names its sisters without their class
                found[own] = function.name
        found |= {s.python.__name__: s.name for s in self.structs if s.python is not None}
        found |= {name: printed for (name, _), printed in self.constant_names.items()}
        return found | self.names

    # --- expressions -------------------------------------------------------------------------------

    def expr(self, expr: Expr, level: int = ANY) -> str:
        """An expression, bracketed if it binds less tightly than `level`."""
        text, own = self._expr(expr)
        return f"({text})" if own < level else text

    def _expr(self, expr: Expr) -> tuple[str, int]:
        if isinstance(expr, Number):
            text = number(expr.value, self.target.suffix)
            return text, SIGN if text.startswith("-") else POSTFIX
        if isinstance(expr, Constant):
            return self.constant_names[expr.name, expr.value], POSTFIX
        if isinstance(expr, Variable):
            if self._is_this(expr):
                return "this", POSTFIX
            if expr.name == SELF:
                return SELF, POSTFIX
            return self.name(expr.name), POSTFIX
        if isinstance(expr, Access):
            return f"{self.expr(expr.value, POSTFIX)}.{self._member(expr)}", POSTFIX
        if isinstance(expr, Negation):
            return self._negation(expr)
        if isinstance(expr, Operation):
            return self._operation(expr)
        if isinstance(expr, Splat):
            self._need("splat")
            kind = self.type(expr.type)
            if self.target.splat_plain and _is_plain(expr.value):
                value = self.expr(expr.value)
                return self.target.splat_plain.format(value, type=kind), POSTFIX
            level = POSTFIX if self.target.splat.startswith("{0}") else ANY
            return self.target.splat.format(self.expr(expr.value, level), type=kind), POSTFIX
        if isinstance(expr, Builtin):
            return self._builtin(expr)
        if isinstance(expr, Construction):
            return self._construction(expr)
        return self._call(expr)

    def _member(self, expr: Access) -> str:
        """Components have their own names; members of structs may need another one."""
        kind = expr.value.type
        return self.member(kind, expr.name) if isinstance(kind, Struct) else expr.name

    def _is_this(self, expr: Expr) -> bool:
        return (
            self.target.methods
            and isinstance(expr, Variable)
            and expr.name == SELF
            and self.inside is not None
            and self.inside.owner is not None
        )

    def _negation(self, expr: Negation) -> tuple[str, int]:
        if expr.type == "bool3":
            raise ExportError("a mask of a colour cannot be inverted; swap the branches of select.")
        symbol = "!" if expr.type == "bool" else "-"
        if expr.type == "vec3":
            self._need("-vec3")
        # A sign before a sign would read as a decrement
        inner = self.expr(expr.value, SIGN + 1 if _signed(expr.value) else SIGN)
        return f"{symbol}{inner}", SIGN

    def _operation(self, expr: Operation) -> tuple[str, int]:
        left, right = expr.left, expr.right
        if expr.operator not in LEVELS:
            return self._comparison(expr)
        if not self.target.mixed and left.type != right.type:
            left, right = (e if e.type == expr.type else Splat(e, expr.type) for e in (left, right))
        self._need(f"{left.type}{expr.operator}{right.type}")
        level = LEVELS[expr.operator]
        if level in (OR, AND):
            # Different ones are bracketed: some compilers demand it, and readers are glad
            parts = [
                self.expr(e, level if _joins(e) in ("", expr.operator) else POSTFIX)
                for e in (left, right)
            ]
            return f" {expr.operator} ".join(parts), level
        # Floating-point sums and products are not associative: the right one keeps its brackets
        return f"{self.expr(left, level)} {expr.operator} {self.expr(right, level + 1)}", level

    def _comparison(self, expr: Operation) -> tuple[str, int]:
        spelling = self.target.comparisons.get(expr.operator)
        if expr.left.type == "vec3" and self.target.comparisons and spelling is None:
            raise ExportError(
                f"{self.target.title} cannot compare colours by {expr.operator}; use < or >=."
            )
        if expr.left.type == "vec3" and spelling is not None:
            text = self._spelled(spelling, self.expr(expr.left), self.expr(expr.right))
            return text, POSTFIX
        if expr.type == "bool3":
            self.type("bool3")
        self._need(f"{expr.left.type}{expr.operator}{expr.right.type}")
        left, right = self.expr(expr.left, SUM), self.expr(expr.right, SUM)
        return f"{left} {expr.operator} {right}", COMPARED

    def _spelled(self, spelling: str, *arguments: str) -> str:
        for helper in re.findall(r"\{p\}_(\w+)", spelling):
            self._need(helper)
        return spelling.format(*arguments, p=self.prefix)

    def _builtin(self, expr: Builtin) -> tuple[str, int]:
        arguments = expr.arguments
        if expr.name == "select":
            return self._select(expr)
        if expr.name in ("safe_sqrt", "smooth_sqrt") and "safe_sqrt" in self.target.helpers:
            helper = "safe_sqrt3" if expr.type == "vec3" else "safe_sqrt"
            return self._spelled(f"{{p}}_{helper}({{0}})", self.expr(arguments[0])), POSTFIX
        if expr.name == "safe_sqrt":
            zero: Expr = Number(0)
            if expr.type != "float":
                zero = Splat(zero, expr.type)
            bounded = Builtin("maximum", (arguments[0], zero), expr.type)
            return self._builtin(Builtin("sqrt", (bounded,), expr.type))
        if expr.name == "smooth_sqrt":  # its derivative is Python's matter
            return self._builtin(Builtin("sqrt", arguments, expr.type))
        spelling = self.target.spellings.get(expr.name)
        if expr.name == "fma" and spelling is None:
            product = Operation("*", arguments[0], arguments[1], expr.type)
            return self._operation(Operation("+", product, arguments[2], expr.type))
        if spelling is None:
            raise ExportError(f"{self.target.title} has no {expr.name!r}.")
        texts = [self.expr(a) for a in arguments]
        if expr.name in self.target.untyped and all(map(_is_constant, arguments)):
            texts[0] = self.target.to_float.format(texts[0])
        if expr.type == "vec3" and f"{expr.name}3" in self.target.helpers:
            self._need(f"{expr.name}3")
            return f"{expr.name}({', '.join(texts)})", POSTFIX
        self._need(expr.name)
        return self._spelled(spelling, *texts), POSTFIX

    def _select(self, expr: Builtin) -> tuple[str, int]:
        condition, yes, no = expr.arguments
        spelling = self.target.select
        if expr.type != "float" and not (_is_plain(yes) and _is_plain(no)):
            spelling = self.target.select_computed or spelling
        if condition.type == "bool3":
            spelling = self.target.select3
            self._need("select3")
        if spelling:
            mask = {"float": "", "vec2": "bvec2", "vec3": "bvec3"}[str(expr.type)]
            texts = [self.expr(e) for e in (condition, yes, no)]
            if "{mask}" in spelling and not mask:
                spelling = spelling.replace("{mask}({0})", "{0}")
            return self._spelled(spelling.replace("{mask}", mask), *texts), POSTFIX
        test = self.expr(condition, OR)
        return f"{test} ? {self.expr(yes, OR)} : {self.expr(no, TERNARY)}", TERNARY

    def _construction(self, expr: Construction) -> tuple[str, int]:
        arguments = ", ".join(self._listed(expr.arguments))
        kind = self.type(expr.type)
        if isinstance(expr.type, Struct):
            if not self.target.record:
                raise AssertionError(f"{kind} is made in a statement of its own")
            return self.target.record.format(type=kind, arguments=arguments), POSTFIX
        if expr.type == "vec2" and self.target.types["vec2"] == self.target.types["vec3"]:
            arguments += f", {number(0, self.target.suffix)}"  # no type for two numbers
        alike = len({a.value if isinstance(a, Number) else a for a in expr.arguments}) == 1
        if alike and self.target.splat == "{type}({0})" and isinstance(expr.arguments[0], Number):
            arguments = self.expr(expr.arguments[0])
        return self.target.vector.format(type=kind, arguments=arguments), POSTFIX

    def _listed(self, arguments: Sequence[Expr]) -> list[str]:
        """Arguments as they stand between commas.

        Of several comparisons each is bracketed: f(a < b, c > d) has a template a<b, c> in WGSL.
        """
        several = sum(a.type in ("bool", "bool3") for a in arguments) > 1
        return [self.expr(a, SUM if several else ANY) for a in arguments]

    def _call(self, expr: Call) -> tuple[str, int]:
        arguments = self._listed(expr.arguments)
        if self.target.methods and expr.function.owner is not None:
            model = self.expr(expr.arguments[0], POSTFIX)
            return f"{model}.{self._method(expr.function)}({', '.join(arguments[1:])})", POSTFIX
        return f"{expr.function.name}({', '.join(arguments)})", POSTFIX

    def _method(self, function: Function) -> str:
        assert function.owner is not None
        name = function.method.strip("_")
        taken = {self.member(function.owner, m.name) for m in function.owner.members}
        # As methods they may be called what is reserved elsewhere, such as sample
        reserved = frozenset() if name in CALLED else self.target.reserved
        return legal(name, reserved | taken)


def _is_plain(expr: Expr) -> bool:
    """Whether it takes no computation: a name, a number, a member."""
    if isinstance(expr, (Access, Negation, Splat)):
        return _is_plain(expr.value)
    return isinstance(expr, (Number, Constant, Variable))


def _is_constant(expr: Expr) -> bool:
    """Whether it is a number made of numbers alone, without a variable."""
    if isinstance(expr, Negation):
        return _is_constant(expr.value)
    if isinstance(expr, Operation):
        return _is_constant(expr.left) and _is_constant(expr.right)
    if isinstance(expr, Builtin):
        return all(map(_is_constant, expr.arguments))
    return isinstance(expr, (Number, Constant))


def _signed(expr: Expr) -> bool:
    """Whether its text begins with a sign."""
    if isinstance(expr, Number):
        return math.copysign(1, expr.value) < 0
    return isinstance(expr, Negation)


def _joins(expr: Expr) -> str:
    """The operator by which an expression joins masks, if it does."""
    if isinstance(expr, Operation) and expr.operator in ("&&", "||"):
        return expr.operator
    return ""
