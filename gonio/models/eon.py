"""EON: energy-preserving Oren–Nayar rough diffuse reflection.

Source: Portsmouth, Kutz, Hill, "EON: A practical energy-preserving rough diffuse BRDF",
arXiv:2410.18026. Symbols and equation numbers are the paper's.
Deviations: every difference that the paper takes (1 - E_F, 1 - <E_F>, 1 + s) is rearranged so that
nothing cancels; the values are the same, but finite at the horizon and exact in float32.
Listing 1 keeps the loss 1 - E_F of its fit above 1e-7; the fit here does not and is -0.0016 at
grazing, so that values at cosines below 0.0015 differ by up to 4e-4 of themselves: the clamp would
put a kink there and gain nothing.
"""

from gonio.claims import Claims, Place, at_most, kink, white_furnace
from gonio.lang import (
    INV_PI,
    PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    safe_sqrt,
    twice_atan_over,
)
from gonio.model import Model, option, param
from gonio.models.fon import FON
from gonio.parts import cltc
from gonio.parts.hemisphere import pdf_cosine, pdf_uniform, sample_cosine, sample_uniform
from gonio.parts.oren_nayar import MEAN_G_FUJII, fujii_shape

C1 = 0.5 - 2 / (3 * PI)  # A_F = 1 / (1 + C1 r)
C2 = MEAN_G_FUJII  # the hemispherical mean of E_F is A_F (1 + C2 r)

# Eq. 14: G_F / pi as a polynomial in 1 - mu, error below 0.1 %.
G1, G2, G3, G4 = 0.0571085289, 0.491881867, -0.332181442, 0.0714429953
L0 = PI * (C1 - (G1 + G2 + G3 + G4))
L1 = PI * (G1 + 2 * G2 + 3 * G3 + 4 * G4)
L2 = -PI * (G2 + 3 * G3 + 6 * G4)
L3 = PI * (G3 + 4 * G4)
L4 = -PI * G4
MEAN_G_FITTED = G1 / 3 + G2 / 6 + G3 / 10 + G4 / 15  # its hemispherical mean: g_k 2 / ((k+1)(k+2))


def loss_exact(mu: Float) -> Float:
    """pi C1 - G_F at cosine mu, from 0 at grazing to pi C1 at the normal: 1 - E_F = r A_F loss / pi.

    With 1 - s = mu^2 / (1 + s) every term of Eq. 13 that cancels against C1 can be collected, which
    leaves a sum of positive terms.
    """
    # The angle is taken from s, not from mu: their rounding errors cancel at the normal
    s = safe_sqrt(1 - mu * mu)
    t = mu / (1 + s)  # tan(asin(mu) / 2)
    lost = mu * (PI / 2 - 2 / 3 - t * s * (1 / 3 * s + 2 / 3))
    return t * (lost + s * twice_atan_over(t))


def loss_fitted(mu: Float) -> Float:
    """The same from the fit of Eq. 14; within 0.0016 of `loss_exact`, and -0.0016 at grazing.

    Eq. 14 is a polynomial in 1 - mu; multiplied out in mu, its small value at grazing keeps its digits.
    """
    return L0 + mu * (L1 + mu * (L2 + mu * (L3 + mu * L4)))


