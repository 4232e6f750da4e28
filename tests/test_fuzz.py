"""`gonio check --fuzz`: a screen in one kernel suspects what the checks find; a search can be resumed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drjit.llvm import Float64
from hypothesis import example, given
from hypothesis import strategies as st
from mpmath import mp, mpf
from support.tolerances import SINGLE

import gonio
from gonio.check import finite, fuzz
from gonio.check.adversarial import EXTRA, Cases, hard_cases, hard_parameters, random_points
from gonio.check.gradient import METHODS, gradients
from gonio.check.kernels import evaluate
from gonio.check.screen import LANES, MOVED, Rows, cases, places, screen
from gonio.check.subject import ModelSubject
from gonio.check.variants import part_of
from gonio.materials import model_file

BROKEN = Path(__file__).parent / "broken"


def some_rows(subject: ModelSubject, count: int) -> Rows:
    """Rows of which every second one looks near a case."""
    near = np.random.default_rng(3).random((count, EXTRA))
    near[::2] = np.nan
    return Rows(hard_parameters(subject, count, 5), near, 17)


@pytest.mark.parametrize(
    "name",
    [
        *("nan_at_tiny_cosines", "infinite_gradient", "overflow_near_normal", "equal_widths"),
        "steep_sampler",
    ],
)
def test_a_screen_suspects_what_the_checks_find(name: str) -> None:
    subject = ModelSubject(model_file.load(BROKEN / f"{name}.py")())
    rows = some_rows(subject, 256)
    count = len(rows.parameters) * LANES
    found = screen(subject, rows, count)
    everything = cases(subject, rows, np.arange(count))
    index = np.arange(count, dtype=np.uint32)
    with np.errstate(invalid="ignore", over="ignore"):
        f, pdf = evaluate(
            subject,
            everything.parameters,
            index,
            everything.wi,
            everything.wo,
            single_precision=True,
            rounded=True,
        )
        steep = np.zeros(count)
        for method in METHODS:
            for gradient in gradients(subject, everything, method).values():
                size = np.where(np.isfinite(gradient), np.abs(gradient), np.inf)
                steep = np.maximum(steep, size.max(axis=0))
    bad = ~np.isfinite(f).all(axis=1) | (f < 0).any(axis=1) | ~(np.isfinite(pdf) & (pdf >= 0))
    assert not (bad & ~found.wrong).any()
    assert np.array_equal(np.isinf(found.steep), np.isinf(steep))
    assert bad.any() or np.isinf(steep).any()
    # And what is suspected is wrong by the checks
    number = int(np.count_nonzero(found.wrong))
    if number:
        suspects = cases(subject, rows, np.flatnonzero(found.wrong))
        assert finite.not_finite(subject, suspects, True)[1] >= number


def test_a_screen_suspects_densities_and_samples_as_well(tmp_path: Path) -> None:
    text = (BROKEN / "infinite_gradient.py").read_text().replace(", sqrt", ", select, sqrt")
    share = {"negative": "pdf_cosine(wi) * select(wi.z < 0.01, -1, 1)", "long": "pdf_cosine(wi)"}
    for name, density in share.items():
        path = tmp_path / f"{name}.py"
        path.write_text(
            text.replace("InfiniteGradient", name.title())
            .replace("return pdf_cosine(wi)", f"return {density}")
            .replace("Sample(wi, ", "Sample(wi * 1.0001, " if name == "long" else "Sample(wi, ")
        )
        subject = ModelSubject(model_file.load(path)())
        rows = some_rows(subject, 24)
        found = screen(subject, rows, 24 * LANES)
        everything = cases(subject, rows, np.arange(24 * LANES))
        expected = everything.wi[:, 2] < 0.01 if name == "negative" else everything.wo[:, 2] > 0
        assert np.array_equal(found.wrong, expected)
        assert np.count_nonzero(expected) > 0


def test_a_screen_measures_float32_as_the_check_does() -> None:
    subject = ModelSubject(model_file.load(BROKEN / "cancelling_half_vector.py")())
    rows = some_rows(subject, 24)
    count = len(rows.parameters) * LANES
    found = screen(subject, rows, count)
    everything = cases(subject, rows, np.arange(count))
    unexcused = finite.float32_error(subject, everything, np.inf).max(axis=1)
    assert unexcused.max() > 0.1  # it loses all digits
    large = np.isfinite(unexcused) & ~found.wrong & (unexcused > finite.FLOAT32)
    # Two roundings of one formula, which compilers contract in different ways
    assert found.errors["float32"][large] == pytest.approx(
        unexcused[large], rel=0.05, abs=finite.FLOAT32
    )


def test_cases_are_those_of_their_places() -> None:
    """Made in the kernel, they are what `hard_cases` makes of the same coordinates."""
    subject = ModelSubject(gonio.models()["torrance_sparrow"]())
    rows = some_rows(subject, 8)
    chosen = np.arange(0, len(rows.parameters) * LANES, 7)
    made = cases(subject, rows, chosen)
    points = np.concatenate([rows.parameters[chosen // LANES], places(rows, chosen)], axis=1)
    again = hard_cases(subject, points)
    for name in ("parameters", "wi", "wo", "u"):
        assert getattr(made, name) == pytest.approx(getattr(again, name), abs=SINGLE)
    lanes = chosen // LANES
    kept = places(rows, chosen) == rows.near[lanes]
    # 259 coordinates that stay with a probability of 0.6: three standard deviations
    assert kept[lanes % 2 == 1].mean() == pytest.approx(1 - MOVED, abs=0.1)
    assert not kept[lanes % 2 == 0].any()


@pytest.mark.parametrize("name", ["torrance_sparrow", "patina"])
def test_all_parameters_together_never_excuse_more_than_one_by_one(name: str) -> None:
    """The triangle inequality: a difference of all roundings is at most the sum of each one's."""
    subject = ModelSubject(gonio.models()[name]())
    tried = hard_cases(subject, random_points(subject, 512, 4))
    value = finite._values(subject, tried, single_precision=False)
    each = finite._rounding_effect(subject, tried, value)
    together = finite._rounding_effect_at_least(subject, tried, value)
    # Second order, and the digits of float64, which steep values have fewer of
    assert (together <= each * (1 + 1e-3) + 1e-9 * np.abs(value) + 1e-20).all()
    assert (together > 0).any()


