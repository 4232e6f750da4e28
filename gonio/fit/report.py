"""A fit in lines of text, and as data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from gonio.fit.columns import CHANNELS
from gonio.fit.fitting import Fit
from gonio.fit.intervals import LEVEL
from gonio.fit.metrics import METRICS
from gonio.fit.misfit import EXACT
from gonio.materials.notation import model_text


def lines(found: Sequence[Fit], costs: Sequence[int | None]) -> Iterator[str]:
    """What was found, the best model first.

    Args:
        found: the fits.
        costs: instructions of each model in a shader; None where the compilers that count are not there.
    """
    if len(found) > 1:
        yield from _table(found, costs)
    for f, cost in zip(found, costs, strict=True):
        yield model_text(f.model)
        yield from _misfit(f)
        yield from _numbers(f)
        if not f.intervals and set(f.values) - set(f.undetermined):
            yield (
                f"  {f'{LEVEL:.0%} in':<13} unknown: {f.directions} directions make {f.blocks} blocks "
                f"of neighbours, too few for {len(f.values)} numbers"
            )
        if f.undetermined:
            names = ", ".join(_whole(f.undetermined))
            yield f"  {'undetermined':<13} {names}: not determined by this data"
        if f.spare:
            yield f"  {'spare':<13} {', '.join(_whole(f.spare))}: kept, others can do whatever they do"
        if f.at_bounds:
            yield f"  {'at an end':<13} {', '.join(_whole(f.at_bounds))}"
        for number, region in enumerate(f.regions):
            yield f"  {'fails at' if number == 0 else '':<13} {region.sentence()}"
        if len(found) == 1 and not getattr(f.model, "not_exported", ""):
            yield f"  {'cost':<13} {_cost(cost)}"
        # Below EXACT of the data all is rounding
        size = f.misfit[f.metric] / f.relative if f.relative else 0.0
        same = sum(s <= max(1.001 * f.starts[0], EXACT * size) + 1e-12 for s in f.starts)
        yield (
            f"  {'starts':<13} {same} of {len(f.starts)} came to the same; {f.directions} directions, "
            f"{f.evaluations} evaluations, {f.seconds:.1f} s"
        )


def _cost(cost: int | None) -> str:
    if cost is None:
        return (
            "unknown: glslangValidator and spirv-opt count it ('gonio doctor' says how to get them)"
        )
    return f"{cost} instructions of SPIR-V in a shader"


def _table(found: Sequence[Fit], costs: Sequence[int | None]) -> Iterator[str]:
    """One line for each model."""
    names = [_name(f.model) for f in found]
    width = max(len(name) for name in names)
    yield "  ".join(
        [f"{'model':<{width}}", "misfit", *(f"{m:>9}" for m in METRICS), "numbers", "instructions"]
    )
    for name, f, cost in zip(names, found, costs, strict=True):
        sizes = [f"{f.misfit[m]:>9.4g}" for m in METRICS]
        count = f"{len(f.values):>7}"
        known = f"{'unknown' if cost is None else cost:>12}"
        yield "  ".join([f"{name:<{width}}", f"{f.relative:>6.1%}", *sizes, count, known])
    yield ""


def _name(model: Any) -> str:
    """A model's name, or those of a sum's terms."""
    if model.name != "sum":
        return str(model.name)
    return f"{_name(model.first)}+{_name(model.second)}"


def _misfit(f: Fit) -> Iterator[str]:
    others = ", ".join(f"{name} {value:.4g}" for name, value in f.misfit.items())
    yield f"  {'misfit':<13} {f.relative:.2%} of the data in {f.metric}; root mean squares: {others}"
    if f.noise is not None:
        part = f.relative / max(f.misfit[f.metric], 1e-300)
        yield (
            f"  {'of that':<13} noise {f.noise.size * part:.2%} (by {f.noise.by}), the model's own "
            f"{f.noise.model * part:.2%}"
        )


def _numbers(f: Fit) -> Iterator[str]:
    """Each free number, or colour, with its interval, and what the other metrics make of it."""
    names = _whole(tuple(f.values))
    width = max(len(name) for name in names)
    shown = {m: [_number(values, name) for name in names] for m, values in f.by_metric.items()}
    wide = max(len(text) for text in shown[f.metric])
    for row, name in enumerate(names):
        between = ""
        if all(part in f.intervals for part in _parts(name, f.values)):
            low, high = (
                _number({n: ends[k] for n, ends in f.intervals.items()}, name) for k in (0, 1)
            )
            between = f"{LEVEL:.0%} in {low} to {high}"
        elsewhere = ", ".join(f"{m} {shown[m][row]}" for m in shown if m != f.metric)
        line = f"    {name:<{width}}  {shown[f.metric][row]:<{wide}}  {between}"
        yield (f"{line}; {elsewhere}" if between else line + elsewhere).rstrip()


def _parts(name: str, known: Any) -> list[str]:
    """A number's name, or those of a colour's channels."""
    return [name] if name in known else [f"{name}.{c}" for c in CHANNELS]


def _number(values: dict[str, float], name: str) -> str:
    """A value in four digits; a colour with slashes, unless it is grey."""
    found = [f"{values[part]:.4g}" for part in _parts(name, values)]
    return found[0] if len(set(found)) == 1 else "/".join(found)


def _whole(names: tuple[str, ...]) -> list[str]:
    """Names of numbers, with that of a colour in place of all its channels'."""
    found: dict[str, None] = {}
    for name in names:
        path, dot, channel = name.rpartition(".")
        whole = dot and channel in CHANNELS and all(f"{path}.{c}" in names for c in CHANNELS)
        found[path if whole else name] = None
    return list(found)


def data(f: Fit, cost: int | None) -> dict[str, Any]:
    """The same as plain numbers and words, for JSON."""
    return {
        "model": model_text(f.model),
        "parameters": {path: value for path, _, value in f.model.parameters()},
        "metric": f.metric,
        "misfit": f.misfit,
        "relative": f.relative,
        "noise": None
        if f.noise is None
        else {"noise": f.noise.size, "model": f.noise.model, "by": f.noise.by},
        "values": f.values,
        "intervals": {name: list(ends) for name, ends in f.intervals.items()},
        "by_metric": f.by_metric,
        "linear": list(f.linear),
        "undetermined": list(f.undetermined),
        "spare": list(f.spare),
        "at_bounds": list(f.at_bounds),
        "fails": [
            {"where": r.name, "share": r.share, "ratio": r.ratio, "sentence": r.sentence()}
            for r in f.regions
        ],
        "instructions": cost,
        "starts": list(f.starts),
        "directions": f.directions,
        "seconds": f.seconds,
    }
