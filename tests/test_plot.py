"""Plots: their numbers against closed forms, and their files."""

import csv
import io
import math
import re
from pathlib import Path

import numpy as np
import pytest

import gonio
from gonio import plot as plots
from gonio.plot import Plot, albedo, plot, polar, sampling, surface
from gonio.plot.labels import named

SIGNATURES = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def read(path_or_text):
    text = path_or_text if isinstance(path_or_text, str) else path_or_text.read_text()
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers(columns, name):
    return np.array(columns[name], np.float64)


def test_a_lambert_lobe_is_rho_over_pi_times_the_cosine(tmp_path):
    path = plot([gonio.Lambert(rho=(0.8, 0.3, 0.1))], "polar", tmp_path / "lambert.csv")
    columns = read(path)
    cosine = np.cos(np.radians(numbers(columns, "theta_i [deg]")))
    assert len(cosine) == 4 * 361
    for colour, rho in (("red", 0.8), ("green", 0.3), ("blue", 0.1)):
        f_cos = numbers(columns, f"f_cos {colour} [1/sr]")
        # 9 digits are written, of a value up to 0.25
        np.testing.assert_allclose(f_cos, rho / math.pi * cosine, atol=1e-9)


def test_without_the_cosine_a_lambert_lobe_is_constant():
    f = polar([gonio.Lambert()], cosine=False).columns["f red [1/sr]"]
    np.testing.assert_allclose(f, 0.8 / math.pi, rtol=1e-12)


def test_positive_angles_are_the_viewers_side():
    columns = polar([gonio.FON(roughness=1)], theta_o=60, cosine=False).columns
    at = dict(zip(columns["theta_i [deg]"], columns["f red [1/sr]"], strict=True))
    A_F = 1 / (1.5 - 2 / (3 * math.pi))
    # s/t = sin^2 / cos for wi = wo, and -sin^2 for the mirror direction (Eq. 10 and 11 of EON)
    assert at[60] == pytest.approx(0.8 / math.pi * A_F * (1 + 0.75 / 0.5), rel=1e-12)
    assert at[-60] == pytest.approx(0.8 / math.pi * A_F * (1 - 0.75), rel=1e-12)


def test_white_eon_has_albedo_1_in_every_row():
    columns = albedo([gonio.EON(rho=1, roughness=r) for r in (0, 0.4, 1)]).columns
    assert {*columns["albedo"]} == {"directional", "mean"}
    for colour in plots.RGB:
        np.testing.assert_allclose(columns[f"albedo {colour}"], 1, atol=1e-6)


def test_mean_albedo_is_plotted_against_each_models_own_roughness():
    columns = albedo([gonio.FON(), gonio.QON(), gonio.Lambert()]).columns
    rows = [*zip(*(columns[n] for n in ("model", "albedo", "against", "x")), strict=True)]
    assert {r[2] for r in rows if r[0].startswith("fon") and r[1] == "mean"} == {"roughness", ""}
    assert {r[2] for r in rows if r[0].startswith("qon") and r[1] == "mean"} == {"sigma", ""}
    assert [r[2] for r in rows if r[0] == "lambert" and r[1] == "mean"] == [""]


def test_mean_albedo_of_fon_is_eq_15():
    columns = albedo([gonio.FON(rho=1)]).columns
    mean = [
        (x, value)
        for kind, against, x, value in zip(
            columns["albedo"], columns["against"], columns["x"], columns["albedo red"], strict=True
        )
        if kind == "mean" and against == "roughness"
    ]
    r, value = np.array(mean).T
    expected = (1 + (2 / 3 - 28 / (15 * math.pi)) * r) / (1 + (0.5 - 2 / (3 * math.pi)) * r)
    assert r[[0, -1]].tolist() == [0, 1]
    np.testing.assert_allclose(value, expected, rtol=1e-6)


def test_a_lambert_surface_is_a_sphere():
    columns = surface([gonio.Lambert()], theta_o=(0, 45)).columns
    theta = np.radians(columns["theta_i [deg]"])
    np.testing.assert_allclose(
        columns["f_cos red [1/sr]"], 0.8 / math.pi * np.cos(theta), atol=1e-12
    )


def test_sampling_weights_average_to_the_albedo():
    columns = sampling([gonio.EON(rho=1, roughness=1), gonio.Lambert()]).columns
    name = np.array(columns["model"])
    mean = np.array(columns["mean weight, luminance"])
    variance = np.array(columns["variance of weight, luminance"])
    rare = np.array(columns["weight exceeded by 0.001 of samples, luminance"])
    eon = np.char.startswith(name, "eon")
    # 32768 evenly spread numbers integrate a weight between 0 and 2 to a few 1e-5
    np.testing.assert_allclose(mean[eon], 1, atol=2e-4)
    np.testing.assert_allclose(mean[~eon], 0.8, rtol=1e-6)
    # cosine sampling is exact for Lambert
    assert variance[~eon].max() < 1e-10
    np.testing.assert_allclose(rare[~eon], 0.8, rtol=1e-5)


