"""Light from environment pictures, prefiltered the way real-time renderers do it.

    sky = gonio.bake.environment.load("studio.hdr")        # or one of gonio's own: "studio", "sunsky", ...
    blurred = sky.blurred(alpha=0.1)                       # what a surface of that roughness mirrors
    blurred.radiance(directions)                           # (..., 3)
    harmonics = sky.harmonics()                            # (9, 3), for diffuse light
    irradiance(harmonics, normals)

Pictures are in longitude and latitude, as Mitsuba's `envmap` has them: y is up, the first row the zenith.
Directions are in the world; gonio's models are evaluated in the frame of each normal.

Sources: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3, for the coat's reflection;
Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course, Eq. 6 to
9 and 27 to 29, for layers and for Oren-Nayar; Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013
course, for the blur; Ramamoorthi, Hanrahan, "An efficient representation for irradiance environment maps",
SIGGRAPH 2001, for the harmonics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.arrays.elementwise import elementwise
from gonio.files import check_place, replacing
from gonio.images import write_linear
from gonio.lights import image_light
from gonio.parts import distribution, fresnel

if TYPE_CHECKING:
    from gonio.model import Model

Floats = NDArray[np.float64]
Progress = Callable[[int, int], None]

# Widths of blurred pictures: so many pixels for each alpha radians, which resolve the lobe (twice as many
# change the result by 6e-4 on the mean), but at least BLUR_WIDTH_MIN pixels all round, and not more than
# BLUR_WIDTH_MAX, which takes ten seconds.
PIXELS_PER_ALPHA = 8
BLUR_WIDTH_MIN = 64
BLUR_WIDTH_MAX = 1024

# Steps per pixel in which pictures are averaged to another size.
STEPS = 32

# Rows down to which a picture is refined before its harmonics are summed (error below 1e-5), or up to twice
# as many to which a large one is averaged, so that memory does not run out.
HARMONIC_ROWS = 512


@dataclass(frozen=True)
class Environment:
    """Radiance from all directions; linear RGB."""

    pixels: Floats
    """Shape (height, width, 3), at least 2 x 2; rows from zenith to nadir, both included."""

    def __post_init__(self) -> None:
        """Refuse what is no such picture."""
        pixels = np.asarray(self.pixels, np.float64)
        if pixels.ndim != 3 or pixels.shape[2] != 3 or min(pixels.shape[:2]) < 2:
            raise ValueError(
                f"the picture has shape {pixels.shape}; needed is (height, width, 3), at least 2 x 2."
            )
        if not (np.isfinite(pixels).all() and pixels.min() >= 0):
            raise ValueError("the picture has pixels that are negative or not finite.")
        object.__setattr__(self, "pixels", pixels)

    def radiance(self, directions: ArrayLike) -> Floats:
        """What comes from these directions, shape (..., 3), interpolated between pixels."""
        return _look_up(self.pixels, np.asarray(directions, np.float64))

    def blurred(
        self, alpha: float, *, width: int | None = None, progress: Progress | None = None
    ) -> Environment:
        """What a GGX surface of this width mirrors when it is seen from above, for every direction.

        Karis's first sum: the lobe of the view along the normal stands for those of all views, which
        are longer and thinner at grazing angles. Without random numbers: a convolution on the sphere.

        Args:
            alpha: width of the facets' slopes, above 0 and at most 1.
            width: of the new picture in pixels; by default as fine as the lobe needs.
            progress: called with (rows done, rows in all).

        Raises:
            ValueError: an argument out of its range.
        """
        check_blur(alpha, width)
        wanted = min(
            max(BLUR_WIDTH_MIN, 2 * np.pi * PIXELS_PER_ALPHA / alpha), self.pixels.shape[1]
        )
        columns = width or min(2 * int(wanted / 2), BLUR_WIDTH_MAX)
        rows = columns // 2 + 1

        def lobe(mu: Floats) -> Floats:
            """mu times the density of light mirrored by facets: D(h) (N.h) / (4 N.h), N = V."""
            tan2 = (1 - mu) / np.maximum(1 + mu, 1e-9)  # of h, half way between N and the light
            D = ((1 + tan2) / (1 + tan2 / alpha**2)) ** 2
            return np.asarray(np.maximum(mu, 0) * D)

        return Environment(_convolved(_resampled(self.pixels, rows, columns), lobe, progress))

    def harmonics(self) -> Floats:
        """The first nine real spherical harmonics of the radiance, shape (9, 3).

        In the order of Ramamoorthi and Hanrahan: 1; y, z, x; xy, yz, 3 z^2 - 1, xz, x^2 - y^2.
        """
        pixels = self.pixels
        if pixels.shape[0] > 2 * HARMONIC_ROWS:
            pixels = _resampled(pixels, HARMONIC_ROWS + 1, 2 * HARMONIC_ROWS)
        factor = max(1, -(-HARMONIC_ROWS // (pixels.shape[0] - 1)))
        if factor > 1:
            rows, columns = factor * (pixels.shape[0] - 1) + 1, factor * pixels.shape[1]
            pixels = _look_up(pixels, _directions(rows, columns))
        weights = _solid_angles(*pixels.shape[:2])
        basis = _harmonic_basis(_directions(*pixels.shape[:2]))
        return np.asarray(np.einsum("ijk,ijc,i->kc", basis, pixels, weights))

    def write(self, path: str | Path) -> None:
        """Write the picture as .exr or .hdr, for any renderer.

        Raises:
            ValueError: another suffix.
            FileNotFoundError: the folder does not exist.
        """

        path = check_format(path)
        with replacing(path) as temporary:
            write_linear(temporary, self.pixels)


def check_format(path: str | Path) -> Path:
    """The path, or a ValueError or OSError unless `Environment.write` can write a file of this name."""
    path = Path(path)
    if path.suffix.lower() not in {".exr", ".hdr"}:
        raise ValueError(f"cannot write {path.name!r}; the suffix must be .exr or .hdr.")
    return check_place(path)


def check_blur(alpha: float, width: int | None) -> None:
    """A ValueError unless `Environment.blurred` can blur so much, into a picture so wide."""
    if not 0 < alpha <= 1:
        raise ValueError(f"alpha={alpha} is out of range; allowed is above 0 to 1.")
    if width is not None and not 8 <= width <= BLUR_WIDTH_MAX:
        raise ValueError(f"width={width} is out of range; allowed is 8 to {BLUR_WIDTH_MAX}.")


def load(
    environment: str | Path, *, width: int = 512, spp: int = 64, progress: Progress | None = None
) -> Environment:
    """An environment from an .exr or .hdr file, or one of gonio's own as seen from the object's place.

    A file's directions are those of Mitsuba's `envmap` without a transformation; `gonio render --env` turns
    it by half a turn, so that its middle is behind the object.

    Args:
        environment: a path, or "studio", "sun", "front", "side", "white" or "sunsky".
        width: of the picture of one of gonio's own, in pixels.
        spp: samples per pixel of it.
        progress: called with (samples done, samples in all).

    Raises:
        ValueError, FileNotFoundError: one line on what was wrong.
    """
    import mitsuba as mi

    from gonio import backend
    from gonio.render.light import environment_nodes

    if mi.variant() is None:
        mi.set_variant(backend.mitsuba_variant())
    nodes = environment_nodes(environment)
    sky = nodes.get("sky")
    if isinstance(sky, dict) and sky.get("type") == "envmap":
        return Environment(np.array(sky["bitmap"]))
    return _panorama(nodes, width, spp, progress)


# --- light from prefiltered pictures ---------------------------------------------------------------------


def irradiance(harmonics: Floats, normals: ArrayLike) -> Floats:
    """Irradiance from the first nine harmonics, shape (..., 3). Ramamoorthi and Hanrahan, Eq. 11."""
    basis = _harmonic_basis(np.asarray(normals, np.float64))
    return np.asarray(basis * COSINE_LOBE @ harmonics, np.float64)


def coat_reflection(
    blurred: Environment,
    normals: ArrayLike,
    to_viewer: ArrayLike,
    eta: ArrayLike,
    k: ArrayLike = 0.0,
) -> Floats:
    """What a coat mirrors of an environment: F(mu_o) times the blurred picture (Elek, Algorithm 1).

    Args:
        blurred: the environment, blurred by the coat's alpha (`Environment.blurred`).
        normals: unit vectors, shape (..., 3).
        to_viewer: unit vectors, shape (..., 3).
        eta: relative index of the coat, one number or three.
        k: its extinction.

    Returns:
        Radiance, shape (..., 3); 0 where the viewer is behind the surface.
    """
    mu, mirrored = _mirrored(normals, to_viewer)
    F = elementwise(fresnel.F_conductor, mu[..., None], eta, k)
    return np.where(mu[..., None] > 0, F * blurred.radiance(mirrored), 0)


def oren_nayar_light(
    harmonics: Floats,
    normals: ArrayLike,
    to_viewer: ArrayLike,
    *,
    rho: ArrayLike,
    shininess: float,
    form: str = "arccos",
) -> Floats:
    """Radiance of tri-Ace's Oren-Nayar surface in an environment: harmonics with scales (Eq. 27 to 29).

    The constant harmonic is scaled by Eq. 27, or by Eq. 28 with form="cheap", the linear ones by Eq. 29.
    The course stops there. The quadratic ones are scaled like the linear ones here.

    Args:
        harmonics: as `Environment.harmonics` gives them.
        normals: unit vectors, shape (..., 3).
        to_viewer: unit vectors, shape (..., 3).
        rho: albedo of the facets, one number or three.
        shininess: Blinn-Phong's exponent n.
        form: "arccos" for Eq. 27, "cheap" for Eq. 28, "lambert" for no scales at all.

    Raises:
        ValueError: an unknown form.
    """
    forms: dict[str, Callable[..., Any] | None] = {
        "arccos": image_light.harmonic_dc_scale,
        "cheap": image_light.harmonic_dc_scale_cheap,
        "lambert": None,
    }
    if form not in forms:
        raise ValueError(f"form={form!r} is not known; allowed are {', '.join(forms)}.")
    n = np.asarray(normals, np.float64)
    mu, _ = _mirrored(n, to_viewer)
    terms = _harmonic_basis(n) * COSINE_LOBE
    dc_scale = forms[form]
    if dc_scale is not None:
        above = np.clip(mu, 0, 1)
        terms = np.concatenate(
            [
                terms[..., :1] * elementwise(dc_scale, above, shininess)[..., None],
                terms[..., 1:]
                * elementwise(image_light.harmonic_linear_scale, above, shininess)[..., None],
            ],
            axis=-1,
        )
    light = np.maximum(terms @ harmonics, 0) * np.asarray(rho, np.float64) / np.pi
    return np.where(mu[..., None] > 0, light, 0)


def layered_light(
    environment: Environment,
    model: Model,
    normals: ArrayLike,
    to_viewer: ArrayLike,
    *,
    progress: Progress | None = None,
) -> Floats:
    """Radiance of `gonio.TriAceLayered` in an environment, as the course's shader has it (Eq. 5 to 9).

    Args:
        environment: not blurred.
        model: a TriAceLayered with numbers, not arrays, for parameters.
        normals: unit vectors, shape (..., 3).
        to_viewer: unit vectors, shape (..., 3).
        progress: called with (samples done, samples in all).

    Raises:
        ValueError: another model.
    """
    if model.name != "triace_layered":
        raise ValueError(f"layered_light takes a TriAceLayered, not {type(model).__name__}.")
    p = {name: np.asarray(getattr(model, name), np.float64) for name in _numbers(model)}
    mu, mirrored = _mirrored(normals, to_viewer)
    seen = np.clip(mu, 0, 1)[..., None]
    depth = p["sigma_a"] * p["thickness"]
    f0 = elementwise(fresnel.f0_from_eta, p["top_eta"])
    F_top = elementwise(lambda c, f: fresnel.F_schlick(c, f, 1), seen, f0)
    F_bottom = elementwise(fresnel.f0_between, p["top_eta"], p["bottom_eta"]) * (1 - f0)
    T = 1 - F_top if getattr(model, "top_transmission") == "on" else 1.0  # noqa: B009

    def blurred(shininess: Floats, part: int) -> Environment:
        def step(done: int, total: int) -> None:
            if progress is not None:
                progress(part * total + done, 2 * total)

        alpha = float(elementwise(distribution.blinn_phong_alpha, shininess))
        return environment.blurred(alpha, progress=step)

    top = F_top * blurred(p["top_shininess"], 0).radiance(mirrored)
    kept = elementwise(image_light.specular_image_absorption, depth, seen)
    glossy = T * F_bottom * kept * blurred(p["bottom_shininess"], 1).radiance(mirrored)
    form = "arccos" if getattr(model, "diffuse") == "oren_nayar" else "lambert"  # noqa: B009
    kept = elementwise(image_light.diffuse_image_absorption, depth, seen)
    matte = (T * (1 - F_bottom) * kept) * oren_nayar_light(
        environment.harmonics(),
        normals,
        to_viewer,
        rho=p["rho"],
        shininess=float(p["bottom_shininess"]),
        form=form,
    )
    return np.where(mu[..., None] > 0, top + glossy + matte, 0)


def _numbers(model: Model) -> list[str]:
    from gonio.fields import Parameter

    return [name for name, declared in model.fields.items() if isinstance(declared, Parameter)]


def reflected(
    environment: Environment,
    model: Model,
    normals: ArrayLike,
    to_viewer: ArrayLike,
    *,
    samples: int = 256,
    seed: int = 0,
    progress: Progress | None = None,
) -> Floats:
    """Radiance of any model in an environment, without prefiltering: what the shortcuts are compared with.

    Half of the directions are sampled as the model reflects, half as the picture is bright, and each counts
    by the mean of both densities. The frame's x axis is horizontal.

    Args:
        environment: not blurred.
        model: any.
        normals: unit vectors, shape (..., 3).
        to_viewer: unit vectors, shape (..., 3).
        samples: for each normal, at least 2.
        seed: the same seed gives the same result.
        progress: called with (samples done, samples in all).

    Returns:
        Radiance, shape (..., 3); 0 where the viewer is behind the surface.
    """
    if samples < 2:
        raise ValueError(f"samples={samples} is out of range; allowed is at least 2.")
    n, v = np.broadcast_arrays(np.asarray(normals, np.float64), np.asarray(to_viewer, np.float64))
    axes = np.stack([*_tangents(n), n], axis=-2)
    wo = _unit(np.einsum("...ij,...j->...i", axes, v))
    sky = _BrightPlaces(environment)
    shift = np.random.default_rng(seed).random((2, *wo.shape[:-1], 2))
    total: Floats = np.zeros(wo.shape)
    pairs = (samples + 1) // 2
    for number, point in enumerate(_points(pairs)):
        u = np.minimum((shift + point) % 1, 1 - 2.0**-24)
        by_model, _ = model.sample(wo, u[0])
        by_sky = _unit(np.einsum("...ij,...j->...i", axes, sky.sample(u[1])))
        for wi in (by_model, by_sky):
            towards = np.einsum("...ij,...i->...j", axes, wi)
            density = model.pdf(wi, wo) + sky.pdf(towards)
            factor = np.maximum(wi[..., 2], 0) / np.maximum(density, 1e-30)
            total += model.eval(wi, wo) * factor[..., None] * environment.radiance(towards)
        if progress is not None:
            progress(number + 1, pairs)
    return total / pairs


class _BrightPlaces:
    """Directions sampled as bright as the picture is: a pixel is chosen, then a place in it."""

    def __init__(self, environment: Environment) -> None:
        pixels = environment.pixels.mean(axis=2)
        rows, columns = pixels.shape
        # A pixel's light reaches into its neighbours when it is interpolated.
        padded = np.pad(np.pad(pixels, ((0, 0), (1, 1)), "wrap"), ((1, 1), (0, 0)), "edge")
        around = [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
        near = np.mean(around, axis=0)
        self.edges = np.clip(np.pi * (np.arange(rows + 1) - 0.5) / (rows - 1), 0, np.pi)
        solid_angle = 2 * np.pi / columns * -np.diff(np.cos(self.edges))[:, None]
        weight = (near + 1e-3 * near.mean() + 1e-30) * solid_angle
        self.shape = rows, columns
        self.density = weight / weight.sum() / solid_angle
        self.below = np.cumsum(weight.ravel()) / weight.sum()

    def sample(self, u: Floats) -> Floats:
        """Directions in the world for random numbers of shape (..., 2)."""
        columns = self.shape[1]
        chosen = np.minimum(
            np.searchsorted(self.below, u[..., 0], side="right"), self.below.size - 1
        )
        before = np.where(chosen > 0, self.below[chosen - 1], 0)
        left = np.clip((u[..., 0] - before) / (self.below[chosen] - before), 0, 1)
        i, j = chosen // columns, chosen % columns
        high, low = np.cos(self.edges[i]), np.cos(self.edges[i + 1])
        y = high + (low - high) * u[..., 1]
        phi = 2 * np.pi * (j + left) / columns
        sine = np.sqrt(np.maximum(1 - y * y, 0))
        return np.stack([sine * np.sin(phi), y, -sine * np.cos(phi)], axis=-1)

    def pdf(self, w: Floats) -> Floats:
        """Density of `sample` in 1/sr."""
        rows, columns = self.shape
        phi = np.arctan2(w[..., 0], -w[..., 2]) / (2 * np.pi) % 1
        j = np.minimum((phi * columns).astype(int), columns - 1)
        theta = np.arccos(np.clip(w[..., 1], -1, 1))
        i = np.clip(np.searchsorted(self.edges, theta, side="right") - 1, 0, rows - 1)
        return np.asarray(self.density[i, j])


# --- pictures in longitude and latitude -------------------------------------------------------------------


def _directions(rows: int, columns: int) -> Floats:
    """The direction of each pixel, shape (rows, columns, 3)."""
    theta = np.linspace(0, np.pi, rows)[:, None]
    phi = 2 * np.pi * (np.arange(columns) + 0.5)[None] / columns
    sine = np.sin(theta)
    x, z = sine * np.sin(phi), -sine * np.cos(phi)
    return np.stack(np.broadcast_arrays(x, np.cos(theta), z), axis=-1)


def _solid_angles(rows: int, columns: int) -> Floats:
    """Integral over the sphere of each row's interpolation weights, for one pixel of it."""
    h = np.pi / (rows - 1)
    weights = np.sin(np.linspace(0, np.pi, rows)) * 2 * (1 - np.cos(h)) / h
    weights[[0, -1]] = 1 - np.sin(h) / h
    return np.asarray(weights * 2 * np.pi / columns, np.float64)


