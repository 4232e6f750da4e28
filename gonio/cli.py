"""The command line: every command is a few lines around a function that Python can call as well.

What a command needs loads when it runs, so that `gonio list` starts quickly.
"""

from __future__ import annotations

import dataclasses
import difflib
import io
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import click

import gonio


class Program(click.Group):
    """A click group whose errors are one line on stderr, with a traceback only for --debug."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command and end the process with its exit code."""
        given = list(sys.argv[1:] if args is None else args)
        debug = "--debug" in given  # wherever it stands
        given = [a for a in given if a != "--debug"]
        try:
            _make_writable(sys.stdout)
            # Not standalone: click would print errors its own way. It still ends the process, quietly
            # and with code 1, when nobody reads its output any more.
            code = super().main(given, "gonio", complete_var, False, **extra)
        except (KeyboardInterrupt, click.Abort):
            click.echo("gonio: interrupted", err=True)
            sys.exit(128 + 2)  # as a program that SIGINT ends
        except Exception as error:
            if debug:
                raise
            click.echo(f"gonio: error: {_one_line(error)}", err=True)
            sys.exit(error.exit_code if isinstance(error, click.ClickException) else 1)
        sys.exit(code if isinstance(code, int) else 0)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command, or fail with the nearest one."""
        if args and self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            near = difflib.get_close_matches(args[0], self.list_commands(ctx), n=1)
            did = f"did you mean {near[0]!r}? " if near else ""
            raise click.UsageError(f"no command {args[0]!r}; {did}'gonio --help' shows all.")
        return super().resolve_command(ctx, args)


def _one_line(error: Exception) -> str:
    """What went wrong, in one line, for somebody who did not write gonio."""
    from gonio.export.tree import ExportError

    if isinstance(error, ExportError):
        return str(error)  # shows the place in the source, on lines of its own
    if isinstance(error, click.NoSuchOption):
        name = error.option_name.lstrip("-").replace("-", "_")
        if any(name in cls.fields for cls in gonio.models().values()):
            return f"no option {error.option_name}; parameters are given as --param {name}=VALUE."
    if isinstance(error, click.ClickException):
        text = error.format_message()
        context = getattr(error, "ctx", None)
        if isinstance(error, click.UsageError) and context is not None:
            text = f"{text.rstrip('.')}; see '{context.command_path} --help'."
    elif isinstance(error, OSError) and error.strerror and error.filename is not None:
        text = f"{error.filename}: {error.strerror}"
    elif isinstance(error, (ValueError, OSError, gonio.BackendError)):
        text = str(error)
    else:  # not foreseen
        text = f"{type(error).__name__}: {error} ('gonio --debug ...' shows where)"
    return " ".join(text.split()) or type(error).__name__


def _make_writable(stream: Any) -> None:
    """Let a terminal without Unicode show a question mark instead of failing."""
    if isinstance(stream, io.TextIOWrapper) and stream.encoding.lower() not in ("utf-8", "utf8"):
        stream.reconfigure(errors="replace")


SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


@click.group(cls=Program, context_settings=SETTINGS, invoke_without_command=True)
@click.version_option(gonio.__version__, "-V", "--version", message="gonio %(version)s")
@click.option(
    "--debug", is_flag=True, expose_value=False, help="Show the Python traceback of an error."
)
@click.pass_context
def main(ctx: click.Context) -> None:
    """BRDF models, each written once: evaluate them, look at them, render with them.

    \b
      gonio list                                  which models there are
      gonio show eon                              what one of them is, and its parameters
      gonio eval eon --theta-i 30 --theta-o 60    its numbers
      gonio plot lambert eon:roughness=1          its shape
      gonio render eon --param roughness=1        its looks
      gonio export eon --to wgsl                  its shader
      gonio check eon                             whether it is what it claims to be
      gonio doctor                                whether this machine can run them
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def _complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    return [name for name in gonio.models() if name.startswith(incomplete)]


json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
param_option = click.option(
    "-p",
    "--param",
    "params",
    multiple=True,
    metavar="NAME=VALUE",
    help="A parameter or option of the model; again for more. Colours: rho=0.8,0.3,0.1.",
)


