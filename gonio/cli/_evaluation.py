"""What a model, or a Mitsuba BSDF, says about one pair of directions: as data, and as text for people."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gonio.lang import MU_MIN

if TYPE_CHECKING:
    from gonio.check.derivatives import Derivative


@dataclass(frozen=True)
class Evaluation:
    """A model at one pair of directions."""

    model: str
    precision: str
    wi: list[float]
    wo: list[float]
    eval: list[float]
    """BRDF in 1/sr, without the cosine."""
    pdf: float
    """Density with which `sample` draws wi for this wo, in 1/sr."""
    weight: list[float] | None
    """Monte Carlo weight f cos(theta_i) / pdf; None where the pdf is 0."""
    albedo: list[float]
    """Directional, for wo."""
    mean_albedo: list[float] | None
    """None of a Mitsuba BSDF."""
    u: list[float] | None = None
    """The random numbers from which `sample` made wi; None where wi was given."""
    sampled_pdf: float | None = None
    """The density that `sample` reported."""
    compared: Evaluation | None = None
    """What it was compared with."""
    derivatives: list[Derivative] | None = None
    """Where they were asked for."""
    all_parts: float | None = None
    """Of a Mitsuba BSDF that also mirrors or transmits: the mean weight of all samples, for wo."""


def differences(one: Evaluation, other: Evaluation) -> str:
    """By how much two evaluations differ, relative to the larger one of the two."""

    def off(a: Any, b: Any) -> float:
        a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
        scale = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.finfo(np.float64).tiny)
        return float((np.abs(a - b) / scale).max())

    found = [
        ("eval", one.eval, other.eval),
        ("pdf", one.pdf, other.pdf),
        ("albedo", one.albedo, other.albedo),
    ]
    if one.u is not None:
        between = np.linalg.norm(np.subtract(one.wi, other.wi))
        return f"wi by {between:.3g}, " + ", ".join(f"{n} {off(a, b):.3g}" for n, a, b in found)
    return ", ".join(f"{name} {off(a, b):.3g}" for name, a, b in found)


def lines(result: Evaluation) -> Iterator[str]:
    """The lines of an evaluation, for a terminal."""
    yield f"{result.model}  in {result.precision}"
    if result.u is not None:
        yield f"  {'u':<12} {', '.join(f'{x:.9g}' for x in result.u)}   (wi is sampled)"
    for name, w in (("wi", result.wi), ("wo", result.wo)):
        theta = math.degrees(math.atan2(math.hypot(w[0], w[1]), w[2]))
        yield f"  {name:<12} {', '.join(f'{x:.7g}' for x in w)}   (theta {theta:.6g}°)"
    weight = "none, the pdf is 0" if result.weight is None else _number(result.weight)
    digits = [
        ("eval", f"{_number(result.eval)} 1/sr", "BRDF without the cosine"),
        ("pdf", f"{_number(result.pdf)} 1/sr", "density of sample"),
        *(
            []
            if result.sampled_pdf is None
            else [("reported", f"{_number(result.sampled_pdf)} 1/sr", "density that came with wi")]
        ),
        ("weight", weight, "eval cos(theta_i) / pdf"),
        ("albedo", _number(result.albedo), "directional, for wo"),
    ]
    if result.mean_albedo is not None:
        digits.append(("mean albedo", _number(result.mean_albedo), "over all directions"))
    if result.all_parts is not None:
        digits.append(
            ("all parts", _number(result.all_parts), "mean weight of all samples, for wo")
        )
    width = max(len(value) for _, value, _ in digits)
    for name, value, meaning in digits:
        yield f"  {name:<12} {value:<{width}}   {meaning}"
    if result.compared is not None:
        yield from lines(result.compared)
        yield f"  {'difference':<12} {differences(result, result.compared)}   (relative)"
    longest = max((len(d.name) for d in result.derivatives or ()), default=0)
    for d in result.derivatives or ():
        parts = [("float32", d.float32), ("float64", d.float64)]
        parts += [] if d.difference is None else [("central difference", d.difference)]
        yield f"  {d.name:<{longest}}  {'; '.join(f'{name} {_number(v)}' for name, v in parts)}"
    below = [n for n, w in (("wi", result.wi), ("wo", result.wo)) if w[2] <= MU_MIN]
    if below and result.mean_albedo is not None:  # a Mitsuba BSDF may have a back
        yield f"  {' and '.join(below)} not above the horizon: BRDF and pdf are 0 there."


def _number(value: float | Sequence[float]) -> str:
    if isinstance(value, (int, float)):
        return f"{value:.9g}"
    distinct = value[:1] if len(set(value)) == 1 else value
    return ", ".join(f"{v:.9g}" for v in distinct)


# What is left out where there is none.
OPTIONAL = {"u", "sampled_pdf", "compared", "derivatives", "mean_albedo", "all_parts"}


def _readable(value: Any) -> Any:
    """Numbers that JSON cannot hold as the words NaN, Infinity and -Infinity."""
    if isinstance(value, dict):
        return {
            key: _readable(v) for key, v in value.items() if not (key in OPTIONAL and v is None)
        }
    if isinstance(value, list):
        return [_readable(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else f"{'-' if value < 0 else ''}Infinity"
    return value


def data(result: Evaluation) -> Any:
    """The same as plain data that JSON can hold."""
    return _readable(dataclasses.asdict(result))
