"""How much numeric albedos may be off, beyond the rules' own error, because of kinks nobody told them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gonio.check.variants import chosen
from gonio.claims import Place
from gonio.model import Model

# Kinks that the rules of gonio.albedos.quadrature are cut at.
FORESEEN = {
    "angles": {Place.EQUAL_COSINES, Place.SIDE_LIGHT},
    "half_vectors": {Place.EQUAL_COSINES},
    "mirror": {Place.RIGHT_ANGLE_TO_MIRROR},
}
ACROSS_A_KINK = 1e-3

# Walter's fit of the masking has a small jump, inside the lobe.
WALTER = 1e-4

# The edge of total internal reflection, for indices below 1 only.
TOTAL_REFLECTION = 0.03


def kink_error(cls: type[Model], choice: Mapping[str, str], parameters: Mapping[str, Any]) -> float:
    """The error that is allowed for a model with these options and parameters."""
    options = chosen(cls, choice)
    error = 0.0
    places = {k.place for k in cls.claims.known_kinks(options) if k.kind != "jump"}
    if places - FORESEEN[cls.numeric.rule]:
        error = ACROSS_A_KINK
    if options.get("masking") == "smith_walter":
        error = max(error, WALTER)
    if options.get("fresnel") == "dielectric" and np.min(parameters.get("eta", 1.5)) < 1:
        error = max(error, TOTAL_REFLECTION)
    return error
