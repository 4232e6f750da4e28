"""What is true of a function's values whatever model it is, with float32's rounding told from error.

How large rounding can be is measured where a departure is: the directions are shaken by a few roundings of
float32, and what that changes is taken off, several times over, before anything is called a departure.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from gonio.check import energy, hemisphere, sampling
from gonio.check.adversarial import special_parts
from gonio.check.reciprocity import dimensions
from gonio.check.report import EFFORTS, FAIL, NOTE, PASS, UNSURE, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import Array
from gonio.foreign import gain
from gonio.foreign.function import Foreign
from gonio.foreign.gain import with_digits, without_poles
from gonio.foreign.harness import judged
from gonio.foreign.places import LIMIT, MU_HARD, places
from gonio.foreign.returned import names_exchanged
from gonio.foreign.rounding import BEST, NEAR, NEIGHBOURS, OFTEN, ROUNDINGS, TIMES, Rounded, rounded
from gonio.foreign.sampled import constant
from gonio.foreign.subject import ForeignSubject

# More than this of a value lost to roundings is said. At lower cosines half vectors are short, so that
# their roundings are large whatever is done with them.
LOST, MU_STEEP = 1e-3, 0.3

# Differences count relative to the larger of two values, or to this, in 1/sr.
FLOOR = 1e-4

# Half precision is compared at so many places; it has 11 bits, so that a few roundings are below this part.
HALVES, HALF_LIMIT = 4096, 0.05

# A largest value so small is black: nothing can be judged then.
BLACK = 1e-8

Progress = Callable[[int, int], None]


def check(
    foreign: Foreign,
    effort: str = "quick",
    only: Iterable[str] = (),
    progress: Progress | None = None,
) -> list[Report]:
    """Run the checks that make sense for values.

    Args:
        foreign: a function that is running.
        effort: of EFFORTS in gonio.check.report.
        only: names of VERDICTS; all if empty.
        progress: called with what is done and what there is to do.
    """
    chosen = list(only) or list(VERDICTS)
    level = EFFORTS[effort]
    subject = ForeignSubject(foreign)
    start = time.perf_counter()
    found = [_scope(foreign, subject)]
    if any(f.verdict in (UNSURE, FAIL) for f in found[0].findings):
        return found
    inner, notes = without_poles(subject)
    clear, more = with_digits(inner) if set(CLEAR) & set(chosen) else (inner, [])
    found = [replace(found[0], findings=(*found[0].findings, *notes, *more))]
    for done, name in enumerate(chosen):
        if progress is not None:
            progress(done, len(chosen))
        judged_on = subject if name == "finite" else clear if name in CLEAR else inner
        findings = VERDICTS[name](judged_on, level)
        seconds = time.perf_counter() - start
        start = time.perf_counter()
        if findings:
            found.append(Report(name, subject.name, tuple(findings), seconds))
    return found


def _scope(foreign: Foreign, subject: ForeignSubject) -> Report:
    """What was understood, and whether there is anything to judge."""
    how = "as --returns says" if foreign.returns.told else "measured; --returns says otherwise"
    if foreign.source.entry and str(foreign.returns) == "f cos(theta_i)":
        how = "as MaterialX defines it"
    findings = [
        Finding("returns", foreign.returns.factor, NOTE, f"{foreign.returns} ({how})"),
        Finding("arguments", float(foreign.matched.columns), NOTE, foreign.matched.explained()),
    ]
    if names_exchanged(foreign):
        other = {"wi": "wo", "wo": "wi"}
        told = " ".join(
            f"{leaf.place}={other[e.text]}" for leaf, e in foreign.matched.leaves if e.text in other
        )
        text = "reciprocal without the viewer's cosine: was the light taken for wo?"
        said = f'--map "{told}" exchanges them' if told else "--map says which is which"
        findings.append(Finding("exchanged", 0.0, NOTE, f"{text} {said}"))
    if summed := judged(foreign.source, foreign.function):
        text = f"{' + '.join(summed)}, which it writes"
        findings.append(Finding("judged", float(len(summed)), NOTE, text))
    text = "factors, widths and terms that break no law; 'gonio compare' with a model finds these"
    findings.append(Finding("not judged", 0.0, NOTE, text))
    if foreign.shipped is None and foreign.source.short:
        text = "it is declared, and computed in float32 here, so that what it loses is not judged"
        findings.append(Finding("half precision", 0.0, NOTE, text))
    words = foreign.source.reached(foreign.function)
    for name, word in foreign.textures.items():
        if {name, constant(name)} & words:
            text = (
                f"{name} is taken for {word}; --texture {name}=FILE.png or a value says otherwise"
            )
            findings.append(Finding("texture", 0.0, NOTE, text))
    findings += [Finding("assumed", 0.0, NOTE, note) for note in foreign.matched.notes]
    points = np.random.default_rng(1).random((512, dimensions(subject)))
    values = np.abs(foreign.brdf(*places(subject, points)))
    largest = float(np.nanmax(values)) if np.isfinite(values).any() else float("nan")
    if not largest > BLACK:
        black = largest == largest
        what = "black" if black else "not a number"
        text = f"{what} at all of 512 random places, so that nothing can be judged; is --map right?"
        findings.append(Finding("values", largest, UNSURE if black else FAIL, text))
    return Report("scope", subject.name, tuple(findings))


def _departure(a: Rounded, b: Rounded) -> Array:
    """Relative differences beyond rounding, of the worst channel, (n,)."""
    with np.errstate(invalid="ignore"):
        beyond = np.abs(a.values - b.values) - ROUNDINGS * (a.rounding + b.rounding)
        scale = np.maximum(np.maximum(np.abs(a.values), np.abs(b.values)), FLOOR)
        return np.asarray(np.nan_to_num(np.maximum(beyond, 0) / scale, nan=0.0).max(axis=1))


Other = Callable[[Foreign, Array, Array, Any, Array, int], Rounded]
"""What values should be equal to, for directions, values, further coordinates, and a number of shakes."""


def _searched(
    subject: ForeignSubject, effort: Effort, what: str, other: Other, seed: int, extra: int = 0
) -> Finding:
    """The largest departure of a function from what it should be equal to."""
    foreign = subject.foreign
    numbers, size = len(subject.parameters), dimensions(subject)

    def departure(points: Array, times: int = TIMES) -> Array:
        wi, wo, values = places(subject, points[:, :size])
        a = rounded(foreign, wi, wo, values, times=times)
        return _departure(a, other(foreign, wi, wo, values, points[:, size:], times))

    points, _ = maximise(
        departure,
        size + extra,
        population=effort.population // 4,
        rounds=effort.rounds // 2 + 2,
        seed=seed,
        special=special_parts(subject),
    )
    rng = np.random.default_rng(seed)
    near = np.repeat(points[:BEST], NEIGHBOURS, axis=0)
    near[:, numbers:] += NEAR * rng.uniform(-1, 1, near[:, numbers:].shape)
    lasting = departure(np.clip(near, 0, 1), OFTEN).reshape(-1, NEIGHBOURS)
    lasting = np.quantile(lasting, 0.25, axis=1)
    best = int(np.argmax(lasting))
    measured = float(lasting[best])
    wi, wo, given = places(subject, points[best : best + 1, :size])
    both = rounded(foreign, wi, wo, given, times=OFTEN)
    rounding = float((both.rounding / np.maximum(np.abs(both.values), FLOOR)).max())
    verdict = PASS if measured <= LIMIT else FAIL
    angles = np.degrees(np.arccos(np.clip([wi[0, 2], wo[0, 2]], 0, 1)))
    where = (
        f"; theta_i = {angles[0]:.4g}, theta_o = {angles[1]:.4g} degrees" if verdict == FAIL else ""
    )
    text = f"at most {LIMIT:g} beyond rounding, which is {rounding:.1g} there{where}"
    case = (points[best, :numbers], wi[0], wo[0])
    return Finding(what, measured, verdict, text, "", subject.replay(*case), case)


def _reciprocity(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    def swapped(f: Foreign, wi: Array, wo: Array, values: Any, _: Array, times: int) -> Rounded:
        return rounded(f, wo, wi, values, 6, times)

    return [_searched(subject, effort, "relative difference", swapped, 11)]


def _isotropy(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    def turned(f: Foreign, wi: Array, wo: Array, values: Any, t: Array, times: int) -> Rounded:
        c, s = np.cos(2 * np.pi * t[:, 0]), np.sin(2 * np.pi * t[:, 0])
        a, b = (
            np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], -1)
            for w in (wi, wo)
        )
        return rounded(f, a, b, values, 7, times)

    found = _searched(subject, effort, "change by a turn", turned, 13, extra=1)
    if found.verdict == PASS:
        return [found]
    roles = set().union(*(e.names for _, e in subject.foreign.matched.leaves))
    along = any(
        r.startswith(("tangent", "bitangent", "cos_tangent", "cos_bitangent")) for r in roles
    )
    local = "normal" not in roles and {"wi", "wo"} & roles
    verdict = NOTE if along or local else FAIL
    text = "anisotropic" if verdict == NOTE else "anisotropic, though it is given no tangents"
    return [
        Finding(
            found.what,
            found.measured,
            verdict,
            f"{text}; {found.text}",
            "",
            found.replay,
            found.case,
        )
    ]


def _finite(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    foreign = subject.foreign
    size = dimensions(subject)
    rng = np.random.default_rng(17)
    count = effort.cases
    points = rng.random((count, size))
    at_end = rng.random(points.shape) < 0.25
    points = np.where(at_end, rng.integers(0, 2, points.shape), points)
    findings = []
    for low, what in ((MU_HARD, "not finite"), (0.0, "not finite at the horizon")):
        wi, wo, values = places(subject, points, max(low, 1e-30))
        mu = 10.0 ** rng.uniform(np.log10(max(low, 1e-30)), 0, (count, 2))
        grazing = rng.random((count, 2)) < (0.3 if low else 0.8)
        wi = _lowered(wi, np.where(grazing[:, 0], mu[:, 0], wi[:, 2]))
        wo = _lowered(wo, np.where(grazing[:, 1], mu[:, 1], wo[:, 2]))
        mirror = rng.random(count) < 0.25
        wi = np.where(mirror[:, None], wo * np.array([-1.0, -1.0, 1.0]), wi)
        f = foreign.brdf(wi, wo, values)
        bad = np.flatnonzero(~np.isfinite(f).all(axis=1))
        if not len(bad):
            findings.append(
                Finding(what, 0.0, PASS, f"at {count} hard cases, cosines from {low or 1e-30:g}")
            )
            continue
        k = bad[int(np.argmax(np.minimum(wi[bad, 2], wo[bad, 2])))]
        shown = ", ".join(f"{x:g}" for x in f[k])
        verdict = FAIL if low else NOTE
        text = f"of {count} hard cases, cosines from {low or 1e-30:g}; one is ({shown})"
        case = (points[k, : len(subject.parameters)], wi[k], wo[k])
        findings.append(
            Finding(what, float(len(bad)), verdict, text, "", subject.replay(*case), case)
        )
    lowest, where = maximise_lowest(subject, effort)
    verdict = PASS if lowest >= -LIMIT * FLOOR else FAIL
    findings.append(
        Finding(
            "below zero, times pi",
            max(0.0, -lowest * np.pi),  # 0 first: the other may be -0
            verdict,
            "light is not negative",
            "",
            subject.replay(*where),
            where,
        )
    )
    return findings


def _lowered(w: Array, z: Array) -> Array:
    flat = np.maximum(np.hypot(w[:, 0], w[:, 1]), 1e-300)
    scale = np.sqrt(np.maximum(1 - z * z, 0)) / flat
    return np.stack([w[:, 0] * scale, w[:, 1] * scale, z], -1)


def maximise_lowest(
    subject: ForeignSubject, effort: Effort
) -> tuple[float, tuple[Array, Array, Array]]:
    """The lowest value, by search, and where."""

    def darkness(points: Array) -> Array:
        f = subject.foreign.brdf(*places(subject, points))
        lowest = np.nan_to_num(f, nan=0.0).min(axis=1)
        return np.asarray(np.nan_to_num(-lowest, posinf=0.0, neginf=0.0))

    points, values = maximise(
        darkness,
        dimensions(subject),
        population=effort.population // 4,
        rounds=effort.rounds // 2,
        seed=19,
        special=special_parts(subject),
    )
    wi, wo, _ = places(subject, points[:1])
    return -float(values[0]), (points[0, : len(subject.parameters)], wi[0], wo[0])


def _precision(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    """The largest relative change by roundings of the directions: cancellation makes it large."""
    foreign = subject.foreign
    size = dimensions(subject)

    def change(points: Array, times: int = TIMES) -> Array:
        both = rounded(foreign, *places(subject, points, MU_STEEP), times=times)
        with np.errstate(invalid="ignore"):
            scale = np.maximum(np.abs(both.values), FLOOR)
            lost = np.minimum(both.rounding / scale, 1.0)  # 1: there are no digits left
            return np.asarray(np.nan_to_num(lost, nan=0.0).max(axis=1))

    points, _ = maximise(
        change,
        size,
        population=effort.population // 4,
        rounds=effort.rounds // 2,
        seed=29,
        special=special_parts(subject),
    )
    again = change(points[:BEST], OFTEN)
    best = int(np.argmax(again))
    measured = float(again[best])
    wi, wo, _ = places(subject, points[best : best + 1], MU_STEEP)
    case = (points[best, : len(subject.parameters)], wi[0], wo[0])
    verdict, text = PASS, "change by roundings of the directions"
    if measured > LOST:
        verdict = NOTE
        text += ": digits are lost, in 1 - NoH^2 of a narrow lobe for example; a cross product keeps them"
    return [Finding("rounding", measured, verdict, text, "", subject.replay(*case), case)]


def _half(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    """What the half precision that code declares makes of its values, where that was told apart."""
    foreign, shipped = subject.foreign, subject.foreign.shipped
    if shipped is None:
        return []
    points = np.random.default_rng(47).random((HALVES, dimensions(subject)))
    points[::2, -2:] = points[::2, -4:-2] + 0.05 * (
        points[::2, -2:] - 0.5
    )  # near the mirror direction
    wi, wo, values = places(subject, np.clip(points, 0, 1), 0.05)
    full = foreign.brdf(wi, wo, values)
    half = shipped.brdf(wi, wo, values)
    lost = np.isfinite(full).all(axis=1) & ~np.isfinite(half).all(axis=1)
    with np.errstate(invalid="ignore"):
        scale = np.maximum(np.maximum(np.abs(full), np.abs(half)), FLOOR)
        off = np.nan_to_num(np.abs(full - half) / scale, nan=0.0, posinf=0.0).max(axis=1)
    k = int(np.argmax(np.where(lost, np.inf, off)))
    case = (points[k, : len(subject.parameters)], wi[k], wo[k])
    if not off.any() and not lost.any():
        text = "mediump changes nothing here: this machine's driver computes it in float32"
        return [Finding("half precision", 0.0, NOTE, text)]
    shown = f"{half[k, 0]:.4g} instead of {full[k, 0]:.4g}"
    many = f", by more than 10 % at {(off > 0.1).mean():.0%} of {HALVES} places"
    verdict = FAIL if lost.any() or off.max() > HALF_LIMIT else PASS
    text = f"mediump changes values: {shown}{many}"
    if lost.any():
        text += f"; not finite at {lost.mean():.0%}"
    return [
        Finding("half precision", float(off.max()), verdict, text, "", subject.replay(*case), case)
    ]


def _frame(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    """Directions, normal and tangents turned together: nothing may change."""
    foreign = subject.foreign
    roles = set().union(*(e.names for _, e in foreign.matched.leaves))
    if "normal" not in roles:
        return []
    points = np.random.default_rng(23).random((1024, dimensions(subject)))
    wi, wo, values = places(subject, points, 0.05)
    q = np.linalg.qr(np.random.default_rng(24).normal(size=(3, 3)))[0]
    q *= np.sign(np.linalg.det(q))
    a = rounded(foreign, wi, wo, values, times=OFTEN)
    departure = _departure(a, Rounded(foreign.brdf(wi, wo, values, turn=q), a.rounding))
    # Code that takes the normal as +z is wrong nearly everywhere, roundings are large in sharp lobes only
    k = int(np.argsort(departure)[int(0.8 * len(departure))])
    verdict = PASS if departure[k] <= LIMIT else FAIL
    text = "light, viewer, normal and tangents turned together change nothing"
    if verdict == FAIL:
        text = "turning light, viewer, normal and tangents changes the value: it takes the normal as +z"
    case = (points[k, : len(subject.parameters)], wi[k], wo[k])
    return [
        Finding(
            "change by another frame",
            float(departure[k]),
            verdict,
            text,
            "",
            subject.replay(*case),
            case,
        )
    ]


def _sampling(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    """The code's sampler and its density, as those of models."""
    if subject.foreign.sampler is None:
        return []
    return list(sampling.check(ForeignSubject(subject.foreign, drawn=True), effort).findings)


