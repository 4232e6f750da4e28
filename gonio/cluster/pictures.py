"""Pictures by shares: some samples of some rows are a task, and their sum is the picture.

Each share has random numbers of its own and the sums are added in one order, so that a picture is the same
whoever rendered its shares. Inside a share Dr.Jit uses one thread: with several, the order in which samples
are added to a pixel, and so the last bits, would change from run to run.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from gonio.cluster.codec import decode, encode
from gonio.cluster.run import Run
from gonio.cluster.task import Failure, Task
from gonio.materials import Material
from gonio.model import Model
from gonio.render import check_diffusion, diffused, scene, without_diffuse
from gonio.render.light import is_own
from gonio.render.passes import Pixels, Share, render_share, shares
from gonio.render.picture import Picture, describe
from gonio.render.stage import check_size

WORK = f"{__name__}:share"

Shown = Model | Material
"""A stack of layers is rendered on one machine."""


def tasks(shown: Shown, arguments: Mapping[str, Any]) -> list[Task]:
    """The shares of a picture, those with black diffuse reflection last where light diffuses.

    Args:
        shown: a model or material.
        arguments: of `gonio.render`, with a number of samples.
    """
    given = dict(arguments)
    diffusion = given.pop("diffusion", 0.0)
    given["size"] = check_size(given["size"])
    if not is_own(given["environment"]):
        given["environment"] = Path(given["environment"])
    if given.get("mesh") is not None:
        given["mesh"] = Path(given["mesh"])
    layers = [shown]
    if diffusion:
        layers.append(without_diffuse(shown))
        plain = {k: v for k, v in given.items() if k != "seed"}
        check_diffusion(scene(shown, **plain), diffusion)
    found = []
    for layer in layers:
        for part in shares(given["size"], given["spp"])[0]:
            samples = f"samples {part.spp_before} to {part.spp_before + part.spp}"
            rows = f"rows {part.top} to {part.top + part.rows}"
            title = f"{describe(layer)}: {samples}, {rows}"
            found.append(Task.of(WORK, title, shown=layer, arguments=given, part=part))
    return found


def share(shown: Shown, arguments: dict[str, Any], part: Share) -> Pixels:
    """The work of a task: a share's samples, added up."""
    given = dict(arguments)
    seed = given.pop("seed", 0)
    with _one_thread():
        loaded = _scene(*_known(shown, given))
        return render_share(loaded, part, seed, alpha=bool(given.get("transparent")))


def pictures(
    run: Run, wanted: Sequence[tuple[Shown, Mapping[str, Any]]]
) -> Iterator[Picture | None]:
    """Pictures, one after the other; None for one that has failed, of which the run knows why.

    Args:
        run: does the tasks.
        wanted: what is shown, and arguments of `gonio.render`.
    """
    cut = [tasks(shown, arguments) for shown, arguments in wanted]
    results = run.results([task for group in cut for task in group])
    for (shown, arguments), group in zip(wanted, cut, strict=True):
        found = [next(results)[1] for _ in group]
        if any(isinstance(f, Failure) for f in found):
            yield None
            continue
        yield _joined(shown, arguments, [f.value for f in found if not isinstance(f, Failure)])


def _joined(shown: Shown, arguments: Mapping[str, Any], sums: Sequence[Pixels]) -> Picture:
    """The picture of its shares' sums."""
    size, spp = check_size(arguments["size"]), arguments["spp"]
    parts = shares(size, spp)[0]
    layers = []
    for first in range(0, len(sums), len(parts)):
        layer = np.zeros((size[1], size[0], sums[first].shape[2]), np.float32)
        for part, pixels in zip(parts, sums[first : first + len(parts)], strict=True):
            layer[part.top : part.top + part.rows] += pixels
        layers.append(layer / np.float32(spp))
    if len(layers) == 1:
        return layers[0].view(Picture)
    given = {k: v for k, v in arguments.items() if k not in ("seed", "diffusion")}
    full, glossy = layers
    return diffused(full, glossy[..., :3], scene(shown, **given), arguments["diffusion"])


def _known(shown: Shown, arguments: dict[str, Any]) -> tuple[bytes, tuple[tuple[str, Path], ...]]:
    data, files = encode([shown, arguments])
    return data, tuple(files.items())


@functools.lru_cache(maxsize=1)
def _scene(data: bytes, files: tuple[tuple[str, Path], ...]) -> Any:
    """The scene that was rendered last, which the next share most often needs as well."""
    places = dict(files)
    shown, arguments = decode(data, lambda digest, name: places[digest])
    return scene(shown, **arguments)


@contextmanager
def _one_thread() -> Iterator[None]:
    import drjit as dr

    before = dr.thread_count()
    dr.set_thread_count(1)
    try:
        yield
    finally:
        dr.set_thread_count(before)
