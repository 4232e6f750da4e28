"""Where code differs from a model, as pictures: over angles, around the normal, and over parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.files import check_place, replacing
from gonio.foreign.compared import Comparison, evaluate, links
from gonio.foreign.expressions import Array
from gonio.foreign.function import Foreign
from gonio.foreign.source import ForeignError
from gonio.model import Model

# Steps of angles and of parameters, and azimuths that are looked at for each place of a parameter's map.
ANGLES, STEPS, TURNS = 91, 25, (0.0, 45.0, 90.0, 135.0, 180.0)

# Ratios of code and model at which the colours end: 8 times too bright or too dark.
OCTAVES = 3.0

# Differences below this look equal; the scale of those over parameters begins here.
LEAST = 1e-6

# The angle nearest to the horizon that is shown.
GRAZING = 89.0

# Parameters that have a map.
MOST = 4


def check_format(path: str | Path) -> None:
    """Raise a ValueError or OSError unless `write` can write a file of this name."""
    if Path(path).suffix.lower() not in (".png", ".svg", ".pdf"):
        raise ForeignError(
            f"cannot write {Path(path).name!r}; the suffix must be .png, .svg or .pdf."
        )
    check_place(path)


def write(path: str | Path, comparisons: Sequence[Comparison]) -> None:
    """Draw comparisons, one below the other.

    Args:
        path: a .png, .svg or .pdf; it appears only when it is complete.
        comparisons: what `compare` found.
    """
    import matplotlib
    from matplotlib.figure import Figure

    numbers = [_numbers(found.foreign, found.model) for found in comparisons]
    columns = 2 + max(min(len(n), MOST) for n in numbers)
    with matplotlib.rc_context({"font.family": "DejaVu Sans", "font.size": 9}):
        figure = Figure(figsize=(3.6 * columns, 4.0 * len(comparisons)), layout="constrained")
        rows = figure.subfigures(len(comparisons), 1, squeeze=False)[:, 0]
        for row, found, own in zip(rows, comparisons, numbers, strict=True):
            _row(row, found.foreign, found.model, found, own[:MOST], columns)
        with replacing(path) as temporary:
            kind = Path(path).suffix.lower()[1:]
            figure.savefig(temporary, format=kind, dpi=110)


def _numbers(foreign: Foreign, model: Model | Foreign) -> list[str]:
    """Names of single numbers that both have."""
    return [name for name, (own, _) in links(foreign, model).items() if own.width == 1]


def _row(
    figure: Any,
    foreign: Foreign,
    model: Model | Foreign,
    found: Comparison,
    numbers: Sequence[str],
    columns: int,
) -> None:
    shown = ", ".join(f"{k} = {_short(v)}" for k, v in found.values.items())
    figure.suptitle(
        f"{foreign.name} over {model.name}" + (f"   ({shown})" if shown else ""), fontsize=11
    )
    panels = figure.subplots(1, columns, squeeze=False)[0]
    _plane(figure, panels[0], foreign, model, found)
    _around(figure, panels[1], foreign, model, found)
    for panel, name in zip(panels[2:], numbers, strict=False):
        _parameter(figure, panel, foreign, model, found, name)
    for panel in panels[2 + len(numbers) :]:
        panel.set_axis_off()


def _short(value: Any) -> str:
    numbers = np.atleast_1d(np.asarray(value, float))
    return "/".join(f"{x:.3g}" for x in (numbers[:1] if np.ptp(numbers) == 0 else numbers))


def _directions(theta_i: Array, theta_o: Array, phi: Array) -> tuple[Array, Array]:
    """wi at an azimuth from the viewer, who is at x; angles in degrees."""
    a, b, p = np.radians(theta_i), np.radians(theta_o), np.radians(phi)
    wi = np.stack([np.sin(a) * np.cos(p), np.sin(a) * np.sin(p), np.cos(a)], -1)
    wo = np.stack([np.sin(b), 0 * b, np.cos(b)], -1)
    return wi, wo


def _both(
    foreign: Foreign, model: Model | Foreign, wi: Array, wo: Array, values: Mapping[str, Any]
) -> tuple[Array, Array]:
    given = {k: np.asarray(v) for k, v in values.items()}
    spread = {
        k: np.broadcast_to(v, (len(wi), *v.shape)) if v.shape in ((), (3,)) else v
        for k, v in given.items()
    }
    return foreign.brdf(wi, wo, spread), evaluate(model, wi, wo, spread)


def _octaves(code: Array, truth: Array) -> Array:
    """How many times too bright, as powers of two, of the channels' means."""
    a, b = code.mean(axis=1), truth.mean(axis=1)
    with np.errstate(all="ignore"):
        found = np.log2(np.maximum(a, 0) / b)
    found = np.where((a <= 0) & (b <= 0), 0.0, found)
    return np.asarray(np.clip(np.nan_to_num(found, nan=OCTAVES), -OCTAVES, OCTAVES))


