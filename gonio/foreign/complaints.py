"""What compilers complain about, at the line of the user's file."""

from __future__ import annotations

import re
from pathlib import Path

from gonio.foreign.harness import OWN
from gonio.foreign.source import FILE_LINES, ForeignError, Source

# What compilers write: g++ FILE:12:3:, slangc FILE(12) or, from 2026 on, --> FILE:12:3 below the message,
# Mesa 0:12(3), NVIDIA 0(12), naga wgsl:12:3.
_PLACES = (
    re.compile(r"^\s*(?P<file>[^\s:()]*?\.\w+|harness):(?P<line>\d+)(?::\d+)?:.*\berror\b"),
    re.compile(r"^\s*(?P<file>[^\s:()]*?\.\w+)\((?P<line>\d+)[^)]*\).*\berror\b"),
    re.compile(r"(?:^|ERROR:\s*)\d+:(?P<line>\d+)(?:\(\d+\))?:"),
    re.compile(r"^\d+\((?P<line>\d+)\)\s*:"),
    re.compile(r"wgsl:(?P<line>\d+):\d+"),
    re.compile(r"^\s*-+>\s*(?P<file>[^\s:()]*?\.\w+):(?P<line>\d+)(?::\d+)?\s*$"),
)


def refused(source: Source, message: str) -> ForeignError:
    """The first complaint of a compiler, at the line of the user's file."""
    lines = [line for line in message.splitlines() if line.strip()]
    errors = [line for line in lines if re.search(r"\berror\b", line, re.I)] or lines
    # wgpu puts naga's sentence below its own
    errors = [line for line in errors if line.strip() != "Validation Error"] or errors
    # slangc says only below what is undefined
    below = next((m[1] for line in lines if (m := re.match(r"\s*\|\s*\^+\s*(.+)", line))), "")
    if below and errors[0].startswith("error["):
        errors = [f"error: {below}", *errors]
    if source.entry:
        said = (
            re.sub(r"^.*?\berror\b[^:]*:\s*", "", errors[0], flags=re.I) if errors else "no message"
        )
        return ForeignError(f"{source.path}: the generated code does not compile: {said.strip()}")
    for line in [*errors, *lines]:
        for pattern in _PLACES:
            if match := pattern.search(line):
                return ForeignError(_quoted(source, match, line, errors[0]))
    return ForeignError(
        f"{source.path} does not compile: {errors[0].strip() if errors else 'no message'}"
    )


def _quoted(source: Source, match: re.Match[str], line: str, first: str) -> str:
    groups = match.groupdict()
    number = int(groups["line"])
    path: Path | None = source.path
    k, counted = divmod(number, FILE_LINES)
    if k == OWN:
        path = None
    elif k:
        path, number = source.files[k], counted
    elif groups.get("file"):
        name = Path(groups["file"])
        if name.name in ("harness", "code.cpp"):
            path = None
        elif name.name != source.path.name:
            path = name
    said = re.sub(r"^.*?\berror\b[^:]*:\s*", "", first, flags=re.I).strip() or line.strip()
    if path is None and re.search(
        r"no matching function for call to .(?:\w+::)*(\w+)::\1\(\)", said
    ):
        return (
            f"{source.path}: the class has a constructor that wants arguments; write a function of the "
            "directions and parameters that makes one and calls it."
        )
    if path is None:
        return f"{source.path} does not take the arguments that were read from it: {said}"
    try:
        text = path.read_text(encoding="utf-8", errors="replace").splitlines()[number - 1].strip()
    except (OSError, IndexError):
        text = ""
    return f"{path}:{number}: {said}" + (f"  |  {text}" if text else "")
