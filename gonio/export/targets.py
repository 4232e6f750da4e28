"""One table for each language: types, declarations, spellings, words that cannot be names.

A new language is a new `Target`. What differs in structure, not in spelling (Slang's methods, OSL's
shader), stands in `gonio.export.printer` behind a flag of the target.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from gonio.messages import did_you_mean

# Functions of the vocabulary that graphics languages lack or have too inexact: see gonio.export.library.
SHADER_LIBRARY = frozenset({"safe_acos", "safe_asin", "twice_atan_over", "erf", "erfinv"})


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Of C and C++, whose words and macros any shading language may take up, or the program around a shader.
C_WORDS = _words(
    "alignas alignof and and_eq asm atomic_uint bitand bitor catch char16_t char32_t char8_t class compl "
    "concept consteval constexpr constinit const_cast co_await co_return co_yield decltype delete "
    "dynamic_cast explicit export friend module mutable nan noexcept not not_eq nullptr or or_eq "
    "reinterpret_cast requires static_assert static_cast thread_local typeid typename virtual wchar_t xor "
    "xor_eq union NULL EOF NAN INFINITY HUGE_VAL HUGE_VALF MAXFLOAT PI TAU errno stdin stdout stderr "
    "linux unix i386 VULKAN GL_ES HLSL SLANG TRUE FALSE row_major column_major main "
    "auto bool break case char const continue default do double else enum extern false float for goto "
    "if inline int long namespace new operator private protected public register return short signed "
    "sizeof static struct switch template this throw true try typedef union unsigned using void "
    "volatile while"
)
GLSL_WORDS = C_WORDS | _words(
    "active asm attribute buffer cast centroid class coherent common discard extern external filter "
    "fixed flat fvec2 fvec3 half highp hvec2 hvec3 image1D in inout input interface invariant layout "
    "lowp mat2 mat3 mat4 mediump noinline noperspective out output packed partition patch precise "
    "precision readonly resource restrict sample sampler sampler2D shared smooth subroutine superp "
    "uint uniform uvec2 varying vec2 vec3 vec4 writeonly main"
)
HLSL_WORDS = C_WORDS | _words(
    "AppendStructuredBuffer asm asm_fragment BlendState Buffer ByteAddressBuffer cbuffer centroid "
    "class column_major compile compile_fragment CompileShader ComputeShader ConstantBuffer "
    "ConsumeStructuredBuffer DepthStencilState DepthStencilView discard DomainShader dword export "
    "fxgroup GeometryShader globallycoherent groupshared half HullShader Hullshader in inout "
    "InputPatch interface line lineadj linear LineStream main matrix min10float min12int min16float "
    "min16int min16uint nointerpolation noperspective NULL out OutputPatch packoffset pass payload "
    "pixelfragment PixelShader point PointStream precise RasterizerState register RenderTargetView "
    "row_major RWBuffer RWByteAddressBuffer RWStructuredBuffer RWTexture1D RWTexture1DArray "
    "RWTexture2D RWTexture2DArray RWTexture3D sample sampler SamplerComparisonState SamplerState "
    "shared snorm stateblock stateblock_state string StructuredBuffer SubpassInput SubpassInputMS "
    "tbuffer technique technique10 technique11 texture Texture1D Texture1DArray Texture2D "
    "Texture2DArray Texture2DMS Texture2DMSArray Texture3D TextureCube TextureCubeArray triangle "
    "triangleadj TriangleStream uint uniform unorm unsigned vector vertexfragment VertexShader "
    + " ".join(
        f"{kind}{rows}"
        for kind in ("bool", "int", "uint", "half", "float", "double", "dword")
        for rows in ("1", "2", "3", "4", *(f"{r}x{c}" for r in "1234" for c in "1234"))
    )
)
WGSL_WORDS = C_WORDS | _words(
    "continuing nil varying storage workgroup function "
    "abstract active alias alignas alignof array as asm asm_fragment async atomic attribute auto "
    "await become bitcast cast catch class co_await co_return co_yield coherent column_major common "
    "compile compile_fragment concept const_assert const_cast consteval constexpr constinit crate "
    "debugger decltype delete demote demote_to_helper diagnostic discard dynamic_cast enable explicit "
    "export extends external f16 f32 fallthrough filter final finally fn fixed from fxgroup get "
    "groupshared highp i32 impl implements import instanceof interface invariant is layout let loop "
    "lowp macro macro_rules match mat2x2 mat3x3 mediump meta mod module move mut mutable native "
    "noexcept noinline nointerpolation non_coherent noncoherent noperspective null nullptr of "
    "override package packoffset partition pass patch pixelfragment precise precision premerge priv "
    "ptr pub readonly ref regardless reinterpret_cast require requires resource restrict sampler self "
    "Self set shared smooth snorm static_assert static_cast std subroutine super super target texture "
    "thread_local trait type typeid typename typeof u32 unless unorm unsafe unsized use var vec2 "
    "vec2f vec3 vec3f virtual volatile wgsl where with writeonly yield"
)
MSL_WORDS = C_WORDS | _words(
    "access alignas and array as_type atomic bitand bitor class compl constant constexpr decltype "
    "delete device dispatch explicit export final float2 float3 fragment friend half kernel metal "
    "mutable not noexcept nullptr object or override packed_float3 patch point read sampler sample "
    "stage_in static_assert texture texture2d thread threadgroup threadgroup_imageblock typename uint "
    "vec vertex virtual visible write xor main"
)
SLANG_WORDS = HLSL_WORDS | _words(
    "associatedtype extension func get import let no_diff none module property set This throws "
    "typealias var where __generic __init __subscript"
)
CPP_WORDS = MSL_WORDS | _words(
    "asm catch char16_t char32_t concept consteval const_cast dynamic_cast export final import module "
    "nullptr reinterpret_cast requires static_cast std typeid union virtual wchar_t Vec2 Vec3 Bool3 "
    # Functions of <math.h> that a variable would hide
    "acosf asinf cosf expf fabsf floorf fmaf fmaxf fminf gamma j0 j1 jn log1p logf powf sinf sqrtf y0 "
    "y1 yn"
)
OSL_WORDS = C_WORDS | _words(
    "catch class delete explicit friend varying uniform virtual closure color emit illuminance "
    "illuminate matrix normal output point public shader surface displacement volume string vector "
    "and or not "
    # Variables that every shader has, and functions that a variable of the same name would hide
    "P I N Ng dPdu dPdv Ps u v time dtime dPdtime Ci abs acos asin clamp cos dot exp floor length log "
    "max min mix mod normalize pow sin sqrt erf step cross"
)


@dataclass(frozen=True)
class Target:
    """How one language is written."""

    name: str
    title: str
    extension: str
    types: Mapping[str, str]
    reserved: frozenset[str]
    spellings: Mapping[str, str]
    """By function of the vocabulary; {0}, {1} are the arguments."""
    note: str = ""
    """What a user has to know, for the head of the file."""
    library: frozenset[str] = SHADER_LIBRARY
    suffix: str = ""
    """Of numbers."""
    local: str = "{type} {name} = {value};"
    variable: str = "{type} {name} = {value};"
    """A local that changes."""
    uninitialized: str = "{type} {name};"
    constant: str = "const {type} {name} = {value};"
    function: str = "{result} {name}({parameters}) {{"
    parameter: str = "{type} {name}"
    struct_parameter: str = "{type} {name}"
    """A parameter that is a model's struct."""
    attribute: str = ""
    """A line before every function."""
    value: str = ""
    """What structs and interfaces derive from."""
    member: str = "{type} {name};"
    struct: str = "struct {name}{bases} {{"
    struct_end: str = "};"
    vector: str = "{type}({arguments})"
    splat: str = "{type}({0})"
    splat_plain: str = ""
    """The same for a name or a number; empty: as `splat`."""
    record: str = "{type}({arguments})"
    """A struct from its members; empty if that takes a declaration."""
    select: str = ""
    """Empty: condition ? yes : no."""
    select_computed: str = ""
    """The same where a branch is more than a name, if "condition ? yes : no" would become a jump there."""
    select3: str = ""
    """By a mask of a colour; empty: a helper."""
    comparisons: Mapping[str, str] = field(default_factory=dict)
    """Of vectors, by operator; empty: the operators themselves."""
    loop: str = "for (int {index} = 0; {index} < {count}; ++{index}) {{"
    to_float: str = "float({0})"
    whole: str = "int"
    """The type of whole numbers, which is also its cast."""
    named_counts: bool = True
    """Whether a loop may end at a named number; Slang's derivatives have to see how many steps it has."""
    constants_in_file: bool = False
    """Whether named numbers stand once in the file, in a namespace where they clash with no others."""
    untyped: frozenset[str] = frozenset()
    """Functions that compilers leave undone, and refuse, where all arguments are numbers without a type."""
    mixed: bool = True
    """Whether a vector and a number can be added, multiplied ..."""
    result_struct_members: bool = True
    """Whether members of a call's result can be taken at once: f(x).z"""
    methods: bool = False
    """Whether models are structs with methods, behind an interface."""
    shader: bool = False
    """Whether a text is one shader, with parameters as inputs and values as outputs."""
    helpers: Mapping[str, str] = field(default_factory=dict)
    """Small functions that the language lacks. A spelling with {p}_less takes "less"; C++ takes what its
    operators need."""
    head: str = ""
    foot: str = ""


