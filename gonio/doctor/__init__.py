"""What gonio finds on this machine, and what to do about what is missing.

    for finding in gonio.doctor.diagnose():
        print(finding.status, finding.name, finding.value)

Everything that might end a process (an LLVM that does not fit, a broken GPU driver) is tried in
processes of its own, so that looking never crashes.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

from gonio.doctor import findings, probes
from gonio.doctor.findings import Finding
from gonio.version import __version__

__all__ = ["SYMBOLS", "Finding", "can_compute", "diagnose", "report"]

SYMBOLS = {"ok": "✓", "absent": "–", "broken": "✗"}


def diagnose() -> list[Finding]:
    """Look at versions, backends, GPU, kernel cache and optional packages. Never raises.

    Takes about two seconds: every backend compiles and runs a small kernel in its own process.
    """
    started = {name: probes.start(name) for name in probes.PROBES}
    answers = {name: probes.answer(process) for name, process in started.items()}
    checks: list[tuple[str, Callable[[], Finding]]] = [
        ("Python", findings.python),
        ("gonio", lambda: Finding("gonio", "ok", __version__)),
        ("Dr.Jit", lambda: findings.package("Dr.Jit", "drjit", "pip install drjit")),
        ("NumPy", lambda: findings.package("NumPy", "numpy", "pip install numpy")),
        ("Mitsuba", lambda: findings.mitsuba(answers["mitsuba"])),
        ("LLVM", lambda: findings.llvm(answers["llvm"])),
        ("vector width", lambda: findings.vector_width(answers["llvm"])),
        ("threads", lambda: findings.threads(answers["llvm"])),
        ("GPU", lambda: findings.gpu(answers["cuda"])),
        ("backend", lambda: findings.chosen_backend(answers)),
        ("kernel cache", lambda: findings.kernel_cache()),
        *((name, functools.partial(findings.optional, name)) for name in findings.OPTIONAL),
        ("g++", findings.compiler),
        *((name, functools.partial(findings.prover, name)) for name in findings.PROVERS),
    ]
    return [_guarded(name, check) for name, check in checks]


def can_compute(found: Sequence[Finding]) -> bool:
    """Whether a compiled backend (llvm or cuda) computes models here, and not plain Python."""
    return any(f.name == "backend" and f.status != "broken" for f in found)


def report(found: Sequence[Finding]) -> str:
    """The findings as lines of text: a mark, a name, a value, and what to do."""
    width = max((len(f.name) for f in found), default=0)
    lines = []
    for f in found:
        lines.append(f"{SYMBOLS[f.status]} {f.name:<{width}}  {f.value}")
        if f.advice:
            lines.append(f"  {'':<{width}}  → {f.advice}")
    return "\n".join(lines)


def _guarded(name: str, check: Callable[[], Finding]) -> Finding:
    try:
        return check()
    except Exception as error:  # a doctor that crashes helps nobody
        return Finding(name, "broken", f"could not be found out: {type(error).__name__}: {error}")
