"""What got worse or better since an earlier run, whose `--json` is the baseline."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
    if not isinstance(found, kind) or not _whole(found):
        raise BaselineError(f"{path} is not what the same command with --json writes.")
    return found


def _whole(found: Any) -> bool:
    """Whether a file has all that is compared."""
    try:
        if isinstance(found, list):
            return all(
                isinstance(f["verdict"], str) and {"measured", "text"} <= f.keys()
                for _, f in _findings(found)
            )
        return all(_number(c["largest"]) >= 0 for c in _compared(found).values())
    except (TypeError, KeyError, AttributeError):
        return False


@dataclass(frozen=True)
class Change:
    """What has changed since a baseline, one line each."""

    worse: list[str]
    better: list[str]
    unknown: list[str]
    """What the baseline says nothing about."""

    def lines(self, path: str) -> list[str]:
        """For people."""
        found = [*self.worse, *self.better]
        found += [f"{path} has nothing of {name}: all of it counts as new" for name in self.unknown]
        return found if self.worse else [*found, f"nothing is worse than in {path}"]


def checks(before: Sequence[Mapping[str, Any]], now: Sequence[Mapping[str, Any]]) -> Change:
    """Findings that fail now and did not before, or whose measure changed, or that are judged no more."""
    known = dict(_findings(before))
    worse, better = [], []
    for key, finding in _findings(now):
        model, check, what, _ = key
        size, old = finding["measured"], known.get(key)
        text = f"{model}, {check}, {what} = {_shown(size)}"
        failed = old is not None and old["verdict"] == "fail"
        was = "new" if old is None else f"was {_shown(old['measured'])}"
        if finding["verdict"] == "unsure":
            if old is None or old["verdict"] != "unsure":
                worse.append(f"worse: {text} (cannot be judged any more): {finding['text']}")
        elif finding["verdict"] != "fail":
            if failed:
                better.append(f"better: {text} ({was})")
        elif old is None or not failed:
            was = was if old is None else f"passed with {_shown(old['measured'])}"
            worse.append(f"worse: {text} ({was}): {finding['text']}")
        elif _number(size) > _number(old["measured"]) * (1 + GROWN):
            worse.append(f"worse: {text} ({was}): {finding['text']}")
        elif _number(size) * (1 + GROWN) < _number(old["measured"]):
            better.append(f"better: {text} ({was}), and fails still")
    had = {r["model"] for r in before}
    unknown = [m for m in dict.fromkeys(r["model"] for r in now) if m not in had]
    return Change(worse, better, unknown)


_Key = tuple[str, str, str, str]


def _findings(reports: Sequence[Mapping[str, Any]]) -> list[tuple[_Key, Mapping[str, Any]]]:
    return [
        ((r["model"], r["check"], f["what"], str(f["options"])), f)
        for r in reports
        for f in r["findings"]
    ]


def _compared(found: Mapping[str, Any]) -> dict[tuple[str, str], Mapping[str, Any]]:
    return {(c["code"], c["model"]): c for c in found["comparisons"]}


def comparisons(before: Mapping[str, Any], now: Mapping[str, Any], equal: float) -> Change:
    """Differences that grew beyond what counts as equal, or became less."""
    known = _compared(before)
    worse, better, unknown = [], [], []
    for key, c in _compared(now).items():
        old = known.get(key)
        limit = equal if old is None else max(equal, _number(old["largest"]) * (1 + GROWN))
        was = "new" if old is None else f"was {_shown(old['largest'])}"
        text = f"{c['code']} differs from {c['model']} by {c['largest']:.4g} ({was})"
        if not c["largest"] <= limit:
            worse.append(f"worse: {text}")
        elif old is None:
            unknown.append(f"{c['code']} and {c['model']}")
        elif max(c["largest"], equal) * (1 + GROWN) < _number(old["largest"]):
            better.append(f"better: {text}")
    return Change(worse, better, unknown)


def _number(value: Any) -> float:
    """A measure, which JSON has as a word if it is not finite."""
    try:
        return abs(float(value))
    except (TypeError, ValueError):
        return float("inf")


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, (int, float)) else str(value)
