"""`gonio fit`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from gonio.cli._cluster import cluster_options, run_of
from gonio.cli._code import Code, code_options
from gonio.cli.program import complete, echo_json, json_option, progress
from gonio.files import check_place, replacing
from gonio.fit import CHANNELS, LEVEL, METRICS, POINTS, Fit
from gonio.fit.misfit import EXACT
from gonio.foreign.model import ForeignModel
from gonio.materials.notation import model_text
from gonio.materials.toml_file import to_toml

PICTURES = (".png", ".svg", ".pdf", ".csv")


@click.command("fit", short_help="Fit models to measured reflection, or to another model.")
@click.argument("data", metavar="DATA")
@click.argument("models", nargs=-1, required=True, metavar="MODEL...", shell_complete=complete)
@click.option(
    "--metric",
    type=click.Choice(list(METRICS)),
    default=next(iter(METRICS)),
    show_default=True,
    help="What is made small: ln(1 + f cos), its cube root, or f cos itself.",
)
@click.option(
    "--fix",
    multiple=True,
    metavar="NAME[=VALUE]",
    help="A parameter that stays, at its default or a value; again for more.",
)
@click.option(
    "--free",
    multiple=True,
    metavar="NAME",
    help="A parameter that is given to a MODEL, and begins there instead of staying.",
)
@click.option(
    "--tie",
    multiple=True,
    metavar="NAME=NAME",
    help="Parameters that are one number, as alpha_x=alpha_y; again for more.",
)
@click.option(
    "--truth", is_flag=True, help="DATA is a layered model: fit to random walks through its layers."
)
@click.option("--starts", type=click.IntRange(1, 1000), default=4, show_default=True)
@click.option(
    "--points",
    type=click.IntRange(0),
    default=POINTS,
    show_default=True,
    help="Directions that are drawn from the data; 0 for all.",
)
@click.option(
    "--seed", type=click.IntRange(0, 65535), default=0, help="Of the draw and the starts."
)
@click.option(
    "-o",
    "--output",
    "outputs",
    multiple=True,
    metavar="FILE",
    help="Write the best: a material (.toml), or a picture of data, fit and difference (.png .svg .pdf "
    ".csv); again for both.",
)
@cluster_options
@code_options
@json_option
def command(
    data: str,
    models: tuple[str, ...],
    metric: str,
    fix: tuple[str, ...],
    free: tuple[str, ...],
    tie: tuple[str, ...],
    truth: bool,
    starts: int,
    points: int,
    seed: int,
    outputs: tuple[str, ...],
    cluster: str | None,
    run_dir: str | None,
    code: Code,
    as_json: bool,
) -> int:
    """Find the parameters of each MODEL that come nearest to DATA: a measured file, a folder, a model.

    Of a folder, every file of measured reflection in it and below is fitted. With --cluster or --run-dir,
    more than 8 starts are several tasks; what is found is the same.

    What is given to a MODEL, as in disney:metallic=1, stays; --free lets it go from there. A sum of
    lobes is written with plus signs. All metrics are reported, because they do not agree: the misfit of
    real data is the models', not noise, and how much of it is noise is said. A material that is written
    is ready for gonio render and gonio export.

    \b
    Examples:
      gonio fit paint.binary disney torrance_sparrow
      gonio fit paint.binary disney:metallic=1 -o paint.toml -o paint.png
      gonio fit metal.bsdf "lambert+ward" --tie alpha_x=alpha_y
      gonio fit paint.binary "lambert+torrance_sparrow:fresnel=schlick+torrance_sparrow:fresnel=schlick"
      gonio fit oren_nayar:sigma=0.5 eon
      gonio fit merl/ disney torrance_sparrow --cluster local --json
      gonio fit lacquered_oak disney --truth        # the nearest to the lacquer's layers
      gonio fit paint.binary shading.glsl#specular --range roughness=0.05..1
    """
    from gonio import fit

    _check_outputs(outputs)
    shared = Path(data).is_dir() or cluster is not None or run_dir is not None
    if shared and (code.given or truth or outputs):
        raise click.UsageError(
            "folders, --cluster and --run-dir are for gonio's models and files, and print what is found; "
            "leave --truth, -o and options of code out"
        )
    target: Any = None
    if Path(data).is_dir():
        named = code.models(models)
    else:
        target, named = _target(data, models, truth, code)
    if any(Path(o).suffix.lower() == ".toml" for o in outputs) and any(
        isinstance(model, ForeignModel) for model in named
    ):
        raise click.UsageError("-o writes a material of gonio's own models; code has no such file")
    candidates = [
        _candidate(text, model, fix, free, tie) for text, model in zip(models, named, strict=True)
    ]
    _check_names(candidates, fix, free, tie)
    if shared:
        given = {"metric": metric, "starts": starts, "points": points or None, "seed": seed}
        return _many(data, target, candidates, given, cluster, run_dir, as_json)
    found: list[Fit] = []
    with progress("fitting") as step:
        for number, (model, fixed, tied) in enumerate(candidates):

            def part(done: int, total: int, number: int = number) -> None:
                step(number * total + done, len(candidates) * total)

            found.append(
                fit.fit(
                    model,
                    target,
                    metric=metric,
                    fixed=fixed,
                    tied=tied,
                    starts=starts,
                    points=points or None,
                    seed=seed,
                    progress=part,
                )
            )
    found.sort(key=lambda f: f.misfit[metric])
    costs = [_instructions(f.model) for f in found]
    for output in outputs:
        _write(output, found[0], target, data, seed)
    if as_json:
        echo_json([_data(f, cost) for f, cost in zip(found, costs, strict=True)])
        return 0
    for line in lines(found, costs):
        click.echo(line)
    for output in outputs:
        click.echo(output)
    return 0


def _many(
    data: str,
    target: Any,
    candidates: list[Any],
    given: dict[str, Any],
    cluster: str | None,
    run_dir: str | None,
    as_json: bool,
) -> int:
    """Fits by tasks, of a folder or of one thing."""
    from gonio.cluster import fits
    from gonio.measured import is_data_file

    folder = Path(data).is_dir()
    targets: list[Any] = [Path(data) if is_data_file(data) else target]
    if folder:
        targets = list(fits.data_files(data))
    printed: list[dict[str, Any]] = []
    beside = Path(data).name if folder else "gonio-fit"
    with run_of(cluster, run_dir, beside, "fitting") as run:
        for place, found in fits.fits(run, targets, candidates, given):
            costs = [_instructions(f.model) for f in found]
            these = [_data(f, cost) for f, cost in zip(found, costs, strict=True)]
            printed += [{"data": str(place), "fits": these}] if folder else these
            if not as_json and found:
                for line in [str(place)] * folder + list(lines(found, costs)):
                    click.echo(line)
    if as_json:
        echo_json(printed)
    return 1 if run.failures else 0


def _check_outputs(outputs: tuple[str, ...]) -> None:
    from gonio.plot.output import check_output

    for output in outputs:
        suffix = Path(output).suffix.lower()
        if suffix == ".toml":
            check_place(output)
        elif suffix in PICTURES:
            check_output(output)
        else:
            raise click.UsageError(
                f"--output {output}: a material file's name ends in .toml, a picture's in "
                f"{', '.join(PICTURES)}"
            )
    kinds = [Path(output).suffix.lower() == ".toml" for output in outputs]
    if len(set(outputs)) < len(outputs) or sum(kinds) > 1:
        raise click.UsageError("--output names two files for one thing; give one of each")


def _target(data: str, texts: tuple[str, ...], truth: bool, code: Code) -> tuple[Any, list[Any]]:
    """What is fitted to, and the models that are fitted."""
    from gonio import measured
    from gonio.reference import Stack

    if measured.is_data_file(data):
        if truth:
            raise click.UsageError(f"--truth is for layered models; {data} is measured")
        return measured.load(data), code.models(texts)
    model, *named = code.models([data, *texts])
    return (Stack.of(model) if truth else model), named


def _model(text: str) -> Any:
    from gonio import materials

    return materials.load_model(text)[0]


def _candidate(
    text: str, model: Any, fix: tuple[str, ...], free: tuple[str, ...], tie: tuple[str, ...]
) -> tuple[Any, tuple[str, ...], tuple[tuple[str, ...], ...]]:
    """A model, the names that are fixed in it, and those that are tied."""
    from gonio.fit import has

    fixed = [name for name in _given(text) if name not in free and has(model, name)]
    for name, _, value in (entry.partition("=") for entry in fix):
        if has(model, name):
            if value and name in fixed:
                raise click.UsageError(f"{name} is given twice, by --fix and in {text}; drop one")
            fixed.append(name)
            if value:
                model = _assigned(model, name, value)
    tied = [tuple(part.strip() for part in entry.split("=")) for entry in tie]
    return model, tuple(fixed), tuple(t for t in tied if all(has(model, name) for name in t))


def _assigned(model: Any, name: str, value: str) -> Any:
    """The model with a parameter, or a channel of a colour, at a value."""
    from gonio.materials import notation

    stored = {path: (declared, old) for path, declared, old in model.parameters()}
    if name in stored:
        return notation.assign(model, [f"{name}={value}"], _model)
    path, _, channel = name.rpartition(".")
    _, old = stored[path]
    triple = list(old if isinstance(old, tuple) else (old,) * 3)
    try:
        triple[CHANNELS.index(channel)] = float(value)
    except ValueError:
        raise click.UsageError(f"--fix {name}={value}: {value!r} is not a number") from None
    return model.replace(**{path: tuple(triple)})


def _given(text: str) -> Iterator[str]:
    """The parameters that a text gives a model, those of a sum's terms with their paths."""
    from gonio.materials import notation

    one_file = Path(notation.split(text)[0]).exists()
    terms = [text] if one_file else notation.terms(text)
    for number, term in enumerate(terms):
        # Sums of two, one in the other's second
        path = "second." * number + ("first." if number < len(terms) - 1 else "")
        for piece in notation.split(term)[1]:
            yield path + piece.partition("=")[0].strip()


