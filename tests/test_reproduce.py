"""Figures, tables and numbers of the texts: verdicts are computed, and every item has one."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from support.tolerances import DOUBLE_DIVIDED

import gonio
from gonio import reproduce
from gonio.cli import main
from gonio.reproduce import Sheet, Verdict, rendered
from gonio.reproduce.measure import directions, drawn, hemisphere, weights
from gonio.reproduce.text import Item, Text

ITEMS = {item.id: item for item in reproduce.items()}
FIGURES = Path(__file__).parent.parent.parent / "shared" / "figures.csv"
TEXTS = {"000": "triace", "002": "pbr", "003": "eon", "004": "elek"}


# What the page of all verdicts says cannot be had
PAGE = (Path(__file__).parents[1] / "docs" / "reproduce.md").read_text(encoding="utf-8")
LACKING = set(
    re.findall(
        r"`(\w+:[\w-]+)`", PAGE.partition("## What cannot be had")[2].partition("## From")[0]
    )
)


def run(*arguments: object) -> object:
    return CliRunner().invoke(main, [str(a) for a in arguments], catch_exceptions=True)


# --- verdicts ---------------------------------------------------------------------------------------


def test_a_number_agrees_within_half_of_its_last_printed_digit() -> None:
    for ours, verdict in ((0.35, Verdict.AGREES), (0.451, Verdict.DIFFERS), (0.4, Verdict.AGREES)):
        sheet = Sheet()
        sheet.claim("S", "=", "0.4", ours)
        assert sheet.verdict is verdict, ours
    sheet = Sheet()
    sheet.claim("S", "=", "1e6", 1.3e6)
    assert sheet.verdict is Verdict.AGREES


@pytest.mark.parametrize(("relation", "good", "bad"), [("<=", 0.05, 0.2), (">=", 0.2, 0.05)])
def test_bounds_hold_or_fail(relation: str, good: float, bad: float) -> None:
    for ours, verdict in ((good, Verdict.AGREES), (bad, Verdict.DIFFERS)):
        sheet = Sheet()
        sheet.claim("a bound", relation, "0.1", ours)
        assert sheet.verdict is verdict


def test_nan_never_agrees() -> None:
    for relation in ("=", "<=", ">="):
        sheet = Sheet()
        sheet.claim("broken", relation, "1", math.nan, within=1e9)
        assert sheet.verdict is Verdict.DIFFERS


def test_a_text_is_wrong_only_while_gonio_is_as_the_proof_says() -> None:
    def verdict(ours: float) -> Verdict:
        sheet = Sheet()
        sheet.claim("something right", "=", "1", 1)
        sheet.refute("the factor", "=", "100", ours, proof=35.0, within=1, why="derived")
        return sheet.verdict

    assert verdict(35.4) is Verdict.TEXT_WRONG
    assert verdict(50) is Verdict.DIFFERS  # neither
    assert verdict(100) is Verdict.DIFFERS  # as the text, against the proof


def test_without_a_claim_it_is_shown_unless_something_is_lacking() -> None:
    sheet = Sheet()
    sheet.show("ours", 3.0)
    assert sheet.verdict is Verdict.SHOWN
    sheet.lack("a console that nobody has")
    assert sheet.verdict is Verdict.NOT_COMPARABLE
    sheet.claim("its ratio", "=", "2", 3)
    assert sheet.verdict is Verdict.DIFFERS, "what is lacking excuses no claim that fails"


def test_a_reason_that_several_lines_share_is_told_once() -> None:
    sheet = Sheet()
    for what, why in (("a", "float32"), ("b", "float32"), ("c", "flat")):
        sheet.claim(what, "=", "1", 1, why=why)
    sheet.lack("a table")
    assert sheet.notes() == ["a table", "float32", "c: flat"]


# --- the items --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [i.id for i in ITEMS.values() if not i.slow])
def test_each_number_is_the_text_s_or_the_proven_correction(name: str) -> None:
    made = reproduce.make(ITEMS[name])
    assert made.verdict is not Verdict.DIFFERS, reproduce.table(made)
    if made.verdict is Verdict.SHOWN:
        assert made.sheet.lines or made.picture is not None, "nothing is shown"
    assert (made.verdict is Verdict.NOT_COMPARABLE) == (name in LACKING), made.verdict


def test_all_that_cannot_be_had_has_an_item() -> None:
    assert set(ITEMS) >= LACKING
    assert len(LACKING) > 5


def test_ids_and_parts_are_unique_within_a_text() -> None:
    for text in reproduce.texts().values():
        names = [n for item in text.items for n in (item.name, *item.covers)]
        assert len(set(names)) == len(names), text.name


@pytest.mark.skipif(not FIGURES.exists(), reason="the list of all figures is not here")
def test_every_figure_table_equation_and_number_has_its_item() -> None:
    with FIGURES.open(encoding="utf-8") as file:
        rows = [row["id"] for row in csv.DictReader(file)]
    missing = []
    for row in rows:
        text, _, name = row.partition("-")
        name = name.lower().removeprefix("p-").removeprefix("fig")
        try:
            reproduce.find(f"{TEXTS[text]}:{name}")
        except ValueError:
            missing.append(row)
    assert missing == []


def test_a_changed_model_changes_the_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = gonio.EON.mean_albedo
    assert reproduce.make(ITEMS["eon:eq18"]).verdict is Verdict.TEXT_WRONG
    monkeypatch.setattr(gonio.EON, "mean_albedo", lambda self: 0.99 * broken(self))
    assert reproduce.make(ITEMS["eon:eq18"]).verdict is Verdict.DIFFERS


def test_unknown_items_are_named_with_near_ones() -> None:
    with pytest.raises(ValueError, match=r"no item 'eon:12x'; did you mean .*eon:12"):
        reproduce.find("eon:12x")
    assert reproduce.find("EON:11-left").id == "eon:11"


# --- measurements -----------------------------------------------------------------------------------


def test_the_quadrature_knows_the_hemisphere() -> None:
    for theta in (0.0, 0.7, 1.5):
        over = hemisphere(theta)
        assert over.integral(np.ones(len(over.wi))) == pytest.approx(
            2 * math.pi, rel=DOUBLE_DIVIDED
        )
        assert over.reflected(np.ones(len(over.wi))) == pytest.approx(math.pi, rel=DOUBLE_DIVIDED)


def test_statistics_of_weights_are_those_of_samples() -> None:
    model = gonio.EON(rho=1, roughness=1, sampler="cosine")
    exact, found = weights(model, math.radians(70)), drawn(model, math.radians(70), 200_000)
    # 200,000 weights of variance 0.36: five standard errors of the mean; 3 % of the variance
    assert found.mean == pytest.approx(exact.mean, abs=5 * math.sqrt(0.36 / 2e5))
    # The variance by as many weights; the largest of them lies beside the largest of all
    assert found.variance == pytest.approx(exact.variance, rel=0.03)
    assert found.highest == pytest.approx(exact.highest, rel=1e-3)
    # What is wasted counts as weight 0
    ltc = gonio.EON(rho=1, roughness=1, sampler="ltc")
    mean = weights(ltc, math.radians(89)).mean
    # Five standard errors of 200,000 weights, of which some are 0
    assert mean == pytest.approx(drawn(ltc, math.radians(89), 200_000).mean, abs=0.003)
    assert mean < 0.995


def test_directions_are_units() -> None:
    w = directions(np.array([0.1, 1.2]), 0.4)
    np.testing.assert_allclose(np.linalg.norm(w, axis=-1), 1)


# --- files and the command --------------------------------------------------------------------------


def small(text: Text, make: object) -> Item:
    return Item(text, "x", "Eq. 1", "a number", (), False, make)  # type: ignore[arg-type]


def test_what_was_written_is_kept_until_the_code_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def make(sheet: Sheet) -> None:
        calls.append(1)
        sheet.claim("n", "=", "2", 2)

    item = small(Text("t", "A text"), make)
    told: list[str] = []

    def progress(done: int, total: int, item: Item, text: str) -> None:
        told.append(text)

    for _ in range(2):
        assert reproduce.write_all([item], tmp_path, progress=progress) == {"t:x": Verdict.AGREES}
    assert (len(calls), told) == (1, ["agrees", "kept, agrees"])
    assert "| n | 2 | 2 | 0 | holds |" in (tmp_path / "t-x.md").read_text(encoding="utf-8")
    assert "1 items: 1 agrees" in (tmp_path / "index.md").read_text(encoding="utf-8")
    reproduce.write_all([item], tmp_path, again=True)
    assert len(calls) == 2
    from gonio.reproduce import runner

    monkeypatch.setattr(runner, "fingerprint", lambda: "another")
    reproduce.write_all([item], tmp_path)
    assert len(calls) == 3
    (tmp_path / "t-x.json").write_text("{")  # half a file is made again
    reproduce.write_all([item], tmp_path)
    assert len(calls) == 4


def test_one_that_fails_does_not_take_the_others_along(tmp_path: Path) -> None:
    def broken(sheet: Sheet) -> None:
        raise ValueError("no such thing")

    text = Text("t", "A text")
    good = Item(
        text, "y", "Eq. 2", "a number", (), False, lambda sheet: sheet.claim("n", "=", "2", 2)
    )
    told: list[str] = []
    with pytest.raises(RuntimeError, match=r"1 of 2 could not be made: t:x\."):
        reproduce.write_all(
            [small(text, broken), good], tmp_path, progress=lambda d, n, i, what: told.append(what)
        )
    assert told == ["failed: no such thing", "agrees"]
    assert "t:y" in (tmp_path / "index.md").read_text(encoding="utf-8")
    assert not (tmp_path / "t-x.json").exists()


def test_a_page_has_picture_and_numbers(tmp_path: Path) -> None:
    from PIL import Image

    made = reproduce.write(ITEMS["eon:3"], tmp_path)
    assert made.verdict is Verdict.AGREES
    with Image.open(tmp_path / "eon-3.png") as page:
        assert page.width > 1000
    data = json.loads((tmp_path / "eon-3.json").read_text(encoding="utf-8"))
    assert data["verdict"] == "agrees"
    assert {line["state"] for line in data["lines"]} == {"holds"}


def test_a_picture_without_labels_has_no_strip_for_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from PIL import Image

    monkeypatch.setattr(rendered, "compare", lambda *_, **__: np.full((8, 8, 3), 0.2, np.float32))
    eon = gonio.model("eon")
    for labels, high in (([""], False), (["EON"], True)):
        one = rendered.Rendered([eon], labels, common={"size": (8, 8)})
        with Image.open(one.save(tmp_path / "one.png")) as picture:
            assert (picture.height > 8) is high


def test_plots_on_a_page_have_letters_of_one_size() -> None:
    from PIL import Image

    for width, dots, fits in (
        (800, None, 800),
        (800, 240, 400),
        (2000, 200, 1200),
        (2400, 120, 1200),
    ):
        picture = Image.new("RGB", (width, 100))
        if dots is not None:
            picture.info["dpi"] = (dots, dots)
        assert rendered.fitted(picture).width == fits


def test_the_command_lists_and_writes(tmp_path: Path) -> None:
    listed = run("reproduce").stdout  # type: ignore[attr-defined]
    assert "eon:11 " in listed
    assert "Table 1" in listed
    result = run("reproduce", "eon:eq1", "eon:fn1", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output  # type: ignore[attr-defined]
    assert "2/2  eon:fn1" in result.stdout  # type: ignore[attr-defined]
    assert "2 agrees" in result.stdout  # type: ignore[attr-defined]
    assert (tmp_path / "out" / "eon-eq1.md").exists()
    wrong = run("reproduce", "--text", "eno")
    assert wrong.exit_code == 1  # type: ignore[attr-defined]
    assert "no text 'eno'; there are" in wrong.stderr  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("eon",), "'eon' is a text, not an item; --text eon makes all its items"),
        (("--again",), "nothing to make; name items"),
        (("-o", "elsewhere"), "nothing to make; name items"),
    ],
)
def test_what_makes_nothing_is_refused(words: tuple[str, ...], told: str) -> None:
    result = run("reproduce", *words)
    assert result.exit_code != 0  # type: ignore[attr-defined]
    assert told in result.stderr  # type: ignore[attr-defined]
