"""From the statements of a Python function to those of a checked tree, with their comments.

Conditions on options are decided here, and only the chosen branch is read.
"""

from __future__ import annotations

import ast
import types
from dataclasses import replace

from gonio import lang
from gonio.export.expressions import (
    SIGNATURES,
    Changed,
    Collector,
    Expressions,
    Many,
    Method,
    Static,
    Value,
)
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
    Builtin,
    Call,
    Construction,
    Expr,
    Function,
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
from gonio.model import Model

# More steps than this are a mistake, or hang a graphics driver.
STEPS_MAX = 2**16


class Body(Expressions):
    """Reads one function."""

    def __init__(
        self,
        reader: Collector,
        function: types.FunctionType,
        given: tuple[Type | Static, ...],
        owner: Struct | None,
        method: str,
    ) -> None:
        """Begin a function for some types of arguments."""
        super().__init__(reader, function, owner)
        self.method = method
        self.node = self.source.function(function)
        self.parameters: list[tuple[str, Type]] = []
        self.statements: list[Statement] = []
        self.result: Type | None = SIGNATURES[method][1] if method in SIGNATURES else None
        self.done = False
        self.pending: tuple[str, ...] = ()  # comments for the next statement
        self.branch_taken = True  # whether the branch that ends right above was taken
        self.used = {n.id for n in ast.walk(self.node) if isinstance(n, ast.Name)}
        self._bind(given)

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
        if isinstance(expr, Changed):
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
        if isinstance(value, Changed):
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

    def _change(self, name: str, value: Changed) -> None:
        self.scope[name] = value.type
        self.statements.append(Assign(name, value.model))
        for member, expr in value.members.items():
            self.statements.append(SetMember(name, member, expr))


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
