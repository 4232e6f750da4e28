"""Bounded least squares from several starts, with what is linear solved inside.

Variable projection: Golub, Pereyra, "The differentiation of pseudo-inverses and nonlinear least squares
problems whose variables separate", SIAM J. Numer. Anal. 10(2), 1973, with the Jacobian of Kaufman, "A
variable projection method for solving separable nonlinear least squares problems", BIT 15, 1975. The
metric bends what is linear, so that the inner problem takes a few steps of Gauss and Newton.

`scipy.optimize.least_squares` uses the residuals r and their Jacobian J by JᵀJ, Jᵀr and |r| alone. It gets
a root of the matrix of all products of [J r] in their place, which has the same, and as few rows as there
are numbers: its singular values cost nothing then, and memory has a bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gonio.fit.metrics import Metric
from gonio.fit.problem import Floats, Problem
from gonio.fit.structure import Structure

# Steps of one descent; most need 10 to 30. Of the inner problem; most need 2 to 5.
STEPS, INNER = 60, 12

# Descents begin strictly inside the bounds, by this part of a range.
INSIDE = 1e-3

# Relative changes of the sum and of the numbers at which a descent ends.
TOLERANCE = 1e-8

# More directions than this are fitted last: the descents from all starts see a part of them.
FEW = 10_000

# Places that are tried for each start but the first, at so many directions.
TRIED, SEEN = 8, 600

# What linear values and the model's own may differ by, relative to the largest, before the fit gives up
# on their being linear.
AGREEMENT = 1e-7

Progress = Callable[[int, int], None]


class NotLinearError(Exception):
    """What seemed to be linear is not everywhere."""


@dataclass(frozen=True)
class Found:
    """The end of a descent."""

    cost: float
    """Half the sum of squares."""
    number: int
    x: Floats


class Reduced:
    """A problem in the numbers that are not linear; the others are where they are best."""

    def __init__(self, problem: Problem, metric: Metric, structure: Structure, x: Floats) -> None:
        """Take a problem, and values to begin with."""
        self.problem, self.metric, self.structure = problem, metric, structure
        self.inside, self.outside = structure.columns(True), structure.columns(False)
        self.low, self.high = problem.bounds
        self.width = problem.width
        self.target = metric.value(problem.values * problem.cosines)
        self.root = np.sqrt(problem.weights)[:, None]
        self.full = x.copy()
        self.scale = max(float(np.abs(problem.values * problem.cosines).max()), 1e-12)
        self._key: bytes = b""
        self._condensed = np.zeros((0, 0))

    def residual(self, theta: Floats) -> Floats:
        """Of the reduced problem; see above."""
        return self._reduced(theta)[1]

    def jacobian(self, theta: Floats) -> Floats:
        """Of the reduced problem."""
        return self._reduced(theta)[0]

    def cost(self, theta: Floats) -> float:
        """Half the sum of squares after the inner problem, without derivatives by theta."""
        self.full[list(self.outside)] = theta
        if not self.inside:
            f = self.problem.evaluate(self.full)
            return 0.5 * float((self._differences(f) ** 2).sum())
        return self._solve_inside()

    def _reduced(self, theta: Floats) -> tuple[Floats, Floats]:
        if theta.tobytes() != self._key:
            self.full[list(self.outside)] = theta
            if self.inside:
                self._solve_inside()
            self._condensed = condensed(self.problem, self.metric, self.structure, self.full)
            self._key = theta.tobytes()
            self._solved = self.full.copy()
        self.full = self._solved.copy()
        M, p = self._condensed, len(self.full)
        J, r = M[:, list(self.outside)], M[:, p]
        margin = 1e-9 * self.width
        between = [
            j
            for j in self.inside
            if self.low[j] + margin[j] < self.full[j] < self.high[j] - margin[j]
        ]
        if between:
            Q, size = np.linalg.qr(M[:, between])
            Q = Q[:, np.abs(np.diag(size)) > 1e-12 * max(np.abs(size).max(), 1e-300)]
            J = J - Q @ (Q.T @ J)
        return J, r

    def _differences(self, f: Floats) -> Floats:
        return np.asarray((self.metric.value(f * self.problem.cosines) - self.target) * self.root)

    def _solve_inside(self) -> float:
        """The linear numbers where the sum is smallest; returns half of it."""
        problem, columns = self.problem, list(self.inside)
        groups = [self.structure.groups[g] for g in self.structure.linear]
        f, slopes = problem.slopes(self.full, groups)
        f, slopes = f * problem.cosines, slopes * problem.cosines
        low, high = self.low[columns], self.high[columns]
        first = self.full[columns]
        c = first.copy()
        rows = {j: g for g, group in enumerate(groups) for j in group}
        # Which columns are in each channel, as places among the linear ones, with their derivatives
        per_channel = [
            [
                (n, slopes[rows[j], :, k])
                for n, j in enumerate(columns)
                if self.structure.alone[j, k]
            ]
            for k in range(3)
        ]
        target, root = self.target, self.root[:, 0]

        def value(c: Floats) -> Floats:
            found = f.copy()
            for k, members in enumerate(per_channel):
                for n, slope in members:
                    if c[n] != first[n]:
                        found[:, k] += slope * (c[n] - first[n])
            return found

        now = value(c)
        difference = (self.metric.value(now) - target) * self.root
        cost = 0.5 * float((difference**2).sum())
        for _ in range(INNER):
            H, g = np.zeros((len(c), len(c))), np.zeros(len(c))
            steep = self.metric.slope(now)
            for k, members in enumerate(per_channel):
                if not members:
                    continue
                places = [n for n, _ in members]
                J = np.stack([slope for _, slope in members], -1) * (steep[:, k] * root)[:, None]
                H[np.ix_(places, places)] += J.T @ J
                g[places] += J.T @ difference[:, k]
            step = bounded_step(H, g, low - c, high - c)
            for _ in range(6):
                tried = np.clip(c + step, low, high)
                there = value(tried)
                moved = (self.metric.value(there) - target) * self.root
                after = 0.5 * float((moved**2).sum())
                if after <= cost:
                    break
                step = 0.5 * step
            else:
                break
            small = (np.abs(tried - c) <= 1e-10 * self.width[columns]).all()
            even = cost - after <= 1e-14 * cost
            c, now, difference, cost = tried, there, moved, after
            if small or even:
                break
        self.full[columns] = c
        self._check(now)
        return cost

    def _check(self, expected: Floats) -> None:
        """Compare a few values with the model's own."""
        some = slice(None, None, max(1, len(expected) // 64))
        few = self.problem.part(some)
        true = few.evaluate(self.full) * few.cosines
        if np.abs(true - expected[some]).max() > AGREEMENT * max(self.scale, np.abs(true).max()):
            raise NotLinearError


def bounded_step(H: Floats, g: Floats, low: Floats, high: Floats) -> Floats:
    """The x in [low, high] where x H x / 2 + g x is smallest; H is positive, or nearly."""
    from scipy.optimize import lsq_linear

    H = H + np.diag(1e-13 * np.maximum(np.diag(H), 1e-13 * max(np.diag(H).max(), 1e-300)) + 1e-300)
    x = np.linalg.solve(H, -g)
    if (x >= low).all() and (x <= high).all():
        return np.asarray(x)
    # As a least-squares problem, by the root of H
    sizes, axes = np.linalg.eigh(H)
    roots = np.sqrt(np.maximum(sizes, 1e-15 * sizes[-1]))
    spread = np.maximum(high - low, 1e-300)
    found = lsq_linear(
        (axes * roots).T,
        -(axes.T @ g) / roots,
        (low, low + spread),
        method="bvls",
    )
    return np.asarray(np.clip(found.x, low, high))


def condensed(problem: Problem, metric: Metric, structure: Structure, x: Floats) -> Floats:
    """A square matrix M, (numbers + 1)^2, with MᵀM = AᵀA for A = [J r]."""
    count = len(x)
    place = {j: g for g, group in enumerate(structure.groups) for j in group}
    total = np.zeros((count + 1, count + 1))
    for part, f, slopes in problem.parts(x, structure.groups):
        cosines, root = problem.cosines[part], np.sqrt(problem.weights[part])[:, None]
        f = f * cosines
        r = (metric.value(f) - metric.value(problem.values[part] * cosines)) * root
        factor = metric.slope(f) * cosines * root
        for k in range(3):
            members = [j for j in range(count) if structure.alone[j, k]]
            A = np.empty((len(members) + 1, len(f)))
            for n, j in enumerate(members):
                np.multiply(slopes[place[j], :, k], factor[:, k], out=A[n])
            A[-1] = r[:, k]
            inside = [*members, count]
            total[np.ix_(inside, inside)] += A @ A.T
    # Columns of length 1, so that the smallest eigenvalues have as many digits as there can be
    size = np.sqrt(np.maximum(np.diag(total), 1e-300))
    sizes, axes = np.linalg.eigh(total / np.outer(size, size))
    return np.asarray(np.sqrt(np.maximum(sizes, 0))[:, None] * axes.T * size)


def search(
    problem: Problem,
    metric: Metric,
    structure: Structure,
    starts: int,
    seed: int,
    progress: Progress | None = None,
    first: int = 0,
) -> list[Found]:
    """Descend from the model's own values and from the best of places all over the ranges.

    Start 0 is the model's own; each of the others has places of its own, by its number, so that starts
    `first`, first + 1, ... are the same wherever they are made.

    Returns:
        What each start came to, the best first.
    """
    few = problem
    if len(problem.wi) > FEW:
        chosen = np.random.default_rng(seed).choice(len(problem.wi), FEW, replace=False)
        few = problem.part(np.sort(chosen))
    found = []
    seen = few.part(np.random.default_rng(seed + 1).permutation(len(few.wi))[:SEEN])
    for number in range(first, first + starts):
        x = _start(seen, metric, structure, number, seed)
        found.append(_descend(few, metric, structure, x, number))
        if progress is not None:
            progress(number - first + 1, starts)
    problem.evaluations += seen.evaluations
    problem.evaluations += few.evaluations if few is not problem else 0
    found.sort(key=lambda f: (f.cost, f.number))
    if few is problem:
        return found
    best = _descend(problem, metric, structure, found[0].x, found[0].number)
    scale = best.cost / max(found[0].cost, 1e-300)
    return [best, *(Found(f.cost * scale, f.number, f.x) for f in found[1:])]


def polish(problem: Problem, metric: Metric, structure: Structure, x: Floats) -> Found:
    """Descend from one place."""
    return _descend(problem, metric, structure, x, 0)


def _start(
    problem: Problem, metric: Metric, structure: Structure, number: int, seed: int
) -> Floats:
    """The model's own values, or the best of some places."""
    if number == 0:
        return problem.start()
    outside = list(structure.columns(False))
    places = problem.random(np.random.default_rng((seed + 1, number)), TRIED)
    costs = [Reduced(problem, metric, structure, x).cost(x[outside]) for x in places]
    return np.asarray(places[np.nanargmin(np.nan_to_num(costs, nan=np.inf))])


def _descend(
    problem: Problem, metric: Metric, structure: Structure, x: Floats, number: int
) -> Found:
    from scipy.optimize import least_squares

    low, high = problem.bounds
    width = problem.width
    x = np.clip(x, low + INSIDE * width, high - INSIDE * width)
    outside = list(structure.columns(False))
    reduced = Reduced(problem, metric, structure, x)
    if not outside:
        return Found(reduced.cost(x[outside]), number, reduced.full.copy())
    result = least_squares(
        reduced.residual,
        x[outside],
        reduced.jacobian,
        (low[outside], high[outside]),
        x_scale=width[outside],
        max_nfev=STEPS,
        ftol=TOLERANCE,
        xtol=TOLERANCE,
        gtol=1e-12,
    )
    reduced.residual(result.x)
    return Found(float(result.cost), number, reduced.full.copy())
