"""Everything that a Mitsuba BSDF says about one pair of directions, with gonio's conventions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click
import numpy as np

from gonio.check.all_parts import MANY, means
from gonio.check.energy import precise
from gonio.check.kernels import draw, evaluate
from gonio.check.mitsuba_bsdf import SIDES, MitsubaSubject, sides_of
from gonio.cli._evaluation import Evaluation
from gonio.fields import few_digits

# Directions are as long as one to within what a float32 has.
UNIT = 1e-5


class Plugin:
    """A BSDF at one place; directions below the surface are those of its back."""

    def __init__(self, description: str, params: Iterable[str] = ()) -> None:
        """Load it, as `gonio check --mitsuba` does."""
        self.sides = sides_of(description, params)

    def evaluate(self, wi: Any, wo: Any, u: Any = None) -> Evaluation:
        """What it says; with `u` of the direction that it samples.

        Raises:
            ValueError: a direction that is not a unit vector.
            UsageError: directions on a side that reflects nothing, or on both.
        """
        subject = self._side(wo, wo if u is not None else wi)
        flip = np.array([1.0, 1.0, subject.side])
        light, viewer = (np.asarray(w, np.float64)[None] * flip for w in (wi, wo))
        row, index = subject.default()[None], np.zeros(1, np.uint32)
        reported = None
        if u is not None:
            light, density = draw(subject, row, index, viewer, np.asarray(u, np.float64)[None])
            light, reported = light.astype(np.float64), float(density[0])
        f, pdf = evaluate(subject, row, index, light, viewer)
        weight = f[0] * light[0, 2] / pdf[0] if pdf[0] > 0 else None
        whole = None
        if subject.left_out:
            mean, _ = means(subject, row, viewer, MANY)
            whole = float(mean[0])
        return Evaluation(
            model=" ".join([subject.name, *([subject.tag()] if subject.tag() else [])]),
            precision="float32",
            wi=few_digits(light[0] * flip),
            wo=few_digits(wo),
            eval=few_digits(f[0].astype(np.float32)),
            pdf=few_digits(pdf.astype(np.float32))[0],
            weight=None if weight is None else few_digits(weight.astype(np.float32)),
            albedo=few_digits(precise(subject, row, viewer)[0].astype(np.float32)),
            mean_albedo=None,
            u=None if u is None else few_digits(u),
            sampled_pdf=reported,
            all_parts=whole,
        )

    def _side(self, wo: Any, wi: Any) -> MitsubaSubject:
        """The side that both directions are on."""
        for name, w in (("wi", wi), ("wo", wo)):
            if not abs(np.linalg.norm(w) - 1) < UNIT:
                length = float(np.linalg.norm(w))
                raise ValueError(
                    f"{name} has length {length:.6g}; give unit vectors, or add --normalize."
                )
        if wi[2] * wo[2] < 0:
            raise click.UsageError(
                "wi and wo are on two sides of the surface; gonio shows what is reflected"
            )
        sign = -1.0 if wo[2] < 0 else 1.0
        for subject in self.sides:
            if subject.side == sign:
                return subject
        side = next(name for name, z in SIDES.items() if z == sign)
        raise click.UsageError(f"{self.sides[0].name} reflects nothing on its {side}")