def _albedo(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    """The albedo that the code has, a fit or a table often, against integrals of its values."""
    own = subject.foreign.reflectance
    if own is None:
        return []
    count = 4 * effort.confirmed
    points = np.random.default_rng(37).random((count, energy.dimensions(subject)))
    points[0, : len(subject.parameters)] = subject.default()
    parameters, wo = energy.viewer(subject, points)
    found = hemisphere.integrate(
        subject,
        parameters,
        wo,
        hemisphere.partition(subject, parameters, wo),
        1e-5,
        albedo_only=True,
    )
    values = subject.values(parameters)
    off = np.abs(own.raw(wo, wo, values) - found.total[:, :3]).max(axis=1) - found.error
    row = int(np.argmax(np.where(np.isnan(off), np.inf, off)))
    verdict = PASS if off[row] <= LIMIT else FAIL
    text = f"at most {LIMIT:g}, at {count} places; integrals are good to {found.error.max():.1g}"
    case = (parameters[row], wo[row], wo[row])
    return [
        Finding(
            "error of albedo",
            max(float(off[row]), 0.0),
            verdict,
            text,
            "",
            subject.replay(*case),
            case,
        )
    ]


# What is judged where values have digits.
CLEAR = ("energy", "reciprocity", "isotropy", "frame")

VERDICTS: dict[str, Callable[[ForeignSubject, Effort], list[Finding]]] = {
    "energy": gain.check,
    "reciprocity": _reciprocity,
    "finite": _finite,
    "isotropy": _isotropy,
    "frame": _frame,
    "precision": lambda s, effort: [*_precision(s, effort), *_half(s, effort)],
    "sampling": _sampling,
    "albedo": _albedo,
}
