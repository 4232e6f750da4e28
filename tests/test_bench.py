"""The logic of `gonio bench`: pairing, checking, counting, reporting. How fast is not tested."""

import json
import statistics
from functools import partial

import drjit as dr
import numpy as np
import pytest
from support.tolerances import SINGLE, SINGLE_LONG

import gonio
from gonio.bench import (
    BenchError,
    albedos,
    bench,
    command,
    kernels,
    native,
    pairs,
    pictures,
    startup,
)
from gonio.bench.exported_loop import exported_loops
from gonio.bench.report import GENERATED, Column, Report, Section, goal_text, milliseconds
from gonio.bench.timing import alternate, stopwatch
from gonio.fields import Parameter

needs_llvm = pytest.mark.skipif(
    not gonio.backend.available("llvm"), reason="gonio bench measures the LLVM backend"
)


def silent(text):
    pass


class Twin:
    """Stands for the C++ baseline without a compiler; `factor` makes it wrong."""

    eval_names = ("lambert", "fon", "eon_exact", "eon_fitted")
    sample_names = ("lambert", "eon_exact")

    def __init__(self, factor=1.0):
        self.factor = factor
        self.calls = []

    def model(self, name, parameters):
        rho, rest = tuple(parameters[:3]), parameters[3:]
        if name == "lambert":
            assert not rest
            return gonio.Lambert(rho=rho)
        if name == "fon":
            return gonio.FON(rho=rho, roughness=rest[0])
        return gonio.EON(rho=rho, roughness=rest[0], albedo_form=name.partition("_")[2])

    def eval(self, name, wi, wo, parameters, *, threads, repeat, inlined=False):
        self.calls.append(("inlined " if inlined else "") + name)
        model = self.model(name, parameters)
        value = model.eval(np.stack(wi, -1), np.stack(wo, -1)) * self.factor
        return native.Timed(1e-3, np.ascontiguousarray(value.T))

    def sample_pdf_eval(self, name, wo, u1, u2, parameters, *, threads, repeat, inlined=False):
        model = self.model(name, parameters)
        wo, u = np.stack(wo, -1), np.stack([u1, u2], -1)
        wi, pdf = model.sample(wo, u)
        value = model.eval(wi, wo)
        return native.TimedSamples(1e-3, value.T.copy(), wi.T.copy(), pdf * self.factor)

    def bandwidth(self, threads, repeat):
        return 1e9


class TwinLoop:
    """The model itself in place of its export, so that nothing is compiled."""

    def __init__(self, model):
        self.model = model

    def eval(self, wi, wo, threads):
        value = self.model.eval(np.stack(wi, -1), np.stack(wo, -1))
        return native.Timed(1e-3, np.ascontiguousarray(value.T))


def twin_loops(models):
    return {label: TwinLoop(model) for label, model in models.items()}


def instantly():
    return 1e-6


def everything(entry):
    return True


@pytest.fixture(scope="module")
def few():
    return pairs.random_pairs(256)


# ---------------------------------------------------------------------------------------- pairing


def test_every_registered_model_is_measured():
    found = list(pairs.entries(Twin.eval_names))
    assert {entry.model.name for entry in found} == set(gonio.models())
    assert len(found) == len({entry.label for entry in found})


def test_a_row_named_after_an_option_measures_that_option():
    found = {entry.label: entry for entry in pairs.entries(Twin.eval_names)}
    assert found["eon_fitted"].model.albedo_form == "fitted"
    assert found["eon_exact"].model.albedo_form == "exact"
    assert "eon" not in found


def test_a_model_without_a_baseline_comes_alone():
    (eon,) = (entry for entry in pairs.entries(()) if entry.model.name == "eon")
    assert (eon.label, eon.in_baseline) == ("eon", False)


def test_a_row_named_after_an_inner_model_comes_beside_the_models_own():
    found = {entry.label: entry for entry in pairs.entries(("weidlich_wilkie_two_coats",))}
    assert not found["weidlich_wilkie"].in_baseline
    two = found["weidlich_wilkie_two_coats"].model
    assert (two.name, two.base.name, two.base.base.name) == (
        "weidlich_wilkie",
        "weidlich_wilkie",
        "lambert",
    )


def test_parameters_are_all_numbers_in_order_with_three_for_a_colour():
    model = gonio.model("weidlich_wilkie", eta=1.4, sigma_a=(1, 2, 3), **{"base.rho": 0.5})
    assert pairs.Entry("", model, False).parameters == (1.4, 0.1, 1, 2, 3, 1, 0.5, 0.5, 0.5)


