"""`gonio cost`."""

from __future__ import annotations

from pathlib import Path

import click

from gonio.cli.program import check_params, complete, json_option, param_option, say
from gonio.cost.gpus import GPUS, USUAL
from gonio.cost.program import LANGUAGES

ROUNDS = 9
"""How often --time runs each shader; the median is said."""


@click.command("cost", short_help="Show what shaders cost on GPUs.")
@click.argument("texts", nargs=-1, metavar="[MODEL|FILE#FUNCTION]...", shell_complete=complete)
@param_option
@click.option("--all", "everything", is_flag=True, help="All models.")
@click.option(
    "--gpu",
    "gpus",
    multiple=True,
    metavar="NAME[,NAME]",
    help=f"For which GPUs, none of which need be there: {', '.join(GPUS)}, or all "
    f"(default: {','.join(USUAL)}).",
)
@click.option(
    "--only",
    metavar="NAME[,NAME]",
    help="Functions: eval, sample, pdf, albedo (default: the first three).",
)
@click.option(
    "--against", metavar="MODEL", help="Compare with this model, in the same run. --against phong"
)
@click.option(
    "--to",
    "language",
    type=click.Choice(LANGUAGES),
    help=f"Language of the exports that AMD's compiler gets (default: {LANGUAGES[0]}); NVIDIA's gets CUDA.",
)
@click.option(
    "--map",
    "mapping",
    multiple=True,
    metavar="ARGUMENT=FORMULA",
    help='For FILE#FUNCTION, what its arguments are, as in gonio check: --map "L=wi V=wo".',
)
@click.option(
    "--time",
    "timed",
    is_flag=True,
    help="Also run eval by OpenGL on the GPU that is there (or llvmpipe on the processor).",
)
@click.option(
    "--texts",
    "of_texts",
    is_flag=True,
    help="The cost tables of the texts (tri-Ace 2012, Elek 2010): whole shaders beside their numbers.",
)
@click.option(
    "--by-hand",
    "beside",
    is_flag=True,
    help="Exports beside shaders that are written by hand (gonio/bench/handwritten).",
)
@click.option("-o", "--output", metavar="FILE", help="Also write a .md or .json file.")
@json_option
def command(
    texts: tuple[str, ...],
    params: tuple[str, ...],
    everything: bool,
    gpus: tuple[str, ...],
    only: str | None,
    against: str | None,
    language: str | None,
    mapping: tuple[str, ...],
    timed: bool,
    of_texts: bool,
    beside: bool,
    output: str | None,
    as_json: bool,
) -> None:
    """Compile shaders to the machine code of real GPUs, and count instructions, registers and cycles.

    No GPU is needed: Mesa's driver compiles for AMD's GPUs and NVRTC for NVIDIA's. Cycles come from the
    compiler and compare shaders on one GPU; they are not the time of a frame.

    \b
    Examples:
      gonio cost eon phong torrance_sparrow
      gonio cost --all --against phong --gpu navi21,navi31,sm_89
      gonio cost eon:albedo_form=fitted --only eval,sample --to hlsl
      gonio cost eon engine.glsl#diffuse --map "L=wi V=wo"   a hand-written function beside an export
      gonio cost patina --time --json
      gonio cost --all --against phong --by-hand --texts -o docs/cost.md
    """
    from gonio.bench.report import Report
    from gonio.cost import compilers
    from gonio.cost.by_hand import by_hand
    from gonio.cost.gpus import CostError, chosen
    from gonio.cost.table import FUNCTIONS, cost
    from gonio.cost.texts import tables
    from gonio.export.selection import choose, named
    from gonio.files import check_place
    from gonio.foreign import is_foreign
    from gonio.materials import load_model

    wanted = chosen(gpus)
    functions = list(FUNCTIONS) if only is None else [part.strip() for part in only.split(",")]
    files = [text for text in texts if is_foreign(text)]
    models = [text for text in texts if not is_foreign(text)]
    _check_functions(functions, files, timed)
    of_models = {"--param": params, "--to": language, "--time": timed}
    if (of_texts or beside) and not files:  # whole shaders, compared with each other
        of_models |= {"--only": only, "--against": against}
    given = [name for name, value in of_models.items() if value]
    if given and not models and not everything and (params or not (files and against)):
        raise CostError(f"{given[0]} is for models; name one, or drop it.")
    if mapping and not files:
        raise CostError("--map says what arguments of FILE#FUNCTION are; none is given.")
    if all(gpu.vendor != "amd" for gpu in wanted):
        if language is not None:
            raise CostError(
                "--to is for AMD's GPUs, and none is named; NVIDIA's compiler gets CUDA."
            )
        if files:
            raise CostError(
                f"{files[0]} is GLSL, which only AMD's compiler takes; add --gpu navi21."
            )
    if output is not None:
        if Path(output).suffix not in (".md", ".json"):
            raise CostError(f"-o {output}: the file's name ends in .md or .json.")
        check_place(output)
    sections = []
    if models or everything or files or not (of_texts or beside):
        check_params([named(text)[1] for text in models], params)
        chosen_models = choose(models, params, everything).models if models or everything else {}
        if not chosen_models and not files:
            raise CostError("nothing to measure; name a model, such as eon, or give --all.")
        found = cost(
            chosen_models,
            files,
            functions=functions,
            language=language or LANGUAGES[0],
            gpus=wanted,
            against=None if against is None else (against, load_model(against)[0]),
            mapping=mapping,
            rounds=ROUNDS if timed else 0,
            progress=say,
        )
        sections.append(found)
    if beside:
        sections.append(by_hand(wanted, say))
    if of_texts:
        sections += tables(wanted, say)
    report = Report(
        compilers.describe(wanted), [], sections, "What shaders cost", "gonio cost --output"
    )
    if output is not None:
        report.write(Path(output))
    click.echo(report.json() if as_json else report.text(), nl=False)


def _check_functions(functions: list[str], files: list[str], timed: bool) -> None:
    """Raise a CostError for a function that there is not, or that what is asked for needs."""
    from gonio.cost.gpus import CostError
    from gonio.export import FUNCTIONS

    for name in functions:
        if name not in FUNCTIONS:
            raise CostError(f"--only {name!r}: there are {', '.join(FUNCTIONS)}.")
    if "eval" not in functions:
        if files:
            raise CostError(f"{files[0]} is compared with eval, which --only leaves out.")
        if timed:
            raise CostError("--time runs eval, which --only leaves out.")
