"""Pictures and tables of models: lobes, albedos, and how well they are sampled.

    from gonio import plot
    plot.plot([gonio.Lambert(), gonio.EON(roughness=1)], "polar", "lobes.svg")
    plot.polar([gonio.EON(roughness=r) for r in (0, 0.5, 1)]).figure()      # a matplotlib Figure
    plot.albedo([gonio.EON(), gonio.QON()]).columns                         # the numbers

Angles are in degrees. Each kind of plot is a function that takes models and returns a `Plot`.
matplotlib loads when one is drawn; pyplot and its figures are not touched.
"""

from __future__ import annotations

import csv
import functools
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio import arrays, backend
from gonio.files import replacing
from gonio.model import Model, Parameter

Floats = npt.NDArray[np.float64]
Columns = dict[str, Any]

# Okabe and Ito's colours, which people with any colour vision can tell apart, without the yellow
# that is too pale for a line. Dashes show curves that lie on one another, and help in grey print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#56B4E9", "#E69F00")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (7, 2, 1.5, 2)))
INK, FAINT, GRID = "#222222", "#666666", "#d9d9d9"

CHANNELS: dict[str, tuple[float, float, float]] = {
    "luminance": (0.2126, 0.7152, 0.0722),  # of linear sRGB
    "red": (1, 0, 0),
    "green": (0, 1, 0),
    "blue": (0, 0, 1),
}
RGB = ("red", "green", "blue")

SUFFIXES = (".png", ".svg", ".pdf", ".csv")

# A parameter with one of these names is the one that mean albedos are plotted against.
ROUGHNESS_NAMES = ("roughness", "sigma", "alpha", "shininess")

# Random numbers per direction of the viewer in the sampling plot.
SAMPLES_COMPILED, SAMPLES_SCALAR = 32768, 512

# How rare a weight may be to count as the largest. Some samplers have no largest weight at all.
RARE = 1e-3


@dataclass(frozen=True)
class Plot:
    """The numbers of a plot, and how to draw them."""

    columns: Mapping[str, Any]
    """Equally long columns by name, ready for a data frame; the names say the units."""
    draw: Callable[[], Any]

    def figure(self) -> Any:
        """Draw a new `matplotlib.figure.Figure`."""
        import matplotlib

        with matplotlib.rc_context(_STYLE):
            return self.draw()

    def save(self, output: str | Path, dpi: int = 200) -> Path:
        """Write a picture, or the numbers, as the suffix says: .png, .svg, .pdf or .csv.

        dpi: dots per inch of a PNG, and of the shaded surfaces inside SVG and PDF. The file appears
        when it is complete; when writing fails, what was there before stays. The same plot gives
        the same bytes.

        Raises:
            ValueError: a suffix that is not known.
            OSError: the folder does not exist or cannot be written to.
        """
        path = check_output(output)
        if path.suffix.lower() == ".csv":
            content = self.csv().encode()
        else:
            import matplotlib

            kind = path.suffix.lower()[1:]
            # Dates and random ids would make every file different.
            dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}
            buffer = io.BytesIO()
            with matplotlib.rc_context(_STYLE):
                self.draw().savefig(buffer, format=kind, dpi=dpi, metadata=dates[kind])
            content = buffer.getvalue()
        with replacing(path) as temporary:
            temporary.write_bytes(content)
        return path

    def csv(self) -> str:
        """The columns as comma-separated text with a header; numbers have 9 digits."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        for row in zip(*self.columns.values(), strict=True):
            writer.writerow([v if isinstance(v, str) else f"{v:.9g}" for v in row])
        return text.getvalue()


def plot(
    models: Sequence[Model],
    kind: str = "polar",
    output: str | Path = "plot.png",
    *,
    dpi: int = 200,
    **settings: Any,
) -> Path:
    """Plot models to a .png, .svg, .pdf or .csv file and return its path.

    Args:
        models: one or more models whose parameters are numbers, not arrays.
        kind: "polar", "albedo", "surface" or "sampling"; see the functions of these names, which
            take the further settings, such as theta_o=(0, 60).
        output: the file; an existing one is replaced.
        dpi: dots per inch of a PNG.

    Raises:
        ValueError: an unknown kind, suffix or setting.
        OSError: the file cannot be written.
    """
    if kind not in KINDS:
        raise ValueError(f"no plot {kind!r}; known are {', '.join(KINDS)}.")
    check_output(output)  # before the work, not after
    allowed = KINDS[kind].__kwdefaults__ or {}
    for name in settings:
        if name not in allowed:
            raise ValueError(f"the {kind} plot has no {name}; it takes {', '.join(allowed)}.")
    return KINDS[kind](models, **settings).save(output, dpi)


def check_output(output: str | Path) -> Path:
    """The path of a file that can be written, or a ValueError or OSError that says why not."""
    path = Path(output)
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(
            f"cannot write {str(output)!r}: its name must end in {', '.join(SUFFIXES[:-1])} "
            f"or {SUFFIXES[-1]}."
        )
    if not path.parent.is_dir():
        raise FileNotFoundError(f"cannot write {str(output)!r}: no folder {str(path.parent)!r}.")
    if path.is_dir():
        raise IsADirectoryError(f"cannot write {str(output)!r}: it is a folder.")
    return path


# ------------------------------------------------------------------------------- what is plotted


def polar(
    models: Sequence[Model],
    *,
    theta_o: Sequence[float] | float = (0, 30, 60, 80),
    cosine: bool = True,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Slices through the lobes in the plane of incidence: f cos(theta_i) against theta_i.

    Args:
        models: the models, one curve each.
        theta_o: polar angles of the viewer in degrees, 0 to 90, one panel each.
        cosine: False plots f alone.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.

    theta_i is signed: positive on the viewer's side (retro-reflection), negative on the other.
    """
    models, labels, shared = _named(models)
    angles = _angles(theta_o)
    theta_i = np.linspace(-90, 90, 361)
    wi = _direction(theta_i)
    values = np.stack(
        [[_value(m, wi, _direction(a), cosine) for a in angles] for m in models]
    )  # model, theta_o, theta_i, rgb
    columns: Columns = {
        "model": np.repeat(labels, len(angles) * len(theta_i)).tolist(),
        "theta_o [deg]": np.tile(np.repeat(angles, len(theta_i)), len(models)),
        "theta_i [deg]": np.tile(theta_i, len(models) * len(angles)),
        **_rgb_columns(_symbol(cosine, "f_cos", "f"), values, " [1/sr]"),
    }
    draw = functools.partial(
        _draw_polar,
        labels,
        _styles(models),
        shared,
        angles,
        theta_i,
        _choose(values, channel),
        cosine,
        _channel_note(values, channel),
        title,
    )
    return Plot(columns, draw)


