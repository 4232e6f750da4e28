"""What is varied in a sweep, as it is written (roughness=0..1:21), and what is measured."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gonio.fields import ModelError, Option, Parameter
from gonio.materials.notation import parse_angle
from gonio.model import Model

COLUMNS: dict[str, tuple[str, ...]] = {
    "albedo": ("albedo_r", "albedo_g", "albedo_b"),
    "mean_albedo": ("mean_albedo_r", "mean_albedo_g", "mean_albedo_b"),
    "variance": ("weight_mean", "weight_variance", "weight_maximum"),
    "difference": ("difference", "energy"),
}
"""What can be measured, and its columns."""

# Values of a range that says no number of its own.
STEPS = 11

# A sweep of more points is a slip of the keyboard.
MOST = 100_000_000

Value = float | str


@dataclass(frozen=True)
class Axis:
    """A parameter or option, and what it becomes."""

    name: str
    values: tuple[Value, ...]


def axis(model: Model, text: str) -> Axis:
    """What is varied, and how: name=0..1, name=0..1:21, name=0.01..1:log, name=0.01..1:21:log, name=a,b,c.

    Raises:
        ModelError: an unknown name, values out of the parameter's range, or something else than that.
    """
    name, equals, rest = (part.strip() for part in text.partition("="))
    if not equals or not rest:
        raise _wrong(text)
    declared = {path: p for path, p, _ in model.parameters()}.get(name)
    if declared is None and isinstance(model.fields.get(name), Option):
        choices = tuple(choice.strip() for choice in rest.split(","))
        for choice in choices:
            model.replace(**{name: choice})  # complains about what it does not know
        return Axis(name, choices)
    if declared is None:
        names = [path for path, _, _ in model.parameters()]
        names += [n for n, f in model.fields.items() if isinstance(f, Option)]
        raise ModelError(f"{model.name} has no {name!r} to vary; it has {', '.join(names)}.")
    values = _values(text, rest)
    _check(model, declared, name, values)
    return Axis(name, values)


def _values(text: str, rest: str) -> tuple[float, ...]:
    try:
        if ".." not in rest:
            return tuple(parse_angle(piece) for piece in rest.split(","))
        ends, *more = rest.split(":")
        low, high = (parse_angle(end) for end in ends.split("..", 1))
        logarithmic = "log" in more
        counts = [int(piece) for piece in more if piece != "log"]
    except ValueError:
        raise _wrong(text) from None
    if len(counts) > 1 or more.count("log") > 1 or not (math.isfinite(low) and math.isfinite(high)):
        raise _wrong(text)
    steps = counts[0] if counts else STEPS
    if steps < 2:
        raise ModelError(f"{text!r}: a range has 2 values or more; write one value as name=VALUE.")
    if logarithmic and not (low > 0 and high > 0):
        raise ModelError(f"{text!r}: logarithmic steps need ends above 0.")
    made = np.geomspace(low, high, steps) if logarithmic else np.linspace(low, high, steps)
    # The ends as they were written, not as a logarithm rounds them
    return (low, *made[1:-1].tolist(), high)


def _wrong(text: str) -> ModelError:
    return ModelError(
        f"{text!r} is not what can be varied; write name=0..1, name=0..1:21, name=0.01..1:21:log, "
        "or name=a,b,c."
    )


def _check(model: Model, declared: Parameter, name: str, values: Sequence[float]) -> None:
    for value in (values[0], values[-1], *values):  # the ends are what the user wrote
        if not declared.low <= value <= declared.high:
            raise ModelError(
                f"{model.name}: {name}={value:g} is out of range; allowed is {declared.range_text()}."
            )


def points(axes: Sequence[Axis]) -> Iterator[tuple[Value, ...]]:
    """All combinations, the last axis fastest.

    Raises:
        ModelError: one name twice, or more points than anybody can mean.
    """
    names = [a.name for a in axes]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(f"{name} is varied twice; leave one of them out.")
    count = math.prod(len(a.values) for a in axes)
    if count > MOST:
        raise ModelError(f"{count:.3g} combinations are too many; at most {MOST:.0e} are allowed.")
    return itertools.product(*(a.values for a in axes))
