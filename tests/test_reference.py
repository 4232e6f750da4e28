"""Random walks through layers against closed forms, an adding method, and another program's walks.

Nothing in the two oracles here uses gonio: `Adding` is deterministic (matrices over discretised
directions, averaged over azimuth), `brute_force` walks from the viewer without connections, with normals
sampled by D alone and histograms for results. Walter's surfaces are written out once more for them.

Statistical tests have fixed seeds. Their limits are 4.5 standard errors of a single number (one in 150,000
by chance), and their power is said by the broken variants, all of which have to fail.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import drjit as dr
import numpy as np
import pytest
from make_layers_page import lost
from numpy.typing import NDArray
from support.directions import adversarial_pairs, from_cosine, polar, random_directions
from support.tolerances import SINGLE_LONG, decimals

import gonio
from gonio.fields import ModelError
from gonio.reference import Layer, Stack, speed, stack, walk

Array = NDArray[np.float64]

CHANCE = 4.5
"""Standard errors that one number may be off."""


# --- Walter et al. 2007, written apart from gonio ---------------------------------------------------


@dataclass(frozen=True)
class Facets:
    """A rough surface; the numbers in the comments are Walter's equations."""

    alpha: float
    distribution: str = "ggx"

    def D(self, m: Array) -> Array:
        cos2 = m[..., 2] ** 2
        tan2 = (1 - cos2) / cos2
        if self.distribution == "ggx":  # 33
            value = self.alpha**2 / (np.pi * cos2**2 * (self.alpha**2 + tan2) ** 2)
        else:  # 25
            value = np.exp(-tan2 / self.alpha**2) / (np.pi * self.alpha**2 * cos2**2)
        return np.where(m[..., 2] > 0, value, 0)

    def G1(self, v: Array, m: Array) -> Array:
        cos = np.abs(v[..., 2])
        tan = np.sqrt(np.maximum(1 - cos**2, 0)) / cos
        if self.distribution == "ggx":  # 34
            value = 2 / (1 + np.sqrt(1 + self.alpha**2 * tan**2))
        else:  # the exact form above 27
            a = 1 / (self.alpha * np.maximum(tan, 1e-12))
            value = 2 / (1 + _erf(a) + np.exp(-(a**2)) / (a * np.sqrt(np.pi)))
        return np.where(np.sum(v * m, -1) * v[..., 2] > 0, value, 0)

    def normal(self, u: Array) -> Array:
        if self.distribution == "ggx":  # 35
            tan = self.alpha * np.sqrt(u[:, 0] / (1 - u[:, 0]))
        else:  # 28
            tan = np.sqrt(-(self.alpha**2) * np.log1p(-u[:, 0]))
        cos = 1 / np.sqrt(1 + tan**2)
        phi = 2 * np.pi * u[:, 1]
        return np.stack([tan * cos * np.cos(phi), tan * cos * np.sin(phi), cos], -1)

    def reflected(self, i: Array, o: Array, n_i: float, n_o: float) -> Array:
        """f_s of reflection (20): n_i on the side of both, n_o beyond."""
        m = i + o
        m = m / np.linalg.norm(m, axis=-1, keepdims=True)
        G = self.G1(i, m) * self.G1(o, m)
        F = fresnel(np.sum(i * m, -1), n_i, n_o)
        return F * G * self.D(m) / (4 * i[..., 2] * o[..., 2])

    def refracted(self, i: Array, o: Array, n_i: float, n_o: float) -> Array:
        """f_s of refraction (21) from i, above, to o, below."""
        h = -(n_i * i + n_o * o)  # 16
        m = h / np.linalg.norm(h, axis=-1, keepdims=True)
        m = m * np.sign(m[..., 2:])
        im, om = np.sum(i * m, -1), np.sum(o * m, -1)
        G = self.G1(i, m) * self.G1(o, m)
        T = 1 - fresnel(np.maximum(im, 0), n_i, n_o)
        jacobian = n_o**2 / (n_i * im + n_o * om) ** 2
        value = np.abs(im * om / (i[..., 2] * o[..., 2])) * jacobian * T * G * self.D(m)
        return np.where((im > 0) & (om < 0), value, 0)


_erf = np.vectorize(math.erf, otypes=[float])