COMMON: Mapping[str, str] = MappingProxyType(
    {
        "minimum": "min({0}, {1})",
        "maximum": "max({0}, {1})",
        "clamp": "clamp({0}, {1}, {2})",
        "lerp": "mix({0}, {1}, {2})",
        "absolute": "abs({0})",
        "fract": "fract({0})",
        "sqrt": "sqrt({0})",
        "sin": "sin({0})",
        "cos": "cos({0})",
        "exp": "exp({0})",
        "log": "log({0})",
        "power": "pow({0}, {1})",
        "fma": "fma({0}, {1}, {2})",
        "dot": "dot({0}, {1})",
        "length": "length({0})",
        "normalize": "normalize({0})",
    }
)

GLSL_TYPES = {"float": "float", "vec2": "vec2", "vec3": "vec3", "bool": "bool", "bool3": "bvec3"}
HLSL_TYPES = {
    "float": "float",
    "vec2": "float2",
    "vec3": "float3",
    "bool": "bool",
    "bool3": "bool3",
}

GLSL = Target(
    name="glsl",
    title="GLSL 4.5",
    extension="glsl",
    types=GLSL_TYPES,
    reserved=GLSL_WORDS,
    spellings=COMMON,
    select_computed="mix({2}, {1}, {mask}({0}))",
    select3="mix({2}, {1}, {0})",
    comparisons={
        "<": "lessThan({0}, {1})",
        "<=": "lessThanEqual({0}, {1})",
        ">": "greaterThan({0}, {1})",
        ">=": "greaterThanEqual({0}, {1})",
        "==": "equal({0}, {1})",
        "!=": "notEqual({0}, {1})",
    },
)

