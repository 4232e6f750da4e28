"""Ground truth as a Mitsuba 3 BSDF: `gonio_layered_reference`.

    import gonio.mitsuba
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    mi.load_dict({"type": "gonio_layered_reference", "eta": 1.5, "alpha": 0.1, "sigma_a": 0.2,
                  "base": {"type": "gonio_lambert"}})

One plug-in is one layer; its base is a gonio BSDF or another layer. Properties: eta, alpha (0 is smooth),
sigma_a, thickness (numbers, colours or textures), distribution ("ggx" or "beckmann"), base, and walks, the
number of random walks of each evaluation in the outermost layer.

Values and densities are estimates, without bias. Their random numbers are scrambled from the directions and
the place, so that the same question has the same answer: `pdf` is then a function, if a rough one, and
multiple importance sampling by it adds nothing and loses nothing, whatever its values are. Samples are
walks; their weights need no density.
"""

from __future__ import annotations

import struct
from typing import Any

import drjit as dr
import mitsuba as mi

from gonio.fields import ModelError, Parameter
from gonio.lang import select, vec3
from gonio.mitsuba.properties import PLUGIN, PREFIX, parameter_texture, plain, reject_unknown
from gonio.mitsuba.upsampling import holds_rgb, spread
from gonio.parts.distribution import ALPHA_MIN
from gonio.reference.generator import generator, scramble
from gonio.reference.interfaces import Pile, chance
from gonio.reference.stack import Slab, assemble
from gonio.reference.walk import Channels, Quantity, State, direct, walk

# Walks of an evaluation, unless the user wants others: a picture averages many evaluations anyway.
WALKS = 4

# Added to the density, so that no direction in which a walk can leave has a density of 0, which renderers
# take for a failed sample. It has no say in the values.
DENSITY_MIN = 1e-4

PARAMETERS = (
    Parameter(1.5, 1 / 3, 3, "index of the layer over that of the medium above it", "eta"),
    Parameter(0.0, 0, 1, "width of the facets' slopes; 0 is smooth", "alpha"),
    Parameter((0, 0, 0), 0, 1e6, "absorption per unit of thickness", "sigma_a", 3),
    Parameter(1.0, 0, 1e6, "thickness of the layer", "thickness"),
)
NAME = PLUGIN.removeprefix(PREFIX)
NAMES = [*(p.name for p in PARAMETERS), "distribution", "base", "walks"]


