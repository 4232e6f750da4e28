"""Models made of the text of a method, exported, run, and compared with what Python computes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.export import Export, export
from gonio.export.prove.runners import RUNNERS
from gonio.materials.model_file import load
from gonio.model import Model

ROWS = 64

# Single precision, after some ten operations on numbers about 1.
NEAR = 2e-5

HEAD = '''"""Mine."""
import functools
import math
from typing import NamedTuple

from gonio import lang
from gonio.lang import *
from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, option, param

{head}


class Mine(Model, register=False):
    """Mine."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "a colour")
    width: Float = param(0.5, 0.1, 1, "a number")
    form: str = option("round", "flat", doc="a choice")
{fields}

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
{body}

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return Sample(wo, 1)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return wi.z
'''


def made(folder: Path, body: str, fields: str = "", head: str = "") -> Model:
    """A model with an eval of its own."""
    path = folder / "mine.py"
    inside = "\n".join("        " + line for line in body.split("\n"))
    more = "\n".join("    " + line for line in fields.split("\n"))
    path.write_text(HEAD.format(body=inside, fields=more, head=head), encoding="utf-8")
    return load(path)()


def rows(export_: Export) -> Any:
    """wi, wo, u and the parameters that the export has."""
    rng = np.random.default_rng(1)
    w = rng.normal(size=(2, ROWS, 3))
    w[..., 2] = np.abs(w[..., 2]) + 0.1
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    given = [rng.uniform(0.1, 1, (ROWS, m.width)) for m in export_.entry.members]
    return np.concatenate([w[0], w[1], rng.uniform(size=(ROWS, 2)), *given], 1).astype(np.float32)


def by_python(model: Model, export_: Export, inputs: Any) -> Any:
    """The values by the model itself."""
    x, column, given = inputs.astype(np.float64), 8, {}
    for member in export_.entry.members:
        value = x[:, column : column + member.width]
        given[member.path] = value if member.width == 3 else value[:, 0]
        column += member.width
    return model.replace(**given).eval(x[:, :3], x[:, 3:6])


def compare(models: Sequence[Model], language: str) -> None:
    """The exports of some models, run, against Python."""
    exports = [
        export({f"mine{i}": model}, language, only=["eval"])[0] for i, model in enumerate(models)
    ]
    inputs = [rows(e) for e in exports]
    results = RUNNERS[language](exports, inputs)
    for model, made_, given, found in zip(models, exports, inputs, results.outputs, strict=True):
        assert isinstance(found, np.ndarray), f"{found}\n{made_.source}"
        right = by_python(model, made_, given)
        assert np.isfinite(right).all()
        off = np.abs(found - right) / (1 + np.abs(right))
        assert off.max() < NEAR, made_.source
