"""Hundreds of bodies of eval: refused with file, line and advice, or the same in every language.

tests/export_fixtures/bodies.txt has them; here are those that are made of lists: the words that languages
reserve, as locals, arguments and functions, and every kind of character in a comment. What is accepted is
compiled and compared with Python in the long run (--long); its text is made always.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from support.methods import compare, made

from gonio.export import ExportError, export
from gonio.export.targets import TARGETS

FILE = Path(__file__).parent / "export_fixtures" / "bodies.txt"

# Each language's own words and functions, and what stands in the headers that come with it.
WORDS = {
    "glsl": "active patch precise resource subroutine common partition enum typedef template this packed "
    "goto inline noinline public static external interface long short half fixed unsigned superp input "
    "output hvec2 filter sizeof cast namespace using lowp varying buffer shared invariant discard flat "
    "texture radians degrees inversesqrt faceforward mix step smoothstep mod outerProduct inverse dFdx "
    "barrier noise1 roundEven",
    "wgsl": "alias const_assert diagnostic enable loop switch case f16 vec2f ptr atomic NULL Self abstract "
    "auto become compile concept constexpr demote do dyn export extends final finally friend get handle "
    "impl instanceof macro match module move mut mutable nullptr of pixelfragment premerge ref regardless "
    "require signed snorm std subgroup target throw trait undef unless unorm use virtual wgsl where "
    "workgroup write select saturate bitcast storage uniform function private read",
    "hlsl": "cbuffer tbuffer technique pass stateblock row_major sample centroid linear dword Texture2D "
    "BlendState lerp frac rsqrt mul clip ddx rcp sincos matrix vector line point triangle string register "
    "packoffset numthreads float4x4 globallycoherent min10float SamplerState int3 PointStream",
    "metal": "kernel vertex fragment device constant thread threadgroup metal simd bfloat access coord "
    "as_type vec INFINITY NAN MAXFLOAT M_PI_F fast",
    "cpp and cuda": "alignas bitand bitor compl decltype delete explicit new not_eq operator protected "
    "reinterpret_cast thread_local typeid typename wchar_t xor co_yield EOF errno stdin M_PI INT_MAX "
    "threadIdx warpSize dim3 float3 make_float3 uint32_t size_t y0 j1 gamma div abs exit time signal",
    "osl": "closure color normal illuminance shader surface emit P N I Ng u v dPdu Ci Ps L Cl dtime noise "
    "hash luminance transform rotate Dx area bump aastep spline message trace raytype phong cloth ward "
    "diffuse emission reflection endif",
    "slang": "extension associatedtype property set This throws catch as where func let var no_diff "
    "Differential bwd_diff Optional none Tuple expand each implementing internal typealias countof",
    "python": "print len sum min max round pow range type list str input id vars object complex any map",
}
PLACES: dict[str, Callable[[list[str]], tuple[str, str]]] = {
    "locals": lambda words: (
        "\n".join(f"{w} = wi.{'xyz'[i % 3]} * {i + 1}" for i, w in enumerate(words))
        + f"\nreturn self.rho * (({' + '.join(words)}) / {len(words) ** 2})",
        "",
    ),
    "arguments": lambda words: (
        f"return self.rho * ({' + '.join(f'f{i}(wi.x, 2)' for i in range(len(words)))}) / {len(words)}",
        "\n\n".join(f"def f{i}({w}, k):\n    return {w} * k + {i}" for i, w in enumerate(words)),
    ),
    "functions": lambda words: (
        f"return self.rho * ({' + '.join(f'{w}(wi.x)' for w in words)}) / {len(words) ** 2}",
        "\n\n".join(f"def {w}(x):\n    return x * {i} + 1" for i, w in enumerate(words)),
    ),
}
COMMENTS = {
    "ends of comments": "*/ x = 1; /* --> ]]> #endif \"\"\" '''",
    "directives": "#define X 1 #pragma once #version 100 @import #include <x> // /*",
    "formats": "%s {0} {x} %(a)s $x ${y} `q` {rho} \\alpha \\n \\u0041 <b>&amp;",
    "a backslash": "ends \\",
    "a trigraph": "what??/",
    "control characters": "a\x07b\x7fc\x1cd\x1de\x1ef\x0bg\x0ch\ti",
    "other ends of lines": "one\x85two\u2028three\u2029four",
    "other directions": "one\u202etwo\u200dthree\ufeff\U0001f600",
    "a long word": "w" * 400 + " and more" * 40,
}


def from_file() -> dict[str, tuple[str, str, str, str]]:
    """Outcome, body, fields and head of each body of the file, by name."""
    found = {}
    for part in FILE.read_text(encoding="utf-8").split("\n=== ")[1:]:
        title, _, rest = part.partition("\n")
        name, _, outcome = title.rpartition(": ")
        body, _, head = rest.rstrip("\n").partition("\n--- head\n")
        body, _, fields = body.partition("\n--- fields\n")
        assert name not in found, name
        found[name] = (outcome, body, fields, head)
    return found


def from_lists() -> dict[str, tuple[str, str, str, str]]:
    """Reserved words in three places, and characters in comments."""
    found = {}
    for language, text in WORDS.items():
        words = [w for w in dict.fromkeys(text.split()) if not keyword.iskeyword(w)]
        for place, make in PLACES.items():
            body, head = make(words)
            found[f"words of {language} as {place}"] = ("same", body, "", head)
    for name, text in COMMENTS.items():
        body = f"# {text}\nx = self.width * wi.z  # {text}\nreturn self.rho * x"
        found[f"a comment with {name}"] = ("same", body, "", "")
    return found


BODIES = from_file() | from_lists()
REFUSED = [name for name, case in BODIES.items() if case[0] == "refused"]
SAME = [name for name, case in BODIES.items() if case[0] == "same"]


def test_bodies_that_no_shader_can_have_are_refused_with_line_and_advice(tmp_path: Path) -> None:
    assert len(REFUSED) > 150
    for name in REFUSED:
        model = made(tmp_path, *BODIES[name][1:])
        with pytest.raises(ExportError) as error:
            export({"mine": model}, "glsl", only=["eval"])
        text = str(error.value)
        first = text.partition("\n")[0]
        assert re.match(r"\S*mine\.py:\d+:\d+: .{15,}\.\s*$", first), (name, text)
        assert "^" in text, (name, text)  # the caret below the line


def test_the_other_bodies_are_accepted(tmp_path: Path) -> None:
    assert len(SAME) > 120
    for name in SAME:
        model = made(tmp_path, *BODIES[name][1:])
        assert export({"mine": model}, "wgsl", only=["eval"])[0].source, name


def test_bodies_mean_the_same_in_every_language(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """In the short run a dozen of them, in C++ alone."""
    long = request.config.getoption("--long")
    models = []
    for number, name in enumerate(SAME if long else SAME[::16]):
        folder = tmp_path / str(number)
        folder.mkdir()
        models.append(made(folder, *BODIES[name][1:]))
    for language in TARGETS if long else ["cpp"]:
        compare(models, language)