def _look_up(pixels: Floats, w: Floats) -> Floats:
    rows, columns = pixels.shape[:2]
    across = np.arctan2(w[..., 0], -w[..., 2]) / (2 * np.pi) * columns - 0.5
    down = np.arccos(np.clip(w[..., 1], -1, 1)) / np.pi * (rows - 1)
    j = np.floor(across).astype(int)
    i = np.minimum(down.astype(int), rows - 2)
    s, t = (across - j)[..., None], (down - i)[..., None]
    left, right = j % columns, (j + 1) % columns
    above = (1 - s) * pixels[i, left] + s * pixels[i, right]
    below = (1 - s) * pixels[i + 1, left] + s * pixels[i + 1, right]
    return np.asarray((1 - t) * above + t * below)


def _resampled(pixels: Floats, rows: int, columns: int) -> Floats:
    """The picture with another size, each new pixel the mean over its place; no light is lost."""
    if pixels.shape[:2] == (rows, columns):
        return pixels
    old_rows, old_columns = pixels.shape[:2]
    # Fine steps along one axis: where they lie among the old pixels, and in which new one.
    theta = np.pi * (np.arange(STEPS * (old_rows - 1)) + 0.5) / (STEPS * (old_rows - 1))
    down = theta / np.pi * (old_rows - 1)
    new_row = np.floor(theta / np.pi * (rows - 1) + 0.5).astype(int)
    turn = (np.arange(STEPS * old_columns) + 0.5) / (STEPS * old_columns)
    across = turn * old_columns - 0.5
    new_column = np.minimum((turn * columns).astype(int), columns - 1)
    vertical = _means(down, new_row, np.sin(theta), old_rows, rows)
    horizontal = _means(across, new_column, np.ones_like(turn), old_columns, columns)
    return np.asarray(np.einsum("ri,ijc,kj->rkc", vertical, pixels, horizontal, optimize=True))


