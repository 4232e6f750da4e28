"""`gonio compare`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import click

from gonio.cli import _baseline as baselines
from gonio.cli._code import Code, code_options
from gonio.cli._numbers import Number
from gonio.cli.program import (
    check_params,
    complete,
    echo_json,
    json_option,
    param_option,
    plain_models,
    progress,
    was_given,
)
from gonio.foreign import is_foreign


@click.command("compare", short_help="Compare models with the truth, or with each other.")
@click.argument("models", nargs=-1, metavar="[MODEL|MATERIAL]...", shell_complete=complete)
@click.option(
    "--truth", is_flag=True, help="Compare layered models with random walks through layers."
)
@param_option
@click.option(
    "--vary", metavar="NAME", help="The parameter whose influence is shown (a roughness)."
)
@click.option("--walks", type=click.IntRange(1), help="Random walks for each pair of directions.")
@click.option("--no-pictures", is_flag=True, help="Numbers and maps only, which is faster.")
@click.option("--size", type=click.IntRange(16, 2048), default=192, help="Pixels of the pictures.")
@click.option("--spp", type=click.IntRange(1, 1 << 20), default=100, help="Samples per pixel.")
@click.option("--seed", type=click.IntRange(0, 65535), default=0, help="Of the random numbers.")
@click.option("-o", "--output", metavar="FILE", help="A .png file (default: compare.png).")
@click.option("--fit-parameters", is_flag=True, help="Of code: fit what only the model has.")
@click.option(
    "--tolerance", type=Number(0), metavar="X", help="Of code: differ by more, exit with 1."
)
@click.option(
    "--baseline",
    metavar="FILE.json",
    help="Of code: what an earlier run wrote with --json; only larger differences end with 1.",
)
@click.option("--identify", is_flag=True, help="Of code: say which model it is.")
@code_options
@json_option
def command(
    models: tuple[str, ...],
    truth: bool,
    params: tuple[str, ...],
    vary: str | None,
    walks: int | None,
    no_pictures: bool,
    size: int,
    spp: int,
    seed: int,
    output: str | None,
    fit_parameters: bool,
    tolerance: float | None,
    baseline: str | None,
    identify: bool,
    code: Code,
    as_json: bool,
) -> int:
    """Show how wrong models are, and where: error maps, numbers, and pictures side by side.

    With --truth every layered model is compared with the layers that it stands for, whose light is followed
    by random walks. FILE.glsl#FUNCTION, code that others wrote, is compared with the models beside it: the
    largest difference over all angles and common parameters, and where it is. Without either, the first
    model is what the others are compared with. --json prints numbers and writes a picture only with -o.

    \b
    Examples:
      gonio compare weidlich_wilkie triace_layered --truth -o layers.png
      gonio compare weidlich_wilkie:alpha=0.3,bounces=diffuse --truth --vary eta --json
      gonio compare my.glsl#diffuse eon --map "rough=roughness" --tolerance 1e-4
      gonio compare my.glsl#specular ue4 -o difference.png
      gonio compare my.glsl#specular --identify
      gonio compare eon:roughness=1 oren_nayar:sigma=1.2 qon:sigma=1.2
    """
    from gonio import compare as comparison
    from gonio.compare import drawing
    from gonio.materials import Material, load

    given: dict[str, Any] = {} if walks is None else {"walks": walks}
    if not models:
        raise click.UsageError("give a MODEL; 'gonio list' shows the models")
    models = tuple(code.named(text) for text in models)
    if is_foreign(models[0]):
        of_models = ("truth", "vary", "walks", "no_pictures", "size", "spp", "seed")
        if idle := [name for name in of_models if was_given(name)]:
            raise click.UsageError(
                f"code is compared with models as they are; it goes with no {_options(idle)}"
            )
        wanted = _Wanted(fit_parameters, tolerance, baseline, identify, output, as_json)
        return _code(models[0], models[1:], params, code, wanted)
    if code.given or fit_parameters or tolerance is not None or identify or baseline:
        raise click.UsageError(
            "--map, --tolerance and the like take FILE.glsl#FUNCTION before the models"
        )
    target = output or ("" if as_json else "compare.png")
    idle = [name for name in ("size", "spp") if was_given(name)]
    if idle and (no_pictures or not target):
        raise click.UsageError(f"{_options(idle)} is for pictures, and none are made")
    if target:
        drawing.check_format(target)
    check_params(models, params)
    shown = [load(text, params) for text in models]
    for material in shown:
        for note in material.plain()[1] if isinstance(material, Material) else ():
            click.echo(f"note: {note}", err=True)
    with progress("comparing") as step:
        found = comparison.compare(
            shown,
            truth=truth,
            pictures=bool(target) and not no_pictures,
            size=size,
            spp=spp,
            vary=vary,
            seed=seed,
            progress=step,
            **given,
        )
    if target:
        drawing.write(target, found)
    if as_json:
        echo_json([c.data() for c in found])
        return 0
    click.echo("\n".join(line for c in found for line in comparison.lines(c)))
    click.echo(target)
    return 0


def _options(names: Iterable[str]) -> str:
    return " or ".join(f"--{name.replace('_', '-')}" for name in names)


@dataclass(frozen=True)
class _Wanted:
    """What a comparison of code is to give."""

    fit_parameters: bool
    tolerance: float | None
    baseline: str | None
    identify: bool
    picture: str | None
    as_json: bool


def _code(
    text: str, models: tuple[str, ...], params: tuple[str, ...], code: Code, wanted: _Wanted
) -> int:
    """Compare code with models, or say which model it is."""
    from gonio.foreign import compare, maps
    from gonio.foreign import identify as identified
    from gonio.foreign.compared import EQUAL

    if not models and not wanted.identify:
        raise click.UsageError("give a MODEL to compare the code with, or --identify")
    if wanted.picture is not None:
        if not models:
            raise click.UsageError("-o draws the difference from a MODEL; name one")
        maps.check_format(wanted.picture)
    before = None if wanted.baseline is None else baselines.load(wanted.baseline, dict)
    foreign = code.load(text)
    beside = [
        code.load(other) if is_foreign(other) else plain_models([other], params)[0]
        for other in models
    ]
    with progress("comparing") as step:
        found = [compare(foreign, m, fit_parameters=wanted.fit_parameters) for m in beside]
        identity = identified(foreign, progress=step) if wanted.identify else None
    if wanted.picture is not None:
        maps.write(wanted.picture, found)
    data: dict[str, Any] = {"comparisons": [c.data() for c in found]}
    if identity is not None:
        data["identity"] = identity.data()
    equal = EQUAL if wanted.tolerance is None else wanted.tolerance
    change = None if before is None else baselines.comparisons(before, data, equal)
    since = change.lines(str(wanted.baseline)) if change is not None else []
    if wanted.as_json:
        echo_json(data)
        for line in since:
            click.echo(line, err=True)
    else:
        lines = [line for c in found for line in c.lines()]
        lines += [] if identity is None else identity.lines()
        lines += since
        lines += [wanted.picture] if wanted.picture is not None else []
        click.echo("\n".join(lines))
    if change is not None:
        return int(bool(change.worse))
    limit = wanted.tolerance
    return int(limit is not None and any(not c.largest <= limit for c in found))
