"""Broken on purpose: keeps every promise of Lambert's, and makes none of them."""

from gonio.claims import Claims, Place, at_most, kink
from gonio.models.lambert import Lambert


class Modest(Lambert, register=False):
    """Lambert that declares departures which it does not have."""

    claims = Claims(
        energy=at_most(1.5),
        reciprocity=at_most(0.5),
        negative=at_most(0.1),
        wasted=at_most(0.1),
        kinks=kink(Place.SIDE_LIGHT),
    )
