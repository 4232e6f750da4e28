"""`gonio show`."""

from __future__ import annotations

import click

from gonio.cli.program import complete, echo_json, json_option


@click.command("show", short_help="Show what a model is, and its parameters.")
@click.argument("model", shell_complete=complete)
@json_option
def command(model: str, as_json: bool) -> None:
    """Show what MODEL is: source, parameters, and what is known to be wrong with it.

    \b
    Examples:
      gonio show eon
      gonio show qon --json
    """
    from gonio import description

    about = description.describe(model)
    if as_json:
        echo_json(about)
    else:
        click.echo("\n".join(description.description(about)))