class EON(Model):
    """Rough, clay-like diffuse. Reciprocal; white stays white; Lambert at roughness 0."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "single-scattering albedo, linear RGB")
    roughness: Float = param(0.5, 0, 1, "unitless r; not the Oren-Nayar angle sigma")
    albedo_form: str = option(
        "exact", "fitted", doc="E_F inside the BRDF: Eq. 13, or the faster fit of Eq. 14"
    )
    color_shift: str = option(
        "physical",
        "none",
        doc="multiple scattering saturates the colour, or rho only multiplies the white BRDF",
    )
    sampler: str = option(
        "cltc_matched",
        "cltc_uniform",
        "cltc",
        "ltc",
        "ltc_nonnegative",
        "uniform",
        "cosine",
        doc="how `sample` draws directions; cltc_uniform is the paper's choice, cltc_matched ours",
    )
    caveats = (
        "albedo_form='fitted' reflects up to 0.05 % more or less than it should (rho = 1).",
        "sampler='ltc' wastes the samples that fall below the horizon; 'cltc' has rare high weights.",
    )
    unlike = (
        ("fon", "is EON without the multiple scattering: it loses light."),
        (
            "oren_nayar",
            "is rough by an angle sigma; this one by r, which is none. `gonio convert` has both.",
        ),
    )
    claims = Claims(
        energy=at_most(1.00016, albedo_form="fitted"),
        wasted=at_most(0.0534, sampler="ltc"),
        unreached=at_most(0.01, sampler=("ltc", "cltc")),
        kinks=(kink(Place.SIDE_LIGHT), kink(Place.EQUAL_COSINES)),
        furnace=(
            white_furnace(within=1e-6, rho=1, albedo_form="exact"),
            white_furnace(within=5.5e-4, rho=1, albedo_form="fitted"),
        ),
        falls=("roughness",),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 16 and 19: BRDF value in 1/sr, without the cosine."""
        r = self.roughness
        A_F = 1 / (1 + C1 * r)
        single = INV_PI * A_F * fujii_shape(wi, wo, r)
        # (1 - E_i)(1 - E_o) / (1 - <E>) / pi, of which r^2 A_F^2 / (r A_F) remains
        white = INV_PI * INV_PI * INV_PI / (C1 - C2)
        multiple = white * (A_F * r) * self._loss(wi.z) * self._loss(wo.z)
        return self.rho * (single + self._shifted(multiple))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """By default CLTC with a uniform lobe that fades with the roughness.

        Its variance is never above that of cosine sampling, nor of the paper's cltc_uniform: at
        rho = 1, roughness 1 and viewers at 60, 85, 89 and 89.9 degrees cosine sampling has 11, 29,
        55 and 90 times as much. No weight is above 3.5; cltc_uniform keeps them below 1.52.
        """
        r = self.roughness
        if self.sampler == "cltc_matched":
            wi = cltc.sample_cltc_matched(wo, r, u)
        elif self.sampler == "cltc_uniform":
            wi = cltc.sample_cltc_uniform(wo, r, u)
        elif self.sampler == "cltc":
            wi = cltc.sample_cltc(wo, r, u)
        elif self.sampler == "ltc":
            wi = cltc.sample_ltc(wo, r, u)
        elif self.sampler == "ltc_nonnegative":
            wi = cltc.sample_ltc_nonnegative(wo, r, u)
        elif self.sampler == "uniform":
            wi = sample_uniform(u)
        else:
            wi = sample_cosine(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of the chosen sampler in 1/sr."""
        r = self.roughness
        if self.sampler == "cltc_matched":
            return cltc.pdf_cltc_matched(wi, wo, r)
        if self.sampler == "cltc_uniform":
            return cltc.pdf_cltc_uniform(wi, wo, r)
        if self.sampler == "cltc":
            return cltc.pdf_cltc(wi, wo, r)
        if self.sampler == "ltc":
            return cltc.pdf_ltc(wi, wo, r)
        if self.sampler == "ltc_nonnegative":
            return cltc.pdf_ltc_nonnegative(wi, wo, r)
        if self.sampler == "uniform":
            return pdf_uniform()
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        """rho E_F + rho_ms (1 - E_F), after Eq. 20: exactly 1 for rho = 1 and albedo_form='exact'.

        For 'fitted' this is the exact integral of the fitted BRDF.
        """
        r = self.roughness
        A_F = 1 / (1 + C1 * r)
        part = INV_PI * r * A_F
        single = 1 - part * loss_exact(wo.z)
        multiple = part * self._loss(wo.z) * self._mean_loss_ratio()
        return self.rho * (single + self._shifted(multiple))

    def mean_albedo(self) -> Color:
        """Hemispherical mean of `albedo`."""
        r = self.roughness
        A_F = 1 / (1 + C1 * r)
        single = A_F * (1 + C2 * r)
        ratio = self._mean_loss_ratio()
        multiple = r * A_F * (C1 - C2) * ratio * ratio
        return self.rho * (single + self._shifted(multiple))

    def single_scattering(self) -> Model:
        """What of it is scattered once: FON. The rest is Eq. 19."""
        return FON(rho=self.rho, roughness=self.roughness)

    def _loss(self, mu: Float) -> Float:
        if self.albedo_form == "exact":
            return loss_exact(mu)
        return loss_fitted(mu)

    def _mean_loss_ratio(self) -> float:
        """Hemispherical mean of `_loss` over that of `loss_exact`."""
        if self.albedo_form == "exact":
            return 1
        return (C1 - MEAN_G_FITTED) / (C1 - C2)

    def _shifted(self, multiple: Float) -> Color:
        """Multiple scattering in its colour, which is that of Eq. 19 over rho."""
        if self.color_shift == "none":
            return multiple
        r = self.roughness
        A_F = 1 / (1 + C1 * r)
        mean_loss = (C1 - C2) * (A_F * r)  # 1 - <E_F>
        return multiple * (1 - mean_loss) * self.rho / (1 - self.rho * mean_loss)