# OpenGL ES and WebGL 2 have no fma. Its use here is to carry rounding errors along; without it they are 0.
ESSL = replace(
    GLSL,
    name="essl",
    title="GLSL ES 3.00 (WebGL 2)",
    extension="essl",
    spellings={k: v for k, v in COMMON.items() if k != "fma"},
    note="Needs 'precision highp float;'.",
)

HLSL = Target(
    name="hlsl",
    title="HLSL",
    extension="hlsl",
    types=HLSL_TYPES,
    reserved=HLSL_WORDS,
    spellings={
        **COMMON,
        "lerp": "lerp({0}, {1}, {2})",
        "fract": "frac({0})",
        "fma": "mad({0}, {1}, {2})",
    },
    splat="{0}.xxx",
    splat_plain="float3({0}, {0}, {0})",
    record="",
    select3="{p}_select({0}, {1}, {2})",
    helpers={
        "select": """\
float3 {p}_select(bool3 condition, float3 yes, float3 no) {
    return float3(condition.x ? yes.x : no.x, condition.y ? yes.y : no.y, condition.z ? yes.z : no.z);
}
"""
    },
)

WGSL = Target(
    name="wgsl",
    title="WGSL (WebGPU)",
    extension="wgsl",
    types={"float": "f32", "vec2": "vec2f", "vec3": "vec3f", "bool": "bool", "bool3": "vec3<bool>"},
    reserved=WGSL_WORDS,
    spellings=COMMON,
    local="let {name} = {value};",
    variable="var {name} = {value};",
    uninitialized="var {name}: {type};",
    constant="const {name} = {value};",
    function="fn {name}({parameters}) -> {result} {{",
    parameter="{name}: {type}",
    struct_parameter="{name}: {type}",
    member="{name}: {type},",
    struct_end="}",
    select="select({2}, {1}, {0})",
    select3="select({2}, {1}, {0})",
    loop="for (var {index} = 0; {index} < {count}; {index}++) {{",
    to_float="f32({0})",
    whole="i32",
    untyped=frozenset({"lerp"}),  # naga, of wgpu and Firefox; the standard allows it
)

