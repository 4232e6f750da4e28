"""Code in the ways in which engines write it: structs, macros, globals, classes and conventions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.tolerances import SINGLE

import gonio
from gonio import foreign
from gonio.check.report import NOTE, PASS
from gonio.export.prove import tools
from gonio.foreign import partly, registry, roles, source, sums
from gonio.foreign.function import probe
from gonio.foreign.harness import judged
from gonio.foreign.returned import names_exchanged
from gonio.foreign.rounding import rounded
from gonio.foreign.source import ForeignError

# The rule by which foreign code gets its albedos has some thousand directions.
COARSE = 1e-3

needs_gxx = pytest.mark.skipif(tools.locate("g++") is None, reason="needs g++")


def read(folder: Path, name: str, text: str) -> source.Source:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return source.read(path)


def taken(code: source.Source, name: str) -> dict[str, str]:
    """What each number of a function is taken for."""
    found = roles.match(code, code.find(name), {}, {}, {})
    return {leaf.place: e.text for leaf, e in found.leaves}


def python(folder: Path, text: str) -> foreign.Foreign:
    path = folder / "code.py"
    path.write_text(f"import numpy as np\n{text}", encoding="utf-8")
    return foreign.load(f"{path}#f", returns="f")


def test_colours_of_a_struct_that_is_given_back_are_added_up(tmp_path: Path) -> None:
    text = """
struct Lighting { float3 Diffuse; float3 Specular; float Pdf; };
struct Sample { float3 wi; float3 weight; };
Lighting lit(float3 N, float3 V, float3 L) { Lighting o; return o; }
Sample drawn(float3 N, float3 V, float3 L) { Sample o; return o; }
void writes(float3 N, float3 V, float3 L, inout float alpha, inout float3 d, inout float3 s) { }
"""
    code = read(tmp_path, "a.hlsl", text)
    assert judged(code, code.find("lit")) == ["Diffuse", "Specular"]
    assert judged(code, code.find("writes")) == ["d", "s"]
    assert judged(code, code.find("drawn")) == []  # its weight alone, not the direction


def test_macros_of_textures_and_constant_buffers_are_written_out(tmp_path: Path) -> None:
    (tmp_path / "core.hlsl").write_text("#define SAMPLER(n) SamplerState n\n", encoding="utf-8")
    text = """#include "core.hlsl"
#define PLATFORM_SAMPLE(t, s, uv) t.Sample(s, uv)
#define SAMPLE(t, s, uv) PLATFORM_SAMPLE(t, s, uv)
#define TEXTURE2D(n) Texture2D n
#define CBUFFER_START(name) cbuffer name {
#define CBUFFER_END };
TEXTURE2D(_Map); SAMPLER(sampler_Map);
CBUFFER_START(PerMaterial)
float _Smoothness;
CBUFFER_END
float3 shade(float3 V, float3 L, float2 uv) { return SAMPLE(_Map, sampler_Map, uv).rgb * _Smoothness; }
"""
    code = read(tmp_path, "a.hlsl", text)
    assert code.textures == ("_Map",)
    assert [u.name for u in code.uniforms] == ["_Smoothness"]
    assert code.find("shade").line == text.count("\n")
    assert "gonio_texture__Map.rgb * _Smoothness" in code.text


def test_globals_that_an_entry_point_fills_are_arguments(tmp_path: Path) -> None:
    text = """
vec3 shading_view; vec3 shading_normal;
highp float shading_NoV;
float made_here;
vec3 surface(vec3 L, vec3 tone) {
    made_here = dot(shading_normal, L);
    return tone * made_here * shading_NoV * shading_view.z;
}
"""
    assert taken(read(tmp_path, "a.glsl", text), "surface") == {
        "L": "wi", "tone": "tone", "shading_view": "wo", "shading_normal": "normal", "shading_NoV": "cos_o",
    }  # fmt: skip


def test_members_that_code_does_not_read_are_no_parameters(tmp_path: Path) -> None:
    text = """
struct Inputs { float3 reflectedVector; float3 tone; float unused; };
float3 other(Inputs i) { return i.reflectedVector * i.unused; }
float3 lit(float3 N, float3 V, float3 L, Inputs i) { return i.tone; }
"""
    assert taken(read(tmp_path, "a.hlsl", text), "lit") == {
        "N": "normal", "V": "wo", "L": "wi", "i.tone": "tone",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "high"), [("_Metallic", 1), ("metalness", 1), ("materialIor", 3), ("eta_t", 3)]
)
def test_metallic_is_no_index_of_refraction(tmp_path: Path, name: str, high: float) -> None:
    code = read(tmp_path, "a.glsl", f"float f(vec3 L, vec3 V, float {name}) {{ return {name}; }}")
    assert roles.match(code, code.find("f"), {}, {}, {}).parameters[name].high == high


def test_what_gives_back_closures_is_left_out_and_said(tmp_path: Path) -> None:
    text = """
