"""What a host supplies, in each language: declarations, and functions with textures and tables.

Most languages have textures and buffers as global names, and a lookup is a function. C++, CUDA and Metal
have none, or not everywhere: there a lookup is a method of an object that the host passes in, of any type.

Level k of the environment map is blurred by alpha = (k / LAST_LEVEL)^2; the table's axes are mu and the
root of alpha, with values in the middles of its texels, so that clamped coordinates need no correction.
`gonio bake` writes both that way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from gonio.export import buffer
from gonio.export.coded import CodedTable
from gonio.export.comments import comment
from gonio.export.host import OBJECTS
from gonio.export.printer import INDENT, Printer
from gonio.export.tree import Function
from gonio.lights.lookups import LAST_LEVEL

# What hosts bind: resources by lookup.
MAPS: Mapping[str, str] = MappingProxyType(
    {
        "environment": "environment_map",
        "split_sum": "split_sum_map",
        "fresnel_table": "fresnel_map",
        "distribution_table": "distribution_map",
    }
)

# Lookups that stand for functions of the model.
TABLES = ("fresnel_table", "distribution_table")

# What the object of C++, CUDA and Metal calls the buffer of tables.
ROWS = "rows"

# A lookup's statements, after the language's own words for textures: {map} is its resource, {step} and
# {half} make a place from 0 to 1 the coordinate between the middles of a table's outer texels, {down} and
# {first} a row that of its middle.
_LEVEL = f"{LAST_LEVEL}.0 * sqrt(alpha)"
_F_X = "{step} * cos_theta + {half}"
_D_X = "{step} * u + {half}"
_Y = "{down} * row + {first}"
_GLSL = {
    "fresnel_table": (f"return textureLod({{map}}, vec2({_F_X}, {_Y}), 0.0).rgb;",),
    "distribution_table": (f"return textureLod({{map}}, vec2({_D_X}, {_Y}), 0.0).r;",),
    "environment": ("return textureLod({map}, direction, " + _LEVEL + ").rgb;",),
    "split_sum": ("return textureLod({map}, vec2(mu, sqrt(alpha)), 0.0).rg;",),
}
_HLSL = {
    "fresnel_table": (
        f"return {{map}}.SampleLevel({{p}}_linear_clamp, float2({_F_X}, {_Y}), 0.0).rgb;",
    ),
    "distribution_table": (
        f"return {{map}}.SampleLevel({{p}}_linear_clamp, float2({_D_X}, {_Y}), 0.0).r;",
    ),
    "environment": ("return {map}.SampleLevel({p}_linear_clamp, direction, " + _LEVEL + ").rgb;",),
    "split_sum": ("return {map}.SampleLevel({p}_linear_clamp, float2(mu, sqrt(alpha)), 0.0).rg;",),
}
_WGSL = {
    "fresnel_table": (
        f"let at = vec2f({_F_X}, {_Y});",
        "return textureSampleLevel({map}, {p}_linear_clamp, at, 0.0).rgb;",
    ),
    "distribution_table": (
        f"let at = vec2f({_D_X}, {_Y});",
        "return textureSampleLevel({map}, {p}_linear_clamp, at, 0.0).r;",
    ),
    "environment": (
        "return textureSampleLevel({map}, {p}_linear_clamp, direction, " + _LEVEL + ").rgb;",
    ),
    "split_sum": (
        "return textureSampleLevel({map}, {p}_linear_clamp, vec2f(mu, sqrt(alpha)), 0.0).rg;",
    ),
}
_MSL = {
    "environment": (
        "constexpr sampler smooth(filter::linear, mip_filter::linear);",
        "return {map}.sample(smooth, direction, level(" + _LEVEL + ")).rgb;",
    ),
    "split_sum": (
        "constexpr sampler smooth(filter::linear, address::clamp_to_edge);",
        "return {map}.sample(smooth, float2(mu, sqrt(alpha)), level(0.0)).rg;",
    ),
}
_CUDA = {
    "environment": (
        f"float level = {LAST_LEVEL}.0f * sqrtf(alpha);",
        "float4 c = texCubemapLod<float4>({map}, direction.x, direction.y, direction.z, level);",
        "return Vec3{{c.x, c.y, c.z}};",
    ),
    "split_sum": (
        "float2 c = tex2D<float2>({map}, mu, sqrtf(alpha));",
        "return Vec2{{c.x, c.y}};",
    ),
}
_BODIES: Mapping[str, Mapping[str, Sequence[str]]] = {
    "glsl": _GLSL,
    "essl": _GLSL,
    "hlsl": _HLSL,
    "slang": _HLSL,
    "wgsl": _WGSL,
    "msl": _MSL,
    "cuda": _CUDA,
}
_RESOURCES = {
    "glsl": {
        "environment": "layout(binding = 0) uniform samplerCube {map};",
        "split_sum": "layout(binding = 1) uniform sampler2D {map};",
        "fresnel_table": "layout(binding = 2) uniform sampler2D {map};",
        "distribution_table": "layout(binding = 3) uniform sampler2D {map};",
    },
    "essl": {
        "environment": "uniform highp samplerCube {map};",
        "split_sum": "uniform highp sampler2D {map};",
        "fresnel_table": "uniform highp sampler2D {map};",
        "distribution_table": "uniform highp sampler2D {map};",
    },
    "hlsl": {
        "environment": "TextureCube<float4> {map} : register(t0);",
        "split_sum": "Texture2D<float4> {map} : register(t1);",
        "fresnel_table": "Texture2D<float4> {map} : register(t2);",
        "distribution_table": "Texture2D<float4> {map} : register(t3);",
    },
    "slang": {
        "environment": "TextureCube<float4> {map};",
        "split_sum": "Texture2D<float4> {map};",
        "fresnel_table": "Texture2D<float4> {map};",
        "distribution_table": "Texture2D<float4> {map};",
    },
    "wgsl": {
        "environment": "@group(1) @binding(0) var {map}: texture_cube<f32>;",
        "split_sum": "@group(1) @binding(1) var {map}: texture_2d<f32>;",
        "fresnel_table": "@group(1) @binding(3) var {map}: texture_2d<f32>;",
        "distribution_table": "@group(1) @binding(4) var {map}: texture_2d<f32>;",
    },
    "msl": {
        "environment": "texturecube<float> {map};",
        "split_sum": "texture2d<float> {map};",
    },
    "cuda": {
        "environment": "cudaTextureObject_t {map};  // a cube map with levels",
        "split_sum": "cudaTextureObject_t {map};  // normalized coordinates, clamped",
    },
}
_SAMPLERS = {
    "hlsl": "SamplerState {p}_linear_clamp : register(s0);",
    "slang": "SamplerState {p}_linear_clamp;",
    "wgsl": "@group(1) @binding(2) var {p}_linear_clamp: sampler;",
}


@dataclass(frozen=True)
class Supply:
    """Where a text's lookups come from."""

    textures: bool = True
    """With textures; else the host defines them."""
    tables: Mapping[str, CodedTable] = field(default_factory=dict)
    """Those of F and D by the lookup's name."""
    arrays: bool = False
    """Whether tables stand in the text as arrays, as they always do in C++, CUDA and Metal."""

    def as_array(self, function: Function, language: str) -> bool:
        """Whether a lookup reads an array of the text."""
        return function.plain in self.tables and (self.arrays or language in OBJECTS)


