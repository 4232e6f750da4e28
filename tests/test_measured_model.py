"""A measured file as a model: values, samples, albedos, Mitsuba, coats, and what it is called."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from support.tolerances import DOUBLE, SINGLE, SINGLE_LONG

import gonio
from gonio import backend, measured
from gonio.cli import main
from gonio.fields import ModelError
from gonio.measured import DataError, as_model
from gonio.measured.formats import mbsdf
from gonio.measured.frames import spherical
from gonio.model import Model
from gonio.table import Table, fetch

# Coarse tables keep the tests fast; the errors below are theirs.
COARSE = (45, 20, 24)


def directions(count: int, lowest: float = 0.15, seed: int = 2) -> Any:
    random = np.random.default_rng(seed)
    mu = random.uniform(lowest, 1, (2, count))
    phi = random.uniform(-math.pi, math.pi, (2, count))
    return tuple(spherical(np.arccos(m), p) for m, p in zip(mu, phi, strict=True))


@functools.cache
def source(name: str) -> Model:
    return {
        "matte": gonio.model("eon", rho=(0.7, 0.4, 0.2), roughness=0.6),
        "glossy": gonio.model("disney", roughness=0.35, base_color=(0.6, 0.3, 0.1)),
        "brushed": gonio.model("torrance_sparrow", alpha=0.35, anisotropy=0.5),
    }[name]


class Sampled:
    """A model as a measurement without a file: values wherever they are asked for."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __call__(self, wi: Any, wo: Any) -> Any:
        return source(self.name).eval(wi, wo).astype(float), np.ones(len(wi), bool)


@functools.cache
def made(name: str) -> Model:
    wi, wo = directions(8)
    found = measured.measurement(
        "test",
        name,
        wi,
        wo,
        source(name).eval(wi, wo),
        channels=("r", "g", "b"),
        isotropic=name != "brushed",
        interpolator=Sampled(name),
    )
    return as_model(found, COARSE if name != "brushed" else (24, 40, 12, 24))


NAMES = ("matte", "glossy", "brushed")


# --- values --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "error"), [("matte", 0.01), ("glossy", 0.03), ("brushed", 0.08)])
def test_values_are_those_that_were_measured(name: str, error: float) -> None:
    wi, wo = directions(4000)
    true = source(name).eval(wi, wo)
    off = np.abs(made(name).eval(wi, wo) - true) / true
    # Between the places of a coarse table; nine of ten directions
    assert np.percentile(off, 90) < error
    assert made(name).isotropic == (name != "brushed")


@pytest.mark.parametrize("name", NAMES)
def test_precisions_and_backends_agree(name: str) -> None:
    wi, wo = directions(300)
    double = made(name).eval(wi, wo)
    single = made(name).eval(wi.astype(np.float32), wo.astype(np.float32))
    # Angles in single precision, over steps of half a degree at the smallest
    assert np.allclose(single, double, rtol=2e-3, atol=SINGLE_LONG)
    before = backend.current()
    try:
        backend.use("scalar")
        plain = made(name).eval(wi[:20], wo[:20])
    finally:
        backend.use(before)
    assert np.allclose(plain, double[:20], rtol=DOUBLE)


@pytest.mark.parametrize("name", NAMES)
def test_swapped_directions_have_the_same_value(name: str) -> None:
    wi, wo = directions(2000)
    assert np.allclose(made(name).eval(wi, wo), made(name).eval(wo, wi), rtol=SINGLE_LONG)


def test_scale_multiplies() -> None:
    wi, wo = directions(5)
    half = made("matte").replace(scale=(0.5, 1, 2))
    assert np.allclose(half.eval(wi, wo), made("matte").eval(wi, wo) * [0.5, 1, 2])
    assert np.allclose(half.albedo(wo), made("matte").albedo(wo) * [0.5, 1, 2])


def test_a_looked_up_number_is_the_tables() -> None:
    import drjit as dr

    table = Table("some", np.arange(12.0).reshape(2, 2, 3), colours=True)
    assert list(fetch(table, 2.0)) == [6, 7, 8]
    for place in (-1, 0.5, table.count):
        with pytest.raises(IndexError, match=rf"no place {place}; its places are .* from 0 to"):
            fetch(table, place)
    index = dr.llvm.ad.Float([0, 3])
    assert np.allclose(np.array(fetch(table, index)).T, [[0, 1, 2], [9, 10, 11]])


