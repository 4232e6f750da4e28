"""Tolerances that many tests share, each with its reason. Those of one file or one test stand there."""

from __future__ import annotations

import math

from gonio.model import Model

DOUBLE = 1e-12
"""One formula in two orders of operations, in double precision: some thousand roundings of 1e-16."""

DOUBLE_SHORT = 1e-14
"""One formula with a few roundings of double precision, and text that keeps all digits."""

DOUBLE_DIVIDED = 1e-9
"""The same where a small cosine, or a difference of near equals, is divided by on the way."""

SINGLE = 1e-6
"""A dozen roundings of single precision, 6e-8 each."""

SINGLE_LONG = 1e-5
"""Some hundred roundings of single precision: a picture, or a sum of many values."""

SINGLE_PROMISED = 1e-5
"""What docs/conventions.md promises of single against double precision, for every model."""

NUMERIC_ALBEDO = 1e-5
"""What `gonio.albedos.quadrature` is good to where a model is smooth, or has its kinks on its edges."""

NINE_DIGITS = 1e-8
"""Numbers that are written with nine digits: in files of `gonio plot`, and constants of exported texts."""

SINGLE_UNPROMISED = 1e-4
"""Where a model promises nothing, because its terms may cancel: they do not at most parameters."""

HALF = 1e-3
"""What is stored as half floats, whose steps are 1e-3 of the value at most: half a step, and a little."""

MISTAKE = 1e-3
"""Broken things have to be further off than this, which no tolerance beside it comes near."""


def single_promised(model: Model) -> float:
    """What a model with its options says of its own single precision."""
    options = {
        name: getattr(model, name) for name, f in model.fields.items() if hasattr(f, "values")
    }
    size = model.claims.size("float32", options)
    if size is None:
        return SINGLE_PROMISED
    return size if math.isfinite(size) else SINGLE_UNPROMISED


def decimals(count: int) -> float:
    """Half of a stated number's last decimal, and a little for the rounding of what is compared with it."""
    return 0.51 * 10.0**-count
