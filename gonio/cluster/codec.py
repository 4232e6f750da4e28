"""Inputs and results of tasks as bytes: the same value is the same bytes, on every machine.

Numbers, texts, lists, tuples, dictionaries, arrays, models, materials and gonio's own dataclasses. A `Path`
is a file, which travels by its content: the bytes hold its name and digest, and the one who reads them says
where the content lies. Nothing is executed when bytes are read, as pickles would.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib
import inspect
import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio import measured
from gonio.materials import model_file
from gonio.model import Model, models

# What marks a value that JSON has no word for.
MARK = "!"

# Files that name others, which would be missing where the content arrives.
GLTF = ".gltf"


class NotPortableError(ValueError):
    """A value that cannot be sent to another machine; the message says what to do."""


Place = Callable[[str, str], Path]
"""Where a file's content lies, by its digest and name."""


def encode(value: Any) -> tuple[bytes, dict[str, Path]]:
    """A value as bytes, and the files that it names, by their digests.

    Raises:
        NotPortableError: there is something in it that exists on this machine only.
        OSError: a file cannot be read.
    """
    writer = _Writer()
    tree = writer.tree(value)
    text = json.dumps(tree, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    buffer = io.BytesIO()
    # Each array in a file of its own: NumPy's format, which pickles nothing
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr(zipfile.ZipInfo("tree.json"), text)
        for number, array in enumerate(writer.arrays):
            data = io.BytesIO()
            np.lib.format.write_array(data, array, allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{number}.npy"), data.getvalue())
    return buffer.getvalue(), writer.files


def decode(data: bytes, place: Place | None = None) -> Any:
    """The value that bytes stand for.

    Args:
        data: as `encode` makes them.
        place: says where files lie; without it there may be none.

    Raises:
        ValueError: these are no such bytes.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            tree = json.loads(archive.read("tree.json"))
            arrays = [
                np.lib.format.read_array(
                    io.BytesIO(archive.read(f"{number}.npy")), allow_pickle=False
                )
                for number in range(len(archive.namelist()) - 1)
            ]
    except (zipfile.BadZipFile, KeyError, EOFError) as error:
        raise ValueError(f"these bytes are none of gonio's: {error}.") from None
    return _Reader(arrays, place).value(tree)


class _Writer:
    """Makes a tree that JSON can hold, and collects what it cannot."""

    def __init__(self) -> None:
        self.arrays: list[NDArray[Any]] = []
        self.files: dict[str, Path] = {}

    def tree(self, value: Any) -> Any:
        if value is None or isinstance(value, (bool, str)):
            return value
        if isinstance(value, (int, np.integer)):
            return int(value)
        if isinstance(value, (float, np.floating)):
            return float(value)  # its shortest text gives the same bits back
        if isinstance(value, list):
            return [self.tree(v) for v in value]
        if isinstance(value, tuple):
            return {MARK: "tuple", "of": [self.tree(v) for v in value]}
        if isinstance(value, dict):
            pairs = [[self.tree(k), self.tree(v)] for k, v in value.items()]
            return {MARK: "dict", "of": pairs}
        if isinstance(value, np.ndarray):
            self.arrays.append(np.ascontiguousarray(value))
            return {MARK: "array", "of": len(self.arrays) - 1}
        if isinstance(value, Path):
            return self.file(value)
        if isinstance(value, Model):
            return self.model(value)
        if dataclasses.is_dataclass(value) and type(value).__module__.startswith("gonio."):
            cls = type(value)
            fields = {f.name: self.tree(getattr(value, f.name)) for f in dataclasses.fields(value)}
            return {MARK: "data", "class": f"{cls.__module__}:{cls.__qualname__}", "of": fields}
        raise NotPortableError(
            f"a {type(value).__name__} cannot be sent to another machine; give numbers, models and files."
        )

    def file(self, path: Path) -> Any:
        if path.suffix.lower() == GLTF:
            _complete(path)
        found = digest(path)
        self.files[found] = path
        return {MARK: "file", "digest": found, "name": path.name}

    def model(self, model: Model) -> Any:
        cls = model.written
        source: Any
        if models().get(cls.name) is cls:
            source = cls.name
        elif (path := measured.source_of(cls)) is not None:
            source = {"data": self.file(path)}
        elif cls.__module__.startswith(model_file.PACKAGE):
            source = {"code": self.file(_alone(Path(inspect.getfile(cls))))}
        else:
            raise NotPortableError(
                f"{cls.name} is defined in this program; put it into a file of its own, my_model.py, so "
                "that it can be sent to other machines."
            )
        fields = {name: self.tree(getattr(model, name)) for name in model.fields}
        return {MARK: "model", "source": source, "of": fields}


class _Reader:
    """Makes values of a tree."""

    def __init__(self, arrays: list[NDArray[Any]], place: Place | None) -> None:
        self.arrays, self.place = arrays, place

    def value(self, tree: Any) -> Any:
        if isinstance(tree, list):
            return [self.value(v) for v in tree]
        if not isinstance(tree, dict):
            return tree
        kind: str = tree[MARK]
        of: Any = tree.get("of")
        if kind == "tuple":
            return tuple(self.value(v) for v in of)
        if kind == "dict":
            return {self.value(k): self.value(v) for k, v in of}
        if kind == "array":
            return self.arrays[of]
        if kind == "file":
            return self.file(tree)
        if kind == "model":
            return self.model(tree["source"])(**{name: self.value(v) for name, v in of.items()})
        if kind == "data":
            return _dataclass(tree["class"])(**{name: self.value(v) for name, v in of.items()})
        raise ValueError(f"no kind of value is called {kind!r}.")

    def file(self, tree: dict[str, str]) -> Path:
        if self.place is None:
            raise ValueError(f"the content of {tree['name']} is not here.")
        return self.place(tree["digest"], tree["name"])

    def model(self, source: Any) -> type[Model]:
        if isinstance(source, str):
            return models()[source]
        if "data" in source:
            return measured.model_class(self.file(source["data"]))
        return model_file.load(self.file(source["code"]))


def _dataclass(name: str) -> Any:
    """One of gonio's own dataclasses, and nothing else."""
    module, _, qualname = name.partition(":")
    if not module.startswith("gonio."):
        raise ValueError(f"{name} is no dataclass of gonio's.")
    found: Any = importlib.import_module(module)
    for part in qualname.split("."):
        found = getattr(found, part)
    if not dataclasses.is_dataclass(found):
        raise ValueError(f"{name} is no dataclass of gonio's.")
    return found


def digest(path: Path) -> str:
    """SHA-256 of a file's content; computed again when the file has changed."""
    found = path.stat()
    return _digest(path, found.st_mtime_ns, found.st_size)


@functools.lru_cache(maxsize=4096)
def _digest(path: Path, modified: int, size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _alone(path: Path) -> Path:
    """A model file that imports nothing that lies beside it."""
    import ast

    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        for name in names:
            first = name.partition(".")[0]
            beside = (path.parent / f"{first}.py", path.parent / first / "__init__.py")
            if any(other.is_file() for other in beside):
                raise NotPortableError(
                    f"{path} imports {first} from beside it, which would be missing on other machines; put "
                    "both into one file."
                )
    return path


def _complete(path: Path) -> None:
    """Raise for a .gltf whose numbers or pictures lie in other files."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        entries = [*found.get("buffers", ()), *found.get("images", ())]
        outside = [u for e in entries if not (u := e.get("uri", "data:")).startswith("data:")]
    except (ValueError, AttributeError, TypeError):
        return  # its reader says what is wrong with it
    if outside:
        raise NotPortableError(
            f"{path} takes {outside[0]} from beside it, which would be missing on other machines; give a "
            ".glb, which holds everything."
        )
