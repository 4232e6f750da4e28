"""Readers and writers of measured reflection, against the formats' descriptions and other programs."""

from __future__ import annotations

import math
import struct
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.measured_files import EXAMPLES, klems, merl, rgl, tree
from support.tolerances import DOUBLE, DOUBLE_DIVIDED, SINGLE, SINGLE_LONG

import gonio
from gonio import measured
from gonio.measured import DataError
from gonio.measured.formats import alta
from gonio.measured.frames import (
    angles,
    around_mirror,
    from_half_difference,
    half_difference,
    spherical,
)
from gonio.measured.spectra import rgb_matrix

SAMPLES = Path(__file__).parents[2] / "shared" / "samples" / "measured"
with_samples = pytest.mark.skipif(not SAMPLES.is_dir(), reason="the real files are not here")

random = np.random.default_rng(3)


def directions(count: int, lowest: float = 0.1) -> Any:
    mu = random.uniform(lowest, 1, count)
    return spherical(np.arccos(mu), random.uniform(-math.pi, math.pi, count))


def put(folder: Path, name: str, content: bytes) -> Path:
    path = folder / f"{name}.dat"  # no format's own suffix
    path.write_bytes(content)
    return path


# --- angles --------------------------------------------------------------------------------------


def test_half_and_difference_angles_agree_with_vectors() -> None:
    wi, wo = directions(2000), directions(2000)
    theta_h, phi_h, theta_d, phi_d = half_difference(wi, wo)
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
    assert np.allclose(h, spherical(theta_h, phi_h), atol=DOUBLE)
    assert np.allclose(np.cos(theta_d), np.sum(wi * h, -1), atol=DOUBLE)
    back = from_half_difference(theta_h, phi_h, theta_d, phi_d)
    assert np.allclose(back[0], wi, atol=DOUBLE)
    assert np.allclose(back[1], wo, atol=DOUBLE)
    swapped = half_difference(wo, wi)[3]
    assert np.allclose(np.cos(swapped - phi_d), -1)  # half a turn


def test_azimuth_0_about_the_mirror_leads_to_the_normal() -> None:
    wi = spherical(math.radians(30), 0.4)
    assert np.allclose(around_mirror(wi, np.array(0.3), np.array(0.0)), wi * [-1, -1, 1])
    up = around_mirror(wi, np.array(0.0), np.array(math.radians(30)))
    assert np.allclose(up, [0, 0, 1])


# --- every format --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_file_is_recognised_by_its_content_and_by_one_format_only(
    name: str, tmp_path: Path
) -> None:
    source = measured.Source(put(tmp_path, name, EXAMPLES[name]))
    format = name.partition("_")[0] if name != "bsdf_xml_tree" else "bsdf_xml"
    format = "bsdf_xml" if format == "bsdf" else format
    assert [n for n, m in measured.formats().items() if m.sniff(source)] == [format]


def test_every_format_of_the_folder_has_an_example() -> None:
    assert all(any(e.startswith(name) for e in EXAMPLES) for name in measured.formats())


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_measurement_has_unit_directions_and_a_place_for_every_value(
    name: str, tmp_path: Path
) -> None:
    for found in measured.load_parts(put(tmp_path, name, EXAMPLES[name])):
        for w in (found.wi, found.wo):
            assert np.allclose(np.linalg.norm(w[found.valid], axis=-1), 1, atol=SINGLE)
        assert found.values.shape == (len(found.wi), len(found.channels))
        assert np.isfinite(found.values).all()
        assert found.valid.any()
        at = found.evaluate(found.wi[found.valid], found.wo[found.valid])
        assert np.isfinite(at).all()
        if found.wavelengths is not None:
            assert len(found.wavelengths) == len(found.channels)


