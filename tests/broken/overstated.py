"""Broken on purpose: QON that documents a much larger gain of energy than it has."""

from gonio.claims import Claims, kink, known
from gonio.models.qon import QON


class Overstated(QON, register=False):
    """QON with a wrong number in its claims."""

    claims = Claims(
        energy=known(1.2),
        kinks=(kink("dark ring at s = 0"), kink("kink at mu_i = mu_o")),
    )
