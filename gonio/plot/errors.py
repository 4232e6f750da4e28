"""Plots of how far models are from one another: what a fit costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gonio.plot.labels import Shown, named
from gonio.plot.numbers import (
    Floats,
    brdf_values,
    channel_note,
    choose_channel,
    direction,
    is_slow,
    rgb_columns,
    viewer_angles,
)
from gonio.plot.output import Plot
from gonio.plot.panels import DEGREES, SIGNED, Curve, Panel, draw_panels
from gonio.plot.style import curve_styles


def error(
    models: Shown,
    *,
    theta_o: Sequence[float] | float = (0, 60, 80),
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """How far models are from the first one, in percent of it: albedos and values.

    Args:
        models: the one that is right, and those that stand for it, such as eon and eon:albedo_form=fitted.
        theta_o: polar angles of the viewer in degrees, one panel each.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = named(models)
    if len(models) < 2:
        raise ValueError("the error plot needs at least two models; the first one is right.")
    theta = np.linspace(0, 89.9, 19 if is_slow() else 181)
    albedos = np.stack([m.albedo(direction(theta)) for m in models]).astype(np.float64)
    views = viewer_angles(theta_o)
    signed = np.linspace(-89.9, 89.9, 361)
    values = np.stack(
        [[brdf_values(m, direction(signed), direction(v), False) for v in views] for m in models]
    )
    albedo_error, value_error = _percent(albedos), _percent(values)
    count = len(models) - 1
    x = np.concatenate([theta, np.tile(signed, len(views))])
    both = np.concatenate(
        [albedo_error, value_error.reshape(count, -1, 3)], axis=1
    )  # model, place, rgb
    what = ["albedo"] * theta.size + [f"f, theta_o = {v:g}" for v in views for _ in signed]
    columns: dict[str, Any] = {
        "model": np.repeat(labels[1:], x.size).tolist(),
        "of": what * count,
        "theta [deg]": np.tile(x, count),
        **rgb_columns("error", both, " [%]"),
    }
    shown = choose_channel(albedo_error, channel), choose_channel(value_error, channel)

    def draw() -> Any:
        zero = [(0.0, "")]
        panels = [
            Panel(
                "directional albedo",
                r"angle of the viewer $\theta_o$  [degrees]",
                "error  [%]",
                [Curve(i + 1, theta, shown[0][i]) for i in range(count)],
                scale=DEGREES,
                lines=zero,
            )
        ]
        panels += [
            Panel(
                rf"$f$, $\theta_o$ = {view:g}°",
                r"angle of the light $\theta_i$  [degrees]",
                "error  [%]",
                [Curve(i + 1, signed, shown[1][i, v]) for i in range(count)],
                scale=SIGNED,
                lines=zero,
            )
            for v, view in enumerate(views)
        ]
        facts = (f"the first one is right: {labels[0]}", shared, channel_note(albedos, channel))
        across = 2 if len(panels) in (2, 4) else 3
        styles = curve_styles(models)
        return draw_panels(
            panels, labels, styles, title or "Difference from the first model", facts, across=across
        )

    return Plot(columns, draw)


def _percent(values: Floats) -> Floats:
    """Of all but the first, relative to the first; 0 where that is 0."""
    right = values[0]
    apart = values[1:] - right
    return np.asarray(100 * np.divide(apart, right, out=0 * apart, where=np.abs(right) > 1e-12))