@needs_llvm
def test_a_row_holds_both_sides_and_what_follows_from_them(few, monkeypatch):
    monkeypatch.setattr(pairs, "exported_loops", twin_loops)
    twin = Twin()

    def some(entry):
        return entry.label in {"fon", "eon_exact", "qon"}

    section = pairs.eval_section(twin, few, instantly, 2, some, silent)
    rows = {row["row"]: row for row in section.rows}
    fon = rows["fon"]
    assert fon["calls_seconds"] == 1e-3
    assert fon["calls_ratio"] == pytest.approx(1e-3 / fon["seconds"])
    assert fon["seconds_per_pair"] == pytest.approx(fon["seconds"] / 256)
    assert fon["bandwidth_share"] == pytest.approx(1e-6 / fon["seconds"])
    # The twin evaluates NumPy arrays, by another kernel: they may differ by rounding.
    assert fon["difference"] < 1e-6
    assert rows["eon_exact"]["goal"].startswith("≥ 14")
    assert "calls_seconds" not in rows["qon"]
    assert rows["qon"]["seconds"] > 0
    # Both loops are called once in each of three rounds, and once for the values.
    assert twin.calls.count("fon") == 4
    assert twin.calls.count("inlined fon") == 3


@needs_llvm
def test_samples_are_compared_where_the_baseline_sampled(few):
    section = pairs.sample_section(Twin(), few, instantly, 1, everything, silent)
    assert [row["row"] for row in section.rows] == ["eon_exact", "lambert"]
    assert all(row["difference"] < SINGLE_LONG for row in section.rows)
    assert all(row["calls_ratio"] > 0 for row in section.rows)


@needs_llvm
def test_numpy_is_compared_with_drjit():
    section = pairs.numpy_section(64, 1, silent)
    assert section.rows[0]["multiple"] == 1
    assert section.rows[1]["goal"].startswith("≤ 4")
    assert gonio.backend.validating()  # as it was before


@needs_llvm
def test_albedos_are_timed_with_their_evaluations_and_the_share_of_evals_own_speed(monkeypatch):
    monkeypatch.setattr(albedos, "PEAK_PAIRS", 2000)
    monkeypatch.setattr(albedos, "DIRECTIONS", 3)

    def some(entry):
        return entry.label in {"hapke", "eon"}  # eon has a closed form

    (row,) = albedos.albedo_section(1, some, silent).rows
    assert (row["row"], row["rule"]) == ("hapke", "angles")  # found
    assert row["seconds_per_evaluation"] == row["seconds"] / (3 * row["evaluations"])
    assert row["share"] == row["eval_seconds"] / row["seconds_per_evaluation"]
    assert row["mean_evaluations"] % row["evaluations"] == 0
    assert row["goal"].startswith("≤ 100")


# --------------------------------------------------------------------------------------- checking


@needs_llvm
def test_a_baseline_that_computes_something_else_is_an_error(few, monkeypatch):
    def only(entry):
        return entry.label == "fon"

    monkeypatch.setattr(pairs, "exported_loops", twin_loops)
    with pytest.raises(BenchError, match=r"fon: gonio's value and .* differ by 0\.0099"):
        pairs.eval_section(Twin(1.01), few, instantly, 1, only, silent)


@needs_llvm
def test_a_baseline_with_another_density_is_an_error(few):
    with pytest.raises(BenchError, match=r"gonio's pdf and .* differ by 0\.0099"):
        pairs.sample_section(Twin(1.01), few, instantly, 1, everything, silent)


