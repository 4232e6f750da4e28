"""tri-Ace Oren–Nayar: fitted for game consoles, driven by Blinn–Phong's shininess.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012
course "Practical physically based shading in film and game production", Eq. 20 to 25.
The course gives the radiance f cos(theta_i); this is f. Where eq24 passes through zero on its way to a
negative value, float32 keeps an absolute accuracy of 1e-6 rho / pi, not a relative one.
"""

from typing import NamedTuple

from gonio.claims import UNBOUNDED, Claims, Place, at_most, dark_ring, kink
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, option, param
from gonio.parts import cltc
from gonio.parts.frame import tangential_dot
from gonio.parts.oren_nayar import (
    MEAN_G_FUJII,
    MEAN_G_QUALITATIVE,
    G_fujii,
    G_qualitative,
    s_over_max,
    s_over_t_fujii,
    s_over_t_qualitative,
)


class Coefficients(NamedTuple):
    """The two numbers of the qualitative model."""

    A: Float
    """A', of the constant term."""
    B: Float
    """B, of the term that depends on the azimuth."""


class TriAceOrenNayar(Model):
    """Rough diffuse that shares its roughness with a Blinn-Phong highlight. Reciprocal."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo of the facets, linear RGB")
    shininess: Float = param(10, 0, 1e6, "Blinn-Phong exponent n; sigma = sqrt(2 / n)")
    variant: str = option(
        "eq25",
        "eq24",
        "eq23",
        doc="eq23 is the qualitative model, eq24 without its max, eq25 softened for s < 0",
    )
    caveats = (
        "eq23 and eq25 reflect more than they receive at grazing angles for shininess > 19, at most "
        "1.0152 (eq23) and 1.0109 (eq25).",
        "eq24 is negative when light and viewer graze on opposite sides, without a lower bound: "
        "-98 per steradian at shininess 10 with both cosines 0.001.",
        "eq23 has QON's dark ring where cos(phi_i - phi_o) changes sign.",
    )
    unlike = (
        ("oren_nayar", "takes the angle sigma; this one the exponent of a Blinn–Phong highlight."),
    )
    claims = Claims(
        energy=(at_most(1.0152, variant="eq23"), at_most(1.0109, variant="eq25")),
        negative=at_most(UNBOUNDED, variant="eq24"),
        kinks=(
            kink(Place.EQUAL_COSINES),
            dark_ring(variant="eq23"),
            kink(Place.SIDE_LIGHT, variant="eq25"),
        ),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 23, 24 or 25 without the cosine: BRDF value in 1/sr."""
        A, B = self._coefficients()
        s = tangential_dot(wi, wo)
        if self.variant == "eq23":
            s_over_t = s_over_t_qualitative(s, wi, wo)
        elif self.variant == "eq24":
            s_over_t = s_over_max(s, wi, wo)
        else:
            s_over_t = s_over_t_fujii(s, wi, wo)
        return self.rho * (INV_PI * (A + B * s_over_t))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """EON's sampler, at the roughness with the same weight of s/t."""
        A, B = self._coefficients()
        wi = cltc.sample_cltc_matched(wo, B / A, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        A, B = self._coefficients()
        return cltc.pdf_cltc_matched(wi, wo, B / A)

    def albedo(self, wo: Vec3) -> Color:
        """rho (A + B G / pi); for eq24 the azimuth averages s to nothing and rho A remains."""
        A, B = self._coefficients()
        if self.variant == "eq23":
            return self.rho * (A + B * INV_PI * G_qualitative(wo.z))
        if self.variant == "eq24":
            return self.rho * A
        return self.rho * (A + B * INV_PI * G_fujii(wo.z))

    def mean_albedo(self) -> Color:
        """Hemispherical mean of `albedo`."""
        A, B = self._coefficients()
        if self.variant == "eq23":
            return self.rho * (A + B * MEAN_G_QUALITATIVE)
        if self.variant == "eq24":
            return self.rho * A
        return self.rho * (A + B * MEAN_G_FUJII)

    def _coefficients(self) -> Coefficients:
        """A' and B: QON's with sigma^2 = 2 / n, and 0.65 for 0.33 in A' since Eq. 24."""
        n = self.shininess
        B = 1 / (2.22222 + 0.1 * n)
        if self.variant == "eq23":
            return Coefficients(1 - 1 / (2 + 0.33 * n), B)
        return Coefficients(1 - 1 / (2 + 0.65 * n), B)
