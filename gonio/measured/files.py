"""Files of measured reflection: which format they have, what they hold, and writing them."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from gonio.measured.formats import formats
from gonio.measured.measurement import DataError, Measurement, reflectance
from gonio.measured.source import Source
from gonio.measured.spectra import to_rgb


def recognise(source: Source) -> ModuleType:
    """The format of a file, by its content.

    Raises:
        DataError: it has none that is known.
    """
    for module in formats().values():
        if module.sniff(source):
            return module
    what = "is empty" if source.size == 0 else "is of no known format"
    raise source.error(f"{what}; gonio reads {', '.join(m.NAME for m in formats().values())}.")


def load_parts(path: str | Path) -> list[Measurement]:
    """All parts of a file, reflection first.

    Raises:
        DataError: no such file, no known format, or it is damaged: one line that says what and where.
    """
    source = Source(path)
    module = recognise(source)
    try:
        # What is no number in a damaged file becomes a hole; the rest of NumPy's warnings say nothing more
        with np.errstate(all="ignore"):
            found: list[Measurement] = module.read(source)
    except OSError as error:
        raise source.error(f"cannot be read: {error.strerror or error}.") from None
    except MemoryError:
        raise source.error("needs more memory than there is.") from None
    return found


def load(path: str | Path, part: str | None = None) -> Measurement:
    """A file's reflection, or another part of it.

    Args:
        path: a file of any known format.
        part: the name of one of its parts, or how it begins; the first by default.

    Raises:
        DataError: as `load_parts`, or no such part.
    """
    parts = load_parts(path)
    if part is None:
        return parts[0]
    for found in parts:
        if found.part.startswith(part):
            return found
    raise DataError(f"{path} has no part {part!r}; there are {', '.join(m.part for m in parts)}.")


def writers() -> dict[str, ModuleType]:
    """The formats that are written, by name."""
    return {name: module for name, module in formats().items() if hasattr(module, "write")}


def format_for(path: str | Path, format: str | None = None) -> str:
    """The format to write a file in: as given, or by its suffix.

    Raises:
        DataError: it is not known, or not written.
    """
    known = writers()
    suffix = Path(path).suffix.lower()
    if format is None:
        # .bsdf is RGL's and Zemax's; only one of them is written
        format = next((name for name, m in known.items() if suffix == m.SUFFIX), None)
    if format not in known:
        listing = ", ".join(f"{name} ({m.SUFFIX})" for name, m in known.items())
        raise DataError(f"cannot write {path}: give one of the formats {listing}.")
    return str(format)


def save(path: str | Path, source: Any, format: str | None = None, **options: Any) -> list[str]:
    """Write a model or a measurement, and return what the format could not keep, in words.

    Args:
        path: the file, which appears when it is complete.
        source: a `gonio.Model` whose parameters are numbers, or a `Measurement`.
        format: one of `writers()`; by the suffix of `path` if it is not given.
        options: of the format: `binary` of ALTA; `thetas`, `side` and `phis` of RGL.

    Raises:
        DataError: an unknown format, or something that it cannot hold.
        OSError: the file cannot be written.
    """
    module = writers()[format_for(path, format)]
    what = reflectance(source)
    if isinstance(what, Measurement):
        if what.transmission:
            raise DataError(f"{what.title}: {what.part} cannot be written; reflection can.")
        what = _channels_for(what, module)
    lost: list[str] = module.write(path, what, **options)
    return lost


def _channels_for(what: Measurement, module: ModuleType) -> Any:
    """A measurement as RGB, for formats that know nothing else."""
    if module.NAME in {"CSV", "ALTA"} or (module.NAME == "RGL" and what.wavelengths is not None):
        return what
    if module.NAME == "MDL mbsdf" and len(what.channels) == 1:
        return what
    if what.channels == ("r", "g", "b"):
        return what
    return AsRGB(what)


class AsRGB:
    """A measurement as linear sRGB."""

    channels: tuple[str, ...] = ("r", "g", "b")
    wavelengths = None

    def __init__(self, source: Measurement) -> None:
        """Take a measurement of any channels."""
        self.source, self.title, self.isotropic = source, source.title, source.isotropic

    def evaluate(self, wi: Any, wo: Any) -> Any:
        """Linear sRGB (n, 3)."""
        return to_rgb(self.source, self.source.evaluate(wi, wo))[0]


def is_named_like_data(path: str | Path) -> bool:
    """Whether a path is an existing file, or has a suffix that files of measured reflection have."""
    path = Path(path)
    return path.is_file() or path.suffix.lower() in {m.SUFFIX for m in formats().values()}


def is_data_file(text: str) -> bool:
    """Whether a text on a command line names an existing file of a known format."""
    try:
        path = Path(text)
        if not path.is_file() or path.suffix.lower() in {".py", ".toml", ".mtlx"}:
            return False
        recognise(Source(path))
    except (DataError, OSError, ValueError):
        return False
    return True