def fresnel(c: Array, n_i: float, n_o: float) -> Array:
    """Walter's equation 22, with c = |i . m|."""
    g2 = (n_o / n_i) ** 2 - 1 + c**2
    g = np.sqrt(np.maximum(g2, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        a = (g - c) ** 2 / (g + c) ** 2
        b = (c * (g + c) - 1) ** 2 / (c * (g - c) + 1) ** 2
    return np.where(g2 > 0, 0.5 * a * (1 + b), 1.0)


# --- oracle 1: adding ------------------------------------------------------------------------------


class Adding:
    """Reflection of a stack of rough layers as a matrix over elevations, averaged over azimuths.

    An element says what part of the light that arrives in one direction leaves in another: in medium k
    the directions are Gauss's nodes between the critical angles. Layers are added from the bottom up, with
    the series of light between base and surface summed by a matrix inverse.
    """

    AZIMUTHS = 160

    def __init__(self, layers: list[Layer], rho: float, nodes: int = 56) -> None:
        n = np.concatenate([[1.0], np.cumprod([layer.eta for layer in layers])])
        self.mu, self.w = zip(*(self._nodes(n, k, nodes) for k in range(len(n))), strict=True)
        # Lambert: the same part from every direction, proportional to the cosine of the way out
        B = np.repeat((2 * rho * self.mu[-1] * self.w[-1])[:, None], len(self.mu[-1]), axis=1)
        for k in reversed(range(len(layers))):
            facets = Facets(layers[k].alpha, layers[k].distribution)
            kept = np.exp(-layers[k].depth[0] / self.mu[k + 1])
            B = kept[:, None] * B * kept
            up = self._matrix(facets.refracted, n, k + 1, k)
            down = self._matrix(facets.refracted, n, k, k + 1)
            inside = self._matrix(facets.reflected, n, k + 1, k + 1, beyond=k)
            once = self._matrix(facets.reflected, n, k, k, beyond=k + 1)
            B = once + up @ np.linalg.solve(np.eye(len(B)) - B @ inside, B @ down)
        self.B = B

    @staticmethod
    def _nodes(n: Array, k: int, nodes: int) -> tuple[Array, Array]:
        edges = {0.0, 1.0} | {math.sqrt(1 - (m / n[k]) ** 2) for m in n if m < n[k]}
        x, w = np.polynomial.legendre.leggauss(nodes)
        pieces = sorted(edges)
        mu = [a + (b - a) * (x + 1) / 2 for a, b in pairwise(pieces)]
        weights = [(b - a) * w / 2 for a, b in pairwise(pieces)]
        return np.concatenate(mu), np.concatenate(weights)

    def _matrix(
        self, f: Callable[..., Array], n: Array, source: int, to: int, beyond: int | None = None
    ) -> Array:
        phi = np.pi * (np.arange(self.AZIMUTHS) + 0.5) / self.AZIMUTHS
        i = from_cosine(self.mu[source])[None, :, None]
        o = from_cosine(self.mu[to][:, None], phi)[:, None]
        if beyond is None:
            o = o * (1, 1, -1)
        i, o = np.broadcast_arrays(i, o)
        mean = f(i, o, n[source], n[to if beyond is None else beyond]).mean(-1)
        return mean * (2 * np.pi * self.mu[to] * self.w[to])[:, None]

    def albedo(self) -> Array:
        """What leaves for each direction outside."""
        return self.B.sum(0)

    def value(self) -> Array:
        """The BRDF averaged over azimuth, [wi, wo]."""
        return self.B / (2 * np.pi * self.mu[0] * self.w[0])[:, None]


# --- oracle 2: brute force -------------------------------------------------------------------------


def brute_force(
    layers: list[Layer], base: Facets | float, wo: Array, walks: int, seed: int
) -> tuple[Array, Array]:
    """Where light leaves that walks in along wo, and with which weight: (walks, 3) and (walks,).

    base: the albedo of a Lambert base, or white facets.
    """
    rng = np.random.default_rng(seed)
    n = np.concatenate([[1.0], np.cumprod([layer.eta for layer in layers])])
    w = np.repeat(wo[None], walks, 0)  # where each walk comes from
    level, weight = np.zeros(walks, int), np.ones(walks)
    exits, found = np.zeros((walks, 3)), np.zeros(walks)
    active = np.arange(walks)
    while len(active):
        u = rng.random((len(active), 3))
        a, at = w[active], level[active]
        new, factor = np.zeros_like(a), np.ones(len(active))
        for k in range(len(layers) + 1):
            here = at == k
            side = np.sign(a[here][:, 2:])
            if k == len(layers) and isinstance(base, float):
                r, phi = np.sqrt(u[here, 0]), 2 * np.pi * u[here, 1]
                new[here] = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - r * r)], -1)
                factor[here] = base
                continue
            facets = Facets(layers[k].alpha, layers[k].distribution) if k < len(layers) else base
            assert isinstance(facets, Facets)
            flip = np.concatenate([np.ones((here.sum(), 2)), side], -1)
            i = a[here] * flip
            smooth = facets.alpha == 0
            m = np.array([[0.0, 0, 1]]) if smooth else facets.normal(u[here])
            c = np.sum(i * m, -1)
            if k == len(layers):
                F = np.ones(len(c))
                ratio = np.ones(len(c))
            else:
                up = side[:, 0] > 0
                ratio = np.where(up, n[k] / n[k + 1], n[k + 1] / n[k])
                F = fresnel(np.abs(c), 1.0, 1 / ratio)
            through = u[here, 2] >= F
            root = np.sqrt(np.maximum(1 + ratio**2 * (c**2 - 1), 0))
            refracted = (ratio * c - np.sign(c) * root)[:, None] * m - ratio[:, None] * i  # 40
            o = np.where(through[:, None], refracted, 2 * c[:, None] * m - i)
            if smooth:
                g = np.ones(len(c))
            else:  # 41
                G = facets.G1(i, m) * facets.G1(o, m)
                G = np.where((o[:, 2] < 0) == through, G, 0)
                g = np.abs(c) * G / np.maximum(np.abs(i[:, 2] * m[:, 2]), 1e-300)
            new[here], factor[here] = o * flip, g
        weight[active] *= factor
        up = new[:, 2] > 0
        out = up & (at == 0)
        slab = np.where(up, at - 1, at)
        depth = np.array([layer.depth[0] for layer in layers])[np.clip(slab, 0, len(layers) - 1)]
        crossed = np.exp(-depth / np.maximum(np.abs(new[:, 2]), 1e-300))
        weight[active] *= np.where(out, 1, crossed)
        exits[active[out]], found[active[out]] = new[out], weight[active[out]]
        w[active], level[active] = -new, np.where(up, at - 1, at + 1)
        active = active[~out & (weight[active] > 1e-9)]
    return exits, found


