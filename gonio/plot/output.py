"""A plot as numbers that can be drawn, and how it is written."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gonio.files import check_place, replacing
from gonio.plot.style import STYLE

SUFFIXES = (".png", ".svg", ".pdf", ".csv")


@dataclass(frozen=True)
class Plot:
    """The numbers of a plot, and how to draw them."""

    columns: Mapping[str, Any]
    """Equally long columns by name, ready for a data frame; the names say the units."""
    draw: Callable[[], Any]

    def figure(self) -> Any:
        """Draw a new `matplotlib.figure.Figure`."""
        import matplotlib

        with matplotlib.rc_context(STYLE):
            return self.draw()

    def save(self, output: str | Path, dpi: int = 200) -> Path:
        """Write a picture, or the numbers, as the suffix says: .png, .svg, .pdf or .csv.

        dpi: dots per inch of a PNG, and of the shaded surfaces inside SVG and PDF. The file appears
        when it is complete; when writing fails, what was there before stays. The same plot gives
        the same bytes.

        Raises:
            ValueError: a suffix that is not known.
            OSError: the folder does not exist or cannot be written to.
        """
        path = check_output(output)
        if path.suffix.lower() == ".csv":
            content = self.csv().encode()
        else:
            import matplotlib

            kind = path.suffix.lower()[1:]
            # Dates and random ids would make every file different.
            dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}
            buffer = io.BytesIO()
            with matplotlib.rc_context(STYLE):
                self.draw().savefig(buffer, format=kind, dpi=dpi, metadata=dates[kind])
            content = buffer.getvalue()
        with replacing(path) as temporary:
            temporary.write_bytes(content)
        return path

    def csv(self) -> str:
        """The columns as comma-separated text with a header; numbers have 9 digits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        for row in zip(*self.columns.values(), strict=True):
            writer.writerow([v if isinstance(v, str) else f"{v:.9g}" for v in row])
        return text.getvalue()


def check_output(output: str | Path) -> Path:
    """The path of a file that can be written, or a ValueError or OSError that says why not."""
    path = Path(output)
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(
            f"cannot write {str(output)!r}: its name must end in {', '.join(SUFFIXES[:-1])} "
            f"or {SUFFIXES[-1]}."
        )
    if not path.parent.is_dir():
        raise FileNotFoundError(f"cannot write {str(output)!r}: no folder {str(path.parent)!r}.")
    if path.is_dir():
        raise IsADirectoryError(f"cannot write {str(output)!r}: it is a folder.")
    return check_place(path)
