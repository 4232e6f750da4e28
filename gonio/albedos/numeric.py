"""Albedos without a closed form, as users ask for them: many lanes at once, and never silently wrong.

`gonio.albedos.quadrature` has three rules, each for lobes of another shape. A model says which one fits
(`numeric = NumericAlbedo("mirror")`); of a model that says nothing, the rule is found here by comparing all
three with the model's own sampler, at some of the directions that are asked for. Where none agrees, a
`Notice` says by how much they differ, and what to do.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from gonio.albedos.quadrature import RULES, SMOOTH_FROM, NumericAlbedo, mean_nodes
from gonio.fields import Parameter, framework, is_array
from gonio.messages import notice

# Values of parameters up to which a mean is taken over an array of directions; more keep a machine busy by
# themselves, and the directions take their turns in the kernel.
LANES = 4096

# Pairs of a direction and parameters at which rules are compared, and samples for each of them.
PROBES = 12
SAMPLES = 4096

# A rule agrees with the sampler up to that many standard errors, and up to this part of the albedo: kinks
# cost some rules 1e-3, and more would be seen.
SPREAD = 5.0
AGREEMENT = 4e-3

# Directions by which it is judged whether few half vectors do, by how much these may change the albedo, and
# how many directions are worth the trial.
SMOOTH_PROBES = 13
SMOOTHNESS = 2e-6
WORTH = 64

# Pairs of directions by which mirror symmetry is judged, and by how much double precision may break it for
# a lobe of width 1e-4.
SYMMETRY_PAIRS = 512
SYMMETRY = 1e-6

# Batches from whose spread the sampler's standard error is taken.
BATCHES = 16


class Asked(Protocol):
    """What is asked of a model that users hold; `gonio.model.Model` has it."""

    name: ClassVar[str]
    numeric: NumericAlbedo

    def parameters(self) -> Iterator[tuple[str, Parameter, Any]]:
        """Path, declaration and value of every parameter."""

    def replace(self, **changed: Any) -> Self:
        """A copy with some parameters changed."""

    def with_numeric(self, numeric: NumericAlbedo) -> Self:
        """A copy whose albedos are found in another way."""

    def follows_tangents(self) -> bool:
        """Whether turning both directions about the normal changes the value."""

    def eval(self, wi: Any, wo: Any) -> Any:
        """BRDF value in 1/sr."""

    def sample(self, wo: Any, u: Any) -> Any:
        """Sampled directions and their density."""

    def albedo(self, wo: Any) -> Any:
        """Directional albedo."""


# --- means -----------------------------------------------------------------------------------------


def mean_over_directions(model: Asked) -> Any | None:
    """The mean albedo over an array of directions; None where the kernel's own loop serves better.

    A mean needs 24 directions, or 288 of an anisotropic model. One after the other they would leave all but
    one lane of the machine idle.
    """
    arrays = [(declared, value) for _, declared, value in model.parameters() if is_array(value)]
    if any(framework(value) == "drjit" for _, value in arrays):
        return None
    shapes = [_batch(declared, value) for declared, value in arrays]
    if sum(math.prod(shape) for shape in shapes) > LANES:
        return None
    wo, weights = mean_nodes(model.follows_tangents())
    double = any(str(value.dtype).endswith("float64") for _, value in arrays)
    rank = max((len(shape) for shape in shapes), default=0)
    directions = wo.astype(np.float64 if double else np.float32)
    found = model.albedo(directions.reshape(len(wo), *(1,) * rank, 3))
    if framework(found) == "torch":
        return (found * found.new_tensor(weights).reshape(-1, *(1,) * (rank + 1))).sum(0)
    return (found * weights.reshape(-1, *(1,) * (rank + 1)).astype(found.dtype)).sum(0)


def _batch(declared: Parameter, value: Any) -> tuple[int, ...]:
    """The shape of a parameter's array without the component."""
    shape = tuple(value.shape)
    return shape[:-1] if declared.width == 3 else shape


# --- which rule ------------------------------------------------------------------------------------


