"""Measures the smallest fault that each check of `gonio check` finds: the table in docs/checking.md.

    python tools/measure_power.py --effort quick --placements 100

Every fault has a size, and a place that is drawn at random: a bump over a tenth of a cosine's range and of
a parameter's, unless it is everywhere. Sizes go up by 1, 2, 5; printed is the smallest one that was found
at every place, so that with 100 of them one in a hundred may be missed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import gonio  # before Dr.Jit, for which it finds an LLVM

# isort: split
import drjit as dr

from gonio.check import CHECKS, kernels
from gonio.check.report import EFFORTS, Effort
from gonio.check.subject import ModelSubject
from gonio.lang import Sample, select
from gonio.model import Model

SIZES = [m * 10.0**e for e in range(-7, 1) for m in (1, 2, 5)]

# Width of a bump, of a range from 0 to 1.
WIDTH = 0.05


class Fault:
    """The size of a fault and three random numbers that say where it is, as values that kernels read."""

    def __init__(self) -> None:
        """No fault."""
        self.size = 0.0
        self.place = [0.5, 0.5, 0.5]

    def numbers(self, Float: Any) -> tuple[Any, Any, Any, Any]:
        """Size and place in the kernel's number type."""
        size, *place = (dr.opaque(Float, float(v)) for v in (self.size, *self.place))
        return (size, *place)


FAULT = Fault()


def bump(x: Any, centre: Any) -> Any:
    """1 at the centre, falling to nothing within a tenth of the range."""
    t = (x - centre) / WIDTH
    return dr.exp(-t * t)


Planted = Callable[[Any, Any, Any, Any, tuple[Any, Any, Any, Any]], Any]


def planted(base: str, parameter: str, **methods: Planted) -> type[Model]:
    """A model with faults: functions of the value, wi, wo, the parameter and the fault's numbers.

    Args:
        base: name of the model.
        parameter: field whose range the fault's second place is in.
        methods: what is wrong, by the name of the method.
    """
    cls: Any = gonio.models()[base]
    declared = cls.fields[parameter]

    def part(self: Any) -> Any:
        return (getattr(self, parameter) - declared.low) / (declared.high - declared.low)

    class Wrong(cls, register=False):  # type: ignore[misc, call-arg]
        def eval(self, wi: Any, wo: Any) -> Any:
            value = super().eval(wi, wo)
            wrong = methods.get("eval")
            numbers = FAULT.numbers(self.float_type)
            return value if wrong is None else wrong(value, wi, wo, part(self), numbers)

        def pdf(self, wi: Any, wo: Any) -> Any:
            value = super().pdf(wi, wo)
            wrong = methods.get("pdf")
            numbers = FAULT.numbers(self.float_type)
            return value if wrong is None else wrong(value, wi, wo, part(self), numbers)

        def sample(self, wo: Any, u: Any) -> Any:
            wi = super().sample(wo, u).wi
            return Sample(wi, self.pdf(wi, wo))

    if cls.writes("albedo"):

        def albedo(self: Any, wo: Any) -> Any:
            value = super(Wrong, self).albedo(wo)
            wrong = methods.get("albedo")
            numbers = FAULT.numbers(self.float_type)
            return value if wrong is None else wrong(value, wo, wo, part(self), numbers)

        Wrong.albedo = albedo
    return Wrong


