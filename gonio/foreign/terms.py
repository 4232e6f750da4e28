"""What shaders are made of: distributions, masking, Fresnel terms, cosines, in the ways people write them.

Most reflection in shaders is one product, D G F / (4 cos cos), or one diffuse formula. All combinations of
the terms below, right and wrong ones, are tried against values of the code: in logarithms a product is a
sum and an unknown constant is the mean, so that thousands of them cost less than one fit. A match names
every term: "GGX, alpha = roughness; masking Schlick, k = alpha / 2". Sources are the papers of gonio.parts;
the mistakes are those that forums and issue trackers are full of.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gonio.foreign import anisotropic, fresnels
from gonio.foreign.expressions import Array
from gonio.foreign.fresnels import TINY, Cosines
from gonio.foreign.function import Returns, Valued
from gonio.foreign.scales import Unscaled, unscaled

PAIRS = 300

# Values below this part of the largest one have few digits in float32.
FAINT = 1e-6

# Spread of the logarithm, up to which code is the product: roundings of float32.
EXACT = 2e-4

# The largest index of refraction of what is clear; numbers from 1 to that may be one.
DENSEST = 5.0

# Exponents up to here, so that tails have digits.
EXPONENTS = 300.0

# V.H where Schlick's term is mostly F90, and the fewest pairs of directions that tell it.
GRAZING, FEW = 0.35, 20

# Values that change more than this by a turn about the normal are anisotropic.
STRETCHED = 1e-3


@dataclass(frozen=True)
class Choice:
    """One way to write a term."""

    text: str
    """For people; empty for what is usual."""
    log: Array
    """Of its values, (n,)."""
    usual: bool = True
    kind: str = ""
    """diffuse; specular, whose cosines and 1 / 4 stand before D G; bare, without masking; lobe, a power."""
    remark: str = ""


@dataclass(frozen=True)
class Product:
    """A combination of terms that was tried."""

    terms: tuple[str, ...]
    constant: float
    misfit: float
    """Standard deviation of the logarithm of the ratio."""
    worst: float
    """Largest relative difference."""
    odd: tuple[str, ...]
    """Terms that are usually mistakes."""
    remarks: tuple[str, ...] = ()
    """What may be meant, and is not what most have."""

    @property
    def exact(self) -> bool:
        """Whether nothing but roundings is left."""
        return self.misfit < EXACT

    def __str__(self) -> str:
        """In a sentence."""
        factor = constant_name(self.constant)
        return "; ".join([*self.terms, f"times {factor}"] if factor else self.terms)


def constant_name(value: float) -> str:
    """A constant as people write it; empty for 1."""
    names = {
        "": 1.0, "pi": np.pi, "1 / pi": 1 / np.pi, "4": 4.0, "1 / 4": 0.25, "pi / 4": np.pi / 4,
        "1 / (4 pi)": 0.25 / np.pi, "4 / pi": 4 / np.pi, "2": 2.0, "1 / 2": 0.5, "1 / pi^2": np.pi**-2,
        "1 / (2 pi)": 0.5 / np.pi, "4 pi": 4 * np.pi, "1 / (4 pi^2)": 0.25 / np.pi**2, "pi^2": np.pi**2,
        "1 / 8": 0.125, "2 / pi": 2 / np.pi,
    }  # fmt: skip
    for name, number in names.items():
        if abs(value / number - 1) < 1e-3:
            return name
    return f"{value:.5g}"


def _ggx(c: Array, a: Array) -> Array:
    return a * a / (np.pi * (c * c * (a * a - 1) + 1) ** 2)


def _beckmann(c: Array, a: Array) -> Array:
    c2 = np.maximum(c * c, TINY)
    return np.asarray(np.exp((c2 - 1) / (c2 * a * a)) / (np.pi * a * a * c2 * c2))


def _blinn(c: Array, a: Array) -> Array:
    n = np.maximum(2 / (a * a) - 2, 0)
    return np.asarray((n + 2) / (2 * np.pi) * np.maximum(c, TINY) ** n)


def _charlie(c: Array, a: Array) -> Array:
    """Estevez and Kulla 2017, Eq. 2."""
    sine = np.sqrt(np.maximum(1 - c * c, TINY))
    return np.asarray((2 + 1 / a) * sine ** (1 / a) / (2 * np.pi))


def _velvet(c: Array, a: Array) -> Array:
    """Ashikhmin and Premoze 2007, as Neubelt and Pettineo 2013 normalise it."""
    s2, a2 = np.maximum(1 - c * c, TINY), a * a
    return np.asarray((1 + 4 * np.exp(-c * c / (a2 * s2)) / (s2 * s2)) / (np.pi * (1 + 4 * a2)))


DISTRIBUTIONS: dict[str, Callable[[Array, Array], Array]] = {
    "GGX": _ggx,
    "Beckmann": _beckmann,
    "Blinn-Phong": _blinn,
    "Charlie": _charlie,
    "Ashikhmin's velvet": _velvet,
}

# Cloth's widths are no roughness that is squared.
CLOTH = ("Charlie", "Ashikhmin's velvet")

# Of the width, by what is done to the parameter.
WIDTHS: dict[str, Callable[[Array], Array]] = {
    "{}": lambda r: r,
    "{}^2": lambda r: r * r,
    "{}^4": lambda r: r**4,
    "sqrt({})": np.sqrt,
    "1 - {}": lambda r: 1 - r,
    "(1 - {})^2": lambda r: (1 - r) ** 2,
}


def _smith(c: Array, a: Array) -> Array:
    """G1 of GGX."""
    return 2 * c / (c + np.sqrt(a * a + (1 - a * a) * c * c))


def _schlick_g(c: Array, k: Array) -> Array:
    return c / (c * (1 - k) + k)


def maskings(c: Cosines, a: Array, r: Array) -> Iterator[tuple[str, Array, bool]]:
    """Name, G, and whether it is usual."""
    yield "no masking", np.ones_like(a), True
    root_i = np.sqrt(a * a + (1 - a * a) * c.i * c.i)
    root_o = np.sqrt(a * a + (1 - a * a) * c.o * c.o)
    yield (
        "Smith's masking of GGX, height-correlated",
        2 * c.i * c.o / (c.i * root_o + c.o * root_i),
        True,
    )
    fast = 2 * c.i * c.o / (c.i * (c.o * (1 - a) + a) + c.o * (c.i * (1 - a) + a))
    yield "Smith's masking of GGX, height-correlated, Filament's fast form", fast, True
    ones: list[tuple[str, Callable[[Array], Array], bool]] = [
        ("Smith's masking of GGX", lambda x: _smith(x, a), True),
        ("Schlick's masking, k = alpha / 2", lambda x: _schlick_g(x, a / 2), True),
        (
            "Schlick's masking, k = (parameter + 1)^2 / 8",
            lambda x: _schlick_g(x, (r + 1) ** 2 / 8),
            True,
        ),
        ("Schlick's masking, k = alpha", lambda x: _schlick_g(x, a), False),
        ("Schlick's masking, k = alpha^2 / 2", lambda x: _schlick_g(x, a * a / 2), False),
        ("Schlick's masking, k = parameter / 2", lambda x: _schlick_g(x, r / 2), False),
        (
            "Schlick's masking, k = alpha sqrt(2 / pi)",
            lambda x: _schlick_g(x, a * np.sqrt(2 / np.pi)),
            True,
        ),
    ]
    for name, g, usual in ones:
        yield f"{name}, separable", g(c.i) * g(c.o), usual
        yield f"{name} on the light's side only", g(c.i), False
        yield f"{name} on the viewer's side only", g(c.o), False
    groove = np.minimum(1, 2 * c.h * np.minimum(c.i, c.o) / np.maximum(c.d, TINY))
    yield "Cook-Torrance's masking", groove, True
    yield "Kelemen's masking", c.i * c.o / np.maximum(c.d**2, TINY), True
    yield "Neumann's masking", c.i * c.o / np.maximum(c.i, c.o), True
    yield "Neubelt and Pettineo's masking", c.i * c.o / (c.i + c.o - c.i * c.o), True


def _plain_diffuse(c: Cosines) -> Iterator[tuple[str, Array, bool]]:
    """Shapes without a width."""
    yield "Lambert", np.ones_like(c.i), True
    # Ashikhmin and Shirley 2000, Eq. 5
    shape = 28 / 23 * (1 - (1 - c.i / 2) ** 5) * (1 - (1 - c.o / 2) ** 5)
    yield "Ashikhmin and Shirley's diffuse term", shape, True


def _diffuse(c: Cosines, r: Array, name: str) -> Iterator[tuple[str, Array, bool]]:
    """Shapes of diffuse reflection, without colour and 1 / pi."""
    s = c.v - c.i * c.o
    for text, sigma, usual in (
        (name, r, True),
        (f"{name} pi / 2", r * np.pi / 2, True),
        (f"{name}^2", r * r, False),
        (f"{name} in degrees", np.radians(r), False),
    ):
        s2 = sigma * sigma
        A, B = 1 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09)
        A57 = 1 - 0.5 * s2 / (s2 + 0.57)
        over = np.maximum(c.i, c.o)
        t = np.where(s > 0, over, 1)
        cut = np.maximum(c.v, 0) - c.i * c.o
        tc = np.where(cut > 0, over, 1)
        kinds = [
            ("Oren-Nayar", A + B * np.maximum(s, 0) / over, usual),
            ("Oren-Nayar with 0.57", A57 + B * np.maximum(s, 0) / over, usual),
            ("Oren-Nayar with Fujii's t", A + B * s / t, usual),
            ("Oren-Nayar with 0.57 and Fujii's t", A57 + B * s / t, usual),
            ("Oren-Nayar whose s / t is not cut at 0", A + B * s / over, False),
            ("Oren-Nayar with Fujii's t and L.V cut at 0", A + B * cut / tc, False),
            (
                "Oren-Nayar whose s / t is not cut at 0, with L.V cut at 0",
                A + B * cut / over,
                False,
            ),
        ]
        for kind, shape, fine in kinds:
            yield f"{kind}, sigma = {text}", shape, fine
        AF = 1 / (np.pi + (np.pi / 2 - 2 / 3) * sigma)
        yield f"Fujii's Oren-Nayar, sigma = {text}", np.pi * AF * (1 + sigma * s / t), usual
        yield (
            f"Fujii's Oren-Nayar with L.V cut at 0, sigma = {text}",
            np.pi * AF * (1 + sigma * cut / tc),
            False,
        )
    for text, rough, usual in (
        (name, r, True),
        (f"1 - {name}", 1 - r, True),
        (f"{name}^2", r * r, False),
        (f"sqrt({name})", np.sqrt(r), False),
    ):
        for kind, f90, fine in (
            ("Burley diffuse", 0.5 + 2 * rough * c.d**2, usual),
            ("Burley diffuse with V.H not squared", 0.5 + 2 * rough * c.d, False),
            ("Frostbite's Burley diffuse", 0.5 * rough + 2 * rough * c.d**2, usual),
        ):
            w_i, w_o = (1 - c.i) ** 5, (1 - c.o) ** 5
            shape = (1 + (f90 - 1) * w_i) * (1 + (f90 - 1) * w_o)
            if kind.startswith("Frostbite"):
                shape = shape * (1 + (1 / 1.51 - 1) * rough)
            yield f"{kind}, roughness = {text}", shape, fine


# Cosines that stand before the product, as powers of N.L and N.V, and what they mean.
POWERS = ((-1, -1), (0, 0), (0, -1), (-1, 0), (1, 0), (1, -1), (1, 1), (0, 1), (2, 0))


def directions(count: int, seed: int) -> tuple[Array, Array, Cosines]:
    """Pairs of directions up to 85 degrees, half of them near the mirror direction, and their cosines."""
    from gonio.foreign.function import probe

    wi, wo = probe(count, seed)
    good = wi[:, 2] > 0.08
    wi, wo = wi[good], wo[good]
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    return wi, wo, Cosines(wi[:, 2], wo[:, 2], h[:, 2], (wi * h).sum(1), (wi * wo).sum(1))


@dataclass(frozen=True)
class Asked:
    """Values of code, where they have digits, and what it was given there."""

    log: Array
    """Logarithms of what it gives back, without the parameters that scale it, (n,)."""
    cosines: Cosines
    wi: Array
    wo: Array
    numbers: dict[str, Array]
    """Parameters that may be widths."""
    colours: dict[str, Array]
    """Parameters that may be F0 or albedo."""
    scaled: str
    """The parameters that scale it, in words."""
    returns: Returns
    stretched: bool
    """Whether it is anisotropic."""


def asked(foreign: Unscaled, fixed: Mapping[str, float] | None = None) -> Asked | None:
    """Values of code, each pair of directions with its own parameters; None if there are too few.

    Args:
        foreign: code that is running.
        fixed: parameters that are the same everywhere.
    """
    wi, wo, c = directions(2 * PAIRS, 11)
    rng = np.random.default_rng(12)
    n = len(wi)
    values: dict[str, Array] = {}
    numbers: dict[str, Array] = {}
    colours: dict[str, Array] = {}
    for name, p in foreign.parameters.items():
        low, high = p.low, p.high
        t = rng.uniform(0.15, 0.9, n)
        if high > 10:
            low = max(low, 1.0)
            t = low * (min(high, EXPONENTS) / low) ** t
        else:
            t = low + (high - low) * t
        if fixed and name in fixed:
            t = np.full(n, fixed[name])
        if p.width == 3:
            values[name] = np.repeat(t[:, None], 3, axis=1)
            colours[name] = t
        else:
            values[name] = t
            numbers[name] = t
            if high <= 1:
                colours[name] = t
            elif 1 <= p.low < high <= DENSEST:
                colours[f"(({name} - 1) / ({name} + 1))^2"] = ((t - 1) / (t + 1)) ** 2
    raw = foreign.raw(wi, wo, values)[:, 0]
    turned = foreign.raw(_turned(wi), _turned(wo), values)[:, 0]
    good = np.isfinite(raw) & (raw > FAINT * np.nanmax(np.where(np.isfinite(raw), raw, 0)))
    if good.sum() < PAIRS // 4:
        return None
    return Asked(
        np.log(raw[good]),
        Cosines(c.i[good], c.o[good], c.h[good], c.d[good], c.v[good]),
        wi[good],
        wo[good],
        {k: v[good] for k, v in numbers.items()},
        {k: v[good] for k, v in colours.items()},
        foreign.text,
        foreign.returns,
        float(np.median(np.abs(turned - raw)[good] / raw[good])) > STRETCHED,
    )


def identify(foreign: Valued, count: int = 6) -> list[Product]:
    """The products that are nearest to a function, best first.

    Every scalar parameter is tried as the width, every colour and every other number as F0 or albedo;
    each pair of directions has its own values of the parameters.
    """
    inner = unscaled(foreign)
    seen = asked(inner)
    if seen is None:
        return []
    cut = seen.cosines
    found: list[Product] = []
    if seen.stretched and 1 < len(seen.numbers) <= anisotropic.PAIRED:
        found += _stretched(seen)
    with np.errstate(all="ignore"):
        for name in [*seen.numbers, ""]:
            r = seen.numbers.get(name, np.full(len(seen.log), 0.5))
            others = {k: v for k, v in seen.colours.items() if k != name}
            fresnel = choices(fresnels.terms(cut, others))
            plain = choices(_plain_diffuse(cut), "diffuse")
            found += tried(seen, cut, plain, fresnel)
            if not name:
                continue
            rough = choices(_diffuse(cut, r, name), "diffuse")
            found += tried(seen, cut, rough, fresnel)
            for mistake, other in _halves(cut):
                terms = choices(fresnels.terms(other, others))
                shapes = speculars if inner.parameters[name].high <= 1 else _powers
                made = list(shapes(other, r, name, mistake))
                found += tried(seen, other, made, terms)
    found.sort(key=lambda p: (max(p.misfit, 2 * EXACT / 3), len(p.odd), len(p.terms)))
    if found and found[0].exact and (remark := _faded(inner, found[0])):
        found[0] = replace(found[0], remarks=(*found[0].remarks, remark))
    return found[:count]


def _faded(foreign: Valued, product: Product) -> str:
    """How F90 follows an F0 that is set too small for any material; empty if it does not."""
    name = next((n for n in foreign.parameters if fresnels.of_half(n) in product.terms), "")
    low, high = fresnels.DIM
    if not name or foreign.parameters[name].low > low:
        return ""
    wi, wo, c = directions(2 * PAIRS, 13)
    grazing = c.d < GRAZING
    wi, wo, d = wi[grazing], wo[grazing], c.d[grazing]
    f0 = np.linspace(low, high, len(d))
    middle = {n: 0.5 * (max(p.low, -1) + min(p.high, 1)) for n, p in foreign.parameters.items()}

    def values(f0: Array) -> Array:
        shown = np.repeat(f0[:, None], 3, axis=1) if foreign.parameters[name].width == 3 else f0
        return foreign.raw(wi, wo, {**middle, name: shown})[:, 0]

    bright = np.full_like(d, 0.5)
    with np.errstate(all="ignore"):
        F = values(f0) / values(bright) * fresnels.schlick(d, bright)
    seen = np.isfinite(F)
    end = fresnels.faded(d[seen], f0[seen], F[seen]) if seen.sum() > FEW else ""
    return f"with {end} below {name} = 0.02, where no material is" if end else ""


def _turned(w: Array) -> Array:
    """Turned about the normal."""
    c, s = np.cos(0.5), np.sin(0.5)
    return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], -1)


def _stretched(seen: Asked) -> list[Product]:
    """The best anisotropic products; numbers that are widths are no F0."""
    h = seen.wi + seen.wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    c = seen.cosines
    with np.errstate(all="ignore"):
        shapes = [
            Choice(s.text, s.log, not s.swapped, s.kind)
            for s in anisotropic.shapes(anisotropic.Vectors(seen.wi, seen.wo, h), seen.numbers)
        ]
        return tried(seen, c, shapes, choices(fresnels.terms(c, seen.colours))) if shapes else []


def choices(pairs: Iterator[tuple[str, Array, bool]], kind: str = "") -> list[Choice]:
    """Terms by their logarithms."""
    return [Choice(text, np.log(np.maximum(v, TINY)), usual, kind) for text, v, usual in pairs]


def _halves(c: Cosines) -> Iterator[tuple[str, Cosines]]:
    """The cosines of the half vector, and those of one that was not normalised: |L + V| = 2 L.H."""
    yield "", c
    h, d = 2 * c.d * c.h, 2 * c.d * c.d
    yield "half vector not normalised", replace(c, h=np.minimum(h, 1), d=np.minimum(d, 1))
    yield "half vector not normalised, its cosines not cut at 1", replace(c, h=h, d=d)
    yield "half vector (L + V) / 2, not normalised", replace(c, h=c.d * c.h, d=c.d * c.d)


def speculars(c: Cosines, r: Array, name: str, mistake: str) -> Iterator[Choice]:
    """D times G, in all combinations."""
    for (d_name, D), (scale, turn) in itertools.product(DISTRIBUTIONS.items(), WIDTHS.items()):
        a = np.maximum(turn(r), 1e-4)
        usual = scale in ("{}", "{}^2") and not mistake
        log_d = np.log(np.maximum(D(c.h, a), TINY))
        for g_name, G, common in maskings(c, a, r):
            text = f"{d_name}, alpha = {scale.format(name)}; {g_name}"
            if mistake:
                text += f"; {mistake}"
            kind = "bare" if g_name in BARE else "specular"
            remark = ""
            if scale == "{}" and "rough" in name.lower() and d_name not in CLOTH:
                remark = f"alpha = {name}; most engines have alpha = {name}^2"
            log = log_d + np.log(np.maximum(G, TINY))
            yield Choice(text, log, usual and common, kind, remark)


# These are meant with cosines that cancel, in one way or another.
BARE = ("no masking", "Kelemen's masking", "Neumann's masking", "Neubelt and Pettineo's masking")

NORMALISED: dict[str, Callable[[Array], Array]] = {
    "not normalised": np.ones_like,
    "times (n + 2) / (2 pi)": lambda n: (n + 2) / (2 * np.pi),
    "times (n + 1) / (2 pi)": lambda n: (n + 1) / (2 * np.pi),
    "times (n + 8) / (8 pi)": lambda n: (n + 8) / (8 * np.pi),
}


def _powers(c: Cosines, n: Array, name: str, mistake: str) -> Iterator[Choice]:
    """Blinn's and Phong's lobes, whose width is an exponent, with masking or without."""
    a = np.sqrt(2 / (n + 2))
    mirror = 2 * c.i * c.o - c.v  # R.V
    for lobe, cosine in (("Blinn-Phong, (N.H)^n", c.h), ("Phong, (R.V)^n", mirror)):
        log_power = n * np.log(np.maximum(cosine, TINY))
        for how, factor in NORMALISED.items():
            for g_name, G, usual in maskings(c, a, n):
                text = "; ".join(
                    t for t in (f"{lobe} with n = {name}, {how}", g_name, mistake) if t
                )
                log = log_power + np.log(factor(n)) + np.log(np.maximum(G, TINY))
                yield Choice(text, log, usual and not mistake and how != "not normalised", "lobe")


def tried(seen: Asked, c: Cosines, shapes: list[Choice], fresnel: list[Choice]) -> list[Product]:
    """The best combinations of shapes, Fresnel terms and powers of cosines."""
    li, lo = np.log(c.i), np.log(c.o)
    second = np.stack([s.log for s in shapes])
    second = second - second.mean(axis=1, keepdims=True)
    first = np.stack([f.log for f in fresnel])
    best: list[tuple[float, int, int, int]] = []
    for p, (a, b) in enumerate(POWERS):
        left = seen.log - a * li - b * lo - first
        left -= left.mean(axis=1, keepdims=True)
        # Of all differences at once: |x - y|^2 = |x|^2 + |y|^2 - 2 x.y
        variance = left @ second.T * (-2 / len(li))
        variance += (second**2).mean(axis=1) + (left**2).mean(axis=1)[:, None]
        order = np.argpartition(variance, min(3, len(shapes) - 1), axis=1)[:, :3]
        best += [
            (float(variance[k, s]), int(s), k, p) for k in range(len(fresnel)) for s in order[k]
        ]
    best.sort()
    return [made(seen, c, shapes[s], fresnel[k], POWERS[p]) for _, s, k, p in best[:24]]


def made(
    seen: Asked, c: Cosines, shape: Choice, fresnel: Choice, powers: tuple[int, int]
) -> Product:
    """One combination, and how far the code is from it."""
    a, b = powers
    ratio = seen.log - shape.log - fresnel.log - a * np.log(c.i) - b * np.log(c.o)
    shift = float(np.median(ratio))
    off = ratio - shift
    terms = [
        t
        for t in (shape.text, fresnel.text, seen.scaled, power(a, b))
        if t and t != "no Fresnel term"
    ]
    odd = [t.text for t in (shape, fresnel) if not t.usual]
    constant = float(np.exp(shift))
    returns = seen.returns
    return Product(
        tuple(terms),
        constant,
        float(off.std()),
        float(np.expm1(np.abs(off).max())),
        (*odd, *_before(shape.kind, a - returns.cosine, b, constant / returns.factor)),
        (shape.remark,) if shape.remark else (),
    )


def _before(kind: str, a: int, b: int, constant: float) -> Iterator[str]:
    """What is wrong with the cosines and the constant that stand before a shape, if f is meant.

    Args:
        kind: of a Choice.
        a: the power of N.L.
        b: the power of N.V.
        constant: the factor.
    """
    name = constant_name(constant)
    if kind == "specular" and (a, b) == (0, 0):
        yield "4 where 4 N.L N.V is meant" if name == "1 / 4" else "N.L N.V is missing below"
    elif kind == "specular" and (a, b) != (-1, -1):
        sides = [n for n, p in (("N.L", a), ("N.V", b)) if p > -1]
        yield f"{' and '.join(sides)} {'is' if len(sides) == 1 else 'are'} missing below"
    elif kind == "diffuse" and (a, b) != (0, 0):
        above = [n for n, p in (("N.L", a), ("N.V", b)) if p > 0]
        below = [n for n, p in (("N.L", a), ("N.V", b)) if p < 0]
        yield "; ".join(
            [f"times {n} once too often" for n in above]
            + [f"divided by {n}, which reflection is not" for n in below]
        )
    if kind == "diffuse":
        wrong = {
            "1 / pi^2": "pi twice",
            "": "1 / pi is missing",
            "1 / (2 pi)": "1 / (2 pi) where 1 / pi is meant",
            "2 / pi": "2 / pi where 1 / pi is meant",
        }
    elif kind in ("specular", "bare"):
        wrong = {
            "1 / (4 pi)": "pi twice: the distribution has 1 / pi already",
            "": "1 / 4 is missing",
            "1 / 2": "1 / 2 where 1 / 4 is meant",
            "1 / 8": "1 / 8 where 1 / 4 is meant",
            "1 / pi": "1 / pi where 1 / 4 is meant (Cook and Torrance had pi)",
            "pi / 4": "pi is missing below",
            "pi": "pi where 1 / 4 is meant: the distribution has no 1 / pi, and nothing divides by 4",
        }
    else:
        wrong = {"1 / pi": "pi twice: the lobe has 1 / pi already"}
    if name in wrong and not (kind == "lobe" and a == b == 0 and name == ""):
        yield wrong[name]


def power(a: int, b: int) -> str:
    """What powers of N.L and N.V are called."""
    above = [n for n, p in (("N.L", a), ("N.V", b)) if p > 0]
    below = [n for n, p in (("N.L", a), ("N.V", b)) if p < 0]
    if not above and not below:
        return ""
    if not below:
        return "times " + " ".join(above)
    return f"{' '.join(above) or '1'} / ({' '.join(below)})"
