"""Where a step in a model's own file has failed, and what to write there: one line for an exception."""

from __future__ import annotations

import ast
import importlib
import inspect
import linecache
import pkgutil
import re
import types
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gonio import lang, model, parts
from gonio.fields import ModelError
from gonio.messages import nearest
from gonio.model import Model, as_written

# Modules whose mathematics does not work on the values of a model, and how they are called.
FOREIGN = {"numpy", "math", "torch", "jax", "cmath", "scipy"}
ALIASES = re.compile(r"\b(np|numpy|math|torch|jnp|cmath)\.(\w+)")

# What the same is called in gonio.lang, where it has another name.
SPELLED = {
    "arccos": "safe_acos",
    "acos": "safe_acos",
    "arcsin": "safe_asin",
    "asin": "safe_asin",
    "where": "select",
    "clip": "clamp",
    "pow": "power",
    "abs": "absolute",
    "fabs": "absolute",
    "min": "minimum",
    "max": "maximum",
    "norm": "length",
    "linalg": "length",
    "inner": "dot",
    "pi": "PI",
    "array": "vec3",
    "if": "select",
}

# Declarations of a model's class, as they are written.
DECLARED = {
    "param": 'param(default, low, high, "what it means")',
    "option": 'option("first", "second", doc="what it means")',
    "child": 'child("lambert", "what it means")',
    "Sample": "Sample(wi, pdf)",
}

WRONG_CALL = re.compile(
    r"(\w+)\(\) (missing|takes|got)|missing a required argument|too many positional|unexpected keyword"
)

NOT_CALLED = re.compile(r"type '(method|function|builtin_function_or_method)'|^'(method|function)'")

TRUTH = (
    "a value has no truth of its own: it stands for many at once. Write select(condition, yes, no) in "
    "place of if, and & | ~ in place of and, or, not."
)

LANGUAGE = "docs/language.md says what methods are made of."


@dataclass(frozen=True)
class Stop:
    """The last step inside a model's own files that an exception went through."""

    filename: str
    line: int
    text: str
    """What failed: the part of the line, or the line where Python does not know."""
    names: dict[str, Any]
    """The module's, and those of the function."""

    @property
    def where(self) -> str:
        """File and line, as every message begins."""
        return place(self.filename, self.line)


def place(filename: str, line: int) -> str:
    """A line of a file, which is named as it is seen from the current folder if it is inside."""
    path, here = Path(filename), Path.cwd()
    return f"{path.relative_to(here) if path.is_relative_to(here) else path}, line {line}"


