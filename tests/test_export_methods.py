"""Whole methods written at random: what Python computes, every language computes, or the exporter refuses.

A grammar writes assignments, loops, branches on options, calls, exchanges and comments, with names from the
reserved lists of all languages. `pytest --long` goes on for minutes in every language; what it has found
stands in test_export_kinds.
"""

from __future__ import annotations

import itertools
import re
import time
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from support.methods import by_python, made, rows

from gonio.export import ExportError, export
from gonio.export.prove.runners import RUNNERS
from gonio.model import Model

# Seconds for each language in the long run, and how many methods are compiled together.
LONG = 60
TOGETHER = 12

# Run as GLSL, and a second time by way of SPIR-V.
WRITTEN_AS = {"spirv": "glsl"}

# Nine of ten rows are nearer than this: a condition that the last bit decides may be any way.
NEAR = 2e-4


def _words(text: str) -> list[str]:
    return text.split()


# Names that some language, Python or the model's file has a meaning of its own for.
NAMES = _words(
    "x y z f u1 wi_ half half_ sample filter mix fract lerp frac saturate asm NULL PI M_PI "
    "EOF NAN bool3 float3 vec3f mat3 vec4 texture sampler buffer input output in_ out inout "
    "uniform varying attribute precise patch shared common flat smooth noise select step sign "
    "abs min max pow round sum len int float range K TWO dot length normalize sqrt sin cos "
    "exp log power select_ minimum fma erf operator template typename namespace virtual "
    "signed unsigned long short union typedef register goto let var fn loop override ref type "
    "alias move mut pub crate self_ super_ this thread kernel device constant vertex fragment "
    "metal technique pass_ matrix vector string color point normal surface shader N P I Ng "
    "time result result_ material made drawn value albedo pdf rough gl_x webgl_x _ _A _b a_ "
    "mine eval linux unix errno near far ddx detach property associatedtype extension none "
    "where yield_ await_ f32 i32 u32 j0 y1 gamma signgam index count params_ rho width form "
    "interface module export_ import_ requires concept"
)

HEAD = '''
K = 0.75  # a number \\\\
TWO = 2


class Pair(NamedTuple):
    """Two values."""

    half: Float
    """The first."""
    sample: Color


def twice(x, k=TWO):
    """k times x \\\\"""
    y = x
    return y * k


def several(x, *, shift=0.25):
    first = x + shift
    # Not equal to the first at x = 1, a direction's square, where < would be a matter of rounding
    second = 1.5 * x * first
    return first, second


def pair(x, v):
    return Pair(x * K, v * x)
'''.replace('\\\\"""', '\\\\\n    """')

FIELDS = """
K2 = 0.5

@property
def soft(self):
    return self.width * self.K2

def _mixed(self, a, b):
    if self.form == "round":
        return a - (b - self.width)
    return a + b
"""

COMMENTS = st.text(
    st.characters(blacklist_characters="\n\r", blacklist_categories=("Cs",)), max_size=30
)


class Scope:
    """The names that a method has so far."""

    def __init__(self) -> None:
        self.floats = [
            "wi.x",
            "wi.z",
            "wo.y",
            "self.width",
            "self.rho.y",
            "self.soft",
            "K",
            "0.5",
            "-1.5",
        ]
        self.vectors = ["wi", "wo", "self.rho", "-wi"]
        self.numbers: list[str] = []  # names of numbers that may get another value
        self.hidden: set[str] = set()


