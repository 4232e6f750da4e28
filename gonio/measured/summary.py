"""What `gonio data` says about a file: as lines for people, and as plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from gonio.measured.measurement import Measurement
from gonio.measured.quality import Quality, Spread
from gonio.measured.spectra import to_rgb

# Lines of metadata that are shown; files have whole essays.
SHOWN = 12


def lines(measured: Measurement, q: Quality, others: list[str]) -> Iterator[str]:
    """Lines for a terminal: what it is, what it covers, how good it is.

    Args:
        measured: a measurement.
        q: its quality.
        others: the names of the file's other parts.
    """
    kind = "isotropic" if measured.isotropic else "anisotropic"
    yield f"{measured.title}: {measured.format}, {kind} {measured.part}"
    for name, value in list(measured.metadata.items())[:SHOWN]:
        yield f"  {name:<14} {_cut(value, 90)}"
    if others:
        yield f"  {'also inside':<14} {', '.join(others)} (--part NAME)"
    yield f"  {'values':<14} {_shape(measured)}, {measured.units}"
    yield f"  {'spectrum':<14} {spectrum(measured)}"
    yield f"  {'covers':<14} {coverage(q)}"
    yield f"  {'holes':<14} {holes(q)}"
    yield f"  {'range':<14} {_range(q)}"
    yield f"  {'noise':<14} {_spread(q.noise, 'of values from the plane through those around them')}"
    yield f"  {'reciprocity':<14} {_spread(q.reciprocity, 'when the directions are swapped')}"
    what = "in the mirror image" if measured.isotropic else "when the sample turns"
    yield f"  {'symmetry':<14} {_spread(q.symmetry, what)}"
    yield from _albedos(q)
    for note in measured.notes:
        yield f"  {'note':<14} {note}"


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else text[: most - 3] + "..."


def _shape(measured: Measurement) -> str:
    if measured.grid:
        axes = " x ".join(f"{name} {count}" for name, count in measured.grid.items())
        return f"{len(measured.values)} places ({axes}) of {_channels(measured)}"
    return f"{len(measured.values)} loose points of {_channels(measured)}"


def _channels(measured: Measurement) -> str:
    count = len(measured.channels)
    if measured.wavelengths is not None and count > 1:
        return f"{count} wavelengths"
    return measured.channels[0] if count == 1 else ", ".join(measured.channels[:6])


def spectrum(measured: Measurement) -> str:
    """Which wavelengths or colours there are, and how they become RGB."""
    how = to_rgb(measured, np.ones((1, len(measured.channels))))[1]
    w = measured.wavelengths
    if w is None:
        text = _channels(measured)
        return text if how == "as in the file" else f"{text}; RGB: {how}"
    steps = np.diff(w)
    step = ""
    if steps.size:
        even = np.ptp(steps) < 1e-3 * steps.mean()
        step = f" in steps of {steps.mean():.3g}" if even else f", {len(w)} places"
    return f"{w[0]:g} to {w[-1]:g} nm{step}; RGB: {how}"


def coverage(q: Quality) -> str:
    """The angles that a measurement has."""
    text = (
        f"light {q.theta_i[0]:.1f}° to {q.theta_i[1]:.1f}° ({q.incidences} directions), "
        f"detector {q.theta_o[0]:.1f}° to {q.theta_o[1]:.1f}°"
    )
    if not math.isnan(q.from_mirror):
        text += f"; half vectors from {max(round(q.from_mirror, 3), 0):g}° on; "
        text += f"{q.covered:.0%} of all pairs are near a value"
    return text


def holes(q: Quality) -> str:
    """How much is missing."""
    above = q.used + q.holes
    text = "none" if q.holes == 0 else f"{q.holes} of {above} places above the horizon"
    text += f" ({q.holes / above:.1%})" if q.holes else ""
    if q.extrapolated:
        text += f"; {q.extrapolated} values ({q.extrapolated / q.used:.1%}) are extrapolated"
    return text


def _range(q: Quality) -> str:
    i, o, apart = q.brightest
    text = (
        f"{q.lowest:.4g} to {q.largest:.4g}, brightest at theta_i {i:.1f}°, theta_o {o:.1f}°, "
        f"{apart:.0f}° apart"
    )
    if q.negative:
        text += f"; {q.negative} places ({q.negative / q.used:.1%}) below 0"
    return text


def _spread(spread: Spread, what: str) -> str:
    if spread.count == 0:
        return "cannot be told from this file"
    return f"{spread.median:.2%} in the middle, {spread.high:.2%} at 19 of 20 places, {what}"


def _albedos(q: Quality) -> Iterator[str]:
    if not q.albedos:
        return
    byangle: dict[float, float] = {}
    for a in q.albedos:
        byangle[a.theta] = max(byangle.get(a.theta, 0), a.all)
    shown = ", ".join(f"{t:.0f}°: {v:.3f}" for t, v in byangle.items() if t in {0, 30, 60, 75, 85})
    yield f"  {'albedo':<14} {shown} (largest channel, holes filled by what is near)"


def data(measured: Measurement, q: Quality) -> dict[str, Any]:
    """The same as plain data that JSON can hold."""
    return {
        "title": measured.title,
        "format": measured.format,
        "part": measured.part,
        "isotropic": measured.isotropic,
        "channels": list(measured.channels),
        "wavelengths": None if measured.wavelengths is None else measured.wavelengths.tolist(),
        "units": measured.units,
        "grid": dict(measured.grid),
        "metadata": dict(measured.metadata),
        "notes": list(measured.notes),
        "quality": _plain(asdict(q)),
    }


def _plain(value: Any) -> Any:
    """NaN, which JSON does not have, as nothing."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
