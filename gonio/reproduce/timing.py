"""Times of exported C++ on this processor, for the tables of the texts."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.export import Export
from gonio.export.prove import tools
from gonio.export.prove.tools import ProofError
from gonio.export.text import export
from gonio.model import Model
from gonio.reproduce.measure import random_pairs
from gonio.reproduce.sheet import Sheet

# Pairs of directions, which fit into the first cache, and how often they are evaluated.
PAIRS, ROUNDS, REPEATS = 512, 400, 5

# "maximum optimizations" of the EON paper, on one thread; IEEE semantics are kept.
FLAGS = ("-std=c++17", "-O3", "-march=native", "-ffp-contract=fast", "-fPIC", "-shared", "-w")

# What is timed of each model: the value, a cosine-weighted sample with it, the model's own sample with it.
EVAL, COSINE, OWN = "eval", "cosine sample", "own sample"
WAYS = (EVAL, COSINE, OWN)

Times = Mapping[tuple[str, str], float]
"""Nanoseconds by model and way, less those of an empty loop."""


def measure_times(models: Mapping[str, Model]) -> Times:
    """Compile the exports of models and time them, one thread.

    Raises:
        ProofError: there is no C++ compiler, or an export does not compile.
    """
    compiler = tools.program("g++", "compiles what is timed")
    exports = [
        export({model.name: model}, "cpp", only=("eval", "sample", "pdf"))[0]
        for model in models.values()
    ]
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        for number, one in enumerate(exports):
            (folder / f"{number}.h").write_text(
                one.source.replace(one.entry.namespace, f"timed_{number}"), encoding="utf-8"
            )
        (folder / "main.cpp").write_text(_text(list(models.values()), exports), encoding="utf-8")
        command = [compiler, *FLAGS, "main.cpp", "-o", "timed.so"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ProofError(f"g++ says: {done.stderr.strip().splitlines()[0]}")
        library = ctypes.CDLL(str(folder / "timed.so"))
        found = _run(library, len(exports))
    empty = found[-1]
    return {
        (label, way): found[len(WAYS) * number + k] - empty
        for number, label in enumerate(models)
        for k, way in enumerate(WAYS)
    }


def _run(library: ctypes.CDLL, count: int) -> list[float]:
    wi, wo = random_pairs(PAIRS)
    u = np.random.default_rng(1).random((PAIRS, 8))
    rows = np.ascontiguousarray(np.concatenate([wi, wo, u], axis=1), np.float32)
    times = np.zeros(len(WAYS) * count + 1)
    pointer = ctypes.POINTER(ctypes.c_float)
    library.run(
        rows.ctypes.data_as(pointer),
        ctypes.c_int(PAIRS),
        ctypes.c_int(ROUNDS),
        ctypes.c_int(REPEATS),
        times.ctypes.data_as(ctypes.POINTER(ctypes.c_double)),
    )
    return [float(t) for t in times]


def _text(models: Sequence[Model], exports: Sequence[Export]) -> str:
    """A loop for each model and way; the albedo and the roughness change from pair to pair."""
    includes = "\n".join(f'#include "{n}.h"' for n in range(len(exports)))
    loops = []
    for n, (model, one) in enumerate(zip(models, exports, strict=True)):
        e = one.entry
        space = f"timed_{n}::"
        given = "".join(
            f"        p.{path} = {_number(path, declared.width, value, space)};\n"
            for path, declared, value in model.parameters()
        )
        head = f"        {space}{e.struct} p;\n{given}        {space}Vec3 wo{{x[3], x[4], x[5]}};\n"
        value = f"auto f = {space}{e.prefix}_eval(p, wi, wo); total += f.x + f.y + f.z;"
        bodies = (
            head + f"        {space}Vec3 wi{{x[0], x[1], x[2]}};\n        {value}\n",
            head
            + "        float r = sqrtf(x[6]), phi = 6.2831853f * x[7];\n"
            + f"        {space}Vec3 wi{{r * cosf(phi), r * sinf(phi), sqrtf(1.0f - x[6])}};\n"
            + f"        {value}\n        total += wi.z * 0.31830989f;\n",
            head
            + f"        auto s = {space}{e.prefix}_sample(p, wo, {space}Vec2{{x[6], x[7]}});\n"
            + f"        {space}Vec3 wi = s.wi;\n        {value}\n        total += s.pdf;\n",
        )
        loops += [_loop(len(WAYS) * n + k, body) for k, body in enumerate(bodies)]
    loops.append(_loop(len(WAYS) * len(exports), "        total += x[0] + x[3] + x[6] + x[8];\n"))
    return (
        f"{includes}\n#include <chrono>\n#include <cmath>\n#include <algorithm>\n"
        "static volatile float sink;\n"
        'extern "C" void run(const float* rows, int count, int rounds, int repeats, double* out) {\n'
        + "".join(loops)
        + "}\n"
    )


def _number(path: str, width: int, value: Any, space: str) -> str:
    """A parameter in C++: albedos and roughnesses of a pair of directions, else the model's own number."""
    name = path.rpartition(".")[2]
    if name == "rho":
        return f"{space}Vec3{{x[8], x[9], x[10]}}"
    if name in ("roughness", "sigma"):
        return "x[11]"
    values = value if isinstance(value, tuple) else (value,) * width
    numbers = ", ".join(f"{float(v)!r}f" for v in values)
    return f"{space}Vec3{{{numbers}}}" if width == 3 else numbers


def _loop(place: int, body: str) -> str:
    return (
        "    {\n    double best = 1e30;\n"
        "    for (int repeat = 0; repeat < repeats; ++repeat) {\n"
        "    auto start = std::chrono::steady_clock::now();\n    float total = 0.0f;\n"
        "    for (int round = 0; round < rounds; ++round) {\n"
        "      const float* x = rows;\n"
        '      asm volatile("" : : "r"(x) : "memory");\n'
        "      for (int i = 0; i < count; ++i, x += 14) {\n"
        f"{body}      }}\n    }}\n    sink = total;\n"
        "    std::chrono::duration<double, std::nano> t = std::chrono::steady_clock::now() - start;\n"
        "    best = std::min(best, t.count() / (double(rounds) * count));\n    }\n"
        f"    out[{place}] = best;\n    }}\n"
    )


def show_times(
    sheet: Sheet, models: Mapping[str, Model], printed: Mapping[tuple[str, str], float], why: str
) -> Times | None:
    """Put the text's times beside ours, where there is a compiler; other machines cannot be compared."""
    sheet.lack(why)
    try:
        times = measure_times(models)
    except ProofError as error:
        sheet.remark(str(error))
        return None
    for (label, way), nanoseconds in times.items():
        stated = printed.get((label, way))
        beside = "" if stated is None else f", text {stated:g}"
        if stated is not None or not printed:
            sheet.show(f"{label}, {way} [ns]{beside}", nanoseconds)
    return times


def ratio_of(
    sheet: Sheet,
    what: str,
    text: float | str,
    times: Times | None,
    over: tuple[str, str],
    under: tuple[str, str],
) -> None:
    """The text's ratio of two times beside ours, which depends on the machine and is only shown."""
    if times is not None:
        sheet.show(f"{what}; text {text}", times[over] / times[under])
