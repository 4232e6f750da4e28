"""Plots of what models are made of: D and G of facets, F of surfaces and layers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gonio import backend
from gonio.arrays.elementwise import elementwise
from gonio.fields import Parameter
from gonio.lang import vec3
from gonio.model import Model
from gonio.plot.labels import Shown, named
from gonio.plot.numbers import Floats, choose_channel, direction, light_angles, rgb_columns
from gonio.plot.output import Plot
from gonio.plot.panels import DEGREES, SIGNED, Curve, Panel, draw_panels
from gonio.plot.style import curve_styles

# Logarithmic axes show tails whole that end above the second of these parts of the peak, and others down to
# the first: GGX's fall by alpha^4, Beckmann's by hundreds of decades.
TAIL, LONG_TAIL = 1e-7, 1e-13


def _bound(model: Model) -> Model:
    """A copy in double precision whose methods take and return the backend's numbers."""
    Float: Any = float if backend.current() == "scalar" else backend.array_module().Float64

    def convert(path: str, declared: Parameter, value: Any) -> Any:
        if declared.width == 1:
            return Float(value)
        return vec3(*(Float(v) for v in (value if isinstance(value, tuple) else (value,) * 3)))

    return model.bind(Float, convert)


def _method(model: Model, name: str, what: str) -> Callable[..., dict[str, Any]]:
    found = getattr(_bound(model), name, None)
    if found is None:
        raise ValueError(
            f"{model.name} has no {what} of its own to plot; torrance_sparrow has, for example."
        )
    method: Callable[..., dict[str, Any]] = found
    return method


def facet_terms(model: Model, wi: Floats, wo: Floats) -> dict[str, Floats]:
    """D and G of a model of facets for directions (..., 3), in double precision.

    Raises:
        ValueError: a model without them.
    """
    method = _method(model, "facet_terms", "facets")
    wi, wo = np.broadcast_arrays(wi, wo)
    parts = [w[..., i] for w in (wi, wo) for i in range(3)]

    def at(name: str) -> Callable[..., Any]:
        return lambda a, b, c, d, e, f: method(vec3(a, b, c), vec3(d, e, f))[name]

    return {name: elementwise(at(name), *parts) for name in ("D", "G")}


def reflectances(model: Model, cos_theta: Floats) -> dict[str, Floats]:
    """What a model's surfaces reflect and transmit at a cosine: names and values (..., 3).

    Raises:
        ValueError: a model without Fresnel terms.
    """
    method = _method(model, "reflectances", "Fresnel terms")
    one = float if backend.current() == "scalar" else backend.array_module().Float64
    names = list(method(one(1.0)))
    black = vec3(one(0), one(0), one(0))

    def at(name: str, i: int) -> Callable[..., Any]:
        def value(c: Any) -> Any:
            found = method(c)[name]
            return (found + 0 * black)[i]  # a number becomes a colour

        return value

    return {
        name: np.stack([elementwise(at(name, i), cos_theta) for i in range(3)], -1)
        for name in names
    }


def distribution(
    models: Shown,
    *,
    log: bool = False,
    title: str | None = None,
) -> Plot:
    """D, the distribution of facets' normals, against their angle; models with facets.

    Args:
        models: such as torrance_sparrow, one curve each.
        log: a logarithmic axis, which shows the tails.
        title: replaces the title.
    """
    models, labels, shared = named(models)
    theta = np.linspace(-89.5 if not log else 0, 89.5, 717 if not log else 359)
    m = direction(theta)
    values = np.stack([facet_terms(model, m, m)["D"] for model in models])
    columns = {
        "model": np.repeat(labels, theta.size).tolist(),
        "theta_m [deg]": np.tile(theta, len(models)),
        "D [1/sr]": values.ravel(),
    }

    def draw() -> Any:
        panel = Panel(
            "",
            r"angle of the facet's normal $\theta_m$  [degrees]",
            "$D$  [1/sr]",
            [Curve(i, theta, y) for i, y in enumerate(values)],
            scale=DEGREES if log else SIGNED,
            log=log,
            floor=_floor(values) if log else None,
            ylim=(None if log else 0, None),
        )
        facts = (shared,)
        return draw_panels([panel], labels, curve_styles(models), title or "Distribution", facts)

    return Plot(columns, draw)