# --- judges ----------------------------------------------------------------------------------------


def surprise(found: Any, error: Any, truth: Any, oracle: float = 0.0) -> float:
    """Largest deviation in standard errors; `oracle` is the relative error of the truth."""
    found, error, truth = (np.asarray(x, np.float64) for x in (found, error, truth))
    allowed = np.sqrt(error**2 + (oracle / CHANCE * truth) ** 2 + (1e-6 * truth) ** 2)
    return float(np.max(np.abs(found - truth) / np.maximum(allowed, 1e-12)))


WALSH_INSIDE = 0.596346
"""Diffuse reflectance of an index of 1.5 from inside (Walsh 1926; published as 0.59635)."""


def lambert_under_glass(mu_i: Array, mu_o: Array, rho: float, depth: float = 0.0) -> Array:
    """The interfaced Lambertian: T(i) T(o) / n^2 rho / pi / (1 - rho R), for n = 1.5.

    With absorption, for one crossing each way and every number of inner bounces, R by quadrature.
    """
    n = 1.5
    x, w = np.polynomial.legendre.leggauss(400)
    edges = (0.0, math.sqrt(1 - 1 / n**2), 1.0)
    mu = np.concatenate([a + (b - a) * (x + 1) / 2 for a, b in pairwise(edges)])
    w = np.concatenate([(b - a) * w / 2 for a, b in pairwise(edges)])
    R = np.sum(w * 2 * mu * fresnel(mu, n, 1.0) * np.exp(-2 * depth / mu))
    if depth == 0:
        assert pytest.approx(WALSH_INSIDE, abs=decimals(6)) == R
    inner = [np.sqrt(1 - (1 - m**2) / n**2) for m in (mu_i, mu_o)]
    T = np.prod([1 - fresnel(m, 1.0, n) for m in (mu_i, mu_o)], 0)
    kept = np.exp(-depth / inner[0] - depth / inner[1])
    return np.asarray(T * kept / n**2 * rho / np.pi / (1 - rho * R))


def closed_form_surprise() -> float:
    """How far a smooth coat over Lambert is from its closed form, in standard errors."""
    wi, wo = random_directions(60, 1), random_directions(60, 2)
    worst = []
    for rho, depth in ((1.0, 0.0), (0.5, 0.0), (0.9, 0.3), (0.0, 0.0)):
        coated = Stack([Layer(1.5, sigma_a=depth)], gonio.Lambert(rho=rho))
        f = coated.eval(wi, wo, walks=200_000)
        truth = lambert_under_glass(wi[:, 2], wo[:, 2], rho, depth)
        assert np.all(f.error[:, 0] <= 0.02 * np.maximum(truth, f.value[:, 0])), (
            "not exact enough to judge"
        )
        worst.append(surprise(f.value[:, 0], f.error[:, 0], truth))
    return max(worst)


ROUGH_STACKS = {
    "one coat": ([Layer(1.5, 0.5, 0.2)], 0.9),
    "beckmann": ([Layer(1.5, 0.4, 0.1, distribution="beckmann")], 1.0),
    "two coats": ([Layer(1.4, 0.5, 0.1), Layer(1.3, 0.6, 0.3)], 1.0),
    "thinner below": ([Layer(1.6, 0.5, 0.1), Layer(0.8, 0.5, 0.1)], 0.8),
    "black": ([Layer(1.5, 0.6)], 0.0),
}

# Relative error of `Adding`: Fresnel's term has a kink at the critical angle, which moves with the facet,
# so that values at single nodes still change by 0.3 % from 56 to 112 nodes.
ADDING_ERROR = 4e-3


