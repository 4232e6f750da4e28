"""Tasks known by their content: done once, anywhere, with the same result; whoever dies in between."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st
from support.tolerances import SINGLE

import gonio
from gonio import check, materials
from gonio.check import fuzz
from gonio.cli import main
from gonio.cluster import (
    ClusterError,
    Done,
    Here,
    NotPortableError,
    Run,
    RunFolder,
    Task,
    checks,
    connect,
    pictures,
    sweep,
)
from gonio.cluster.codec import decode, encode
from gonio.cluster.grid import axis, points
from gonio.cluster.identity import Identity, identity
from gonio.fields import ModelError
from gonio.messages import Notice
from gonio.model import Model
from gonio.render import passes, render

WORK = "support.cluster_work"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


def squares(log: Path, count: int = 6, seconds: float = 0.0) -> list[Task]:
    return [
        Task.of(f"{WORK}:square", f"x = {x}", x=float(x), log=str(log), seconds=seconds)
        for x in range(count)
    ]


def values(results: Any) -> list[Any]:
    return [done.value if isinstance(done, Done) else done.reason for _, done in results]


# ----------------------------------------------------------------------------------- what travels

floats = st.floats() | st.integers(-(2**60), 2**60) | st.text() | st.booleans() | st.none()
trees = st.recursive(
    floats,
    lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@given(trees)
@settings(max_examples=60, deadline=None)
def test_values_arrive_as_they_were_in_the_same_bytes(value: Any) -> None:
    data, files = encode(value)
    assert repr(decode(data)) == repr(value)  # nan is not equal to itself
    assert (encode(decode(data))[0], files) == (data, {})


def test_arrays_and_models_and_dataclasses_arrive_to_the_last_bit(tmp_path: Path) -> None:
    model = gonio.model("weidlich_wilkie", alpha=1 / 3, **{"base.rho": (0.1, 0.2, 1 / 7)})
    array = np.array([[np.nan, -0.0], [1e-300, 1 / 3]], np.float32)
    share = passes.Share(3, 4, ((0, 16),), 5)
    back = decode(encode([model, array, share, Path(__file__)])[0], lambda digest, name: tmp_path)
    assert back[0] == model
    assert back[1].tobytes() == array.tobytes()
    assert back[1].dtype == array.dtype
    assert back[2:] == [share, tmp_path]


def test_bytes_of_others_are_refused_and_run_nothing() -> None:
    with pytest.raises(ValueError, match=r"none of gonio's"):
        decode(b"\x80\x04no zip")
    data = encode(passes.Share(0, 1, (), 0))[0].replace(
        b"gonio.render.passes:Share", b"subprocess:Popen.........."[:25]
    )
    with pytest.raises(ValueError, match=r"no dataclass|none of gonio's"):
        decode(data)


def test_a_user_s_own_model_and_textures_travel_by_content(tmp_path: Path) -> None:
    source = Path(gonio.__file__).parent / "models" / "lambert.py"
    (tmp_path / "mine.py").write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    model = materials.load(f"{tmp_path / 'mine.py'}:rho=0.3")
    data, files = encode(model)
    assert [path.name for path in files.values()] == ["mine.py"]
    assert str(tmp_path).encode() not in data
    there = tmp_path / "elsewhere"
    there.mkdir()

    def place(digest: str, name: str) -> Path:
        return (there / name).write_bytes(files[digest].read_bytes()) and there / name  # type: ignore[return-value]

    back = decode(data, place)
    assert (back.name, back.rho) == ("mine", 0.3)


def test_what_exists_here_only_is_refused_with_what_to_do(tmp_path: Path) -> None:
    class Local(gonio.models()["lambert"], register=False):  # type: ignore[misc]
        pass

    with pytest.raises(NotPortableError, match=r"file of its own, my_model\.py"):
        encode(Local())
    (tmp_path / "parts.py").write_text("C = 1\n")
    lambert = (Path(gonio.__file__).parent / "models" / "lambert.py").read_text(encoding="utf-8")
    (tmp_path / "uses.py").write_text(lambert.replace('"""\nfrom', '"""\nimport json\nfrom', 1))
    encode(materials.load(str(tmp_path / "uses.py")))
    text = (tmp_path / "uses.py").read_text(encoding="utf-8")
    (tmp_path / "uses.py").write_text(f"{text}\ndef f():\n    import parts\n", encoding="utf-8")
    with pytest.raises(NotPortableError, match="imports parts from beside it"):
        encode(materials.load(str(tmp_path / "uses.py")))
    (tmp_path / "car.gltf").write_text(json.dumps({"buffers": [{"uri": "car.bin"}]}))
    with pytest.raises(NotPortableError, match=r"car\.bin.*\.glb"):
        encode(tmp_path / "car.gltf")


def test_a_key_is_what_decides_the_result_and_nothing_else(tmp_path: Path) -> None:
    here = identity()
    (tmp_path / "a").mkdir()
    for name in ("x.txt", "a/x.txt"):
        (tmp_path / name).write_text("same")
    first, second = (
        Task.of(f"{WORK}:text_of", title, file=tmp_path / name)
        for title, name in (("one", "x.txt"), ("another", "a/x.txt"))
    )
    assert first.key(here) == second.key(here)
    (tmp_path / "a" / "x.txt").write_text("other")
    assert Task.of(f"{WORK}:text_of", "", file=tmp_path / "a" / "x.txt").key(here) != first.key(
        here
    )
    for field in ("gonio", "python", "packages", "backend"):
        other = Identity(**{**vars(here), field: "x"})
        assert first.key(other) != first.key(here)
        assert f"{field} x (here" in here.differences(other)
    assert here.differences(here) == ""


# ------------------------------------------------------------------------------------ run folders


def test_what_is_done_is_not_done_again(tmp_path: Path) -> None:
    log, folder = tmp_path / "log", RunFolder(tmp_path / "a run")
    log.mkdir()
    first = Run(Here(), folder)
    assert values(first.results(squares(log, 4))) == [0, 1, 4, 9]
    again = Run(Here(), RunFolder(tmp_path / "a run"))
    assert values(again.results(squares(log, 6))) == [0, 1, 4, 9, 16, 25]
    assert len(list(log.iterdir())) == 6


def test_damaged_and_half_written_results_are_done_again(tmp_path: Path) -> None:
    log, folder = tmp_path / "log", RunFolder(tmp_path / "run")
    log.mkdir()
    list(Run(Here(), folder).results(squares(log, 3)))
    whole, cut, empty = sorted((tmp_path / "run").glob("??/*"))
    content = bytearray(cut.read_bytes())
    content[len(content) // 2] ^= 1
    cut.write_bytes(content)
    empty.write_bytes(b"")
    (whole.parent / ".gonio-half").write_text("half")
    with pytest.warns(Notice, match="is damaged"):
        found = values(Run(Here(), folder).results(squares(log, 3)))
    assert found == [0, 1, 4]
    assert len(list(log.iterdir())) == 5
    folder.remove()
    assert not (tmp_path / "run").exists()


def test_a_folder_of_others_is_neither_filled_nor_emptied(tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.tex").write_text("")
    with pytest.raises(OSError, match="other things in it"):
        RunFolder(tmp_path / "home")
    with pytest.raises(OSError, match="is a file"):
        RunFolder(tmp_path / "home" / "thesis.tex")
    with pytest.raises(FileNotFoundError, match="no folder"):
        RunFolder(tmp_path / "none" / "run")
    folder = RunFolder(tmp_path / "run")
    assert not folder.path.exists()  # nothing is left of a run that did nothing
    folder.put("ab" * 32, b"data")
    (folder.path / "ab" / "notes.txt").write_text("mine")
    folder.remove()
    assert [p.name for p in folder.path.rglob("*")] == ["ab", "notes.txt"]


def test_two_clients_may_share_a_folder_even_when_one_removes_it(tmp_path: Path) -> None:
    log = tmp_path / "log"
    log.mkdir()
    tasks = squares(log, 3)
    one, other = (Run(Here(), RunFolder(tmp_path / "run")) for _ in range(2))
    slow = one.results(tasks)
    first = next(slow)
    assert values(other.results(tasks)) == [0, 1, 4]
    assert len(list(log.iterdir())) == 3
    RunFolder(tmp_path / "run").remove()
    assert values([first, *slow]) == [0, 1, 4]


def test_a_full_disk_ends_the_run_with_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="the disk is full"):
        list(Run(Here(), RunFolder(tmp_path / "run")).results(squares(tmp_path)))
    assert not list((tmp_path / "run").glob("??/*"))


def test_a_failing_task_is_named_and_the_others_go_on() -> None:
    tasks = [Task.of(f"{WORK}:unlucky", f"x = {x}", x=float(x), bad=1.0) for x in range(3)]
    run = Run(Here())
    with pytest.warns(Notice, match="odd") as said:
        found = [done for _, done in run.results(tasks)]
    assert len(said) == 1  # each note once
    assert [done.value for done in found if isinstance(done, Done)] == [0, 4]
    assert [(f.title, f.reason) for f in run.failures] == [("x = 1", "1 brings no luck.")]
    assert "unlucky" in run.failures[0].trace


# ----------------------------------------------------------------------------------------- sweeps


def test_ranges_are_written_in_a_few_ways() -> None:
    model = gonio.model("torrance_sparrow")
    assert axis(model, "alpha=0.1..1:4").values == pytest.approx((0.1, 0.4, 0.7, 1.0))
    assert axis(model, "alpha=0.01..1:3:log").values == pytest.approx((0.01, 0.1, 1.0))
    assert axis(model, "alpha=0.1, 0.3").values == (0.1, 0.3)
    assert len(axis(model, "alpha=0.01..1:log").values) == 11
    assert axis(gonio.model("oren_nayar"), "sigma=0..pi/2:2").values == (0, np.pi / 2)
    assert axis(gonio.model("eon"), "sampler=cosine,cltc").values == ("cosine", "cltc")
    assert axis(gonio.model("weidlich_wilkie"), "base.rho=0..1:2").name == "base.rho"
    two = [axis(model, "alpha=0.1,0.2"), axis(model, "eta=1.5,2")]
    assert list(points(two)) == [(0.1, 1.5), (0.1, 2), (0.2, 1.5), (0.2, 2)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("alpha", "is not what can be varied"),
        ("alpha=1..", "is not what can be varied"),
        ("alpha=0..1:3:4", "is not what can be varied"),
        ("alpha=0..inf", "is not what can be varied"),
        ("alpha=0.1..1:1", "2 values or more"),
        ("alpha=0..1:log", "above 0"),
        ("alpha=0.1..2", "alpha=2 is out of range; allowed is"),
        ("beta=0..1", "no 'beta' to vary; it has"),
        ("distribution=cube", "cube"),
    ],
)
def test_a_wrong_range_is_one_line(text: str, said: str) -> None:
    with pytest.raises(ModelError, match=said):
        axis(gonio.model("torrance_sparrow"), text)


def table(path: Path) -> list[dict[str, float]]:
    with path.open(encoding="utf-8") as file:
        return [{k: float(v or "nan") for k, v in row.items()} for row in csv.DictReader(file)]


def test_a_sweep_has_the_numbers_of_closed_forms(tmp_path: Path) -> None:
    out = tmp_path / "a b.csv"
    both = ["--measure", "albedo", "--measure", "mean_albedo", "--measure", "variance"]
    found = run("sweep", "lambert", "--vary", "rho=0..1:3", *both, "--samples", 999, "-o", out)
    assert found.exit_code == 0, found.output
    rows = table(out)
    assert len(rows) == 3 * 4
    for row in rows:
        rho = row["rho"]
        for column in ("albedo_r", "mean_albedo_b", "weight_mean", "weight_maximum"):
            assert row[column] == pytest.approx(rho, abs=1e-6)  # float32 samples
        assert row["weight_variance"] == pytest.approx(0, abs=1e-12)  # a perfect sampler
    assert {row["theta_o"] for row in rows} == {0, 30, 60, 80}
    against = ("--measure", "difference", "--against", "lambert:rho=0.8")
    run("sweep", "lambert", "--vary", "rho=0.4,0.8", *against, "-o", out)
    assert [(r["difference"], r["energy"]) for r in table(out)] == [
        pytest.approx((0.5, -0.5), abs=SINGLE),
        pytest.approx((0, 0), abs=SINGLE),
    ]
    # What is not given of the other is varied in it too
    run("sweep", "lambert", "--vary", "rho=0.4", *against[:3], "eon:roughness=0", "-o", out)
    assert table(out)[0]["difference"] == pytest.approx(0, abs=SINGLE)


def test_parquet_holds_the_same_as_csv(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    what = ("sweep", "eon", "--vary", "sampler=cosine,cltc", "--vary", "roughness=0..1:3")
    for name in ("x.csv", "x.parquet"):
        assert run(*what, "-o", tmp_path / name).exit_code == 0
    read = parquet.read_table(tmp_path / "x.parquet")
    with (tmp_path / "x.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert read.column_names == list(rows[0])
    assert read["sampler"].to_pylist() == [row["sampler"] for row in rows]
    for name in read.column_names[1:]:
        assert read[name].to_pylist() == [float(row[name]) for row in rows]
    assert json.loads(read.schema.metadata[b"gonio"])["model"] == "eon"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["eon"], "give --vary"),
        (["eon", "--vary", "roughness=0..1", "--measure", "difference"], "--against MODEL"),
        (["eon", "--vary", "roughness=0..1", "--against", "lambert"], "--measure difference"),
        (["eon", "--vary", "roughness=0..1", "--vary", "roughness=0,1"], "varied twice"),
        (["eon", "--vary", "roughness=0..1", "-o", "x.xlsx"], ".parquet or .csv"),
        (["eon", "--vary", "roughness=0..1", "--theta-o", "95"], "less than 90"),
        (["eon", "--vary", "roughness=0..1", "--samples", "9"], "--samples is for"),
        (
            ["eon", "--vary", "roughness=0..1", "--cluster", "here", "-o", "x.csv"],
            "is not local, local:N",
        ),
        (
            ["eon", "--vary", "roughness=0..1", "--cluster", "s.json", "-o", "x.csv"],
            "no scheduler file s.json",
        ),
        (
            ["eon", "--vary", "roughness=0..1", "--run-dir", ".", "-o", "x.csv"],
            "other things in it",
        ),
    ],
)
def test_a_wrong_sweep_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "thesis.tex").write_text("")
    found = run("sweep", *arguments)
    assert found.exit_code in (1, 2)
    assert said in found.output
    assert found.output.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.tex"]


def test_failing_points_are_empty_in_the_table_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def sometimes(model: Model, **given: Any) -> Any:
        if given["points"][0] == (0.5,):
            raise ValueError("no such number.")
        return np.ones((len(given["points"]), 1, 3))

    monkeypatch.setitem(sweep.POINTS, "mean_albedo", 1)
    monkeypatch.setattr(sweep, "rows", sometimes)
    out = tmp_path / "x.csv"
    found = run(
        *("sweep", "eon", "--vary", "roughness=0..1:3", "--measure", "mean_albedo", "-o", out)
    )
    assert found.exit_code == 1
    assert "eon at roughness=0.5: no such number." in found.output
    assert [row["mean_albedo_r"] for row in table(out)] == pytest.approx(
        [1, np.nan, 1], nan_ok=True
    )


# -------------------------------------------------------------------------- pictures and checks


@given(st.integers(1, 300), st.integers(1, 5000), st.integers(1, 200))
@settings(max_examples=30, deadline=None)
def test_shares_hold_each_sample_of_each_row_once(height: int, spp: int, room: int) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(passes, "PATHS_PER_PASS", 64 * room)
        patch.setattr(passes, "PATHS_PER_SHARE", 256 * room)
        (found,) = passes.shares((16, height), spp)
    samples = np.zeros(height, int)
    for share in found:
        assert (samples[share.top : share.top + share.rows] == share.spp_before).all()
        samples[share.top : share.top + share.rows] += share.spp
    assert (samples == spp).all()
    numbers = [number for share in found for number, _ in share.passes]
    assert len(set(numbers)) == len(numbers)  # no random numbers twice


def test_a_picture_of_shares_is_the_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passes, "PATHS_PER_SHARE", 24 * 16 * 16)
    arguments: Any = {"environment": "studio", "size": (24, 16), "spp": 40, "seed": 3}
    whole = render("eon", diffusion=0.05, **arguments)
    shown = gonio.model("eon")
    run = Run(Here())
    (shared,) = pictures.pictures(run, [(shown, {**arguments, "diffusion": 0.05})])
    assert len(pictures.tasks(shown, {**arguments, "diffusion": 0.05})) == 2 * 2
    assert shared is not None
    # Threads add float32 in another order; samples that are missing or doubled are worth a tenth
    np.testing.assert_allclose(shared, whole, rtol=1e-4, atol=1e-6)


def test_checks_by_tasks_find_the_same() -> None:
    subjects = check.subjects(gonio.model("lambert"))
    names = ["reciprocity", "isotropy"]
    direct = check.check_subjects(subjects, "quick", names)
    shared = checks.reports(Run(Here()), [subjects], "quick", names)
    assert [r.findings for r in shared] == [r.findings for r in direct]
    assert [repr(f.case) for r in shared for f in r.findings] == [
        repr(f.case) for r in direct for f in r.findings
    ]


def test_a_search_by_tasks_finds_the_same_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fuzz, "BATCH", 2048)
    monkeypatch.setattr(checks, "CASES", 4096)
    subjects = check.subjects(gonio.model("lambert"))
    (whole,) = fuzz.run(subjects, 10_000)
    folder = RunFolder(tmp_path / "run")
    checks.search(Run(Here(), folder), subjects, 8192)
    with monkeypatch.context() as patch:
        patch.setattr(fuzz, "advance", lambda *_: pytest.fail("done already"))
        checks.search(Run(Here(), folder), subjects, 8192, tmp_path / "state.json")
    (resumed,) = checks.search(Run(Here(), folder), subjects, 10_000, tmp_path / "state.json")
    assert vars(resumed) | {"seconds": 0} == vars(whole) | {"seconds": 0}
    assert fuzz.load(tmp_path / "state.json") == [resumed]


def test_what_cannot_be_shared_out_is_said(tmp_path: Path) -> None:
    for arguments in (
        ["render", "eon", "--run-dir", tmp_path / "r"],
        ["render", "eon", "--spp", "9", "--noise", "0.1", "--run-dir", tmp_path / "r"],
        ["series", "patina", "--cluster", "local"],
        ["check", "--mitsuba", "diffuse", "--run-dir", tmp_path / "r"],
    ):
        found = run(*arguments)
        assert found.exit_code == 2
        assert "--cluster and --run-dir" in found.output
    assert not list(tmp_path.iterdir())


# ------------------------------------------------------------------------- scheduler and workers

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")

BIN = Path(sys.executable).parent
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": os.pathsep.join(
        [str(Path(gonio.__file__).parents[1]), str(Path(__file__).parent)]
    ),
}


class Machines:
    """A scheduler and its workers, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.file = folder / "the scheduler.json"
        self.all: list[subprocess.Popen[bytes]] = []
        self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")

    def start(self, kind: str, *arguments: str, **environment: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [BIN / "dask", kind, "--scheduler-file", str(self.file), *arguments],
            cwd=self.folder,
            env=ENVIRONMENT | environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.all.append(process)
        return process

    def worker(self, **environment: str) -> subprocess.Popen[bytes]:
        return self.start(
            *("worker", "--no-nanny", "--nthreads", "1", "--no-dashboard", "--name"),
            f"w{len(self.all)}",
            **environment,
        )

    def end(self) -> None:
        for process in self.all:
            process.kill()
        for process in self.all:
            process.wait()


@pytest.fixture(scope="module")
def machines(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machines]:
    pytest.importorskip("distributed")
    made = Machines(tmp_path_factory.mktemp("machines"))
    try:
        made.workers = [made.worker(), made.worker()]  # type: ignore[attr-defined]
        until(lambda: made.file.is_file())
        yield made
    finally:
        made.end()


def until(reached: Any, seconds: float = 120.0) -> None:
    """Wait for something; long, because many tests may run beside this one."""
    end = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.05)


