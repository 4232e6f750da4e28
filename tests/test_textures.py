"""Maps of flakes and of growth: seeds, seams, statistics, and what Mitsuba makes of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.tolerances import SINGLE

from gonio.materials import load_material
from gonio.mitsuba import textures
from gonio.mitsuba.nodes import node

mi = pytest.importorskip("mitsuba")


@pytest.fixture(autouse=True)
def variant() -> None:
    import gonio.mitsuba

    mi.set_variant("llvm_ad_rgb")
    gonio.mitsuba.register()


# --- flakes --------------------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_flakes() -> None:
    a, b, c = (textures.flake_map(64, seed=s) for s in (3, 3, 4))
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()
    assert a.shape == (64, 64, 2)
    assert a.dtype == np.float32


def test_density_size_and_spread_are_what_they_say() -> None:
    for density, spread in ((0.3, 0.2), (0.9, 0.5)):
        m = textures.flake_map(512, density=density, flake_size=8, spread=spread, seed=1)
        tilted = (m != 0).any(axis=-1)
        # Four standard errors of a share among 4,096 tiles
        assert tilted.mean() == pytest.approx(density, abs=0.03)
        # Three standard errors of 1,200 flakes and more
        assert m[tilted].std() == pytest.approx(spread, rel=0.05)
        # Three standard errors of 1,200 flakes and more
        assert abs(m.mean()) < 0.02
        flakes = len(np.unique(m[tilted], axis=0))
        # Two standard errors of the number of flakes
        assert flakes == pytest.approx(density * (512 / 8) ** 2, rel=0.05)
    assert (textures.flake_map(64, density=0) == 0).all()
    assert np.abs(textures.flake_map(256, spread=50)).max() == textures.SLOPE_MAX


def changes(m: Any, axis: int) -> Any:
    """Share of neighbouring pixels that differ, from each row or column to the next, around."""
    return (m != np.roll(m, -1, axis)).any(-1).mean(1 - axis)


def test_flakes_tile_without_a_seam() -> None:
    m = textures.flake_map(512, flake_size=8, seed=2)
    for axis in (0, 1):
        seam = changes(m, axis)[-1]
        assert seam < 2 * np.median(changes(m, axis))
    cut = m[:403, :403]  # what does not tile has flakes cut off at its edge
    assert changes(cut, 0)[-1] > 2 * np.median(changes(cut, 0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"density": 1.5}, r"density=1.5 is out of range; allowed is 0 to 1"),
        ({"flake_size": 0.1}, r"flake_size=0.1 is out of range"),
        ({"spread": -1}, r"spread=-1 is out of range"),
        ({"spread": float("nan")}, r"spread=nan is out of range"),
    ],
)
def test_bad_flakes_get_one_clear_line(arguments: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        textures.flake_map(64, **arguments)


def looked_up(texture: Any, uv: Any) -> Any:
    si = mi.SurfaceInteraction3f()
    si.uv = mi.Point2f(np.asarray(uv, np.float32).T)
    return np.array(texture.eval_1(si))


def test_mitsuba_reads_the_slopes_tiled_and_unfiltered() -> None:
    m = textures.flake_map(32, seed=1)
    nodes = textures.flake_texture(m, tiles=3)
    rng = np.random.default_rng(0)
    uv = rng.random((1000, 2))
    column, row = (np.floor(np.mod(3 * uv, 1) * 32).astype(int) for uv in (uv[:, 0], uv[:, 1]))
    inside = np.min(np.abs(np.mod(96 * uv, 1) - 0.5), axis=1) < 0.49  # not on a pixel's edge
    for axis, name in enumerate(("flake_x", "flake_y")):
        found = looked_up(mi.load_dict(nodes[name]), uv)
        expected = m[row, column, axis]
        assert np.mean(found[inside] != expected[inside]) < 0.01  # rounding at the edges
    assert (m < 0).any()  # negative slopes survive


# Towards the light, beside the coat's own highlight of the viewer at (0.3, 0, 0.954).
BESIDE = (0.0, 0.3, 0.954)


def test_car_paint_takes_the_textures() -> None:
    m = textures.flake_map(32, spread=0.8, seed=1)
    node = {"type": "gonio_car_paint", "sigma_a": 0.0, **textures.flake_texture(m, tiles=1)}
    bsdf = mi.load_dict(node)
    si = mi.SurfaceInteraction3f()
    rng = np.random.default_rng(0)
    si.uv = mi.Point2f(rng.random((2, 500)).astype(np.float32))
    si.wi = mi.Vector3f(0.3, 0, 0.954)
    value = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*BESIDE)))
    assert np.isfinite(value).all()
    assert value[0].std() > 0.3 * value[0].mean()  # sparkle


def test_sparkle_vanishes_with_distance() -> None:
    m = textures.flake_map(32, spread=0.8, seed=1)
    rng = np.random.default_rng(0)
    uv = rng.random((2, 500)).astype(np.float32)
    contrast = []
    for distance in (1.0, 10.0, 1000.0):
        bsdf = mi.load_dict(
            {"type": "gonio_car_paint", "distance": distance, **textures.flake_texture(m, tiles=1)}
        )
        si = mi.SurfaceInteraction3f()
        si.uv, si.wi = mi.Point2f(uv), mi.Vector3f(0.3, 0, 0.954)
        value = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*BESIDE))[0])
        contrast.append(value.std() / value.mean())
    assert contrast[0] > 3 * contrast[1] > 30 * contrast[2]


def paint(fade: float | None = None, seed: int = 1) -> dict[str, Any]:
    # Three texels to a pixel, so that no ray hits the edge of one
    m = textures.flake_map(96, flake_size=6, spread=0.5, seed=seed)
    return {"type": "gonio_car_paint", **textures.flake_texture(m, tiles=1, fade=fade)}


def seen(bsdf: dict[str, Any], shift: int = 0, away: float = 5.0, seed: int = 0) -> Any:
    """A painted square from straight above by a parallel camera, moved by whole pixels; one lamp."""
    scene = {
        "type": "scene",
        "integrator": {"type": "direct"},
        "square": {"type": "rectangle", "bsdf": bsdf},
        "lamp": {"type": "directional", "direction": [-0.1, 0.05, -1]},
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at(
                [shift * 2 / 32, 0, away], [shift * 2 / 32, 0, 0], [0, 1, 0]
            ),
            "film": {
                "type": "hdrfilm",
                "width": 32,
                "height": 32,
                "rfilter": {"type": "box"},
            },
            # One ray through the middle of each pixel
            "sampler": {"type": "stratified", "sample_count": 1, "jitter": False},
        },
    }
    picture = np.array(mi.render(mi.load_dict(scene), spp=1, seed=seed))[..., 0]
    return picture


def test_flakes_stay_where_they_are_when_the_camera_moves() -> None:
    """They belong to points of the surface: a camera moved by whole pixels sees the same, moved."""
    still = seen(paint())
    assert still.std() > 0.3 * still.mean()  # sparkle
    for shift in (3, -5):
        moved = seen(paint(), shift=shift, seed=9)
        here, there = (still[:, 5:-5], np.roll(moved, shift, axis=1)[:, 5:-5])
        # Positions in single precision; a flake is flat, so that its pixels do not change
        np.testing.assert_allclose(there, here, rtol=1e-3)
    other = seen(paint(seed=2))
    assert np.abs(other - still)[:, 5:-5].max() > 0.1 * still.max()


def test_sparkle_fades_with_the_viewers_distance() -> None:
    """Past `fade` the contrast falls like 1 / distance: the slopes of the normals do."""
    contrast = []
    for away in (1.0, 5.0, 50.0, 500.0, 5000.0):
        picture = seen(paint(fade=5.0), away=away)
        contrast.append(picture.std() / picture.mean())
    assert contrast[0] == pytest.approx(contrast[1], rel=1e-3)  # nothing fades up to there
    assert contrast[1] > 2 * contrast[2]
    # A highlight bends a little over the slopes that are left
    assert contrast[3] / contrast[4] == pytest.approx(10, rel=0.1)
    assert contrast[4] < 1e-2
    # Without it, distance is what the material says, wherever the camera stands
    near, far = seen(paint(), away=1.0), seen(paint(), away=5000.0)
    # The camera is far away both times: its rays are parallel but for single precision
    np.testing.assert_allclose(near, far, rtol=1e-3)


def test_a_material_file_says_where_its_flakes_fade(tmp_path: Path) -> None:
    file = tmp_path / "paint.toml"
    file.write_text('model = "car_paint"\n[flakes]\nsize = 8\nfade = 12.5\n', encoding="utf-8")
    made = node(load_material(file))
    assert made["distance"] == {"type": "gonio_viewer_distance", "unit": 12.5}
    assert mi.load_dict(made) is not None
    file.write_text('model = "car_paint"\n[flakes]\nsize = 8\n', encoding="utf-8")
    assert node(load_material(file))["distance"] == 1.0


def test_viewer_distance_is_the_rays_length() -> None:
    texture = mi.load_dict({"type": "gonio_viewer_distance", "unit": 4.0})
    si = mi.SurfaceInteraction3f()
    si.t = mi.Float([2.0, 10.0])
    np.testing.assert_allclose(np.array(texture.eval_1(si)), [0.5, 2.5])
    with pytest.raises(RuntimeError, match=r"unit=0\.0 is out of range; allowed is above 0"):
        mi.load_dict({"type": "gonio_viewer_distance", "unit": 0.0})
    with pytest.raises(ValueError, match=r"fade=-1 is out of range; allowed is above 0"):
        textures.flake_texture(textures.flake_map(8), fade=-1)


def test_written_maps_come_back(tmp_path: Path) -> None:
    m = textures.flake_map(16, seed=1)[..., 0]
    textures.write_map(tmp_path / "x.exr", m)
    np.testing.assert_array_equal(np.array(mi.Bitmap(str(tmp_path / "x.exr"))).reshape(16, 16), m)
    with pytest.raises(ValueError, match=r"cannot write 'x.png'"):
        textures.write_map(tmp_path / "x.png", m)


# --- growth --------------------------------------------------------------------------------------


def torus(major: int = 96, minor: int = 48) -> tuple[Any, Any]:
    u, v = np.meshgrid(np.arange(major), np.arange(minor), indexing="ij")
    a, b = 2 * np.pi * u / major, 2 * np.pi * v / minor
    r = 1 + 0.5 * np.cos(b)
    vertices = np.stack([r * np.cos(a), r * np.sin(a), 0.5 * np.sin(b)], -1).reshape(-1, 3)
    at = lambda i, j: (i % major) * minor + j % minor  # noqa: E731
    quads = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)]
    first = np.stack([quads[0], quads[1], quads[2]], -1).reshape(-1, 3)
    second = np.stack([quads[0], quads[2], quads[3]], -1).reshape(-1, 3)
    return vertices, np.concatenate([first, second])


def test_patina_grows_in_cavities_first() -> None:
    """A torus is more hollow on the side of its hole."""
    vertices, faces = torus()
    growth = textures.growth_map(vertices, faces, noise=0)
    radius = np.hypot(vertices[:, 0], vertices[:, 1])
    assert growth[radius < 0.6].max() < growth[radius > 1.4].min()
    assert np.corrcoef(growth, radius)[0, 1] > 0.95
    inside_out = textures.growth_map(vertices, faces[:, ::-1], noise=0)
    assert np.corrcoef(inside_out, radius)[0, 1] < -0.95


def test_growth_is_spread_evenly_over_the_area() -> None:
    vertices, faces = torus()
    for noise in (0.0, 0.5, 1.0):
        growth = textures.growth_map(vertices, faces, noise=noise)
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        share = [np.sum(area * (growth[faces].mean(1) < t)) / area.sum() for t in (0.25, 0.5, 0.75)]
        # Ranks are of vertices, the shares of faces, which are a 30th of the ring wide
        np.testing.assert_allclose(share, [0.25, 0.5, 0.75], atol=0.03)
        assert growth.min() >= 0
        assert growth.max() <= 1


def test_noise_breaks_growth_up_and_depends_on_the_seed() -> None:
    vertices, faces = torus()
    a, b, c = (textures.growth_map(vertices, faces, noise=1, seed=s) for s in (0, 0, 1))
    np.testing.assert_array_equal(a, b)
    assert abs(np.corrcoef(a, c)[0, 1]) < 0.3
    ring = a.reshape(96, 48)
    step = np.abs(np.diff(ring, axis=0)).mean()
    assert 0.005 < step < 0.2  # smooth from vertex to vertex, but not flat


def test_vertices_doubled_at_seams_get_one_value() -> None:
    vertices, faces = torus()
    doubled = np.concatenate([vertices, vertices])
    mixed = faces.copy()
    mixed[::2] += len(vertices)
    growth = textures.growth_map(doubled, mixed)
    np.testing.assert_array_equal(growth[: len(vertices)], growth[len(vertices) :])
    np.testing.assert_allclose(
        growth[: len(vertices)], textures.growth_map(vertices, faces), atol=SINGLE
    )


def test_growth_pictures_tile() -> None:
    picture = textures.growth_picture(128, blobs=3, seed=5)
    assert picture.shape == (128, 128)
    for axis in (0, 1):
        steps = np.abs(picture - np.roll(picture, -1, axis)).mean(1 - axis)
        assert steps[-1] < 1.5 * steps.max() + 1e-3
        assert steps[-1] < 3 * np.median(steps)
    cut = picture[:100]
    steps = np.abs(cut - np.roll(cut, -1, 0)).mean(1)
    assert steps[-1] > 3 * np.median(steps)


def test_mitsuba_reads_growth_from_the_mesh() -> None:
    vertices, faces = torus(24, 12)
    growth = textures.growth_map(vertices, faces)
    mesh = mi.Mesh("torus", len(vertices), len(faces))
    buffers = mi.traverse(mesh)
    buffers["vertex_positions"] = np.ravel(vertices).astype(np.float32)
    buffers["faces"] = np.ravel(faces).astype(np.uint32)
    buffers.update()
    textures.add_growth(mesh, growth)
    scene = mi.load_dict({"type": "scene", "mesh": mesh})
    ray = mi.Ray3f(mi.Point3f(1.2, 0.1, 3), mi.Vector3f(0, 0, -1))
    si = scene.ray_intersect(ray)
    found = mi.load_dict(textures.growth_texture()).eval_1(si)[0]
    near = np.linalg.norm(vertices - np.array(si.p).ravel(), axis=1).argsort()[:4]
    assert growth[near].min() - 0.05 <= found <= growth[near].max() + 0.05


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"noise": 2}, r"noise=2 is out of range; allowed is 0 to 1"),
        ({"scale": 0}, r"scale=0 is out of range"),
        ({"vertices": np.zeros((5, 3))}, r"no extent"),
        ({"vertices": np.zeros((5, 2))}, r"shapes \(5, 2\)"),
    ],
)
def test_bad_growth_gets_one_clear_line(arguments: Any, message: str) -> None:
    vertices, faces = torus(6, 4)
    with pytest.raises(ValueError, match=message):
        textures.growth_map(**{"vertices": vertices, "faces": faces, **arguments})
