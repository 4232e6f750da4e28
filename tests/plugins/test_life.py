"""Every registered model as a Mitsuba BSDF: life of its objects, and of the process."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import mitsuba as mi
import numpy as np
import pytest
from support.directions import Array
from support.plugins import (
    RUNNABLE,
    WI,
    WO,
    Lambertian,
    ball,
    bitmap,
    grey_value,
    interaction,
    load,
    vector,
)
from support.tolerances import SINGLE

from gonio.lang import Color, Vec3
from gonio.model import Model


def test_objects_outlive_a_change_of_variant() -> None:
    before = mi.load_dict({"type": "gonio_eon"})
    ctx, si, wi = mi.BSDFContext(), interaction(WO), vector(WI)
    expected = before.eval(ctx, si, wi).numpy()
    for other in RUNNABLE:
        mi.set_variant(other)
        mi.load_dict({"type": "gonio_eon"})
        value, _ = before.eval_pdf(ctx, si, wi)
        np.testing.assert_allclose(value.numpy(), expected, rtol=SINGLE)
        before.sample(ctx, si, 0.5, si.uv)
        assert before.eval_diffuse_reflectance(si).x[0] > 0
    mi.set_variant("llvm_ad_rgb")
    again = mi.load_dict({"type": "gonio_eon"})
    assert type(again) is type(before)
    assert (again.eval(mi.BSDFContext(), si, wi).numpy() == expected).all()


def test_a_dictionary_loads_twice() -> None:
    scene = ball({"type": "gonio_eon", "roughness": bitmap(0.25, 0.75)})
    first, second = (mi.render(mi.load_dict(scene), spp=1, seed=1).numpy() for _ in range(2))
    assert (first == second).all()


def test_objects_are_freed() -> None:
    def alive() -> int:
        gc.collect()
        return sum(type(o).__name__ == "Plugin" for o in gc.get_objects())

    before = alive()
    scenes = [mi.load_dict(ball({"type": "gonio_eon"})) for _ in range(5)]
    mi.render(scenes[0], spp=1)
    assert alive() == before + 5
    del scenes
    assert alive() == before


def test_threads_do_not_disturb_each_other() -> None:
    def work(number: int) -> Array:
        return grey_value(mi.load_dict({"type": "gonio_eon", "roughness": number / 32}))

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(work, range(32)))
    assert (np.array(together) == np.array([work(number) for number in range(32)])).all()


def test_a_redefined_model_replaces_the_old_one() -> None:
    """As it happens in notebooks."""

    def define(factor: float) -> type[Model]:
        class Notebook(Lambertian, register=False):
            def eval(self, wi: Vec3, wo: Vec3) -> Color:
                return super().eval(wi, wo) * factor

        return Notebook

    first, second = grey_value(load(define(1.0))), grey_value(load(define(0.5)))
    np.testing.assert_allclose(second, 0.5 * first, rtol=SINGLE)


def run(code: str, *flags: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *flags, "-c", code],
        env={k: v for k, v in os.environ.items() if k != "DRJIT_LIBLLVM_PATH"} | environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_users_own_model_is_a_plugin_after_register() -> None:
    code = """
import gonio.mitsuba, gonio, mitsuba as mi
mi.set_variant("llvm_ad_rgb")
class FlatGrey(gonio.Model):
    value: gonio.lang.Float = gonio.param(0.25, 0, 1, "value")
    def eval(self, wi, wo): return 0 * wi + self.value
    def sample(self, wo, u): return gonio.Sample(wo, 1 + 0 * u.x)
    def pdf(self, wi, wo): return 0 * wi.z + 1
gonio.mitsuba.register()
print(mi.load_dict({"type": "gonio_flat_grey", "value": 0.75}))
mi.set_variant("llvm_ad_mono")
print(mi.load_dict({"type": "gonio_flat_grey", "value": 0.75}))
"""
    done = run(code, "-W", "error")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("gonio_flat_grey[") == 2


MITSUBA_FIRST = """
import drjit as dr, mitsuba as mi
{disguise}
import gonio, gonio.mitsuba
mi.set_variant("scalar_rgb")
print(mi.load_dict({{"type": "gonio_eon"}}))
try:
    mi.set_variant("llvm_ad_rgb")
    bsdf = mi.load_dict({{"type": "gonio_eon"}})
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = [0, 0, 1]
    print("value", bsdf.eval(mi.BSDFContext(), si, mi.Vector3f([0, 0.6], 0, [1, 0.8])))
except (gonio.BackendError, ImportError) as error:
    print("error", error)
"""
REMEDY = "import gonio.mitsuba before mitsuba and drjit, or set DRJIT_LIBLLVM_PATH="


def test_importing_mitsuba_first_works_or_says_what_to_do() -> None:
    """Whatever LLVM the system has: the process must not be ended by it."""
    done = run(MITSUBA_FIRST.format(disguise=""))
    assert done.returncode == 0, done.stderr
    assert "gonio_eon[" in done.stdout
    assert "value [[" in done.stdout or ("error" in done.stdout and REMEDY in done.stderr)


OLD_LLVM = "dr.detail.llvm_version = lambda: (15, 0, 6)"
NO_LLVM = "dr.detail.llvm_version = lambda: (-1, -1, -1)"


@pytest.mark.parametrize(("disguise", "named"), [(OLD_LLVM, "LLVM 15"), (NO_LLVM, "no LLVM")])
def test_an_llvm_that_was_loaded_too_early_is_refused(disguise: str, named: str) -> None:
    """The process would end with "Cannot select: fmaximum" at the first kernel."""
    done = run(MITSUBA_FIRST.format(disguise=disguise))
    assert done.returncode == 0, done.stderr
    assert "gonio_eon[" in done.stdout  # scalar variants need no LLVM
    assert f"UserWarning: Dr.Jit has loaded {named}" in done.stderr
    assert REMEDY in done.stderr
    if named == "LLVM 15":
        assert "error Dr.Jit has loaded LLVM 15, and Mitsuba's llvm variants need 16" in done.stdout
        assert REMEDY in done.stdout


def test_an_old_llvm_is_refused_on_import_too() -> None:
    done = run(
        "import drjit as dr, mitsuba as mi\nmi.set_variant('llvm_ad_rgb')\n"
        f"{OLD_LLVM}\nimport gonio.mitsuba",
        DRJIT_LIBLLVM_PATH=os.environ["DRJIT_LIBLLVM_PATH"],
    )
    assert done.returncode == 1
    assert REMEDY in done.stderr.splitlines()[-1]


def test_a_bare_import_chooses_no_variant_and_warns_of_nothing() -> None:
    done = run("import gonio.mitsuba, mitsuba as mi; print(mi.variant())", "-W", "error")
    assert (done.returncode, done.stdout.strip()) == (0, "None"), done.stderr
