"""GLSL for NVIDIA's compiler: the same text as C++ with GLSL's types, operators and functions.

So an export and a shader written by hand go the same way, and only what stands in them differs.
"""

from __future__ import annotations

import re

from gonio.cost.program import Program
from gonio.export.entry import Export
from gonio.export.prove import opengl
from gonio.export.prove.harness import indented, input_columns, output_columns, statements

OPTIONS = ("--device-as-default-execution-space", "--std=c++20")
"""Functions and constants without a word are the GPU's; structs are made as `Name(a, b)`."""

# A number with a point or an exponent is single precision in GLSL.
NUMBER = re.compile(r"(?<![\w.])(\d+\.\d*(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.])")
SWIZZLE = re.compile(r"\.([xyz]{2,3})\b(?!\()")

# What shaders in gonio/bench/handwritten and exports beside them use; what is missing, NVRTC names.
TYPES = """
struct vec2 {
    float x, y;
    vec2() = default;
    vec2(float s) : x(s), y(s) {}
    vec2(float a, float b) : x(a), y(b) {}
    vec2 xy() const { return vec2(x, y); }
    vec2 yx() const { return vec2(y, x); }
};
struct bvec3 { bool x, y, z; };
struct vec3 {
    float x, y, z;
    vec3() = default;
    vec3(float s) : x(s), y(s), z(s) {}
    vec3(float a, float b, float c) : x(a), y(b), z(c) {}
    vec3(vec2 v, float c) : x(v.x), y(v.y), z(c) {}
    vec2 xy() const { return vec2(x, y); }
    vec2 yx() const { return vec2(y, x); }
};
"""
OPERATORS = "+-*/"
FUNCTIONS = """
float mix(float a, float b, float t) { return a + t * (b - a); }
float clamp(float v, float low, float high) { return min(max(v, low), high); }
float dot(vec2 a, vec2 b) { return a.x * b.x + a.y * b.y; }
float dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
float length(vec2 v) { return sqrt(dot(v, v)); }
float length(vec3 v) { return sqrt(dot(v, v)); }
vec3 normalize(vec3 v) { return v * rsqrtf(dot(v, v)); }
float inversesqrt(float v) { return rsqrtf(v); }
bvec3 greaterThan(vec3 a, vec3 b) { return bvec3{a.x > b.x, a.y > b.y, a.z > b.z}; }
bvec3 lessThan(vec3 a, vec3 b) { return greaterThan(b, a); }
vec3 mix(vec3 a, vec3 b, bvec3 t) { return vec3(t.x ? b.x : a.x, t.y ? b.y : a.y, t.z ? b.z : a.z); }
vec3 mix(vec3 a, vec3 b, vec3 t) { return a + t * (b - a); }
vec3 mix(vec3 a, vec3 b, float t) { return a + vec3(t) * (b - a); }
vec3 max(vec3 a, float b) { return max(a, vec3(b)); }
vec3 min(vec3 a, float b) { return min(a, vec3(b)); }
vec3 clamp(vec3 v, float low, float high) { return min(max(v, low), high); }
"""


def _vectors() -> str:
    """Operators and functions of each component."""
    lines = []
    for kind, parts in (("vec2", "xy"), ("vec3", "xyz")):
        for sign in OPERATORS:
            both = ", ".join(f"a.{c} {sign} b.{c}" for c in parts)
            lines.append(f"{kind} operator{sign}({kind} a, {kind} b) {{ return {kind}({both}); }}")
            # A plain number is every component, by the constructor
            lines.append(
                f"{kind}& operator{sign}=({kind}& a, {kind} b) {{ return a = a {sign} b; }}"
            )
        lines.append(f"{kind} operator-({kind} a) {{ return {kind}(0.0f) - a; }}")
        for name in ("sqrt", "exp", "log", "abs"):
            of = ", ".join(f"{name}(a.{c})" for c in parts)
            lines.append(f"{kind} {name}({kind} a) {{ return {kind}({of}); }}")
        of = ", ".join(f"fma(a.{c}, b.{c}, d.{c})" for c in parts)
        lines.append(f"{kind} fma({kind} a, {kind} b, {kind} d) {{ return {kind}({of}); }}")
        for name in ("min", "max", "pow"):
            of = ", ".join(f"{name}(a.{c}, b.{c})" for c in parts)
            lines.append(f"{kind} {name}({kind} a, {kind} b) {{ return {kind}({of}); }}")
    return "\n".join(lines)


def translated(glsl: str) -> str:
    """GLSL's functions as C++ that `TYPES` and `FUNCTIONS` stand before."""
    return SWIZZLE.sub(r".\1()", NUMBER.sub(r"\1f", glsl))


def kernel(shader: Export, label: str) -> Program:
    """`eval` of a GLSL export, or of what has its names, as a program for NVIDIA's GPUs."""
    entry = shader.entry
    header = f"{TYPES}{_vectors()}{FUNCTIONS}\n{translated(shader.source)}\n"
    lines = translated(indented(statements(entry, opengl.GLSL)))
    text = (
        '#include "export.h"\n\n'
        'extern "C" __global__ void run(const float* x, float* y, int rows) {\n'
        "    int row = blockIdx.x * blockDim.x + threadIdx.x;\n"
        "    if (row >= rows) {\n        return;\n    }\n"
        f"    int i = row * {input_columns(entry)};\n"
        f"    int o = row * {output_columns(entry)};\n"
        f"{lines}\n}}\n"
    )
    return Program(label, "", cuda=(header, text))
