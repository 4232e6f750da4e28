"""How many terms of a polynomial single precision can tell from all of them."""

from __future__ import annotations

from collections.abc import Sequence

# A quarter of the distance between numbers of single precision beside 1: the sum rounds off more.
TOLD = 2.0**-26


def terms_in_single(bound: float, coefficients: Sequence[float]) -> int:
    """How many of the first terms of c0 + c1 x + c2 x^2 + ... are enough for |x| up to `bound`; 2 at least.

    All of them where the value may be 0 there, as its digits have no size then.
    """
    sizes = [abs(c) * bound**k for k, c in enumerate(coefficients)]
    least = sizes[0] - sum(sizes[1:])
    for count in range(2, len(sizes)):
        if sum(sizes[count:]) <= TOLD * least:
            return count
    return len(sizes)
