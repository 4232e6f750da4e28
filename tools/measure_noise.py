"""Prints how noisy gonio's pictures are beside Mitsuba's own materials, at equal time, on the same scene.

    python tools/measure_noise.py

The scene is that of `gonio render`: the shader ball in the studio. Its material is gonio's plug-in or
Mitsuba's own of the same formula, and it is sampled as gonio sets it up, or as Mitsuba does when nothing
is said (independent samples, every lamp as often as any other). A row's cost is its variance times its
CPU seconds, over that of Mitsuba's material in gonio's setup: 1 is as noisy in equal time, 2 takes twice
as long.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

import gonio
from gonio.mitsuba import node
from gonio.render.passes import ready_mitsuba
from gonio.render.stage import shader_ball

SIZE, SPP, SEEDS = 96, 36, 8
ENVIRONMENTS = ("studio", "sun")


def materials() -> dict[str, tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """gonio's and Mitsuba's own, by what they show."""
    gold = gonio.model(
        "torrance_sparrow", masking="smith", alpha=0.15
    )  # Mitsuba's masking is separable
    conductor = node(gold)
    own = {"distribution": "ggx"} | {name: conductor[name] for name in ("alpha", "eta", "k")}
    grey = {"type": "rgb", "value": [0.8, 0.8, 0.8]}
    return {
        "gold, alpha 0.15": (conductor, {"type": "roughconductor", **own}),
        "matte, rho 0.8": (node(gonio.Lambert()), {"type": "diffuse", "reflectance": grey}),
    }


def as_it_comes(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene without gonio's settings of samplers."""
    plain: dict[str, Any] = {}
    for name, part in scene.items():
        if isinstance(part, dict):
            part = {k: v for k, v in part.items() if k != "sampling_weight"}
            if isinstance(part.get("emitter"), dict):
                emitter = part["emitter"]
                part["emitter"] = {k: v for k, v in emitter.items() if k != "sampling_weight"}
        plain[name] = part
    plain["sensor"]["sampler"] = {"type": "independent", "sample_count": SPP}
    del plain["integrator"]["rr_depth"]
    return plain


def measure(mi: Any, scene: Any) -> tuple[float, float]:
    """Variance of a pixel over the square of its brightness, on the mean; CPU seconds of a picture."""
    loaded = mi.load_dict(scene, optimize=False)

    def picture(seed: int) -> Any:
        return np.array(mi.render(loaded, spp=SPP, seed=seed)).mean(axis=2)

    picture(1000)  # compiles
    start = time.process_time()
    pictures = np.stack([picture(seed) for seed in range(SEEDS)])
    seconds = (time.process_time() - start) / SEEDS
    mean, variance = pictures.mean(axis=0), pictures.var(axis=0, ddof=1)
    return float(np.mean(variance / (mean + 0.05) ** 2)), seconds


def main() -> None:
    """One row for each material, environment and setup."""
    mi = ready_mitsuba()
    print("| scene | material, setup | noise of a pixel | CPU s | cost |")
    print("|---|---|---:|---:|---:|")
    for name, (ours, own) in materials().items():
        for environment in ENVIRONMENTS:
            settings: dict[str, Any] = {
                "environment": environment,
                "size": (SIZE, SIZE),
                "spp": SPP,
            }
            rows = {
                "Mitsuba's, gonio's setup": shader_ball(dict(own), **settings),
                "gonio's, gonio's setup": shader_ball(dict(ours), **settings),
                "Mitsuba's, as it comes": as_it_comes(shader_ball(dict(own), **settings)),
            }
            found = {label: measure(mi, scene) for label, scene in rows.items()}
            base = np.prod(found["Mitsuba's, gonio's setup"])
            for label, (variance, seconds) in found.items():
                cost = variance * seconds / base
                print(
                    f"| {name}, {environment} | {label} | {100 * variance**0.5:.2f} % "
                    f"| {seconds:.2f} | {cost:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
