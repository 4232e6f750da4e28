"""Plots: their numbers against closed forms, and their files."""

import csv
import io
import math
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from support.tolerances import DOUBLE, DOUBLE_DIVIDED, SINGLE

import gonio
from gonio import plot as plots
from gonio.plot import (
    Plot,
    albedo,
    cartesian,
    distribution,
    error,
    fresnel,
    masking,
    plot,
    polar,
    sampling,
    scattering,
    surface,
)
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
        np.testing.assert_allclose(f_cos, rho / math.pi * cosine, atol=DOUBLE_DIVIDED)


def test_without_the_cosine_a_lambert_lobe_is_constant():
    f = polar([gonio.Lambert()], cosine=False).columns["f red [1/sr]"]
    np.testing.assert_allclose(f, 0.8 / math.pi, rtol=DOUBLE)


def test_positive_angles_are_the_viewers_side():
    columns = polar([gonio.FON(roughness=1)], theta_o=60, cosine=False).columns
    at = dict(zip(columns["theta_i [deg]"], columns["f red [1/sr]"], strict=True))
    A_F = 1 / (1.5 - 2 / (3 * math.pi))
    # s/t = sin^2 / cos for wi = wo, and -sin^2 for the mirror direction (Eq. 10 and 11 of EON)
    assert at[60] == pytest.approx(0.8 / math.pi * A_F * (1 + 0.75 / 0.5), rel=DOUBLE)
    assert at[-60] == pytest.approx(0.8 / math.pi * A_F * (1 - 0.75), rel=DOUBLE)


def test_white_eon_has_albedo_1_in_every_row():
    columns = albedo([gonio.EON(rho=1, roughness=r) for r in (0, 0.4, 1)]).columns
    assert {*columns["albedo"]} == {"directional", "mean"}
    for colour in plots.RGB:
        np.testing.assert_allclose(columns[f"albedo {colour}"], 1, atol=SINGLE)


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
    np.testing.assert_allclose(value, expected, rtol=SINGLE)


def test_a_lambert_surface_is_a_sphere():
    columns = surface([gonio.Lambert()], theta_o=(0, 45)).columns
    theta = np.radians(columns["theta_i [deg]"])
    np.testing.assert_allclose(
        columns["f_cos red [1/sr]"], 0.8 / math.pi * np.cos(theta), atol=DOUBLE
    )


def test_sampling_weights_average_to_the_albedo():
    columns = sampling([gonio.EON(rho=1, roughness=1), gonio.Lambert()], samples=20_000).columns
    name = np.array(columns["model"])
    mean = np.array(columns["mean of weight, luminance"])
    variance = np.array(columns["variance of weight, luminance"])
    eon = np.char.startswith(name, "eon")
    # five times the error of a mean of 20,000 weights of variance 0.029, the largest there is
    np.testing.assert_allclose(mean[eon], 1, atol=5 * math.sqrt(0.029 / 20_000))
    np.testing.assert_allclose(mean[~eon], 0.8, rtol=SINGLE)
    # cosine sampling is exact for Lambert
    assert variance[~eon].max() < 1e-10
    np.testing.assert_allclose(np.array(columns["maximum of weight, luminance"])[~eon], 0.8, 1e-5)


def test_variance_and_maximum_of_cosine_sampling_are_those_of_the_brdf():
    white = gonio.EON(rho=1, roughness=1, sampler="cosine")
    columns = sampling([white], along="roughness", theta_o=60, samples=200_000).columns
    last = columns["roughness"].index(1.0)
    # E[w^2] = pi * integral of f^2 cos, by midpoints in cos^2 (the sampler's own density) and azimuth
    n = 1000
    x = (np.arange(n) + 0.5) / n
    mu, phi = np.sqrt(x)[:, None], 2 * np.pi * x[None, ::4]
    s = np.sqrt(1 - mu * mu)
    wi = np.stack(np.broadcast_arrays(s * np.cos(phi), s * np.sin(phi), mu), -1)
    wo = np.array([math.sin(math.radians(60)), 0, 0.5])
    weight = np.pi * white.eval(wi, wo)[..., 0]
    # 200,000 weights that are not far from 1 know their variance to half a percent
    variance = columns["variance of weight, luminance"][last]
    assert variance == pytest.approx(np.mean(weight**2) - 1, rel=0.01)  # twice that
    highest = columns["maximum of weight, luminance"][last]
    # The largest of 200,000 lies next to the largest of all: the weight bends little there
    assert highest == pytest.approx(weight.max(), rel=1e-3)


