"""gonio/__init__.pyi: it is what the models' fields say, and a type checker finds mistakes by it."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

import gonio

ROOT = Path(__file__).parent.parent

USE = """
import numpy as np
import gonio

gonio.EON(roughness=1, rho=(0.8, 0.3, 0.1), albedo_form="fitted")
gonio.EON(roughness=np.linspace(0, 1, 5), rho=np.ones((5, 3), np.float32))
gonio.WeidlichWilkie(base=gonio.QON(sigma=np.float32(0.5)), eta=1.33, interface="smooth")
gonio.WeidlichWilkie(base="eon").replace(alpha=0.2).eval(0, 0)
gonio.check.check_model(gonio.EON).sort()
gonio.conversions.alpha_from_perceptual(0.5)
gonio.render(gonio.model("eon"), size=(8, 8)).mean()
gonio.EON(roughnes=1)
gonio.EON(roughness="rough")
gonio.EON(albedo_form="fited")
gonio.EON(0.5)
gonio.Eon()
gonio.tekstures
"""
WRONG = USE.splitlines().index("gonio.EON(roughnes=1)") + 1
"""The first line with a mistake; all before are right, all from there are wrong."""


def made() -> str:
    spec = importlib.util.spec_from_file_location("make_stubs", ROOT / "tools" / "make_stubs.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text: str = module.stub()
    return text


def test_the_stub_is_what_the_fields_say() -> None:
    """If this fails: python tools/make_stubs.py."""
    assert (ROOT / "gonio" / "__init__.pyi").read_text(encoding="utf-8") == made()


def test_a_new_parameter_changes_the_stub(monkeypatch: pytest.MonkeyPatch) -> None:
    field = gonio.models()["eon"].fields["roughness"]
    monkeypatch.setattr(field, "default", 0.25)
    assert "roughness: _Number = 0.25," in made()


def test_a_type_checker_finds_misspelt_parameters(tmp_path: Path) -> None:
    """Run by mypy with the project's cache, which is warm after 'make test' has checked the types."""
    mypy = pytest.importorskip("mypy", reason="a tool of development")
    assert mypy
    script = tmp_path / "use.py"
    script.write_text(USE, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", script]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False
    )
    lines = {int(n) for n in re.findall(r"use\.py:(\d+): error", done.stdout)}
    assert lines == set(range(WRONG, len(USE.splitlines()) + 1)), done.stdout
    assert (
        'Unexpected keyword argument "roughnes" for "EON"; did you mean "roughness"?' in done.stdout
    )
