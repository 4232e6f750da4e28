"""The figures."""

from __future__ import annotations

import dataclasses
import functools
import math
from pathlib import Path
from typing import Any

import numpy as np

import gonio
from gonio import plot
from gonio.arrays.elementwise import elementwise
from gonio.bake import tables
from gonio.materials import Material, load
from gonio.mitsuba import textures
from gonio.model import Model
from gonio.parts import metals, tilt
from gonio.reproduce.elek import TEXT, formulas
from gonio.reproduce.measure import Floats, directions, gray, hemisphere
from gonio.reproduce.rendered import Later, Rendered, Shade, Shaded, single_bounce
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.text import Picture

# A shader shows what a lamp's light does at its first reflection, and no more.
SUN = [("", single_bounce("sun"))]


def _over_metal(alpha: float, below: float, clamp: str = "on") -> Model:
    metal = gonio.TorranceSparrow(alpha=below)
    return gonio.model("weidlich_wilkie", alpha=alpha, base=metal, roughness_clamp=clamp)


def half_width(model: Model) -> float:
    """Angle at which a lobe around the normal has fallen to half of its peak, in degrees."""
    theta = np.radians(np.linspace(0, 80, 801))
    values = gray(model)(directions(theta), directions(0))
    return float(np.degrees(theta[np.argmax(values < values[0] / 2)]))


@TEXT.item(
    "2",
    "Figure 2",
    "the coat's roughness shapes the reflection below, m2 = 0.3; m1 = 0.4 over 0.05 uncorrected",
    "2-left",
    "2-right",
)
def figure_2(sheet: Sheet) -> Picture:
    narrow, clamped, free = (
        _over_metal(0.05, 0.3),
        _over_metal(0.4, 0.05),
        _over_metal(0.4, 0.05, "off"),
    )
    sheet.claim(
        "half width of the corrected lobe over the uncorrected one's",
        ">=",
        "1",
        half_width(clamped) / half_width(free),
    )
    rough = float(half_width(_over_metal(0.4, 0.3)) / half_width(narrow))
    sheet.claim("half width under a coat of 0.4 over that under 0.05, m2 = 0.3", ">=", "1", rough)
    columns = [narrow, _over_metal(0.3, 0.3), _over_metal(0.6, 0.3), clamped, free]
    names = ["m1 0.05", "m1 0.3", "m1 0.6", "0.4 over 0.05", "uncorrected"]
    return Rendered(columns, names, SUN, common={"size": (176, 176)})


def printed_albedo(theta: float) -> float:
    """Of Eq. 2 to 4 over white Lambert, by quadrature of the printed formulas."""
    over = hemisphere(theta, 48)
    wo = np.broadcast_to(directions(theta), over.wi.shape)
    lambert = functools.partial(lambda i, o: np.full(i.shape[:-1], 1 / math.pi))
    return over.reflected(
        formulas.layered(1.5, 0.3, 0.0, lambert, over.wi.copy(), wo.copy(), formulas.conductor)
    )


@TEXT.item(
    "3", "Figure 3", "the only qualitative difference from Monte Carlo is global illumination"
)
def figure_3(sheet: Sheet) -> Picture:
    model = gonio.WeidlichWilkie(eta=1.5, alpha=0.3, base=gonio.Lambert(rho=1))
    for angle in (0, 75):
        theta = math.radians(angle)
        sheet.refute(
            f"albedo over white Lambert at {angle} degrees; a random walk that absorbs nothing returns 1",
            "=",
            "1.00",
            float(model.albedo(directions(theta))[0]),
            proof=printed_albedo(theta),
            within=5e-3,
            why="the integral of Eq. 2 to 4 itself: without the spreading of solid angles and "
            "with one crossing "
            "at the half vector its energy is not that of the walk",
        )
    truth = gonio.reference.Stack.of(model)
    return Rendered([model, truth], ["Eq. 2 to 4", "random walks"], [("", {"environment": "side"})])  # type: ignore[list-item]


def mip_level(table: tables.Table, level: int) -> tables.Table:
    """A table in half its size, so many times: what a texture unit takes of a picture seen from afar."""
    for _ in range(level):
        table = (
            table[::2, ::2] + table[1::2, ::2] + table[::2, 1::2] + table[1::2, 1::2]
        ) / np.float32(4)
    return table


