"""From a model's Python to a checked tree: the only file that knows `ast`.

Every function is read for the types of its arguments, with the model's options known: conditions on them
are decided here, and only the chosen branch is exported. docs/language.md describes what is understood;
all else is refused with its place and with what to write instead.
"""

from __future__ import annotations

import ast
import inspect
import operator
import re
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn, cast

from gonio import lang
from gonio.export import library
from gonio.export.source import Source, source
from gonio.export.tree import (
    Access,
    Assign,
    Builtin,
    Call,
    Constant,
    Construction,
    ExportError,
    Expr,
    Function,
    Member,
    Negation,
    Number,
    Operation,
    Remark,
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Splat,
    Statement,
    Struct,
    Type,
    Variable,
    inside,
    walk,
)
from gonio.export.vocabulary import RULES, VECTORS, widest
from gonio.model import Child, Model, Option, Parameter

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

# More steps than this are a mistake, or hang a graphics driver.
STEPS_MAX = 2**16

# Name of the struct of parameters where a function gets it.
SELF = "params"

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


def snake(name: str) -> str:
    """A name that a function may begin with, made of a class's or a material's."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def camel(name: str) -> str:
    """A type's name made of a function's, such as CarPaint of car_paint."""
    return "".join(part[:1].upper() + part[1:] for part in name.split("_") if part)


class Reader:
    """Collects the functions and structs of one export, each once, callees before callers."""

    def __init__(self, prefix: str, lacking: frozenset[str]) -> None:
        """Begin an export.

        Args:
            prefix: of shared functions and types.
            lacking: functions of the vocabulary that are taken from the library.
        """
        self.prefix = prefix
        self.lacking = lacking
        self.structs: list[Struct] = []
        self.functions: list[Function] = []
        self.sample = self._add(
            Struct(
                camel(prefix) + "Sample",
                (
                    Member("wi", "vec3", "direction towards the light, unit, local frame"),
                    Member("pdf", "float", "its density in 1/sr; 0 marks a wasted sample"),
                ),
                doc=("A sampled direction and its density.",),
            )
        )
        self._models: dict[Any, Struct] = {}
        self._read: dict[Any, Function] = {}
        self._results: dict[Any, Struct] = {}
        self._names: dict[str, types.CodeType] = {}
        self._methods: set[str] = set()  # what the models' methods are called
        self._open: list[Any] = []

    def _add(self, struct: Struct) -> Struct:
        self.structs.append(struct)
        return struct

    def model(self, model: Model, prefix: str, title: str = "") -> Struct:
        """The struct of a model's parameters; models that differ in their numbers only share it."""
        key = _kind(model)
        if not title and key in self._models:
            return self._models[key]
        members: list[Member] = []
        for name, declared in model.fields.items():
            value = getattr(model, name)
            if not name.isascii() or "__" in name:
                raise ExportError(
                    f"{model.name}: shading languages do not take the name {name!r} of a parameter; use "
                    "letters of the English alphabet, digits and single underscores."
                )
            if isinstance(declared, Parameter):
                doc = f"{declared.doc}; {declared.range_text()}, default {_plain(value)}"
                members.append(Member(name, "vec3" if declared.width == 3 else "float", doc))
            elif isinstance(declared, Child):
                inner = self.model(value, f"{prefix}_{name}")
                members.append(Member(name, inner, declared.doc))
        if not members:
            raise ExportError(
                f"{model.name} has no parameters; give it one, as shading languages have no empty structs."
            )
        doc = title or f"Parameters of {model.name}"
        options = [
            f"{name}={getattr(model, name)!r}"
            for name, declared in model.fields.items()
            if isinstance(declared, Option)
        ]
        text = [f"{doc}: {(type(model).__doc__ or '').strip().splitlines()[0]}"]
        if options:
            text.append(f"Exported with {', '.join(options)}.")
        struct = Struct(camel(prefix), tuple(members), tuple(text), model, prefix)
        own = {name for cls in type(model).__mro__ for name in vars(cls)}
        self._methods |= {f"{prefix}_{name.strip('_')}" for name in own}
        self._models[key] = struct
        return self._add(struct)

    def method(self, owner: Struct, name: str) -> Function:
        """A method of a model, for the types of its declaration."""
        parameters, _ = SIGNATURES[name]
        return self.function_for(_method(owner, name), [t for _, t in parameters], owner, name)

    def function_for(
        self,
        function: types.FunctionType,
        arguments: Iterable[Type | Static],
        owner: Struct | None = None,
        method: str = "",
    ) -> Function:
        """A Python function as it is for some types of arguments; those of a model get its struct first."""
        given = tuple(arguments)
        key = (function, owner, given, method == UNTESTED)
        if key in self._read:
            return self._read[key]
        if key in self._open:
            place = f"{function.__code__.co_filename}:{function.__code__.co_firstlineno}"
            raise ExportError(
                f"{place}: {function.__name__} calls itself, which shading languages do not allow; "
                "write a loop over a fixed number of steps."
            )
        self._open.append(key)
        made = _Body(self, function, given, owner, method).read()
        self._open.pop()
        plain = method or function.__name__
        inherited = (
            owner is not None and inspect.unwrap(getattr(type(owner.model), plain)) is not function
        )
        made.name = self._name(function, given, owner, plain, inherited and not method)
        if inherited and not method:
            made.method = f"{function.__module__.rpartition('.')[2]}_{plain}"
        self._read[key] = made
        self.functions.append(made)
        return made

    def _name(
        self,
        function: types.FunctionType,
        given: tuple[Type | Static, ...],
        owner: Struct | None,
        plain: str,
        inherited: bool,
    ) -> str:
        """A name that no other function has: of the model or the prefix, then of the file, then counted."""
        plain = plain.strip("_")
        start = owner.prefix if owner is not None else self.prefix
        file = function.__module__.rpartition(".")[2]
        # The same function for other types: of a colour, or of a number
        other = "rgb" if "vec3" in given else "scalar"
        candidates = [f"{start}_{plain}", f"{start}_{file}_{plain}"]
        if inherited:  # the model's own method has the plain name
            candidates = candidates[1:]
        candidates = [c for name in candidates for c in (name, f"{name}_{other}")]
        candidates += [f"{start}_{plain}_{i}" for i in range(2, 100)]
        mine = function.__code__
        name = next(
            c
            for c in candidates
            if self._names.get(c) is None
            and (not c.endswith(f"_{other}") or self._names.get(c[: -len(other) - 1]) is mine)
            and not (owner is None and c in self._methods)
        )
        self._names[name] = mine
        return name

    def results(self, function: str, names: tuple[str, ...], given: tuple[Type, ...]) -> Struct:
        """The struct for several results of a function."""
        key = (function, names, given)
        if key not in self._results:
            name = camel(f"{self.prefix}_{function.strip('_')}")
            taken = {s.name for s in self.structs}
            name = next(n for n in (name, *(f"{name}{i}" for i in range(2, 100))) if n not in taken)
            members = tuple(Member(n, t) for n, t in zip(names, given, strict=True))
            self._results[key] = self._add(
                Struct(name, members, (f"Results of {function.strip('_')}.",))
            )
        return self._results[key]


