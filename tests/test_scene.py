"""The stage: meshes made by code, meshes and skies of the user, and what they look like lit."""

import struct
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
import trimesh
from support.tolerances import DOUBLE, SINGLE, SINGLE_LONG

from gonio.render import ball, light, stage, user_mesh

WHITE = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}}
ORANGE = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.3, 0.1]}}

PARTS = {"core": lambda: ball.sphere(0.7), "shell": ball.shell, "pedestal": ball.pedestal}

TRIANGLE_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
PLY_HEADER = (
    "ply\nformat binary_little_endian 1.0\nelement vertex {0}\nproperty float x\nproperty float y\n"
    "property float z\nelement face {1}\nproperty list uchar int vertex_indices\nend_header\n"
)


@pytest.fixture(autouse=True)
def _variant():
    mi.set_variant("llvm_ad_rgb")


def ply(vertices, faces, vertex_count=None):
    data = PLY_HEADER.format(vertex_count or len(vertices), len(faces)).encode()
    data += np.asarray(vertices, dtype="<f4").tobytes()
    return data + b"".join(struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces)


def render(description, spp=16):
    return np.array(mi.render(mi.load_dict(description), spp=spp))


# -------------------------------------------------------------------------------------- the ball


@pytest.mark.parametrize("part", PARTS)
def test_every_part_is_closed(part):
    mesh = PARTS[part]()
    _, place = np.unique(np.round(mesh.positions, 6), axis=0, return_inverse=True)
    corner = place.reshape(-1)[mesh.faces]
    edges = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    there = edges[:, 0] * len(mesh.positions) + edges[:, 1]
    back = edges[:, 1] * len(mesh.positions) + edges[:, 0]
    # Each edge once in each direction: closed, and all triangles turned the same way.
    assert len(np.unique(there)) == len(there)
    assert np.array_equal(np.sort(there), np.sort(back))


@pytest.mark.parametrize("part", PARTS)
def test_no_triangle_is_degenerate(part):
    mesh = PARTS[part]()
    assert mesh.face_areas().min() > 1e-7
    assert mesh.faces.max() == len(mesh.positions) - 1


