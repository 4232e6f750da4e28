"""Pictures of what the checks have found: the worst case of each failure beside its surroundings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.check.energy import precise
from gonio.check.kernels import evaluate
from gonio.check.report import FAIL, KNOWN, Finding, Report
from gonio.check.subject import Array, Subject, directions
from gonio.files import check_place, replacing

# More panels than this would be too small to see something.
PANELS = 6

# Points of a curve, and of the curve of albedos.
POINTS, ANGLES = 721, 61


def plot(
    path: str | Path, subjects: Sequence[Subject], reports: Sequence[Report], dpi: int = 150
) -> Path:
    """Draw the failures, or what is known if nothing has failed, into a .png, .svg or .pdf file.

    Raises:
        ValueError: there is nothing to draw, or the format is none of the three.
    """
    path = Path(path)
    check_format(path)
    shown = drawable(subjects, reports)
    if not shown:
        raise ValueError(
            "nothing has failed and nothing is known to be wrong: there is no picture."
        )
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib.figure import Figure

    columns = min(len(shown), 3)
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(4.6 * columns, 3.9 * rows), dpi=dpi, layout="constrained")
    panels = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for panel, (subject, report, finding) in zip(panels, shown, strict=False):
        _panel(panel, subject, report, finding)
    for panel in panels[len(shown) :]:
        panel.set_visible(False)
    with replacing(path) as temporary:
        figure.savefig(temporary)
    return path


def check_format(path: str | Path) -> None:
    """Raise a ValueError or OSError if a picture cannot be written under this name."""
    if Path(path).suffix not in (".png", ".svg", ".pdf"):
        raise ValueError(f"{path} must end in .png, .svg or .pdf.")
    check_place(path)


def drawable(
    subjects: Sequence[Subject], reports: Sequence[Report]
) -> list[tuple[Subject, Report, Finding]]:
    """Failures with a case that can be drawn, or known departures if there are none."""
    by_tag = {(s.name, s.tag()): s for s in subjects}
    for verdict in (FAIL, KNOWN):
        found = [
            (by_tag[r.model, f.tag], r, f)
            for r in reports
            for f in r.findings
            if f.verdict == verdict and f.case is not None and (r.model, f.tag) in by_tag
        ]
        # One of each kind first, then the other variants of it
        seen: dict[tuple[str, str], int] = {}
        order = []
        for _, r, f in found:
            kind = (r.model + r.check, f.what)
            seen[kind] = seen.get(kind, -1) + 1
            order.append(seen[kind])
        if found:
            return [found[k] for k in sorted(range(len(found)), key=order.__getitem__)][:PANELS]
    return []


def _panel(panel: Any, subject: Subject, report: Report, finding: Finding) -> None:
    assert finding.case is not None
    parameters, wi, wo = finding.case
    tag = f" ({finding.tag})" if finding.tag else ""
    panel.set_title(
        f"{subject.name}{tag}\n{report.check}: {finding.what} {finding.measured:.4g}", fontsize=9
    )
    if report.check in ("energy", "albedo"):
        _albedos(panel, subject, parameters, wo)
    elif "s = 0" in finding.what:
        _turn(panel, subject, parameters, wi, wo)
    else:
        _slice(panel, subject, parameters, wi, wo, both=report.check == "reciprocity")
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.3)
    panel.legend(fontsize=7)


def _albedos(panel: Any, subject: Subject, parameters: Array, wo: Array) -> None:
    """Albedo of every channel over the viewer's angle, in the azimuth of the worst case."""
    theta = np.radians(np.linspace(0, 89.9, ANGLES))
    azimuth = np.arctan2(wo[1], wo[0])
    E = precise(subject, np.tile(parameters, (ANGLES, 1)), directions(np.cos(theta), azimuth))
    grey = np.allclose(E, E[:, :1], atol=1e-6)
    channels = [(0, "black", "albedo")] if grey else list(zip(range(3), RGB, NAMES, strict=True))
    for channel, colour, name in channels:
        panel.plot(np.degrees(theta), E[:, channel], color=colour, label=name)
    panel.axhline(1, color="grey", linestyle=":", label="all that is received")
    worst = np.degrees(np.arccos(np.clip(wo[2], -1, 1)))
    panel.axvline(worst, color="crimson", linewidth=1, alpha=0.6, label=f"worst, {worst:.4g}°")
    panel.set_xlabel("angle of the viewer, degrees", fontsize=8)
    panel.set_ylim(0, 1.08 * max(1.0, float(np.nanmax(E))))


RGB = ("#c02020", "#208020", "#2040c0")
NAMES = ("albedo, red", "green", "blue")


def _turn(panel: Any, subject: Subject, parameters: Array, wi: Array, wo: Array) -> None:
    """Values while wi turns about the normal, away from wo's azimuth, with the worst case marked."""
    turn = np.radians(np.linspace(-180, 180, POINTS))
    light = directions(np.full(POINTS, wi[2]), turn + np.arctan2(wo[1], wo[0]))
    index = np.zeros(POINTS, np.uint32)
    f, _ = evaluate(subject, parameters[None], index, light, np.tile(wo, (POINTS, 1)))
    panel.plot(np.degrees(turn), f.mean(axis=1), color="black", label="f(wi, wo)")
    worst = np.degrees(np.arctan2(wi[1], wi[0]) - np.arctan2(wo[1], wo[0]))
    worst = (worst + 180) % 360 - 180
    panel.axvline(worst, color="crimson", linewidth=1, alpha=0.6, label=f"worst, {worst:.4g}°")
    panel.set_xlabel("azimuth of wi minus that of wo, degrees", fontsize=8)
    panel.set_ylabel("1/sr", fontsize=8)


def _slice(
    panel: Any, subject: Subject, parameters: Array, wi: Array, wo: Array, both: bool
) -> None:
    """Values along the great circle of wi through the normal, with the worst case marked."""
    theta = np.radians(np.linspace(-89.9, 89.9, POINTS))
    azimuth = np.arctan2(wi[1], wi[0]) if abs(wi[2]) < 1 - 1e-12 else np.arctan2(wo[1], wo[0])
    light = directions(np.cos(theta), azimuth)
    light[:, :2] *= np.sign(theta)[:, None]
    viewer = np.tile(wo, (POINTS, 1))
    index = np.zeros(POINTS, np.uint32)
    where = parameters[None]
    f, pdf = evaluate(subject, where, index, light, viewer)
    degrees = np.degrees(theta)
    panel.plot(degrees, f.mean(axis=1), color="black", label="f(wi, wo)")
    if both:
        g, _ = evaluate(subject, where, index, viewer, light)
        panel.plot(degrees, g.mean(axis=1), color="#2060c0", linestyle="--", label="f(wo, wi)")
    else:
        panel.plot(degrees, pdf, color="#2060c0", linestyle="--", label="density of sample")
    worst = np.degrees(np.arccos(np.clip(wi[2], -1, 1)))
    panel.axvline(worst, color="crimson", linewidth=1, alpha=0.6, label=f"worst, {worst:.4g}°")
    top = np.nanpercentile(np.abs(f.mean(axis=1)), 99.5)
    if np.isfinite(top) and top > 0 and np.nanmax(f) > 20 * top:
        panel.set_yscale("symlog", linthresh=float(top))
    panel.set_xlabel("angle of wi, degrees; the worst case's side is positive", fontsize=8)
    panel.set_ylabel("1/sr", fontsize=8)
