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
from typing import Any, ClassVar, NamedTuple

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import UNBOUNDED, Claims, at_most
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
from gonio.measured.measurement import DataError, Measurement
from gonio.measured.tabulate import ALBEDOS, AZIMUTHS, BINS, ROWS, Tables, tabulate
from gonio.model import Model, param
from gonio.parts.frame import azimuth, cos_half, half_length, half_vector, mirror, pdf_mirror
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.table import Table, fetch

# A length below which an azimuth means nothing.
TINY = 1e-20

# Steps of a search among up to 128 places, and half of these.
STEPS = 7
HALF = 64


def floor(x: Float) -> Float:
    """The next lower whole number."""
    return x - fract(x)


def angle(sine: Float, cosine: Float) -> Float:
    """The angle in [0, pi] with this sine and cosine."""
    v = sine / (1 + cosine)
    return v * twice_atan_over(v)


def half_turn(x: Float, y: Float) -> Float:
    """The azimuth of the line through (x, y), in [0, pi): opposite directions are one."""
    along = select(y < 0, -x, x)
    # The tangent of half the angle to the nearer end of the x axis, at most 1
    v = absolute(y) / maximum(smooth_sqrt(x * x + y * y) + absolute(x), TINY)
    a = v * twice_atan_over(v)
    return select(along < 0, PI - a, a)


def wrapped(k: Float, period: Float) -> Float:
    """A whole number in [0, 3 period) as one in [0, period)."""
    once = select(k >= period, k - period, k)
    return select(once >= period, once - period, once)


class Angles(NamedTuple):
    """Where a pair of directions stands in the table, in radians."""

    theta_h: Float
    """Between the half vector and the normal."""
    theta_d: Float
    """Between the half vector and either direction."""
    phi_d: Float
    """The azimuth of wi around the half vector, in [0, pi)."""


class MeasuredIsotropic(Model, register=False):
    """A measured material that does not change when it turns. Reciprocal, as it was made to be."""

    scale: Color = param((1.0, 1.0, 1.0), 0, 10, "multiplies what was measured")
    numeric = NumericAlbedo("half_vectors")
    # Files may hold anything. A tenth of the samples at least is cosine-weighted: none of those is wasted
    claims = Claims(
        energy=at_most(UNBOUNDED),
        wasted=at_most(0.9),
        float32=at_most(1e-3),
        numeric_albedo=at_most(1e-2),
    )
    steps_h: ClassVar[int]  # of the table, along the root of theta_h
    steps_d: ClassVar[int]  # along theta_d
    steps_p: ClassVar[int]  # along phi_d
    values: ClassVar[Table]
    density: ClassVar[Table]
    cumulative: ClassVar[Table]
    bounds: ClassVar[Table]
    share: ClassVar[Table]
    albedos: ClassVar[Table]
    mean_r: ClassVar[float]
    mean_g: ClassVar[float]
    mean_b: ClassVar[float]

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The table's value, interpolated in three dimensions."""
        h = half_vector(wi, wo)
        at = self._angles(h, wi, wo)
        return self.scale * self._in_volume(0 * at.theta_h, at)

    def _in_volume(self, first: Float, at: Angles) -> Color:
        """The value between the eight places around these angles, in a table that begins at `first`."""
        # Numbers stand for the middle of their steps
        x = self.steps_h * smooth_sqrt(at.theta_h * (2 * INV_PI)) - 0.5
        x = clamp(x, 0, self.steps_h - 1)
        y = clamp(self.steps_d * at.theta_d * (2 * INV_PI) - 0.5, 0, self.steps_d - 1)
        z = self.steps_p * at.phi_d * INV_PI + (
            self.steps_p - 0.5
        )  # a turn further, so that it is positive
        i = floor(x)
        t = x - i
        low = self._in_plane(first + i * (self.steps_d * self.steps_p), y, z)
        above = minimum(i + 1, self.steps_h - 1)
        high = self._in_plane(first + above * (self.steps_d * self.steps_p), y, z)
        return (1 - t) * low + t * high

    def _in_plane(self, first: Float, y: Float, z: Float) -> Color:
        """The same in two dimensions."""
        j = floor(y)
        t = y - j
        low = self._in_line(first + j * self.steps_p, z)
        high = self._in_line(first + minimum(j + 1, self.steps_d - 1) * self.steps_p, z)
        return (1 - t) * low + t * high

    def _in_line(self, first: Float, z: Float) -> Color:
        """The same in one, where the last place is followed by the first."""
        k = floor(z)
        t = z - k
        low = fetch(self.values, first + wrapped(k, self.steps_p))
        high = fetch(self.values, first + wrapped(k + 1, self.steps_p))
        return (1 - t) * low + t * high

    def _angles(self, h: Vec3, wi: Vec3, wo: Vec3) -> Angles:
        """The angles between two directions and their half vector."""
        sine = smooth_sqrt(h.x * h.x + h.y * h.y)
        d = 0.5 * (wi - wo)
        theta_d = angle(smooth_sqrt(dot(d, d)), cos_half(wi, wo))
        # x and y of wi in the frame whose pole is h: x goes down its meridian
        axis = azimuth(h)
        x = h.z * (axis.x * wi.x + axis.y * wi.y) - sine * wi.z
        y = axis.x * wi.y - axis.y * wi.x
        return Angles(angle(sine, h.z), theta_d, half_turn(x, y))

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
        k, stride = 0 * v, 0 * v + HALF
        for _ in range(STEPS):
            ahead = k + stride
            stride = 0.5 * stride
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
        return share * pdf_cosine(wi) + (1 - share) * pdf_mirror(density, half_length(wi, wo))

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
        return self.scale * vec3(self.mean_r, self.mean_g, self.mean_b)


