"""`gonio show`: what a model is, or what a material is made of."""

from __future__ import annotations

from typing import Any

import click

from gonio.cli.program import check_params, complete, echo_json, json_option, param_option
from gonio.description.about import describe, description
from gonio.materials import Material, library, load
from gonio.materials.notation import settings_of, split
from gonio.materials.toml_file import to_toml
from gonio.measured import source_of
from gonio.model import Model


@click.command("show", short_help="Show what a model is, and its parameters; or a material's file.")
@click.argument("model", shell_complete=complete)
@param_option
@json_option
def command(model: str, params: tuple[str, ...], as_json: bool) -> None:
    """Show what MODEL is: source, parameters, and what is known to be wrong with it.

    Of a ready material or a material file it shows the file, ready to be copied and changed.

    \b
    Examples:
      gonio show eon
      gonio show qon --json
      gonio show gold
      gonio show gold:alpha=0.4 > my_gold.toml
      gonio show my_model.py
    """
    check_params([model], params)
    found = load(model, params)
    if isinstance(found, Material):
        if as_json:
            echo_json(material_data(found))
        else:
            changed = bool(split(model)[1] or params)
            click.echo(material_text(found, changed), nl=False)
            click.echo(f"\n'gonio show {found.model.name}' describes its model.", err=True)
        return
    about = describe(found.written)
    measured = source_of(found.written) or source_of(type(found))
    if measured is not None:
        about["file"] = str(measured)
    given = dict(settings_of(found))
    if as_json:
        echo_json(about | ({"given": given} if given else {}))
        return
    click.echo("\n".join(description(about)))
    if given:
        lines = (f"  {path} = {value}" for path, value in given.items())
        click.echo("\n".join(["", "Given", *lines]))


def material_text(material: Material, changed: bool = False) -> str:
    """The file of a ready material as it is, or what would be the file of another one."""
    path = library().get(material.name)
    if path is None or changed:
        return to_toml(material)
    return path.read_text(encoding="utf-8")


def material_data(material: Material) -> dict[str, Any]:
    """A material as plain dicts that JSON can hold."""
    return {
        "name": material.name,
        "description": material.description,
        "model": material.model.name,
        "values": _values(material.model),
        "textures": {path: str(picture) for path, picture in material.textures.items()},
        "flakes": material.flakes,
        "growth": "mesh" if material.grows else None,
    }


def _values(model: Model) -> dict[str, Any]:
    """Values of all parameters and options by name, inner models as dicts with their model's name."""
    values: dict[str, Any] = {}
    for name in model.fields:
        value = getattr(model, name)
        inner = isinstance(value, Model)
        values[name] = {"model": value.name, **_values(value)} if inner else value
    return values
