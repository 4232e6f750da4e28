"""Proves that exports compute what their models do: compiles them, runs them, compares, tabulates.

from gonio.export import export
from gonio.export.prove import prove, table
model = gonio.model("eon")
proofs = prove([(model, e) for e in export({"eon": model}, "wgsl")])
print(table(proofs))
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gonio.claims import UNBOUNDED
from gonio.export.entry import Entry, Export
from gonio.export.prove import judge, rows
from gonio.export.prove.harness import GIVEN, WIDTHS, split
from gonio.export.prove.lit import codes, lit_rows, with_stand_ins
from gonio.export.prove.runners import RUNNERS
from gonio.export.prove.tabled import tabled
from gonio.export.prove.tools import ProofError, Rows
from gonio.export.text import has_own_albedo
from gonio.model import Model

ROWS = 10_000

# Albedos without a closed form are sums over many directions, in the export as well as in the model.
ALBEDO_ROWS = 40

# Such a sum may miss what is sharp at grazing angles; in this share of the rows it is as exact as promised.
ALBEDO_MOST = 0.9


Known = dict[Any, dict[str, judge.Expected]]
"""What models compute, by the object and the parameters that vary, and by function."""


@dataclass(frozen=True)
class Proof:
    """One function of one export, compared with the float64 model; or why that was not possible."""

    model: str
    language: str
    function: str
    """One of eval, sample, pdf, albedo; "compile" for an export that a compiler refused."""
    device: str
    """What ran it."""
    rows: int
    error: float
    """Relative error (of a direction, absolute) in the row that comes nearest to its tolerance."""
    tolerance: float
    """What is allowed there."""
    reason: str
    """Why that much is allowed."""
    median: float
    """Error of the median row."""
    where: dict[str, Any]
    """That row: wi, wo, u, the parameters, what was computed (got) and what is right (expected)."""
    seconds: float
    """What the language took for all exports of this run, compiling included."""
    failure: str = ""
    """What is wrong; empty where the proof succeeds."""
    note: str = ""

    @property
    def holds(self) -> bool:
        """Whether the function computes what the model does."""
        return not self.failure


def prove(
    pairs: Sequence[tuple[Model, Export]],
    count: int = ROWS,
    *,
    seed: int = 0,
    known: Known | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Proof]:
    """Compile and run exports, and compare them with the models they came from.

    Args:
        pairs: models, with the options that were exported, and their exports in any languages. What an
            export takes as a parameter is varied; other parameters keep the model's values.
        count: rows of inputs, random and adversarial.
        seed: of the inputs.
        known: filled with what the models compute; give it to another call with the same models, count and
            seed to save that time.
        progress: called with a line of text before each step.

    Raises:
        ProofError: a compiler or runtime is not installed, or does not work at all.
    """
    found: dict[tuple[int, str], Proof] = {}
    known = {} if known is None else known
    languages = list(dict.fromkeys(export.language for _, export in pairs))
    inputs = [_inputs(m, e, count, seed) for m, e in pairs]
    pairs = [(_as_exported(m, e), e) for m, e in pairs]
    tables = [codes(e) for _, e in pairs]
    pairs = [(m, with_stand_ins(e, len(r))) for (m, e), r in zip(pairs, inputs, strict=True)]
    for language in languages:
        if language not in RUNNERS:
            raise ProofError(f"nothing can run {language!r}; there are {', '.join(RUNNERS)}.")
        numbers = [k for k, (_, export) in enumerate(pairs) if export.language == language]
        progress(f"{language}: compiling and running {len(numbers)} exports")
        start = time.perf_counter()
        jobs = [job for k in numbers for job in _jobs(k, pairs[k][1], inputs[k])]
        given = [_with_codes(j.rows, tables[j.number]) for j in jobs]
        results = RUNNERS[language]([j.export for j in jobs], given)
        seconds = time.perf_counter() - start
        for job, outputs in zip(jobs, results.outputs, strict=True):
            model, export = pairs[job.number]
            if not isinstance(outputs, ProofError):
                outputs = outputs[: len(job.rows)]
            progress(f"{language}: comparing {export.entry.prefix}")
            entry = export.entry
            computed = known.setdefault((id(model), entry.members, entry.lights), {})
            for proof in _compare(model, job, outputs, results.device, seconds, computed):
                found[job.number, proof.function] = proof
    order = ["compile", *WIDTHS]
    keys = sorted(found, key=lambda key: (key[0], order.index(key[1])))
    return [found[key] for key in keys]


def _as_exported(model: Model, export: Export) -> Any:
    """The model, with tables where its export has them."""
    return model if export.tables is None else tabled(model, export)


def _inputs(model: Model, export: Export, count: int, seed: int) -> Rows:
    if "shade" in export.entry.functions:
        return lit_rows(model, export.entry, count, seed)
    return rows.rows_for(model, export.entry.members, count, seed)


def _with_codes(rows: Rows, codes: Rows) -> Rows:
    """Rows with a table behind them, as further rows that nobody looks at."""
    if not len(codes):
        return rows
    padded = np.zeros((-(-len(codes) // rows.shape[1]), rows.shape[1]), np.float32)
    padded.ravel()[: len(codes)] = codes
    return np.concatenate([rows, padded])


@dataclass(frozen=True)
class _Job:
    number: int
    export: Export
    rows: Rows


def _jobs(number: int, export: Export, inputs: Rows) -> list[_Job]:
    """An export to run on all rows; where its albedo is a long sum, that apart on few rows."""
    entry = export.entry
    if "albedo" not in entry.functions or export.albedo_tolerance == 0:
        return [_Job(number, export, inputs)]
    jobs = []
    rest = tuple(f for f in entry.functions if f != "albedo")
    if rest:
        jobs.append(_Job(number, replace(export, entry=replace(entry, functions=rest)), inputs))
    if export.albedo_tolerance is not None:
        alone = replace(export, entry=replace(entry, functions=("albedo",)))
        jobs.append(_Job(number, alone, inputs[:ALBEDO_ROWS]))
    return jobs


def _compare(
    model: Model,
    job: _Job,
    outputs: Rows | ProofError,
    device: str,
    seconds: float,
    known: dict[str, judge.Expected],
) -> list[Proof]:
    export, entry = job.export, job.export.entry
    exactness = judge.device_for(export.language, device)
    proof = Proof(
        model=entry.prefix,
        language=export.language,
        function="compile",
        device=device,
        rows=0,
        error=np.inf,
        tolerance=0.0,
        reason=exactness.reason,
        median=np.inf,
        where={},
        seconds=seconds,
    )
    if isinstance(outputs, ProofError):
        return [replace(proof, failure=str(outputs))]
    proofs = []
    for function, got in split(entry, outputs).items():
        sampled = function == "albedo" and bool(export.albedo_tolerance)
        # Of an albedo made of those of models inside, only these are sums of samples
        kind = "sampled albedo" if sampled and not has_own_albedo(model) else function
        if kind not in known:
            known[kind] = judge.expect(model, entry, kind, job.rows)
        verdict = judge.judge(model, entry, kind, job.rows, got, exactness, known[kind])
        failure, note = verdict.failure, verdict.note
        if sampled:
            if kind == function:
                errors = np.abs(got - known[kind].value).max(-1)
                failure = failure if "not finite" in failure else ""
            else:
                errors = judge.albedo_rule_errors(model, entry, job.rows, known[kind])
            usual, largest = float(np.quantile(errors, ALBEDO_MOST)), float(errors.max())
            note = f"a sum of samples, off by {usual:.1e} in most places, {largest:.1e} at most"
            # Where the albedo has no bound, no number of samples gives it.
            if not failure and _bounded(model) and usual > (export.albedo_tolerance or 0):
                failure = f"{note}; {export.albedo_tolerance} is promised"
        where = _where(entry, job.rows[verdict.worst])
        where |= {"got": verdict.got, "expected": verdict.expected}
        proofs.append(
            replace(
                proof,
                function=function,
                rows=verdict.rows,
                error=verdict.error,
                tolerance=verdict.tolerance,
                median=verdict.median,
                where=where,
                failure=failure,
                note=note,
            )
        )
    return proofs


def _bounded(model: Model) -> bool:
    """Whether a model and those inside it claim an albedo with a bound."""
    values = {name: getattr(model, name) for name in model.fields}
    options = {name: value for name, value in values.items() if isinstance(value, str)}
    inner = [value for value in values.values() if isinstance(value, Model)]
    return model.claims.size("energy", options) != UNBOUNDED and all(map(_bounded, inner))


def _where(entry: Entry, row: Rows) -> dict[str, Any]:
    """A row by names."""
    found: dict[str, Any] = {
        "wi": row[:3].tolist(),
        "wo": row[3:6].tolist(),
        "u": row[6:8].tolist(),
    }
    column = GIVEN
    for member in entry.members:
        value = row[column : column + member.width].tolist()
        found[member.path] = value if member.width == 3 else value[0]
        column += member.width
    return found


def table(proofs: Sequence[Proof]) -> str:
    """The proofs as text: a line per model and function, a column per language; then what failed.

    A cell has the relative error in the row that comes nearest to its tolerance.
    """
    languages = list(dict.fromkeys(p.language for p in proofs))
    lines = list(dict.fromkeys((p.model, p.function) for p in proofs))
    cells = {(p.model, p.function, p.language): _cell(p) for p in proofs}
    name = max([len(m) for m, _ in lines] + [len("model")])
    wide = max([len(c) for c in cells.values()] + [len(n) for n in languages])
    text = [f"{'model':<{name}}  {'':<7}  " + "  ".join(f"{n:>{wide}}" for n in languages)]
    for model, function in lines:
        row = [cells.get((model, function, n), "") for n in languages]
        text.append(f"{model:<{name}}  {function:<7}  " + "  ".join(f"{c:>{wide}}" for c in row))
    text.append("")
    for language in languages:
        first = next(p for p in proofs if p.language == language)
        text.append(f"{language}: {first.device}, {first.seconds:.1f} s")
    for reason in dict.fromkeys(p.reason for p in proofs):
        names = dict.fromkeys(p.language for p in proofs if p.reason == reason)
        text.append(f"Tolerance for {', '.join(names)}: {reason}.")
    usual = max((p.median for p in proofs if p.rows), default=0.0)
    text.append(
        "Cells: relative error in the row nearest to its tolerance (of sample, the direction's or the "
        f"density's); the median row of every cell is off by {usual:.1e} or less. ! marks what failed."
    )
    notes = list(dict.fromkeys(f"{p.model} {p.function}: {p.note}." for p in proofs if p.note))
    failures = [describe(p) for p in proofs if not p.holds]
    return "\n".join([*text, *notes, *failures])


def _cell(proof: Proof) -> str:
    return f"{proof.error:.1e}" if proof.holds else f"{proof.error:.1e}!"


def describe(proof: Proof) -> str:
    """A proof as a sentence with the row that comes nearest to its tolerance, or shows the failure."""
    if proof.function == "compile":
        return f"FAILED {proof.failure}"
    facts = ", ".join(f"{name}={value}" for name, value in proof.where.items())
    return (
        f"{'' if proof.holds else 'FAILED '}{proof.model} in {proof.language}: {proof.function} is "
        f"{proof.failure or 'right'}; error {proof.error:.2g} where {proof.tolerance:.2g} is allowed, "
        f"at {facts}"
    )
