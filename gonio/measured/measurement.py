"""What every reader returns: reflection as it was measured, in one form whatever the file was."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gonio.measured.frames import Floats, spherical
from gonio.measured.interpolation import Scattered

Singles = NDArray[np.float32]
Mask = NDArray[np.bool_]

# Values in 1/sr above this are damage, not light: the sun's disc reflected by a perfect mirror has 1.5e4.
LARGEST = 1e12

# A direction is above the horizon if its cosine is larger: what readers' single precision leaves of 0.
HORIZON = 1e-6


class DataError(ValueError):
    """A file that is damaged, truncated, too large or of no known format; the message is one line."""


class Reflectance(Protocol):
    """Anything that has a value for each pair of directions: what writers take."""

    title: str
    channels: tuple[str, ...]
    wavelengths: Floats | None
    """In nm, one for each channel of a spectrum; None for colours."""
    isotropic: bool

    def evaluate(self, wi: Any, wo: Any) -> Floats:
        """BRDF in 1/sr without the cosine, (n, channels), for directions (n, 3)."""


Interpolator = Callable[[Floats, Floats], tuple[Floats, Mask]]


@dataclass(frozen=True)
class Measurement:
    """Measured reflection (or transmission) of one side of a sample.

    The directions are unit vectors in the local frame, normal +z: `wi` towards the light, `wo` towards
    the detector, below the surface for transmission. Values are BSDFs in 1/sr, without the cosine.
    """

    format: str
    """The file's format, such as "MERL"."""
    title: str
    wi: Singles
    """(n, 3)."""
    wo: Singles
    """(n, 3)."""
    values: Singles
    """(n, channels); 0 where there is no value."""
    weights: Singles
    """(n,): 1 for a value, 0 for a hole, and 1 / variance (1 on average) where the file has errors."""
    channels: tuple[str, ...]
    """Names of the columns of `values`: "r", "g", "b", "X", "Y", "Z", "value", or "550 nm"."""
    wavelengths: Floats | None = None
    """In nm, one for each channel of a spectrum."""
    isotropic: bool = True
    """Whether only the difference of the azimuths matters, as far as the file says."""
    extrapolated: Mask | None = None
    """(n,): values that were not measured but continued by the file's authors."""
    part: str = "reflection"
    """Which of a file's parts this is: "reflection", "reflection back", "transmission" and so on."""
    units: str = "1/sr"
    """What the file's numbers are."""
    notes: tuple[str, ...] = ()
    """What was converted, corrected or left out on reading, for people."""
    metadata: Mapping[str, str] = field(default_factory=dict)
    """What the file says about the sample and how it was measured."""
    grid: Mapping[str, int] = field(default_factory=dict)
    """The axes of the file's table and how many places each has; empty for loose points."""
    interpolator: Interpolator | None = field(default=None, repr=False, compare=False)
    """Values between the measured ones as the format defines them; loose points have none."""

    @property
    def valid(self) -> Mask:
        """(n,): where there is a value."""
        return self.weights > 0

    @property
    def transmission(self) -> bool:
        """Whether light goes through."""
        return self.part.startswith("transmission")

    def evaluate(self, wi: Any, wo: Any) -> Floats:
        """Values at any directions, interpolated: (n, channels). See `interpolate`."""
        return self.interpolate(wi, wo)[0]

    def interpolate(self, wi: Any, wo: Any) -> tuple[Floats, Mask]:
        """Values (n, channels) at directions (n, 3), and where measured ones are near enough: (n,).

        As the format defines it, else by `gonio.measured.interpolation`.
        """
        wi, wo = (np.atleast_2d(np.asarray(w, np.float64)) for w in (wi, wo))
        interpolator = self.interpolator
        if interpolator is None:
            use = self.valid
            interpolator = Scattered(
                self.wi[use].astype(np.float64),
                self.wo[use].astype(np.float64),
                self.values[use],
                self.isotropic,
            )
            object.__setattr__(self, "interpolator", interpolator)
        with np.errstate(
            all="ignore"
        ):  # what is no number in a damaged file is no value here either
            values, covered = interpolator(wi, wo)
        broken = ~np.isfinite(values).all(-1)
        below = wi[:, 2] <= HORIZON
        below |= (wo[:, 2] >= -HORIZON) if self.transmission else (wo[:, 2] <= HORIZON)
        away = below | broken
        return np.where(away[:, None], 0.0, values), covered & ~away

    def with_notes(self, *notes: str) -> Measurement:
        """A copy that says more."""
        return replace(self, notes=(*self.notes, *notes))