class MeasuredAnisotropic(MeasuredIsotropic, register=False):
    """A measured material that changes when it turns: the table has the half vector's azimuth as well."""

    isotropic = False

    steps_q: ClassVar[int]  # along phi_h

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The table's value, interpolated in four dimensions."""
        h = half_vector(wi, wo)
        at = self._angles(h, wi, wo)
        line = half_turn(h.x, h.y)
        phi_h = select(h.y < 0, line + PI, line)
        q = self.steps_q * phi_h * (0.5 * INV_PI) + (self.steps_q - 0.5)
        l = floor(q)  # noqa: E741
        t = q - l
        size = self.steps_h * (self.steps_d * self.steps_p)
        low = self._in_volume(wrapped(l, self.steps_q) * size, at)
        high = self._in_volume(wrapped(l + 1, self.steps_q) * size, at)
        return self.scale * ((1 - t) * low + t * high)

    def albedo(self, wo: Vec3) -> Color:
        """Integrated when the file was read, to 1e-2; it changes when the sample turns."""
        theta_o = angle(smooth_sqrt(wo.x * wo.x + wo.y * wo.y), wo.z)
        line = half_turn(wo.x, wo.y)
        x = AZIMUTHS * select(wo.y < 0, line + PI, line) * (0.5 * INV_PI)
        k = floor(x)
        t = x - k
        low, high = wrapped(k, AZIMUTHS) * ALBEDOS, wrapped(k + 1, AZIMUTHS) * ALBEDOS
        return self.scale * (
            (1 - t) * self._albedo_at(theta_o, low) + t * self._albedo_at(theta_o, high)
        )


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
        **_members(tables),
        "caveats": tables.notes,
    }
    made: type[Model] = types.new_class(
        name, (base,), {"register": False}, lambda namespace: namespace.update(members)
    )
    made.name = name
    return made


def _members(tables: Tables) -> dict[str, Any]:
    """What the class of a model has of its tables."""
    names = ("steps_q", "steps_h", "steps_d", "steps_p")
    shape = tables.values.shape[:-1]
    angles = ("phi_h", "theta_h", "theta_d", "phi_d")[-len(shape) :]
    made = (
        Table("values", tables.values, colours=True, doc=f"BRDF in 1/sr over {', '.join(angles)}"),
        Table("density", tables.density, doc="Density of normals over theta_o and their own angle"),
        Table("cumulative", tables.cumulative, doc="The same, summed up to the normal's angle"),
        Table("bounds", tables.bounds, doc="1 - cos of the normal's angles"),
        Table("share", tables.share, doc="Share of cosine-weighted samples over theta_o"),
        Table("albedos", tables.albedo, colours=True, doc="Directional albedo over theta_o"),
    )
    return {
        **dict(zip(names[-len(shape) :], shape, strict=True)),
        **{table.name: table for table in made},
        **dict(zip(("mean_r", "mean_g", "mean_b"), tables.mean_albedo, strict=True)),
    }