@pytest.mark.parametrize("part", PARTS)
def test_normals_are_unit_and_agree_with_the_triangles(part):
    mesh = PARTS[part]()
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=DOUBLE)
    a, b, c = (mesh.positions[mesh.faces[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    # 10 degrees: the bevels turn by 15 from one row to the next, all else by less.
    cosine = np.einsum("ij,ikj->ik", flat, mesh.normals[mesh.faces])
    assert cosine.min() > np.cos(np.radians(10))


def test_outside_is_outside():
    analytic = 4 / 3 * np.pi * 0.7**3
    # An inscribed mesh loses volume as the square of its step, here pi / 128.
    assert ball.sphere(0.7).volume() == pytest.approx(analytic, rel=5e-4)
    whole = 4 / 3 * np.pi * (1 - ball.SHELL_INSIDE**3)
    assert 0.7 * whole < ball.shell().volume() < 0.9 * whole
    assert ball.pedestal().volume() > 0


def test_pedestal_stands_on_the_ground_and_touches_the_ball():
    positions = ball.pedestal().positions
    assert abs(positions[:, 1].min()) < DOUBLE
    gap = np.linalg.norm(positions - [0, ball.BALL_CENTRE, 0], axis=1).min() - 1
    assert -0.02 < gap < 0.01


@pytest.mark.parametrize("part", PARTS)
def test_texture_is_nowhere_folded_to_nothing(part):
    mesh = PARTS[part]()
    a, b, c = (mesh.uvs[mesh.faces[:, k]] for k in range(3))
    e, f = b - a, c - a
    area = np.abs(e[:, 0] * f[:, 1] - e[:, 1] * f[:, 0]) / 2
    # Only where the sphere's own poles are may a triangle have (almost) no texture.
    assert np.mean(area < 1e-10) < 1e-3


# -------------------------------------------------------------------------------- the user's mesh


@pytest.fixture(params=[".obj", ".ply", ".stl", ".glb"])
def torus_file(request, tmp_path):
    torus = trimesh.creation.torus(1.0, 0.4, major_sections=48, minor_sections=24)
    torus.apply_scale(37.0)
    torus.apply_translation([100.0, -7.0, 3.0])
    torus.export(tmp_path / f"torus{request.param}")
    return tmp_path / f"torus{request.param}"


def test_user_mesh_is_scaled_centred_and_put_on_the_ground(torus_file):
    mesh = user_mesh.with_normals(
        user_mesh.on_stage(user_mesh.load_mesh(torus_file), up="z", turn=30)
    )
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    assert low[1] == pytest.approx(user_mesh.LIFT, abs=SINGLE)
    np.testing.assert_allclose((low + high)[[0, 2]], 0, atol=SINGLE)
    middle = (low + high) / 2
    radius = np.linalg.norm(mesh.positions - middle, axis=1).max()
    assert radius == pytest.approx(user_mesh.MESH_RADIUS, rel=SINGLE_LONG)
    # A torus lying flat: its height is 0.4 / 1.4 of its width.
    assert high[1] == pytest.approx(2 * user_mesh.MESH_RADIUS * 0.4 / 1.4, rel=0.01)
    assert mesh.volume() > 0
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=SINGLE)


def test_user_mesh_is_in_the_picture(torus_file):
    description = stage.shader_ball(ORANGE, mesh=torus_file, up="z", size=(48, 48))
    picture = render(description)
    assert np.isfinite(picture).all()
    red, _, blue = np.moveaxis(picture, -1, 0)
    assert 0.05 < np.mean(red > 2 * blue) < 0.6


def test_glb_keeps_every_geometry_with_its_transform_and_uv(tmp_path):
    box = trimesh.creation.box()
    box.visual = trimesh.visual.TextureVisuals(uv=np.linspace(0, 1, 16).reshape(8, 2))
    mirror = np.diag([-2.0, 1.0, 1.0, 1.0])
    mirror[:3, 3] = [0, 5, 0]
    both = trimesh.Scene()
    both.add_geometry(box, node_name="one")
    both.add_geometry(box, node_name="two", transform=mirror)
    (tmp_path / "two.glb").write_bytes(both.export(file_type="glb"))
    mesh = user_mesh.load_mesh(tmp_path / "two.glb")
    assert len(mesh.faces) == 24
    np.testing.assert_allclose(mesh.positions.max(axis=0), [1, 5.5, 0.5])
    assert mesh.volume() == pytest.approx(3)  # 1 + 2; the mirrored one not inside out
    # glTF has v = 0 at the top of a picture, as Mitsuba has; trimesh turned it over twice.
    np.testing.assert_allclose(mesh.uvs[:8], box.visual.uv * [1, -1] + [0, 1], atol=SINGLE)


def test_normals_of_the_file_are_kept_and_missing_ones_are_smooth_unless_edges_are_meant(tmp_path):
    tilted = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0.6 0.8\nf 1//1 2//1 3//1\n"
    (tmp_path / "tilted.obj").write_text(tilted)
    mesh = user_mesh.load_mesh(tmp_path / "tilted.obj")
    np.testing.assert_allclose(
        user_mesh.with_normals(mesh).normals, [[0, 0.6, 0.8]] * 3, atol=SINGLE
    )

    ball = trimesh.creation.icosphere(subdivisions=2)
    (tmp_path / "ball.ply").write_bytes(ply(ball.vertices, ball.faces))
    mesh = user_mesh.load_mesh(tmp_path / "ball.ply")
    assert mesh.normals is None
    # Normals are averages over the triangles around a vertex
    np.testing.assert_allclose(user_mesh.with_normals(mesh).normals, mesh.positions, atol=0.03)

    box = trimesh.creation.box()
    (tmp_path / "box.ply").write_bytes(ply(box.vertices, box.faces))
    cube = user_mesh.with_normals(user_mesh.load_mesh(tmp_path / "box.ply"))
    a, b, c = (cube.positions[cube.faces[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)  # of length 1: every triangle is half of a unit square
    np.testing.assert_allclose(
        cube.normals[cube.faces], flat[:, None].repeat(3, axis=1), atol=SINGLE
    )


def test_normals_missing_at_some_vertices_are_filled_in(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 2 4 3\n"
    (tmp_path / "some.obj").write_text(text)
    mesh = user_mesh.with_normals(user_mesh.load_mesh(tmp_path / "some.obj"))
    np.testing.assert_allclose(mesh.normals, [[0, 0, 1]] * len(mesh.normals), atol=SINGLE)


def test_quads_and_relative_indices_are_read(tmp_path):
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    (tmp_path / "quad.ply").write_bytes(ply(square, [[0, 1, 2, 3]]))
    assert len(user_mesh.load_mesh(tmp_path / "quad.ply").faces) == 2
    (tmp_path / "back.obj").write_text(TRIANGLE_OBJ.replace("f 1 2 3", "f -3 -2 -1"))
    assert user_mesh.load_mesh(tmp_path / "back.obj").faces.tolist() == [[0, 1, 2]]


POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
GLB = trimesh.Scene(trimesh.creation.box()).export(file_type="glb")
DAMAGED = {
    "empty.obj": (b"", "is an empty file"),
    "empty.glb": (b"", "is an empty file"),
    "prose.obj": (b"hello world\nf f f\n", "line 2: could not read the corner 'f'"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\n", "has no triangles"),
    "cut.obj": (TRIANGLE_OBJ.encode() + b"v 1 1", "line 5: could not read 'v 1 1'"),
    "index.obj": (
        TRIANGLE_OBJ.replace("3\n", "99\n").encode(),
        "line 4: a face has a vertex that is not there",
    ),
    "nan.obj": (
        TRIANGLE_OBJ.replace("v 1 0", "v nan 0").encode(),
        "a vertex that is NaN or infinite",
    ),
    "flat.obj": (b"v 1 2 3\n" * 3 + b"f 1 2 3\n", "has no extent"),
    "binary.obj": (bytes(range(256)) * 40, "has no triangles"),
    "cut.ply": (ply(POINTS, [[0, 1, 2]])[:-4], "cut short"),
    "header.ply": (ply(POINTS, [[0, 1, 2]])[:60], "cut short"),
    "huge.ply": (ply(POINTS, [[0, 1, 2]], vertex_count=10**12), "cut short"),
    "index.ply": (ply(POINTS, [[0, 1, 77]]), "a vertex that is not there"),
    "index31.ply": (ply(POINTS, [[0, 1, 2**31 - 1]]), "a vertex that is not there"),
    "nan.ply": (
        ply([[np.nan, 0, 0], *POINTS[1:]], [[0, 1, 2]]),
        "a vertex that is NaN or infinite",
    ),
    "inf.ply": (
        ply([[np.inf, 0, 0], *POINTS[1:]], [[0, 1, 2]]),
        "a vertex that is NaN or infinite",
    ),
    "points.ply": (ply(POINTS, []), "has no triangles"),
    "cut.glb": (GLB[: len(GLB) // 2], "cut short"),
    "header.glb": (GLB[:10], "cut short"),
    "junk.glb": (b"junk" * 99, "cut short"),
    "count.glb": (GLB.replace(b'"count":8,', b'"count":9,'), "cut short"),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_mesh_is_one_clear_line(tmp_path, name):
    data, reason = DAMAGED[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ValueError, match=reason) as error:
        stage.shader_ball(ORANGE, mesh=tmp_path / name)
    assert name in str(error.value)
    assert "\n" not in str(error.value)


def test_glb_with_nan_is_an_error(tmp_path):
    box = trimesh.creation.box()
    data = trimesh.Scene(box).export(file_type="glb")
    data = data.replace(struct.pack("<3f", *box.vertices[0]), struct.pack("<3f", np.nan, 0, 0))
    (tmp_path / "nan.glb").write_bytes(data)
    with pytest.raises(ValueError, match=r"NaN|cannot read"):
        user_mesh.load_mesh(tmp_path / "nan.glb")


def test_mesh_that_is_not_there_or_not_a_mesh_says_what_to_do(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no mesh file .*none\.obj"):
        user_mesh.load_mesh(tmp_path / "none.obj")
    with pytest.raises(ValueError, match=r"must end in \.obj, \.ply, \.stl, \.glb, \.gltf"):
        user_mesh.load_mesh(tmp_path / "scan.fbx")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(ValueError, match="is not a file"):
        user_mesh.load_mesh(tmp_path / "folder.obj")
    (tmp_path / "good.obj").write_text(TRIANGLE_OBJ)
    with pytest.raises(ValueError, match="no up axis 'x'; use one of y, z"):
        stage.shader_ball(ORANGE, mesh=tmp_path / "good.obj", up="x")


# ------------------------------------------------------------------------------------------ light


@pytest.mark.parametrize("environment", light.ENVIRONMENTS)
def test_white_is_bright_but_not_blown_out(environment):
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.8, 0.8]}}
    description = stage.shader_ball(grey, environment=environment, size=(32, 32))
    picture = render(description, spp=64)
    assert np.isfinite(picture).all()
    ball = picture[7:25, 7:26]
    assert 0.55 < np.percentile(ball, 98) < 1.05
    if environment != "white":  # whose background is 1 and may round up
        assert picture.max() < 1.2


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_picture_lights_the_scene_and_its_middle_is_behind_the_object(tmp_path, suffix):
    pixels = np.full((16, 32, 3), 0.5, dtype=np.float32)
    pixels[:, 12:20] = (0.1, 0.9, 0.1)
    path = tmp_path / f"sky{suffix}"
    mi.Bitmap(pixels).write(str(path))
    corner = render(stage.shader_ball(ORANGE, environment=path, size=(32, 32)))[0, 16]
    np.testing.assert_allclose(corner, [0.1, 0.9, 0.1], atol=0.02)  # .hdr keeps 8 bits
    description = stage.shader_ball(ORANGE, environment=path, size=(32, 32), environment_turn=180)
    # .hdr keeps 8 bits
    np.testing.assert_allclose(render(description)[0, 16], 0.5, atol=0.02)


def exr(path: Path, value: float) -> bytes:
    pixels = np.full((4, 8, 3), 1.0, dtype=np.float32)
    pixels[1] = value
    pixels = pixels * 0 if value == 0 else pixels
    mi.Bitmap(pixels).write(str(path))
    return path.read_bytes()


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("empty.exr", "is an empty file"),
        ("cut.exr", "is it damaged|cut short"),
        ("junk.hdr", r"is no \.hdr picture"),
        ("black.exr", "has no light in it"),
        ("sky.png", r"must end in \.exr, \.hdr"),
    ],
)
def test_unusable_environment_is_one_clear_line(tmp_path, name, reason):
    path = tmp_path / name
    good = exr(tmp_path / "good.exr", 2.0)
    data = {"cut.exr": good[:200], "junk.hdr": b"abc" * 99, "sky.png": good}.get(name, b"")
    if name == "black.exr":
        data = exr(path, 0.0)
    path.write_bytes(data)
    with pytest.raises(ValueError, match=reason) as error:
        light.environment_nodes(path)
    assert "\n" not in str(error.value)


def test_unknown_environment_names_the_known_ones():
    with pytest.raises(ValueError, match=r"did you mean 'studio'\? known are studio, sun, front"):
        light.environment_nodes("studo")
    with pytest.raises(FileNotFoundError, match="no environment file"):
        light.environment_nodes("none.exr")


@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10, 10**6), (10,), "big"])
def test_impossible_size_is_an_error(size):
    with pytest.raises(ValueError, match="size must be"):
        stage.shader_ball(ORANGE, size=size)


# ---------------------------------------------------------------------------------------- furnace


def test_white_furnace_hides_a_white_ball():
    picture = render(stage.shader_ball(WHITE, furnace=True, size=(64, 64)), spp=64)
    # Blocks of 4 x 4 pixels; what is missing left through the gap between a mesh and its smooth
    # normals, in the cavity, where paths are longest.
    blocks = picture.reshape(16, 4, 16, 4, 3).mean(axis=(1, 3, 4))
    assert np.abs(blocks - 1).max() < 0.01
    assert abs(picture.mean() - 1) < 0.001


def test_furnace_shows_a_material_that_loses_light():
    picture = render(stage.shader_ball(ORANGE, furnace=True, size=(64, 64)))
    np.testing.assert_allclose(picture[0, 0], 1, atol=SINGLE_LONG)
    np.testing.assert_allclose(picture[32, 46], [0.8, 0.3, 0.1], atol=1e-3)  # convex: one bounce


@pytest.mark.parametrize("variant", ["scalar_rgb", "llvm_ad_spectral", "llvm_ad_mono"])
def test_other_variants_show_the_same(variant):
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5, 0.5, 0.5]}}

    def mean(name):
        mi.set_variant(name)
        return render(stage.shader_ball(grey, size=(24, 24)), spp=64).mean()

    # 2 %: 64 random paths a pixel, and the lamps' tints weigh differently in one grey channel
    assert mean(variant) == pytest.approx(mean("llvm_ad_rgb"), rel=0.02)


def test_sunsky_without_colour_is_an_error():
    mi.set_variant("llvm_ad_mono")
    with pytest.raises(ValueError, match="needs colour"):
        stage.shader_ball(ORANGE, environment="sunsky")


def test_material_on_a_mesh_is_made_two_sided_unless_it_lets_light_through(tmp_path):
    # One triangle, wound so that the camera sees its back.
    (tmp_path / "back.obj").write_text(TRIANGLE_OBJ.replace("f 1 2 3", "f 3 2 1"))
    picture = render(stage.shader_ball(ORANGE, mesh=tmp_path / "back.obj", size=(32, 32)))
    assert picture[20, 12, 0] > 2 * picture[20, 12, 2] > 0
    glass = {"type": "thindielectric"}
    assert stage.shader_ball(glass, mesh=tmp_path / "back.obj")["mesh"].bsdf() is not None
