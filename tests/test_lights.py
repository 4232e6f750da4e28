"""Lights against closed forms and plain NumPy, and lit exports against lights."""

from __future__ import annotations

import functools
import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import example, given
from hypothesis import strategies as st
from support.tolerances import DOUBLE, DOUBLE_DIVIDED, NINE_DIGITS, SINGLE_LONG, decimals

import gonio
from gonio.arrays.functions import applied
from gonio.bake import environment
from gonio.bake.environment import Environment
from gonio.bake.split_sum import look_up, split_sum, split_sum_table
from gonio.cli import main
from gonio.export.entry import Export
from gonio.export.lit import export_lit
from gonio.export.prove import each_way, prove, table, tools
from gonio.export.prove.cuda import _compile as compile_cuda
from gonio.export.prove.lit import with_stand_ins
from gonio.export.prove.native import FLAGS, METAL_FLAGS
from gonio.export.targets import TARGETS
from gonio.fields import ModelError
from gonio.lights import frames
from gonio.lights.catalogue import form_for, lights, listed
from gonio.lights.lookups import Lookups
from gonio.lights.shading import shade
from gonio.lights.sky import Harmonics, irradiance_bands
from gonio.model import Model

RADIANCE = np.array([0.9, 0.5, 0.2])
COSINES = np.array([1, 0.9, 0.7, 0.5, 0.3, 0.2, 0.1])
VIEWS = np.stack([np.sqrt(1 - COSINES**2), 0 * COSINES, COSINES], -1)
UP, RIGHT = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


def constant_sky() -> Any:
    """The harmonics of the same radiance from everywhere."""
    sky = np.zeros((9, 3))
    sky[0] = RADIANCE * np.sqrt(4 * np.pi)
    return sky


class Uniform(Lookups):
    """The same radiance from everywhere, and the two sums of a model's highlight."""

    def __init__(self, model: Model, *, size: int = 0) -> None:
        """From a table of a size, or integrated where they are asked for."""
        self.model = model
        self.table = split_sum_table(model, size, samples=512) if size else None

    def environment(self, direction: Any, alpha: Any) -> Any:
        return type(direction)(*RADIANCE.tolist())

    def split_sum(self, mu: Any, alpha: Any) -> Any:
        c, width = mu.numpy(), (alpha + 0 * mu).numpy()
        found = (
            split_sum(self.model, c, width) if self.table is None else look_up(self.table, c, width)
        )
        number = type(mu)
        pair = dr.replace_shape_t(number, (2, -1))
        return pair(*(number(np.ascontiguousarray(c)) for c in found.T))


# The table is looked up between texels, and what models say of themselves is a fit: 0.3 % of the albedo.
TABLE = 3e-3
# F other than Schlick's is taken at one cosine for all facets; and Disney's subsurface term is a fit.
ONE_COSINE, FIT = 0.09, 0.03

HIGHLIGHTS = {
    "metallic_roughness": TABLE,
    "metallic_roughness:roughness=0.2,metallic=0.5,masking=smith": TABLE,
    "ue4:light=image": TABLE,
    "unity_standard": TABLE,
    "unity_brdf2": TABLE,
    "phong": TABLE,
    "blinn": TABLE,
    "ward:form=balanced": TABLE,
    "ashikhmin_shirley": TABLE,
    "triace_blinn_phong:diffuse=oren_nayar,shininess=5": TABLE,
    "disney:sheen=1,roughness=0.9": TABLE,
    "student_t:gamma=4": TABLE,
    "disney:subsurface=1,roughness=0.7": FIT,
    "torrance_sparrow:fresnel=schlick,compensation=kulla_conty": TABLE,
    "torrance_sparrow:fresnel=white,compensation=turquin": TABLE,
    "torrance_sparrow:fresnel=schlick,f0=0.1,f90=0.7,diffuse=lambert,rho=0.8": TABLE,
    "torrance_sparrow": ONE_COSINE / 3,
    "torrance_sparrow:fresnel=dielectric,eta=1.5": ONE_COSINE,
}

LOOKED_UP = ("metallic_roughness", "ue4:light=image")


