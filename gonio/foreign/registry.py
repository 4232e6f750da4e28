"""Which of gonio's models code is: by fitting every model of the registry to values of the code.

First all models with their default options, then the options of the nearest ones; last, the code's own
parameters are moved, and the model's are fitted anew, which shows how they belong together: alpha = r^2.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.fields import Option
from gonio.fit import METRICS, Problem, columns
from gonio.foreign.expressions import Array
from gonio.foreign.function import Foreign, probe
from gonio.measured import Measurement, measurement
from gonio.model import Model, models

# Pairs of directions of a fit, descents, and steps of each.
PAIRS = 240
STARTS = 3
STEPS = 60

# Models whose options are tried, and the misfit at which nothing is left to find.
NEAREST = 3
EXACT = 2e-4

# Code that is known but for one term is fitted further only to models that are so near.
PROMISING = 0.02

# Factors that are tried between code and model, beside the measured one.
FACTORS = {"f": 1.0, "pi f": float(np.pi), "f / pi": float(1 / np.pi)}

# How a model's parameter may come from the code's, tried in this order.
SCALES: dict[str, Callable[[Array], Array]] = {
    "{}": lambda r: r,
    "{}^2": lambda r: r * r,
    "sqrt({})": np.sqrt,
    "1 - {}": lambda r: 1 - r,
    "{}^4": lambda r: r**4,
    "(1 - {})^2": lambda r: (1 - r) ** 2,
    "{} / 2": lambda r: r / 2,
    "2 {}": lambda r: 2 * r,
    "{} pi / 2": lambda r: r * np.pi / 2,
    "radians({})": np.radians,
    "{}^2 / 2": lambda r: r * r / 2,
    "{}^3": lambda r: r**3,
    "{}^2.2": lambda r: r**2.2,
}
STEPPED = 4
RELATED = 2e-3

# A relation that has no formula, and how many numbers of a model may follow one of the code's like that.
UNKNOWN = "a function of"
BENT = 2

Progress = Callable[[int, int], None]


_Ranked = tuple[float, Model, str, Array]
"""Misfit, fitted model, factor, and its numbers."""


@dataclass(frozen=True)
class Found:
    """A model that was fitted to code."""

    model: Model
    factor: str
    misfit: float
    """Relative, at one setting of the code's parameters."""
    relations: dict[str, str]
    """The model's parameters in terms of the code's."""

    @property
    def exact(self) -> bool:
        """Whether only roundings are left, by numbers that have to do with those of the code.

        A model with many numbers can be bent to the code at every setting, which says nothing.
        """
        bent = Counter(text for text in self.relations.values() if text.startswith(UNKNOWN))
        return self.misfit < EXACT and max(bent.values(), default=0) <= BENT

    @property
    def named(self) -> str:
        """The model with its options."""
        chosen = [
            f"{name}={getattr(self.model, name)}"
            for name, f in self.model.fields.items()
            if isinstance(f, Option) and not f.is_default(getattr(self.model, name))
        ]
        return self.model.name + (f" with {', '.join(chosen)}" if chosen else "")

    def __str__(self) -> str:
        """In a sentence."""
        text = self.named
        if self.relations:
            text += ": " + ", ".join(f"{k} = {v}" for k, v in self.relations.items())
        return text + (f"; returns {self.factor}" if self.factor != "f" else "")


def setting(foreign: Foreign) -> dict[str, Any]:
    """Values of the code's parameters inside of their ranges, all different."""
    found: dict[str, Any] = {}
    for k, (name, p) in enumerate(foreign.parameters.items()):
        t = (0.45 + 0.17 * k) % 0.7 + 0.15
        if p.width == 3:
            found[name] = np.array([p.low + (p.high - p.low) * x for x in (0.75, 0.5, 0.3)])
        else:
            found[name] = p.low + (p.high - p.low) * t
    return found


def measured(foreign: Foreign, values: Mapping[str, Any], count: int) -> Measurement:
    """Values of code as a measurement."""
    wi, wo = probe(count, 21)
    f = foreign.brdf(wi, wo, values)
    return measurement("code", foreign.name, wi, wo, f, channels=("r", "g", "b"), isotropic=False)


