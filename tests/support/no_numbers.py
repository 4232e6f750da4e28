"""Models with one planted value that is no number, each in another method or derivative."""

from __future__ import annotations

from pathlib import Path

TEXT = '''"""Lambert under a veil, with one value that is no number."""

from gonio.claims import Claims
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, maximum, select, sqrt, vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Planted(Model):
    """Lambert under a veil that is brighter towards the normal."""

    claims = Claims(falls=("veil",))

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.6, "colour")
    veil: Float = param(0.3, 0, 1, "part of the veil")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi (1 - veil + veil 9/8 mu_i mu_o)."""
        x = self.rho * ((1 - self.veil + 1.125 * self.veil * wi.z * wo.z) * INV_PI)
        return {eval}

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        w = sample_cosine(u)
        x = pdf_cosine(w)
        return Sample(vec3({x_of_wi}, w.y, w.z), {reported})

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        x = pdf_cosine(wi)
        return {pdf}

    def albedo(self, wo: Vec3) -> Color:
        """The integral of mu_i^2 is 2 pi / 3."""
        x = self.rho * (1 - self.veil + 0.75 * self.veil * wo.z)
        return {albedo}

    def mean_albedo(self) -> Color:
        """The mean of mu_o is 2 / 3."""
        x = self.rho * (1 - 0.5 * self.veil)
        return {mean}
'''

SOUND = dict.fromkeys(("eval", "reported", "pdf", "albedo", "mean"), "x") | {"x_of_wi": "w.x"}

# At some azimuths of wo only, and in a part of the veil's range: 0 / 0, and 1 / 0.
NAN, INFINITE = (f"{over} / (self.veil - self.veil)" for over in ("(self.veil - self.veil)", "1"))
AZIMUTH, VEIL = "wo.x > 0.3", "self.veil > 0.6"
ROOT = "1e-12 * sqrt(maximum(self.veil - 0.3, 0))"


def _where(place: str, value: str) -> str:
    return f"x + select({place}, {value}, 0)"


# What is planted, and the checks that have to tell it, beside `finite`.
PLANTED: dict[str, tuple[dict[str, str], set[str]]] = {
    "eval_nan": (
        {"eval": _where(AZIMUTH, NAN)},
        {"energy", "reciprocity", "gradient", "sampling", "albedo", "isotropy", "monotonicity"},
    ),
    # No sample meets it
    "eval_nan_in_a_plane": (
        {"eval": _where("wi.x * wo.y == wi.y * wo.x", NAN)},
        {"energy", "reciprocity", "gradient", "sampling", "albedo", "isotropy"},
    ),
    "eval_infinite": (
        {"eval": _where(VEIL, INFINITE)},
        {"energy", "reciprocity", "gradient", "sampling", "albedo", "isotropy", "monotonicity"},
    ),
    "pdf_nan": ({"pdf": _where(AZIMUTH, NAN)}, {"gradient", "sampling", "isotropy"}),
    "pdf_infinite": ({"pdf": _where(VEIL, INFINITE)}, {"gradient", "sampling", "isotropy"}),
    "wi_nan": ({"x_of_wi": _where(AZIMUTH, NAN).replace("x +", "w.x +")}, {"gradient", "sampling"}),
    "reported_nan": ({"reported": _where(AZIMUTH, NAN)}, {"gradient", "sampling"}),
    "reported_infinite": ({"reported": _where(AZIMUTH, INFINITE)}, {"gradient", "sampling"}),
    "albedo_nan": ({"albedo": _where(AZIMUTH, NAN)}, {"gradient", "albedo", "isotropy"}),
    "albedo_infinite": ({"albedo": _where(VEIL, INFINITE)}, {"gradient", "albedo", "isotropy"}),
    "mean_nan": ({"mean": _where(VEIL, NAN)}, {"gradient", "albedo"}),
    # Finite themselves, with derivatives that are not; at the default of the veil, too
    "derivative_nan": ({"eval": f"x + {ROOT}"}, {"gradient"}),
    "derivative_of_pdf_nan": ({"pdf": f"x + {ROOT}"}, {"gradient"}),
    "derivative_of_albedo_nan": ({"albedo": f"x + {ROOT}"}, {"gradient"}),
}


def written(folder: Path, name: str) -> Path:
    """The file of a planted model."""
    path = folder / f"{name}.py"
    path.write_text(TEXT.format(**SOUND | PLANTED[name][0]), encoding="utf-8")
    return path
