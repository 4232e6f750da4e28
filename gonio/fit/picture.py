"""A picture of data, fit and difference: lit spheres, lobes, and where the residuals are."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from gonio.fit.fitting import Fit
from gonio.fit.misfit import THETA_D, THETA_H
from gonio.fit.problem import Floats
from gonio.fit.targets import measure
from gonio.materials.notation import model_text
from gonio.measured.frames import from_half_difference, spherical
from gonio.measured.spectra import to_rgb
from gonio.model import Model
from gonio.plot.output import Plot, check_output
from gonio.plot.style import COLOURS, draw_head, new_figure

# Pixels of a sphere's side, and the lights that it is lit by: direction towards them, and strength. One is
# at the viewer's left above, the other behind: grazing light shows what the first does not.
PIXELS = 220
LIGHTS = (((-0.45, 0.55, 0.7), 1.0), ((0.75, -0.1, -0.45), 0.6))

# Angles of the light whose lobes are drawn, in degrees, and points along each.
LOBES, ALONG = (15, 45, 70), 721

# Brightness of the spheres: this percentile of the data's pixels is white.
WHITE = 99.5

# Cells of a slice along each side.
CELLS = 120


def save(path: str, found: Fit, data: Any, title: str, seed: int = 0) -> Path:
    """Write the picture, or the numbers of its lobes as .csv.

    Args:
        path: .png, .svg, .pdf or .csv.
        found: a fit.
        data: what it was fitted to.
        title: of the data.
        seed: that the fit had.

    Raises:
        ValueError: another suffix.
    """
    check_output(path)
    return plot(found, data, title, seed).save(path)


def plot(found: Fit, data: Any, title: str, seed: int = 0) -> Plot:
    """Spheres of data, fit and difference above; lobes, slices and the map of residuals below."""
    measured = None if isinstance(data, Model) else measure(data, seed)

    def of_data(wi: Floats, wo: Floats) -> tuple[Floats, Any]:
        if measured is None:
            return np.asarray(data.eval(wi, wo), np.float64), np.ones(len(wi), bool)
        values, known = measured.interpolate(wi, wo)
        return to_rgb(measured, values)[0], known

    def of_fit(wi: Floats, wo: Floats) -> Floats:
        return np.asarray(found.model.eval(wi, wo), np.float64)

    lobes = [_lobe(theta, of_data, of_fit) for theta in LOBES]
    columns = {name: np.concatenate([lobe[name] for lobe in lobes]) for name in lobes[0]}

    def draw() -> Any:
        figure = new_figure(12.5, 8.6)
        facts = [f"misfit {found.relative:.1%} of the data in {found.metric}"]
        if found.noise is not None:
            part = found.relative / max(found.misfit[found.metric], 1e-300)
            facts.append(f"noise {found.noise.size * part:.1%}")
        facts += [region.sentence() for region in found.regions[:1]]
        # Four digits are enough to look at
        text = re.sub(r"\d*\.\d{5,}", lambda n: f"{float(n[0]):.4g}", model_text(found.model))
        draw_head(figure, f"{title}, fitted", [text, *facts])
        axes = figure.subplots(2, 3, height_ratios=(1.05, 1))
        _draw_spheres(axes[0], of_data, of_fit)
        _draw_lobes(axes[1, 0], lobes)
        _draw_slice(axes[1, 1], of_data, of_fit, figure)
        _draw_map(axes[1, 2], found, figure)
        return figure

    return Plot(columns, draw)


def _grey(values: Floats) -> Floats:
    return np.asarray(values @ (0.2126, 0.7152, 0.0722))


def _lobe(theta: float, of_data: Any, of_fit: Any) -> dict[str, Any]:
    """The plane of incidence; theta_o is negative on the light's side."""
    theta_o = np.linspace(-88, 88, ALONG)
    wi = np.broadcast_to(spherical(np.radians(theta), 0.0), (ALONG, 3))
    wo = spherical(np.radians(-theta_o), 0.0)
    values, known = of_data(wi, wo)
    return {
        "theta_i_deg": np.full(ALONG, float(theta)),
        "theta_o_deg": theta_o,
        "data_per_sr": np.where(known, _grey(values), np.nan),
        "fit_per_sr": _grey(of_fit(wi, wo)),
    }


def _sphere() -> tuple[Any, Floats, Floats]:
    """Which pixels are on the sphere, and wo (n, 3) and the lights' wi (lights, n, 3) in the frame of
    each, whose x goes round the sphere."""
    across = (np.arange(PIXELS) + 0.5) / PIXELS * 2 - 1
    x, y = np.meshgrid(across * 1.03, -across * 1.03)
    inside = x**2 + y**2 < 1
    n = np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], -1)[inside]
    t = np.stack([n[:, 2], 0 * n[:, 0], -n[:, 0]], -1)
    t /= np.maximum(np.linalg.norm(t, axis=-1, keepdims=True), 1e-9)
    frame = np.stack([t, np.cross(n, t), n], 1)
    wo = frame @ np.array([0.0, 0.0, 1.0])
    lights = [np.array(w) / np.linalg.norm(w) for w, _ in LIGHTS]
    return inside, wo, np.stack([frame @ w for w in lights])


def _shade(evaluate: Any) -> tuple[Floats, Any]:
    """Linear RGB of a sphere's pixels, and where there is data for all of the light."""
    inside, wo, wi = _sphere()
    light, sure = np.zeros((len(wo), 3)), np.ones(len(wo), bool)
    for (_, strength), w in zip(LIGHTS, wi, strict=True):
        up = (w[:, 2] > 1e-3) & (wo[:, 2] > 1e-3)
        found = evaluate(w[up], wo[up])
        values, known = found if isinstance(found, tuple) else (found, np.ones(int(up.sum()), bool))
        light[up] += strength * values * w[up, 2:]
        sure[up] &= known
    picture, where = np.zeros((PIXELS, PIXELS, 3)), np.zeros((PIXELS, PIXELS), bool)
    picture[inside], where[inside] = light, sure
    return picture, where