def test_merl_index_is_the_published_one(tmp_path: Path) -> None:
    n_h, n_d, n_p = 90, 90, 180
    planes = np.full(3 * n_h * n_d * n_p, -1.0)
    theta_h, theta_d, phi_d = 12, 34, 56  # indices
    place = phi_d + 180 * (theta_d + 90 * theta_h)
    for c in range(3):
        planes[place + c * n_h * n_d * n_p] = 1500.0
    path = put(tmp_path, "m", struct.pack("<3i", n_h, n_d, n_p) + planes.tobytes())
    found = measured.load(path)
    (where,) = np.flatnonzero(found.valid)
    assert np.allclose(found.values[where], [1, 1.15, 1.66])
    wi, wo = found.wi[where].astype(float), found.wo[where].astype(float)
    h = (wi + wo) / np.linalg.norm(wi + wo)
    # The reader that comes with the data: index = sqrt(theta / 90°) 90, and degrees, cut down
    assert int(90 * math.sqrt(math.acos(h[2]) / (math.pi / 2))) == theta_h
    assert int(math.degrees(math.acos(wi @ h))) == theta_d
    # phi_d about h, from where h's meridian goes on beyond h
    meridian = np.array([0.0, 0.0, 1.0]) - h[2] * h
    meridian /= -np.linalg.norm(meridian)
    x, y = wi @ meridian, wi @ np.cross(h, meridian)
    assert int(math.degrees(math.atan2(y, x) % math.pi)) == phi_d


def test_negative_numbers_of_merl_are_holes_and_grazing_ones_are_extrapolated(
    tmp_path: Path,
) -> None:
    found = measured.load(put(tmp_path, "m", merl()))
    assert found.weights[7] == 0
    assert found.extrapolated is not None
    theta_d = half_difference(found.wi, found.wo)[2]
    assert (theta_d[found.extrapolated] > math.radians(80)).all()


def test_mbsdf_numbers_stand_in_the_middle_of_their_steps(tmp_path: Path) -> None:
    reflected, through = measured.load_parts(put(tmp_path, "m", EXAMPLES["mbsdf"]))
    assert (reflected.part, through.part) == ("reflection", "transmission")
    assert reflected.metadata["manufacturer"] == "somebody"
    # [theta_i][theta_o][phi]: theta_i 22.5°, theta_o 67.5°, phi 90° is the fifth triple
    at = spherical(math.radians(22.5), 0.0), spherical(math.radians(67.5), math.radians(90))
    assert np.allclose(reflected.evaluate(*at), [[12, 13, 14]], atol=DOUBLE)
    assert np.allclose(reflected.evaluate(at[0], at[1] * [1, -1, 1]), [[12, 13, 14]], atol=DOUBLE)
    assert np.allclose(through.evaluate(at[0], at[1] * [1, 1, -1]), [[4]], atol=DOUBLE)


def test_zemax_angles_are_about_the_mirror_direction(tmp_path: Path) -> None:
    found = measured.load(put(tmp_path, "z", EXAMPLES["zemax"]))
    assert found.metadata["Sample"] == "a plate"
    values = found.values.reshape(2, 3, 2)
    wo = found.wo.reshape(2, 3, 2, 3)
    assert values[1, 0, 1] == pytest.approx(0.11)
    # 30° of incidence, 40° towards the normal: 10° on the light's side, where x is positive
    assert np.allclose(wo[1, 0, 1], spherical(math.radians(10), 0.0), atol=SINGLE)
    assert found.weights.reshape(2, 3, 2)[1, 2, 1] == 0  # the zero, at 70°


@pytest.mark.parametrize("name", ["astm", "pbrt"])
def test_rows_of_angles_are_directions(name: str, tmp_path: Path) -> None:
    found = measured.load(put(tmp_path, name, EXAMPLES[name]))
    assert np.allclose(found.wi[0], [math.sin(0.5), 0, math.cos(0.5)], atol=SINGLE)
    assert np.allclose(found.wo[0], [-math.sin(0.5), 0, math.cos(0.5)], atol=SINGLE)
    assert np.allclose(found.values[1], [0.14, 0.13, 0.12])


def test_fred_has_the_mirror_direction_at_azimuth_0(tmp_path: Path) -> None:
    found = measured.load(put(tmp_path, "f", EXAMPLES["fred"]))
    mirror = np.flatnonzero(np.isclose(found.values[:, 0], 0.5))  # 0.25 times the scale
    assert np.allclose(found.wo[mirror], found.wi[mirror] * [-1, -1, 1], atol=SINGLE)