def _ratios(figure: Any, panel: Any, x: Array, y: Array, octaves: Array, title: str) -> None:
    image = panel.pcolormesh(
        x,
        y,
        octaves,
        cmap="RdBu_r",
        vmin=-OCTAVES,
        vmax=OCTAVES,
        shading="nearest",
        rasterized=True,
    )
    panel.set_title(title, fontsize=9)
    bar = figure.colorbar(image, ax=panel, fraction=0.05, pad=0.02)
    ticks = [-3, -2, -1, 0, 1, 2, 3]
    bar.set_ticks(ticks, labels=["1/8", "1/4", "1/2", "equal", "2", "4", "8 times"])


def _plane(
    figure: Any, panel: Any, foreign: Foreign, model: Model | Foreign, found: Comparison
) -> None:
    """Both angles in the plane of incidence: on the left light from the viewer's side."""
    x, y = np.linspace(-GRAZING, GRAZING, 2 * ANGLES - 1), np.linspace(0, GRAZING, ANGLES)
    i, o = (a.ravel() for a in np.meshgrid(x, y))
    code, truth = _both(foreign, model, *_directions(i, o, np.full_like(i, 180.0)), found.values)
    octaves = _octaves(code, truth).reshape(len(y), len(x))
    _ratios(figure, panel, x, y, octaves, "in the plane of incidence")
    panel.set_xlabel("light, degrees; on the right forward scatter")
    panel.set_ylabel("viewer, degrees")


def _around(
    figure: Any, panel: Any, foreign: Foreign, model: Model | Foreign, found: Comparison
) -> None:
    """The light all over the hemisphere, where the viewer sees the largest difference."""
    x, y = np.linspace(0, 360, 2 * ANGLES - 1), np.linspace(0, GRAZING, ANGLES)
    p, i = (a.ravel() for a in np.meshgrid(x, y))
    viewer = min(found.theta_o, GRAZING)
    code, truth = _both(foreign, model, *_directions(i, np.full_like(i, viewer), p), found.values)
    octaves = _octaves(code, truth).reshape(len(y), len(x))
    _ratios(figure, panel, x, y, octaves, f"viewer at {viewer:.3g} degrees")
    panel.set_xlabel("azimuth between light and viewer, degrees")
    panel.set_ylabel("light, degrees")
    panel.set_xticks([0, 90, 180, 270, 360])


def _parameter(
    figure: Any, panel: Any, foreign: Foreign, model: Model | Foreign, found: Comparison, name: str
) -> None:
    """The largest difference over all lights and some azimuths, for a parameter and the viewer's angle."""
    from matplotlib.colors import LogNorm

    own, other = links(foreign, model)[name]
    x = np.linspace(max(own.low, other.low), min(own.high, other.high), STEPS)
    y = np.linspace(0, GRAZING, STEPS)
    turns = np.array(TURNS)
    v, o, i, p = (a.ravel() for a in np.meshgrid(x, y, y, turns, indexing="ij"))
    code, truth = _both(foreign, model, *_directions(i, o, p), {**found.values, name: v})
    scale = np.maximum(np.maximum(np.abs(code), np.abs(truth)), 1e-4)
    with np.errstate(invalid="ignore"):
        off = np.nan_to_num(np.abs(code - truth) / scale, nan=1.0).max(axis=1)
    worst = off.reshape(len(x), len(y), -1).max(axis=2).T
    image = panel.pcolormesh(
        x, y, np.maximum(worst, LEAST), cmap="viridis", norm=LogNorm(LEAST, 1.0), shading="nearest",
        rasterized=True,
    )  # fmt: skip
    panel.set_title("largest difference, of the larger value", fontsize=9)
    figure.colorbar(image, ax=panel, fraction=0.05, pad=0.02)
    panel.set_xlabel(name)
    panel.set_ylabel("viewer, degrees")
