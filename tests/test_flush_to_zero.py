"""GPUs take numbers below 1.2e-38 for 0, and with them the squares of what is below 1.1e-19.

So short are half vectors of opposite directions in the horizon, where models still promise their digits.
The rows below run as GLSL, on what is seen to flush.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.tolerances import SINGLE_PROMISED

import gonio
from gonio.bench import shaders
from gonio.export import export
from gonio.export.entry import Export
from gonio.export.prove import judge
from gonio.export.prove.opengl import run_glsl
from gonio.export.prove.rows import rows_for
from gonio.model import Model

# What has facets, with every kind of them that D_along is written for
CASES: dict[str, tuple[str, dict[str, object]]] = {
    "ue4": ("ue4", {}),
    "blinn": ("blinn", {}),
    "triace_blinn_phong": ("triace_blinn_phong", {}),
    "disney": ("disney", {}),
    "torrance_sparrow": ("torrance_sparrow", {}),
    "blinn_phong": ("torrance_sparrow", {"distribution": "blinn_phong"}),
    "weidlich_wilkie": ("weidlich_wilkie", {"masking": "smith_correlated"}),
    "car_paint": ("car_paint", {}),
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
        rows[:, start : start + 3] = np.stack([x, np.full(ROWS, y), sizes(1.05e-18, 1e-16)], -1)
    return rows


def errors(model: Model, made: list[Export]) -> list[float]:
    """The largest of each shader over its value, or over a millionth of the usual one."""
    rows = opposite(model, made[0])
    exact = judge.evaluate(model, made[0].entry, "eval", rows, np.float64)
    size = np.maximum(np.abs(exact), 1e-6 * np.median(np.abs(exact)))
    ran = run_glsl(made, [rows] * len(made))
    found = []
    for output in ran.outputs:
        assert isinstance(output, np.ndarray)
        assert np.isfinite(output).all()
        found.append(float((np.abs(output - exact) / size).max()))
    return found


@pytest.mark.parametrize("case", CASES)
def test_exports_keep_their_digits_where_squares_are_flushed(case: str) -> None:
    model = model_of(case)
    (found,) = errors(model, export({case: model}, "glsl", only=["eval"]))
    assert found < ALLOWED.get(case, SINGLE_PROMISED)


# llvmpipe's exp and log, of exponents up to some hundreds
ALLOWED = {"triace_blinn_phong": 1e-4, "blinn": 1e-3, "blinn_phong": 1e-3, "disney": 1e-5}


def test_a_facet_of_squares_is_noticed() -> None:
    """As D_along would be written without thinking of it: sin^2 and cos^2 of a vector of any length."""
    model = model_of("ue4")
    (shader,) = export({"ue4": model}, "glsl", only=["eval"])
    slopes = "return t.x * t.x + t.y * t.y;"
    assert shader.source.count(slopes) == 1
    squares = "return (h.x * h.x + h.y * h.y) / (h.z * h.z);"
    right, wrong = errors(
        model, [shader, replace(shader, source=shader.source.replace(slopes, squares))]
    )
    assert right < SINGLE_PROMISED
    assert wrong > 30 * SINGLE_PROMISED


def test_hand_written_shaders_keep_them_as_well() -> None:
    """Else they would be cheaper for a promise that they do not keep."""
    for case in ("torrance_sparrow", "disney", "triace_blinn_phong"):
        model = model_of(case)
        found, by_hand = errors(model, [shaders.exported(case), shaders.handwritten(case)])
        assert by_hand < 4 * max(found, SINGLE_PROMISED), case
