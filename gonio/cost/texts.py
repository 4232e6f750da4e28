"""The tables of cost in the texts, beside whole shaders of today's GPUs: ratios, since machines differ.

Sources: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course,
Figures 2, 3(b), 6(c), 11 and 14; Elek, "Layered materials in real-time rendering", CESCG 2010, Table 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import gonio
from gonio.bench.report import Column, Section, Value, ratio
from gonio.cost import amd
from gonio.cost.gpus import CostError, Gpu
from gonio.cost.program import Program
from gonio.cost.scenes import lit, plain_phong
from gonio.export.coded import Request

SUN = ("directional",)


@dataclass(frozen=True)
class Row:
    """A shader, and what the text measured for its own."""

    program: Program
    theirs: float


@dataclass(frozen=True)
class Table:
    """One table of a text; all is compared with its last row."""

    key: str
    title: str
    unit: str
    rows: tuple[Row, ...]
    note: str = ""


def _single(diffuse: str, lights: Sequence[str]) -> Program:
    label = f"one layer over {'Lambert' if diffuse == 'lambert' else 'Oren-Nayar'}"
    return lit(label, gonio.model("triace_blinn_phong", diffuse=diffuse), lights)


def _dual(diffuse: str, lights: Sequence[str]) -> Program:
    label = f"two layers over {'Lambert' if diffuse == 'lambert' else 'Oren-Nayar'}"
    model = gonio.model(
        "triace_layered", diffuse=diffuse, absorption="linear", bottom_fresnel="constant"
    )
    return lit(label, model, lights)


def _coated(label: str, fresnel: str, mirror: str, tables: Request | None = None) -> Program:
    """Elek's basic model: a coat over a metal by Algorithm 1, both of round facets.

    Evaluated they are Beckmann's; in a table all round facets cost the same, and torrance_sparrow's
    Blinn-Phong ones have no stretch, which Elek's have not either.
    """
    facets = "beckmann" if tables is None else "blinn_phong"
    metal = gonio.model(
        "torrance_sparrow",
        distribution=facets,
        masking="cook_torrance",
        fresnel="conductor" if fresnel == "exact" else fresnel,
    )
    coat = gonio.model("weidlich_wilkie", base=metal, distribution=facets, fresnel=fresnel)
    return lit(label, coat, SUN, tables=tables, mirror=mirror)


# F(mu_o) of the surface, by which it mirrors the environment.
MIRRORS = {
    "lazanyi": "1.0 - {prefix}_transmittance_lazanyi({mu}, params.eta)",
}


def _triace_2() -> Table:
    exact = gonio.model("triace_layered")
    linear = gonio.model("triace_layered", absorption="linear", bottom_fresnel="constant")
    clear = {"sigma_a": "vec3(0.0)"}
    return Table(
        "triace_2",
        "tri-Ace, Figure 2: absorption under one directional light",
        "ms on a PlayStation 3",
        (
            Row(lit("Eq. 2 and 4, as they stand", exact, SUN), 0.53),
            Row(lit("Eq. 3 and 5, approximated", linear, SUN), 0.37),
            Row(lit("the same without absorption", linear, SUN, clear), 0.34),
            Row(_single("lambert", SUN), 0.33),
        ),
    )


def _triace_3b() -> Table:
    return Table(
        "triace_3b",
        "tri-Ace, Figure 3(b): light from pictures",
        "ms on a PlayStation 3",
        (Row(_dual("lambert", ("layered",)), 4.28), Row(_single("lambert", ("image",)), 3.00)),
    )


def _triace_6c() -> Table:
    return Table(
        "triace_6c",
        "tri-Ace, Figure 6(c): Oren-Nayar under one directional light",
        "ms on a PlayStation 3",
        (Row(_single("oren_nayar", SUN), 1.25), Row(_single("lambert", SUN), 0.97)),
    )


def _triace_11() -> Table:
    return Table(
        "triace_11",
        "tri-Ace, Figure 11: Oren-Nayar under light from pictures",
        "ms on a PlayStation 3",
        (Row(_single("oren_nayar", ("image",)), 1.62), Row(_single("lambert", ("image",)), 1.35)),
    )


def _triace_14() -> Table:
    return Table(
        "triace_14",
        "tri-Ace, Figure 14: one directional light and light from pictures",
        "ms on a PlayStation 3",
        (
            Row(_dual("oren_nayar", (*SUN, "layered")), 7.82),
            Row(_dual("lambert", (*SUN, "layered")), 7.55),
            Row(_single("oren_nayar", (*SUN, "image")), 7.17),
            Row(_single("lambert", (*SUN, "image")), 6.87),
        ),
        "The text's times hold a frame of several milliseconds that all four share, so its ratios are "
        "nearer to 1.",
    )


def _elek_1() -> Table:
    return Table(
        "elek_1",
        "Elek, Table 1: layers against plain Phong",
        "cycles on a GeForce 8800",
        (
            Row(
                _coated("layered, evaluated in full (Lazanyi's F)", "lazanyi", MIRRORS["lazanyi"]),
                436.0,
            ),
            Row(
                _coated(
                    "layered, F and D from tables",
                    "exact",
                    "F_dielectric_entering",
                    Request(("fresnel", "distribution")),
                ),
                236.0,
            ),
            Row(plain_phong("Phong, written by hand"), 104.0),
        ),
        "All have a normal map, one light, and the environment as the surface mirrors it.",
    )


MADE: dict[str, Callable[[], Table]] = {
    "triace_2": _triace_2,
    "triace_3b": _triace_3b,
    "triace_6c": _triace_6c,
    "triace_11": _triace_11,
    "triace_14": _triace_14,
    "elek_1": _elek_1,
}
"""What writes each table's shaders, by the table's key."""


def tables(
    gpus: Sequence[Gpu], progress: Callable[[str], None] = lambda text: None
) -> list[Section]:
    """Every table of the texts, measured for AMD's GPUs among those that are asked for.

    Raises:
        CostError: none of the GPUs is AMD's.
        ProofError: a compiler is missing, or refuses a shader.
    """
    chosen = [gpu for gpu in gpus if gpu.vendor == "amd"]
    if not chosen:
        raise CostError(
            "--texts needs a GPU of AMD, whose compiler tells cycles; add --gpu navi21."
        )
    return [measured(made(), chosen, progress) for made in MADE.values()]


def measured(
    table: Table, gpus: Sequence[Gpu], progress: Callable[[str], None] = lambda text: None
) -> Section:
    """One table, measured for GPUs of AMD.

    Raises:
        ProofError: a compiler is missing, or refuses a shader.
    """
    rows: list[dict[str, Value]] = [
        {
            "row": row.program.label,
            "text": row.theirs,
            "text_ratio": row.theirs / table.rows[-1].theirs,
        }
        for row in table.rows
    ]
    for gpu in gpus:
        progress(f"cost: {table.title} on {gpu.name}")
        found = amd.measure([row.program for row in table.rows], gpu)
        base = found[-1].cycles or 1
        for row, numbers in zip(rows, found, strict=True):
            row[f"{gpu.name}_cycles"] = numbers.cycles
            row[f"{gpu.name}_registers"] = numbers.registers
            row[f"{gpu.name}_ratio"] = (numbers.cycles or 0) / base
    columns = [
        Column("row", "shader"),
        Column("text", table.unit),
        Column("text_ratio", "ratio", ratio),
        *(
            column
            for gpu in gpus
            for column in (
                Column(f"{gpu.name}_cycles", f"{gpu.name} cycles"),
                Column(f"{gpu.name}_ratio", "ratio", ratio),
                Column(f"{gpu.name}_registers", "registers"),
            )
        ),
    ]
    notes = [WHOLE, *([table.note] if table.note else [])]
    return Section(table.key, table.title, notes, columns, rows)


WHOLE = "Whole shaders from the normal map to the radiance; ratios are to the last row."
