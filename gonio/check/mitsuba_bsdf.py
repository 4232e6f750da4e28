"""Any Mitsuba BSDF as a subject of the checks: Mitsuba's own plug-ins, and those of others.

Its reflection is checked in Mitsuba's default context, as an integrator uses it, and on both sides where
both reflect. Samples of mirrors (delta lobes are no functions) and transmitted ones count as samples
without a direction, and so do their parts of the probability; the energy of all parts together is what
their weights say. Textures are looked at all over: uv are free parameters then. Mitsuba has the directions
the other way round and multiplies by the cosine; this file undoes both. It computes in single precision,
which the checks allow for.
"""

from __future__ import annotations

import json
import math
import re
import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

import drjit as dr
import numpy as np

from gonio import backend
from gonio.check.subject import (
    Array,
    Case,
    FreeNumber,
    Remark,
    Size,
    compute,
    even,
    stored,
    vectors,
)
from gonio.claims import Claims, Kink, WhiteFurnace
from gonio.fields import Parameter
from gonio.model import models

# Hair's plug-ins are called so.
FIBRES = "hair"

# Places at which is looked for a texture, and what roundings change there.
PLACES, SAME = 256, 1e-5

# The coordinates of a place in a texture.
UV = ("u", "v")

# Name of the report on what is left out of the checks.
SCOPE = "scope"

# Sides of a surface, by the factor of z: what is behind it is mirrored to the front.
SIDES = {"front": 1.0, "back": -1.0}

# Divides f cos(theta_i); far below any cosine that float32 directions of the search have.
COSINE_MIN = 1e-30


