"""Tables in exported texts: the buffer that a host binds, and functions that read it."""

from __future__ import annotations

import base64
import functools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from scipy.interpolate import RegularGridInterpolator
from support.tolerances import DOUBLE

import gonio
from gonio import measured
from gonio.cli import main
from gonio.export import export
from gonio.export.buffer import WIDTH, Buffer, check_unread
from gonio.export.lit import export_lit
from gonio.export.manifest import manifest
from gonio.export.prove import Proof, prove
from gonio.export.prove.runners import each_way
from gonio.export.tree import ExportError
from gonio.lang import Color, Float, Sample, Vec2, Vec3, fract, vec3
from gonio.measured import as_model
from gonio.measured.frames import half_difference, spherical
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.table import COUNT_MAX, Table, fetch
from gonio.view.page import Names, payload_of

LANGUAGES = ("cpp", "cuda", "msl", "hlsl", "slang", "wgsl", "glsl", "essl")

# Small tables: what is compared is how they are read.
ISOTROPIC, ANISOTROPIC = (20, 9, 12), (6, 12, 5, 8)


class Smooth:
    """A measurement without a file, with another value for every pair of directions."""

    reciprocal = True

    def __call__(self, wi: Any, wo: Any) -> Any:
        theta_h, phi_h, theta_d, phi_d = half_difference(wi, wo)
        gloss = np.exp(-((theta_h / 0.4) ** 2)) * (1.5 + np.cos(2 * phi_d) * np.sin(theta_d))
        tint = 0.3 + 0.1 * np.cos(2 * phi_h) * np.sin(theta_h)
        return np.stack([tint, gloss, 0.2 + 0.1 * theta_d], -1), np.ones(len(wi), bool)


@functools.cache
def made(isotropic: bool = True) -> Model:
    w = spherical(np.array([0.3, 0.8]), np.array([0.1, 2.0]))
    found = measured.measurement(
        "test",
        "smooth",
        w,
        w[::-1],
        Smooth()(w, w[::-1])[0],
        channels=("r", "g", "b"),
        isotropic=isotropic,
        interpolator=Smooth(),
    )
    return as_model(found, ISOTROPIC if isotropic else ANISOTROPIC)


def proofs(model: Model, languages: tuple[str, ...], rows: int = 400, **only: Any) -> list[Proof]:
    texts = [export({"paint": model}, language, **only)[0] for language in languages]
    return prove([(model, way) for text in texts for way in each_way(text)], rows)


# --- what the shaders compute --------------------------------------------------------------------


@pytest.mark.parametrize("isotropic", [True, False])
def test_every_language_computes_what_the_measured_model_does(isotropic: bool) -> None:
    found = proofs(made(isotropic), LANGUAGES if isotropic else ("cpp", "essl"))
    assert [p for p in found if not p.holds] == []
    assert {p.function for p in found} == {"eval", "sample", "pdf", "albedo"}


def test_a_coat_over_measured_paint_reads_the_tables_of_its_base() -> None:
    coated = gonio.model("weidlich_wilkie", base=made())
    found = proofs(coated, ("cpp",), 200, only=["eval", "pdf"])
    assert [p for p in found if not p.holds] == []


def test_lights_and_tables_come_from_one_host() -> None:
    model = made()
    texts = [
        export_lit(model, "paint", ["directional", "ambient"], to, lookups="host")
        for to in ("cpp", "wgsl")
    ]
    assert texts[0].entry.hosted == ("eval", "shade")
    found = prove([(model, text) for text in texts], 200)
    assert [p for p in found if not p.holds] == []


class Shifted(Buffer):
    """A host's mistake: every entry is the one before."""

    def rows(self) -> Any:
        return np.roll(super().rows(), 1, axis=0)


def test_a_buffer_off_by_one_entry_is_found() -> None:
    text = export({"paint": made()}, "cpp")[0]
    assert text.buffer is not None
    wrong = replace(text, buffer=Shifted(text.buffer.prefix, text.buffer.placed))
    assert {p.function for p in prove([(made(), wrong)], 200) if not p.holds} >= {"eval", "albedo"}


# --- the file and what is said of it -------------------------------------------------------------


def in_buffer(about: dict[str, Any], content: bytes, lookup: str) -> Any:
    """A table as docs/embedding.md describes the file."""
    table = next(t for t in about["buffer"]["tables"] if t["lookup"] == lookup)
    rows = np.frombuffer(content, "<f4").reshape(about["buffer"]["entries"], 4)
    rows = rows[table["first"] : table["first"] + table["count"], : table["components"]]
    return rows.reshape(*table["shape"], table["components"])