def adding_surprise(name: str, adding: Adding) -> float:
    """How far azimuthal means of values are from the adding method, in standard errors."""
    layers, rho = ROUGH_STACKS[name]
    rough = Stack(layers, gonio.Lambert(rho=rho))
    mu, turns = adding.mu[0], 96
    picked = np.searchsorted(mu, (0.15, 0.4, 0.7, 0.95))
    phi = np.pi * (np.arange(turns) + 0.5) / turns
    wi = from_cosine(mu[picked][:, None, None], phi)
    wo = from_cosine(mu[picked])[:, None]
    f = rough.eval(wi.astype(np.float32), wo.astype(np.float32), walks=4000)
    value = f.value[..., 0].astype(float).mean(-1)
    error = np.sqrt(np.sum(f.error[..., 0].astype(float) ** 2, -1)) / turns
    truth = adding.value()[np.ix_(picked, picked)]
    assert np.all(error < 0.01 * np.maximum(truth, 1e-3)), "not exact enough to judge"
    return surprise(value, error, truth, ADDING_ERROR)


MIXED_STACKS: dict[str, tuple[list[Layer], Facets | float]] = {
    "smooth on white": ([Layer(1.5, 0, 0.2)], 1.0),
    "rough on white": ([Layer(1.5, 0.2, 0.1)], 1.0),
    "rough on metal": ([Layer(1.5, 0.15, 0.1)], Facets(0.3)),
    "smooth on rough": ([Layer(1.3, 0, 0.1), Layer(1.4, 0.3, 0.2)], 0.9),
    "rough on smooth": ([Layer(1.3, 0.3, 0.1), Layer(1.4, 0, 0.2)], 0.9),
    "rough on smooth on metal": ([Layer(1.4, 0.2), Layer(0.75, 0, 0.1)], Facets(0.4)),
    "pile": ([Layer(1.3, 0, 0.1), Layer(1.4, 0, 0.2), Layer(0.7, 0, 0.1)], 0.9),
    "three": (
        [Layer(1.3, 0.2, 0.1), Layer(1.3, 0, 0.1), Layer(1.2, 0.5, 0.1, distribution="beckmann")],
        0.9,
    ),
}
THETA_O = np.radians(55.0)


def as_stack(name: str) -> Stack:
    layers, base = MIXED_STACKS[name]
    if isinstance(base, float):
        return Stack(layers, gonio.Lambert(rho=base))
    metal = gonio.model("torrance_sparrow", alpha=base.alpha, fresnel="white", masking="smith")
    return Stack(layers, metal)


def cells(w: Array) -> Array:
    """The number of the cell, 4 elevations by 6 azimuths of half the circle, of each direction."""
    elevation = np.minimum((w[:, 2] ** 2 * 4).astype(int), 3)
    azimuth = np.minimum((np.abs(np.arctan2(w[:, 1], w[:, 0])) / np.pi * 6).astype(int), 5)
    return elevation * 6 + azimuth