color fine(vector L, vector V, color tone) { return tone / M_PI; }
closure color helper(color c) { return c * diffuse(N); }
shader principled(color Base = 0.8, output closure color BSDF = 0) { BSDF = Base * diffuse(N); }
surface simple(color Cs = 0.5) { Ci = Cs * diffuse(N); }
"""
    code = read(tmp_path, "a.osl", text)
    assert [f.name for f in code.functions] == ["fine"]
    for name in ("principled", "simple", "helper"):
        with pytest.raises(ForeignError, match=f"{name} gives back a closure"):
            code.find(name)


def test_methods_of_python_and_arrays_of_lights_are_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.py"
    path.write_text("class A:\n    def f(self, wi, wo):\n        return 1\n", encoding="utf-8")
    with pytest.raises(ForeignError, match=r"A\.f is a method"):
        foreign.load(f"{path}#A.f")
    text = """
struct Lamp { vec3 pos; };
uniform Lamp lamps[4];
vec3 lit(vec3 N, vec3 V) { return lamps[0].pos; }
"""
    code = read(tmp_path, "a.glsl", text)
    with pytest.raises(ForeignError, match=r"arrays such as lamps\[4\] cannot be set"):
        roles.match(code, code.find("lit"), {}, {}, {})


@needs_gxx
def test_classes_with_constructors_and_private_members_are_made(tmp_path: Path) -> None:
    text = """
#include <curand_kernel.h>
class Lobe {
  public:
    explicit Lobe(float w) : weight(w) {}
    float scaled() const { return weight; }
  private:
    float weight;
};
class Diffuse {
  public:
    Diffuse(float3 r, Lobe l) : tone(r), lobe(l) {}
    virtual float3 f(float3 wo, float3 wi) const { float w = lobe.scaled() / 3.14159265f;
        return make_float3(tone.x * w, tone.y * w, tone.z * w); }
  private:
    float3 tone; Lobe lobe;
};
"""
    path = tmp_path / "a.cu"
    path.write_text(text, encoding="utf-8")
    code = foreign.load(f"{path}#Diffuse.f", returns="f")
    values = {"tone": (0.8, 0.4, 0.2), "lobe_weight": 0.5}
    found = code.brdf(*probe(4), values)
    assert np.allclose(found, np.array([0.4, 0.2, 0.1]) / np.pi, rtol=SINGLE)


MADE = {
    "cpp": """
struct V { float x, y, z; V(float a = 0, float b = 0, float c = 0) : x(a), y(b), z(c) {} };
struct Base { float scale; explicit Base(float s = 1.0f) noexcept : scale{s} {} };
template <class T> struct Other { T twice; Other(T t) { twice = 2 * t; } };
class Lobe final : public Base {
    float twice, gain = 1;
  public:
    explicit Lobe(V tone = {0.5f, 0.5f, 0.5f}) : Lobe{tone, 1} {}
    Lobe(const V& tone, float k) : Base(tone.y), twice(2 * k) { twice += tone.x; }
    Lobe(const Lobe& other) = default;
    V f(const V& wi, const V& wo) const { return V(twice, scale, gain); }
};
""",
    "slang": """
struct Lobe {
    float twice; float scale; float gain;
    __init(float3 tone, float k) { scale = tone.y; twice = 2 * k + tone.x; gain = 1; }
    float3 f(float3 wi, float3 wo) { return float3(twice, scale, gain) + 0 * wi.x; }
}
""",
}


@pytest.mark.parametrize("ending", MADE)
def test_constructors_that_compute_are_called_with_their_arguments(
    tmp_path: Path, ending: str
) -> None:
    if tools.locate("g++" if ending == "cpp" else "slangc") is None:
        pytest.skip("needs a compiler")
    path = tmp_path / f"a.{ending}"
    path.write_text(MADE[ending], encoding="utf-8")
    code = foreign.load(f"{path}#Lobe.f", returns="f")
    # gain of the C++ class is no business of its constructor, and is set
    assert set(code.parameters) == {"tone", "k"} | ({"gain"} if ending == "cpp" else set())
    found = code.brdf(*probe(4), {"tone": (0.25, 0.5, 0.75), "k": 0.125, "gain": 1})
    assert np.allclose(found, [0.5, 0.5, 1])


def test_light_in_four_numbers_is_a_direction_or_how_bright_it_is(tmp_path: Path) -> None:
    text = """
