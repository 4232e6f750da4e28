"""Makes the page that says how wrong the layered models are, docs/layers.md, with its pictures.

Run 'make layers'; it takes some minutes.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gonio import compare as comparison
from gonio.compare import Errors, drawing, percent
from gonio.files import replacing
from gonio.materials.notation import model_text
from gonio.model import Model, model
from gonio.parts.metals import metal
from gonio.reference.stack import Stack

Progress = Callable[[int, int], None]
Settings = dict[str, Any]

# Characters of a line of the page.
WIDTH = 110

# Walks of the truth for one pair of directions.
WALKS = 4096

AS_PRINTED: Settings = {}
BOTH_WAYS = {"transmission": "both_ways"}
COMPRESSED = {"solid_angle": "compressed"}
BOTH = BOTH_WAYS | COMPRESSED
ALL = BOTH | {"bounces": "diffuse"}
SMITH = {"masking": "smith"}

COAT_ROWS: tuple[tuple[str, Settings], ...] = (
    ("as printed", AS_PRINTED),
    ("Fresnel both ways", BOTH_WAYS),
    ("1/η²", COMPRESSED),
    ("Fresnel both ways, 1/η²", BOTH),
    ("Fresnel both ways, 1/η², inner bounces", ALL),
)
ROUGH_ROWS = (
    *COAT_ROWS[:1],
    ("as printed, Smith's masking", SMITH),
    ("as printed, Lazányi's Fresnel", {"fresnel": "lazanyi"}),
    *COAT_ROWS[3:],
    ("the same, Smith's masking", ALL | SMITH),
)


@dataclass(frozen=True)
class Situation:
    """A stack, and a model's settings that are meant to look like it."""

    title: str
    model: str
    given: Settings
    rows: tuple[tuple[str, Settings], ...]
    remark: str
    """What the table shows, in words."""

    def make(self, settings: Settings) -> Model:
        """The model with one row's settings."""
        return model(self.model, **self.given, **settings)


def situations() -> list[Situation]:
    """Everything on the page, in its order."""
    gold = {name: tuple(x / 1.5 for x in value) for name, value in metal("Au").items()}
    matte = {"base": model("lambert", rho=0.8)}
    inner = model("weidlich_wilkie", eta=1.2, alpha=0.3, sigma_a=(0.1, 0.3, 0.6), **matte)
    exact_inner = inner.replace(**ALL)
    return [
        Situation(
            "Smooth clear coat on matte",
            "weidlich_wilkie",
            {"interface": "smooth", **matte},
            COAT_ROWS,
            SMOOTH,
        ),
        Situation(
            "Glossy clear coat on matte",
            "weidlich_wilkie",
            {"alpha": 0.1, **matte},
            ROUGH_ROWS,
            GLOSSY,
        ),
        Situation(
            "Rough clear coat on matte",
            "weidlich_wilkie",
            {"alpha": 0.4, **matte},
            ROUGH_ROWS,
            ROUGH,
        ),
        Situation(
            "Tinted coat on matte",
            "weidlich_wilkie",
            {"alpha": 0.1, "sigma_a": (0.1, 0.4, 0.9), **matte},
            (COAT_ROWS[0], COAT_ROWS[3], COAT_ROWS[4]),
            TINTED,
        ),
        Situation(
            "Coat on brushed gold",
            "weidlich_wilkie",
            {"alpha": 0.2, "base": model("torrance_sparrow", alpha=0.1, **gold)},
            (
                COAT_ROWS[0],
                ("as printed, no roughness clamp", {"roughness_clamp": "off"}),
                COAT_ROWS[3],
                ("the same, no roughness clamp", BOTH | {"roughness_clamp": "off"}),
                ("Fresnel both ways, 1/η², inner bounces", ALL),
            ),
            GOLD,
        ),
        Situation(
            "Two coats on matte",
            "weidlich_wilkie",
            {"eta": 1.4, "alpha": 0.05},
            (
                ("both as printed", {"base": inner}),
                ("both with all options", ALL | {"base": exact_inner}),
            ),
            NESTED,
        ),
        Situation("Metallic paint, one flake", "car_paint", {"flake_x": 0.2}, PAINT_ROWS, PAINT),
        Situation("tri-Ace's layers", "triace_layered", {}, TRIACE_ROWS, TRIACE),
        Situation(
            "tri-Ace's layers, tinted",
            "triace_layered",
            {"sigma_a": (0.05, 0.1, 0.15)},
            (TRIACE_ROWS[0], ("linear absorption (Eq. 3)", {"absorption": "linear"})),
            TRIACE_TINTED,
        ),
    ]


