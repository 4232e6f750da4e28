"""Any Mitsuba BSDF as a subject of the checks: Mitsuba's own plug-ins, and those of others.

Its reflection is checked, without mirrors (delta lobes are no functions) and without transmission. Mitsuba
has the directions the other way round and multiplies by the cosine; this file undoes both. It computes in
single precision, which the checks allow for.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import drjit as dr
import numpy as np

from gonio import backend
from gonio.check.report import NOTE, Finding, Report
from gonio.check.subject import Array, Column
from gonio.claims import Claims

# Divides f cos(theta_i); far below any cosine that float32 directions of the search have.
COSINE_MIN = 1e-30


class MitsubaSubject:
    """A Mitsuba BSDF with the parameters it was given."""

    columns: tuple[Column, ...] = ()
    claims = Claims()
    chosen: Mapping[str, str] = {}
    isotropic = False  # not known beforehand
    whole = False
    float32 = True

    def __init__(self, description: str) -> None:
        """Load a BSDF.

        Args:
            description: a plug-in's name, a dict as JSON, XML, or a file with one of the two.

        Raises:
            ValueError: it cannot be loaded, or it is no BSDF with a reflection that is a function.
        """
        import mitsuba as mi

        import gonio.mitsuba  # noqa: F401  (finds a usable LLVM before Mitsuba loads one)

        if mi.variant() is None or "rgb" not in mi.variant() or mi.variant().startswith("scalar"):
            mi.set_variant(backend.mitsuba_variant("rgb"))
        self.name, self.bsdf = _load(mi, description)
        self.mi = mi
        flags = self.bsdf.flags()
        reflection = int(mi.BSDFFlags.DiffuseReflection) | int(mi.BSDFFlags.GlossyReflection)
        if not int(flags) & reflection:
            raise ValueError(
                f"{self.name} reflects nothing that is a function; mirrors and transmission are left out."
            )
        self.left_out = [
            word
            for word, bits in (
                ("delta lobes", mi.BSDFFlags.Delta),
                (
                    "transmission",
                    int(mi.BSDFFlags.DiffuseTransmission) | int(mi.BSDFFlags.GlossyTransmission),
                ),
            )
            if int(flags) & int(bits)
        ]
        self.context = mi.BSDFContext()
        self.context.type_mask = reflection

    def at(self, places: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """The BSDF with gonio's conventions, for Dr.Jit arrays of any precision."""
        return _Bound(self, Float)

    def default(self) -> Array:
        """No parameters."""
        return np.zeros(0)

    def tag(self) -> str:
        """No options."""
        return ""

    def replay(self, places: Array, wi: Array, wo: Array) -> str:
        """The directions, in Mitsuba's terms."""
        viewer, light = (", ".join(f"{x:.9g}" for x in w) for w in (wo, wi))
        return f"si.wi = ({viewer}), wo = ({light})"

    def notes(self) -> list[Report]:
        """What was left out of the checks."""
        if not self.left_out:
            return []
        text = f"not checked: {' and '.join(self.left_out)}"
        return [Report("scope", self.name, (Finding("left out", float("nan"), NOTE, text),))]


class _Bound:
    """eval, sample and pdf of a Mitsuba BSDF as gonio's models have them."""

    def __init__(self, subject: MitsubaSubject, Float: Any) -> None:
        self.subject, self.Float = subject, Float

    def _interaction(self, wo: Any) -> Any:
        mi = self.subject.mi
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wo))
        si.wi = self._in(wo)
        si.n = mi.Normal3f(0, 0, 1)
        si.sh_frame = mi.Frame3f(si.n)
        si.uv = mi.Point2f(0.5)
        si.t = 1.0
        return si

    def _in(self, w: Any) -> Any:
        mi = self.subject.mi
        return mi.Vector3f(mi.Float(w.x), mi.Float(w.y), mi.Float(w.z))

    def _out(self, value: Any) -> Any:
        Vec = dr.replace_shape_t(self.Float, (3, -1))
        return Vec(*(self.Float(dr.detach(c)) for c in value))

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
        third = third - dr.floor(third)
        numbers = mi.Point2f(mi.Float(u.x), mi.Float(u.y))
        # Rounded to float32 they may be 1
        numbers = mi.Point2f(dr.minimum(numbers, dr.one_minus_epsilon(mi.Float)))
        choice = dr.minimum(mi.Float(third), dr.one_minus_epsilon(mi.Float))
        bs, weight = self.subject.bsdf.sample(
            self.subject.context, self._interaction(wo), choice, numbers
        )
        pdf = self.Float(dr.detach(bs.pdf))
        wi = self._out(bs.wo)
        # Mitsuba marks what is of no use by a weight of 0 as well
        wasted = (wi.z <= 0) & (dr.max(self._out(weight)) == 0)
        used = (pdf > 0) & (wo.z > 0) & ~wasted
        up = type(wi)(0, 0, 1)
        return dr.select(used, wi, up), dr.select(used, pdf, 0)


def _load(mi: Any, description: str) -> tuple[str, Any]:
    """Name and BSDF; the files that it names are looked for beside its own."""
    from gonio.mitsuba.xml_files import files_from, reason

    text = description.strip()
    name, folder = text, Path()
    if text.endswith((".xml", ".json")):
        path = Path(text)
        if not path.is_file():
            raise ValueError(f"there is no file {path}; give a BSDF as XML or JSON.")
        name, folder = path.stem, path.parent
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
        raise ValueError(f"Mitsuba cannot load {name!r} as a BSDF: {reason(error)}") from None
    if not isinstance(found, mi.BSDF):
        raise ValueError(f"{name!r} is no BSDF but a {type(found).__name__}.")
    return name, found