@functools.cache
def loaded(text: str) -> Model:
    found = gonio.load(text)
    assert isinstance(found, Model)
    return found


@pytest.mark.parametrize("text", HIGHLIGHTS)
def test_a_uniform_sky_shows_the_albedo(text: str) -> None:
    model = loaded(text)
    host = Uniform(model, size=64 if text in LOOKED_UP else 0)
    expected = model.albedo(VIEWS) * RADIANCE
    picture = shade(model, ["image"], UP, RIGHT, VIEWS, sky=constant_sky(), host=host)
    np.testing.assert_allclose(picture, expected, rtol=0, atol=HIGHLIGHTS[text] * expected.max())
    same = shade(model, ["ambient"], UP, RIGHT, VIEWS, radiance=RADIANCE, host=host)
    np.testing.assert_allclose(same, picture, rtol=DOUBLE_DIVIDED)


def test_a_wrong_table_shows_another_albedo() -> None:
    model = loaded("metallic_roughness")
    wrong = Uniform(loaded("triace_blinn_phong"))
    picture = shade(model, ["ambient"], UP, RIGHT, VIEWS, radiance=RADIANCE, host=wrong)
    expected = model.albedo(VIEWS) * RADIANCE
    assert np.abs(picture - expected).max() > 3 * TABLE * expected.max()


@pytest.mark.parametrize("name", ["eon", "lambert", "triace_oren_nayar"])
def test_a_matte_model_shows_its_closed_albedo(name: str) -> None:
    model = loaded(name)
    picture = shade(model, ["image"], UP, RIGHT, VIEWS, sky=constant_sky())
    np.testing.assert_allclose(picture, model.albedo(VIEWS) * RADIANCE, rtol=DOUBLE_DIVIDED)


@pytest.mark.parametrize(("shininess", "albedo"), [(1, 0.36), (10, 0.73), (50, 0.93), (100, 0.96)])
def test_ambient_brdf_is_the_integral_of_eq_1(shininess: float, albedo: float) -> None:
    """At the normal, by quadrature over the half vector, and as it is known to two digits."""
    alpha = np.sqrt(2 / (shininess + 2))
    found = split_sum(loaded("triace_blinn_phong"), 1.0, alpha, samples=4096).sum()
    cos_h = np.cos(np.linspace(0, np.pi / 4, 20_001))
    mu = 2 * cos_h**2 - 1
    norm = 0.0397436 * shininess + 0.0856832
    closed = 2 * np.pi * abs(np.trapezoid(norm * cos_h**shininess * mu, mu))
    # 4096 samples of a lattice, of a smooth weight
    assert found == pytest.approx(closed, abs=5e-5)
    assert found == pytest.approx(albedo, abs=decimals(2))


def test_a_black_metal_shows_b_and_a_white_one_a_plus_b() -> None:
    """F = f0 + (1 - f0) w: the table is what these two reflect."""
    pair = [loaded(f"metallic_roughness:metallic=1,base_color={c},roughness=0.6") for c in (0, 1)]
    black, white = (m.albedo(VIEWS)[:, 0] for m in pair)
    found = split_sum(pair[0], COSINES, np.full(len(COSINES), 0.36))
    # 2048 samples of a lattice, whose weights jump where facets mirror below the horizon
    np.testing.assert_allclose(found[:, 1], black, atol=5e-4)
    np.testing.assert_allclose(found.sum(-1), white, atol=5e-4)


# --- frames ----------------------------------------------------------------------------------------


def frame_of(normal: Any, tangent: Any) -> Any:
    def made(_: Any, n: Any, t: Any, which: Any) -> Any:
        frame = frames.surface_frame(n, t)
        return dr.select(
            which == 0, frame.tangent, dr.select(which == 1, frame.bitangent, frame.normal)
        )

    normals, tangents = np.broadcast_arrays(np.atleast_2d(normal), np.atleast_2d(tangent))
    axes = [applied(made, loaded("lambert"), [normals, tangents, [float(k)]]) for k in range(3)]
    return np.stack(axes, axis=1)


