"""A long search for inputs that break a model in float32: resumable, and the same on every machine.

    gonio check eon --fuzz 1e9 --resume eon.json --record fuzz.md

Batch after batch of hard cases (`gonio.check.adversarial`), a quarter of them near the worst ones before:
eval, pdf, sample and the derivatives of each may not be NaN or infinite, nothing may be negative where none
is claimed, and float32 has to keep within the claimed distance of float64. The state after each batch
is all that the next one depends on.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.check.adversarial import EXTRA, Cases, hard_parameters
from gonio.check.finite import FLOAT32, MEANS, NAMES, float32_error, not_finite, promises
from gonio.check.gradient import METHODS, gradients
from gonio.check.kernels import evaluate
from gonio.check.report import FAIL, PASS, Finding, Report
from gonio.check.screen import LANES, MOVED, STEPS, Rows, cases, places, screen
from gonio.check.subject import Array, Subject
from gonio.claims import UNBOUNDED
from gonio.files import replacing

# Cases of a batch, within the first EARLY cases and after them: a search first learns where to look, and
# then spends no third of its time on Python's part of a batch.
BATCH, LARGE_BATCH = 1 << 17, 1 << 20
EARLY = 16 * BATCH

# How many of the worst cases are kept to look near them.
ELITE = 32

# Suspects are judged so many at a time.
JUDGED = 1 << 15

# A state is written so often, in seconds.
SAVED = 10.0

# Failures of one kind that are kept with their replay; all are counted.
SHOWN = 3

HEAD = (
    "| model | options | cases | not finite | derivatives | negative | float32 error | claimed | hours |\n"
    "| :-- | :-- | --: | --: | --: | --: | --: | --: | --: |\n"
)


@dataclass
class State:
    """What a search has done and found so far, for one choice of options."""

    model: str
    options: str
    cases: int = 0
    batches: int = 0
    seconds: float = 0.0
    error: float = 0.0
    """Largest relative error of float32."""
    error_replay: str = ""
    claimed: float = FLOAT32
    density_error: float = 0.0
    """The same of the density alone, where a model has a claim for it."""
    density_error_replay: str = ""
    density_claimed: float | None = None
    counts: dict[str, int] = field(default_factory=dict)
    """Failures by kind: "not finite", "derivatives", "negative"."""
    replays: dict[str, list[str]] = field(default_factory=dict)
    elite: list[list[float]] = field(default_factory=list)
    """Points of the worst cases."""
    values: list[float] = field(default_factory=list)
    """How bad they are."""

    @property
    def failed(self) -> bool:
        """Whether something has been found that is not as claimed."""
        return bool(self.counts) or not all(error <= most for _, error, most, _ in self.errors())

    def errors(self) -> list[tuple[str, float, float, str]]:
        """What float32 is compared in, the largest error, what is claimed, and the replay."""
        found = [("float32 error", self.error, self.claimed, self.error_replay)]
        if self.density_claimed is not None:
            found.append(
                (
                    "float32 error of the density",
                    self.density_error,
                    self.density_claimed,
                    self.density_error_replay,
                )
            )
        return found

    def row(self) -> str:
        """A line of the record."""
        kinds = (f"{self.counts.get(k, 0):,}" for k in ("not finite", "derivatives", "negative"))
        errors = self.errors()
        found, claimed = (", pdf ".join(f"{e[k]:.2g}" for e in errors) for k in (1, 2))
        return (
            f"| {self.model} | {self.options or '–'} | {self.cases:.2g} | {' | '.join(kinds)} | "
            f"{found} | {claimed} | {self.seconds / 3600:.2g} |"
        )


def run(
    subjects: Sequence[Subject],
    count: int,
    state_file: str | Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[State]:
    """Search `count` cases of a model, shared by its variants, on top of nothing or up to it.

    Args:
        subjects: the variants of one or of several models.
        count: cases of each model in all, those of a state that is resumed included.
        state_file: is read if it exists, and written every few seconds.
        progress: called with what is done and what there is to do.
    """
    path = None if state_file is None else Path(state_file)
    states = {(s.model, s.options): s for s in load(path)}
    shares = goals(subjects, count)
    own = [states.setdefault((s.name, s.tag()), State(s.name, s.tag())) for s in subjects]
    saved = time.monotonic()

    def between() -> None:
        nonlocal saved
        if progress is not None:
            done = sum(min(s.cases, g) for s, g in zip(own, shares, strict=True))
            progress(done, sum(shares))
        if path is not None and time.monotonic() - saved > SAVED:
            save(path, states.values())
            saved = time.monotonic()

    for subject, goal, state in zip(subjects, shares, own, strict=True):
        advance(subject, state, goal, between)
    if path is not None:
        save(path, states.values())
    return own


def goals(subjects: Sequence[Subject], count: int) -> list[int]:
    """Cases of each subject: those of a model are shared by its variants."""
    alike = {name: sum(s.name == name for s in subjects) for name in {s.name for s in subjects}}
    return [-(-count // alike[subject.name]) for subject in subjects]


def advance(
    subject: Subject, state: State, goal: int, between: Callable[[], None] | None = None
) -> None:
    """Try batch after batch until a state has come to a number of cases."""
    subject.prepare()
    for promise in promises(subject):
        size = subject.size(promise)
        setattr(state, FIELDS[promise][1], FLOAT32 if size is None else size.size)
    while state.cases < goal:
        if between is not None:
            between()
        most = BATCH if state.cases < EARLY else LARGE_BATCH
        batch(subject, state, min(most, goal - state.cases))


def batch(subject: Subject, state: State, count: int) -> None:
    """Try one batch of cases, and add what it has found to the state."""
    start = time.perf_counter()
    rows = _rows(subject, state, -(-count // LANES))
    found = screen(subject, rows, count)
    for some in _portions(found.wrong):
        suspects = cases(subject, rows, some)
        _values(subject, state, suspects)
        _negative(subject, state, suspects)
    for some in _portions(~np.isfinite(found.steep)):
        _derivatives(subject, state, cases(subject, rows, some))
    if subject.albedos == "composed" or subject.mean_closed:
        # Integrals and sums, of a few
        few = np.linspace(0, count - 1, min(MEANS, count)).astype(np.intp)
        _values(subject, state, cases(subject, rows, few))
    error = np.zeros(count)
    for promise, raw in found.errors.items():
        excused = _precision(subject, state, rows, promise, raw)
        # What is claimed more loosely is as bad where it is as near to its claim
        looser = 1 if promise == "float32" else getattr(state, FIELDS[promise][1]) / FLOAT32
        error = np.maximum(error, excused / looser)
    steep = np.where(np.isfinite(found.steep), found.steep, 0)
    badness = np.maximum(
        0.2 * np.log10(np.maximum(steep, 1)), np.log10(np.maximum(error, 1e-12)) + 12
    )
    _keep(state, rows, badness)
    state.cases += count
    state.batches += 1
    state.seconds += time.perf_counter() - start


# The state's fields for each promise: the largest error, what is claimed, and the replay.
FIELDS = {
    "float32": ("error", "claimed", "error_replay"),
    "float32_density": ("density_error", "density_claimed", "density_error_replay"),
}


def _precision(subject: Subject, state: State, rows: Rows, promise: str, error: Array) -> Array:
    """The errors without what is excused, of which the largest is noted."""
    largest, claimed, replay = FIELDS[promise]
    most = getattr(state, claimed)
    # Nothing is to be excused where nothing is promised
    told = 0.5 * (FLOAT32 if promise == "float32" else most) if most < UNBOUNDED else np.inf
    for some in _portions(~(error <= told)):
        error[some] = float32_error(subject, cases(subject, rows, some), told, promise).max(axis=1)
    worst = int(error.argmax())
    if not error[worst] <= getattr(state, largest):
        setattr(state, largest, float(error[worst]))
        one = cases(subject, rows, np.array([worst, worst]))
        columns = float32_error(subject, one, told, promise)[0]
        case = (one.parameters[0], one.wi[0], one.wo[0])
        shown = subject.replay(*case, double=False, compare="double")
        setattr(state, replay, f"{NAMES[int(columns.argmax())]}: {shown}")
    return error


def _rows(subject: Subject, state: State, count: int) -> Rows:
    """Parameters of a batch; a quarter near those of the worst cases, and so are their directions."""
    seed = 1_000_003 + 7 * state.batches
    parameters = hard_parameters(subject, count, seed)
    near = np.full((count, EXTRA), np.nan)
    if state.elite:
        rng = np.random.default_rng(seed)
        elite = np.array(state.elite)
        chosen = elite[rng.integers(0, len(elite), count // 4)]
        old, near[: len(chosen)] = np.split(chosen, [parameters.shape[1]], axis=1)
        steps = 10.0 ** rng.uniform(*STEPS, (len(chosen), 1)) * rng.normal(size=old.shape)
        moved = rng.random(old.shape) < MOVED
        parameters[: len(chosen)] = np.clip(old + np.where(moved, steps, 0), 0, 1)
    return Rows(parameters, near, seed)


def _portions(suspicious: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Numbers of the suspicious cases, so many at a time as are judged together."""
    numbers = np.flatnonzero(suspicious)
    return [numbers[first : first + JUDGED] for first in range(0, len(numbers), JUDGED)]