def derive() -> Any:
    """The plug-in's class for Mitsuba's current variant."""
    types: Any = getattr(mi, mi.variant())
    width = dr.size_v(types.UnpolarizedSpectrum)
    count = max(width, 3)
    # Colours of a walk: three channels, also for one, or as many as there are wavelengths
    scalar = dr.scalar.Array3f64 if count == 3 else dr.scalar.Array4f64
    channels = scalar if types.Float is float else dr.replace_shape_t(types.Float, (count, -1))
    flags = mi.BSDFFlags
    spectral = mi.is_spectral

    def spectrum(colour: Any) -> Any:
        value = types.UnpolarizedSpectrum(*[colour[c] for c in range(width)])
        return types.mueller.depolarizer(value) if types.is_polarized else types.Spectrum(value)

    class Plugin(types.BSDF):  # type: ignore[misc]
        """A layer over a base, as a BSDF of one variant."""

        def __init__(self, properties: Any) -> None:
            super().__init__(properties)
            reject_unknown(NAME, NAMES, properties)
            self.spread: Any = spread() if spectral else None
            self.parts = {p.name: parameter_texture(NAME, p, properties) for p in PARAMETERS}
            alpha = properties.get("alpha", 0.0)
            self.smooth = isinstance(alpha, (int, float)) and alpha == 0
            self.distribution = properties.get("distribution", "ggx")
            if self.distribution not in ("ggx", "beckmann"):
                raise ModelError(
                    f"{PLUGIN}: distribution={self.distribution!r} is not known; allowed are ggx, beckmann."
                )
            self.walks = properties.get("walks", WALKS)
            if not isinstance(self.walks, int) or self.walks < 1:
                raise ModelError(
                    f"{PLUGIN}: walks={self.walks!r} is not known; allowed is 1 or more."
                )
            base = properties.get("base", "lambert")
            if isinstance(base, str):
                base = mi.load_dict({"type": PREFIX + base})
            if not hasattr(base, "model") and not hasattr(base, "slabs"):
                raise ModelError(
                    f"{PLUGIN}: base is {base}; allowed are a BSDF of type {PREFIX}... and a "
                    "model's name."
                )
            self.base = base
            glossy = flags.GlossyReflection | flags.FrontSide
            mirror = flags.DeltaReflection | flags.FrontSide
            self.m_components = [mirror, glossy] if self.smooth else [glossy]
            self.m_flags = mirror | glossy if self.smooth else glossy

        def traverse(self, callback: Any) -> None:
            for name, part in (self.parts | {"base": self.base}).items():
                callback.put(name, part, mi.ParamFlags.NonDifferentiable)

        def to_string(self) -> str:
            shown = self.parts | {
                "distribution": self.distribution,
                "walks": self.walks,
                "base": self.base,
            }
            lines = (f"{name} = {value}".replace("\n", "\n  ") for name, value in shown.items())
            return f"{PLUGIN}[\n  " + ",\n  ".join(lines) + "\n]"

        def slabs(self, si: Any, active: Any) -> list[Slab]:
            """This layer and those below it, with what their textures hold at si."""
            held = {}
            for declared in PARAMETERS:
                texture = self.parts[declared.name]
                if declared.width == 1:
                    value = texture.eval_1(si, active)
                elif spectral and holds_rgb(texture):
                    value = self.spread(texture.eval_3(si, active), si, active)
                else:
                    value = texture.eval(si, active)
                value = dr.clip(value, declared.low, declared.high)
                held[declared.name] = value
            sigma, d = held["sigma_a"], held["thickness"]
            depth = channels(*(sigma[c % width] * d for c in range(count)))
            alpha = None if self.smooth else dr.maximum(held["alpha"], ALPHA_MIN)
            slab = Slab(held["eta"], alpha, depth, self.distribution == "ggx")
            below = self.base.slabs(si, active) if hasattr(self.base, "slabs") else []
            return [slab, *below]

        def innermost(self, si: Any, active: Any) -> Any:
            """The model below all layers, with what its textures hold at si."""
            if hasattr(self.base, "slabs"):
                return self.base.innermost(si, active)
            models = self.base._bound(si, active, by_wavelength=True)
            return models[0] if len(models) == 1 else Channels(models, count)

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            with dr.suspend_grad():
                return self._sample(ctx, si, sample1, sample2, active)

        def _sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any
        ) -> tuple[Any, Any]:
            wo, scene = plain(si.wi), assemble(self.slabs(si, active), self.innermost(si, active))
            active = active & (wo.z > 0)
            rng = _generator(wo.x, wo.y, sample1, sample2.x, sample2.y)
            end = self._walked(scene, wo, None, rng, 1, "sample", active)
            wi = end.exit
            left = active & (wi.z > 0)
            top = scene.surfaces[0]
            density = self._estimate(si, scene, _safe(wi), wo, left, "density")[0] + DENSITY_MIN
            kind, component = dr.zeros(types.UInt32), dr.zeros(types.UInt32)
            kind, component = kind + int(+flags.GlossyReflection), component + int(self.smooth)
            if isinstance(top, Pile):
                mirrored = end.specular
                bend = top.bend(_safe(wo).z, True)
                density = select(mirrored, 1 - chance(bend), density)
                kind = dr.select(mirrored, types.UInt32(+flags.DeltaReflection), kind)
                component = dr.select(mirrored, types.UInt32(0), component)
                wanted = ctx.is_enabled(flags.DeltaReflection, 0)
                left = left & (mirrored & wanted | _not(mirrored))
                wanted = ctx.is_enabled(flags.GlossyReflection, 1)
                left = left & (mirrored | _not(mirrored) & wanted)
            else:
                left = left & ctx.is_enabled(flags.GlossyReflection, 0)
            bs = dr.zeros(types.BSDFSample3f)
            bs.wo = types.Vector3f(wi.x, wi.y, wi.z)
            bs.pdf = dr.select(left, density, 0)
            bs.eta = 1.0
            bs.sampled_type, bs.sampled_component = kind, component
            return bs, dr.select(left, spectrum(end.total), 0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self._both(ctx, si, wo, active, True, False)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self._both(ctx, si, wo, active, False, True)[1]

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return self._both(ctx, si, wo, active, True, True)

        def _both(
            self, ctx: Any, si: Any, wo: Any, active: Any, valued: bool, dense: bool
        ) -> tuple[Any, Any]:
            with dr.suspend_grad():
                wi, wo = plain(wo), plain(si.wi)
                active = active & (wi.z > 0) & (wo.z > 0)
                active = active & ctx.is_enabled(flags.GlossyReflection, int(self.smooth))
                scene = assemble(self.slabs(si, active), self.innermost(si, active))
                value, density = channels(0 * wi.z), 0 * wi.z
                if valued:
                    value = self._estimate(si, scene, _safe(wi), _safe(wo), active, "value") * wi.z
                if dense:
                    density = self._estimate(si, scene, _safe(wi), _safe(wo), active, "density")[0]
                    density = density + DENSITY_MIN
                return (
                    dr.select(active, spectrum(value), 0),
                    dr.select(active, density, 0),
                )

        def _estimate(
            self, si: Any, scene: Any, wi: Any, wo: Any, active: Any, quantity: Quantity
        ) -> Any:
            """Mean of `walks` walks, with random numbers that belong to the directions and the place."""
            rng = _generator(wi.x, wi.y, wo.x, wo.y, si.p.x, si.p.y, si.p.z, salt=len(quantity))
            end = self._walked(scene, wo, wi, rng, self.walks, quantity, active)
            once = direct(scene, wi, wo)[0 if quantity == "value" else 1]
            return end.total / self.walks + once

        def _walked(
            self,
            scene: Any,
            wo: Any,
            wi: Any,
            rng: Any,
            walks: int,
            quantity: Quantity,
            active: Any,
        ) -> State:
            Float = types.Float
            if Float is float:
                return walk(scene, _safe(wo), wi, rng, walks if active else 0, quantity, Float)
            counts = dr.select(active, types.UInt32(walks), types.UInt32(0))
            return walk(scene, _safe(wo), wi, rng, counts, quantity, Float)

    return Plugin


def _safe(w: Any) -> Any:
    """A direction above the horizon; values for others are masked."""
    up = w.z > 0
    return vec3(select(up, w.x, 0), select(up, w.y, 0), select(up, w.z, 1))


def _not(mask: Any) -> Any:
    return not mask if isinstance(mask, bool) else ~mask


def _generator(*numbers: Any, salt: int = 0) -> Any:
    """Random numbers that belong to some floats, bit by bit."""
    words = [_bits(x) for x in numbers]
    first, second = words[0], words[1]
    for word in words[2:]:
        first, second = scramble(first ^ word, second, rounds=3)
    return generator(first, second ^ salt)


def _bits(x: Any) -> Any:
    if isinstance(x, float):
        return int.from_bytes(struct.pack("<f", x), "little")
    UInt = dr.uint32_array_t(type(x))
    return dr.reinterpret_array(UInt, dr.detach(x))
