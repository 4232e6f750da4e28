"""gonio's Mitsuba plug-ins beside Mitsuba's own `diffuse`: render times, and kernels compiled."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import drjit as dr
import numpy as np

import gonio
from gonio.bench.kernels import another_value, needed_again
from gonio.bench.report import BenchError, Column, Section, Value, goal_text, milliseconds, ratio
from gonio.bench.timing import alternate, stopwatch
from gonio.model import Parameter

VARIANT = "llvm_ad_rgb"

# Render time as a multiple of that with `diffuse`.
GOALS = {"gonio_lambert": 1.05, "gonio_eon": 1.15}

# gonio_lambert and diffuse are the same material, sampled in different ways: the mean difference of
# their pictures stays within this many standard errors.
SIGMAS = 5


@contextlib.contextmanager
def _mitsuba() -> Iterator[Any]:
    """Mitsuba with our variant and plug-ins; the variant of before comes back afterwards."""
    import mitsuba as mi

    import gonio.mitsuba

    before = mi.variant()
    mi.set_variant(VARIANT)
    gonio.mitsuba.register()
    try:
        yield mi
    finally:
        if before is not None:
            mi.set_variant(before)


def cornell_box(mi: Any, material: Mapping[str, Any], colour: str, size: int) -> Any:
    """Mitsuba's Cornell box with `material` on everything; `colour` is what it calls the albedo."""
    scene = mi.cornell_box()
    for name, part in scene.items():
        if isinstance(part, dict) and part.get("type") == "diffuse":
            scene[name] = {**material, colour: part["reflectance"]}
    scene["sensor"]["film"]["width"] = scene["sensor"]["film"]["height"] = size
    return mi.load_dict(scene)


def render_section(size: int, spp: int, repeat: int, progress: Callable[[str], None]) -> Section:
    """Render times of `diffuse`, `gonio_lambert` and `gonio_eon` in the same scene, in turn."""
    with _mitsuba() as mi:
        scenes = {"diffuse": cornell_box(mi, {"type": "diffuse"}, "reflectance", size)}
        for name in GOALS:
            scenes[name] = cornell_box(mi, {"type": name}, "rho", size)

        def render(scene: Any) -> Any:
            image = mi.render(scene, spp=spp, seed=0)
            dr.eval(image)
            dr.sync_thread()
            return image

        progress("render: the first pictures, which compile")
        pictures = {name: np.array(render(scene)) for name, scene in scenes.items()}
        _check_same(pictures["gonio_lambert"], pictures["diffuse"])
        progress(f"render: {', '.join(scenes)} {repeat} times")
        sides = {
            name: stopwatch(lambda scene=scene: render(scene))  # type: ignore[misc]
            for name, scene in scenes.items()
        }
        seconds = alternate(sides, repeat)
    rows: list[dict[str, Value]] = []
    for name, value in seconds.items():
        multiple = value / seconds["diffuse"]
        row: dict[str, Value] = {"row": name, "seconds": value, "multiple": multiple}
        if name in GOALS:
            row["goal"] = goal_text(multiple, at_most=GOALS[name])
        rows.append(row)
    columns = (
        Column("row", "material"),
        Column("seconds", "ms", milliseconds),
        Column("multiple", "× diffuse", ratio),
        Column("goal", "goal"),
    )
    note = (
        f"Mitsuba's Cornell box with the material on everything, {VARIANT}, path tracer, {size}×{size} "
        f"pixels, {spp} samples per pixel, compiled before."
    )
    return Section("render", "Mitsuba 3 plug-ins", [note], columns, rows)


def _check_same(ours: Any, theirs: Any) -> None:
    apart = np.mean(ours - theirs, axis=-1, dtype=np.float64)
    error = np.std(apart) / np.sqrt(apart.size)
    if not abs(np.mean(apart)) <= SIGMAS * error:
        raise BenchError(
            f"gonio_lambert and diffuse should give the same picture, but their means are "
            f"{np.mean(ours):.6g} and {np.mean(theirs):.6g} (standard error {error:.1g}): the render "
            "times cannot be compared."
        )


def kernel_rows(progress: Callable[[str], None]) -> list[dict[str, Value]]:
    """New kernels after `mi.traverse` changed each parameter of `gonio_eon`, one after the other."""
    progress("kernels of a changed plug-in")
    model = gonio.model("eon")
    changes = compiled = 0
    with _mitsuba() as mi:
        scene = mi.load_dict(
            {
                "type": "scene",
                "integrator": {"type": "direct"},
                "light": {"type": "constant"},
                "ball": {"type": "sphere", "bsdf": {"type": "gonio_eon"}},
                "sensor": {
                    "type": "perspective",
                    "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
                    "film": {"type": "hdrfilm", "width": 8, "height": 8},
                },
            }
        )
        scene_parameters = mi.traverse(scene)

        def render() -> None:
            dr.eval(mi.render(scene, spp=1, seed=0))

        for name, declared in model.fields.items():
            if not isinstance(declared, Parameter):
                continue
            (key,) = (k for k in scene_parameters.keys() if f".bsdf.{name}." in k)  # noqa: SIM118

            def changed(key: str = key, name: str = name, declared: Parameter = declared) -> None:
                value = another_value(declared, getattr(model, name))
                scene_parameters[key] = mi.Color3f(value) if declared.width == 3 else value
                scene_parameters.update()
                render()

            changes += 1
            compiled += needed_again(render, changed)
    return [{"row": "gonio_eon in Mitsuba, mi.traverse", "changes": changes, "compiled": compiled}]
