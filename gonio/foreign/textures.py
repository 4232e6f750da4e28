"""Textures of foreign code: pictures as they are stored, or one value everywhere.

One that is not given is white, as engines have it, so that it changes no colour that it is multiplied with;
what adds light is black, and a normal map flat.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.foreign.sampled import NOTHING, head
from gonio.foreign.source import SHADERS, ForeignError, Source
from gonio.images import ImageError, read_image
from gonio.messages import did_you_mean

Texels = NDArray[np.float32]

FILE = "textures.npz"

# Textures that are not white if nothing is said: words in their names, the value, and what that is.
ASSUMED = (
    (r"normal|bump|nrm", "0.5/0.5/1", "flat (0.5, 0.5, 1)"),
    (
        r"emi(?:ss|t)|glow|env|irradi|radiance|reflection|cube|sky|ambient|probe|light|prefilter"
        r"|height|displace|parallax|depth",
        "0",
        "black",
    ),
)
WHITE = ("1", "white")


def parse(texts: Iterable[str]) -> dict[str, str]:
    """What --texture says: NAME=FILE.png, NAME=0.5 or NAME=0.8/0.3/0.1.

    Raises:
        ForeignError: something else, or a name twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value) or name in found:
            raise ForeignError(
                f"--texture {text!r} is not NAME=FILE.png or NAME=VALUE, once for each texture."
            )
        found[name] = value
    return found


def assumed(name: str) -> tuple[str, str]:
    """The value of a texture that is not given, and a word for it."""
    for pattern, value, word in ASSUMED:
        if re.search(pattern, name, re.I):
            return value, word
    return WHITE


def check(source: Source, given: dict[str, str]) -> None:
    """Raise a ForeignError for textures that the code does not have, or a language without them."""
    if not given:
        return
    if source.language not in SHADERS and not source.textures:
        raise ForeignError(
            f"{source.path}: no texture was found that it reads; write a constant into the code instead."
        )
    for name, value in given.items():
        if source.language not in SHADERS and texels(value).shape[:2] != (1, 1):
            raise ForeignError(
                f"{source.path}: pictures are read for GLSL alone; give --texture {name}=0.5 or "
                "=0.8/0.3/0.1."
            )
        if name not in source.textures:
            raise ForeignError(
                f"{source.path} has no texture {name!r}; {did_you_mean(name, source.textures)}it has "
                f"{', '.join(source.textures) or 'none'}."
            )


def filled(source: Source, given: Mapping[str, str]) -> Source:
    """The source with the values of its textures, in languages where they are constants."""
    if source.language in SHADERS or NOTHING not in source.text:
        return source
    values = {n: texels(given[n])[0, 0] for n in source.textures}
    declared = head(source.language, values)
    if source.language == "wgsl":  # whose first lines may be directives, and whose order is free
        return replace(source, text=f"{source.text}\n{declared}\n")
    place = f'#line 1 "{source.path.resolve()}"'
    return replace(source, text=f"{declared}\n{place}\n{source.text}")


def texels(value: str) -> Texels:
    """Rows of RGBA numbers, (height, width, 4), the first row at v = 0.

    Raises:
        ForeignError: neither numbers nor a picture that can be read.
    """
    try:
        numbers = [float(x) for x in value.split("/")]
    except ValueError:
        try:
            pixels = np.asarray(read_image(Path(value)).pixels, np.float32)
        except (ImageError, OSError) as error:
            raise ForeignError(f"--texture {value}: {error}.") from None
        pixels = pixels[..., None] if pixels.ndim == 2 else pixels
        return _filled(np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels)[
            ::-1
        ].copy()
    if len(numbers) not in (1, 3, 4) or not np.isfinite(numbers).all():
        raise ForeignError(f"--texture {value}: a value has 1, 3 or 4 finite numbers.")
    numbers = numbers * 3 if len(numbers) == 1 else numbers
    return _filled(np.array(numbers, np.float32).reshape(1, 1, -1))


def _filled(pixels: Texels) -> Texels:
    """With an opacity of 1 where there is none."""
    if pixels.shape[2] >= 4:
        return np.ascontiguousarray(pixels[..., :4], np.float32)
    more = np.ones((*pixels.shape[:2], 4 - pixels.shape[2]), np.float32)
    return np.concatenate([pixels, more], axis=2).astype(np.float32)


def write(folder: Path, source: Source, given: Mapping[str, str]) -> None:
    """Put all textures of the code where its process looks for them."""
    if source.textures and source.language in SHADERS:
        found: dict[str, Any] = {n: texels(given[n]) for n in source.textures}
        np.savez(folder / FILE, **found)
