"""In which of its numbers a model is linear, which change one channel alone, and which are too many: found
by trying.

Nothing lists the models' parameters. A number is linear if the derivative by it does not change with it;
several are together if none of their derivatives changes with any of them. A number is too many if its
derivative is a sum of multiples of the others' everywhere, as a weight's of a colour is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gonio.fit.problem import Floats, Group, Problem
from gonio.measured.frames import half_difference

# Directions that are tried, a part of them where highlights are, and places in the ranges: a kink that all
# of them miss shows in the descent.
DIRECTIONS, NEAR, TRIALS = 64, 24, 3

# A change below this part of the largest derivative is rounding; and what is left of a derivative that is a
# sum of others.
ROUNDING, DEPENDENT = 1e-9, 1e-8


@dataclass(frozen=True)
class Structure:
    """What is known about a problem's columns."""

    groups: tuple[Group, ...]
    """All columns, those of one colour together where each changes its own channel alone."""
    linear: tuple[int, ...]
    """Indices into `groups`: the value is linear in all of them together."""
    alone: NDArray[np.bool_]
    """(columns, 3): the channels that a column can change."""
    idle: tuple[int, ...]
    """Columns that change nothing."""
    spare: tuple[int, ...]
    """Columns that can keep the model's values: those before them can change whatever they change."""

    def columns(self, linear: bool) -> tuple[int, ...]:
        """The columns that are linear, or the others, in order."""
        inside = {j for g in self.linear for j in self.groups[g]}
        return tuple(j for j in range(len(self.alone)) if (j in inside) == linear)

    def without_linear(self) -> Structure:
        """The same, with nothing known to be linear."""
        return replace(self, linear=())


def structure(problem: Problem, seed: int = 0) -> Structure:
    """Find out; some tens of small kernels."""
    count = len(problem.free)
    random = np.random.default_rng(seed)
    few = problem.part(_directions(problem, random))
    single: list[Group] = [(j,) for j in range(count)]
    changes = np.zeros((count, count))
    effects = np.zeros((count, 3))
    left = np.zeros(count)
    places = few.random(random, TRIALS)
    for base, other in zip(places, few.random(random, TRIALS), strict=True):
        _, slopes = few.slopes(base, single)
        size = np.maximum(np.abs(slopes).max((1, 2)), 1e-300)
        effects = np.maximum(effects, np.abs(slopes).max(1))
        left = np.maximum(left, _left(slopes))
        for i in range(count):
            moved = base.copy()
            moved[i] = other[i]
            change = np.abs(few.slopes(moved, single)[1] - slopes).max((1, 2))
            changes[i] = np.maximum(changes[i], change / size)
    idle = effects.max(-1) == 0
    effects /= np.maximum(effects.max(-1, keepdims=True), 1e-300)
    alone = effects > ROUNDING
    alone[~alone.any(-1)] = True  # without any effect here
    groups = _groups(problem, alone)
    bends = np.array([[changes[np.ix_(a, b)].max() > ROUNDING for b in groups] for a in groups])
    linear: list[int] = []
    # Colours first, then what bends the fewest others
    for g in sorted(range(len(groups)), key=lambda g: (-len(groups[g]), bends[g].sum(), g)):
        if not bends[np.ix_([*linear, g], [*linear, g])].any():
            linear.append(g)
    return Structure(
        tuple(groups),
        tuple(sorted(linear)),
        alone,
        tuple(np.flatnonzero(idle).tolist()),
        _spare(few, places, ~idle & (left <= DEPENDENT), single),
    )


def _spare(
    few: Problem, places: Floats, dependent: NDArray[np.bool_], single: list[Group]
) -> tuple[int, ...]:
    """Those that are dependent where they have the model's own values as well: these can stay.

    A weight of 0 cannot: a colour that it multiplies would do nothing.
    """
    if not dependent.any():
        return ()
    own = few.start()
    left = np.zeros(len(own))
    for place in places:
        _, slopes = few.slopes(np.where(dependent, own, place), single)
        left = np.maximum(left, _left(slopes))
    return tuple(np.flatnonzero(dependent & (left <= DEPENDENT)).tolist())


def _directions(problem: Problem, random: np.random.Generator) -> NDArray[np.intp]:
    """Some near the mirror direction, where narrow highlights are, and others anywhere."""
    near = np.argsort(half_difference(problem.wi, problem.wo)[0], kind="stable")[:NEAR]
    others = random.permutation(len(problem.wi))[: DIRECTIONS - NEAR]
    return np.unique(np.concatenate([near, others]))


def _left(slopes: Floats) -> Floats:
    """What is left of each derivative, as a part of it, without those before it."""
    A = slopes.reshape(len(slopes), -1).T
    size = np.linalg.norm(A, axis=0)
    R = np.linalg.qr(A / np.maximum(size, 1e-300), "r")
    found = np.zeros(len(slopes))
    found[: len(R)] = np.abs(np.diag(R))
    return found


def _groups(problem: Problem, alone: NDArray[np.bool_]) -> list[Group]:
    found: list[Group] = []
    colours: dict[str, int] = {}
    for j, column in enumerate(problem.free):
        channel = column.channel
        own = channel is not None and not np.delete(alone[j], channel).any()
        path = column.places[0][0]
        if own and path in colours:
            found[colours[path]] += (j,)
        else:
            if own:
                colours[path] = len(found)
            found.append((j,))
    return found
