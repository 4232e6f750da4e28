"""Conversions between the scales on which roughness is measured.

    from gonio import conversions
    conversions.alpha_from_perceptual(0.5)                   # 0.25
    conversions.convert(10, "shininess", "sigma").value      # 0.447...

Every function takes a number or a NumPy array (any shape, elementwise) and returns the same kind.
A value outside its scale is a ValueError. Only `alpha_from_perceptual`, `sigma_from_shininess` and
their inverses are definitions; the others match two shapes that are not equal, and say how.

`specular_from_metallic` and `metallic_from_specular` convert whole materials between the two workflows of
games, base colour-metallic-roughness and diffuse-specular-gloss.

Sources: Burley, SIGGRAPH 2012 course; Walter et al., EGSR 2007; Gotanda, SIGGRAPH 2012 course; "PBR theory,
part 1: foundations" (SZ's temple, 2019), section 4, for the workflows.
"""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

HALF_PI = float(np.pi / 2)

Numbers = TypeVar("Numbers", float, npt.NDArray[np.float64])


@dataclass(frozen=True)
class Scale:
    """A way to state roughness: its name, allowed range and meaning."""

    name: str
    low: float
    high: float
    meaning: str
    excluded: float | None = None
    """An end of the range that is not allowed itself."""

    def check(self, value: Numbers) -> Numbers:
        """Return the value as float64, or raise a ValueError that names the range."""
        array = np.asarray(value, np.float64)
        good = (array >= self.low) & (array <= self.high) & np.isfinite(array)  # not NaN
        if self.excluded is not None:
            good &= array != self.excluded
        if not good.all():
            bad = float(array[~good].flat[0])
            allowed = self.range_text()
            raise ValueError(f"{self.name} {bad:g} is out of range; allowed is {allowed}.")
        return array if isinstance(value, np.ndarray) else float(array)

    def range_text(self) -> str:
        """The range for people, such as "0 to 1" or "more than 0"."""
        if not np.isfinite(self.high):
            return f"{'more than' if self.excluded == self.low else 'at least'} {self.low:g}"
        high = "pi/2" if self.high == HALF_PI else f"{self.high:g}"
        ends = f"{self.low:g} to {high}"
        return ends if self.excluded is None else f"{ends}, without {self.excluded:g}"


PERCEPTUAL = Scale("perceptual", 0, 1, "artists' roughness, alpha = perceptual^2")
ALPHA = Scale("alpha", 0, 1, "width of a microfacet distribution; for Beckmann the rms slope m")
SHININESS = Scale("shininess", 0, np.inf, "Blinn-Phong exponent n")
SIGMA = Scale("sigma", 0, HALF_PI, "Oren-Nayar: standard deviation of the facet angle, radians")
R = Scale("r", 0, 1, "roughness of FON and EON; unitless, not an angle")

SCALES: dict[str, Scale] = {s.name: s for s in (PERCEPTUAL, ALPHA, SHININESS, SIGMA, R)}

# A sharp highlight is an infinite exponent, which no float holds.
_ALPHA_OPEN = Scale("alpha", 0, 1, ALPHA.meaning, excluded=0)
_SIGMA_OPEN = Scale("sigma", 0, HALF_PI, SIGMA.meaning, excluded=0)

# Least exponent whose sigma = sqrt(2 / n) is still an angle up to pi/2, the top of the sigma scale.
SHININESS_MIN = 8 / np.pi**2
_SHININESS_ANGLE = Scale("shininess", SHININESS_MIN, np.inf, SHININESS.meaning)

# Up to here alpha = sqrt(2) sigma is within 10 % of the Beckmann nearest to the Gaussian.
SIGMA_SMALL = 0.5
_SIGMA_SMALL = Scale("sigma", 0, SIGMA_SMALL, SIGMA.meaning)
_ALPHA_SMALL = Scale("alpha", 0, float(np.sqrt(2)) * SIGMA_SMALL, ALPHA.meaning)


def alpha_from_perceptual(perceptual: Numbers) -> Numbers:
    """alpha = perceptual² (Burley 2012), the usual definition of perceptual roughness."""
    r = PERCEPTUAL.check(perceptual)
    return r * r


