"""Broken on purpose: keeps every promise of Lambert's, and makes none of them."""

from gonio.claims import Claims, kink, known
from gonio.models.lambert import Lambert


class Modest(Lambert, register=False):
    """Lambert that declares departures which it does not have."""

    claims = Claims(
        energy=known(1.5),
        reciprocity=known(0.5),
        negative=known(0.1),
        wasted=known(0.1),
        kinks=kink("kink at s = 0"),
    )