@TEXT.item(
    "4", "Figure 4", "a highlight of m1 = 0.01 from a table of D: linear, non-linear, in full"
)
def figure_4(sheet: Sheet) -> Picture:
    linear, curved = (tables.distribution_table("beckmann", exponent=e) for e in (1, 8))
    error = {
        e: tables.distribution_error(t, "beckmann", e, 0.01) for e, t in ((1, linear), (8, curved))
    }
    sheet.claim(
        "linear: largest error over the peak", ">=", "0.01", error[1].largest, why="visible"
    )
    sheet.claim("u^8: the same", "<=", "0.004", error[8].largest, why="less than a step of 8 bits")
    smaller = mip_level(curved, 3)
    sheet.claim(
        "u^8, MIP-mapped to an eighth: the same",
        ">=",
        "0.004",
        tables.distribution_error(smaller, "beckmann", 8, 0.01).largest,
    )
    model = gonio.TorranceSparrow(alpha=0.01, distribution="beckmann", fresnel="white")
    angles = np.linspace(0, 3, 400)
    theta = np.radians(angles)
    m = directions(theta)
    curves = [
        plot.Curve(0, angles, plot.facet_terms(model, m, m)["D"], "in full"),
        plot.Curve(0, angles, tables.look_up_distribution(curved, theta, 0.01, 8), "u^8"),
        plot.Curve(0, angles, tables.look_up_distribution(linear, theta, 0.01, 1), "linear"),
        plot.Curve(0, angles, tables.look_up_distribution(smaller, theta, 0.01, 8), "u^8, MIP"),
    ]
    panel = plot.Panel("m = 0.01", r"$\theta_m$  [degrees]", "$D$  [1/sr]", curves)
    return plot.of_panels([panel], [model], "D from tables")


M, SYMBOL = 0.15, "Cu"


def _copper(use_tables: bool, light: Floats, normals: Floats, viewer: Floats) -> Any:
    """A sphere of copper under one lamp, in the paper's terms."""
    index = metals.metal(SYMBOL)
    h = light + viewer
    h = h / np.linalg.norm(h)
    cos_n, cos_h = np.clip(normals @ h, 1e-3, 1), float(viewer @ h)
    i, o = (np.clip(normals @ w, 1e-3, 1) for w in (light, viewer))
    if use_tables:
        D = tables.look_up_distribution(_d_table(), np.arccos(cos_n), M)
        F = tables.look_up_fresnel(tables.fresnel_table(index["eta"], index["k"]), cos_h)
    else:
        D = formulas.D(M, cos_n) / math.pi
        F = np.array(
            [
                formulas.conductor(np.array(cos_h), e, k)
                for e, k in zip(index["eta"], index["k"], strict=True)
            ]
        )
    G = np.minimum(1, 2 * cos_n * np.minimum(i, o) / cos_h)
    return (F * (D * G / (4 * o) * (normals @ light > 0))[..., None]) * 2


@functools.cache
def _d_table() -> Any:
    return tables.distribution_table("beckmann")


@TEXT.item(
    "5", "Figure 5", "full evaluation against tables of F and D: the largest error is below 6 %"
)
def figure_5(sheet: Sheet) -> Picture:
    light = directions(0.7, 1.0)
    normals = directions(*np.meshgrid(np.linspace(0, 1.5, 200), np.linspace(0, 6.28, 100)))
    viewer = np.array([0.0, 0.0, 1.0])
    full, table = (_copper(t, light, normals, viewer) for t in (False, True))
    sheet.claim(
        "largest difference over the brightest pixel",
        "<=",
        "0.06",
        float(np.abs(full - table).max() / full.max()),
    )
    columns: dict[str, Shade] = {
        "full": functools.partial(_copper, False, light),
        "precomputed": functools.partial(_copper, True, light),
        "100 times the difference": lambda n, v: (
            100 * np.abs(_copper(False, light, n, v) - _copper(True, light, n, v))
        ),
    }
    return Shaded(columns)


NO_NUMBERS = (
    "the text has no numbers; its object is not public, so that the shader ball stands for it"
)


def _material(name: str) -> Material:
    found = load(name)
    return found if isinstance(found, Material) else Material(name, found)


def _changed(name: str, **values: Any) -> Material:
    material = _material(name)
    return dataclasses.replace(material, model=material.model.replace(**values))


@TEXT.item("6-left", "Figure 6", "sparkling on metallic paint")
def figure_6_left(sheet: Sheet) -> Picture:
    sheet.remark(NO_NUMBERS)
    return Rendered([_material("car_paint_silver_strong")], [""], SUN, common={"size": (400, 400)})


@dataclasses.dataclass(frozen=True)
class _Maps:
    """Maps of numbers as grey or coloured pictures, side by side."""

    maps: tuple[Floats, ...]

    def save(self, output: str | Path) -> Path:
        from PIL import Image

        cells = [m if m.ndim == 3 else np.repeat(m[..., None], 3, 2) for m in self.maps]
        sheet = np.concatenate(cells, axis=1)
        Image.fromarray(np.uint8(np.clip(sheet, 0, 1) * 255)).resize(
            (len(cells) * 512, 512), Image.Resampling.NEAREST
        ).save(output)
        return Path(output)