def _floor(values: Floats) -> float:
    """Where a logarithmic axis of distributions, (models, angles), ends."""
    peaks, ends = values.max(axis=1), values[:, -1]
    return float(np.where(ends > LONG_TAIL * peaks, ends / 2, TAIL * peaks).min())


def masking(
    models: Shown,
    *,
    theta_i: Sequence[float] | float | None = None,
    title: str | None = None,
) -> Plot:
    """G, the share of facets that both light and viewer see; models with facets.

    Args:
        models: such as torrance_sparrow, one curve each.
        theta_i: polar angles of the light in degrees, one panel each, with the viewer in the plane of
            incidence; by default one panel for mirror pairs, wo at the angle of wi on the other side.
        title: replaces the title.
    """
    models, labels, shared = named(models)
    if theta_i is None:
        theta = np.linspace(0, 89.9, 300)
        pairs = [("mirror pairs", direction(theta), direction(-theta))]
        scale, name = DEGREES, r"angle of light and viewer  [degrees]"
    else:
        theta = np.linspace(-89.9, 89.9, 600)
        pairs = [
            (rf"$\theta_i$ = {a:g}°", direction(a) + 0 * theta[:, None], direction(theta))
            for a in light_angles(theta_i)
        ]
        scale, name = SIGNED, r"angle of the viewer, on the light's side  [degrees]"
    values = np.stack(
        [[facet_terms(model, wi, wo)["G"] for _, wi, wo in pairs] for model in models]
    )
    columns = {
        "model": np.repeat(labels, len(pairs) * theta.size).tolist(),
        "theta_i [deg]": np.tile(np.concatenate([_polar(wi) for _, wi, _ in pairs]), len(models)),
        "theta_o [deg]": np.tile(theta, len(models) * len(pairs)),
        "G": values.ravel(),
    }

    def draw() -> Any:
        panels = [
            Panel(
                what,
                name,
                "$G$",
                [Curve(i, theta, values[i, k]) for i in range(len(models))],
                scale=scale,
                ylim=(0, None),
            )
            for k, (what, _, _) in enumerate(pairs)
        ]
        return draw_panels(panels, labels, curve_styles(models), title or "Masking", (shared,))

    return Plot(columns, draw)


def _polar(w: Floats) -> Floats:
    return np.asarray(np.degrees(np.arctan2(w[..., 0], w[..., 2])))


def fresnel(
    models: Shown,
    *,
    log: bool = False,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """F against the angle of incidence; of layered models what each surface reflects and lets through.

    Args:
        models: models with Fresnel terms, such as torrance_sparrow, weidlich_wilkie, triace_layered.
        log: a logarithmic axis of values.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = named(models)
    theta = np.linspace(0, 90, 361)
    cosines = np.cos(np.radians(theta))
    found = [reflectances(model, cosines) for model in models]
    rows = [(i, name, values) for i, terms in enumerate(found) for name, values in terms.items()]
    columns = {
        "model": np.repeat([labels[i] for i, _, _ in rows], theta.size).tolist(),
        "term": np.repeat([name for _, name, _ in rows], theta.size).tolist(),
        "theta [deg]": np.tile(theta, len(rows)),
        **rgb_columns("reflectance", np.stack([v for _, _, v in rows]), ""),
    }
    single = len({name for _, name, _ in rows}) == 1

    def draw() -> Any:
        curves = [
            Curve(i, theta, choose_channel(values, channel), "" if single else name)
            for i, name, values in rows
        ]
        panel = Panel(
            "",
            r"angle of incidence $\theta$  [degrees]",
            "reflectance",
            curves,
            scale=DEGREES,
            log=log,
            floor=1e-5 if log else None,
            ylim=(None, None) if log else (0, None),
        )
        note = channel if any(np.ptp(v, axis=-1).max() > 1e-9 for _, _, v in rows) else ""
        facts = (shared, note)
        return draw_panels([panel], labels, curve_styles(models), title or "Fresnel terms", facts)

    return Plot(columns, draw)
