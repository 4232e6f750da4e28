"""The kinds of plots: each is a function of models that returns a `Plot`."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.plot.cartesian import cartesian, scattering
from gonio.plot.drawing import draw_albedo, draw_polar, draw_surface
from gonio.plot.errors import error
from gonio.plot.labels import Shown, named
from gonio.plot.numbers import (
    Floats,
    brdf_values,
    channel_note,
    choose_channel,
    direction,
    is_slow,
    numeric_albedo,
    quantity_symbol,
    rgb_columns,
    roughness_parameter,
    swept_values,
    viewer_angles,
)
from gonio.plot.output import Plot, check_output
from gonio.plot.sampling import sampling
from gonio.plot.style import curve_styles
from gonio.plot.terms import distribution, fresnel, masking

Columns = dict[str, Any]


def plot(
    models: Shown,
    kind: str = "polar",
    output: str | Path = "plot.png",
    *,
    dpi: int = 200,
    **settings: Any,
) -> Path:
    """Plot models to a .png, .svg, .pdf or .csv file and return its path.

    Args:
        models: one or more models or materials whose parameters are numbers, not arrays.
        kind: one of `KINDS`, such as "polar"; see the functions of these names, which take the
            further settings, such as theta_o=(0, 60).
        output: the file; an existing one is replaced.
        dpi: dots per inch of a PNG.

    Raises:
        ValueError: an unknown kind, suffix or setting.
        OSError: the file cannot be written.
    """
    if kind not in KINDS:
        raise ValueError(f"no plot {kind!r}; known are {', '.join(KINDS)}.")
    check_output(output)  # before the work, not after
    allowed = KINDS[kind].__kwdefaults__ or {}
    for name in settings:
        if name not in allowed:
            raise ValueError(f"the {kind} plot has no {name}; it takes {', '.join(allowed)}.")
    return KINDS[kind](models, **settings).save(output, dpi)


def polar(
    models: Shown,
    *,
    theta_o: Sequence[float] | float = (0, 30, 60, 80),
    phi: float = 0,
    cosine: bool = True,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Slices through the lobes in a plane through the normal: f cos(theta_i) against theta_i.

    Args:
        models: the models, one curve each.
        theta_o: polar angles of the viewer in degrees, 0 to 90, one panel each.
        phi: azimuth of the plane's positive side, in degrees from the viewer; 0 is the plane of
            incidence.
        cosine: False plots f alone.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.

    theta_i is signed: positive on the side of phi, which is the viewer's for 0; negative on the other.
    """
    models, labels, shared = named(models)
    angles = viewer_angles(theta_o)
    if not isinstance(phi, (int, float)):
        raise ValueError("the polar plot takes one plane phi; the cartesian one takes several.")
    theta_i = np.linspace(-90, 90, 361)
    wi = direction(theta_i, phi)
    values = np.stack(
        [[brdf_values(m, wi, direction(a), cosine) for a in angles] for m in models]
    )  # model, theta_o, theta_i, rgb
    columns: Columns = {
        "model": np.repeat(labels, len(angles) * len(theta_i)).tolist(),
        "theta_o [deg]": np.tile(np.repeat(angles, len(theta_i)), len(models)),
        "theta_i [deg]": np.tile(theta_i, len(models) * len(angles)),
        **rgb_columns(quantity_symbol(cosine, "f_cos", "f"), values, " [1/sr]"),
    }
    draw = functools.partial(
        draw_polar,
        labels,
        curve_styles(models),
        shared,
        angles,
        float(phi),
        theta_i,
        choose_channel(values, channel),
        cosine,
        channel_note(values, channel),
        title,
    )
    return Plot(columns, draw)


