"""Processes that share the checks: the same results, the same errors, and none that stays behind."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import gonio
from gonio import check
from gonio.check.named import subjects_of
from gonio.cli import main
from gonio.cluster import Task, checks, processes
from gonio.cluster.processes import Processes

BROKEN = Path(__file__).parent / "broken"

# Seconds in which a process has to come up, on a machine with other work.
PATIENCE = 60.0


def until(condition: Any) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_other_processes_do_the_last_tasks_and_what_kills_them_is_done_here() -> None:
    whose = [
        Task.of("os:getpid", "its number"),
        Task.of("os:_exit", "which ends it", status=3),
        Task.of("os:getpid", "its number"),
    ]
    steps: list[tuple[int, int]] = []
    with Processes(1) as others:

        def here(number: int) -> int:
            until(lambda: number != 0 or others._landed.qsize() == 2)
            return -number

        found = others.results(len(whose), lambda n: whose[n], here, lambda *s: steps.append(s))
    assert found[:2] == [0, -1]
    assert found[2] not in (0, os.getpid())
    assert steps[0] == (0, 3)


def test_an_error_here_ends_the_processes() -> None:
    def here(number: int) -> None:
        raise KeyboardInterrupt

    started: list[subprocess.Popen[bytes]] = []
    start = processes._start
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(processes, "_start", lambda: started.append(start()) or started[-1])
        with pytest.raises(KeyboardInterrupt), Processes(2) as others:
            others.results(1, lambda n: Task.of("os:getpid", "its number"), here)
    assert [process.poll() is None for process in started] == [False, False]


def test_where_none_can_be_started_all_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused() -> None:
        raise BlockingIOError("no process is left to this user")

    monkeypatch.setattr(processes, "_start", refused)
    with Processes(3) as others:
        found = others.results(2, lambda n: Task.of("os:getpid", "its number"), lambda n: n)
        assert others.results(0, lambda n: Task.of("os:getpid", ""), lambda n: n) == []
    assert found == [0, 1]


def test_a_process_ends_with_the_one_that_asked_for_it() -> None:
    process = processes._start()
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stdout.read(processes.HEAD) == bytes(processes.HEAD)  # it is there
    process.stdin.close()  # as when who asked is killed
    assert process.wait(PATIENCE) == 0
    process.stdout.close()


@pytest.fixture
def others_do_all_but_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    results = Processes.results

    def patched(self: Processes, count: int, task: Any, here: Any, progress: Any = None) -> Any:
        def first(number: int) -> Any:
            assert number == 0
            until(lambda: self._landed.qsize() == count - 1)
            return here(0)

        return results(self, count, task, first, progress)

    monkeypatch.setattr(Processes, "results", patched)


@pytest.mark.usefixtures("others_do_all_but_the_first")
@pytest.mark.parametrize("text", ["ward", str(BROKEN / "non_reciprocal.py")])
def test_checks_find_the_same_bit_by_bit_in_any_number_of_processes(text: str) -> None:
    def found(count: int) -> list[Any]:
        only = ["reciprocity", "isotropy"]
        with checks.beside(count) as runner:
            reports = check.check_subjects(subjects_of(text), "quick", only, None, runner)
        return [(r.check, r.verdict, [repr((f, f.case)) for f in r.findings]) for r in reports]

    alone = found(0)
    assert found(2) == alone
    assert (alone[0][1] == "FAIL") == text.endswith(".py")  # what is broken is found there as well


def test_processes_are_started_where_they_are_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Mine(gonio.Model, register=False):  # which no other process knows
        def eval(self, wi: Any, wo: Any) -> Any:
            return wi

    monkeypatch.setattr(checks.dr, "thread_count", lambda: 64)
    ward, lambert = (check.subjects(gonio.model(name)) for name in ("ward", "lambert"))
    assert checks.worthwhile([ward], "quick") == len(ward) * len(check.CHECKS) // 4
    assert checks.worthwhile([lambert], "normal") == checks.MOST
    assert checks.worthwhile([lambert], "quick") == len(check.CHECKS) // 4
    assert checks.worthwhile([lambert], "quick", ["energy", "sampling"]) == 1
    assert checks.worthwhile([ward], "normal", ["energy"]) == 1
    assert checks.worthwhile([ward], "thorough") == 1
    assert checks.worthwhile([check.subjects(Mine)], "normal") == 1


def test_processes_that_would_have_no_effect_are_refused(tmp_path: Path) -> None:
    code = tmp_path / "matte.glsl"
    code.write_text("vec3 brdf(vec3 L, vec3 V, vec3 N) { return vec3(0.1); }\n", encoding="utf-8")
    for words, said in (
        (["eon", "--thorough"], "--thorough uses all cores"),
        (["eon", "--fuzz", "1e3"], "--fuzz uses all cores"),
        (["eon", "--cluster", "local"], "--cluster and --run-dir share"),
        ([f"{code}#brdf"], "check matte.glsl#brdf without it"),
    ):
        refused = CliRunner().invoke(main, ["check", *words, "--processes", "2"])
        assert refused.exit_code == 2
        assert said in refused.stderr