class MitsubaSubject:
    """A Mitsuba BSDF with the parameters it was given."""

    claims = Claims()
    claiming = False
    isotropic = False  # not known beforehand
    whole = False
    float32 = True
    differentiable = False
    albedos = ""
    mean_closed = False

    def __init__(
        self,
        mi: Any,
        name: str,
        bsdf: Any,
        side: str,
        both: bool,
        description: str = "",
        place: tuple[float, float] | None = None,
    ) -> None:
        """Look at one side of a BSDF; `sides_of` loads it.

        Args:
            mi: Mitsuba, with a variant.
            name: what it is called.
            bsdf: what it is.
            side: one of SIDES.
            both: whether the other side is looked at too.
            description: how it is called on the command line, if not by its name.
            place: uv, where only that place of its textures is looked at.
        """
        self.mi, self.name, self.bsdf, self.side = mi, name, bsdf, SIDES[side]
        self.description, self.place = description or name, place
        self.chosen: Mapping[str, str] = {"side": side}
        self.both = both
        self.varied = frozenset({"side"} if both and side == "back" else ())
        flags = int(self.bsdf.flags())
        transmission = int(mi.BSDFFlags.DiffuseTransmission) | int(mi.BSDFFlags.GlossyTransmission)
        self.transmits = bool(flags & transmission)
        self.left_out: Sequence[str] = [
            word
            for word, bits in (
                ("delta lobes", int(mi.BSDFFlags.Delta)),
                ("transmission", transmission),
            )
            if flags & bits
        ]
        self.context = mi.BSDFContext()
        self.parameters: tuple[FreeNumber, ...] = ()
        # SpatiallyVarying is not set by every plug-in whose children are textures
        try:
            varies = flags & int(mi.BSDFFlags.SpatiallyVarying) or self._varies()
        except RuntimeError as error:
            raise self.fault(error) from error
        self.varies = bool(varies)
        self.textured = self.varies and place is None
        if self.textured:
            self.parameters = tuple(
                FreeNumber(name, 0, Parameter(0.5, 0, 1, name), ()) for name in UV
            )

    def _varies(self) -> bool:
        """Whether value or density change with uv, at one pair of directions."""
        places = even(PLACES)
        module = compute()
        bound = _Bound(self, module.Float, [stored(module.Float, c) for c in places.T])
        up = np.tile([[0.48, 0.36, 0.8]], (PLACES, 1))
        w = vectors(module.Float, up)
        f, pdf = bound.eval(w, w), bound.pdf(w, w)
        columns = [np.broadcast_to(c.numpy(), PLACES) for c in (*f, pdf)]
        return any(np.ptp(c) > SAME * np.abs(c).max() for c in columns)

    def prepare(self) -> None:
        """It has been loaded; that is all."""

    def fault(self, error: Exception) -> Exception:
        """What Mitsuba cannot do, with the plug-in's name."""
        if isinstance(error, RuntimeError):
            from gonio.mitsuba.xml_files import reason

            return ValueError(f"Mitsuba cannot evaluate {self.name!r}: {reason(error)}.")
        return error

    def at(self, parameters: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """The BSDF with gonio's conventions, for Dr.Jit arrays of any precision."""
        if not self.parameters:
            return _Bound(self, Float, self.place)
        uv = [dr.gather(Float, stored(Float, c), index) for c in np.asarray(parameters).T]
        return _Bound(self, Float, uv)

    def bound(self, values: Mapping[str, Any], Float: Any) -> Any:
        """The BSDF at uv that are Dr.Jit values."""
        return _Bound(self, Float, [values[x] for x in UV] if self.parameters else self.place)

    def values(self, parameters: Array, rounded: bool = False) -> dict[str, Array]:
        """The coordinates uv, if there are textures."""
        return {f.path: np.asarray(parameters)[:, n] for n, f in enumerate(self.parameters)}

    def default(self) -> Array:
        """The middle of the textures."""
        return np.full(len(self.parameters), 0.5)

    def tag(self) -> str:
        """The side, where both are looked at."""
        return f"side={self.chosen['side']}" if self.both else ""

    def with_options(self, choice: Mapping[str, str]) -> MitsubaSubject:
        """No options."""
        return self

    def size(self, promise: str) -> Size | None:
        """Nothing is documented."""
        return None

    def kinks(self) -> list[tuple[Kink, bool]]:
        """Nothing is documented."""
        return []

    def furnaces(self) -> list[WhiteFurnace]:
        """Nothing is claimed."""
        return []

    def replay(
        self,
        parameters: Array,
        wi: Array,
        wo: Array,
        *,
        double: bool = True,
        u: Array | None = None,
        compare: str = "",
        derivatives: bool = False,
    ) -> str:
        """The `gonio eval` line; it computes in single precision, and has no derivatives."""
        wi, wo = (np.asarray(w) * (1, 1, self.side) for w in (wi, wo))
        given = [("wo", wo), ("wi", wi)] if u is None else [("wo", wo), ("u", u)]
        words = " ".join(
            f"--{name} {' '.join(repr(float(x)) for x in numbers)}" for name, numbers in given
        )
        beside = f" --compare {compare}" if compare else ""
        return f"gonio eval {self._named(parameters)} {words}{beside}"

    def recheck(self, check: str, case: Case | None = None, free: Collection[str] = ()) -> str:
        """The `gonio check` line of one check at one place of its textures, or all over them."""
        return f"gonio check {self._named(None if case is None else case[0])} --only {check}"

    def _named(self, parameters: Array | None) -> str:
        here = () if parameters is None or not self.parameters else tuple(parameters)
        place = self.place or here
        words = [f"--param {name}={float(x)!r}" for name, x in zip(UV, place, strict=False)]
        return " ".join([f"--mitsuba {shlex.quote(self.description)}", *words])

    def notes(self) -> list[Remark]:
        """What was left out of the checks."""
        if not self.left_out:
            return []
        text = f"not checked: {' and '.join(self.left_out)}, but for their energy"
        return [Remark(SCOPE, "left out", text)]


class _Bound:
    """eval, sample and pdf of a Mitsuba BSDF as gonio's models have them."""

    def __init__(self, subject: MitsubaSubject, Float: Any, uv: Sequence[Any] | None) -> None:
        self.subject, self.Float, self.uv = subject, Float, uv

    def _interaction(self, wo: Any) -> Any:
        mi = self.subject.mi
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wo))
        si.wi = self._in(wo)
        # A flat piece of surface, one unit long for one of uv: its derivatives are those of the frame
        x, y, z = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Normal3f(0, 0, 1)
        si.n, si.sh_frame = z, mi.Frame3f(x, y, mi.Vector3f(z))
        si.dp_du, si.dp_dv = x, y
        si.uv = mi.Point2f(0.5) if self.uv is None else mi.Point2f(*map(mi.Float, self.uv))
        si.p = mi.Point3f(si.uv.x, si.uv.y, 0)
        si.t = 1.0
        return si

    def _in(self, w: Any) -> Any:
        mi = self.subject.mi
        return mi.Vector3f(mi.Float(w.x), mi.Float(w.y), self.subject.side * mi.Float(w.z))

    def _out(self, value: Any) -> Any:
        Vec = dr.replace_shape_t(self.Float, (3, -1))
        return Vec(*(self.Float(dr.detach(c)) for c in value))

    def _direction(self, value: Any) -> Any:
        w = self._out(value)
        return type(w)(w.x, w.y, self.subject.side * w.z)

    def eval(self, wi: Any, wo: Any) -> Any:
        """BRDF without the cosine."""
        above = (wi.z > 0) & (wo.z > 0)
        value = self.subject.bsdf.eval(self.subject.context, self._interaction(wo), self._in(wi))
        return dr.select(above, self._out(value) / dr.maximum(wi.z, COSINE_MIN), 0)

    def pdf(self, wi: Any, wo: Any) -> Any:
        """Density in 1/sr."""
        value = self.subject.bsdf.pdf(self.subject.context, self._interaction(wo), self._in(wi))
        return dr.select((wi.z > 0) & (wo.z > 0), self.Float(dr.detach(value)), 0)

    def sample(self, wo: Any, u: Any) -> tuple[Any, Any]:
        """Direction and density. The third random number is made of the last digits of the first."""
        mi = self.subject.mi
        third = self.Float(u.x) * 2.0**24
        bs, weight = self._sample(self.subject.context, wo, third - dr.floor(third), u)
        pdf = self.Float(dr.detach(bs.pdf))
        wi = self._direction(bs.wo)
        # principledthin has transmitted samples that go up, with a weight of 0
        others = int(mi.BSDFFlags.Delta) | int(mi.BSDFFlags.Transmission)
        left_out = (bs.sampled_type & mi.UInt32(others)) != 0
        # Mitsuba marks what is of no use by a weight of 0 as well: a bump map, what is above the horizon
        # but below its own. What is transmitted is not judged
        nothing = dr.max(self._out(weight)) == 0
        below = (wi.z <= 0) & (self.subject.transmits | nothing)
        useless = below | (nothing & (self.pdf(wi, wo) == 0))
        weighed = (pdf > 0) | (dr.isnan(pdf) & ~type(wo.z > 0)(nothing))
        used = weighed & (wo.z > 0) & ~useless & ~type(wo.z > 0)(left_out)
        up = type(wi)(0, 0, 1)
        return dr.select(used, wi, up), dr.select(used, pdf, 0)

    def weight(self, wo: Any, choice: Any, u: Any) -> Any:
        """The part of the energy that a sample carries on, also of a mirror and of what is transmitted."""
        mi = self.subject.mi
        # Radiance is denser inside glass, by the square of the index; energy is not
        context = mi.BSDFContext(mi.TransportMode.Importance)
        _, weight = self._sample(context, wo, choice, u)
        return dr.select(wo.z > 0, self._out(weight), 0)

    def _sample(self, context: Any, wo: Any, choice: Any, u: Any) -> Any:
        mi = self.subject.mi
        # Rounded to float32 they may be 1
        most = dr.one_minus_epsilon(mi.Float)
        numbers = mi.Point2f(dr.minimum(mi.Point2f(mi.Float(u.x), mi.Float(u.y)), most))
        choice = dr.minimum(mi.Float(choice), most)
        return self.subject.bsdf.sample(context, self._interaction(wo), choice, numbers)