def test_alta_has_errors_as_weights_and_any_byte_order(tmp_path: Path) -> None:
    text = measured.load(put(tmp_path, "a", EXAMPLES["alta"]))
    assert text.weights[0] / text.weights[1] == pytest.approx(4)  # half widths 0.1 and 0.2
    binary = measured.load(put(tmp_path, "b", EXAMPLES["alta_binary"]))
    assert np.allclose(text.wi, binary.wi)
    assert np.allclose(text.wo, binary.wo)
    assert np.allclose(text.values, binary.values)
    assert np.allclose(angles(text.wo)[0], [0.5, 0.2], atol=SINGLE)  # V, the viewer, comes first


def _alta_numbers(name: str, V: Any, L: Any) -> list[float]:
    """ALTA's definitions of its parametrisations, forwards."""
    H, K = V + L, V - L
    h, B = H / np.linalg.norm(H), (L - V) / 2
    (tv, pv), (tl, pl) = angles(V), angles(L)
    th, ph, td, pd = half_difference(V, L)
    back = np.array([V[0] - L[0], V[1] - L[1], V[2] + L[2]])
    tk, pk = angles(back / np.linalg.norm(back))
    apart = math.acos(V @ L)
    return {
        "COS_TH": [h[2]],
        "RUSIN_TH_TD_PD": [th, td, pd],
        "RUSIN_TH_PH_TD_PD": [th, ph, td, pd],
        "COS_TH_TD": [h[2], V @ h],
        "ISOTROPIC_TV_TL_DPHI": [tv, tl, pv - pl],
        "ISOTROPIC_TL_TV_PROJ_DPHI": [tl, tv * math.cos(pv - pl), tv * math.sin(pv - pl)],
        "SPHERICAL_TL_PL_TV_PV": [tl, pl, tv, pv],
        "CARTESIAN": [*V, *L],
        "STEREOGRAPHIC": [*(V[:2] / (1 + V[2])), *(L[:2] / (1 + L[2]))],
        "STARK_2D": [np.hypot(*(H[:2] / 2)), np.linalg.norm(B)],
        "NEUMANN_2D": [np.hypot(*(H[:2] / 2)), np.hypot(*B[:2])],
        "SCHLICK_TL_TK_PROJ_DPHI": [tl, tk * math.cos(pk - pl), tk * math.sin(pk - pl)],
        "RETRO_TL_TVL_PROJ_DPHI": [tl, apart, np.linalg.norm(K)],
    }[name]


@pytest.mark.parametrize(
    "name",
    [
        *("RUSIN_TH_TD_PD", "RUSIN_TH_PH_TD_PD", "ISOTROPIC_TV_TL_DPHI", "STEREOGRAPHIC"),
        *("ISOTROPIC_TL_TV_PROJ_DPHI", "SPHERICAL_TL_PL_TV_PV", "CARTESIAN"),
        "SCHLICK_TL_TK_PROJ_DPHI",
    ],
)
def test_parametrisation_of_alta_gives_back_the_directions(name: str) -> None:
    _, convert = alta.PARAMETRISATIONS[name]
    for V, L in zip(directions(20), directions(20), strict=True):
        numbers = _alta_numbers(name, V, L)
        v, el = convert(*(np.array([x]) for x in numbers))
        for w in (v, el):
            assert np.linalg.norm(w) == pytest.approx(1, abs=DOUBLE_DIVIDED)
        # Isotropic ones leave the azimuth open: what has to be kept is the angles to N and between them
        pairs = [(v[0], V), (el[0], L)]
        if name.startswith("RUSIN"):  # ALTA turns V where gonio turns L: the same pair, swapped
            pairs = [(el[0], V), (v[0], L)]
            if min(abs(np.array(v[0])[2] - V[2]), 1) < 1e-9:
                pairs = [(v[0], V), (el[0], L)]
        assert all(a[2] == pytest.approx(b[2], abs=DOUBLE_DIVIDED) for a, b in pairs)
        assert v[0] @ el[0] == pytest.approx(V @ L, abs=DOUBLE_DIVIDED)


