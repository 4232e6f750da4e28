"""Pictures beside each other: comparisons, contact sheets, the demo."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.files import replacing
from gonio.materials import Material
from gonio.model import Model
from gonio.render import Shown, render
from gonio.render.passes import Progress
from gonio.render.picture import BACKGROUND, Picture, captioned, describe, write_picture
from gonio.render.tone import to_srgb


def compare(rows: Sequence[Mapping[str, Any]], columns: Sequence[Shown], **common: Any) -> Picture:
    """Render several materials side by side, once for each row.

    Args:
        rows: arguments of `render` for each row, such as {"environment": "side"}.
        columns: the materials.
        common: arguments of `render` for all.

    Returns:
        Linear RGB radiance, float32, shape (rows * height, columns * width, 3).
    """
    progress = common.pop("progress", None)
    cells = len(rows) * len(columns)
    pictures = []
    for r, row in enumerate(rows):
        for c, material in enumerate(columns):
            done = r * len(columns) + c

            def step(n: int, total: int, done: int = done) -> None:
                if progress is not None:
                    progress(done * total + n, cells * total)

            pictures.append(render(material, progress=step, **{**common, **row}))
    width = len(columns)
    return beside([pictures[i : i + width] for i in range(0, cells, width)])


def beside(rows: Sequence[Sequence[Any]]) -> Picture:
    """Pictures of one size in rows and columns."""
    return np.concatenate([np.concatenate(row, axis=1) for row in rows]).view(Picture)


def write_sheet(
    path: str | Path,
    materials: Sequence[Model | Material],
    *,
    columns: int = 6,
    cell: int = 256,
    exposure: float = 0.0,
    tone: str = "linear",
    progress: Progress | None = None,
    **common: Any,
) -> None:
    """Render a contact sheet of materials into a .png, each with its name.

    Args:
        path: the file; it appears only when it is complete.
        materials: what to show, row by row.
        columns: how many side by side.
        cell: pixels of one picture.
        exposure: in stops.
        tone: the curve, as `write_picture` has it.
        progress: called after each pass.
        common: further arguments of `render`, such as environment="sunsky".

    Raises:
        ValueError: no materials, or a suffix other than .png.
    """
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise ValueError(f"cannot write a sheet to {path.name!r}; the suffix must be .png.")
    if not materials:
        raise ValueError("a sheet needs at least one material.")

    pictures = []
    for first, material in enumerate(materials):

        def step(done: int, total: int, first: int = first) -> None:
            if progress is not None:
                progress(first * total + done, len(materials) * total)

        pictures.append(render(material, size=(cell, cell), progress=step, **common))
    write_cells(path, materials, pictures, columns=columns, exposure=exposure, tone=tone)


def write_cells(
    path: str | Path,
    materials: Sequence[Model | Material],
    pictures: Sequence[Any],
    *,
    columns: int = 6,
    exposure: float = 0.0,
    tone: str = "linear",
) -> None:
    """Write a contact sheet of pictures that are there, with the names of their materials.

    Args:
        path: a .png file; it appears only when it is complete.
        materials: what the pictures show.
        pictures: linear, all of one size.
        columns: how many side by side.
        exposure: in stops.
        tone: the curve, as `write_picture` has it.
    """
    from PIL import Image

    strips = []
    for first in range(0, len(materials), columns):
        pixels = beside([pictures[first : first + columns]])
        names = [describe(m) for m in materials[first : first + columns]]
        strips.append(captioned(to_srgb(pixels, exposure, tone), names, []))
    width = max(strip.width for strip in strips)
    sheet = Image.new("RGB", (width, sum(strip.height for strip in strips)), BACKGROUND)
    top = 0
    for strip in strips:
        sheet.paste(strip, (0, top))
        top += strip.height
    with replacing(path) as temporary:
        sheet.save(temporary, format="PNG")


DEMO_ROWS = (("front-lit", {"environment": "front"}), ("side-lit", {"environment": "side"}))


def demo(
    folder: str | Path = "demo",
    *,
    cell: int = 320,
    spp: int = 64,
    progress: Progress | None = None,
) -> list[Path]:
    """Render Lambert, QON, FON and EON at full roughness: front-lit, side-lit, and in a white furnace.

    After Figures 1 and 4 of the EON paper. Writes demo.png into `folder` and returns its path.
    """
    from gonio.model import model

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    clay = (0.75, 0.41, 0.28)

    def materials(rho: Any) -> list[Model]:
        return [
            model("lambert", rho=rho),
            model("qon", rho=rho, sigma=math.pi / 2),
            model("fon", rho=rho, roughness=1),
            model("eon", rho=rho, roughness=1),
        ]

    rows = [row for _, row in DEMO_ROWS]
    height = len(rows) + 1

    def share(first: int, count: int) -> Progress:
        """Progress of `count` rows after `first` ones, as progress of the whole."""

        def step(done: int, total: int) -> None:
            if progress is not None:
                progress(first * total + done * count, height * total)

        return step

    lit = compare(rows, materials(clay), size=(cell, cell), spp=spp, progress=share(0, len(rows)))
    furnace = compare(
        [{"furnace": True}],
        materials(1.0),
        size=(cell, cell),
        spp=spp,
        progress=share(len(rows), 1),
    )
    target = folder / "demo.png"
    write_picture(
        target,
        np.concatenate([lit, furnace]),
        labels=["Lambert", "QON σ = π/2", "FON r = 1", "EON r = 1"],
        row_labels=[*(label for label, _ in DEMO_ROWS), "white furnace"],
    )
    return [target]
