"""The numbers that plots show: values, weights, and the places where they are taken."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio import backend
from gonio.fields import Parameter
from gonio.model import Model

Floats = npt.NDArray[np.float64]

CHANNELS: dict[str, tuple[float, float, float]] = {
    "luminance": (0.2126, 0.7152, 0.0722),  # of linear sRGB
    "red": (1, 0, 0),
    "green": (0, 1, 0),
    "blue": (0, 0, 1),
}
RGB = ("red", "green", "blue")

# A parameter with one of these names is the one that mean albedos are plotted against.
ROUGHNESS_NAMES = ("roughness", "sigma", "alpha", "shininess")

# Samples per direction of the viewer in the sampling plot, unless the user asks for another number.
SAMPLES_COMPILED, SAMPLES_SCALAR = 1_000_000, 512

# Samples that are drawn at once: a few arrays of this length fit into a cache of the last level.
BATCH = 1 << 20


def is_slow() -> bool:
    """Whether plain Python computes, for which plots take fewer points."""
    return backend.current() == "scalar"


def direction(theta: Any, phi: Any = 0.0) -> Floats:
    """Unit vectors, shape (..., 3), from polar angles and azimuths in degrees."""
    theta, phi = np.radians(theta), np.radians(phi)
    x, y, z = np.broadcast_arrays(
        np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    )
    return np.stack([x, y, z], -1)


def brdf_values(model: Model, wi: Floats, wo: Floats, cosine: bool) -> Floats:
    """Values for directions, times the cosine or not, in double precision."""
    f = np.asarray(model.eval(wi, wo), np.float64)
    return f * wi[..., 2:] if cosine else f


def sample_weights(model: Model, theta_o: Floats, channel: str, samples: int) -> Floats:
    """Mean, variance and maximum of the weights of independent samples, shape (len(theta_o), 3).

    A wasted sample counts as weight 0. The same numbers are drawn for every model and angle.
    """
    found = []
    for wo in direction(theta_o).astype(np.float32):
        rng = np.random.default_rng(0)
        done, mean, spread, highest = 0, 0.0, 0.0, 0.0
        while done < samples:
            u = rng.random((min(BATCH, samples - done), 2), np.float32)
            wi, pdf = model.sample(wo, u)
            f_cos = choose_channel(model.eval(wi, wo), channel) * wi[..., 2]
            weight = np.where(pdf > 0, f_cos / np.where(pdf > 0, pdf, 1), 0)
            # Chan's way to join means and squared deviations of two batches
            apart, share = weight.mean() - mean, len(u) / (done + len(u))
            spread += weight.var() * len(u) + apart**2 * done * share
            mean += apart * share
            done += len(u)
            highest = max(highest, float(weight.max()))
        found.append((mean, spread / samples, highest))
    return np.array(found)


def viewer_angles(theta_o: Sequence[float] | float) -> list[float]:
    """The viewer's angles in degrees, or an error unless they lie above the horizon."""
    angles = [float(a) for a in ([theta_o] if isinstance(theta_o, (int, float)) else theta_o)]
    if not angles:
        raise ValueError("theta_o must hold at least one angle.")
    for a in angles:
        if not 0 <= a < 90:
            raise ValueError(
                f"theta_o={a:g} is out of range; allowed is 0 to less than 90 degrees."
            )
    return angles


def light_angles(theta_i: Sequence[float] | float) -> list[float]:
    """The light's angles in degrees, or an error unless they lie above the horizon."""
    angles = [float(a) for a in ([theta_i] if isinstance(theta_i, (int, float)) else theta_i)]
    for a in angles:
        if not 0 <= a < 90:
            raise ValueError(
                f"theta_i={a:g} is out of range; allowed is 0 to less than 90 degrees."
            )
    if not angles:
        raise ValueError("theta_i must hold at least one angle.")
    return angles


def known_channel(channel: str) -> str:
    """The channel, or an error unless it is one of CHANNELS."""
    if channel not in CHANNELS:
        raise ValueError(f"no channel {channel!r}; known are {', '.join(CHANNELS)}.")
    return channel


def choose_channel(values: Floats, channel: str) -> Floats:
    """One number from the colour in the last axis."""
    return np.asarray(values @ np.array(CHANNELS[known_channel(channel)]), np.float64)


def channel_note(values: Floats, channel: str) -> str:
    """The channel's name where the colours are not all grey."""
    grey = np.allclose(values, values[..., :1], rtol=1e-6, atol=1e-9)
    return "" if grey else channel


def is_grey(model: Model) -> bool:
    """Whether all colours of a model are greys."""
    values = (getattr(model, n) for n in model.fields)
    return all(not isinstance(v, tuple) or len(set(v)) == 1 for v in values)


def rgb_columns(name: str, values: Floats, unit: str) -> dict[str, Floats]:
    """A column for each channel of a quantity."""
    flat = values.reshape(-1, 3)
    return {f"{name} {colour}{unit}": flat[:, i] for i, colour in enumerate(RGB)}


def quantity_symbol(cosine: bool, with_cosine: str, without: str) -> str:
    """What a plot shows, as a formula."""
    return with_cosine if cosine else without


def roughness_parameter(model: Model, along: str | None) -> Parameter | None:
    """The parameter that mean albedos are plotted against, if there is one."""
    names = ROUGHNESS_NAMES if along is None else (along,)
    found = (numeric_parameter(model, name) for name in names)
    return next((declared for declared in found if declared is not None), None)


def numeric_parameter(model: Model, name: str) -> Parameter | None:
    """The parameter of this name, if it is a single number."""
    declared = model.fields.get(name)
    return declared if isinstance(declared, Parameter) and declared.width == 1 else None


def numeric_albedo(model: Model, wo: Floats) -> Floats:
    """Directional albedos by quadrature, whether or not the model has a formula."""

    written: Any = model.written

    class Numeric(written, register=False):  # type: ignore[misc,call-arg]
        albedo = Model.albedo

    return np.asarray(Numeric(**{name: getattr(model, name) for name in model.fields}).albedo(wo))


# A range that spans more than this is shown on a logarithmic axis.
LOG_RATIO = 1000
LOG_LOW, LOG_HIGH = 0.1, 1e4


def is_logarithmic(p: Parameter) -> bool:
    """Whether a parameter's range asks for a logarithmic axis."""
    return p.high - p.low > LOG_RATIO


def swept_values(p: Parameter) -> Floats:
    """Values across a parameter's range, at the axis' even steps."""
    if is_logarithmic(p):
        return np.geomspace(max(p.low, LOG_LOW), min(p.high, LOG_HIGH), 9 if is_slow() else 121)
    return np.linspace(p.low, p.high, 9 if is_slow() else 121)
