"""Published fits of measured materials: data made from their numbers, and the numbers found again.

Collected in tables of one line for each material, which lie beside the repository; without them the tests
that read them are left out, and the materials written down here are fitted alone.
"""

from __future__ import annotations

import functools
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gonio
from gonio import fit, measured
from gonio.measured.formats.csv import directions
from gonio.model import Model

FOLDER = Path(__file__).resolve().parent.parent.parent / "shared/samples/fits"

# Of each value, and directions.
NOISE, POINTS = 0.02, 1500

# Some tables have 1e-15 where their authors' solvers ended at 0.
ZERO = 1e-6

Numbers = dict[str, Any]


@dataclass(frozen=True)
class Family:
    """A table of fits, as one of gonio's models."""

    line: str
    """A material of the table, for machines without it."""
    truth: Callable[[Numbers], Model]
    begin: str
    fixed: tuple[str, ...] = ()
    tied: tuple[tuple[str, ...], ...] = ()


def lobe(text: str, weights: Any, diffuse: Any, **numbers: Any) -> Model:
    """Lambert and one lobe, as the model of a sum."""
    model = gonio.load(text)
    assert isinstance(model, Model)
    second = model.second.replace(**numbers)
    first = model.first.replace(rho=diffuse)
    return model.replace(first=first, second=second, first_weight=1.0, second_weight=weights)


COOK = "lambert+torrance_sparrow:distribution=beckmann,masking=cook_torrance,fresnel="
BLINN = "lambert+torrance_sparrow:distribution=blinn_phong,masking=implicit,fresnel=white"
ROUND = ("second.anisotropy", "first_weight")


def four(weights: Any) -> Any:
    """The tables leave a factor out: D G / (mu_i mu_o) without the 4."""
    return tuple(min(4 * w, 1.0) for w in weights)


FAMILIES = {
    "ngan_ward": Family(
        "Lambertian(albedo = [0.267, 0.0384, 0.00604]), "
        "NganWard(albedo = [0.0433, 0.0349, 0.0241], roughness = 0.25)",
        lambda n: gonio.model(
            "ward",
            rho=n["diffuse"],
            specular=n["albedo"],
            alpha_x=n["roughness"],
            alpha_y=n["roughness"],
        ),
        "ward",
        tied=(("alpha_x", "alpha_y"),),
    ),
    "ngan_blinnphong": Family(
        "Lambertian(albedo = [0.276, 0.0456, 0.0109]), "
        "NganBlinnPhong(albedo = [0.00801, 0.00662, 0.00463], sharpness = 40.2)",
        lambda n: lobe(
            BLINN, four(n["albedo"]), n["diffuse"], alpha=(2 / (n["sharpness"] + 2)) ** 0.5
        ),
        BLINN,
        fixed=ROUND,
    ),
    "ngan_cooktorrance": Family(
        "Lambertian(albedo = [0.271, 0.0419, 0.00855]), "
        "NganCookTorrance(albedo = [0.193, 0.153, 0.105], eta = 0.085, roughness = 0.262)",
        lambda n: lobe(
            f"{COOK}schlick", four(n["albedo"]), n["diffuse"], alpha=n["roughness"], f0=n["eta"]
        ),
        f"{COOK}schlick",
        fixed=(*ROUND, "second.f90"),
        tied=(("second.f0.r", "second.f0.g", "second.f0.b"),),
    ),
    "low_cooktorrance_E1": Family(
        "Lambertian(albedo = [0.2747, 0.0507, 0.0169]), "
        "LowCookTorrance(albedo = [0.06155, 0.06017, 0.05979], roughness = 0.250444, eta = 1.60425)",
        lambda n: lobe(
            f"{COOK}dielectric", four(n["albedo"]), n["diffuse"], alpha=n["roughness"], eta=n["eta"]
        ),
        f"{COOK}dielectric",
        fixed=ROUND,
        tied=(("second.eta.r", "second.eta.g", "second.eta.b"),),
    ),
    "ngan_ashikhminshirley": Family(
        "Lambertian(albedo = [0.263, 0.0354, 0.00405]), NganAshikhminShirley("
        "albedo = [0.042, 0.0336, 0.0231], fresnelReflectance = 0.908, sharpness = 27.9)",
        lambda n: gonio.model(
            "ashikhmin_shirley",
            rho=n["diffuse"],
            f0=n["albedo"],
            shininess_x=n["sharpness"],
            shininess_y=n["sharpness"],
        ),
        "ashikhmin_shirley",
        tied=(("shininess_x", "shininess_y"),),
    ),
    "bagher_sgd": Family(
        "Lambertian(albedo = [0.152796, 0.124616, 0.113375]), Bagher(albedo = [0.30418, "
        "0.30146, 0.283174], alpha = [0.110819, 0.105318, 0.0785677], p = [0.640378, "
        "0.641115, 0.445228], eta = [[2.37347e-13, 7.68194e-13, 2.9434e-12], [-0.350607, "
        "-0.355433, -0.359297]], K = [7.21531, 7.46519, 10.8289], Lambda = [3.06016, 2.97652, "
        "3.78287], c = [9.71666e-08, 1.09342e-07, 9.82336e-08], k = [24.1475, 24.5083, "
        "25.6757], theta0 = [-0.281384, -0.257633, -0.200968])",
        lambda n: gonio.model(
            "sgd",
            rho=n["diffuse"],
            specular=n["albedo"],
            alpha=n["alpha"],
            p=n["p"],
            f0=n["eta"][0],
            f1=n["eta"][1],
            normalization=n["K"],
            masking_strength=n["Lambda"],
            masking_angle=n["theta0"],
            masking_width=tuple(c ** (-1 / k) for c, k in zip(n["c"], n["k"], strict=True)),
            masking_exponent=n["k"],
        ),
        "sgd",
        # What only normalises beside the weight, and the masking, which is fitted to facets
        fixed=(
            "normalization",
            "masking_strength",
            "masking_angle",
            "masking_width",
            "masking_exponent",
        ),
    ),
}


