"""From the checked tree to text: one printer for all languages.

It writes brackets only where precedence needs them, keeps names, structure and comments, and knows no
language by name: all that differs is in the tables of `gonio.export.targets`.
"""

from __future__ import annotations

import math
import re
import textwrap
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from gonio import lang
from gonio.export.targets import Target
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
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
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Splat,
    Statement,
    Struct,
    Type,
    Variable,
    rebuilt,
    walk,
)

# Code is folded to WIDTH. Comments may be as wide as they are in gonio's files, and are not folded twice.
WIDTH = 100
COMMENT_WIDTH = 112
INDENT = "    "

# A broken line keeps at least so much in front: a name and an equals sign alone read badly.
BREAK_MIN = 20

# Precedence: a part is bracketed where it binds less tightly than its place asks.
ANY, TERNARY, OR, AND, COMPARED, SUM, PRODUCT, SIGN, POSTFIX = range(9)
LEVELS = {"||": OR, "&&": AND, "+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT}

# Numbers of the vocabulary are written small: many engines have macros called PI or INV_PI.
SHARED_CONSTANTS = frozenset(n for n in vars(lang) if n.isupper())

ASCII = str.maketrans(
    {"–": "-", "—": "-", "−": "-", "·": "*", "∫": "integral of ", "≤": "<=", "≥": ">=", "²": "^2"}
    | {"³": "^3", "π": "pi", "θ": "theta", "φ": "phi", "α": "alpha", "μ": "mu", "τ": "tau"}
    | {"ω": "omega", "σ": "sigma", "ρ": "rho", "×": "x", "’": "'", "“": '"', "”": '"', "…": "..."}
    | {"Λ": "Lambda", "λ": "lambda", "ε": "eps", "δ": "delta", "β": "beta", "η": "eta", "ß": "ss"}
)


def plain_text(text: str) -> str:
    """Text in ASCII, because some compilers stumble over anything else, in comments as well."""
    text = unicodedata.normalize("NFKD", text.translate(ASCII))
    return text.encode("ascii", "ignore").decode()


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


class Printer:
    """Writes structs and functions in one language."""

    def __init__(self, target: Target, prefix: str) -> None:
        """Begin a text; the prefix is that of helpers."""
        self.target = target
        self.prefix = prefix
        self.helpers: dict[str, None] = {}
        # Functions that the text calls: a variable of the same name would hide them
        self.called = set(re.findall(r"(\w+)\(", " ".join(target.spellings.values())))
        self.names: dict[str, str] = {}
        self.inside: Function | None = None
        self.used: set[str] = set()  # names in the function at hand
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
        """A local name, changed where the language has a meaning of its own for it."""
        if name in self.names:
            return self.names[name]
        return f"{name}_" if name in self.target.reserved or name in self.called else name

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
            return self.name(expr.name), POSTFIX
        if isinstance(expr, Variable):
            if self._is_this(expr):
                return "this", POSTFIX
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
            return self.target.splat.format(self.expr(expr.value), type=kind), POSTFIX
        if isinstance(expr, Builtin):
            return self._builtin(expr)
        if isinstance(expr, Construction):
            return self._construction(expr)
        return self._call(expr)

    def _member(self, expr: Access) -> str:
        """Components have their own names; members of structs may need another one."""
        return self.name(expr.name) if isinstance(expr.value.type, Struct) else expr.name

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
        if expr.type == "vec3" and f"{expr.name}3" in self.target.helpers:
            self._need(f"{expr.name}3")
            return f"{expr.name}({', '.join(texts)})", POSTFIX
        self._need(expr.name)
        return self._spelled(spelling, *texts), POSTFIX

    def _select(self, expr: Builtin) -> tuple[str, int]:
        condition, yes, no = expr.arguments
        spelling = self.target.select
        if not (_is_plain(yes) and _is_plain(no)):
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
        arguments = ", ".join(self.expr(a) for a in expr.arguments)
        kind = self.type(expr.type)
        if isinstance(expr.type, Struct):
            if not self.target.record:
                raise ExportError(
                    f"{self.target.title} makes a {kind} in a statement of its own; return it directly."
                )
            return self.target.record.format(type=kind, arguments=arguments), POSTFIX
        if expr.type == "vec2" and self.target.types["vec2"] == self.target.types["vec3"]:
            arguments += f", {number(0, self.target.suffix)}"  # no type for two numbers
        return self.target.vector.format(type=kind, arguments=arguments), POSTFIX

    def _call(self, expr: Call) -> tuple[str, int]:
        arguments = [self.expr(a) for a in expr.arguments]
        if self.target.methods and expr.function.owner is not None:
            model = self.expr(expr.arguments[0], POSTFIX)
            return f"{model}.{self._method(expr.function)}({', '.join(arguments[1:])})", POSTFIX
        return f"{expr.function.name}({', '.join(arguments)})", POSTFIX

    def _method(self, function: Function) -> str:
        assert function.owner is not None
        name = function.method.lstrip("_")
        taken = {m.name for m in function.owner.members}
        return f"{name}_" if name in taken else name

    # --- statements --------------------------------------------------------------------------------

    def body(self, function: Function) -> list[str]:
        """The lines of a function's body."""
        self.inside = function
        statements = function.body
        if not self.target.result_struct_members:
            statements = self._hoisted(function, statements)
        constants = _constants(statements)
        self.used = {n for n, _ in function.parameters} | _assigned(statements)
        self.used |= {c.name for c in constants}
        self.names = self._constant_names(constants)
        lines: list[str] = []
        for constant in constants:
            text = self.target.constant.format(
                type=self.type("float"),
                name=self.name(constant.name),
                value=number(constant.value, self.target.suffix),
            )
            # Once in a file: a comment may stand above several numbers, and a number in many functions
            new = () if constant.comments in self.said else constant.comments
            lines += self._with_comments(text, new)
            self.said.add(constant.comments)
        changing = _changing(statements)
        for statement in statements:
            lines += self.statement(statement, changing)
        self.names = {}
        self.inside = None
        return lines

    def _constant_names(self, constants: Sequence[Constant]) -> dict[str, str]:
        """Numbers of the vocabulary are written small, unless that name is taken."""
        found: dict[str, str] = {}
        for constant in constants:
            small = constant.name.lower()
            if constant.name in SHARED_CONSTANTS and small not in self.used:
                found[constant.name] = small
        return found

    def _with_comments(self, line: str, comments: tuple[str, ...]) -> list[str]:
        """A line with one short comment behind it, or its comments above."""
        if len(comments) == 1:
            beside = f"{line}  // {plain_text(comments[0])}"
            if len(beside) + len(INDENT) <= WIDTH:
                return [beside]
        return [*comment(comments), line]

    def statement(self, statement: Statement, changing: set[str]) -> list[str]:
        """The lines of one statement, with its comments."""
        lines = self._statement(statement, changing)
        if statement.trailing and lines:
            if isinstance(statement, ReturnIf):
                lines[0] += f"  // {statement.trailing}"
            else:
                together = self._with_comments(lines[-1], (statement.trailing,))
                lines = [*together[:-1], *lines[:-1], together[-1]]
        lines = [*comment(statement.comments), *lines]
        return ["", *lines] if statement.blank else lines

    def _statement(self, statement: Statement, changing: set[str]) -> list[str]:
        if isinstance(statement, Assign):
            return self._assign(statement, changing)
        if isinstance(statement, SetMember):
            value = self.expr(statement.value)
            return fold(f"{self.name(statement.variable)}.{self.name(statement.member)} = {value};")
        if isinstance(statement, Return):
            return self._return(statement.value)
        if isinstance(statement, ReturnIf):
            inner = self._return(statement.value)
            return [
                f"if ({self.expr(statement.condition)}) {{",
                *(INDENT + line for line in inner),
                "}",
            ]
        if isinstance(statement, Repeat):
            return self._repeat(statement, changing)
        return []

    def _assign(self, statement: Assign, changing: set[str]) -> list[str]:
        value, name = self.expr(statement.value), self.name(statement.name)
        if not statement.declares:
            return fold(f"{name} = {value};")
        template = self.target.variable if statement.name in changing else self.target.local
        kind = self.type(statement.value.type)
        return fold(template.format(type=kind, name=name, value=value))

    def _return(self, value: Expr) -> list[str]:
        if not isinstance(value, Construction) or not isinstance(value.type, Struct):
            return fold(f"return {self.expr(value)};")
        if self.target.record:
            return fold(f"return {self.expr(value)};")
        kind, name = value.type, "result"
        while name in self.used:
            name += "_"
        lines = [self.target.uninitialized.format(type=kind.name, name=name)]
        for member, part in zip(kind.members, value.arguments, strict=True):
            lines += fold(f"{name}.{self.name(member.name)} = {self.expr(part)};")
        return [*lines, f"return {name};"]

    def _repeat(self, statement: Repeat, changing: set[str]) -> list[str]:
        name = self.name(statement.variable)
        index = f"{statement.variable}_step"
        while index in self.used:
            index += "_"
        start = self.target.to_float.format(index)
        local = self.target.local.format(type=self.type("float"), name=name, value=start)
        lines = [self.target.loop.format(index=index, count=statement.count), INDENT + local]
        for inner in statement.body:
            lines += [INDENT + line if line else "" for line in self.statement(inner, changing)]
        return [*lines, "}"]

    def _hoisted(
        self, function: Function, statements: Sequence[Statement]
    ) -> tuple[Statement, ...]:
        """Members are taken of variables only: what else they are taken of becomes a variable."""
        used = {n for n, _ in function.parameters} | _assigned(statements)
        found: list[Statement] = []

        def hoist(expr: Expr) -> Expr:
            expr = rebuilt(expr, hoist)
            if isinstance(expr, Access) and not isinstance(expr.value, (Variable, Access)):
                base = "part"
                if isinstance(expr.value, Call):
                    base = expr.value.function.method.strip("_")
                names = (f"{base}_value", *(f"{base}_value_{i}" for i in range(2, 1000)))
                name = next(n for n in names if n not in used)
                used.add(name)
                found.append(Assign(name, expr.value))
                expr = Access(Variable(name, expr.value.type), expr.name, expr.type)
            return expr

        for statement in statements:
            if isinstance(statement, Repeat):
                statement = replace(statement, body=self._hoisted(function, statement.body))
            elif isinstance(statement, (Assign, SetMember, Return)):
                statement = replace(statement, value=hoist(statement.value))
            elif isinstance(statement, ReturnIf):
                statement = replace(statement, condition=hoist(statement.condition))
            found.append(statement)
        return tuple(found)

    # --- functions and structs ---------------------------------------------------------------------

    def function(self, function: Function) -> list[str]:
        """A function with its description."""
        target = self.target
        self.inside = function
        parameters = function.parameters
        name = function.name
        if target.methods and function.owner is not None:
            parameters, name = parameters[1:], self._method(function)
        texts = []
        for n, kind in parameters:
            template = target.parameter
            if isinstance(kind, Struct) and kind.model is not None:
                template = target.struct_parameter
            texts.append(template.format(type=self.type(kind), name=self.name(n)))
        head = target.function.format(
            result=self.type(function.result), name=name, parameters=", ".join(texts)
        )
        body = [INDENT + line if line else "" for line in self.body(function)]
        return [*comment(function.doc), *fold(head), *body, "}"]

    def struct(
        self, struct: Struct, bases: str = "", methods: Iterable[Function] = ()
    ) -> list[str]:
        """A struct with what its members mean."""
        lines = comment(struct.doc)
        lines.append(self.target.struct.format(name=struct.name, bases=bases))
        for member in struct.members:
            text = self.target.member.format(
                type=self.type(member.type), name=self.name(member.name)
            )
            comments = (member.doc,) if member.doc else ()
            lines += [INDENT + line for line in self._with_comments(text, comments)]
        for method in methods:
            lines += ["", *(INDENT + line if line else "" for line in self.function(method))]
        return [*lines, self.target.struct_end]


def _is_plain(expr: Expr) -> bool:
    """Whether it takes no computation: a name, a number, a member."""
    if isinstance(expr, (Access, Negation, Splat)):
        return _is_plain(expr.value)
    return isinstance(expr, (Number, Constant, Variable))


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


def _constants(statements: Sequence[Statement]) -> list[Constant]:
    found: dict[str, Constant] = {}
    for expr in walk(tuple(statements)):
        if isinstance(expr, Constant):
            known = found.setdefault(expr.name, expr)
            if known.value != expr.value:
                raise ExportError(f"two different numbers are called {expr.name}; rename one.")
    return list(found.values())


def _assigned(statements: Sequence[Statement]) -> set[str]:
    found: set[str] = set()
    for statement in statements:
        if isinstance(statement, Assign):
            found.add(statement.name)
        elif isinstance(statement, Repeat):
            found |= {statement.variable} | _assigned(statement.body)
    return found


def _changing(statements: Sequence[Statement]) -> set[str]:
    """Variables that get another value later."""
    found: set[str] = set()
    for statement in statements:
        if isinstance(statement, Assign) and not statement.declares:
            found.add(statement.name)
        elif isinstance(statement, SetMember):
            found.add(statement.variable)
        elif isinstance(statement, Repeat):
            found |= _changing(statement.body)
    return found


def comment(lines: Iterable[str]) -> list[str]:
    """Comment lines, folded to the width of the page."""
    found: list[str] = []
    for line in lines:
        text = plain_text(line).rstrip()
        indent = " " * (len(text) - len(text.lstrip()))
        found += [
            f"// {part}"
            for part in textwrap.wrap(text, COMMENT_WIDTH - 7, subsequent_indent=indent)
        ] or ["//"]
    return found


def fold(line: str) -> list[str]:
    """A statement on as many lines as it needs: broken at its outermost commas and operators."""
    if len(line) + len(INDENT) <= WIDTH:
        return [line]
    best: tuple[int, bool, int] | None = None
    depth = 0
    for i, c in enumerate(line):
        if c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
        at = -1
        if c == "," and line[i : i + 2] == ", ":
            at = i + 1
        elif c == " " and re.match(r" (\+|-|\*|/|\?|:|&&|\|\|) ", line[i : i + 4]):
            at = i
        # The outermost place; sums before products; and of these the last one that fits
        product = line[i : i + 3] in (" * ", " / ")
        if BREAK_MIN < at <= WIDTH - len(INDENT) and (best is None or (depth, product) <= best[:2]):
            best = (depth, product, at)
    if best is None:
        return [line]
    first, rest = line[: best[2]].rstrip(), line[best[2] :].lstrip()
    return [first, *(INDENT + part for part in fold(rest))]
