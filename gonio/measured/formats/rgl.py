"""RGL's `.bsdf`: a table over a square that is warped by the facets that the viewer sees.

Source: Dupuy, Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering",
SIGGRAPH Asia 2018, and its supplement. A tensor file: "tensor_file\\0", two bytes of version, uint32
fields; for each uint16 length, name, uint16 dimensions, uint8 type, uint64 offset and extents.
Directions on the square are
u = (sqrt(2 theta / pi), phi / 2 pi + 1/2); m is the half vector, sigma the projected area of the facets:

    f cos(theta_i) = spectra(u) ndf(u_m) / (4 sigma(u_wo)),  u = the inverse of vndf's warp at u_m.

Files call the known direction the incident one; it is gonio's (and Mitsuba's) viewer. What is measured
is reciprocal but for errors.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.files import replacing
from gonio.measured.frames import Floats, angles, spherical
from gonio.measured.measurement import HORIZON, Mask, Measurement, Reflectance, measurement
from gonio.measured.source import MOST_NUMBERS, Source
from gonio.measured.warp import Bilinear, Density

NAME, SUFFIX = "RGL", ".bsdf"

MAGIC = b"tensor_file\0"

# Types of fields by their number, with gaps where Mitsuba has none.
TYPES = ("", "u1", "i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f2", "<f4", "<f8")

# A field's name, and how many fields and dimensions there may be; real files have 11 of at most 5.
LONGEST_NAME, MOST_FIELDS, MOST_DIMENSIONS = 256, 64, 8

# The measurements end at this angle.
MEASURED_TO = np.radians(83.0)

# What gonio writes: as many angles of the viewer, places along each side of the square, and azimuths.
THETAS, SIDE, PHIS = 24, 48, 16

# Directions evaluated at once.
BATCH = 1 << 16


@dataclass(frozen=True)
class Tensors:
    """The fields of a tensor file."""

    source: Source
    fields: dict[str, NDArray[Any]]

    def take(self, name: str, dimensions: int, what: str = "floats") -> NDArray[Any]:
        """A field with so many dimensions, or an error."""
        if name not in self.fields:
            raise self.source.error(
                f"has no field {name!r}; an RGL file has it. There are {', '.join(self.fields)[:200]}."
            )
        field = self.fields[name]
        if (
            field.ndim != dimensions
            or field.size == 0
            or (what == "floats" and field.dtype.kind != "f")
        ):
            raise self.source.error(
                f"field {name!r} is {field.dtype} of shape {field.shape}; {what} with {dimensions} "
                "dimensions are needed."
            )
        return field


def tensors(source: Source) -> Tensors:
    """The fields of a tensor file, mapped.

    Raises:
        DataError: it is truncated, or its header makes no sense.
    """
    major, minor, count = source.unpack("<BBI", len(MAGIC))
    if (major, minor) != (1, 0):
        raise source.error(f"is a tensor file of version {major}.{minor}; 1.0 is read.")
    if count > MOST_FIELDS:
        raise source.error(f"claims {count} fields; at most {MOST_FIELDS} are read.")
    place, fields = len(MAGIC) + 6, {}
    for _ in range(count):
        (length,) = source.unpack("<H", place)
        if length > LONGEST_NAME:
            raise source.error(f"has a field with a name of {length} characters.")
        name = source.bytes(place + 2, length).decode("latin-1")
        place += 2 + length
        dimensions, kind, offset = source.unpack("<HBQ", place)
        place += 11
        if dimensions > MOST_DIMENSIONS or not 1 <= kind < len(TYPES):
            raise source.error(f"field {name[:40]!r} has {dimensions} dimensions of type {kind}.")
        shape = source.unpack(f"<{dimensions}Q", place)
        place += 8 * dimensions
        fields[name] = source.binary(offset, TYPES[kind], shape)
    return Tensors(source, fields)


def sniff(source: Source) -> bool:
    """By its first twelve bytes."""
    return source.head.startswith(MAGIC)


class Table:
    """An RGL file's reflection at any directions."""

    def __init__(self, file: Tensors) -> None:
        """Check the fields and prepare the warps.

        Raises:
            DataError: a field is missing or does not fit the others.
        """
        source = file.source
        self.theta = source.finite(file.take("theta_i", 1), "theta_i")
        self.phi = source.finite(file.take("phi_i", 1), "phi_i")
        for name, places in (("theta_i", self.theta), ("phi_i", self.phi)):
            if (np.diff(places) <= 0).any() or np.abs(places).max() > 7:
                raise source.error(f"{name} does not grow, or is not in radians.")
        if self.theta[0] < 0 or self.theta[-1] > 0.5 * np.pi + 1e-4:
            raise source.error("theta_i is not between 0 and pi / 2.")
        self.spectral = "spectra" in file.fields
        values = file.take("spectra" if self.spectral else "rgb", 5)
        if self.spectral:
            self.wavelengths = source.finite(file.take("wavelengths", 1), "wavelengths")
        outer = (len(self.phi), len(self.theta))
        vndf, ndf, sigma = file.take("vndf", 4), file.take("ndf", 2), file.take("sigma", 2)
        channels = len(self.wavelengths) if self.spectral else 3
        fits = (
            vndf.shape[:2] == outer
            and values.shape[:3] == (*outer, channels)
            and min(*vndf.shape[2:], *ndf.shape, *sigma.shape, *values.shape[3:]) >= 2
        )
        if not fits:
            raise source.error(
                f"its fields do not fit: phi_i {outer[0]}, theta_i {outer[1]}, {channels} channels, vndf "
                f"{vndf.shape}, values {values.shape}, ndf {ndf.shape}, sigma {sigma.shape}."
            )
        if values.size + 4 * vndf.size > MOST_NUMBERS:
            raise source.error(f"holds {values.size:.3g} values; {MOST_NUMBERS:.3g} are read.")
        self.channels = channels
        jacobian = file.fields.get("jacobian")
        self.scaled = jacobian is None or jacobian.size == 0 or bool(jacobian.reshape(-1)[0])
        self.isotropic = len(self.phi) <= 2
        self.reduction = 1
        if not self.isotropic:
            self.reduction = max(1, round(2 * np.pi / float(self.phi[-1] - self.phi[0])))
        parameters = (self.phi, self.theta)
        self.vndf = Density(np.maximum(np.nan_to_num(np.asarray(vndf, np.float64)), 0), parameters)
        self.ndf, self.sigma = Bilinear(np.asarray(ndf)), Bilinear(np.asarray(sigma))
        # Channels last: a value's channels are read together
        self.values = Bilinear(np.moveaxis(np.asarray(values), 2, -1), parameters)

    def scale(self, u_m: Floats, v_m: Floats, theta: Any, phi: Any) -> Floats:
        """ndf / (4 sigma): what the values have been divided by."""
        if not self.scaled:
            return np.ones(len(u_m))
        area = self.sigma.eval(*_square(theta, phi))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.ndf.eval(u_m, v_m) / (4 * area))

    def __call__(self, wi: Floats, wo: Floats) -> tuple[Floats, Mask]:
        """Values and where they were measured."""
        found, covered = np.zeros((len(wi), self.channels)), np.zeros(len(wi), bool)
        for start in range(0, len(wi), BATCH):
            part = slice(start, start + BATCH)
            found[part], covered[part] = self._eval(wi[part], wo[part])
        return found, covered

    def _eval(self, wi: Floats, wo: Floats) -> tuple[Floats, Mask]:
        if self.reduction >= 2:  # of symmetric samples a half or a quarter has been measured
            sy = np.where(wo[:, 1] >= 0, -1.0, 1.0)
            sx = np.where(wo[:, 0] >= 0, -1.0, 1.0) if self.reduction == 4 else sy
            turn = np.stack([sx, sy, np.ones(len(wo))], -1)
            wi, wo = wi * turn, wo * turn
        theta, phi = angles(wo)
        h = wi + wo
        theta_m, phi_m = angles(h)
        x, y = _square(theta_m, phi_m - phi if self.isotropic else phi_m)
        y = y - np.floor(y)
        u, v = self.vndf.invert(x, y, (phi, theta))
        values = self.values.eval(np.nan_to_num(u), np.nan_to_num(v), (phi, theta))
        cosine = np.maximum(wi[:, 2], HORIZON)
        values = values * (self.scale(x, y, theta, phi) / cosine)[:, None]
        good = np.isfinite(values).all(-1) & np.isfinite(u)
        covered = (
            good & (theta <= max(self.theta[-1], MEASURED_TO)) & (cosine > np.cos(MEASURED_TO))
        )
        return np.where(good[:, None], values, 0), covered

    def places(self) -> tuple[Floats, Floats, Floats]:
        """wi and wo (n, 3) of every number of the table, and its factor (n,)."""
        ny, nx = self.values.ny, self.values.nx
        u, v = np.tile(np.linspace(0, 1, nx), ny), np.repeat(np.linspace(0, 1, ny), nx)
        found = []
        for i, phi in enumerate(self.phi):
            for j, theta in enumerate(self.theta):
                x, y = self.vndf.sample(u, v, (i, j))
                wo = spherical(theta, phi)
                m = spherical(
                    0.5 * np.pi * x * x, np.pi * (2 * y - 1) + (phi if self.isotropic else 0)
                )
                wi = 2 * (m @ wo)[:, None] * m - wo
                wi /= np.linalg.norm(wi, axis=-1, keepdims=True)
                scale = self.scale(x, y, np.full(len(x), theta), np.full(len(x), phi))
                found.append((wi, np.broadcast_to(wo, wi.shape), scale))
        wi, wo, scale = (np.concatenate(part) for part in zip(*found, strict=True))
        return wi, wo, scale