def _check_names(
    candidates: list[Any], fix: tuple[str, ...], free: tuple[str, ...], tie: tuple[str, ...]
) -> None:
    """Names that no model has are mistakes; with several models, each takes those that it has."""
    from gonio.fit import columns, has

    models = [model for model, _, _ in candidates]
    for name in (entry.partition("=")[0] for entry in fix):
        if not any(has(model, name) for model in models):
            columns(models[0], [name])
    for name in free:
        if not any(has(model, name) for model in models):
            columns(models[0], [name])
    for entry in tie:
        names = [part.strip() for part in entry.split("=")]
        if not any(all(has(model, name) for name in names) for model in models):
            columns(models[0], (), [names])


def _instructions(model: Any) -> int | None:
    """What the model's `eval` costs in a shader; None where the compilers are not there."""
    from gonio.bench.shaders import length
    from gonio.export import export
    from gonio.export.prove.tools import ProofError
    from gonio.export.tree import ExportError

    try:
        return length(export({model.name: model}, "glsl", only=("eval",))[0]).instructions
    except (ProofError, ExportError):
        return None


def _write(output: str, found: Fit, target: Any, data: str, seed: int) -> None:
    if Path(output).suffix.lower() != ".toml":
        from gonio.fit import picture

        picture.save(output, found, target, Path(data).name, seed)
        return
    from gonio import materials

    size = f"misfit {found.relative:.2g} of the data in {found.metric}"
    best = materials.Material(
        Path(output).stem, found.model, f"Fitted to {Path(data).name}: {size}."
    )
    with replacing(output) as temporary:
        temporary.write_text(to_toml(best), encoding="utf-8")


