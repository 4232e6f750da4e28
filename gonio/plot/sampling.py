"""Plots of how well samplers fit: variance, maximum and mean of the Monte Carlo weight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gonio.model import Model
from gonio.plot.labels import Shown, named
from gonio.plot.numbers import (
    SAMPLES_COMPILED,
    SAMPLES_SCALAR,
    Floats,
    is_grey,
    is_slow,
    known_channel,
    numeric_parameter,
    sample_weights,
    swept_values,
    viewer_angles,
)
from gonio.plot.output import Plot
from gonio.plot.panels import DEGREES, Curve, Panel, draw_panels
from gonio.plot.style import curve_styles

# Angles of the viewer, closer where grazing views make samplers fail.
ANGLES = (*range(0, 78, 6), *range(78, 89, 2), 89.0, 89.5, 89.9)

# Places along a parameter: evenly, and again in its lowest tenth.
PLACES = 21

# Rounding of float32 leaves this much variance in weights that do not vary.
VARIANCE_FLOOR = 1e-10

STATISTICS = ("mean", "variance", "maximum")


def sampling(
    models: Shown,
    *,
    along: str | None = None,
    theta_o: Sequence[float] | float | None = None,
    samples: int | None = None,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Variance, maximum and mean of the weight f cos(theta_i) / pdf, against theta_o or a parameter.

    Args:
        models: the models, one curve each; samplers are compared as options of a model.
        along: a parameter, such as roughness, for the axis in place of theta_o.
        theta_o: with `along`, polar angles of the viewer in degrees, a row of panels each; default 75.
        samples: how many are drawn for each point; default a million, as in the EON paper.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.

    A wasted sample counts as weight 0. The maximum is that of the samples drawn: where a density goes
    to 0 before the BRDF does, as that of CLTC alone, weights have no bound, and more samples find more.
    """
    models, labels, shared = named(models)
    known_channel(channel)
    if samples is None:
        samples = SAMPLES_SCALAR if is_slow() else SAMPLES_COMPILED
    if samples < 1:
        raise ValueError(f"samples={samples} is out of range; allowed is at least 1.")
    if along is None:
        if theta_o is not None:
            raise ValueError("theta_o goes with along: without it the viewer's angle is the axis.")
        x = np.array(ANGLES, np.float64)
        rows = [("", [x] * len(models), _against_angle(models, x, channel, samples))]
        name, columns_of = r"angle of the viewer $\theta_o$  [degrees]", "theta_o [deg]"
    else:
        places = [_places(m, along) for m in models]
        name = columns_of = along
        rows = [
            (
                rf"$\theta_o$ = {view:g}°",
                places,
                [
                    np.concatenate(
                        [
                            sample_weights(
                                m.replace(**{along: float(v)}), np.array([view]), channel, samples
                            )
                            for v in x
                        ]
                    )
                    for m, x in zip(models, places, strict=True)
                ],
            )
            for view in viewer_angles(75 if theta_o is None else theta_o)
        ]
    columns: dict[str, Any] = {"model": [], columns_of: []}
    if along is not None:
        columns["row"] = []
    for statistic in STATISTICS:
        columns[f"{statistic} of weight, {channel}"] = []
    for row, xs, found in rows:
        for label, x, statistics in zip(labels, xs, found, strict=True):
            columns["model"] += [label] * len(x)
            columns[columns_of] += x.tolist()
            if along is not None:
                columns["row"] += [row.replace("$", "").replace("\\", "")] * len(x)
            for k, statistic in enumerate(STATISTICS):
                columns[f"{statistic} of weight, {channel}"] += statistics[:, k].tolist()
    note = "" if all(is_grey(m) for m in models) else channel

    def draw() -> Any:
        panels = []
        for row, xs, found in rows:
            panels += _row(row, name, DEGREES if along is None else "", xs, found)
        count = f"{samples:,} samples for each point"
        return draw_panels(
            panels,
            labels,
            curve_styles(models),
            title or r"Weights $f\,\cos\theta_i\,/$pdf of the samplers",
            (shared, note, count),
            across=3,
        )

    return Plot(columns, draw)


def _against_angle(models: Sequence[Model], x: Floats, channel: str, samples: int) -> list[Floats]:
    return [sample_weights(m, x, channel, samples) for m in models]


def _places(model: Model, along: str) -> Floats:
    declared = numeric_parameter(model, along)
    if declared is None:
        raise ValueError(f"{model.name} has no number {along!r} to plot along.")
    values = swept_values(declared)
    even = values[:: max(1, (len(values) - 1) // (PLACES - 1))]
    # Rarely a sampler fails in the middle, but often where the BRDF degenerates.
    low = values[0] + (values[-1] - values[0]) * np.array([1e-4, 1e-3, 0.01, 0.025])
    return np.unique(np.concatenate([even, low]))


def _row(
    row: str, xlabel: str, scale: str, xs: Sequence[Floats], found: Sequence[Floats]
) -> list[Panel]:
    titles = {"variance": "variance", "maximum": "maximum", "mean": "mean"}
    panels = []
    for statistic in ("variance", "maximum", "mean"):
        k = STATISTICS.index(statistic)
        values = [f[:, k] for f in found]
        if statistic == "variance":
            values = [np.maximum(v, VARIANCE_FLOOR) for v in values]
        lowest, highest = min(v.min() for v in values), max(v.max() for v in values)
        log = statistic == "variance" or highest > 10 * max(lowest, 1e-30)
        lines = [(1.0, "")] if statistic == "mean" else []
        ylim: tuple[float | None, float | None] = (None, None)
        if statistic == "mean":  # noise in the fourth digit is not to fill the panel
            ylim = (min(lowest, 0.99) - 0.001, max(highest, 1.002))
            lines = [(1.0, "no bias")] if lowest > 0.5 else []
            log = False
        panels.append(
            Panel(
                f"{titles[statistic]}, {row}" if row else titles[statistic],
                xlabel,
                f"{statistic} of the weight",
                [Curve(i, x, v) for i, (x, v) in enumerate(zip(xs, values, strict=True))],
                scale=scale,
                log=log,
                lines=lines,
                ylim=ylim,
            )
        )
    return panels
