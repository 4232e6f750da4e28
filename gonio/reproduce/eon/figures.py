"""The figures."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np

import gonio
from gonio import plot
from gonio.arrays.elementwise import elementwise
from gonio.model import Model
from gonio.parts import cltc
from gonio.plot.cartesian import single_scattering
from gonio.reproduce.eon import TEXT
from gonio.reproduce.eon.formulas import (
    CLAY,
    HALF_PI,
    degrees,
    qon_coefficients,
    white_eon,
)
from gonio.reproduce.eon.shared import fit_error, loss_difference
from gonio.reproduce.measure import (
    albedo_by_quadrature,
    directions,
    drawn,
    gray,
    weights,
)
from gonio.reproduce.rendered import (
    ALL_BOUNCES,
    BOUNCES,
    Later,
    Layout,
    Rendered,
    furnace,
    middle,
    single_bounce,
)
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.text import Picture


def _three(rho: Any) -> list[Model]:
    return [
        gonio.Lambert(rho=rho),
        gonio.QON(rho=rho, sigma=HALF_PI),
        gonio.EON(rho=rho, roughness=1),
    ]


@TEXT.item("1", "Figure 1", "Lambert, QON and EON at full roughness, front- and side-lit")
def figure_1(sheet: Sheet) -> Picture:
    lambert, qon, eon = (float(m.mean_albedo()[0]) for m in _three(0.75))
    sheet.show("mean albedo of QON over Lambert's, rho 0.75", qon / lambert)
    sheet.show("mean albedo of EON over Lambert's, rho 0.75", eon / lambert)
    closer = abs(eon / lambert - 1) / abs(qon / lambert - 1)
    sheet.claim(
        "how much of QON's darkening EON has",
        "<=",
        "0.5",
        closer,
        why='"similar brightness to the Lambert model" is read as less than half of what QON lacks',
    )
    rows = [(f"{e}-lit", {"environment": e}) for e in ("front", "side")]
    return Rendered(_three(CLAY), ["Lambert", "QON", "EON"], rows)


@TEXT.item(
    "2", "Figure 2", "back-scattering of smooth and rough diffuse models, lit from the viewer"
)
def figure_2(sheet: Sheet) -> Picture:
    """The rough models are flat: darker in the middle, against their edge, than Lambert."""
    models = {
        "lambert": gonio.Lambert(),
        "QON": gonio.QON(sigma=HALF_PI),
        "FON": gonio.FON(roughness=1),
        "EON": gonio.EON(roughness=1),
    }
    edge, centre = directions(math.radians(75)), directions(0)
    fall = {
        n: float(m.eval(edge, edge)[0] * edge[2] / m.eval(centre, centre)[0])
        for n, m in models.items()
    }
    for name, value in fall.items():
        if name != "lambert":
            sheet.claim(
                f"{name}: radiance at 75 degrees over that at the centre, over Lambert's",
                ">=",
                "1",
                value / fall["lambert"],
                why="flat and bright compared to the Lambertian model",
            )
    return Rendered(
        list(models.values()), list(models), [("lit from the viewer", {"environment": "front"})]
    )


def _models_of_figure_3(rho: Any) -> list[Model]:
    """80 % albedo and 50 % roughness: sigma = pi / 4 or r = 1 / 2."""
    sigma = math.pi / 4
    return [
        gonio.Lambert(rho=rho),
        gonio.OrenNayar(rho=rho, sigma=sigma),
        gonio.QON(rho=rho, sigma=sigma),
        gonio.model("qon_footnote", rho=rho, sigma=sigma),
        gonio.model("qon_fujii", rho=rho, sigma=sigma),
        gonio.FON(rho=rho, roughness=0.5),
        gonio.EON(rho=rho, roughness=0.5),
    ]


@TEXT.item(
    "3", "Figure 3", "f cos of seven models against the angle, 80 % albedo and 50 % roughness"
)
def figure_3(sheet: Sheet) -> Picture:
    models = _models_of_figure_3(0.8)
    retro = {m.name: float(m.eval(directions(1.31), directions(1.31))[0]) for m in models}
    flat = {m.name: float(m.eval(directions(0), directions(1.31))[0]) for m in models}
    sheet.claim(
        "full model: peak at wi = wo over the value at the normal, viewer at 75 degrees",
        ">=",
        "1",
        retro["oren_nayar"] / flat["oren_nayar"],
        why='"the back-scattering peak is most prominent in the grazing configuration"',
    )
    back = directions(-1.31)
    away = {m.name: float(m.eval(back, directions(1.31))[0]) for m in models}
    sheet.claim(
        "QON over the full model, lit from behind at 75 degrees",
        ">=",
        "1",
        away["qon"] / away["oren_nayar"],
        why='"overly bright when backlit"',
    )
    return plot.cartesian(models, theta_o=(0, 30, 60, 75))


@TEXT.item("4", "Figure 4", "all models of Figure 3 on one object")
def figure_4(sheet: Sheet) -> Picture:
    models = _models_of_figure_3(CLAY)
    sheet.remark(
        "the text has no numbers; its object is not public, so that the shader ball stands for it"
    )
    brightness = {m.name: float(m.mean_albedo().mean()) for m in models}
    for name, value in brightness.items():
        sheet.show(f"mean albedo of {name}", value)
    names = ["Lambert", "full ON", "QON", "footnote QON", "Fujii QON", "FON", "EON"]
    rows = [(f"{e}-lit", {"environment": e}) for e in ("front", "side")]
    return Rendered(models, names, rows, common={"size": (176, 176)})


LARGE = {"size": (320, 320)}


def _pair(rough: Model, white: Model, sheet: Sheet, loses: bool, bounces: int = BOUNCES) -> Picture:
    """A single bounce of a directional light, and a furnace."""
    albedo = float(white.mean_albedo()[0])
    if loses:
        sheet.claim(
            "mean albedo of the white surface",
            "<=",
            "0.95",
            albedo,
            why="loses a significant amount",
        )
    else:
        sheet.claim("mean albedo of the white surface", "=", "1.000", albedo)

    def measure(cells: Any) -> None:
        seen = float(middle(cells[0, 0]).mean())
        if loses:
            sheet.claim("radiance of the ball in the furnace of 1", "<=", "0.95", seen)
        else:
            sheet.claim("radiance of the ball in the furnace of 1", "=", "1.00", seen)

    lit = Rendered([rough], ["single bounce"], [("", single_bounce("sun"))], common=LARGE)
    lost = Rendered([white], ["furnace"], [("", furnace(bounces))], measure, LARGE)
    return Layout([lit, lost], in_a_row=True)


@TEXT.item(
    "5",
    "Figure 5",
    "QON at sigma = pi / 2: single bounce, and furnace of 50 bounces",
    "5-left",
    "5-right",
)
def figure_5(sheet: Sheet) -> Picture:
    white = gonio.QON(rho=1, sigma=HALF_PI)
    return _pair(gonio.QON(rho=CLAY, sigma=HALF_PI), white, sheet, loses=True)


@TEXT.item(
    "8", "Figure 8", "FON at r = 1: single bounce, and under a uniform sky", "8-left", "8-right"
)
def figure_8(sheet: Sheet) -> Picture:
    fon, qon = gonio.FON(rho=1, roughness=1), gonio.QON(rho=1, sigma=HALF_PI)
    better = float(fon.mean_albedo()[0] / qon.mean_albedo()[0])
    sheet.claim(
        "mean albedo over QON's", ">=", "1", better, why="performs better on the furnace test"
    )
    return _pair(gonio.FON(rho=CLAY, roughness=1), fon, sheet, loses=True)


@TEXT.item(
    "9", "Figure 9", "EON at r = 1: single bounce, and under a uniform sky", "9-left", "9-right"
)
def figure_9(sheet: Sheet) -> Picture:
    sheet.remark("the furnace has 256 bounces, as the ball's cavity needs; the paper's sky is open")
    rough, white = gonio.EON(rho=CLAY, roughness=1), white_eon(roughness=1)
    return _pair(rough, white, sheet, loses=False, bounces=ALL_BOUNCES)


def _dots_lie_on_lines(sheet: Sheet, model: Model) -> None:
    worst = max(
        abs(albedo_by_quadrature(gray(model), t) - float(model.albedo(directions(t))[0]))
        for t in np.radians([0, 20, 45, 70, 85, 89])
    )
    sheet.claim(
        f"{model.name}: largest distance of a quadrature's dot from the formula's line",
        "<=",
        1e-6,
        worst,
        why="the lines are the analytical formula, the dots the numerically evaluated integral",
    )


@TEXT.item(
    "6", "Figure 6", "albedos of QON over the angle and over sigma, rho = 1", "6-left", "6-right"
)
def figure_6(sheet: Sheet) -> Picture:
    models = [gonio.QON(rho=1, sigma=s) for s in (0.1, 0.2, 0.5, 1, HALF_PI)]
    for model in (models[1], models[-1]):
        _dots_lie_on_lines(sheet, model)
    A, B = qon_coefficients(HALF_PI)
    sheet.claim(
        "mean albedo at sigma = pi / 2 by Eq. 9",
        "=",
        A + B * (2 / 3 - 64 / (45 * math.pi)),
        float(models[-1].mean_albedo()[0]),
        within=1e-6,
        why="float32",
    )
    return Later(lambda: plot.albedo(models, dots=True))


@TEXT.item("7", "Figure 7", "albedos of FON, and its fit's error", "7-left", "7-centre", "7-right")
def figure_7(sheet: Sheet) -> Picture:
    models = [gonio.FON(rho=1, roughness=r) for r in (0.25, 0.5, 1)]
    _dots_lie_on_lines(sheet, models[-1])
    rough = models[-1]
    sheet.claim("albedo in the horizon", "=", "1.000", float(rough.albedo(np.array([1, 0, 0]))[0]))
    sheet.claim(
        "loss at r = 1, on average",
        "=",
        "0.2",
        1 - float(rough.mean_albedo()[0]),
        within=0.05,
        why='"approximately 20 %", between 15 and 25',
    )
    sheet.show("loss at r = 1, at the normal", 1 - float(rough.albedo(directions(0))[0]))
    fit_error(sheet)
    theta = np.radians(np.linspace(0, 89.9, 181))
    error = plot.Panel(
        "exact albedo less its fit",
        r"angle of the viewer $\theta_o$  [degrees]",
        "$E$ (Eq. 13) − $E$ (Eq. 14)  [%]",
        [
            plot.Curve(i, np.degrees(theta), 100 * loss_difference(r, theta))
            for i, r in enumerate((0.25, 0.5, 1))
        ],
        scale=plot.DEGREES,
        lines=[(0.0, "")],
    )
    return Layout(
        [
            Later(lambda: plot.albedo(models, dots=True)),
            plot.of_panels([error], models, "Error of the fit"),
        ]
    )


@TEXT.item(
    "10", "Figure 10", "QON beside the single and multiple scattering of EON, several albedos"
)
def figure_10(sheet: Sheet) -> Picture:
    colour = np.array(CLAY)
    eon = gonio.EON(rho=CLAY, roughness=1)
    wi, wo = directions(0.5), directions(0.9, 2.0)
    multiple = eon.eval(wi, wo) - single_scattering(eon).eval(wi, wo)
    saturation = [float(v[2] / v[0]) for v in (colour, multiple)]
    sheet.claim(
        "blue over red of multiple scattering, over that of rho",
        "<=",
        "1",
        saturation[1] / saturation[0],
        why="multiple scattering is more saturated",
    )
    colours = [CLAY, (0.3, 0.55, 0.8), (0.85, 0.85, 0.85)]
    lit = ("QON", "single", "multiple")

    class Orders:
        """Pictures of one bounce are linear in f: multiple is the whole less single, at the same seed."""

        def save(self, output: Any) -> Any:
            from gonio.render.picture import write_picture

            rows = []
            for rho in colours:
                whole = gonio.EON(rho=rho, roughness=1)
                shown = [gonio.QON(rho=rho, sigma=HALF_PI), single_scattering(whole), whole]
                settings = {"size": (224, 224)}
                row = [("", single_bounce("side"))]
                cells = Rendered(shown, [""] * 3, row, common=settings).cells()[0]
                rows.append(
                    np.concatenate([cells[0], cells[1], np.maximum(cells[2] - cells[1], 0)], 1)
                )
            labels = [f"{n} scattering" if n != "QON" else n for n in lit]
            write_picture(output, np.concatenate(rows), labels=labels)
            return output

    return Layout([Orders(), plot.scattering([gonio.EON(rho=c, roughness=1) for c in colours])])


PAPER_SAMPLERS = ("cosine", "uniform", "ltc_nonnegative", "ltc", "cltc", "cltc_uniform")


@TEXT.item(
    "11",
    "Figure 11",
    "variance, maximum and mean of the weight over the angle, six samplers, 10^6 samples",
    "11-left",
    "11-centre",
    "11-right",
)
def figure_11(sheet: Sheet) -> Picture:
    models = {s: white_eon(roughness=1, sampler=s) for s in (*PAPER_SAMPLERS, "cltc_matched")}
    for sampler, model in models.items():
        for angle, theta in degrees(0, 60, 89):
            found = drawn(model, theta, 100_000)
            sheet.show(
                f"{sampler} at {angle:g} degrees: variance of 100,000 samples", found.variance
            )
    highest = {
        (s, a): drawn(models[s], t, 200_000).highest
        for s, (a, t) in itertools.product(("cosine", "cltc", "cltc_uniform"), degrees(60, 89))
    }
    sheet.claim(
        "CLTC alone: maximum weight over that of uniform sampling, 60 degrees",
        ">=",
        "1",
        highest["cltc", 60] / drawn(models["uniform"], math.radians(60), 200_000).highest,
        why="generates high outliers of throughput weight compared to uniform sampling",
    )
    sheet.claim(
        "CLTC + uniform over CLTC: maximum weight at 89 degrees",
        "<=",
        "1",
        highest["cltc_uniform", 89] / highest["cltc", 89],
        why="with MIS the maximum throughput weight is reduced",
    )
    for sampler in ("ltc", "cltc"):
        sheet.claim(
            f"{sampler}: mean weight at 89 degrees",
            "<=",
            "1",
            weights(models[sampler], math.radians(89)).mean,
            why="a slight bias: directions where the lobe is zero but the BRDF is not",
        )
    for sampler in ("cosine", "uniform", "cltc_uniform"):
        mean = weights(models[sampler], math.radians(89)).mean
        sheet.claim(f"{sampler}: mean weight at 89 degrees", "=", "1.000", mean)
    return Later(lambda: plot.sampling(list(models.values())))


@TEXT.item("12", "Figure 12", "geometry of CLTC: the lobe, the clipped hemisphere, the transform")
def figure_12(sheet: Sheet) -> Picture:
    mu, r = math.cos(math.radians(85)), 1.0
    d = elementwise(lambda m: cltc.coefficients(m, 1 - m, r)[3], np.array([mu]))[0]
    sheet.claim(
        "area that clipping keeps of the unit disk, from 4,000,000 points",
        "=",
        (1 + 1 / math.sqrt(1 + d * d)) / 2,
        _kept_area(d),
        within=1e-3,
        why="Eq. 28; five times the error of so many points",
    )
    sheet.remark(
        "above: samples in the unit disk that the hemisphere projects to, the viewer to the right; those "
        "below the horizon are hollow. Below: their densities in the plane of incidence"
    )
    lobes = [white_eon(roughness=1, sampler=s) for s in ("ltc", "cltc", "cltc_uniform", "cosine")]
    theta_o = math.radians(85)
    return Layout([_Projected(tuple(lobes), theta_o), _densities(lobes, theta_o)])


@dataclasses.dataclass(frozen=True)
class _Projected:
    """Nusselt's projection of samples: equal areas of the disk hold equal cosine-weighted solid angles."""

    models: tuple[Model, ...]
    theta_o: float

    def save(self, output: str | Path) -> Path:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(3 * len(self.models), 3.4), dpi=100, layout="constrained")
        panels = figure.subplots(1, len(self.models))
        u = np.random.default_rng(0).random((3000, 2))
        for panel, model in zip(panels, self.models, strict=True):
            wi, _ = model.sample(directions(self.theta_o), u)
            x, y, z = np.asarray(wi, float).T
            panel.scatter(x[z > 0], y[z > 0], s=1.5, color="#0072b2", linewidths=0)
            panel.scatter(x[z <= 0], y[z <= 0], s=5, facecolors="none", edgecolors="#d55e00")
            turn = np.linspace(0, 2 * np.pi, 200)
            panel.plot(np.cos(turn), np.sin(turn), color="#222222", linewidth=0.8)
            panel.plot(math.sin(self.theta_o), 0, marker="x", color="#222222")
            panel.set_title(str(getattr(model, "sampler")), fontsize=11)  # noqa: B009
            panel.set_aspect("equal")
            panel.axis("off")
        figure.savefig(output)
        return Path(output)