@pytest.fixture(scope="module")
def real_baseline(tmp_path_factory):
    """The C++ baseline, compiled from what the repository has now."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield native.compile_baseline.__wrapped__()


@needs_llvm
def test_the_baseline_samples_with_the_densities_of_today(real_baseline):
    given = pairs.random_pairs(4096)
    measured = [e for e in pairs.entries(real_baseline.sample_names) if e.in_baseline]
    assert {entry.label for entry in measured} == set(real_baseline.sample_names)
    for entry in measured:
        samples = pairs._baseline_samples(real_baseline, entry, given)
        assert pairs.compare_samples(entry, given, samples) <= pairs.TOLERANCE


@needs_llvm
def test_every_loop_over_an_export_computes_what_the_model_does(
    real_baseline, monkeypatch, tmp_path
):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    given = pairs.random_pairs(4096)
    measured = list(pairs.entries(real_baseline.eval_names))
    # One library without optimisation, which costs a second; the vectorised one is compared by `bench`
    flags = ("-std=c++17", "-fPIC", "-shared", "-pthread")
    loops = exported_loops({entry.label: entry.model for entry in measured}, flags)
    for entry in measured:
        theirs = partial(pairs._baseline_values, real_baseline, entry, given)
        pairs.compare_values(
            entry, given, loops[entry.label], theirs if entry.in_baseline else None
        )
    # Loops that are mixed up would be seen
    eon = next(entry for entry in measured if entry.label == "eon_fitted")
    with pytest.raises(
        BenchError, match="eon_fitted: gonio's value and its C\\+\\+ export's differ"
    ):
        pairs.compare_values(eon, given, loops["fon"], None)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_values_that_are_not_finite_never_agree(wrong):
    values = np.float32([1, 2, 3])
    broken = np.float32([1, wrong, 3])
    assert pairs.difference(broken, values) == float("inf")
    assert pairs.difference(values, broken) == float("inf")
    assert pairs.difference(values, values) == 0


def test_one_pair_of_ten_thousand_may_differ_and_no_more():
    theirs, ours = np.ones(40_001, np.float32), np.ones(40_001, np.float32)
    ours[:4] = 2
    assert pairs.difference(ours, theirs) == 0
    ours[4] = 2
    assert pairs.difference(ours, theirs) == 1


def test_a_value_near_zero_is_compared_with_the_mean():
    theirs = np.float32([1, 1, 1e-9])
    ours = theirs + np.float32([0, 0, 1e-5])
    # Far from the 1e4 of a comparison with the value itself
    assert pairs.difference(ours, theirs) == pytest.approx(1e-5 / (pairs.SMALL * 2 / 3), rel=1e-2)


# --------------------------------------------------------------------------------------- counting


@needs_llvm
def test_another_value_of_a_parameter_needs_no_new_kernel():
    rows = pairs.kernel_rows(silent)
    assert [row["compiled"] for row in rows] == [0, 0]
    # At least a colour for each model.
    assert all(row["changes"] >= len(gonio.models()) for row in rows)


@needs_llvm
def test_a_number_in_the_code_needs_a_new_kernel(few):
    def scaled(factor):
        return lambda: dr.eval(gonio.FON().eval(few.jit_wi, few.jit_wo) * factor)

    assert kernels.needed_again(scaled(0.5), scaled(0.25)) == 1
    assert kernels.needed_again(scaled(0.5), scaled(0.5)) == 0
    opaque = dr.opaque(dr.llvm.ad.Float, 0.5), dr.opaque(dr.llvm.ad.Float, 0.25)
    assert kernels.needed_again(scaled(opaque[0]), scaled(opaque[1])) == 0


@needs_llvm
def test_a_plugin_changed_by_traverse_needs_no_new_kernel():
    import mitsuba as mi

    before = mi.variant()
    (row,) = pictures.kernel_rows(silent)
    assert (row["compiled"], row["changes"]) == (0, 2)
    assert before is None or mi.variant() == before


@pytest.mark.parametrize("name", gonio.models())
def test_a_changed_copy_differs_in_one_parameter(name):
    model = gonio.model(name)
    changed = dict(kernels.changed_copies(model))
    numbers = [n for n, f in model.fields.items() if isinstance(f, Parameter)]
    assert list(changed) == numbers
    for parameter, copy in changed.items():
        differing = [n for n in model.fields if getattr(copy, n) != getattr(model, n)]
        assert differing == [parameter]


@needs_llvm
def test_memory_is_counted_in_the_kernel_itself(few):
    def moved(name):
        model = gonio.model(name)
        (kernel,) = kernels.launched(lambda: dr.eval(model.eval(few.jit_wi, few.jit_wo)))
        assert kernel.size == few.count
        return kernels.moved_bytes(kernel)

    simplest, *_ = kernels.launched(pairs.stream(few.count))
    assert kernels.moved_bytes(simplest) * simplest.size == pairs.STREAM_BYTES * few.count
    assert moved("eon") == native.EVAL_BYTES
    assert moved("lambert") == 5 * 4  # two cosines, which tell what is below the horizon, and RGB


@pytest.mark.parametrize(
    ("exported", "ours", "moving", "said"),
    [
        (4.0, 3.0, 2.9, "≥ 1.3 ✓"),
        (4.0, 3.5, 2.0, "≥ 1.3 ✗"),  # memory would allow 2
        (3.6, 3.2, 3.0, "memory allows 1.20"),
    ],
)
def test_a_row_that_memory_limits_has_no_goal_but_says_so(exported, ours, moving, said):
    assert pairs.export_goal(exported, ours, moving) == said


@needs_llvm
def test_exact_quotients_and_roots_are_counted(few):
    x, y = few.jit_wi.x + 2, few.jit_wo.y + 3

    def counted(make):
        (kernel,) = kernels.launched(lambda: dr.eval(make()))
        return kernels.exact_operations(kernel)

    dr.eval(x, y)
    assert counted(lambda: x * y + 1) == 0
    assert counted(lambda: x / y + dr.sqrt(x)) == 2
    assert counted(lambda: x * (1 / dr.opaque(type(y), 3)) + y / x) == 2


# ----------------------------------------------------------------------------------------- timing


def test_sides_take_turns_and_the_first_round_does_not_count():
    order = []
    times = {"a": iter([100.0, 1, 2, 30]), "b": iter([100.0, 5, 7, 6])}

    def side(name):
        def run():
            order.append(name)
            return next(times[name])

        return run

    assert alternate({"a": side("a"), "b": side("b")}, 3) == {"a": 2, "b": 6}
    assert order == ["a", "b"] * 4


def test_a_stopwatch_gives_the_median_of_its_calls():
    calls = []
    assert stopwatch(lambda: calls.append(0), 3)() >= 0
    assert len(calls) == 3


def test_a_process_is_timed_or_says_why_not(monkeypatch):
    assert isinstance(startup.process_seconds(["-c", "pass"], 1), float)
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    compiled = "import sys; raise SystemExit(sys.dont_write_bytecode)"
    assert isinstance(startup.process_seconds(["-c", compiled], 1), float)
    assert startup.process_seconds(["-c", "raise SystemExit('no luck')"], 1) == "failed: no luck"


def test_the_commands_that_are_timed_are_gonios_own():
    assert isinstance(startup.process_seconds([*startup.COMMAND, "list"], 1), float)


# -------------------------------------------------------------------------------------- reporting


def report():
    columns = (Column("row", "row"), Column("seconds", "ms", milliseconds), Column("goal", "goal"))
    rows = [
        {"row": "eon_exact", "seconds": 0.01234, "goal": goal_text(15, at_least=14)},
        {"row": "new|model", "seconds": "not available"},
    ]
    section = Section("eval", "eval of pairs", ["How it was done."], columns, rows)
    return Report({"processor": "abacus"}, ["Medians of one."], [section])


def test_markdown_says_first_that_it_is_generated():
    lines = report().markdown().splitlines()
    assert lines[0] == GENERATED.format(command="gonio bench --output")
    assert "gonio bench" in lines[0]
    assert lines[2] == "# Performance"
    assert "| processor | abacus |" in lines
    assert "## eval of pairs" in lines
    assert "| `eon_exact` | 12.3 | ≥ 14 ✓ |" in lines
    assert "| new\\|model | not available | – |" in lines


def test_text_is_aligned():
    *_, headings, first, second = report().text().splitlines()
    assert headings.index("goal") + len("goal") == len(first)
    assert first == "eon_exact           12.3  ≥ 14 ✓"
    assert second == "new|model  not available       –"


def test_json_has_the_numbers():
    content = json.loads(report().json())
    assert content["machine"] == {"processor": "abacus"}
    assert content["sections"]["eval"]["rows"][0]["seconds"] == 0.01234


def test_the_report_is_written_whole(tmp_path):
    page, numbers = tmp_path / "performance.md", tmp_path / "performance.json"
    report().write(page)
    report().write(numbers)
    assert page.read_text(encoding="utf-8") == report().markdown()
    assert json.loads(numbers.read_text(encoding="utf-8"))
    assert sorted(tmp_path.iterdir()) == [numbers, page]


@pytest.mark.parametrize(
    ("text", "value", "bounds"),
    [
        ("≥ 7.5 ✓", 7.5, {"at_least": 7.5}),
        ("≥ 7.5 ✗", 7.4, {"at_least": 7.5}),
        ("≤ 4 ✓", 4, {"at_most": 4}),
        ("≤ 4 ✗", 4.1, {"at_most": 4}),
    ],
)
def test_a_goal_says_whether_it_is_met(text, value, bounds):
    assert goal_text(value, **bounds) == text


# ------------------------------------------------------------------------------------ the command


@needs_llvm
def test_bench_measures_what_was_asked_for(monkeypatch, tmp_path):
    monkeypatch.setattr(native, "compile_baseline", Twin)
    monkeypatch.setattr(native, "_find_compiler", lambda: ["echo"])
    monkeypatch.setattr(pairs, "exported_loops", twin_loops)
    told = []
    output = tmp_path / "performance.md"
    found = bench(pairs=128, repeat=1, rows=["eon"], output=output, progress=told.append)
    assert [section.key for section in found.sections] == ["eval", "sample"]
    assert [row["row"] for row in found["eval"].rows] == ["eon_exact", "eon_fitted"]
    assert "eval eon_exact" in told
    assert {"processor", "cores", "vector width", "C++", "Dr.Jit", "date"} <= set(found.machine)
    page = output.read_text(encoding="utf-8")
    assert page.startswith(GENERATED.format(command="gonio bench --output"))
    assert "cosine uniform in (0, 1]" in page


@needs_llvm
def test_wrong_arguments_are_errors_that_say_what_is_right(monkeypatch):
    monkeypatch.setattr(native, "compile_baseline", Twin)
    with pytest.raises(
        ValueError, match=r"no row 'no_such_model' in the bench; known are .*eon_fitted"
    ):
        bench(rows=["no_such_model"], progress=silent)
    with pytest.raises(ValueError, match="pairs=0"):
        bench(pairs=0)


def test_without_llvm_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setattr(gonio.backend, "available", lambda name: False)
    with pytest.raises(gonio.BackendError, match="gonio bench needs LLVM"):
        bench()


def test_random_directions_are_unit_and_above_the_horizon():
    if not gonio.backend.available("llvm"):
        pytest.skip("the pairs live in LLVM arrays")
    found = pairs.random_pairs(1000)
    for w in (found.wi, found.wo):
        assert min(w[2]) > 0
        np.testing.assert_allclose(sum(np.float64(c) ** 2 for c in w), 1, atol=SINGLE)
    assert statistics.mean(found.wo[2]) == pytest.approx(0.5, abs=0.05)  # 5 standard deviations
    assert found.jit_wi.numpy().shape == (3, 1000)


@needs_llvm
def test_materials_are_rendered_in_the_same_scene():

    section = pictures.render_section(4, 1, 1, silent)
    rows = {row["row"]: row for row in section.rows}
    assert set(rows) == {*pictures.COMPARED, *pictures.GOALS}
    for own, ours in pictures.COMPARED.items():
        assert rows[own]["multiple"] == 1
        for name in ours:
            expected = rows[name]["seconds"] / rows[own]["seconds"]
            assert rows[name]["multiple"] == pytest.approx(expected)
            assert rows[name]["goal"].startswith("≤")
    assert all(row["seconds"] > 0 for row in section.rows)


@needs_llvm
def test_another_metal_is_not_taken_for_mitsubas(monkeypatch):
    materials = pictures._materials

    def wrong():
        found = materials()
        found["gonio_torrance_sparrow"][0]["alpha"] = 0.5
        return found

    monkeypatch.setattr(pictures, "_materials", wrong)
    monkeypatch.setattr(pictures, "COMPARED", {"roughconductor": ("gonio_torrance_sparrow",)})
    with pytest.raises(BenchError, match="gonio_torrance_sparrow and roughconductor should give"):
        pictures.render_section(64, 16, 1, silent)


def test_pictures_of_different_materials_are_an_error():
    random = np.random.default_rng(1)
    one, other = (1 + 0.1 * random.standard_normal((32, 32, 3)) for _ in range(2))
    pictures._check_same("a", "b", one, other)
    with pytest.raises(BenchError, match="should give the same picture"):
        pictures._check_same("a", "b", one, 1.05 * other)


def test_sections_are_known_by_name():
    sections, models = command._chosen(["numpy"], Twin())
    assert (sections, models) == ({"numpy"}, None)
    sections, models = command._chosen(["fon"], Twin())
    assert (sections, models) == ({"eval", "sample"}, {"fon"})


def test_the_loop_over_an_export_computes_what_the_model_does():
    model = gonio.model("weidlich_wilkie", alpha=0.3, sigma_a=(0.1, 0.5, 0.2))
    given = pairs.random_pairs(3000)
    found = exported_loops({"coat": model})["coat"].eval(given.wi, given.wo, threads=2)
    expected = model.eval(np.stack(given.wi, -1), np.stack(given.wo, -1))
    assert found.seconds > 0
    # Small numbers are still numbers here: a library linked with -Ofast would flush them for all
    assert np.float32(1e-40) * np.float32(0.5) > 0
    assert pairs.difference(found.value, np.ascontiguousarray(expected.T)) < pairs.TOLERANCE
    # Another parameter would be seen
    other = gonio.model("weidlich_wilkie", alpha=0.31, sigma_a=(0.1, 0.5, 0.2))
    wrong = other.eval(np.stack(given.wi, -1), np.stack(given.wo, -1))
    assert pairs.difference(found.value, np.ascontiguousarray(wrong.T)) > 10 * pairs.TOLERANCE
