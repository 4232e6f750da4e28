"""Inputs for proofs: random ones, and those that break shading code. All float32.

A few rows in each hundred are of every kind below; which row is of which kind can be read from its number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio.export.entry import Member
from gonio.export.prove.tools import Rows
from gonio.fields import Parameter
from gonio.model import Model

Array = npt.NDArray[np.float64]

LAST_RANDOM = np.float32(1 - 2.0**-24)
"""The largest float32 below 1: random numbers lie in [0, 1)."""

# Smallest cosine and sine of a grazing or nearly perpendicular direction, and distance from the mirror
# direction: about the rounding of a float32.
NEAREST = 1e-7

# Ranges that span more than this are walked by powers of ten.
WIDE = 100.0


def rows_for(model: Model, members: Sequence[Member], count: int, seed: int = 0) -> Rows:
    """Rows of inputs for an export of `model` with these members, shape (count, 8 + parameters)."""
    rng = np.random.default_rng(seed)
    declared = {path: parameter for path, parameter, _ in model.parameters()}
    columns = [_parameter(rng, declared[m.path], count) for m in members]
    wo, u = _hemisphere(rng, count), _random_numbers(rng, count)
    wi = _hemisphere(rng, count)
    kinds = rng.permutation(count) % len(KINDS)
    for number, kind in enumerate(KINDS):
        chosen = np.nonzero(kinds == number)[0]
        wi[chosen], wo[chosen] = kind(rng, wi[chosen], wo[chosen])
    wi, wo = wi.astype(np.float32), wo.astype(np.float32)
    rows = np.concatenate([wi, wo, u, *columns], 1).astype(np.float32)
    # The last sixth: where the model itself sends samples, so that every lobe is met at its width
    sampled = np.nonzero(kinds >= len(KINDS) * 5 // 6)[0]
    found = with_parameters(model, members, rows[sampled], np.float64).sample(
        rows[sampled, 3:6].astype(np.float64), rows[sampled, 6:8].astype(np.float64)
    )
    rows[sampled, :3] = found.wi
    return rows


def with_parameters(model: Model, members: Sequence[Member], rows: Rows, dtype: Any) -> Model:
    """The model with the rows' parameters as arrays of a precision."""
    values: dict[str, Any] = {}
    column = 8
    for member in members:
        value = rows[:, column : column + member.width].astype(dtype)
        values[member.path] = value if member.width == 3 else value[:, 0]
        column += member.width
    return model.replace(**_nested(model, values))


def _nested(model: Model, values: dict[str, Any]) -> dict[str, Any]:
    """Replacements for the model's own fields; inner models are replaced as a whole."""
    own = {path: value for path, value in values.items() if "." not in path}
    children = {path.partition(".")[0] for path in values if "." in path}
    for name in children:
        inner = {p.partition(".")[2]: v for p, v in values.items() if p.startswith(f"{name}.")}
        child = getattr(model, name)
        own[name] = child.replace(**_nested(child, inner))
    return own


def _hemisphere(rng: np.random.Generator, count: int) -> Array:
    return _direction(rng.random(count), 2 * np.pi * rng.random(count))


def _direction(mu: Any, phi: Any) -> Array:
    mu, phi = np.broadcast_arrays(np.asarray(mu, np.float64), phi)
    s = np.sqrt((1 - mu) * (1 + mu))
    return np.stack([s * np.cos(phi), s * np.sin(phi), mu], -1)


def _small(rng: np.random.Generator, count: int, largest: float) -> Array:
    """Numbers of all sizes from NEAREST up."""
    return np.exp(rng.uniform(np.log(NEAREST), np.log(largest), count))


def _azimuth(w: Array) -> Array:
    return np.asarray(np.arctan2(w[:, 1], w[:, 0]))


Kind = Callable[[np.random.Generator, Array, Array], tuple[Array, Array]]


