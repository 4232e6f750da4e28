"""What a fit can have for data: measured reflection, a model, or the ground truth of layers."""

from __future__ import annotations

import numpy as np

from gonio.fields import ModelError
from gonio.measured import Measurement, OfModel, measurement
from gonio.measured.formats.csv import directions
from gonio.model import Model
from gonio.reference import Stack

# Directions of a stack that are walked to, and walks to each: an error of about 2 %.
WALKED, WALKS = 4000, 1024


def measure(data: Measurement | Model | Stack, seed: int) -> Measurement:
    """Data as a measurement of reflection.

    Args:
        data: a measurement as it is; a model at directions all over the hemisphere, crowded around the
            mirror direction; or a stack at some of these.
        seed: of the stack's directions and walks.

    Raises:
        ModelError: transmission, or a model with arrays for parameters.
    """
    if isinstance(data, Measurement):
        if data.transmission:
            raise ModelError(f"{data.title}: {data.part} is no reflection; models have no other.")
        return data
    if isinstance(data, Stack):
        return _walked(data, seed)
    what = OfModel(data)
    wi, wo = directions(what.isotropic)
    return measurement(
        "model",
        what.title,
        wi,
        wo,
        what.evaluate(wi, wo),
        channels=what.channels,
        isotropic=what.isotropic,
    )


def _walked(stack: Stack, seed: int) -> Measurement:
    isotropic = OfModel(stack.base).isotropic
    wi, wo = directions(isotropic)
    chosen = np.random.default_rng(seed).permutation(len(wi))[:WALKED]
    wi, wo = wi[np.sort(chosen)], wo[np.sort(chosen)]
    found = stack.eval(wi, wo, walks=WALKS, seed=seed)
    return measurement(
        "random walks",
        f"{len(stack.layers)} layers over {stack.base!r}",
        wi,
        wo,
        found.value,
        channels=("r", "g", "b"),
        isotropic=isotropic,
    )
