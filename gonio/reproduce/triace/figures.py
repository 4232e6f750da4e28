"""The figures, and the times below them."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

import gonio
from gonio import plot
from gonio.arrays.elementwise import elementwise
from gonio.bake import environment
from gonio.lights import image_light
from gonio.materials import load
from gonio.model import Model
from gonio.parts import distribution, fresnel
from gonio.reproduce.cycles import show_cycles
from gonio.reproduce.measure import Floats, directions, gray
from gonio.reproduce.rendered import Later, Layout, Rendered, Shaded, single_bounce
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.text import Picture
from gonio.reproduce.triace import TEXT, formulas
from gonio.reproduce.triace.equations import N1, N2, rms

CONSOLE = "milliseconds of a PlayStation 3, which nobody here has"


@TEXT.item(
    "1", "Figure 1", "Fresnel of the top (1.33333) and bottom layer (1.5): almost a flat line"
)
def figure_1(sheet: Sheet) -> Picture:
    exact = gonio.TriAceLayered(bottom_fresnel="exact")
    constant = exact.replace(bottom_fresnel="constant", top_transmission="off")
    cos = np.cos(np.radians(np.linspace(0, 90, 181)))
    bottom = plot.reflectances(exact, cos)["lower layer"][:, 0]
    flat = plot.reflectances(constant, cos)["lower layer"][:, 0]
    sheet.claim(
        "largest difference of the bottom layer from its constant, on an axis to 1",
        "<=",
        "0.005",
        float(np.abs(bottom - flat).max()),
        why='"almost a flat line": half a percent of the axis',
    )
    sheet.claim(
        "largest difference from Eq. 4",
        "<=",
        1e-9,
        float(np.abs(bottom[:-1] - formulas.bottom_exact(N1, N2, cos[:-1])).max()),
    )
    for angle in (0, 70, 85):
        at = int(2 * angle)
        sheet.show(
            f"bottom layer at {angle} degrees, over the constant", float(bottom[at] / flat[at])
        )
    models = [exact, constant]
    return Layout(
        [plot.fresnel(models), plot.fresnel(models, log=True, title="the same, log axis")]
    )


def _absorbing(**changed: Any) -> list[Model]:
    base = gonio.TriAceLayered(
        rho=(0.8, 0.75, 0.7), top_shininess=400, bottom_shininess=20, **changed
    )
    tint = np.array([0.06, 0.14, 0.2])
    approximated = base.replace(absorption="linear", bottom_fresnel="constant")
    return [
        base.replace(sigma_a=tuple(tint)),
        approximated.replace(sigma_a=tuple(_modified(tint))),
        approximated,
    ]


def _modified(sigma_a: Floats) -> Floats:
    """The coefficient of Eq. 3 that absorbs as much at 45 degrees, there and back, as Eq. 2 does."""
    outside = math.cos(math.pi / 4)
    inside = math.sqrt(1 - (1 - outside**2) / N1**2)
    return np.asarray((1 - np.exp(-2 * sigma_a / inside)) * outside / 2)


@TEXT.item("2", "Figure 2", "original absorption, approximated, without absorption")
def figure_2(sheet: Sheet) -> Picture:
    exact, linear, _ = _absorbing()
    wi, wo = directions(0.4), directions(0.3, 2.0)
    ratio = linear.eval(wi, wo) / exact.eval(wi, wo)
    sheet.remark(
        "the coefficient of Eq. 3 is modified, as the text has it: equal absorption at 45 degrees"
    )
    sheet.claim(
        "approximated over original, near the normal, blue",
        "=",
        "1",
        float(ratio[2]),
        within=0.15,
        why='"our approximation provides good results"',
    )
    names = ["original", "approximated", "no absorption"]
    return Rendered(_absorbing(), names, [("sun", single_bounce("sun"))])


@TEXT.item("2-times", "Figure 2", "0.53, 0.37, 0.34 ms, and 0.33 ms for a single layer", slow=True)
def times_2(sheet: Sheet) -> None:
    show_cycles(sheet, "triace_2", CONSOLE)


@functools.cache
def _light() -> environment.Environment:
    return environment.load("studio")


def _lacquer(rho: tuple[float, float, float], depth: tuple[float, float, float]) -> Any:
    model = gonio.TriAceLayered(
        rho=rho,
        sigma_a=depth,
        top_shininess=600,
        bottom_shininess=12,
        absorption="linear",
        bottom_fresnel="constant",
    )
    return functools.partial(_layered, model)


def _layered(model: Any, normals: Floats, viewer: Floats) -> Any:
    return environment.layered_light(_light(), model, normals, viewer)


def _single(form: str, n: float, normals: Floats, viewer: Floats) -> Any:
    """A single layer in a picture's light: Schlick's F of the blurred picture, and harmonics below."""
    light, f0, rho = _light(), 0.04, (0.6, 0.35, 0.25)
    alpha = float(elementwise(distribution.blinn_phong_alpha, np.array(n)))
    seen = np.clip(normals @ viewer, 0, 1)[..., None]
    F = elementwise(lambda c: fresnel.F_schlick(c, f0, 1), seen)
    mirrored = 2 * seen * normals - viewer
    below = environment.oren_nayar_light(
        light.harmonics(), normals, viewer, rho=rho, shininess=n, form=form
    )
    return F * light.blurred(alpha).radiance(mirrored) + (1 - f0) * below


@TEXT.item("3a", "Figure 3(a)", "lacquer and coating under image-based light")
def figure_3a(sheet: Sheet) -> Picture:
    sheet.remark(
        "the text has no numbers; its object is not public, so that a sphere stands for it"
    )
    lacquers = {
        "red lacquer": _lacquer((0.6, 0.04, 0.03), (0.02, 0.1, 0.12)),
        "black lacquer": _lacquer((0.02, 0.02, 0.02), (0, 0, 0)),
        "varnished wood": _lacquer((0.4, 0.2, 0.08), (0.02, 0.06, 0.12)),
    }
    return Later(lambda: Shaded(lacquers))


@TEXT.item("3b", "Figure 3(b)", "single against dual layer under image-based light")
def figure_3b(sheet: Sheet) -> Picture:
    sheet.remark("the text has no numbers but the times; its object is not public")
    columns = {
        "single layer": functools.partial(_single, "lambert", 12.0),
        "dual layer": _lacquer((0.6, 0.35, 0.25), (0, 0, 0)),
    }
    return Later(lambda: Shaded(columns))


@TEXT.item(
    "3b-times",
    "Figure 3(b)",
    "3.00 ms for one layer, 4.28 ms for two, image-based light only",
    slow=True,
)
def times_3b(sheet: Sheet) -> None:
    show_cycles(sheet, "triace_3b", CONSOLE)


# --- Oren-Nayar ----------------------------------------------------------------------------------------

SIGMA, RHO = 0.5, 0.9
LIGHTS = (30, 60, 75)


def _variants() -> list[Model]:
    n = formulas.shininess(SIGMA)
    return [
        gonio.OrenNayar(rho=RHO, sigma=SIGMA),
        *(
            gonio.model("triace_oren_nayar", rho=RHO, shininess=n, variant=v)
            for v in ("eq23", "eq24", "eq25")
        ),
    ]


def _against(model: Model) -> Picture:
    """Radiance over E.N, negative where the light comes from behind, as the figures have it."""
    models = [_variants()[0], model]  # blue and red, as in the text
    angles = np.linspace(-89.5, 89.5, 359)
    x = np.where(angles < 0, -1, 1) * np.cos(np.radians(angles))
    middle = int(np.searchsorted(angles, 0))
    panels = []
    for light in LIGHTS:
        wi = directions(math.radians(light))
        curves = []
        for i, one in enumerate(models):
            radiance = gray(one)(wi, directions(np.radians(angles))) * wi[2]
            curves.append(
                plot.Curve(i, np.insert(x, middle, np.nan), np.insert(radiance, middle, np.nan))
            )
        panels.append(
            plot.Panel(
                f"light at {light}°",
                "E·N, negative for backward lighting",
                r"$L_r$ for $E_0 = 1$",
                curves,
            )
        )
    return plot.of_panels(panels, models, "Against the full Oren-Nayar model")


def _rms(model: Model, light: float) -> float:
    wi, wo = directions(math.radians(light)), directions(np.radians(np.linspace(-85, 85, 171)))
    return float(np.sqrt(np.mean((gray(model)(wi, wo) - gray(_variants()[0])(wi, wo)) ** 2)))


SILENT_SIGMA = "sigma is 0.5 and rho 0.9: the text gives rho below Figure 6(a), and no sigma"


@TEXT.item("4", "Figure 4", "the qualitative model (red) against the full one (blue) over E.N")
def figure_4(sheet: Sheet) -> Picture:
    full, eq23, _, _ = _variants()
    sheet.remark(SILENT_SIGMA)
    wi, behind = directions(math.radians(60)), directions(np.radians(np.linspace(-85, -5, 40)))
    flat = gray(eq23)(wi, behind)
    sheet.claim(
        "change of f in backward lighting: as Lambert",
        "<=",
        1e-9,
        float(np.ptp(flat) / flat.mean()),
    )
    front = directions(np.radians(np.linspace(0, 60, 40)))
    darker = float(np.mean(gray(eq23)(directions(math.radians(30)), front)))
    darker /= float(np.mean(gray(full)(directions(math.radians(30)), front)))
    sheet.claim(
        "qualitative over full model, light at 30 degrees", "<=", "1", darker, why="slightly darker"
    )
    return _against(eq23)


@TEXT.item("5", "Figure 5", "Eq. 24 against the full model: still a problem on the left side")
def figure_5(sheet: Sheet) -> Picture:
    full, _, eq24, _ = _variants()
    sheet.remark(SILENT_SIGMA)
    wi, wo = directions(math.radians(60)), directions(math.radians(-80))
    away = float(gray(eq24)(wi, wo) / gray(full)(wi, wo))
    sheet.claim(
        "Eq. 24 over the full model, light at 60, viewer at 80 degrees on the other side",
        "<=",
        "1",
        away,
    )
    return _against(eq24)


@TEXT.item("6a", "Figure 6(a)", "Eq. 25 against the full model, rho 0.9: closer")
def figure_6a(sheet: Sheet) -> Picture:
    _, eq23, eq24, eq25 = _variants()
    sheet.remark(SILENT_SIGMA)
    for light in LIGHTS:
        sheet.show(f"rms from the full model, light at {light} degrees", _rms(eq25, light))
    for name, other in (("23", eq23), ("24", eq24)):
        ratio = max(_rms(eq25, light) for light in LIGHTS) / max(
            _rms(other, light) for light in LIGHTS
        )
        sheet.claim(f"largest rms over that of Eq. {name}", "<=", "1", ratio)
    return _against(eq25)


@TEXT.item(
    "6b", "Figure 6(b)", "the qualitative model beside the improved one: the bottom side is darker"
)
def figure_6b(sheet: Sheet) -> Picture:
    _, eq23, _, eq25 = _variants()
    wi, wo = directions(math.radians(70)), directions(math.radians(-70))
    ratio = float(gray(eq25)(wi, wo) / gray(eq23)(wi, wo))
    sheet.claim("improved over qualitative, lit from behind", "<=", "1", ratio)
    lights = [("side", {"environment": "side"})]
    return Rendered([eq23, eq25], ["qualitative (Eq. 23)", "improved (Eq. 25)"], lights)


@TEXT.item(
    "6c-times", "Figure 6(c)", "0.97 ms for Lambert, 1.25 ms for Oren-Nayar below", slow=True
)
def times_6c(sheet: Sheet) -> None:
    show_cycles(sheet, "triace_6c", CONSOLE)


@TEXT.item("7", "Figure 7", "the integral of Eq. 26 over N.E for sigma 0, 0.25, 0.5, 1")
def figure_7(sheet: Sheet) -> Picture:
    x = np.linspace(0.01, 1, 100)
    curves = []
    models = []
    for i, sigma in enumerate((0.0, 0.25, 0.5, 1.0)):
        n = formulas.shininess(sigma)
        found = elementwise(image_light.in_plane_integral, x, n)
        exact = formulas.in_plane(n, 0.3)
        ours = float(elementwise(image_light.in_plane_integral, 0.3, n))
        sheet.claim(f"sigma {sigma:g}, N.E 0.3, by Gauss's rule", "=", exact, ours, within=1e-9)
        curves.append(plot.Curve(i, x, found))
        models.append(gonio.TriAceOrenNayar(rho=1, shininess=min(n, 1e6)))
    sheet.claim("sigma 0 is Lambert: the integral is flat", "=", "1.0", float(np.mean(curves[0].y)))
    panel = plot.Panel("", "N·E", "integral of Eq. 25", curves)
    return plot.of_panels([panel], models, "Eq. 26 (sigma = sqrt(2 / shininess))")


def _fit(sheet: Sheet, scale: Any, sigma: float, most: float) -> plot.Panel:
    sheet.claim(f"sigma {sigma:g}: rms from the integral", "<=", most, rms(sigma, scale))
    x, n = np.linspace(0.01, 1, 100), formulas.shininess(sigma)
    curves = [
        plot.Curve(0, x, elementwise(image_light.in_plane_integral, x, n), "integral"),
        plot.Curve(0, x, elementwise(scale, x, n), "fit"),
    ]
    return plot.Panel(f"sigma = {sigma:g}", "N·E", "scale of the constant harmonic", curves)


@TEXT.item(
    "8", "Figure 8", "the integral and its fit by Eq. 27, sigma 0.5 and 1", "8-left", "8-right"
)
def figure_8(sheet: Sheet) -> Picture:
    panels = [_fit(sheet, image_light.harmonic_dc_scale, s, 0.03) for s in (0.5, 1.0)]
    return plot.of_panels(panels, [gonio.TriAceOrenNayar()], "Eq. 27")


@TEXT.item(
    "9",
    "Figure 9",
    "the integral and the compromise of Eq. 28, sigma 0.5 and 1",
    "9-left",
    "9-right",
)
def figure_9(sheet: Sheet) -> Picture:
    panels = [_fit(sheet, image_light.harmonic_dc_scale_cheap, s, 0.06) for s in (0.5, 1.0)]
    return plot.of_panels(panels, [gonio.TriAceOrenNayar()], "Eq. 28")


@TEXT.item(
    "10",
    "Figure 10",
    "shape of Oren-Nayar: 0.7 Lambert at N.E 1, comparatively flat at N.E 0, sigma 1",
)
def figure_10(sheet: Sheet) -> None:
    S = functools.partial(elementwise, image_light.harmonic_linear_scale)
    sharp = formulas.shininess(0)
    for x in (1.0, 0.0):
        sheet.claim(f"sigma 0, N.E {x:g}: equivalent to Lambert", "=", "1.0", float(S(x, sharp)))
    rough = formulas.shininess(1)
    sheet.claim("sigma 1, N.E 1", "=", "0.7", float(S(1.0, rough)))
    sheet.claim("sigma 1, N.E 0, comparatively flat", "<=", "0.5", float(S(0.0, rough)))


@TEXT.item("11", "Figure 11", "image-based light: Lambert against Oren-Nayar, with highlight")
def figure_11(sheet: Sheet) -> Picture:
    sheet.remark("the text has no numbers but the times; its object is not public")
    columns = {
        "Blinn-Phong-Lambert": functools.partial(_single, "lambert", 8.0),
        "Blinn-Phong-Oren-Nayar (Eq. 27)": functools.partial(_single, "arccos", 8.0),
        "(Eq. 28)": functools.partial(_single, "cheap", 8.0),
    }
    return Later(lambda: Shaded(columns))


@TEXT.item(
    "11-times",
    "Figure 11",
    "1.35 ms for Lambert, 1.62 ms for Oren-Nayar, image-based light",
    slow=True,
)
def times_11(sheet: Sheet) -> None:
    show_cycles(sheet, "triace_11", CONSOLE)


# --- skin, and all four --------------------------------------------------------------------------------


@TEXT.item(
    "12", "Figure 12", "Blinn-Phong skin, and too much scattering: like wax", "12-left", "12-right"
)
def figure_12(sheet: Sheet) -> Picture:
    sheet.remark(
        "the text has no numbers; no head is public, so that the shader ball stands for it"
    )
    skin = gonio.TriAceBlinnPhong(rho=(0.75, 0.46, 0.35), f0=0.028, shininess=20)
    return _with_and_without(skin, ("Blinn-Phong", "too much scattering"), 0.08, 240)


def _with_and_without(
    shown: Any, labels: tuple[str, str], millimetre: float, size: int, measure: Any = None
) -> Picture:
    """A skin, and beside it with light that wanders: a millimetre in units of the scene."""
    sun = {"environment": "sun"}  # whose shadows have edges for the light to wander across
    rows: list[tuple[str, dict[str, Any]]] = [("", sun), ("", sun | {"diffusion": millimetre})]
    kept: list[Any] = []

    def both(cells: Any) -> None:
        kept.append(cells)
        if measure is not None and len(kept) == 2:
            measure(*kept)

    pictures = [
        Rendered([shown], [label], [row], both, {"size": (size, size)})
        for label, row in zip(labels, rows, strict=True)
    ]
    return Layout(pictures, in_a_row=True)


@TEXT.item("13", "Figure 13", "layered skin, and with a little scattering", "13-left", "13-right")
def figure_13(sheet: Sheet) -> Picture:
    sheet.remark("the text has no numbers: the scattering is to be almost invisible")

    def measure(plain: Any, scattered: Any) -> None:
        change = float(np.abs(scattered - plain).mean() / plain.mean())
        sheet.claim("mean change of the picture", "<=", "0.05", change, why='"almost invisible"')

    return _with_and_without(load("skin"), ("layered", "a little scattering"), 0.01, 320, measure)


@TEXT.item("14", "Figure 14", "the four combinations under one lamp and one image-based light")
def figure_14(sheet: Sheet) -> Picture:
    sheet.remark("the text has no numbers but the times; under the image-based light, on spheres")
    layered = gonio.TriAceLayered(
        rho=(0.6, 0.35, 0.25),
        top_shininess=600,
        bottom_shininess=8,
        absorption="linear",
        bottom_fresnel="constant",
    )
    columns = {
        "Blinn-Phong-Lambert": functools.partial(_single, "lambert", 8.0),
        "Blinn-Phong-Oren-Nayar": functools.partial(_single, "arccos", 8.0),
        "layered, Lambert": functools.partial(_layered, layered),
        "layered, Oren-Nayar": functools.partial(_layered, layered.replace(diffuse="oren_nayar")),
    }
    return Later(lambda: Shaded(columns, 200))


@TEXT.item("14-times", "Figure 14", "6.87, 7.17, 7.55, 7.82 ms", slow=True)
def times_14(sheet: Sheet) -> None:
    show_cycles(sheet, "triace_14", CONSOLE)