def _values(subject: Subject, state: State, suspects: Cases) -> None:
    wrong, number = not_finite(subject, suspects, True)
    _count(state, "not finite", number)
    for found in wrong:
        u = found.u if found.what == "sample" else None
        replay = subject.replay(found.parameters, found.wi, found.wo, double=False, u=u)
        _show(state, "not finite", f"{found.what} = {found.value}: {replay}")


def _negative(subject: Subject, state: State, suspects: Cases) -> None:
    if subject.size("negative") is not None:
        return
    index = np.arange(len(suspects), dtype=np.uint32)
    f, _ = evaluate(
        subject,
        suspects.parameters,
        index,
        suspects.wi,
        suspects.wo,
        single_precision=True,
        rounded=True,
    )
    rows = np.flatnonzero((f < 0).any(axis=1))
    _count(state, "negative", len(rows))
    for row in rows[:1]:
        case = (suspects.parameters[row], suspects.wi[row], suspects.wo[row])
        _show(
            state, "negative", f"eval = {f[row].min():.6g}: {subject.replay(*case, double=False)}"
        )


def _derivatives(subject: Subject, state: State, suspects: Cases) -> None:
    if not subject.differentiable:
        return
    for method in METHODS:
        for name, gradient in gradients(subject, suspects, method).items():
            bad = np.flatnonzero(~np.isfinite(gradient).all(axis=0))
            _count(state, "derivatives", len(bad))
            for row in bad[:1]:
                case = (suspects.parameters[row], suspects.wi[row], suspects.wo[row])
                u = suspects.u[row] if method == "sample" else None
                replay = subject.replay(*case, double=False, u=u, derivatives=True)
                _show(state, "derivatives", f"d {method} / d {name}: {replay}")