numbers = st.floats(-1, 1, width=32)
vectors = st.tuples(numbers, numbers, numbers).filter(lambda v: np.linalg.norm(v) > 1e-2)


@given(vectors, st.one_of(vectors, st.just((0.0, 0.0, 0.0))))
def test_a_frame_is_right_handed_and_follows_the_tangent(normal: Any, tangent: Any) -> None:
    x, y, z = frame_of(normal, tangent)[0]
    np.testing.assert_allclose(
        np.stack([x, y, z]) @ np.stack([x, y, z]).T, np.eye(3), atol=DOUBLE_DIVIDED
    )
    np.testing.assert_allclose(np.cross(x, y), z, atol=DOUBLE_DIVIDED)
    np.testing.assert_allclose(z, np.asarray(normal) / np.linalg.norm(normal), atol=DOUBLE_DIVIDED)
    level = np.asarray(tangent) - z * np.dot(z, tangent)
    if np.linalg.norm(level) > 2 * frames.TANGENT_MIN * np.linalg.norm(tangent):
        np.testing.assert_allclose(x, level / np.linalg.norm(level), atol=DOUBLE_DIVIDED)


@given(vectors, st.lists(vectors, min_size=3, max_size=3))
@example((0.0, 0.0, -1.0), [(1.0, 0.5, 0.2), (0.0, 1.0, 0.3), (0.3, 0.2, -1.0)])
def test_a_frame_of_the_normal_alone_turns_it_to_z_and_back(normal: Any, given: Any) -> None:
    def turned(_: Any, n: Any, w: Any, there: Any) -> Any:
        frame = frames.normal_frame(n)
        return dr.select(there > 0, frame.to_local(w), frame.to_world(w))

    def turn(vectors: Any, there: float) -> Any:
        normals = np.broadcast_to(np.asarray(normal, np.float64), np.shape(vectors))
        return applied(turned, loaded("lambert"), [normals, vectors, [there]])

    n = np.asarray(normal) / np.linalg.norm(normal)
    w = np.array([n, *given])
    local = turn(w, 1)
    np.testing.assert_allclose(local[0], [0, 0, 1], atol=DOUBLE_DIVIDED)
    np.testing.assert_allclose(local @ local.T, w @ w.T, atol=DOUBLE_DIVIDED)
    volume = np.linalg.det(w[1:])  # not mirrored
    np.testing.assert_allclose(np.linalg.det(local[1:]), volume, atol=DOUBLE_DIVIDED)
    np.testing.assert_allclose(turn(local, 0), w, atol=DOUBLE_DIVIDED)


def test_models_say_whether_they_follow_tangents_with_what_is_inside() -> None:
    stretched = {
        "weidlich_wilkie": False,
        "weidlich_wilkie:base=ward": True,
        "sum:second=phong": False,
        "sum:second=ward": True,
        "retroreflective:base=phong": False,
        "retroreflective:base=ward": True,
        "torrance_sparrow": True,
        "torrance_sparrow:distribution=gaussian": False,
    }
    assert {text: loaded(text).follows_tangents() for text in stretched} == stretched


def test_without_a_tangent_a_normal_map_leaves_the_normal() -> None:
    values = [[[0.0, 3.0, 4.0]], [[0.0, 0.0, 0.0]], [[0.9, 0.3, 0.8]], [1.0]]
    mapped = applied(lambda _, *v: frames.mapped_normal(*v), loaded("lambert"), values)[0]
    np.testing.assert_allclose(mapped, [0, 0.6, 0.8], atol=DOUBLE)


