"""What the Oren–Nayar family shares: s/t of its azimuthal term s, and the albedo integrals of it.

Numbers of equations are those of Portsmouth, Kutz, Hill, "EON", arXiv:2410.18026.
"""

from gonio.lang import PI, Float, Vec3, maximum, safe_acos, safe_sqrt, select
from gonio.parts.frame import tangential_dot


def s_over_max(s: Float, wi: Vec3, wo: Vec3) -> Float:
    """s / max(mu_i, mu_o)."""
    return s / maximum(wi.z, wo.z)


def s_over_t_qualitative(s: Float, wi: Vec3, wo: Vec3) -> Float:
    """s / t of Eq. 4: nothing for s <= 0."""
    return select(s > 0, s_over_max(s, wi, wo), 0)


def s_over_t_fujii(s: Float, wi: Vec3, wo: Vec3) -> Float:
    """s / t of Eq. 11: s itself for s <= 0."""
    return select(s > 0, s_over_max(s, wi, wo), s)


def fujii_shape(wi: Vec3, wo: Vec3, r: Float) -> Float:
    """1 + r s/t with Eq. 11: the angular shape of FON and of EON's single scattering."""
    s = tangential_dot(wi, wo)
    # 1 + s = (|t_i + t_o|^2 + mu_i^2 + mu_o^2) / 2 with the tangential parts t: nothing cancels when
    # wi is the mirror direction of a grazing wo, where 1 + s goes to 0.
    x, y = wi.x + wo.x, wi.y + wo.y
    one_plus_s = 0.5 * (x * x + y * y + wi.z * wi.z + wo.z * wo.z)
    return (1 - r) + r * select(s > 0, 1 + s_over_max(s, wi, wo), one_plus_s)


def G_qualitative(mu: Float) -> Float:
    """Eq. 8: the integral of s/t (Eq. 4) times the cosine, at a cosine mu in [0, 1]; pi/2 at mu = 0."""
    s = safe_sqrt((1 - mu) * (1 + mu))
    # The paper has tan(theta) (1 - s^3); with 1 - s = mu^2 / (1 + s) the division by mu cancels.
    return s * (safe_acos(mu) - s * mu) + 2 / 3 * s * mu * (1 + s + s * s) / (1 + s)


def G_fujii(mu: Float) -> Float:
    """Eq. 13: the same for s/t of Eq. 11."""
    return G_qualitative(mu) - 2 / 3 * safe_sqrt((1 - mu) * (1 + mu))


# Hemispherical means of G / pi: Eq. 9 and Eq. 15.
MEAN_G_QUALITATIVE = 2 / 3 - 64 / (45 * PI)
MEAN_G_FUJII = 2 / 3 - 28 / (15 * PI)


def qualitative_coefficients(sigma: Float, offset: float) -> tuple[Float, Float]:
    """A and B of Eq. 3. sigma: angle in radians; offset: 0.33, or 0.57 for the footnote's variant."""
    s2 = sigma * sigma
    A = 1 - 0.5 * s2 / (s2 + offset)
    B = 0.45 * s2 / (s2 + 0.09)
    return A, B
