"""gonio's Mitsuba plug-ins beside Mitsuba's own: render times, and kernels compiled."""

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
from gonio.fields import Parameter

VARIANT = "llvm_ad_rgb"

# Render time as a multiple of that with Mitsuba's own material.
GOALS = {"gonio_lambert": 1.05, "gonio_eon": 1.15, "gonio_torrance_sparrow": 1.1}

# gonio's plug-ins by Mitsuba's own that they are compared with. The first of each is the same material,
# sampled in another way: the mean difference of their pictures stays within SIGMAS standard errors.
COMPARED = {
    "diffuse": ("gonio_lambert", "gonio_eon"),
    "roughconductor": ("gonio_torrance_sparrow",),
}
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


def cornell_box(mi: Any, material: Mapping[str, Any], colour: str | None, size: int) -> Any:
    """Mitsuba's Cornell box with `material` on everything; `colour` is what it calls the albedo."""
    scene = mi.cornell_box()
    for name, part in scene.items():
        if isinstance(part, dict) and part.get("type") == "diffuse":
            albedo = {} if colour is None else {colour: part["reflectance"]}
            scene[name] = {**material, **albedo}
    scene["sensor"]["film"]["width"] = scene["sensor"]["film"]["height"] = size
    return mi.load_dict(scene)


def _materials() -> dict[str, tuple[dict[str, Any], str | None]]:
    """Plug-ins by name, with the name of their albedo; the metal is gold for both."""
    from gonio.mitsuba import node

    # Mitsuba's masking is the separable one.
    gold = gonio.model("torrance_sparrow", masking="smith")
    conductor = node(gold)
    own = {"distribution": "ggx"} | {name: conductor[name] for name in ("alpha", "eta", "k")}
    return {
        "diffuse": ({"type": "diffuse"}, "reflectance"),
        "gonio_lambert": ({"type": "gonio_lambert"}, "rho"),
        "gonio_eon": ({"type": "gonio_eon"}, "rho"),
        "roughconductor": ({"type": "roughconductor", **own}, None),
        "gonio_torrance_sparrow": (conductor, None),
    }


def render_section(size: int, spp: int, repeat: int, progress: Callable[[str], None]) -> Section:
    """Render times of Mitsuba's materials and of gonio's in the same scene, in turn."""
    rows: list[dict[str, Value]] = []
    with _mitsuba() as mi:
        materials = _materials()

        def render(scene: Any) -> Any:
            image = mi.render(scene, spp=spp, seed=0)
            dr.eval(image)
            dr.sync_thread()
            return image

        for own, ours in COMPARED.items():
            names = (own, *ours)
            progress(f"render: the first pictures of {', '.join(names)}, which compile")
            scenes = {name: cornell_box(mi, *materials[name], size) for name in names}
            pictures = {name: np.array(render(scene)) for name, scene in scenes.items()}
            _check_same(ours[0], own, pictures[ours[0]], pictures[own])
            progress(f"render: {', '.join(names)} {repeat} times")
            sides = {
                name: stopwatch(lambda scene=scene: render(scene))  # type: ignore[misc]
                for name, scene in scenes.items()
            }
            seconds = alternate(sides, repeat)
            for name, value in seconds.items():
                multiple = value / seconds[own]
                row: dict[str, Value] = {"row": name, "seconds": value, "multiple": multiple}
                if name in GOALS:
                    row["goal"] = goal_text(multiple, at_most=GOALS[name])
                rows.append(row)
    columns = (
        Column("row", "material"),
        Column("seconds", "ms", milliseconds),
        Column("multiple", "× Mitsuba's", ratio),
        Column("goal", "goal"),
    )
    note = (
        f"Mitsuba's Cornell box with the material on everything, {VARIANT}, path tracer, {size}×{size} "
        f"pixels, {spp} samples per pixel, compiled before. gonio_lambert and gonio_eon are compared with "
        "Mitsuba's diffuse, gonio_torrance_sparrow (GGX, gold) with its roughconductor."
    )
    return Section("render", "Mitsuba 3 plug-ins", [note], columns, rows)


def _check_same(ours: str, own: str, our_picture: Any, own_picture: Any) -> None:
    apart = np.mean(our_picture - own_picture, axis=-1, dtype=np.float64)
    error = np.std(apart) / np.sqrt(apart.size)
    if not abs(np.mean(apart)) <= SIGMAS * error:
        raise BenchError(
            f"{ours} and {own} should give the same picture, but their means are "
            f"{np.mean(our_picture):.6g} and {np.mean(own_picture):.6g} (standard error {error:.1g}): "
            "the render times cannot be compared."
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