def resources(lookups: Sequence[Function], prefix: str, language: str) -> list[str]:
    """Names of pictures that the host binds, with textures; empty in a language without."""
    lookups = [f for f in lookups if f.table is None]
    if language not in _RESOURCES:
        return []
    apart = language not in OBJECTS
    names = [f"{prefix}_{MAPS[f.plain]}" if apart else MAPS[f.plain] for f in lookups]
    return [*names, *([f"{prefix}_linear_clamp"] if names and language in _SAMPLERS else [])]


def definitions(
    printer: Printer, lookups: Sequence[Function], supply: Supply, stored: buffer.Buffer | None
) -> list[list[str]]:
    """The text about lookups, in blocks: with textures, or what the host has to define; and tables."""
    language, textures = printer.target.name, supply.textures
    if language in OBJECTS:
        return _objects(printer, lookups, textures and language in _BODIES, stored)
    blocks = [] if stored is None else _with_buffer(printer, lookups, stored)
    pictures = [f for f in lookups if f.table is None]
    if textures:
        return [
            *blocks,
            *(_samplers(printer) if pictures else []),
            *(_with_texture(printer, f, supply.tables.get(f.plain)) for f in pictures),
        ]
    return [*blocks, *(_without(printer, f, _head(printer, f)) for f in pictures)]


def _place(function: Function, stored: buffer.Buffer) -> buffer.Placed:
    return next(place for place in stored.placed if place.table is function.table)


def _with_buffer(
    printer: Printer, lookups: Sequence[Function], stored: buffer.Buffer
) -> list[list[str]]:
    """The buffer of tables, and the functions that read it."""
    language, name = printer.target.name, f"{stored.prefix}_tables"
    said = comment((f"All tables, {stored.entries} entries of four numbers: {stored.file}.",))
    blocks = [[*said, buffer.resource(language, stored.prefix, name)]]
    attribute = [printer.target.attribute] if printer.target.attribute else []
    for function in lookups:
        if function.table is not None:
            body = buffer.body(language, name, _place(function, stored), "")
            head = [*comment(function.doc), *attribute, f"{_head(printer, function)} {{"]
            blocks.append([*head, *(INDENT + line for line in body), "}"])
    return blocks