def measurement(
    format: str,
    title: str,
    wi: Any,
    wo: Any,
    values: Any,
    *,
    hole: Any = None,
    precision: Any = None,
    **more: Any,
) -> Measurement:
    """Put a measurement together: what is no number, or below the horizon, becomes a hole, and is
    counted.

    Args:
        format: its name.
        title: of the sample.
        wi: unit vectors (n, 3).
        wo: likewise.
        values: (n, channels), in 1/sr.
        hole: (n,), values that the format marks as missing.
        precision: (n,), 1 / variance, where the file has it.
        more: the other fields of `Measurement`.

    Raises:
        DataError: there is not one value.
    """
    values = np.asarray(values)
    with np.errstate(over="ignore", invalid="ignore"):
        broken = ~(np.abs(values) <= LARGEST).all(-1)  # NaN fails this as well
    through = str(more.get("part", "reflection")).startswith("transmission")
    below = wi[..., 2] <= HORIZON
    below = below | ((wo[..., 2] >= -HORIZON) if through else (wo[..., 2] <= HORIZON))
    missing = np.zeros(len(values), bool) if hole is None else np.asarray(hole)
    away = broken | below | missing
    if away.all():
        raise DataError(
            f"{title}: no value can be used: of {len(values)}, {int(broken.sum())} are no numbers, "
            f"{int(below.sum())} below the horizon and {int(missing.sum())} marked as missing."
        )
    notes = list(more.pop("notes", ()))
    if (broken & ~missing & ~below).any():
        notes.append(f"{int((broken & ~missing & ~below).sum())} values are no numbers: holes")
    if below.any():
        notes.append(f"{int(below.sum())} values are in the horizon or below: left out")
    weights = np.ones(len(values)) if precision is None else np.array(precision, np.float64)
    if precision is not None:
        weights[~np.isfinite(weights) | (weights < 0)] = 0
        used = weights[~away & (weights > 0)]
        weights = weights / used.mean() if used.size else np.ones(len(values))
    weights[away] = 0
    return Measurement(
        format=format,
        title=title,
        wi=np.ascontiguousarray(wi, np.float32),
        wo=np.ascontiguousarray(wo, np.float32),
        values=np.where(away[:, None], 0, values).astype(np.float32),
        weights=weights.astype(np.float32),
        notes=tuple(notes),
        **more,
    )


# Departure under turns up to which a model counts as isotropic: rounding, far below what files resolve.
ROUND = 1e-6


class OfModel:
    """A model as something that writers take."""

    channels: tuple[str, ...] = ("r", "g", "b")
    wavelengths: Floats | None = None

    def __init__(self, model: Any) -> None:
        """Take a model whose parameters are numbers, and find out whether it is isotropic as it is."""
        self.model, self.title = model, repr(model)
        random = np.random.default_rng(7)
        wi, wo = (
            spherical(np.arccos(random.uniform(0.05, 1, 256)), a)
            for a in random.uniform(-np.pi, np.pi, (2, 256))
        )
        c, s = np.cos(2.0), np.sin(2.0)
        about = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        straight, turned = self.evaluate(wi, wo), self.evaluate(wi @ about, wo @ about)
        self.isotropic = bool((np.abs(turned - straight) <= ROUND * (1 + np.abs(straight))).all())

    def evaluate(self, wi: Any, wo: Any) -> Floats:
        """The model in double precision, (n, 3)."""
        wi, wo = (np.atleast_2d(np.asarray(w, np.float64)) for w in (wi, wo))
        return np.asarray(self.model.eval(wi, wo), np.float64)


def reflectance(source: Any) -> Reflectance:
    """A model or a measurement as what writers take."""
    from gonio.model import Model

    if isinstance(source, Model):
        return OfModel(source)
    found: Reflectance = source
    return found
