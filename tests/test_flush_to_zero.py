"""GPUs take numbers below 1.2e-38 for 0, and with them the squares of what is below 1.1e-19.

So short are half vectors of opposite directions in the horizon, where models still promise their digits.
The rows below run as C++ on a processor that is told to flush, results and operands, as GPUs do; shaders
written by hand run as GLSL, where llvmpipe keeps the few digits that such numbers have.
"""

from __future__ import annotations

import ctypes
import platform
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.tolerances import SINGLE_PROMISED

import gonio
from gonio.bench import shaders
from gonio.export import export
from gonio.export.entry import Export
from gonio.export.prove import judge
from gonio.export.prove.harness import Results
from gonio.export.prove.native import run_cpp
from gonio.export.prove.opengl import run_glsl
from gonio.export.prove.rows import rows_for
from gonio.model import Model

# What has facets, with every kind of them that D_along is written for
CASES: dict[str, tuple[str, dict[str, object]]] = {
    "ue4": ("ue4", {}),
    "blinn": ("blinn", {}),
    "triace_blinn_phong": ("triace_blinn_phong", {}),
    "triace_layered": ("triace_layered", {}),
    "triace_layered_constants": (
        "triace_layered",
        {"bottom_fresnel": "constant", "top_transmission": "off"},
    ),
    "disney": ("disney", {}),
    "torrance_sparrow": ("torrance_sparrow", {}),
    "blinn_phong": ("torrance_sparrow", {"distribution": "blinn_phong"}),
    "weidlich_wilkie": ("weidlich_wilkie", {"masking": "smith_correlated"}),
    "car_paint": ("car_paint", {}),
    "patina": ("patina", {}),
    "student_t": ("student_t", {}),
}

ROWS = 400


def model_of(case: str) -> Model:
    name, chosen = CASES[case]
    return gonio.model(name, **chosen)


def opposite(model: Model, shader: Export) -> np.ndarray:
    """Opposite directions along y, hardly above the horizon, whose sum is as short and tilted along x."""
    rng = np.random.default_rng(11)
    rows = rows_for(model, shader.entry.members, ROWS)

    def sizes(low: float, high: float) -> np.ndarray:
        return np.exp(rng.uniform(np.log(low), np.log(high), ROWS))

    for start, y in ((0, 1), (3, -1)):
        x = sizes(1e-22, 1e-17) * rng.choice([-1, 1], ROWS)
        rows[:, start : start + 3] = np.stack([x, np.full(ROWS, y), sizes(1.05e-18, 1e-17)], -1)
    return rows


# Bits of x86's MXCSR: results below 1.2e-38 become 0, and operands count as 0.
FLUSH = 0x8000 | 0x0040
CONTROL = """#include <xmmintrin.h>
unsigned get(void) { return _mm_getcsr(); }
void set(unsigned value) { _mm_setcsr(value); }
"""


@pytest.fixture(scope="module")
def run_flushed(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Results]:
    """Runs exports in C++ by a processor that flushes."""
    if platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("the processor is told to flush by a register of x86")
    folder: Path = tmp_path_factory.mktemp("flush")
    (folder / "control.c").write_text(CONTROL, encoding="utf-8")
    library = folder / "control.so"
    command = ["gcc", "-O1", "-shared", "-fPIC", "control.c", "-o", str(library)]
    subprocess.run(command, cwd=folder, check=True)
    control = ctypes.CDLL(str(library))

    @contextmanager
    def flushing() -> Iterator[None]:
        before = control.get()
        control.set(before | FLUSH)
        try:
            yield
        finally:
            control.set(before)

    def run(shaders: list[Export], rows: list[np.ndarray]) -> Results:
        with flushing():
            return run_cpp(shaders, rows)

    return run


def errors(
    model: Model,
    made: list[Export],
    run: Callable[..., Results] = run_glsl,
    method: str = "eval",
) -> list[float]:
    """The largest of each shader over its value, or over a millionth of the usual one."""
    rows = opposite(model, made[0])
    exact = judge.evaluate(model, made[0].entry, method, rows, np.float64)
    size = np.maximum(np.abs(exact), 1e-6 * np.median(np.abs(exact)))
    ran = run(made, [rows] * len(made))
    found = []
    for output in ran.outputs:
        assert isinstance(output, np.ndarray)
        assert np.isfinite(output).all()
        found.append(float((np.abs(output - exact) / size).max()))
    return found


@pytest.mark.parametrize("method", ["eval", "pdf"])
@pytest.mark.parametrize("case", CASES)
def test_exports_keep_their_digits_where_squares_are_flushed(
    case: str, method: str, run_flushed: Callable[..., Results]
) -> None:
    model = model_of(case)
    (found,) = errors(model, export({case: model}, "cpp", only=[method]), run_flushed, method)
    assert found < SINGLE_PROMISED


@pytest.mark.parametrize("case", ["ue4", "triace_layered"])
def test_a_facet_of_squares_is_noticed(case: str, run_flushed: Callable[..., Results]) -> None:
    """As facets would be written without thinking of it: sin^2 and cos^2 of a vector of any length."""
    model = model_of(case)
    (shader,) = export({case: model}, "cpp", only=["eval"])
    slopes = "return t.x * t.x + t.y * t.y;"
    assert shader.source.count(slopes) == 1
    squares = "return t.x == t.x ? (h.x * h.x + h.y * h.y) / (h.z * h.z) : 0.0f;"
    wrong = replace(shader, source=shader.source.replace(slopes, squares))
    found = errors(model, [shader, wrong], run_flushed)
    assert found[0] < SINGLE_PROMISED
    assert found[1] > 30 * SINGLE_PROMISED


def test_hand_written_shaders_keep_them_as_well() -> None:
    """Else they would be cheaper for a promise that they do not keep."""
    for case in ("torrance_sparrow", "disney", "triace_blinn_phong"):
        model = model_of(case)
        found, by_hand = errors(model, [shaders.exported(case), shaders.handwritten(case)])
        assert by_hand < 4 * max(found, SINGLE_PROMISED), case
