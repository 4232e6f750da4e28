"""Assignments of a Python function as statements of a checked tree: names, types, what shares a value."""

from __future__ import annotations

import ast
import types
from collections import Counter
from dataclasses import dataclass, field
from typing import NoReturn

from gonio.export.aliases import aliases
from gonio.export.calls import Calls
from gonio.export.collector import Collector
from gonio.export.tree import (
    Access,
    Assign,
    Call,
    Constant,
    Expr,
    Negation,
    Number,
    Operation,
    SetMember,
    Statement,
    Struct,
    Variable,
    children,
    inside,
)
from gonio.export.values import Changed, Many, Method, Static, Value, is_number


@dataclass
class Loop:
    """What is known of a loop whose body is being read."""

    outside: frozenset[str]
    """Names that have a value before it."""
    shared: set[str] = field(default_factory=set)
    """Names that come to have the value of another one in it."""
    changed: dict[str, ast.AugAssign] = field(default_factory=dict)
    """Names from outside that are changed in place."""


_SIGNS: dict[type, str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.BitAnd: "&",
    ast.BitOr: "|",
}


class Assignments(Calls):
    """Reads the assignments of one function."""

    def __init__(
        self, reader: Collector, function: types.FunctionType, owner: Struct | None
    ) -> None:
        """Begin a function, which may be the method of a model."""
        super().__init__(reader, function, owner)
        self.statements: list[Statement] = []
        self.node = self.source.function(function)
        names = [n for n in ast.walk(self.node) if isinstance(n, ast.Name)]
        self.used = {n.id for n in names}
        stored = Counter(n.id for n in names if isinstance(n.ctx, ast.Store))
        self.once = {name for name, times in stored.items() if times == 1}
        self.unread = {"_"} - {n.id for n in names if isinstance(n.ctx, ast.Load)}
        # Names whose value no other name has: `x += y` changes it in place
        self.own: set[str] = set()
        self.loops: list[Loop] = []

    def _fresh(self, name: str) -> str:
        """A local name that the function does not use; its type is set by the caller."""
        free = (n for n in (name, *(f"{name}_{i}" for i in range(2, 100))) if n not in self.used)
        name = next(free)
        self.used.add(name)
        return name

    def _assign(self, node: ast.Assign) -> None:
        value = self._result(node.value)
        for i, target in enumerate(node.targets):
            if isinstance(target, ast.Name):
                self._store(node, target.id, value)
                if i + 1 < len(node.targets) and not isinstance(value, (Static, Method, Many)):
                    if self.scope[target.id] != value.type:
                        self.refuse(
                            node,
                            f"{target.id} has a value of another type before; write a statement of its own "
                            "for each name.",
                        )
                    value = Variable(target.id, value.type)  # computed once
            elif isinstance(target, ast.Tuple) and len(node.targets) == 1:
                names = [t.id for t in target.elts if isinstance(t, ast.Name)]
                if len(names) != len(target.elts):
                    self.refuse(target, "only names can be assigned; unpack once more below.")
                self._unpack(node, names, value)
            else:
                self.refuse(target, "only a name, or names separated by commas, can be assigned.")

    def _augment(self, node: ast.AugAssign) -> None:
        """x += y, which changes x in place: in Python other names may have its value, and change too."""
        target = node.target
        if not isinstance(target, ast.Name):
            self.refuse(
                target, "only a name can be changed; write v = vec3(...) with what changes."
            )
        name = target.id
        if name in self.arguments or name == self.self_name:
            self.refuse(
                node,
                f"{name} is an argument, which Python would change for the caller as well; write "
                f"{name}_changed = ...",
            )
        known = self.scope.get(name)
        if isinstance(known, Static):
            self.refuse(
                node,
                f"{name} is known when the shader is made and cannot be changed; write another name = "
                f"{name} {_SIGNS.get(type(node.op), '+')} ...",
            )
        if known is None:
            self.refuse(node, f"{name} has no value here that could be changed.")
        if name not in self.own and type(node.op) in _SIGNS:
            self._refuse_in_place(node, name)
        for loop in self.loops:
            if name in loop.outside:
                loop.changed.setdefault(name, node)
        value = self._operation(node, node.op, Variable(name, known), self.expr(node.value))
        self._store(node, name, value)

    def _refuse_in_place(self, node: ast.AugAssign, name: str) -> NoReturn:
        self.refuse(
            node,
            f"{name} may be the value of another name too, which Python changes with it; write "
            f"{name} = {name} {_SIGNS.get(type(node.op), '+')} ...",
        )

    def _note_sharing(self, name: str, value: Expr) -> None:
        """Take note of which names may have one value: a += b would change it for all of them."""
        shared = aliases(value)
        self.own -= shared
        for loop in self.loops:
            loop.shared |= shared
        if shared:
            self.own.discard(name)
            for loop in self.loops:
                loop.shared.add(name)
        else:
            self.own.add(name)

    def _result(self, node: ast.expr) -> Value:
        value = self.value(node)
        if isinstance(value, Method):
            self.refuse(node, "a method must be called.")
        if isinstance(value, Static) and is_number(value.value):
            value = self._number(node, value.value)  # which may change later: t = n
        return value

    def _unpack(self, node: ast.Assign, names: list[str], value: Value) -> None:
        if isinstance(value, Static) and isinstance(value.value, tuple):
            if len(value.value) != len(names):
                self.refuse(node, f"{len(names)} names for {len(value.value)} values.")
            for name, known in zip(names, value.value, strict=True):
                value = self._number(node, known) if is_number(known) else Static(known)
                self._store(node, name, value)
            return
        if isinstance(value, Many):
            values = list(value.values)
            if len(values) != len(names):
                self.refuse(node, f"{len(names)} names for {len(values)} values.")
            for i, v in enumerate(values):
                # All values are taken before the first name gets its own: a, b = b, a
                if {e.name for e in inside(v) if isinstance(e, Variable)} & set(names[:i]):
                    label = self._fresh(f"new_{names[i].strip('_')}")
                    self._store(node, label, v)
                    values[i] = Variable(label, v.type)
            for name, v in zip(names, values, strict=True):
                if name not in self.unread:
                    self._store(node, name, v)
            return
        expr = self._expr(node.value, value)
        kind = expr.type
        if kind in ("vec2", "vec3"):
            parts = ", ".join(f"v.{axis}" for axis in "xyz"[: 2 if kind == "vec2" else 3])
            self.refuse(node, f"a {kind} is one value; write its components: ... = {parts}.")
        if not isinstance(kind, Struct) or kind.model is not None:
            self.refuse(node, f"this is not {len(names)} values.")
        if kind.python is not None and not issubclass(kind.python, tuple):
            self.refuse(
                node,
                f"Python unpacks no dataclass; write its members: ... = made.{kind.order[0]}, ...",
            )
        if len(kind.members) + len(kind.fixed) != len(names):
            self.refuse(node, f"this is not {len(names)} values.")
        if not isinstance(expr, Variable):
            label = expr.function.method.strip("_") if isinstance(expr, Call) else "several"
            label = self._fresh(f"{label}_result")
            self.statements.append(Assign(label, expr))
            self.made[label] = expr
            self._note_origin(label, expr)
            expr = Variable(label, kind)
        types = {m.name: m.type for m in kind.members}
        fixed = dict(kind.fixed)
        for name, member in zip(names, kind.order or types, strict=True):
            if name not in self.unread:
                known = Static(fixed[member]) if member in fixed else None
                self._store(node, name, known or Access(expr, member, types[member]))

    def _store(self, node: ast.stmt, name: str, value: Value) -> None:
        self._check_name(node, name)
        known = self.scope.get(name)
        repeated = any(name in loop.outside for loop in self.loops)
        if isinstance(value, (Static, Method)):
            if isinstance(value, Method):
                self.refuse(node, "a method must be called.")
            if not isinstance(known, Static) and known is not None:
                self.refuse(node, f"{name} cannot be a number here and something else there.")
            if repeated:
                self.refuse(
                    node,
                    f"{name} changes from step to step, but is known when the shader is made; make it "
                    "a number, or write the first step before the loop.",
                )
            self.scope[name] = value
            return
        if isinstance(value, Many):
            self.refuse(node, f"several values for one name; unpack them: {name}_1, {name}_2 = ...")
        if isinstance(value, Variable) and value.name == name and known == value.type:
            return  # tint = white if tint is None else tint
        if name in self.arguments or name == self.self_name:
            self.refuse(node, f"the argument {name} cannot be assigned; use another name.")
        if isinstance(known, Static) and repeated:
            self.refuse(node, f"{name} cannot be a number here and something else there.")
        if isinstance(value, Changed):
            self._change(node, name, value)
            return
        self._note_sharing(name, value)
        self.places[id(value)] = (value, node)
        self._note_origin(name, value)
        names = {e.name for e in inside(value) if isinstance(e, Variable)}
        dynamic = (Access, Call)
        if names <= self.plain and not any(isinstance(e, dynamic) for e in inside(value)):
            self.plain.add(name)
        else:
            self.plain.discard(name)
        if known is None or isinstance(known, Static):
            if name in self.once and self._is_arithmetic(resolved := self._resolved(value)):
                self.given[name] = resolved
            if name in self.once:
                self.made[name] = value
            self.scope[name] = value.type
            self.statements.append(Assign(name, value))
            return
        if (known, value.type) == ("float", "vec3"):
            self.refuse(
                node,
                f"a vec3 where a number is expected, which {name} was before; begin with "
                f"{name} = vec3(...), or use another name.",
            )
        value = self._coerce(node, value, known)
        self.statements.append(Assign(name, value, declares=False))

    def _note_origin(self, name: str, value: Expr) -> None:
        """Take note of the arguments that a value is made of, if of nothing else but numbers."""
        names = {e.name for e in inside(value) if isinstance(e, Variable)} - self.plain
        known = [frozenset({n}) if n in self.arguments else self.made_of.get(n) for n in names]
        self.made_of[name] = self.made_of.get(name, frozenset()).union(*(k for k in known if k))
        if None in known:
            del self.made_of[name]

    def _is_arithmetic(self, expr: Expr) -> bool:
        """Whether a value is made of numbers and of the function's own arguments alone."""
        if isinstance(expr, Variable):
            return expr.name in self.arguments
        if isinstance(expr, (Operation, Negation)) and expr.type in ("float", "bool"):
            return all(self._is_arithmetic(e) for e in children(expr))
        return isinstance(expr, (Number, Constant))

    def _change(self, node: ast.stmt, name: str, value: Changed) -> None:
        """A copy of a model, and then its changed members."""
        known = self.scope.get(name)
        self.own.discard(name)
        if known is not None:
            if known is not value.type:
                self.refuse(node, f"{name} is another model already; use another name.")
            if any(isinstance(e, Variable) and e.name == name for e in inside(value.model)):
                self.refuse(node, f"{name} is changed by itself; use another name.")
        self.scope[name] = value.type
        self.statements.append(Assign(name, value.model, declares=known is None))
        for member, expr in value.members.items():
            assert isinstance(value.type, Struct)
            self.statements.append(SetMember(name, member, expr, value.type))