def lines(found: list[Fit], costs: list[int | None]) -> Iterator[str]:
    """What was found, the best model first."""
    if len(found) > 1:
        yield from _table(found, costs)
    for f, cost in zip(found, costs, strict=True):
        yield model_text(f.model)
        yield from _misfit(f)
        yield from _numbers(f)
        if not f.intervals and set(f.values) - set(f.undetermined):
            yield (
                f"  {f'{LEVEL:.0%} in':<13} unknown: {f.directions} directions make {f.blocks} blocks "
                f"of neighbours, too few for {len(f.values)} numbers"
            )
        if f.undetermined:
            names = ", ".join(_whole(f.undetermined))
            yield f"  {'undetermined':<13} {names}: not determined by this data"
        if f.spare:
            yield f"  {'spare':<13} {', '.join(_whole(f.spare))}: kept, others can do whatever they do"
        if f.at_bounds:
            yield f"  {'at an end':<13} {', '.join(_whole(f.at_bounds))}"
        for number, region in enumerate(f.regions):
            yield f"  {'fails at' if number == 0 else '':<13} {region.sentence()}"
        if len(found) == 1 and not isinstance(f.model, ForeignModel):  # code is no export
            yield f"  {'cost':<13} {_cost(cost)}"
        # Below EXACT of the data all is rounding
        size = f.misfit[f.metric] / f.relative if f.relative else 0.0
        same = sum(s <= max(1.001 * f.starts[0], EXACT * size) + 1e-12 for s in f.starts)
        yield (
            f"  {'starts':<13} {same} of {len(f.starts)} came to the same; {f.directions} directions, "
            f"{f.evaluations} evaluations, {f.seconds:.1f} s"
        )


