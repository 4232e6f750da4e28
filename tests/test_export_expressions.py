"""Random models through every printer, compiler and runtime, against Python's own arithmetic.

A lost bracket, a swapped select or a wrong constant changes most results by more than a hundredth; float32
changes them by a millionth, and more only where a condition is decided by the last bit. So the error that
nine of ten rows stay below tells them apart.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from gonio.export import Export, export
from gonio.export.printer import Printer
from gonio.export.prove.runners import RUNNERS
from gonio.export.targets import TARGETS
from gonio.export.tree import Builtin, Expr, Operation
from gonio.materials.model_file import load
from gonio.model import Model

ROWS = 200

# Nine of ten rows are nearer than this, of values about 1.
NEAR = 2e-4

MODELS = 4

counter = itertools.count()

NUMBERS = st.sampled_from(["0.25", "1", "1.5", "2", "3", "-0.5", "-2", "C1", "C2"])
FLOATS = st.sampled_from(["wi.x", "wi.y", "wi.z", "wo.x", "wo.z", "self.a", "self.b", "self.rho.y"])
VECTORS = st.sampled_from(["wi", "wo", "self.rho", "-wi", "vec3(wi.z, C1, self.a)"])


def floats(depth: int) -> st.SearchStrategy[str]:
    """Text of an expression whose value is a number of about 1."""
    if depth == 0:
        return st.one_of(FLOATS, NUMBERS)
    inner, vector = floats(depth - 1), vectors(depth - 1)
    pair = st.tuples(inner, inner)
    return st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*"]), inner).map(
            lambda t: f"({t[0]}) {t[1]} ({t[2]})"
        ),
        pair.map(lambda t: f"({t[0]}) / (2 + absolute({t[1]}))"),
        inner.map(lambda t: f"-({t})"),
        st.tuples(inner, inner, inner, inner).map(
            lambda t: f"select(({t[0]}) < ({t[1]}) + wi.x, {t[2]}, {t[3]})"
        ),
        st.tuples(inner, inner, inner).map(
            lambda t: (
                f"select(({t[0]} > wi.y) & ~({t[1]} > wi.z) | ({t[1]} - wi.x < {t[2]}), {t[0]}, {t[2]})"
            )
        ),
        pair.map(lambda t: f"minimum({t[0]}, {t[1]})"),
        pair.map(lambda t: f"maximum({t[0]}, {t[1]})"),
        inner.map(lambda t: f"clamp({t}, -1, C2)"),
        st.tuples(inner, inner, FLOATS).map(lambda t: f"lerp({t[0]}, {t[1]}, {t[2]})"),
        inner.map(lambda t: f"sin({t}) + cos({t})"),
        inner.map(lambda t: f"sqrt(1 + absolute({t})) - safe_sqrt({t}) * smooth_sqrt(fract({t}))"),
        st.just("polynomial(wi.x, 1, 2, -0.5, *SERIES)"),
        inner.map(lambda t: f"twice_atan_over(fract({t}))"),
        inner.map(lambda t: f"exp(-absolute({t})) * log(2 + absolute({t}))"),
        inner.map(lambda t: f"power(1 + absolute({t}), 0.3)"),
        inner.map(lambda t: f"safe_asin(0.2 * ({t})) - safe_acos(0.3 * sin({t})) * erf({t})"),
        st.tuples(vector, vector).map(lambda t: f"dot({t[0]}, {t[1]})"),
        vector.map(lambda t: f"length({t} + wi)"),
        vector.map(lambda t: f"helper({t}).y"),
        inner.map(lambda t: f"helper({t})"),
        pair.map(lambda t: f"self._mixed({t[0]}, {t[1]})"),
    )


def vectors(depth: int) -> st.SearchStrategy[str]:
    """Text of an expression whose value is a vector."""
    if depth <= 0:
        return VECTORS
    inner, number = vectors(depth - 1), floats(depth - 1)
    return st.one_of(
        VECTORS,
        st.tuples(inner, st.sampled_from(["+", "-", "*"]), inner).map(
            lambda t: f"({t[0]}) {t[1]} ({t[2]})"
        ),
        st.tuples(number, st.sampled_from(["+", "-", "*"]), inner).map(
            lambda t: f"({t[0]}) {t[1]} ({t[2]})"
        ),
        st.tuples(inner, number).map(lambda t: f"({t[0]}) / (2 + absolute({t[1]}))"),
        st.tuples(number, inner).map(lambda t: f"({t[0]}) / (2 + absolute({t[1]}))"),
        st.tuples(inner, inner).map(lambda t: f"select({t[0]} < {t[1]}, {t[1]}, {t[0]} * 0.5)"),
        st.tuples(number, inner).map(lambda t: f"select({t[0]} > wi.x, {t[1]}, 1)"),
        st.tuples(inner, number).map(lambda t: f"lerp({t[0]}, {t[1]}, 0.3)"),
        inner.map(lambda t: f"maximum({t}, 0.1)"),
        inner.map(lambda t: f"exp(-absolute({t}))"),
    )


BODIES = st.tuples(floats(3), vectors(2), floats(2)).map(
    lambda t: (
        f"p, q = {t[0]}, {t[1]}\n        r = {t[2]}\n        v = q * (p - r) + vec3(p, r, p * r)\n"
        # From 0 to 2: pictures, through which OSL's values come, hold no negative ones
        "        return 1 + v / (1 + absolute(v))"
    )
)

SOURCE = '''
"""A model made of random expressions."""
from gonio.lang import *
from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param

C1 = 0.75  # a number
C2 = 1 + 2 / 3
SERIES = (0.125, -0.03)


def helper(x: Float) -> Float:
    """Twice x, less a bit."""
    twice = x + x
    return twice - (x - C1) * (C2 - x)


class Random(Model, register=False):
    """Random."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "a colour")
    a: Float = param(0.5, -1, 1, "a number")
    b: Float = param(0.5, -1, 1, "a number")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        {body}

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return Sample(vec3(u.x, u.y, 0.5), 1)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return wi.z

    def _mixed(self, x: Float, y: Float) -> Float:
        return x - (y - self.a) * (x - (self.b - y))