def test_more_batches_have_the_same_statistics(monkeypatch):
    from gonio.plot import numbers

    white, at = gonio.EON(rho=1, roughness=1), np.array([60.0])
    whole = numbers.sample_weights(white, at, "red", 30_000)
    monkeypatch.setattr(numbers, "BATCH", 7_000)
    np.testing.assert_allclose(
        numbers.sample_weights(white, at, "red", 30_000), whole, rtol=DOUBLE_DIVIDED
    )


def test_sampling_along_a_parameter_needs_one():
    with pytest.raises(ValueError, match="lambert has no number 'roughness' to plot along"):
        sampling([gonio.Lambert()], along="roughness")
    with pytest.raises(ValueError, match="theta_o goes with along"):
        sampling([gonio.Lambert()], theta_o=30)


def test_a_cartesian_slice_is_the_polar_one_turned_and_any_plane_can_be_had():
    model = gonio.FON(roughness=1)
    A_F = 1 / (1.5 - 2 / (3 * math.pi))
    columns = cartesian([model], theta_o=60, phi=(0, 90), cosine=False).columns
    rows = zip(*(columns[n] for n in ("phi [deg]", "theta_i [deg]", "f red [1/sr]")), strict=True)
    at = {(phi, theta): f for phi, theta, f in rows}
    # s/t = sin^2 / cos for wi = wo, and 0 across (Eq. 10 and 11 of EON)
    assert at[0, 60] == pytest.approx(0.8 / math.pi * A_F * 2.5, rel=DOUBLE)
    assert at[90, 60] == pytest.approx(0.8 / math.pi * A_F, rel=DOUBLE)
    polar_columns = polar([model], theta_o=60, phi=90, cosine=False).columns
    across = [f for (phi, _), f in at.items() if phi == 90]
    np.testing.assert_allclose(polar_columns["f red [1/sr]"], across, rtol=DOUBLE)


def test_a_light_that_turns_passes_viewer_and_mirror_direction():
    columns = cartesian([gonio.FON(roughness=1)], theta_o=60, theta_i=60, cosine=False).columns
    at = dict(zip(columns["phi_i - phi_o [deg]"], columns["f red [1/sr]"], strict=True))
    A_F = 1 / (1.5 - 2 / (3 * math.pi))
    assert at[0] == pytest.approx(0.8 / math.pi * A_F * 2.5, rel=DOUBLE_DIVIDED)
    assert at[180] == pytest.approx(0.8 / math.pi * A_F * 0.25, rel=DOUBLE_DIVIDED)


def test_multiple_scattering_is_what_eon_adds_to_fon():
    columns = scattering([gonio.EON(rho=1, roughness=1)], theta_o=60).columns
    whole, single, multiple = (
        np.array(columns[f"f_cos, {part}, red [1/sr]"]) for part in ("all", "single", "multiple")
    )
    # A few roundings of double precision
    np.testing.assert_allclose(single + multiple, whole, atol=1e-15)
    at = columns["theta_i [deg]"].tolist().index(0.0)
    # Eq. 19 at rho = 1 for the normal and 60 degrees, with E_F of Eq. 13 and its mean of Eq. 15
    C1 = 0.5 - 2 / (3 * math.pi)
    mean = (1 + 2 / 3 - 28 / (15 * math.pi)) / (1 + C1)

    def E(theta):
        s, c = math.sin(theta), math.cos(theta)
        G = s * (theta - s * c) + 2 / 3 * (s / c * (1 - s**3) - s)
        return (1 + G / math.pi) / (1 + C1)

    expected = (1 - E(0)) * (1 - E(math.pi / 3)) / (1 - mean) / math.pi
    assert multiple[at] == pytest.approx(expected, rel=DOUBLE_DIVIDED)
    with pytest.raises(ValueError, match="lambert does not tell single scattering from multiple"):
        scattering([gonio.Lambert()])


def test_dots_of_albedos_are_quadratures_and_lie_on_the_formula():
    figure = albedo([gonio.FON(rho=1, roughness=1)], dots=True).figure()
    curve, dots = figure.axes[0].lines[:2]
    assert dots.get_linestyle() == "None"
    on_curve = np.interp(dots.get_xdata(), curve.get_xdata(), curve.get_ydata())
    # the curve's points are half a degree apart
    np.testing.assert_allclose(dots.get_ydata(), on_curve, atol=2e-5)