def _head(printer: Printer, function: Function, name: str = "") -> str:
    parameters = [
        printer.target.parameter.format(type=printer.type(kind), name=n)
        for n, kind in function.parameters
    ]
    return printer.target.function.format(
        result=printer.type(function.result),
        name=name or function.name,
        parameters=", ".join(parameters),
    ).removesuffix(" {")


def _samplers(printer: Printer) -> list[list[str]]:
    text = _SAMPLERS.get(printer.target.name)
    if text is None:
        return []
    note = comment(("Linear between texels and levels, clamped at the edges.",))
    return [[*note, text.format(p=printer.prefix)]]


def _filled(
    printer: Printer, function: Function, apart: bool, table: CodedTable | None = None
) -> dict[str, str]:
    name = MAPS[function.plain]
    names = {"map": f"{printer.prefix}_{name}" if apart else name, "p": printer.prefix}
    if table is not None:
        rows, width = table.codes.shape[:2]
        across, down = 1 / width, 1 / rows
        numbers = {"step": 1 - across, "half": across / 2, "down": down, "first": down / 2}
        names |= {name: repr(float(f"{value:.9g}")) for name, value in numbers.items()}
    return names


def _with_texture(printer: Printer, function: Function, table: CodedTable | None) -> list[str]:
    language, names = printer.target.name, _filled(printer, function, True, table)
    body = [line.format(**names) for line in _BODIES[language][function.plain]]
    resource = _RESOURCES[language][function.plain].format(**names)
    doc = (*function.doc, "", *table.meaning()) if table is not None else function.doc
    lines = [resource, "", *comment(doc), f"{_head(printer, function)} {{"]
    return [*lines, *(INDENT + line for line in body), "}"]


def _without(printer: Printer, function: Function, head: str) -> list[str]:
    """A prototype; a comment where the language has none."""
    doc = comment((*function.doc, "The host defines it."))
    prototypes = printer.target.name not in ("wgsl", "slang")
    return [*doc, f"{head};" if prototypes else f"// {head}"]


def object_name(prefix: str, of: str) -> str:
    """The type of an object that has the lookups of a text."""
    return "".join(part.capitalize() for part in prefix.split("_")) + of


def _objects(
    printer: Printer,
    lookups: Sequence[Function],
    textures: bool,
    stored: buffer.Buffer | None,
) -> list[list[str]]:
    """What Host has to be, and one that uses textures and the buffer of tables."""
    language = printer.target.name
    pictures = [f for f in lookups if f.table is None]
    textures = textures and bool(pictures)
    said = ["Host is an object of yours with these methods:"]
    said += [f"    {_head(printer, f, f.plain).replace('inline ', '')} const" for f in lookups]
    if not textures and stored is None:
        return [comment(said)]
    struct = object_name(printer.prefix, "Textures" if textures else "Tables")
    of = "textures" if textures else ""
    if stored is not None:
        of = f"{of} and {stored.file}" if of else stored.file
        if pictures and not textures:
            of += "; those for pictures are yours to add"
    lines = comment([*said, f"such as {struct}, which has them with {of}."])
    guard = language == "cuda" and textures
    lines += ["#ifdef __CUDACC__"] if guard else []
    lines.append(f"struct {struct} {{")
    written = [f for f in lookups if f.table is not None or textures]
    if stored is not None:
        lines.append(INDENT + buffer.resource(language, stored.prefix, ROWS))
    filled = {f.plain: _filled(printer, f, False) for f in pictures}
    for function in pictures if textures else []:
        lines.append(INDENT + _RESOURCES[language][function.plain].format(**filled[function.plain]))
    for function in written:
        head = _head(printer, function, function.plain)
        if function.table is not None and stored is not None:
            vector = printer.type("vec3")
            body = buffer.body(language, ROWS, _place(function, stored), vector)
        else:
            head = head.replace("__host__ __device__ inline", "__device__")
            body = [
                line.format(**filled[function.plain]) for line in _BODIES[language][function.plain]
            ]
        head = head.replace("inline ", "")
        inside = [*comment(function.doc), f"{head} const {{", *(INDENT + b for b in body), "}"]
        lines += ["", *(INDENT + line for line in inside)]
    return [[*lines, "};", *(["#endif"] if guard else [])]]