def test_a_flat_normal_map_changes_nothing_and_others_lean_along_u_and_v() -> None:
    def mapped(_: Any, n: Any, t: Any, texel: Any, hand: Any) -> Any:
        return frames.mapped_normal(n, t, texel, hand)

    n, t = [[0.0, 0.0, 2.0]], [[3.0, 0.0, 1.0]]

    def at(texel: Any, hand: float = 1) -> Any:
        return applied(mapped, loaded("lambert"), [n, t, [texel], [hand]])[0]

    half = 1 / np.sqrt(2)
    np.testing.assert_allclose(at([0.5, 0.5, 1]), [0, 0, 1], atol=DOUBLE)
    u = 0.5 + 0.5 * half
    np.testing.assert_allclose(at([u, 0.5, u]), [half, 0, half], atol=DOUBLE)
    np.testing.assert_allclose(at([0.5, u, u]), [0, half, half], atol=DOUBLE)
    np.testing.assert_allclose(at([0.5, u, u], -1), [0, -half, half], atol=DOUBLE)


def test_flakes_even_out_with_distance() -> None:
    def tilt(distance: float) -> float:
        slope = np.tan(np.radians(30))
        values = [[[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]], [slope], [0.0], [distance]]
        flake = applied(lambda _, *v: frames.world_flake_normal(*v), loaded("lambert"), values)[0]
        return float(np.degrees(np.arccos(flake[1])))

    # Of N + N_flake, N_flake tilted by 30 degrees: 15 degrees; Elek's sum counts the normal once more
    assert tilt(0.5) == tilt(1) == pytest.approx(15)
    assert tilt(100) < 0.4


# --- light from one direction ----------------------------------------------------------------------


@pytest.mark.parametrize("text", ["ue4", "ward:alpha_x=0.4,alpha_y=0.1", "weidlich_wilkie"])
def test_directional_light_is_f_times_cosine_times_irradiance(text: str) -> None:
    rng = np.random.default_rng(3)
    normal, tangent, light, view = rng.normal(size=(4, 200, 3))
    light, view = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (light, view))
    z = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    x = tangent - np.sum(tangent * z, 1, keepdims=True) * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    axes = np.stack([x, np.cross(z, x), z], 1)
    wi, wo = (np.einsum("nij,nj->ni", axes, w) for w in (light, view))
    expected = loaded(text).eval(wi, wo) * np.maximum(wi[:, 2:], 0) * RADIANCE
    assert (expected > 0).any()
    found = shade(
        loaded(text), ["directional"], normal, tangent, view, light=light, irradiance=RADIANCE
    )
    np.testing.assert_allclose(found, expected, rtol=DOUBLE_DIVIDED, atol=DOUBLE)


# --- harmonics -------------------------------------------------------------------------------------


