"""A measured file as a model: it evaluates, samples, has albedos and renders as any other.

Values are looked up in a table over half and difference angles (Rusinkiewicz 1998), interpolated.
Samples are mirrored at normals from a tabulated distribution, one for each of 32 angles of the viewer
(after Dupuy et al., "Extracting Microfacet-based BRDF Parameters from Arbitrary Materials with Power
Iterations", EGSR 2015, who have one for all), mixed with cosine-weighted ones, so that weights have a
bound.
"""

from __future__ import annotations

import re
import types
from pathlib import Path
from typing import Any, ClassVar

from gonio.albedos.quadrature import NumericAlbedo
from gonio.lang import (
    INV_PI,
    PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    absolute,
    clamp,
    cos,
    dot,
    fract,
    maximum,
    minimum,
    select,
    sin,
    smooth_sqrt,
    twice_atan_over,
    vec2,
    vec3,
)
from gonio.measured.files import load
from gonio.measured.lookup import Table, fetch
from gonio.measured.measurement import DataError, Measurement
from gonio.measured.tabulate import ALBEDOS, AZIMUTHS, BINS, ROWS, Tables, tabulate
from gonio.model import Model, param
from gonio.parts.frame import azimuth, cos_half, half_vector, mirror, pdf_mirror
from gonio.parts.hemisphere import pdf_cosine, sample_cosine

# A length below which an azimuth means nothing.
TINY = 1e-20

# Steps of a search among up to 128 places.
STEPS = 7


def floor(x: Float) -> Float:
    """The next lower whole number."""
    return x - fract(x)


def angle(sine: Float, cosine: Float) -> Float:
    """The angle in [0, pi] with this sine and cosine."""
    v = sine / (1 + cosine)
    return v * twice_atan_over(v)


def half_turn(x: Float, y: Float) -> Float:
    """The azimuth of the line through (x, y), in [0, pi): opposite directions are one."""
    x = select(y < 0, -x, x)
    y = absolute(y)
    # The tangent of half the angle to the nearer end of the x axis, at most 1
    v = y / maximum(smooth_sqrt(x * x + y * y) + absolute(x), TINY)
    a = v * twice_atan_over(v)
    return select(x < 0, PI - a, a)