def albedo(
    models: Sequence[Model],
    *,
    along: str | None = None,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Directional albedo against the viewer's angle, and mean albedo against the roughness.

    Args:
        models: the models, one curve each.
        along: the parameter that the mean albedo is plotted against; by default a model's
            roughness, sigma, alpha or shininess. Models without it are drawn as a level line.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = _named(models)
    theta_o = np.linspace(0, 90, 19 if _slow() else 181)
    wo = _direction(theta_o)
    directional = np.stack([m.albedo(wo) for m in models]).astype(np.float64)
    parameters = [_roughness_parameter(m, along) for m in models]
    if along is not None and not any(parameters):
        raise ValueError(f"none of the models has a number {along!r} to plot along.")
    axes = {p.name: p for p in parameters if p is not None}
    sweeps: list[tuple[str, Floats, Floats]] = []
    for m, p in zip(models, parameters, strict=True):
        if p is None:
            sweeps.append(("", np.empty(0), np.empty((0, 3))))
            continue
        x = _sweep(p)
        sweeps.append((p.name, x, np.asarray(m.replace(**{p.name: x}).mean_albedo())))
    means = np.stack([m.mean_albedo() for m in models]).astype(np.float64)

    rows: list[tuple[str, str, str, float, Floats]] = []
    for label, curve, (name, x, mean), own in zip(labels, directional, sweeps, means, strict=True):
        rows += [
            (label, "directional", "theta_o [deg]", *r) for r in zip(theta_o, curve, strict=True)
        ]
        rows += [(label, "mean", name, *r) for r in zip(x, mean, strict=True)]
        rows += [(label, "mean", "", math.nan, own)]
    rgb = np.array([r[4] for r in rows])
    columns: Columns = {
        "model": [r[0] for r in rows],
        "albedo": [r[1] for r in rows],
        "against": [r[2] for r in rows],
        "x": [r[3] for r in rows],
        **_rgb_columns("albedo", rgb, ""),
    }
    note = _channel_note(directional, channel)
    # Models that differ only in the swept parameter share one mean curve.
    families = [
        repr(m.replace(**{p.name: p.default})) if p else repr(m)
        for m, p in zip(models, parameters, strict=True)
    ]
    draw = functools.partial(
        _draw_albedo,
        models,
        labels,
        _styles(models),
        shared,
        axes,
        families,
        theta_o,
        _choose(directional, channel),
        [(name, x, _choose(mean, channel)) for name, x, mean in sweeps],
        _choose(means, channel),
        note,
        title,
    )
    return Plot(columns, draw)


def surface(
    models: Sequence[Model],
    *,
    theta_o: Sequence[float] | float = 60,
    cosine: bool = True,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Lobes as shaded surfaces in space, with the normal, the viewer and the mirror direction.

    Args:
        models: the models, one panel each for every angle.
        theta_o: polar angles of the viewer in degrees, 0 to 90.
        cosine: the distance from the origin is f cos(theta_i); False makes it f.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.
    """
    models, labels, shared = _named(models)
    angles = _angles(theta_o)
    theta_i = np.linspace(0, 90, 91)
    phi = np.linspace(0, 360, 181)
    wi = _direction(theta_i[:, None], phi[None, :])
    values = np.stack(
        [[_value(m, wi, _direction(a), cosine) for a in angles] for m in models]
    )  # model, theta_o, theta_i, phi, rgb
    count = len(models) * len(angles)
    columns: Columns = {
        "model": np.repeat(labels, len(angles) * theta_i.size * phi.size).tolist(),
        "theta_o [deg]": np.tile(np.repeat(angles, theta_i.size * phi.size), len(models)),
        "theta_i [deg]": np.tile(np.repeat(theta_i, phi.size), count),
        "phi_i - phi_o [deg]": np.tile(phi, theta_i.size * count),
        **_rgb_columns(_symbol(cosine, "f_cos", "f"), values, " [1/sr]"),
    }
    draw = functools.partial(
        _draw_surface,
        labels,
        _styles(models),
        shared,
        angles,
        wi,
        _choose(values, channel),
        cosine,
        _channel_note(values, channel),
        title,
    )
    return Plot(columns, draw)


def sampling(
    models: Sequence[Model],
    *,
    channel: str = "luminance",
    title: str | None = None,
) -> Plot:
    """Variance and highest values of the Monte Carlo weight f cos(theta_i) / pdf against theta_o.

    Args:
        models: the models, one curve each; samplers are compared as options of a model.
        channel: "luminance", "red", "green" or "blue".
        title: replaces the title.

    The highest value is the one that one sample in 1000 exceeds. Where a density goes to 0 before
    the BRDF does, as that of CLTC alone, the weight has no bound and no finite variance; what is
    shown then is what 1e7 samples would find. A wasted sample counts as weight 0.
    """
    models, labels, shared = _named(models)
    _known_channel(channel)
    theta_o = np.append(np.arange(0, 88.5, 1.5), (88.5, 89, 89.5, 89.9))
    statistics = np.stack([_weights(m, theta_o, channel) for m in models])
    columns: Columns = {
        "model": np.repeat(labels, theta_o.size).tolist(),
        "theta_o [deg]": np.tile(theta_o, len(models)),
        f"mean weight, {channel}": statistics[..., 0].ravel(),
        f"variance of weight, {channel}": statistics[..., 1].ravel(),
        f"weight exceeded by {RARE:g} of samples, {channel}": statistics[..., 2].ravel(),
    }
    note = "" if all(_is_grey(m) for m in models) else channel
    draw = functools.partial(
        _draw_sampling, labels, _styles(models), shared, theta_o, statistics, note, title
    )
    return Plot(columns, draw)


KINDS: dict[str, Callable[..., Plot]] = {
    "polar": polar,
    "albedo": albedo,
    "surface": surface,
    "sampling": sampling,
}


def _slow() -> bool:
    """Whether plain Python computes, for which plots take fewer points."""
    return backend.current() == "scalar"


def _direction(theta: Any, phi: Any = 0.0) -> Floats:
    """Unit vectors, shape (..., 3), from polar angles and azimuths in degrees."""
    theta, phi = np.radians(theta), np.radians(phi)
    x, y, z = np.broadcast_arrays(
        np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    )
    return np.stack([x, y, z], -1)


def _value(model: Model, wi: Floats, wo: Floats, cosine: bool) -> Floats:
    f = np.asarray(model.eval(wi, wo), np.float64)
    return f * wi[..., 2:] if cosine else f


def _weights(model: Model, theta_o: Floats, channel: str) -> Floats:
    """Mean, variance and rare maximum of the weight, shape (len(theta_o), 3)."""
    u, share = _random_numbers(SAMPLES_SCALAR if _slow() else SAMPLES_COMPILED)
    wo = _direction(theta_o)[:, None, :].astype(np.float32)
    wi, pdf = model.sample(wo, u.astype(np.float32))
    f_cos = _choose(model.eval(wi, wo), channel) * wi[..., 2]
    weight = np.where(pdf > 0, f_cos / np.where(pdf > 0, pdf, 1), 0)
    mean = weight @ share
    variance = (weight - mean[:, None]) ** 2 @ share
    order = np.argsort(-weight, axis=1)
    exceeded = np.cumsum(share[order], axis=1) >= RARE
    rare = np.take_along_axis(order, exceeded.argmax(axis=1)[:, None], axis=1)
    return np.stack([mean, variance, np.take_along_axis(weight, rare, axis=1)[:, 0]], -1)


def _random_numbers(count: int) -> tuple[Floats, Floats]:
    """Pairs in [0, 1), shape (count, 2), and the share of all samples that each stands for.

    Evenly spread (Roberts' R2 sequence), and denser towards the ends of the first number: there lie
    the horizon and the samplers' edges, where the weights are rare and high.
    """
    golden = 1.3247179572447460  # the root of x^3 = x + 1
    v = (0.5 + np.arange(1, count + 1)[:, None] / (golden, golden**2)) % 1
    ends = v[:, 0]
    u = np.stack([ends * ends * (3 - 2 * ends), v[:, 1]], -1)
    share = ends * (1 - ends)
    # Of the numbers in [0, 1) that float32 has, 1 - 2^-24 is the largest.
    return np.minimum(u, 1 - 2.0**-24), share / share.sum()


def _angles(theta_o: Sequence[float] | float) -> list[float]:
    angles = [float(a) for a in ([theta_o] if isinstance(theta_o, (int, float)) else theta_o)]
    if not angles:
        raise ValueError("theta_o must hold at least one angle.")
    for a in angles:
        if not 0 <= a < 90:
            raise ValueError(
                f"theta_o={a:g} is out of range; allowed is 0 to less than 90 degrees."
            )
    return angles


def _known_channel(channel: str) -> str:
    if channel not in CHANNELS:
        raise ValueError(f"no channel {channel!r}; known are {', '.join(CHANNELS)}.")
    return channel


def _choose(values: Floats, channel: str) -> Floats:
    """One number from the colour in the last axis."""
    return np.asarray(values @ np.array(CHANNELS[_known_channel(channel)]), np.float64)


def _channel_note(values: Floats, channel: str) -> str:
    """The channel's name where the colours are not all grey."""
    grey = np.allclose(values, values[..., :1], rtol=1e-6, atol=1e-9)
    return "" if grey else channel


def _is_grey(model: Model) -> bool:
    values = (getattr(model, n) for n in model.fields)
    return all(not isinstance(v, tuple) or len(set(v)) == 1 for v in values)


def _rgb_columns(name: str, values: Floats, unit: str) -> dict[str, Floats]:
    flat = values.reshape(-1, 3)
    return {f"{name} {colour}{unit}": flat[:, i] for i, colour in enumerate(RGB)}


def _symbol(cosine: bool, with_cosine: str, without: str) -> str:
    return with_cosine if cosine else without


def _roughness_parameter(model: Model, along: str | None) -> Parameter | None:
    names = ROUGHNESS_NAMES if along is None else (along,)
    for name in names:
        declared = model.fields.get(name)
        if isinstance(declared, Parameter) and declared.width == 1:
            return declared
    return None


# A range that spans more than this is shown on a logarithmic axis.
LOG_RATIO = 1000
LOG_LOW, LOG_HIGH = 0.1, 1e4


def _is_logarithmic(p: Parameter) -> bool:
    return p.high - p.low > LOG_RATIO


def _sweep(p: Parameter) -> Floats:
    """Values across a parameter's range, at the axis' even steps."""
    if _is_logarithmic(p):
        return np.geomspace(max(p.low, LOG_LOW), min(p.high, LOG_HIGH), 9 if _slow() else 121)
    return np.linspace(p.low, p.high, 9 if _slow() else 121)


# ------------------------------------------------------------------------------------- the labels


def _number(value: Any) -> str:
    if isinstance(value, tuple):
        distinct = value[:1] if len(set(value)) == 1 else value
        return "/".join(f"{v:.4g}" for v in distinct)
    return value if isinstance(value, str) else f"{value:.4g}"


def _named(models: Sequence[Model]) -> tuple[list[Model], list[str], str]:
    """The models, a label for each, and a line with what they have in common.

    Between the two, every number of every model is told.
    """
    models = [models] if isinstance(models, Model) else list(models)
    if not models:
        raise ValueError("a plot needs at least one model.")
    for m in models:
        for name in m.fields:
            if arrays.is_array(getattr(m, name)):
                raise ValueError(
                    f"{m.name}.{name} is an array; a plot needs numbers: make one model per value."
                )
    first = models[0]
    common = {
        name: declared
        for name, declared in first.fields.items()
        if all(name in m.fields and _text(m, name) == _text(first, name) for m in models)
    }
    labels = []
    for m in models:
        telling = []
        for name, declared in m.fields.items():
            differs = any(_text(o, name) != _text(m, name) for o in models if type(o) is type(m))
            default = declared.is_default(getattr(m, name))
            if name not in common and (isinstance(declared, Parameter) or differs or not default):
                telling.append(f"{name} = {_text(m, name)}")
        labels.append(", ".join([m.name, *telling]))
    told = (
        f"{name} = {_text(first, name)}"
        for name, declared in common.items()
        if isinstance(declared, Parameter) or not declared.is_default(getattr(first, name))
    )
    return models, labels, ", ".join(told)


def _text(model: Model, name: str) -> str:
    return _number(getattr(model, name))


# -------------------------------------------------------------------------------------- drawing

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "text.usetex": False,
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlesize": 11,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.9,
    "legend.frameon": False,
    "savefig.facecolor": "white",
    "svg.fonttype": "path",  # looks the same where the font is missing
    "svg.hashsalt": "gonio",
    "pdf.fonttype": 42,
}


@dataclass(frozen=True)
class _Style:
    colour: Any
    dashes: Any

    def line(self) -> dict[str, Any]:
        return {"color": self.colour, "linestyle": self.dashes}


def _styles(models: Sequence[Model]) -> Callable[[], list[_Style]]:
    """A style for each model: an ordered scale for one growing parameter, else distinct colours."""

    def choose() -> list[_Style]:
        ordered = _ordered(models)
        if ordered is None:
            return [
                _Style(COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)])
                for i in range(len(models))
            ]
        import matplotlib

        scale = matplotlib.colormaps["viridis"]
        return [_Style(scale(0.88 * rank / (len(models) - 1)), "-") for rank in ordered]

    return choose


