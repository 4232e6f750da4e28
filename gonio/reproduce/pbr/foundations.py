"""The pictures and definitions of the first sections, held against what gonio's models and lamps do.

The text's pictures are drawings of what a word means; what they say can be computed, and is.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.parts import fresnel
from gonio.render.light import ENVIRONMENTS, Lamp
from gonio.reproduce.measure import (
    Floats,
    albedo_by_quadrature,
    directions,
    gray,
    hemisphere,
)
from gonio.reproduce.pbr import TEXT
from gonio.reproduce.sheet import Sheet

WATER = 1.333


def _steel(alpha: float) -> gonio.Model:
    return gonio.TorranceSparrow(alpha=alpha, fresnel="white")


def _lobe(alpha: float, viewer: float) -> tuple[Floats, Floats]:
    """Angles of the light opposite to the viewer, and f cos there."""
    angles = np.linspace(0, 89, 1781)
    wi, wo = directions(np.radians(angles), math.pi), directions(math.radians(viewer))
    return angles, gray(_steel(alpha))(wi, wo) * wi[..., 2]


@TEXT.item("a", "section 1", "law of reflection")
def law_of_reflection(sheet: Sheet) -> None:
    for viewer in (20, 50):
        angles, values = _lobe(0.01, viewer)
        sheet.claim(
            f"where a smooth surface reflects most, viewer at {viewer} degrees",
            "=",
            f"{viewer}.0",
            float(angles[np.argmax(values)]),
            within=0.1,
            why="facets of slope 0.01 move the maximum by less than 0.1 degrees",
        )


@TEXT.item("b", "section 1", "scattering by microfacets")
def scattering(sheet: Sheet) -> None:
    widths = []
    for alpha in (0.05, 0.1, 0.2, 0.4):
        angles, values = _lobe(alpha, 30)
        widths.append(float(np.ptp(angles[values > values.max() / 2])))
        sheet.show(f"width of the lobe at half its height, alpha {alpha:g} [degrees]", widths[-1])
    ratio = min(b / a for a, b in itertools.pairwise(widths))
    sheet.claim("rougher scatters wider: smallest ratio of two", ">=", "1", ratio)


@TEXT.item("c", "section 1", "light that enters and leaves")
def entering(sheet: Sheet) -> None:
    coat = gonio.WeidlichWilkie(
        eta=WATER, alpha=0.05, base="lambert", transmission="both_ways", solid_angle="compressed"
    )
    up = directions(0.3)
    whole, above = (float(coat.replace(**{"base.rho": rho}).albedo(up)[0]) for rho in (1.0, 0.0))
    sheet.claim(
        "what leaves again over what is reflected at once", ">=", "1", (whole - above) / above
    )
    sheet.claim("both together", "<=", "1", whole)


@TEXT.item("d", "section 1", "photograph of the sea: Fresnel reflection grows towards the horizon")
def sea(sheet: Sheet) -> None:
    angles = np.radians([0, 40, 60, 75, 85, 89])
    F = elementwise(fresnel.F_dielectric, np.cos(angles), WATER)
    sheet.claim("water, smallest step from angle to angle", ">=", "0", float(np.diff(F).min()))
    sheet.claim("water, from above", "=", "0.02", float(F[0]))
    sheet.claim("water, 89 degrees", ">=", "0.8", float(F[-1]))


@TEXT.item("e", "section 2", "solid angle")
def solid_angle(sheet: Sheet) -> None:
    half_angle = 0.7
    over = hemisphere(half_angle)  # it has an edge of its pieces there
    inside = over.wi[:, 2] > math.cos(half_angle)
    sheet.claim(
        "a cone of 0.7 radians, summed, over 2 pi (1 - cos 0.7)",
        "=",
        "1",
        over.integral(inside) / (2 * math.pi * (1 - math.cos(half_angle))),
        within=1e-9,
    )


@TEXT.item("f", "section 2", "projected area and radiance")
def projected_area(sheet: Sheet) -> None:
    over = hemisphere(0.4)
    sheet.claim(
        "cosine over the hemisphere: irradiance under radiance 1",
        "=",
        math.pi,
        over.reflected(np.ones(len(over.wi))),
        within=1e-9,
    )


@TEXT.item("k", "section 4.2.3", "shadowing and masking of facets")
def shadowing(sheet: Sheet) -> None:
    """G alone: f over the same without it."""
    seen, hidden = (
        gonio.TorranceSparrow(alpha=0.4, fresnel="white", masking="implicit"),
        _steel(0.4),
    )
    angles = np.radians([0, 30, 60, 75, 85])
    w = directions(angles)
    # G of "implicit" is cos cos, which leaves D F / 4.
    G = gray(hidden)(w, w) / gray(seen)(w, w) * w[:, 2] ** 2
    sheet.claim("the largest G", "<=", "1", float(G.max()))
    sheet.claim("largest step of G towards the horizon", "<=", "0", float(np.diff(G).max()))


# --- sections 2 and 3: radiometry, of gonio's own lamps ------------------------------------------------

SUN: Lamp = ENVIRONMENTS["sun"].lamps["sun"]
FACING = "2 degrees across: its edge is as far as its middle, to 2e-4"


def _radiance() -> float:
    """Of the sun's green, for which its colour is taken out again."""
    return SUN.radiance[1] / SUN.colour[1]