def draw_float(draw: st.DrawFn, scope: Scope, depth: int) -> str:
    """An expression whose value is a number of about 1."""
    if depth == 0:
        return draw(st.sampled_from([n for n in scope.floats if n not in scope.hidden]))
    a, b = draw_float(draw, scope, depth - 1), draw_float(draw, scope, depth - 1)
    v = draw(st.sampled_from(scope.vectors))
    forms = [
        f"({a}) {draw(st.sampled_from('+-*'))} ({b})",
        f"({a}) / (2 + lang.absolute({b}))",
        f"-({a})",
        f"lang.select(({a}) < ({b}), {a}, 1)",
        f"lang.select(~(({a}) < wi.y) & (({b}) > -1) | (wi.x > 0), 0, {b})",
        f"lang.maximum({a}, lang.minimum({b}, TWO))",
        f"lang.sin({a}) * lang.smooth_sqrt(lang.absolute({b}))",
        f"lang.power({a}, {draw(st.sampled_from(['2', '3', '0', '1', '5', '2.0', 'TWO']))})",
        f"lang.dot({v}, wo)",
        f"twice({a})",
        f"twice({a}, k=self.K2)",
        f"pair({a}, {v}).half",
        f"self._mixed({a}, {b})",
        f"({a} if self.form == 'round' else {b})",
        f"lang.clamp({a}, -1, 2**0.5)",
        f"lang.lerp({a}, {b}, 0.25)",
    ]
    return draw(st.sampled_from(forms))


def draw_statement(draw: st.DrawFn, scope: Scope, inside: bool) -> list[str]:
    """Lines of one statement, and what it adds to the scope."""
    kind = draw(st.integers(0, 11))
    name = draw(st.sampled_from(NAMES))
    value = draw_float(draw, scope, draw(st.integers(0, 2)))
    if kind <= 2 or (inside and kind > 7):
        scope.numbers.append(name)
        scope.floats.append(name)
        return [f"{name} = {value}  # {draw(COMMENTS)}"]
    if kind == 3 and scope.numbers:
        return [f"{draw(st.sampled_from(scope.numbers))} {draw(st.sampled_from('+-*'))}= {value}"]
    if kind == 4 and len(scope.numbers) > 1:
        a, b = draw(st.sampled_from(scope.numbers)), draw(st.sampled_from(scope.numbers))
        return [f"{a}, {b} = {b}, {a}"] if a != b else []
    if kind == 5:
        other = draw(st.sampled_from([n for n in NAMES if n != name]))
        scope.floats += [name, other]
        return [f"{name}, {other} = several({value})"]
    if kind == 6 and not inside:
        scope.vectors.append(name)
        return [f"{name} = pair({value}, {draw(st.sampled_from(scope.vectors))}).sample"]
    if kind == 7:
        return [f"# {draw(COMMENTS)}"]
    if kind == 8:
        inner = draw_statement(draw, scope, True) or ["pass"]
        other = draw_statement(draw, scope, True) or ["pass"]
        lines = [f"if self.form == {draw(st.sampled_from(['round', 'flat']))!r}:"]
        return [*lines, *_indented([*inner, "pass"]), "else:", *_indented([*other, "pass"])]
    if kind == 9:
        before = list(scope.floats)
        scope.floats.append(name)
        lines = [line for _ in range(2) for line in draw_statement(draw, scope, True)]
        if draw(st.booleans()):
            scope.floats = before
        return [f"for {name} in range({draw(st.integers(1, 3))}):", *_indented([*lines, "pass"])]
    return [f"{name} = {value}"]


def _indented(lines: list[str]) -> list[str]:
    return ["    " + line for line in lines]


@st.composite
def methods(draw: st.DrawFn) -> str:
    """The body of an eval."""
    scope = Scope()
    lines: list[str] = []
    for _ in range(draw(st.integers(2, 8))):
        lines += draw_statement(draw, scope, False)
    a, b = draw_float(draw, scope, 1), draw_float(draw, scope, 1)
    lines.append(f"v_ = {draw(st.sampled_from(scope.vectors))} * ({a}) + lang.vec3({b}, {a}, 1)")
    # From 0 to 2: pictures, through which OSL's values come, hold no negative ones
    return "\n".join([*lines, "return 1 + v_ / (1 + lang.absolute(v_))"])


counter = itertools.count()


