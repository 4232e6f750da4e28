"""Options of commands that take code which others wrote."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import click

from gonio import foreign
from gonio.cli._numbers import Number
from gonio.cli.program import plain_materials
from gonio.foreign import Foreign, ForeignError, is_foreign
from gonio.materials import Material, notation
from gonio.model import Model


@dataclass(frozen=True)
class Code:
    """What the options say."""

    function: str | None
    mapping: tuple[str, ...]
    ranges: tuple[str, ...]
    uniforms: tuple[str, ...]
    defines: tuple[str, ...]
    include: tuple[str, ...]
    returns: str | None
    signature: str | None
    sample: str | None
    pdf: str | None
    albedo: str | None
    textures: tuple[str, ...]
    seconds: float | None

    @property
    def given(self) -> bool:
        """Whether any of them was given."""
        lists = (
            self.mapping,
            self.ranges,
            self.uniforms,
            self.defines,
            self.include,
            self.textures,
        )
        words = (self.function, self.returns, self.signature, self.sample, self.pdf, self.albedo)
        return any(lists) or any(option is not None for option in (*words, self.seconds))

    def named(self, text: str) -> str:
        """The text with the function of --function, where a file of Python is code because of it."""
        return f"{text}#{self.function}" if self.function and text.endswith(".py") else text

    def refuse(self) -> None:
        """There is no code that the options could be about.

        Raises:
            ForeignError: one of them was given.
        """
        if self.given:
            raise ForeignError(
                "--function, --map and the like belong to a FILE of code, such as x.glsl#eval."
            )

    def models(self, texts: Iterable[str], params: Iterable[str] = ()) -> list[Model]:
        """The models that texts name, and code as a model: x.glsl#ggx:roughness=0.3.

        Raises:
            ValueError: as `materials`.
        """
        found = self.materials(texts, params)
        return [one.model if isinstance(one, Material) else one for one in found]

    def materials(self, texts: Iterable[str], params: Iterable[str] = ()) -> list[Model | Material]:
        """As `models`; materials keep their names.

        Raises:
            ValueError: as `plain_models`, or options of code without any code.
        """
        texts = [self.named(text) for text in texts]
        code = [_code_in(text) for text in texts]
        if not any(code):
            self.refuse()
        found: list[Model | Material] = []
        loaded: dict[str, Model] = {}
        for text, name in zip(texts, code, strict=True):
            if name is None:
                found += plain_materials([text], params)
                continue
            if name not in loaded:
                loaded[name] = foreign.as_model(self.load(name))
            rest = text.removeprefix(name).removeprefix(":")
            pieces = rest.split(",") if rest else []
            named = {piece.partition("=")[0].strip() for piece in pieces}
            given = [p for p in params if p.partition("=")[0].strip() not in named]
            changed = notation.assign(loaded[name], [*given, *pieces], _no_inner)
            assert isinstance(changed, Model)
            found.append(changed)
        return found

    def load(self, text: str) -> Foreign:
        """The function that a text and the options name, running."""
        limit: dict[str, Any] = {} if self.seconds is None else {"seconds": self.seconds}
        return foreign.load(
            text,
            function=self.function,
            mapping=self.mapping,
            ranges=self.ranges,
            uniforms=self.uniforms,
            defines=self.defines,
            include=self.include,
            returns=self.returns,
            signature=self.signature,
            sample=self.sample,
            pdf=self.pdf,
            albedo=self.albedo,
            textures=self.textures,
            **limit,
        )


def _code_in(text: str) -> str | None:
    """The name of code in a text that may have parameters behind it."""
    name, pieces = notation.split(text)
    if pieces and "=" in pieces[0]:
        return name if is_foreign(name) else None
    return text if is_foreign(text) else None


def _no_inner(text: str) -> Model:
    raise ForeignError(f"{text!r}: code has no model inside.")


OPTIONS = (
    click.option("--function", metavar="NAME", help="Of code: the function, as after FILE#."),
    click.option(
        "--map",
        "mapping",
        multiple=True,
        metavar='"ARG=WHAT ..."',
        help="Of code: what arguments are: wi, wo, normal, tangent, bitangent, half, a name, a formula.",
    ),
    click.option(
        "--range", "ranges", multiple=True, metavar="NAME=LOW..HIGH", help="Of a parameter of code."
    ),
    click.option(
        "--uniform", "uniforms", multiple=True, metavar="NAME=VALUE", help="A number that code has."
    ),
    click.option("-D", "defines", multiple=True, metavar="NAME[=VALUE]", help="A macro of code."),
    click.option(
        "-I", "include", multiple=True, metavar="FOLDER", help="Where code includes files from."
    ),
    click.option(
        "--returns",
        metavar='"f|f cos|pi f|pi f cos"',
        help="What code gives back, if not as measured.",
    ),
    click.option(
        "--signature", metavar="C", help="Of a compiled library: how its function is declared in C."
    ),
    click.option(
        "--sample", metavar="NAME", help="Of code: the function that samples, beside the first."
    ),
    click.option("--pdf", metavar="NAME", help="Of code: the density of its samples."),
    click.option("--albedo", metavar="NAME", help="Of code: its directional albedo."),
    click.option(
        "--texture",
        "textures",
        multiple=True,
        metavar="NAME=FILE|VALUE",
        help="What a texture has: 0.5, 0.8/0.3/0.1 or, in GLSL, a picture (default: white).",
    ),
    click.option(
        "--time-limit",
        "seconds",
        type=Number(0.1),
        help="Seconds for a call of code (default: 20).",
    ),
)


def code_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of code to a command, which gets them as one argument `code`."""

    @functools.wraps(command)
    def packed(**given: Any) -> Any:
        code = Code(**{name: given.pop(name) for name in Code.__dataclass_fields__})
        return command(code=code, **given)

    for option in reversed(OPTIONS):
        packed = option(packed)
    return packed
