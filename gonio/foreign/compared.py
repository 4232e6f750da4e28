"""Foreign code beside one of gonio's models: the largest difference, where it is, and what it depends on.

Faults that break no law, such as 4 for 4 cos cos, a factor of pi, or a roughness squared twice, are found
here alone.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.check.report import EFFORTS, Effort
from gonio.check.search import maximise
from gonio.check.variants import value_at
from gonio.fields import Parameter
from gonio.foreign.expressions import Array
from gonio.foreign.function import Foreign
from gonio.foreign.rounding import OFTEN, ROUNDINGS, Rounded, rounded
from gonio.foreign.source import ForeignError
from gonio.foreign.terms import constant_name
from gonio.foreign.verdicts import FLOOR
from gonio.model import Model

# Ends of the bands of angles, in degrees: the larger of the two angles counts.
BANDS = (0.0, 60.0, 75.0, 85.0, 89.0, 89.9)
BAND_POINTS = 2048

# What counts as equal: differences of this size are roundings of constants in shaders.
EQUAL = 1e-4

# The ratio depends on one thing alone if what is left inside of its bins is less than this of the whole.
ALONE = 0.1
BINS = 48


@dataclass(frozen=True)
class Comparison:
    """How far code is from a model."""

    code: str
    model: Model | Foreign
    linked: dict[str, str]
    """Parameters of the model that the code has, by the model's name."""
    fitted: dict[str, Any]
    """Parameters of the model that were fitted, or kept, at the code's defaults."""
    largest: float
    """Relative difference beyond rounding."""
    rounding: float
    theta_i: float
    theta_o: float
    azimuth: float
    """Between both directions, in degrees; 180 is forward."""
    values: dict[str, Any]
    """Of the code's parameters there."""
    code_value: float
    model_value: float
    bands: tuple[tuple[float, float, float], ...]
    """From and to which angle, and the largest difference there."""
    hint: str
    foreign: Foreign
    """The code, its parameters called as the model's."""
    taken: dict[str, str]
    """Parameters of the code that were taken for one of the model with another name."""

    def data(self) -> dict[str, Any]:
        """As plain data that JSON can hold."""
        return {
            "code": self.code,
            "model": self.model.name,
            "linked": self.linked,
            "taken": self.taken,
            "fitted": {k: _plain(v) for k, v in self.fitted.items()},
            "largest": self.largest,
            "rounding": self.rounding,
            "at": {
                "theta_i": self.theta_i,
                "theta_o": self.theta_o,
                "azimuth": self.azimuth,
                **{k: _plain(v) for k, v in self.values.items()},
            },
            "code_value": _finite(self.code_value),
            "model_value": _finite(self.model_value),
            "bands": [{"from": a, "to": b, "largest": d} for a, b, d in self.bands],
            "hint": self.hint,
        }

    def lines(self) -> list[str]:
        """For people."""
        same = [b for b in self.bands if b[2] <= EQUAL]
        name = self.model.name
        if self.largest <= EQUAL:
            first = (
                f"{self.code} is {name}: equal to {self.largest:.2g} everywhere, beyond rounding"
            )
        elif same and len(same) < len(self.bands) and self.bands.index(same[-1]) == len(same) - 1:
            first = (
                f"{self.code} is {name} up to {same[-1][1]:g} degrees (equal to "
                f"{max(b[2] for b in same):.1g}), but not beyond, where it is up to {_times(self)}"
            )
        else:
            first = f"{self.code} is not {name}: up to {_times(self)}"
        if self.hint and self.largest > EQUAL:
            first += f"; {self.hint}"
        times = self.code_value / self.model_value if self.model_value else np.inf
        found = [
            first,
            f"  largest difference {self.largest:.4g} (of the larger value; rounding is "
            f"{self.rounding:.1g} there): "
            f"{self.code_value:.6g} instead of {self.model_value:.6g}, {times:.4g} times",
            f"  at theta_i = {self.theta_i:.4g}, theta_o = {self.theta_o:.4g}, azimuth "
            f"{self.azimuth:.4g} degrees"
            + "".join(f", {k} = {_text(v)}" for k, v in self.values.items()),
            "  by the larger angle: "
            + ", ".join(
                f"{a:g}-{b:g} degrees {d:.2g}"
                + (f" ({1 / (1 - d):.3g} times)" if 0.1 < d < 0.999 else "")
                for a, b, d in self.bands
            ),
        ]
        if self.linked:
            found.append("  same parameters: " + ", ".join(self.linked))
        for name, path in self.taken.items():
            found.append(
                f"  taken as the same: {name} and {path}, the only colour of each; "
                f'--map "{name}=..." says otherwise'
            )
        alone = [n for n in self.foreign.parameters if n not in self.linked]
        if alone and not isinstance(self.model, Foreign):
            kept = ", ".join(f"{n} = {_text(self.foreign.parameters[n].default)}" for n in alone)
            others = ", ".join(self.fitted) or "none"
            found.append(
                f"  parameters of the code alone: {kept}; if one of them is {others}: "
                f'--map "{alone[0]}={next(iter(self.fitted), alone[0])}"'
            )
        if self.fitted:
            shown = ", ".join(f"{k} = {_text(v)}" for k, v in self.fitted.items())
            found.append(f"  parameters of {name} alone: {shown}")
        return found


