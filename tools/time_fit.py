"""Print what fits take on this machine, in seconds of wall and CPU.

python tools/time_fit.py            # six parameters of disney, 10,000 directions, four starts
python tools/time_fit.py --merl     # all 1.46 million cells of a MERL file, made from a model
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import gonio
from gonio import fit, measured

# Six parameters are free; the others of 2012's model are not in the data.
FIXED = ("subsurface", "specular_tint", "anisotropic", "sheen_tint", "clearcoat", "clearcoat_gloss")
TRUE = {"base_color": (0.6, 0.3, 0.1), "roughness": 0.35, "metallic": 0.3, "specular": 0.6}


def timed(name: str, points: int | None, data: measured.Measurement) -> None:
    """Fit, and print one line."""
    wall, cpu = time.perf_counter(), time.process_time()
    found = fit.fit(gonio.model("disney"), data, fixed=(*FIXED, "sheen"), points=points)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(
        f"{name}: {found.directions} directions x RGB, {len(found.starts)} starts, "
        f"{len(found.values)} numbers: {wall:.2f} s, {cpu:.2f} s of CPU; "
        f"roughness {found.model.roughness:.5f}, {TRUE['roughness']} is right"
    )


def main() -> None:
    """Make the data, and fit it twice: the first time compiles the kernels."""
    true = gonio.model("disney", **TRUE)
    if "--merl" in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "made.binary"
            measured.save(path, true)
            timed("a MERL file", None, measured.load(path))
        return
    data = fit.measure(true, 0)
    for name in ("first", "again"):
        timed(name, fit.POINTS, data)


if __name__ == "__main__":
    main()
