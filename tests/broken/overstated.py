"""Broken on purpose: QON that documents a much larger gain of energy than it has."""

from gonio.claims import Claims, Place, at_most, dark_ring, kink
from gonio.models.qon import QON


class Overstated(QON, register=False):
    """QON with a wrong number in its claims."""

    claims = Claims(
        energy=at_most(1.2),
        kinks=(dark_ring(), kink(Place.EQUAL_COSINES)),
    )
