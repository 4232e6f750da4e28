"""Options that pictures share: the mesh, the view, the light's turn, the noise that is taken out, and how
bright a .png is."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from gonio.cli._numbers import VIEW, Number
from gonio.messages import notice


class Stops(click.ParamType[float | str]):
    """An exposure: a finite number of stops, or auto."""

    name = "stops"

    def __init__(self, auto: bool = True) -> None:
        self.auto = auto

    def convert(self, value: Any, param: Any, ctx: Any) -> float | str:
        """A number, or "auto"."""
        if self.auto and str(value).lower() == "auto":
            return "auto"
        try:
            stops = float(value)
        except ValueError:
            stops = math.nan
        if not math.isfinite(stops):
            allowed = "a finite number of stops" + (" or auto" if self.auto else "")
            self.fail(f"{value!r} is not {allowed}", param, ctx)
        return stops


def tone_option(function: Any) -> Any:
    """`--tone`."""
    return click.option(
        "--tone",
        type=click.Choice(["linear", "filmic", "agx"]),
        help="How a .png shows highlights: clipped (linear, default), or bent by a curve.",
    )(function)


def scene_exposure_option(function: Any) -> Any:
    """`--exposure` of a scene, which has no white to go by."""
    return click.option(
        "--exposure", type=Stops(auto=False), metavar="STOPS", help="Brighten a .png (default: 0)."
    )(function)


exposure_option = click.option(
    "--exposure",
    type=Stops(),
    metavar="STOPS|auto",
    help="Brighten a .png. auto brings white to 0.9; default for your own --env file, else 0.",
)

denoise_option = click.option(
    "--denoise",
    is_flag=True,
    help="Take the noise out of the finished picture (needs: pip install 'gonio[denoise]'). Flakes and "
    "other fine texture go with it.",
)


def check_denoise(denoise: bool, cluster: str | None, run_dir: str | None) -> None:
    """Raise a UsageError for --denoise of pictures whose samples are shared out."""
    if denoise and (cluster is not None or run_dir is not None):
        raise click.UsageError("--denoise is for pictures that are rendered here and at once.")


_STAGE = (
    click.option(
        "--mesh",
        metavar="FILE",
        help="A mesh (.obj, .ply, .stl, .glb, .gltf) instead of the ball.",
    ),
    click.option(
        "--up", type=click.Choice(["y", "z"]), help="The mesh's vertical axis (default: y)."
    ),
    click.option("--turn", type=Number(), metavar="DEG", help="Turn the mesh about the vertical."),
    click.option(
        "--uv",
        type=click.Choice(["box", "sphere"]),
        help="Project texture coordinates on the mesh, in place of its own.",
    ),
    click.option("--env-turn", type=Number(), metavar="DEG", help="Turn an --env file."),
    click.option(
        "--camera",
        type=VIEW,
        metavar="AZ,EL",
        help="Where to look from, in degrees: right of the front, and up (default: 0,13; higher up for "
        "a flat mesh).",
    ),
    click.option("--zoom", type=Number(0.05, 100), help="A longer lens (default: 1)."),
    click.option(
        "--max-depth",
        type=click.IntRange(1, 1 << 16),
        metavar="N",
        help="Segments of the longest path: 2 is one reflection (default: 12; with --furnace 256).",
    ),
    click.option("--no-ground", is_flag=True, help="Leave the ground out."),
    click.option(
        "--transparent", is_flag=True, help="The object alone, before a transparent background."
    ),
)


def stage_options(function: Any) -> Any:
    """All options of the stage; the command takes them as keywords for `stage_settings`."""
    for option in reversed(_STAGE):
        function = option(function)
    return function


def stage_settings(
    *,
    mesh: str | None,
    up: str | None,
    turn: float | None,
    uv: str | None,
    env_turn: float | None,
    camera: tuple[float, float] | None,
    zoom: float | None,
    max_depth: int | None,
    no_ground: bool,
    transparent: bool,
) -> dict[str, Any]:
    """Arguments of `gonio.render.stage.shader_ball`; those that were not given are left out.

    Raises:
        click.UsageError: an option that has no effect beside the others.
    """
    if mesh is None:
        for name, value in (("--up", up), ("--turn", turn), ("--uv", uv)):
            if value is not None:
                raise click.UsageError(f"{name} is for your own mesh; give --mesh FILE with it")
    if transparent and no_ground:
        raise click.UsageError("--transparent leaves the ground out already; drop --no-ground")
    given = {
        "mesh": mesh,
        "up": up,
        "turn": turn,
        "uv": uv,
        "environment_turn": env_turn,
        "camera": camera,
        "zoom": zoom,
        "max_depth": max_depth,
        "ground": False if no_ground else None,
        "transparent": transparent or None,
    }
    return {name: value for name, value in given.items() if value is not None}


def check_look(target: Path, exposure: float | str | None, tone: str | None) -> None:
    """Raise a UsageError for an exposure or a curve of a file that keeps radiance as it is."""
    if target.suffix.lower() == ".exr":
        for name, value in (("--exposure", exposure), ("--tone", tone)):
            if value is not None:
                raise click.UsageError(f"{name} is for a .png; an .exr keeps the radiance as it is")


def light_of(environment: str | None, furnace: bool, exposure: float | str | None) -> str:
    """The environment that was given, or the studio.

    Raises:
        click.UsageError: the furnace, and something that has no effect in it.
    """
    if furnace and environment is not None:
        raise click.UsageError(
            f"--furnace is radiance 1 from everywhere; drop it, or --env {environment}"
        )
    if furnace and exposure == "auto":
        raise click.UsageError("--furnace has nothing to find an exposure for: white is 1 in it")
    return environment or "studio"


def stops(environment: str, furnace: bool, given: float | str | None, target: Path) -> float:
    """The exposure of a picture; one that was found automatically is said."""
    from gonio.render.light import auto_exposure, is_own

    if target.suffix.lower() == ".exr":
        return 0.0
    own = furnace or is_own(environment)
    if isinstance(given, float) or (given is None and own):
        return float(given or 0.0)
    found = 0.0 if own else auto_exposure(environment)
    notice(
        f"exposure {found:+.1f} stops: brings white under {environment} to 0.9; "
        "--exposure 0 shows the radiance as it is."
    )
    return found