# --- samples and albedos -------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_samples_have_their_density_and_bounded_weights(name: str) -> None:
    model = made(name)
    random = np.random.default_rng(5)
    for theta in (5, 40, 75):
        wo = np.broadcast_to(spherical(math.radians(theta), 0.3), (40_000, 3))
        wi, pdf = model.sample(wo, random.random((40_000, 2)))
        good = pdf > 0
        assert np.allclose(model.pdf(wi[good], wo[good]), pdf[good], rtol=SINGLE)
        weight = model.eval(wi[good], wo[good]) * wi[good][:, 2:] / pdf[good][:, None]
        # Cosine-weighted samples alone would have weights of 5 to 20 for the glossy ones
        assert weight.max() < 6
        albedo = model.albedo(wo[:1])[0]
        mean = weight.sum(0) / len(wo)
        spread = weight.std(0) / math.sqrt(len(wo))
        assert (np.abs(mean - albedo) < 4 * spread + 0.01 * albedo).all(), (theta, mean, albedo)
        # The density integrates to what is not wasted: counted with uniform directions
        even = spherical(np.arccos(random.random(40_000)), 2 * math.pi * random.random(40_000))
        share = 2 * math.pi * model.pdf(even, wo)
        assert abs(share.mean() - good.mean()) < 5 * share.std() / 200 + 0.005


@pytest.mark.parametrize("name", ["glossy", "brushed"])
def test_samples_fall_where_the_density_says(name: str) -> None:
    model, count = made(name), 200_000
    wo = spherical(math.radians(50), 0.4)
    random = np.random.default_rng(6)
    wi, pdf = model.sample(np.broadcast_to(wo, (count, 3)), random.random((count, 2)))
    wi = wi[pdf > 0]
    rows, columns, fine = 12, 24, 24
    counted, *_ = np.histogram2d(
        wi[:, 2], np.arctan2(wi[:, 1], wi[:, 0]), (rows, columns), ((0, 1), (-math.pi, math.pi))
    )
    z = (np.arange(rows * fine) + 0.5) / (rows * fine)
    phi = -math.pi + 2 * math.pi * (np.arange(columns * fine) + 0.5) / (columns * fine)
    even = spherical(np.arccos(z)[:, None], phi)
    density = model.pdf(even.reshape(-1, 3), wo).reshape(rows, fine, columns, fine)
    expected = count * density.mean((1, 3)) * 2 * math.pi * 2 / 2 / (rows * columns)
    busy = expected > 50
    # Pearson's sum has a mean of 1 per cell; the integral's own error adds a little to it
    chi = ((counted - expected) ** 2 / expected)[busy].mean()
    assert chi < 1.8
    # A density that is 5 % too large would be refused
    wrong = ((counted - 1.05 * expected) ** 2 / (1.05 * expected))[busy].mean()
    assert wrong > 2.2


@pytest.mark.parametrize("name", NAMES)
def test_albedos_are_the_sources(name: str) -> None:
    wo = spherical(np.radians([0, 20, 45, 60, 75]), 0.2)
    true = source(name).albedo(wo)
    # A coarse table, which cuts off the top of a highlight; the narrow one has fewer cells across it
    assert np.allclose(made(name).albedo(wo), true, atol=0.03 if name == "brushed" else 0.012)
    assert np.allclose(made(name).mean_albedo(), source(name).mean_albedo(), atol=0.01)


# --- what is wrong with measurements -------------------------------------------------------------


def test_negative_values_and_holes_are_mended_and_named() -> None:
    wi, wo = directions(8)

    def faulty(a: Any, b: Any) -> Any:
        values = np.full((len(a), 3), 0.2)
        values[a[:, 2] * b[:, 2] < 0.4] = -1
        known = (a[:, 2] > 0.5) & (b[:, 2] > 0.5)
        return np.where(known[:, None], values, 77.0), known

    found = measured.measurement(
        "test", "faulty", wi, wo, np.ones((8, 3)), channels=("r", "g", "b"), interpolator=faulty
    )
    model = as_model(found, COARSE)
    assert any("negative" in text for text in model.caveats)
    assert any("nearest measured" in text for text in model.caveats)
    f = model.eval(*directions(500, 0.01))
    assert f.min() >= 0
    assert f.max() == pytest.approx(0.2)  # and not what stood in the holes


# --- Mitsuba and coats ---------------------------------------------------------------------------


