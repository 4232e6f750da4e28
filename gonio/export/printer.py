"""From the checked tree to text: one printer for all languages.

It writes brackets only where precedence needs them, keeps names, structure and comments, and knows no
language by name: all that differs is in the tables of `gonio.export.targets`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from gonio import lang
from gonio.export.comments import comment, named, plain_text
from gonio.export.names import Names, legal, snake
from gonio.export.print_expressions import ExpressionPrinter, number
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
    Call,
    Constant,
    Construction,
    Expr,
    Function,
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Statement,
    Struct,
    Variable,
    rebuilt,
    walk,
)

# Code is folded to this width.
WIDTH = 100
INDENT = "    "

# A broken line keeps at least so much in front: a name and an equals sign alone read badly.
BREAK_MIN = 20

# Numbers of the vocabulary are written small: many engines have macros called PI or INV_PI.
SHARED_CONSTANTS = frozenset(n for n in vars(lang) if n.isupper())


class Printer(ExpressionPrinter):
    """Writes structs and functions in one language."""

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
        index = self.taken.give(f"{statement.variable.strip('_') or 'repeated'}_step")
        start = self.target.to_float.format(index)
        template = self.target.variable if statement.variable in changing else self.target.local
        name = self.name(statement.variable)
        local = template.format(type=self.type("float"), name=name, value=start)
        count, beside = str(statement.count), ""
        if statement.named is not None and self.target.named_counts:
            count = f"{self.target.whole}({self.expr(statement.named)})"
        elif statement.named is not None:
            beside = f"  // {self.expr(statement.named)}"
        lines = [self.target.loop.format(index=index, count=count) + beside]
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
        # Truth has no derivative: Slang takes the result of a function that had one for a pair
        plain = function.result == "bool"
        attribute = [target.attribute] if target.attribute and not plain else []
        lines = [*comment(function.doc, self.spoken()), *attribute, *fold(head), *body, "}"]
        self.names, self.inside = {}, None
        return lines

    def _results_of(self, struct: Struct) -> tuple[str, ...]:
        """What is said of a struct that stands for several results of a function."""
        if struct.model is not None or struct.python is not None:
            return ()
        made = [f for f in self.functions if f.result is struct]
        methods = [self.target.methods and f.owner is not None for f in made]
        names = [self._method(f) if m else f.name for f, m in zip(made, methods, strict=True)]
        return (f"What {' and '.join(dict.fromkeys(names))} returns.",)

    def struct(
        self, struct: Struct, bases: str = "", methods: Iterable[Function] = ()
    ) -> list[str]:
        """A struct with what its members mean."""
        lines = comment(struct.doc or self._results_of(struct), self.spoken())
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


def fold(line: str, indents: int = 1) -> list[str]:
    """A statement on as many lines as it needs: broken at its outermost commas and operators, else at =."""
    width = WIDTH - indents * len(INDENT)
    if len(line) <= width:
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
        if BREAK_MIN < at <= width and (best is None or (depth, product) <= best[:2]):
            best = (depth, product, at)
    if best is None:
        first, equals, rest = line.partition(" = ")
        if not equals:
            return [line]
        first += " ="
    else:
        first, rest = line[: best[2]].rstrip(), line[best[2] :].lstrip()
    return [first, *(INDENT + part for part in fold(rest, indents + 1))]
