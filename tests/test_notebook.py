"""gonio at a prompt and in notebooks: help, attributes, equality, and what is shown in place of text."""

from __future__ import annotations

import html
import io
import pydoc
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import gonio
from gonio import check, notebook
from gonio.check.report import FAIL, PASS, Finding, Report
from gonio.render.picture import Picture


class Cells(HTMLParser):
    """The texts of a table's cells, row by row; fails where tags are not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.rows: list[list[str]] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


# --- at a prompt -----------------------------------------------------------------------------------


def test_help_says_what_the_parameters_mean() -> None:
    text = pydoc.plain(pydoc.render_doc(gonio.models()["eon"]))
    assert "roughness: unitless r; not the Oren-Nayar angle sigma; 0 to 1, default 0.5" in text
    assert "albedo_form: E_F inside the BRDF" in text
    assert "'exact', 'fitted'; default 'exact'" in text
    inner = gonio.models()["weidlich_wilkie"].__doc__
    assert inner is not None
    assert "a model or its name, default 'lambert'" in inner


def test_every_parameter_is_explained_in_its_class() -> None:
    for cls in gonio.models().values():
        for name, declared in cls.fields.items():
            assert f"\n    {name}: {declared.doc}; " in (cls.__doc__ or "")
        assert "Parameters:" not in cls.description


def test_modules_load_when_they_are_asked_for() -> None:
    """In a process of its own: here others have loaded them."""
    script = (
        "import sys, gonio\n"
        "assert 'mitsuba' not in sys.modules and 'matplotlib' not in sys.modules\n"
        "assert 'gonio.check' not in sys.modules\n"
        "print(gonio.check.check_model.__name__, gonio.reference.Stack.__name__)\n"
        "print(gonio.mitsuba.register.__name__, gonio.conversions.SCALES['alpha'].name)\n"
        "print(callable(gonio.render), callable(gonio.models), callable(gonio.model))\n"
        "assert {'EON', 'check', 'mitsuba', 'render'} <= set(dir(gonio))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [
        "check_model", "Stack", "register", "alpha", "True", "True", "True",
    ]  # fmt: skip


def test_what_is_not_there_is_an_attribute_error() -> None:
    for name in ("Eon", "tekstures", "__wrapped__"):
        with pytest.raises(AttributeError, match=f"module 'gonio' has no attribute '{name}'"):
            getattr(gonio, name)


# --- equality --------------------------------------------------------------------------------------

COLOR = st.one_of(st.floats(0, 1), st.tuples(*[st.floats(0, 1)] * 3))


@given(rho=COLOR, roughness=st.floats(0, 1), form=st.sampled_from(["exact", "fitted"]))
def test_models_made_alike_are_equal_and_have_equal_hashes(
    rho: Any, roughness: float, form: str
) -> None:
    first, second = (gonio.EON(rho=rho, roughness=roughness, albedo_form=form) for _ in range(2))
    assert first == second
    assert hash(first) == hash(second)
    assert eval(repr(first), {"EON": gonio.EON}) == first
    assert first != first.replace(roughness=0.25 if roughness == 0.5 else 1 - roughness)
    assert first != first.replace(albedo_form="exact" if form == "fitted" else "fitted")


def test_a_grey_is_the_colour_of_three_equal_numbers() -> None:
    assert gonio.EON(rho=0.5) == gonio.EON(rho=(0.5, 0.5, 0.5))
    assert gonio.EON(rho=0.5) != gonio.EON(rho=(0.5, 0.5, 0.4))
    assert len({gonio.EON(rho=0.5), gonio.EON(rho=(0.5, 0.5, 0.5)), gonio.EON()}) == 2


def test_models_of_different_kinds_or_bases_differ() -> None:
    assert gonio.FON() != gonio.EON()
    coat = gonio.model("weidlich_wilkie", base="eon")
    assert coat == gonio.model("weidlich_wilkie", base=gonio.EON())
    assert coat != gonio.model("weidlich_wilkie", **{"base": "eon", "base.roughness": 0.3})
    assert gonio.EON() != "EON()"


def test_arrays_are_compared_by_being_the_same_object() -> None:
    """Their values can change, and comparing them would cost a kernel."""
    array = np.linspace(0, 1, 4)
    assert gonio.EON(roughness=array) == gonio.EON(roughness=array)
    assert gonio.EON(roughness=array) != gonio.EON(roughness=array.copy())
    assert hash(gonio.EON(roughness=array)) == hash(gonio.EON(roughness=array))


def test_the_name_of_eighteen_coats_is_said_at_once() -> None:
    """Each coat used to say its base twice, and that base its own twice again."""
    model = gonio.model("lambert", rho=0.25)
    for _ in range(18):
        model = gonio.model("weidlich_wilkie", base=model)
    text = repr(model)
    assert text.count("WeidlichWilkie(") == 18
    assert hash(model) == hash(model.replace())


# --- in notebooks ----------------------------------------------------------------------------------


def test_a_model_is_a_table_of_its_parameters() -> None:
    model = gonio.model("weidlich_wilkie", eta=1.4, base=gonio.EON(roughness=np.linspace(0, 1, 5)))
    rows = Cells(model._repr_html_()).rows
    assert rows[0] == ["parameter", "value", "allowed", "meaning"]
    found = {row[0]: row[1:] for row in rows[1:]}
    assert found["eta"][:2] == ["1.4", "1 to 3"]
    assert found["base"][0] == "EON"
    assert found["base.roughness"][0] == "array of shape (5,)"
    assert found["interface"][1] == "'rough', 'smooth'"
    paths = {path for path, _, _ in model.parameters()}
    assert paths <= set(found)


def test_a_material_is_a_table_that_names_its_pictures(tmp_path: Path) -> None:
    Image.new("RGB", (4, 4), (200, 100, 50)).save(tmp_path / "oak.png")
    file = tmp_path / "board.toml"
    file.write_text(
        'model = "weidlich_wilkie"\ndescription = "A board."\n[base]\nmodel = "eon"\nrho = "oak.png"\n',
        encoding="utf-8",
    )
    text = gonio.load(file)._repr_html_()
    found = {row[0]: row[1] for row in Cells(text).rows}
    assert found["base.rho"] == "oak.png"
    assert found["base.roughness"] == "0.5"
    assert "A board." in text
    flaky = {row[0]: row[1] for row in Cells(gonio.load("car_paint_red_strong")._repr_html_()).rows}
    assert flaky["flake_x"] == "a map"


def test_what_is_shown_is_escaped() -> None:
    evil = "<script>alert('&')</script>"
    text = notebook.table(evil, evil, [evil], [[evil]])
    assert "<script>" not in text
    assert Cells(text).rows == [[evil], [evil]]
    assert text.count(html.escape(evil)) == 4


def test_names_in_backticks_are_code_and_nothing_else_is() -> None:
    text = notebook.table("`eval`", "of `<b>`", ["a `sample` drawn"], [["` x `"]])
    assert "<b><code>eval</code></b> of `&lt;b&gt;`" in text
    assert "a <code>sample</code> drawn" in text
    assert "` x `" in text


def test_reports_are_a_table_with_a_sum() -> None:
    bad = Finding("largest albedo", 1.5, FAIL, "at most 1 is allowed")
    reports = check.Reports(
        [
            Report("energy", "eon", (bad,)),
            Report("finite", "eon", (Finding("NaN", 0.0, PASS, "none"),)),
        ]
    )
    text = reports._repr_html_()
    assert Cells(text).rows[1] == [
        "energy",
        "largest albedo",
        "1.5",
        "FAIL",
        "at most 1 is allowed",
    ]
    assert "1 FAILED, 1 passed" in text
    assert "gonio check eon" in text
    assert str(reports).splitlines()[-1] == "1 FAILED, 1 passed"
    assert check.failed(reports)


def test_checking_gives_such_reports() -> None:
    reports = gonio.check.check_model(gonio.Lambert(), "quick", only=["isotropy"], fixed=["rho"])
    assert isinstance(reports, check.Reports)
    assert len(Cells(reports._repr_html_()).rows) > 1


def test_a_rendered_picture_is_shown_as_a_picture() -> None:
    picture = gonio.render(
        gonio.Lambert(rho=(0.9, 0.2, 0.1)), size=(24, 16), spp=4, environment="white"
    )
    assert isinstance(picture, Picture)
    png = picture._repr_png_()
    assert png is not None
    shown = Image.open(io.BytesIO(png))
    assert shown.size == (24, 16)
    red, green, _ = np.asarray(shown, float)[8, 12]
    assert red > 2 * green  # the middle of the ball
    assert picture[..., 0]._repr_png_() is None  # one channel is no picture
    assert float(picture.mean()) > 0  # an array as any other
