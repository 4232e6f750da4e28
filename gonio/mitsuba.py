"""Every model as a Mitsuba 3 BSDF: importing this module registers `gonio_<name>`.

    import gonio.mitsuba          # before `import mitsuba`, so that a usable LLVM is found
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    bsdf = mi.load_dict({"type": "gonio_eon", "roughness": 1.0})

Each parameter takes a number, an RGB colour, a spectrum or a texture, under the name it has in gonio;
options take their names. `mi.traverse` shows the parameters, and they are differentiable. The models
are one-sided, like Mitsuba's own `diffuse`: wrap them into `twosided` where backs are seen. What
textures hold is limited to the allowed range; a number outside it is an error.

This is the only file that swaps the directions (Mitsuba's `si.wi` is the viewer's, gonio's `wo`) and
that multiplies by the cosine, beside `gonio.reference.plugin`, whose `gonio_layered_reference` is
registered with the models.
"""

from __future__ import annotations

import difflib
import os
import warnings
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from gonio import backend, viewer_distance
from gonio.arrays import is_array
from gonio.lang import vec2, vec3
from gonio.model import Child, Model, ModelError, Parameter, models

PREFIX = "gonio_"

_registered: dict[tuple[str, str], type[Model]] = {}


def plugin(model: Model) -> dict[str, Any]:
    """A model with its parameters as a dict for `mitsuba.load_dict`.

    Raises:
        ModelError: a parameter is an array; pictures take numbers, colours and Mitsuba's textures.
    """
    if _registered.get((mi.variant(), model.name)) is not type(model):
        register(type(model))  # from a user's file, which gonio's registry does not hold
    node: dict[str, Any] = {"type": PREFIX + model.name}
    for name in model.fields:
        value = getattr(model, name)
        if is_array(value):
            raise ModelError(
                f"{model.name}: {name} is an array; a picture takes numbers, colours or textures."
            )
        if isinstance(value, tuple):
            value = {"type": "rgb", "value": list(value)}
        node[name] = plugin(value) if isinstance(value, Model) else value
    return node


def register(*private: type[Model]) -> None:
    """Register every model for Mitsuba's current variant; what is known to it is left alone.

    Runs by itself on import and on every `mi.set_variant`. Call it after defining a model of your own.

    Args:
        private: models that are not in gonio's registry, defined with `register=False`.

    Raises:
        BackendError: Dr.Jit has loaded an LLVM that would end the process; the message says what helps.
    """
    variant = mi.variant()
    if variant is None:
        return
    if variant.startswith("llvm") and (problem := _llvm_problem()):
        raise backend.BackendError(problem)
    for cls in (*models().values(), *private):
        if _registered.get((variant, cls.name)) is not cls:
            mi.register_bsdf(PREFIX + cls.name, _derive(cls))
            _registered[variant, cls.name] = cls
    viewer_distance.register()
    from gonio.reference import plugin as reference  # which needs this module

    reference.register()


def _llvm_problem() -> str | None:
    """What is wrong with the LLVM that Dr.Jit has loaded; it chooses alone if imported before gonio."""
    version = dr.detail.llvm_version()[0]
    if version >= backend.LLVM_MINIMUM:
        return None
    path = next(backend.usable_llvm(), None)
    remedy = (
        "import gonio.mitsuba before mitsuba and drjit, or set "
        f"DRJIT_LIBLLVM_PATH={path} before starting Python."
    )
    return (
        f"Dr.Jit has loaded {f'LLVM {version}' if version > 0 else 'no LLVM'}, and Mitsuba's llvm "
        f"variants need {backend.LLVM_MINIMUM} or newer: {remedy if path else backend.install_hint()}"
    )


