"""Every model and every material, in every language: compiled, run, and equal to the float64 model.

The exports of a language are compiled and run together, which starts each tool once, and what the models
compute is shared by the languages.
"""

from __future__ import annotations

import functools
import re
import sys
from dataclasses import replace

import pytest

import gonio
from gonio.export import export, printer
from gonio.export.prove import ROWS, each_way, prove, table
from gonio.export.prove.proof import Known
from gonio.export.prove.runners import RUNNERS
from gonio.fields import Option
from gonio.materials import library, load_material
from gonio.model import Model

# Blender's Python package, which has the compiler of OSL, exists for one version of Python.
LANGUAGES = [name for name in RUNNERS if name != "osl" or sys.version_info[:2] == (3, 11)]

# Options and materials change single functions of models that are proven on more rows.
FEWER_ROWS = 2000

KNOWN: Known = {}


@functools.cache
def every_model() -> dict[str, Model]:
    return {name: gonio.model(name) for name in gonio.models()}


@functools.cache
def every_material() -> dict[str, Model]:
    """Materials by name, one of those that have the same models and options; none of a model as it is."""
    kinds: dict[str, tuple[str, Model]] = {}
    for name in library():
        model = load_material(name).model
        kinds.setdefault(kind(model), (name, model))
    as_they_are = [kind(model) for model in every_model().values()]
    return dict(found for kind, found in kinds.items() if kind not in as_they_are)


def kind(model: Model) -> str:
    """Text that models share if they differ in numbers alone."""
    parts = [model.name]
    for name, declared in model.fields.items():
        value = getattr(model, name)
        if isinstance(declared, Option):
            parts.append(f"{name}={value}")
        elif isinstance(value, Model):
            parts.append(f"{name}=({kind(value)})")
    return " ".join(parts)


@functools.cache
def every_option() -> dict[str, Model]:
    """Every choice of every option of every model, one at a time, by a name that says it."""
    found = {}
    for name, cls in gonio.models().items():
        for option, declared in cls.fields.items():
            if isinstance(declared, Option):
                for value in declared.values[1:]:
                    found[f"{name}_{option}_{value}"] = gonio.model(name, **{option: value})
    return found


def proven(models: dict[str, Model], language: str, count: int) -> str:
    """Prove exports; return the names of those that are proven, and fail with the table otherwise."""
    text = "glsl" if language == "spirv" else language
    ways = ((m, w) for name, m in models.items() for w in each_way(*export({name: m}, text)))
    pairs = [(m, w) for m, w in ways if w.language == language]
    proofs = prove(pairs, count, known=KNOWN)
    failed = [p for p in proofs if not p.holds]
    assert not failed, table(failed)
    names = {p.model for p in proofs}
    for name in names:
        assert [p.function for p in proofs if p.model == name] == [
            "eval",
            "sample",
            "pdf",
            "albedo",
        ]
    return names


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_model_is_proven(language):
    assert proven(every_model(), language, ROWS) == set(gonio.models())


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_material_is_proven(language):
    assert proven(every_material(), language, FEWER_ROWS) == set(every_material())


def test_materials_of_one_kind_have_one_code():
    codes: dict[str, list[str]] = {}
    for model in (*every_model().values(), *(load_material(name).model for name in library())):
        (found,) = export({"same": model}, "glsl")
        # Comments say the defaults, which are the material's numbers
        code = re.sub("//.*", "", found.source).split()
        assert codes.setdefault(kind(model), code) == code


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_option_of_every_model_is_proven(language):
    """In C++ and GLSL all of them; the other languages share them among each other."""
    others = [name for name in LANGUAGES if name not in ("cpp", "glsl")]
    chosen = every_option()
    if language in others:
        mine = list(chosen)[others.index(language) :: len(others)]
        chosen = {name: chosen[name] for name in mine}
    assert proven(chosen, language, FEWER_ROWS) == set(chosen)


def test_every_language_of_the_exporter_can_be_proven():
    from gonio.export.targets import TARGETS

    exports = [e for name in TARGETS for e in export({"lambert": gonio.model("lambert")}, name)]
    assert {way.language for e in exports for way in each_way(e)} == set(RUNNERS)


# -------------------------------------------------------------------------- and what is broken, is caught


def without_brackets(monkeypatch):
    right = printer.Printer.expr
    monkeypatch.setattr(printer.Printer, "expr", lambda self, e, level=0: right(self, e))


def with_arms_swapped(monkeypatch):
    right = printer.Printer._select

    def swapped(self, expr):
        condition, yes, no = expr.arguments
        return right(self, replace(expr, arguments=(condition, no, yes)))

    monkeypatch.setattr(printer.Printer, "_select", swapped)


def with_a_wrong_constant(monkeypatch):
    right = printer.number
    monkeypatch.setattr(
        printer,
        "number",
        lambda value, suffix: right(value if value % 1 == 0 else 1.002 * value, suffix),
    )


@pytest.mark.parametrize("language", ["cpp", "wgsl"])
@pytest.mark.parametrize("breaking", [without_brackets, with_arms_swapped, with_a_wrong_constant])
def test_a_broken_printer_is_caught_on_a_real_model(monkeypatch, breaking, language):
    model = gonio.model("burley_diffuse")
    pairs = [(model, e) for e in export({"burley_diffuse": model}, language)]
    assert all(p.holds for p in prove(pairs, FEWER_ROWS))
    breaking(monkeypatch)
    pairs = [(model, e) for e in export({"burley_diffuse": model}, language)]
    wrong = {p.function for p in prove(pairs, FEWER_ROWS) if not p.holds}
    assert wrong
    # Lost brackets also add numbers to colours, which C++ refuses; all else compiles, and is off
    assert "compile" not in wrong or (breaking is without_brackets and language == "cpp")


def test_a_wrong_sum_of_samples_and_a_wrong_promise_are_caught():
    """Albedos without a closed form: the sum is compared with the same sum, and with the integral."""
    model = gonio.model("phong")
    (right,) = export({"phong": model}, "cpp")
    assert right.albedo_tolerance
    assert all(p.holds for p in prove([(model, right)], FEWER_ROWS))
    source, count = re.subn(r"return total / \w+", "return total / 986.0f", right.source)
    assert count == 1
    for wrong, words in (
        (replace(right, source=source), "off in"),
        (replace(right, albedo_tolerance=1e-5), "1e-05 is promised"),
    ):
        (failed,) = [p for p in prove([(model, wrong)], FEWER_ROWS) if not p.holds]
        assert failed.function == "albedo"
        assert words in failed.failure
