"""Stacks of layers, and their BRDF on arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, NamedTuple

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.albedos.quadrature import HORIZON
from gonio.arrays.kernel import opaque
from gonio.arrays.leaf import UNIT_TOLERANCE
from gonio.fields import ModelError, framework, is_array
from gonio.model import Model, model
from gonio.parts.distribution import ALPHA_MIN, blinn_phong_alpha
from gonio.reference.generator import WORD, generator, scramble
from gonio.reference.interfaces import Pile, Rough, channels
from gonio.reference.walk import Channels, Quantity, Scene, State, direct, walk

# Lanes that keep all cores of a machine busy, or a GPU; few pairs of directions are repeated up to that.
LANES = 1 << 16

# Walks of one launch, between which long work shows progress and can be interrupted.
WALKS_PER_LAUNCH = 1 << 25

# Rough surfaces need an index of their own: refracted directions tell facets apart only by bending, and
# below this difference a float32 cannot. Such surfaces count as smooth, and so they do not mask either.
BEND_MIN = 1e-3

Progress = Any
"""A function that is called with (walks done, walks in all) after every launch."""


class Estimate(NamedTuple):
    """A mean over random walks."""

    value: NDArray[Any]
    error: NDArray[Any]
    """Standard error of `value`."""


class Walked(NamedTuple):
    """A direction that a walk has left in."""

    wi: NDArray[Any]
    """Unit, shape (..., 3)."""
    weight: NDArray[Any]
    """f cos(theta_i) / density, shape (..., 3); 0 where the walk has ended inside."""
    specular: NDArray[np.bool_]
    """Mirrored by smooth surfaces only: an infinite density, which `pdf` does not count."""


class Slab(NamedTuple):
    """A layer whose numbers are values of a kernel."""

    eta: Any
    alpha: Any
    """None for a smooth surface."""
    depth: Any
    ggx: bool


def assemble(slabs: Sequence[Slab], base: Model | Channels) -> Scene:
    """The surfaces of slabs, from the top down; smooth ones that lie on one another become a pile."""
    surfaces: list[Rough | Pile] = []
    etas: list[Any] = []
    n2: list[Any] = []
    depths: list[Any] = []
    index: Any = 1
    for slab in slabs:
        index = index * slab.eta
        above = surfaces[-1] if surfaces else None
        if slab.alpha is None and isinstance(above, Pile):
            surfaces[-1] = Pile([*above.etas, slab.eta], [*above.depths, depths[-1]])
            etas[-1], n2[-1], depths[-1] = etas[-1] * slab.eta, index * index, slab.depth
            continue
        surfaces.append(Pile([slab.eta], []) if slab.alpha is None else Rough(slab.alpha, slab.ggx))
        etas.append(slab.eta)
        n2.append(index * index)
        depths.append(slab.depth)
    return Scene(surfaces, etas, n2, depths, base)


@dataclass(frozen=True)
class Layer:
    """A slab of clear medium, and the surface on its top.

    Raises:
        ModelError: a number out of its range.
    """

    eta: float = 1.5
    """Index of the slab over that of the medium above it, 1/3 to 3."""
    alpha: float = 0.0
    """Width of the slopes of the surface's facets, 1e-4 to 1; 0 is smooth."""
    sigma_a: float | tuple[float, float, float] = 0.0
    """Absorption per unit of thickness, a number or linear RGB."""
    thickness: float = 1.0
    distribution: str = "ggx"
    """Of the facets: "ggx" or "beckmann"."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, low, high in (("eta", 1 / 3, 3), ("alpha", 0, 1), ("thickness", 0, math.inf)):
            _check(name, getattr(self, name), low, high)
        several = isinstance(self.sigma_a, (tuple, list))
        sigma = tuple(self.sigma_a) if isinstance(self.sigma_a, (tuple, list)) else (self.sigma_a,)
        if several and len(sigma) != 3:
            raise ModelError(f"layer: sigma_a takes one or three numbers, got {self.sigma_a!r}.")
        for value in sigma:
            _check("sigma_a", value, 0, math.inf)
        if several:
            object.__setattr__(self, "sigma_a", sigma)
        if 0 < self.alpha < ALPHA_MIN:
            raise ModelError(
                f"layer: alpha={self.alpha!r} is out of range; allowed is {ALPHA_MIN:g} to 1, or 0 for "
                "smooth."
            )
        if self.distribution not in ("ggx", "beckmann"):
            raise ModelError(
                f"layer: distribution={self.distribution!r} is not known; allowed are ggx, beckmann."
            )

    @property
    def depth(self) -> tuple[float, float, float]:
        """Optical depth along the normal."""
        sigma = self.sigma_a if isinstance(self.sigma_a, tuple) else (self.sigma_a,) * 3
        r, g, b = (s * self.thickness for s in sigma)
        return r, g, b

    @property
    def smooth(self) -> bool:
        """Whether the surface has no facets, or none that bend light."""
        return self.alpha == 0 or abs(self.eta - 1) < BEND_MIN


def _check(name: str, value: Any, low: float, high: float) -> None:
    allowed = f"{low:.4g} to {high:g}" if math.isfinite(high) else f"at least {low:g}"
    if type(value) is bool or not isinstance(value, Real):
        raise ModelError(f"layer: {name}={value!r} is not a number; allowed is {allowed}.")
    if not low <= float(value) <= high or math.isinf(float(value)):
        raise ModelError(f"layer: {name}={value!r} is out of range; allowed is {allowed}.")


@dataclass(frozen=True)
class Stack:
    """Layers over a base, from the top down: their BRDF by random walks, without approximation.

        stack = Stack([Layer(eta=1.5, alpha=0.1, sigma_a=(0, 0.2, 0.5))], base=gonio.Lambert(rho=0.8))
        f = stack.eval(wi, wo, walks=4096)
        f.value, f.error                          # (..., 3) each

    Directions are as everywhere in gonio: NumPy arrays or numbers, unit vectors, (..., 3), broadcast.
    The base is any model; its indices are relative to the lowest layer. What a smooth top mirrors is no
    function: it is in `sample` and `albedo`, but not in `eval` and `pdf`.
    """

    layers: tuple[Layer, ...]
    base: Model = field(default_factory=lambda: model("lambert"))

    def __init__(self, layers: Sequence[Layer], base: Model | str = "lambert") -> None:
        """Take the layers from the top down, and the model below them or its name."""
        if not isinstance(layers, Sequence):
            raise ModelError(f"a stack takes a list of layers, got {layers!r}.")
        object.__setattr__(self, "layers", tuple(layers))
        object.__setattr__(self, "base", model(base) if isinstance(base, str) else base)
        object.__setattr__(self, "_scenes", {})
        if not self.layers:
            raise ModelError("a stack needs at least one layer; the base alone is a model.")
        for layer in self.layers:
            if not isinstance(layer, Layer):
                raise ModelError(f"a stack takes layers, got {layer!r}.")
        if not isinstance(self.base, Model):
            raise ModelError(f"a stack's base is a model or a model's name, got {self.base!r}.")
        for path, _, value in self.base.parameters():
            if is_array(value):
                raise ModelError(f"a stack's base takes numbers; {path} is an array.")

    @classmethod
    def of(cls, approximation: Model) -> Stack:
        """The physical layers that a layered model stands for.

        weidlich_wilkie: its coats, each with the facets' distribution and width, and the innermost base
        as it is, without the roughness clamp. car_paint: its coat over one flake. triace_layered: facets
        of Beckmann's distribution as wide as its Blinn-Phong highlights; below, a second rough surface
        with the index n2 / n1 on the diffuse base.

        Raises:
            ModelError: another model, or parameters that are arrays.
        """
        for path, _, value in approximation.parameters():
            if is_array(value):
                raise ModelError(
                    f"{approximation.name}: {path} is an array; a stack takes numbers."
                )
        made = _LAYERED.get(approximation.name)
        if made is None:
            raise ModelError(
                f"{approximation.name} stands for no layers; models that do are {', '.join(_LAYERED)}."
            )
        layers, base = made(approximation)
        return cls(layers, base)

    def eval(
        self,
        wi: Any,
        wo: Any,
        *,
        walks: int = 1024,
        seed: int = 0,
        progress: Progress = None,
    ) -> Estimate:
        """BRDF in 1/sr, without the cosine: mean and standard error, shape (..., 3) each.

        Args:
            wi: towards the light.
            wo: towards the viewer.
            walks: random walks for each pair; the error falls with their root.
            seed: of the random numbers.
            progress: called with (done, total) now and then.

        Raises:
            ValueError: shapes that do not fit, vectors that are not of unit length, or walks < 1.
        """
        return self._estimate("value", wi, wo, walks, seed, progress)

    def pdf(
        self,
        wi: Any,
        wo: Any,
        *,
        walks: int = 1024,
        seed: int = 0,
        progress: Progress = None,
    ) -> Estimate:
        """Density in 1/sr with which `sample` leaves at wi: mean and standard error, shape (...).

        An unbiased estimate, with arguments as `eval`. It integrates to less than 1 by the shares of the
        samples that are specular and of those that end inside.
        """
        value, error = self._estimate("density", wi, wo, walks, seed, progress)
        return Estimate(value[..., 0], error[..., 0])

    def albedo(
        self, wo: Any, *, walks: int = 1024, seed: int = 0, progress: Progress = None
    ) -> Estimate:
        """Directional albedo, specular reflection included: mean and standard error, shape (..., 3).

        In the horizon it is the limit.
        """
        return self._estimate("sample", None, _lifted(wo), walks, seed, progress)

    def mirrored(self, wo: Any) -> NDArray[Any]:
        """The part of `albedo` that a smooth top mirrors, shape (..., 3); 0 for a rough one."""
        (wo,), batch, dtype = _directions(("wo",), (_lifted(wo),))
        found = np.zeros((len(wo), 3))
        for n, w in enumerate(wo if self.layers[0].smooth else ()):
            top = self.scene(float).surfaces[0]
            assert isinstance(top, Pile)
            found[n] = list(channels(top.bend(float(w[2]), True).reflected)) if w[2] > 0 else 0
        return found.astype(dtype).reshape(*batch, 3)

    def sample(self, wo: Any, *, seed: int = 0) -> Walked:
        """One walk from each direction: where it leaves, and its weight."""
        (wo,), batch, dtype = _directions(("wo",), (wo,))
        pairs = len(wo)
        if not pairs:
            none = np.zeros((*batch, 3), dtype)
            return Walked(none, none, np.zeros(batch, bool))
        if backend.current() == "scalar":
            runs = [self._scalar("sample", None, w, 1, (seed, 0, n)) for n, w in enumerate(wo)]
            exits = np.array([[*s.exit] for s in runs]).reshape(pairs, 3)
            weights = np.array([[*s.total] for s in runs]).reshape(pairs, 3)
            specular = np.array([s.specular for s in runs], bool)
        else:
            Float = self._float(dtype)
            w = _upload(Float, wo)
            lane = dr.arange(dr.uint32_array_t(Float), pairs)
            rng = generator(lane, _seed(Float, seed, 0))
            state = walk(self.scene(Float), w, None, rng, 1, "sample", Float)
            dr.eval(state.exit, state.total, state.specular)
            exits, weights = np.array(state.exit).T, np.array(state.total).T
            specular = np.array(state.specular)
        good = (weights.max(-1, initial=0) > 0) & (wo[:, 2] > 0)
        exits = np.where(good[:, None], exits, (0, 0, 1))
        return Walked(
            exits.astype(dtype).reshape(*batch, 3),
            np.where(good[:, None], weights, 0).astype(dtype).reshape(*batch, 3),
            (specular & good).reshape(batch),
        )

    def scene(self, Float: Any) -> Scene:
        """The stack as values of a kernel with this number type."""
        if Float not in self._scenes:
            self._scenes[Float] = self._bound(Float)
        return self._scenes[Float]

    _scenes: dict[Any, Scene] = field(init=False, repr=False, compare=False)

    def _bound(self, Float: Any) -> Scene:
        slabs = [
            Slab(
                opaque(Float, 1, layer.eta),
                None if layer.smooth else opaque(Float, 1, layer.alpha),
                opaque(Float, 3, layer.depth),
                layer.distribution == "ggx",
            )
            for layer in self.layers
        ]
        base = self.base.bind(Float, lambda path, p, value: opaque(Float, p.width, value))
        return assemble(slabs, base)

    @staticmethod
    def _float(dtype: Any) -> Any:
        module = backend.array_module()
        return dr.detached_t(module.Float if dtype == np.float32 else module.Float64)

    def _estimate(
        self, quantity: Quantity, wi: Any, wo: Any, walks: int, seed: int, progress: Progress
    ) -> Estimate:
        if not isinstance(walks, (int, np.integer)) or walks < 1:
            raise ValueError(f"walks={walks!r} is out of range; allowed is at least 1.")
        named = {"wi": wi, "wo": wo} if wi is not None else {"wo": wo}
        found, batch, dtype = _directions(tuple(named), tuple(named.values()))
        o, i = found[-1], found[0] if wi is not None else None
        above = o[:, 2] > 0 if i is None else (o[:, 2] > 0) & (i[:, 2] > 0)
        pairs = len(o)
        sums = np.zeros((2, pairs, 3))
        once = np.zeros((pairs, 3))
        each = max(1, min(int(walks), WALKS_PER_LAUNCH // max(pairs, 1)))
        done, launch = 0, 0
        while done < walks and pairs:
            count = min(each, int(walks) - done)
            part, once = self._launch(quantity, i, o, count, (seed, launch), dtype)
            sums += part
            done, launch = done + count, launch + 1
            if progress is not None:
                progress(done, int(walks))
        mean = sums[0] / walks
        variance = np.maximum(sums[1] / walks - mean**2, 0)
        error = np.sqrt(variance / max(int(walks) - 1, 1))
        value = np.where(above[:, None], mean + once, 0)
        error = np.where(above[:, None], error, 0)
        return Estimate(
            value.astype(dtype).reshape(*batch, 3), error.astype(dtype).reshape(*batch, 3)
        )

    def _launch(
        self, quantity: Quantity, wi: Any, wo: Any, walks: int, seed: tuple[int, int], dtype: Any
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Sums and sums of squares, shape (2, pairs, 3), and what comes on top without a walk."""
        pairs = len(wo)
        if backend.current() == "scalar":
            return self._launch_scalar(quantity, wi, wo, walks, seed)
        Float = self._float(dtype)
        UInt = dr.uint32_array_t(Float)
        repeats = max(1, min(walks, LANES // pairs))
        lanes = pairs * repeats
        lane = dr.arange(UInt, lanes)
        pair = lane // dr.opaque(UInt, repeats)
        more = lane - pair * dr.opaque(UInt, repeats) < dr.opaque(UInt, walks % repeats)
        counts = dr.opaque(UInt, walks // repeats) + dr.select(more, UInt(1), UInt(0))
        scene, o, i = self.scene(Float), _upload(Float, wo), None
        once = np.zeros((pairs, 3))
        if wi is not None:
            i = _upload(Float, wi)
            top = direct(scene, i, o)[0 if quantity == "value" else 1]
            once += np.broadcast_to(np.array(top, np.float64), pairs)[:, None]
            i = dr.gather(type(i), dr.ravel(i), pair)
        o = dr.gather(type(o), dr.ravel(o), pair)
        rng = generator(lane, _seed(Float, *seed))
        state = walk(scene, o, i, rng, counts, quantity, Float)
        dr.eval(state.total, state.squares)
        parts = (np.array(x, np.float64).T for x in (state.total, state.squares))
        return np.stack([part.reshape(pairs, repeats, 3).sum(1) for part in parts]), once

    def _launch_scalar(
        self, quantity: Quantity, wi: Any, wo: Any, walks: int, seed: tuple[int, int]
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """The same in plain Python, one walk after the other."""
        pairs = len(wo)
        sums, once = np.zeros((2, pairs, 3)), np.zeros((pairs, 3))
        for n in range(pairs):
            i = None if wi is None else wi[n]
            state = self._scalar(quantity, i, wo[n], walks, (*seed, n))
            sums[:, n] = [*state.total], [*state.squares]
            if i is not None:
                both = direct(self.scene(float), _above(i), _above(wo[n]))
                once[n] = both[0 if quantity == "value" else 1]
        return sums, once

    def _scalar(
        self, quantity: Quantity, wi: Any, wo: Any, walks: int, seed: tuple[int, int, int]
    ) -> State:
        rng = generator(seed[2], scramble(seed[0], seed[1])[0])
        i = None if wi is None else _above(wi)
        return walk(self.scene(float), _above(wo), i, rng, walks, quantity, float)


def _seed(Float: Any, seed: int, launch: int) -> Any:
    """One number made of two, that is not compiled into the kernel."""
    return dr.opaque(dr.uint32_array_t(Float), scramble(seed & WORD, launch)[0])


def _above(w: NDArray[Any]) -> Any:
    """A direction in plain Python; one below the horizon, whose value is masked, becomes the normal."""
    return dr.scalar.Array3f64(w.tolist() if w[2] > 0 else (0, 0, 1))


def _upload(Float: Any, w: NDArray[Any]) -> Any:
    """Directions as Dr.Jit values; those below the horizon, whose values are masked, become the normal."""
    safe = np.where(w[:, 2:] > 0, w, np.array((0, 0, 1), w.dtype))
    return dr.replace_shape_t(Float, (3, -1))(*(Float(np.ascontiguousarray(c)) for c in safe.T))


def _lifted(wo: Any) -> Any:
    """Directions of which those in the horizon are raised a little; what is no array of numbers stays."""
    if framework(wo) not in (None, "numpy"):
        return wo
    try:
        array = np.array(wo, getattr(wo, "dtype", np.float32))
        array = array if array.dtype.kind == "f" else array.astype(np.float32)
    except (TypeError, ValueError):
        return wo
    if array.shape[-1:] == (3,):
        z = array[..., 2]
        z[(z >= 0) & (z < HORIZON)] = HORIZON
    return array


def _directions(
    names: Sequence[str], given: Sequence[Any]
) -> tuple[list[NDArray[Any]], tuple[int, ...], Any]:
    """Flat arrays (n, 3) of unit vectors, their common shape, and the precision to compute in."""
    found = []
    for name, value in zip(names, given, strict=True):
        if (kind := framework(value)) not in (None, "numpy"):
            raise ValueError(
                f"{name} is an array of {kind}; the reference takes NumPy arrays and numbers."
            )
        try:
            array = (
                np.asarray(value)
                if isinstance(value, np.ndarray)
                else np.asarray(value, np.float32)
            )
        except (TypeError, ValueError):
            raise ValueError(f"{name} must be numbers with 3 components last.") from None
        if array.shape[-1:] != (3,):
            raise ValueError(
                f"{name} has shape {array.shape}; its last axis must hold 3 components."
            )
        bad = ~(np.abs(np.sum(np.square(array, dtype=np.float64), -1) - 1) <= UNIT_TOLERANCE)
        if bad.any():
            raise ValueError(
                f"{name} has a vector {array[bad][0].tolist()} that is not of unit length; divide by "
                f"np.linalg.norm({name}, axis=-1, keepdims=True)."
            )
        found.append(array)
    dtype = np.float64 if any(a.dtype == np.float64 for a in found) else np.float32
    try:
        spread = np.broadcast_arrays(*found)
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in zip(names, found, strict=True))
        raise ValueError(f"shapes do not broadcast: {shapes}.") from None
    return [a.reshape(-1, 3).astype(dtype) for a in spread], spread[0].shape[:-1], dtype


# --- what the approximations stand for ------------------------------------------------------------


def _coats(coat: Model) -> tuple[list[Layer], Model]:
    """weidlich_wilkie, nested as deep as it is."""
    layers = []
    below: Any = coat
    while below.name == "weidlich_wilkie":
        if below.fresnel not in ("exact", "lazanyi"):
            raise ModelError(
                f"{below.name}: fresnel={below.fresnel!r} reflects each channel by an index of its own; "
                "a stack's surfaces have one, so take fresnel='exact'."
            )
        alpha = 0.0 if below.interface == "smooth" else below.alpha
        layers.append(Layer(below.eta, alpha, below.sigma_a, below.thickness, below.distribution))
        below = below.base
    return layers, below


def _paint(paint: Any) -> tuple[list[Layer], Model]:
    """car_paint: the flake by itself is the same model under a coat that bends and reflects nothing."""
    layer = Layer(paint.eta, paint.alpha, paint.sigma_a, paint.thickness, "ggx")
    flake = paint.replace(
        eta=1.0,
        alpha=paint.metal_alpha,
        sigma_a=0.0,
        metal_eta=_divided(paint.metal_eta, paint.eta),
        metal_k=_divided(paint.metal_k, paint.eta),
    )
    return [layer], flake


def _divided(colour: Any, divisor: float) -> Any:
    return tuple(c / divisor for c in colour) if isinstance(colour, tuple) else colour / divisor


def _glossy_over_matte(paint: Any) -> tuple[list[Layer], Model]:
    """triace_layered."""
    top, bottom = blinn_phong_alpha(paint.top_shininess), blinn_phong_alpha(paint.bottom_shininess)
    layers = [
        Layer(paint.top_eta, top, paint.sigma_a, paint.thickness, "beckmann"),
        Layer(paint.bottom_eta / paint.top_eta, bottom, 0.0, 0.0, "beckmann"),
    ]
    if paint.diffuse == "lambert":
        return layers, model("lambert", rho=paint.rho)
    return layers, model("triace_oren_nayar", rho=paint.rho, shininess=paint.bottom_shininess)


_LAYERED = {
    "weidlich_wilkie": _coats,
    "triace_layered": _glossy_over_matte,
    "car_paint": _paint,
}
