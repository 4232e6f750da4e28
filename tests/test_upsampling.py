"""Spectral variants show the colours of RGB: whatever a parameter is, and for every ready material."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from support.tolerances import DOUBLE

import gonio
import gonio.mitsuba
from gonio.materials import library, load_material
from gonio.mitsuba import node
from gonio.mitsuba.upsampling import primaries, wavelengths

# Mitsuba's observer and daylight, every nanometre.
NANOMETRES = np.arange(360.0, 830.5)


def light() -> tuple[Any, Any]:
    """Weights that turn a spectrum at NANOMETRES, lit by D65, into XYZ; and XYZ into linear sRGB."""
    observer = np.array([np.ravel(mi.cie1931_xyz(float(w))) for w in NANOMETRES])
    daylight = np.array([float(np.ravel(mi.cie_d65(float(w)))[0]) for w in NANOMETRES])
    weights = daylight[:, None] * observer
    # IEC 61966-2-1, from the chromaticities of BT.709 and D65
    to_rgb = np.array(
        [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    )
    return weights / weights[:, 1].sum(), to_rgb


def as_rgb(spectrum: Any) -> Any:
    weights, to_rgb = light()
    return to_rgb @ (weights.T @ spectrum)


def seen(bsdf: Any, wi: Any, wo: Any) -> Any:
    """Linear sRGB of a BSDF's value in D65, in a scalar variant."""
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi, si.uv = mi.Vector3f(*wo), mi.Point2f(0.5)
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    context = mi.BSDFContext()
    if not mi.is_spectral:
        return np.array(bsdf.eval(context, si, mi.Vector3f(*wi)))
    grid = np.arange(360.0, 830.5, 10)
    grid = np.append(grid, [830.0] * (-len(grid) % 4))
    values = []
    for four in grid.reshape(-1, 4):
        si.wavelengths = type(si.wavelengths)(*four.tolist())
        values.append(np.array(bsdf.eval(context, si, mi.Vector3f(*wi))))
    return as_rgb(np.interp(NANOMETRES, grid, np.concatenate(values)))


def both(description: Any, wi: Any = (0.48, 0.1, 0.87), wo: Any = (-0.4, 0.2, 0.89)) -> Any:
    found = []
    for variant in ("scalar_rgb", "scalar_spectral"):
        mi.set_variant(variant)
        bsdf = mi.load_dict(description() if callable(description) else description)
        unit = [np.array(w) / np.linalg.norm(w) for w in (wi, wo)]
        found.append(seen(bsdf, *(u.tolist() for u in unit)))
    return found


@pytest.fixture(autouse=True, scope="module")
def _variant() -> Any:
    mi.set_variant("scalar_spectral")
    yield
    mi.set_variant("llvm_ad_rgb")


def test_the_three_spectra_are_reflectances_that_add_up_and_look_like_the_primaries() -> None:
    spectra = primaries()
    assert spectra.min() >= 0
    assert spectra.max() <= 1
    np.testing.assert_allclose(spectra.sum(axis=0), 1, atol=DOUBLE)
    for spectrum, primary in zip(spectra, np.eye(3), strict=True):
        shown = as_rgb(np.interp(NANOMETRES, wavelengths(), spectrum))
        np.testing.assert_allclose(shown, primary, atol=2e-3)  # the matrix has four digits


@pytest.mark.parametrize("name", library())
def test_every_ready_material_has_its_colour_in_spectral_variants(name: str) -> None:
    rgb, spectral = both(lambda: node(load_material(name).model))
    # 1 %: the matrix has four digits, and the grid ten nanometres
    np.testing.assert_allclose(spectral, rgb, rtol=0.01, atol=0.002 * rgb.max())


@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("lambert", {"rho": (0.9, 0.1, 0.3)}),  # reflectance
        ("torrance_sparrow", {"eta": (0.2, 0.9, 1.4), "k": (3.9, 2.4, 1.9)}),  # index, extinction
        (
            "weidlich_wilkie",  # absorption
            {"sigma_a": (0.1, 3.0, 9.0), "thickness": 0.5, "base": gonio.Lambert(rho=0.9)},
        ),
    ],
)
def test_every_kind_of_parameter_is_upsampled_rightly(model: str, parameters: Any) -> None:
    rgb, spectral = both(lambda: node(gonio.model(model, **parameters)))
    # 0.1 %: the matrix has four digits, and the grid ten nanometres; small colours have the largest's error
    np.testing.assert_allclose(spectral, rgb, rtol=1e-3, atol=5e-4 * rgb.max())


@pytest.mark.parametrize("colour", [(0.9, 0.4, 0.1), (0.05, 0.6, 0.9), (0.5, 0.5, 0.5)])
def test_lambert_has_the_colour_of_mitsubas_diffuse(colour: tuple[float, ...]) -> None:
    """The spectra differ (Mitsuba's are smoother); what the observer sees does not."""
    mi.set_variant("scalar_spectral")
    rgb = {"type": "rgb", "value": list(colour)}
    ours = mi.load_dict({"type": "gonio_lambert", "rho": rgb})
    theirs = mi.load_dict({"type": "diffuse", "reflectance": rgb})
    found, expected = (seen(bsdf, (0, 0, 1), (0, 0.6, 0.8)) for bsdf in (ours, theirs))
    # 0.2 %, for the same reason
    np.testing.assert_allclose(found, np.array(colour) / np.pi, rtol=2e-3, atol=1e-4)
    # 2 %: Mitsuba's fit of smooth spectra meets a colour to that
    np.testing.assert_allclose(found, expected, rtol=0.02, atol=3e-3)


def test_colours_beside_a_real_spectrum_keep_their_colour() -> None:
    """A grey spectrum changes nothing but that the model computes by wavelength."""
    mi.set_variant("scalar_spectral")
    found = []
    for rho in (
        {"type": "rgb", "value": 0.5},
        {"type": "spectrum", "value": [(300, 0.5), (900, 0.5)]},
    ):
        description = {
            "type": "gonio_weidlich_wilkie",
            "sigma_a": {"type": "rgb", "value": [0.1, 1.5, 4.0]},
            "thickness": 0.2,
            "base": {"type": "gonio_lambert", "rho": rho},
        }
        found.append(seen(mi.load_dict(description), (0.3, 0, 0.954), (-0.3, 0, 0.954)))
    in_rgb, by_wavelength = found
    # 5 %: where the three spectra overlap, exp(-sigma) of a mean is not the mean of exp(-sigma)
    np.testing.assert_allclose(by_wavelength, in_rgb, rtol=0.05)
    assert np.abs(by_wavelength / in_rgb - 1).max() > 1e-5  # it did