MSL = Target(
    name="msl",
    title="Metal",
    extension="metal",
    types=HLSL_TYPES,
    reserved=MSL_WORDS,
    spellings=COMMON,
    function="inline {result} {name}({parameters}) {{",
    record="{type}{{{arguments}}}",
    select3="select({2}, {1}, {0})",
    head="#include <metal_stdlib>\nusing namespace metal;\n",
)

SLANG = Target(
    name="slang",
    title="Slang",
    extension="slang",
    types=HLSL_TYPES,
    reserved=SLANG_WORDS,
    spellings=HLSL.spellings,
    splat=HLSL.splat,
    splat_plain=HLSL.splat_plain,
    record="",
    select3="select({0}, {1}, {2})",
    named_counts=False,
    methods=True,
    attribute="[Differentiable]",
    value="IDifferentiable",
    helpers={
        "safe_sqrt": """\
// Square root; 0 for negative values, and a finite derivative everywhere.
[Differentiable]
float {p}_safe_sqrt(float x) {
    return x > 0.0 ? sqrt(max(x, 1.0e-30)) : 0.0;
}
""",
        "safe_sqrt3": """\
[Differentiable]
float3 {p}_safe_sqrt3(float3 x) {
    return float3({p}_safe_sqrt(x.x), {p}_safe_sqrt(x.y), {p}_safe_sqrt(x.z));
}
""",
    },
    note="bwd_diff and fwd_diff differentiate every method by its directions and all parameters.",
)


def _per_component(name: str, count: int, spelling: str) -> str:
    """A C++ function on vectors from the one on numbers."""
    names = ["a", "b", "c"][:count]
    parts = [spelling.format(*(f"{n}.{part}" for n in names)) for part in "xyz"]
    parameters = ", ".join(f"Vec3 {n}" for n in names)
    text = f"{{q}}Vec3 {name}({parameters}) {{\n    return Vec3{{{', '.join(parts)}}};\n}}\n"
    return text


_CPP_SPELLINGS = {
    "minimum": "fminf({0}, {1})",
    "maximum": "fmaxf({0}, {1})",
    "clamp": "fminf(fmaxf({0}, {1}), {2})",
    "lerp": "lerp({0}, {1}, {2})",
    "absolute": "fabsf({0})",
    "fract": "fract({0})",
    "sqrt": "sqrtf({0})",
    "safe_acos": "acosf(fminf(fmaxf({0}, -1.0f), 1.0f))",
    "safe_asin": "asinf(fminf(fmaxf({0}, -1.0f), 1.0f))",
    "sin": "sinf({0})",
    "cos": "cosf({0})",
    "exp": "expf({0})",
    "log": "logf({0})",
    "power": "powf({0}, {1})",
    "erf": "erff({0})",
    "fma": "fmaf({0}, {1}, {2})",
    "dot": "dot({0}, {1})",
    "length": "length({0})",
    "normalize": "normalize({0})",
}


