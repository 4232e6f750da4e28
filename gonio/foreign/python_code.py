"""Functions of Python on arrays as foreign code: file.py#function, or module:function.

The file is read without running it; it is imported in the process that calls it.
"""

from __future__ import annotations

import ast
import importlib.util
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from gonio.foreign.declarations import Function, Variable
from gonio.foreign.roles import COSINES, DIRECTIONS, Matched
from gonio.foreign.source import ForeignError, Source

# Names of arguments that are colours where neither a default nor an annotation says so.
_COLOURS = frozenset(
    [
        "color",
        "colour",
        "basecolor",
        "base_color",
        "albedo",
        "rho",
        "tint",
        "diffuse_color",
        "specular_color",
        "reflectance",
    ]
)
_VECTOR = re.compile(r"(?i)vec(tor)?_?3|color|colour|rgb|spectrum|direction|normal3")

# Names whose values are two random numbers.
PAIRS = frozenset(["u", "xi", "rand", "rnd", "random", "uv", "e", "sample"])


def split_python(text: str) -> tuple[str, str] | None:
    """File or module, and function; None for what is no function of Python."""
    file, sign, name = text.rpartition("#")
    if sign and file.endswith(".py") and name:
        return file, name
    match = re.fullmatch(r"([A-Za-z_][\w.]*):([A-Za-z_]\w*)", text)
    if match is None:
        return None
    try:
        found = importlib.util.find_spec(match[1])
    except (ImportError, ValueError):
        return None
    origin = "" if found is None else str(found.origin or "")
    return (match[1], match[2]) if origin.endswith(".py") else None


def is_python(text: str) -> bool:
    """Whether a text names a function of Python."""
    return split_python(text) is not None


def read(text: str) -> Source:
    """Read the file of a function, without running it.

    Raises:
        ForeignError: there is no such file, or it is not Python.
    """
    parts = split_python(text)
    assert parts is not None
    name = parts[0]
    if not name.endswith(".py"):
        found = importlib.util.find_spec(name)
        assert found is not None
        name = str(found.origin)
    path = Path(name)
    try:
        code = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ForeignError(f"{path}: {error.strerror or error}") from None
    try:
        tree = ast.parse(code)
    except SyntaxError as error:
        raise ForeignError(f"{path}:{error.lineno}: {error.msg}") from None
    functions = tuple(
        Function(
            node.name,
            (),
            "vec4",
            tuple(_arguments(node)),
            node.lineno,
            ast.get_source_segment(code, node) or "",
        )
        for node in tree.body
        if isinstance(node, ast.FunctionDef)
    )
    module = "" if parts[0].endswith(".py") else parts[0]
    return Source(path, "python", code, functions, {}, (), (path,), module=module)


def _arguments(node: ast.FunctionDef) -> Iterable[Variable]:
    given = [*node.args.posonlyargs, *node.args.args]
    defaults: list[ast.expr | None] = [None] * (len(given) - len(node.args.defaults))
    defaults += node.args.defaults
    given += node.args.kwonlyargs
    defaults += node.args.kw_defaults
    for argument, default in zip(given, defaults, strict=True):
        value: Any = None
        if default is not None:
            try:
                value = ast.literal_eval(default)
            except ValueError:
                value = None
        kind = _kind(argument, value)
        numbers: tuple[float, ...] = ()
        if isinstance(value, (bool, int, float)):
            numbers = (float(value),)
        elif isinstance(value, (tuple, list)) and all(isinstance(v, (int, float)) for v in value):
            numbers = tuple(float(v) for v in value)
        yield Variable(argument.arg, kind, default=numbers)


def _kind(argument: ast.arg, value: Any) -> str:
    note = "" if argument.annotation is None else ast.unparse(argument.annotation)
    plain = argument.arg.lower().replace("_", "")
    if isinstance(value, bool) or note == "bool":
        return "bool"
    if note == "int" and not isinstance(value, float):
        return "int"
    if isinstance(value, (tuple, list)) and len(value) in (2, 3):
        return f"vec{len(value)}"
    if any(plain in names.split() for names in COSINES.values()):
        return "float"
    if any(plain in names.split() for names in DIRECTIONS.values()) and value is None:
        return "vec3"
    if _VECTOR.search(note) or (argument.arg.lower() in _COLOURS and value is None):
        return "vec3"
    return "vec2" if argument.arg.lower() in PAIRS and value is None else "float"


def job(source: Source, function: Function, matched: Matched) -> str:
    """What the process is told, as JSON."""
    arguments: list[list[Any]] = []
    column = 0
    for leaf, _ in matched.leaves:
        arguments.append([leaf.place, column, leaf.width, leaf.type if leaf.whole else ""])
        column += leaf.width
    return json.dumps(
        {
            "path": str(source.path.resolve()),
            "module": source.module,
            "folder": str(Path.cwd()),
            "function": function.name,
            "arguments": arguments,
        }
    )
