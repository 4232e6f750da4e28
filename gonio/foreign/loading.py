"""From a file's name to a function that is running."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from gonio.foreign.function import (
    Foreign,
    Returns,
    parse_map,
    parse_ranges,
    parse_returns,
    probe,
    split,
)
from gonio.foreign.harness import text as harness_text
from gonio.foreign.materialx import is_materialx
from gonio.foreign.materialx import read as read_materialx
from gonio.foreign.process import MEMORY, SECONDS, Running
from gonio.foreign.returned import measure
from gonio.foreign.roles import match
from gonio.foreign.source import read


def load(
    text: str,
    *,
    function: str | None = None,
    mapping: Iterable[str] = (),
    ranges: Iterable[str] = (),
    uniforms: Iterable[str] = (),
    defines: Sequence[str] = (),
    include: Sequence[str] = (),
    returns: str | None = None,
    seconds: float = SECONDS,
    memory: int = MEMORY,
) -> Foreign:
    """Read, compile and start a function of foreign code.

    Args:
        text: FILE or FILE#FUNCTION.
        function: its name, if not in the text. "Struct.method" and "namespace::name" work.
        mapping: each "ARGUMENT=FORMULA ...", where the names do not tell.
        ranges: each "PARAMETER=LOW..HIGH".
        uniforms: each "NAME=VALUE": numbers that stay fixed.
        defines: macros, NAME or NAME=VALUE.
        include: folders of headers.
        returns: one of RETURNS; None to measure it.
        seconds: after which a call is given up.
        memory: that it may use, in bytes.

    Raises:
        ForeignError: anything that does not work, in one line.
    """
    file, named = split(text)
    if is_materialx(text):
        source = read_materialx(text if named or not function else f"{text}#{function}")
        returns = returns or "f cos"
    else:
        source = read(file, include)
    found = source.find(function or named)
    told = parse_returns(returns) if returns else None
    matched = match(source, found, parse_map(mapping), parse_ranges(ranges), parse_map(uniforms))
    running = Running(
        source,
        harness_text(source, found, matched, defines),
        matched.columns,
        include=include,
        defines=defines,
        seconds=seconds,
        memory=memory,
    )
    foreign = Foreign(source, found, matched, running, told or Returns(), text)
    foreign.raw(*probe(8))
    if told is None:
        foreign.returns = measure(foreign)
    return foreign
