"""Sums and products with what their rounding leaves out, for differences of nearly equal terms.

Source: Ogita, Rump, Oishi, "Accurate sum and dot product", SIAM Journal on Scientific Computing 2005.
Where a compiler rearranges sums as if they were exact, what was left out is 0 and nothing is gained.
"""

from gonio.lang import Float, Vec2, fma, vec2


def two_sum(a: Float, b: Float) -> Vec2:
    """a + b as it is rounded, and what is missing to a + b; both together are exact (Knuth's TwoSum)."""
    rounded = a + b
    of_b = rounded - a
    return vec2(rounded, (a - (rounded - of_b)) + (b - of_b))


def two_product(a: Float, b: Float) -> Vec2:
    """a b as it is rounded, and what is missing to a b; both together are exact."""
    rounded = a * b
    return vec2(rounded, fma(a, b, -rounded))
