"""What `gonio export` does, for Python as well: named models in, files or text out."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import click
from click.core import ParameterSource

from gonio.cli.program import check_params, complete, param_option, say
from gonio.export import materialx
from gonio.export.buffer import RESOURCES
from gonio.export.coded import ARRAY_PLACES, Request
from gonio.export.entry import Export
from gonio.export.files import exports, manifests, write
from gonio.export.host import OBJECTS
from gonio.export.lit import export_lit
from gonio.export.targets import TARGETS
from gonio.export.text import FUNCTIONS, LOOKUPS, PROVABLE, export
from gonio.export.tree import ExportError
from gonio.lights.catalogue import listed, usual
from gonio.materials import Material, library, load
from gonio.model import Model
from gonio.model import models as registered


@dataclass(frozen=True)
class Selection:
    """Models by the names that their functions get, and what a user has to know of them."""

    models: dict[str, Model] = field(default_factory=dict)
    found: dict[str, Model | Material] = field(default_factory=dict)
    """The same, with what drives the materials' parameters."""
    notes: list[str] = field(default_factory=list)


def choose(
    texts: Iterable[str],
    params: Sequence[str] = (),
    everything: bool = False,
    materials: bool = False,
) -> Selection:
    """Find models from text: a model, a material, a .toml or .py file; NAME=... gives it another name.

    Args:
        texts: what to find.
        params: parameters and options for each of them, "name=value".
        everything: all models in place of texts.
        materials: all ready materials in place of texts.

    Raises:
        ModelError: an unknown model, parameter or option.
        ExportError: two models with the same name, or nothing to choose.
    """
    wanted = list(texts)
    if (everything or materials) and (wanted or params):
        raise ExportError("--all and --materials take no models and no parameters.")
    if everything:
        wanted += registered()
    if materials:
        wanted += library()
    if not wanted:
        raise ExportError("nothing to export; name a model, such as eon, or give --all.")
    check_params([re.sub(r"^[A-Za-z]\w*=", "", text) for text in wanted], params)
    found = Selection()
    for text in wanted:
        renamed = re.fullmatch(r"([A-Za-z]\w*)=(.+)", text)
        name, thing = (renamed[1], renamed[2]) if renamed else ("", text)
        what = load(thing, params)
        model = what.model if isinstance(what, Material) else what
        name = name or re.sub(r"\W", "_", what.name)
        if name in found.models:
            raise ExportError(
                f"two exports are called {name!r}; give one another name: other_{name}={thing}."
            )
        found.models[name] = model
        found.found[name] = what
        if isinstance(what, Material):
            found.notes.extend(_notes(name, what))
    return found


def _notes(name: str, material: Material) -> list[str]:
    """What the host has to feed, because it is not a number."""
    notes = [
        f"{name}: {path} comes from {picture.name}; read that texture into the struct."
        for path, picture in material.textures.items()
    ]
    if material.flakes:
        notes.append(
            f"{name}: {' and '.join(material.driven_by_maps())} come from a map of flakes; "
            "gonio.mitsuba.textures.flake_map makes it."
        )
    if material.grows:
        notes.append(
            f"{name}: growth comes from the mesh; gonio.mitsuba.textures.add_growth makes it."
        )
    return notes


def by_extension(output: str) -> str:
    """The language of a file's name, such as wgsl of x.wgsl; empty if it says none."""
    extension = Path(output).suffix.removeprefix(".")
    return next((t.name for t in TARGETS.values() if t.extension == extension), "")


def chosen_languages(names: Sequence[str], output: str | None = None) -> list[str]:
    """The languages that are asked for; "all" is all of them, none that of the file's name.

    Raises:
        ExportError: none is named, or another one than the file's name says.
    """
    found = [part for name in names for part in name.split(",") if part]
    of_file = by_extension(output or "")
    if not found and of_file:
        return [of_file]
    named = TARGETS.get(found[0]) if len(found) == 1 else None
    if of_file and named and named.extension != TARGETS[of_file].extension:
        raise ExportError(
            f"--to {named.name} and {output} do not agree; leave out --to, or name the file "
            f"NAME.{named.extension}."
        )
    if not found:
        known = ", ".join(TARGETS)
        raise ExportError(f"no language; add --to and one of {known}, {materialx.NAME}, all.")
    if "all" in found:
        return [*TARGETS, materialx.NAME]
    return list(dict.fromkeys(found))