def _ordered(models: Sequence[Model]) -> list[int] | None:
    """Ranks by the one number in which at least three models of one type differ, else None."""
    if len(models) < 3 or len({type(m) for m in models}) > 1:
        return None
    changing = [n for n in models[0].fields if len({_text(m, n) for m in models}) > 1]
    values = [getattr(m, changing[0]) for m in models] if len(changing) == 1 else []
    if not values or not all(isinstance(v, float) for v in values):
        return None
    return [sorted(values).index(v) for v in values]


def _figure(width: float, height: float) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.06)
    return figure


def _head(figure: Any, title: str, facts: Iterable[str]) -> None:
    """A title above, and facts in a smaller, paler type beneath it."""
    width, height = figure.get_size_inches()
    lines = _fact_lines(width, facts)
    # The empty lines make constrained layout leave room for the facts; it wants to choose y.
    place = {} if figure.get_layout_engine() else {"y": 1 - 0.08 / height, "va": "top"}
    figure.suptitle(title + "\n" * len(lines), fontsize=13, **place)
    for i, line in enumerate(lines):
        y = 1 - (0.42 + 0.19 * i) / height
        figure.text(0.5, y, line, ha="center", va="center", color=FAINT)


def _fact_lines(width: float, facts: Iterable[str]) -> list[str]:
    """Facts joined into lines that fit a figure's width in inches."""
    lines: list[str] = []
    for fact in filter(None, facts):
        if lines and len(lines[-1]) + len(fact) < width / 0.078 - 6:
            lines[-1] += f";   {fact}"
        else:
            lines.append(fact)
    return lines