def _means(place: Floats, new: Any, weight: Floats, old_count: int, count: int) -> Floats:
    """The matrix that averages a row of interpolated old pixels over each new one."""
    low = np.floor(place).astype(int)
    t = place - low
    matrix: Floats = np.zeros((count, old_count))
    np.add.at(matrix, (new, low % old_count), weight * (1 - t))
    np.add.at(matrix, (new, (low + 1) % old_count), weight * t)
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


def _convolved(
    pixels: Floats, lobe: Callable[[Floats], Floats], progress: Progress | None
) -> Floats:
    """The mean of the picture around each pixel, weighted by a function of the angle's cosine."""
    rows, columns = pixels.shape[:2]
    theta = np.linspace(0, np.pi, rows)
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
    turned = np.cos(2 * np.pi * np.arange(columns) / columns)
    weights = _solid_angles(rows, columns)
    # Along each row the lobe depends on the difference of longitudes alone: a product of spectra.
    spectrum = np.fft.rfft(pixels * weights[:, None, None], axis=1)
    result = np.empty(pixels.shape)
    for i in range(rows):
        around = lobe(np.clip(cosine[i] * cosine + sine[i] * sine * turned, -1, 1))
        lobes = np.fft.rfft(around, axis=1)
        total = np.fft.irfft(np.einsum("jk,jkc->kc", lobes, spectrum), columns, axis=0)
        result[i] = total / np.sum(around * weights[:, None])
        if progress is not None:
            progress(i + 1, rows)
    # The product of spectra leaves rounding errors of both signs where the sky is black.
    return np.maximum(result, 0)