def test_slices_of_alta_have_the_angles_they_name() -> None:
    for name in ("COS_TH", "COS_TH_TD", "STARK_2D", "NEUMANN_2D"):
        dimensions, convert = alta.PARAMETRISATIONS[name]
        numbers = [np.array([x]) for x in (0.7, 0.5)[:dimensions]]
        V, L = (w[0] for w in convert(*numbers))
        again = _alta_numbers(name, V, L)
        assert again == pytest.approx([0.7, 0.5][:dimensions], abs=DOUBLE_DIVIDED), name
    V, L = (
        w[0]
        for w in alta.PARAMETRISATIONS["RETRO_TL_TVL_PROJ_DPHI"][1](
            np.array([0.6]), np.array([0.2]), np.array([0.1])
        )
    )
    t = math.hypot(0.2, 0.1)
    assert pytest.approx(math.cos(t)) == V @ L
    # Its law of cosines: cos(theta_v) = cos l cos t + cos p sin l sin t
    expected = math.cos(0.6) * math.cos(t) + 0.2 / t * math.sin(0.6) * math.sin(t)
    assert V[2] == pytest.approx(expected)


def test_klems_matrix_is_out_by_in_and_mirrored_light_stays_in_its_patch(tmp_path: Path) -> None:
    found = measured.load(put(tmp_path, "k", klems()))
    assert found.metadata["Name"] == "a blind"
    up = np.array([[0.0, 0.0, 1.0]])
    for ring in range(4):  # patches of the ring are centred at azimuths 0, 90, 180, 270
        wo = spherical(math.radians(60), np.array([0.5 * math.pi * ring]))
        assert found.evaluate(up, wo)[0, 0] == pytest.approx(ring + 2)  # the pole's column
    wi = spherical(math.radians(60), np.array([0.0]))
    assert found.evaluate(wi, up)[0, 0] == pytest.approx(0.1)


def test_tree_has_radiances_order_of_branches(tmp_path: Path) -> None:
    found = measured.load(put(tmp_path, "t", tree()))
    # Branch n has bit i of n on axis i; those with bit 0 are beyond the middle of the first axis,
    # where an isotropic tree has nothing.
    values = {round(float(v), 3) for v in found.values[found.valid][:, 0]}
    assert {0.5, 2.5, 4.5, 6.5} <= values
    assert not values & {1.5, 5.5, 7.5}
    two = np.flatnonzero(
        np.isclose(found.values[:, 0], 2.5)
    )  # bit 1: x of wo is positive, y negative
    assert found.wo[two, 0] > 0 > found.wo[two, 1]


def test_csv_takes_radians_vectors_and_wavelengths(tmp_path: Path) -> None:
    text = b"theta_i [rad],phi_i [rad],theta_o [rad],phi_o [rad],450,550,650\n0.5,0,0.5,1,1,2,3\n"
    found = measured.load(put(tmp_path, "r", text))
    assert found.wavelengths is not None
    assert np.allclose(found.wavelengths, [450, 550, 650])
    assert np.allclose(found.wi[0], [math.sin(0.5), 0, math.cos(0.5)], atol=SINGLE)
    text = b"wi_x;wi_y;wi_z;wo_x;wo_y;wo_z;f\n0;0;1;0.6;0;0.8;0.25\n"
    found = measured.load(put(tmp_path, "v", text))
    assert np.allclose(found.wo[0], [0.6, 0, 0.8], atol=SINGLE)
    assert found.channels == ("value",)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "theta_i,theta_o,f\n10,20,1\n\n# so\n10,200,1\n",
            "line 5: has an angle to the normal of 200",
        ),
        (
            "theta_i,phi_i,theta_o,phi_o,f\n1,0,1,0,1\n1,nan,1,0,1\n",
            "line 3: has an angle that is no",
        ),
        ("theta_i,phi_i,theta_o,phi_o,f\n1,0,1,1e9,1\n1,1,1,0,1\n", "line 2: has an azimuth of 1e"),
        ("wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f\n0,0,1,0,0,1,1\n0,0,1,0,3,4,1\n", "line 3: .* length 5"),
    ],
)
def test_a_wrong_direction_of_a_table_is_named_by_its_line(
    text: str, said: str, tmp_path: Path
) -> None:
    with pytest.raises(DataError, match=said):
        measured.load(put(tmp_path, "w", text.encode()))


# --- damaged files -------------------------------------------------------------------------------

# What a reader may need beside the file itself: Python's objects for small files of any content. A header
# that lies about its size by a factor of thousands would need more.
MOST_MEMORY = 48 << 20