# What is planted: a check, what is wrong in words, and the model.
FAULTS: list[tuple[str, str, type[Model]]] = [
    (
        "energy",
        "gain, in a tenth of wo's cosines and of a parameter",
        planted(
            "eon",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(o.z, n[1]) * bump(r, n[2])),
        ),
    ),
    (
        "reciprocity",
        "a factor that only wi has, in a tenth of its cosines and of a parameter",
        planted(
            "metallic_roughness",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(i.z, n[1]) * bump(r, n[2])),
        ),
    ),
    (
        "isotropy",
        "a factor at one azimuth of wo, in a tenth of a parameter",
        planted(
            "metallic_roughness",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(o.x, 2 * n[1] - 1) * bump(r, n[2])),
        ),
    ),
    (
        "albedo",
        "closed form, in a tenth of the cosines and of a parameter",
        planted(
            "eon",
            "roughness",
            albedo=lambda f, i, o, r, n: f + n[0] * bump(o.z, n[1]) * bump(r, n[2]),
        ),
    ),
    (
        "sampling",
        "density too large on one side of wi and too small on the other, everywhere",
        planted(
            "eon",
            "roughness",
            pdf=lambda p, i, o, r, n: (
                p * (1 + select(i.x * (n[1] - 0.5) > i.y * (n[2] - 0.5), n[0], -n[0]))
            ),
        ),
    ),
    (
        "sampling",
        "the same in a tenth of a parameter",
        planted(
            "eon",
            "roughness",
            pdf=lambda p, i, o, r, n: p * (1 + bump(r, n[2]) * select(i.x > 0, n[0], -n[0])),
        ),
    ),
    (
        "sampling",
        "density times a factor, everywhere",
        planted("metallic_roughness", "roughness", pdf=lambda p, i, o, r, n: p * (1 + n[0])),
    ),
    (
        "sampling",
        "the same in a tenth of a parameter",
        planted(
            "metallic_roughness",
            "roughness",
            pdf=lambda p, i, o, r, n: p * (1 + n[0] * bump(r, n[2])),
        ),
    ),
    (
        "finite",
        "NaN in a part of the parameter's range",
        planted(
            "eon",
            "roughness",
            eval=lambda f, i, o, r, n: select(dr.abs(r - n[2]) < 0.5 * n[0], np.nan, f),
        ),
    ),
    (
        "finite",
        "NaN in a square of both cosines with this side",
        planted(
            "eon",
            "roughness",
            eval=lambda f, i, o, r, n: select(
                (dr.abs(i.z - n[1]) < 0.5 * n[0]) & (dr.abs(o.z - n[2]) < 0.5 * n[0]), np.nan, f
            ),
        ),
    ),
    (
        "finite",
        "float32 off, in a tenth of a parameter",
        planted(
            "eon",
            "roughness",
            eval=lambda f, i, o, r, n: (
                f * (1 + n[0] * bump(r, n[2])) if dr.itemsize_v(type(i.z)) == 4 else f
            ),
        ),
    ),
    (
        "gradient",
        "a derivative off by this part of the value, in a tenth of the parameter",
        planted(
            "eon",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(r, n[2]) * (r - dr.detach(r))),
        ),
    ),
    (
        "continuity",
        "a jump at one cosine of wi, in a tenth of a parameter",
        planted(
            "metallic_roughness",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(r, n[2]) * select(i.z > n[1], 1, 0)),
        ),
    ),
    (
        "continuity",
        "a kink there: the slope changes by this part of the value per unit of the cosine",
        planted(
            "metallic_roughness",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(r, n[2]) * dr.abs(i.z - n[1])),
        ),
    ),
    (
        "continuity",
        "a jump in a parameter",
        planted(
            "metallic_roughness",
            "roughness",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * select(r > n[2], 1, 0)),
        ),
    ),
    (
        "monotonicity",
        "growth over a tenth of the parameter's range",
        # Not at the range's beginning, where a bump only falls
        planted(
            "qon",
            "sigma",
            eval=lambda f, i, o, r, n: f * (1 + n[0] * bump(r, 3 * WIDTH + (1 - 3 * WIDTH) * n[2])),
        ),
    ),
]


def found(check: str, model: type[Model], effort: Effort) -> bool:
    """Whether a check fails the model."""
    with kernels.one_thread():
        return CHECKS[check](ModelSubject(model()), effort).failed


def smallest(
    check: str, model: type[Model], effort: Effort, placements: int, progress: Callable[[str], None]
) -> float:
    """The smallest size that is found at every place; infinite if some fault of size 5 is missed."""
    rng = np.random.default_rng(1)
    FAULT.size = 0.0
    if found(check, model, effort):
        raise SystemExit(f"{model.__mro__[1].__name__} fails {check} without a fault as well.")
    rank = None
    for number in range(placements):
        FAULT.place = list(rng.random(3))
        if rank is None:  # the first place: from above
            rank = len(SIZES)
            while rank > 0:
                FAULT.size = SIZES[rank - 1]
                if not found(check, model, effort):
                    break
                rank -= 1
        while rank < len(SIZES):
            FAULT.size = SIZES[rank]
            if found(check, model, effort):
                break
            rank += 1
        progress(f"{number + 1} of {placements}: {SIZES[rank] if rank < len(SIZES) else np.inf:g}")
        if rank == len(SIZES):
            return np.inf
    return SIZES[rank or 0]


def main() -> None:
    """Print a line of the table for every fault."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--effort", choices=list(EFFORTS), default="quick")
    parser.add_argument("--placements", type=int, default=100)
    parser.add_argument("--only", default="", help="names of checks, with commas")
    options = parser.parse_args()
    only = options.only.split(",") if options.only else list(CHECKS)
    print(f"| check | fault | {options.effort} |\n| :-- | :-- | --: |")
    for check, words, model in FAULTS:
        if check not in only:
            continue
        start = time.perf_counter()

        def show(text: str, check: str = check, words: str = words) -> None:
            print(f"\r{check}, {words}: {text}   ", end="", flush=True)

        size = smallest(check, model, EFFORTS[options.effort], options.placements, show)
        print(f"\r| {check} | {words} | {size:g} |  ({time.perf_counter() - start:.0f} s)   ")


if __name__ == "__main__":
    main()