def _tangents(n: Floats) -> tuple[Floats, Floats]:
    """Two axes at right angles to n: a horizontal one, and the one that completes the frame."""
    flat = np.hypot(n[..., 0], n[..., 2])
    pole = flat < 1e-9
    scale = 1 / np.where(pole, 1, flat)
    x = np.stack(
        [np.where(pole, 1, n[..., 2] * scale), 0 * flat, np.where(pole, 0, -n[..., 0] * scale)], -1
    )
    return x, np.cross(n, x)


def _points(count: int) -> Floats:
    """Points that fill the unit square evenly: a lattice turned by the golden ratio."""
    index = np.arange(count)
    return np.stack([(index + 0.5) / count, (index * 0.6180339887498949) % 1], axis=-1)


def _mirrored(normals: ArrayLike, to_viewer: ArrayLike) -> tuple[Floats, Floats]:
    """N.V, and V mirrored at N."""
    n, v = np.asarray(normals, np.float64), np.asarray(to_viewer, np.float64)
    mu = np.sum(n * v, axis=-1)
    return mu, 2 * mu[..., None] * n - v


def _unit(v: Floats) -> Floats:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-30))


HARMONICS = ("1", "y", "z", "x", "xy", "yz", "3z^2-1", "xz", "x^2-y^2")
"""The nine real harmonics, in order."""

