"""Reading files that may be damaged, truncated, hostile or huge: with bounds, and errors of one line."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.measured.measurement import DataError

# Numbers that a file may hold: a spectral, anisotropic RGL file has 5e7. 1 GiB in single precision.
MOST_NUMBERS = 1 << 28

# Text is read into Python's objects, which take some five times its size.
MOST_TEXT = 256 << 20

# A longer line is no line of text.
LONGEST_LINE = 1 << 20

# What formats look at to recognise their files.
HEAD = 1 << 14


class Source:
    """A file that is being read."""

    def __init__(self, path: str | Path) -> None:
        """Look at a file.

        Raises:
            DataError: there is none, it is a folder, or it cannot be read.
        """
        self.path = Path(path)
        try:
            if not self.path.is_file():
                raise DataError(
                    f"{path} {_no_file(self.path)}; give the path of a file of measured reflection."
                )
            self.size = self.path.stat().st_size
            with self.path.open("rb") as file:
                self.head = file.read(HEAD)
        except OSError as error:
            raise DataError(f"{path} cannot be read: {error.strerror or error}.") from None
        except DataError:  # a ValueError as well
            raise
        except ValueError as error:  # a null byte in the name
            raise DataError(f"{str(path)!r} is no file's name: {error}.") from None

    @property
    def title(self) -> str:
        """The file's name without its suffix."""
        return self.path.stem

    def error(self, text: str, line: int | None = None) -> DataError:
        """The error to raise: the file, the line if there is one, and what is wrong."""
        where = f", line {line}" if line else ""
        return DataError(f"{self.path}{where}: {text}")

    def binary(self, offset: int, dtype: str, shape: Sequence[int]) -> NDArray[Any]:
        """Numbers at a place of the file, mapped: what is not used is not read.

        Raises:
            DataError: the file ends before them, or there are too many.
        """
        # Python's integers: products of hostile sizes do not overflow
        count = math.prod(int(n) for n in shape)
        if count > MOST_NUMBERS:
            raise self.error(f"claims {count:.3g} numbers; at most {MOST_NUMBERS:.3g} are read.")
        end = offset + count * np.dtype(dtype).itemsize
        if offset < 0 or end > self.size:
            raise self.error(f"is truncated: its header needs {end} bytes, there are {self.size}.")
        if count == 0:
            # NumPy multiplies the sizes that are not 0 even so
            return np.zeros(tuple(min(int(n), 1) for n in shape), dtype)
        try:
            return np.memmap(self.path, dtype, "r", offset, tuple(int(n) for n in shape))
        except (OSError, ValueError) as error:
            raise self.error(f"cannot be read: {error}.") from None

    def unpack(self, form: str, offset: int) -> tuple[Any, ...]:
        """What `struct.unpack` finds at a place of the file."""
        length = struct.calcsize(form)
        return struct.unpack(form, self.bytes(offset, length))

    def bytes(self, offset: int, length: int) -> bytes:
        """A few bytes at a place of the file.

        Raises:
            DataError: the file ends before them.
        """
        if offset < 0 or length < 0 or offset + length > self.size:
            raise self.error(
                f"is truncated: byte {offset + length} is needed, there are {self.size}."
            )
        with self.path.open("rb") as file:
            file.seek(offset)
            content = file.read(length)
        if len(content) < length:
            raise self.error("changed while it was read.")
        return content

    def text(self) -> str:
        """The whole file as text.

        Raises:
            DataError: it is too large, or no text.
        """
        return "\n".join(line for _, line in self.lines())

    def lines(self) -> Iterator[tuple[int, str]]:
        """Number and content of each line, without blanks at its ends.

        Raises:
            DataError: the file is too large, a line is too long, or it is no text.
        """
        if self.size > MOST_TEXT:
            raise self.error(
                f"has {self.size >> 20} MiB of text; at most {MOST_TEXT >> 20} are read."
            )
        with self.path.open("rb") as file:
            number = 0
            while content := file.readline(LONGEST_LINE + 1):
                number += 1
                if len(content) > LONGEST_LINE:
                    raise self.error(f"has more than {LONGEST_LINE} characters.", number)
                if number == 1:
                    content = content.removeprefix(b"\xef\xbb\xbf")
                try:
                    line = content.decode("utf-8")
                except UnicodeDecodeError:
                    line = content.decode("latin-1")  # names of samples in old files
                if "\0" in line:
                    raise self.error("holds a null byte; this is no text.", number)
                yield number, line.strip()

    def number(self, text: str, line: int, what: str = "a number") -> float:
        """A finite number, or NaN where the file says so."""
        try:
            value = float(text)
        except ValueError:
            raise self.error(f"{_short(text)} is not {what}.", line) from None
        return value

    def numbers(self, texts: Sequence[str], line: int) -> list[float]:
        """Several of them."""
        try:
            return [float(text) for text in texts]
        except ValueError:
            return [self.number(text, line) for text in texts]

    def count(self, text: str, line: int, what: str, most: int = MOST_NUMBERS) -> int:
        """A count of at least 1."""
        try:
            value = int(text)
        except ValueError:
            raise self.error(f"{what} is {_short(text)}, not a whole number.", line) from None
        if not 1 <= value <= most:
            raise self.error(f"{what} is {value}; 1 to {most} are read.", line)
        return value

    def finite(self, values: Any, what: str) -> NDArray[np.float64]:
        """Numbers as an array, or an error if one is not finite.

        Raises:
            DataError: NaN or infinity where there must not be one.
        """
        array = np.asarray(values, np.float64)
        if not np.isfinite(array).all():
            raise self.error(f"{what} are not all finite numbers.")
        return array


def _no_file(path: Path) -> str:
    if path.is_dir():
        return "is a folder"
    # A pipe or a device has no end that could be known before it is read
    return "is no ordinary file" if path.exists() else "does not exist"


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else text[:37] + "...")


def is_text(head: bytes) -> bool:
    """Whether the beginning of a file looks like text."""
    return b"\0" not in head