def usable(body: str, folder: Path) -> Model | None:
    """The model, if Python can load and evaluate it."""
    place = folder / f"m{next(counter)}"
    place.mkdir()
    try:
        model = made(place, body, FIELDS, HEAD)
        w = np.array([[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [-0.48, 0.6, 0.64]])
        value = model.eval(w, w[::-1])
    except Exception:
        return None  # not a program at all: a name without a value, a shadowed function
    return model if np.isfinite(value).all() else None


def outcomes(bodies: list[str], language: str, folder: Path) -> list[str]:
    """What became of each method: "same", "refused", or "no program"; else the test fails."""
    found: list[str] = []
    models, exports = [], []
    for body in bodies:
        model = usable(body, folder)
        if model is None:
            found.append("no program")
            continue
        name = f"method{len(exports)}"
        try:
            exports += export({name: model}, WRITTEN_AS.get(language, language), only=["eval"])
        except ExportError as error:
            placed = re.match(r"\S+\.py:\d+:\d+: .+\n.*\n\s*\^+$", str(error))
            found.append("refused" if placed else f"without a place: {error}")
            continue
        models.append(model)
        found.append("same")
    if not exports:
        return found
    inputs = [rows(e) for e in exports]
    results = RUNNERS[language](exports, inputs)
    for model, made_, given_, values in zip(models, exports, inputs, results.outputs, strict=True):
        assert isinstance(values, np.ndarray), f"{values}\n{made_.source}"
        right = by_python(model, made_, given_)
        # Roots and powers of negative numbers have no value in Python either
        has_value = np.isfinite(right).all(1)
        off = np.abs(values - right).max(1) / (1 + np.abs(right).max(1))
        assert np.quantile(off[has_value], 0.9) < NEAR, made_.source
    return found


@pytest.mark.parametrize("language", RUNNERS)
def test_random_methods_mean_the_same_or_are_refused(
    language: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    long = request.config.getoption("--long")
    if not long and language != "cpp":
        pytest.skip("only with --long")
    counts: dict[str, int] = {}
    until = time.monotonic() + (LONG if long else 0)

    @settings(
        max_examples=2,
        deadline=None,
        database=None,
        derandomize=not long,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(st.lists(methods(), min_size=TOGETHER, max_size=TOGETHER))
    def search(bodies: list[str]) -> None:
        for outcome in outcomes(bodies, language, tmp_path):
            counts[outcome] = counts.get(outcome, 0) + 1

    search()
    while time.monotonic() < until:
        search()
    assert set(counts) <= {"same", "refused", "no program"}
    # Else nothing was tried
    assert counts["same"] > counts.get("refused", 0) / 4


def test_functions_of_numbers_alone_have_a_type_in_wgsl(tmp_path: Path) -> None:
    # naga computes most functions of constants itself, but not mix, and refuses one that has no type
    body = (
        "a = lang.lerp(-1.5, K, 0.25) * wi\n"
        "b = lang.maximum(lang.lerp(lang.minimum(K, 2 * K), -K, 0.5), 0.1) * wo\n"
        "return self.rho * lang.lerp(0.5, TWO, 0.25) + a + b + lang.lerp(wi.z, 1, 0.25)"
    )
    assert outcomes([body], "wgsl", tmp_path) == ["same"]


def test_a_printer_that_forgets_a_swap_is_caught(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gonio.export.statements import Body

    body = "a, b = wi.x, wo.y + 2\na, b = b, a\nreturn self.rho * a + b * wi * 0.1 + 1"
    assert outcomes([body], "cpp", tmp_path) == ["same"]

    def one_by_one(self, node, names, value):  # type: ignore[no-untyped-def]
        for name, part in zip(names, value.values, strict=True):
            self._store(node, name, part)

    monkeypatch.setattr(Body, "_unpack", one_by_one)
    with pytest.raises(AssertionError):
        outcomes([body], "cpp", tmp_path)
