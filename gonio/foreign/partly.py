"""Products of known terms but for one: a Fresnel term, a distribution or a masking that nobody has named.

Such a term depends on one cosine alone, or on N.L and N.V. Pairs of directions come in groups that share
it, so that it drops out of the differences inside of a group, whatever it is, and the others can be told.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.foreign import fresnels, terms
from gonio.foreign.expressions import Array
from gonio.foreign.fresnels import Cosines
from gonio.foreign.function import Valued
from gonio.foreign.scales import unscaled

# Groups of pairs of directions, pairs in each, and the fewest of them that have values.
GROUPS, EACH, LEFT = 40, 8, 3

# The lowest cosine of light and viewer.
LOWEST = 0.1

# The unknown term is shown at so many places.
SHOWN = 4

# Powers of N.L and N.V, of which no more than these are common beside masking.
POWERS = ((-1, -1), (0, 0), (0, -1), (-1, 0))

Log = tuple[str, Array]
"""What a term is called, and the logarithm of its values."""


@dataclass(frozen=True)
class Partly:
    """A product one term of which is unknown."""

    terms: tuple[str, ...]
    kind: str
    """What the unknown term stands in the place of."""
    of: str
    """What it depends on."""
    fixed: dict[str, float]
    """Values of the parameters that it may depend on."""
    values: tuple[tuple[float, float], ...]
    """Where it was seen, and what it is there; none if it depends on two things."""
    misfit: float

    def __str__(self) -> str:
        """In a sentence."""
        text = f"{'; '.join(self.terms)}; and {self.kind} that is not known, of {self.of} alone"
        if self.values:
            text += ": " + ", ".join(f"{y:.3g} at {x:.2f}" for x, y in self.values)
        at = ", ".join(f"{name} = {value:.3g}" for name, value in self.fixed.items())
        return f"{text} (with {at})" if at and self.values else text


def identify(foreign: Valued) -> Partly | None:
    """The known terms of a product, if all but one are known."""
    inner = unscaled(foreign)
    numbers = [n for n, p in inner.parameters.items() if p.width == 1 and 0 <= p.low < p.high <= 1]
    found = [
        partly
        for width in numbers
        for search in (_fresnel, _distribution, _masking)
        if (partly := search(inner, width)) is not None
    ]
    best = min(found, key=lambda f: (len(f.terms), f.misfit), default=None)
    if best is None or not inner.scales:
        return best
    return replace(best, terms=(*best.terms, inner.text))


@dataclass(frozen=True)
class _Seen:
    """Values of code in groups of pairs."""

    log: Array
    """Logarithms of its values, without the cosine and the factor that it returns, (n,)."""
    cosines: Cosines
    values: dict[str, Array]
    """Of the parameters that vary."""
    fixed: dict[str, float]
    group: NDArray[np.intp]
    """The number of the group of each pair, (n,)."""
    shared: Array
    """What a group shares, (groups,)."""

    def inside(self, x: Array) -> Array:
        """Differences from the mean of each group, (..., n)."""
        count = np.bincount(self.group)
        means = np.stack([np.bincount(self.group, row) / count for row in np.atleast_2d(x)])
        return np.atleast_2d(x) - means[:, self.group]

    def means(self, x: Array) -> Array:
        """Of each group, (groups,)."""
        return np.asarray(np.bincount(self.group, x) / np.bincount(self.group))


def _seen(
    foreign: Valued,
    pairs: Iterator[tuple[float, Array, Array]],
    varies: Callable[[str], bool],
) -> _Seen | None:
    """The code's values; parameters that do not vary are in the middle of their ranges."""
    rows = list(itertools.islice(pairs, GROUPS))
    wi, wo = (np.concatenate([row[k] for row in rows]) for k in (1, 2))
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    c = Cosines(wi[:, 2], wo[:, 2], h[:, 2], (wi * h).sum(1), (wi * wo).sum(1))
    rng = np.random.default_rng(53)
    given: dict[str, Array] = {}
    fixed: dict[str, float] = {}
    for name, p in foreign.parameters.items():
        high = min(p.high, p.low + 1)
        if varies(name):
            given[name] = p.low + (high - p.low) * rng.uniform(0.25, 0.9, len(wi))
        else:
            fixed[name] = p.low + 0.5 * (high - p.low)
    shown = {
        name: np.repeat(v[:, None], 3, axis=1) if foreign.parameters[name].width == 3 else v
        for name, v in given.items()
    }
    middle = {n: np.full(3, v) if foreign.parameters[n].width == 3 else v for n, v in fixed.items()}
    raw = foreign.raw(wi, wo, {**middle, **shown})[:, 0] / foreign.returns.factor
    raw = raw / c.i**foreign.returns.cosine
    good = np.isfinite(raw) & (raw > terms.FAINT * np.nanmax(np.where(np.isfinite(raw), raw, 0)))
    group = np.repeat(np.arange(len(rows)), EACH)
    good &= (np.bincount(group, good) >= LEFT)[group]
    kept, number = np.unique(group[good], return_inverse=True)
    if len(kept) < GROUPS // 2:
        return None
    cut = Cosines(c.i[good], c.o[good], c.h[good], c.d[good], c.v[good])
    varying = {name: v[good] for name, v in given.items()}
    shared = np.array([rows[k][0] for k in kept])
    return _Seen(np.log(raw[good]), cut, varying, fixed, number, shared)