def test_variance_of_cosine_sampling_is_the_integral_of_the_squared_brdf():
    columns = sampling([gonio.EON(rho=1, roughness=1, sampler="cosine")]).columns
    theta_o = 60.0
    variance = dict(
        zip(columns["theta_o [deg]"], columns["variance of weight, luminance"], strict=True)
    )[theta_o]
    # E[w^2] = pi * integral of f^2 cos, by midpoints in cos^2 (the sampler's own density) and azimuth
    n = 1000
    x = (np.arange(n) + 0.5) / n
    mu, phi = np.sqrt(x)[:, None], 2 * np.pi * x[None, ::4]
    s = np.sqrt(1 - mu * mu)
    wi = np.stack(np.broadcast_arrays(s * np.cos(phi), s * np.sin(phi), mu), -1)
    wo = np.array([math.sin(math.radians(theta_o)), 0, math.cos(math.radians(theta_o))])
    f = gonio.EON(rho=1, roughness=1).eval(wi, wo)[..., 0]
    expected = np.mean((np.pi * f) ** 2) - 1
    assert variance == pytest.approx(expected, rel=2e-3)


MODELS = [
    gonio.Lambert(),
    gonio.EON(rho=(0.8, 0.3, 0.1)),
    gonio.QON(sigma=1.0),
    gonio.TriAceOrenNayar(),
]


@pytest.mark.parametrize("suffix", SIGNATURES)
@pytest.mark.parametrize("kind", plots.KINDS)
def test_pictures_are_written(kind, suffix, tmp_path):
    models = MODELS if kind in {"polar", "albedo"} and suffix == ".png" else MODELS[:2]
    path = plot(models, kind, tmp_path / f"x{suffix}", dpi=40)
    assert path.read_bytes().startswith(SIGNATURES[suffix])
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_the_same_plot_gives_the_same_bytes(tmp_path):
    for suffix in SIGNATURES:
        one, two = (plot(MODELS[:2], "polar", tmp_path / f"{n}{suffix}", dpi=40) for n in "ab")
        assert one.read_bytes() == two.read_bytes()


def test_drawing_leaves_pyplot_alone(tmp_path):
    import matplotlib

    before = dict(matplotlib.rcParams)
    plot([gonio.Lambert()], "polar", tmp_path / "x.png", dpi=40)
    assert dict(matplotlib.rcParams) == before
    from matplotlib import pyplot

    assert pyplot.get_fignums() == []


def test_an_odd_number_of_panels_leaves_an_empty_one():
    figure = polar([gonio.Lambert()], theta_o=(0, 45, 80)).figure()
    assert [a.get_title() for a in figure.axes].count("") == 1


def test_a_growing_parameter_gets_an_ordered_colour_scale():
    figure = polar([gonio.EON(roughness=r) for r in (0, 1, 0.5)], theta_o=0).figure()
    handles = figure.legends[0].legend_handles
    brightness = [np.dot(h.get_color()[:3], plots.CHANNELS["luminance"]) for h in handles]
    assert brightness[0] < brightness[2] < brightness[1]


def test_labels_tell_what_differs_and_the_head_what_is_common():
    models = [gonio.EON(rho=0.5), gonio.EON(rho=0.5, sampler="cosine"), gonio.Lambert(rho=0.5)]
    _, labels, shared = named(models)
    assert labels == [
        "eon, roughness = 0.5, sampler = cltc_matched",
        "eon, roughness = 0.5, sampler = cosine",
        "lambert",
    ]
    assert shared == "rho = 0.5"


def test_an_interrupted_write_leaves_what_was_there(tmp_path, monkeypatch):
    path = tmp_path / "x.csv"
    path.write_text("before")

    def interrupt(self, target):
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        plot([gonio.Lambert()], "polar", path)
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["x.csv"]


def test_a_failing_drawing_leaves_nothing(tmp_path):
    def fail():
        raise RuntimeError("no ink")

    with pytest.raises(RuntimeError, match="no ink"):
        Plot({}, fail).save(tmp_path / "x.png")
    assert list(tmp_path.iterdir()) == []


def test_a_link_stays_a_link(tmp_path):
    target = tmp_path / "target.csv"
    link = tmp_path / "link.csv"
    link.symlink_to(target)
    plot([gonio.Lambert()], "polar", link)
    assert link.is_symlink()
    assert target.read_text().startswith("model,")


@pytest.mark.parametrize(
    ("arguments", "settings", "message"),
    [
        (("lobe", "x.png"), {}, "no plot 'lobe'; known are polar, albedo, surface, sampling."),
        (("polar", "x.gif"), {}, "'x.gif': its name must end in .png, .svg, .pdf or .csv."),
        (("polar", "x"), {}, "'x': its name must end in .png, .svg, .pdf or .csv."),
        (("polar", "x.csv"), {"theta_o": 90}, "theta_o=90 is out of range; allowed is 0 to less"),
        (("polar", "x.csv"), {"theta_o": ()}, "theta_o must hold at least one angle."),
        (("polar", "x.csv"), {"channel": "y"}, "no channel 'y'; known are luminance, red, green,"),
        (("albedo", "x.csv"), {"theta_o": 3}, "no theta_o; it takes along, channel, title."),
        (("albedo", "x.csv"), {"along": "eta"}, "none of the models has a number 'eta'"),
    ],
)
def test_mistakes_are_named_with_what_is_allowed(
    arguments, settings, message, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=re.escape(message)):
        plot([gonio.EON()], *arguments, **settings)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=re.escape(f"no folder '{tmp_path / 'no'}'.")):
        plot([gonio.Lambert()], "polar", tmp_path / "no" / "x.png")


def test_no_models_and_arrays_are_refused():
    with pytest.raises(ValueError, match="at least one model"):
        polar([])
    with pytest.raises(ValueError, match=r"eon\.roughness is an array; a plot needs numbers"):
        polar([gonio.EON(roughness=np.array([0.0, 1.0]))])