def _times(found: Comparison) -> str:
    """How much too bright or dark the code is at the worst."""
    code, model = found.code_value, found.model_value
    if not np.isfinite(code):
        return "not a number"
    if min(code, model) < FLOOR:
        return f"{code:.4g} instead of {model:.4g}"
    ratio = code / model
    if abs(ratio - 1) < 0.1:
        return f"{abs(ratio - 1):.2g} too {'bright' if ratio > 1 else 'dark'} (of {model:.4g})"
    return f"{ratio:.4g} times too bright" if ratio > 1 else f"{1 / ratio:.4g} times too dark"


def _plain(value: Any) -> Any:
    return np.asarray(value, np.float64).tolist()


def _finite(value: float) -> float | str:
    return value if np.isfinite(value) else "NaN"


def _text(value: Any) -> str:
    numbers = [float(x) for x in np.atleast_1d(value)]
    return "/".join(f"{x:.5g}" for x in (numbers[:1] if len(set(numbers)) == 1 else numbers))


def links(foreign: Foreign, model: Model | Foreign) -> dict[str, tuple[Parameter, Parameter]]:
    """Parameters that code and model both have, by name: as the code and as the model declares them.

    Raises:
        ForeignError: the code has a colour where the model has a number.
    """
    found = {}
    for path, declared in _declared(model).items():
        own = foreign.parameters.get(path) or foreign.parameters.get(path.replace(".", "_"))
        if own is None:
            continue
        if own.width == 3 and declared.width == 1:
            raise ForeignError(f"{foreign.name}: {path} is a colour, but a number in {model.name}.")
        found[path] = (own, declared)
    return found


_COLOUR = re.compile(r"albedo|colou?r|diffuse|^k_?d$|reflectance|^rho|^base$|tint", re.I)


def adopted(foreign: Foreign, model: Model | Foreign) -> tuple[Foreign, dict[str, str]]:
    """The code with its one colour called as the model's one colour, and what was renamed."""
    if isinstance(model, Foreign):
        return foreign, {}
    known = links(foreign, model)
    own = [
        n
        for n, p in foreign.parameters.items()
        if n not in known and (p.width == 3 or _COLOUR.search(n))
    ]
    other = [n for n, p in _declared(model).items() if n not in known and p.width == 3]
    if len(own) != 1 or len(other) != 1 or other[0] in foreign.parameters or "." in other[0]:
        return foreign, {}
    return foreign.renamed(own[0], other[0]), {own[0]: other[0]}


