"""What light from pictures asks of a model: its highlight and its diffuse part, apart.

A model with a highlight has three methods for it: `image_lobes`, `highlight`, from which a table of two
sums A and B is baked (`gonio.bake.split_sum`), and `highlight_albedo`, which turns these into what the
highlight reflects. gonio.lights reckons with them. With F = f0 (1 - w) + f90 w and Schlick's weight w at
the half vector, A is the share of f0 and B that of f90.

Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course "Physically based shading in theory
and practice": the two sums.
"""

from typing import NamedTuple, Protocol

from gonio.lang import Color, Float, Vec2, Vec3, clamp, maximum, power
from gonio.parts.fresnel import schlick_weight

# The integral of (1 - wo.H)^5 mu_i / pi over all wi, as a polynomial in the cosine of wo; fitted to
# quadrature, error below 1.3e-4.
LOST_0, LOST_1, LOST_2, LOST_3 = 0.02804434, -0.0773302, 0.07495867, -0.02571104

# The integrals of 2 mu (1 - mu)^5, of 2 mu^2 (1 - mu)^5 and of 2 mu^3 (1 - mu)^5 over mu in [0, 1].
W_0, W_1, W_2 = 1 / 21, 1 / 84, 1 / 252

# Smallest mean weight whose root is taken: of a cosine of 0.999.
WEIGHT_MIN = 1e-15


class ImageLobes(NamedTuple):
    """A model as light from a picture sees it."""

    alpha: Float
    """Width of the GGX facets whose highlight is as wide."""
    matte: Color
    """Albedo of all that is diffuse."""


class ImageSurface(NamedTuple):
    """The surface of a model whose depths no picture lights."""

    reflected: Color
    """What it mirrors."""
    alpha: Float
    """Width of its facets."""


class ImageCoat(NamedTuple):
    """A coat as light from a picture sees it."""

    reflected: Color
    """What it mirrors."""
    glossy: Color
    """What it lets in and out again of light that the base mirrors."""
    matte: Color
    """The same of light that the base reflects diffusely."""
    below: Vec3
    """The refracted view."""
    alpha_below: Float
    """Least width of the base's highlight."""
    cone: Float
    """Squared tangent of half the angle beyond which light from the base cannot leave."""


class Surfaced(Protocol):
    """A model whose surface alone mirrors a picture."""

    def image_surface(self, mu: Float) -> ImageSurface:
        """What it mirrors."""


class Glossy(Protocol):
    """A model with a highlight."""

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight without F, in 1/sr."""

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""


class CoatedGloss(Protocol):
    """A coat over a model with a highlight."""

    alpha: Float
    """Width of the coat's facets."""
    eta: Float
    """Its index."""
    base: Glossy
    """What lies below."""

    def image_coat(self, wo: Vec3) -> ImageCoat:
        """The coat as light from a picture sees it."""


def schlick_albedo(f0: Color, f90: Color, split: Vec2) -> Color:
    """Albedo of a highlight whose facets have Schlick's F; split: A and B of its table."""
    return f0 * split.x + f90 * split.y


def facet_cosine(split: Vec2) -> Float:
    """The cosine at which light meets the facets of a highlight, for any other F.

    B / (A + B) is the mean of (1 - wo.H)^5 over what facets reflect, and this is where it has this value.
    """
    weight = split.y / maximum(split.x + split.y, WEIGHT_MIN)
    return 1 - power(clamp(weight, WEIGHT_MIN, 1), 0.2)


def lost_at_facets(mu: Float) -> Float:
    """Mean of Schlick's weight at the half vector over a Lambertian's light from everywhere."""
    return LOST_0 + mu * (LOST_1 + mu * (LOST_2 + mu * LOST_3))


def left_by_facets(mu: Float) -> Float:
    """For a diffuse part that facets leave 1 - F: its albedo is (1 - f0) times this."""
    return 1 - lost_at_facets(mu)


def burley_albedo(mu: Float, roughness: Float) -> Float:
    """Directional albedo of Burley's diffuse term, exact, for white."""
    # f = (1 + rise W_i) (1 + rise W_o) / pi with W = (1 - mu)^5 and rise = k + r cos(wi, wo); the cosine's
    # mean over the azimuth is mu_i mu_o, its square's is (mu_i mu_o)^2 + (s_i s_o)^2 / 2.
    k = roughness - 0.5
    W_o = schlick_weight(mu)
    W_c = W_1 * mu * roughness
    W_cc = (W_2 * mu * mu + 0.5 * (W_0 - W_2) * (1 - mu * mu)) * roughness * roughness
    rise = k + 2 / 3 * roughness * mu
    return 1 + W_o * rise + (k * W_0 + W_c) + W_o * (k * k * W_0 + 2 * k * W_c + W_cc)


def scattered_albedo(mu: Float, roughness: Float) -> Float:
    """Directional albedo of Disney's subsurface term, fitted: error below 0.03, for white."""
    W = schlick_weight(mu)
    flat = 1.35661 + mu * (-2.945222 + mu * (2.783762 - 1.079847 * mu))
    rough = W * (0.729699 - 1.153954 * mu) + (1 - W) * (0.060934 - 0.053938 * mu)
    rougher = W * (0.113155 - 0.351441 * mu)
    return 0.625 + (1 - W) * flat + roughness * (rough + roughness * rougher)
