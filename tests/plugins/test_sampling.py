"""Every registered model as a Mitsuba BSDF: samples against densities."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from support.directions import polar, random_directions
from support.plugins import EACH, Lambertian, between, interaction, load, wiring
from support.tolerances import SINGLE

import gonio.mitsuba
from gonio.check.variants import options
from gonio.lang import INV_PI, Float, Sample, Vec2, Vec3, vec2, vec3
from gonio.model import Model
from gonio.parts.hemisphere import pdf_cosine, sample_cosine

# At 4, Mitsuba's default, the trapezoid rule is 1e-4 off at Lambert: more than 1e7 samples forgive.
# Lobes as narrow as 0.05 need this many.
STEPS_PER_CELL = 96
ANGLES = (1.0, 60.0, 85.0)
AZIMUTH = 0.7

# Each of about two hundred tests may fail by chance; all together on one of a hundred machines.
CHI2_TESTS = 200


def chi2(cls: type[Model], degrees: float, **properties: Any) -> tuple[bool, str]:
    """Whether 1e7 samples at a resolution of 31 follow the pdf, and Mitsuba's remarks."""
    gonio.mitsuba.register(cls)
    bsdf, ctx = mi.load_dict({"type": f"gonio_{cls.name}", **properties}), mi.BSDFContext()
    si = interaction(polar(np.radians(degrees), AZIMUTH))
    dr.make_opaque(si.wi)  # one kernel for all angles

    def sample(u: Any) -> tuple[Any, Any]:
        bs, _ = bsdf.sample(ctx, si, u[0], mi.Point2f(u[1], u[2]))
        # mi.chi2.BSDFAdapter tells wasted samples by their weight, but black ones are not wasted.
        return bs.wo, dr.select(bs.pdf > 0, mi.Float(1), 0)

    def pdf(wi: Any) -> Any:
        return bsdf.pdf(ctx, si, wi)

    test = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(),
        sample_func=sample,
        pdf_func=pdf,
        sample_dim=3,
        sample_count=10_000_000,
        res=31,
        ires=STEPS_PER_CELL,
    )
    return test.run(significance_level=0.01, test_count=CHI2_TESTS, quiet=True), test.messages


@EACH
def test_samples_follow_the_density(cls: type[Model]) -> None:
    """At three angles; at the middle one with every option as well."""
    cases = [(degrees, {}) for degrees in ANGLES] + [(60.0, c) for c in options(cls)[1:]]
    for degrees, choice in cases:
        passed, messages = chi2(cls, degrees, **between(cls, 0.4), **choice)
        assert passed, (degrees, choice, messages)


@pytest.mark.parametrize("sampler", gonio.EON.fields["sampler"].values)
def test_samples_of_eon_follow_the_density(sampler: str) -> None:
    for degrees in ANGLES:
        for roughness in (0.3, 1.0):
            passed, messages = chi2(gonio.EON, degrees, roughness=roughness, sampler=sampler)
            assert passed, (degrees, roughness, messages)


class HalfAPercentOff(gonio.EON, register=False):
    """The lobe's share is 0.5 % too large; the density still sums to 1."""

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return super().pdf(wi, wo) + 0.005 * (2 * wi.z - 1) * INV_PI


class HalfAPercentTooMuch(Lambertian, register=False):
    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return super().pdf(wi, wo) * 1.005


class Turned(gonio.EON, register=False):
    """Samples turned by half a degree about the normal."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi, _ = super().sample(wo, u)
        wi = vec3(wi.x - 0.01 * wi.y, wi.y + 0.01 * wi.x, wi.z)
        return Sample(wi, self.pdf(wi, wo))


class Tilted(Lambertian, register=False):
    """Samples tilted by half a degree."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(vec3(wi.x + 0.01 * wi.z, wi.y, wi.z - 0.01 * wi.x), pdf_cosine(wi))


class CosineForgotten(Lambertian, register=False):
    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return 0 * wi.z + 0.5 * INV_PI


class RandomNumbersSwapped(gonio.EON, register=False):
    """Right alone, wrong in company: the second number decides on both lobe and azimuth."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return super().sample(wo, vec2(u.y, u.y))


class Unturned(gonio.EON, register=False):
    """Forgets that the viewer has an azimuth."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return super().sample(vec3((1 - wo.z * wo.z) ** 0.5, 0 * wo.z, wo.z), u)


BROKEN = [
    HalfAPercentOff,
    HalfAPercentTooMuch,
    Turned,
    Tilted,
    CosineForgotten,
    RandomNumbersSwapped,
    Unturned,
]


@pytest.mark.parametrize("cls", BROKEN)
def test_chi2_rejects_broken_samplers(cls: type[Model]) -> None:
    given = {"roughness": 1.0} if "roughness" in cls.fields else {}
    passed, messages = chi2(cls, 60, **given)
    assert not passed, messages


def test_chi2_accepts_what_the_broken_samplers_derive_from() -> None:
    assert chi2(Lambertian, 60)[0]
    assert chi2(gonio.EON, 60, roughness=1.0)[0]


@pytest.mark.parametrize("sampling", ["cosine", "uniform"])
def test_samples_that_know_nothing_of_the_model_follow_their_density(sampling: str) -> None:
    accepted, message = chi2(gonio.EON, 60.0, roughness=1.0, sampling=sampling)
    assert accepted, message
    bsdf = load(gonio.EON, sampling=sampling)
    wi, wo = random_directions(16, 1), random_directions(16, 2)
    wi[:4] *= -1  # below the horizon
    found = wiring(bsdf, wi, wo, np.random.default_rng(3).random((16, 2), np.float32))
    above = np.maximum(wi[:, 2], 0)
    expected = above / np.pi if sampling == "cosine" else (above > 0) / (2 * np.pi)
    np.testing.assert_allclose(found["pdf"], expected, rtol=SINGLE)


def test_a_sampling_that_does_not_exist_is_refused() -> None:
    with pytest.raises(
        RuntimeError, match="sampling is 'mirror'; allowed are own, cosine, uniform"
    ):
        load(gonio.EON, sampling="mirror")


def test_no_model_has_a_field_that_means_something_else() -> None:
    assert not [name for name, cls in gonio.models().items() if "sampling" in cls.fields]