def test_another_reader_of_the_file_finds_the_models_values() -> None:
    text = export({"paint": made()}, "glsl")[0]
    assert text.buffer is not None
    about = manifest(made(), "paint")
    assert about["buffer"]["read_by"] == ["eval", "sample", "pdf", "albedo"]
    assert about["buffer"]["entries"] % WIDTH == 0
    values = in_buffer(about, text.buffer.content(), "paint_values")
    n_h, n_d, n_p = values.shape[:3]
    # phi_d goes round; numbers stand for the middle of their steps
    round_ = np.concatenate([values[:, :, -1:], values, values[:, :, :1]], 2)
    places = (np.arange(n_h), np.arange(n_d), np.arange(-1, n_p + 1))
    between = RegularGridInterpolator(places, round_)
    rng = np.random.default_rng(5)
    wi, wo = (spherical(np.arccos(rng.uniform(0.1, 1, 500)), rng.uniform(-3, 3, 500)) for _ in "io")
    theta_h, _, theta_d, phi_d = half_difference(wi, wo)
    at = np.stack(
        [
            np.clip(n_h * np.sqrt(theta_h / (0.5 * np.pi)) - 0.5, 0, n_h - 1),
            np.clip(n_d * theta_d / (0.5 * np.pi) - 0.5, 0, n_d - 1),
            n_p * (phi_d % np.pi) / np.pi - 0.5,
        ],
        -1,
    )
    # The table is stored in single precision
    assert np.allclose(between(at), made().eval(wi, wo), rtol=1e-5)