def _kept_area(d: float) -> float:
    """Of the unit disk: points whose direction lies above the plane z + d x = 0."""
    x, y = np.random.default_rng(0).uniform(-1, 1, (2, 5_000_000))
    inside = x * x + y * y < 1
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    return float(np.mean((z + d * x > 0)[inside]))


def _densities(models: list[Model], theta_o: float) -> Picture:
    angles = np.linspace(-90, 90, 721)
    wi, wo = directions(np.radians(angles)), directions(theta_o)
    curves = [plot.Curve(i, angles, np.asarray(m.pdf(wi, wo), float)) for i, m in enumerate(models)]
    panel = plot.Panel(
        f"viewer at {math.degrees(theta_o):g}°",
        r"angle of the light $\theta_i$  [degrees]",
        "density  [1/sr]",
        curves,
        scale=plot.SIGNED,
        ylim=(0, None),
    )
    return plot.of_panels([panel], models, "Densities in the plane of incidence")


@TEXT.item(
    "13",
    "Figure 13",
    "variance and maximum weight for several r, CLTC + uniform against cosine",
    "13-left",
    "13-right",
)
def figure_13(sheet: Sheet) -> Picture:
    for sampler in ("cltc_uniform", "cosine"):
        still = weights(white_eon(roughness=0, sampler=sampler), math.radians(80))
        sheet.claim(f"{sampler} at r = 0: weight", "=", "1.000", still.highest)
        sheet.claim(f"{sampler} at r = 0: variance", "=", "0.000", still.variance)
    angles = np.radians([0, 30, 60, 80, 85, 89])
    for r in (0.25, 1.0):
        peak = {
            s: max(weights(white_eon(roughness=r, sampler=s), t).variance for t in angles)
            for s in ("cltc_uniform", "cosine")
        }
        sheet.claim(
            f"r = {r:g}: peak of the variance over that of cosine sampling, up to 89 degrees",
            "<=",
            "0.5",
            peak["cltc_uniform"] / peak["cosine"],
            why='"much lower" is read as less than half',
        )
    grid = itertools.product((0.1, 0.2, 0.4, 0.6, 0.8, 1.0), np.radians([30, 60, 72, 75, 80, 89]))
    highest = max(
        weights(white_eon(roughness=r, sampler="cltc_uniform"), t).highest for r, t in grid
    )
    sheet.show("largest maximum weight of CLTC + uniform", highest)
    roughnesses = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)
    names = {"cltc_uniform": "CLTC + uniform", "cosine": "cosine"}

    def curves(sampler: str) -> Picture:
        models = [white_eon(roughness=r, sampler=sampler) for r in roughnesses]
        return plot.sampling(models, title=names[sampler])

    return Layout([Later(functools.partial(curves, sampler)) for sampler in names])


@TEXT.item("14", "Figure 14", "EON at r = 1 by cosine and by CLTC sampling, 50 samples, 50 bounces")
def figure_14(sheet: Sheet) -> Picture:
    samplers = ("cosine", "cltc_uniform", "cltc_matched")

    def measure(cells: Any) -> None:
        noise = [float(np.var(middle(cell))) for cell in cells[0]]
        sheet.claim(
            "pixel variance of cosine sampling over that of CLTC + uniform",
            ">=",
            "1",
            noise[0] / noise[1],
            why="the variance reduction of CLTC sampling in renders",
        )
        sheet.show(
            "pixel variance of CLTC + uniform over that of gonio's default", noise[1] / noise[2]
        )

    labels = ["cosine", "CLTC + uniform", "gonio's default"]
    models = [white_eon(roughness=1, sampler=s) for s in samplers]
    return Rendered(models, labels, [("", furnace())], measure, {"spp": 50})