@main.command("list", short_help="List all models, materials, or parts of models.")
@click.option("--materials", is_flag=True, help="The ready materials instead of the models.")
@click.option("--parts", is_flag=True, help="The functions that models are made of, and tools.")
@json_option
def list_command(materials: bool, parts: bool, as_json: bool) -> None:
    """List all models with a line on each; with --materials, the ready materials.

    With --parts, every distribution, masking, Fresnel term, interface and table, with its source.

    \b
    Examples:
      gonio list
      gonio list --materials
      gonio list --parts
      gonio list --json | jq -r '.[].name'
    """
    from gonio.description import summary
    from gonio.material import library, load_material

    if materials and parts:
        raise click.UsageError("--materials and --parts are two lists; choose one")
    if parts:
        from gonio import inventory

        if as_json:
            _echo_json([dataclasses.asdict(part) for part in inventory.parts()])
        else:
            click.echo("\n".join(inventory.lines(inventory.parts())))
        return
    if materials:
        rows = [{"name": name, "summary": load_material(name).description} for name in library()]
    else:
        rows = [{"name": name, "summary": summary(cls)} for name, cls in gonio.models().items()]
    if as_json:
        _echo_json(rows)
        return
    width = max(len(row["name"]) for row in rows)
    for row in rows:
        click.echo(f"{row['name']:<{width}}  {row['summary']}")
    if not materials:  # on stderr, so that a pipe gets the list alone
        click.echo(
            "\n--materials lists ready materials, --parts what models are made of.", err=True
        )


@main.command(short_help="Show what a model is, and its parameters.")
@click.argument("model", shell_complete=_complete)
@json_option
def show(model: str, as_json: bool) -> None:
    """Show what MODEL is: source, parameters, and what is known to be wrong with it.

    \b
    Examples:
      gonio show eon
      gonio show qon --json
    """
    from gonio import description

    about = description.describe(model)
    if as_json:
        _echo_json(about)
    else:
        click.echo("\n".join(description.description(about)))


@main.command("eval", short_help="Evaluate a model for two directions.")
@click.argument("model", shell_complete=_complete)
@click.option("--wi", type=float, nargs=3, metavar="X Y Z", help="Unit vector towards the light.")
@click.option("--wo", type=float, nargs=3, metavar="X Y Z", help="Unit vector towards the viewer.")
@click.option("--theta-i", type=float, metavar="DEG", help="Polar angle of the light, instead.")
@click.option("--theta-o", type=float, metavar="DEG", help="Polar angle of the viewer, instead.")
@click.option(
    "--phi",
    type=float,
    metavar="DEG",
    help="Azimuth between the two: 0 (default) is the viewer's side, 180 the mirror's.",
)
@param_option
@click.option("--normalize", is_flag=True, help="Scale the vectors to length 1 first.")
@click.option("--double/--float32", help="Compute in double precision (default: float32).")
@json_option
def eval_command(
    model: str,
    wi: tuple[float, float, float] | None,
    wo: tuple[float, float, float] | None,
    theta_i: float | None,
    theta_o: float | None,
    phi: float | None,
    params: tuple[str, ...],
    normalize: bool,
    double: bool,
    as_json: bool,
) -> None:
    """Evaluate MODEL for one pair of directions: BRDF, pdf, albedos, Monte Carlo weight.

    Directions are unit vectors that leave the surface, with the normal along +z.

    \b
    Examples:
      gonio eval lambert --wi 0 0 1 --wo 0 0 1
      gonio eval eon --theta-i 30 --theta-o 60 --phi 180 --param roughness=1
      gonio eval eon:sampler=cosine --wi 1 0 1 --wo 0 1 1 --normalize -p rho=0.8,0.3,0.1 --json
    """
    from gonio import evaluation
    from gonio.notation import parse_model

    material = parse_model(model, params)
    wi_vector, wo_vector = evaluation.directions(wi, wo, theta_i, theta_o, phi, normalize)
    try:
        result = evaluation.evaluate(material, wi_vector, wo_vector, double=double)
    except ValueError as error:
        if "has length" in str(error):  # the model's advice is for Python
            sentence = str(error).partition(";")[0]
            raise ValueError(f"{sentence}; give unit vectors, or add --normalize.") from error
        raise
    if as_json:
        _echo_json(dataclasses.asdict(result))
    else:
        click.echo("\n".join(evaluation.lines(result)))