def test_bands_of_irradiance_are_those_of_polynomials() -> None:
    """Of the radiance 1 + y + x z: pi, 2 pi / 3 y and pi / 4 x z."""
    sky = np.zeros((9, 3))
    sky[0] = np.sqrt(4 * np.pi)
    sky[1] = 1 / np.sqrt(3 / (4 * np.pi))
    sky[7] = 1 / np.sqrt(15 / (4 * np.pi))
    n = np.random.default_rng(1).normal(size=(50, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)

    def bands(_: Any, w: Any, *colours: Any) -> Any:
        found = irradiance_bands(Harmonics(*colours), w)
        return type(w)(found.constant.x, found.linear.x, found.quadratic.x)

    found = applied(bands, loaded("lambert"), [n, *sky[:, None]])
    one = np.ones(50)
    expected = np.stack([np.pi * one, 2 * np.pi / 3 * n[:, 1], np.pi / 4 * n[:, 0] * n[:, 2]], -1)
    np.testing.assert_allclose(found, expected, rtol=NINE_DIGITS, atol=DOUBLE_DIVIDED)


# Down to 60 degrees; beyond, F(mu_o) of a rough coat is too bright.
STEEP = COSINES >= 0.5

COATS = {
    "weidlich_wilkie": 0.01,
    "weidlich_wilkie:transmission=both_ways,solid_angle=compressed,bounces=diffuse,base.rho=1": 0.01,
    "weidlich_wilkie:interface=smooth,base=eon,sigma_a=0.2": 0.04,
    # What leaves the base too flat is told by GGX's slopes at the normal alone.
    "weidlich_wilkie:base=torrance_sparrow,base.fresnel=schlick,base.alpha=0.1": 0.27,
    "weidlich_wilkie:base=torrance_sparrow,base.fresnel=schlick,solid_angle=compressed": 0.2,
}


@pytest.mark.parametrize("text", COATS)
def test_a_coat_under_a_uniform_sky_shows_the_albedo_of_the_whole(text: str) -> None:
    model = loaded(text)
    host = Uniform(loaded("torrance_sparrow:fresnel=schlick"))
    picture = shade(model, ["coat"], UP, RIGHT, VIEWS, sky=constant_sky(), host=host)
    expected = model.albedo(VIEWS) * RADIANCE
    np.testing.assert_allclose(picture[STEEP], expected[STEEP], rtol=COATS[text])


def test_a_coat_over_black_mirrors_f_times_the_picture() -> None:
    """Elek, Algorithm 1, lines 28 and 29, with the exact F of glass seen at 60 degrees: 0.0892."""
    model = loaded("weidlich_wilkie:base.rho=0")
    host = Uniform(loaded("ue4"))
    picture = shade(model, ["coat"], UP, RIGHT, VIEWS, sky=constant_sky(), host=host)
    np.testing.assert_allclose(picture[0], 0.04 * RADIANCE, rtol=DOUBLE_DIVIDED)
    np.testing.assert_allclose(picture[3], 0.0891867 * RADIANCE, rtol=SINGLE_LONG)


def test_the_surface_of_paint_and_patina_mirrors_f_times_the_picture() -> None:
    """F of glass at 60 degrees; and of copper and of cuprite, where nothing and all has grown."""
    host = Uniform(loaded("ue4"))
    paint = shade(loaded("car_paint"), ["coat"], UP, RIGHT, VIEWS, host=host)
    np.testing.assert_allclose(paint[3], 0.0891867 * RADIANCE, rtol=SINGLE_LONG)
    for extent, name in ((-1, "metal"), (2, "coat")):
        model = loaded(f"patina:extent={extent}")
        eta, k = (np.array(getattr(model, f"{name}_{part}")) for part in ("eta", "k"))
        F = ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)
        found = shade(model, ["coat"], UP, RIGHT, VIEWS, host=host)
        np.testing.assert_allclose(found[0], F * RADIANCE, rtol=DOUBLE_DIVIDED)


LAYERS = "triace_layered:absorption=linear,bottom_fresnel=constant,sigma_a=0.1,diffuse=oren_nayar"


def test_tri_aces_layers_are_lit_as_by_the_array_code() -> None:
    """Two programs of the same equations (6 to 9): of arrays, and in the language of models."""
    sky = Environment(RADIANCE + np.zeros((9, 16, 3)))
    model = loaded(LAYERS)
    expected = environment.layered_light(sky, model, np.array(UP), VIEWS)
    host = Uniform(loaded("ue4"))
    found = shade(model, ["layered"], UP, RIGHT, VIEWS, sky=sky.harmonics(), host=host)
    np.testing.assert_allclose(found, expected, rtol=NINE_DIGITS)


@pytest.mark.parametrize(("dc", "form"), [("eq27", "arccos"), ("eq28", "cheap")])
def test_harmonics_light_oren_nayar_as_the_array_code_does(dc: str, form: str) -> None:
    sky = np.random.default_rng(2).random((9, 3)) * [[4]] + [[3]] * (np.arange(9) == 0)[:, None]
    model = loaded("triace_oren_nayar:shininess=5,rho=0.6")
    normals = np.tile([0.36, 0.48, 0.8], (len(VIEWS), 1))
    expected = environment.oren_nayar_light(sky, normals, VIEWS, rho=0.6, shininess=5, form=form)
    found = shade(model, [f"harmonics:dc={dc}"], normals, RIGHT, VIEWS, sky=sky)
    np.testing.assert_allclose(found, expected, rtol=NINE_DIGITS, atol=DOUBLE_DIVIDED)