'''


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("random")


def made(body: str, folder: Path) -> Model:
    path = folder / f"random_{next(counter)}.py"
    path.write_text(SOURCE.replace("{body}", body), encoding="utf-8")
    return load(path)()


def rows(seed: int) -> Any:
    """wi, wo, u and the parameters rho, a, b."""
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(2, ROWS, 3))
    w[..., 2] = np.abs(w[..., 2]) + 0.05
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    given = rng.uniform(size=(ROWS, 2)), rng.uniform(size=(ROWS, 3)), rng.uniform(-1, 1, (ROWS, 2))
    return np.concatenate([w[0], w[1], *given], 1).astype(np.float32)


# Where the parameters are in a row.
COLUMNS = {"rho": [8, 9, 10], "a": [11], "b": [12]}


def asked(made_: Export, inputs: Any) -> Any:
    """The columns of what the export has: parameters that a body does not read are left out."""
    columns = [c for member in made_.entry.members for c in COLUMNS[member.path]]
    return np.ascontiguousarray(inputs[:, [*range(8), *columns]])


def expected(model: Model, inputs: Any) -> Any:
    """By the model itself in double precision."""
    x = inputs.astype(np.float64)
    bound = model.replace(rho=x[:, 8:11], a=x[:, 11], b=x[:, 12])
    return bound.eval(x[:, :3], x[:, 3:6])


def errors(bodies: list[str], language: str, folder: Path) -> Iterator[tuple[str, float]]:
    """The error that nine of ten rows stay below, for each body."""
    models = [made(body, folder) for body in bodies]
    exports = [
        export({f"random{i}": model}, language, only=["eval"])[0] for i, model in enumerate(models)
    ]
    inputs = [rows(i) for i in range(len(models))]
    given_inputs = [asked(made_, given) for made_, given in zip(exports, inputs, strict=True)]
    results = RUNNERS[language](exports, given_inputs)
    for body, model, given_rows, found in zip(bodies, models, inputs, results.outputs, strict=True):
        assert isinstance(found, np.ndarray), f"{body}: {found}"
        right = expected(model, given_rows)
        off = np.abs(found - right).max(1) / (1 + np.abs(right).max(1))
        yield body, float(np.quantile(off, 0.9))


@pytest.mark.parametrize("language", TARGETS)
def test_random_expressions_mean_the_same_in_every_language(language: str, folder: Path) -> None:
    @settings(
        max_examples=3,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(st.lists(BODIES, min_size=MODELS, max_size=MODELS))
    def check(bodies: list[str]) -> None:
        for body, error in errors(bodies, language, folder):
            assert error < NEAR, body

    check()


# --- printers that are wrong -----------------------------------------------------------------------

TRICKY = [
    "p = (wi.x - (wi.y - wo.z)) * (2 - (self.a - self.b))\n        return self.rho * p",
    "p = select(wi.z < wo.z, self.a, 2 * self.b)\n        return self.rho * p",
    "p = C1 * wi.z - C2 * wo.x\n        return self.rho * p",
]


def other_way_round(original: Callable[..., Any]) -> Callable[..., Any]:
    def select(self: Printer, expr: Builtin) -> Any:
        condition, yes, no = expr.arguments
        return original(self, Builtin("select", (condition, no, yes), expr.type))

    return select


def bracketless_right(original: Callable[..., Any]) -> Callable[..., Any]:
    def operation(self: Printer, expr: Operation) -> Any:
        text, level = original(self, expr)
        right: Expr = expr.right
        if isinstance(right, Operation) and expr.operator == "-":
            text = f"{self.expr(expr.left, level)} - {self.expr(right)}"
        return text, level

    return operation


BREAKAGES: dict[str, tuple[int, Callable[[pytest.MonkeyPatch], None]]] = {
    "a lost bracket": (
        0,
        lambda patch: patch.setattr(Printer, "_operation", bracketless_right(Printer._operation)),
    ),
    "a swapped select": (
        1,
        lambda patch: patch.setattr(Printer, "_select", other_way_round(Printer._select)),
    ),
    "a wrong constant": (
        2,
        lambda patch: [
            patch.setattr(
                f"gonio.export.{module}.number",
                lambda value, suffix: f"{value * 1.001!r}{suffix}",
            )
            for module in ("printer", "print_expressions")
        ],
    ),
}


@pytest.mark.parametrize("language", ["cpp", "glsl", "wgsl"])
@pytest.mark.parametrize("what", BREAKAGES)
def test_a_broken_printer_is_caught(
    what: str, language: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    which, broken = BREAKAGES[what]
    body = TRICKY[which]
    assert next(errors([body], language, folder))[1] < NEAR
    broken(monkeypatch)
    assert next(errors([body], language, folder))[1] > NEAR
