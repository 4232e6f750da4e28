"""Rendered figures: rows of lights, columns of materials, and what is measured in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio.materials import Material
from gonio.model import Model
from gonio.render.picture import write_picture
from gonio.render.sheets import compare

Cells = npt.NDArray[np.float32]
"""Linear radiance, shape (rows, columns, height, width, 3)."""

# Pixels of a cell and samples of a pixel: a cell takes about a second on two idle cores, once compiled.
CELL, SAMPLES = 208, 36

# Furnaces of the EON paper have 50 bounces; a path's last one sees the light.
BOUNCES = 50

# In the gap behind the ball's cut some light is still on its way after 50 bounces: a hundredth of it with
# a white surface of any model. So many leave less than a thousandth there, as under the paper's open sky.
ALL_BOUNCES = 256


@dataclass(frozen=True)
class Rendered:
    """A sheet of pictures, rendered when it is saved."""

    columns: Sequence[Model | Material]
    labels: Sequence[str]
    rows: Sequence[tuple[str, Mapping[str, Any]]] = (("", {}),)
    """A name, and arguments of `gonio.render`, for each."""
    measure: Callable[[Cells], None] | None = None
    """Called with the pixels; adds numbers to the item's sheet."""
    common: Mapping[str, Any] = field(default_factory=dict)

    def cells(self) -> Cells:
        """The pixels of each picture."""
        settings = {"size": (CELL, CELL), "spp": SAMPLES, **self.common}
        width, height = settings["size"]
        pixels = compare([row for _, row in self.rows], self.columns, **settings)
        shape = (len(self.rows), height, len(self.columns), width, 3)
        return np.asarray(pixels[..., :3].reshape(shape).transpose(0, 2, 1, 3, 4), np.float32)

    def save(self, output: str | Path) -> Path:
        """Render, measure, and write a .png."""
        cells = self.cells()
        if self.measure is not None:
            self.measure(cells)
        rows, columns, height, width, _ = cells.shape
        sheet = cells.transpose(0, 2, 1, 3, 4).reshape(rows * height, columns * width, 3)
        names = [name for name, _ in self.rows]
        write_picture(
            output,
            sheet,
            labels=self.labels if any(self.labels) else (),
            row_labels=names if any(names) else (),
        )
        return Path(output)


def furnace(bounces: int = BOUNCES) -> dict[str, Any]:
    """Arguments of `gonio.render` for an object in radiance 1 from everywhere."""
    return {"furnace": True, "max_depth": bounces + 1}


def single_bounce(environment: str) -> dict[str, Any]:
    """Arguments of `gonio.render` for direct light alone."""
    return {"environment": environment, "max_depth": 2}


def middle(cell: Cells) -> Cells:
    """The inner quarter of a picture, which the ball fills."""
    height, width = cell.shape[:2]
    return cell[3 * height // 8 : 5 * height // 8, 3 * width // 8 : 5 * width // 8]


FINER = 2

Shade = Callable[[Any, Any], Any]
"""Radiance (..., 3) for unit normals (..., 3) and a direction to the viewer (3,)."""


@dataclass(frozen=True)
class Shaded:
    """Spheres shaded by formulas, as a shader with prefiltered light does; y is up.

    Each pixel is the mean of `FINER` by `FINER` points, so that outlines are smooth.
    """

    columns: Mapping[str, Shade]
    size: int = 224

    def save(self, output: str | Path) -> Path:
        """Shade them and write a .png."""
        fine = FINER * self.size
        step = (np.arange(fine) + 0.5) / fine * 2.2 - 1.1
        x, y = np.meshgrid(step, -step)
        inside = x * x + y * y < 1
        normals = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], -1)
        normals[~inside] = (0, 0, 1)
        cells = []
        for shade in self.columns.values():
            radiance = np.asarray(shade(normals, np.array([0.0, 0.0, 1.0])), np.float32)
            seen = np.where(inside[..., None], np.clip(radiance, 0, 1), np.float32(0.05))
            cells.append(seen.reshape(self.size, FINER, self.size, FINER, 3).mean((1, 3)))
        write_picture(output, np.concatenate(cells, axis=1), labels=list(self.columns))
        return Path(output)


# Pictures on a page are at most this wide, so that its text keeps its size; and plots, which know how many
# pixels they have to an inch, have at most these, so that one panel's letters are as large as four panels'.
WIDTH, DOTS_PER_INCH = 1200, 120


def fitted(picture: Any) -> Any:
    """A Pillow image as RGB, made smaller if it is too large for a page."""
    from PIL import Image

    rgb = picture.convert("RGB")
    dots = picture.info.get("dpi", (DOTS_PER_INCH,))[0]
    scale = min(1.0, WIDTH / rgb.width, DOTS_PER_INCH / dots)
    if scale == 1:
        return rgb
    size = round(rgb.width * scale), round(rgb.height * scale)
    return rgb.resize(size, Image.Resampling.LANCZOS)


@dataclass(frozen=True)
class Later:
    """A picture that is computed when it is saved, because that takes long."""

    make: Callable[[], Any]

    def save(self, output: str | Path) -> Path:
        """Compute it and write a .png."""
        return Path(self.make().save(output))


@dataclass(frozen=True)
class Layout:
    """Several pictures of the item, one above the other or in a row."""

    pictures: Sequence[Any]
    in_a_row: bool = False

    def save(self, output: str | Path) -> Path:
        """Draw them all onto one sheet."""
        import tempfile

        from PIL import Image

        with tempfile.TemporaryDirectory() as folder:
            drawn = []
            for n, picture in enumerate(self.pictures):
                with Image.open(picture.save(Path(folder) / f"{n}.png")) as file:
                    drawn.append(fitted(file))
        widths, heights = [one.width for one in drawn], [one.height for one in drawn]
        if self.in_a_row:
            sheet = Image.new("RGB", (sum(widths), max(heights)), "white")
        else:
            sheet = Image.new("RGB", (max(widths), sum(heights)), "white")
        for n, one in enumerate(drawn):
            if self.in_a_row:
                sheet.paste(one, (sum(widths[:n]), 0))
            else:
                sheet.paste(one, ((sheet.width - one.width) // 2, sum(heights[:n])))
        sheet.save(output, format="PNG")
        return Path(output)
