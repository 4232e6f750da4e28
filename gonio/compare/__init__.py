"""How wrong is an approximation, and where: models beside the truth, or beside each other.

    from gonio.compare import compare, drawing
    result = compare([gonio.model("weidlich_wilkie")], truth=True)
    result[0].errors.mean                       # 0.31: the mean error is 31 % of the mean value
    drawing.write("coats.png", result)          # error maps, a parameter's influence, pictures

The truth of a layered model is `gonio.reference.Stack.of(model)`: the layers that it stands for, with their
light followed by random walks. Without `truth`, the first model is what the others are compared with.
All numbers are luminances. What a smooth surface mirrors is left out on both sides, because it is no
function; pictures show it where the truth has it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.fields import ModelError, Parameter
from gonio.materials import Material
from gonio.model import Model
from gonio.reference import Stack
from gonio.render import Shown
from gonio.render.picture import describe

Array = NDArray[Any]
Progress = Callable[[int, int], None]
"""Called with (steps done, steps in all)."""

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB

# Directions of the maps, in degrees. Closer to the horizon relative errors say little: there is no light.
ANGLES_O = np.arange(0, 86, 5)
ANGLES_I = np.arange(-85, 86, 5)

# Walks of the truth for one pair of directions: an error of about 1 %.
WALKS = 4096

# Pairs of directions for means over the hemisphere, and for each value of a parameter.
PAIRS, PAIRS_VARIED = 2000, 500

# Where the truth's standard error is larger than this part of its value, it judges nobody.
JUDGED = 0.05

# The parameter whose influence is shown: the first one that a model has.
VARIED = ("alpha", "top_shininess", "roughness", "sigma", "eta")
STEPS = 7


@dataclass(frozen=True)
class Errors:
    """An approximation's errors, relative to the truth; 0.1 is 10 %."""

    mean: float
    """Mean of |f - truth| over mean of the truth, both weighted by both cosines."""
    worst: float
    """Largest |f - truth| / truth on the maps, with its sign."""
    worst_at: tuple[float, float, float]
    """theta_i, theta_o and phi between them, in degrees; 0 is the viewer's side, 180 the mirror's."""
    albedo: float
    """Mean albedo (luminance, without mirrors) of the approximation."""
    truth: float
    """Mean albedo of the truth."""
    noise: float
    """What `mean` would be by the truth's own noise alone."""

    @property
    def energy(self) -> float:
        """Energy gained (positive) or lost, as a part of the truth's."""
        return self.albedo / max(self.truth, 1e-12) - 1


@dataclass(frozen=True)
class Comparison:
    """One model beside its truth, or beside another model."""

    name: str
    against: str
    errors: Errors
    in_plane: Array
    """Relative errors, [theta_o, theta_i] at ANGLES_O and ANGLES_I; nan where the truth is too noisy."""
    across: Array
    """The same for phi = 90 degrees and theta_i at ANGLES_O."""
    varied: str
    """Name of the parameter whose influence was measured; "" for none."""
    values: tuple[float, ...]
    influence: tuple[Errors, ...]
    pictures: tuple[Any, Any] | None
    """Linear pictures of the model and of the truth."""

    def data(self) -> dict[str, Any]:
        """The numbers, without maps and pictures, for JSON."""
        errors = dataclasses.asdict(self.errors) | {"energy": self.errors.energy}
        influence = [
            {self.varied: v, "mean": e.mean, "energy": e.energy}
            for v, e in zip(self.values, self.influence, strict=True)
        ]
        return {"model": self.name, "against": self.against, **errors, "influence": influence}


@dataclass(frozen=True)
class _Truth:
    """What others are compared with: a stack or a model."""

    stack: Stack | None
    model: Model | None

    def eval(self, wi: Array, wo: Array, walks: int, seed: int) -> tuple[Array, Array]:
        """Luminances and their standard errors."""
        if self.stack is not None:
            found = self.stack.eval(wi, wo, walks=walks, seed=seed)
            # Channels share their walks; the largest error is a bound.
            return luminance(found.value), found.error.max(-1).astype(np.float64)
        assert self.model is not None
        value = luminance(self.model.eval(wi, wo))
        return value, np.zeros_like(value)


