"""All derivatives of a model at one pair of directions, or at one sample, beside what they should be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.check.adversarial import Cases
from gonio.check.gradient import METHODS, central_differences, closed, gradients
from gonio.check.subject import ModelSubject
from gonio.fields import few_digits
from gonio.model import Model


@dataclass(frozen=True)
class Derivative:
    """A derivative of the sum of a method's channels, by each channel or coordinate of one input."""

    name: str
    float32: list[float]
    float64: list[float]
    difference: list[float] | None
    """Central differences in float64, for eval by parameters."""


def derivatives(model: Model, wi: Any, wo: Any, u: Any = None) -> list[Derivative]:
    """Derivatives of eval, pdf and closed-form albedos; with `u` also of the sample made of it.

    Those of a sample are of its density and mixed coordinates together, as `gonio check` has them.

    Args:
        model: a model whose parameters are numbers.
        wi: towards the light, shape (3,), unit, normal +z.
        wo: towards the viewer, likewise.
        u: two random numbers in [0, 1), shape (2,).
    """
    subject = ModelSubject(model)
    row = subject.default()[None]
    given = (wi, wo, (0.0, 0.0) if u is None else u)
    light, viewer, numbers = (np.asarray(x, np.float64)[None] for x in given)
    cases = Cases(row, light, viewer, numbers)
    differences: dict[str, list[float]] = {}
    with np.errstate(invalid="ignore", over="ignore"):  # what is no number is shown
        plain = subject.values(row)
        by_number = central_differences(subject, plain, cases.wi, cases.wo, np.ones(3))
    for free, (near, _) in zip(subject.parameters, by_number, strict=True):
        differences.setdefault(f"d eval / d {free.path}", []).append(float(near[0]))
    found = []
    for method in [*METHODS, *closed(subject)]:
        if method == "sample" and u is None:
            continue
        low, high = (
            gradients(subject, cases, method, single_precision=precision, rounded=False)
            for precision in (True, False)
        )
        for name, exact in high.items():
            words = f"d {method} / d {name}"
            single, double = (few_digits(g[:, 0]) for g in (low[name], exact))
            found.append(Derivative(words, single, double, differences.get(words)))
    return found