@dataclass(frozen=True)
class Proven:
    """The outcome of a proof."""

    lines: list[str]
    failed: bool


# Languages whose proofs read tables from a buffer.
BUFFERED = ("glsl", "wgsl")


def run_proof(
    models: Mapping[str, Model],
    to: Sequence[str],
    rows: int,
    only: Sequence[str] = FUNCTIONS,
    progress: Callable[[str], None] = lambda text: None,
    *,
    lit: Sequence[str] | None = None,
    tables: Request | None = None,
) -> Proven:
    """Export models, compile and run them, and compare with the float64 models.

    With `lit`, names of lights or none for the usual ones, the material function is compared too; what it
    looks up is then computed by formulas. With `tables`, texts are compared with the tables' own
    interpolation in NumPy, and that with the models; where they are arrays in shaders, D has fewer entries.

    Raises:
        ProofError: a compiler or runtime is not installed.
        ExportError: what cannot be exported.
    """
    from gonio.export.prove import each_way, table
    from gonio.export.prove import prove as compare

    if tables is not None and "eval" not in only:
        raise ExportError("tables stand for functions that eval calls; prove that as well.")
    runnable = [language for language in to if language != materialx.NAME]
    if not runnable:
        raise ExportError(
            "MaterialX's documents are not run by --prove; prove essl, which has the same formulas."
        )

    def exported(name: str, model: Model, language: str) -> Export:
        used, lookups = tables, "host"
        if tables is not None and language not in BUFFERED:
            lookups = PROVABLE
            if language not in OBJECTS:
                used = replace(tables, places=ARRAY_PLACES)
        if lit is None:
            made = export({name: model}, language, only=only, tables=used, lookups=lookups)
            return made[0]
        lights = lit or usual(model)
        return export_lit(model, name, lights, language, only=only, tables=used, lookups=lookups)

    pairs = [
        (model, way)
        for name, model in models.items()
        for language in runnable
        for way in each_way(exported(name, model, language))
    ]
    proofs = compare(pairs, rows, progress=progress)
    lines = table(proofs).splitlines()
    if tables is not None:
        for name, model in models.items():
            lines += _table_errors(name, model, tables, rows)
    return Proven(lines, not all(p.holds for p in proofs))


def _table_errors(name: str, model: Model, tables: Request, rows: int) -> list[str]:
    """What the tables cost a material, row by row and as a whole."""
    from gonio.export.prove.tabled import price

    made = export({name: model}, "cpp", only=["eval"], tables=tables)[0]
    assert made.tables is not None
    lines = [line for one in made.tables.all for line in one.said()]
    return [f"{name}: {line}" for line in [*lines, price(model, made, rows)]]


def _request(names: Sequence[str], bits: int, found: Mapping[str, Model | Material]) -> Request:
    """The tables that are asked for; what textures and meshes drive is in none of them."""
    kinds = tuple(dict.fromkeys(part.strip() for name in names for part in name.split(",")))
    varying: set[str] = set()
    for what in found.values():
        if isinstance(what, Material):
            varying |= {*what.textures, *what.driven_by_maps()}
    return Request(kinds, bits, frozenset(varying))


def _in_text(to: Sequence[str], lookups: str) -> bool:
    """Whether every text has its tables as arrays."""
    return lookups == "array" or all(language in OBJECTS for language in to)