PAINT_ROWS: tuple[tuple[str, Settings], ...] = (
    ("Fresnel both ways, 1/η²", {}),
    ("T at the half vector", {"transmission": "half_vector"}),
    ("no 1/η²", {"solid_angle": "none"}),
    ("both, as printed", {"transmission": "half_vector", "solid_angle": "none"}),
)
TRIACE_ROWS: tuple[tuple[str, Settings], ...] = (
    ("exact Fresnel (Eq. 4)", {}),
    ("constant Fresnel (Eq. 5)", {"bottom_fresnel": "constant"}),
    ("Eq. 5, F_trans not on the bottom", {"bottom_fresnel": "constant", "top_transmission": "off"}),
    ("Oren-Nayar below (Eq. 25)", {"diffuse": "oren_nayar"}),
)

SMOOTH = """With all options the model is the closed form of the interfaced Lambertian, and its error is
the truth's noise. As printed, two omissions hide each other in part: light does not spread by 1/η² on
its way out, and none is reflected back inside. 1/η² without the inner bounces makes things worse."""
GLOSSY = """The choice of masking and of Fresnel's fit hardly matters beside those two. With all
options, what is left lies near the horizon, where light that meets a tilted facet enters more easily
than through the mean surface."""
ROUGH = """The model refracts at the mean surface however rough the coat is, and its mean error grows
with the roughness. But a surplus of energy is not its own fault here: the truth's facets lose more than
that."""
TINTED = """Inner bounces cross the colour again; the model's series takes that light as diffuse, which
is good to about a percent in the mean. As printed, every colour is too bright and too pale."""
GOLD = """No setting fits a bright metal. Without 1/η² a mirror shines η² times too bright; the
roughness clamp stands for the blur of two rough crossings and widens the highlight too much when base
and coat are of like roughness; and `bounces="diffuse"` is not made for mirrors. Best are Fresnel both
ways, 1/η² and no clamp: what they lack is the light that comes back from the inside of the surface."""
NESTED = """Errors of layers multiply. With all options on both coats most of the error is gone. What is
left is smaller than what the truth's facets lose, and holds the light between the two surfaces, which
nesting counts below each surface by itself."""
PAINT = """With gonio's defaults, in the first row, nothing but the inner bounces is missing, and the
tint, a flat flake and a dark metal leave little of those. A surface that is nearly smooth is where
these models are at home."""
TRIACE = """The stack that these equations stand for has two surfaces with Beckmann facets. The
equations have neither 1/η² nor inner bounces, so the matte part is far too bright, also when what the
truth's facets lose is put back; beside that, exact and constant Fresnel terms are the same."""
TRIACE_TINTED = """Eq. 3 absorbs too much, which happens to take away part of the surplus, and is black
near the horizon."""

PICTURES: tuple[tuple[str, str, Settings, str], ...] = (
    (
        "as_printed",
        "weidlich_wilkie",
        {"alpha": 0.1},
        "The glossy coat as printed, beside the truth.",
    ),
    (
        "all_options",
        "weidlich_wilkie",
        {"alpha": 0.1} | ALL,
        "The same coat with Fresnel both ways, 1/η² and inner bounces.",
    ),
    ("triace", "triace_layered", {}, "tri-Ace's layers, beside the truth."),
)

HEAD = """<!-- Made by 'make layers'; do not edit. -->
# How wrong are layered models?

Layered models of real-time rendering take one path of the light: down through the surface, off the
base, and up again. `gonio.reference` follows all paths, by random walks through the layers that a model
stands for (Guo, Hašan, Zhao, "Position-free Monte Carlo simulation for arbitrary layered BSDFs", 2018),
and is the truth here. `gonio compare MODEL --truth` says the same of any settings.

- **Mean error**: mean of |f − truth| over mean of the truth, over all pairs of directions, weighted by
  both cosines.
- **Worst**: largest relative error at angles up to 85°, and where: θi, θo and the azimuth between them
  (0° is the viewer's side, 180° the mirror's). Up to 4 %% of it may be noise.
- **Energy**: mean albedo gained or lost; then the mean albedos of model and truth (luminance, without
  mirrors).

The truth's noise adds less than %.1f %% to a mean error. Its surfaces are Walter's (2007): facets
scatter once, and what would need a second facet is lost; a surface between nearly equal indices loses
as much by masking. Below each table stands how much of its mean albedo the same stack without
absorption loses in this way over a white matte base. Coats have η = 1.5 and Beckmann facets, matte
bases the albedo 0.8, unless the text says otherwise.
"""


