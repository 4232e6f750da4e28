"""Mean albedos that a model asks of what lies below it, found once instead of at every point.

A coat with `bounces="diffuse"` asks its base for one. Where the base has no formula, it is a sum of two
million values, and a kernel of Mitsuba's would do it again in each lane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi

from gonio.albedos.quadrature import know_mean
from gonio.lang import vec3
from gonio.mitsuba.properties import PREFIX
from gonio.model import Child, Model


def asked(model: Model) -> tuple[str, ...]:
    """Paths of the inner models whose mean albedo `eval` asks for, and that have no formula for it."""
    found: list[str] = []

    def convert(path: str, declared: Any, value: Any) -> Any:
        wide = value if isinstance(value, tuple) else (value,) * 3
        return vec3(*map(float, wide)) if declared.width == 3 else float(value)

    def answer(path: str) -> Any:
        found.append(path)
        return vec3(0.5, 0.5, 0.5)

    bound = model.bind(float, convert)
    inner = [(path, each) for path, each in _inner(bound) if not each.writes("mean_albedo")]
    if inner:
        for path, each in inner:
            object.__setattr__(each, "mean_albedo", lambda path=path: answer(path))
        up = vec3(0.0, 0.0, 1.0)
        bound.eval(up, up)
    return tuple(dict.fromkeys(found))


def find(model: Model, bound: Model, paths: Sequence[str], Float: Any) -> dict[str, Any]:
    """The mean albedos of inner models, by their paths.

    Args:
        model: as users hold it.
        bound: the same with the values that Mitsuba's textures have everywhere.
        paths: of the inner models.
        Float: Mitsuba's type of numbers.
    """
    values = {path: _plain(value, declared) for path, declared, value in bound.parameters()}
    found = {}
    for path in paths:
        part: Any = model
        for name in path.split("."):
            part = getattr(part, name)
        own = {p.removeprefix(f"{path}."): v for p, v in values.items() if p.startswith(f"{path}.")}
        colour = part.replace(**own).mean_albedo()
        # Opaque: known to no kernel, so that another value compiles none
        opaque = [dr.opaque(Float, float(c)) if dr.is_jit_v(Float) else float(c) for c in colour]
        found[path] = vec3(*opaque)
    return found


def give(bound: Model, means: dict[str, Any]) -> None:
    """Let inner models of a bound one answer with what was found."""
    for path, each in _inner(bound):
        if path in means:
            know_mean(each, means[path])


_told: set[tuple[str, str]] = set()


def say_varies(model: Model, path: str) -> None:
    """Say once that a mean is summed at every point, and what to do."""
    if (model.name, path) not in _told:
        _told.add((model.name, path))
        mi.Log(
            mi.LogLevel.Warn,
            f"{PREFIX}{model.name} asks for the mean albedo of its {path}, whose parameters are textures, "
            "spectra or differentiated: it is summed at every point, which takes minutes. Give that part "
            "constants, or another option.",
        )


def _inner(model: Model, prefix: str = "") -> Iterator[tuple[str, Model]]:
    for name, declared in model.fields.items():
        if isinstance(declared, Child):
            part = getattr(model, name)
            yield prefix + name, part
            yield from _inner(part, f"{prefix}{name}.")


def _plain(value: Any, declared: Any) -> Any:
    """A number, or three, of a value that is the same everywhere."""
    if declared.width == 1:
        return float(dr.slice(value)) if dr.is_jit_v(value) else float(value)
    return tuple(float(dr.slice(c)) if dr.is_jit_v(c) else float(c) for c in value)