class MeasuredIsotropic(Model, register=False):
    """A measured material that does not change when it turns. Reciprocal, as it was made to be."""

    not_exported: ClassVar[str] = (
        "its tables need buffers, which exported shaders do not have; export a model fitted to it"
    )
    scale: Color = param((1.0, 1.0, 1.0), 0, 10, "multiplies what was measured")
    numeric = NumericAlbedo("half_vectors")
    tables: ClassVar[Tables]
    values: ClassVar[Table]
    density: ClassVar[Table]
    cumulative: ClassVar[Table]
    bounds: ClassVar[Table]
    share: ClassVar[Table]
    albedos: ClassVar[Table]

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The table's value, interpolated in three dimensions."""
        n_h, n_d, n_p = self.tables.values.shape[:3]
        h = half_vector(wi, wo)
        theta_h, theta_d, phi_d = self._angles(h, wi, wo)
        # Numbers stand for the middle of their steps
        x = clamp(n_h * smooth_sqrt(theta_h * (2 * INV_PI)) - 0.5, 0, n_h - 1)
        y = clamp(n_d * theta_d * (2 * INV_PI) - 0.5, 0, n_d - 1)
        z = n_p * phi_d * INV_PI + (n_p - 0.5)  # a turn further, so that it is positive
        i, j, k = floor(x), floor(y), floor(z)
        total = vec3(0 * x, 0 * x, 0 * x)
        for corner in range(8):
            a, b, c = corner // 4, corner // 2 % 2, corner % 2
            weight = _part(x - i, a) * _part(y - j, b) * _part(z - k, c)
            row = minimum(i + a, n_h - 1) * n_d + minimum(j + b, n_d - 1)
            total = total + weight * fetch(self.values, row * n_p + _wrapped(k + c, n_p))
        return self.scale * total

    def _angles(self, h: Vec3, wi: Vec3, wo: Vec3) -> tuple[Float, Float, Float]:
        """theta_h, theta_d, and phi_d in [0, pi)."""
        sine = smooth_sqrt(h.x * h.x + h.y * h.y)
        d = 0.5 * (wi - wo)
        theta_d = angle(smooth_sqrt(dot(d, d)), cos_half(wi, wo))
        # x and y of wi in the frame whose pole is h: x goes down its meridian
        axis = azimuth(h)
        x = h.z * (axis.x * wi.x + axis.y * wi.y) - sine * wi.z
        y = axis.x * wi.y - axis.y * wi.x
        return angle(sine, h.z), theta_d, half_turn(x, y)

    def _row(self, wo: Vec3) -> Float:
        """Which of the distributions of normals a viewer has."""
        theta_o = angle(smooth_sqrt(wo.x * wo.x + wo.y * wo.y), wo.z)
        return clamp(floor(ROWS * theta_o * (2 * INV_PI)), 0, ROWS - 1)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Mirrored at a normal of the table, or cosine-weighted."""
        row = self._row(wo)
        share = fetch(self.share, row)
        diffuse = u.x < share
        v = clamp(select(diffuse, u.x / share, (u.x - share) / (1 - share)), 0, 1 - 2.0**-24)
        # The last place whose cumulative value is not above v
        first = row * (BINS + 1)
        k = 0 * v
        for step in range(STEPS):
            ahead = k + 2 ** (STEPS - 1 - step)
            inside = ahead < BINS
            place = first + minimum(ahead, BINS - 1)
            k = select(inside & (fetch(self.cumulative, place) <= v), ahead, k)
        low, high = fetch(self.cumulative, first + k), fetch(self.cumulative, first + k + 1)
        part = clamp((v - low) / maximum(high - low, TINY), 0, 1)
        # 1 - cos(theta_m), even in each bin; the cosine itself has no digits at small angles
        w = (1 - part) * fetch(self.bounds, k) + part * fetch(self.bounds, k + 1)
        sine = smooth_sqrt(w * (2 - w))
        phi = 2 * PI * u.y
        m = vec3(sine * cos(phi), sine * sin(phi), 1 - w)
        c = sample_cosine(vec2(v, u.y))
        r = mirror(wo, m)
        wi = vec3(select(diffuse, c.x, r.x), select(diffuse, c.y, r.y), select(diffuse, c.z, r.z))
        above = wi.z > 0
        up = vec3(select(above, wi.x, 0), select(above, wi.y, 0), select(above, wi.z, 1))
        return Sample(wi, select(above, self.pdf(up, wo), 0))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        row = self._row(wo)
        share = fetch(self.share, row)
        h = half_vector(wi, wo)
        theta_h = angle(smooth_sqrt(h.x * h.x + h.y * h.y), h.z)
        k = clamp(floor(BINS * smooth_sqrt(theta_h * (2 * INV_PI))), 0, BINS - 1)
        density = fetch(self.density, row * BINS + k)
        return share * pdf_cosine(wi) + (1 - share) * pdf_mirror(density, cos_half(wi, wo))

    def albedo(self, wo: Vec3) -> Color:
        """Integrated when the file was read, to 1e-3 below 80 degrees."""
        theta_o = angle(smooth_sqrt(wo.x * wo.x + wo.y * wo.y), wo.z)
        return self.scale * self._albedo_at(theta_o, 0 * theta_o)

    def _albedo_at(self, theta_o: Float, first: Float) -> Color:
        """Between the places of the table that begins at `first`."""
        x = clamp(theta_o * (2 * INV_PI) * (ALBEDOS - 1), 0, ALBEDOS - 1)
        k = minimum(floor(x), ALBEDOS - 2)
        t = x - k
        place = first + k
        return (1 - t) * fetch(self.albedos, place) + t * fetch(self.albedos, place + 1)

    def mean_albedo(self) -> Color:
        """The mean of the table of albedos."""
        r, g, b = self.tables.mean_albedo
        return self.scale * vec3(r, g, b)


class MeasuredAnisotropic(MeasuredIsotropic, register=False):
    """A measured material that changes when it turns: the table has the half vector's azimuth as well."""

    isotropic = False

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The table's value, interpolated in four dimensions."""
        n_q, n_h, n_d, n_p = self.tables.values.shape[:4]
        h = half_vector(wi, wo)
        theta_h, theta_d, phi_d = self._angles(h, wi, wo)
        line = half_turn(h.x, h.y)
        phi_h = select(h.y < 0, line + PI, line)
        q = n_q * phi_h * (0.5 * INV_PI) + (n_q - 0.5)
        x = clamp(n_h * smooth_sqrt(theta_h * (2 * INV_PI)) - 0.5, 0, n_h - 1)
        y = clamp(n_d * theta_d * (2 * INV_PI) - 0.5, 0, n_d - 1)
        z = n_p * phi_d * INV_PI + (n_p - 0.5)
        l, i, j, k = floor(q), floor(x), floor(y), floor(z)  # noqa: E741
        total = vec3(0 * x, 0 * x, 0 * x)
        for corner in range(16):
            a, b, c, d = corner // 8, corner // 4 % 2, corner // 2 % 2, corner % 2
            weight = _part(q - l, a) * _part(x - i, b) * _part(y - j, c) * _part(z - k, d)
            row = _wrapped(l + a, n_q) * n_h + minimum(i + b, n_h - 1)
            row = row * n_d + minimum(j + c, n_d - 1)
            total = total + weight * fetch(self.values, row * n_p + _wrapped(k + d, n_p))
        return self.scale * total

    def albedo(self, wo: Vec3) -> Color:
        """Integrated when the file was read, to 1e-2; it changes when the sample turns."""
        theta_o = angle(smooth_sqrt(wo.x * wo.x + wo.y * wo.y), wo.z)
        line = half_turn(wo.x, wo.y)
        x = AZIMUTHS * select(wo.y < 0, line + PI, line) * (0.5 * INV_PI)
        k = floor(x)
        t = x - k
        low, high = _wrapped(k, AZIMUTHS) * ALBEDOS, _wrapped(k + 1, AZIMUTHS) * ALBEDOS
        return self.scale * (
            (1 - t) * self._albedo_at(theta_o, low) + t * self._albedo_at(theta_o, high)
        )


