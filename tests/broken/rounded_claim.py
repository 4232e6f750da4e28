"""Broken on purpose: Burley's diffuse that documents a gain of energy rounded down."""

from gonio.claims import Claims, at_most
from gonio.models.burley_diffuse import BurleyDiffuse


class RoundedClaim(BurleyDiffuse, register=False):
    """Burley's diffuse with 1.5 for 1.5575."""

    claims = Claims(energy=at_most(1.5))
