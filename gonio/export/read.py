"""From models to the functions and structs of one export, each once, callees before callers.

Every function is read for the types of its arguments, with the model's options known: conditions on them
are decided, and only the chosen branch is exported. docs/language.md describes what is understood; all
else is refused with its place and with what to write instead. `ast` is known to this file's
companions only: `gonio.export.source`, `statements`, `assignments`, `expressions`, and what that one names.
"""

from __future__ import annotations

import ast
import inspect
import types
from collections.abc import Iterable
from typing import Any, get_type_hints

from gonio import lang
from gonio.export import library, records
from gonio.export.builtin_calls import PRODUCT_MAX
from gonio.export.contract import SIGNATURES, UNTESTED, method_of, written
from gonio.export.expressions import UndecidedError
from gonio.export.names import legal, snake
from gonio.export.record_calls import ANNOTATED
from gonio.export.source import source
from gonio.export.stand_ins import usual_name
from gonio.export.statements import Body, record_of
from gonio.export.targets import TARGETS
from gonio.export.tree import (
    CALLED,
    Assign,
    Builtin,
    ExportError,
    Expr,
    Function,
    Member,
    Number,
    Operation,
    Return,
    Splat,
    Statement,
    Struct,
    Type,
    Variable,
)
from gonio.export.values import Static
from gonio.fields import Option, Parameter
from gonio.model import Child, Model
from gonio.table import Table

# What the annotations of a declaration mean, which has no arguments to take its types from.
OF_ANNOTATIONS: dict[Any, Type] = {**ANNOTATED, lang.Float: "float"}


# What any language calls otherwise: types have the same name in all of them, and in the manifest.
TAKEN = frozenset().union(*(t.reserved | set(t.types.values()) for t in TARGETS.values()))

# What users call, after the model's name.
ENTRIES = frozenset({*SIGNATURES, *CALLED, "material", "load"})


def camel(name: str) -> str:
    """A type's name made of a function's, such as CarPaint of car_paint."""
    return "".join(part[:1].upper() + part[1:] for part in name.split("_") if part)


