"""Derivatives that slangc makes of Slang exports, beside those of Dr.Jit."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np
import pytest
from support.directions import random_directions

import gonio
from gonio.export import export
from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import GIVEN, input_columns
from gonio.export.prove.native import FLAGS

ROWS = 100

# Of float32 in another order of operations: what differs by more, differs by a formula.
SINGLE_DERIVED = 1e-3

pytestmark = pytest.mark.skipif(tools.locate("slangc") is None, reason="needs slangc")


def places(made: Export) -> dict[str, tuple[int, int, str]]:
    """Column, width and name of every parameter that the export has, by its path."""
    found, column = {}, GIVEN
    for member in made.entry.members:
        found[member.path] = (column, member.width, member.name)
        column += member.width
    return found


def program(made: Export) -> str:
    """The export and a loop that writes the derivatives of the sum of each method's numbers."""
    entry, columns = made.entry, input_columns(made.entry)

    def read(column: int, width: int) -> str:
        numbers = ", ".join(f"x[i + {column + k}]" for k in range(width))
        return numbers if width == 1 else f"float{width}({numbers})"

    body = [f"{entry.struct} params;"]
    for column, width, name in places(made).values():
        body.append(f"params.{name} = {read(column, width)};")
    given = {"wi": (0, 3), "wo": (3, 3), "u": (6, 2)}
    calls = {
        "eval": (("wi", "wo"), "float3(1, 1, 1)"),
        "sample": (("wo", "u"), "one"),
        "pdf": (("wi", "wo"), "1.0"),
    }
    body.append(f"{entry.sample_struct}.Differential one;")
    body += ["one.wi = float3(1, 1, 1);", "one.pdf = 1.0;"]
    for number, (method, (names, seed)) in enumerate(calls.items()):
        out = [(f"{n}.d", *given[n]) for n in names]
        out += [(f"p.d.{name}", column, width) for column, width, name in places(made).values()]
        body += ["{", "var p = diffPair(params);"]
        body += [f"var {n} = diffPair({read(*given[n])});" for n in names]
        body.append(f"bwd_diff({entry.struct}.{method})(p, {', '.join(names)}, {seed});")
        for text, column, width in out:
            parts = [""] if width == 1 else [f".{c}" for c in "xyz"[:width]]
            for k, part in enumerate(parts):
                body.append(f"y[3 * i + {number * columns + column + k}] = {text}{part};")
        body.append("}")
    loop = f"for (int row = 0; row < {ROWS}; ++row) {{\nint i = row * {columns};\n"
    return (
        f"{made.source}\nexport __extern_cpp void run(float* x, float* y)\n{{\n"
        + loop
        + "\n".join(body)
        + "\n}\n}\n"
    )


def by_slang(folder: Path, made: Export, inputs: Any) -> Any:
    (folder / "x.slang").write_text(program(made), encoding="utf-8")
    slangc, gxx = tools.program("slangc", "compiles Slang"), tools.program("g++", "compiles C++")
    for command in (
        [slangc, "x.slang", "-target", "cpp", "-o", "x.cpp"],
        [gxx, *FLAGS, "-w", "x.cpp", "-o", "x.so"],
    ):
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[:2000]
    outputs = np.zeros((ROWS, 3 * inputs.shape[1]), np.float32)
    pointer = ctypes.POINTER(ctypes.c_float)
    run = ctypes.CDLL(str(folder / "x.so")).run
    run.argtypes, run.restype = [pointer, pointer], None
    run(inputs.ctypes.data_as(pointer), outputs.ctypes.data_as(pointer))
    return outputs


def by_drjit(made: Export, model: gonio.Model, inputs: Any) -> Any:
    Number, Vector, Pair = dr.llvm.ad.Float, dr.llvm.ad.Array3f, dr.llvm.ad.Array2f
    found = []
    for method in ("eval", "sample", "pdf"):
        x = [Number(np.ascontiguousarray(c)) for c in inputs.T]
        dr.enable_grad(x)

        def convert(path: str, parameter: Any, value: Any, x: Sequence[Any] = x) -> Any:
            if path not in places(made):
                return Number(value) if parameter.width == 1 else Vector(value)
            column, width, _ = places(made)[path]
            return x[column] if width == 1 else Vector(*x[column : column + 3])

        bound, wo = model.bind(Number, convert), Vector(*x[3:6])
        if method == "sample":
            wi, pdf = bound.sample(wo, Pair(*x[6:8]))
            total = dr.sum(wi) + pdf
        else:
            value = getattr(bound, method)(Vector(*x[:3]), wo)
            total = dr.sum(value) if method == "eval" else value
        dr.backward(total)
        found.append(np.stack([dr.grad(v).numpy() * np.ones(len(inputs)) for v in x], -1))
    return np.concatenate(found, -1)


@pytest.mark.parametrize("name", ["eon", "weidlich_wilkie"])
def test_every_method_has_the_derivatives_that_dr_jit_has(name: str, tmp_path: Path) -> None:
    model = gonio.model(name)
    made = export({name: model}, "slang", only=("eval", "sample", "pdf"))[0]
    rng = np.random.default_rng(5)
    inputs = np.zeros((ROWS, input_columns(made.entry)), np.float32)
    inputs[:, :3], inputs[:, 3:6] = random_directions(ROWS, 1), random_directions(ROWS, 2)
    inputs[:, 6:8] = rng.random((ROWS, 2))
    declared = {path: parameter for path, parameter, _ in model.parameters()}
    for path, (column, width, _) in places(made).items():
        low = declared[path].lowest
        high = min(declared[path].highest, low + 2)
        inputs[:, column : column + width] = low + (high - low) * rng.uniform(
            0.1, 0.9, (ROWS, width)
        )
    inputs[0, :6] = 0, 0, 1, 0, 0, 1  # where roots of 0 are taken
    found, expected = by_slang(tmp_path, made, inputs), by_drjit(made, model, inputs)
    assert np.isfinite(found).all()
    # Derivatives at the normal itself depend on the side
    scale = np.abs(expected[1:]).max(0)
    assert (scale > 0).sum() > len(scale) / 2
    off = np.abs(found - expected)[1:] / (np.abs(expected[1:]) + SINGLE_DERIVED * scale + 1e-6)
    assert off.max() < 3 * SINGLE_DERIVED
    assert np.quantile(off, 0.95) < SINGLE_DERIVED / 10