M = TypeVar("M", bound=Asked)


def for_quadrature(model: M, wo: Any, known: dict[Any, Any]) -> M:
    """The model with the rule that fits its lobes at some of the directions, which are (..., 3).

    Gives a `Notice` where no rule agrees with the model's own sampler. known: what was found out for the
    same model before; what holds for all directions is added.
    """
    constant = not any(is_array(value) for _, _, value in model.parameters())
    if not model.numeric.rule:
        return _with_fitting_rule(model, wo, constant and _symmetric(model))
    if "symmetric" not in known:
        numeric = replace(model.numeric, symmetric=constant and _symmetric(model))
        known["symmetric"] = model.with_numeric(numeric)
    found: M = known["symmetric"]
    if not constant or found.numeric.rule != "half_vectors" or math.prod(np.shape(wo)) < 3 * WORTH:
        return found
    if "smooth" not in known:
        smooth = found.with_numeric(replace(found.numeric, smooth=True))
        known["smooth"] = smooth if _same_albedos(found, smooth) else found
    few: M = known["smooth"]
    return few


def _same_albedos(model: Asked, other: Asked) -> bool:
    """Whether the albedos of two are the same, at directions of all elevations and azimuths."""
    mu = np.linspace(SMOOTH_FROM, 1, SMOOTH_PROBES)
    phi = 2 * np.pi * _random_numbers()[:SMOOTH_PROBES, 0]
    s = np.sqrt(1 - mu * mu)
    wo = np.stack([s * np.cos(phi), s * np.sin(phi), mu], -1).astype(np.float32)
    one, two = (np.asarray(m.albedo(wo)) for m in (model, other))
    return bool((np.abs(one - two) <= SMOOTHNESS).all())


def _symmetric(model: Asked) -> bool:
    """Whether values are the same on both sides of the plane of wo, at random directions."""
    rng = np.random.default_rng(0)
    wi, wo = rng.normal(size=(2, SYMMETRY_PAIRS, 3))
    # Near the mirror direction as well, where sharp lobes are
    near = SYMMETRY_PAIRS // 2
    wi[:near] = (
        wo[:near] * [-1, -1, 1] + 0.1 * rng.normal(size=(near, 3)) * rng.random((near, 1)) ** 4
    )
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    wi /= np.linalg.norm(wi, axis=-1, keepdims=True)
    wo /= np.linalg.norm(wo, axis=-1, keepdims=True)
    across = np.stack([-wo[:, 1], wo[:, 0], np.zeros(len(wo))], -1)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    mirrored = wi - 2 * np.sum(wi * across, -1, keepdims=True) * across
    one, other = np.asarray(model.eval(wi, wo)), np.asarray(model.eval(mirrored, wo))
    return bool((np.abs(one - other) <= SYMMETRY * (np.abs(one) + np.abs(other))).all())


def _with_fitting_rule(model: M, wo: Any, symmetric: bool) -> M:
    try:
        probes, parameters = _probes(model, wo)
    except TypeError:  # values that are not known yet, as inside jax.jit
        return model.with_numeric(NumericAlbedo("angles", symmetric=symmetric))
    if not len(probes):
        return model.with_numeric(NumericAlbedo("angles", symmetric=symmetric))
    probe = model.replace(**parameters)
    expected, error = _by_sampling(probe, probes)
    allowed = SPREAD * error + AGREEMENT * np.maximum(np.abs(expected), 0.1)
    misses = {}
    for rule in RULES:
        found = np.asarray(probe.with_numeric(NumericAlbedo(rule)).albedo(probes), np.float64)
        miss = np.abs(found - expected) / allowed
        if np.isfinite(found).all() and (miss <= 1).all():
            return model.with_numeric(NumericAlbedo(rule, symmetric=symmetric))
        misses[rule] = (float(np.nan_to_num(miss, nan=np.inf, posinf=np.inf).max()), found)
    best = min(misses, key=lambda rule: misses[rule][0])
    found = misses[best][1]
    at = int(np.argmax((np.abs(found - expected) / allowed).max(-1)))
    angle = math.degrees(math.acos(min(1.0, float(probes[at, 2]))))
    notice(
        f"{model.name}: the albedo is uncertain; at {angle:.1f} degrees quadrature gives "
        f"{_text(found[at])} and the model's own samples {_text(expected[at])}. Write a method albedo, "
        f"name the rule that fits (numeric = NumericAlbedo(rule) of {', '.join(map(repr, RULES))}), or let "
        "'gonio check' look for a wrong sampler."
    )
    return model.with_numeric(NumericAlbedo(best, symmetric=symmetric))


