"""Colours, dashes, heads and legends that all plots share."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from gonio.model import Model
from gonio.plot.labels import parameter_text

# Okabe and Ito's colours, which people with any colour vision can tell apart, without the yellow
# that is too pale for a line. Dashes show curves that lie on one another, and help in grey print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#56B4E9", "#E69F00")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (7, 2, 1.5, 2)))
INK, FAINT, GRID = "#222222", "#666666", "#d9d9d9"


STYLE: dict[str, Any] = {
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
class CurveStyle:
    """Colour and dashes of one model's curve."""

    colour: Any
    dashes: Any

    def line(self) -> dict[str, Any]:
        """Arguments for matplotlib's lines."""
        return {"color": self.colour, "linestyle": self.dashes}


def curve_styles(models: Sequence[Model]) -> Callable[[], list[CurveStyle]]:
    """A style for each model: an ordered scale for one growing parameter, else distinct colours."""

    def choose() -> list[CurveStyle]:
        ordered = _ordered(models)
        if ordered is None:
            return [
                CurveStyle(COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)])
                for i in range(len(models))
            ]
        import matplotlib

        scale = matplotlib.colormaps["viridis"]
        return [CurveStyle(scale(0.88 * rank / (len(models) - 1)), "-") for rank in ordered]

    return choose


def _ordered(models: Sequence[Model]) -> list[int] | None:
    """Ranks by the one number in which at least three models of one type differ, else None."""
    if len(models) < 3 or len({m.written for m in models}) > 1:
        return None
    changing = [n for n in models[0].fields if len({parameter_text(m, n) for m in models}) > 1]
    values = [getattr(m, changing[0]) for m in models] if len(changing) == 1 else []
    if not values or not all(isinstance(v, float) for v in values):
        return None
    return [sorted(values).index(v) for v in values]


def new_figure(width: float, height: float) -> Any:
    """An empty figure of this size in inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.06)
    return figure


def draw_head(figure: Any, title: str, facts: Iterable[str]) -> None:
    """A title above, and facts in a smaller, paler type beneath it."""
    width, height = figure.get_size_inches()
    lines = _fact_lines(width, facts)
    # The empty lines make constrained layout leave room for the facts; it wants to choose y.
    place = {} if figure.get_layout_engine() else {"y": 1 - 0.08 / height, "va": "top"}
    figure.suptitle(title + "\n" * len(lines), fontsize=13, **place)
    for i, line in enumerate(lines):
        y = 1 - (0.42 + 0.19 * i) / height
        figure.text(0.5, y, line, ha="center", va="center", color=FAINT)


# Of models in models in models, a figure has room for the first.
FACT_LINES = 8
REST = " …; 'gonio show' has all"


def _fact_lines(width: float, facts: Iterable[str]) -> list[str]:
    """Facts joined into lines that fit a figure's width in inches."""
    lines: list[str] = []
    room = int(width / 0.078) - 2
    for fact in filter(None, facts):
        if lines and len(lines[-1]) + len(fact) < room - 4:
            lines[-1] += f";   {fact}"
        else:
            lines += textwrap.wrap(fact, room, max_lines=FACT_LINES, placeholder=REST)
    return lines


def _legend_columns(width: float, labels: Sequence[str]) -> int:
    fitting = int(width / (0.75 + 0.078 * max(map(len, labels))))
    rows = -(-len(labels) // max(1, min(len(labels), fitting)))
    return -(-len(labels) // rows)  # as few columns as these rows need, so that they are even


def _legend_lines(width: float, labels: Sequence[str]) -> list[list[str]]:
    """Each label in lines that fit a figure's width: one that needs several has a column's whole width."""
    room = int((width - 0.75) / 0.078)
    return [textwrap.wrap(x, room, max_lines=FACT_LINES, placeholder=REST) for x in labels]


def legend_height(width: float, labels: Sequence[str]) -> float:
    """In inches."""
    lines = sum(map(len, _legend_lines(width, labels)))
    return 0.2 + 0.21 * -(-lines // _legend_columns(width, labels))


def draw_legend(figure: Any, handles: Sequence[Any], labels: Sequence[str]) -> None:
    """A legend below the panels."""
    width = figure.get_size_inches()[0]
    shown = ["\n".join(lines) for lines in _legend_lines(width, labels)]
    columns = _legend_columns(width, labels)
    figure.legend(handles, shown, loc="outside lower center", ncols=columns, handlelength=3)