def _derive(cls: type[Model]) -> Any:
    # The types of the current variant. Objects keep theirs when another variant is chosen later.
    types: Any = getattr(mi, mi.variant())
    lobe = mi.BSDFFlags.GlossyReflection

    # Models know colours of three channels. One is given three times, and of four the first three and
    # three times the last; what is computed twice that way, Dr.Jit compiles once.
    count = dr.size_v(types.UnpolarizedSpectrum)
    triples = [[min(first + c, count - 1) for c in range(3)] for first in range(0, count, 3)]

    def spectrum(colours: list[Any]) -> Any:
        channels = [c for colour in colours for c in types.Vector3f(colour)]
        value = types.UnpolarizedSpectrum(*channels[:count])
        return types.mueller.depolarizer(value) if types.is_polarized else types.Spectrum(value)

    class Plugin(types.BSDF):  # type: ignore[misc]
        """One model as a BSDF of one variant."""

        def __init__(self, properties: Any) -> None:
            super().__init__(properties)
            _reject_unknown(cls, properties)
            self.parts: dict[str, Any] = {}  # texture or inner BSDF of each field
            self.textures: dict[str, Any] = {}  # those of inner BSDFs as well, by path
            choices = {}
            for name, declared in cls.fields.items():
                if isinstance(declared, Parameter):
                    self.parts[name] = self.textures[name] = _texture(cls, declared, properties)
                elif isinstance(declared, Child):
                    inner = self.parts[name] = _inner(cls, declared, properties)
                    choices[name] = inner.model
                    self.textures |= {f"{name}.{path}": t for path, t in inner.textures.items()}
                elif name in properties:
                    choices[name] = properties[name]
            self.model = cls(**choices)
            self.m_flags = lobe | mi.BSDFFlags.FrontSide
            self.m_components = [self.m_flags]

        def traverse(self, callback: Any) -> None:
            for name, part in self.parts.items():
                callback.put(name, part, mi.ParamFlags.Differentiable)

        def to_string(self) -> str:
            shown = {name: getattr(self.model, name) for name in cls.fields} | self.parts
            lines = (f"{name} = {value}".replace("\n", "\n  ") for name, value in shown.items())
            return f"{PREFIX}{cls.name}[\n  " + ",\n  ".join(lines) + "\n]"

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            models, wo = self._bound(si, active), _plain(si.wi)
            # Where to look is not differentiated, only what is seen there. A picture's expectation
            # does not depend on the sampling; but samplers choose between lobes, and a derivative
            # that follows the samples misses those that change over from one lobe to the other.
            with dr.suspend_grad():
                wi, pdf = models[0].sample(wo, vec2(sample2.x, sample2.y))
            active = active & (pdf > 0) & ctx.is_enabled(lobe)
            factor = wi.z / dr.select(active, pdf, 1)
            weight = spectrum([model.eval(wi, wo) * factor for model in models])
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
            models, wi, wo = self._bound(si, active), _plain(wo), _plain(si.wi)
            # 0 where wi.z is negative
            value = spectrum([model.eval(wi, wo) * wi.z for model in models])
            with dr.suspend_grad():  # as in sample, so that weights of MIS still add up to 1
                pdf = models[0].pdf(wi, wo)
            return dr.select(active, value, 0), dr.select(active, pdf, 0)

        def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
            albedos = [model.albedo(_plain(si.wi)) for model in self._bound(si, active)]
            return dr.select(active, spectrum(albedos), 0)

        def _bound(self, si: Any, active: Any) -> list[Model]:
            """The model with what the textures hold at si, once for every three channels."""
            values = {}
            for path, declared, _ in self.model.parameters():
                texture = self.textures[path]
                value = (texture.eval if declared.width == 3 else texture.eval_1)(si, active)
                # Not dr.clip, whose derivative is 0 at the lower end: optimisers would stay there.
                value = dr.select(value < declared.low, declared.low, value)
                values[path] = dr.select(value > declared.high, declared.high, value)

            def bind(triple: list[int]) -> Model:
                def convert(path: str, declared: Parameter, _: Any) -> Any:
                    value = values[path]
                    return vec3(*(value[c] for c in triple)) if declared.width == 3 else value

                return self.model.bind(type(si.t), convert)

            return [bind(triple) for triple in triples]

    return Plugin


def _plain(w: Any) -> Any:
    return vec3(w.x, w.y, w.z)


def _reject_unknown(cls: type[Model], properties: Any) -> None:
    for name in properties.keys():  # noqa: SIM118 (not a dictionary)
        if name not in cls.fields:
            near = difflib.get_close_matches(name, cls.fields, n=1)
            did = f"did you mean {near[0]!r}? " if near else ""
            raise ModelError(
                f"{PREFIX}{cls.name} has no property {name!r}; {did}Known are {', '.join(cls.fields)}."
            )


def _texture(cls: type[Model], declared: Parameter, properties: Any) -> Any:
    """The texture of a parameter: the one given, or a constant one made from numbers or the default."""
    name = declared.name
    value = properties.get(name, declared.default)
    if isinstance(value, mi.Texture):
        return value
    if name in properties and properties.type(name) == mi.Properties.Type.Spectrum:
        for v in value.values:
            declared.check(cls.name, float(v))
        if declared.width == 3:
            return properties.get_unbounded_texture(name)
        if value.is_uniform():
            value = float(value.values[0])
    elif dr.is_array_v(value) and len(value) == 3:  # <rgb>
        value = tuple(float(v) for v in value)
    if isinstance(value, bool) or not isinstance(value, (int, float, tuple)):
        allowed = "a number, an RGB colour, a spectrum" if declared.width == 3 else "a number"
        raise ModelError(
            f"{PREFIX}{cls.name}: {name} is a {type(value).__name__}; "
            f"allowed are {allowed} and a texture."
        )
    if isinstance(value, tuple) and declared.width == 1:
        value = sum(value) / 3  # the mean stands for a colour where one number is needed
    value = declared.check(cls.name, value)
    if isinstance(value, tuple) and mi.is_spectral and max(value) > 1:
        return _upsampled(value)
    constant = mi.Properties()
    constant["value"] = mi.ScalarColor3d(value) if isinstance(value, tuple) else value
    return constant.get_unbounded_texture("value")  # the range has been checked


def _upsampled(colour: tuple[float, ...]) -> Any:
    """A spectrum for a colour above 1, such as a metal's index, at which Mitsuba's own spectra end."""
    scale = max(colour)
    coefficients = np.ravel(mi.srgb_model_fetch(mi.ScalarColor3f([c / scale for c in colour])))
    x = np.polyval(coefficients, np.arange(mi.MI_CIE_MIN, mi.MI_CIE_MAX + 5, 5))
    # The sigmoid of Jakob, Hanika, "A low-dimensional function space for spectral upsampling", 2019
    values = scale * (0.5 + 0.5 * x / np.sqrt(1 + x * x))
    limits = {"wavelength_min": mi.MI_CIE_MIN, "wavelength_max": mi.MI_CIE_MAX}
    return mi.load_dict({"type": "regular", "values": ", ".join(map(str, values))} | limits)


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


register()
if "DRJIT_LIBLLVM_PATH" not in os.environ and (_problem := _llvm_problem()):
    # gonio came too late to choose; the error that Mitsuba may raise does not say what helps.
    warnings.warn(_problem, stacklevel=2)
mi.detail.add_variant_callback(lambda old, new: register())
