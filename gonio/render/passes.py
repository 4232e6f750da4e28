"""Mitsuba at work: passes of samples that add up to a picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio import backend

Pixels = NDArray[np.float32]
Progress = Callable[[int, int], None]
"""Called with (samples done, samples in all) after every pass."""

# Samples of one pass: small enough to show progress and to answer an interrupt within a second or two,
# large enough (4 M paths) to keep all cores busy.
PATHS_PER_PASS = 1 << 22


def integrate(loaded: Any, spp: int, seed: int, progress: Progress | None) -> Pixels:
    """The mean of several passes, so that long work shows progress and can be interrupted."""
    import drjit as dr
    import mitsuba as mi

    if spp < 1:
        raise ValueError(f"spp={spp} is out of range; allowed is at least 1.")
    width, height = loaded.sensors()[0].film().size()
    limit = max(1, PATHS_PER_PASS // max(int(width) * int(height), 1))
    total: Any = 0
    done = 0
    for number, count in enumerate(_passes(spp, limit)):
        # Mitsuba derives a pass's random numbers from its seed; far-apart seeds never overlap.
        picture = mi.render(loaded, spp=count, seed=seed * 65536 + number)
        total = total + picture * (count / spp)
        dr.eval(total)
        done += count
        if progress is not None:
            dr.sync_thread()
            progress(done, spp)
    pixels = np.array(total, dtype=np.float32)[..., :3]
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels


# A stratified sampler wants square numbers of samples, and rounds others up with a warning.
SQUARES = (64, 36, 16, 4, 1)


def _passes(spp: int, limit: int) -> Iterator[int]:
    """Square numbers of samples, at most `limit` each, that add up to `spp`."""
    while spp > 0:
        count = next(n for n in SQUARES if n <= min(spp, limit))
        yield count
        spp -= count


def ready_mitsuba() -> Any:
    """Mitsuba with a variant that fits the backend in force, unless the user chose one."""
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant(backend.mitsuba_variant())
    import gonio.mitsuba

    gonio.mitsuba.register()
    return mi