def _square(theta: Any, phi: Any) -> tuple[Floats, Floats]:
    x = np.sqrt(np.maximum(np.asarray(theta), 0) * (2 / np.pi))
    return x, (np.asarray(phi) + np.pi) / (2 * np.pi)


def read(source: Source) -> list[Measurement]:
    """The reflection, at the directions of the file's numbers."""
    file = tensors(source)
    with np.errstate(over="ignore", invalid="ignore"):
        table = Table(file)
        wi, wo, scale = table.places()
        values = table.values.data.reshape(-1, table.channels)
        factor = scale / np.maximum(wi[:, 2], HORIZON)
        values = (values * factor[:, None].astype(np.float32)).astype(np.float32)
    description = file.fields.get("description")
    text = ""
    if description is not None and description.dtype.itemsize == 1:
        text = np.asarray(description).tobytes()[:2000].decode("utf-8", "replace").strip("\0 \n")
    channels: tuple[str, ...] = ("r", "g", "b")
    if table.spectral:
        channels = tuple(f"{w:g} nm" for w in table.wavelengths)
    found = measurement(
        NAME,
        source.title,
        wi,
        wo,
        values,
        channels=channels,
        wavelengths=table.wavelengths if table.spectral else None,
        isotropic=table.isotropic,
        extrapolated=np.maximum(angles(wi)[0], angles(wo)[0]) > MEASURED_TO,
        units="f cos(theta_i) over ndf / (4 sigma)" if table.scaled else "f cos(theta_i), in 1/sr",
        notes=("beyond 83° nothing was measured",),
        metadata={"description": text} if text else {},
        grid={
            "phi_o": len(table.phi),
            "theta_o": len(table.theta),
            "u": table.values.nx,
            "v": table.values.ny,
        },
        interpolator=table,
    )
    return [found]


