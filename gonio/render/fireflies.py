"""Fireflies: samples of indirect light far brighter than white, cut at a limit, and what that takes away.

A small sun in a rough metal is found by chance alone once another surface lies between: few samples then
hold much light, and stand as bright dots in a picture that is right on average. To cut them makes it calm
and a little too dark. What the lamps do at the first surface, highlights among it, is left as it is.
"""

from __future__ import annotations

import functools
from typing import Any

import drjit as dr

TINY = 1e-30  # under which no limit is asked for

# A smaller share of the light is not cut: single precision's difference of a sample and its first surface.
ROUNDING = 1e-7


@functools.cache
def _type(variant: str) -> Any:
    """The integrator of one of Mitsuba's variants."""
    import mitsuba as mi

    assert mi.variant() == variant

    class Cut(mi.SamplingIntegrator):  # type: ignore[misc]
        """Another integrator's samples, whose indirect light is nowhere brighter than a limit."""

        def __init__(self, whole: Any, direct: Any, limit: float) -> None:
            super().__init__(mi.Properties())
            self.whole, self.direct, self.limit = whole, direct, mi.Float(limit)
            dr.make_opaque(self.limit)
            self.light, self.kept = dr.zeros(mi.Float64), dr.zeros(mi.Float64)

        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> Any:
            # The same random numbers, so that the first surface gets the same light in both
            again = sampler.clone()
            whole, valid, more = self.whole.sample(scene, sampler, ray, medium, active)
            direct, _, _ = self.direct.sample(scene, again, ray, medium, active)
            indirect = dr.maximum(whole - direct, 0)
            share = dr.minimum(1, self.limit / dr.maximum(dr.max(indirect), TINY))
            found = direct + indirect * share
            for total, part in ((self.light, whole), (self.kept, found)):
                dr.scatter_add(total, mi.Float64(dr.sum(part)), mi.UInt32(0), active)
            return found, valid, more

        def aov_names(self) -> Any:
            return self.whole.aov_names()

    return Cut


def cut(whole: Any, limit: float) -> Any:
    """An integrator that gives a path tracer's samples, no indirect light in them above a limit."""
    import mitsuba as mi

    direct = mi.load_dict({"type": "path", "max_depth": 2, "hide_emitters": whole.hide_emitters})
    return _type(mi.variant())(whole, direct, limit)


def lost(integrator: Any) -> float:
    """Part of the picture's light that was cut away."""
    light, kept = float(integrator.light[0]), float(integrator.kept[0])
    share = 1 - kept / light if light > 0 else 0.0
    return share if share > ROUNDING else 0.0
