"""Values from outside: derived in mpmath, straight from publications, knowing nothing of gonio."""

from __future__ import annotations

import csv
import json
import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.kinks import kink_error

import gonio
from gonio.description import citations
from gonio.parts.oren_nayar import qualitative_coefficients

ROWS = [
    row
    for file in sorted(Path(__file__).parent.glob("anchors*.csv"))
    for row in csv.DictReader(file.read_text(encoding="utf-8").splitlines())
]
MINIMUM_PER_MODEL = 5
ROOT = Path(__file__).parent.parent

# Derived values have 17 digits. The directions are unit only to 1e-16, and two forms of the same
# formula (1 + s as a sum of squares) differ by that, which the absolute part allows for.
DERIVED_RTOL, DERIVED_ATOL = 1e-10, 1e-14

# Albedos without a closed form come from the rule in gonio.albedos.quadrature.
NUMERIC_RTOL = 1e-5

# mean_albedo takes no array whose precision it could follow, and is computed in float32.
FLOAT32_RTOL = 1e-6


def compute(row: dict[str, str]) -> Any:
    parameters = {
        k: tuple(v) if isinstance(v, list) else v for k, v in json.loads(row["parameters"]).items()
    }
    model = gonio.model(row["model"], **parameters)
    directions = [np.array(json.loads(row[name]), np.float64) for name in ("wi", "wo") if row[name]]
    if row["quantity"] == "mean_albedo":
        return model.mean_albedo()
    return getattr(model, row["quantity"])(*directions)


def check(row: dict[str, str]) -> None:
    value = compute(row)
    expected = np.array(json.loads(row["value"]))
    if decimals := re.match(r"rounded to (\d+) decimals: ", row["source"]):
        np.testing.assert_allclose(value, expected, atol=0.51 * 10 ** -int(decimals[1]), rtol=0)
        return
    rtol = DERIVED_RTOL
    if row["quantity"] == "mean_albedo":
        rtol = FLOAT32_RTOL
    elif row["quantity"] not in vars(gonio.models()[row["model"]]):
        given = json.loads(row["parameters"])
        chosen = {k: v for k, v in given.items() if isinstance(v, str)}
        rtol = NUMERIC_RTOL + kink_error(gonio.models()[row["model"]], chosen, given)
    np.testing.assert_allclose(value, expected, rtol=rtol, atol=DERIVED_ATOL)


@pytest.mark.parametrize(
    "row", ROWS, ids=[f"{n}-{r['model']}-{r['quantity']}" for n, r in enumerate(ROWS, 2)]
)
def test_anchor(row: dict[str, str]) -> None:
    check(row)


def test_every_model_has_anchors() -> None:
    count = Counter(row["model"] for row in ROWS)
    few = {name: count[name] for name in gonio.models() if count[name] < MINIMUM_PER_MODEL}
    assert not few, f"at least {MINIMUM_PER_MODEL} each; step 4 of docs/adding_a_model.md says how"


def complaint(source: str) -> str:
    """What keeps a reader from finding an anchor's source; "" if nothing does.

    A source says how the value was found, then for each publication its key in the bibliography and where
    in it, and last the file that derives the value with its function.
    """
    how, *places = source.split("; ")
    if not re.match(r"(derived|rounded to \d+ decimals): \S", how):
        return f"{how!r} does not say how the value was found"
    if not places:
        return "no place is named"
    for place in places:
        name, _, where = place.partition(" ")
        if name not in citations.bibliography() and not (ROOT / name).is_file():
            return f"{name!r} is neither in the bibliography nor a file"
        if not where:
            return f"{name}: no equation, section or function is named"
    file, _, function = places[-1].partition(" ")
    if f"def {function}(" not in (ROOT / file).read_text(encoding="utf-8"):
        return f"{file} has no function {function!r}"
    return ""


@pytest.mark.parametrize("source", sorted({row["source"] for row in ROWS}))
def test_every_anchor_names_a_source_that_a_reader_can_find(source: str) -> None:
    assert complaint(source) == ""


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("derived: mpmath, 40 digits; formulas.md section 1", "neither"),
        ("derived: mpmath, 40 digits; oren1995 Eq. 30; tests/derive_anchors.py qon", "neither"),
        ("derived: mpmath, 40 digits; oren1994; tests/derive_anchors.py qon", "no equation"),
        ("derived: mpmath, 40 digits; oren1994 Eq. 30; tests/derive_anchors.py gon", "no function"),
        ("derived: mpmath, 40 digits", "no place"),
        ("Oren and Nayar, Eq. 30; tests/derive_anchors.py qon", "how the value was found"),
    ],
)
def test_a_source_that_nobody_can_find_is_refused(source: str, reason: str) -> None:
    assert reason in complaint(source)


def test_a_wrong_constant_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """0.34 in place of 0.33 in QON's A moves values by 1 % at most; no anchor may let it pass."""
    monkeypatch.setattr(
        sys.modules["gonio.models.qon"],
        "qualitative_coefficients",
        lambda sigma, offset: qualitative_coefficients(sigma, offset + 0.01),
    )
    rough = [
        row
        for row in ROWS
        if row["model"] == "qon"
        and json.loads(row["parameters"])["sigma"] > 0
        and row["source"].startswith("derived: ")
    ]
    assert len(rough) >= MINIMUM_PER_MODEL
    for row in rough:
        with pytest.raises(AssertionError):
            check(row)