def perceptual_from_alpha(alpha: Numbers) -> Numbers:
    """perceptual = sqrt(alpha), the inverse of `alpha_from_perceptual`."""
    return _sqrt(ALPHA.check(alpha))


def shininess_from_alpha(alpha: Numbers) -> Numbers:
    """n = 2 / alpha² − 2: the Blinn–Phong lobe nearest to Beckmann's (Walter et al. 2007).

    A match: both distributions have the same value at the normal, and the same width as alpha goes
    to 0. alpha is more than 0 and at most 1, where n reaches 0.
    """
    a = _ALPHA_OPEN.check(alpha)
    return 2 / (a * a) - 2


def alpha_from_shininess(shininess: Numbers) -> Numbers:
    """alpha = sqrt(2 / (n + 2)), the inverse of `shininess_from_alpha`."""
    n = SHININESS.check(shininess)
    return _sqrt(2 / (n + 2))


def sigma_from_shininess(shininess: Numbers) -> Numbers:
    """sigma = sqrt(2 / n): Gotanda's definition (tri-Ace, 2012), used by `triace_oren_nayar`.

    Should not be confused with `sigma_from_alpha`: this one calls sigma what Beckmann calls m, the
    rms slope of both axes together, which is sqrt(2) times the standard deviation of one. n is at
    least 8 / pi², where sigma reaches pi/2.
    """
    n = _SHININESS_ANGLE.check(shininess)
    return _sqrt(2 / n)


def shininess_from_sigma(sigma: Numbers) -> Numbers:
    """n = 2 / sigma², the inverse of `sigma_from_shininess`; sigma is more than 0."""
    s = _SIGMA_OPEN.check(sigma)
    return 2 / (s * s)


def alpha_from_sigma(sigma: Numbers) -> Numbers:
    """alpha = sqrt(2) sigma: Beckmann's m for a Gaussian of facet angles, for sigma up to 0.5.

    A match to first order: exp(−θ²/(2 sigma²)) and exp(−tan²θ/m²) agree where tan θ ≈ θ. Compared
    with the Beckmann distribution nearest to the Gaussian (least integral of |difference| cos θ),
    alpha is at most 3 % too high up to sigma = 0.3 and 10 % at 0.5. Beyond, no Beckmann is near.
    """
    s = _SIGMA_SMALL.check(sigma)
    return float(np.sqrt(2)) * s


def sigma_from_alpha(alpha: Numbers) -> Numbers:
    """sigma = alpha / sqrt(2), the inverse of `alpha_from_sigma`; alpha is at most 0.7071."""
    a = _ALPHA_SMALL.check(alpha)
    # alpha's end divided by sqrt(2) may round to more than 0.5, which the inverse would refuse.
    limited: Numbers = np.minimum(a / float(np.sqrt(2)), SIGMA_SMALL)
    return limited if isinstance(a, np.ndarray) else float(limited)


def r_from_sigma(sigma: Numbers) -> Numbers:
    """r = B/A of QON: FON's retro-reflective term then weighs as much against its constant one.

    A match of the shape f = rho/pi (A + B s/t), with QON's A = 1 − 0.5 sigma²/(sigma² + 0.33) and
    B = 0.45 sigma²/(sigma² + 0.09), and FON's B_F/A_F = r. The brightness is not kept: QON's A is
    the smaller one. sigma = pi/2 gives r = 0.7767, the roughest that QON can be.
    """
    s = SIGMA.check(sigma)
    s2 = s * s
    A = 1 - 0.5 * s2 / (s2 + 0.33)
    B = 0.45 * s2 / (s2 + 0.09)
    return B / A


R_MAX = r_from_sigma(HALF_PI)
_R_REACHED = Scale("r", 0, R_MAX, R.meaning)