@main.command(short_help="Plot models to PNG, SVG, PDF or CSV.")
@click.argument("models", nargs=-1, required=True, metavar="MODEL...", shell_complete=_complete)
@click.option(
    "-k",
    "--kind",
    type=click.Choice(["polar", "albedo", "surface", "sampling"]),
    default="polar",
    show_default=True,
    help="Lobe slices, albedo curves, lobes in space, or the quality of the samplers.",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="A .png, .svg, .pdf or .csv file (default: KIND.png).",
)
@param_option
@click.option(
    "--vary",
    metavar="NAME=A,B,...",
    help="Plot every model once for each of these values of a parameter or option.",
)
@click.option(
    "--theta-o", metavar="DEG,...", help="Angles of the viewer, for polar and surface plots."
)
@click.option("--no-cosine", is_flag=True, help="Plot f, not f cos(theta_i) (polar, surface).")
@click.option("--along", metavar="NAME", help="The parameter mean albedos are plotted against.")
@click.option(
    "--channel",
    type=click.Choice(["luminance", "red", "green", "blue"]),
    help="What to plot of a coloured model (default: luminance); a .csv has all.",
)
@click.option("--title", metavar="TEXT", help="Another title.")
@click.option("--dpi", type=click.IntRange(20, 1200), default=200, show_default=True)
def plot(
    models: tuple[str, ...],
    kind: str,
    output: str | None,
    params: tuple[str, ...],
    vary: str | None,
    theta_o: str | None,
    no_cosine: bool,
    along: str | None,
    channel: str | None,
    title: str | None,
    dpi: int,
) -> None:
    """Plot one or more models into a picture, or the numbers into a CSV file.

    A MODEL may carry parameters: eon:roughness=1,rho=0.8/0.3/0.1 (colours with slashes).

    \b
    Examples:
      gonio plot lambert qon:sigma=1.57 fon:roughness=1 eon:roughness=1 -o lobes.svg
      gonio plot eon --vary roughness=0,0.25,0.5,0.75,1 --theta-o 60 --no-cosine
      gonio plot eon qon oren_nayar --kind albedo -p rho=1 -o albedo.pdf
      gonio plot eon:roughness=1 --kind surface --theta-o 30,75
      gonio plot eon --kind sampling --vary sampler=cltc_uniform,cltc,cosine -p rho=1
      gonio plot eon -o eon.csv
    """
    from gonio import plot as plots
    from gonio.notation import parse_model

    materials = [parse_model(text, params) for text in _variations(models, vary)]
    settings: dict[str, Any] = {"along": along, "channel": channel, "title": title}
    if theta_o is not None:
        settings["theta_o"] = _parse_angles(theta_o)
    if no_cosine:
        settings["cosine"] = False
    given = {name: value for name, value in settings.items() if value is not None}
    path = plots.plot(materials, kind, output or f"{kind}.png", dpi=dpi, **given)
    click.echo(path)


def _variations(models: Iterable[str], vary: str | None) -> list[str]:
    """Every model's text with every value of "name=a,b,...", as texts of models."""
    if vary is None:
        return list(models)
    name, equals, values = vary.partition("=")
    if not (name and equals and values):
        raise ValueError(f"--vary {vary} is not NAME=A,B,..., such as roughness=0,0.5,1.")
    return [
        f"{text}{',' if ':' in text else ':'}{name}={value}"
        for text in models
        for value in values.split(",")
    ]


def _parse_angles(text: str) -> list[float]:
    try:
        return [float(angle) for angle in text.split(",")]
    except ValueError:
        raise ValueError(f"--theta-o {text} is not a list of degrees, such as 0,30,60.") from None