# Convolution with the cosine, for each of the nine: pi, 2 pi / 3 and pi / 4.
COSINE_LOBE = np.array([np.pi] + [2 * np.pi / 3] * 3 + [np.pi / 4] * 5)


def _harmonic_basis(w: Floats) -> Floats:
    """The nine real harmonics at directions, shape (..., 9)."""
    x, y, z = w[..., 0], w[..., 1], w[..., 2]
    one = np.ones_like(x)
    linear, quadratic = np.sqrt(3 / (4 * np.pi)), np.sqrt(15 / (4 * np.pi))
    return np.stack(
        [
            one / np.sqrt(4 * np.pi),
            linear * y,
            linear * z,
            linear * x,
            quadratic * x * y,
            quadratic * y * z,
            np.sqrt(5 / (16 * np.pi)) * (3 * z * z - 1),
            quadratic * x * z,
            quadratic / 2 * (x * x - y * y),
        ],
        axis=-1,
    )


def _panorama(
    nodes: dict[str, Any], width: int, spp: int, progress: Progress | None
) -> Environment:
    """The scene of an environment, seen in all directions from where the object stands."""
    import mitsuba as mi

    from gonio.render.ball import BALL_CENTRE

    loaded = mi.load_dict(
        {"type": "scene", "integrator": {"type": "path", "max_depth": 8}, **nodes}
    )
    integrator = mi.load_dict({"type": "path", "max_depth": 8})
    rows = width // 2 + 1
    middle = _directions(rows, width)
    across, along = _tangents(middle)
    rng = np.random.default_rng(0)
    total = np.zeros((rows, width, 3))
    sampler = mi.load_dict({"type": "independent", "sample_count": spp})
    for number in range(spp):
        sampler.seed(number, rows * width)
        step = np.pi / (rows - 1)
        a, b = step * (rng.random((2, rows, width, 1)) - 0.5)
        w = middle + a * across + b * along
        w /= np.linalg.norm(w, axis=-1, keepdims=True)
        origin = mi.Point3f(0, BALL_CENTRE, 0)
        ray = mi.RayDifferential3f(o=origin, d=mi.Vector3f(w.reshape(-1, 3).T))
        colour, _, _ = integrator.sample(loaded, sampler, ray)
        total += np.array(colour).T.reshape(rows, width, 3)
        if progress is not None:
            progress(number + 1, spp)
    return Environment(total / spp)
