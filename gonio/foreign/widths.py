"""Products whose width comes from a parameter in a way of the code's own: clamped, shifted, an exponent.

The parameter is held, and the width that the lobes would have is searched for; done for several values of
the parameter, this gives the relation between both, and a formula where it is a simple one:
alpha = (0.5 + 0.5 roughness)^2, as Burley has it for lights, or n = 2^(1 + 10 gloss).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gonio.fields import Parameter
from gonio.foreign import fresnels, terms
from gonio.foreign.expressions import Array
from gonio.foreign.function import Valued
from gonio.foreign.scales import Unscaled, unscaled
from gonio.foreign.terms import Asked, Choice, Product

# Widths that are tried: steps of a fifth, so that one is near enough to go down from.
GRID = np.geomspace(2e-3, 1.6, 40)

# So many of the best combinations of each distribution are gone down from, in so many steps.
BEST, STEPS = 6, 40

# The parameter is held at such parts of its range; the first tells the product. A range that ends above
# WIDE is one of exponents, and the parts grow by factors.
HELD, WIDE = (0.55, 0.08, 0.25, 0.4, 0.7, 0.85, 1.0), 10
GROWING = (0.1, 0.003, 0.01, 0.03, 0.3, 0.6, 1.0)

# A formula is one if it is so near to all widths, and coefficients are shown in so many digits.
FORMULA, DIGITS = 2e-3, 3

# A number that changes the shape of the lobe less than this is no width.
SHAPED = 1e-3

# Constants of products at different widths are the same to this.
SAME = 3e-3


def identify(foreign: Valued) -> list[Product]:
    """Products, best first; if none has a usual width, one with a width of the code's own.

    Args:
        foreign: code that is running.
    """
    found = terms.identify(foreign)
    if not found or found[0].exact:
        return found
    inner = unscaled(foreign)
    candidates = [name for name in inner.parameters if _shapes(inner, name)]
    for name in candidates:
        free = _searched(inner, name)
        if free is not None:
            return [free, *found]
    return found


def _value(p: Parameter, part: float) -> float:
    """A parameter's value at a part of its range."""
    high = min(p.high, p.low + terms.EXPONENTS)
    return p.low + (high - p.low) * part


def _shapes(foreign: Unscaled, name: str) -> bool:
    """Whether a number changes more than the size of values."""
    p = foreign.parameters[name]
    if p.width == 3 or not p.low < p.high:
        return False
    seen = [terms.asked(foreign, {name: _value(p, part)}) for part in (0.4, 0.7)]
    if seen[0] is None or seen[1] is None or len(seen[0].log) != len(seen[1].log):
        return seen[0] is not None
    return float((seen[0].log - seen[1].log).std()) > SHAPED


@dataclass(frozen=True)
class _Combination:
    """A product but for its width."""

    shape: int
    """The number of the distribution and the masking among those of `_made`."""
    fresnel: int
    powers: tuple[int, int]