# --- writing -------------------------------------------------------------------------------------


def write(
    path: str | Path,
    reflectance: Reflectance,
    *,
    thetas: int = THETAS,
    side: int = SIDE,
    phis: int = PHIS,
    **options: Any,
) -> list[str]:
    """Write a table that Mitsuba's `measured` plug-in reads, in its rgb variants (and spectral ones).

    The facets' distribution is taken from what is reflected back to where it came from: any smooth one
    would do, as it only decides where the places of the table lie.

    Args:
        path: the file.
        reflectance: what to write.
        thetas: angles of the viewer, crowded at grazing.
        side: places along each side of the square.
        phis: azimuths of the viewer, for what is anisotropic.
        options: of other formats.
    """
    isotropic = reflectance.isotropic
    theta = (0.5 * np.pi - 0.02) * np.linspace(0, 1, thetas) ** 0.8
    phi = np.zeros(1) if isotropic else np.linspace(-np.pi, np.pi, phis + 1)
    axis = np.linspace(0, 1, side)
    grid_x, grid_y = np.tile(axis, side), np.repeat(axis, side)
    m = spherical(0.5 * np.pi * grid_x**2, np.pi * (2 * grid_y - 1))
    ndf = _facets(reflectance, grid_x).reshape(side, side)
    sigma = _projected_area(ndf, m, m)
    # Density of m on the square: dm = 2 pi^2 u sin(theta_m) du dv
    area = (2 * np.pi**2 * grid_x * np.sin(0.5 * np.pi * grid_x**2)).reshape(side, side)
    channels = len(reflectance.channels)
    shape = (len(phi), len(theta))
    vndf = np.empty((*shape, side, side), np.float32)
    for i, p in enumerate(phi):
        for j, t in enumerate(theta):
            wo = spherical(t, p)
            turned = spherical(t, 0.0) if isotropic else wo
            seen = np.maximum(m @ turned, 0).reshape(side, side)
            # Not 0 anywhere, or what is there could not be looked up
            visible = np.maximum(ndf * seen * area, 0)
            vndf[i, j] = visible + 1e-4 * visible.mean()
    warp = Density(vndf, (phi, theta))
    values = np.empty((*shape, channels, side, side), np.float32)
    factors = Bilinear(ndf), Bilinear(sigma.reshape(side, side))
    for i, p in enumerate(phi):
        for j, t in enumerate(theta):
            x, y = warp.sample(grid_x, grid_y, (i, j))
            facet = spherical(0.5 * np.pi * x * x, np.pi * (2 * y - 1) + (p if isotropic else 0))
            wo = np.broadcast_to(spherical(t, p), facet.shape)
            wi = 2 * np.sum(facet * wo, -1, keepdims=True) * facet - wo
            f = np.where(wi[:, 2:] > 0, reflectance.evaluate(_unit(wi), wo), 0)
            scale = factors[0].eval(x, y) / (4 * factors[1].eval(*_square(np.full(1, t), p)))
            values[i, j] = (f * np.maximum(wi[:, 2:], 0) / scale[:, None]).T.reshape(
                channels, side, side
            )
    rgb, how = _rgb(values, reflectance.wavelengths)
    luminance = np.maximum(np.tensordot(rgb, (0.2126, 0.7152, 0.0722), (2, 0)), 0)
    # A table of zeros is no density
    luminance += 1e-4 * luminance.mean((-1, -2), keepdims=True) + 1e-12
    text = f"{reflectance.title} (written by gonio)".encode()[:1000]
    fields: dict[str, NDArray[Any]] = {
        "description": np.frombuffer(text, np.uint8),
        "jacobian": np.ones(1, np.uint8),
        "phi_i": phi.astype(np.float32),
        "theta_i": theta.astype(np.float32),
        "ndf": ndf.astype(np.float32),
        "sigma": sigma.reshape(side, side).astype(np.float32),
        "vndf": vndf,
        "luminance": luminance.astype(np.float32),
        "rgb": rgb.astype(np.float32),
    }
    if reflectance.wavelengths is not None:
        fields["wavelengths"] = reflectance.wavelengths.astype(np.float32)
        fields["spectra"] = values
    with replacing(path) as temporary:
        temporary.write_bytes(_pack(fields))
    return how


