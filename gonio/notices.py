"""Notices: what was done to an input that its owner should know, though the work goes on."""

from __future__ import annotations

import warnings


class Notice(UserWarning):
    """A warning that commands print as one line, and that Python code may turn into an error."""


def notice(text: str) -> None:
    """Warn with a `Notice`; `text` names the input, what was found, and what was done."""
    warnings.warn(text, Notice, stacklevel=3)