def document(
    path: str | Path, *, walks: int = WALKS, progress: Progress | None = None
) -> list[Path]:
    """Measure everything and write the page, with its pictures in a folder `images` beside it.

    Args:
        path: a .md file; it appears when it is complete.
        walks: random walks of the truth for each pair of directions.
        progress: called after each step.

    Returns:
        The files that were written.

    Raises:
        ValueError: another suffix.
        FileNotFoundError: the folder does not exist.
    """
    path = Path(path)
    if path.suffix.lower() != ".md":
        raise ValueError(f"cannot write {path.name!r}; the suffix must be .md.")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {path.parent}; create it first.")
    images = path.parent / "images"
    images.mkdir(exist_ok=True)
    every = situations()
    total = sum(len(s.rows) for s in every) + len(PICTURES)

    def step(done: int) -> None:
        if progress is not None:
            progress(done, total)

    tables = measure_all(every, walks, step)
    written = []
    for n, (name, kind, given, _) in enumerate(PICTURES):
        target = images / f"layers_{name}.png"
        drawing.write(target, comparison.compare([model(kind, **given)], truth=True, spp=256))
        written.append(target)
        step(total - len(PICTURES) + n + 1)
    with replacing(path) as temporary:
        temporary.write_text(page(every, tables), encoding="utf-8")
    return [path, *written]


def measure_all(
    every: Sequence[Situation], walks: int, step: Callable[[int], None]
) -> list[list[Errors]]:
    """The errors of every row of every situation; rows that stand for the same stack share its truth."""
    found, done = [], 0
    for situation in every:
        rows = []
        measured: dict[str, comparison.Measured] = {}
        for _, settings in situation.rows:
            made = situation.make(settings)
            stack = Stack.of(made)
            key = repr(stack)
            if key not in measured:
                measured[key] = comparison.measure(made, stack, walks=walks)
            rows.append(measured[key].judge(made)[0])
            done += 1
            step(done)
        found.append(rows)
    return found


def page(every: Sequence[Situation], tables: Sequence[Sequence[Errors]]) -> str:
    """The text of the page."""
    noise = max(e.noise for rows in tables for e in rows)
    lines = [HEAD % (100 * noise + 0.05)]
    for situation, rows in zip(every, tables, strict=True):
        first = situation.make(situation.rows[0][1])
        lines += [
            f"## {situation.title}",
            "",
            f"`{_command(first)}`",
            "",
            "| settings | mean error | worst | at θi, θo, φ | energy | albedo | truth |",
            "|---|---:|---:|---|---:|---:|---:|",
        ]
        for (label, _), e in zip(situation.rows, rows, strict=True):
            at = "{:g}°, {:g}°, {:g}°".format(*e.worst_at)
            lines.append(
                f"| {label} | {100 * e.mean:.1f} % | {percent(e.worst)} | {at} | {percent(e.energy)} "
                f"| {e.albedo:.3f} | {e.truth:.3f} |"
            )
        loss = 100 * lost(Stack.of(first))
        lines += [
            "",
            f"Lost by the truth's facets: {loss:.1f} %.",
            "",
            textwrap.fill(" ".join(situation.remark.split()), WIDTH),
            "",
        ]
    lines += ["## Pictures", ""]
    for name, kind, given, caption in PICTURES:
        lines += [f"![{caption}](images/layers_{name}.png)", ""]
        lines += [f"*{caption} `{_command(model(kind, **given))}`*", ""]
    return "\n".join(lines).rstrip() + "\n"


def lost(stack: Stack) -> float:
    """What a stack's facets lose of its mean albedo, without absorption and over a white matte base."""
    clear = [replace(layer, sigma_a=0.0) for layer in stack.layers]
    u = np.random.default_rng(0).random((4000, 2))
    r, phi = np.sqrt(u[:, 0]), 2 * math.pi * u[:, 1]
    wo = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u[:, 0])], -1)
    white = Stack(clear, model("lambert", rho=1))
    return float(1 - white.albedo(wo.astype(np.float32), walks=256).value.mean())


def _command(made: Model) -> str:
    """The command that compares a model with the truth, for models with plain numbers."""
    return f"gonio compare {model_text(made)} --truth"


def main() -> None:
    """Write the page of this repository."""

    def progress(done: int, total: int) -> None:
        print(f"{done} of {total}", end="\r", flush=True)

    for path in document(Path(__file__).parent.parent / "docs" / "layers.md", progress=progress):
        print(path)


if __name__ == "__main__":
    main()