struct Light { vec4 colorIntensity; vec4 direction; };
vec3 lit(vec4 lightDirection, vec3 viewDir, vec4 baseColor) { return baseColor.rgb * lightDirection.w; }
vec3 all(Light light, vec3 v, vec3 n) { return light.colorIntensity.rgb * light.direction.z; }
"""
    code = read(tmp_path, "a.glsl", text)
    assert taken(code, "lit") == {
        "lightDirection": "wi",
        "viewDir": "wo",
        "baseColor": "baseColor",
    }
    found = taken(code, "all")
    assert found["light.colorIntensity"] == "(1, 1, 1, 1)"
    assert found["light.direction"] == "wi"


def test_roundings_of_parameters_count(tmp_path: Path) -> None:
    code = python(tmp_path, "def f(wi, wo, eta=1.5):\n    return (eta - 1) ** 2 + 0 * wi[:, 0]\n")
    wi, wo = probe(4)
    assert (rounded(code, wi, wo, {"eta": 1.0}).rounding > 0).all()


def test_the_cosine_of_the_viewer_tells_that_names_are_exchanged(tmp_path: Path) -> None:
    assert names_exchanged(python(tmp_path, "def f(wi, wo):\n    return 0.3 * wo[:, 2]\n"))
    assert not names_exchanged(python(tmp_path, "def f(wi, wo):\n    return 0.3 + 0 * wo[:, 2]\n"))
    assert not names_exchanged(python(tmp_path, "def f(wi, wo):\n    return wo[:, 2] ** 3\n"))


@pytest.mark.parametrize(
    ("white", "returns"), [("1.0", "pi f"), ("0.3", "f")], ids=["without 1 / pi", "with it"]
)
def test_a_factor_of_pi_is_told_beside_a_gain_of_energy(
    tmp_path: Path, white: str, returns: str
) -> None:
    # Ten times as bright where it is glossy, which is 10 pi or 3 pi for white
    text = f"""
def f(wi, wo, rho=(0.5, 0.5, 0.5), gloss=0.5):
    return {white} * rho * np.where(gloss > 0.7, 10.0, 1.0)[:, None]
"""
    (tmp_path / "code.py").write_text(f"import numpy as np\n{text}", encoding="utf-8")
    assert str(foreign.load(f"{tmp_path / 'code.py'}#f").returns) == returns


def test_energy_is_judged_where_values_have_digits(tmp_path: Path) -> None:
    # Below m = 0.02 there is nothing but roundings; above, the albedo is 0.3
    text = """
def f(wi, wo, m=0.5, strength=1.0):
    noise = 5 * np.mod(1e9 * wi[:, 0], 1.0)
    return strength * np.where(m < 0.02, noise, 0.3 / np.pi)
"""
    found = foreign.check(python(tmp_path, text), only=["energy"])
    by_name = {f.what: f for r in found for f in r.findings}
    assert by_name["largest albedo"].verdict == PASS
    assert by_name["largest albedo"].measured == pytest.approx(0.3, rel=COARSE)
    assert "values have digits from m = 0.05 on;" in by_name["left out"].text


def test_schlicks_term_with_another_end_at_grazing_angles_is_named(tmp_path: Path) -> None:
    text = """
def f(wi, wo, f0=0.3, f90=0.8, roughness=0.5):
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    a2 = roughness**4
    d = a2 / np.pi / (h[:, 2] ** 2 * (a2 - 1) + 1) ** 2
    x = np.sum(h * wo, axis=1)
    away = 2 ** ((-5.55473 * x - 6.98316) * x)
    l, v = wi[:, 2], wo[:, 2]
    g = 0.5 / (l * np.sqrt(a2 + (1 - a2) * v * v) + v * np.sqrt(a2 + (1 - a2) * l * l))
    return d * g * (f0 + (f90 - f0) * away)
