"""One file format per file. The folder is the list: a module here is a format that gonio reads.

Each has NAME and SUFFIX, `sniff(source) -> bool`, which looks at the content, `read(source) -> list` of
measurements, one for each part of the sample that the file describes, and, if gonio writes the format,
`write(path, reflectance)`.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from types import ModuleType


@functools.cache
def formats() -> dict[str, ModuleType]:
    """All formats by the names of their files, sorted."""
    return {
        found.name: importlib.import_module(f"{__name__}.{found.name}")
        for found in sorted(pkgutil.iter_modules(__path__), key=lambda m: m.name)
    }
