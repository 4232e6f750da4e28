"""One microfacet shader with one planted fault, written in each language from one list of statements.

Cook-Torrance with GGX (Walter et al. 2007, Eq. 33), Smith's correlated masking (Heitz 2014, Eq. 99) and
Schlick's Fresnel term; PLANTED changes one expression each.
"""

from __future__ import annotations

from dataclasses import dataclass

RIGHT = {
    "colour": "f0",
    "half": "normalize(L + V)",
    "alpha": "roughness * roughness",
    "distribution": "a2 / (3.14159265 * q * q)",
    "masking": "2.0 * NoL * NoV / (NoV * gi + NoL * go)",
    "fresnel": "VoH",
    "below": "1.0 / (4.0 * NoL * NoV)",
    "result": "F * (D * G * K)",
}

# What is changed, and a word of the sentence that has to name it.
PLANTED: dict[str, tuple[dict[str, str], str]] = {
    "alpha for alpha^2": ({"alpha": "roughness"}, "GGX, alpha = roughness;"),
    "roughness squared twice": (
        {"alpha": "roughness * roughness * roughness * roughness"},
        "alpha = roughness^4",
    ),
    "4 for 4 cos cos": ({"below": "1.0 / 4.0"}, "times 1 / 4"),
    "pi twice": ({"below": "1.0 / (4.0 * 3.14159265 * NoL * NoV)"}, "times 1 / (4 pi)"),
    "a cosine is missing below": ({"below": "1.0 / (4.0 * NoV)"}, "1 / (N.V)"),
    "Schlick with N.V": ({"fresnel": "NoV"}, "Fresnel of N.V instead of V.H"),
    "masking on one side": ({"masking": "2.0 * NoV / (NoV + go)"}, "on the viewer's side only"),
    "half vector is not normalised": ({"half": "L + V"}, "half vector not normalised"),
    "sRGB taken as linear": ({"colour": "power(f0, 2.2)"}, "f0^2.2"),
}


@dataclass(frozen=True)
class Language:
    """How a language writes what the shader needs."""

    ending: str
    number: str
    vector: str
    tool: str
    prelude: str = ""
    name: str = "ggx"
    swift: bool = False
    """Whether types stand behind names, as in WGSL."""


# What C-like languages without vectors of their own need.
_STRUCT = """
#include <cmath>
struct V3 { float x, y, z; };
inline V3 operator+(V3 a, V3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline V3 operator*(V3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline float dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V3 normalize(V3 a) { return a * (1.0f / std::sqrt(dot(a, a))); }
inline float clamp(float x, float low, float high) { return std::fmin(std::fmax(x, low), high); }
inline float fpow(float a, float b) { return std::pow(a, b); }
inline V3 power(V3 a, float b) { return {fpow(a.x, b), fpow(a.y, b), fpow(a.z, b)}; }
inline V3 schlick(V3 f, float w) { return {f.x + (1 - f.x) * w, f.y + (1 - f.y) * w, f.z + (1 - f.z) * w}; }
"""


def _words(vector: str, head: str = "") -> str:
    return (
        f"{head}{vector} power({vector} a, float b) {{ return pow(a, {vector}(b, b, b)); }}\n"
        f"{head}float fpow(float a, float b) {{ return pow(a, b); }}\n"
        f"{head}{vector} schlick({vector} f, float w) {{ return f + ({vector}(1.0, 1.0, 1.0) - f) * w; }}\n"
    )


LANGUAGES = (
    Language("glsl", "float", "vec3", "moderngl", _words("vec3")),
    Language(
        "essl", "float", "vec3", "moderngl",
        "#version 300 es\nprecision highp float;\n" + _words("vec3"),
    ),
    Language("hlsl", "float", "float3", "slangc", _words("float3")),
    Language("slang", "float", "float3", "slangc", _words("float3")),
    Language(
        "metal", "float", "float3", "g++",
        "#include <metal_stdlib>\nusing namespace metal;\n" + _words("float3", "inline "),
    ),
    Language("cpp", "float", "V3", "g++", _STRUCT),
    Language("cu", "float", "V3", "g++", _STRUCT.replace("inline", "__device__ inline")),
    Language("osl", "float", "vector", "g++", _words("vector")),
    Language(
        "wgsl", "f32", "vec3f", "wgpu",
        "fn power(a: vec3f, b: f32) -> vec3f { return pow(a, vec3f(b)); }\n"
        "fn fpow(a: f32, b: f32) -> f32 { return pow(a, b); }\n"
        "fn schlick(f: vec3f, w: f32) -> vec3f { return f + (vec3f(1.0) - f) * w; }\n",
        swift=True,
    ),
    Language("brdf", "float", "vec3", "moderngl", _words("vec3"), "BRDF"),
)  # fmt: skip


def shader(language: Language, **changed: str) -> str:
    """The text of the shader with something changed."""
    use = RIGHT | changed
    n, v = language.number, language.vector
    statements = [
        (v, "c", use["colour"]),
        (v, "H", use["half"]),
        (n, "NoL", "clamp(dot(N, L), 0.0001, 1.0)"),
        (n, "NoV", "clamp(dot(N, V), 0.0001, 1.0)"),
        (n, "NoH", "clamp(dot(N, H), 0.0, 1.0)"),
        (n, "VoH", "clamp(dot(V, H), 0.0, 1.0)"),
        (n, "a", use["alpha"]),
        (n, "a2", "a * a"),
        (n, "q", "NoH * NoH * (a2 - 1.0) + 1.0"),
        (n, "gi", "sqrt(NoL * NoL * (1.0 - a2) + a2)"),
        (n, "go", "sqrt(NoV * NoV * (1.0 - a2) + a2)"),
        (n, "D", use["distribution"]),
        (n, "G", use["masking"]),
        (n, "K", use["below"]),
        (v, "F", f"schlick(c, fpow(1.0 - {use['fresnel']}, 5.0))"),
    ]
    given = [(v, "L"), (v, "V"), (v, "N")]
    parameters = [(v, "f0"), (n, "roughness")]
    if language.ending == "brdf":
        given += [(v, "X"), (v, "Y")]
    else:
        given += parameters
    if language.swift:
        arguments = ", ".join(f"{name}: {kind}" for kind, name in given)
        lines = [f"    let {name} = {value};" for _, name, value in statements]
        head = f"fn {language.name}({arguments}) -> {v} {{"
    else:
        arguments = ", ".join(f"{kind} {name}" for kind, name in given)
        lines = [f"    {kind} {name} = {value};" for kind, name, value in statements]
        head = f"{v} {language.name}({arguments}) {{"
    text = "\n".join([language.prelude, head, *lines, f"    return {use['result']};", "}", ""])
    if language.ending == "brdf":
        begin = "::begin parameters\ncolor f0 0.5 0.5 0.5\nfloat roughness 0.1 1 0.5\n::end parameters\n"
        text = f"analytic\n{begin}::begin shader\n{text}::end shader\n"
    return text
