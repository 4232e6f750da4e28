"""Comparisons as pictures: error maps, a parameter's influence, renderings side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.compare import Comparison, luminance, percent
from gonio.files import check_place, replacing

# Errors at which the colours of the maps end, and the least radiance at which those of differences do:
# the noise of two pictures stays pale.
RANGE, DIFFERENCE_MIN = 1.0, 0.05


def write(path: str | Path, comparisons: Sequence[Comparison], *, dpi: int = 75) -> None:
    """Draw comparisons, one below the other: maps, a parameter's influence, and pictures.

    Args:
        path: a .png; it appears only when it is complete.
        comparisons: what `compare` returned.
        dpi: dots per inch.

    Raises:
        ValueError: another suffix.
        FileNotFoundError: the folder does not exist.
    """
    check_format(path)
    if not Path(path).resolve().parent.is_dir():
        raise FileNotFoundError(f"there is no folder {Path(path).parent}; create it first.")
    figure = draw(comparisons)
    with replacing(path) as temporary:
        # Dates would make every file different.
        figure.savefig(temporary, format="png", dpi=dpi, metadata={"Software": None})


def check_format(path: str | Path) -> None:
    """Raise a ValueError or OSError unless `write` can write a file of this name."""
    if Path(path).suffix.lower() != ".png":
        raise ValueError(f"cannot write {Path(path).name!r}; the suffix must be .png.")
    check_place(path)


def draw(comparisons: Sequence[Comparison]) -> Any:
    """The same as a `matplotlib.figure.Figure`."""
    from matplotlib.figure import Figure

    pictured = any(c.pictures for c in comparisons)
    columns = 6 if pictured else 3
    rows = len(comparisons)
    figure = Figure(figsize=(3.3 * columns, 3.7 * rows), layout="constrained")
    strips = figure.subfigures(rows, 1, squeeze=False)
    for strip, c in zip(strips[:, 0], comparisons, strict=True):
        _strip(strip, c, columns)
    return figure


def _strip(strip: Any, c: Comparison, columns: int) -> None:
    e = c.errors
    at = "θi {:g}°, θo {:g}°, φ {:g}°".format(*e.worst_at)
    strip.suptitle(
        f"{c.name}  against {c.against}:  mean error {100 * e.mean:.1f} %,  worst {percent(e.worst)} "
        f"({at}),  energy {percent(e.energy)}",
        fontsize=10,
        x=0.01,
        ha="left",
    )
    panels = strip.subplots(1, columns, squeeze=False)[0]
    colours: dict[str, Any] = {"cmap": "RdBu_r", "vmin": -RANGE, "vmax": RANGE, "origin": "lower"}
    for panel, errors, low, title in (
        (panels[0], c.in_plane, -87.5, "error in the plane of incidence"),
        (panels[1], c.across, -2.5, "error across it, φ = 90°"),
    ):
        panel.set_facecolor("0.75")
        extent = (low, 87.5, -2.5, 87.5)
        shown = panel.imshow(errors, extent=extent, aspect="auto", **colours)
        panel.set(title=title, xlabel="θi (degrees)", ylabel="θo (degrees)")
        panel.set_xticks(range(-60, 61, 30) if low < -80 else range(0, 91, 30))
        panel.set_yticks(range(0, 91, 30))
    bar = strip.colorbar(shown, ax=panels[1], extend="max")
    bar.set_ticks([-1, -0.5, 0, 0.5, 1], labels=["-100 %", "-50 %", "0", "+50 %", "+100 %"])
    panels[0].set_xlabel("θi (degrees; + viewer's side, − mirror's)")
    _influence(panels[2], c)
    if columns == 3:
        return
    if c.pictures is None:
        for panel in panels[3:]:
            panel.set_axis_off()
        return
    ours, truth = c.pictures
    for panel, pixels, title in ((panels[3], ours, "model"), (panels[4], truth, c.against)):
        panel.imshow(_srgb(pixels), interpolation="nearest")
        panel.set_title(title)
        panel.set_axis_off()
    difference = luminance(ours - truth)
    scale = max(float(np.quantile(np.abs(difference), 0.995)), DIFFERENCE_MIN)
    shown = panels[5].imshow(difference, cmap="RdBu_r", vmin=-scale, vmax=scale)
    panels[5].set_title(f"model minus {'truth' if c.against == 'truth' else 'first'}")
    panels[5].set_axis_off()
    strip.colorbar(shown, ax=panels[5], shrink=0.7, label="radiance")


def _influence(panel: Any, c: Comparison) -> None:
    if not c.varied:
        panel.set_axis_off()
        return
    mean, energy = ([100 * getattr(e, n) for e in c.influence] for n in ("mean", "energy"))
    panel.plot(c.values, mean, "o-", color="#D55E00", label="mean error")
    panel.plot(c.values, energy, "s--", color="#0072B2", label="energy")
    if max(c.values) > 100:
        panel.set_xscale("log")
    panel.axhline(0, color="0.5", linewidth=0.8)
    panel.set(title=f"influence of {c.varied}", xlabel=c.varied, ylabel="%")
    panel.legend(frameon=False)


def _srgb(pixels: Any) -> Any:
    x = np.clip(np.asarray(pixels, np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