def sides_of(description: str, params: Iterable[str] = ()) -> list[MitsubaSubject]:
    """Load a BSDF; a subject for each side that reflects, the front first.

    Args:
        description: a plug-in's name, a dict as JSON, XML, or a file with one of the two.
        params: "u=0.3" and "v=0.7", to look at one place of its textures only.

    Raises:
        ValueError: it cannot be loaded, or it is no BSDF with a reflection that is a function.
    """
    place = _place(list(params))
    import mitsuba as mi

    import gonio.mitsuba  # noqa: F401  (finds a usable LLVM before Mitsuba loads one)

    if mi.variant() is None or "rgb" not in mi.variant() or mi.variant().startswith("scalar"):
        mi.set_variant(backend.mitsuba_variant("rgb"))
    name, bsdf = _load(mi, description)
    if FIBRES in bsdf.class_name().lower():
        raise ValueError(
            f"{name} scatters light around fibres, over the whole sphere; gonio check knows surfaces only."
        )
    flags = mi.BSDFFlags
    reflection = int(flags.DiffuseReflection) | int(flags.GlossyReflection)
    parts = [int(bsdf.flags(n)) for n in range(bsdf.component_count())]
    reflecting = [part for part in parts or [int(bsdf.flags())] if part & reflection]
    if not reflecting:
        raise ValueError(
            f"{name} reflects nothing that is a function; mirrors and transmission are left out."
        )
    back = any(part & int(flags.BackSide) for part in reflecting)
    # Plug-ins that set neither flag are asked on the front
    front = not back or any(part & int(flags.FrontSide) for part in reflecting)
    both = front and back
    sides = [side for side, looked_at in (("front", front), ("back", back)) if looked_at]
    found = [MitsubaSubject(mi, name, bsdf, side, both, description, place) for side in sides]
    if place is not None and not any(subject.varies for subject in found):
        raise ValueError(
            f"{name} has no texture, and is the same at every u and v; leave --param out, or give a BSDF "
            "with a texture as XML or JSON."
        )
    return found


