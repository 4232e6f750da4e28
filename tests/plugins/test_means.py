"""Every registered model as a Mitsuba BSDF: mean albedos of what lies below a coat are found once."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import pytest
from support.plugins import ball, bitmap, disagreement
from support.tolerances import SINGLE_LONG

import gonio
from gonio.albedos import quadrature

COPPER = {"type": "gonio_torrance_sparrow", "alpha": 0.2, "metal": "Cu"}
COAT = {"type": "gonio_weidlich_wilkie", "bounces": "diffuse"}
PHYSICAL = {"solid_angle": "compressed", "transmission": "both_ways"}


@pytest.fixture
def no_sums(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mean that Mitsuba's kernel, or plain Python, sums is an error; it would take minutes."""
    own = quadrature._mean_albedo

    def summed(model: Any) -> Any:
        recorded = dr.flag(dr.JitFlag.SymbolicScope) or model.float_type is float
        assert not recorded, f"{model.name} sums its mean albedo at every point"
        return own(model)

    monkeypatch.setattr(quadrature, "_mean_albedo", summed)


def model(alpha: float) -> Any:
    copper = gonio.load("torrance_sparrow:metal=Cu").replace(alpha=alpha)
    return gonio.WeidlichWilkie(bounces="diffuse", base=copper)


@pytest.mark.parametrize("variant", ["llvm_ad_rgb", "scalar_rgb"], indirect=True)
@pytest.mark.usefixtures("no_sums")
def test_a_metal_under_a_coat_is_what_the_arrays_say(variant: str) -> None:
    bsdf = mi.load_dict({**COAT, "base": COPPER})
    assert disagreement(bsdf, model(0.2), count=8) < SINGLE_LONG


@pytest.mark.usefixtures("no_sums")
def test_a_value_that_changes_changes_the_mean() -> None:
    bsdf = mi.load_dict({**COAT, "base": COPPER})
    parameters = mi.traverse(bsdf)
    parameters["base.alpha.value"] = 0.9
    parameters.update()
    assert disagreement(bsdf, model(0.9), count=8) < SINGLE_LONG


@pytest.mark.usefixtures("no_sums")
def test_a_picture_of_coats_over_coats_needs_no_sum() -> None:
    inner = {**COAT, "alpha": 0.3, "base": COPPER}
    coats = mi.load_dict({**COAT, **PHYSICAL, "base": inner | PHYSICAL})
    assert set(coats.means) == {"base", "base.base"}
    assert mi.render(mi.load_dict(ball(coats)), spp=1).numpy().mean() > 0.1


@pytest.mark.usefixtures("no_sums")
def test_a_sum_at_every_point_is_noticed() -> None:
    scene = mi.load_dict(ball({**COAT, "base": {**COPPER, "alpha": bitmap(0.1, 0.5)}}))
    # Mitsuba's own message names its operation
    with pytest.raises(RuntimeError, match="error while performing"):
        mi.render(scene, spp=1)


def test_what_varies_or_is_differentiated_keeps_its_own_mean() -> None:
    varying = {**COPPER, "alpha": bitmap(0.1, 0.5)}
    assert not mi.load_dict({**COAT, "base": varying}).means
    bsdf = mi.load_dict({**COAT, "base": COPPER})
    assert set(bsdf.means) == {"base"}
    parameters = mi.traverse(bsdf)
    dr.enable_grad(parameters["base.alpha.value"])
    parameters.update()
    assert not bsdf.means


def test_nothing_is_asked_where_there_is_a_formula_or_no_bounce() -> None:
    assert not mi.load_dict({**COAT, "base": {"type": "gonio_lambert"}}).asked
    assert not mi.load_dict({**COAT, "bounces": "none", "base": COPPER}).asked