def numbers(line: str) -> Numbers:
    """The numbers of a material's line."""
    diffuse, rest = line.split("),", 1)
    found = {
        name: eval(value, {"__builtins__": {}})
        for name, value in re.findall(r"(\w+) = (\[\[.*?\]\]|\[.*?\]|[-+.\deE]+)", rest)
    }
    albedo = re.search(r"albedo = (\[.*?\])", diffuse)
    assert albedo is not None
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in found.items()}
    return values | {"diffuse": tuple(eval(albedo[1], {"__builtins__": {}}))}


def table(name: str) -> dict[str, str]:
    """The lines of a table, by material."""
    path = FOLDER / f"{name}.fit"
    if not path.exists():
        return {}
    lines = [t for t in path.read_text(encoding="utf-8").splitlines() if t and t[0] != "#"]
    return dict(line.split(" = Aggregate(", 1) for line in lines)


@functools.cache
def found(name: str, material: str) -> tuple[Model, fit.Fit]:
    """The published model, and what a fit to noisy data of it finds."""
    family = FAMILIES[name]
    true = family.truth(numbers(table(name)[material] if material else family.line))
    wi, wo = directions(True)
    random = np.random.default_rng(zlib.crc32(f"{name} {material}".encode()))
    values = true.eval(wi, wo) * (1 + NOISE * random.normal(size=(len(wi), 3)))
    data = measured.measurement("test", name, wi, wo, values, channels=("r", "g", "b"))
    begin = gonio.load(family.begin)
    assert isinstance(begin, Model)
    for path in family.fixed:  # what stays has the published value
        part, _, own = path.rpartition(".")
        if part:
            inner = getattr(true, part)
            begin = begin.replace(
                **{part: getattr(begin, part).replace(**{own: getattr(inner, own)})}
            )
        else:
            begin = begin.replace(**{own: getattr(true, own)})
    return true, fit.fit(begin, data, fixed=family.fixed, tied=family.tied, points=POINTS, starts=4)


def truths(true: Model, name: str) -> float:
    """The published value of a free number."""
    path = name.split("=")[0]
    values = {p: v for p, _, v in true.parameters()}
    if path in values:
        value = values[path]
        return float(value[0] if isinstance(value, tuple) else value)
    path, _, channel = path.rpartition(".")
    value = values[path]
    return float(value["rgb".index(channel)] if isinstance(value, tuple) else value)


def chosen(name: str) -> list[str]:
    """Materials that are fitted here: a broad highlight, and a narrow one of the table."""
    narrow = "gold-metallic-paint" if name == "bagher_sgd" else "nickel"
    return ["", *[m for m in (narrow,) if m in table(name)]]


CASES = [(name, material) for name in FAMILIES for material in chosen(name)]


@pytest.mark.parametrize(("name", "material"), CASES)
def test_published_numbers_come_back_from_data_made_of_them(name: str, material: str) -> None:
    true, result = found(name, material)
    # Not more is left than was put in
    assert result.relative < 1.3 * NOISE
    wi, wo = directions(True)
    place = np.random.default_rng(8).choice(len(wi), 300, replace=False)
    f, g = (np.log1p(m.eval(wi[place], wo[place])) for m in (true, result.model))
    # In what was fitted: noise of 4,500 values moves some ten numbers
    assert np.sqrt(np.mean((f - g) ** 2)) < NOISE / 4 * np.sqrt(np.mean(f**2))
    for number, (low, high) in result.intervals.items():
        if number in result.undetermined:
            continue
        width = max(high - low, 0.02 * abs(truths(true, number)), ZERO)
        # Four half widths of a 95 % interval are eight standard deviations
        assert abs(result.values[number] - truths(true, number)) < 2 * width, number


def test_intervals_hold_published_numbers_as_often_as_they_say() -> None:
    held = [
        low - ZERO <= truths(true, number) <= high + ZERO
        for true, result in (found(*case) for case in CASES)
        for number, (low, high) in result.intervals.items()
        if number not in result.undetermined and number not in result.at_bounds
    ]
    # A bootstrap over 64 blocks is narrow where a few directions in the highlight decide
    assert len(held) > 30
    assert np.mean(held) > 0.8
