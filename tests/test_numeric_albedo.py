"""Albedos without a closed form: a rule that fits is found, the others are noticed, means agree."""

from __future__ import annotations

import warnings
from typing import Any

import drjit as dr
import numpy as np
import pytest
from support.directions import polar
from support.tolerances import NUMERIC_ALBEDO, SINGLE, SINGLE_LONG

import gonio
from gonio import arrays, backend
from gonio.albedos import quadrature
from gonio.albedos.numeric import SMOOTHNESS, for_quadrature
from gonio.albedos.quadrature import NumericAlbedo
from gonio.arrays.kernel import opaque
from gonio.fields import ModelError
from gonio.lang import (
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    cos,
    maximum,
    power,
    sin,
    sqrt,
    vec2,
    vec3,
)
from gonio.messages import Notice
from gonio.model import Model, param
from gonio.parts.frame import azimuth
from gonio.parts.hemisphere import pdf_cosine, sample_cosine

UP = np.array([[0.0, 0.0, 1.0]])


class Lobe(Model, register=False):
    """A normalised lobe cos^n about the mirror direction, over the cosine: its albedo is 1 at N."""

    n: Float = param(100, 1, 1e5, "exponent")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        value = self.pdf(wi, wo) / wi.z
        return vec3(value, value, value)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        c = power(maximum(1 - u.x, 1e-7), 1 / (self.n + 1))
        s = sqrt(maximum(1 - c * c, 0))
        axis, sine = azimuth(wo), sqrt(maximum(1 - wo.z * wo.z, 0))
        x, y = s * cos(TWO_PI * u.y), s * sin(TWO_PI * u.y)
        out = x * wo.z - c * sine
        wi = vec3(axis.x * out - axis.y * y, axis.y * out + axis.x * y, x * sine + c * wo.z)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        c = maximum(wi.z * wo.z - wi.x * wo.x - wi.y * wo.y, 1e-20)
        return (self.n + 1) / TWO_PI * power(c, self.n)


class Lying(Lobe, register=False):
    """The same, whose sampler claims twice the density."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi, pdf = super().sample(wo, u)
        return Sample(wi, 2 * pdf)


class Chiral(Model, register=False):
    """Brighter to the left of the viewer: unchanged by turns, but no mirror image of itself."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        value = 0.2 + 0.1 * (wo.x * wi.y - wo.y * wi.x)
        return vec3(value, value, value)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)


@pytest.mark.parametrize("n", [1, 50, 5000, 1e5])
def test_a_users_lobe_of_any_sharpness_has_its_albedo(n: float) -> None:
    # ∫ (n + 1) / 2π cos^n θ dω over the hemisphere is 1.
    assert Lobe(n=n).albedo(UP)[0] == pytest.approx(1, abs=2e-4)


def test_lobes_of_different_sharpness_in_one_array_have_their_albedos() -> None:
    lobes = Lobe(n=np.array([2.0, 300.0, 1e5]))
    np.testing.assert_allclose(lobes.albedo(UP[0])[:, 0], 1, atol=NUMERIC_ALBEDO)


def test_an_albedo_that_disagrees_with_the_sampler_is_noticed_with_the_cure() -> None:
    with pytest.warns(Notice, match=r"albedo is uncertain; at 0.0 degrees .* samples 0.5\. Write"):
        Lying(n=50).albedo(UP)


def test_the_first_rule_alone_would_be_wrong_in_silence() -> None:
    tilted = polar(0.7, 1.0)
    assert Lobe(n=5000).albedo(tilted)[0] == pytest.approx(1, abs=NUMERIC_ALBEDO)
    assert abs(Lobe(n=5000).with_numeric(NumericAlbedo("angles")).albedo(tilted)[0] - 1) > 0.02


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            "numeric = NumericAlbedo('half_vector')",
            "no rule 'half_vector'; did you mean 'half_vectors'",
        ),
        ("numeric = 'mirror'", "numeric is a NumericAlbedo"),
        ("numerik = NumericAlbedo('mirror')", "nothing asks for numerik"),
        ("numeric = NumericAlbedo('mirror', stretched=True)", 'only the rule "half_vectors"'),
        ("numeric = NumericAlbedo('half_vectors', round_part=True)", "add stretched=True"),
        ("numeric = NumericAlbedo('half_vectors', stretched=True)", "has no method slope_widths"),
        ("def slope_widths(self):\n        return vec2(1, 1)", "has a method slope_widths"),
        ("def eval_round(self, wi, wo):\n        return 0", "has a method eval_round"),
    ],
)
def test_a_slip_in_what_is_declared_is_refused_when_the_class_is_made(
    body: str, words: str
) -> None:
    text = f"class Wrong(Lobe, register=False):\n    {body}\n"
    with pytest.raises(ModelError, match=words):
        exec(
            text, {"Lobe": Lobe, "NumericAlbedo": NumericAlbedo, "vec2": vec2, "__name__": "wrong"}
        )