class _Fitter:
    """Fits models to the code at one setting after the other."""

    def __init__(self, foreign: Foreign) -> None:
        self.foreign = foreign
        self.values = setting(foreign)
        self.wi, self.wo = probe(PAIRS // 2, 21)
        good = self.wi[:, 2] > 0.05
        self.wi, self.wo = self.wi[good], self.wo[good]

    def data(self, values: Mapping[str, Any]) -> Array:
        f = self.foreign.brdf(self.wi, self.wo, values)
        return np.where(np.isfinite(f), f, 0)

    def fit(
        self, model: Model, data: Array, starts: int, begin: Array | None = None
    ) -> tuple[float, Model, Array]:
        """Relative misfit, the fitted model, and its numbers."""
        from scipy.optimize import least_squares

        free = columns(model)
        problem = Problem(model, free, self.wi, self.wo, data, np.ones(len(data)))
        metric = METRICS["log"]
        low, high = problem.bounds
        width = np.where(np.isfinite(high - low), high - low, 1.0)
        scale = max(float(np.sqrt(np.mean(metric.value(data * self.wi[:, 2:]) ** 2))), 1e-9)
        rng = np.random.default_rng(3)
        best: tuple[float, Array] | None = None
        for number in range(starts):
            x = (
                begin
                if number == 0 and begin is not None
                else problem.start()
                if number == 0
                else problem.random(rng, 1)[0]
            )
            x = np.clip(x, low + 1e-3 * width, high - 1e-3 * width)
            result = least_squares(
                lambda x: problem.residuals(x, metric),
                x,
                lambda x: problem.jacobian(x, metric),
                (low, high),
                x_scale=width,
                max_nfev=STEPS,
                ftol=1e-10,
                xtol=1e-10,
                gtol=1e-13,
            )
            misfit = float(np.sqrt(2 * result.cost / data.size)) / scale
            if best is None or misfit < best[0]:
                best = (misfit, result.x)
            if best[0] < EXACT / 4:
                break
        assert best is not None
        return best[0], problem.made(best[1]), best[1]


def identify(
    foreign: Foreign,
    names: Iterable[str] = (),
    *,
    thorough: bool = False,
    partly: bool = False,
    count: int = 3,
    progress: Progress | None = None,
) -> list[Found]:
    """The models of the registry that are nearest to code, best first.

    Args:
        foreign: a function that is running.
        names: of models; all if empty.
        thorough: try the options of every model, not of the nearest ones alone.
        partly: most of it is known already: fit each model once, and go on with what is near.
        count: how many are returned.
        progress: called with what is done and what there is to do.
    """
    chosen = _ordered(foreign, names)
    fitter = _Fitter(foreign)
    values = fitter.values
    data = fitter.data(values)
    ranked: list[_Ranked] = []
    total = len(chosen) + (len(chosen) if thorough else NEAREST)

    def tell(done: int) -> None:
        if progress is not None:
            progress(done, total)

    for done, cls in enumerate(chosen):
        tell(done)
        model = _begin(cls, values)
        if model is None:
            continue
        for factor, size in list(FACTORS.items())[: 1 if partly else None]:
            misfit, fitted, x = fitter.fit(model, data / size, 1 if partly else STARTS)
            ranked.append((misfit, fitted, factor, x))
            if misfit < EXACT:
                break
        if (
            set(foreign.parameters)
            and set(foreign.parameters) <= set(cls.fields)
            and misfit >= EXACT
        ):
            # All names are the model's own: some of its options may be another
            for entry in ranked[-1 if partly else -len(FACTORS) :]:
                ranked.append(_improved(fitter, entry, data))
                if ranked[-1][0] < EXACT:
                    break
        if ranked and ranked[-1][0] < EXACT and not thorough:
            break
    ranked.sort(key=_rank)
    for k in range(len(ranked) if thorough else min(NEAREST, len(ranked))):
        tell(len(chosen) + k)
        if (ranked[0][0] < EXACT and not thorough) or (partly and ranked[k][0] > PROMISING):
            break
        ranked[k] = _improved(fitter, ranked[k], data)
    ranked.sort(key=_rank)
    tell(total)
    found: list[Found] = []
    seen: set[str] = set()
    for misfit, model, factor, _ in ranked:
        if model.name in seen:
            continue
        seen.add(model.name)
        related = _relations(fitter, model, FACTORS[factor], values) if len(found) == 0 else {}
        found.append(Found(model, factor, misfit, related))
        if len(found) == count:
            break
    return found


def by_names(foreign: Foreign, names: Iterable[str] = ()) -> Found | None:
    """The model whose parameters are the code's of the same names, if there is one.

    No fit is needed then, whose many numbers may have several best ones.
    """
    fitter = _Fitter(foreign)
    for cls in _ordered(foreign, names) if foreign.parameters else ():
        plain = cls()
        for factor, size in FACTORS.items():
            same = _same_names(fitter, plain, size)
            if same is not None and same < EXACT:
                return Found(plain, factor, same, {name: name for name in foreign.parameters})
    return None


def _ordered(foreign: Foreign, names: Iterable[str]) -> list[type[Model]]:
    """Models, those first that have the most names in common with the code, and few others.

    An exact one ends the search, and lambert comes before what can be made lambert.
    """
    registered = models()
    chosen = [registered[n] for n in names] if names else list(registered.values())
    return sorted(chosen, key=lambda cls: (-len(_shared(cls, foreign)), len(cls.fields)))


def _improved(fitter: _Fitter, entry: _Ranked, data: Array) -> _Ranked:
    """A fit with the best options."""
    misfit, model, factor, x = entry
    misfit, model, x = _options(fitter, model, data / FACTORS[factor], misfit, x)
    return misfit, model, factor, x


def _shared(cls: type[Model], foreign: Foreign) -> set[str]:
    return set(cls.fields) & set(foreign.parameters)


def _rank(entry: _Ranked) -> tuple[float, int]:
    """Exact ones first; among the others many numbers to fit count against a model."""
    misfit, _, factor, x = entry
    size = EXACT / 2 if misfit < EXACT else misfit * np.sqrt(len(x))
    return size, list(FACTORS).index(factor)


def _begin(cls: type[Model], values: Mapping[str, Any], model: Model | None = None) -> Model | None:
    """A model with the code's values where names are the same; None if it has nothing to fit."""
    model = model or cls()
    given = {}
    for path, p, _ in model.parameters():
        name = as_code(path)
        if name in values and np.ndim(values[name]) == (1 if p.width == 3 else 0):
            value = np.clip(values[name], p.low, p.high)
            given[path] = tuple(map(float, value)) if p.width == 3 else float(value)
    return model.replace(**given) if list(model.parameters()) else None


def as_code(path: str) -> str:
    """The name that code has for a parameter of an inner model: base_rho for base.rho."""
    return path.replace(".", "_")


def _options(
    fitter: _Fitter, model: Model, data: Array, misfit: float, x: Array
) -> tuple[float, Model, Array]:
    """The best options, one after the other."""
    for name, declared in model.fields.items():
        if not isinstance(declared, Option):
            continue
        for value in declared.values:
            if value == getattr(model, name) or misfit < EXACT:
                continue
            try:
                other = model.replace(**{name: value})
            except ValueError:  # options that do not go together
                continue
            # From where the fit was, and from the code's own values where names are the same
            own = _begin(type(other), fitter.values, other)
            tries = [fitter.fit(other, data, 1, x)]
            if own is not None:
                tries.append(fitter.fit(own, data, 2))
            off, fitted, y = min(tries, key=lambda t: t[0])
            if off < 0.98 * misfit:
                misfit, model, x = off, fitted, y
    return misfit, model, x


def _relations(
    fitter: _Fitter, model: Model, factor: float, values: Mapping[str, Any]
) -> dict[str, str]:
    """How the model's parameters come from the code's; numbers where they do not."""
    foreign = fitter.foreign
    found: dict[str, str] = {}
    if _same_names(fitter, model, factor) is not None:
        return {name: name for name in foreign.parameters}
    free = columns(model)
    base = {c.name: v for c, v in zip(free, _numbers(model, free), strict=True)}
    for name, p in foreign.parameters.items():
        steps = p.low + (p.high - p.low) * np.linspace(0.3, 0.85, STEPPED)
        rows = []
        x = np.array(list(base.values()))
        for step in steps:
            value = np.full(3, step) if p.width == 3 else step
            _, _, x = fitter.fit(model, fitter.data({**values, name: value}) / factor, 1, x)
            rows.append(x)
        table = np.stack(rows)
        for k, column in enumerate(free):
            low, high, path = column.low, column.high, column.places[0][0]
            width = high - low if np.isfinite(high) else 1.0
            if np.ptp(table[:, k]) < RELATED * width or path in found:
                continue
            for text, turn in SCALES.items():
                with np.errstate(all="ignore"):
                    expected = np.clip(turn(steps), low, high)
                if np.abs(expected - table[:, k]).max() < RELATED * max(width, 1e-9):
                    found[path] = text.format(name)
                    break
            else:
                found[path] = f"{UNKNOWN} {name}"
    for path, p, value in model.parameters():
        if path not in found and not p.is_default(value):
            numbers = np.atleast_1d(value)
            shown = numbers[:1] if np.ptp(numbers) == 0 else numbers
            found[path] = "/".join(f"{v:.4g}" for v in shown)
    return found


def _same_names(fitter: _Fitter, model: Model, factor: float) -> float | None:
    """The misfit if the model's parameters are the code's of the same names, and none else is needed.

    Fitted numbers that the values hardly depend on would hide that. None if they are not.
    """
    foreign = fitter.foreign
    paths = {as_code(path): path for path, _, _ in model.parameters()}
    declared = {as_code(path): p for path, p, _ in model.parameters()}
    if not set(foreign.parameters) <= set(declared):
        return None
    rng = np.random.default_rng(9)
    worst = 0.0
    for _ in range(3):
        values: dict[str, Any] = {}
        for name, p in foreign.parameters.items():
            low, high = max(p.low, declared[name].low), min(p.high, declared[name].high)
            t = low + (min(high, low + 100) - low) * rng.uniform(0.1, 0.9, declared[name].width)
            values[name] = tuple(map(float, t)) if p.width == 3 else float(t[0])
        code = fitter.data(values) / factor
        given = {paths[name]: value for name, value in values.items()}
        truth = np.asarray(model.replace(**given).eval(fitter.wi, fitter.wo), np.float64)
        scale = float(np.sqrt(np.mean(code**2)))
        off = float(np.sqrt(np.mean((code - truth) ** 2)))
        if not off <= 5 * EXACT * scale:
            return None
        worst = max(worst, off / max(scale, 1e-30))
    return worst


def _numbers(model: Model, free: Any) -> list[float]:
    values = {path: np.atleast_1d(v) for path, _, v in model.parameters()}
    places = [column.places[0] for column in free]
    return [float(values[path][channel % len(values[path])]) for path, channel in places]
