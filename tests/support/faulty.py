"""Shaders with one planted fault, written in each language from one list of statements.

Cook-Torrance with GGX (Walter et al. 2007, Eq. 33), Smith's correlated masking (Heitz 2014, Eq. 99) and
Schlick's Fresnel term; the same with two widths (Burley 2012, Eq. 13; Heitz 2014, Eq. 85); and Oren-Nayar
(1994, Eq. 30 without interreflection). PLANTED changes one or two expressions each.
"""

from __future__ import annotations

from dataclasses import dataclass, field

SPECULAR = {
    "colour": "f0",
    "half": "normalize(L + V)",
    "alpha": "roughness * roughness",
    "distribution": "a2 / (3.14159265 * q * q)",
    "masking": "2.0 * NoL * NoV / (NoV * gi + NoL * go)",
    "fresnel": "VoH",
    "below": "1.0 / (4.0 * NoL * NoV)",
}
STRETCHED = {"along": "X", "across": "Y", "masked_along": "X", "masked_across": "Y"}
DIFFUSE = {"cosine": "dot(L, V)", "part": "clamp(s, 0.0, 1.0)"}


@dataclass(frozen=True)
class Fault:
    """What is changed, and a word of the sentence that has to name it."""

    words: str
    changed: dict[str, str]
    base: dict[str, str] = field(default_factory=lambda: SPECULAR)


PLANTED = {
    "alpha for alpha^2": Fault("GGX, alpha = roughness;", {"alpha": "roughness"}),
    "roughness squared twice": Fault(
        "alpha = roughness^4", {"alpha": "roughness * roughness * roughness * roughness"}
    ),
    "4 for 4 cos cos": Fault("4 where 4 N.L N.V is meant", {"below": "1.0 / 4.0"}),
    "pi twice": Fault("pi twice", {"below": "1.0 / (4.0 * 3.14159265 * NoL * NoV)"}),
    "a cosine is missing below": Fault("N.L is missing below", {"below": "1.0 / (4.0 * NoV)"}),
    "Schlick with N.V": Fault("Fresnel of N.V instead of V.H", {"fresnel": "NoV"}),
    "masking on one side": Fault(
        "on the viewer's side only", {"masking": "2.0 * NoV / (NoV + go)"}
    ),
    "k is not halved": Fault(
        "Schlick's masking, k = alpha,",
        {"masking": "NoL * NoV / ((NoL * (1.0 - a) + a) * (NoV * (1.0 - a) + a))"},
    ),
    "half vector is not normalised": Fault("half vector not normalised", {"half": "L + V"}),
    "sRGB taken as linear": Fault("f0^2.2", {"colour": "power(f0, 2.2)"}),
    "L.V cut at 0": Fault(
        "with L.V cut at 0", {"cosine": "clamp(dot(L, V), 0.0, 1.0)", "part": "s"}, DIFFUSE
    ),
    "swapped tangents": Fault(
        "the tangents of the distribution are swapped", {"along": "Y", "across": "X"}, STRETCHED
    ),
    "swapped tangents of the masking": Fault(
        "the tangents of the masking are swapped",
        {"masked_along": "Y", "masked_across": "X"},
        STRETCHED,
    ),
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


def shader(language: Language, base: dict[str, str] = SPECULAR, **changed: str) -> str:
    """The text of a shader with something changed."""
    use = base | changed
    n, v = language.number, language.vector
    numbers = ["roughness"]
    statements = [
        (n, "NoL", "clamp(dot(N, L), 0.0001, 1.0)"),
        (n, "NoV", "clamp(dot(N, V), 0.0001, 1.0)"),
    ]
    if base is DIFFUSE:
        statements += [
            (n, "s", f"{use['cosine']} - NoL * NoV"),
            (n, "t", "0.5 * (NoL + NoV + sqrt((NoL - NoV) * (NoL - NoV)))"),
            (n, "s2", "roughness * roughness"),
            (n, "A", "1.0 - 0.5 * s2 / (s2 + 0.33)"),
            (n, "B", "0.45 * s2 / (s2 + 0.09)"),
        ]
        result = f"f0 * ((A + B * {use['part']} / t) / 3.14159265)"
    elif base is STRETCHED:
        numbers = ["ax", "ay"]

        def length(x: str, y: str, z: str) -> str:
            return f"sqrt(ax * ax * {x} * {x} + ay * ay * {y} * {y} + {z} * {z})"

        statements += [
            (v, "H", "normalize(L + V)"),
            (n, "NoH", "clamp(dot(N, H), 0.0, 1.0)"),
            (n, "hx", f"dot(H, {use['along']}) / ax"),
            (n, "hy", f"dot(H, {use['across']}) / ay"),
            (n, "q", "hx * hx + hy * hy + NoH * NoH"),
            *((n, f"{w}{a}", f"dot({w}, {use[m]})") for w in "LV" for a, m in AXES),
            (n, "gi", length("Lx", "Ly", "NoL")),
            (n, "go", length("Vx", "Vy", "NoV")),
            (n, "D", "1.0 / (3.14159265 * ax * ay * q * q)"),
        ]
        result = "f0 * (D * 0.5 / (NoV * gi + NoL * go))"
    else:
        statements += [
            (v, "c", use["colour"]),
            (v, "H", use["half"]),
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
        result = "F * (D * G * K)"
    return _written(language, statements, numbers, result, base is STRETCHED)


AXES = (("x", "masked_along"), ("y", "masked_across"))


def _written(
    language: Language,
    statements: list[tuple[str, str, str]],
    numbers: list[str],
    result: str,
    tangents: bool,
) -> str:
    n, v = language.number, language.vector
    given = [(v, "L"), (v, "V"), (v, "N")]
    if language.ending == "brdf" or tangents:
        given += [(v, "X"), (v, "Y")]
    if language.ending != "brdf":
        given += [(v, "f0"), *((n, number) for number in numbers)]
    if language.swift:
        arguments = ", ".join(f"{name}: {kind}" for kind, name in given)
        lines = [f"    let {name} = {value};" for _, name, value in statements]
        head = f"fn {language.name}({arguments}) -> {v} {{"
    else:
        arguments = ", ".join(f"{kind} {name}" for kind, name in given)
        lines = [f"    {kind} {name} = {value};" for kind, name, value in statements]
        head = f"{v} {language.name}({arguments}) {{"
    text = "\n".join([language.prelude, head, *lines, f"    return {result};", "}", ""])
    if language.ending == "brdf":
        declared = "".join(f"float {number} 0.1 1 0.5\n" for number in numbers)
        begin = f"::begin parameters\ncolor f0 0.5 0.5 0.5\n{declared}::end parameters\n"
        text = f"analytic\n{begin}::begin shader\n{text}::end shader\n"
    return text