EXTREMES = [
    b"\xff" * 8,
    b"\0" * 8,
    b"\x7f" * 4,
    b"nan",
    b"-1",
    b"1e999",
    b"99999999999",
    b"\n",
    b"{",
    b"}",
]
EXTREMES += [b"<!DOCTYPE a [", b"&a;", b"<a>", b",", b" ", b"#", b"180", b"\xf0\x28", b"inf", b"="]


def read_safely(path: Path) -> None:
    """Read a file of any content: measurements, or one clear line, in bounded memory."""
    tracemalloc.start()
    try:
        for found in measured.load_parts(path):
            assert np.isfinite(found.values).all()
            assert len(found.wi) == len(found.wo) == len(found.values) == len(found.weights)
            use = found.valid
            found.interpolate(found.wi[use][:50], found.wo[use][:50])
    except DataError as error:
        text = str(error)
        assert "\n" not in text
        assert len(text) < 700
        assert str(path) in text or path.stem in text
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < MOST_MEMORY, f"{peak >> 20} MiB"


@st.composite
def damaged(draw: st.DrawFn) -> bytes:
    content = bytearray(EXAMPLES[draw(st.sampled_from(sorted(EXAMPLES)))])
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, max(len(content) - 1, 0)))
        # Headers are short; half of all damage goes there
        place = place % 120 if draw(st.booleans()) else place
        what = draw(st.sampled_from(["byte", "cut", "put", "overwrite", "remove", "double"]))
        if what == "byte" and content:
            content[place % len(content)] = draw(st.integers(0, 255))
        elif what == "cut":
            del content[place:]
        elif what == "put":
            content[place:place] = draw(st.sampled_from(EXTREMES))
        elif what == "overwrite":
            extreme = draw(st.sampled_from(EXTREMES))
            content[place : place + len(extreme)] = extreme
        elif what == "remove":
            del content[place : place + draw(st.integers(1, 40))]
        else:
            content[place:place] = content[place : place + draw(st.integers(1, 300))]
    return bytes(content)


@settings(
    max_examples=400, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(content=damaged())
def test_damaged_file_is_read_or_refused_in_one_line(content: bytes, tmp_path: Path) -> None:
    read_safely(put(tmp_path, "damaged", content))


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_truncated_file_is_read_or_refused_in_one_line(name: str, tmp_path: Path) -> None:
    content = EXAMPLES[name]
    for place in {
        *range(0, min(len(content), 200), 7),
        *np.linspace(0, len(content), 40, dtype=int),
    }:
        read_safely(put(tmp_path, "truncated", content[:place]))


def test_hostile_files_are_refused(tmp_path: Path) -> None:
    laughs = (
        b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "ha">]><WindowElement>&a;</WindowElement>'
    )
    deep = b"<WindowElement>" + b"<a>" * 100_000
    braces = tree().replace(b"{ 0.5 }", b"{" * 50_000 + b"}" * 50_000)
    huge = struct.pack("<3i", 4000, 4000, 4000) + b"\0" * 100
    fields = rgl().replace(b"theta_i", b"theta_x")
    many = b"NVIDIA ARC MBSDF V1\nMBSDF_DATA=\n" + struct.pack("<3I", 1, 1 << 31, 1 << 31)
    line = b"theta_i,theta_o,f\n" + b"1" * (3 << 20)
    for number, content in enumerate((laughs, deep, braces, huge, fields, many, line, b"", b"\0")):
        path = put(tmp_path, f"hostile{number}", content)
        with pytest.raises(DataError) as caught:
            measured.load(path)
        assert "\n" not in str(caught.value), number
        read_safely(path)
    # A field without numbers whose other sizes are more than NumPy can multiply
    nothing = bytearray(rgl())
    place = nothing.index(b"luminance") + len(b"luminance")
    (sizes,) = struct.unpack_from("<H", nothing, place)
    struct.pack_into(f"<{sizes}Q", nothing, place + 11, 0, *[1 << 62] * (sizes - 1))
    read_safely(put(tmp_path, "nothing", bytes(nothing)))


def test_a_folder_and_no_file_are_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="is a folder"):
        measured.load(tmp_path)
    with pytest.raises(DataError, match="does not exist"):
        measured.load(tmp_path / "none")
    for path in (tmp_path, tmp_path / "none"):
        with pytest.raises(DataError) as caught:
            measured.load(path)
        assert str(caught.value).startswith(f"{path} ")
        assert "no file's name" not in str(caught.value)