def _cpp_helpers() -> dict[str, str]:
    """What C++ needs for vectors: only what a model uses is printed."""
    found = {
        "vec2": "struct Vec2 {\n    float x, y;\n};\n",
        "vec3": "struct Vec3 {\n    float x, y, z;\n};\n",
        "bool3": "struct Bool3 {\n    bool x, y, z;\n};\n",
        "splat": "{q}Vec3 splat(float a) {\n    return Vec3{a, a, a};\n}\n",
        "-vec3": "{q}Vec3 operator-(Vec3 a) {\n    return Vec3{-a.x, -a.y, -a.z};\n}\n",
        "lerp": "{q}float lerp(float a, float b, float t) {\n    return a * (1.0f - t) + b * t;\n}\n",
        "fract": "{q}float fract(float a) {\n    return a - floorf(a);\n}\n",
        "dot": "{q}float dot(Vec3 a, Vec3 b) {\n    return a.x * b.x + a.y * b.y + a.z * b.z;\n}\n",
        "length": "{q}float length(Vec3 a) {\n    return sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);\n}\n",
        "normalize": "{q}Vec3 normalize(Vec3 a) {\n"
        "    float inv = 1.0f / sqrtf(a.x * a.x + a.y * a.y + a.z * a.z);\n"
        "    return Vec3{a.x * inv, a.y * inv, a.z * inv};\n}\n",
        "select3": "{q}Vec3 select(Bool3 c, Vec3 yes, Vec3 no) {\n"
        "    return Vec3{c.x ? yes.x : no.x, c.y ? yes.y : no.y, c.z ? yes.z : no.z};\n}\n",
    }
    for op in "+-*/":
        for left, right in (("Vec3", "Vec3"), ("Vec3", "float"), ("float", "Vec3")):
            a = [f"a.{c}" if left == "Vec3" else "a" for c in "xyz"]
            b = [f"b.{c}" if right == "Vec3" else "b" for c in "xyz"]
            parts = ", ".join(f"{x} {op} {y}" for x, y in zip(a, b, strict=True))
            key = f"{left.lower()}{op}{right.lower()}"
            found[key] = (
                f"{{q}}Vec3 operator{op}({left} a, {right} b) {{\n    return Vec3{{{parts}}};\n}}\n"
            )
    for op in ("<", "<=", ">", ">=", "==", "!="):
        parts = ", ".join(f"a.{c} {op} b.{c}" for c in "xyz")
        found[f"vec3{op}vec3"] = (
            f"{{q}}Bool3 operator{op}(Vec3 a, Vec3 b) {{\n    return Bool3{{{parts}}};\n}}\n"
        )
    counts = {"minimum": 2, "maximum": 2, "clamp": 3, "lerp": 3, "power": 2, "fma": 3}
    for name in (*counts, "absolute", "fract", "sqrt", "sin", "cos", "exp", "log"):
        found[f"{name}3"] = _per_component(name, counts.get(name, 1), _CPP_SPELLINGS[name])
    return found


CPP = Target(
    name="cpp",
    title="C++",
    extension="h",
    types={"float": "float", "vec2": "Vec2", "vec3": "Vec3", "bool": "bool", "bool3": "Bool3"},
    reserved=CPP_WORDS,
    spellings=_CPP_SPELLINGS,
    library=frozenset({"erfinv", "twice_atan_over"}),
    suffix="f",
    constant="constexpr {type} {name} = {value};",
    constants_in_file=True,
    function="inline {result} {name}({parameters}) {{",
    struct_parameter="const {type}& {name}",
    vector="{type}{{{arguments}}}",
    splat="splat({0})",
    record="{type}{{{arguments}}}",
    select3="select({0}, {1}, {2})",
    helpers=_cpp_helpers(),
    head="#pragma once\n#include <math.h>\n\nnamespace {namespace} {{\n",
    foot="\n}}  // namespace {namespace}\n",
)