def _has_tables(models: Mapping[str, Model]) -> bool:
    """Whether a model reads tables."""
    found = (export({name: model}, "wgsl")[0].buffer for name, model in models.items())
    return any(buffer is not None for buffer in found)


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
@click.option("--embed", is_flag=True, help="Also a function that gives the parameters' values.")
@click.option("--load", is_flag=True, help="Also a function that takes the values from a buffer.")
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
@click.pass_context
def command(
    ctx: click.Context,
    models: tuple[str, ...],
    languages: tuple[str, ...],
    params: tuple[str, ...],
    options: tuple[str, ...],
    everything: bool,
    materials: bool,
    lit: tuple[str, ...],
    tables: tuple[str, ...],
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
) -> None:
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
    """
    lights = listed(lit) if lit else None
    if lights and not (models or everything or materials):
        raise click.UsageError(f"--lit took {lit[0]!r} for its lights; name the model before it")
    idle = {"--embed": embed, "--load": load, "--manifest": manifest, "--prefix": prefix}
    idle |= {"--output": output, "--lookups": lookups != "textures"}
    if prove and (named := [option for option, value in idle.items() if value]):
        raise click.UsageError(f"--prove writes no file; leave out {' and '.join(named)}.")
    if not prove and ctx.get_parameter_source("rows") is ParameterSource.COMMANDLINE:
        raise click.UsageError("--rows is for --prove; give that as well.")
    selection = choose(models, [*params, *options], everything, materials)
    to = [] if manifest and not languages else chosen_languages(languages, output)
    usual_functions = list(FUNCTIONS) if lights is None and not tables else ["eval"]
    functions = [name.strip() for name in only.split(",")] if only else usual_functions
    if (lights is not None or tables) and "all" in ",".join(languages).split(","):
        to = [name for name in to if name in TARGETS and not TARGETS[name].shader]
        reason = "their renderers light surfaces" if lights is not None else "they have no tables"
        selection.notes.append(f"OSL and MaterialX are left out: {reason}.")
    elif "all" in ",".join(languages).split(",") and _has_tables(selection.models):
        to = [name for name in to if name in RESOURCES]
        selection.notes.append("OSL and MaterialX are left out: they read no tables.")
    if lights is None and not tables and lookups != "textures":
        raise click.UsageError("--lookups is for lights and tables; give --lit or --table as well.")
    if lookups == "array" and not tables:
        raise click.UsageError("--lookups array is for tables; give --table as well.")
    arrays = [name for name in to if name in OBJECTS]
    asked = ctx.get_parameter_source("lookups") is ParameterSource.COMMANDLINE
    if asked and tables and lookups == "textures" and arrays:
        raise click.UsageError(
            f"{TARGETS[arrays[0]].title} has its tables as arrays in the text; leave out --lookups."
        )
    if not tables and ctx.get_parameter_source("bits") is ParameterSource.COMMANDLINE:
        raise click.UsageError("--bits is for tables; give --table as well.")
    request = _request(tables, int(bits), selection.found) if tables else None
    if load and not to:
        raise click.UsageError("--load adds to a text; say in which language with --to.")
    if prove:
        results = run_proof(selection.models, to, rows, functions, say, lit=lights, tables=request)
        click.echo("\n".join(results.lines))
        if results.failed:
            sys.exit(1)
        return
    made = exports(
        selection.models,
        to,
        together=not (everything or materials),
        only=functions,
        prefix=prefix,
        embed=embed,
        load=load,
        lit=lights,
        tables=request,
        lookups=lookups,
    )
    files = made.files
    if manifest:
        files |= manifests(
            selection.found,
            together=not (everything or materials),
            only=functions,
            prefix=prefix,
            lit=lights,
            tables=request,
        )
    pictures = {} if _in_text(to, lookups) else made.pictures()
    if pictures and (output is None or (not output.endswith("/") and not Path(output).is_dir())):
        raise click.UsageError(
            f"a text and its tables are {len(files) + len(pictures)} files; give a folder: -o FOLDER/"
        )
    files |= pictures
    shown = [text for text in files.values() if isinstance(text, str)]
    if output is None and len(shown) == 1:
        click.echo(shown[0], nl=False)
        left = [name for name, content in files.items() if isinstance(content, bytes)]
        selection.notes.extend(f"the text reads {name}, which -o FOLDER/ writes." for name in left)
    else:
        for path in write(files, output):
            click.echo(path)
    for one in made.tables.values():
        for said in (line for table in one.all for line in table.said()):
            click.echo(f"note: {said}", err=True)
        if one.left:
            click.echo(f"note: no table for {', '.join(one.left)}, whose index varies.", err=True)
    for note in selection.notes:
        click.echo(f"note: {note}", err=True)
