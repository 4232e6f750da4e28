"""`gonio eval`: everything that a model says about one pair of directions."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import click
import numpy as np
import numpy.typing as npt

from gonio.cli._code import Code, code_options
from gonio.cli._evaluation import Evaluation, data, lines
from gonio.cli._numbers import Number
from gonio.cli.program import complete, echo_json, json_option, param_option
from gonio.fields import few_digits
from gonio.model import Model

if TYPE_CHECKING:
    from gonio.check.derivatives import Derivative


def evaluate(model: Model, wi: Any, wo: Any, *, double: bool = False, u: Any = None) -> Evaluation:
    """Evaluate everything a model knows about one pair of unit vectors.

    Args:
        model: a model whose parameters are numbers.
        wi: towards the light, shape (3,), unit, normal +z; with `u` it is not looked at.
        wo: towards the viewer, likewise.
        double: float64 instead of float32.
        u: two random numbers in [0, 1), shape (2,): wi is the direction that `sample` makes of them.

    Raises:
        ValueError: a direction that is not a unit vector.
    """
    dtype = np.float64 if double else np.float32
    wi, wo = np.asarray(wi, dtype), np.asarray(wo, dtype)
    exact = model
    if double:  # parameters as arrays make the mean albedo, which has no directions, double as well
        exact = model.replace(
            **{
                path: np.asarray(_triple(value, declared.width), dtype)
                for path, declared, value in model.parameters()
            }
        )
    reported = None
    if u is not None:
        u = np.asarray(u, dtype)
        drawn, density = exact.sample(wo, u)
        wi, reported = np.asarray(drawn, dtype), float(str(density))
        if not (np.isfinite(wi).all() and abs(np.linalg.norm(wi) - 1) < DRAWN):
            return Evaluation(
                repr(model),
                np.dtype(dtype).name,
                few_digits(wi),
                few_digits(wo),
                [math.nan] * 3,
                math.nan,
                None,
                _albedo(exact.albedo, wo),
                _albedo(exact.mean_albedo),
                few_digits(u),
                reported,
            )
    f, pdf = exact.eval(wi, wo), float(exact.pdf(wi, wo))
    weight = f * wi[2] / pdf if pdf > 0 else None
    return Evaluation(
        model=repr(model),
        precision=np.dtype(dtype).name,
        wi=few_digits(wi),
        wo=few_digits(wo),
        eval=few_digits(f),
        pdf=pdf,
        weight=None if weight is None else few_digits(weight),
        albedo=few_digits(exact.albedo(wo)),
        mean_albedo=few_digits(exact.mean_albedo()),
        u=None if u is None else few_digits(u),
        sampled_pdf=reported,
    )


def _albedo(method: Callable[..., Any], *given: Any) -> list[float]:
    """NaN where it would be made of samples that are no directions, as one is."""
    try:
        return few_digits(method(*given))
    except ValueError:
        return [math.nan] * 3


Evaluate = Callable[..., Evaluation]
"""Evaluates wi and wo; `double` and `u` as `evaluate` has them."""


def beside(evaluated: Evaluate, what: str, given: Any) -> Evaluation:
    """What an evaluation is compared with.

    Args:
        evaluated: what was done.
        what: "double", "swapped" or "turned:DEG", as `--compare` has it.
        given: wi, wo, u (or None) and whether they were taken in double precision.

    Raises:
        UsageError: another word, or one that does not go with what was given.
    """
    wi, wo, u, double = given
    word, _, angle = what.partition(":")
    if word == "double" and not angle:
        if double:
            raise click.UsageError("--compare double shows float32 beside it; leave --double out")
        # The same numbers: what float32 has of them
        single = [None if x is None else np.asarray(x, np.float32) for x in (wi, wo, u)]
        return evaluated(single[0], single[1], double=True, u=single[2])
    if u is not None:
        raise click.UsageError(f"--compare {word} goes with --wi and --wo; with --u compare double")
    if word == "swapped" and not angle:
        return evaluated(wo, wi, double=double)
    try:
        turn = math.radians(float(angle)) if word == "turned" else math.nan
    except ValueError:
        turn = math.nan
    if not math.isfinite(turn):
        raise click.UsageError(
            f"--compare {what} is not known; write double, swapped, or turned:DEG, such as turned:90"
        )
    c, s = math.cos(turn), math.sin(turn)
    about = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return evaluated(about @ wi, about @ wo, double=double)


# A sampled direction that is further from unit length is no direction: nothing is evaluated there.
DRAWN = 1e-4


def _evaluating(
    model: str | None, plugin: str | None, code: Code, params: tuple[str, ...]
) -> tuple[Evaluate, Model | None]:
    """What evaluates the model or the plug-in, and the model."""
    if plugin is not None:
        code.refuse()
        from gonio.cli._plugin import Plugin  # with Mitsuba

        found = Plugin(plugin, params)
        return lambda wi, wo, double=False, u=None: found.evaluate(wi, wo, u), None
    (material,) = code.models([model or ""], params)
    return functools.partial(evaluate, material), material


def _derivatives(model: Model, wi: Any, wo: Any, u: Any) -> list[Derivative]:
    """All of them; of a sample at the direction that it has, where it has one."""
    from gonio.check.derivatives import derivatives  # with all that checks need

    if u is not None:
        drawn = np.asarray(model.sample(np.asarray(wo, np.float64), np.asarray(u, np.float64))[0])
        wi = drawn if np.isfinite(drawn).all() else wo
    return derivatives(model, wi, wo, u)


def _triple(value: float | tuple[float, ...], width: int) -> Any:
    return (value,) * 3 if width == 3 and not isinstance(value, tuple) else value


def directions(
    wi: Sequence[float] | None,
    wo: Sequence[float] | None,
    theta_i: float | None,
    theta_o: float | None,
    phi: float | None,
    normalize: bool,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The two directions, from vectors or from angles in degrees.

    phi: azimuth of wi minus that of wo, 0 by default; 0 is the viewer's side, 180 the mirror's.

    Raises:
        ValueError: neither or both are given, or a vector that cannot be normalised.
    """
    angles = (theta_i, theta_o, phi)
    if wi is not None and wo is not None and angles == (None, None, None):
        vectors = np.array(wi, np.float64), np.array(wo, np.float64)
        return (_normalized("wi", wi), _normalized("wo", wo)) if normalize else vectors
    if wi is None and wo is None and theta_i is not None and theta_o is not None:
        ti, to, p = (math.radians(a or 0) for a in (theta_i, theta_o, phi))
        wi = (math.sin(ti) * math.cos(p), math.sin(ti) * math.sin(p), math.cos(ti))
        wo = (math.sin(to), 0, math.cos(to))
        # The sine of 180 degrees is 1.2e-16 in doubles and should be 0.
        return np.round(wi, 15) + 0.0, np.round(wo, 15) + 0.0
    raise ValueError(
        "give both directions, either as vectors, --wi X Y Z --wo X Y Z, or as angles in degrees, "
        "--theta-i A --theta-o B [--phi C]."
    )