def test_harmonics_of_a_uniform_sky_are_the_integral_in_the_viewers_plane() -> None:
    """By quadrature of Eq. 25 over the half plane with the cosine, within what Eq. 27 fits (4 %)."""
    n = 2.0
    picture = shade(
        loaded(f"triace_oren_nayar:shininess={n},rho=1"),
        ["harmonics"],
        UP,
        RIGHT,
        VIEWS,
        sky=constant_sky(),
    )
    theta_o = np.arccos(COSINES)[:, None]
    theta = np.linspace(0, np.pi / 2, 4001)[None]
    f, g = 1 - 1 / (2 + 0.65 * n), 1 / (2.22222 + 0.1 * n)
    s = np.sin(theta) * np.sin(theta_o)
    value = f + g * s / np.maximum(np.cos(theta), np.cos(theta_o))
    closed = np.trapezoid(value * np.cos(theta), theta[0], axis=1)
    np.testing.assert_allclose(picture, closed[:, None] * RADIANCE, rtol=0.04)  # what Eq. 27 fits


def test_half_the_effect_of_eq_29_is_halfway() -> None:
    sky = np.zeros((9, 3))
    sky[3] = 1
    model = loaded("triace_oren_nayar:shininess=2,rho=1")
    options = ["harmonics:linear=eq29", "harmonics:linear=halved"]
    full, half = (shade(model, [o], RIGHT, UP, [0.6, 0.8, 0], sky=sky)[0, 0] for o in options)
    above = shade(model, ["harmonics"], RIGHT, UP, RIGHT, sky=sky)[0, 0]
    assert half == pytest.approx((full + above) / 2)
    # Figure 10 at sigma = 1: 0.70 seen from above; S falls by 0.3 (1 - x)
    scale = np.sqrt(np.pi / 3) / np.pi
    assert above / scale == pytest.approx(0.697, abs=2 * decimals(3))
    assert full / scale == pytest.approx(0.697 - 0.303 * 0.4, abs=2 * decimals(3))


# --- which lights a model can have -----------------------------------------------------------------


def test_a_light_that_does_not_fit_says_which_do() -> None:
    with pytest.raises(ModelError, match="did you mean 'image'"):
        form_for(loaded("eon"), "imag")
    with pytest.raises(ModelError, match=r"image_lobes.*hapke can have directional"):
        form_for(loaded("hapke"), "image")
    with pytest.raises(ModelError, match="looks up pictures"):
        shade(loaded("ue4"), ["ambient"], UP, RIGHT, VIEWS, radiance=RADIANCE)
    with pytest.raises(ModelError, match="take light, irradiance; got light"):
        shade(loaded("ue4"), ["directional"], UP, RIGHT, VIEWS, light=UP)
    with pytest.raises(ModelError, match="named twice"):
        shade(loaded("ue4"), ["ambient", "ambient"], UP, RIGHT, VIEWS)
    assert listed(["directional,image", "a:b=c,d=e"]) == ["directional", "image", "a:b=c,d=e"]


def test_every_light_is_documented() -> None:
    page = (Path(__file__).parent.parent / "docs/real_time.md").read_text(encoding="utf-8")
    for name in lights():
        assert f"| `{name}` |" in page


# --- exports ---------------------------------------------------------------------------------------

LANGUAGES = [name for name, target in TARGETS.items() if not target.shader]
LIT = ["directional", "image"]


SHADED = '''
from gonio import Model, param
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Shaded(Model):
    """A number has the name of the function that lit exports add."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo")
    shade: Float = param(0.5, 0, 1, "its factor")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho shade / pi."""
        return self.rho * (self.shade * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """cos(theta_i) / pi."""
        return pdf_cosine(wi)
'''


def test_a_parameter_may_be_called_shade_where_functions_are_methods(tmp_path: Path) -> None:
    (tmp_path / "shaded.py").write_text(SHADED, "utf-8")
    model = loaded(str(tmp_path / "shaded.py"))
    made = export_lit(model, "shaded", ["directional"], "slang")
    assert "float3 shade(float3 normal" in made.source
    assert all(p.holds for p in prove([(model, made)], 100))


