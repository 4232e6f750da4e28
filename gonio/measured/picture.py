"""A picture of a measurement: where it has values, its lobes, a slice of it, and its albedos."""

from __future__ import annotations

from typing import Any

import numpy as np

from gonio.measured.frames import Floats, angles, from_half_difference, spherical
from gonio.measured.measurement import Measurement
from gonio.measured.quality import Quality
from gonio.measured.spectra import to_rgb
from gonio.measured.summary import coverage, holes
from gonio.plot.output import Plot, check_output
from gonio.plot.style import COLOURS, FAINT, draw_head, new_figure

# Angles of the light whose lobes are shown, unless the file has few of its own, in degrees.
LOBES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)

# Points along a lobe, and cells of the slices.
ALONG, CELLS = 721, 180

# Powers of ten below the brightest that colours show.
DECADES = 5

# Points that the map of directions shows.
SHOWN = 20_000


def plot(measured: Measurement, q: Quality) -> Plot:
    """Four panels: lobes, directions, values over half and difference angles, and albedos."""
    lobes = _lobes(measured)
    rows = {name: np.concatenate([lobe[name] for lobe in lobes]) for name in lobes[0]}

    def draw() -> Any:
        figure = new_figure(11.0, 8.4)
        draw_head(
            figure,
            f"{measured.title} ({measured.format}, {measured.part})",
            [coverage(q), f"holes: {holes(q)}"],
        )
        axes = figure.subplots(2, 2)
        _draw_lobes(axes[0, 0], lobes)
        _draw_directions(axes[0, 1], measured)
        _draw_slice(axes[1, 0], measured, figure)
        _draw_albedo(axes[1, 1], q)
        return figure

    return Plot(rows, draw)


def save(path: str, measured: Measurement, q: Quality) -> Any:
    """Write the picture, or the numbers of its lobes as .csv."""
    check_output(path)
    return plot(measured, q).save(path)


def _grey(measured: Measurement, values: Floats) -> Floats:
    return np.asarray(to_rgb(measured, values)[0] @ (0.2126, 0.7152, 0.0722))


def _lobes(measured: Measurement) -> list[dict[str, Any]]:
    """The plane of incidence for some angles of the light: theta_o is negative on the light's side."""
    use = measured.valid
    own = np.unique(np.round(np.degrees(angles(measured.wi[use])[0]), 1))
    chosen = own if len(own) <= len(LOBES) else np.array(LOBES)
    theta_o = np.linspace(-89, 89, ALONG)
    found = []
    for theta in chosen:
        wi = np.broadcast_to(spherical(np.radians(theta), 0.0), (ALONG, 3))
        wo = spherical(
            np.radians(-theta_o), 0.0
        )  # beyond the normal, the mirror's side, is positive
        if measured.transmission:
            wo = wo * [1, 1, -1]
        values, known = measured.interpolate(wi, wo)
        f = _grey(measured, values)
        found.append(
            {
                "theta_i_deg": np.full(ALONG, float(theta)),
                "theta_o_deg": theta_o,
                "f_per_sr": np.where(known, f, np.nan),
                "near_a_measured_value": known.astype(float),
            }
        )
    return found


def _draw_lobes(axes: Any, lobes: list[dict[str, Any]]) -> None:
    positive = [f for lobe in lobes for f in lobe["f_per_sr"] if f > 0]
    for i, lobe in enumerate(lobes):
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(
            lobe["theta_o_deg"],
            np.where(lobe["f_per_sr"] > 0, lobe["f_per_sr"], np.nan),
            color=colour,
            label=f"{lobe['theta_i_deg'][0]:g}°",
            linewidth=1.4,
        )
    if positive and max(positive) > 20 * np.median(positive):
        axes.set_yscale("log")
    axes.set_xlim(-90, 90)
    axes.set_xticks(range(-90, 91, 30), [f"{x}°" for x in range(-90, 91, 30)])
    axes.set_xlabel("theta_o in the plane of incidence; the mirror's side is right")
    axes.set_title("f in 1/sr, for the light at")
    axes.legend(fontsize=8, ncols=3, loc="best")


