"""What all commands share: errors of one line, progress, options; and the folder as their list."""

from __future__ import annotations

import importlib
import io
import itertools
import json
import pkgutil
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

import gonio
from gonio.cli._interrupt import CODE, prompt_interrupt
from gonio.cli._numbers import Number
from gonio.files import remove_unfinished
from gonio.messages import Notice, did_you_mean
from gonio.model import Model

if TYPE_CHECKING:
    from gonio.materials import Material

# Options that name what is written: without a name, a file would land in the folder one is in.
WRITTEN = ("-o", "--output", "--save")


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
            with prompt_interrupt(remove_unfinished), _notices():
                code = super().main(given, "gonio", complete_var, False, **extra)
        except (KeyboardInterrupt, click.Abort):
            click.echo("gonio: interrupted", err=True)
            sys.exit(CODE)
        except Exception as error:
            if debug:
                raise
            click.echo(f"gonio: error: {_one_line(error)}", err=True)
            sys.exit(error.exit_code if isinstance(error, click.ClickException) else 1)
        sys.exit(code if isinstance(code, int) else 0)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The files of this folder, but for this one."""
        names = (info.name for info in pkgutil.iter_modules([str(Path(__file__).parent)]))
        return sorted(name for name in names if name != "program" and not name.startswith("_"))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load a command from its file."""
        if cmd_name not in self.list_commands(ctx):
            return None
        command: click.Command = importlib.import_module(f"gonio.cli.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command, or fail with the nearest one."""
        if args and self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            did = did_you_mean(args[0], self.list_commands(ctx))
            raise click.UsageError(f"no command {args[0]!r}; {did}'gonio --help' shows all.")
        for flag, value in itertools.pairwise(args):
            if (flag in WRITTEN and not value) or value in {f"{name}=" for name in WRITTEN}:
                raise click.UsageError("the output has no name; is a variable of the shell empty?")
        return super().resolve_command(ctx, args)


@contextmanager
def _notices() -> Iterator[None]:
    """Print what Python code gets as a warning of gonio's in one line, each time it happens."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", Notice)
        others = warnings.showwarning

        def show(message: Any, category: Any, *where: Any, **more: Any) -> None:
            if issubclass(category, Notice):
                click.echo(f"gonio: note: {message}", err=True)
            else:
                others(message, category, *where, **more)

        warnings.showwarning = show
        yield


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


# Noise that looks clean at arm's length, noise that a denoiser takes out whole, and the samples at which a
# picture ends, clean or not.
NOISE, NOISE_DENOISED, SPP_MOST = 0.02, 0.1, 512

SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    """Names of models and ready materials for a shell that completes."""
    from gonio.materials import library

    return [name for name in (*gonio.models(), *library()) if name.startswith(incomplete)]


json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
param_option = click.option(
    "-p",
    "--param",
    "params",
    multiple=True,
    metavar="NAME=VALUE",
    help="A parameter or option of the model; again for more. Colours: rho=0.8,0.3,0.1 or #c08040.",
)


def was_given(name: str) -> bool:
    """Whether an option stands on the command line, be it with its default."""
    source = click.get_current_context().get_parameter_source(name)
    return source is ParameterSource.COMMANDLINE


@contextmanager
def progress(label: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr, shown on terminals only."""
    if not sys.stderr.isatty():  # click would still print the label
        yield lambda done, total: None
        return
    with click.progressbar(length=1000, label=label, file=sys.stderr) as bar:

        def step(done: int, total: int) -> None:
            bar.update(1000 * done // total - bar.pos)

        yield step


def say(text: str) -> None:
    """A line of progress, for people who wait."""
    if sys.stderr.isatty():
        click.echo(text, err=True)


def check_params(texts: Iterable[str], params: Iterable[str]) -> None:
    """Raise a UsageError for a --param that has no effect, since each of the models says it itself."""
    from gonio.materials.notation import split

    said = [{piece.partition("=")[0].strip() for piece in split(text)[1]} for text in texts]
    for given in params:
        name = given.partition("=")[0].strip()
        if said and all(name in names for names in said):
            raise click.UsageError(f"{name} is given twice, by --param and in the model; drop one")


def plain_models(texts: Iterable[str], params: Iterable[str] = ()) -> list[Model]:
    """The models that texts name, for commands without a surface; what a surface would add is noted.

    Raises:
        ValueError: as `gonio.load`, or a picture drives a parameter.
    """
    from gonio.materials import Material

    found = plain_materials(texts, params)
    return [one.model if isinstance(one, Material) else one for one in found]


def plain_materials(texts: Iterable[str], params: Iterable[str] = ()) -> list[Model | Material]:
    """As `plain_models`; materials keep their names.

    Raises:
        ValueError: as `plain_models`.
    """
    from gonio.materials import Material, load

    texts, given = list(texts), list(params)
    check_params(texts, given)
    found = []
    for text in texts:
        one = load(text, given)
        found.append(one)
        for note in one.plain()[1] if isinstance(one, Material) else ():
            click.echo(f"note: {note}", err=True)
    return found


def echo_json(value: Any) -> None:
    """Print a value as JSON."""
    click.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


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


environment_option = click.option(
    "--env",
    "environment",
    metavar="NAME|FILE",
    help="Light: studio (default), sun, front, side, white, sunsky, or an .exr or .hdr file.",
)


def spp_option(default: int | None) -> Callable[[Any], Any]:
    """Samples per pixel; None for a number that depends on something else."""
    text = "Samples per pixel" + ("." if default is None else f" (default: {default}).")
    return click.option("--spp", type=click.IntRange(1, 1 << 20), default=default, help=text)


noise_option = click.option(
    "--noise",
    type=Number(0, above=True),
    metavar="PART",
    help="Stop when the noise is below this part of a pixel's brightness (default, without --spp: "
    f"{NOISE}; with --denoise {NOISE_DENOISED}).",
)
time_option = click.option(
    "--time",
    "seconds",
    type=Number(0, above=True),
    metavar="SECONDS",
    help="Begin no further pass after that time, for each picture of a strip.",
)


def until(
    spp: int | None, noise: float | None, seconds: float | None, denoise: bool
) -> dict[str, Any]:
    """Arguments of `gonio.render`: a number of samples alone is exact, otherwise it is a limit."""
    given: dict[str, Any] = {"denoise": denoise}
    if noise is None and seconds is None and spp is not None:
        return given | {"spp": spp}
    if noise is None and seconds is None:
        noise = NOISE_DENOISED if denoise else NOISE
    return given | {"spp": spp or SPP_MOST, "noise": noise, "seconds": seconds}


seed_option = click.option(
    "--seed", type=click.IntRange(0, 65535), default=0, help="Of the random numbers."
)


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
      gonio cost eon                              what its shader costs on a GPU
      gonio check eon                             whether it is what it claims to be
      gonio reproduce eon:11                      a paper's figure beside gonio's
      gonio doctor                                whether this machine can run them
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())