def client(folder: Path, *arguments: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [BIN / "gonio", *(str(a) for a in arguments)],
        cwd=folder,
        env=ENVIRONMENT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )


def done_in(folder: Path) -> int:
    return len(list(folder.glob("??/[0-9a-f]*")))


def test_two_workers_give_the_bits_of_none(machines: Machines, tmp_path: Path) -> None:
    shown = materials.load("gold")
    arguments: Any = {"environment": "studio", "size": (32, 32), "spp": 48, "seed": 0}
    (tmp_path / "note.txt").write_text("content")
    files = [Task.of(f"{WORK}:text_of", "note", file=tmp_path / "note.txt")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(passes, "PATHS_PER_SHARE", 32 * 32 * 4)
        cut = pictures.tasks(shown, arguments)
    assert len(cut) == 4  # 36 samples and three times 4
    tasks = [*cut, *files]
    here = values(Run(Here()).results(tasks))
    cluster = connect(str(machines.file), print)
    flying = 0

    def count(task: Task, found: Any) -> Any:
        nonlocal flying
        flying = max(flying, len(cluster.client.futures))
        return ()

    try:
        until(lambda: len(cluster.client.nthreads()) == 2)
        there = values(Run(cluster, RunFolder(tmp_path / "run")).results(tasks))
        # Back-pressure: of many tasks a few are on their way
        from collections import deque

        many = [Task.of(f"{WORK}:same", f"{n}", value=n) for n in range(100)]
        cluster.work(deque(many), lambda task: False, count)
    finally:
        cluster.close()
    assert there[-1] == here[-1] == "note.txt: content"
    assert [a.tobytes() for a in there[:-1]] == [a.tobytes() for a in here[:-1]]
    assert flying <= 2 * 2 + 1 + 1  # two for each worker, a file, and the one that is looked at


def test_an_erring_task_is_named_wherever_it_was_done(machines: Machines) -> None:
    cluster = connect(str(machines.file), print)
    tasks = [Task.of(f"{WORK}:unlucky", f"x = {x}", x=float(x), bad=2.0) for x in range(4)]
    tasks.append(Task.of("no.such.module:f", "nowhere"))
    run = Run(cluster)
    try:
        with pytest.warns(Notice, match="odd"):
            found = [done for _, done in run.results(tasks)]
    finally:
        cluster.close()
    assert [d.value for d in found if isinstance(d, Done)] == [0, 1, 9]
    assert [(f.title, f.reason) for f in run.failures] == [
        ("x = 2", "2 brings no luck."),
        ("nowhere", "ModuleNotFoundError: No module named 'no'"),
    ]


def test_other_code_is_refused_in_one_line(
    machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = Identity("9.9 code 0", identity().python, identity().packages, "llvm")
    monkeypatch.setattr("gonio.cluster.dask.identity", lambda: other)
    with pytest.raises(
        ClusterError, match=r"the worker at tcp:\S+ has gonio .* \(here 9.9 code 0\)"
    ):
        connect(str(machines.file), print)


def test_a_worker_that_joins_with_another_backend_gets_no_tasks(
    machines: Machines, tmp_path: Path
) -> None:
    cluster = connect(str(machines.file), print)
    stranger = machines.worker(GONIO_BACKEND="scalar")
    try:
        until(lambda: len(cluster.client.nthreads()) == 3)
        (tmp_path / "log").mkdir()
        tasks = squares(tmp_path / "log", 12, 0.05)
        with pytest.warns(Notice, match=r"has backend scalar \(here llvm\); it gets no tasks"):
            found = values(Run(cluster).results(tasks))
    finally:
        cluster.close()
        stranger.kill()
        stranger.wait()
    assert found == [x * x for x in range(12)]


SWEEP = ("sweep", "eon", "--vary", "roughness=0..1:2048", "--measure", "difference", "--against")


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL and SIGINT are POSIX's")
def test_killed_workers_and_clients_cost_nothing_that_is_done(
    machines: Machines, tmp_path: Path
) -> None:
    what = [*SWEEP, "oren_nayar", "-o", "a b.csv", "--cluster", machines.file]
    folder = tmp_path / "a b.csv.run"
    first = client(tmp_path, *what)
    until(lambda: done_in(folder) >= 1)
    killed = machines.workers[0]  # type: ignore[attr-defined]
    os.kill(killed.pid, signal.SIGKILL)
    before = done_in(folder)
    until(lambda: done_in(folder) >= before + 2)
    first.send_signal(signal.SIGINT)
    said, _ = first.communicate(timeout=60)
    assert first.returncode == 130, said
    assert "gonio: interrupted" in said
    kept = done_in(folder)
    assert 3 <= kept < 16
    assert [p.name for p in tmp_path.iterdir()] == ["a b.csv.run"]
    second = client(tmp_path, *what)  # one worker is left
    said, _ = second.communicate(timeout=120)
    assert second.returncode == 0, said
    assert f"{kept} of 16 tasks are done already" in said
    assert [p.name for p in tmp_path.iterdir()] == ["a b.csv"]  # no run folder any more
    assert run(*SWEEP, "oren_nayar", "-o", tmp_path / "none.csv").exit_code == 0
    assert (tmp_path / "a b.csv").read_bytes() == (tmp_path / "none.csv").read_bytes()


def test_nobody_who_answers_is_said_within_seconds(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    begin = time.monotonic()
    with pytest.raises(ClusterError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        connect("tcp://127.0.0.1:9", print)
    assert time.monotonic() - begin < 60
    (tmp_path / "x.json").write_text("{}")
    with pytest.raises(ClusterError, match="is no scheduler file"):
        connect(str(tmp_path / "x.json"), print)


def test_a_folder_of_files_is_fitted_and_a_damaged_one_named(tmp_path: Path) -> None:
    data = tmp_path / "data set"
    (data / "below").mkdir(parents=True)
    for name, model in (("a.csv", "lambert:rho=0.3"), ("below/b.csv", "lambert:rho=0.6")):
        assert run("data", model, "--convert", data / name).exit_code == 0
    (data / "notes.txt").write_text("no measurement")
    what = ("fit", data, "lambert", "--points", 200, "--starts", 9, "--json")
    kept = ("--run-dir", tmp_path / "run")
    first, again = (json.loads(run(*what, *kept).stdout) for _ in range(2))
    assert first == again  # to the last bit, and its seconds: nothing was done twice
    assert [Path(entry["data"]).name for entry in first] == ["a.csv", "b.csv"]
    for entry, rho in zip(first, (0.3, 0.6), strict=True):
        (found,) = entry["fits"]
        # Data without noise: EXACT of test_fit.py
        assert found["parameters"]["rho"] == pytest.approx([rho] * 3, abs=1e-5)
        assert len(found["starts"]) == 9
    text = (data / "a.csv").read_text(encoding="utf-8")
    (data / "below" / "b.csv").write_text(text[: len(text) // 2], encoding="utf-8")
    broken = run(*what[:-1], *kept)
    assert (broken.exit_code, "b.csv by lambert" in broken.output) in ((0, False), (1, True))