def test_roundings_are_told_where_one_of_them_does_not_reach_total_reflection() -> None:
    """sin^2 is 4.7e-8 above eta^2, where all is reflected, and one rounding of eta moves that by 4.2e-8."""
    subject = ModelSubject(gonio.models()["torrance_sparrow"]())
    row = subject.default()
    for number, free in enumerate(subject.parameters):
        given = {"eta": 0.698647677898407, "k": 0.0, "alpha": 0.1625055372714996}.get(free.path)
        row[number] = row[number] if given is None else part_of(free.declared, given)
    wi = [-0.9880371689796448, -0.00010845065844478086, 0.15421584248542786]
    wo = [0.00010823820775840431, -0.9880371689796448, 0.15421584248542786]
    case = Cases(*(np.array([numbers] * 2) for numbers in (row, wi, wo, [0.5, 0.5])))
    assert finite.float32_error(subject, case, np.inf).max() > 1e-4  # with nothing excused
    assert finite.float32_error(subject, case).max() < finite.FLOAT32


def test_a_search_goes_on_where_it_stopped_and_finds_what_is_broken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stopped after two thirds of the cases, it ends with the state of one that was not."""
    monkeypatch.setattr(fuzz, "BATCH", 1 << 13)
    subject = ModelSubject(model_file.load(BROKEN / "overflow_near_normal.py")())
    half, count = tmp_path / "half.json", 3 * fuzz.BATCH
    fuzz.run([subject], 2 * fuzz.BATCH, half)
    (resumed,) = fuzz.run([subject], count, half)
    (whole,) = fuzz.run([subject], count)
    assert (resumed.cases, resumed.counts) == (whole.cases, whole.counts)
    assert (resumed.elite, resumed.error) == (whole.elite, whole.error)
    assert resumed.cases == count
    assert resumed.counts["not finite"] > 0
    assert "--double" not in resumed.replays["not finite"][0]
    (report,) = fuzz.reports([resumed])
    assert report.failed
    assert f"| overflow_near_normal | – | {count:.2g} |" in fuzz.table([resumed])


def test_a_density_with_a_claim_of_its_own_is_held_to_it() -> None:
    """Car paint's declares 5e-3, which says nothing of its values; here is ten times as much."""
    size = 5e-2
    cls: Any = gonio.models()["car_paint"]

    class Wrong(cls, register=False):  # type: ignore[misc]
        def pdf(self, wi: Any, wo: Any) -> Any:
            value = super().pdf(wi, wo)
            return value * (1 + size) if self.float_type.__name__ == "Float" else value

    (state,) = fuzz.run([ModelSubject(Wrong())], 1 << 12)
    values, density = fuzz.reports([state])[0].findings
    assert (values.verdict, density.verdict) == ("pass", "FAIL")
    assert density.measured == pytest.approx(size, rel=0.1)  # beside its own roundings
    assert f"pdf {density.measured:.2g} " in fuzz.table([state])
    assert density.replay is not None
    assert density.replay.startswith("pdf: gonio eval")