def test_the_fit_s_error_is_as_small_as_the_paper_says():
    models = [gonio.EON(rho=1, roughness=1, albedo_form=f) for f in ("exact", "fitted")]
    columns = error(models, theta_o=60).columns
    of = np.array(columns["of"])
    # Section 2.2: "less than 0.1 %"
    found = np.abs(np.array(columns["error red [%]"]))[of == "albedo"].max()
    assert 0.01 < found < 0.1


def test_distributions_have_their_peaks_and_tails():
    ggx, beckmann = (gonio.TorranceSparrow(alpha=0.3, distribution=d) for d in ("ggx", "beckmann"))
    columns = distribution([ggx, beckmann], log=True).columns
    theta = np.array(columns["theta_m [deg]"]).reshape(2, -1)[0]
    D = np.array(columns["D [1/sr]"]).reshape(2, -1)
    np.testing.assert_allclose(D[:, 0], 1 / (math.pi * 0.09), rtol=DOUBLE)
    at = int(np.argmin(abs(theta - 45)))
    t = math.radians(theta[at])
    tan2, cos4 = math.tan(t) ** 2, math.cos(t) ** 4
    assert D[0, at] == pytest.approx(
        0.09 / (math.pi * cos4 * (0.09 + tan2) ** 2), rel=DOUBLE_DIVIDED
    )
    assert D[1, at] == pytest.approx(
        math.exp(-tan2 / 0.09) / (math.pi * 0.09 * cos4), rel=DOUBLE_DIVIDED
    )


def test_a_logarithmic_axis_ends_at_the_peak_however_low_the_tails_are():
    beckmann = gonio.TorranceSparrow(alpha=0.1, distribution="beckmann")  # 1e-1400 at 89 degrees
    low, high = distribution([beckmann], log=True).figure().axes[0].get_ylim()
    peak = 1 / (math.pi * 0.01)
    assert peak < high < 3 * peak
    assert 1e-9 < low < 1e-3


@pytest.mark.parametrize("beside", [(), (1.0,)])
def test_a_logarithmic_axis_shows_the_whole_tail_of_narrow_facets(beside):
    models = [gonio.TorranceSparrow(alpha=a, distribution="ggx") for a in (0.01, *beside)]
    low, high = distribution(models, log=True).figure().axes[0].get_ylim()
    assert high > 1 / (math.pi * 0.01**2)  # D along the normal
    assert low < 0.01**2 / math.pi < 1e4 * low  # D across it


def test_masking_of_v_cavities_is_theirs():
    columns = masking([gonio.TorranceSparrow(masking="cook_torrance")], theta_i=60).columns
    at = dict(zip(np.round(columns["theta_o [deg]"], 6), columns["G"], strict=True))
    angle = min(at, key=lambda a: abs(a - 75))
    wi = np.array([math.sin(math.radians(60)), 0, 0.5])
    wo = np.array([math.sin(math.radians(angle)), 0, math.cos(math.radians(angle))])
    h = (wi + wo) / np.linalg.norm(wi + wo)
    expected = min(1, 2 * h[2] * min(wi[2], wo[2]) / (wo @ h))
    assert at[angle] == pytest.approx(expected, rel=SINGLE)


def test_fresnel_terms_of_layers_are_told_apart():
    layered = gonio.TriAceLayered(bottom_fresnel="constant", top_transmission="off")
    columns = fresnel([layered]).columns
    term = np.array(columns["term"])
    values = np.array(columns["reflectance red"])
    f0 = (0.33333 / 2.33333) ** 2
    assert values[term == "F, upper layer"][0] == pytest.approx(f0, rel=DOUBLE_DIVIDED)
    # Eq. 5 of the course: F0(n2/n1) (1 - F0(1/n1))
    bottom = ((1.5 - 1.33333) / (1.5 + 1.33333)) ** 2 * (1 - f0)
    np.testing.assert_allclose(values[term == "lower layer"], bottom, rtol=DOUBLE_DIVIDED)


MODELS = [
    gonio.Lambert(),
    gonio.EON(rho=(0.8, 0.3, 0.1)),
    gonio.QON(sigma=1.0),
    gonio.TriAceOrenNayar(),
]