def stop(error: BaseException, files: Collection[str | None]) -> Stop | None:
    """Where an exception left these files; None if it was never in them."""
    found, trace = None, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename in files:
            found = trace
        trace = trace.tb_next
    if found is None:
        return None
    code, line = found.tb_frame.f_code, found.tb_lineno
    text = linecache.getline(code.co_filename, line)
    first, last, start, end = next(
        (p for n, p in enumerate(code.co_positions()) if n == found.tb_lasti // 2), (None,) * 4
    )
    if first == last == line and start is not None and end is not None:
        text = text.encode()[start:end].decode(errors="ignore")
    names = found.tb_frame.f_globals | found.tb_frame.f_locals
    return Stop(code.co_filename, line, text.strip(), names)


def own_files(cls: type[Model]) -> set[str | None]:
    """The files in which a model's class and those above it are written."""
    return {
        inspect.getsourcefile(c) for c in cls.__mro__ if issubclass(c, Model) and c is not Model
    }


def advice(error: BaseException, at: Stop, cls: type[Model] | None = None) -> str:
    """What to write in place of what failed; "" where only the exception itself can be told."""
    reason = " ".join(str(error).split())
    if isinstance(error, ModelError):
        return reason
    if isinstance(error, ImportError):
        return _not_there(error)
    if isinstance(error, NameError):
        return _unknown(error.name or "", cls)
    if isinstance(error, AttributeError):
        if "does not change" in reason:
            return f"a model does not change; give the value a name of its own, without self, in {at.text}."
        if text := _lacking(error, cls):
            return text
    if found := _foreign(at):
        name = SPELLED.get(found.rpartition(".")[2], found.rpartition(".")[2])
        write = (
            f"{name} of gonio.lang" if hasattr(lang, name) else f"what is in gonio.lang; {LANGUAGE}"
        )
        return f"{found} does not work on the values of a model; write {write.rstrip('.')}."
    if "__bool__" in reason or "truth value" in reason or "condition" in reason:
        return _truth(at)
    if isinstance(error, TypeError) and WRONG_CALL.search(reason):
        return _call(reason, at, cls)
    if NOT_CALLED.search(reason) and (text := _uncalled(at, cls)):
        return text
    if "NoneType" in reason:
        return f"{at.text} computes with None; every path through a helper has to end in 'return'."
    if "not callable" in reason:
        return f"{at.text.partition('(')[0]} is a value and no function; write it without ()."
    if "format string" in reason:
        return "a value stands for many numbers and has no text; leave the text out."
    if "unhashable" in reason:
        return "a value stands for many numbers and is no key; write select(condition, yes, no)."
    if "as an integer" in reason or "indices must be" in reason:
        return (
            "a value stands for many numbers and counts nothing; write a fixed number, such as range(8), "
            "and fetch(table, index) of gonio.table to look a value up."
        )
    if builtin := re.match(r"(float|int|round|complex|bool)\b", at.text):
        return f"{builtin[1]}() makes one number of many; leave it out: all values are floats."
    return ""


# --- names ---------------------------------------------------------------------------------------


def _not_there(error: ImportError) -> str:
    """An import of something that does not exist."""
    module = error.name or ""
    wanted = re.search(r"cannot import name '(\w+)'", str(error))
    if wanted is None:
        above, _, name = module.rpartition(".")
        try:
            path = importlib.import_module(above).__path__ if above else None
        except (ImportError, AttributeError):
            path = None
        known = [m.name for m in pkgutil.iter_modules(path)] if path else []
        near = nearest(name, known)
        hint = (
            f"did you mean {above}{'.' if above else ''}{near[0]}?" if near else "is it installed?"
        )
        return f"there is no module {module}; {hint}"
    name = wanted[1]
    try:
        known = [n for n in vars(importlib.import_module(module)) if not n.startswith("_")]
    except ImportError:
        known = []
    if home := _home(name):
        hint = f"write 'from {home} import {name}'."
    elif near := nearest(name, known):
        hint = f"did you mean {near[0]}?"
    else:
        hint = f"it has {', '.join(sorted(n for n in known if n.islower())[:8])}."
    return f"{module} has no {name}; {hint}"


def _home(name: str) -> str:
    """The module of gonio that has what a model's file may call by this name."""
    for module in (lang, model, *_parts()):
        found = vars(module).get(name)
        if found is not None and getattr(found, "__module__", module.__name__) == module.__name__:
            return module.__name__
    return "gonio.lang" if not name.startswith("_") and hasattr(lang, name) else ""


def _parts() -> Iterator[types.ModuleType]:
    for found in pkgutil.iter_modules(parts.__path__, f"{parts.__name__}."):
        yield importlib.import_module(found.name)


def _unknown(name: str, cls: type[Model] | None) -> str:
    """A name that is not known."""
    if home := _home(name):
        return f"{name} is not known here; write 'from {home} import {name}' at the top."
    if cls is not None and name in cls.fields:
        return f"{name} is not known here; a parameter is written self.{name}."
    if cls is not None and inspect.isfunction(getattr(cls, name, None)):
        return f"{name} is not known here; a method is written self.{name}(...)."
    near = nearest(name, (n for n in dir(lang) if not n.startswith("_")))
    hint = f"did you mean {near[0]!r} of gonio.lang?" if near else "define or import it."
    return f"{name} is not known here; {hint}"


def _lacking(error: AttributeError, cls: type[Model] | None) -> str:
    """Something that a model, a value, or a class above has not."""
    name, owner = error.name or "", error.obj
    methods = [n for n in dir(Model) if not n.startswith("_")]
    if isinstance(owner, super):
        near = nearest(name, methods)
        hint = f"; did you mean super().{near[0]}(...)?" if near else "."
        return f"no class above has {name!r}{hint}"
    if owner is super:
        return f"super is called: write super().{name}(...)."
    if isinstance(owner, Model):
        known = [*(cls or type(owner)).fields, *(n for n in dir(type(owner)) if n[:1] != "_")]
        near = nearest(name, known)
        hint = f"did you mean self.{near[0]}? Else declare" if near else "declare"
        return (
            f"the model has no {name!r}; {hint} it in the class: "
            f'{name}: Float = param(0.5, 0, 1, "what it means").'
        )
    if isinstance(owner, lang.Sample):
        return f"a Sample has wi and pdf, no {name!r}."
    if isinstance(owner, types.ModuleType):
        return ""
    if type(owner).__module__.startswith("drjit") or isinstance(owner, (int, float)):
        write = SPELLED.get(name, name)
        if hasattr(lang, write):
            return f"a value has no {name!r}; write {write}(...) of gonio.lang."
        return f"a value has no {name!r}; vectors and colours have .x, .y and .z. {LANGUAGE}"
    return ""


def _foreign(at: Stop) -> str:
    """A function of a module that knows nothing of a model's values, as it stands there."""
    if found := ALIASES.search(at.text):
        return found[0]
    for name in re.findall(r"(?<![\w.])([A-Za-z_]\w*)(?=\()", at.text):
        value = at.names.get(name)
        if str(getattr(value, "__module__", "")).partition(".")[0] in FOREIGN:
            return str(name)
    return ""


# --- calls ---------------------------------------------------------------------------------------


def _truth(at: Stop) -> str:
    """What to write in place of a decision about a value."""
    line = linecache.getline(at.filename, at.line).strip()
    if found := re.search(r"\b(min|max)\(", at.text):
        return f"{found[1]} cannot compare the values of a model; write {SPELLED[found[1]]} of gonio.lang."
    if line.startswith("while"):
        return f"{TRUTH} A loop has a fixed number of steps: for i in range(8)."
    if line.startswith("assert"):
        return "a value stands for many at once, so that assert cannot judge it; leave it out."
    try:
        tree: ast.AST | None = ast.parse(at.text, mode="eval")
    except SyntaxError:
        tree = None
    if tree and any(isinstance(n, ast.Compare) and len(n.ops) > 1 for n in ast.walk(tree)):
        return f"{TRUTH} Of two limits, as in a < x < b, write (a < x) & (x < b)."
    return TRUTH


def _call(reason: str, at: Stop, cls: type[Model] | None) -> str:
    """A call with other arguments than the function has."""
    named = re.search(r"(\w+)\(\) (?:missing|takes|got)", reason)
    try:
        tree: ast.AST | None = ast.parse(at.text, mode="eval")
    except SyntaxError:
        tree = None
    call = next((n for n in ast.walk(tree) if isinstance(n, ast.Call)), None) if tree else None
    spoken = ast.unparse(call.func) if call is not None else named[1] if named else ""
    name = spoken.rpartition(".")[2]
    if name in DECLARED:
        return f"write {DECLARED[name]}; {_plain(reason)}."
    function = as_written(at.names.get(name))
    inside = inspect.isfunction(getattr(cls, name, None)) and "." in spoken
    if inside:
        function = as_written(getattr(cls, name))
    if not callable(function):
        return f"{_plain(reason)}."
    arguments = list(inspect.signature(function, follow_wrapped=False).parameters)
    if (
        inside
        and "self" not in arguments
        and not spoken.startswith(str(getattr(cls, "__name__", "")))
    ):
        return (
            f"{name} is a method without self; write def {name}({', '.join(['self', *arguments])})."
        )
    if inside and arguments[:1] == ["self"] and call is not None and _bound(call.func, cls):
        arguments = arguments[1:]
    return f"write {spoken}({', '.join(arguments)}); {_plain(reason)}."


def _bound(function: ast.expr, cls: type[Model] | None) -> bool:
    """Whether a method is called of an instance, not of a class by its name."""
    value = function.value if isinstance(function, ast.Attribute) else None
    names = {c.__name__ for c in cls.__mro__} if cls else set()
    return not (isinstance(value, ast.Name) and value.id in names)


def _plain(reason: str) -> str:
    """Python's words about a call, without the names of classes."""
    reason = reason.replace(".__new__()", "()")
    return re.sub(r"\b[\w.]*\.(\w+\(\))", r"\1", reason).rstrip(".")


def _uncalled(at: Stop, cls: type[Model] | None) -> str:
    """A method or function that stands without its arguments."""
    try:
        tree = ast.parse(at.text, mode="eval")
    except SyntaxError:
        return ""
    called = {id(n.func) for n in ast.walk(tree) if isinstance(n, ast.Call)}
    for node in ast.walk(tree):
        if id(node) in called or not isinstance(node, (ast.Attribute, ast.Name)):
            continue
        method = isinstance(node, ast.Attribute)
        name = node.attr if isinstance(node, ast.Attribute) else node.id
        found: Callable[..., Any] | None = (
            getattr(cls, name, None) if method else at.names.get(name)
        )
        if inspect.isfunction(found):
            arguments = list(inspect.signature(found).parameters)[1 if method else 0 :]
            kind = "method" if method else "function"
            return f"{name} is a {kind}; write {ast.unparse(node)}({', '.join(arguments)})."
    return ""
