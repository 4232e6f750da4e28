"""What several texts need to be measured: differences, quadratures, statistics of weights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gonio.model import Model

Floats = npt.NDArray[np.float64]
Value = Callable[[Floats, Floats], Any]

# Directions at random for comparing two forms of one function: enough that a wrong constant is seen.
PAIRS = 4000

# Nodes of a quadrature over the hemisphere, on each of its pieces; the integrals below converge to 1e-6.
NODES = 32


def directions(theta: Any, phi: Any = 0.0) -> Floats:
    """Unit vectors (..., 3) for angles in radians."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    sine = np.sin(theta)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)], -1)


def random_pairs(
    count: int = PAIRS, *, seed: int = 0, lowest: float = 0.02
) -> tuple[Floats, Floats]:
    """Directions wi and wo, uniform in the cosine from `lowest` to 1 and in the azimuth."""
    rng = np.random.default_rng(seed)
    cosine, phi = rng.uniform(lowest, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    wi, wo = directions(np.arccos(cosine), phi)
    return wi, wo


def largest_difference(
    one: Value, other: Value, pairs: tuple[Floats, Floats] | None = None, *, relative: bool = False
) -> float:
    """Largest |one - other| over random pairs, or over the given ones; NaN if a value is."""
    wi, wo = pairs or random_pairs()
    a, b = np.asarray(one(wi, wo), float), np.asarray(other(wi, wo), float)
    if a.ndim > b.ndim:
        a = a[..., 0]
    difference = np.abs(a - b)
    return float(np.max(difference / np.maximum(np.abs(b), 1e-300) if relative else difference))


def gray(model: Model) -> Value:
    """The first channel of a model's values."""
    return lambda wi, wo: np.asarray(model.eval(wi, wo), float)[..., 0]


class Hemisphere(NamedTuple):
    """Directions of the light (n, 3), and the solid angle that each stands for (n,)."""

    wi: Floats
    weight: Floats

    def integral(self, values: Any) -> float:
        """Of values at the directions, over solid angle."""
        return float(np.sum(np.asarray(values, float) * self.weight))

    def reflected(self, values: Any) -> float:
        """Of values times the cosine."""
        return self.integral(np.asarray(values, float) * self.wi[:, 2])


def hemisphere(theta_o: float, nodes: int = NODES) -> Hemisphere:
    """Gauss's rule on pieces that end at the viewer's angle and at quarter turns.

    Nodes crowd there and in the horizon. theta_o: radians; the viewer's azimuth is 0.
    """
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = ((x + 1) / 2) ** 3, 1.5 * ((x + 1) / 2) ** 2 * w  # crowds at 0
    middle = (theta_o + np.pi / 2) / 2

    def pieces(ends: list[tuple[float, float]]) -> tuple[Floats, Floats]:
        places = [a + (b - a) * x for a, b in ends]
        return np.concatenate(places), np.concatenate([abs(b - a) * w for a, b in ends])

    theta, theta_weight = pieces([(theta_o, 0), (theta_o, middle), (np.pi / 2, middle)])
    quarters = [(k * np.pi / 2, (k + side) * np.pi / 2) for k in range(4) for side in (0.5, -0.5)]
    phi, phi_weight = pieces(quarters)
    wi = directions(theta[:, None], phi[None, :]).reshape(-1, 3)
    return Hemisphere(wi, np.outer(np.sin(theta) * theta_weight, phi_weight).ravel())


def albedo_by_quadrature(value: Value, theta_o: float) -> float:
    """The integral of f cos over the light's directions; `value` gives one number for each pair."""
    over = hemisphere(theta_o)
    return over.reflected(value(over.wi, directions(theta_o)))


class Weights(NamedTuple):
    """Statistics of a sampler's weight f cos / pdf, without noise."""

    mean: float
    variance: float
    highest: float


def weights(model: Model, theta_o: float) -> Weights:
    """By quadrature over what the sampler reaches."""
    over, wo = hemisphere(theta_o), directions(theta_o)
    f_cos = gray(model)(over.wi, wo) * over.wi[:, 2]
    pdf = np.asarray(model.pdf(over.wi, wo), float)
    reached = pdf > 0
    ratio = np.where(reached, f_cos / np.where(reached, pdf, 1), 0)
    mean = over.integral(np.where(reached, f_cos, 0))
    # (w - 1)^2 pdf needs no difference of nearly equal numbers, where the mean is nearly 1
    spread = over.integral(np.where(reached, (ratio - 1) ** 2 * pdf, 0))
    share = over.integral(pdf)
    # E[(w - 1)^2] with the wasted samples, whose weight is 0
    return Weights(mean, spread + max(1 - share, 0) - (mean - 1) ** 2, float(ratio.max()))


class Drawn(NamedTuple):
    """Statistics of the weights of samples that were drawn."""

    mean: float
    variance: float
    highest: float


def drawn(model: Model, theta_o: float, samples: int = 1_000_000, *, seed: int = 0) -> Drawn:
    """As the EON paper measures: of independent samples, a wasted one with weight 0."""
    rng = np.random.default_rng(seed)
    u = rng.random((samples, 2), np.float32)
    wo = directions(theta_o).astype(np.float32)
    wi, pdf = model.sample(wo, u)
    f_cos = np.asarray(model.eval(wi, wo), np.float64)[..., 0] * wi[..., 2]
    weight = np.where(pdf > 0, f_cos / np.where(pdf > 0, pdf, 1), 0)
    return Drawn(float(weight.mean()), float(weight.var()), float(weight.max()))