def albedo(
    models: Shown,
    *,
    along: str | None = None,
    dots: bool = False,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Directional albedo against the viewer's angle, and mean albedo against the roughness.

    Args:
        models: the models, one curve each.
        along: the parameter that the mean albedo is plotted against; by default a model's
            roughness, sigma, alpha or shininess. Models without it are drawn as a level line.
        dots: draw dots for albedos that a quadrature finds, beside the models' own formulas.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = named(models)
    theta_o = np.linspace(0, 90, 19 if is_slow() else 181)
    wo = direction(theta_o)
    directional = np.stack([m.albedo(wo) for m in models]).astype(np.float64)
    parameters = [roughness_parameter(m, along) for m in models]
    if along is not None and not any(parameters):
        raise ValueError(f"none of the models has a number {along!r} to plot along.")
    axes = {p.name: p for p in parameters if p is not None}
    sweeps: list[tuple[str, Floats, Floats]] = []
    for m, p in zip(models, parameters, strict=True):
        if p is None:
            sweeps.append(("", np.empty(0), np.empty((0, 3))))
            continue
        x = swept_values(p)
        sweeps.append((p.name, x, np.asarray(m.replace(**{p.name: x}).mean_albedo())))
    means = np.stack([m.mean_albedo() for m in models]).astype(np.float64)

    rows: list[tuple[str, str, str, float, Floats]] = []
    for label, curve, (name, x, mean), own in zip(labels, directional, sweeps, means, strict=True):
        rows += [
            (label, "directional", "theta_o [deg]", *r) for r in zip(theta_o, curve, strict=True)
        ]
        rows += [(label, "mean", name, *r) for r in zip(x, mean, strict=True)]
        rows += [(label, "mean", "", math.nan, own)]
    rgb = np.array([r[4] for r in rows])
    columns: Columns = {
        "model": [r[0] for r in rows],
        "albedo": [r[1] for r in rows],
        "against": [r[2] for r in rows],
        "x": [r[3] for r in rows],
        **rgb_columns("albedo", rgb, ""),
    }
    note = channel_note(directional, channel)
    sparse = np.linspace(0, 87.5, 8 if is_slow() else 15)
    found = (
        [
            (sparse, choose_channel(np.asarray(numeric_albedo(m, direction(sparse))), channel))
            for m in models
        ]
        if dots
        else []
    )
    # Models that differ only in the swept parameter share one mean curve.
    families = [
        repr(m.replace(**{p.name: p.default})) if p else repr(m)
        for m, p in zip(models, parameters, strict=True)
    ]
    draw = functools.partial(
        draw_albedo,
        models,
        labels,
        curve_styles(models),
        shared,
        axes,
        families,
        theta_o,
        choose_channel(directional, channel),
        found,
        [(name, x, choose_channel(mean, channel)) for name, x, mean in sweeps],
        choose_channel(means, channel),
        note,
        title,
    )
    return Plot(columns, draw)


def surface(
    models: Shown,
    *,
    theta_o: Sequence[float] | float = 60,
    cosine: bool = True,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Lobes as shaded surfaces in space, with the normal, the viewer and the mirror direction.

    Args:
        models: the models, one panel each for every angle.
        theta_o: polar angles of the viewer in degrees, 0 to 90.
        cosine: the distance from the origin is f cos(theta_i); False makes it f.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = named(models)
    angles = viewer_angles(theta_o)
    theta_i = np.linspace(0, 90, 91)
    phi = np.linspace(0, 360, 181)
    wi = direction(theta_i[:, None], phi[None, :])
    values = np.stack(
        [[brdf_values(m, wi, direction(a), cosine) for a in angles] for m in models]
    )  # model, theta_o, theta_i, phi, rgb
    count = len(models) * len(angles)
    columns: Columns = {
        "model": np.repeat(labels, len(angles) * theta_i.size * phi.size).tolist(),
        "theta_o [deg]": np.tile(np.repeat(angles, theta_i.size * phi.size), len(models)),
        "theta_i [deg]": np.tile(np.repeat(theta_i, phi.size), count),
        "phi_i - phi_o [deg]": np.tile(phi, theta_i.size * count),
        **rgb_columns(quantity_symbol(cosine, "f_cos", "f"), values, " [1/sr]"),
    }
    draw = functools.partial(
        draw_surface,
        labels,
        curve_styles(models),
        shared,
        angles,
        wi,
        choose_channel(values, channel),
        cosine,
        channel_note(values, channel),
        title,
    )
    return Plot(columns, draw)


KINDS: dict[str, Callable[..., Plot]] = {
    "polar": polar,
    "cartesian": cartesian,
    "surface": surface,
    "scattering": scattering,
    "albedo": albedo,
    "error": error,
    "distribution": distribution,
    "masking": masking,
    "fresnel": fresnel,
    "sampling": sampling,
}
