"""Whole shaders: a normal map, the material, a light and an environment, as a renderer shades a pixel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gonio.cost.program import ROWS, Program
from gonio.export.coded import Request
from gonio.export.lit import export_lit
from gonio.export.prove.opengl import HEAD
from gonio.model import Model

PHONG = Path(__file__).with_name("phong.glsl")

PER_PIXEL = 11
"""Numbers that differ from pixel to pixel: normal, tangent, view, u and v; the rest is a draw call's."""

BINDINGS = ("texture", "texture", "texture", "texture", "texture", "buffer", "buffer", "buffer")
"""Environment, tables of the split sum, of F and of D, normal map, constants, pixels, results."""


@dataclass(frozen=True)
class _Shade:
    """What is called."""

    prefix: str
    struct: str
    given: Mapping[str, str]
    """Arguments behind params, normal, tangent and view, with their types."""


def lit(
    label: str,
    model: Model,
    lights: Sequence[str],
    constants: Mapping[str, str] | None = None,
    tables: Request | None = None,
    mirror: str = "",
) -> Program:
    """A material function with its lights.

    Args:
        label: its row.
        model: the material.
        lights: as `gonio export --lit` takes them.
        constants: parameters that the compiler knows, by their place in the struct, as GLSL.
        tables: which functions are looked up.
        mirror: F(mu_o) by which the surface mirrors the environment, where no light does it, as GLSL in
            terms of {prefix} and {mu}; with a table of F the end of the name of the function that its row
            stands for.

    Raises:
        ExportError: the model cannot be exported.
    """
    made = export_lit(model, model.name, lights, "glsl", tables=tables)
    if made.tables is not None and made.tables.fresnel is not None:
        rows = made.tables.fresnel.rows
        row = next(i for i, name in enumerate(rows) if name.startswith(mirror))
        mirror = f"{{prefix}}_fresnel_table({{mu}}, {row}.0).x"
    given = {g.name: g.struct or ("float" if g.width == 1 else "vec3") for g in made.entry.given}
    shade = _Shade(made.entry.prefix, made.entry.struct, given)
    return Program(label, _text(made.source, shade, constants or {}, mirror), bindings=BINDINGS)


def plain_phong(label: str) -> Program:
    """Phong as it is written by hand, with the same features."""
    shade = _Shade("plain", "Plain", {"light": "vec3", "irradiance": "vec3"})
    return Program(label, _text(PHONG.read_text(encoding="utf-8"), shade, {}), bindings=BINDINGS)


def _text(source: str, shade: _Shade, constants: Mapping[str, str], mirror: str = "") -> str:
    members = "".join(f" {kind} {name};" for name, kind in shade.given.items())
    fixed = "".join(f"    params.{place} = {value};\n" for place, value in constants.items())
    arguments = ", ".join(["params", "mapped", "tangent", "view", *shade.given])
    reads = "\n".join(
        f"    vec3 {name} = vec3(x[i + {k}], x[i + {k + 1}], x[i + {k + 2}]);"
        for name, k in (("normal", 0), ("tangent", 3), ("view", 6))
    )
    return (
        f"{HEAD}layout(binding = 4) uniform sampler2D normal_map;\n{source}\n"
        f"{ENVIRONMENT if mirror else ''}layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 6) readonly buffer Pixels { float x[]; };\n"
        "layout(std430, binding = 7) writeonly buffer Made { float y[]; };\n"
        "layout(std430, binding = 5) readonly buffer Constants "
        f"{{ {shade.struct} material;{members} }};\n\n"
        "void main() {\n    int row = int(gl_GlobalInvocationID.x);\n"
        f"    if (row >= {ROWS}) {{\n        return;\n    }}\n    int i = row * {PER_PIXEL};\n{reads}\n"
        "    vec3 texel = textureLod(normal_map, vec2(x[i + 9], x[i + 10]), 0.0).xyz;\n"
        f"    {shade.struct} params = material;\n{fixed}"
        f"    vec3 mapped = {shade.prefix}_mapped_normal(normal, tangent, texel, 1.0);\n"
        f"    vec3 made = {shade.prefix}_shade({arguments});\n"
        f"{_mirrored(shade, mirror)}"
        "    y[3 * row] = made.x;\n    y[3 * row + 1] = made.y;\n    y[3 * row + 2] = made.z;\n}\n"
    )


ENVIRONMENT = "layout(binding = 0) uniform samplerCube environment_map;\n"


def _mirrored(shade: _Shade, reflectance: str) -> str:
    """Statements that add F(mu_o) times the environment, as Elek's Algorithm 1 ends (line 29)."""
    if not reflectance:
        return ""
    F = reflectance.format(prefix=shade.prefix, mu="max(dot(mapped, view), 0.0)")
    return (
        f"    float F = {F};\n"
        "    made += F * textureLod(environment_map, reflect(-view, mapped), 0.0).rgb;\n"
    )