def test_lit_exports_are_proven_in_every_language() -> None:
    model = loaded("metallic_roughness")
    pairs = [
        (model, way)
        for language in LANGUAGES
        for way in each_way(export_lit(model, "paint", LIT, language, lookups="host"))
    ]
    stretched = loaded("ward:alpha_x=0.4,alpha_y=0.1,form=balanced")  # whose frame has tangents
    pairs += [
        (stretched, export_lit(stretched, "cloth", ["directional"], language))
        for language in LANGUAGES
    ]
    proofs = prove(pairs, 1000)
    assert {p.function for p in proofs} == {"eval", "shade"}
    assert {p.language for p in proofs} == {*LANGUAGES, "spirv"}
    assert all(p.holds for p in proofs), table(proofs)


def test_lights_of_one_kind_of_model_are_proven() -> None:
    kinds = {
        "coat": "weidlich_wilkie:base=torrance_sparrow,base.fresnel=schlick",
        "coat_matte": "weidlich_wilkie:bounces=diffuse",
        "layered": LAYERS,
        "coat_alone": "patina",
        "harmonics:dc=eq28,linear=halved": "triace_oren_nayar",
    }
    pairs = [
        (
            loaded(text),
            export_lit(loaded(text), "m", [light.partition("_")[0]], to, lookups="host"),
        )
        for light, text in kinds.items()
        for to in ("cpp", "essl")
    ]
    proofs = prove(pairs, 500)
    assert all(p.holds for p in proofs), table(proofs)


BROKEN = {
    "a frame that is turned the wrong way": (
        r"dot\(frame\.bitangent, w\)",
        "-dot(frame.bitangent, w)",
    ),
    "a lost cosine": (r"fmaxf\(wi\.z, 0\.0f\)", "1.0f"),
    "a mirrored direction behind the surface": (r"-wo\.x, -wo\.y, wo\.z", "-wo.x, -wo.y, -wo.z"),
    "a wrong constant of a harmonic": (r"0\.8580855", "0.8680855"),
    "a lookup with the wrong width": (r"(environment\(mirrored, )lobes\.alpha", r"\g<1>1.0f"),
}


@pytest.mark.parametrize("mistake", BROKEN)
def test_a_broken_light_is_caught(mistake: str) -> None:
    model = loaded("ward:alpha_x=0.4,alpha_y=0.1,form=balanced")
    made = export_lit(model, "paint", LIT, "cpp", lookups="host")
    pattern, new = BROKEN[mistake]
    source, count = re.subn(pattern, new, made.source, count=1)
    assert count == 1
    proofs = prove([(model, replace(made, source=source))], 500)
    assert {p.function for p in proofs if not p.holds} == {"shade"}


def compiled(export: Export, folder: Path) -> None:
    """Let the language's own compiler have the text with textures."""
    text = export.source

    def run(*command: str) -> None:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr

    if export.language in ("glsl", "essl"):
        head = (
            "#version 450\n"
            if export.language == "glsl"
            else "#version 300 es\nprecision highp float;\n"
        )
        (folder / "x.frag").write_text(f"{head}{text}\nvoid main() {{}}\n", encoding="utf-8")
        glslang = tools.program("glslangValidator", "compiles GLSL")
        run(glslang, *(["-V", "-o", "x.spv"] if export.language == "glsl" else []), "x.frag")
    elif export.language == "wgsl":
        # In a process of its own, as Vulkan's LLVM must not meet Dr.Jit's
        (folder / "x.wgsl").write_text(text, encoding="utf-8")
        code = "import wgpu; text = open('x.wgsl', encoding='utf-8').read(); "
        code += "wgpu.utils.get_default_device().create_shader_module(code=text)"
        run(sys.executable, "-P", "-c", code)
    elif export.language in ("hlsl", "slang"):
        (folder / "x.slang").write_text(
            f'{text}\nRWStructuredBuffer<float3> made;\n[shader("compute")] [numthreads(1, 1, 1)] '
            f"void main() {{ {export.entry.struct} params; made[0] = params.base_color; }}\n",
            encoding="utf-8",
        )
        slangc = tools.program("slangc", "compiles Slang")
        run(slangc, "x.slang", "-target", "hlsl", "-entry", "main", "-o", "made.hlsl")
        if export.language == "hlsl":
            (folder / "x.hlsl").write_text(
                f"{text}\n[numthreads(1, 1, 1)] void main() {{}}\n", encoding="utf-8"
            )
            glslang = tools.program("glslangValidator", "compiles HLSL")
            run(glslang, "-D", "-V", "-e", "main", "-S", "comp", "x.hlsl", "-o", "x.spv")
    elif export.language == "msl":
        entry = export.entry
        use = (
            f"float3 f({entry.struct} p, {entry.struct}Harmonics s, {entry.struct}Textures h) {{\n"
        )
        use += "float3 z = float3(0.0, 0.0, 1.0);\n"
        use += f"return {entry.prefix}_shade(p, z, z, z, z, z, s, h);\n}}\n"
        (folder / "x.cpp").write_text(text + use, encoding="utf-8")
        run("g++", *FLAGS, "-w", *METAL_FLAGS, "x.cpp", "-o", "x.so")
    elif export.language == "cuda":
        assert compile_cuda([with_stand_ins(export)]) == [None]
    else:
        (folder / "x.h").write_text(text, encoding="utf-8")
        (folder / "x.cpp").write_text('#include "x.h"\n', encoding="utf-8")
        warnings = ["-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter"]
        run("g++", *FLAGS, *warnings, "x.cpp", "-o", "x.so")