def _kind(model: Model) -> Any:
    """What makes the code of two models the same: class, options, and the kinds of inner models."""
    return (
        type(model),
        *(
            _kind(value) if isinstance(value, Model) else value
            for name, declared in model.fields.items()
            if not isinstance(declared, Parameter)
            for value in [getattr(model, name)]
        ),
    )


def _plain(value: Any) -> str:
    """A parameter's value for a comment."""
    if isinstance(value, tuple):
        return f"({', '.join(_plain(v) for v in value)})"
    return f"{value:.7g}" if isinstance(value, (int, float)) else "an array"


def _method(owner: Struct, name: str) -> types.FunctionType:
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


class _Body:
    """Reads one function."""

    def __init__(
        self,
        reader: Reader,
        function: types.FunctionType,
        given: tuple[Type | Static, ...],
        owner: Struct | None,
        method: str,
    ) -> None:
        self.reader = reader
        self.python = function
        self.owner = owner
        self.method = method
        self.source: Source = source(function.__code__.co_filename)
        self.node = self.source.function(function)
        self.scope: dict[str, Type | Static] = {}
        self.parameters: list[tuple[str, Type]] = []
        self.statements: list[Statement] = []
        self.result: Type | None = SIGNATURES[method][1] if method in SIGNATURES else None
        self.done = False
        self.pending: tuple[str, ...] = ()  # comments for the next statement
        self.branch_taken = True  # whether the branch that ends right above was taken
        self.used = {n.id for n in ast.walk(self.node) if isinstance(n, ast.Name)}
        self._bind(given)

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

    def _bind(self, given: tuple[Type | Static, ...]) -> None:
        arguments = self.node.args
        if arguments.vararg or arguments.kwarg:
            self.refuse(self.node, "*args and **kwargs have no meaning in a shader; name each one.")
        names = [a.arg for a in (*arguments.posonlyargs, *arguments.args)]
        if self.owner is not None:
            self.parameters.append((SELF, self.owner))
            self.scope[names[0]] = self.owner
            self.self_name = names[0]
            names = names[1:]
        else:
            self.self_name = ""
        self._check_name(self.node, self.node.name.strip("_"))
        for name, value in zip(names, given, strict=True):
            self._check_name(self.node, name)
            self.scope[name] = value
            if not isinstance(value, Static):
                self.parameters.append((name, value))

    def read(self) -> Function:
        """The function, checked."""
        if self.method in ("eval", "pdf"):
            self._guard("wi", "wo", "<=")
        elif self.method == "sample":
            self._guard("wo", "", "<=")
        elif self.method == "albedo":
            self._guard("wo", "", "<")
        statements = self.node.body
        doc = ast.get_docstring(self.node)
        last = self.node.lineno
        if doc is not None:
            last = statements[0].end_lineno or last
            statements = statements[1:]
        else:
            last = statements[0].lineno - 1
            last -= len(self.source.above(statements[0].lineno))
        last = self.block(statements, last)
        if not self.done:
            self.refuse(self.node, f"{self.node.name} ends without a result; end it with 'return'.")
        if last == self.node.end_lineno:  # else they belong to a branch that is not taken
            rest = self._comments_between(last, self._end(self.node))
            if rest:
                self.statements.append(Remark(comments=rest))
        assert self.result is not None
        return Function(
            "",
            tuple((doc or "").splitlines()),
            tuple(self.parameters),
            self.result,
            _without_unused(tuple(self.statements)),
            self.owner,
            self.method or self.node.name,
        )

    def _end(self, node: ast.FunctionDef) -> int:
        """The last line that belongs to a function, comments at its end included."""
        line = (node.end_lineno or node.lineno) + 1
        while (comment := self.source.comments.get(line)) is not None and comment.alone:
            text = self.source.lines[line - 1]
            if len(text) - len(text.lstrip()) <= node.col_offset:
                break
            line += 1
        return line

    def _guard(self, first: str, second: str, comparison: str) -> None:
        """Everything is zero below the horizon: the contract of `gonio.model`."""
        names = [a.arg for a in self.node.args.args][1:]
        known = dict(zip([n for n, _ in SIGNATURES[self.method][0]], names, strict=True))
        height: Expr = Access(Variable(known[first], "vec3"), "z", "float")
        if second:
            other = Access(Variable(known[second], "vec3"), "z", "float")
            height = Builtin("minimum", (height, other), "float")
        horizon = Number(0 if self.method == "albedo" else lang.MU_MIN)
        condition = Operation(comparison, height, horizon, "bool")
        zero: Expr = Number(0)
        if self.method == "sample":
            up = Construction((Number(0), Number(0), Number(1)), "vec3")
            zero = Construction((up, zero), self.reader.sample)
        elif self.result == "vec3":
            zero = Splat(zero, "vec3")
        where = "below the horizon" if self.method == "albedo" else "in the horizon or below"
        self.statements.append(ReturnIf(condition, zero, trailing=where))

    # --- statements --------------------------------------------------------------------------------

    def block(self, statements: list[ast.stmt], last: int) -> int:
        """Read statements; `last` is the line that the one before ends in. Return that of the last."""
        for node in statements:
            if self.done:
                break
            before = len(self.statements)
            # Deeper ones are the end of the branch above: they stay if that was taken
            deepest = 1000 if self.branch_taken else node.col_offset
            comments = self.pending + self._comments_between(last, node.lineno, deepest)
            self.pending = ()
            self.branch_taken = True
            end = node.end_lineno or node.lineno
            trailing = ""
            if not isinstance(node, (ast.If, ast.For)):
                within = [
                    self.source.comments[i]
                    for i in range(node.lineno, end + 1)
                    if i in self.source.comments
                ]
                if node.lineno == end and within:
                    trailing = within[0].text
                else:
                    comments += tuple(c.text for c in within)
            blank = self._blank_before(node, last)
            self.statement(node)
            if len(self.statements) > before:
                first = self.statements[before]
                self.statements[before] = replace(
                    first,
                    comments=comments + first.comments,
                    trailing=trailing or first.trailing,
                    blank=blank or first.blank,
                )
            last = end
        return last

    def _comments_between(self, last: int, line: int, deepest: int = 1000) -> tuple[str, ...]:
        """Comments on lines of their own between two lines, indented no more than `deepest`."""
        found = []
        for i in range(last + 1, line):
            comment = self.source.comments.get(i)
            text = self.source.lines[i - 1] if i <= len(self.source.lines) else ""
            if comment is not None and comment.alone and len(text) - len(text.lstrip()) <= deepest:
                found.append(comment.text)
        return tuple(found)

    def _blank_before(self, node: ast.stmt, last: int) -> bool:
        return any(
            not self.source.lines[i - 1].strip() for i in range(last + 1, node.lineno)
        ) and bool(self.statements)

    def statement(self, node: ast.stmt) -> None:
        """Read one statement."""
        if isinstance(node, ast.Return):
            self._return(node)
        elif isinstance(node, ast.Assign) and len(node.targets) == 1:
            self._assign(node, node.targets[0])
        elif isinstance(node, ast.If):
            self._if(node)
        elif isinstance(node, ast.For):
            self._for(node)
        elif isinstance(node, ast.Pass):
            return
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            self.refuse(node, "text that is not the function's docstring; write it as a comment.")
        else:
            self._unknown(node)

    def _unknown(self, node: ast.AST) -> NoReturn:
        instead = INSTEAD.get(type(node), "assignments, returns and calls (docs/language.md)")
        kind = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(node).__name__).lower()
        self.refuse(node, f"this ({kind}) cannot be exported; write {instead}.")

    def _if(self, node: ast.If) -> None:
        test = self.value(node.test)
        if not isinstance(test, Static):
            self.refuse(
                node.test,
                "this condition is not known when the shader is made; write select(condition, yes, no).",
            )
        start = node.body[-1].end_lineno or node.lineno
        inner = node.orelse[0] if node.orelse else None
        keyword = [
            i
            for i in range(start + 1, inner.lineno + 1 if inner is not None else 0)
            if self.source.lines[i - 1].lstrip().startswith(("else", "elif"))
        ]
        if test.value:
            head = range(node.lineno, node.body[0].lineno)
            self.pending += tuple(
                self.source.comments[i].text
                for i in head
                if i in self.source.comments and not self.source.comments[i].alone
            )
            self.block(node.body, node.test.end_lineno or node.lineno)
            if keyword and not self.done:
                rest = self._comments_between(start, keyword[0])
                if rest:
                    self.statements.append(Remark(comments=rest))
            self.branch_taken = not node.orelse
            return
        self.branch_taken = False
        if inner is not None:
            beside = self.source.comments.get(keyword[0]) if keyword else None
            if beside is not None and not isinstance(inner, ast.If):
                self.pending += (beside.text,)
            self.block(node.orelse, keyword[0] if keyword else start)

    def _for(self, node: ast.For) -> None:
        call = node.iter
        if not (
            isinstance(call, ast.Call)
            and isinstance(call.func, ast.Name)
            and call.func.id == "range"
            and len(call.args) == 1
            and isinstance(node.target, ast.Name)
            and not node.orelse
        ):
            self.refuse(node, "only 'for i in range(count)' can be exported.")
        count = self._static_number(call.args[0])
        if count != int(count) or not 0 < count <= STEPS_MAX:
            self.refuse(call, f"the number of steps must be from 1 to {STEPS_MAX}, got {count:g}.")
        self._check_name(node, node.target.id)
        outside = dict(self.scope)
        self.scope[node.target.id] = "float"
        kept, self.statements = self.statements, []
        self.block(node.body, node.lineno)
        if self.done:
            self.refuse(node, "a loop cannot return; return its result after it.")
        body, self.statements = tuple(self.statements), kept
        self.scope = outside
        self.statements.append(Repeat(node.target.id, int(count), body))

    def _static_number(self, node: ast.expr) -> float:
        value = self.value(node)
        if isinstance(value, (Number, Constant)):
            return value.value
        if isinstance(value, Static) and isinstance(value.value, (int, float)):
            return float(value.value)
        self.refuse(node, "this number must be known when the shader is made.")

    def _return(self, node: ast.Return) -> None:
        if node.value is None:
            self.refuse(node, "a function returns a value.")
        value = self.value(node.value)
        if isinstance(value, Many):
            names = self._result_names(node.value)
            given = tuple(v.type for v in value.values)
            struct = self.reader.results(self.node.name, names, given)
            value = Construction(value.values, struct)
        if isinstance(value, Static) and isinstance(value.value, Model):
            self.refuse(
                node, "a model that is made here cannot be exported; declare it with child()."
            )
        expr = self._expr(node.value, value)
        if isinstance(expr, _Changed):
            name = self._fresh("rougher")
            self._change(name, expr)
            expr = Variable(name, expr.type)
        if self.method in SIGNATURES and self.result is not None:
            expr = self._coerce(node, expr, self.result)
        if self.method == "sample":
            if expr.type is not self.reader.sample:
                self.refuse(node, "sample returns Sample(wi, pdf).")
            expr = self._waste_below(expr)
        self.statements.append(Return(expr))
        self.result = expr.type
        self.done = True

    def _waste_below(self, expr: Expr) -> Expr:
        """Sample(wi, pdf) with pdf = 0 where wi is below the horizon; `self.pdf` sees to it itself."""
        if not isinstance(expr, Construction):
            self.refuse(self.node, "sample ends with 'return Sample(wi, pdf)'.")
        wi, pdf = expr.arguments
        if isinstance(pdf, Call) and pdf.function.method == "pdf":
            return expr
        if not isinstance(wi, Variable):
            name = self._fresh("wi")
            self.statements.append(Assign(name, wi))
            wi = Variable(name, "vec3")
        above = Operation(">", Access(wi, "z", "float"), Number(lang.MU_MIN), "bool")
        masked = Builtin("select", (above, pdf, Number(0)), "float")
        return Construction((wi, masked), expr.type)

    def _result_names(self, node: ast.expr) -> tuple[str, ...]:
        assert isinstance(node, ast.Tuple)
        names = [n.id if isinstance(n, ast.Name) else "" for n in node.elts]
        if all(names) and len(set(names)) == len(names):
            return tuple(names)
        return ("first", "second", "third", "fourth", "fifth", "sixth")[: len(names)]

    def _fresh(self, name: str) -> str:
        """A local name that the function does not use; its type is set by the caller."""
        free = (n for n in (name, *(f"{name}_{i}" for i in range(2, 100))) if n not in self.used)
        name = next(free)
        self.used.add(name)
        return name

    def _assign(self, node: ast.Assign, target: ast.expr) -> None:
        if isinstance(target, ast.Name):
            self._store(node, target.id, self._result(node.value))
        elif isinstance(target, ast.Tuple) and all(isinstance(t, ast.Name) for t in target.elts):
            names = [t.id for t in target.elts if isinstance(t, ast.Name)]
            value = self._result(node.value)
            self._unpack(node, names, value)
        else:
            self.refuse(target, "only a name, or names separated by commas, can be assigned.")

    def _result(self, node: ast.expr) -> Value:
        value = self.value(node)
        if isinstance(value, Method):
            self.refuse(node, "a method must be called.")
        return value

    def _unpack(self, node: ast.Assign, names: list[str], value: Value) -> None:
        if isinstance(value, Many):
            values = list(value.values)
            if len(values) != len(names):
                self.refuse(node, f"{len(names)} names for {len(values)} values.")
            for i, v in enumerate(values[1:], 1):
                used = {e.name for e in inside(v) if isinstance(e, Variable)}
                if used & set(names[:i]):
                    self.refuse(node, "a value uses a name that is assigned here; write two lines.")
            for name, v in zip(names, values, strict=True):
                if name != "_":
                    self._store(node, name, v)
            return
        expr = self._expr(node.value, value)
        kind = expr.type
        if not isinstance(kind, Struct) or len(kind.members) != len(names):
            self.refuse(node, f"this is not {len(names)} values.")
        if not isinstance(expr, Variable):
            label = expr.function.method.strip("_") if isinstance(expr, Call) else "several"
            label = self._fresh(f"{label}_result")
            self.statements.append(Assign(label, expr))
            expr = Variable(label, kind)
        for name, member in zip(names, kind.members, strict=True):
            if name != "_":
                self._store(node, name, Access(expr, member.name, member.type))

    def _check_name(self, node: ast.AST, name: str) -> None:
        """Refuse what no shading language takes as a name."""
        if name == SELF:
            self.refuse(node, f"{SELF} is the struct of parameters in shaders; use another name.")
        if not name.isascii() or "__" in name or name.startswith("gl_"):
            self.refuse(
                node,
                f"shading languages do not take the name {name!r}; use letters of the English alphabet, "
                "digits and single underscores.",
            )

    def _store(self, node: ast.stmt, name: str, value: Value) -> None:
        self._check_name(node, name)
        if isinstance(value, (Static, Method)):
            if (
                isinstance(value, Method)
                or isinstance(self.scope.get(name, value), Static) is False
            ):
                self.refuse(node, f"{name} cannot be a number here and something else there.")
            self.scope[name] = value
            return
        if isinstance(value, Many):
            self.refuse(node, f"several values for one name; unpack them: {name}_1, {name}_2 = ...")
        if isinstance(value, _Changed):
            self._change(name, value)
            return
        known = self.scope.get(name)
        if known is None or isinstance(known, Static):
            self.scope[name] = value.type
            self.statements.append(Assign(name, value))
            return
        if any(name == parameter for parameter, _ in self.parameters):
            self.refuse(node, f"the argument {name} cannot be assigned; use another name.")
        value = self._coerce(node, value, known)
        self.statements.append(Assign(name, value, declares=False))

    def _change(self, name: str, value: _Changed) -> None:
        self.scope[name] = value.type
        self.statements.append(Assign(name, value.model))
        for member, expr in value.members.items():
            self.statements.append(SetMember(name, member, expr))

    def _coerce(self, node: ast.AST, expr: Expr, wanted: Type) -> Expr:
        if expr.type == wanted:
            return expr
        if wanted in ("vec2", "vec3") and expr.type == "float":
            return Splat(expr, wanted)
        self.refuse(node, f"a {_spoken(expr.type)} where a {_spoken(wanted)} is expected.")

    # --- expressions -------------------------------------------------------------------------------

    def expr(self, node: ast.expr) -> Expr:
        """An expression that has a value in the shader."""
        return self._expr(node, self.value(node))

    def _expr(self, node: ast.expr, value: Value) -> Expr:
        if isinstance(value, Static):
            if isinstance(value.value, bool) or not isinstance(value.value, (int, float)):
                self.refuse(node, f"{_shown(value.value)} has no value in a shader.")
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
            return Constant(name, float(value), _comments_of(name, file))
        return Static(value)

    def _attribute(self, node: ast.Attribute) -> Value:
        value = self.value(node.value)
        if isinstance(value, Static):
            if not hasattr(value.value, node.attr):
                self.refuse(node, f"{_shown(value.value)} has no {node.attr!r}.")
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
        self.refuse(node, f"a {_spoken(kind)} has no {node.attr!r}.")

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
            self.refuse(node, f"this cannot be done with a {_spoken(expr.type)}.")
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
            self.refuse(
                node, f"a {_spoken(kinds[0])} {symbol} a {_spoken(kinds[1])} has no meaning."
            )
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
            self.refuse(node, f"a {_spoken(a.type)} and a {_spoken(b.type)} cannot be compared.")
        kind = widest((a.type, b.type))
        a, b = self._coerce(node, a, kind), self._coerce(node, b, kind)
        return Operation(COMPARISON[op], a, b, "bool3" if kind == "vec3" else "bool")

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
        function = _method(owner, method.name)
        names = list(inspect.signature(function).parameters)[1:]
        arguments = self._arguments(node, names, {})
        passed, kinds = self._typed(arguments)
        if method.name in SIGNATURES:
            for (name, kind), expr in zip(SIGNATURES[method.name][0], passed, strict=True):
                if expr.type != kind:
                    self.refuse(node, f"{name} must be a {_spoken(kind)}.")
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
        return _Changed(model, owner, members) if members else model

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
                self.refuse(node, f"{name} cannot take a {_spoken(kind)}.")
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