@TEXT.item("6-right", "Figure 6", "height field of the flakes and its normal map")
def figure_6_right(sheet: Sheet) -> Picture:
    slopes = np.asarray(textures.flake_map(128), float)
    normals = np.concatenate([slopes, np.ones((*slopes.shape[:2], 1))], -1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    tilted = np.degrees(np.arccos(normals[..., 2]))
    sheet.show("mean tilt of the flakes [degrees]", float(tilted[tilted > 0.1].mean()))
    sheet.remark(
        "gonio makes the slopes of each flake at once, without a height field: their sizes, and the normals"
    )
    return _Maps((np.hypot(*np.moveaxis(slopes, -1, 0)), 0.5 + 0.5 * normals))


@TEXT.item(
    "7",
    "Figure 7",
    "four distances, and without the correction: flakes even out",
    "7-middle",
    "7-right",
)
def figure_7(sheet: Sheet) -> Picture:
    slope = math.tan(math.radians(30))
    tilts = []
    for distance in (1.0, 4.0, 16.0):
        x, z = (
            float(elementwise(lambda s, d, i=i: tilt.flake_normal(s, 0 * s, d)[i], slope, distance))
            for i in (0, 2)
        )
        tilts.append(math.degrees(math.atan2(x, z)))
        sheet.show(f"tilt of a flake of 30 degrees at distance {distance:g} [degrees]", tilts[-1])
    sheet.claim(
        "tilt at distance 16 over that at 1",
        "<=",
        "0.5",
        tilts[2] / tilts[0],
        why="smooth from distance",
    )
    sheet.remark(
        "the camera stays, and the distance is given: so the evening out is seen by itself"
    )
    paints = [_changed("car_paint_silver_strong", distance=d) for d in (1, 4, 16, 64)]
    names = ["distance 1 (uncorrected)", "4", "16", "64"]
    return Rendered(paints, names, SUN)


PRINTED_EXTENTS = ("-0.65", "-0.05", "0.15", "0.45", "0.75", "1.65")


def _number(material: Material, name: str) -> float:
    return float(getattr(material.model, name))


@TEXT.item("8", "Figure 8", "patina over the extent: -0.65 to 1.65, transition 0.65")
def figure_8(sheet: Sheet) -> Picture:
    patinas = [_material(f"patina_{n}") for n in range(1, 7)]
    for text, patina in zip(PRINTED_EXTENTS, patinas, strict=True):
        sheet.claim(
            f"extent of {patina.name}",
            "=",
            text,
            _number(patina, "extent"),
            within=1e-9,
        )
        sheet.claim("its transition", "=", "0.65", _number(patina, "transition"), within=1e-9)
    first, last = (1 - formulas.smoothstep(e - 0.65, e + 0.65, 0.5) for e in (-0.65, 1.65))
    sheet.claim("extentFactor at -0.65: nothing has grown", "=", "0", first, within=1e-9)
    sheet.claim("extentFactor at 1.65: all has", "=", "1", last, within=1e-9)
    return Rendered(patinas, list(PRINTED_EXTENTS), common={"size": (176, 176)})


@TEXT.item("9-left", "Figure 9", "the grey map of the growth")
def figure_9_left(sheet: Sheet) -> Picture:
    growth = np.asarray(textures.growth_picture(128), float)
    sheet.show("lowest value", float(growth.min()))
    sheet.show("highest value", float(growth.max()))
    sheet.remark(
        "the paper's map belongs to its object; gonio's is made of noise, or of a mesh's cavities"
    )
    return _Maps((growth,))


@TEXT.item("9-right", "Figure 9", "transition 0.9: blurry, 0.2: sharp")
def figure_9_right(sheet: Sheet) -> Picture:
    def mixed(transition: float) -> float:
        """Share of an even map that is neither bare nor grown."""
        values = np.linspace(0, 1, 1001)
        grown = [1 - formulas.smoothstep(0.5 - transition, 0.5 + transition, v) for v in values]
        return float(np.mean([0.05 < g < 0.95 for g in grown]))

    sheet.claim(
        "share between bare and grown, transition 0.9 over 0.2", ">=", "1", mixed(0.9) / mixed(0.2)
    )
    models = [_changed("patina_4", extent=0.5, transition=t) for t in (0.9, 0.2)]
    return Rendered(models, ["transition 0.9", "0.2"])


@TEXT.item(
    "10",
    "Figure 10",
    "paint with strong sparkling, orange and purple lacquer, varnished concrete",
    "10-left",
    "10-middle",
    "10-right",
)
def figure_10(sheet: Sheet) -> Picture:
    sheet.remark(NO_NUMBERS)
    orange = _material("orange_lacquer")
    thin, thick = (
        orange.model.replace(thickness=t).eval(directions(0.3), directions(0.3, 2))
        for t in (0.3, 1.0)
    )
    sheet.claim(
        "blue under the thick lacquer over blue under the thin",
        "<=",
        "1",
        float(thick[2] / thin[2]),
        why="varying upper layer thickness",
    )
    names = ("car_paint_red_strong", "orange_lacquer", "purple_lacquer", "blue_varnished_concrete")
    return Later(
        lambda: Rendered([_material(n) for n in names], [n.replace("_", " ") for n in names], SUN)
    )
