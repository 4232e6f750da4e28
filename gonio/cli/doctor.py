"""`gonio doctor`."""

from __future__ import annotations

import dataclasses

import click

from gonio import doctor
from gonio.cli.program import echo_json, json_option


@click.command("doctor", short_help="Show whether this machine can run models.")
@json_option
def command(as_json: bool) -> int:
    """Show what was found on this machine, and what to do about what is missing.

    Ends with exit code 1 when models cannot be computed by a compiled backend.

    \b
    Examples:
      gonio doctor
      gonio doctor --json > machine.json
    """
    found = doctor.diagnose()
    if as_json:
        echo_json([dataclasses.asdict(f) for f in found])
    else:
        click.echo(doctor.report(found))
    return 0 if doctor.can_compute(found) else 1