FACETS = [gonio.TorranceSparrow(), gonio.TorranceSparrow(distribution="beckmann")]
OF_KIND = {
    "scattering": [gonio.EON()],
    "distribution": FACETS,
    "masking": FACETS,
    "fresnel": [*FACETS, gonio.WeidlichWilkie(), gonio.TriAceLayered()],
}


# Suffixes are no matter of a kind: one with axes and one in space stand for all.
WRITTEN = [(k, ".png") for k in plots.KINDS] + [
    (k, suffix) for k in ("polar", "surface") for suffix in (".svg", ".pdf")
]


@pytest.mark.parametrize(("kind", "suffix"), WRITTEN)
def test_pictures_are_written(kind, suffix, tmp_path):
    models = MODELS if kind in {"polar", "albedo"} and suffix == ".png" else MODELS[:2]
    models = OF_KIND.get(kind, models)
    settings = {"samples": 256} if kind == "sampling" else {}
    path = plot(models, kind, tmp_path / f"x{suffix}", dpi=40, **settings)
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


@pytest.mark.parametrize(("alpha", "own"), [(0.05, True), (1.0, False)])
def test_lobes_of_very_different_sizes_have_scales_of_their_own(alpha: float, own: bool) -> None:
    coat = gonio.model("weidlich_wilkie", alpha=alpha)
    made = polar([coat], theta_o=(0, 80))
    figure = made.figure()
    widths = [panel.get_xlim()[1] for panel in figure.axes[:2]]
    said = any("a scale of its own" in text.get_text() for text in figure.texts)
    assert said == (widths[0] != widths[1]) == own


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


def test_materials_are_called_by_their_names():
    models, labels, shared = named(
        [gonio.load("gold"), gonio.load("gold:alpha=0.3"), gonio.EON(rho=0.5)]
    )
    assert labels == ["gold", "gold, alpha = 0.3", "eon, rho = 0.5, roughness = 0.5"]
    assert shared == ""
    assert models[1] == gonio.load("gold:alpha=0.3").model


def test_of_many_parameters_those_are_told_that_were_changed():
    patina = gonio.Patina()
    assert named([patina])[2] == "all parameters at their defaults"
    told = named([patina.replace(alpha=0.2)])[2]
    assert told == "alpha = 0.2, other parameters at their defaults"
    narrow, wide = (gonio.TorranceSparrow(alpha=a) for a in (0.01, 1))
    assert named([narrow, wide])[2] == "other parameters at their defaults"
    assert named([patina, patina.replace(alpha=0.2)])[1] == [
        "patina, alpha = 0.5",
        "patina, alpha = 0.2",
    ]


def test_long_labels_stay_inside_the_picture():
    models = [gonio.load(name).model for name in ("gold", "ceramic", "skin")]
    figure = albedo(models).figure()
    figure.draw_without_rendering()
    box = figure.legends[0].get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= figure.bbox.x1
    assert box.y0 >= 0
    below = min(panel.get_tightbbox().y0 for panel in figure.axes)
    assert box.y1 <= below, "the legend covers a panel"


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
        (("lobe", "x.png"), {}, "no plot 'lobe'; known are polar, cartesian, surface,"),
        (("polar", "x.gif"), {}, "'x.gif': its name must end in .png, .svg, .pdf or .csv."),
        (("polar", "x"), {}, "'x': its name must end in .png, .svg, .pdf or .csv."),
        (("polar", "x.csv"), {"theta_o": 90}, "theta_o=90 is out of range; allowed is 0 to less"),
        (("polar", "x.csv"), {"theta_o": ()}, "theta_o must hold at least one angle."),
        (("polar", "x.csv"), {"channel": "y"}, "no channel 'y'; known are luminance, red, green,"),
        (("albedo", "x.csv"), {"theta_o": 3}, "no theta_o; it takes along, dots, channel,"),
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


def test_inner_models_are_told_in_labels():
    coats = [gonio.WeidlichWilkie(base=base) for base in ("lambert", "phong")]
    _, labels, _ = named(coats)
    assert labels == ["weidlich_wilkie, base = lambert", "weidlich_wilkie, base = phong"]


def test_the_facts_of_a_deep_model_leave_room_for_its_curves(tmp_path: Path) -> None:
    """matplotlib warns, which is an error here, where text leaves the axes no room."""
    deep: gonio.Model = gonio.EON()
    for n in range(16):
        deep = gonio.WeidlichWilkie(base=deep, eta=1.1 + 0.01 * n, alpha=0.2, thickness=0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        polar([deep]).save(tmp_path / "a.png", dpi=40)
