"""A user's own model file: loads one Python file and finds the model in it.

    from gonio.materials import model_file
    cls = model_file.load("my_model.py")
    cls(roughness=0.3).eval(wi, wo)

The model gets the file's name, as one in the package would, and does not enter gonio's registry: two files
of one name, or one named like a model of gonio's, do not disturb each other.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import inspect
import os
import sys
from importlib.abc import SourceLoader
from pathlib import Path

from gonio.fields import ModelError
from gonio.materials.advice import advice, stop
from gonio.model import Model, _registry


class ModelFileError(ModelError):
    """A file without a usable model; the message names the file, the line and what to do."""


_loaded: dict[tuple[Path, str], type[Model]] = {}

PACKAGE = "gonio_model_files."
"""Begins the names of the modules that files become; nothing else is in that package."""


def is_model_file(text: str) -> bool:
    """Whether a text names a Python file rather than a model."""
    return text.endswith(".py")


def path_of(cls: type[Model]) -> str | None:
    """The file that `load` read a model from, seen from the current folder if inside; else None."""
    if not cls.__module__.startswith(PACKAGE):
        return None
    path, here = Path(inspect.getfile(cls)), Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)


def load(path: str | Path) -> type[Model]:
    """Run a Python file and return the one model class that it defines.

    A file may define helpers with `class Helper(Model, register=False)` that start with an underscore; of
    several others one has to be named like the file (my_model.py: MyModel).

    Raises:
        ModelFileError: no such file, it does not run, or it defines no model or several.
    """
    path = Path(path)
    if not path.is_file():
        raise ModelFileError(
            f"there is no file {path}; give the path of a Python file that defines a model."
        )
    try:
        source = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ModelFileError(f"{path}: not a text file in UTF-8.") from None
    key = (path.resolve(), hashlib.sha256(source.encode()).hexdigest())
    if key not in _loaded:
        _loaded[key] = _run(path, source)
    return _loaded[key]


def _run(path: Path, source: str) -> type[Model]:
    # The name of the module is the model's name
    name = PACKAGE + path.stem
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or not isinstance(spec.loader, SourceLoader):
        raise ModelFileError(f"{path}: Python cannot load a file of this name.")
    module = importlib.util.module_from_spec(spec)
    before, registered = sys.modules.get(name), dict(_registry)
    sys.modules[name] = module
    _registry.pop(path.stem, None)  # a file may be named like a model of gonio's
    try:
        # Not by the loader's bytecode, which it takes for a file's if second and size are the same
        exec(spec.loader.source_to_code(source.encode(), spec.origin or str(path)), vars(module))
    except Exception as error:
        if before is None:
            del sys.modules[name]
        else:
            sys.modules[name] = before
        raise ModelFileError(_problem(path, error)) from error
    finally:
        _registry.clear()
        _registry.update(registered)
    return _only_model(path, name, vars(module))


def _only_model(path: Path, module: str, names: dict[str, object]) -> type[Model]:
    found = [
        value
        for name, value in names.items()
        if isinstance(value, type)
        and issubclass(value, Model)
        and value.__module__ == module
        and not name.startswith("_")
    ]
    if not found:
        raise ModelFileError(
            f"{path} defines no model; derive a class from gonio.model.Model (see docs/adding_a_model.md)."
        )
    if len(found) > 1:
        wanted = path.stem.replace("_", "").lower()
        same = [cls for cls in found if cls.__name__.lower() == wanted]
        if len(same) != 1:
            names_ = ", ".join(cls.__name__ for cls in found)
            raise ModelFileError(
                f"{path} defines several models ({names_}); name one like the file, "
                "or let the others' names start with an underscore."
            )
        found = same
    cls = found[0]
    cls.name = path.stem.encode(errors="replace").decode()  # Mitsuba's names are UTF-8
    for method in ("eval", "sample", "pdf"):
        if getattr(cls, method) is getattr(Model, method):
            wanted = ", ".join(inspect.signature(getattr(Model, method)).parameters)
            raise ModelFileError(
                f"{path}, line {_line_of_class(cls)}: {cls.__name__} has no method {method}; write "
                f"def {method}({wanted})."
            )
    return cls


def _line_of_class(cls: type[Model]) -> int:
    return inspect.getsourcelines(cls)[1]


def _line_of_nul(path: Path) -> int:
    """Where a file has its first null byte, of which Python does not say the line."""
    return path.read_bytes().partition(b"\0")[0].count(b"\n") + 1


def _problem(path: Path, error: Exception) -> str:
    """What went wrong in a user's file, in one line with the file's line number."""
    if isinstance(error, SyntaxError):
        return f"{path}, line {error.lineno or _line_of_nul(path)}: {error.msg}."
    at = stop(error, {str(path), str(path.resolve()), os.path.abspath(path)})
    if at is None:
        return f"{path}: {type(error).__name__}: {error}"
    where = f"{path}, line {at.line}"
    if isinstance(error, ModelError) and error.about:
        where = f"{path}, line {_line_of(path, at.line, error.about)}"
    if text := advice(error, at):
        return f"{where}: {text}"
    return f"{where}: {type(error).__name__}: {error}"


def _line_of(path: Path, line: int, name: str) -> int:
    """The line of a declaration or method in the class that stands in a line; else the latter."""
    for cls in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(cls, ast.ClassDef) and line in (
            cls.lineno,
            cls.lineno - len(cls.decorator_list),
        ):
            for node in reversed(cls.body):
                targets = (
                    node.targets
                    if isinstance(node, ast.Assign)
                    else [getattr(node, "target", node)]
                )
                names = [getattr(t, "id", getattr(t, "name", "")) for t in targets]
                if name in names:
                    return node.lineno
    return line
