"""What people are told: notices of what was done to their input, and the name that they may have meant."""

from __future__ import annotations

import difflib
import warnings
from collections.abc import Iterable


class Notice(UserWarning):
    """A warning that commands print as one line, and that Python code may turn into an error."""


def notice(text: str) -> None:
    """Warn with a `Notice`; `text` names the input, what was found, and what was done."""
    warnings.warn(text, Notice, stacklevel=3)


def nearest(name: str, known: Iterable[str], most: int = 1) -> list[str]:
    """The known names that somebody may have meant, the nearest first; none if none is near."""
    return difflib.get_close_matches(name, list(known), n=most)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """ "did you mean 'eon'? " for the nearest of the known names; "" if none is near."""
    near = nearest(name, known)
    return f"did you mean {near[0]!r}? " if near else ""
