"""Panels with Cartesian axes, side by side: what most kinds of plots are drawn by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gonio.plot.labels import Shown, named
from gonio.plot.numbers import Floats
from gonio.plot.output import Plot
from gonio.plot.style import (
    FAINT,
    INK,
    CurveStyle,
    curve_styles,
    draw_head,
    draw_legend,
    legend_height,
    new_figure,
)

DEGREES = "degrees"
SIGNED = "signed degrees"


@dataclass(frozen=True)
class Curve:
    """One curve of a panel, in the style of a model."""

    model: int
    """Whose style it has."""
    x: Floats
    y: Floats
    part: str = ""
    """What it shows of the model, where a panel shows several things: its dashes say which."""


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    title: str
    xlabel: str
    ylabel: str
    curves: Sequence[Curve]
    dots: Sequence[Curve] = ()
    """Numbers from elsewhere that the curves should meet."""
    scale: str = ""
    """Of the x axis: `DEGREES`, `SIGNED`, "log", or "" for the values' own range."""
    log: bool = False
    """Whether the y axis is logarithmic."""
    lines: Sequence[tuple[float, str]] = ()
    """Levels to mark, each with its name."""
    floor: float | None = None
    """The lowest value that a logarithmic axis shows."""
    ylim: tuple[float | None, float | None] = (None, None)
    marks: Sequence[tuple[float, str]] = field(default=())
    """Places along x to mark, each with its name."""


def of_panels(panels: Sequence[Panel], models: Shown, title: str) -> Plot:
    """A plot of panels made elsewhere, whose curves belong to models.

    For curves that no kind of plot has.
    """
    models, labels, shared = named(models)
    curves = [(panel, curve) for panel in panels for curve in panel.curves]
    columns = {
        "panel": [panel.title for panel, curve in curves for _ in curve.x],
        "model": [labels[curve.model] for _, curve in curves for _ in curve.x],
        "part": [curve.part for _, curve in curves for _ in curve.x],
        "x": np.concatenate([curve.x for _, curve in curves]),
        "y": np.concatenate([curve.y for _, curve in curves]),
    }

    def draw() -> Any:
        return draw_panels(panels, labels, curve_styles(models), title, (shared,))

    return Plot(columns, draw)


# How the parts of a model are told apart: the whole is a full line.
PART_DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (7, 2, 1.5, 2)))


def draw_panels(
    panels: Sequence[Panel],
    labels: list[str],
    choose_styles: Callable[[], list[CurveStyle]],
    title: str,
    facts: Sequence[str],
    across: int | None = None,
    share_y: bool = False,
) -> Any:
    """A figure of panels, with one legend for the models and one for their parts."""
    styles = choose_styles()
    across = across or min(len(panels), 3)
    down = -(-len(panels) // across)
    width = 4.6 * across + 0.8 if across > 1 else 6.8
    parts = list(dict.fromkeys(c.part for panel in panels for c in panel.curves if c.part))
    named = [*labels, *parts]
    height = 3.9 if across > 1 else 4.4
    figure = new_figure(width, height * down + 0.5 + legend_height(width, named))
    axes = figure.subplots(down, across, squeeze=False, sharey=share_y).ravel()
    for place, (axis, panel) in enumerate(zip(axes, panels, strict=False)):
        _draw(axis, panel, styles, parts)
        if share_y and place % across:
            axis.set_ylabel("")
    for axis in axes[len(panels) :]:
        axis.axis("off")
    handles = [_handle(**s.line()) for s in styles]
    handles += [_handle(color=INK, linestyle=_dashes(part, parts)) for part in parts]
    if parts:  # dashes tell the parts, so that the models have colours alone
        handles[: len(styles)] = [_handle(color=s.colour, linestyle="-") for s in styles]
    draw_head(figure, title, facts)
    draw_legend(figure, handles, named)
    return figure


def _handle(**line: Any) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], **line)


def _dashes(part: str, parts: list[str]) -> Any:
    return PART_DASHES[parts.index(part) % len(PART_DASHES)]


def _draw(axis: Any, panel: Panel, styles: list[CurveStyle], parts: list[str]) -> None:
    for curve in panel.curves:
        line = styles[curve.model].line()
        if curve.part:
            line["linestyle"] = _dashes(curve.part, parts)
        axis.plot(curve.x, curve.y, **line)
    for dots in panel.dots:
        colour = styles[dots.model].colour
        axis.plot(dots.x, dots.y, "o", ms=4.5, mec="white", mew=0.7, color=colour, zorder=4)
    axis.set(title=panel.title, xlabel=panel.xlabel, ylabel=panel.ylabel)
    if panel.scale == "log":
        axis.set_xscale("log")
    elif panel.scale == DEGREES:
        axis.set(xlim=(0, 90), xticks=range(0, 91, 15))
    elif panel.scale == SIGNED:
        axis.set(xlim=(-90, 90), xticks=range(-90, 91, 30))
    else:
        axis.margins(x=0)
    if panel.log:
        axis.set_yscale("log")
    axis.set_ylim(*panel.ylim)
    if panel.floor is not None:
        # matplotlib would leave a margin of a share of all decades, and values may have hundreds
        highest = max(float(np.nanmax(curve.y)) for curve in panel.curves)
        axis.set_ylim(panel.floor, 2 * highest)
    for level, name in panel.lines:
        axis.axhline(level, color=FAINT, lw=0.9, zorder=1)
        axis.annotate(
            name,
            (0.02, level),
            (0, 2),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            color=FAINT,
            fontsize=8.5,
        )
    for x, name in panel.marks:
        axis.axvline(x, color=FAINT, lw=0.9, ls=(0, (1, 2)), zorder=1)
        axis.annotate(
            name,
            (x, 1),
            (3, -3),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            va="top",
            color=FAINT,
            fontsize=8.5,
        )