@contextmanager
def _progress(label: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr, shown on terminals only."""
    if not sys.stderr.isatty():  # click would still print the label
        yield lambda done, total: None
        return
    with click.progressbar(length=1000, label=label, file=sys.stderr) as bar:

        def step(done: int, total: int) -> None:
            bar.update(1000 * done // total - bar.pos)

        yield step


class Size(click.ParamType[tuple[int, int]]):
    """A picture's size as on the command line: 512 or 640x480."""

    name = "size"

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[int, int]:
        """Width and height in pixels."""
        try:
            numbers = [int(n) for n in str(value).lower().split("x")]
        except ValueError:
            numbers = []
        if len(numbers) not in (1, 2) or min(numbers) < 1:
            self.fail(f"{value!r} is not a size; write 512 or 640x480", param, ctx)
        return numbers[0], numbers[-1]


@main.command(short_help="Render a picture of a model.")
@click.argument("model", required=False, shell_complete=_complete)
@param_option
@click.option("--material", metavar="FILE.toml", help="A material file instead of MODEL.")
@click.option("--sheet", is_flag=True, help="A contact sheet of all ready materials instead.")
@click.option(
    "--series", metavar="NAME", help="The ready materials NAME_1, NAME_2, ... in a strip."
)
@click.option(
    "--env",
    "environment",
    default="studio",
    metavar="NAME|FILE",
    help="Light: studio (default), sun, front, side, white, sunsky, or an .exr or .hdr file.",
)
@click.option("--mesh", metavar="FILE", help="An .obj, .ply or .glb mesh instead of the ball.")
@click.option("--up", type=click.Choice(["y", "z"]), default="y", help="The mesh's vertical axis.")
@click.option("--turn", type=float, default=0.0, metavar="DEG", help="Turn the mesh.")
@click.option("--furnace", is_flag=True, help="Radiance 1 from everywhere: shows lost energy.")
@click.option(
    "--diffusion",
    type=click.FloatRange(0),
    default=0.0,
    metavar="MM",
    help="For skin: a millimetre in units of the ball's radius, such as 0.01.",
)
@click.option(
    "--compare",
    "others",
    multiple=True,
    metavar="MODEL",
    help="Another model beside the first; again for more. Makes a labelled strip.",
)
@click.option("--scene", metavar="FILE.xml", help="Your own Mitsuba scene, with --assign.")
@click.option(
    "--assign",
    "assignments",
    multiple=True,
    metavar="ID=MODEL",
    help="Give a shape or bsdf of --scene this model; again for more.",
)
@click.option("--spp", type=click.IntRange(1, 1 << 20), help="Samples per pixel (default: 36).")
@click.option(
    "--size", type=Size(), metavar="N|WxH", help="Pixels (default: 512, series 320, sheet 256)."
)
@click.option("--seed", type=click.IntRange(0, 65535), default=0, help="Of the random numbers.")
@click.option("--exposure", type=float, default=0.0, metavar="STOPS", help="Brighten a .png.")
@click.option("-o", "--output", metavar="FILE", help="A .png or .exr file (default: MODEL.png).")
def render(
    model: str | None,
    params: tuple[str, ...],
    material: str | None,
    sheet: bool,
    series: str | None,
    environment: str,
    mesh: str | None,
    up: str,
    turn: float,
    furnace: bool,
    diffusion: float,
    others: tuple[str, ...],
    scene: str | None,
    assignments: tuple[str, ...],
    spp: int | None,
    size: tuple[int, int] | None,
    seed: int,
    exposure: float,
    output: str | None,
) -> None:
    """Render MODEL on a shader ball, on your mesh, or in your own Mitsuba scene.

    A MODEL may carry parameters: eon:roughness=1,rho=0.8/0.3/0.1 (colours with slashes). The name of a
    ready material does as well: 'gonio list --materials' shows them.

    \b
    Examples:
      gonio render eon --param roughness=1 -o clay.png
      gonio render eon --mesh bunny.obj --env studio.hdr
      gonio render lambert --compare qon:sigma=1.57 --compare eon:roughness=1 --env side
      gonio render eon:rho=1,roughness=1 --furnace
      gonio render lacquered_walnut --compare gold --env sunsky
      gonio render skin --diffusion 0.01
      gonio render --sheet -o materials.png
      gonio render --series patina --env sunsky
      gonio render --material clay.toml --size 1024x768 --spp 256 -o clay.exr
      gonio render --scene room.xml --assign wall=eon:roughness=0.8 -o room.png
    """
    from pathlib import Path

    from gonio import rendering
    from gonio.material import find, library, load_material, load_series

    if sheet:
        if model or material or others or scene or series or diffusion:
            raise click.UsageError("--sheet shows all ready materials; it goes with no other")
        target = Path(output or "materials.png")
        cell = (size or (256, 256))[0]
        with _progress("rendering") as step:
            rendering.write_sheet(
                target,
                [load_material(name) for name in library()],
                cell=cell,
                spp=spp or 64,
                seed=seed,
                environment=environment,
                furnace=furnace,
                progress=step,
            )
        click.echo(target)
        return
    if scene is not None:
        if model or material or others or series or furnace or mesh or diffusion:
            raise click.UsageError(
                "--scene goes with --assign ID=MODEL, not with a MODEL, --mesh or --diffusion"
            )
        assign = {}
        for text in assignments:
            name, equals, value = text.partition("=")
            if not (name and equals and value):
                raise click.UsageError(f"--assign {text} is not ID=MODEL, such as wall=eon")
            assign[name] = find(value, params)
        target = Path(output or f"{Path(scene).stem}.png")
        rendering.check_format(target)
        with _progress("rendering") as step:
            pixels = rendering.render_scene(
                scene, assign, size=size, spp=spp, seed=seed, progress=step
            )
        rendering.write_picture(target, pixels, exposure=exposure)
        click.echo(target)
        return
    if assignments:
        raise click.UsageError("--assign goes with --scene FILE.xml")
    shown: list[Any]
    if series is not None:
        if model or material or others or params:
            raise click.UsageError("--series shows ready materials; it goes with no other")
        shown = load_series(series)
        labels = rendering.captions(shown)
    else:
        if (model is None) == (material is None):
            raise click.UsageError(
                "give a MODEL or --material FILE.toml; 'gonio list' shows the models"
            )
        first = load_material(material) if material else find(str(model), params)
        shown = [first, *(find(text) for text in others)]
        labels = [rendering.describe(m) for m in shown] if others else []
    target = Path(output or f"{series or shown[0].name}.png")
    rendering.check_format(target)
    settings: dict[str, Any] = {"mesh": mesh, "up": up, "turn": turn} if mesh else {}
    with _progress("rendering") as step:
        pixels = rendering.compare(
            [{"environment": environment, "furnace": furnace, "diffusion": diffusion}],
            shown,
            size=size or ((320, 320) if series else (512, 512)),
            spp=spp or 36,
            seed=seed,
            progress=step,
            **settings,
        )
    rendering.write_picture(target, pixels, exposure=exposure, labels=labels)
    click.echo(target)


@main.command(short_help="Render the Oren-Nayar family side by side.")
@click.option("-o", "--output", default="demo", metavar="FOLDER", help="Where to (default: demo).")
@click.option("--size", type=click.IntRange(16, 4096), default=320, help="Pixels of one cell.")
@click.option("--spp", type=click.IntRange(1, 1 << 20), default=64, help="Samples per pixel.")
def demo(output: str, size: int, spp: int) -> None:
    """Render Lambert, QON, FON and EON at full roughness: front-lit, side-lit, white furnace.

    After Figures 1 and 4 of the EON paper. Takes about half a minute on two cores.

    \b
    Examples:
      gonio demo
      gonio demo --size 512 --spp 256 -o pictures
    """
    from gonio import rendering

    with _progress("rendering") as step:
        paths = rendering.demo(output, cell=size, spp=spp, progress=step)
    for path in paths:
        click.echo(f"The picture is {path}")


@main.command(short_help="Measure whether a model is what it claims to be.")
@click.argument("models", nargs=-1, metavar="[MODEL|MATERIAL|FILE.py]...", shell_complete=_complete)
@param_option
@click.option("--all", "everything", is_flag=True, help="Every model of gonio.")
@click.option(
    "--mitsuba",
    "plugins",
    multiple=True,
    metavar="NAME|XML|JSON",
    help="A Mitsuba BSDF: a plug-in's name, its XML or JSON, or a file with it; again for more.",
)
@click.option("--quick", "effort", flag_value="quick", help="Seconds for each model.")
@click.option("--thorough", "effort", flag_value="thorough", help="Minutes for each model.")
@click.option("--only", metavar="CHECK,...", help="Only these checks, such as energy,sampling.")
@click.option("--junit", metavar="FILE", help="Also write a JUnit report for other programs.")
@click.option("--plot", "picture", metavar="FILE", help="Also draw the worst cases.")
@json_option
def check(
    models: tuple[str, ...],
    params: tuple[str, ...],
    everything: bool,
    plugins: tuple[str, ...],
    effort: str | None,
    only: str | None,
    junit: str | None,
    picture: str | None,
    as_json: bool,
) -> int:
    """Measure energy, reciprocity, sampling, precision, derivatives and more; compare with the claims.

    Worst cases are searched for over all angles, parameters and options. What is given of them stays
    fixed; a material is checked as it is. Ends with exit code 1 when something is not as it
    is claimed.

    \b
    Examples:
      gonio check eon
      gonio check qon:sigma=0.2 --only energy --plot qon.png
      gonio check my_model.py --quick
      gonio check lacquered_walnut
      gonio check --all --quick --junit report.xml
      gonio check --mitsuba roughplastic
      gonio check --mitsuba '{"type": "roughconductor", "alpha": 0.5}' --only energy
    """
    from gonio.check import command

    if everything and (models or params):
        raise click.UsageError("--all checks every model; it goes with no MODEL and no --param")
    texts = list(gonio.models()) if everything else list(models)
    if not texts and not plugins:
        raise click.UsageError("give a MODEL, a FILE.py, --all or --mitsuba NAME")
    plan = command.plan(
        texts,
        params,
        plugins=plugins,
        only=only.split(",") if only else (),
        junit_file=junit,
        picture_file=picture,
    )
    with _progress("checking") as step:
        result = plan.run(effort or "normal", step)
    if as_json:
        _echo_json(command.data(result.reports))
    else:
        click.echo("\n".join(command.lines(result.reports)))
        for path in result.written:
            click.echo(path)
    return 1 if command.failed(result.reports) else 0


@main.command(short_help="Compare models with the truth, or with each other.")
@click.argument("models", nargs=-1, metavar="[MODEL|MATERIAL]...", shell_complete=_complete)
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
@click.option(
    "--docs", metavar="FILE.md", help="Write the page about gonio's layered models instead."
)
@json_option
def compare(
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
    docs: str | None,
    as_json: bool,
) -> None:
    """Show how wrong models are, and where: error maps, numbers, and pictures side by side.

    With --truth every layered model is compared with the layers that it stands for, whose light is followed
    by random walks. Without it, the first model is what the others are compared with. --json prints numbers
    and writes a picture only with -o.

    \b
    Examples:
      gonio compare weidlich_wilkie triace_layered --truth -o layers.png
      gonio compare weidlich_wilkie:alpha=0.3,bounces=diffuse --truth --vary eta --json
      gonio compare eon:roughness=1 oren_nayar:sigma=1.2 qon:sigma=1.2
      gonio compare --docs docs/layers.md
    """
    from gonio import comparison
    from gonio.material import find

    given: dict[str, Any] = {} if walks is None else {"walks": walks}
    if docs is not None:
        if models or truth or output or as_json:
            raise click.UsageError("--docs writes a page of its own; it goes with --walks alone")
        from gonio.reference.document import document

        with _progress("measuring") as step:
            written = document(docs, progress=step, **given)
        for path in written:
            click.echo(path)
        return
    if not models:
        raise click.UsageError("give a MODEL; 'gonio list' shows the models")
    target = output or ("" if as_json else "compare.png")
    if target:
        comparison.check_format(target)
    shown = [find(text, params) for text in models]
    with _progress("comparing") as step:
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
        comparison.write(target, found)
    if as_json:
        _echo_json([c.data() for c in found])
        return
    click.echo("\n".join(line for c in found for line in comparison.lines(c)))
    click.echo(target)


@main.command(short_help="Measure speed on this machine.")
@click.argument("rows", nargs=-1, metavar="[ROW]...")
@click.option("--pairs", type=click.IntRange(1), default=4_000_000, help="Pairs of directions.")
@click.option("--repeat", type=click.IntRange(1), default=7, help="Rounds; medians are reported.")
@click.option("-o", "--output", metavar="FILE", help="Also write a .md or .json file.")
@json_option
def bench(
    rows: tuple[str, ...], pairs: int, repeat: int, output: str | None, as_json: bool
) -> None:
    """Measure gonio beside plain C++ (compiled for the purpose), Mitsuba's own plug-ins and the clock.

    ROWs choose what to measure: sections (eval, sample, numpy, render, shaders, kernels, startup), models,
    or rows such as eon_fitted. Everything takes about four minutes; close other programs first.

    \b
    Examples:
      gonio bench
      gonio bench eon oren_nayar --repeat 15
      gonio bench shaders             exported GLSL beside GLSL written by hand
      gonio bench -o docs/performance.md
    """
    from pathlib import Path

    from gonio import bench as benches

    report = benches.bench(
        pairs, repeat, list(rows) or None, None if output is None else Path(output)
    )
    click.echo(report.json() if as_json else report.text())


@main.group(
    short_help="Make tables and prefiltered light for shaders.", invoke_without_command=True
)
@click.pass_context
def bake(ctx: click.Context) -> None:
    """Make what real-time shaders look up: tables of F and D, blurred environments, harmonics.

    Each tells how far the table is from the function that it stands for.

    \b
    Examples:
      gonio bake fresnel --metal Cu -o copper.npy
      gonio bake distribution ggx -o ggx.exr
      gonio bake blur studio.hdr --alpha 0.2 -o rough.exr
      gonio bake harmonics sunsky
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@bake.command(short_help="F of a material, by the cosine.")
@click.option("--eta", metavar="N[,N,N]", help="Relative index; one number, or one per channel.")
@click.option("--k", default="0", metavar="N[,N,N]", help="Extinction, for metals.")
@click.option("--metal", metavar="SYMBOL", help="A metal such as Cu instead of --eta and --k.")
@click.option("--entries", type=click.IntRange(2, 1 << 16), default=128, show_default=True)
@click.option("-o", "--output", default="fresnel.npy", metavar="FILE", help="A .npy or .exr file.")
def fresnel(eta: str | None, k: str, metal: str | None, entries: int, output: str) -> None:
    """Write a table of the exact Fresnel reflectance at evenly spaced cosines from 0 to 1.

    \b
    Examples:
      gonio bake fresnel --eta 1.5 -o glass.npy
      gonio bake fresnel --metal Cu --entries 64 -o copper.exr
    """
    from gonio import metals, tables

    if (eta is None) == (metal is None):
        raise click.UsageError("give either --eta, such as 1.5, or --metal, such as Cu")
    if metal is not None:
        index: dict[str, Any] = dict(metals.metal(metal))
    else:
        index = {"eta": _parse_numbers("--eta", str(eta)), "k": _parse_numbers("--k", k)}
    table = tables.fresnel_table(**index, entries=entries)
    tables.write_table(output, table)
    error = tables.fresnel_error(table, **index)
    click.echo(f"{output}: largest error {error.largest:.2g}, at {error.at:.1f} degrees")


def _parse_numbers(option: str, text: str) -> list[float]:
    try:
        return [float(number) for number in text.split(",")]
    except ValueError:
        raise ValueError(f"{option} {text} is not a number, or three as in 0.2,0.9,1.1.") from None


@bake.command(short_help="D for all widths and angles.")
@click.argument("kind", default="beckmann", metavar="[DISTRIBUTION]")
@click.option("--size", type=click.IntRange(2, 8192), default=512, show_default=True)
@click.option("-o", "--output", metavar="FILE", help="A .npy or .exr file (default: NAME.npy).")
def distribution(kind: str, size: int, output: str | None) -> None:
    """Write D over u (to the right, theta = 90 degrees times u^8) and width (downwards).

    DISTRIBUTION is beckmann, ggx, blinn_phong or gaussian. Row v, from 0 to 1, has alpha = 0.003^(1 - v).

    \b
    Examples:
      gonio bake distribution
      gonio bake distribution ggx --size 256 -o ggx.exr
    """
    from gonio import tables

    table = tables.distribution_table(kind, size)
    target = output or f"{kind}.npy"
    tables.write_table(target, table)
    error = tables.distribution_error(table, kind)
    click.echo(
        f"{target}: largest error {error.largest:.2g} of the peak, at {error.at:.1f} degrees; "
        f"of the integral {error.mean:.2g}"
    )


@bake.command(short_help="An environment as a rough surface mirrors it.")
@click.argument("environment", metavar="NAME|FILE")
@click.option(
    "--alpha",
    type=click.FloatRange(0, 1, min_open=True),
    required=True,
    help="Width of the surface's GGX facets.",
)
@click.option("--width", type=int, help="Pixels of the picture (default: as alpha needs).")
@click.option("-o", "--output", default="blurred.exr", metavar="FILE", help="An .exr or .hdr file.")
def blur(environment: str, alpha: float, width: int | None, output: str) -> None:
    """Blur an environment by a GGX lobe about each direction, for split-sum reflections.

    \b
    Examples:
      gonio bake blur studio.hdr --alpha 0.2
      gonio bake blur sunsky --alpha 0.05 --width 512 -o sky.exr
    """
    from gonio import environment as environments

    environments.check_format(output)
    with _progress("blurring") as step:
        environments.load(environment).blurred(alpha, width=width, progress=step).write(output)
    click.echo(output)


@bake.command(short_help="An environment's spherical harmonics.")
@click.argument("environment", metavar="NAME|FILE")
@json_option
def harmonics(environment: str, as_json: bool) -> None:
    """Print the first nine real spherical harmonics of an environment's radiance, red, green and blue.

    \b
    Examples:
      gonio bake harmonics studio.hdr
      gonio bake harmonics sunsky --json
    """
    from gonio import environment as environments

    found = environments.load(environment).harmonics()
    if as_json:
        names = environments.HARMONICS
        _echo_json([{"harmonic": n, "rgb": list(c)} for n, c in zip(names, found, strict=True)])
        return
    for name, colour in zip(environments.HARMONICS, found, strict=True):
        click.echo(f"{name:<10}  " + "  ".join(f"{value:10.6f}" for value in colour))


@main.command(short_help="Convert between scales of roughness.")
@click.argument("value", type=float)
@click.option("--from", "source", required=True, metavar="SCALE", help="The scale of VALUE.")
@click.option("--to", "target", required=True, metavar="SCALE", help="The scale that is wanted.")
@json_option
def convert(value: float, source: str, target: str, as_json: bool) -> None:
    """Convert VALUE between scales of roughness, and say what the conversion takes them to mean.

    \b
    Scales:
      perceptual  artists' roughness, alpha = perceptual^2
      alpha       width of a microfacet distribution; for Beckmann the rms slope m
      shininess   Blinn-Phong exponent n
      sigma       Oren-Nayar: standard deviation of the facet angle, radians
      r           roughness of FON and EON; unitless, not an angle

    \b
    Examples:
      gonio convert 0.5 --from perceptual --to alpha
      gonio convert 10 --from shininess --to r
    """
    from gonio import conversions

    result = conversions.convert(value, source, target)
    if as_json:
        steps = [step.__name__ for step in result.steps]
        _echo_json({"value": result.value, "from": source, "to": target, "steps": steps})
        return
    click.echo(f"{result.value:.9g}")
    for step, meaning in zip(result.steps, result.meanings(), strict=True):
        click.echo(f"  {step.__name__}: {meaning}")


@main.command("export", short_help="Write a model as shader or C++ source.")
@click.argument("models", nargs=-1, metavar="MODEL...", shell_complete=_complete)
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
@click.option("--only", metavar="NAME,...", help="Of eval, sample, pdf, albedo (default: all).")
@click.option("--embed", is_flag=True, help="Also a function that gives the parameters' values.")
@click.option("--prefix", metavar="NAME", help="Of what the models share (default: the model).")
@click.option("--prove", is_flag=True, help="Compile, run and compare with the model; no file.")
@click.option(
    "--rows",
    type=click.IntRange(100, 10_000_000),
    default=10_000,
    show_default=True,
    help="Directions and parameters that --prove tries.",
)
@click.option("-o", "--output", metavar="PATH", help="A file or folder (default: print the text).")
def export_command(
    models: tuple[str, ...],
    languages: tuple[str, ...],
    params: tuple[str, ...],
    options: tuple[str, ...],
    everything: bool,
    materials: bool,
    only: str | None,
    embed: bool,
    prefix: str | None,
    prove: bool,
    rows: int,
    output: str | None,
) -> None:
    """Write MODELs as readable source: functions NAME_eval, _sample, _pdf, _albedo and a struct.

    A MODEL is a model (eon, or eon:albedo_form=fitted), a ready material, or a .toml or .py file;
    fast=eon:albedo_form=fitted gives it another name. Options are fixed in the text, parameters are
    members of the struct. Several models share one text, and its common parts.

    \b
    Examples:
      gonio export eon --to wgsl
      gonio export eon --option albedo_form=fitted --only eval --to glsl -o eon.glsl
      gonio export orange_lacquer --to hlsl --embed
      gonio export eon torrance_sparrow --to cpp -o brdfs.h
      gonio export --all --to all -o shaders/
      gonio export eon --to wgsl --to glsl --prove
      gonio export my_model.py --to slang
    """
    from gonio.export import FUNCTIONS, command, files

    selection = command.choose(models, [*params, *options], everything, materials)
    to = command.languages(languages)
    functions = [name.strip() for name in only.split(",")] if only else list(FUNCTIONS)
    if prove:
        results = command.prove(selection.models, to, rows, functions, _say)
        click.echo("\n".join(results.lines))
        if results.failed:
            sys.exit(1)
        return
    texts = files.texts(
        selection.models,
        to,
        together=not (everything or materials),
        only=functions,
        prefix=prefix,
        embed=embed,
    )
    if output is None and len(texts) == 1:
        click.echo(next(iter(texts.values())), nl=False)
    else:
        for path in files.write(texts, output):
            click.echo(path)
    for note in selection.notes:
        click.echo(f"note: {note}", err=True)


@main.command(short_help="Show whether this machine can run models.")
@json_option
def doctor(as_json: bool) -> int:
    """Show what was found on this machine, and what to do about what is missing.

    Ends with exit code 1 when models cannot be computed by a compiled backend.

    \b
    Examples:
      gonio doctor
      gonio doctor --json > machine.json
    """
    from gonio import doctor as doctors

    findings = doctors.diagnose()
    if as_json:
        _echo_json([dataclasses.asdict(f) for f in findings])
    else:
        click.echo(doctors.report(findings))
    return 0 if doctors.can_compute(findings) else 1


def _say(text: str) -> None:
    """A line of progress, for people who wait."""
    if sys.stderr.isatty():
        click.echo(text, err=True)


def _echo_json(value: Any) -> None:
    click.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


if __name__ == "__main__":
    main()