def _judge(truth: Model | Stack | _Truth) -> _Truth:
    if isinstance(truth, _Truth):
        return truth
    return _Truth(truth, None) if isinstance(truth, Stack) else _Truth(None, truth)


def compare(
    materials: Sequence[Model | Material],
    *,
    truth: bool = False,
    pictures: bool = True,
    size: int = 192,
    spp: int = 100,
    walks: int = WALKS,
    vary: str | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> list[Comparison]:
    """Compare each model with its truth, or all others with the first.

    Args:
        materials: models or materials whose parameters are numbers.
        truth: compare with the layers that each of them stands for.
        pictures: render both as well.
        size: of the pictures, in pixels.
        spp: samples per pixel of the pictures.
        walks: random walks of the truth for each pair of directions.
        vary: the parameter whose influence is measured; a roughness by default.
        seed: of all random numbers.
        progress: called after each step.

    Raises:
        ModelError: a model that stands for no layers, or has textures; fewer than two models without truth.
    """
    models = [_model(m) for m in materials]
    if not truth and len(models) < 2:
        raise ModelError(
            "give at least two models; the others are compared with the first. With --truth one is enough."
        )
    truths = [Stack.of(m) if truth else None for m in models]
    subjects = range(0 if truth else 1, len(models))
    per = 2 + STEPS + 2 * pictures
    found = []
    for number, k in enumerate(subjects):

        def step(done: int, number: int = number) -> None:
            if progress is not None:
                progress(number * per + done, len(subjects) * per)

        against = _Truth(truths[k], None if truth else models[0])
        shown = _Shown(materials[k], _shown_truth(materials, models[k], truths[k]), size, spp, seed)
        found.append(
            _compare(models[k], against, shown if pictures else None, walks, vary, seed, step)
        )
    return found


@dataclass(frozen=True)
class _Shown:
    """What to render for one comparison."""

    model: Model | Material
    truth: Shown
    size: int
    spp: int
    seed: int


def _shown_truth(materials: Sequence[Model | Material], model: Model, stack: Stack | None) -> Shown:
    return materials[0] if stack is None else stack


def _model(material: Model | Material) -> Model:
    return material.plain()[0] if isinstance(material, Material) else material


def _compare(
    model: Model,
    truth: _Truth,
    shown: _Shown | None,
    walks: int,
    vary: str | None,
    seed: int,
    step: Callable[[int], None],
) -> Comparison:
    measured = measure(model, truth, walks=walks, seed=seed)
    step(1)
    errors, in_plane, across = measured.judge(model)
    step(2)
    declared = _varied(model, vary)
    values: tuple[float, ...] = ()
    influence: list[Errors] = []
    if declared is not None:
        values = _steps(declared)
        for n, value in enumerate(values):
            changed = model.replace(**{declared.name: value})
            other = _judge(Stack.of(changed)) if truth.stack is not None else truth
            there = measure(changed, other, walks=walks, pairs=PAIRS_VARIED, maps=False, seed=seed)
            influence.append(there.judge(changed)[0])
            step(3 + n)
    pictures = None
    if shown is not None:
        common: dict[str, Any] = {"size": (shown.size,) * 2, "spp": shown.spp, "seed": shown.seed}
        from gonio.render import sheets  # which loads Mitsuba

        both = sheets.compare([{}], [shown.model, shown.truth], **common)
        pictures = (both[:, : shown.size], both[:, shown.size :])
        step(4 + STEPS)
    against = "truth" if truth.model is None else describe(truth.model)
    return Comparison(
        describe(model),
        against,
        errors,
        in_plane,
        across,
        declared.name if declared is not None else "",
        values,
        tuple(influence),
        pictures,
    )


@dataclass(frozen=True)
class Measured:
    """The truth at pairs of directions over the hemisphere and on both maps, to judge models by."""

    wi: Array
    wo: Array
    weight: Array
    """Cosine of the light over the density of wi; the viewer's directions are cosine-weighted."""
    value: Array
    error: Array
    maps: tuple[tuple[Array, Array, Array, Array], ...]
    """Light, viewer, value and error of each map; none where only means are wanted."""
    albedo: float

    def judge(self, model: Model) -> tuple[Errors, Array, Array]:
        """A model's errors, and the maps of its relative errors."""
        f = luminance(model.eval(self.wi, self.wo))
        scale = max(float(np.mean(self.value * self.weight)), 1e-12)
        maps = [_relative(luminance(model.eval(i, o)), v, e) for i, o, v, e in self.maps]
        errors = Errors(
            mean=float(np.mean(np.abs(f - self.value) * self.weight)) / scale,
            **(_worst(*maps) if maps else {"worst": math.nan, "worst_at": (0.0, 0.0, 0.0)}),
            albedo=self.albedo * float(np.mean(f * self.weight)) / scale,
            truth=self.albedo,
            noise=float(np.mean(self.error * self.weight)) * math.sqrt(2 / math.pi) / scale,
        )
        none = np.zeros((0, 0))
        return (errors, maps[0], maps[1]) if maps else (errors, none, none)


def measure(
    model: Model,
    truth: Model | Stack | _Truth,
    *,
    walks: int = WALKS,
    pairs: int = PAIRS,
    maps: bool = True,
    seed: int = 0,
) -> Measured:
    """Evaluate the truth where a model, or several that are alike, will be judged.

    Args:
        model: its sampler chooses half of the light's directions; the others are cosine-weighted.
        truth: a `gonio.reference.Stack`, or another model.
        walks: random walks of a stack for each pair.
        pairs: pairs of directions over the hemisphere.
        maps: evaluate the maps as well, by which the worst error is found.
        seed: of the random numbers.
    """
    judge = _judge(truth)
    rng = np.random.default_rng(seed)
    wo, other = (_cosine_weighted(rng.random((pairs, 2))) for _ in range(2))
    sampled, density = model.sample(wo, rng.random((pairs, 2)).astype(np.float32))
    chosen, wasted = rng.random(pairs) < 0.5, np.asarray(density) <= 0
    wi = np.where((chosen & ~wasted)[:, None], sampled, other)
    density = 0.5 * np.asarray(model.pdf(wi, wo), np.float64) + 0.5 * wi[:, 2] / math.pi
    weight = np.where(chosen & wasted, 0, wi[:, 2] / density)
    value, error = judge.eval(wi, wo, walks, seed)
    grids = [_grid(ANGLES_I, ANGLES_O, 0), _grid(ANGLES_O, ANGLES_O, 90)] if maps else []
    albedo = float(np.mean(value * weight))
    if judge.stack is not None:
        albedo = _true_albedo(judge.stack, wo, seed)
    return Measured(
        wi,
        wo,
        weight,
        value,
        error,
        tuple((i, o, *judge.eval(i, o, walks, seed)) for i, o in grids),
        albedo,
    )


# --- numbers ---------------------------------------------------------------------------------------


def _cosine_weighted(u: Array) -> NDArray[np.float32]:
    r, phi = np.sqrt(u[:, 0]), 2 * math.pi * u[:, 1]
    w = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u[:, 0])], -1)
    return w.astype(np.float32)