"""
    found = "\n".join(foreign.identify(python(tmp_path, text)).lines())
    assert "GGX, alpha = roughness^2" in found
    assert "Schlick's Fresnel as a spherical Gaussian, F0 = f0, F90 = f90" in found


# Standard surfaces of engines: F0 and F90 after Lagarde and de Rousiers 2014, and terms of a test's own.
SURFACE = """
def parts(wi, wo, a):
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    l, v, a2 = wi[:, 2], wo[:, 2], a * a
    d = a2 / np.pi / (h[:, 2] ** 2 * (a2 - 1) + 1) ** 2
    g = 2 * l * v / (l * np.sqrt(a2 + (1 - a2) * v * v) + v * np.sqrt(a2 + (1 - a2) * l * l))
    return d, g / (4 * l * v), 1 - np.sum(h * wo, axis=1), h[:, 2]

def filament(wi, wo, base=(0.5, 0.5, 0.5), reflectance=0.5, roughness=0.5):
    d, g, x, _ = parts(wi, wo, roughness**2)
    f0 = 0.16 * reflectance**2
    f = f0 + (np.minimum(49.5 * f0, 1) - f0) * x**5
    return base / np.pi + (d * g * f)[:, None]

def unreal(wi, wo, diffuse=(0.5, 0.5, 0.5), f0=(0.5, 0.5, 0.5), roughness=0.5):
    d, g, x, _ = parts(wi, wo, roughness**2)
    f = (1 - x**5)[:, None] * f0 + (np.clip(50 * f0[:, 1], 0, 1) * x**5)[:, None]
    return diffuse / np.pi + (d * g)[:, None] * f

def fresnel(wi, wo, base=(0.5, 0.5, 0.5), specular=0.5, roughness=0.5):
    d, g, x, _ = parts(wi, wo, roughness**2)
    return base / np.pi + (d * g * (0.02 + specular * (1 - np.sqrt(1 - x))))[:, None]

def distribution(wi, wo, f0=(0.5, 0.5, 0.5), roughness=0.5):
    _, g, x, h = parts(wi, wo, roughness**2)
    return (np.exp(-np.sqrt(1 - h) / roughness) * g)[:, None] * (f0 + (1 - f0) * (x**5)[:, None])

def masking(wi, wo, f0=(0.5, 0.5, 0.5), roughness=0.5):
    d, _, x, _ = parts(wi, wo, roughness**2)
    l, v = wi[:, 2], wo[:, 2]
    return (d / (0.1 + roughness * (l + v) + l * v))[:, None] * (f0 + (1 - f0) * (x**5)[:, None])

def two(wi, wo, f0=(0.5, 0.5, 0.5), roughness=0.5):
    _, g, x, h = parts(wi, wo, roughness**2)
    return (np.exp(-np.sqrt(1 - h) / roughness) * g)[:, None] * (f0 + np.sqrt(x)[:, None])
"""


def surface(folder: Path, name: str) -> foreign.Foreign:
    path = folder / "code.py"
    path.write_text(f"import numpy as np\n{SURFACE}", encoding="utf-8")
    return foreign.load(f"{path}#{name}", returns="f", ranges=["roughness=0.2..1"])


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("filament", "F0 = 0.16 reflectance^2, F90 = saturate(dot(F0, 50 * 0.33))"),
        ("unreal", "with F90 = saturate(50 F0) below f0 = 0.02"),
    ],
)
def test_an_f90_that_is_clamped_is_named_in_a_sum(tmp_path: Path, name: str, words: str) -> None:
    found = "\n".join(foreign.identify(surface(tmp_path, name)).lines())
    assert "a sum:" in found
    assert "GGX, alpha = roughness^2; Smith's masking of GGX, height-correlated" in found
    assert words in found


@pytest.mark.parametrize(
    ("name", "kind", "known"),
    [
        ("fresnel", "Fresnel term", ["GGX, alpha = roughness^2", "Smith's masking"]),
        ("distribution", "distribution", ["F0 = f0", "Smith's masking of GGX, height-correlated"]),
        ("masking", "masking", ["GGX, alpha = roughness^2", "F0 = f0"]),
    ],
)
def test_one_term_that_nobody_has_named_leaves_the_others_their_names(
    tmp_path: Path, name: str, kind: str, known: list[str]
) -> None:
    code = surface(tmp_path, name)
    apart = sums.identify(code)
    assert apart is None or not apart.exact
    found = partly.identify(code if apart is None else apart.last)
    assert found is not None
    assert kind in found.kind
    assert all(word in str(found) for word in known)
    for x, y in found.values if name == "fresnel" else ():
        assert y == pytest.approx(0.02 + 0.5 * (1 - np.sqrt(x)), rel=COARSE)
    two = surface(tmp_path, "two")
    assert partly.identify(two) is None


def test_a_model_that_is_bent_to_code_at_every_setting_is_no_answer() -> None:
    names = ("growth", "extent", "tarnish", "alpha")
    bent = registry.Found(gonio.model("patina"), "f", 1e-5, dict.fromkeys(names, "a function of c"))
    assert not bent.exact
    assert registry.Found(bent.model, "f", 1e-5, {"alpha": "a function of c"}).exact


# Lobes whose terms are written out here anew: widths, factors and F0 as engines have them.
OWN_WIDTHS = (
    SURFACE
    + """