@TEXT.item("eq-flux", "section 2", "phi = dQ / dt")
def flux(sheet: Sheet) -> None:
    over = hemisphere(0.4)
    power = over.reflected(np.full(len(over.wi), _radiance())) * SUN.area
    sheet.claim(
        "flux of gonio's sun over pi L A",
        "=",
        "1",
        power / (math.pi * _radiance() * SUN.area),
        within=1e-9,
    )


@TEXT.item("eq-irradiance", "section 2", "E = dphi / dA")
def irradiance(sheet: Sheet) -> None:
    sheet.claim(
        "irradiance that gonio's sun declares, from its radiance and solid angle",
        "=",
        SUN.irradiance,
        _radiance() * 2 * math.pi * (1 - math.cos(math.atan(SUN.size[0] / 2 / SUN.distance))),
        within=1e-3,
        why=FACING,
    )


@TEXT.item("eq-intensity", "section 2", "I = dphi / domega")
def intensity(sheet: Sheet) -> None:
    sheet.claim(
        "intensity L A of gonio's sun towards the ball, over E d^2",
        "=",
        "1",
        _radiance() * SUN.area / (SUN.irradiance * SUN.distance**2),
        within=1e-9,
    )


@TEXT.item("eq-radiance", "section 2", "L = d2phi / (dA_proj domega)")
def radiance(sheet: Sheet) -> None:
    theta = 0.8
    white = gonio.Lambert(rho=1)
    leaving = float(gray(white)(directions(0.0), directions(theta))) * SUN.irradiance
    sheet.claim(
        "radiance of white Lambert that faces the sun, from 0.8 radians, over E / pi",
        "=",
        "1",
        leaving / (SUN.irradiance / math.pi),
        within=1e-9,
    )


@TEXT.item("eq-projected", "section 2", "dA_proj = dA cos")
def projected(sheet: Sheet) -> None:
    white = gonio.Lambert(rho=1)
    facing, tilted = (directions(math.radians(a)) for a in (0, 60))
    up = directions(0.0)
    ratio = gray(white)(tilted, up) * tilted[2] / (gray(white)(facing, up) * facing[2])
    sheet.claim("light of a lamp at 60 degrees over that from above", "=", "0.5", float(ratio))


@TEXT.item("eq-rendering", "section 3", "the rendering equation")
def rendering(sheet: Sheet) -> None:
    model = gonio.EON(rho=0.8, roughness=0.7)
    for angle in (10, 60, 85):
        theta = math.radians(angle)
        sheet.claim(
            f"radiance under a sky of 1, {angle} degrees: the integral of f cos, over the closed form",
            "=",
            "1",
            albedo_by_quadrature(gray(model), theta) / float(model.albedo(directions(theta))[0]),
            within=1e-9,
        )


@TEXT.item("eq-rendering2", "section 3", "the same without wavelength and time")
def rendering_by_samples(sheet: Sheet) -> None:
    model = gonio.EON(rho=0.8, roughness=0.7)
    theta, count = math.radians(60), 200_000
    wo = directions(theta)
    over = hemisphere(theta)
    exact = over.reflected(gray(model)(over.wi, wo) * _sky(over.wi))
    u = np.random.default_rng(0).random((count, 2))
    wi, pdf = model.sample(wo, u)
    found = gray(model)(wi, wo) * wi[..., 2] * _sky(wi) / np.maximum(pdf, 1e-30)
    sheet.claim(
        "the integral under a sky that is bright above, by 200,000 samples, over a quadrature",
        "=",
        "1",
        float(np.mean(found)) / exact,
        within=5 * float(np.std(found)) / math.sqrt(count) / exact,
        why="five standard errors",
    )


def _sky(wi: Floats) -> Floats:
    return np.asarray(wi[..., 2] ** 4)
