"""Plots of values on Cartesian axes: slices through lobes, tails, azimuths, and orders of scattering."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.model import Model
from gonio.plot.labels import Shown, named
from gonio.plot.numbers import (
    Floats,
    brdf_values,
    channel_note,
    choose_channel,
    direction,
    light_angles,
    quantity_symbol,
    rgb_columns,
    viewer_angles,
)
from gonio.plot.output import Plot
from gonio.plot.panels import SIGNED, Curve, Panel, draw_panels
from gonio.plot.style import curve_styles

# A logarithmic axis ends this far below the largest value.
DECADES = 1e-6

AXES = ("degrees", "cosine")


@dataclass(frozen=True)
class _Cuts:
    """Directions of the light that are shown: slices of the hemisphere, with one axis for all."""

    slices: list[tuple[str, float, Floats]]
    """What a slice is called, its angle, and the directions in it."""
    fixed: str
    """Of which a slice has one angle."""
    varied: str
    """Of which it has all `angles`."""
    angles: Floats
    x: Floats
    """Where they stand on the axis."""
    label: str
    scale: str


def _planes(phi: Sequence[float] | float, axis: str) -> _Cuts:
    """Planes through the normal, by their azimuths."""
    turns = [float(p) for p in ([phi] if isinstance(phi, (int, float)) else phi)]
    angles = np.linspace(-90, 90, 361)
    slices = [(f"phi = {t:g}°", t, direction(angles, t)) for t in turns]
    if len(turns) == 1 and turns[0] == 0:
        slices = [("", 0.0, direction(angles))]
    x, label, scale = angles, "angle of the light $\\theta_i$  [degrees]", SIGNED
    if axis == "cosine":
        x = np.sign(angles) * np.cos(np.radians(angles))
        label, scale = "cosine of the light, negative away from the viewer", ""
    return _Cuts(slices, "phi [deg]", "theta_i [deg]", angles, x, label, scale)


def _circles(theta_i: Sequence[float] | float) -> _Cuts:
    """Circles about the normal, by the angles of the light."""
    angles = np.linspace(0, 360, 361)
    slices = [(rf"$\theta_i$ = {t:g}°", t, direction(t, angles)) for t in light_angles(theta_i)]
    label = "azimuth of the light from the viewer's  [degrees]"
    return _Cuts(slices, "theta_i [deg]", "phi_i - phi_o [deg]", angles, angles, label, "")


def cartesian(
    models: Shown,
    *,
    theta_o: Sequence[float] | float = (0, 30, 60, 80),
    phi: Sequence[float] | float = 0,
    theta_i: Sequence[float] | float | None = None,
    axis: str = "degrees",
    cosine: bool = True,
    log: bool = False,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Values in any plane through the normal, on Cartesian axes: f cos(theta_i) against theta_i.

    Args:
        models: the models, one curve each.
        theta_o: polar angles of the viewer in degrees; a panel for each, and for each of the next two.
        phi: the plane: azimuth of its positive side, in degrees from the viewer. 0 is the plane of
            incidence, 90 the one across.
        theta_i: polar angles of the light in degrees; if given, the light turns about the normal at
            these angles, and its azimuth is the axis, in place of planes.
        axis: "degrees", or "cosine" for the signed cosine, negative on the side away from the viewer.
        cosine: False plots f alone.
        log: a logarithmic axis of values.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.

    theta_i is signed: positive on the side of `phi`, negative on the other.
    """
    models, labels, shared = named(models)
    if axis not in AXES:
        raise ValueError(f"axis={axis!r} is not known; allowed are {', '.join(AXES)}.")
    views = viewer_angles(theta_o)
    if theta_i is not None and axis == "cosine":
        raise ValueError("axis='cosine' goes with planes, not with theta_i.")
    cuts = _planes(phi, axis) if theta_i is None else _circles(theta_i)
    slices = cuts.slices
    values = np.stack(
        [
            [[brdf_values(m, wi, direction(view), cosine) for _, _, wi in slices] for view in views]
            for m in models
        ]
    )  # model, view, slice, angle, rgb
    count = len(models) * len(views)
    each = np.repeat([at for _, at, _ in slices], cuts.angles.size)
    told = {
        "model": np.repeat(labels, values[0].size // 3).tolist(),
        "theta_o [deg]": np.tile(np.repeat(views, each.size), len(models)),
        cuts.fixed: np.tile(each, count),
        cuts.varied: np.tile(cuts.angles, count * len(slices)),
        **rgb_columns(quantity_symbol(cosine, "f_cos", "f"), values, " [1/sr]"),
    }
    shown = choose_channel(values, channel)

    def draw() -> Any:
        label = f"{_symbol(cosine)}  [1/sr]"
        panels = []
        for v, view in enumerate(views):
            for s, (what, _, _) in enumerate(slices):
                curves = [
                    Curve(m, *_split(cuts.x, shown[m, v, s], axis)) for m in range(len(models))
                ]
                at = rf"$\theta_o$ = {view:g}°"
                high = float(shown[:, v, s].max())
                panels.append(
                    Panel(
                        f"{at}, {what}" if what else at,
                        cuts.label,
                        label,
                        curves,
                        scale=cuts.scale,
                        log=log,
                        floor=DECADES * high if log else None,
                        ylim=(None if log or shown.min() < 0 else 0, None),
                        marks=[(view, "viewer"), (-view, "mirror")]
                        if cuts.scale == SIGNED and view > 0 and slices[s][1] == 0
                        else [],
                    )
                )
        return draw_panels(
            panels,
            labels,
            curve_styles(models),
            title or f"{_symbol(cosine)} against the direction of the light",
            (shared, channel_note(values, channel)),
            across=2 if len(panels) in (2, 4) else None,
        )

    return Plot(told, draw)


def _split(x: Floats, y: Floats, axis: str) -> tuple[Floats, Floats]:
    """Against the cosine the two sides meet at +-1, not at 0: a gap keeps them apart."""
    if axis != "cosine":
        return x, y
    middle = int(np.searchsorted(x > 0, True))
    return np.insert(x, middle, np.nan), np.insert(y, middle, np.nan)


def _symbol(cosine: bool) -> str:
    return r"$f\,\cos\theta_i$" if cosine else "$f$"


def scattering(
    models: Shown,
    *,
    theta_o: Sequence[float] | float = (0, 30, 60, 80),
    cosine: bool = True,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """What a model scatters once, and more often, apart, in the plane of incidence.

    Args:
        models: models that know their single scattering, such as EON (`single_scattering`).
        theta_o: polar angles of the viewer in degrees, one panel each.
        cosine: False plots f alone.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = named(models)
    views = viewer_angles(theta_o)
    angles = np.linspace(-90, 90, 361)
    wi = direction(angles)
    singles = [single_scattering(m) for m in models]

    def over(some: Sequence[Model]) -> Floats:
        return np.stack([[brdf_values(m, wi, direction(v), cosine) for v in views] for m in some])

    whole, once = over(models), over(singles)
    symbol = quantity_symbol(cosine, "f_cos", "f")
    told = {
        "model": np.repeat(labels, len(views) * angles.size).tolist(),
        "theta_o [deg]": np.tile(np.repeat(views, angles.size), len(models)),
        "theta_i [deg]": np.tile(angles, len(models) * len(views)),
        **rgb_columns(f"{symbol}, all,", whole, " [1/sr]"),
        **rgb_columns(f"{symbol}, single,", once, " [1/sr]"),
        **rgb_columns(f"{symbol}, multiple,", whole - once, " [1/sr]"),
    }
    parts = {
        "all": choose_channel(whole, channel),
        "single scattering": choose_channel(once, channel),
        "multiple scattering": choose_channel(whole - once, channel),
    }

    def draw() -> Any:
        panels = [
            Panel(
                rf"$\theta_o$ = {view:g}°",
                r"angle of the light $\theta_i$  [degrees]",
                f"{_symbol(cosine)}  [1/sr]",
                [
                    Curve(m, angles, values[m, v], part)
                    for m in range(len(models))
                    for part, values in parts.items()
                ],
                scale=SIGNED,
                ylim=(0, None),
            )
            for v, view in enumerate(views)
        ]
        return draw_panels(
            panels,
            labels,
            curve_styles(models),
            title or "Single and multiple scattering",
            (shared, channel_note(whole, channel)),
            across=2 if len(panels) in (2, 4) else None,
        )

    return Plot(told, draw)


def single_scattering(model: Model) -> Model:
    """The model of what is scattered once, or a ValueError if the model does not know it."""
    single: Callable[[], Model] | None = getattr(model, "single_scattering", None)
    if single is None:
        raise ValueError(
            f"{model.name} does not tell single scattering from multiple; eon does, for example."
        )
    return single()