def mixed(wi, wo, coat=1.0, r=0.5):
    d, _, x, _ = parts(wi, wo, (0.1 + 0.4 * r) ** 2)
    return coat * d * 0.25 / (1 - x) ** 2 * (0.04 + 0.96 * x**5)

def lights(wi, wo, f0=(0.5, 0.5, 0.5), r=0.5):
    d, g, x, _ = parts(wi, wo, (0.5 + 0.5 * r) ** 2)
    return (d * g)[:, None] * (f0 + (1 - f0) * (x**5)[:, None])

def exponent(wi, wo, gloss=0.5):
    _, _, x, h = parts(wi, wo, np.ones(len(wi)))
    n = 2 ** (1 + 8 * gloss)
    return (n + 2) / (8 * np.pi) * h**n * (0.04 + 0.96 * x**5)

def bare(wi, wo, r=0.5):
    _, _, x, h = parts(wi, wo, np.ones(len(wi)))
    return (1 - h * h) ** (1 / r) * (0.04 + 0.96 * x**5)

def scaled(wi, wo, base=(0.5, 0.5, 0.5), occlusion=0.5, metallic=0.5, weight=0.5):
    return base * (occlusion * weight * (1 - metallic) / np.pi)[:, None]

def index(wi, wo, base=(0.5, 0.5, 0.5), ior=1.5, roughness=0.5):
    d, g, x, _ = parts(wi, wo, roughness**2)
    f0 = ((ior - 1) / (ior + 1)) ** 2
    f = f0 + (1 - f0) * x**5
    return base * ((1 - f) / np.pi)[:, None] + (d * g * f)[:, None]

def exchanged(wi, wo, f0=(0.5, 0.5, 0.5), roughness=0.5):
    d, g, x, _ = parts(wi, wo, roughness**2)
    return (d * g)[:, None] * (1 + (f0 - 1) * (x**5)[:, None])

def cloth(wi, wo, sheen=(0.5, 0.5, 0.5), r=0.5):
    _, _, _, h = parts(wi, wo, np.ones(len(wi)))
    l, v = wi[:, 2], wo[:, 2]
    d = (2 + 1 / r) * (1 - h * h) ** (0.5 / r) / (2 * np.pi)
    return sheen * (d / (4 * (l + v - l * v)))[:, None]
"""
)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("mixed", "GGX, alpha = (0.1 + 0.4 r)^2; Kelemen's masking; Schlick's Fresnel, F0 = 0.04"),
        ("lights", "GGX, alpha = (0.5 + 0.5 r)^2; Smith's masking of GGX, height-correlated"),
        ("exponent", "Blinn-Phong, alpha = sqrt(2 / (n + 2)), n = 2^(1 + 8 gloss); no masking"),
        ("bare", "the factor before the lobe changes with r: its distribution is not normalised"),
        ("scaled", "Lambert; times base occlusion weight (1 - metallic); times 1 / pi"),
        ("index", "1 - Schlick's Fresnel of V.H, F0 = ((ior - 1) / (ior + 1))^2; times base"),
        ("exchanged", "mostly a mistake: Schlick's Fresnel with F0 and F90 exchanged, f0"),
        ("cloth", "Charlie, alpha = r; Neubelt and Pettineo's masking; times sheen"),
    ],
)  # fmt: skip
def test_terms_as_engines_write_them_are_named(tmp_path: Path, name: str, words: str) -> None:
    path = tmp_path / "code.py"
    path.write_text(f"import numpy as np\n{OWN_WIDTHS}", encoding="utf-8")
    head = OWN_WIDTHS.split(f"def {name}(")[1].split("\n")[0]
    ranges = ["roughness=0.2..1", "r=0.1..1", "ior=1..3"]
    used = [r for r in ranges if f" {r.partition('=')[0]}=" in head]
    code = foreign.load(f"{path}#{name}", returns="f", ranges=used)
    found = foreign.identify(code, ["lambert"])
    assert found.exact
    assert words in "\n".join(found.lines())


def test_two_white_colours_of_a_sum_are_no_gain_beside_pi(tmp_path: Path) -> None:
    text = """
