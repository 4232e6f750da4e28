"""Pictures as files: sRGB, captions under columns and rows, formats."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.fields import Parameter
from gonio.files import check_place, replacing
from gonio.images import write_linear
from gonio.materials import Material
from gonio.materials.notation import model_text
from gonio.model import Model
from gonio.render.passes import Pixels
from gonio.render.tone import to_srgb

FORMATS = (".png", ".exr")


class Picture(np.ndarray[Any, np.dtype[np.float32]]):
    """Linear pixels (height, width, 3 or 4): an array as any other, which notebooks show as a picture."""

    def _repr_png_(self) -> bytes | None:
        """The picture in sRGB, clipped; None for what is no picture any more, such as one channel."""
        if self.ndim != 3 or self.shape[2] not in (3, 4) or 0 in self.shape:
            return None
        from PIL import Image

        file = io.BytesIO()
        Image.fromarray(to_srgb(self, exposure=0.0)).save(file, "PNG")
        return file.getvalue()


def describe(material: Model | Material) -> str:
    """A label: the name and what differs from the defaults."""
    if isinstance(material, Material):
        return " ".join([material.name, *(f"{p}={_text(v)}" for p, v in material.changed.items())])
    parts = []
    for name, declared in material.fields.items():
        value = getattr(material, name)
        if not declared.is_default(value):
            text = _text(value)
            parts.append(f"{name}={text}" if isinstance(declared, Parameter) else text)
    return " ".join([material.name, *parts])


def _text(value: Any) -> str:
    if isinstance(value, Model):
        return model_text(value)
    numbers = value if isinstance(value, tuple) else (value,)
    return "/".join(f"{v:g}" if isinstance(v, float) else str(v) for v in numbers)


def captions(materials: Sequence[Material]) -> list[str]:
    """Labels of materials of one model: the parameters in which they differ from each other."""
    values = [
        {path: value for path, _, value in material.model.parameters()} for material in materials
    ]
    differing = [path for path in values[0] if len({repr(v[path]) for v in values}) > 1]

    def text(value: Any) -> str:
        numbers = value if isinstance(value, tuple) else (value,)
        return "/".join(f"{v:g}".replace("-", "−") for v in numbers)

    return [", ".join(f"{path} {text(v[path])}" for path in differing) for v in values]


def write_picture(
    path: str | Path,
    pixels: Pixels,
    *,
    exposure: float = 0.0,
    tone: str = "linear",
    labels: Sequence[str] = (),
    row_labels: Sequence[str] = (),
) -> None:
    """Write a picture: .png (8-bit sRGB) or .exr (linear float32, without labels).

    Args:
        path: the file; it appears only when it is complete.
        pixels: linear radiance, shape (height, width, 3), or with alpha, (height, width, 4).
        exposure: in stops, for .png.
        tone: the curve of a .png: "linear", "filmic" or "agx" (see `gonio.render.tone`).
        labels: one under each of that many columns, for .png.
        row_labels: one at the left edge of each of that many rows, for .png.

    Raises:
        ValueError: another suffix, or pixels that are not finite.
        FileNotFoundError: the folder does not exist.
    """

    path = Path(path)
    check_format(path)
    if not np.isfinite(pixels).all():
        raise ValueError(f"{path}: the picture has pixels that are not finite.")
    if path.suffix.lower() == ".exr":
        with replacing(path) as temporary:
            write_linear(temporary, pixels)
        return
    picture = captioned(to_srgb(pixels, exposure, tone), labels, row_labels)
    with replacing(path) as temporary:
        picture.save(temporary, format="PNG")


def check_format(path: Path) -> None:
    """Raise a ValueError or OSError unless `write_picture` can write a file of this name."""
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"cannot write {str(path)!r}; the suffix must be {' or '.join(FORMATS)}.")
    check_place(path)


BACKGROUND, INK = (24, 24, 24), (235, 235, 235)


def captioned(pixels: NDArray[np.uint8], labels: Sequence[str], rows: Sequence[str]) -> Any:
    """A Pillow image with labels under its columns and at the left of its rows."""
    from PIL import Image, ImageDraw

    picture = Image.fromarray(pixels)
    if not labels and not rows:
        return picture
    height, width = pixels.shape[:2]
    cell_height = height // max(len(rows), 1)
    cell_width = width // max(len(labels), 1)
    font_size = max(11, min(cell_width, cell_height) // 20)
    footer = 2 * font_size if labels else 0
    margin = 2 * font_size if rows else 0
    sheet = Image.new(picture.mode, (width + margin, height + footer), BACKGROUND)
    sheet.paste(picture, (margin, 0))
    draw = ImageDraw.Draw(sheet)
    for n, label in enumerate(labels):
        centre = (margin + cell_width * (n + 0.5), height + footer / 2)
        draw.text(
            centre, label, font=_font(label, font_size, cell_width - 4), fill=INK, anchor="mm"
        )
    for n, label in enumerate(rows):
        strip = Image.new("RGB", (cell_height, margin), BACKGROUND)
        ImageDraw.Draw(strip).text(
            (cell_height / 2, margin / 2),
            label,
            font=_font(label, font_size, cell_height - 4),
            fill=INK,
            anchor="mm",
        )
        sheet.paste(strip.rotate(90, expand=True), (0, n * cell_height))
    return sheet


def _font(text: str, size: int, width: int) -> Any:
    """A font in which the text is at most `width` pixels wide, if that is legible at all."""
    import matplotlib
    from PIL import ImageFont

    file = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
    while size > 7 and ImageFont.truetype(file, size).getlength(text) > width:
        size -= 1
    return ImageFont.truetype(file, size)