def _without_unused(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
    """Without variables that only the branches not taken would use."""
    while True:
        used = {e.name for e in walk(statements) if isinstance(e, Variable)}
        kept = tuple(
            s
            for s in statements
            if not (isinstance(s, Assign) and s.declares and s.name not in used)
        )
        if len(kept) == len(statements):
            return kept
        statements = kept


class _Changed(Variable):
    """A copy of a model's struct with other members: only as a whole statement."""

    model: Expr
    members: dict[str, Expr]

    def __init__(self, model: Expr, kind: Type, members: dict[str, Expr]) -> None:
        super().__init__("rougher", kind)
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "members", members)


def _names(builtin: str) -> list[str]:
    return list(inspect.signature(getattr(lang, builtin)).parameters)


def _comments_of(name: str, file: Source) -> tuple[str, ...]:
    """The comments of a named number, from the file that defines it."""
    comments = file.constant_comments(name)
    if comments is not None:
        return comments
    module = file.imported_from(name)
    if module is None:
        return ()
    found = inspect.getsourcefile(__import__(module, fromlist=["_"]))
    return () if found is None else _comments_of(name, source(found))


def _spoken(kind: Type) -> str:
    if isinstance(kind, Struct):
        return kind.name
    return {"float": "number", "bool": "mask", "bool3": "mask of a colour"}.get(kind, kind)


def _shown(value: Any) -> str:
    if isinstance(value, types.ModuleType):
        return f"the module {value.__name__}"
    name = getattr(value, "__name__", None)
    return name if name is not None else repr(value)
