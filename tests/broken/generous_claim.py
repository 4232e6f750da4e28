"""Broken on purpose: Burley's diffuse that documents a quarter more gain of energy than it has."""

from gonio.claims import Claims, at_most
from gonio.models.burley_diffuse import BurleyDiffuse


class GenerousClaim(BurleyDiffuse, register=False):
    """Burley's diffuse with 1.697 for 1.5576."""

    claims = Claims(energy=at_most(1.697))