def _text(colour: NDArray[np.float64]) -> str:
    distinct = colour[:1] if np.ptp(colour) == 0 else colour
    return "/".join(f"{value:.4g}" for value in distinct)


def _probes(model: Asked, wo: Any) -> tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]:
    """Some directions above the horizon, and the parameters that are arrays, at the same places."""
    arrays = {
        path: (declared, _host(value))
        for path, declared, value in model.parameters()
        if is_array(value)
    }
    directions = _host(wo)
    shape = np.broadcast_shapes(
        directions.shape[:-1], *(_batch(declared, value) for declared, value in arrays.values())
    )
    places = _spread(math.prod(shape), PROBES)
    flat = _rows(directions, shape, 3)[places]
    above = flat[:, 2] > 0
    values = {
        path: (_rows(value, shape, 3) if declared.width == 3 else _rows(value, shape, 1)[:, 0])[
            places
        ][above]
        for path, (declared, value) in arrays.items()
    }
    length = np.linalg.norm(flat[above], axis=-1, keepdims=True)
    return flat[above] / length, values


def _host(value: Any) -> NDArray[np.float64]:
    if framework(value) == "torch":
        value = value.detach().cpu()
    host: NDArray[np.float64] = np.asarray(value, np.float64)
    return host


def _rows(value: NDArray[np.float64], shape: Sequence[int], width: int) -> NDArray[np.float64]:
    if width == 1:
        value = value[..., None]
    spread: NDArray[np.float64] = np.broadcast_to(value, (*shape, width))
    return spread.reshape(-1, width)


def _spread(count: int, wanted: int) -> NDArray[np.int64]:
    """Places in an array, the ends among them."""
    places: NDArray[np.int64] = np.linspace(0, count - 1, min(count, wanted)).round().astype(int)
    return np.unique(places)


@functools.cache
def _random_numbers() -> NDArray[np.float64]:
    """A Kronecker sequence (Roberts' R2), shape (SAMPLES, 2): spread evenly, and the same each time."""
    root = 1.32471795724474602596  # of x^3 = x + 1
    steps: NDArray[np.float64] = np.arange(SAMPLES)[:, None] * np.array([1 / root, 1 / root**2])
    return (0.5 + steps) % 1


def _by_sampling(
    model: Asked, wo: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Albedos as the mean weight of the model's own samples, and their standard errors."""
    arrays = {
        path: value[None] if declared.width == 1 else value[None, ...]
        for path, declared, value in model.parameters()
        if is_array(value)
    }
    spread = model.replace(**arrays) if arrays else model
    from_wo = wo[None]
    wi, pdf = spread.sample(from_wo, _random_numbers()[:, None])
    wi, pdf = np.asarray(wi, np.float64), np.asarray(pdf, np.float64)
    valid = pdf > 0
    safe = np.where(valid[..., None], wi, [0.0, 0.0, 1.0])
    value = np.asarray(spread.eval(safe, np.broadcast_to(from_wo, safe.shape)), np.float64)
    factor = np.where(valid, safe[..., 2] / np.where(valid, pdf, 1), 0)
    weight = np.nan_to_num(value * factor[..., None], nan=0.0, posinf=0.0)
    batches = weight.reshape(BATCHES, -1, *weight.shape[1:]).mean(1)
    return batches.mean(0), batches.std(0, ddof=1) / math.sqrt(BATCHES)
