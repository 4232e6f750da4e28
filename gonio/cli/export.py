"""`gonio export`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from gonio.cli.program import check_params, complete, param_option, say, was_given
from gonio.export import FUNCTIONS, export
from gonio.export.buffer import RESOURCES
from gonio.export.files import exports, manifests, write
from gonio.export.host import OBJECTS
from gonio.export.selection import Selection, by_rows, choose, chosen_languages, named, tables_of
from gonio.export.targets import TARGETS
from gonio.export.text import LOOKUPS
from gonio.lights.catalogue import listed


@click.command("export", short_help="Write a model as shader or C++ source.")
@click.argument("models", nargs=-1, metavar="MODEL...", shell_complete=complete)
@click.option(
    "--to",
    "languages",
    multiple=True,
    metavar="LANGUAGE",
    help="glsl, essl, hlsl, wgsl, msl, slang, osl, cpp, cuda or mtlx (MaterialX); again for more, or all.",
)
@param_option
@click.option(
    "--option",
    "options",
    multiple=True,
    metavar="NAME=VALUE",
    help="An option of the model, which is fixed in the text; same as --param.",
)
@click.option("--all", "everything", is_flag=True, help="Every model, one file each.")
@click.option("--materials", is_flag=True, help="Every ready material, one file each.")
@click.option(
    "--lit",
    "lit",
    multiple=True,
    is_flag=False,
    flag_value="",
    metavar="[LIGHT,...]",
    help="A whole material function, shade, with lights: directional, image, ... (docs/real_time.md).",
)
@click.option(
    "--table",
    "tables",
    multiple=True,
    metavar="NAME,...",
    help="Look up fresnel, distribution or both in tables, in place of the functions (docs/real_time.md).",
)
@click.option(
    "--by-row",
    "by_row",
    metavar="NAME",
    help="With --table: one function for all MODELs, NAME_eval, whose parameter row says which it is.",
)
@click.option(
    "--bits",
    type=click.Choice(["8", "16"]),
    default="16",
    show_default=True,
    help="Of the numbers in a --table.",
)
@click.option(
    "--lookups",
    type=click.Choice(LOOKUPS),
    default="textures",
    show_default=True,
    help="With --lit or --table: from textures, from arrays in the text (tables), or left to the host.",
)
@click.option(
    "--only",
    metavar="NAME,...",
    help="Of eval, sample, pdf, albedo (default: all; with --lit eval).",
)
@click.option(
    "--embed", is_flag=True, help="Also NAME_material(), which gives the parameters' values."
)
@click.option(
    "--load",
    is_flag=True,
    help="Also NAME_load(values): the parameters from an array of four-component vectors.",
)
@click.option("--manifest", is_flag=True, help="Also a JSON file for programs that embed the text.")
@click.option("--prefix", metavar="NAME", help="Of what the models share (default: the model).")
@click.option("--prove", is_flag=True, help="Compile, run and compare with the model; no file.")
@click.option(
    "--rows",
    type=click.IntRange(100, 10_000_000),
    default=10_000,
    show_default=True,
    help="Directions and parameters that --prove tries.",
)
@click.option(
    "-o",
    "--output",
    metavar="PATH",
    help="A file, whose name says the language (x.wgsl), or a folder/.",
)
def command(
    models: tuple[str, ...],
    languages: tuple[str, ...],
    params: tuple[str, ...],
    options: tuple[str, ...],
    everything: bool,
    materials: bool,
    lit: tuple[str, ...],
    tables: tuple[str, ...],
    by_row: str | None,
    bits: str,
    lookups: str,
    only: str | None,
    embed: bool,
    load: bool,
    manifest: bool,
    prefix: str | None,
    prove: bool,
    rows: int,
    output: str | None,
) -> int:
    """Write MODELs as readable source: functions NAME_eval, _sample, _pdf, _albedo and a struct.

    In Slang they are methods: params.eval(wi, wo).

    A MODEL is a model (eon, or eon:albedo_form=fitted), a ready material, or a .toml or .py file;
    fast=eon:albedo_form=fitted gives it another name. Options are fixed in the text, parameters are
    members of the struct. Several models share one text, and its common parts.

    \b
    Examples:
      gonio export eon --to wgsl
      gonio export eon --option albedo_form=fitted --only eval -o eon.glsl
      gonio export orange_lacquer --to hlsl --embed
      gonio export eon torrance_sparrow --to cpp -o brdfs.h
      gonio export --all --to all -o shaders/
      gonio export eon --to wgsl --to glsl --prove
      gonio export my_model.py --to slang
      gonio export gold --manifest                      names, kinds, ranges, options
      gonio export gold --to wgsl --load --manifest -o host/
      gonio export paint=paint.binary --to wgsl -o host/    measured: the text and its tables
      gonio export ue4 --to hlsl --lit                  with lights
      gonio export ue4 --to glsl --lit directional,image --prove
      gonio export gold --to glsl --table fresnel,distribution -o host/
      gonio export gold copper --to glsl --table fresnel --by-row metals -o host/
    """
    lights = listed(lit) if lit else None
    if lights and not (models or everything or materials):
        raise click.UsageError(f"--lit took {lit[0]!r} for its lights; name the model before it")
    idle = {"--embed": embed, "--load": load, "--manifest": manifest, "--prefix": prefix}
    idle |= {"--output": output, "--lookups": was_given("lookups")}
    if prove and (unused := [option for option, value in idle.items() if value]):
        raise click.UsageError(f"--prove writes no file; leave out {' and '.join(unused)}.")
    if not prove and was_given("rows"):
        raise click.UsageError("--rows is for --prove; give that as well.")
    check_params([named(text)[1] for text in models], [*params, *options])
    selection = choose(models, [*params, *options], everything, materials)
    to = [] if manifest and not languages else chosen_languages(languages, output)
    if "all" in ",".join(languages).split(","):
        to = _able(to, selection, lit=lights is not None, tables=bool(tables))
    usual_functions = list(FUNCTIONS) if lights is None and not tables else ["eval"]
    functions = [name.strip() for name in only.split(",")] if only else usual_functions
    _check_lookups(lookups, to, lit=lights is not None, tables=bool(tables))
    request = tables_of(tables, int(bits), selection.found) if tables else None
    if by_row is not None:
        if request is None:
            raise click.UsageError("--by-row is for materials in a table; give --table fresnel.")
        selection, request = by_rows(selection, by_row, request)
    if load and not to:
        raise click.UsageError("--load adds to a text; say in which language with --to.")
    if prove:
        from gonio.export.prove.models import prove_models

        results = prove_models(
            selection.models, to, rows, functions, say, lit=lights, tables=request
        )
        click.echo("\n".join(results.lines))
        return 1 if results.failed else 0
    asked: dict[str, Any] = {"together": not (everything or materials), "only": functions}
    asked |= {"prefix": prefix, "lit": lights, "tables": request}
    made = exports(selection.models, to, embed=embed, load=load, lookups=lookups, **asked)
    files = made.files
    if manifest:
        files |= manifests(selection.found, **asked)
    in_text = lookups == "array" or all(language in OBJECTS for language in to)
    pictures = {} if in_text else made.pictures()
    if pictures and (output is None or (not output.endswith("/") and not Path(output).is_dir())):
        raise click.UsageError(
            f"a text and its tables are {len(files) + len(pictures)} files; give a folder: -o FOLDER/"
        )
    _show_or_write(files | pictures, output, [*made.notes(), *selection.notes])
    return 0


def _able(to: list[str], selection: Selection, *, lit: bool, tables: bool) -> list[str]:
    """Of all languages those that can do what is asked for; the others are noted."""
    if lit or tables:
        reason = "their renderers light surfaces" if lit else "they have no tables"
        selection.notes.append(f"OSL and MaterialX are left out: {reason}.")
        return [name for name in to if name in TARGETS and not TARGETS[name].shader]
    found = (export({name: model}, "wgsl")[0].buffer for name, model in selection.models.items())
    if any(buffer is not None for buffer in found):
        selection.notes.append("OSL and MaterialX are left out: they read no tables.")
        return [name for name in to if name in RESOURCES]
    return to


def _check_lookups(lookups: str, to: list[str], *, lit: bool, tables: bool) -> None:
    """Refuse options of tables and lights that would do nothing."""
    if not lit and not tables and was_given("lookups"):
        raise click.UsageError("--lookups is for lights and tables; give --lit or --table as well.")
    if lookups == "array" and not tables:
        raise click.UsageError("--lookups array is for tables; give --table as well.")
    arrays = [name for name in to if name in OBJECTS]
    if was_given("lookups") and tables and lookups == "textures" and arrays:
        raise click.UsageError(
            f"{TARGETS[arrays[0]].title} has its tables as arrays in the text; leave out --lookups."
        )
    if not tables and was_given("bits"):
        raise click.UsageError("--bits is for tables; give --table as well.")


def _show_or_write(files: Mapping[str, str | bytes], output: str | None, notes: list[str]) -> None:
    """Print a text that is alone, or write all files and print their names."""
    shown = [text for text in files.values() if isinstance(text, str)]
    if output is None and len(shown) == 1:
        click.echo(shown[0], nl=False)
        left = [name for name, content in files.items() if isinstance(content, bytes)]
        notes = [*notes, *(f"the text reads {name}, which -o FOLDER/ writes." for name in left)]
    else:
        for path in write(files, output):
            click.echo(path)
    for note in notes:
        click.echo(f"note: {note}", err=True)