def _around(h: Array, cos_d: Array, turn: Array) -> tuple[Array, Array]:
    """Directions with half vectors (n, 3), at an angle from them."""
    x = np.stack([h[:, 2], np.zeros(len(h)), -h[:, 0]], -1)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(h, x)
    side = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y
    wi = cos_d[:, None] * h + np.sqrt(1 - cos_d**2)[:, None] * side
    return wi, 2 * cos_d[:, None] * h - wi


def _sharing(what: str) -> Iterator[tuple[float, Array, Array]]:
    """Groups of pairs with the same V.H or the same N.H, or the same N.L and N.V."""
    rng = np.random.default_rng(51)
    while True:
        n = 40 * EACH
        one = float(rng.uniform(0.2, 0.98))
        if what == "N.L and N.V":
            z, other = one, float(rng.uniform(0.15, 0.98))
            phi = rng.uniform(0, 2 * np.pi, n)
            s, t = np.sqrt(1 - z * z), np.sqrt(1 - other * other)
            wi = np.stack([np.full(n, s), np.zeros(n), np.full(n, z)], -1)
            wo = np.stack([t * np.cos(phi), t * np.sin(phi), np.full(n, other)], -1)
        else:
            cos_h = np.full(n, 0.6 + 0.4 * one) if what == "N.H" else rng.uniform(0.6, 1, n)
            cos_d = np.full(n, one) if what == "V.H" else rng.uniform(0.15, 1, n)
            s = np.sqrt(1 - cos_h**2)
            h = np.stack([s, np.zeros(n), cos_h], -1)
            wi, wo = _around(h, cos_d, rng.uniform(0, 2 * np.pi, n))
            one = float(cos_h[0]) if what == "N.H" else one
        good = np.flatnonzero((wi[:, 2] > LOWEST) & (wo[:, 2] > LOWEST))[:EACH]
        if len(good) == EACH:
            yield one, wi[good], wo[good]


def _best(seen: _Seen, lists: list[list[Log]]) -> tuple[float, tuple[Log, ...]]:
    """The combination of one term of each list that leaves least inside of the groups, and how much."""
    *before, last = lists
    second = seen.inside(np.stack([log for _, log in last]))
    norms = (second**2).mean(axis=1)
    best: tuple[float, tuple[Log, ...]] = (np.inf, ())
    for chosen in itertools.product(*before):
        left = seen.inside(seen.log - sum(log for _, log in chosen))[0]
        variance = norms + (left**2).mean() - 2 * (second @ left) / len(left)
        k = int(np.argmin(variance))
        if variance[k] < best[0]:
            best = (float(variance[k]), (*chosen, last[k]))
    return float(np.sqrt(max(best[0], 0))), best[1]


