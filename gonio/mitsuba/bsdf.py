"""A model as a Mitsuba 3 BSDF.

This is where directions are swapped (Mitsuba's `si.wi` is the viewer's, gonio's `wo`) and values are
multiplied by the cosine.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from gonio.fields import ModelError, Parameter
from gonio.lang import MU_MIN, Sample, vec2, vec3
from gonio.mitsuba import means
from gonio.mitsuba.properties import (
    METAL,
    PREFIX,
    SAMPLING,
    metal_of,
    parameter_texture,
    plain,
    reject_unknown,
    sampling_of,
    say_slow,
    transparent,
)
from gonio.mitsuba.upsampling import holds_rgb, spread
from gonio.model import Child, Model
from gonio.parts.hemisphere import pdf_cosine, pdf_uniform, sample_cosine, sample_uniform


def derive(cls: type[Model]) -> Any:
    """The plug-in's class of a model, for Mitsuba's current variant."""
    # The types of the current variant. Objects keep theirs when another variant is chosen later.
    types: Any = getattr(mi, mi.variant())
    lobe = mi.BSDFFlags.GlossyReflection

    # Models know colours of three channels. One is given three times, and of four the first three and
    # three times the last; what is computed twice that way, Dr.Jit compiles once.
    count = dr.size_v(types.UnpolarizedSpectrum)
    triples = [[min(first + c, count - 1) for c in range(3)] for first in range(0, count, 3)]

    spectral = mi.is_spectral
    scalar = mi.variant().startswith("scalar")

    def spectrum(colours: list[Any], spread: Any, si: Any, active: Any) -> Any:
        if spread is not None and len(colours) == 1:  # of a model that was evaluated in RGB
            value = spread(colours[0], si, active)
            return types.mueller.depolarizer(value) if types.is_polarized else value
        channels = [c for colour in colours for c in types.Vector3f(colour)]
        value = types.UnpolarizedSpectrum(*channels[:count])
        return types.mueller.depolarizer(value) if types.is_polarized else types.Spectrum(value)

    class Plugin(types.BSDF):  # type: ignore[misc]
        """One model as a BSDF of one variant."""

        def __init__(self, properties: Any) -> None:
            super().__init__(properties)
            if scalar:
                say_slow()
            metal = metal_of(cls, properties)
            reject_unknown(cls.name, [*cls.fields, SAMPLING, *(METAL if metal else ())], properties)
            named = metal or transparent(cls, properties)
            self.sampling = sampling_of(cls.name, properties)
            self.spread: Any = spread() if spectral else None
            self.parts: dict[str, Any] = {}  # texture or inner BSDF of each field
            self.textures: dict[str, Any] = {}  # those of inner BSDFs as well, by path
            choices = {}
            for name, declared in cls.fields.items():
                if isinstance(declared, Parameter):
                    self.parts[name] = self.textures[name] = parameter_texture(
                        cls.name, declared, properties, named.get(name)
                    )
                elif isinstance(declared, Child):
                    inner = self.parts[name] = _inner(cls, declared, properties)
                    choices[name] = inner.model
                    self.textures |= {f"{name}.{path}": t for path, t in inner.textures.items()}
                elif name in properties:
                    choices[name] = properties[name]
            self.model = cls(**choices)
            coloured = [self.textures[p] for p, d, _ in self.model.parameters() if d.width == 3]
            self.in_rgb = spectral and all(holds_rgb(texture) for texture in coloured)
            self.m_flags = lobe | mi.BSDFFlags.FrontSide
            self.m_components = [self.m_flags]
            self.asked = means.asked(self.model)
            self.means: dict[str, Any] = {}
            self.parameters_changed([])

        def traverse(self, callback: Any) -> None:
            for name, part in self.parts.items():
                callback.put(name, part, mi.ParamFlags.Differentiable)

        def parameters_changed(self, keys: Any) -> None:
            constant = [path for path in self.asked if self._is_constant(path)]
            for path in set(self.asked) - set(constant):
                means.say_varies(self.model, path)
            self.means = {}
            if constant:
                bound = self._bound(dr.zeros(types.SurfaceInteraction3f), True)[0]
                self.means = means.find(self.model, bound, constant, types.Float)

        def _is_constant(self, path: str) -> bool:
            """Whether an inner model is the same everywhere, at all wavelengths, and not differentiated."""
            textures = [t for p, t in self.textures.items() if p.startswith(f"{path}.")]
            params = [value for t in textures for _, value in mi.traverse(t)]
            varies = any(t.is_spatially_varying() for t in textures) or (
                spectral and not self.in_rgb
            )
            return not varies and not any(dr.grad_enabled(value) for value in params)

        def to_string(self) -> str:
            shown = {name: getattr(self.model, name) for name in cls.fields} | self.parts
            lines = (f"{name} = {value}".replace("\n", "\n  ") for name, value in shown.items())
            return f"{PREFIX}{cls.name}[\n  " + ",\n  ".join(lines) + "\n]"

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            models, wo = self._bound(si, active), plain(si.wi)
            # Where to look is not differentiated, only what is seen there. A picture's expectation
            # does not depend on the sampling; but samplers choose between lobes, and a derivative
            # that follows the samples misses those that change over from one lobe to the other.
            with dr.suspend_grad():
                wi, pdf = self._sampled(models[0], wo, vec2(sample2.x, sample2.y))
            active = active & (pdf > 0) & ctx.is_enabled(lobe)
            factor = wi.z / dr.select(active, pdf, 1)
            weight = spectrum(
                [model.eval(wi, wo) * factor for model in models], self.spread, si, active
            )
            bs = dr.zeros(types.BSDFSample3f)
            bs.wo = types.Vector3f(wi.x, wi.y, wi.z)
            bs.pdf = dr.select(active, pdf, 0)
            bs.eta = 1.0
            bs.sampled_type = types.UInt32(+lobe)
            bs.sampled_component = types.UInt32(0)
            return bs, dr.select(active, weight, 0)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            active = active & ctx.is_enabled(lobe)
            models, wi, wo = self._bound(si, active), plain(wo), plain(si.wi)
            # 0 where wi.z is negative
            value = spectrum(
                [model.eval(wi, wo) * wi.z for model in models], self.spread, si, active
            )
            with dr.suspend_grad():  # as in sample, so that weights of MIS still add up to 1
                pdf = self._density(models[0], wi, wo)
            return dr.select(active, value, 0), dr.select(active, pdf, 0)

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            albedos = [model.albedo(plain(si.wi)) for model in self._bound(si, active)]
            return dr.select(active, spectrum(albedos, self.spread, si, active), 0)

        def _sampled(self, model: Model, wo: Any, u: Any) -> Sample:
            """A direction towards the light and its density, by the sampler that was chosen."""
            if self.sampling == "own":
                return model.sample(wo, u)
            wi = sample_cosine(u) if self.sampling == "cosine" else sample_uniform(u)
            return Sample(wi, self._density(model, wi, wo))

        def _density(self, model: Model, wi: Any, wo: Any) -> Any:
            if self.sampling == "own":
                return model.pdf(wi, wo)
            pdf = pdf_cosine(wi) if self.sampling == "cosine" else pdf_uniform() + 0 * wi.z
            return dr.select((wi.z > MU_MIN) & (wo.z > MU_MIN), pdf, 0)

        def _bound(self, si: Any, active: Any, by_wavelength: bool = False) -> list[Model]:
            """The model with what the textures hold at si, once for every three channels.

            Where all its colours are RGB it is bound once, to those; `by_wavelength` spreads them first.
            """
            in_rgb = self.in_rgb and not by_wavelength
            values = {}
            for path, declared, _ in self.model.parameters():
                texture = self.textures[path]
                if declared.width == 1:
                    value = texture.eval_1(si, active)
                elif in_rgb:
                    value = texture.eval_3(si, active)
                elif spectral and holds_rgb(texture):
                    value = self.spread(texture.eval_3(si, active), si, active)
                else:
                    value = texture.eval(si, active)
                # Not dr.clip, whose derivative is 0 at the lower end: optimisers would stay there.
                value = dr.select(value < declared.low, declared.low, value)
                values[path] = dr.select(value > declared.high, declared.high, value)

            def bind(triple: list[int]) -> Model:
                def convert(path: str, declared: Parameter, _: Any) -> Any:
                    value = values[path]
                    return vec3(*(value[c] for c in triple)) if declared.width == 3 else value

                bound = self.model.bind(type(si.t), convert)
                means.give(bound, {} if by_wavelength else self.means)
                return bound

            return [bind(triple) for triple in ([[0, 1, 2]] if in_rgb else triples)]

    return Plugin


def _inner(cls: type[Model], declared: Child, properties: Any) -> Any:
    """The BSDF of an inner model: the one given, or one made from a model's name or the default."""
    value = properties.get(declared.name, declared.default)
    if isinstance(value, str):
        return mi.load_dict({"type": PREFIX + value})
    if not isinstance(getattr(value, "model", None), Model):
        raise ModelError(
            f"{PREFIX}{cls.name}: {declared.name} is {value}; "
            f"allowed are a BSDF of type {PREFIX}... and a model's name."
        )
    return value