def _uniform(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    return wi, wo


def _grazing_light(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    return _direction(_small(rng, len(wi), 0.1), _azimuth(wi)), wo


def _grazing_view(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    return wi, _direction(_small(rng, len(wo), 0.1), _azimuth(wo))


def _grazing_both(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    """In front of and behind each other, too."""
    turn = rng.choice([0.0, np.pi, 0.5 * np.pi, 1e-3, np.pi - 1e-3], len(wi))
    return (
        _direction(_small(rng, len(wi), 0.1), _azimuth(wo) + turn),
        _direction(_small(rng, len(wo), 0.1), _azimuth(wo)),
    )


def _perpendicular(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    """One or both of them near the normal, or in it."""
    near = []
    for w in (wi, wo):
        sine = _small(rng, len(w), 0.1) * (rng.random(len(w)) < 0.8)
        phi = _azimuth(w)
        upright = np.stack([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - sine * sine)], -1)
        near.append(np.where(rng.random((len(w), 1)) < 0.7, upright, w))
    return near[0], near[1]


def _near_mirror(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    """Off the mirror direction by distances of all sizes, or in it."""
    offset = _small(rng, len(wi), 1.0) * (rng.random(len(wi)) < 0.9)
    near = wo * [-1, -1, 1] + offset[:, None] * rng.normal(size=wi.shape)
    near[:, 2] = np.abs(near[:, 2])
    return near / np.linalg.norm(near, axis=-1, keepdims=True), wo


def _backwards(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    """wi = wo to the last bit."""
    return wo, wo


def _in_plane(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    """In the plane of wo and the normal: same or opposite azimuth."""
    turn = np.where(rng.random(len(wi)) < 0.5, 0.0, np.pi)
    return _direction(wi[:, 2], _azimuth(wo) + turn), wo


def _horizon(rng: np.random.Generator, wi: Array, wo: Array) -> tuple[Array, Array]:
    """Exactly in the horizon, or below it: one of the two, or both."""
    lowered = []
    which = rng.integers(0, 3, len(wi))
    for number, w in enumerate((wi, wo)):
        flat = np.stack([np.cos(_azimuth(w)), np.sin(_azimuth(w)), 0 * w[:, 2]], -1)
        under = np.where(rng.random((len(w), 1)) < 0.5, flat, w * [1, 1, -1])
        lowered.append(np.where((which == number)[:, None], w, under))
    return lowered[0], lowered[1]


KINDS: tuple[Kind, ...] = (
    _uniform,
    _grazing_light,
    _near_mirror,
    _uniform,
    _perpendicular,
    _near_mirror,
    _grazing_view,
    _backwards,
    _uniform,
    _in_plane,
    _horizon,
    _grazing_both,
    # Of these wi is replaced by a direction that the model samples
    _grazing_view,
    _uniform,
    _uniform,
)


def _random_numbers(rng: np.random.Generator, count: int) -> Rows:
    u = rng.random((count, 2)).astype(np.float32)
    ends = np.array([0, 2.0**-24, LAST_RANDOM], np.float32)
    at_end = rng.random(u.shape) < 0.06
    return np.minimum(np.where(at_end, rng.choice(ends, u.shape), u), LAST_RANDOM)


def _parameter(rng: np.random.Generator, declared: Parameter, count: int) -> Rows:
    """Values over the whole range, a twentieth at and a twentieth just inside each end."""
    t = rng.random((count, declared.width))
    place = rng.random(t.shape)
    near = np.exp(rng.uniform(np.log(1e-6), np.log(1e-2), t.shape))
    t = np.select([place < 0.05, place < 0.1, place < 0.15, place < 0.2], [0, 1, near, 1 - near], t)
    # Greys among the colours
    t = np.where(rng.random((count, 1)) < 0.2, t[:, :1], t)
    low, high = declared.low, declared.high
    span = high - low
    value = low + (np.expm1(t * np.log1p(span)) if span > WIDE else t * span)
    return clipped(declared, value.astype(np.float32))


def clipped(declared: Parameter, value: Rows) -> Rows:
    """Into the range that the model allows, without leaving float32."""
    return np.clip(value, np.float32(declared.low), np.float32(declared.high))