def _direction(theta: Array, phi: float) -> NDArray[np.float32]:
    t, p = np.radians(theta), math.radians(phi)
    w = np.stack([np.sin(t) * math.cos(p), np.sin(t) * math.sin(p), np.cos(t)], -1)
    return w.astype(np.float32)


def _grid(theta_i: Array, theta_o: Array, phi: float) -> tuple[Any, Any]:
    """Directions for a map [theta_o, theta_i]; theta_i is positive on the viewer's side."""
    i, o = np.meshgrid(theta_i, theta_o)
    return _direction(i, phi), _direction(o, 0)


def luminance(colour: Any) -> Array:
    """Luminance of linear sRGB, the component last."""
    return np.asarray(np.asarray(colour, np.float64) @ LUMINANCE)


def _relative(f: Array, value: Array, error: Array) -> Array:
    """Relative errors; nan where the truth is too noisy to judge."""
    good = error < JUDGED * value
    return np.where(good, (f - value) / np.where(good, value, 1), np.nan)


def _worst(in_plane: Array, across: Array) -> dict[str, Any]:
    """The largest error of both maps and its place."""
    best: tuple[float, tuple[float, float, float]] = (0.0, (0.0, 0.0, 0.0))
    for errors, columns, turned in ((in_plane, ANGLES_I, False), (across, ANGLES_O, True)):
        known = np.nan_to_num(np.abs(errors), nan=-1.0)
        row, column = np.unravel_index(int(np.argmax(known)), errors.shape)
        if known[row, column] > abs(best[0]):
            theta = float(columns[column])
            phi = 90.0 if turned else (0.0 if theta >= 0 else 180.0)
            best = float(errors[row, column]), (abs(theta), float(ANGLES_O[row]), phi)
    return {"worst": best[0], "worst_at": best[1]}


