"""Pictures that drive a parameter: which channel, and whether they can be used, before any rendering."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from gonio.images import Image, ImageError, Pixels, read_image

CHANNELS = ("r", "g", "b", "a", "luminance")


def split_channel(text: str) -> tuple[str, str | None]:
    """The file's name and the channel of "orm.png:g"; None where no channel is named."""
    name, colon, channel = text.rpartition(":")
    return (name, channel) if colon and channel in CHANNELS else (text, None)


def texture_values(picture: Path, channel: str | None, width: int) -> Pixels:
    """What a picture holds for a parameter of one number or three, shape (height, width, 1 or 3).

    A colour is linear RGB: sRGB is decoded, .exr and .hdr are taken as they are. A number is stored as it
    is, in the named channel, or in a grey picture; of colours none is chosen without a word.

    Raises:
        ImageError: the picture cannot be read, or does not hold that.
    """
    image = _read(picture)
    if width == 3:
        if channel is not None:
            raise ImageError(f"a colour takes the whole picture; leave out ':{channel}'")
        values = image.linear_rgb()
    else:
        values = image.channel(channel or _only_channel(image))[..., None]
    wrong = int((~np.isfinite(values)).any(axis=2).sum())
    if wrong:
        raise ImageError(f"it has {wrong} pixels that are NaN or infinite")
    return np.ascontiguousarray(values, np.float32)


def stored_values(picture: Path) -> Pixels:
    """The three channels of a picture as they are stored, shape (height, width, 3), such as normals.

    Raises:
        ImageError: the picture cannot be read, has fewer channels, or pixels that are not finite.
    """
    image = _read(picture)
    values = np.stack([image.channel(c) for c in ("r", "g", "b")], axis=-1)
    if wrong := int((~np.isfinite(values)).any(axis=2).sum()):
        raise ImageError(f"it has {wrong} pixels that are NaN or infinite")
    return np.ascontiguousarray(values, np.float32)


def _only_channel(image: Image) -> str:
    first = image.pixels[..., :1]
    if image.colours == 3 and not np.array_equal(
        image.pixels[..., :3], np.repeat(first, 3, axis=2), equal_nan=True
    ):
        raise ImageError(
            "one number is needed and its colours differ; add the channel: "
            "':r', ':g', ':b' or ':luminance' behind the name"
        )
    return "r"


def _read(picture: Path) -> Image:
    try:
        known = picture.stat()
    except OSError:
        return read_image(picture)  # which says what is wrong
    return _read_once(picture, known.st_mtime_ns, known.st_size)


@functools.lru_cache(
    maxsize=4
)  # a file is checked when it is named, and read again for the picture
def _read_once(picture: Path, _time: int, _size: int) -> Image:
    return read_image(picture)