def _made(seen: Asked, alpha: float, held: Array, only: int | None = None) -> list[Choice]:
    """D times G for one width: all of them, or one by its number."""
    c = seen.cosines
    found = []
    a = np.full(len(seen.log), alpha)
    maskings = list(terms.maskings(c, a, held))
    lobes = list(terms.DISTRIBUTIONS.items())
    if only is not None:
        lobes = [lobes[only // len(maskings)]]
        maskings = [maskings[only % len(maskings)]]
    for d_name, D in lobes:
        log_d = np.log(np.maximum(D(c.h, a), fresnels.TINY))
        for g_name, G, usual in maskings:
            kind = "bare" if g_name in terms.BARE else "specular"
            log = log_d + np.log(np.maximum(G, fresnels.TINY))
            found.append(Choice(f"{d_name}, {{}}; {g_name}", log, usual, kind))
    return found


def _searched(foreign: Unscaled, name: str) -> Product | None:
    """The product whose width a number gives, whatever the relation between both."""
    p = foreign.parameters[name]
    parts = HELD if p.high <= WIDE else GROWING
    with np.errstate(all="ignore"):
        seen = terms.asked(foreign, {name: _value(p, parts[0])})
        if seen is None or seen.stretched:
            return None
        colours = {n: v for n, v in seen.colours.items() if n != name}
        fresnel = terms.choices(fresnels.terms(seen.cosines, colours))
        combination, alpha = _best(seen, name, fresnel)
        if combination is None:
            return None
        pairs = []
        first = _product(seen, name, fresnel, combination, alpha)
        for part in parts:
            value = _value(p, part)
            there = terms.asked(foreign, {name: value})
            if there is None:
                continue
            known = {n: v for n, v in there.colours.items() if n != name}
            f = terms.choices(fresnels.terms(there.cosines, known))
            width, misfit = _width(there, name, f, combination)
            made = _product(there, name, f, combination, width)
            if misfit < terms.EXACT:
                pairs.append((value, width, made.constant))
    if len(pairs) < len(parts) // 2:  # too few for a relation
        return None
    r, alpha, constant = np.array(sorted(pairs)).T
    text = formula(name, r, alpha)
    shape, *others = first.terms
    first = replace(first, terms=(shape.format(text), *others))
    if np.ptp(constant) < SAME * constant.max():
        return first
    said = f"times a factor that is {_some(name, r, constant)}"
    odd = f"the factor before the lobe changes with {name}: its distribution is not normalised"
    return replace(first, terms=(*first.terms, said), constant=1.0, odd=(*first.odd, odd))


def _product(
    seen: Asked, name: str, fresnel: list[Choice], chosen: _Combination, alpha: float
) -> Product:
    (shape,) = _made(seen, alpha, seen.numbers[name], chosen.shape)
    return terms.made(seen, seen.cosines, shape, fresnel[chosen.fresnel], chosen.powers)


def _best(seen: Asked, name: str, fresnel: list[Choice]) -> tuple[_Combination | None, float]:
    """The combination that is the code but for roundings, with its width; the usual one if several are."""
    c = seen.cosines
    lefts, which = [], []
    for powers in terms.POWERS:
        before = powers[0] * np.log(c.i) + powers[1] * np.log(c.o)
        for k, f in enumerate(fresnel):
            left = seen.log - f.log - before
            lefts.append(left - left.mean())
            which.append((k, powers))
    left_ = np.stack(lefts)
    sizes = (left_**2).mean(axis=1)
    variances = []
    for alpha in GRID:
        shapes = np.stack([s.log for s in _made(seen, alpha, seen.numbers[name])])
        shapes = shapes - shapes.mean(axis=1, keepdims=True)
        own = (shapes**2).mean(axis=1)[:, None]
        variances.append(sizes[None] + own - 2 * shapes @ left_.T / len(c.i))
    v = np.array(variances)
    # Near its width a combination's variance is a parabola, whose lowest point counts
    middle = np.clip(np.argmin(v, axis=0), 1, len(GRID) - 2)
    below, there, above = (np.take_along_axis(v, middle[None] + k, 0)[0] for k in (-1, 0, 1))
    bent = np.maximum(below - 2 * there + above, fresnels.TINY)
    lowest = there - (above - below) ** 2 / (8 * bent)
    found = []
    maskings = lowest.shape[0] // len(terms.DISTRIBUTIONS)
    # Some of each distribution: another one is often nearer than the right one beside its width
    chosen = [
        np.unravel_index(flat + first * lowest.shape[1], lowest.shape)
        for first in range(0, lowest.shape[0], maskings)
        for flat in np.argsort(lowest[first : first + maskings], axis=None)[:BEST]
    ]
    for row, column in chosen:
        key = _Combination(int(row), *which[int(column)])
        alpha = float(GRID[middle[row, column]])
        width, misfit = _down(seen, name, fresnel, key, alpha)
        if misfit < terms.EXACT:
            made = _product(seen, name, fresnel, key, width)
            found.append((len(made.odd), len(made.terms), misfit, key, width))
    if not found:
        return None, 0.0
    return min(found, key=lambda f: f[:3])[3:]


def _width(
    seen: Asked, name: str, fresnel: list[Choice], chosen: _Combination
) -> tuple[float, float]:
    """The width at which a combination is nearest, and how near."""
    off = [_product(seen, name, fresnel, chosen, alpha).misfit for alpha in GRID]
    return _down(seen, name, fresnel, chosen, float(GRID[int(np.argmin(off))]))


def _down(
    seen: Asked, name: str, fresnel: list[Choice], chosen: _Combination, alpha: float
) -> tuple[float, float]:
    """The best width near another, and how far the code is from it."""
    from scipy.optimize import minimize_scalar

    step = np.log(GRID[1] / GRID[0])
    found = minimize_scalar(
        lambda x: _product(seen, name, fresnel, chosen, float(np.exp(x))).misfit,
        bounds=(np.log(alpha) - step, np.log(alpha) + step),
        method="bounded",
        options={"xatol": 1e-7, "maxiter": STEPS},
    )
    return float(np.exp(found.x)), float(found.fun)


# What is a straight line in a parameter or its square: the width, its root, an exponent or its logarithm.
_FORMS: dict[str, tuple[Callable[[Array], Array], Callable[[Array], Array]]] = {
    "alpha = {}": (lambda a: a, lambda y: y),
    "alpha = ({})^2": (np.sqrt, lambda y: y * y),
    "alpha = ({})^4": (lambda a: a**0.25, lambda y: y**4),
    "alpha = sqrt({})": (lambda a: a * a, np.sqrt),
    "alpha = sqrt(2 / (n + 2)), n = 2^({})": (
        lambda a: np.log2(np.maximum(2 / (a * a) - 2, fresnels.TINY)),
        lambda y: np.sqrt(2 / (2**y + 2)),
    ),
    "alpha = sqrt(2 / (n + 2)), n = {}": (
        lambda a: 2 / (a * a) - 2,
        lambda y: np.sqrt(2 / np.maximum(y + 2, fresnels.TINY)),
    ),
}
_VARIABLES: dict[str, Callable[[Array], Array]] = {"{}": lambda r: r, "{}^2": lambda r: r * r}


def formula(name: str, r: Array, alpha: Array) -> str:
    """How a width follows a parameter: a formula, or some of its values.

    Args:
        name: of the parameter.
        r: values of it, (n,), by size.
        alpha: the widths there.
    """
    with np.errstate(all="ignore"):
        for (form, (there, back)), (variable, turn) in (
            (f, v) for f in _FORMS.items() for v in _VARIABLES.items()
        ):
            u, y = turn(r), there(alpha)
            if not np.isfinite(y).all() or np.ptp(y) == 0:
                continue
            slope, level = np.polyfit(u, y, 1)
            level = 0.0 if abs(level) < FORMULA * abs(slope) * np.ptp(u) else level
            a, b = (float(f"{x:.{DIGITS}g}") for x in (level, slope))
            if not np.nanmax(np.abs(back(a + b * u) / alpha - 1)) < FORMULA:
                continue
            shown = variable.format(name)
            times = shown if abs(b) == 1 else f"{abs(b):g} {shown}"
            sign = "-" if b < 0 else "+" if a else ""
            line = " ".join(w for w in (f"{a:g}" if a else "", sign, times) if w)
            return form.format(line)
    return f"alpha = {_some(name, r, alpha)}"


def _some(name: str, r: Array, y: Array) -> str:
    """What follows a parameter, at three places."""
    places = sorted({0, len(r) // 2, len(r) - 1})
    return ", ".join(f"{y[k]:.3g} at {name} = {r[k]:.3g}" for k in places)
