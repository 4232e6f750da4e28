"""What decides the bits of a result besides its inputs: versions, gonio's own code, and the backend."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib.metadata
import platform
from dataclasses import dataclass
from pathlib import Path

import gonio
from gonio import backend

# Rooms whose code changes no number.
WITHOUT_NUMBERS = ("bench", "cli", "reproduce", "view")

# Packages that compute.
PACKAGES = ("drjit", "mitsuba", "numpy", "scipy")


@dataclass(frozen=True)
class Identity:
    """A process as far as results depend on it."""

    gonio: str
    """Version and, because a checkout changes without it, the beginning of the code's digest."""
    python: str
    packages: str
    backend: str

    def text(self) -> str:
        """All of it, for keys."""
        return "\n".join(dataclasses.astuple(self))

    def differences(self, other: Identity) -> str:
        """In words what is different there, such as "gonio 0.2 (here 0.1)"; empty if nothing is."""
        pairs = [
            (f"{name} {theirs}", ours)
            for name, ours, theirs in zip(
                (f.name for f in dataclasses.fields(self)),
                dataclasses.astuple(self),
                dataclasses.astuple(other),
                strict=True,
            )
            if ours != theirs
        ]
        return ", ".join(f"{theirs} (here {ours})" for theirs, ours in pairs)


@functools.cache
def identity() -> Identity:
    """That of this process."""
    versions = (f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)
    return Identity(
        f"{gonio.__version__} code {_code()}",
        ".".join(platform.python_version_tuple()[:2]),
        ", ".join(versions),
        backend.current(),
    )


def _code() -> str:
    """The beginning of the digest of gonio's files."""
    root = Path(gonio.__file__).parent
    found = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        place = path.relative_to(root)
        if place.parts[0] in WITHOUT_NUMBERS or path.suffix not in (".py", ".toml", ".npz"):
            continue
        # Line ends of Windows are no other code
        content = path.read_bytes()
        content = content if path.suffix == ".npz" else content.replace(b"\r\n", b"\n")
        found.update(place.as_posix().encode() + b"\0" + content + b"\0")
    return found.hexdigest()[:12]