def _part(t: Float, upper: int) -> Float:
    """The weight of the lower or upper neighbour."""
    return t if upper else 1 - t


def _wrapped(k: Float, period: int) -> Float:
    """A whole number in [0, 3 period) as one in [0, period)."""
    k = select(k >= 2 * period, k - 2 * period, k)
    return select(k >= period, k - period, k)


# --- classes for files ---------------------------------------------------------------------------

_made: dict[tuple[str, int, int, str], type[Model]] = {}
_names: dict[str, object] = {}


def as_model(
    source: str | Path | Measurement,
    shape: tuple[int, ...] | None = None,
    part: str | None = None,
) -> Model:
    """A model of what a file holds, or of a measurement.

    Args:
        source: a file of any format that gonio reads, or a measurement.
        shape: places of its table; see `gonio.measured.tabulate.tabulate`.
        part: of the file, the first reflection by default.

    Raises:
        DataError: the file cannot be read, or holds transmission only.
    """
    if isinstance(source, Measurement):
        return _class_for(source, shape)()
    return model_class(source, shape, part)()


def model_class(
    path: str | Path, shape: tuple[int, ...] | None = None, part: str | None = None
) -> type[Model]:
    """The class behind a file: made once, and again if the file changes."""
    path = Path(path)
    measured = None
    try:
        found = path.stat()
        key = (str(path.resolve()), found.st_mtime_ns, found.st_size, f"{part} {shape}")
    except OSError:
        measured = load(path, part)  # says why not
        key = (str(path), 0, 0, f"{part} {shape}")
    if key not in _made:
        _made[key] = _class_for(measured or load(path, part), shape)
    return _made[key]


def source_of(cls: type[Model]) -> Path | None:
    """The file behind a class that `model_class` has made; None for any other class."""
    paths = (key[0] for key, made in _made.items() if made is cls)
    return next((Path(path) for path in paths), None)


def _class_for(measured: Measurement, shape: tuple[int, ...] | None) -> type[Model]:
    if measured.transmission:
        raise DataError(
            f"{measured.title}: {measured.part} is no reflection; a model has no other."
        )
    tables = tabulate(measured, shape)
    base = MeasuredIsotropic if measured.isotropic else MeasuredAnisotropic
    # Files may be called like each other and like models; Mitsuba's plug-ins need different names
    stem = re.sub(r"\W+", "_", measured.title).strip("_").lower() or "file"
    name, number = f"measured_{stem}", 2
    while name in _names:
        name, number = f"measured_{stem}_{number}", number + 1
    _names[name] = measured.title
    members: dict[str, Any] = {
        "__doc__": f"Measured: {measured.title}, from {measured.format}.",
        "__module__": __name__,
        "tables": tables,
        "values": Table(tables.values, 3),
        "density": Table(tables.density),
        "cumulative": Table(tables.cumulative),
        "bounds": Table(tables.bounds),
        "share": Table(tables.share),
        "albedos": Table(tables.albedo, 3),
        "caveats": tables.notes,
    }
    made: type[Model] = types.new_class(
        name, (base,), {"register": False}, lambda namespace: namespace.update(members)
    )
    made.name = name
    return made