def _normalized(name: str, vector: Sequence[float]) -> npt.NDArray[np.float64]:
    w = np.array(vector, np.float64)
    length = np.linalg.norm(w)
    if not (np.isfinite(length) and length > 0):
        raise ValueError(
            f"{name} = {list(vector)} has no direction; give finite numbers, not all 0."
        )
    return np.asarray(w / length)


@click.command("eval", short_help="Evaluate a model for two directions.")
@click.argument("model", required=False, shell_complete=complete)
@click.option(
    "--mitsuba",
    "plugin",
    metavar="NAME|XML|JSON",
    help="Instead of a model: a Mitsuba BSDF, as 'gonio check' takes it; -p u=0.3 -p v=0.7 is a place in "
    "its textures.",
)
@click.option(
    "--wi", type=Number(), nargs=3, metavar="X Y Z", help="Unit vector towards the light."
)
@click.option(
    "--wo", type=Number(), nargs=3, metavar="X Y Z", help="Unit vector towards the viewer."
)
@click.option("--theta-i", type=Number(), metavar="DEG", help="Polar angle of the light, instead.")
@click.option("--theta-o", type=Number(), metavar="DEG", help="Polar angle of the viewer, instead.")
@click.option(
    "--phi",
    type=Number(),
    metavar="DEG",
    help="Azimuth between the two: 0 (default) is the viewer's side, 180 the mirror's.",
)
@click.option(
    "--u",
    type=Number(),
    nargs=2,
    metavar="U1 U2",
    help="Sample the light with these random numbers.",
)
@param_option
@click.option("--normalize", is_flag=True, help="Scale the vectors to length 1 first.")
@click.option("--double/--float32", help="Compute in double precision (default: float32).")
@click.option(
    "--compare",
    metavar="WITH",
    help="Also show it in double, swapped (wi and wo exchanged), or turned:DEG about the normal.",
)
@click.option(
    "--derivatives",
    is_flag=True,
    help="Also derivatives of the sum of the channels, in both precisions, beside central differences.",
)
@code_options
@json_option
def command(
    model: str | None,
    plugin: str | None,
    wi: tuple[float, float, float] | None,
    wo: tuple[float, float, float] | None,
    theta_i: float | None,
    theta_o: float | None,
    phi: float | None,
    u: tuple[float, float] | None,
    params: tuple[str, ...],
    normalize: bool,
    double: bool,
    compare: str | None,
    derivatives: bool,
    code: Code,
    as_json: bool,
) -> None:
    """Evaluate MODEL for one pair of directions: BRDF, pdf, albedos, Monte Carlo weight.

    Directions are unit vectors that leave the surface, with the normal along +z.

    \b
    Examples:
      gonio eval lambert --wi 0 0 1 --wo 0 0 1
      gonio eval eon --theta-i 30 --theta-o 60 --phi 180 --param roughness=1
      gonio eval eon --theta-o 60 --u 0.3 0.7
      gonio eval phong --theta-i 30 --theta-o 60 --compare double
      gonio eval eon --theta-i 30 --theta-o 60 --derivatives
      gonio eval --mitsuba roughplastic --theta-i 30 --theta-o 60 --phi 180
      gonio eval eon:sampler=cosine --wi 1 0 1 --wo 0 1 1 --normalize -p rho=0.8,0.3,0.1 --json
    """
    if (model is None) == (plugin is None):
        raise click.UsageError("give a MODEL, or --mitsuba NAME")
    if plugin is not None and (double or derivatives or compare == "double"):
        raise click.UsageError(
            "--mitsuba computes in single precision, without derivatives; leave --double and the like out"
        )
    evaluated, material = _evaluating(model, plugin, code, params)
    if u is not None:
        if wi is not None or theta_i is not None or phi is not None:
            raise click.UsageError("--u makes wi; it goes with --wo or --theta-o alone")
        if not all(0 <= x <= 1 for x in u):
            raise click.UsageError(f"--u {u[0]:g} {u[1]:g}: random numbers lie from 0 to 1")
        wi, theta_i = (wo, None) if wo is not None else (None, 0.0)
    if normalize and wo is None:
        raise click.UsageError("--normalize scales --wi and --wo; leave it out beside angles")
    wi_vector, wo_vector = directions(wi, wo, theta_i, theta_o, phi, normalize)
    try:
        result = evaluated(wi_vector, wo_vector, double=double, u=u)
        if compare is not None:
            given = (wi_vector, wo_vector, u, double)
            other = beside(evaluated, compare, given)
            result = dataclasses.replace(result, compared=other)
        if derivatives and material is not None:
            result = dataclasses.replace(
                result, derivatives=_derivatives(material, wi_vector, wo_vector, u)
            )
    except ValueError as error:
        if "has length" in str(error):  # the model's advice is for Python
            sentence = str(error).partition(";")[0]
            raise ValueError(f"{sentence}; give unit vectors, or add --normalize.") from error
        raise
    if as_json:
        echo_json(data(result))
    else:
        click.echo("\n".join(lines(result)))