def compare(
    foreign: Foreign,
    model: Model | Foreign,
    *,
    fit_parameters: bool = False,
    effort: str | Effort = "quick",
) -> Comparison:
    """Compare code with a model over all angles, and over the parameters that both have.

    Args:
        foreign: a function that is running.
        model: its parameters that the code does not have keep their values. Other code works as well.
        fit_parameters: fit these instead, at the code's defaults.
        effort: of EFFORTS in gonio.check.report.

    Raises:
        ForeignError: parameters that do not go together.
    """
    level = EFFORTS[effort] if isinstance(effort, str) else effort
    foreign, taken = adopted(foreign, model)
    linked = links(foreign, model)
    if fit_parameters:
        if isinstance(model, Foreign):
            raise ForeignError(f"{model.name} is code; only parameters of models can be fitted.")
        model = _fitted(foreign, model, linked)
    numbers = [
        (
            name,
            c,
            Parameter(
                own.default, max(own.low, m.low), min(own.high, m.high), name, name, own.width
            ),
        )
        for name, (own, m) in linked.items()
        for c in range(own.width)
    ]
    count = len(numbers)

    def spread(points: Array) -> tuple[Array, Array, dict[str, Array]]:
        values: dict[str, list[Array]] = {}
        for k, (name, _, p) in enumerate(numbers):
            values.setdefault(name, []).append(np.asarray(value_at(p, points[:, k])))
        given = {n: np.stack(v, -1) if len(v) > 1 else v[0] for n, v in values.items()}
        given = {n: v.astype(np.float32).astype(np.float64) for n, v in given.items()}
        return *_pair(points[:, count:]), given

    def both(points: Array, times: int = 3) -> tuple[Rounded, Array]:
        wi, wo, values = spread(points)
        code = rounded(foreign, wi, wo, values, times=times)
        if isinstance(model, Foreign):
            other = rounded(model, wi, wo, values, times=times)
            return Rounded(code.values, code.rounding + other.rounding), other.values
        return code, evaluate(model, wi, wo, values)

    def departure(points: Array, times: int = 3) -> Array:
        code, truth = both(points, times)
        with np.errstate(invalid="ignore"):
            beyond = np.abs(code.values - truth) - ROUNDINGS * code.rounding
            scale = np.maximum(np.maximum(np.abs(code.values), np.abs(truth)), FLOOR)
            off = np.nan_to_num(np.maximum(beyond, 0) / scale, nan=1.0)
            # Two versions of a shader that both have no number somewhere are no different there
            neither = ~np.isfinite(code.values) & ~np.isfinite(truth)
            return np.asarray(np.where(neither, 0, off).max(axis=1))

    points, _ = maximise(
        departure,
        count + 4,
        population=level.population // 4,
        rounds=level.rounds // 2 + 2,
        seed=31,
    )
    lasting = departure(points[:16], OFTEN)
    best = points[int(np.argmax(lasting)) : int(np.argmax(lasting)) + 1]
    wi, wo, values = spread(best)
    code, truth = both(best, OFTEN)
    channel = int(np.argmax(np.nan_to_num(np.abs(code.values - truth)[0], nan=np.inf)))
    scale = max(abs(float(truth[0, channel])), FLOOR)
    flat = np.arctan2(wi[0, 1], wi[0, 0]) - np.arctan2(wo[0, 1], wo[0, 0])
    return Comparison(
        foreign.label or foreign.name,
        model,
        {name: name for name in linked},
        {p: v for p, v in _values(model).items() if p not in linked},
        float(lasting.max()),
        float(code.rounding[0].max()) / scale,
        float(np.degrees(np.arccos(min(wi[0, 2], 1)))),
        float(np.degrees(np.arccos(min(wo[0, 2], 1)))),
        float(abs((np.degrees(flat) + 180) % 360 - 180)),
        {n: v[0] for n, v in values.items()},
        float(code.values[0, channel]),
        float(truth[0, channel]),
        tuple(_bands(departure, count)),
        hint(foreign, model, spread, count),
        foreign,
        taken,
    )


def _pair(t: Array) -> tuple[Array, Array]:
    """Directions of four coordinates; half of them near the mirror direction. Cosines from 0.001."""
    from gonio.check.subject import directions

    def lifted(z: Array) -> Array:
        return np.maximum(z, 1e-3)

    angle = 0.5 * np.pi
    wo = directions(lifted(np.cos(angle * t[:, 0])), 2 * np.pi * t[:, 1])
    near = t[:, 3] < 0.5
    turn = (
        2 * np.pi * t[:, 1]
        + np.pi
        + np.where(near, 4 * (t[:, 3] - 0.25) ** 3 * 16, 4 * np.pi * t[:, 3])
    )
    wi = directions(lifted(np.cos(angle * t[:, 2])), turn)
    return wi, wo


def _declared(model: Model | Foreign) -> dict[str, Parameter]:
    """The parameters of a model or of code, by name."""
    if isinstance(model, Foreign):
        return model.parameters
    return {path: declared for path, declared, _ in model.parameters()}


def _values(model: Model | Foreign) -> dict[str, Any]:
    """Their values."""
    if isinstance(model, Foreign):
        return model.defaults()
    return {path: value for path, _, value in model.parameters()}


