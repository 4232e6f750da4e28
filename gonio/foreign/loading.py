"""From a file's name to a function that is running."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from gonio.foreign import library, materialx, python_code
from gonio.foreign.function import (
    Foreign,
    Returns,
    parse_map,
    parse_ranges,
    parse_returns,
    parse_uniforms,
    probe,
    split,
)
from gonio.foreign.harness import text as harness_text
from gonio.foreign.process import MEMORY, SECONDS, Running
from gonio.foreign.returned import measure
from gonio.foreign.roles import match
from gonio.foreign.source import ForeignError, Source, blank_comments, read
from gonio.foreign.textures import assumed, filled
from gonio.foreign.textures import check as check_textures
from gonio.foreign.textures import parse as parse_textures


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
    signature: str | None = None,
    sample: str | None = None,
    pdf: str | None = None,
    albedo: str | None = None,
    textures: Iterable[str] = (),
    seconds: float = SECONDS,
    memory: int = MEMORY,
) -> Foreign:
    """Read, compile and start a function of foreign code.

    Args:
        text: FILE, FILE#FUNCTION, module:function, or FILE.mtlx#NODE@TARGET.
        function: its name, if not in the text. "Struct.method" and "namespace::name" work.
        mapping: each "ARGUMENT=FORMULA ...", where the names do not tell.
        ranges: each "PARAMETER=LOW..HIGH".
        uniforms: each "NAME=VALUE": numbers that stay fixed.
        defines: macros, NAME or NAME=VALUE.
        include: folders of headers.
        returns: one of RETURNS; None to measure it.
        signature: of a function in a compiled library, in C.
        sample: the function that draws directions, of the same file or as FILE#FUNCTION.
        pdf: that of their density.
        albedo: that of the directional albedo.
        textures: each "NAME=VALUE", or "NAME=FILE.png" for samplers of GLSL.
        seconds: after which a call is given up.
        memory: that it may use, in bytes.

    Raises:
        ForeignError: anything that does not work, in one line.
    """
    told = parse_returns(returns) if returns else None
    if (sample is None) != (pdf is None):
        raise ForeignError(
            f"{text}: --sample and --pdf go together; a sampler is judged by its density."
        )
    if signature is not None and not library.is_library(text):
        raise ForeignError(f"{text}: --signature is for compiled libraries; code says it itself.")
    file, named = split(text)
    start = _Start(
        dict(parse_map(mapping)),
        parse_ranges(ranges),
        parse_uniforms(uniforms),
        tuple(defines),
        tuple(include),
        seconds,
        memory,
        parse_textures(textures),
    )
    if materialx.is_materialx(text):
        source = materialx.read(text if named or not function else f"{text}#{function}")
        told = told or Returns(1.0, 1, True)
    elif library.is_library(text):
        source = library.read(text, function or named, signature)
    elif (parts := python_code.split_python(text)) is not None:
        source, function = python_code.read(text), parts[1]
    else:
        source = read(file, include, defines)
    check_textures(source, start.textures)
    missing = {n: assumed(n)[1] for n in source.textures if n not in start.textures}
    source = start.textured(source)
    shipped = None
    if (full := full_precision(source)) is not None:
        shipped = start(source, function or named, text, "value")
        source = full
    foreign = start(source, function or named, text, "value")
    foreign.returns = told or Returns()
    foreign.textures = missing
    foreign.raw(*probe(8))
    if told is None:
        foreign.returns = measure(foreign)
    if shipped is not None:
        shipped.returns = foreign.returns
        foreign.shipped = shipped
    others = {"sample": sample, "pdf": pdf, "albedo": albedo}
    beside = {kind: start.beside(foreign, name, kind) for kind, name in others.items() if name}
    foreign.sampler, foreign.density = beside.get("sample"), beside.get("pdf")
    foreign.reflectance = beside.get("albedo")
    return foreign


def full_precision(source: Source) -> Source | None:
    """The code with highp for mediump and lowp, where drivers heed these; None without any.

    The formula is judged in float32, and what half precision makes of it by the difference.
    """
    if source.language != "essl":
        return None
    bare = blank_comments(source.text)
    found = list(re.finditer(r"\b(?:mediump|lowp)\b", bare))
    text = source.text
    for at in reversed(found):
        text = f"{text[: at.start()]}highp{text[at.end() :]}"
    return replace(source, text=text) if found else None


@dataclass(frozen=True)
class _Start:
    """How functions are compiled and started."""

    mapping: dict[str, str]
    ranges: dict[str, tuple[float, float]]
    uniforms: dict[str, str]
    defines: tuple[str, ...]
    include: tuple[str, ...]
    seconds: float
    memory: int
    textures: dict[str, str]

    def __call__(
        self, source: Source, name: str | None, label: str, kind: str, strict: bool = True
    ) -> Foreign:
        """A function that is running.

        Args:
            source: its file.
            name: which one.
            label: for people.
            kind: of `gonio.foreign.roles.KINDS`.
            strict: whether all that options name has to be found in this function.
        """
        found = source.find(name)
        matched = match(source, found, self.mapping, self.ranges, self.uniforms, kind, strict)
        running = Running(
            source,
            harness_text(source, found, matched, self.defines),
            matched.columns,
            include=self.include,
            defines=self.defines,
            seconds=self.seconds,
            memory=self.memory,
            textures=self.textures,
        )
        return Foreign(source, found, matched, running, label=label)

    def textured(self, source: Source) -> Source:
        """The code with values for all of its textures."""
        for name in source.textures:
            self.textures.setdefault(name, assumed(name)[0])
        return filled(source, self.textures)

    def beside(self, main: Foreign, text: str, kind: str) -> Foreign:
        """A function beside the main one, of its file if no other is named."""
        file, name = split(text)
        if name is None and main.source.language != "library":
            source, name = main.source, text
        elif main.source.language == "python" and file.endswith(".py"):
            source = python_code.read(text)
        elif main.source.language == "library":
            raise ForeignError(
                f"{main.source.path}: functions of a library beside the first need a file of C++ that "
                f"calls them; give --{kind} FILE.cpp#FUNCTION."
            )
        else:
            source = self.textured(read(file, self.include, self.defines))
        return self(source, name, text, kind, strict=False)