@example(-4, -5.97, -17.7, -9, 1.003)  # light and viewer opposite, of which one is in the horizon
@given(
    st.floats(-4, 0), st.floats(-18, 0), st.floats(-18, 0), st.floats(-18, 0), st.floats(0, 6.28)
)
def test_no_more_is_excused_of_values_and_densities_than_an_exponential_loses(
    log_alpha: float, log_i: float, log_o: float, log_turn: float, phi: float
) -> None:
    # Beckmann's facets in V-grooves, in numbers without an end; h is the half vector before it is unit
    mp.dps = 50
    alpha, mu_i, mu_o = (mpf(10) ** power for power in (log_alpha, log_i, log_o))
    turn = mpf(10) ** log_turn
    sin_i, sin_o = mp.sqrt(1 - mu_i**2), mp.sqrt(1 - mu_o**2)
    across = sin_i * mp.cos(turn * phi) - sin_o, sin_i * mp.sin(turn * phi)
    tangential2, z = across[0] ** 2 + across[1] ** 2, mu_i + mu_o
    h2 = tangential2 + z**2
    tail = tangential2 / (z * alpha) ** 2
    cos2 = z**2 / h2
    D = mp.exp(-tail) / (mp.pi * alpha**2 * cos2**2)
    lost = D if tail > 126 * mp.log(2) else mpf(0)
    lower, higher = min(mu_i, mu_o), max(mu_i, mu_o)
    G = min(mpf(1), 4 * z * lower / h2)  # 2 m.z mu / wo.m
    subject = ModelSubject(gonio.models()["ward"](form="balanced"))

    def left(error: mpf, column: int) -> float:
        low, high, cosine = (Float64(float(number)) for number in (0, error, higher))
        return float(finite.departures(subject, [low] * 4, [high] * 4, cosine)[column][0][0])

    value, density = finite.NAMES.index("eval"), finite.DENSITY
    assert left(lost * G / (4 * mu_i * mu_o), value) == 0
    assert left(lost * z / (2 * h2), density) == 0  # D m.z / (4 wo.m)
    # Twice what the narrowest facets can lose is not excused
    for larger, column in ((8e-31 / higher**2, value), (4e-31 / higher, density)):
        assert left(larger, column) > 0.5 * float(larger)


def test_a_search_leaves_other_files_alone(tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text("{}")
    with pytest.raises(ValueError, match="is no state"):
        fuzz.load(other)
