"""The chi-square distribution, central and not, and with it the power of a test."""

from __future__ import annotations

import math


def chi2_tail(x: float, degrees: float) -> float:
    """Probability that a chi-square variable is larger than x: Q(degrees / 2, x / 2)."""
    a, x = degrees / 2, x / 2
    if x <= 0:
        return 1.0
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1:  # the series of the lower tail
        term = total = 1 / a
        n = a
        while abs(term) > 1e-17 * abs(total):
            n += 1
            term *= x / n
            total += term
        return 1 - front * total
    # Lentz's continued fraction of the upper one
    b = x + 1 - a
    c, d = 1e300, 1 / b
    h = d
    for i in range(1, 10000):
        an = -i * (i - a)
        b += 2
        d = 1 / (an * d + b)
        c = b + an / c
        h *= d * c
        if abs(d * c - 1) < 1e-15:
            break
    return front * h


def chi2_limit(probability: float, degrees: float) -> float:
    """The value that a chi-square variable exceeds with this probability."""
    low, high = 0.0, degrees + 10
    while chi2_tail(high, degrees) > probability:
        high *= 2
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if chi2_tail(middle, degrees) > probability else (low, middle)
    return high


def noncentral_tail(x: float, degrees: float, offset: float) -> float:
    """The same as `chi2_tail` for the noncentral distribution: a Poisson mixture of central ones."""
    mean = offset / 2
    if mean <= 0:
        return chi2_tail(x, degrees)
    reach = int(mean + 12 * math.sqrt(mean + 1) + 30)
    first = max(0, int(mean - 12 * math.sqrt(mean + 1) - 30))
    total = 0.0
    a, half = degrees / 2 + first, x / 2
    tail = chi2_tail(x, 2 * a)
    for j in range(first, reach):
        total += math.exp(j * math.log(mean) - mean - math.lgamma(j + 1)) * tail
        # Q(a + 1, x) = Q(a, x) + x^a exp(-x) / Gamma(a + 1); all terms are positive
        tail += math.exp(a * math.log(half) - half - math.lgamma(a + 1)) if half > 0 else 0.0
        a += 1
    return min(total, 1.0)


def power(samples: int, bins: int, error: float, alarm: float) -> float:
    """Probability that Pearson's test finds a density that is wrong by ±error in every bin.

    Args:
        samples: drawn.
        bins: all with the same probability.
        error: relative, such as 0.005.
        alarm: probability of a false alarm at which the test rejects.
    """
    return noncentral_tail(chi2_limit(alarm, bins), bins, samples * error * error)