def f(wi, wo, diffuse=(0.5, 0.5, 0.5), specular=(0.5, 0.5, 0.5), scale=SCALE):
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    a2, l, v = 0.09, wi[:, 2], wo[:, 2]
    d = a2 / np.pi / (h[:, 2] ** 2 * (a2 - 1) + 1) ** 2
    g = 0.5 / (l * np.sqrt(a2 + (1 - a2) * v * v) + v * np.sqrt(a2 + (1 - a2) * l * l))
    return SCALE * (diffuse / 3.14159 + specular * (d * g)[:, None])
"""
    path = tmp_path / "code.py"
    for scale, returns in (("3.14159", "pi f"), ("1", "f")):
        path.write_text(f"import numpy as np\n{text.replace('SCALE', scale)}", encoding="utf-8")
        assert str(foreign.load(f"{path}#f").returns) == returns


def test_a_number_that_is_no_part_of_reflection_does_not_hide_the_cosine(tmp_path: Path) -> None:
    text = "def f(wi, wo, size=0.2):\n    return (size + wi[:, 2]) / np.pi\n"
    path = tmp_path / "code.py"
    path.write_text(f"import numpy as np\n{text}", encoding="utf-8")
    assert foreign.load(f"{path}#f").returns.cosine == 1


def test_blocks_with_a_name_and_vulkans_sets_are_read(tmp_path: Path) -> None:
    text = """
layout(set = 0, binding = 1) uniform Mat { vec4 base; mat4 view; float rough; } mat;
layout(set = 1, binding = 0) uniform sampler2D lut;
vec3 lit(vec3 N, vec3 V, vec3 L) { return mat.base.rgb * mat.rough * texture(lut, vec2(0.5)).r; }
"""
    code = read(tmp_path, "a.glsl", text)
    assert "set" not in code.text.split("lit")[0]
    assert taken(code, "lit") == {
        "N": "normal",
        "V": "wo",
        "L": "wi",
        "mat.base": "base",
        "mat.rough": "rough",
    }


POINTED = """
#include <cmath>
struct Vec { float x, y, z; };
struct Two { float x, y; };
float f(const Vec* wo, const Vec& wi) { return wi.z > 0 && wo->z > 0 ? 0.318309886f : 0; }
float density(const Vec& wo, const Vec& wi) { return 0.318309886f * wi.z; }
bool drawn(const Vec& wo, Two u, Vec* wi) {
    float r = std::sqrt(u.x), phi = 6.28318531f * u.y;
    *wi = Vec{r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u.x)};
    return true;
}
float weighed(const Vec& wo, Vec* wi, Two u, float* pdf) {
    drawn(wo, u, wi);
    *pdf = density(wo, *wi);
    return 1;
}
"""


@needs_gxx
@pytest.mark.parametrize("sampler", ["drawn", "weighed"])
def test_samplers_write_through_pointers_and_say_whether_there_is_a_sample(
    tmp_path: Path, sampler: str
) -> None:
    path = tmp_path / "a.cpp"
    path.write_text(POINTED, encoding="utf-8")
    code = foreign.load(f"{path}#f", returns="f", sample=sampler, pdf="density")
    sampling = foreign.check(code, only=["sampling"])[-1]
    assert all(f.verdict in (PASS, NOTE) for f in sampling.findings)
    by_name = {f.what: f for f in sampling.findings}
    assert by_name["mean weight off albedo"].verdict == PASS


def test_two_versions_without_a_number_at_one_place_are_equal_there(tmp_path: Path) -> None:
    text = "def f(wi, wo, r=0.5):\n    return 0.3 * r / r * (1 + GAIN * wi[:, 2] ** 2)\n"
    codes = []
    for name, gain in (("a", "0.0"), ("b", "0.5")):
        path = tmp_path / f"{name}.py"
        path.write_text(text.replace("GAIN", gain), encoding="utf-8")
        codes.append(foreign.load(f"{path}#f", returns="f"))
    assert foreign.compare(codes[0], codes[0]).largest == 0
    found = foreign.compare(*codes)
    assert found.largest == pytest.approx(1 / 3, rel=COARSE)  # 0.45 and 0.3 at the normal
