"""Values between loose points: Shepard's weights over the nearest ones.

Source: Franke, Nielson, "Smooth interpolation of large sets of scattered data", 1980: weights ((R - d) /
(R d))^2 of the points within R, which pass through the values. The coordinates are the root of the half
vector's angle, along which highlights change, and the difference vector's, without its sign: what is
measured is taken as reciprocal.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.measured.frames import Floats, half_difference

# Points that a value is made of. Fewer leave steps, more blur highlights.
NEIGHBOURS = 9

# A direction counts as measured up to this many of the points' distances from each other, and not below
# the second number, a step of 5 degrees at the mirror direction.
REACH, REACH_MIN = 3.0, 0.03

# Directions that are looked up at once.
BATCH = 1 << 16


def coordinates(wi: Floats, wo: Floats, isotropic: bool) -> Floats:
    """Places of pairs of directions (n, 3 or 4); near ones have similar values."""
    if (wo[:, 2] < 0).any() or (wi[:, 2] < 0).any():  # transmission has no half vector of this kind
        azimuth = np.arctan2(wi[:, 1], wi[:, 0]) if isotropic else np.zeros(len(wi))
        c, s = np.cos(azimuth), np.sin(azimuth)
        x, y = c * wi[:, 0] + s * wi[:, 1], c * wi[:, 1] - s * wi[:, 0]
        a, b = c * wo[:, 0] + s * wo[:, 1], c * wo[:, 1] - s * wo[:, 0]
        return np.stack([x, y, a, np.abs(b) if isotropic else b], -1)
    theta_h, phi_h, theta_d, phi_d = half_difference(wi, wo)
    u, v = np.sqrt(theta_h / (0.5 * np.pi)), theta_d / (0.5 * np.pi)
    if isotropic:
        # The azimuth between them means nothing where one of them is 0
        turn = np.abs((phi_d + 0.5 * np.pi) % np.pi - 0.5 * np.pi) / (0.5 * np.pi)
        return np.stack([u, v, np.minimum(u, v) * turn], -1)
    d = 0.5 * (wi - wo)
    length = np.maximum(np.hypot(d[:, 0], d[:, 1]), 1e-9)
    return np.stack(
        [
            u * np.cos(phi_h),
            u * np.sin(phi_h),
            (d[:, 0] ** 2 - d[:, 1] ** 2) / length,
            2 * d[:, 0] * d[:, 1] / length,
        ],
        -1,
    )


class Scattered:
    """Values between loose points."""

    def __init__(self, wi: Floats, wo: Floats, values: NDArray[Any], isotropic: bool) -> None:
        """Sort the points: unit vectors (n, 3) and values (n, channels), of which there is at least one."""
        from scipy.spatial import cKDTree

        self.isotropic, self.values = isotropic, values
        places = coordinates(wi, wo, self.isotropic)
        self.tree: Any = cKDTree(places)
        self.count = min(NEIGHBOURS, len(places))
        some = places[:: max(1, len(places) // 2000)]
        apart = self.tree.query(some, min(2, len(places)))[0].reshape(len(some), -1)[:, -1]
        apart = apart[apart > 0]
        self.reach = max(REACH * float(np.median(apart)) if apart.size else 0.0, REACH_MIN)

    def __call__(self, wi: Floats, wo: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Values (n, channels), and whether a point is near (n,)."""
        found = np.zeros((len(wi), self.values.shape[1]))
        covered = np.zeros(len(wi), bool)
        for start in range(0, len(wi), BATCH):
            part = slice(start, start + BATCH)
            place = coordinates(wi[part], wo[part], self.isotropic)
            distance, index = self.tree.query(place, self.count)
            distance = distance.reshape(len(place), -1)
            index = index.reshape(len(place), -1)
            radius = distance[:, -1:] * (1 + 1e-6) + 1e-12
            weight = ((radius - distance) / (radius * (distance + 1e-9))) ** 2
            weight /= weight.sum(-1, keepdims=True)
            found[part] = np.einsum("nk,nkc->nc", weight, self.values[index])
            covered[part] = distance[:, 0] <= self.reach
        return found, covered
