"""What `gonio export` does, for Python as well: named models in, files or text out."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import click
from click.core import ParameterSource

from gonio.cli.program import check_params, complete, param_option, say
from gonio.export import materialx
from gonio.export.buffer import RESOURCES
from gonio.export.entry import Export
from gonio.export.files import manifests, texts, write
from gonio.export.lit import export_lit
from gonio.export.targets import TARGETS
from gonio.export.text import FUNCTIONS, export
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


def run_proof(
    models: Mapping[str, Model],
    to: Sequence[str],
    rows: int,
    only: Sequence[str] = FUNCTIONS,
    progress: Callable[[str], None] = lambda text: None,
    *,
    lit: Sequence[str] | None = None,
) -> Proven:
    """Export models, compile and run them, and compare with the float64 models.

    With `lit`, names of lights or none for the usual ones, the material function is compared too; what it
    looks up is then computed by formulas.

    Raises:
        ProofError: a compiler or runtime is not installed.
        ExportError: what cannot be exported.
    """
    from gonio.export.prove import each_way, table
    from gonio.export.prove import prove as compare

    runnable = [language for language in to if language != materialx.NAME]
    if not runnable:
        raise ExportError(
            "MaterialX's documents are not run by --prove; prove essl, which has the same formulas."
        )

    def exported(name: str, model: Model, language: str) -> Export:
        if lit is None:
            return export({name: model}, language, only=only)[0]
        return export_lit(model, name, lit or usual(model), language, only=only, textures=False)

    pairs = [
        (model, way)
        for name, model in models.items()
        for language in runnable
        for way in each_way(exported(name, model, language))
    ]
    proofs = compare(pairs, rows, progress=progress)
    return Proven(table(proofs).splitlines(), not all(p.holds for p in proofs))


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
    "--lookups",
    type=click.Choice(["textures", "host"]),
    default="textures",
    show_default=True,
    help="With --lit: how pictures and tables are looked up, or only declared for the host to define.",
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
      gonio export ue4 --to hlsl --lit                  with lights
      gonio export ue4 --to glsl --lit directional,image --prove
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
    usual_functions = list(FUNCTIONS) if lights is None else ["eval"]
    functions = [name.strip() for name in only.split(",")] if only else usual_functions
    if lights is not None and "all" in ",".join(languages).split(","):
        to = [name for name in to if name in TARGETS and not TARGETS[name].shader]
        selection.notes.append("OSL and MaterialX are left out: their renderers light surfaces.")
    elif "all" in ",".join(languages).split(",") and _has_tables(selection.models):
        to = [name for name in to if name in RESOURCES]
        selection.notes.append("OSL and MaterialX are left out: they read no tables.")
    if lights is None and lookups != "textures":
        raise click.UsageError("--lookups is for lights; give --lit as well.")
    if load and not to:
        raise click.UsageError("--load adds to a text; say in which language with --to.")
    if prove:
        results = run_proof(selection.models, to, rows, functions, say, lit=lights)
        click.echo("\n".join(results.lines))
        if results.failed:
            sys.exit(1)
        return
    files = texts(
        selection.models,
        to,
        together=not (everything or materials),
        only=functions,
        prefix=prefix,
        embed=embed,
        load=load,
        lit=lights,
        textures=lookups == "textures",
    )
    if manifest:
        files |= manifests(
            selection.found,
            together=not (everything or materials),
            only=functions,
            prefix=prefix,
            lit=lights,
        )
    shown = [text for text in files.values() if isinstance(text, str)]
    if output is None and len(shown) == 1:
        click.echo(shown[0], nl=False)
        left = [name for name, content in files.items() if isinstance(content, bytes)]
        selection.notes.extend(f"the text reads {name}, which -o FOLDER/ writes." for name in left)
    else:
        for path in write(files, output):
            click.echo(path)
    for note in selection.notes:
        click.echo(f"note: {note}", err=True)