def _powers(c: Cosines) -> list[Log]:
    return [(terms.power(a, b), a * np.log(c.i) + b * np.log(c.o)) for a, b in POWERS]


def _fresnels(c: Cosines, values: dict[str, Array]) -> list[Log]:
    with np.errstate(all="ignore"):
        return [(t, np.log(np.maximum(v, fresnels.TINY))) for t, v, _ in fresnels.terms(c, values)]


def _made(
    seen: _Seen, lists: list[list[Log]], kind: str, of: str, scale: float = 1.0
) -> Partly | None:
    """What is left if all but one term are found."""
    misfit, chosen = _best(seen, lists)
    left = seen.log - sum(log for _, log in chosen)
    if misfit > terms.EXACT or float(left.std()) < 10 * terms.EXACT:
        return None
    values: list[tuple[float, float]] = []
    if scale:
        level = scale * np.exp(seen.means(left))
        order = np.argsort(seen.shared)
        for k in np.linspace(0, len(order) - 1, SHOWN).astype(int)[::-1]:
            values.append((float(seen.shared[order[k]]), float(level[order[k]])))
    names = tuple(name for name, _ in reversed(chosen) if name and name != "no Fresnel term")
    return Partly(names, kind, of, seen.fixed, tuple(values), misfit)


def _fresnel(foreign: Valued, width: str) -> Partly | None:
    """With D and G, and a term of V.H."""
    seen = _seen(foreign, _sharing("V.H"), lambda name: name == width)
    if seen is None:
        return None
    with np.errstate(all="ignore"):
        shapes = [
            (choice.text, choice.log)
            for choice in terms.speculars(seen.cosines, seen.values[width], width, "")
        ]
    return _made(seen, [_powers(seen.cosines), shapes], "a Fresnel term", "V.H", 4.0)


def _colours(foreign: Valued, width: str) -> set[str]:
    """Parameters that may be F0 or F90."""
    return {
        name
        for name, p in foreign.parameters.items()
        if p.width == 3 or (name != width and p.high <= 1)
    }


def _distribution(foreign: Valued, width: str) -> Partly | None:
    """With G and F, and a term of N.H."""
    colours = _colours(foreign, width)
    seen = _seen(foreign, _sharing("N.H"), lambda name: name in colours)
    if seen is None:
        return None
    c = seen.cosines
    maskings: list[Log] = []
    with np.errstate(all="ignore"):
        for scale, turn in terms.WIDTHS.items():
            r = np.full(len(seen.log), seen.fixed[width])
            for name, G, _ in terms.maskings(c, np.maximum(turn(r), 1e-4), r):
                text = name if name in terms.BARE else f"{name}, alpha = {scale.format(width)}"
                maskings.append((text, np.log(np.maximum(G, fresnels.TINY))))
    lists = [_powers(c), _fresnels(c, seen.values), maskings]
    return _made(seen, lists, "a distribution", "N.H", 4.0)


def _masking(foreign: Valued, width: str) -> Partly | None:
    """With D and F, and a term of N.L and N.V."""
    colours = _colours(foreign, width)
    seen = _seen(foreign, _sharing("N.L and N.V"), lambda name: name in colours)
    if seen is None:
        return None
    c = seen.cosines
    lobes: list[Log] = []
    with np.errstate(all="ignore"):
        for d_name, D in terms.DISTRIBUTIONS.items():
            for scale, turn in terms.WIDTHS.items():
                alpha = np.maximum(turn(np.full(len(seen.log), seen.fixed[width])), 1e-4)
                text = f"{d_name}, alpha = {scale.format(width)}"
                lobes.append((text, np.log(np.maximum(D(c.h, alpha), fresnels.TINY))))
    return _made(seen, [_fresnels(c, seen.values), lobes], "masking", "N.L and N.V", 0.0)