# --- writers -------------------------------------------------------------------------------------

EON = gonio.model("eon", rho=(0.7, 0.4, 0.2), roughness=0.6)


@pytest.mark.parametrize(
    ("format", "error"),
    # Interpolation between the places of the tables, at cosines above 0.1
    [("merl", 5e-3), ("mbsdf", 5e-3), ("rgl", 0.1), ("csv", 0.15), ("alta", 0.15)],
)
def test_written_model_is_read_back(format: str, error: float, tmp_path: Path) -> None:
    path = tmp_path / f"eon{measured.formats()[format].SUFFIX}"
    assert measured.save(path, EON) == []
    found = measured.load(path)
    assert found.format == measured.formats()[format].NAME
    assert found.isotropic
    some = random.choice(np.flatnonzero(found.valid), 2000)
    wi, wo = found.wi[some].astype(float), found.wo[some].astype(float)
    high = (wi[:, 2] > 0.02) & (wo[:, 2] > 0.02)
    # At its own places a file has the model's values, but for single precision of the directions
    exact = EON.eval(
        wi / np.linalg.norm(wi, axis=-1, keepdims=True),
        wo / np.linalg.norm(wo, axis=-1, keepdims=True),
    )
    assert np.allclose(found.values[some][high], exact[high], rtol=SINGLE_LONG, atol=SINGLE)
    wi, wo = directions(2000), directions(2000)
    off = np.abs(found.evaluate(wi, wo) - EON.eval(wi, wo)) / EON.eval(wi, wo)
    assert np.percentile(off, 99) < error


def test_writing_fails_without_leaving_anything(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="give one of the formats"):
        measured.save(tmp_path / "eon.xyz", EON)

    class Broken:
        title, channels, wavelengths, isotropic = "broken", ("r", "g", "b"), None, True

        def evaluate(self, wi: Any, wo: Any) -> Any:
            raise ArithmeticError

    for format, module in measured.writers().items():
        with pytest.raises(ArithmeticError):
            measured.save(tmp_path / f"x{module.SUFFIX}", Broken(), format)
    assert list(tmp_path.iterdir()) == []


def test_anisotropy_that_a_format_cannot_keep_is_named(tmp_path: Path) -> None:
    brushed = gonio.model("torrance_sparrow", alpha=0.4, anisotropy=0.6)
    assert measured.save(tmp_path / "b.binary", brushed) == [
        "anisotropy: an average over eight azimuths"
    ]
    assert measured.save(tmp_path / "b.alta", brushed) == []
    assert not measured.load(tmp_path / "b.alta").isotropic


def test_rgl_agrees_with_mitsubas_measured_plug_in(tmp_path: Path) -> None:
    import drjit as dr
    import mitsuba as mi

    import gonio.mitsuba

    mi.set_variant("llvm_ad_rgb")
    for model, isotropic in (
        (gonio.model("torrance_sparrow"), True),
        (gonio.model("torrance_sparrow", alpha=0.3, anisotropy=0.5), False),
    ):
        path = tmp_path / "x.bsdf"
        measured.save(path, model, "rgl", thetas=10, side=24, phis=8)
        found = measured.load(path)
        assert found.isotropic == isotropic
        wi, wo = directions(4000), directions(4000)
        plugin = mi.load_dict({"type": "measured", "filename": str(path)})
        si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
        si.wi = mi.Vector3f(wo.T.astype(np.float32))  # Mitsuba's known direction
        si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
        light = mi.Vector3f(wi.T.astype(np.float32))
        theirs = np.array(plugin.eval(mi.BSDFContext(), si, light)).T
        mine = found.evaluate(wi, wo) * wi[:, 2:]
        # Mitsuba computes in single precision
        assert np.abs(mine - theirs).max() < 2e-4 * theirs.max()
        assert np.median(np.abs(mine - theirs) / np.maximum(theirs, 1e-4)) < 2e-6
        # And both are the model: the plug-in samples what the file says
        u = random.random((4000, 2)).T.astype(np.float32)
        sample, weight = plugin.sample(mi.BSDFContext(), si, mi.Float(0.5), mi.Point2f(u))
        good = np.array(sample.pdf) > 0
        assert good.mean() > 0.5
        assert np.array(weight).T[good].max() < 20