def _cost(cost: int | None) -> str:
    if cost is None:
        return (
            "unknown: glslangValidator and spirv-opt count it ('gonio doctor' says how to get them)"
        )
    return f"{cost} instructions of SPIR-V in a shader"


def _table(found: list[Fit], costs: list[int | None]) -> Iterator[str]:
    """One line for each model."""
    names = [_name(f.model) for f in found]
    width = max(len(name) for name in names)
    yield "  ".join(
        [f"{'model':<{width}}", "misfit", *(f"{m:>9}" for m in METRICS), "numbers", "instructions"]
    )
    for name, f, cost in zip(names, found, costs, strict=True):
        sizes = [f"{f.misfit[m]:>9.4g}" for m in METRICS]
        count = f"{len(f.values):>7}"
        known = f"{'unknown' if cost is None else cost:>12}"
        yield "  ".join([f"{name:<{width}}", f"{f.relative:>6.1%}", *sizes, count, known])
    yield ""


def _name(model: Any) -> str:
    """A model's name, or those of a sum's terms."""
    if model.name != "sum":
        return str(model.name)
    return f"{_name(model.first)}+{_name(model.second)}"


def _misfit(f: Fit) -> Iterator[str]:
    others = ", ".join(f"{name} {value:.4g}" for name, value in f.misfit.items())
    yield f"  {'misfit':<13} {f.relative:.2%} of the data in {f.metric}; root mean squares: {others}"
    if f.noise is not None:
        part = f.relative / max(f.misfit[f.metric], 1e-300)
        yield (
            f"  {'of that':<13} noise {f.noise.size * part:.2%} (by {f.noise.by}), the model's own "
            f"{f.noise.model * part:.2%}"
        )


def _numbers(f: Fit) -> Iterator[str]:
    """Each free number, or colour, with its interval, and what the other metrics make of it."""
    names = _whole(tuple(f.values))
    width = max(len(name) for name in names)
    shown = {m: [_number(values, name) for name in names] for m, values in f.by_metric.items()}
    wide = max(len(text) for text in shown[f.metric])
    for row, name in enumerate(names):
        between = ""
        if all(part in f.intervals for part in _parts(name, f.values)):
            low, high = (
                _number({n: ends[k] for n, ends in f.intervals.items()}, name) for k in (0, 1)
            )
            between = f"{LEVEL:.0%} in {low} to {high}"
        elsewhere = ", ".join(f"{m} {shown[m][row]}" for m in shown if m != f.metric)
        line = f"    {name:<{width}}  {shown[f.metric][row]:<{wide}}  {between}"
        yield (f"{line}; {elsewhere}" if between else line + elsewhere).rstrip()


def _parts(name: str, known: Any) -> list[str]:
    """A number's name, or those of a colour's channels."""
    return [name] if name in known else [f"{name}.{c}" for c in CHANNELS]


def _number(values: dict[str, float], name: str) -> str:
    """A value in four digits; a colour with slashes, unless it is grey."""
    found = [f"{values[part]:.4g}" for part in _parts(name, values)]
    return found[0] if len(set(found)) == 1 else "/".join(found)


def _whole(names: tuple[str, ...]) -> list[str]:
    """Names of numbers, with that of a colour in place of all its channels'."""
    found: dict[str, None] = {}
    for name in names:
        path, dot, channel = name.rpartition(".")
        whole = dot and channel in CHANNELS and all(f"{path}.{c}" in names for c in CHANNELS)
        found[path if whole else name] = None
    return list(found)


def _data(f: Fit, cost: int | None) -> dict[str, Any]:
    return {
        "model": model_text(f.model),
        "parameters": {path: value for path, _, value in f.model.parameters()},
        "metric": f.metric,
        "misfit": f.misfit,
        "relative": f.relative,
        "noise": None
        if f.noise is None
        else {"noise": f.noise.size, "model": f.noise.model, "by": f.noise.by},
        "values": f.values,
        "intervals": {name: list(ends) for name, ends in f.intervals.items()},
        "by_metric": f.by_metric,
        "linear": list(f.linear),
        "undetermined": list(f.undetermined),
        "spare": list(f.spare),
        "at_bounds": list(f.at_bounds),
        "fails": [
            {"where": r.name, "share": r.share, "ratio": r.ratio, "sentence": r.sentence()}
            for r in f.regions
        ],
        "instructions": cost,
        "starts": list(f.starts),
        "directions": f.directions,
        "seconds": f.seconds,
    }
