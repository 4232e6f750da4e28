"""Broken on purpose: UE4's BRDF that documents a quarter more gain for one of its options than it has."""

from gonio.claims import Claims, at_most
from gonio.models.ue4 import UE4


class GenerousOption(UE4, register=False):
    """UE4's with 2.2 for 1.96, for image-based light alone."""

    claims = Claims(energy=(at_most(1.171, light="punctual"), at_most(2.2, light="image")))
