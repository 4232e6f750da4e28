"""Code in the ways in which engines write it: structs, macros, globals, classes and conventions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.tolerances import SINGLE

from gonio import foreign
from gonio.check.report import PASS
from gonio.export.prove import tools
from gonio.foreign import roles, source
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
    energy = next(f for r in found for f in r.findings if f.what == "largest albedo")
    assert energy.verdict == PASS
    assert energy.measured == pytest.approx(0.3, rel=COARSE)
    assert energy.text.endswith("; from m = 0.05 on, as values have no digits beyond")


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