def _legend_columns(width: float, labels: Sequence[str]) -> int:
    fitting = int(width / (0.75 + 0.078 * max(map(len, labels))))
    rows = -(-len(labels) // max(1, min(len(labels), fitting)))
    return -(-len(labels) // rows)  # as few columns as these rows need, so that they are even


def _legend_height(width: float, labels: Sequence[str]) -> float:
    """In inches."""
    return 0.2 + 0.21 * -(-len(labels) // _legend_columns(width, labels))


def _legend(figure: Any, handles: Sequence[Any], labels: Sequence[str]) -> None:
    columns = _legend_columns(figure.get_size_inches()[0], labels)
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, handlelength=3)


def _draw_polar(
    labels: list[str],
    choose_styles: Callable[[], list[_Style]],
    shared: str,
    angles: list[float],
    theta_i: Floats,
    values: Floats,
    cosine: bool,
    note: str,
    title: str | None,
) -> Any:
    styles = choose_styles()
    across = 1 if len(angles) == 1 else 2
    down = -(-len(angles) // across)
    panel_width = 5.2 if across > 1 else 6.8
    width = panel_width * across
    figure = _figure(width, 0.57 * panel_width * down + 0.6 + _legend_height(width, labels))
    panels = figure.subplots(down, across, squeeze=False).ravel()
    ticks = _radial_ticks(float(values.max()))
    theta = np.radians(theta_i)
    handles = []
    for k, (panel, angle) in enumerate(zip(panels, angles, strict=False)):
        _half_disc(panel, ticks, angle, _quantity(cosine))
        handles = [
            panel.plot(r * -np.sin(theta), r * np.cos(theta), zorder=4, **s.line())[0]
            for r, s in zip(np.maximum(values[:, k], 0), styles, strict=True)
        ]
        panel.set_title(rf"viewer at $\theta_o$ = {angle:g}°")
    for panel in panels[len(angles) :]:
        panel.axis("off")
    _head(
        figure,
        title or f"Lobes {_quantity(cosine)} in the plane of incidence",
        (shared, note, _negative_note(values)),
    )
    _legend(figure, handles, labels)
    return figure


def _quantity(cosine: bool) -> str:
    return r"$f\,\cos\theta_i$" if cosine else "$f$"


def _negative_note(values: Floats) -> str:
    # A negative radius would land on the other side of the origin.
    return "negative values are drawn as 0" if values.min() < -1e-9 else ""


def _radial_ticks(high: float) -> Floats:
    """Round radii for rings, the last one at or beyond the largest value."""
    from matplotlib.ticker import MaxNLocator

    ticks = MaxNLocator(nbins=4, steps=[1, 2, 2.5, 5, 10]).tick_values(0, max(high, 1e-6))
    return np.asarray(ticks[ticks > 0], np.float64)


def _half_disc(panel: Any, ticks: Floats, theta_o: float, quantity: str) -> None:
    """Rings, spokes and labels of a polar diagram above the surface; +90° is on the left."""
    rim = float(ticks[-1])
    arc = np.radians(np.linspace(-90, 90, 181))
    for r in ticks:
        edge = r == rim
        panel.plot(
            r * np.sin(arc), r * np.cos(arc), color=FAINT if edge else GRID, lw=0.8, zorder=1
        )

    def at_rim(text: str, degrees: float, colour: str) -> None:
        x, y = -math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        side = "center" if abs(x) < 0.1 else "right" if x < 0 else "left"
        place = {"ha": side, "va": "center" if y < 0.9 else "bottom"}
        panel.annotate(
            text,
            (rim * x, rim * y),
            (4 * x, 4 * y if y < 0.9 else 3),
            textcoords="offset points",
            fontsize=9,
            color=colour,
            **place,
        )

    for degrees in range(-90, 91, 30):
        x, y = -math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        panel.plot([0, rim * x], [0, rim * y], color=GRID, lw=0.7, zorder=0)
        if abs(degrees - theta_o) > 8:  # there the viewer's own label is
            at_rim(f"{degrees}°".replace("-", "−"), degrees, FAINT)
    panel.plot([-rim, rim], [0, 0], color=INK, lw=1.1, zorder=2)
    below = {"xytext": (0, -4), "textcoords": "offset points", "va": "top", "fontsize": 9}
    for r in (0.0, *ticks):
        panel.annotate(f"{r:g}", (-r, 0), ha="center", **below)
    panel.annotate(f"{quantity}  [1/sr]", (rim, 0), ha="right", **below)
    x, y = -math.sin(math.radians(theta_o)), math.cos(math.radians(theta_o))
    arrow = {"arrowstyle": "-|>", "color": INK, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}
    panel.annotate("", (rim * x, rim * y), (0, 0), arrowprops=arrow, zorder=3)
    at_rim(r"$\omega_o$", theta_o, INK)
    if theta_o > 0:
        panel.plot([0, -rim * x], [0, rim * y], color=INK, lw=1, ls=(0, (1, 3)), zorder=3)
        side = {"fontsize": 9, "color": FAINT, "va": "top"}
        panel.text(-1.1 * rim, 1.06 * rim, "light on the\nviewer's side\n(retro)", **side)
        panel.text(1.1 * rim, 1.06 * rim, "light opposite\n(mirror, dotted)", ha="right", **side)
    panel.set_aspect("equal")
    panel.set_xlim(-1.1 * rim, 1.1 * rim)
    panel.set_ylim(-0.14 * rim, 1.1 * rim)
    panel.axis("off")


def _draw_albedo(
    models: list[Model],
    labels: list[str],
    choose_styles: Callable[[], list[_Style]],
    shared: str,
    axes: dict[str, Parameter],
    families: list[str],
    theta_o: Floats,
    directional: Floats,
    sweeps: list[tuple[str, Floats, Floats]],
    means: Floats,
    note: str,
    title: str | None,
) -> Any:
    styles = choose_styles()
    width = 4.6 + 3.6 * len(axes) if axes else 6.6
    figure = _figure(width, 4.4 + _legend_height(width, labels))
    ratios = [1.25] + [1.0] * len(axes)
    panels = figure.subplots(
        1, len(ratios), sharey=True, squeeze=False, gridspec_kw={"width_ratios": ratios}
    )[0]
    handles = [
        panels[0].plot(theta_o, curve, **s.line())[0]
        for curve, s in zip(directional, styles, strict=True)
    ]
    panels[0].set(
        xlabel=r"angle of the viewer $\theta_o$  [degrees]",
        ylabel=f"albedo{f', {note}' if note else ''}",
        title="directional albedo",
        xlim=(0, 90),
        xticks=range(0, 91, 15),
    )
    for panel, (name, p) in zip(panels[1:], axes.items(), strict=True):
        logarithmic = _is_logarithmic(p)
        for i, (m, s) in enumerate(zip(models, styles, strict=True)):
            own, x, curve = sweeps[i]
            if not own:
                panel.axhline(means[i], **s.line())
            elif own == name:
                if families.index(families[i]) == i:
                    alone = families.count(families[i]) == 1
                    panel.plot(x, curve, **(s.line() if alone else {"color": FAINT}))
                panel.plot(
                    getattr(m, name),
                    means[i],
                    "o",
                    ms=8,
                    mec="white",
                    color=s.colour,
                    clip_on=False,
                    zorder=5,
                )
        if logarithmic:
            panel.set_xscale("log")
            panel.set_xlim(max(p.low, LOG_LOW), min(p.high, LOG_HIGH))
        else:
            panel.set_xlim(p.low, p.high)
        unit = p.doc.partition(";")[0].partition(",")[2].strip()
        panel.set(
            xlabel=f"{name}  [{unit}]" if unit == "radians" else name,
            title=f"mean albedo against {name}",
        )
        panel.tick_params(labelleft=False)
    _frame_albedo(panels, [directional, means, *(s[2] for s in sweeps)])
    _head(figure, title or "Albedo", (shared,))
    _legend(figure, handles, labels)
    return figure


def _frame_albedo(panels: Any, values: Sequence[Floats]) -> None:
    """The same height for all panels, with a line where as much is reflected as arrives."""
    low = min(float(v.min()) for v in values if v.size)
    high = max(float(v.max()) for v in values if v.size)
    margin = max(0.06 * (high - low), 0.025)
    panels[0].set_ylim(max(low - margin, 0), high + margin)
    if high > 0.97:
        for panel in panels:
            panel.axhline(1, color=FAINT, lw=0.9, zorder=1)
        panels[0].text(
            1.5, 1, "all light reflected", color=FAINT, fontsize=8.5, va="bottom", ha="left"
        )


def _draw_surface(
    labels: list[str],
    choose_styles: Callable[[], list[_Style]],
    shared: str,
    angles: list[float],
    wi: Floats,
    values: Floats,
    cosine: bool,
    note: str,
    title: str | None,
) -> Any:
    from matplotlib.figure import Figure

    styles = choose_styles()
    if len(angles) == 1:  # as many models as fit into a row, else a row for each model
        down = -(-len(labels) // 3)
        across = -(-len(labels) // down)
    else:
        down, across = len(labels), len(angles)
    width, head = 4.4 if across > 1 else 6.2, 0.85
    height = 0.84 * width
    total = (width * across, height * down + head)
    figure = Figure(figsize=total)
    ticks = _radial_ticks(float(values.max()))
    for place in range(len(labels) * len(angles)):
        i, k = divmod(place, len(angles))
        row, column = divmod(place, across)
        # A square in the middle of the panel, larger than it is high: the disc is flat.
        # mplot3d draws 1.4 % of the width right of the middle.
        corner = (width * (column - 0.014), total[1] - head - height * (row + 0.48) - width / 2)
        panel = figure.add_axes(
            (corner[0] / total[0], corner[1] / total[1], width / total[0], width / total[1]),
            projection="3d",
            computed_zorder=False,
        )
        panel.patch.set_visible(False)
        _ground_disc(panel, ticks)
        lobe = np.maximum(values[i, k], 0)
        _lobe(panel, lobe[..., None] * wi, styles[i].colour)
        rows = [np.interp(abs(a), (0, 90), (0, len(wi) - 1)) for a in (0.0, angles[k])]
        _arrows(panel, angles[k], float(ticks[-1]), lobe, [round(r) for r in rows])
        for artist in panel.get_children():
            artist.set_clip_on(False)
        angle = rf"$\theta_o$ = {angles[k]:g}°"
        figure.text(
            width * (column + 0.5) / total[0],
            (total[1] - head - height * row - 0.12) / total[1],
            f"{labels[i]},  {angle}" if len(labels) > 1 else angle,
            ha="center",
            va="top",
            fontsize=11,
        )
    name = f"Lobe {_quantity(cosine)} over the directions of the light"
    rings = f"rings at {', '.join(f'{t:g}' for t in ticks)} 1/sr"
    alone = f"{labels[0]}:" if len(labels) == 1 else ""
    facts = (" ".join(t for t in (alone, shared) if t), note, rings, _negative_note(values))
    _head(figure, title or name, facts)
    return figure


def _ground_disc(panel: Any, ticks: Floats) -> None:
    rim = float(ticks[-1])
    phi = np.radians(np.linspace(0, 360, 181))
    for r in ticks:
        panel.plot(r * np.cos(phi), r * np.sin(phi), 0, color=FAINT if r == rim else GRID, lw=0.8)
    for degrees in range(0, 180, 30):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        panel.plot([-rim * c, rim * c], [-rim * s, rim * s], [0, 0], color=GRID, lw=0.7)
    panel.set(xlim=(-rim, rim), ylim=(-rim, rim), zlim=(0, rim))
    panel.set_box_aspect((2, 2, 1), zoom=1.3)
    # From the side, so that +x (the viewer) is left, as in the polar plots.
    panel.view_init(elev=20, azim=68)
    panel.set_axis_off()


def _lobe(panel: Any, points: Floats, colour: Any) -> None:
    """A closed surface, shaded; points: shape (theta, phi, 3)."""
    from matplotlib.colors import to_rgb

    across, along = points[1:, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, 1:]
    normal = np.cross(along, across)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    # Light from the upper left, behind the eye. Half Lambert keeps the shadow side readable, and
    # the range from a dark to a pale tone makes even black a shape.
    light = np.array([0.55, 0.45, 0.7]) / np.linalg.norm([0.55, 0.45, 0.7])
    tone = ((normal @ light + 1) / 2)[..., None] ** 1.5
    base = np.array(to_rgb(colour))
    dark, pale = 0.35 * base, 0.45 + 0.55 * base
    panel.plot_surface(
        *np.moveaxis(points, -1, 0),
        rstride=1,
        cstride=1,
        facecolors=(1 - tone) * dark + tone * pale,
        shade=False,
        linewidth=0,
        antialiased=False,
        rasterized=True,
        zorder=2,
    )


def _arrows(panel: Any, theta_o: float, rim: float, lobe: Floats, rows: list[int]) -> None:
    """The normal, the viewer and the mirror direction; faint inside the lobe.

    lobe: the surface's distance from the origin, shape (theta, phi); rows: those of theta = 0 and
    theta_o.
    """
    half_turn = lobe.shape[1] // 2
    arrows = [
        (0.0, lobe[rows[0], 0], "$n$", FAINT, "-"),
        (theta_o, lobe[rows[1], 0], r"$\omega_o$", INK, "-"),
        (-theta_o, lobe[rows[1], half_turn], "mirror", INK, (0, (1, 2))),
    ]
    for degrees, start, name, colour, dashes in arrows if theta_o > 0 else arrows[:2]:
        w = _direction(degrees)
        for (low, high), opacity in (((0, start), 0.3), ((start, rim), 1)):
            line = np.stack([low * w, high * w], -1)
            panel.plot(*line, color=colour, lw=1.5, ls=dashes, alpha=opacity, zorder=3)
        panel.text(*(1.1 * rim * w), name, color=colour, ha="center", va="center", zorder=4)


# Below this a variance is float32 rounding, which says nothing about a sampler.
VARIANCE_FLOOR = 1e-6


def _draw_sampling(
    labels: list[str],
    choose_styles: Callable[[], list[_Style]],
    shared: str,
    theta_o: Floats,
    statistics: Floats,
    note: str,
    title: str | None,
) -> Any:
    styles = choose_styles()
    figure = _figure(10.4, 4.3 + _legend_height(10.4, labels))
    left, right = figure.subplots(1, 2)
    handles = []
    for (_, variance, largest), s in zip(np.moveaxis(statistics, -1, 1), styles, strict=True):
        shown = np.maximum(variance, VARIANCE_FLOOR)
        handles += left.plot(theta_o, shown, **s.line())
        right.plot(theta_o, largest, **s.line())
    for panel in (left, right):
        panel.set(
            xlabel=r"angle of the viewer $\theta_o$  [degrees]",
            xlim=(0, 90),
            xticks=range(0, 91, 15),
        )
    left.set_yscale("log")
    if statistics[..., 1].min() < VARIANCE_FLOOR:
        floor = {"va": "bottom", "fontsize": 9, "color": FAINT}
        left.text(1.5, 1.15 * VARIANCE_FLOOR, "no variance but rounding", **floor)
    if statistics[..., 2].max() > 10 * statistics[..., 2].min():
        right.set_yscale("log")
    left.set(ylabel="variance", title=r"variance of the weight $f\,\cos\theta_i\,/$pdf")
    right.set(ylabel="weight", title=f"weight that one sample in {1 / RARE:,.0f} exceeds")
    _head(figure, title or "How well the samplers fit", (shared, note))
    _legend(figure, handles, labels)
    return figure