def test_an_option_that_does_not_exist_is_pythons_error() -> None:
    with pytest.raises(TypeError, match="streched"):
        NumericAlbedo("half_vectors", streched=True)  # type: ignore[call-arg]


def test_what_is_no_mirror_image_of_itself_is_not_halved() -> None:
    turned = polar(0.9, 2.0)[None]
    # The odd part integrates to 0: 0.2 π.
    np.testing.assert_allclose(Chiral().albedo(turned)[0], 0.2 * np.pi, rtol=SINGLE_LONG)

    class ChiralHighlight(Chiral, register=False):
        numeric = NumericAlbedo("half_vectors")

    np.testing.assert_allclose(
        ChiralHighlight().albedo(turned)[0], 0.2 * np.pi, rtol=NUMERIC_ALBEDO
    )


def by_all_nodes(model: Model, wo: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """By both sides of the plane of wo, and by all slopes and azimuths."""
    return np.asarray(arrays.call(model, "albedo", (wo,)))


@pytest.mark.parametrize(
    ("name", "parameters"),
    [("torrance_sparrow", {}), ("disney", {"anisotropic": 0.5}), ("patina", {}), ("phong", {})],
)
def test_half_the_azimuths_give_the_albedo_of_all(name: str, parameters: dict[str, Any]) -> None:
    model = gonio.model(name, **parameters)
    wo = np.stack([polar(t, p) for t, p in ((0, 0), (0.7, 1.0), (1.5, 4.0))])
    np.testing.assert_allclose(model.albedo(wo), by_all_nodes(model, wo), rtol=SINGLE)


@pytest.mark.parametrize(
    ("name", "parameters", "smooth"),
    [
        ("patina", {}, True),
        ("torrance_sparrow", {"alpha": 1e-4}, True),
        ("torrance_sparrow", {"masking": "cook_torrance"}, False),
    ],
)
def test_many_albedos_take_fewer_nodes_where_the_lobe_has_no_kink(
    name: str, parameters: dict[str, Any], smooth: bool
) -> None:
    model = gonio.model(name, **parameters)
    # Down to the horizon, where few would be 1e-4 off
    wo = polar(np.pi / 2 - np.geomspace(1e-6, np.pi / 2, 100), 0.7).astype(np.float32)
    known: dict[Any, Any] = {}
    numeric = for_quadrature(model, wo, known).numeric
    assert numeric.smooth == smooth
    few = quadrature.evaluations(numeric)
    assert few == (64 * 12 if smooth else 112 * 16) * 2 * 2
    np.testing.assert_allclose(model.albedo(wo), by_all_nodes(model, wo), atol=SMOOTHNESS)
    # One direction alone is not worth the question
    assert not for_quadrature(model, wo[0], {}).numeric.smooth


@pytest.mark.parametrize("name", ["torrance_sparrow", "weidlich_wilkie", "oren_nayar"])
def test_means_over_arrays_of_directions_are_those_of_the_kernels_loop(name: str) -> None:
    model = gonio.model(name)
    Float = backend.array_module().Float

    def means(lanes: int) -> np.ndarray[Any, Any]:
        """With parameters of so many lanes; of one, the kernel takes all directions at once."""
        bound = model.bind(
            Float,
            lambda path, p, value: opaque(Float, p.width, value) + dr.zeros(Float, lanes),
        )
        found = dr.replace_shape_t(Float, (3, -1))(quadrature.mean_albedo(bound))
        return np.array(found)

    at_once, looped = means(1), means(2)
    assert (at_once.shape, looped.shape) == ((3, 1), (3, 2))
    mean = np.asarray(model.mean_albedo())[:, None]
    # Sums in single precision, in two orders
    np.testing.assert_allclose(np.concatenate([at_once, looped], -1), mean + np.zeros(3), rtol=2e-6)


def test_a_mean_that_a_kernel_asks_for_is_found_once_for_all_its_lanes(monkeypatch: Any) -> None:
    asked = []
    albedo = gonio.TorranceSparrow.albedo

    def counted(self: Any, wo: Any) -> Any:
        asked.append(dr.width(wo))
        return albedo(self, wo)

    coat = gonio.WeidlichWilkie(bounces="diffuse", base="torrance_sparrow")
    monkeypatch.setattr(coat.base.written, "albedo", counted)
    wi, wo = polar(np.linspace(0.1, 1.2, 1000), 0.5), polar(0.3)
    coat.eval(wi, wo)
    assert asked == [len(quadrature.mean_nodes(True)[1])]


def test_means_take_parameters_from_arrays_and_have_gradients() -> None:
    torch = pytest.importorskip("torch")

    alpha = torch.tensor([0.1, 0.5], dtype=torch.float64, requires_grad=True)
    mean = gonio.TorranceSparrow(alpha=alpha).mean_albedo()
    assert mean.shape == (2, 3)
    (gradient,) = torch.autograd.grad(mean[:, 0].sum(), alpha)
    step = 1e-4
    up, down = (
        gonio.TorranceSparrow(alpha=alpha.detach() + s).mean_albedo() for s in (step, -step)
    )
    np.testing.assert_allclose(gradient, (up - down)[:, 0] / (2 * step), rtol=NUMERIC_ALBEDO)


def test_no_notice_comes_from_models_of_gonio() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name in gonio.models():
            gonio.model(name).albedo(UP)


def test_drjit_arrays_pass_straight_through() -> None:
    Array3f = backend.array_module().Array3f
    found = gonio.OrenNayar().albedo(Array3f(0, 0, 1))
    assert dr.is_array_v(found)


@pytest.mark.parametrize(
    "numeric",
    [
        NumericAlbedo("angles"),
        NumericAlbedo("half_vectors", symmetric=True),
        NumericAlbedo("half_vectors"),
        NumericAlbedo("half_vectors", symmetric=True, smooth=True),
        NumericAlbedo("mirror"),
        NumericAlbedo("half_vectors", stretched=True, round_part=True, symmetric=True),
    ],
    ids=["angles", "symmetric", "half_vectors", "smooth", "mirror", "round_part"],
)
def test_evaluations_are_as_many_as_a_rule_makes(numeric: NumericAlbedo) -> None:
    calls = []

    class Counted:
        """As little as a rule asks for, in plain Python."""

        float_type = float

        def eval(self, wi: Any, wo: Any) -> Any:
            calls.append(wi)
            return 0.25

        def eval_round(self, wi: Any, wo: Any) -> Any:
            calls.append(wi)
            return 0.125

        def slope_widths(self) -> Any:
            return vec2(0.5, 0.5)

        def bind(self, Float: Any, convert: Any) -> Any:
            return self

    model = Counted()
    model.numeric = numeric  # type: ignore[attr-defined]
    quadrature.directional_albedo(model, vec3(0.0, 0.6, 0.8))  # type: ignore[arg-type]
    beside = len(calls) - quadrature.evaluations(numeric)
    assert 0 <= beside <= 5  # for the types, and for a sum of nothing


def test_the_mean_under_a_coat_goes_round_a_stretched_base() -> None:
    """The coat alone follows no tangents; 24 cosines of 12 azimuths, summed here."""
    model = gonio.WeidlichWilkie(alpha=0.3, base=gonio.Ward(alpha_x=0.05, alpha_y=0.8))
    x, weights = np.polynomial.legendre.leggauss(24)
    z = np.sqrt((x + 1) / 2)  # 2 mu d mu = d(mu^2)
    azimuth = (np.arange(12) + 0.5) * np.pi / 6
    s = np.sqrt(1 - z * z)[:, None]
    wo = np.stack(
        [s * np.cos(azimuth), s * np.sin(azimuth), np.repeat(z[:, None], 12, axis=1)], axis=-1
    )
    summed = (np.asarray(model.albedo(wo)).mean(axis=1) * weights[:, None] / 2).sum(axis=0)
    # One azimuth would be 3 % off; both sums meet the grazing rise with few nodes
    assert model.mean_albedo() == pytest.approx(summed, rel=2e-4)
