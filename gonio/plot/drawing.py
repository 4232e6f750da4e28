"""The drawings themselves; each takes numbers and returns a matplotlib figure."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gonio.fields import Parameter
from gonio.model import Model
from gonio.plot.numbers import LOG_HIGH, LOG_LOW, Floats, direction, is_logarithmic
from gonio.plot.style import (
    FAINT,
    GRID,
    INK,
    CurveStyle,
    draw_head,
    draw_legend,
    legend_height,
    new_figure,
)

# Half discs have scales of their own where one's lobes would be so much smaller than another's.
UNEVEN = 5


def draw_polar(
    labels: list[str],
    choose_styles: Callable[[], list[CurveStyle]],
    shared: str,
    angles: list[float],
    phi: float,
    theta_i: Floats,
    values: Floats,
    cosine: bool,
    note: str,
    title: str | None,
) -> Any:
    """Slices of lobes through a plane, a half disc for each of the viewer's angles."""
    styles = choose_styles()
    across = 1 if len(angles) == 1 else 2
    down = -(-len(angles) // across)
    panel_width = 5.2 if across > 1 else 6.8
    width = panel_width * across
    figure = new_figure(width, 0.57 * panel_width * down + 0.6 + legend_height(width, labels))
    panels = figure.subplots(down, across, squeeze=False).ravel()
    highest = [float(values[:, k].max()) for k in range(len(angles))]
    uneven = min(highest) * UNEVEN < max(highest)
    theta = np.radians(theta_i)
    handles = []
    for k, (panel, angle) in enumerate(zip(panels, angles, strict=False)):
        ticks = _radial_ticks(highest[k] if uneven else max(highest))
        _half_disc(panel, ticks, angle if phi == 0 else None, _quantity(cosine))
        handles = [
            panel.plot(r * -np.sin(theta), r * np.cos(theta), zorder=4, **s.line())[0]
            for r, s in zip(np.maximum(values[:, k], 0), styles, strict=True)
        ]
        panel.set_title(rf"viewer at $\theta_o$ = {angle:g}°")
    for panel in panels[len(angles) :]:
        panel.axis("off")
    draw_head(
        figure,
        title or f"Lobes {_quantity(cosine)} in the plane {_plane(phi)}",
        (
            shared,
            note,
            _negative_note(values),
            "each viewer has a scale of its own" if uneven else "",
        ),
    )
    draw_legend(figure, handles, labels)
    return figure


def _plane(phi: float) -> str:
    return "of incidence" if phi == 0 else f"{phi:g}° from the viewer's"


def _quantity(cosine: bool) -> str:
    return r"$f\,\cos\theta_i$" if cosine else "$f$"


def _negative_note(values: Floats) -> str:
    # A negative radius would land on the other side of the origin.
    return "negative values are drawn as 0" if values.min() < -1e-9 else ""


def _radial_ticks(high: float) -> Floats:
    """Round radii for rings, the last one at or beyond the largest value."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(nbins=4, steps=[1, 2, 2.5, 5, 10]).tick_values(0, max(high, 1e-6))
    return np.asarray(ticks[ticks > 0], np.float64)


def _half_disc(panel: Any, ticks: Floats, theta_o: float | None, quantity: str) -> None:
    """Rings, spokes and labels of a polar diagram above the surface; +90° is on the left.

    theta_o: the viewer's angle; None if the viewer is not in the plane.
    """
    rim = float(ticks[-1])
    arc = np.radians(np.linspace(-90, 90, 181))
    for r in ticks:
        edge = r == rim
        panel.plot(
            r * np.sin(arc), r * np.cos(arc), color=FAINT if edge else GRID, lw=0.8, zorder=1
        )

    def at_rim(text: str, degrees: float, colour: str) -> None:
        x, y = -math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        side = "center" if abs(x) < 0.1 else "right" if x < 0 else "left"
        place = {"ha": side, "va": "center" if y < 0.9 else "bottom"}
        panel.annotate(
            text,
            (rim * x, rim * y),
            (4 * x, 4 * y if y < 0.9 else 3),
            textcoords="offset points",
            fontsize=9,
            color=colour,
            **place,
        )

    for degrees in range(-90, 91, 30):
        x, y = -math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        panel.plot([0, rim * x], [0, rim * y], color=GRID, lw=0.7, zorder=0)
        if theta_o is None or abs(degrees - theta_o) > 8:  # there the viewer's own label is
            at_rim(f"{degrees}°".replace("-", "−"), degrees, FAINT)
    panel.plot([-rim, rim], [0, 0], color=INK, lw=1.1, zorder=2)
    below = {"xytext": (0, -4), "textcoords": "offset points", "va": "top", "fontsize": 9}
    for r in (0.0, *ticks):
        panel.annotate(f"{r:g}", (-r, 0), ha="center", **below)
    panel.annotate(f"{quantity}  [1/sr]", (rim, 0), ha="right", **below)
    _frame_half_disc(panel, rim)
    if theta_o is None:
        return
    x, y = -math.sin(math.radians(theta_o)), math.cos(math.radians(theta_o))
    arrow = {"arrowstyle": "-|>", "color": INK, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", (rim * x, rim * y), (0, 0), arrowprops=arrow, zorder=3)
    at_rim(r"$\omega_o$", theta_o, INK)
    if theta_o > 0:
        panel.plot([0, -rim * x], [0, rim * y], color=INK, lw=1, ls=(0, (1, 3)), zorder=3)
        side = {"fontsize": 9, "color": FAINT, "va": "top"}
        panel.text(-1.1 * rim, 1.06 * rim, "light on the\nviewer's side\n(retro)", **side)
        panel.text(1.1 * rim, 1.06 * rim, "light opposite\n(mirror, dotted)", ha="right", **side)


def _frame_half_disc(panel: Any, rim: float) -> None:
    panel.set_aspect("equal")
    panel.set_xlim(-1.1 * rim, 1.1 * rim)
    panel.set_ylim(-0.14 * rim, 1.1 * rim)
    panel.axis("off")


def draw_albedo(
    models: list[Model],
    labels: list[str],
    choose_styles: Callable[[], list[CurveStyle]],
    shared: str,
    axes: dict[str, Parameter],
    families: list[str],
    theta_o: Floats,
    directional: Floats,
    dots: Sequence[tuple[Floats, Floats]],
    sweeps: list[tuple[str, Floats, Floats]],
    means: Floats,
    note: str,
    title: str | None,
) -> Any:
    """Directional albedos over the angle, and mean ones over a parameter."""
    styles = choose_styles()
    width = 4.6 + 3.6 * len(axes) if axes else 6.6
    figure = new_figure(width, 4.4 + legend_height(width, labels))
    ratios = [1.25] + [1.0] * len(axes)
    panels = figure.subplots(
        1, len(ratios), sharey=True, squeeze=False, gridspec_kw={"width_ratios": ratios}
    )[0]
    handles = [
        panels[0].plot(theta_o, curve, **s.line())[0]
        for curve, s in zip(directional, styles, strict=True)
    ]
    for (x, y), s in zip(dots, styles, strict=False):
        panels[0].plot(x, y, "o", ms=5, mec="white", mew=0.8, color=s.colour, zorder=4)
    panels[0].set(
        xlabel=r"angle of the viewer $\theta_o$  [degrees]",
        ylabel=f"albedo{f', {note}' if note else ''}",
        title="directional albedo",
        xlim=(0, 90),
        xticks=range(0, 91, 15),
    )
    for panel, (name, p) in zip(panels[1:], axes.items(), strict=True):
        logarithmic = is_logarithmic(p)
        for i, (m, s) in enumerate(zip(models, styles, strict=True)):
            own, x, curve = sweeps[i]
            if not own:
                panel.axhline(means[i], **s.line())
            elif own == name:
                if families.index(families[i]) == i:
                    alone = families.count(families[i]) == 1
                    panel.plot(x, curve, **(s.line() if alone else {"color": FAINT}))
                panel.plot(
                    getattr(m, name),
                    means[i],
                    "o",
                    ms=8,
                    mec="white",
                    color=s.colour,
                    clip_on=False,
                    zorder=5,
                )
        if logarithmic:
            panel.set_xscale("log")
            panel.set_xlim(max(p.low, LOG_LOW), min(p.high, LOG_HIGH))
        else:
            panel.set_xlim(p.low, p.high)
        unit = p.doc.partition(";")[0].partition(",")[2].strip()
        panel.set(
            xlabel=f"{name}  [{unit}]" if unit == "radians" else name,
            title=f"mean albedo against {name}",
        )
        panel.tick_params(labelleft=False)
    _frame_albedo(panels, [directional, means, *(s[2] for s in sweeps)])
    draw_head(figure, title or "Albedo", (shared,))
    draw_legend(figure, handles, labels)
    return figure


def _frame_albedo(panels: Any, values: Sequence[Floats]) -> None:
    """The same height for all panels, with a line where as much is reflected as arrives."""
    low = min(float(v.min()) for v in values if v.size)
    high = max(float(v.max()) for v in values if v.size)
    margin = max(0.06 * (high - low), 0.025)
    panels[0].set_ylim(max(low - margin, 0), high + margin)
    if high > 0.97:
        for panel in panels:
            panel.axhline(1, color=FAINT, lw=0.9, zorder=1)
        panels[0].text(
            1.5, 1, "all light reflected", color=FAINT, fontsize=8.5, va="bottom", ha="left"
        )


def draw_surface(
    labels: list[str],
    choose_styles: Callable[[], list[CurveStyle]],
    shared: str,
    angles: list[float],
    wi: Floats,
    values: Floats,
    cosine: bool,
    note: str,
    title: str | None,
) -> Any:
    """Lobes in space, a model in each row and an angle of the viewer in each column."""
    from matplotlib.figure import Figure

    styles = choose_styles()
    if len(angles) == 1:  # as many models as fit into a row, else a row for each model
        down = -(-len(labels) // 3)
        across = -(-len(labels) // down)
    else:
        down, across = len(labels), len(angles)
    width, head = 4.4 if across > 1 else 6.2, 0.85
    height = 0.84 * width
    total = (width * across, height * down + head)
    figure = Figure(figsize=total)
    ticks = _radial_ticks(float(values.max()))
    for place in range(len(labels) * len(angles)):
        i, k = divmod(place, len(angles))
        row, column = divmod(place, across)
        # A square in the middle of the panel, larger than it is high: the disc is flat.
        # mplot3d draws 1.4 % of the width right of the middle.
        corner = (width * (column - 0.014), total[1] - head - height * (row + 0.48) - width / 2)
        panel = figure.add_axes(
            (corner[0] / total[0], corner[1] / total[1], width / total[0], width / total[1]),
            projection="3d",
            computed_zorder=False,
        )
        panel.patch.set_visible(False)
        _ground_disc(panel, ticks)
        lobe = np.maximum(values[i, k], 0)
        _lobe(panel, lobe[..., None] * wi, styles[i].colour)
        rows = [np.interp(abs(a), (0, 90), (0, len(wi) - 1)) for a in (0.0, angles[k])]
        _arrows(panel, angles[k], float(ticks[-1]), lobe, [round(r) for r in rows])
        for artist in panel.get_children():
            artist.set_clip_on(False)
        angle = rf"$\theta_o$ = {angles[k]:g}°"
        figure.text(
            width * (column + 0.5) / total[0],
            (total[1] - head - height * row - 0.12) / total[1],
            f"{labels[i]},  {angle}" if len(labels) > 1 else angle,
            ha="center",
            va="top",
            fontsize=11,
        )
    name = f"Lobe {_quantity(cosine)} over the directions of the light"
    rings = f"rings at {', '.join(f'{t:g}' for t in ticks)} 1/sr"
    alone = f"{labels[0]}:" if len(labels) == 1 else ""
    facts = (" ".join(t for t in (alone, shared) if t), note, rings, _negative_note(values))
    draw_head(figure, title or name, facts)
    return figure


def _ground_disc(panel: Any, ticks: Floats) -> None:
    rim = float(ticks[-1])
    phi = np.radians(np.linspace(0, 360, 181))
    for r in ticks:
        panel.plot(r * np.cos(phi), r * np.sin(phi), 0, color=FAINT if r == rim else GRID, lw=0.8)
    for degrees in range(0, 180, 30):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        panel.plot([-rim * c, rim * c], [-rim * s, rim * s], [0, 0], color=GRID, lw=0.7)
    panel.set(xlim=(-rim, rim), ylim=(-rim, rim), zlim=(0, rim))
    panel.set_box_aspect((2, 2, 1), zoom=1.3)
    # From the side, so that +x (the viewer) is left, as in the polar plots.
    panel.view_init(elev=20, azim=68)
    panel.set_axis_off()


def _lobe(panel: Any, points: Floats, colour: Any) -> None:
    """A closed surface, shaded; points: shape (theta, phi, 3)."""
    from matplotlib.colors import to_rgb

    across, along = points[1:, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, 1:]
    normal = np.cross(along, across)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    # Light from the upper left, behind the eye. Half Lambert keeps the shadow side readable, and
    # the range from a dark to a pale tone makes even black a shape.
    light = np.array([0.55, 0.45, 0.7]) / np.linalg.norm([0.55, 0.45, 0.7])
    tone = ((normal @ light + 1) / 2)[..., None] ** 1.5
    base = np.array(to_rgb(colour))
    dark, pale = 0.35 * base, 0.45 + 0.55 * base
    panel.plot_surface(
        *np.moveaxis(points, -1, 0),
        rstride=1,
        cstride=1,
        facecolors=(1 - tone) * dark + tone * pale,
        shade=False,
        linewidth=0,
        antialiased=False,
        rasterized=True,
        zorder=2,
    )


def _arrows(panel: Any, theta_o: float, rim: float, lobe: Floats, rows: list[int]) -> None:
    """The normal, the viewer and the mirror direction; faint inside the lobe.

    lobe: the surface's distance from the origin, shape (theta, phi); rows: those of theta = 0 and
    theta_o.
    """
    half_turn = lobe.shape[1] // 2
    arrows = [
        (0.0, lobe[rows[0], 0], "$n$", FAINT, "-"),
        (theta_o, lobe[rows[1], 0], r"$\omega_o$", INK, "-"),
        (-theta_o, lobe[rows[1], half_turn], "mirror", INK, (0, (1, 2))),
    ]
    for degrees, start, name, colour, dashes in arrows if theta_o > 0 else arrows[:2]:
        w = direction(degrees)
        for (low, high), opacity in (((0, start), 0.3), ((start, rim), 1)):
            line = np.stack([low * w, high * w], -1)
            panel.plot(*line, color=colour, lw=1.5, ls=dashes, alpha=opacity, zorder=3)
        panel.text(*(1.1 * rim * w), name, color=colour, ha="center", va="center", zorder=4)