class Reader:
    """Collects the functions and structs of one export, each once, callees before callers."""

    def __init__(
        self,
        prefix: str,
        lacking: frozenset[str],
        roots: Iterable[str] = (),
        *,
        differentiable: bool = False,
    ) -> None:
        """Begin an export.

        Args:
            prefix: of shared functions and types.
            lacking: functions of the vocabulary that are taken from the library.
            differentiable: whether the language takes derivatives of the text.
            roots: prefixes of the models that are exported, whose names are theirs.
        """
        self.prefix = prefix
        self.lacking = lacking
        self.differentiable = differentiable
        self._roots = {camel(name) for name in roots}
        self.structs: list[Struct] = []
        self.functions: list[Function] = []
        self.sample = self._add(
            Struct(
                self._struct_name("Sample"),
                (
                    Member("wi", "vec3", "direction towards the light, unit, local frame"),
                    Member("pdf", "float", "its density in 1/sr; 0 marks a wasted sample"),
                ),
                doc=("A sampled direction and its density.",),
            )
        )
        self._models: dict[Any, Struct] = {}
        self._read: dict[Any, Function] = {}
        self._origins: dict[int, types.FunctionType] = {}
        self._results: dict[Any, Struct] = {}
        self._powers: dict[tuple[int, Type], Function] = {}
        self._names: dict[str, types.CodeType | None] = {}
        self._called: dict[
            tuple[Struct, str], Function
        ] = {}  # methods by what languages with methods see
        self._methods: set[str] = set()  # what the models' methods are called
        self._open: list[Any] = []

    def _add(self, struct: Struct) -> Struct:
        self.structs.append(struct)
        return struct

    def model(self, model: Model, prefix: str, title: str = "") -> Struct:
        """The struct of a model's parameters; models that differ in their numbers only share it."""
        key = same_code(model)
        if not title and key in self._models:
            return self._models[key]
        if reason := getattr(model, "not_exported", ""):
            raise ExportError(f"{model.name} cannot be exported: {reason}.")
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
        text = [f"{doc}: {(model.written.__doc__ or '').strip().splitlines()[0]}"]
        if options:
            text.append(f"Exported with {', '.join(options)}.")
        name = self._struct_name("", prefix) if title else self._struct_name(prefix, "")
        struct = Struct(name, tuple(members), tuple(text), model, prefix)
        own = {name for cls in model.written.__mro__ for name in vars(cls)}
        self._methods |= {f"{prefix}_{name.strip('_')}" for name in own}
        self._models[key] = struct
        return self._add(struct)

    def method(self, owner: Struct, name: str) -> Function:
        """A method of a model, for the types of its declaration."""
        parameters, _ = SIGNATURES[name]
        return self.function_for(method_of(owner, name), [t for _, t in parameters], owner, name)

    def is_open(
        self, function: types.FunctionType, arguments: Iterable[Type | Static], owner: Struct | None
    ) -> bool:
        """Whether the function is being read, so that to call it would be to call itself."""
        return (function, owner, tuple(arguments)) in self._open

    def function_for(
        self,
        function: types.FunctionType,
        arguments: Iterable[Type | Static],
        owner: Struct | None = None,
        method: str = "",
        guarded: bool = True,
    ) -> Function:
        """A Python function as it is for some types of arguments; those of a model get its struct first.

        With `method`, one of SIGNATURES, it begins with the test for the horizon, unless not `guarded`.
        """
        given = tuple(arguments)
        guarded = guarded and method not in ("", UNTESTED)
        key = (function, owner, given, guarded)
        if key in self._read:
            return self._read[key]
        self._open.append((function, owner, given))
        before = [len(found) for found in self._collected()]
        try:
            made = Body(self, function, given, owner, method, guarded).read()
        except UndecidedError:
            # It is read again, with the numbers of its arguments
            for found, length in zip(self._collected(), before, strict=True):
                _shorten(found, length)
            self._open.pop()
            raise
        except RecursionError:
            file = source(function.__code__.co_filename)
            raise file.complaint(
                file.function(function),
                f"functions call each other too deeply, down to {function.__name__}; call fewer.",
            ) from None
        self._open.pop()
        plain = "eval_above" if method == UNTESTED else method or usual_name(function)
        if owner is None and (record := record_of(function, given)) is not None:
            plain = f"{snake(record.__name__)}_{plain.strip('_')}"
        inherited = False
        if owner is not None and owner.model is not None and function is not library.sampled_albedo:
            name = "eval" if method == UNTESTED else plain
            own = inspect.getattr_static(owner.model.written, name, None)
            inherited = own is not None and written(name, own) is not function
            # A helper is none of what users call: _eval beside eval
            inherited |= not method and plain.strip("_") in ENTRIES
        made.name = self._name(function, given, owner, plain, inherited)
        if inherited:
            made.method = f"{function.__module__.rpartition('.')[2]}_{plain.strip('_')}"
        if owner is not None:
            called = (owner, made.method.strip("_"))
            if called in self._called:  # f beside _f, or for another option: methods need names too
                made.method = made.name.removeprefix(f"{owner.prefix}_")
            self._called[called] = made
        self._read[key] = made
        self._origins[id(made)] = function
        self.functions.append(made)
        return made

    def _collected(self) -> tuple[list[Any] | dict[Any, Any], ...]:
        """All that grows while functions are read."""
        return (
            self.structs,
            self.functions,
            self._models,
            self._read,
            self._origins,
            self._results,
            self._powers,
            self._names,
            self._called,
        )

    def origin(self, function: Function) -> types.FunctionType | None:
        """The Python function that an exported one was read from; None of powers and of lookups."""
        return self._origins.get(id(function))

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
        # The same function for other types: of a NamedTuple, of a colour, or of a number; or for numbers
        records = [k.python for k in given if isinstance(k, Struct) and k.python is not None]
        other = "rgb" if "vec3" in given else "scalar"
        numbers = [k.value for k in given if isinstance(k, Static) and type(k.value) is int]
        if numbers and min(numbers) >= 0:
            other = "_".join(map(str, numbers))
        if records:
            other = snake(records[0].__name__)
        candidates = [f"{start}_{plain}", f"{start}_{file}_{plain}"]
        if inherited:  # what users call has the plain name
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
            plain = function.strip("_")
            members = tuple(Member(n, t) for n, t in zip(names, given, strict=True))
            struct = Struct(self._struct_name(plain), members)
            self._results[key] = self._add(struct)
        return self._results[key]

    def record(self, cls: type, given: tuple[Type | Static, ...]) -> Struct:
        """The struct of a NamedTuple or dataclass for these types of members, with its descriptions."""
        key = (cls, given)
        if key not in self._results:
            names = records.members(cls) or ()
            doc, docs = described(cls)
            members, fixed = [], []
            for name, kind in zip(names, given, strict=True):
                if isinstance(kind, Static):
                    fixed.append((name, kind.value))
                else:
                    members.append(Member(name, kind, docs.get(name, "")))
            self._results[key] = self._add(
                Struct(
                    self._struct_name(cls.__name__),
                    tuple(members),
                    doc,
                    fixed=tuple(fixed),
                    order=names,
                    python=cls,
                )
            )
        return self._results[key]

    def _struct_name(self, name: str, prefix: str | None = None) -> str:
        """A type's name that no other has, made of the prefix and a function's or class's name."""
        wanted = legal(camel(self.prefix if prefix is None else prefix) + camel(name), TAKEN)
        taken = {s.name for s in self.structs} | (self._roots - {wanted if not name else ""})
        return next(
            n for n in (wanted, *(f"{wanted}{i}" for i in range(2, 1000))) if n not in taken
        )

    def lookup(self, function: types.FunctionType) -> Function:
        """A function without a body, with the types of its annotations, which the host supplies."""
        if function not in self._read:
            hints = get_type_hints(function, include_extras=True)
            kinds = {name: OF_ANNOTATIONS[kind] for name, kind in hints.items()}
            result = kinds.pop("return")
            doc = tuple((inspect.getdoc(function) or "").splitlines())
            made = Function("", doc, tuple(kinds.items()), result, (), external=True)
            made.name, made.method = self._name(function, (), None, function.__name__, False), ""
            made.plain = function.__name__
            self._read[function] = made
            self.functions.append(made)
        return self._read[function]

    def table(self, table: Table, owner: Struct | None) -> Function:
        """A function without a body that reads an entry of a table, which a model's class may have."""
        if table not in self._read:
            start = self.prefix if owner is None else owner.prefix
            names = (
                f"{start}_{table.name}",
                *(f"{start}_{table.name}_{i}" for i in range(2, 1000)),
            )
            name = next(n for n in names if n not in self._names)
            size = " x ".join(map(str, table.shape))
            doc = (f"{table.doc or table.name}; an entry of {size}.",)
            result: Type = "vec3" if table.colours else "float"
            made = Function(
                name, doc, (("index", "float"),), result, (), external=True, table=table
            )
            made.plain = name.removeprefix(f"{self.prefix}_")
            self._names[name] = None
            self._read[table] = made
            self.functions.append(made)
        return self._read[table]

    def of_annotation(self, kind: Any) -> Type:
        """The type of an annotation: of the vocabulary, or the struct of a NamedTuple."""
        if (names := records.members(kind)) is not None:
            hints = get_type_hints(kind, include_extras=True)
            given = tuple(OF_ANNOTATIONS[hints[name]] for name in names)
            return self.record(kind, given)
        return OF_ANNOTATIONS[kind]

    def power(self, exponent: int, kind: Type) -> Function:
        """A function that multiplies a value with itself: right for negative values too."""
        key = (exponent, kind)
        if key not in self._powers:
            x = Variable("x", kind)
            body: list[Statement] = []

            def product(n: int) -> Expr:
                if n == 1:
                    return x
                if f"x{n}" not in {s.name for s in body if isinstance(s, Assign)}:
                    half = n // 2
                    value = Operation("*", product(half), product(n - half), kind)
                    body.append(Assign(f"x{n}", value))
                return Variable(f"x{n}", kind)

            if exponent <= PRODUCT_MAX:
                value = product(exponent)
                last = body.pop()
                assert isinstance(last, Assign)
                value = last.value
            else:
                even: Expr = Number(exponent - exponent % 2)
                if kind != "float":
                    even = Splat(even, kind)
                value = Builtin("power", (Builtin("absolute", (x,), kind), even), kind)
                if exponent % 2:
                    value = Operation("*", x, value, kind)
            doc = (f"x to the power {exponent}, for negative x as well.",)
            made = Function("", doc, (("x", kind),), kind, (*body, Return(value)), method="power")
            name = f"{self.prefix}_power_{exponent}" + ("" if kind == "float" else "_rgb")
            made.name = next(
                n for n in (name, *(f"{name}_{i}" for i in range(2, 100))) if n not in self._names
            )
            self._names[made.name] = None
            self._powers[key] = made
            self.functions.append(made)
        return self._powers[key]


def _shorten(found: list[Any] | dict[Any, Any], length: int) -> None:
    """Forget what was added last."""
    if isinstance(found, list):
        del found[length:]
    else:
        for key in list(found)[length:]:
            del found[key]


def described(cls: type) -> tuple[tuple[str, ...], dict[str, str]]:
    """The descriptions of such a class and of its members, from the file that defines it."""
    try:
        file = source(str(inspect.getsourcefile(cls)))
    except (TypeError, ExportError):
        return (), {}
    for node in ast.walk(file.tree):
        if isinstance(node, ast.ClassDef) and node.name == cls.__name__:
            docs = {}
            for line, after in zip(node.body, node.body[1:], strict=False):
                if (
                    isinstance(line, ast.AnnAssign)
                    and isinstance(line.target, ast.Name)
                    and isinstance(after, ast.Expr)
                    and isinstance(after.value, ast.Constant)
                ):
                    docs[line.target.id] = " ".join(str(after.value.value).split())
            return tuple((ast.get_docstring(node) or "").splitlines()), docs
    return (), {}


def same_code(model: Model) -> Any:
    """What makes the code of two models the same: class, options, and the kinds of inner models."""
    return (
        model.written,
        *(
            same_code(value) if isinstance(value, Model) else value
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