def sigma_from_r(r: Numbers) -> Numbers:
    """sigma whose B/A of QON is r, the inverse of `r_from_sigma`; r is at most 0.7767."""
    r = _R_REACHED.check(r)
    # r (x + 0.09)(0.5 x + 0.33) = 0.45 x (x + 0.33) with x = sigma²: a x² + b x = c
    a = 0.45 - 0.5 * r
    b = 0.1485 - 0.375 * r
    c = 0.0297 * r
    root = _sqrt(b * b + 4 * a * c)
    # Of the two forms of the root, each is exact where the other one cancels; b changes its sign.
    x = np.where(np.asarray(b) > 0, 2 * c / (np.abs(b) + root), (root - b) / (2 * a))
    sigma = np.minimum(np.sqrt(x), HALF_PI)
    return sigma if isinstance(r, np.ndarray) else float(sigma)


def _sqrt(x: Numbers) -> Numbers:
    return np.sqrt(x) if isinstance(x, np.ndarray) else float(np.sqrt(x))


@dataclass(frozen=True)
class Conversion:
    """A converted value and the functions that led to it, in their order."""

    value: Any
    steps: tuple[Callable[[Any], Any], ...]

    def meanings(self) -> list[str]:
        """One sentence for each step: what it takes the two scales to mean."""
        return [(inspect.getdoc(step) or "").partition("\n")[0] for step in self.steps]


# The direct conversions by the scales they connect.
_DIRECT: dict[tuple[str, str], Callable[[Any], Any]] = {
    ("perceptual", "alpha"): alpha_from_perceptual,
    ("alpha", "perceptual"): perceptual_from_alpha,
    ("alpha", "shininess"): shininess_from_alpha,
    ("shininess", "alpha"): alpha_from_shininess,
    ("shininess", "sigma"): sigma_from_shininess,
    ("sigma", "shininess"): shininess_from_sigma,
    ("sigma", "alpha"): alpha_from_sigma,
    ("alpha", "sigma"): sigma_from_alpha,
    ("sigma", "r"): r_from_sigma,
    ("r", "sigma"): sigma_from_r,
}


def convert(value: Any, source: str, target: str) -> Conversion:
    """Convert a number or array between two scales, over as few steps as possible.

    Args:
        value: number or NumPy array on the source's scale.
        source, target: names in `SCALES`: perceptual, alpha, shininess, sigma or r.

    Raises:
        ValueError: an unknown scale, or a value that one of the steps does not allow.
    """
    for name in (source, target):
        if name not in SCALES:
            raise ValueError(f"no roughness scale {name!r}; known are {', '.join(SCALES)}.")
    value = SCALES[source].check(value)
    paths: dict[str, tuple[str, ...]] = {source: (source,)}
    waiting = [source]
    for name in waiting:  # grows while it is read: a breadth-first search
        for start, end in _DIRECT:
            if start == name and end not in paths:
                paths[end] = (*paths[name], end)
                waiting.append(end)
    path = paths[target]
    steps = tuple(_DIRECT[pair] for pair in itertools.pairwise(path))
    for step in steps:
        value = step(value)
    return Conversion(value, steps)


class Metallic(NamedTuple):
    """A material as `metallic_roughness`, `ue4`, `unity_standard` and `disney` describe it."""

    base_color: Any
    """Diffuse colour of dielectrics and F0 of metals, linear RGB, shape (..., 3)."""
    metallic: Any
    """0 for dielectrics, 1 for metals, shape (...)."""
    roughness: Any
    """Perceptual roughness, shape (...)."""


class Specular(NamedTuple):
    """The same material as its two terms: what a diffuse and a specular model take."""

    diffuse: Any
    """Albedo of the diffuse term, linear RGB, shape (..., 3)."""
    specular: Any
    """Reflectance at normal incidence F0, linear RGB, shape (..., 3)."""
    gloss: Any
    """1 - perceptual roughness, which Unity calls smoothness, shape (...)."""


# F0 of every dielectric in the metallic workflow.
F0_DIELECTRIC = 0.04

# How far `metallic_from_specular` lets a material be from one that has a metallic description: half a step
# of an 8-bit texture.
WORKFLOW_TOLERANCE = 0.5 / 255

# Difference of two fits that is rounding: the two roots are then equally good.
ROOT_ROUNDING = 1e-9