def brute_force_surprise(name: str, walks: int = 1_000_000) -> float:
    """How far integrals of value times cosine over 24 cells are from brute force, in standard errors."""
    layers, base = MIXED_STACKS[name]
    wo = polar(THETA_O)
    exits, found = brute_force(layers, base, wo, walks, seed=5)
    if layers[0].alpha == 0:  # the mirror's direction is no function's business
        found = np.where(np.abs(exits + wo * (1, 1, -1)).max(-1) < 1e-9, 0, found)
    cell = cells(exits)
    truth = np.bincount(cell, found, 24) / walks
    truth_error = np.sqrt(np.bincount(cell, found**2, 24)) / walks
    # Cosine-weighted directions, of which each cell has as many
    u = np.random.default_rng(6).random((24, 4000, 2))
    mu = np.sqrt((np.arange(24)[:, None] // 6 + u[..., 0]) / 4)
    wi = from_cosine(mu, np.pi * (np.arange(24)[:, None] % 6 + u[..., 1]) / 6)
    f = as_stack(name).eval(wi.astype(np.float32), wo.astype(np.float32), walks=128)
    samples = f.value[..., 0].astype(float) * np.pi / 24
    mean, error = samples.mean(-1), samples.std(-1) / math.sqrt(samples.shape[-1])
    assert np.median(error / mean) < 0.02, "not exact enough to judge"
    return surprise(mean, np.hypot(error, truth_error), truth)


# --- values ----------------------------------------------------------------------------------------


def test_a_smooth_coat_over_lambert_has_its_closed_form() -> None:
    assert closed_form_surprise() < CHANCE


@pytest.mark.parametrize("name", ROUGH_STACKS)
def test_rough_stacks_agree_with_the_adding_method(name: str) -> None:
    layers, rho = ROUGH_STACKS[name]
    assert adding_surprise(name, Adding(layers, rho)) < CHANCE


@pytest.mark.parametrize("name", MIXED_STACKS)
def test_mixed_stacks_agree_with_brute_force(name: str) -> None:
    assert brute_force_surprise(name) < CHANCE


# --- what the judges must not let pass -------------------------------------------------------------


def no_compression(monkeypatch: pytest.MonkeyPatch) -> None:
    """Solid angles that do not widen by n^2 on the way out."""
    made = stack.Scene
    monkeypatch.setattr(stack, "Scene", lambda s, e, n2, d, b: made(s, e, [1.0] * len(n2), d, b))


def no_absorption_on_the_way_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Light that reaches the base as if the slabs were clear."""
    right = walk.light_path

    def clear(scene: Any, *rest: Any) -> Any:
        return right(replace(scene, depths=[0 * d for d in scene.depths]), *rest)

    monkeypatch.setattr(walk, "light_path", clear)


def counted_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """Connections without the shares of multiple importance sampling."""
    monkeypatch.setattr(walk.Link, "share", lambda link, density, before=0: 1)


def one_bounce(monkeypatch: pytest.MonkeyPatch) -> None:
    """Walks that end at the second visit of the base."""
    monkeypatch.setattr(walk, "_survival", lambda state: dr.select(state.events >= 2, -1.0, 1.0))


def one_percent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every connection 1 % too bright."""
    right = walk.light_path

    def bright(*given: Any) -> Any:
        return [link._replace(weight=link.weight * 1.01) for link in right(*given)]

    monkeypatch.setattr(walk, "light_path", bright)


BROKEN = [no_compression, no_absorption_on_the_way_in, one_bounce, one_percent]


@pytest.mark.parametrize("broken", BROKEN)
def test_the_closed_form_catches(broken: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch)
    assert closed_form_surprise() > 2 * CHANCE


@pytest.mark.parametrize("broken", [*BROKEN[:3], counted_twice])
def test_the_adding_method_catches(broken: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    layers, rho = ROUGH_STACKS["one coat"]
    oracle = Adding(layers, rho)
    broken(monkeypatch)
    assert adding_surprise("one coat", oracle) > 2 * CHANCE


@pytest.mark.parametrize("broken", [*BROKEN[:3], counted_twice])
def test_brute_force_catches(broken: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch)
    assert brute_force_surprise("rough on white") > 2 * CHANCE


# --- energy ----------------------------------------------------------------------------------------


def test_a_smooth_coat_over_white_reflects_everything() -> None:
    wo = from_cosine(np.array([0.02, 0.3, 0.7, 1.0])).astype(np.float32)
    for eta in (1.1, 1.3, 1.5):
        E = Stack([Layer(eta)], gonio.Lambert(rho=1)).albedo(wo, walks=20_000)
        # Every walk leaves with weight 1: there is no variance, only rounding.
        np.testing.assert_allclose(E.value, 1, rtol=2e-5)
        assert np.all(E.error < 1e-5)


def test_a_smooth_coat_over_grey_has_its_closed_albedo() -> None:
    mu = np.array([0.1, 0.4, 0.8])
    for rho in (0.2, 0.8):
        E = Stack([Layer(1.5)], gonio.Lambert(rho=rho)).albedo(from_cosine(mu), walks=400_000)
        F = fresnel(mu, 1.0, 1.5)
        truth = F + (1 - F) * rho * (1 - WALSH_INSIDE) / (1 - rho * WALSH_INSIDE)
        assert surprise(E.value[:, 0], E.error[:, 0], truth) < CHANCE


@pytest.mark.parametrize("name", ROUGH_STACKS)
def test_albedo_is_that_of_the_adding_method(name: str) -> None:
    layers, rho = ROUGH_STACKS[name]
    oracle = Adding(layers, rho)
    picked = oracle.mu[0] > 0.05
    wo = from_cosine(oracle.mu[0][picked])
    E = Stack(layers, gonio.Lambert(rho=rho)).albedo(wo.astype(np.float32), walks=50_000)
    assert surprise(E.value[:, 0], E.error[:, 0], oracle.albedo()[picked], ADDING_ERROR) < CHANCE


def lossless_defect(alpha: float, distribution: str) -> tuple[float, float]:
    """What a rough coat over white loses at the normal: by walks, and by the adding method."""
    layers = [Layer(1.5, alpha, distribution=distribution)]
    E = Stack(layers, gonio.Lambert(rho=1)).albedo((0, 0, 1), walks=400_000)
    oracle = Adding(layers, 1.0)
    return 1 - float(E.value[0]), 1 - float(oracle.albedo()[-1])


def test_facets_that_scatter_once_lose_what_the_adding_method_says() -> None:
    # The surfaces' own loss is the only one: it vanishes with their roughness.
    losses = [lossless_defect(alpha, "beckmann") for alpha in (0.1, 0.2, 0.4)]
    for walked, added in losses:
        assert walked == pytest.approx(added, abs=ADDING_ERROR)
    assert losses[0][0] < 0.02 < losses[2][0]


def test_the_page_about_layers_says_what_facets_lose() -> None:
    layer = Layer(1.5, 0.4, distribution="beckmann")
    oracle = Adding([layer], 1.0)
    kept = np.sum(2 * oracle.mu[0] * oracle.w[0] * oracle.albedo())
    coloured = replace(layer, sigma_a=(0.1, 2.0, 0.3))
    # A million walks, off by 5e-4; the adding method is good to ADDING_ERROR at single nodes. Without
    # facets each walk keeps all, but for the few that are cut short
    assert lost(Stack([coloured])) == pytest.approx(1 - kept, abs=3e-3)
    assert lost(Stack([Layer(1.5)])) == pytest.approx(0, abs=1e-4)


def test_speed_is_measured_for_every_stack() -> None:
    for name in speed.STACKS:
        assert 0 < speed.seconds(name, pairs=10, walks=64, repeat=1) < 60


@pytest.mark.parametrize("name", MIXED_STACKS)
def test_integral_of_values_is_the_albedo(name: str) -> None:
    stacked = as_stack(name)
    wo = polar(THETA_O).astype(np.float32)
    u = np.random.default_rng(8).random((100_000, 2))
    wi = from_cosine(np.sqrt(1 - u[:, 0]), 2 * np.pi * u[:, 1]).astype(np.float32)
    f = stacked.eval(wi, wo, walks=32).value[:, 0].astype(float) * np.pi
    walked = stacked.sample(np.broadcast_to(wo, (400_000, 3)), seed=3)
    weights = np.where(walked.specular, 0, walked.weight[:, 0]).astype(float)
    error = math.hypot(f.std() / len(f) ** 0.5, weights.std() / len(weights) ** 0.5)
    # Small enough to judge by
    assert error < 0.004
    assert abs(f.mean() - weights.mean()) < CHANCE * error


# --- reciprocity -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MIXED_STACKS)
def test_stacks_are_reciprocal(name: str) -> None:
    wi, wo = random_directions(40, 3), random_directions(40, 4)
    there, back = (as_stack(name).eval(*pair, walks=100_000) for pair in ((wi, wo), (wo, wi)))
    error = np.hypot(there.error, back.error)
    # Small enough to judge by
    assert np.median(error / there.value) < 0.02
    assert surprise(there.value, error, back.value) < CHANCE


def test_reciprocity_notices_a_missing_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    right = walk.light_path

    def entering_free(scene: Any, wi: Any, *rest: Any) -> Any:
        """Fresnel's transmittance is left out where light enters."""
        bend = scene.surfaces[0].bend(wi.z, True)
        return [
            link._replace(weight=link.weight / bend.transmitted) for link in right(scene, wi, *rest)
        ]

    monkeypatch.setattr(walk, "light_path", entering_free)
    with pytest.raises(AssertionError):
        test_stacks_are_reciprocal("smooth on white")


# --- samples ---------------------------------------------------------------------------------------


def chi2_surprise(stacked: Stack, scale: float = 1.0) -> float:
    """How far histograms of samples are from integrals of the density, in standard errors.

    Over 24 cells and over all: the sum sees a density that is 1 % too large everywhere.
    """
    count = 2_000_000
    wo = polar(THETA_O).astype(np.float32)
    walked = stacked.sample(np.broadcast_to(wo, (count, 3)), seed=11)
    left = (walked.weight.max(-1) > 0) & ~walked.specular
    seen = np.bincount(cells(walked.wi[left].astype(float)), minlength=24) / count
    u = np.random.default_rng(12).random((24, 6000, 2))
    mu = np.sqrt((np.arange(24)[:, None] // 6 + u[..., 0]) / 4)
    wi = from_cosine(mu, np.pi * (np.arange(24)[:, None] % 6 + u[..., 1]) / 6)
    density = stacked.pdf(wi.astype(np.float32), wo, walks=128).value.astype(float)
    samples = scale * density / mu * np.pi / 24
    mean, error = samples.mean(-1), samples.std(-1) / math.sqrt(samples.shape[-1])
    each = surprise(mean, np.hypot(error, np.sqrt(seen / count)), seen)
    total = surprise(mean.sum(), math.hypot(np.linalg.norm(error), 0.5 / count**0.5), seen.sum())
    return max(each, total)


@pytest.mark.parametrize("name", MIXED_STACKS)
def test_samples_have_the_density_that_pdf_says(name: str) -> None:
    assert chi2_surprise(as_stack(name)) < CHANCE


def test_a_density_two_percent_off_is_noticed() -> None:
    assert chi2_surprise(as_stack("rough on white"), 1.02) > CHANCE
    assert chi2_surprise(as_stack("smooth on rough"), 0.98) > CHANCE


@pytest.mark.parametrize("name", MIXED_STACKS)
def test_weights_of_samples_have_a_bound(name: str) -> None:
    wo = random_directions(200_000, 9)
    walked = as_stack(name).sample(wo)
    # Fresnel and absorption only weaken; a walk that chance let go on carries at most what it had.
    assert walked.weight.max() < 1.2
    assert np.all(walked.wi[..., 2] > 0)
    np.testing.assert_allclose(np.linalg.norm(walked.wi, axis=-1), 1, atol=SINGLE_LONG)


# --- float32, backends, what users give ------------------------------------------------------------


@pytest.mark.parametrize(
    "layers",
    [
        [Layer(1.5, 1e-4)],
        [Layer(1.5, 1.0, 50.0)],
        [Layer(1.001, 0.1, distribution="beckmann")],
        [Layer(3.0, 1e-3, distribution="beckmann"), Layer(0.4, 0)],
        [Layer(0.5, 0.3), Layer(2.0, 0.01)],
        [Layer(3.0), Layer(0.34), Layer(1.5, 0.2, 1e9)],
    ],
)
def test_hard_directions_are_finite_in_float32(layers: list[Layer]) -> None:
    wi, wo = adversarial_pairs()
    for base in (gonio.Lambert(rho=1), gonio.model("torrance_sparrow", alpha=1e-3)):
        stacked = Stack(layers, base)
        for estimate in (stacked.eval(wi, wo, walks=8), stacked.pdf(wi, wo, walks=8)):
            assert np.all(np.isfinite(estimate.value))
            assert np.all(estimate.value >= 0)
            assert np.all(np.isfinite(estimate.error))
        walked = stacked.sample(wo)
        assert np.all(np.isfinite(walked.weight))
        assert np.all(walked.weight >= 0)
        assert np.all(np.isfinite(walked.wi))


def test_directions_below_the_horizon_reflect_nothing() -> None:
    up, down = np.array([0.6, 0, 0.8]), np.array([0.6, 0, -0.8])
    stacked = Stack([Layer(1.5, 0.2)])
    for pair in ((up, down), (down, up), (down, down)):
        assert np.all(stacked.eval(*pair, walks=4).value == 0)
        assert stacked.pdf(*pair, walks=4).value == 0
    assert np.all(stacked.sample(down).weight == 0)
    assert np.all(stacked.albedo(down, walks=4).value == 0)


def test_backends_agree() -> None:
    wi, wo = np.array([0.6, 0, 0.8]), np.array([0, 0.8, 0.6])
    stacked = as_stack("rough on smooth")
    compiled = [stacked.eval(wi, wo, walks=100_000), stacked.pdf(wi, wo, walks=100_000)]
    compiled += [stacked.albedo(wo, walks=100_000)]
    gonio.use("scalar")
    try:
        plain = [stacked.eval(wi, wo, walks=300), stacked.pdf(wi, wo, walks=300)]
        plain += [stacked.albedo(wo, walks=300)]
        assert np.linalg.norm(stacked.sample(wo).wi) == pytest.approx(1)
    finally:
        gonio.use("llvm")
    for one, other in zip(compiled, plain, strict=True):
        assert surprise(one.value, np.hypot(one.error, other.error), other.value) < CHANCE


def test_seeds_and_shapes() -> None:
    wi, wo = random_directions(6, 1).reshape(3, 2, 3), random_directions(1, 2)[0]
    stacked = Stack([Layer(1.5, 0.2)])
    f = stacked.eval(wi, wo, walks=50, seed=7)
    assert f.value.shape == f.error.shape == (3, 2, 3)
    assert f.value.dtype == np.float32
    np.testing.assert_array_equal(f.value, stacked.eval(wi, wo, walks=50, seed=7).value)
    assert np.all(f.value != stacked.eval(wi, wo, walks=50, seed=8).value)
    assert stacked.pdf(wi, wo, walks=5).value.shape == (3, 2)
    assert stacked.albedo(wi, walks=5).value.shape == (3, 2, 3)
    walked = stacked.sample(wi)
    assert (walked.wi.shape, walked.specular.shape) == ((3, 2, 3), (3, 2))
    assert stacked.eval(wi.astype(np.float64), wo, walks=5).value.dtype == np.float64
    assert stacked.eval(np.zeros((0, 3)), wo).value.shape == (0, 3)
    assert stacked.sample(np.zeros((0, 3))).specular.shape == (0,)


def test_standard_errors_tell_the_truth() -> None:
    wi, wo = np.array([0.6, 0, 0.8]), np.array([0, 0.8, 0.6])
    stacked = Stack([Layer(1.5, 0.2)])
    many = [stacked.eval(wi, wo, walks=200, seed=s) for s in range(100)]
    scatter = np.std([f.value[0] for f in many])
    # The scatter of 100 values is known to 7 %.
    assert scatter == pytest.approx(np.mean([f.error[0] for f in many]), rel=0.3)


def test_parameters_do_not_recompile() -> None:
    wi, wo = random_directions(50, 1), random_directions(50, 2)

    def run(eta: float, alpha: float, depth: float) -> None:
        Stack([Layer(eta, alpha, depth)], gonio.Lambert(rho=depth)).eval(wi, wo, walks=20)

    run(1.5, 0.2, 0.3)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        run(1.4, 0.5, 0.1)
        history = dr.kernel_history()
    # The walk itself is the one with a thousand operations; small kernels may differ in their order.
    walks = [k for k in history if k.get("operation_count", 0) > 500]
    assert len(walks) == 1
    assert walks[0]["cache_hit"]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Layer(eta=5), "eta=5 is out of range"),
        (lambda: Layer(alpha=1e-6), "or 0 for smooth"),
        (lambda: Layer(sigma_a=(0.0, -1.0, 0.0)), "sigma_a=-1.0 is out of range"),
        (lambda: Layer(thickness=float("nan")), "thickness=nan is out of range"),
        (lambda: Layer(distribution="phong"), "allowed are ggx, beckmann"),
        (lambda: Stack([]), "at least one layer"),
        (lambda: Stack([1.5]), "takes layers, got 1.5"),
        (lambda: Stack([Layer()], gonio.Lambert(rho=np.ones(3))), "rho is an array"),
        (lambda: Stack.of(gonio.WeidlichWilkie(fresnel="conductor")), "take fresnel='exact'"),
        (lambda: Stack.of(gonio.EON()), "models that do are weidlich_wilkie"),
        (lambda: Stack([Layer()]).eval((0, 0, 2), (0, 0, 1)), "not of unit length"),
        (lambda: Stack([Layer()]).eval((0, 1), (0, 0, 1)), "must hold 3 components"),
        (lambda: Stack([Layer()]).albedo(dr.llvm.Array3f(0, 0, 1)), "array of drjit"),
        (lambda: Stack([Layer()]).eval((0, 0, 1), (0, 0, 1), walks=0), "walks=0 is out of range"),
    ],
)
def test_mistakes_say_what_is_right(make: Callable[[], Any], message: str) -> None:
    with pytest.raises((ModelError, ValueError), match=message):
        make()


# --- what approximations stand for -----------------------------------------------------------------


def test_a_smooth_coat_with_all_options_is_the_truth_over_lambert() -> None:
    exact = {"transmission": "both_ways", "solid_angle": "compressed", "bounces": "diffuse"}
    coat = gonio.model("weidlich_wilkie", interface="smooth", base="lambert", **exact)
    wi, wo = random_directions(40, 1), random_directions(40, 2)
    f = Stack.of(coat).eval(wi, wo, walks=100_000)
    assert surprise(f.value, f.error, coat.eval(wi, wo)) < CHANCE
    plain = coat.replace(bounces="none")
    assert surprise(f.value, f.error, plain.eval(wi, wo)) > 10 * CHANCE


def test_nested_coats_become_layers_from_the_top_down() -> None:
    inner = gonio.model("weidlich_wilkie", eta=1.2, interface="smooth", sigma_a=(1, 2, 3))
    outer = gonio.model("weidlich_wilkie", eta=1.4, alpha=0.3, distribution="ggx", base=inner)
    found = Stack.of(outer)
    assert found.layers == (
        Layer(1.4, 0.3, (0, 0, 0), 1, "ggx"),
        Layer(1.2, 0.0, (1, 2, 3), 1, "beckmann"),
    )
    assert found.base.name == "lambert"


def test_the_base_of_car_paint_is_one_bare_flake() -> None:
    paint = gonio.model("car_paint", eta=1.4, metal_alpha=0.2, sigma_a=1)
    found = Stack.of(paint)
    assert found.layers == (Layer(1.4, paint.alpha, 1.0, 1.0, "ggx"),)
    metal = gonio.model(
        "torrance_sparrow",
        alpha=0.2,
        eta=tuple(x / 1.4 for x in paint.metal_eta),
        k=tuple(x / 1.4 for x in paint.metal_k),
    )
    wi, wo = random_directions(100, 1), random_directions(100, 2)
    # One facet: its normal is a direction in single precision, over a lobe of width 0.2
    np.testing.assert_allclose(found.base.eval(wi, wo), metal.eval(wi, wo), rtol=1e-4)


def test_triace_layered_becomes_two_surfaces() -> None:
    found = Stack.of(gonio.model("triace_layered", diffuse="oren_nayar", bottom_shininess=8))
    assert [round(layer.eta, 4) for layer in found.layers] == [1.3333, 1.125]
    assert found.layers[1].alpha == pytest.approx(math.sqrt(2 / 10))
    assert found.base.name == "triace_oren_nayar"