def _place(params: list[str]) -> tuple[float, float] | None:
    """Uv, in the middle where one of both is not given; None where none is."""
    if not params:
        return None
    given = dict(zip(UV, (0.5, 0.5), strict=True))
    for text in params:
        name, _, number = text.partition("=")
        try:
            given[name.strip()] = float(number)
        except ValueError:
            given[name.strip()] = math.nan
        if name.strip() not in UV or not math.isfinite(given[name.strip()]):
            raise ValueError(
                f"--param {text} is no place in a texture: of a Mitsuba BSDF write u=0.3 and v=0.7; what "
                "else it has stands in its XML or JSON."
            )
    return given["u"], given["v"]


def _load(mi: Any, description: str) -> tuple[str, Any]:
    with ExitStack() as stack:
        return _loaded(mi, description, stack)


def _of_gonio(text: str) -> str:
    """What to write where a plug-in is named as gonio's models are."""
    name, _, values = text.partition(":")
    if name in models():
        return f"; {name} is a model of gonio's, and goes without --mitsuba"
    if values and name.isidentifier():
        return f'; parameters stand in JSON: \'{{"type": "{name}", ...}}\''
    return ""


def _loaded(mi: Any, description: str, stack: ExitStack) -> tuple[str, Any]:
    """Name and BSDF; the files that it names are looked for beside its own."""
    from gonio.mitsuba.xml_files import files_from, in_utf8, reason

    text = description.strip()
    name, folder = text, Path()
    if text.endswith((".xml", ".json")):
        path = Path(text)
        if not path.is_file():
            raise ValueError(f"there is no file {path}; give a BSDF as XML or JSON.")
        name, folder = path.stem, stack.enter_context(in_utf8(path)).parent
        text = path.read_text(encoding="utf-8-sig").strip()
    try:
        if text.startswith("{"):
            node = cast(dict[str, Any], json.loads(text))
            name = str(node.get("type", name)) if name == description.strip() else name
            with files_from(folder):
                found = mi.load_dict(node)
        elif text.startswith("<"):
            text = re.sub(r"^<\?xml[^>]*\?>\s*", "", text)
            if match := re.match(r"<bsdf\b(?![^>]*\bversion=)", text):
                text = f'<bsdf version="3.0.0"{text[match.end() :]}'
            kind = re.search(r'type="([^"]+)"', text)
            name = kind[1] if kind and name == description.strip() else name
            with files_from(folder):
                found = mi.load_string(text)
        else:
            found = mi.load_dict({"type": text})
    except (RuntimeError, ValueError, TypeError) as error:
        advice = _of_gonio(text)
        raise ValueError(
            f"Mitsuba cannot load {name!r} as a BSDF: {reason(error)}{advice}"
        ) from None
    if not isinstance(found, mi.BSDF):
        raise ValueError(f"{name!r} is no BSDF but a {type(found).__name__}.")
    return name, found