CUDA = replace(
    CPP,
    name="cuda",
    title="CUDA C++",
    extension="cuh",
    reserved=CPP.reserved
    | _words("blockDim blockIdx gridDim threadIdx warpSize __device__ __host__"),
    function="__host__ __device__ " + CPP.function,
)

OSL = Target(
    name="osl",
    title="Open Shading Language",
    extension="osl",
    types={"float": "float", "vec2": "vector", "vec3": "vector", "bool": "int", "bool3": "vector"},
    reserved=OSL_WORDS,
    spellings={
        **{k: v for k, v in COMMON.items() if k != "fma"},
        "fract": "mod({0}, 1.0)",
        "erf": "erf({0})",
    },
    note="OSL evaluates BRDFs by closures; this shader gives the values themselves.",
    library=SHADER_LIBRARY - {"erf"},
    constant="{type} {name} = {value};",
    vector="vector({arguments})",
    splat="vector({0})",
    record="",
    select3="{p}_select({0}, {1}, {2})",
    comparisons={
        "<": "{p}_less({0}, {1})",
        "<=": "{p}_not_less({1}, {0})",
        ">": "{p}_less({1}, {0})",
        ">=": "{p}_not_less({0}, {1})",
        "==": "{p}_equal({0}, {1})",
        "!=": "{p}_not_equal({0}, {1})",
    },
    result_struct_members=False,
    shader=True,
    helpers={
        "select": """\
// yes where the mask is 1, else no.
vector {p}_select(vector mask_, vector yes, vector no) {
    float x = mask_[0] > 0.5 ? yes[0] : no[0];
    float y = mask_[1] > 0.5 ? yes[1] : no[1];
    float z = mask_[2] > 0.5 ? yes[2] : no[2];
    return vector(x, y, z);
}
""",
        "less": """\
// A mask: 1 where a < b, else 0.
vector {p}_less(vector a, vector b) {
    return vector(a[0] < b[0], a[1] < b[1], a[2] < b[2]);
}
""",
        "not_less": """\
// A mask: 1 where a >= b, else 0.
vector {p}_not_less(vector a, vector b) {
    return vector(a[0] >= b[0], a[1] >= b[1], a[2] >= b[2]);
}
""",
        "equal": """\
// A mask: 1 where a = b, else 0.
vector {p}_equal(vector a, vector b) {
    return vector(a[0] == b[0], a[1] == b[1], a[2] == b[2]);
}
""",
        "not_equal": """\
// A mask: 0 where a = b, else 1.
vector {p}_not_equal(vector a, vector b) {
    return vector(a[0] != b[0], a[1] != b[1], a[2] != b[2]);
}
""",
    },
)

TARGETS: Mapping[str, Target] = MappingProxyType(
    {t.name: t for t in (GLSL, ESSL, HLSL, WGSL, MSL, SLANG, OSL, CPP, CUDA)}
)

# What people say who mean a language: interfaces, programs and platforms that read it, and its full name.
MEANT = MappingProxyType(
    {
        "glsl": "opengl gl vulkan vk spirv opengl_shading_language godot",
        "essl": "webgl gles opengl_es glsl_es three threejs android",
        "hlsl": "directx dx direct3d d3d fx cg unity unreal",
        "wgsl": "webgpu wgpu dawn",
        "msl": "metal metal_shading_language apple ios macos",
        "cpp": "c++ cxx cc c h hpp",
        "cuda": "cuda_c++ cuda_c cu cuh nvidia nvcc nvrtc optix hip",
        "osl": "open_shading_language arnold cycles blender",
        "mtlx": "materialx mx",
    }
)


def did_you_mean_language(name: str, known: Iterable[str]) -> str:
    """As `did_you_mean`, of languages: "metal" is no near spelling of msl, but means it."""
    known, said = list(known), _bare(name)
    for language in known:
        if said in (language, *map(_bare, MEANT.get(language, "").split())):
            return did_you_mean(language, [language])
    return did_you_mean(name.lower(), known)


def _bare(name: str) -> str:
    """A name without its version: WebGL 2 and DX12 are webgl and dx."""
    return re.sub(r"[^a-z+]", "", name.lower())