def specular_from_metallic(base_color: Any, metallic: Any, roughness: Any) -> Specular:
    """diffuse = base (1 - metallic), specular = lerp(0.04, base, metallic), gloss = 1 - roughness.

    Numbers or arrays from 0 to 1; base_color has three numbers last. Every material has a result.
    """
    base = _unit("base_color", base_color, width=3)
    m = _unit("metallic", metallic)
    r = _unit("roughness", roughness)
    dielectric = (1 - m)[..., None]
    specular = F0_DIELECTRIC * dielectric + base * m[..., None]
    return Specular(base * dielectric, specular, 1 - r)


def metallic_from_specular(diffuse: Any, specular: Any, gloss: Any) -> Metallic:
    """The inverse of `specular_from_metallic`.

    It exists for materials that `specular_from_metallic` can return: three channels of diffuse and three
    of specular have to agree on one metallic, so a dielectric with a coloured or an unusual F0 has none.
    It is unique if the brightest channel of the base colour is more than 0.04. Otherwise two materials
    may have the same two terms, and the least metallic one is returned: black plastic stays plastic.

    Raises:
        ValueError: no metallic material is within half an 8-bit step of this one.
    """
    d = _unit("diffuse", diffuse, width=3)
    s = _unit("specular", specular, width=3)
    g = _unit("gloss", gloss)
    # q = 1 - metallic solves 0.04 q^2 - (d + s) q + d = 0 in every channel, and base = d + s - 0.04 q.
    # The brightest channel has the best-conditioned roots.
    brightest = np.argmax(d + s, axis=-1, keepdims=True)
    total = np.take_along_axis(d + s, brightest, -1)[..., 0]
    d_max = np.take_along_axis(np.broadcast_to(d, (d + s).shape), brightest, -1)[..., 0]
    root = np.sqrt(np.maximum(total * total - 4 * F0_DIELECTRIC * d_max, 0))
    either = (total + root) / (2 * F0_DIELECTRIC)
    larger = np.minimum(either, 1)
    # Of the two forms of the smaller root, the one without cancellation
    smaller = np.minimum(2 * d_max / np.where(total + root > 0, total + root, 1), 1)
    # Darker than 0.04 both may fit the brightest channel, and the others decide. Else the larger one is
    # above 1, which no material has, however near to it one of a metallic of nearly 0 is.
    base, error = _base_color(d, s, larger)
    base_smaller, error_smaller = _base_color(d, s, smaller)
    less_metallic = (either <= 1 + ROOT_ROUNDING) & (error <= error_smaller + ROOT_ROUNDING)
    q = np.where(less_metallic, larger, smaller)
    base = np.where(less_metallic[..., None], base, base_smaller)
    error = np.minimum(error, error_smaller)
    if np.any(error > WORKFLOW_TOLERANCE):
        place = np.unravel_index(np.argmax(error), error.shape)
        diffuse_text = np.broadcast_to(d, base.shape)[place].tolist()
        specular_text = np.broadcast_to(s, base.shape)[place].tolist()
        raise ValueError(
            f"no metallic material has diffuse {diffuse_text} and specular {specular_text} (off by "
            f"{error[place]:.3g}, allowed is {WORKFLOW_TOLERANCE:.3g}); a dielectric needs specular 0.04."
        )
    return Metallic(np.clip(base, 0, 1), 1 - q, 1 - g)


def _base_color(d: Any, s: Any, q: Any) -> tuple[Any, Any]:
    """Base colour for 1 - metallic = q, and how far it is from giving d and s."""
    base = d + s - F0_DIELECTRIC * q[..., None]
    outside = np.max(np.maximum(base - 1, -base), axis=-1)
    return base, np.maximum(np.max(np.abs(d - base * q[..., None]), axis=-1), outside)


def _unit(name: str, value: Any, width: int | None = None) -> npt.NDArray[np.float64]:
    """The value as float64 with numbers from 0 to 1, and three of them last if `width` is 3."""
    array = np.asarray(value, np.float64)
    if width is not None and array.shape[-1:] != (width,):
        raise ValueError(
            f"{name} must have {width} numbers on its last axis, got the shape {array.shape}."
        )
    return np.asarray(Scale(name, 0, 1, "").check(array))