def _count(state: State, kind: str, number: int) -> None:
    if number:
        state.counts[kind] = state.counts.get(kind, 0) + number


def _show(state: State, kind: str, text: str) -> None:
    shown = state.replays.setdefault(kind, [])
    if len(shown) < SHOWN:
        shown.append(text)


def _keep(state: State, rows: Rows, badness: Array) -> None:
    """The worst case of each row of parameters, if it is among the worst of all."""
    count = len(badness)
    padded = np.full(len(rows.parameters) * LANES, -np.inf)
    padded[:count] = badness
    best = padded.reshape(-1, LANES).argmax(axis=1) + LANES * np.arange(len(rows.parameters))
    chosen = best[np.argsort(-padded[best])[: ELITE // 4]]
    points = np.concatenate([rows.parameters[chosen // LANES], places(rows, chosen)], axis=1)
    everything = [*zip(state.values, state.elite, strict=True)]
    everything += zip(padded[chosen].tolist(), points.tolist(), strict=True)
    everything.sort(key=lambda pair: -pair[0])
    state.values = [value for value, _ in everything[:ELITE]]
    state.elite = [point for _, point in everything[:ELITE]]


# --- files and reports ---------------------------------------------------------------------------


def load(path: Path | None) -> list[State]:
    """The states in a file; none if there is no file yet.

    Raises:
        ValueError: the file is none of this command's.
    """
    if path is None or not path.is_file():
        return []
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(entries, list):
            raise TypeError("it holds no list")
        return [State(**entry) for entry in entries]
    except (ValueError, TypeError) as error:
        raise ValueError(
            f"{path} is no state of gonio check --fuzz ({error}); give a new name to start afresh."
        ) from None


def save(path: Path, states: Iterable[State]) -> None:
    """Write all states; a run that is stopped leaves the last whole file."""
    with replacing(path) as temporary:
        temporary.write_text(json.dumps([asdict(s) for s in states]), encoding="utf-8")


def record(path: str | Path, states: Iterable[State]) -> None:
    """Write the table of all states, as docs/fuzz.md has it."""
    with replacing(Path(path)) as temporary:
        temporary.write_text(table(states), encoding="utf-8")


def table(states: Iterable[State]) -> str:
    """All states as a table, and how each failure is shown again."""
    states = list(states)
    text = HEAD + "\n".join(s.row() for s in states) + "\n"
    lines = [
        f"- {s.model}{f' ({s.options})' if s.options else ''}, {kind}: `{replay}`"
        for s in states
        for kind, replays in s.replays.items()
        for replay in replays[:1]
    ]
    return text + ("\n" + "\n".join(lines) + "\n" if lines else "")


def reports(states: Iterable[State]) -> list[Report]:
    """The same as reports, for the table and the exit code of the command."""
    found = []
    for state in states:
        findings = [
            Finding(
                kind,
                float(number),
                FAIL,
                f"of {state.cases:,} cases",
                state.options,
                state.replays[kind][0],
            )
            for kind, number in state.counts.items()
        ]
        findings += [
            Finding(
                what,
                error,
                PASS if error <= claimed else FAIL,
                f"at most {claimed:g} is claimed; {state.cases:,} cases",
                state.options,
                replay or None,
            )
            for what, error, claimed, replay in state.errors()
        ]
        found.append(Report("fuzz", state.model, tuple(findings), state.seconds))
    return found


def parse_count(text: str) -> int:
    """A number of cases, such as 1e9.

    Raises:
        ValueError: it is no number of at least one.
    """
    try:
        value: Any = float(text)
    except ValueError:
        value = math.nan
    if not 1 <= value < 1e15:
        raise ValueError(f"--fuzz takes a number of cases such as 1e6, got {text!r}.")
    return int(value)
