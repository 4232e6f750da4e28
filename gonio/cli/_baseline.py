"""What got worse since an earlier run, whose `--json` is the baseline."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

# Searches find a little more or less from one machine to another: a finding that fails is worse if its
# measure grew by more than this part.
GROWN = 0.05


class BaselineError(ValueError):
    """A file that is no baseline; the message says how one is made."""


def load(path: str, kind: type) -> Any:
    """What an earlier run wrote.

    Args:
        path: of the file.
        kind: list for checks, dict for comparisons.

    Raises:
        BaselineError: no such file, or something else in it.
    """
    try:
        found = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise BaselineError(
            f"{path}: {error.strerror or error}; the same command with --json > {path} makes it."
        ) from None
    except ValueError:
        found = None
    if not isinstance(found, kind):
        raise BaselineError(f"{path} is not what the same command with --json writes.")
    return found


def worse_checks(
    before: Sequence[Mapping[str, Any]], now: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Findings that fail now and did not before, or whose measure grew; one line each."""
    known = dict(_findings(before))
    found = []
    for key, finding in _findings(now):
        if finding["verdict"] != "fail":
            continue
        model, check, what, _ = key
        size, old = finding["measured"], known.get(key)
        if old is None or old["verdict"] != "fail":
            was = "new" if old is None else f"passed with {_shown(old['measured'])}"
        elif _number(size) > _number(old["measured"]) * (1 + GROWN):
            was = f"was {_shown(old['measured'])}"
        else:
            continue
        found.append(f"worse: {model}, {check}, {what} = {_shown(size)} ({was}): {finding['text']}")
    return found


def _findings(
    reports: Sequence[Mapping[str, Any]],
) -> list[tuple[tuple[str, ...], Mapping[str, Any]]]:
    return [
        ((r["model"], r["check"], f["what"], str(f["options"])), f)
        for r in reports
        for f in r["findings"]
    ]


def worse_comparisons(before: Mapping[str, Any], now: Mapping[str, Any], equal: float) -> list[str]:
    """Differences that grew beyond what counts as equal; one line each."""
    known = {(c["code"], c["model"]): c for c in before.get("comparisons", ())}
    found = []
    for c in now["comparisons"]:
        old = known.get((c["code"], c["model"]))
        limit = equal if old is None else max(equal, old["largest"] * (1 + GROWN))
        if not c["largest"] <= limit:
            was = "new" if old is None else f"was {old['largest']:.4g}"
            found.append(
                f"worse: {c['code']} differs from {c['model']} by {c['largest']:.4g} ({was})"
            )
    return found


def _number(value: Any) -> float:
    """A measure, which JSON has as a word if it is not finite."""
    try:
        return abs(float(value))
    except (TypeError, ValueError):
        return float("inf")


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, (int, float)) else str(value)