@pytest.mark.parametrize("language", LANGUAGES)
def test_lookups_with_textures_compile(language: str, tmp_path: Path) -> None:
    made = export_lit(loaded("metallic_roughness"), "paint", LIT, language)
    assert "environment_map" in made.source or language == "cpp"
    compiled(made, tmp_path)


def test_the_command_writes_a_material_function_and_what_to_bind(tmp_path: Path) -> None:
    run = CliRunner().invoke
    done = run(main, ["export", "ue4", "--lit", "--to", "wgsl", "--manifest", "-o", f"{tmp_path}/"])
    assert done.exit_code == 0, done.output
    text = (tmp_path / "ue4.wgsl").read_text(encoding="utf-8")
    about = json.loads((tmp_path / "ue4.json").read_text(encoding="utf-8"))
    assert about["functions"]["shade"] == "ue4_shade"
    assert "fn ue4_shade(params: Ue4, normal: vec3f, tangent: vec3f, view: vec3f" in text
    assert [a["name"] for a in about["lit"]["arguments"]] == [
        *("normal", "tangent", "view", "light", "irradiance", "sky")
    ]
    for bound in about["lit"]["binds"]:
        assert f"var {bound['name']}:" in text
        assert bound["doc"]
    assert all(p["used"] for p in about["parameters"])

    done = run(main, ["export", "eon", "--lit", "--lookups", "host", "--to", "glsl"])
    assert "eon_image_matte" in done.output
    assert "uniform" not in done.output
    for arguments, reason in {
        ("eon", "--lookups", "host", "--to", "glsl"): "--lookups is for lights and tables",
        ("eon", "lambert", "--lit", "image", "--to", "glsl"): "one model",
        ("eon", "--lit", "image", "--to", "osl"): "closures",
        ("eon", "--lit", "image", "--to", "mtlx"): "renderer",
        ("eon", "--lit", "image:x=1", "--to", "glsl"): "no choices",
    }.items():
        done = run(main, ["export", *arguments])
        assert done.exit_code != 0
        assert reason in done.output


def test_all_languages_are_those_that_can_be_lit(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["export", "eon", "--lit", "--to", "all", "-o", f"{tmp_path}/"])
    assert done.exit_code == 0, done.output
    assert "OSL and MaterialX are left out" in done.output
    suffixes = {TARGETS[name].extension for name in LANGUAGES}
    assert {path.suffix for path in tmp_path.iterdir()} == {f".{s}" for s in suffixes}


def test_a_lit_export_is_proven_by_the_command() -> None:
    done = CliRunner().invoke(
        main, ["export", "eon", "--lit", "--to", "cpp", "--prove", "--rows", "200"]
    )
    assert done.exit_code == 0, done.output
    assert re.search(r"eon +shade +\d", done.output)
