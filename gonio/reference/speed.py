"""How long the truth takes: the time of a warm kernel for typical stacks.

python -m gonio.reference.speed
"""

from __future__ import annotations

import statistics
import time

import numpy as np

from gonio.model import model
from gonio.reference.stack import Layer, Stack

PAIRS, WALKS = 10_000, 1024

STACKS = {
    "smooth on lambert": lambda: Stack([Layer(1.5)], model("lambert")),
    "ggx on lambert": lambda: Stack([Layer(1.5, 0.1)], model("lambert")),
    "beckmann on lambert": lambda: Stack(
        [Layer(1.5, 0.1, distribution="beckmann")], model("lambert")
    ),
    "ggx on metal": lambda: Stack([Layer(1.5, 0.1)], model("torrance_sparrow")),
    "two ggx on lambert": lambda: Stack([Layer(1.3, 0.1), Layer(1.3, 0.3)], model("lambert")),
}


def seconds(name: str, *, pairs: int = PAIRS, walks: int = WALKS, repeat: int = 3) -> float:
    """Median time of `eval` over random pairs of directions, compilation not counted.

    name: one of `STACKS`.
    """
    rng = np.random.default_rng(0)
    w = rng.normal(size=(2, pairs, 3)).astype(np.float32)
    w[..., 2] = np.abs(w[..., 2])
    wi, wo = w / np.linalg.norm(w, axis=-1, keepdims=True)
    stack = STACKS[name]()
    stack.eval(wi, wo, walks=max(walks // 64, 1))
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        stack.eval(wi, wo, walks=walks)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


if __name__ == "__main__":
    for each in STACKS:
        print(f"{each:<22} {seconds(each):6.2f} s for {PAIRS} pairs of {WALKS} walks")