def test_mitsuba_has_the_models_values_and_its_own_plug_in_agrees(tmp_path: Path) -> None:
    import drjit as dr
    import mitsuba as mi

    from gonio.mitsuba.nodes import node

    mi.set_variant("llvm_ad_rgb")
    path = tmp_path / "eon.bsdf"
    measured.save(path, source("matte"), "rgl", thetas=16, side=32)
    model = as_model(path, COARSE)
    wi, wo = directions(3000)
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = mi.Vector3f(wo.T.astype(np.float32))
    si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    light = mi.Vector3f(wi.T.astype(np.float32))
    mine, theirs = (
        np.array(mi.load_dict(bsdf).eval(mi.BSDFContext(), si, light)).T
        for bsdf in (node(model), {"type": "measured", "filename": str(path)})
    )
    assert np.allclose(mine, model.eval(wi, wo) * wi[:, 2:], rtol=SINGLE_LONG, atol=SINGLE)
    # Both interpolate, one over a warped square and one over half and difference angles
    off = np.abs(mine - theirs) / theirs
    assert np.percentile(off, 90) < 0.02


def test_a_measured_base_shines_through_a_coat() -> None:
    coated = gonio.model("weidlich_wilkie", base=made("matte"), sigma_a=0)
    same = gonio.model("weidlich_wilkie", base=source("matte"), sigma_a=0)
    wi, wo = directions(300)
    # Twice what a matte table may be off: the coat takes it at refracted directions, grazing ones too
    assert np.allclose(coated.eval(wi, wo), same.eval(wi, wo), rtol=0.02)


# --- names and files -----------------------------------------------------------------------------


@pytest.fixture
def paint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(mbsdf, "N_THETA", 20)
    monkeypatch.setattr(mbsdf, "N_PHI", 30)
    monkeypatch.setattr("gonio.measured.tabulate.ISOTROPIC", COARSE)
    path = tmp_path / "paint.mbsdf"
    measured.save(path, source("matte"))
    return path


def run(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


def test_a_file_is_a_model_wherever_one_is_named(paint: Path, tmp_path: Path) -> None:
    model = gonio.load(f"{paint}:scale=0.5")
    assert isinstance(model, Model)
    assert model.name == "measured_paint"
    assert type(gonio.load(str(paint))) is type(model)  # read once
    inner = gonio.load(f"weidlich_wilkie:base={paint},base.scale=0.5")
    assert inner.base.scale == 0.5
    (tmp_path / "coated.toml").write_text(
        'model = "weidlich_wilkie"\n[base]\nmodel = "paint.mbsdf"\nscale = 0.5\n', encoding="utf-8"
    )
    assert gonio.load(str(tmp_path / "coated.toml")).model.base.scale == 0.5
    for words in (
        ("eval", str(paint), "--theta-i", "30", "--theta-o", "40"),
        ("plot", str(paint), "-o", str(tmp_path / "p.csv")),
        ("show", str(paint)),
    ):
        result = run(*words)
        assert result.exit_code == 0, result.output
    # What is shown to be used can be used: the file is named, not the class that it became
    assert f"gonio eval {paint} " in result.output
    assert "gonio eval measured_paint" not in result.output


def test_files_of_one_name_do_not_disturb_each_other(paint: Path, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = tmp_path / "other" / "paint.mbsdf"
    measured.save(other, source("glossy"))
    first, second = as_model(paint), as_model(other)
    assert first.name != second.name
    wi, wo = directions(10)
    # The other file's values are further off
    assert not np.allclose(first.eval(wi, wo), second.eval(wi, wo), rtol=0.05)
    measured.save(paint, source("glossy"))  # the file changes: so does its model
    again = as_model(paint)
    assert np.allclose(again.eval(wi, wo), second.eval(wi, wo))


def test_what_cannot_be_a_model_is_said_in_one_line(paint: Path, tmp_path: Path) -> None:
    with pytest.raises(DataError, match="does not exist"):
        gonio.load(str(tmp_path / "none.binary"))
    (tmp_path / "noise.xyz").write_bytes(b"hello")
    with pytest.raises(DataError, match="no known format"):
        gonio.load(str(tmp_path / "noise.xyz"))
    with pytest.raises(ModelError, match="roughness"):
        gonio.load(f"{paint}:roughness=1")
    with pytest.raises(ValueError, match="places"):
        as_model(paint, (3, 3))
    result = run("export", str(paint), "--to", "osl")
    assert result.exit_code == 1
    assert result.stderr.count("\n") == 1