def _draw_directions(axes: Any, measured: Measurement) -> None:
    use = np.flatnonzero(measured.valid)
    use = np.random.default_rng(1).permutation(use)[:SHOWN]  # a step would be one of the grid
    wi, wo = measured.wi[use].astype(float), measured.wo[use].astype(float)
    turn = angles(wi)[1] if measured.isotropic else np.zeros(len(wi))
    theta, phi = angles(wo)
    theta = np.where(theta > 0.5 * np.pi, np.pi - theta, theta)
    phi = phi - turn
    f = np.maximum(_grey(measured, measured.values[use].astype(float)), 1e-12)
    order = np.argsort(f)
    x, y = np.degrees(theta) * np.cos(phi), np.degrees(theta) * np.sin(phi)
    shown = axes.scatter(
        x[order],
        y[order],
        c=np.maximum(np.log10(f[order]), np.log10(f.max()) - DECADES),
        s=3,
        cmap="viridis",
        linewidths=0,
        rasterized=True,
    )
    for ring in (30, 60, 90):
        t = np.linspace(0, 2 * np.pi, 181)
        axes.plot(ring * np.cos(t), ring * np.sin(t), color=FAINT, linewidth=0.6)
        axes.annotate(f"{ring}°", (0, ring), fontsize=7, color=FAINT, ha="center")
    axes.set_aspect("equal")
    axes.set_axis_off()
    where = "the light is to the right" if measured.isotropic else "x is to the right"
    axes.set_title(f"Directions of the detector with a value; {where}")
    axes.figure.colorbar(shown, ax=axes, label="log10 f", shrink=0.8)


def _draw_slice(axes: Any, measured: Measurement, figure: Any) -> None:
    """f over theta_h and theta_d at phi_d = 90°; of transmission, over both angles."""
    if measured.transmission:
        theta = np.radians(np.linspace(0.5, 89.5, CELLS))
        i, o = np.meshgrid(theta, theta)
        wi, wo = spherical(i.ravel(), 0.0), spherical(np.pi - o.ravel(), np.pi)
        extent, labels = (0, 90, 0, 90), ("theta_i", "theta_o, straight on")
    else:
        u = (np.arange(CELLS) + 0.5) / CELLS
        h, d = np.meshgrid(0.5 * np.pi * u**2, 0.5 * np.pi * u)
        wi, wo = from_half_difference(h.ravel(), 0.0, d.ravel(), 0.5 * np.pi)
        extent, labels = (0, 1, 0, 90), ("theta_h, by its root", "theta_d")
    values, known = measured.interpolate(wi, wo)
    f = _grey(measured, values).reshape(CELLS, CELLS)
    shown = np.where(known.reshape(CELLS, CELLS) & (f > 0), np.log10(np.maximum(f, 1e-12)), np.nan)
    axes.set_facecolor("#dddddd")
    image = axes.imshow(shown, origin="lower", extent=extent, aspect="auto", cmap="viridis")
    axes.grid(False)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    if not measured.transmission:
        ticks = (0, 1, 5, 15, 30, 60, 90)
        axes.set_xticks([(t / 90) ** 0.5 for t in ticks], [f"{t}°" for t in ticks])
        axes.axhline(80, color="white", linewidth=0.8, linestyle="--")
        axes.set_title(
            "log10 f at phi_d = 90°; grey: no value, below 0 or below the horizon", fontsize=9
        )
    figure.colorbar(image, ax=axes, shrink=0.8)


def _draw_albedo(axes: Any, q: Quality) -> None:
    if not q.albedos:
        axes.set_axis_off()
        return
    thetas = sorted({a.theta for a in q.albedos})
    for attribute, label, style in (
        ("all", "with what is filled in", "--"),
        ("measured", "measured", "-"),
    ):
        highest = [max(getattr(a, attribute) for a in q.albedos if a.theta == t) for t in thetas]
        axes.plot(thetas, highest, style, color=COLOURS[0], label=label)
    axes.axhline(1, color=FAINT, linewidth=0.8)
    axes.set_xlim(0, 90)
    axes.set_ylim(0, None)
    axes.set_xticks(range(0, 91, 15), [f"{x}°" for x in range(0, 91, 15)])
    axes.set_xlabel("theta_o")
    axes.set_title("Directional albedo, largest channel")
    axes.legend(fontsize=8)


__all__ = ["plot", "save"]