def _unit(w: Floats) -> Floats:
    return np.asarray(w / np.linalg.norm(w, axis=-1, keepdims=True))


def _facets(reflectance: Reflectance, x: Floats) -> Floats:
    """A density of facets from retroreflection, f(m, m) cos^2, the same at every azimuth."""
    theta = 0.5 * np.pi * np.unique(x) ** 2
    turns = [0.0] if reflectance.isotropic else [0.25 * np.pi * k for k in range(8)]
    back = np.zeros(len(theta))
    for turn in turns:
        m = spherical(np.minimum(theta, 0.5 * np.pi - 0.02), turn)
        back += np.maximum(reflectance.evaluate(m, m).mean(-1), 0) / len(turns)
    density = back * np.cos(np.minimum(theta, 0.5 * np.pi - 0.02)) ** 2
    density += 1e-3 * density.max() + 1e-9
    return np.asarray(np.interp(0.5 * np.pi * x**2, theta, density))


def _projected_area(ndf: Floats, m: Floats, w: Floats) -> Floats:
    """sigma: the integral of ndf max(0, m . w) over m, for each w (n,)."""
    side = len(ndf)
    axis = np.linspace(0, 1, side)
    # The trapezoid rule on the square; its measure is 2 pi^2 u sin(theta)
    ends = np.full(side, 1 / (side - 1))
    ends[[0, -1]] *= 0.5
    measure = 2 * np.pi**2 * axis * np.sin(0.5 * np.pi * axis**2)
    weight = (ndf * measure * ends).T.reshape(side, side).T * ends[:, None]
    return np.concatenate(
        [np.maximum(part @ m.T, 0) @ weight.reshape(-1) for part in np.array_split(w, side)]
    )


def _rgb(values: NDArray[Any], wavelengths: Floats | None) -> tuple[NDArray[Any], list[str]]:
    if wavelengths is None:
        return (values if values.shape[2] == 3 else np.repeat(values[:, :, :1], 3, 2)), []
    from gonio.measured.spectra import TOOL, rgb_matrix

    matrix = rgb_matrix(wavelengths)
    return np.moveaxis(np.tensordot(values, matrix, (2, 1)), -1, 2), [f"field rgb: {TOOL}"]


def _pack(fields: dict[str, NDArray[Any]]) -> bytes:
    heads, place = [], len(MAGIC) + 6
    place += sum(2 + len(name) + 11 + 8 * field.ndim for name, field in fields.items())
    bodies = []
    for name, field in fields.items():
        place += -place % 8
        kind = TYPES.index(field.dtype.str.replace("|", ""))
        heads.append(struct.pack("<H", len(name)) + name.encode())
        heads[-1] += struct.pack("<HBQ", field.ndim, kind, place)
        heads[-1] += struct.pack(f"<{field.ndim}Q", *field.shape)
        bodies.append((place, np.ascontiguousarray(field).tobytes()))
        place += field.nbytes
    content = bytearray(place)
    head = MAGIC + struct.pack("<BBI", 1, 0, len(fields)) + b"".join(heads)
    content[: len(head)] = head
    for start, body in bodies:
        content[start : start + len(body)] = body
    return bytes(content)
