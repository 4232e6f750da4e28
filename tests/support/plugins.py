"""Models as Mitsuba BSDFs in tests: what plug-ins answer, in gonio's words, beside the arrays."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

import gonio.mitsuba
from gonio import backend
from gonio.check.variants import value_at
from gonio.fields import Parameter
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from support.directions import Array, polar, random_directions

MODELS = sorted(gonio.models().items())
EACH = pytest.mark.parametrize("cls", [cls for _, cls in MODELS], ids=[name for name, _ in MODELS])
# All but those that only turn or combine other models, and have no numbers of their own.
WITH_NUMBERS = [
    (name, cls)
    for name, cls in MODELS
    if any(isinstance(f, Parameter) for f in cls.fields.values())
]
EACH_WITH_NUMBERS = pytest.mark.parametrize(
    "cls", [cls for _, cls in WITH_NUMBERS], ids=[name for name, _ in WITH_NUMBERS]
)

PROMISED = ("scalar_rgb", "llvm_ad_rgb", "llvm_ad_spectral", "llvm_ad_mono")
CUDA_TWINS = ("cuda_ad_rgb", "cuda_ad_spectral", "cuda_ad_mono")
RUNNABLE = [v for v in mi.variants() if not v.startswith("cuda") or backend.available("cuda")]
IN_EACH_VARIANT = pytest.mark.parametrize("variant", RUNNABLE, indirect=True)
IN_EACH_PROMISED_VARIANT = pytest.mark.parametrize(
    "variant", [v for v in RUNNABLE if v in PROMISED + CUDA_TWINS], indirect=True
)

# Two float32 kernels of the same formulas, of which one has more fused multiplications.
FLOAT32 = 2e-5


class Lambertian(Model, register=False):
    """The least that a model needs; the broken ones below derive from it."""

    rho: Color = gonio.param((0.5, 0.5, 0.5), 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)


def load(cls: type[Model], **properties: Any) -> Any:
    """A model as a BSDF of the current variant; classes outside the registry are registered first."""
    gonio.mitsuba.register(cls)
    return mi.load_dict({"type": f"gonio_{cls.name}", **properties})


def numbers(cls: type[Model]) -> list[Parameter]:
    return [p for p in cls.fields.values() if isinstance(p, Parameter)]


def between(cls: type[Model], t: float) -> dict[str, float]:
    """Every parameter at a place in its range, rounded to float32 as Mitsuba stores it."""
    return {p.name: float(np.float32(value_at(p, t))) for p in numbers(cls)}


def interaction(wo: Any, uv: Any = (0.5, 0.5)) -> Any:
    """Surface hits whose viewer is at wo (n, 3); in scalar variants one direction (3,)."""
    wo = np.asarray(wo, np.float64)
    si = dr.zeros(mi.SurfaceInteraction3f, *([] if wo.ndim == 1 else [len(wo)]))
    si.wi = vector(wo)
    si.uv = mi.Point2f(*uv)
    si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    si.n = mi.Normal3f(0, 0, 1)
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    if mi.is_spectral:
        si.wavelengths += type(si.wavelengths)(450.0, 520.0, 590.0, 660.0)
    return si


def vector(w: Any) -> Any:
    w = np.asarray(w)
    scalar = mi.variant().startswith("scalar")
    return mi.Vector3f(*(float(c) if scalar or w.ndim == 1 else mi.Float(c) for c in w.T))


def channels(spectrum: Any) -> Array:
    """A spectrum as (n, channels); of a Mueller matrix the first entry, intensity to intensity."""
    if mi.is_polarized:
        spectrum = spectrum[0, 0]
    return np.array(spectrum).reshape(dr.size_v(mi.UnpolarizedSpectrum), -1).T


def wiring(bsdf: Any, wi: Array, wo: Array, u: Array) -> dict[str, Array]:
    """All that the plug-in answers, in gonio's words: (n, channels), (n,), (n, 3)."""
    if mi.variant().startswith("scalar"):
        rows = [_wiring(bsdf, *row) for row in zip(wi, wo, u, strict=True)]
        return {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    return _wiring(bsdf, wi, wo, u)


def _wiring(bsdf: Any, wi: Array, wo: Array, u: Array) -> dict[str, Array]:
    ctx, si = mi.BSDFContext(), interaction(wo)
    scalar = mi.variant().startswith("scalar")
    first, second = (float(c) if scalar else mi.Float(c) for c in u.T)
    bs, weight = bsdf.sample(ctx, si, 0.5, mi.Point2f(first, second))
    value, pdf = bsdf.eval_pdf(ctx, si, vector(wi))
    dr.eval(value, pdf, bs, weight)
    return {
        "value": channels(value),
        "pdf": np.atleast_1d(pdf),
        "sample": np.array(bs.wo).reshape(3, -1).T,
        "sample_pdf": np.atleast_1d(bs.pdf),
        "weight": channels(weight),
    }


def reflectance(bsdf: Any, wo: Array) -> Array:
    """What denoisers see of it: (n, channels)."""
    if mi.variant().startswith("scalar"):
        return np.concatenate([channels(bsdf.eval_diffuse_reflectance(interaction(w))) for w in wo])
    found = channels(bsdf.eval_diffuse_reflectance(interaction(wo)))
    return np.broadcast_to(found, (len(wo), found.shape[1]))


def contract(model: Model, wi: Array, wo: Array, u: Array) -> dict[str, Array]:
    """The same from the array API, with the cosine that Mitsuba wants."""
    found, pdf = model.sample(wo, u)
    good = pdf > 0
    weight = model.eval(found, wo) * (found[:, 2] / np.where(good, pdf, 1))[:, None]
    return {
        "value": model.eval(wi, wo) * np.maximum(wi[:, 2:], 0),
        "pdf": model.pdf(wi, wo),
        "sample": found,
        "sample_pdf": pdf,
        "weight": np.where(good[:, None], weight, 0),
    }


def disagreement(bsdf: Any, model: Model, count: int = 24) -> float:
    """Largest error of a plug-in against the arrays, relative to the value or to 0.01.

    The arrays have Mitsuba's precision: what rounding does to a steep lobe is not the plug-in's business.
    """
    wi, wo = random_directions(count, 1), random_directions(count, 2)
    wi[0], wo[0] = wo[1], wo[1]
    wi[-2:] *= -1  # light and viewer below the horizon
    wo[-3:-1] *= -1
    u = np.random.default_rng(3).random((count, 2), np.float32)
    found = wiring(bsdf, wi, wo, u)
    precision = np.float64 if mi.variant().startswith("scalar") else np.float32
    expected = contract(model, *(x.astype(precision) for x in (wi, wo, u)))
    assert (found["value"][-3:] == 0).all()
    assert (found["pdf"][-3:] == 0).all()
    assert (found["weight"][-3:-1] == 0).all()
    sampled = expected["sample_pdf"] > 0
    worst = 0.0
    for name, b in expected.items():
        a = found[name]
        if name == "sample":
            a, b = a[sampled], b[sampled]
        elif b.ndim == 2 and a.shape != b.shape:  # other channels than RGB: the models are grey
            b = b[:, :1]
        assert a.shape[0] == b.shape[0]
        worst = max(worst, float(np.max(np.abs(a - b) / np.maximum(np.abs(b), 1e-2), initial=0)))
    return worst


SUN = {"type": "directional", "direction": [-1, -0.5, -0.7], "irradiance": 3.0}


SKY = {"type": "constant"}


def ball(bsdf: Any, integrator: Any = "path", emitter: Any = SKY, size: int = 8) -> dict[str, Any]:
    """A sphere that fills a small picture, seen from +z."""
    if isinstance(integrator, str):
        integrator = {"type": integrator, "max_depth": 2}
    to_world = mi.ScalarTransform4f().look_at([0, 0, 6], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    film |= {"pixel_format": "luminance" if mi.is_monochromatic else "rgb"}
    return {
        "type": "scene",
        "integrator": integrator,
        "sensor": {"type": "perspective", "fov": 20, "to_world": to_world, "film": film},
        "emitter": emitter,
        "ball": {"type": "sphere", "radius": 2.0, "bsdf": bsdf},
    }


def grey_value(bsdf: Any, uv: Any = (0.5, 0.5)) -> Array:
    """One value of a BSDF, per channel."""
    return channels(
        bsdf.eval(mi.BSDFContext(), interaction(polar(0.4), uv), vector(polar(1.0, 2)))
    )[0]


def bitmap(*texels: Any) -> dict[str, Any]:
    """A row of texels, one number or three each, as a texture of raw data without interpolation."""
    data = np.array([texels], np.float32)
    image = mi.Bitmap(data.reshape(1, len(texels), -1))
    return {"type": "bitmap", "bitmap": image, "raw": True, "filter_type": "nearest"}


WI, WO = random_directions(64, 8), random_directions(64, 9)