def evaluate(model: Model | Foreign, wi: Array, wo: Array, values: Mapping[str, Any]) -> Array:
    """Values of a model in float64, or of code, (n, 3), with arrays for some of its parameters."""
    if isinstance(model, Foreign):
        return model.brdf(wi, wo, values)
    widths = {path: p.width for path, p, _ in model.parameters()}
    given = {
        n: np.repeat(v[:, None], 3, axis=1) if widths[n] == 3 and np.ndim(v) == 1 else v
        for n, v in values.items()
    }
    f = np.asarray(model.replace(**given).eval(wi, wo), np.float64)
    return np.broadcast_to(f if f.ndim == 2 else f[:, None], (len(wi), 3))


def _fitted(foreign: Foreign, model: Model, linked: Mapping[str, Any]) -> Model:
    """The model with those parameters fitted that the code does not have."""
    from gonio.fit import fit
    from gonio.foreign.registry import measured

    model = model.replace(**{n: own.default for n, (own, _) in linked.items()})
    if all(path in linked for path, _, _ in model.parameters()):
        return model
    return fit(model, measured(foreign, {}, 1500), fixed=tuple(linked), starts=3).model


def _bands(departure: Any, count: int) -> list[tuple[float, float, float]]:
    rng = np.random.default_rng(33)
    found = []
    for low, high in itertools.pairwise(BANDS):
        points = rng.random((BAND_POINTS, count + 4))
        large = (low + (high - low) * points[:, count]) / 90
        small = large * points[:, count + 2]
        swap = rng.random(BAND_POINTS) < 0.5
        points[:, count] = np.where(swap, large, small)
        points[:, count + 2] = np.where(swap, small, large)
        level = rng.random(BAND_POINTS) < 0.3
        points[level, count + 2] = points[level, count]
        found.append((low, high, float(departure(points, 6).max())))
    return found


def hint(foreign: Foreign, model: Model | Foreign, spread: Any, count: int) -> str:
    """What the ratio of code and model depends on, if it is simple."""
    rng = np.random.default_rng(35)
    points = rng.random((6000, count + 4))
    points[:, count] *= 0.92
    points[:, count + 2] *= 0.92
    wi, wo, values = spread(points)
    code, truth = foreign.brdf(wi, wo, values)[:, 0], evaluate(model, wi, wo, values)[:, 0]
    good = (code > 1e-6) & (truth > 1e-6) & np.isfinite(code)
    if good.sum() < 500:
        return ""
    ratio = np.log(code[good] / truth[good])
    whole = float(ratio.std())
    middle = float(np.exp(np.median(ratio)))
    if whole < 1e-3:
        name = constant_name(middle)
        return f"the code is the model times {name} everywhere" if name else ""
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    things = {
        "N.L": wi[:, 2],
        "N.V": wo[:, 2],
        "N.H": h[:, 2],
        "V.H": (wi * h).sum(1),
        "L.V": (wi * wo).sum(1),
        "N.L N.V": wi[:, 2] * wo[:, 2],
        **{n: v if v.ndim == 1 else v[:, 0] for n, v in values.items()},
    }
    for name, x in things.items():
        rest = _left(ratio, x[good])
        if rest < ALONE * whole:
            slope = np.polyfit(np.log(np.maximum(x[good], 1e-6)), ratio, 1)
            line = float((ratio - np.polyval(slope, np.log(np.maximum(x[good], 1e-6)))).std())
            power = f", as its power {slope[0]:.3g}" if line < 0.02 * whole else ""
            return f"the ratio depends on {name} alone{power}: {MEANING.get(name, '')}".rstrip(": ")
    equal = np.abs(ratio) < 1e-3
    low = (wi * wo).sum(1)[good] < 0
    if equal[~low].mean() > 0.99 and equal[low].mean() < 0.9:
        return "it is equal but where L.V is negative: is L.V cut at 0?"
    return ""


MEANING = {
    "N.L": "a cosine, or masking, that is missing or too much on the light's side",
    "N.V": "a cosine, or masking, that is missing or too much on the viewer's side",
    "N.H": "another distribution, or another width",
    "V.H": "another Fresnel term",
    "L.V": "an angle between light and viewer that is cut or scaled",
    "N.L N.V": "the 4 N.L N.V below, or masking, is another",
}


def _left(ratio: Array, x: Array) -> float:
    """What is left of the spread inside of bins of x, with a line through each."""
    order = np.argsort(x)
    found = []
    for part in np.array_split(order, BINS):
        if len(part) > 8 and np.ptp(x[part]) > 0:
            line = np.polynomial.Polynomial.fit(x[part], ratio[part], 1)
            found.append((ratio[part] - line(x[part])).std())
        else:
            found.append(ratio[part].std())
    return float(np.sqrt(np.mean(np.square(found))))