def _srgb(linear: Floats) -> Floats:
    x = np.clip(linear, 0, 1)
    return np.asarray(np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055))


def _draw_spheres(axes: Any, of_data: Any, of_fit: Any) -> None:
    data, known = _shade(of_data)
    fitted, _ = _shade(of_fit)
    inside = _sphere()[0]
    white = max(float(np.percentile(data[inside].max(-1), WHITE)), 1e-9)
    # Highlights that are far brighter than the rest would leave it black
    white = min(white, 12 * max(float(np.percentile(data[inside].max(-1), 75)), 1e-9))
    paper = ~inside[..., None]
    for one, picture, name in ((axes[0], data, "Data"), (axes[1], fitted, "Fit")):
        shown = np.where(paper, 1.0, _srgb(picture / white))
        if name == "Data":
            shown[inside & ~known] = 0.5 * shown[inside & ~known] + 0.35
        one.imshow(shown, interpolation="bilinear")
        pale = " (paler: no value near)" if name == "Data" and (inside & ~known).any() else ""
        one.set_title(f"{name}: a sphere in two lights{pale}", fontsize=10)
    difference = _grey(fitted - data) / white
    difference = np.where(inside & known, difference, np.nan)
    limit = max(float(np.nanpercentile(np.abs(difference), 99)), 1e-4)
    image = axes[2].imshow(
        difference, cmap="RdBu_r", vmin=-limit, vmax=limit, interpolation="nearest"
    )
    axes[2].set_title("Fit less data, in parts of white", fontsize=10)
    axes[2].figure.colorbar(image, ax=axes[2], shrink=0.8)
    for one in axes:
        one.set_axis_off()


def _draw_lobes(axes: Any, lobes: list[dict[str, Any]]) -> None:
    for i, lobe in enumerate(lobes):
        colour = COLOURS[i % len(COLOURS)]
        data = lobe["data_per_sr"]
        axes.plot(
            lobe["theta_o_deg"],
            np.where(data > 0, data, np.nan),
            color=colour,
            linewidth=3.5,
            alpha=0.35,
        )
        axes.plot(
            lobe["theta_o_deg"],
            lobe["fit_per_sr"],
            color=colour,
            linewidth=1.3,
            label=f"{lobe['theta_i_deg'][0]:g}°",
        )
    positive = np.concatenate([lobe["data_per_sr"] for lobe in lobes])
    positive = positive[positive > 0]
    if positive.size and positive.max() > 20 * np.median(positive):
        axes.set_yscale("log")
        axes.set_ylim(max(np.percentile(positive, 1) / 3, 1e-6), 3 * positive.max())
    axes.set_xlim(-90, 90)
    axes.set_xticks(range(-90, 91, 30), [f"{x}°" for x in range(-90, 91, 30)])
    axes.set_xlabel("theta_o; the mirror's side is right")
    axes.set_title("f in 1/sr; broad: data, thin: fit; light at", fontsize=10)
    axes.legend(fontsize=8, ncols=3)


def _draw_slice(axes: Any, of_data: Any, of_fit: Any, figure: Any) -> None:
    """Fit over data at phi_d = 90°."""
    u = (np.arange(CELLS) + 0.5) / CELLS
    h, d = np.meshgrid(0.5 * np.pi * u**2, 0.5 * np.pi * u)
    wi, wo = from_half_difference(h.ravel(), 0.0, d.ravel(), 0.5 * np.pi)
    up = (wi[:, 2] > 1e-3) & (wo[:, 2] > 1e-3)
    ratio = np.full(len(wi), np.nan)
    values, known = of_data(wi[up], wo[up])
    data, fitted = _grey(values), _grey(of_fit(wi[up], wo[up]))
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio[up] = np.where(known & (data > 0), np.log2(fitted / data), np.nan)
    axes.set_facecolor("#dddddd")
    image = axes.imshow(
        ratio.reshape(CELLS, CELLS),
        origin="lower",
        extent=(0, 1, 0, 90),
        aspect="auto",
        cmap="RdBu_r",
        vmin=-2,
        vmax=2,
    )
    axes.grid(False)
    ticks = (0, 1, 5, 15, 30, 60, 90)
    axes.set_xticks([(t / 90) ** 0.5 for t in ticks], [f"{t}°" for t in ticks])
    axes.set_xlabel("theta_h, by its root")
    axes.set_ylabel("theta_d")
    axes.set_title("Fit over data at phi_d = 90°, in stops; grey: no value", fontsize=10)
    figure.colorbar(image, ax=axes, shrink=0.8)


def _draw_map(axes: Any, found: Fit, figure: Any) -> None:
    """Root mean squares of the residuals in cells of theta_h and theta_d."""
    axes.set_facecolor("#dddddd")
    edges = np.sqrt(np.array(THETA_H) / 90)
    image = axes.pcolormesh(edges, THETA_D, np.ma.masked_invalid(found.map.rms.T), cmap="magma_r")
    axes.grid(False)
    ticks = THETA_H[::2]
    axes.set_xticks([(t / 90) ** 0.5 for t in ticks], [f"{t:g}°" for t in ticks])
    axes.set_xlabel("theta_h, by its root")
    axes.set_ylabel("theta_d")
    axes.set_title(f"Residuals in {found.metric}, root mean squares", fontsize=10)
    figure.colorbar(image, ax=axes, shrink=0.8)


__all__ = ["plot", "save"]
