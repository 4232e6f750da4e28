"""From the checked tree to text: one printer for all languages.

It writes brackets only where precedence needs them, keeps names, structure and comments, and knows no
language by name: all that differs is in the tables of `gonio.export.targets`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from gonio import lang
from gonio.export.comments import comment, named, plain_text
from gonio.export.names import Names, legal, snake
from gonio.export.targets import Target
from gonio.export.tree import (
    METHODS,
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

# Code is folded to this width.
WIDTH = 100
INDENT = "    "

# A broken line keeps at least so much in front: a name and an equals sign alone read badly.
BREAK_MIN = 20

# Precedence: a part is bracketed where it binds less tightly than its place asks.
ANY, TERNARY, OR, AND, COMPARED, SUM, PRODUCT, SIGN, POSTFIX = range(9)
LEVELS = {"||": OR, "&&": AND, "+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT}

# Numbers of the vocabulary are written small: many engines have macros called PI or INV_PI.
SHARED_CONSTANTS = frozenset(n for n in vars(lang) if n.isupper())


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
        spelled = [*target.spellings.values(), target.select, target.select3, target.splat]
        spelled += [*target.comparisons.values(), target.select_computed, target.to_float]
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
            names = Names(self.target.reserved | set(self.target.types.values()) | {struct.name})
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
            if function.owner is None or function.owner is owner:
                methods = self.target.methods and function.owner is not None
                name = self._method(function) if methods else function.name
                if function.owner is owner or function.plain not in found:
                    found[function.plain] = name
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
            return self.target.splat.format(self.expr(expr.value), type=kind), POSTFIX
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
        arguments = ", ".join(self.expr(a) for a in expr.arguments)
        kind = self.type(expr.type)
        if isinstance(expr.type, Struct):
            if not self.target.record:
                raise AssertionError(f"{kind} is made in a statement of its own")
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
        name = function.method.strip("_")
        taken = {self.member(function.owner, m.name) for m in function.owner.members}
        # As methods they may be called what is reserved elsewhere, such as sample
        reserved = frozenset() if name in METHODS else self.target.reserved
        return legal(name, reserved | taken)

    # --- statements --------------------------------------------------------------------------------

    def begin(self, function: Function) -> list[Constant]:
        """Give everything in a function its name; return the named numbers that it uses."""
        self.inside = function
        if not self.target.constants_in_file:
            self.constant_names = {}
        self.taken = Names(self.reserved | set(self.constant_names.values()))
        variables = [n for n, _ in function.parameters if n != SELF]
        variables += [n for n in _assigned(function.body) if n not in variables]
        self.names = {}
        # Those that keep their name first
        for name in sorted(variables, key=lambda n: legal(n, self.reserved) != n):
            self.names[name] = self.taken.give(name)
        constants = constants_of(function.body)
        if not self.target.constants_in_file:
            self.name_constants(constants, self.taken)
        return constants

    def name_constants(self, constants: Iterable[Constant], names: Names) -> None:
        """Numbers of the vocabulary are written small, unless that name is taken."""
        for constant in constants:
            shared = constant.name in SHARED_CONSTANTS
            name = constant.name.lower() if shared else constant.name
            self.constant_names[constant.name, constant.value] = names.give(name)

    def body(self, function: Function, constants: Sequence[Constant]) -> list[str]:
        """The lines of a function's body."""
        statements = self._prepared(function.body)
        lines = [] if self.target.constants_in_file else self.constants(constants)
        changing = _changing(statements)
        for statement in statements:
            lines += self.statement(statement, changing)
        return lines

    def constants(self, constants: Sequence[Constant]) -> list[str]:
        """The declarations of named numbers, with their comments."""
        lines: list[str] = []
        last: tuple[str, ...] = ()
        for constant in constants:
            text = self.target.constant.format(
                type=self.type("float"),
                name=self.constant_names[constant.name, constant.value],
                value=number(constant.value, self.target.suffix),
            )
            # Long ones once in a file; one comment may stand above several numbers
            comments = constant.comments
            long = len(comments) > 1 or len(text) + len("".join(comments)) > WIDTH - 8
            if comments == last or (long and comments in self.said):
                comments = ()
            lines += self._with_comments(text, comments)
            self.said.add(constant.comments)
            last = constant.comments
        return lines

    def _with_comments(self, line: str, comments: tuple[str, ...]) -> list[str]:
        """A line with one short comment behind it, or its comments above."""
        if len(comments) == 1:
            beside = f"{line}  // {named(plain_text(comments[0]), self.spoken())}"
            if len(beside) + len(INDENT) <= WIDTH:
                return [beside]
        return [*comment(comments, self.spoken()), line]

    def statement(self, statement: Statement, changing: set[str]) -> list[str]:
        """The lines of one statement, with its comments."""
        lines = self._statement(statement, changing)
        if statement.trailing and lines:
            if isinstance(statement, ReturnIf):
                lines[0] += f"  // {plain_text(statement.trailing)}"
            else:
                together = self._with_comments(lines[-1], (statement.trailing,))
                lines = [*together[:-1], *lines[:-1], together[-1]]
        lines = [*comment(statement.comments, self.spoken()), *lines]
        return ["", *lines] if statement.blank else lines

    def _statement(self, statement: Statement, changing: set[str]) -> list[str]:
        if isinstance(statement, Assign):
            return self._assign(statement, changing)
        if isinstance(statement, SetMember):
            value = self.expr(statement.value)
            assert isinstance(statement.struct, Struct)
            member = self.member(statement.struct, statement.member)
            return fold(f"{self.name(statement.variable)}.{member} = {value};")
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
        name = self.name(statement.name)
        if self._is_made(statement.value):
            return self._make(name, statement.value)
        value = self.expr(statement.value)
        if not statement.declares:
            return fold(f"{name} = {value};")
        template = self.target.variable if statement.name in changing else self.target.local
        kind = self.type(statement.value.type)
        return fold(template.format(type=kind, name=name, value=value))

    def _is_made(self, value: Expr) -> bool:
        """Whether a value is a struct that takes a statement for each member."""
        made = isinstance(value, Construction) and isinstance(value.type, Struct)
        return made and not self.target.record

    def _make(self, name: str, value: Expr) -> list[str]:
        assert isinstance(value, Construction)
        assert isinstance(value.type, Struct)
        lines = [self.target.uninitialized.format(type=value.type.name, name=name)]
        for member, part in zip(value.type.members, value.arguments, strict=True):
            lines += fold(f"{name}.{self.member(value.type, member.name)} = {self.expr(part)};")
        return lines

    def _return(self, value: Expr) -> list[str]:
        if not self._is_made(value):
            return fold(f"return {self.expr(value)};")
        name = Names(self.taken.taken).give("result")
        return [*self._make(name, value), f"return {name};"]

    def _repeat(self, statement: Repeat, changing: set[str]) -> list[str]:
        index = self.taken.give(f"{statement.variable}_step")
        start = self.target.to_float.format(index)
        template = self.target.variable if statement.variable in changing else self.target.local
        name = self.name(statement.variable)
        local = template.format(type=self.type("float"), name=name, value=start)
        lines = [self.target.loop.format(index=index, count=statement.count)]
        names = {e.name for e in walk(statement.body) if isinstance(e, Variable)}
        if statement.variable in names | changing:
            lines.append(INDENT + local)
        for inner in statement.body:
            lines += [INDENT + line if line else "" for line in self.statement(inner, changing)]
        return [*lines, "}"]

    def _prepared(self, statements: Sequence[Statement]) -> tuple[Statement, ...]:
        """What a language cannot have inside an expression becomes a variable before it.

        That is the member of a call's result, and a struct made of its members.
        """
        if self.target.record and self.target.result_struct_members:
            return tuple(statements)
        found: list[Statement] = []

        def variable(expr: Expr, name: str) -> Expr:
            name = self.taken.give(name)
            self.names[name] = name
            found.append(Assign(name, expr))
            return Variable(name, expr.type)

        def hoist(expr: Expr) -> Expr:
            expr = rebuilt(expr, hoist)
            if isinstance(expr, Access) and not isinstance(expr.value, (Variable, Access)):
                base = "part"
                if isinstance(expr.value, Call):
                    base = expr.value.function.method.strip("_")
                if not self.target.result_struct_members or self._is_made(expr.value):
                    expr = Access(variable(expr.value, f"{base}_value"), expr.name, expr.type)
            if isinstance(expr, (Call, Construction)):
                arguments = tuple(
                    variable(a, _made_name(a)) if self._is_made(a) else a for a in expr.arguments
                )
                expr = replace(expr, arguments=arguments)
            return expr

        for statement in statements:
            if isinstance(statement, Repeat):
                statement = replace(statement, body=self._prepared(statement.body))
            elif isinstance(statement, (Assign, SetMember, Return)):
                value = hoist(statement.value)
                at_once = isinstance(statement, Return)
                if isinstance(statement, Assign):
                    at_once = statement.declares
                if self._is_made(value) and not at_once:
                    # Made aside: the values may ask for the members that are set
                    value = variable(value, "made")
                statement = replace(statement, value=value)
            elif isinstance(statement, ReturnIf):
                statement = replace(statement, condition=hoist(statement.condition))
            found.append(statement)
        return tuple(found)

    # --- functions and structs ---------------------------------------------------------------------

    def function(self, function: Function) -> list[str]:
        """A function with its description."""
        target = self.target
        constants = self.begin(function)
        parameters = function.parameters
        name = function.name
        if target.methods and function.owner is not None:
            parameters, name = parameters[1:], self._method(function)
        texts = []
        for n, kind in parameters:
            template = target.parameter
            if isinstance(kind, Struct) and kind.model is not None:
                template = target.struct_parameter
            name_ = n if n == SELF else self.name(n)
            texts.append(template.format(type=self.type(kind), name=name_))
        head = target.function.format(
            result=self.type(function.result), name=name, parameters=", ".join(texts)
        )
        body = [INDENT + line if line else "" for line in self.body(function, constants)]
        attribute = [target.attribute] if target.attribute else []
        lines = [*comment(function.doc, self.spoken()), *attribute, *fold(head), *body, "}"]
        self.names, self.inside = {}, None
        return lines

    def struct(
        self, struct: Struct, bases: str = "", methods: Iterable[Function] = ()
    ) -> list[str]:
        """A struct with what its members mean."""
        lines = comment(struct.doc)
        if not bases and self.target.value:
            bases = f" : {self.target.value}"
        lines.append(self.target.struct.format(name=struct.name, bases=bases))
        for member in struct.members:
            text = self.target.member.format(
                type=self.type(member.type), name=self.member(struct, member.name)
            )
            comments = (member.doc.rstrip("."),) if member.doc else ()
            lines += [INDENT + line for line in self._with_comments(text, comments)]
        for method in methods:
            lines += ["", *(INDENT + line if line else "" for line in self.function(method))]
        return [*lines, self.target.struct_end]


def _made_name(value: Expr) -> str:
    """What a struct that is made aside is called."""
    python = value.type.python if isinstance(value.type, Struct) else None
    return "made" if python is None else snake(python.__name__)


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


def constants_of(statements: Sequence[Statement]) -> list[Constant]:
    """The named numbers in some statements, in the order of their files."""
    found: dict[tuple[str, float], Constant] = {}
    for expr in walk(tuple(statements)):
        if isinstance(expr, Constant):
            found.setdefault((expr.name, expr.value), expr)
    return in_order(found.values())


def in_order(constants: Iterable[Constant]) -> list[Constant]:
    """Named numbers file by file as they are first used, and in a file as they stand there."""
    found = list(constants)
    files = [c.place[0] for c in found]
    return sorted(found, key=lambda c: (files.index(c.place[0]), c.place[1:]))


def _assigned(statements: Sequence[Statement]) -> list[str]:
    found: dict[str, None] = {}
    for statement in statements:
        if isinstance(statement, Assign):
            found[statement.name] = None
        elif isinstance(statement, Repeat):
            found |= dict.fromkeys([statement.variable, *_assigned(statement.body)])
    return list(found)


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