def run(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


@pytest.fixture
def paint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "paint.binary"
    path.write_bytes(b"")  # whose tables are those of above
    monkeypatch.setattr(measured, "as_model", lambda _: made())
    return path


def test_the_command_writes_texts_with_the_file_that_they_read(paint: Path, tmp_path: Path) -> None:
    named = f"paint={paint}"
    folder = tmp_path / "host"
    done = run("export", named, "--to", "all", "--manifest", "-o", f"{folder}/")
    assert done.exit_code == 0, done.output
    assert "OSL and MaterialX are left out" in done.stderr
    written = {path.name for path in folder.iterdir()}
    assert {"paint.json", "paint_tables.bin", "paint.wgsl", "paint.h"} <= written
    assert not {"paint.osl", "paint.mtlx"} & written
    about = json.loads((folder / "paint.json").read_text(encoding="utf-8"))
    assert (folder / about["buffer"]["file"]).stat().st_size == 16 * about["buffer"]["entries"]
    # One text under a name of its own: the tables lie beside it
    done = run("export", named, "-o", str(tmp_path / "x.wgsl"))
    assert done.exit_code == 0, done.output
    assert (tmp_path / "paint_tables.bin").exists()
    shown = run("export", named, "--to", "glsl")
    assert "paint_tables.bin" in shown.stderr
    assert shown.stdout == (folder / "paint.glsl").read_text(encoding="utf-8")
    for refused in (("--to", "osl"), ("--to", "mtlx")):
        done = run("export", named, *refused)
        assert done.exit_code == 1
        assert done.stderr.count("\n") == 1
        assert "gonio fit" in done.stderr


@pytest.mark.parametrize("language", ["glsl", "wgsl", "slang", "hlsl"])
def test_a_text_of_several_models_is_not_lost_to_another_of_the_same_name(
    language: str, tmp_path: Path
) -> None:
    def export_as(*arguments: str) -> Any:
        return run("export", *arguments, "--to", language, "-o", f"{tmp_path}/")

    assert export_as("lambert", "minnaert").exit_code == 0
    (text,) = tmp_path.iterdir()
    before = text.read_text()
    refused = export_as("lambert", "ward")
    assert refused.exit_code != 0
    assert f"{text} holds {'Minnaert' if language == 'slang' else 'minnaert'}" in refused.output
    assert "--prefix" in refused.output
    assert text.read_text() == before
    # The same again, with more, under another name, and alone
    assert export_as("lambert", "minnaert").exit_code == 0
    assert export_as("lambert", "minnaert", "ward").exit_code == 0
    assert export_as("lambert", "ward", "--prefix", "two").exit_code == 0
    assert export_as("ward").exit_code == 0


def test_tables_that_another_text_reads_are_not_replaced(
    paint: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    two = (f"one={paint}", f"two={paint}")
    tables = tmp_path / "gonio_tables.bin"
    assert run("export", *two, "-o", str(tmp_path / "first.h")).exit_code == 0
    before = tables.read_bytes()
    assert run("export", *two, "-o", str(tmp_path / "same.wgsl")).exit_code == 0
    monkeypatch.setattr(measured, "as_model", lambda _: made(False))
    done = run("export", *two, "-o", str(tmp_path / "second.h"))
    assert done.exit_code == 1
    assert "first.h reads gonio_tables.bin" in done.stderr
    assert done.stderr.count("\n") == 1
    assert tables.read_bytes() == before
    assert not (tmp_path / "second.h").exists()
    named = run("export", *two, "--prefix", "other", "-o", str(tmp_path / "second.h"))
    assert named.exit_code == 0, named.output
    # No text is left that reads the old ones
    (tmp_path / "same.wgsl").unlink()
    assert run("export", *two, "-o", str(tmp_path / "first.h")).exit_code == 0
    assert tables.read_bytes() != before


class Painted(Names):
    """A page's names, one of which has tables."""

    def start(self, _: str) -> Model:
        return made()


def test_the_page_gets_the_tables_that_a_host_binds() -> None:
    tables = payload_of(Painted(), "paint", made())["tables"]
    text = export({"model": made()}, "wgsl")[0]
    assert text.buffer is not None
    assert f"{tables['name']}: array<vec4f>" in text.source
    rows = np.frombuffer(base64.b64decode(tables["rows"]), "<f4").reshape(tables["entries"], 3)
    wanted = np.frombuffer(text.buffer.content(), "<f4").reshape(-1, 4)
    assert np.array_equal(rows, wanted[:, :3])
    assert not wanted[:, 3].any()


def test_a_program_that_binds_no_buffer_says_so() -> None:
    with pytest.raises(ExportError, match="does not bind"):
        check_unread(export({"paint": made()}, "wgsl")[0].buffer, "it")


# --- tables of one's own -------------------------------------------------------------------------

# Of a module: it belongs to no model.
RAMP = Table("ramp", np.linspace(0, 1, 9) ** 2, doc="Squares")


def between(x: Float) -> Float:
    """The ramp at x in [0, 1], linear between its entries."""
    place = 7.999 * x
    t = fract(place)
    k = place - t
    return (1 - t) * fetch(RAMP, k) + t * fetch(RAMP, k + 1)


class Looked(Model, register=False):
    """Two models share one table; each has colours of its own."""

    scale: Float = param(1.0, 0, 1, "of the ramp")
    tints = Table("tints", [[1, 0.5, 0.25], [0.5, 1, 0.75]], colours=True)

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Of the steeper direction."""
        steep = 0 * wi.z + 1
        return self.scale * between(wi.z) * between(wo.z) * fetch(self.tints, steep)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """By the cosine."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))


def test_models_of_a_text_share_a_table_of_a_module() -> None:
    texts = export({"one": Looked(), "other": made()}, "wgsl", only=["eval"])
    assert texts[0].buffer is not None
    names = [place.lookup for place in texts[0].buffer.placed]
    assert names == ["gonio_ramp", "one_tints", "other_values"]
    found = prove(list(zip((Looked(), made()), texts, strict=True)), 200)
    assert [p for p in found if not p.holds] == []


def test_python_squares_by_the_ramp() -> None:
    w = np.array([[0.6, 0, 0.8]])
    x = 7.999 * 0.8 / 8  # its place among nine squares, between the sixth and the seventh
    low, high = (6 / 8) ** 2, (7 / 8) ** 2
    ramp = low + (8 * x - 6) * (high - low)
    assert np.allclose(Looked().eval(w, w), ramp * ramp * np.array([0.5, 1, 0.75]), rtol=DOUBLE)


class Wild(Model, register=False):
    """It asks for something that is no table."""

    scale: Float = param(1.0, 0, 1, "of nothing")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """From a tuple."""
        return vec3(1, 1, 1) * fetch((1, 2), wi.z)  # type: ignore[arg-type]


def test_places_of_the_largest_table_stay_whole_when_a_half_is_added() -> None:
    # Shaders read int(index + 0.5): the sum has to round to nothing else in single precision
    last = np.float32(COUNT_MAX - 1)
    assert int(last + np.float32(0.5)) == COUNT_MAX - 1
    # ... as it does in the next octave, for half of the places
    assert int(np.float32(COUNT_MAX + 1) + np.float32(0.5)) != COUNT_MAX + 1


def test_what_is_no_table_is_said_with_its_place() -> None:
    with pytest.raises(ExportError, match=r"test_export_buffer.py:\d+.*gonio.table.Table"):
        export({"wild": Wild()}, "glsl", only=["eval"])
    with pytest.raises(ValueError, match="colours end in 3"):
        Table("pairs", np.zeros((4, 2)), colours=True)
    with pytest.raises(ValueError, match=str(COUNT_MAX)):
        Table("huge", np.broadcast_to(np.float32(0), (COUNT_MAX + 1,)))
