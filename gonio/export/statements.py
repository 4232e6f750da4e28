"""From the statements of a Python function to those of a checked tree, with their comments.

Conditions on options are decided here, and only the chosen branch is read.
"""

from __future__ import annotations

import ast
import types
from collections.abc import Sequence
from dataclasses import replace

from gonio import lang
from gonio.export import plain as numbers
from gonio.export import records
from gonio.export.aliases import same
from gonio.export.assignments import Assignments, Loop
from gonio.export.collector import Collector
from gonio.export.contract import SIGNATURES, UNTESTED
from gonio.export.names import snake
from gonio.export.operators import simplified
from gonio.export.source import source
from gonio.export.stand_ins import usual_name
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
    Builtin,
    Call,
    Constant,
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
    children,
    inside,
    walk,
)
from gonio.export.values import COMPARISON, Changed, Many, Static, Value, truth
from gonio.model import Model

# More steps than this are a mistake, or hang a graphics driver.
STEPS_MAX = 2**16

# Single precision has all whole numbers up to here.
WHOLE_MAX = 2**24


class Body(Assignments):
    """Reads one function."""

    def __init__(
        self,
        reader: Collector,
        function: types.FunctionType,
        given: tuple[Type | Static, ...],
        owner: Struct | None,
        method: str,
        guarded: bool,
    ) -> None:
        """Begin a function for some types of arguments; `guarded` ones test for the horizon."""
        super().__init__(reader, function, owner)
        self.method = method
        self.guarded = guarded
        self.result: Type | None = SIGNATURES[method][1] if method in SIGNATURES else None
        self.done = False
        self.pending: tuple[str, ...] = ()  # comments for the next statement
        self.branch_taken = True  # whether the branch that ends right above was taken
        self._bind(given)

    def _bind(self, given: tuple[Type | Static, ...]) -> None:
        arguments = self.node.args
        if arguments.vararg or arguments.kwarg:
            self.refuse(self.node, "*args and **kwargs have no meaning in a shader; name each one.")
        names = [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
        if self.owner is not None:
            if not names:
                self.refuse(self.node, "a method takes its model first: self.")
            self.parameters.append((SELF, self.owner))
            self.scope[names[0]] = self.owner
            self.self_name = names[0]
            names = names[1:]
        elif (record := record_of(self.python, given)) is not None:
            self.self_name, self.self_variable = names[0], self._fresh(snake(record.__name__))
            kind, given = given[0], given[1:]
            assert isinstance(kind, Struct)
            self.parameters.append((self.self_variable, kind))
            self.scope[names[0]] = kind
            names = names[1:]
        if self.method in SIGNATURES and len(names) != len(given):
            expected = ", ".join(["self", *(n for n, _ in SIGNATURES[self.method][0])])
            self.refuse(self.node, f"{self.node.name} takes {expected} and nothing else.")
        self._check_name(self.node, self.node.name.strip("_"))
        for name, value in zip(names, given, strict=True):
            self._check_name(self.node, name)
            self.scope[name] = value
            if not isinstance(value, Static):
                self.parameters.append((name, value))
        self.arguments = frozenset(n for n in names if not isinstance(self.scope[n], Static))
        self._know_directions(names)

    def _know_directions(self, names: Sequence[str]) -> None:
        """Which arguments are directions above the horizon: shown by a test, or promised."""
        if self.method in ("eval", "pdf", UNTESTED):
            self.tested = frozenset(names)
        elif self.method == "sample":
            self.tested = frozenset(names[:1])
        elif self.method == "albedo":
            self.upper = frozenset(names)

    def read(self) -> Function:
        """The function, checked."""
        if self.guarded and self.method in ("eval", "pdf"):
            self._guard("wi", "wo", "<=")
        elif self.guarded and self.method == "sample":
            self._guard("wo", "", "<=")
        elif self.guarded and self.method == "albedo":
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
        self._check_numbers()
        return Function(
            "",
            tuple((doc or "").splitlines()),
            tuple(self.parameters),
            self.result,
            _without_unused(tuple(self.statements)),
            self.owner,
            self.method or self.node.name,
            usual_name(self.python) if self.self_variable == SELF else self.python.__qualname__,
            self._places_of(self.exponents),
            self._places_of(self.in_exponents),
            tuple(self.struct_exponents),
        )

    def _places_of(self, names: set[str]) -> frozenset[int]:
        """Which of the arguments have these names."""
        own = self.parameters[self.owner is not None :]
        return frozenset(i for i, (name, _) in enumerate(own) if name in names)

    def _check_numbers(self) -> None:
        """Refuse numbers that Python computes by itself with more digits than a shader has."""
        found = numbers.changed(self.statements)
        if found is None:
            return
        compared = isinstance(found, Operation) and found.operator in COMPARISON
        what = "this comparison comes out otherwise" if compared else "this number is another one"
        self.refuse(
            self._place_of(found),
            f"{what} in single precision, in which shaders compute; "
            + (
                "compare whole numbers, or numbers further apart."
                if compared
                else "write it as one expression of numbers, or as a named number of the module."
            ),
        )

    def _place_of(self, expr: Expr) -> ast.AST:
        """Where an expression stands, or the smallest that is known around it."""
        found: ast.AST = self.node
        around = 0
        for whole, node in self.places.values():
            parts = list(inside(whole))
            if any(e is expr for e in parts) and (not around or len(parts) < around):
                found, around = node, len(parts)
        return found

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
        names = [name for name, _ in self.parameters[1:]]
        known = dict(zip([n for n, _ in SIGNATURES[self.method][0]], names, strict=True))
        height: Expr = Access(Variable(known[first], "vec3"), "z", "float")
        if second:
            other = Access(Variable(known[second], "vec3"), "z", "float")
            height = Builtin("minimum", (height, other), "float")
        horizon = Number(0) if self.method == "albedo" else self._horizon()
        condition = Operation(comparison, height, horizon, "bool")
        zero: Expr = Number(0)
        if self.method == "sample":
            up = Construction((Number(0), Number(0), Number(1)), "vec3")
            zero = Construction((up, zero), self.reader.sample)
        elif self.result == "vec3":
            zero = Splat(zero, "vec3")
        where = "below the horizon" if self.method == "albedo" else "in the horizon or below"
        self.statements.append(ReturnIf(condition, zero, trailing=where))

    @staticmethod
    def _horizon() -> Expr:
        """The cosine that begins the horizon, by its name."""
        file = source(str(lang.__file__))
        comments = file.constant_comments("MU_MIN") or ()
        return Constant(
            "MU_MIN", lang.MU_MIN, comments, (file.path, *file.constant_place("MU_MIN"))
        )

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
        if not isinstance(node, (ast.If, ast.For)):
            self._check_depth(node)
        if isinstance(node, ast.Return):
            self._return(node)
        elif isinstance(node, ast.Assign):
            self._assign(node)
        elif isinstance(node, ast.AugAssign):
            self._augment(node)
        elif isinstance(node, ast.AnnAssign) and node.value is not None and node.simple:
            assert isinstance(node.target, ast.Name)
            self._store(node, node.target.id, self._result(node.value))
        elif isinstance(node, ast.If):
            self._if(node)
        elif isinstance(node, ast.For):
            self._for(node)
        elif isinstance(node, ast.Pass):
            return
        elif isinstance(node, ast.Expr) and self._is_text(node.value):
            self.refuse(node, "text that is not the function's docstring; write it as a comment.")
        elif isinstance(node, ast.Expr):
            if isinstance(node.value, ast.Call):
                self.refuse(
                    node, "a call whose result is not used does nothing in a shader; leave it out."
                )
            if isinstance(node.value, (ast.Constant, ast.Name, ast.Attribute, ast.BinOp)):
                self.refuse(
                    node, "a value that is not used does nothing; leave it out, or return it."
                )
            self._unknown(node.value)
        else:
            self._unknown(node)

    @staticmethod
    def _is_text(node: ast.expr) -> bool:
        return isinstance(node, ast.Constant) and isinstance(node.value, str)

    def _if(self, node: ast.If) -> None:
        self._check_depth(node.test)
        condition = self.value(node.test)
        test = self._decided(node.test, condition)
        if test is None:
            for left in ast.walk(node):
                if isinstance(left, (ast.Break, ast.Continue)):
                    self._unknown(left)
            self._refuse_undecided(
                node.test,
                condition,
                "this condition is not known when the shader is made; write select(condition, yes, no).",
            )
        start = node.body[-1].end_lineno or node.lineno
        inner = node.orelse[0] if node.orelse else None
        keyword = [
            i
            for i in range(start + 1, inner.lineno + 1 if inner is not None else 0)
            if self.source.lines[i - 1].lstrip().startswith(("else", "elif"))
        ]
        if test:
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
            and "range" not in self.scope
            and "range" not in self.python.__globals__
            and call.args
            and not any(isinstance(a, ast.Starred) for a in call.args)
            and not call.keywords
            and isinstance(node.target, ast.Name)
            and not node.orelse
        ):
            self.refuse(
                node,
                "only 'for i in range(...)' can be exported, of whole numbers that are known when the "
                "shader is made.",
            )
        steps, named = self._steps(call)
        name = node.target.id
        self._check_name(node, name)
        if name in self.scope or name in self.arguments:
            self.refuse(node.target, f"{name!r} has a value already, which the loop would change.")
        if not steps:
            return
        outside, plain = dict(self.scope), set(self.plain)
        self.scope[name] = "float"
        counted = steps == range(len(steps))
        index = name if counted else self._fresh(f"{name}_count")
        self.plain |= {name, index}
        kept, self.statements = self.statements, []
        self.loops.append(Loop(frozenset(outside)))
        self.block(node.body, node.lineno)
        if self.done:
            self.refuse(node, "a loop cannot return; return its result after it.")
        loop = self.loops.pop()
        for changed, at in loop.changed.items():
            if changed in loop.shared:
                self._refuse_in_place(at, changed)
        body, self.statements = tuple(self.statements), kept
        if not counted and name in {e.name for e in walk(body) if isinstance(e, Variable)}:
            body = (Assign(name, _of_step(steps, Variable(index, "float"))), *body)
        self.scope, self.plain = outside, self.plain & plain
        self.own &= set(outside)
        self.statements.append(Repeat(index, len(steps), body, named))

    def _steps(self, node: ast.Call) -> tuple[range, Constant | None]:
        """The steps of a loop, and the name of their number if it has one."""
        given = [(at, self.value(at)) for at in node.args]
        whole = [self._whole(at, value) for at, value in given]
        try:
            steps = range(*whole)
        except (TypeError, ValueError) as error:
            self.refuse(node, f"Python cannot make these steps ({error}).")
        if len(steps) > STEPS_MAX:
            self.refuse(node, f"the number of steps must be {STEPS_MAX} at most, got {len(steps)}.")
        if steps and max(abs(steps[0]), abs(steps[-1])) > WHOLE_MAX:
            self.refuse(node, f"single precision counts to {WHOLE_MAX} only; begin at 0.")
        first = given[0][1]
        return steps, first if len(given) == 1 and isinstance(first, Constant) else None

    def _whole(self, node: ast.expr, value: Value) -> int:
        """A whole number that is known when the shader is made."""
        known = truth(self._resolved(value) if isinstance(value, Expr) else value)
        if known is None or isinstance(known.value, bool) or not isinstance(known.value, int):
            self._refuse_undecided(
                node,
                value,
                "this is not a whole number that is known when the shader is made; write one, or an "
                "option's, or a named number (with + - *).",
            )
        return known.value

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
            self._change(node, name, expr)
            expr = Variable(name, expr.type)
        if self.method in SIGNATURES and self.result is not None:
            expr = self._coerce(node, expr, self.result)
        if self.method == "sample":
            if expr.type is not self.reader.sample:
                self.refuse(node, "sample returns Sample(wi, pdf).")
            expr = self._waste_below(expr)
        if isinstance(expr.type, str) and expr.type in ("bool", "bool3") and self.method:
            self.refuse(node, "a mask is no result of this method.")
        self.places[id(expr)] = (expr, node)
        self.statements.append(Return(expr))
        self.result = expr.type
        self.done = True

    def _waste_below(self, expr: Expr) -> Expr:
        """A sample with pdf = 0 where wi is below the horizon; a model's `sample` sees to it itself."""
        if isinstance(expr, Call) and _is_contract(expr, "sample"):
            return expr
        if not isinstance(expr, Construction):
            if not isinstance(expr, Variable):
                name = self._fresh("drawn")
                self.statements.append(Assign(name, expr))
                expr = Variable(name, expr.type)
            expr = Construction(
                (Access(expr, "wi", "vec3"), Access(expr, "pdf", "float")), expr.type
            )
        wi, pdf = expr.arguments
        if not isinstance(wi, (Variable, Access)):
            name = self._fresh("wi")
            self.statements.append(Assign(name, wi))
            wi = Variable(name, "vec3")
        if _is_contract(pdf, "pdf") and same(children(pdf)[1], wi):
            return Construction((wi, pdf), expr.type)
        above = Operation(">", Access(wi, "z", "float"), self._horizon(), "bool")
        masked = Builtin("select", (above, pdf, Number(0)), "float")
        return Construction((wi, masked), expr.type)

    def _result_names(self, node: ast.expr) -> tuple[str, ...]:
        assert isinstance(node, ast.Tuple)
        names = [n.id if isinstance(n, ast.Name) else "" for n in node.elts]
        if not all(names) or len(set(names)) != len(names):
            self.refuse(
                node,
                "what is returned has no names; give each value one (return weight, pdf), or return a "
                "NamedTuple.",
            )
        return tuple(names)


def _of_step(steps: range, index: Expr) -> Expr:
    """What the variable of a loop is at a step, counted from 0."""
    moved = simplified("*", Number(abs(steps.step)), index, "float")
    sign = "+" if steps.step > 0 else "-"
    return simplified(sign, Number(steps.start), moved, "float")


def record_of(function: types.FunctionType, given: Sequence[Type | Static]) -> type | None:
    """The class of the user's own that a function is a method of, if the first of its arguments is one."""
    first = given[0] if given else None
    if not isinstance(first, Struct) or first.python is None:
        return None
    return first.python if records.of_method(function, first.python) else None


def _is_contract(expr: Expr, method: str) -> bool:
    """Whether it calls a model's own eval, sample or pdf, which is 0 below the horizon."""
    if not isinstance(expr, Call):
        return False
    return expr.function.owner is not None and expr.function.method == method


def _without_unused(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
    """Without variables that only the branches not taken would use."""
    while True:
        used = {e.name for e in walk(statements) if isinstance(e, Variable)}
        used |= {s.variable for s in statements if isinstance(s, SetMember)}
        kept = tuple(s for s in statements if not (isinstance(s, Assign) and s.name not in used))
        if len(kept) == len(statements):
            return kept
        statements = kept
