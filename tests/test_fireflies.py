"""Samples that are cut: what a picture loses by it, and that the command says so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from support.tolerances import SINGLE, SINGLE_LONG

from gonio.cli import main
from gonio.images import write_linear
from gonio.messages import Notice
from gonio.render import render

SMALL = {"size": (16, 12), "spp": 16}


def test_a_limit_that_nothing_reaches_changes_nothing() -> None:
    plain = render("clay", **SMALL)
    with pytest.warns(Notice, match="which took 0 % of the picture's light"):
        cut = render("clay", clamp=1e9, **SMALL)
    np.testing.assert_allclose(cut, plain, rtol=1e-5)  # the same samples, added in another order


def test_the_light_that_is_cut_is_the_light_that_is_missing(tmp_path: Path) -> None:
    """A mirror-like metal under a sun of few pixels, with cavities that reflect it twice."""
    sky = np.full((16, 32, 3), 0.2, np.float32)
    sky[3, 12] = 2e3
    write_linear(tmp_path / "sky.exr", sky)
    scene = {"environment": tmp_path / "sky.exr", "size": (24, 24), "spp": 64}
    plain = render("gold", **scene)
    with pytest.warns(Notice, match="which took") as said:
        cut = render("gold", clamp=1, **scene)
    assert cut.max() < plain.max()
    assert (cut <= plain * (1 + 1e-5) + 1e-6).all()
    stated = float(str(said[0].message).partition("took ")[2].partition(" %")[0]) / 100
    # Two digits are stated; the camera's weights, which differ by a thousandth, are not in it.
    assert 1 - cut.sum() / plain.sum() == pytest.approx(stated, rel=0.06)


@pytest.mark.parametrize("clamp", [0, -1, float("nan"), float("inf")])
def test_a_limit_that_is_none_is_refused(clamp: float) -> None:
    with pytest.raises(ValueError, match="is out of range"):
        render("clay", clamp=clamp, **SMALL)


def test_the_furnace_has_nothing_to_cut() -> None:
    with pytest.raises(ValueError, match="changes nothing in the furnace"):
        render("clay", clamp=1.0, furnace=True, **SMALL)


@pytest.mark.parametrize("depth", [1, 2])
def test_paths_without_indirect_light_have_nothing_to_cut(depth: int) -> None:
    with pytest.raises(ValueError, match="hold no indirect light"):
        render("clay", clamp=1.0, max_depth=depth, **SMALL)


def test_direct_light_is_not_cut(tmp_path: Path) -> None:
    """Seen from above, a black mesh has no indirect light: its highlights stay, and so does the sky."""
    write_linear(tmp_path / "sky.exr", np.full((8, 16, 3), 50, np.float32))
    scene = {"environment": tmp_path / "sky.exr", "ground": False, "mesh": tmp_path / "a.ply"}
    corners = "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n"
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    head += "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    (tmp_path / "a.ply").write_text(head + corners + "4 0 1 2 3\n")
    plain = render("clay", **scene, **SMALL)
    assert plain.max() > 10
    with pytest.warns(Notice, match="which took 0 %"):
        cut = render("clay", clamp=0.01, **scene, **SMALL)
    np.testing.assert_allclose(cut, plain, rtol=SINGLE_LONG)


def test_transparent_pictures_keep_their_alpha() -> None:
    plain = render("gold", transparent=True, **SMALL)
    with pytest.warns(Notice, match="which took"):
        cut = render("gold", transparent=True, clamp=1e9, **SMALL)
    np.testing.assert_allclose(cut, plain, rtol=SINGLE_LONG, atol=SINGLE)


def test_the_command_counts_in_whites(tmp_path: Path) -> None:
    """Under light 8 times as bright, white is 8 times as bright, and so is the limit."""
    said = []
    for factor in (1, 8):
        write_linear(tmp_path / "sky.exr", np.full((8, 16, 3), 0.5 * factor, np.float32))
        arguments = ["render", "clay", "--env", str(tmp_path / "sky.exr"), "--clamp", "10"]
        arguments += ["--size", "8", "--spp", "1", "-o", str(tmp_path / "a.png")]
        done = CliRunner().invoke(main, arguments)
        assert done.exit_code == 0, done.output
        said.append(float(done.output.partition("brighter than ")[2].split()[0]))
    # It is said with three digits
    assert said[1] == pytest.approx(8 * said[0], rel=0.01)