def _true_albedo(stack: Stack, wo: Any, seed: int) -> float:
    """Mean albedo without what a smooth top mirrors; wo are cosine-weighted."""
    E = stack.albedo(wo, walks=256, seed=seed).value - stack.mirrored(wo)
    return float(np.mean(luminance(E)))


def _varied(model: Model, vary: str | None) -> Parameter | None:
    """The parameter whose influence is measured."""
    if vary is not None:
        declared = model.fields.get(vary)
        if not isinstance(declared, Parameter) or declared.width != 1:
            names = [
                n for n, d in model.fields.items() if isinstance(d, Parameter) and d.width == 1
            ]
            raise ModelError(f"{model.name} has no number {vary!r}; known are {', '.join(names)}.")
        return declared
    for name in VARIED:
        declared = model.fields.get(name)
        smooth = name == "alpha" and getattr(model, "interface", "") == "smooth"
        if isinstance(declared, Parameter) and declared.width == 1 and not smooth:
            return declared
    return None


def _steps(declared: Parameter) -> tuple[float, ...]:
    """Values across a parameter's range; wide ranges in even ratios."""
    low, high = declared.low, declared.high
    if high - low > 100:
        return tuple(float(x) for x in np.geomspace(max(low, 1.0), min(high, 1e4), STEPS))
    if declared.name == "alpha":
        low = max(low, 0.02)
    # Rounded for the reader, but not out of the range: pi / 2 is less than 1.5708
    values = np.linspace(low, min(high, 2.5), STEPS)
    return tuple(min(max(round(float(x), 4), declared.low), declared.high) for x in values)


# --- the picture -----------------------------------------------------------------------------------


def lines(c: Comparison) -> list[str]:
    """A comparison's numbers, for a terminal."""
    e = c.errors
    at = "theta_i {:g}, theta_o {:g}, phi {:g}".format(*e.worst_at)
    return [
        f"{c.name}  against {c.against}",
        f"  mean error   {100 * e.mean:.2f} %   (of which noise: up to {100 * e.noise:.2f} %)",
        f"  worst error  {percent(e.worst)} at {at} degrees",
        f"  energy       {percent(e.energy)}   (mean albedo {e.albedo:.4f}, should be {e.truth:.4f})",
    ]


def percent(x: float) -> str:
    """A relative number for people: +3 %, -12 %."""
    return f"{100 * x:+.1f} %" if abs(x) < 0.0995 else f"{100 * x:+.0f} %"