# --- spectra -------------------------------------------------------------------------------------


def test_a_spectrum_without_colour_is_grey_and_red_light_is_red() -> None:
    wavelengths = np.arange(400, 701, 10.0)
    matrix = rgb_matrix(wavelengths)
    assert np.allclose(matrix.sum(-1), 1)
    red = matrix @ np.where(wavelengths > 620, 1.0, 0.0)
    assert red[0] > 5 * abs(red[1])
    # IEC 61966-2-1: luminance of the primaries. Green light carries most of it.
    green = matrix @ np.where((wavelengths > 520) & (wavelengths < 580), 1.0, 0.0)
    assert green @ [0.2126, 0.7152, 0.0722] > 2 * (red @ [0.2126, 0.7152, 0.0722])


# --- real files ----------------------------------------------------------------------------------


@with_samples
def test_real_files_are_read() -> None:
    for path in sorted(SAMPLES.iterdir()):
        for found in measured.load_parts(path):
            assert found.valid.any(), path


@with_samples
def test_two_formats_of_one_sample_agree() -> None:
    zemax = measured.load(SAMPLES / "AnoBlackEC1onAlum.bsdf")
    fred = measured.load(SAMPLES / "AnoBlackEC1onAlum_fullAz.txt")
    values, covered = zemax.interpolate(fred.wi, fred.wo)
    off = np.abs(np.log(values[:, 0] / fred.values[:, 0]))
    assert covered.mean() > 0.9
    # Their grids differ, and the highlight at 70° is sharp; with the azimuth turned it is 0.43
    assert np.median(off) < 0.1
    turned = zemax.evaluate(fred.wi, fred.wo * [-1, -1, 1])
    assert np.median(np.abs(np.log(turned[:, 0] / fred.values[:, 0]))) > 0.3


@with_samples
def test_real_paint_has_its_highlight_in_the_mirror_direction() -> None:
    for name in ("carpaint_red.mbsdf", "AnoBlackNiTEonINVAR.bsdf"):
        found = measured.load(SAMPLES / name)
        brightest = int(np.argmax(found.values[:, 0]))
        mirror = found.wi[brightest] * [-1, -1, 1]
        assert mirror @ found.wo[brightest] > 0.95  # within 18°, off-specular at grazing


def test_spectral_rgl_keeps_its_wavelengths_and_mitsuba_reads_them(tmp_path: Path) -> None:
    import drjit as dr
    import mitsuba as mi

    wavelengths = np.array([400.0, 500.0, 600.0, 700.0])

    class Spectral:
        title, isotropic = "a ramp", True
        channels = tuple(f"{w:g} nm" for w in wavelengths)

        def __init__(self) -> None:
            self.wavelengths = wavelengths

        def evaluate(self, wi: Any, wo: Any) -> Any:
            return EON.eval(wi, wo)[:, :1].astype(float) * (wavelengths / 700)

    path = tmp_path / "ramp.bsdf"
    lost = measured.save(path, Spectral(), thetas=8, side=16)
    assert lost == ["field rgb: linear sRGB by Mitsuba's CIE 1931 2° observer and D65"]
    found = measured.load(path)
    assert found.wavelengths is not None
    assert np.allclose(found.wavelengths, wavelengths)
    some = np.flatnonzero(found.valid)[::50]
    assert np.allclose(found.values[some, 0] / found.values[some, 3], 4 / 7, rtol=SINGLE)
    wi, wo = directions(500), directions(500)
    mi.set_variant("llvm_ad_spectral")
    try:
        plugin = mi.load_dict({"type": "measured", "filename": str(path)})
        si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
        si.wi = mi.Vector3f(wo.T.astype(np.float32))
        si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
        si.wavelengths = mi.UnpolarizedSpectrum(*(float(w) for w in wavelengths))
        light = mi.Vector3f(wi.T.astype(np.float32))
        theirs = np.array(plugin.eval(mi.BSDFContext(), si, light)).T
    finally:
        mi.set_variant("llvm_ad_rgb")
    mine = found.evaluate(wi, wo) * wi[:, 2:]
    assert np.abs(mine - theirs).max() < 2e-4 * theirs.max()
