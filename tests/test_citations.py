"""`gonio.description.citations`: what to cite for a model, found by the titles that its file names."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import gonio
from gonio.cli import main
from gonio.description import citations
from gonio.description.citations import CitationError
from gonio.materials import model_file

OWN_MODEL = '''"""Doubts: a model of nothing.

{source}
"""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Doubts(Model):
    """No light."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF."""
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density."""
        return pdf_cosine(wi)
'''


def own_model(folder: Path, source: str) -> type[gonio.Model]:
    path = folder / "doubts.py"
    path.write_text(OWN_MODEL.format(source=source), encoding="utf-8")
    return model_file.load(path)


def keys(model: gonio.Model | type[gonio.Model], **options: bool) -> list[str]:
    return [publication.key for publication in citations.of_model(model, **options)]


@pytest.mark.parametrize("name", gonio.models())
def test_every_model_names_publications_that_the_bibliography_has(name: str) -> None:
    cls = gonio.models()[name]
    docstring = inspect.getdoc(sys.modules[cls.__module__])
    assert docstring is not None
    source = docstring[re.search(r"^Sources?:", docstring, re.MULTILINE).start() :]  # type: ignore[union-attr]
    assert citations.unknown_titles(source) == []
    assert citations.of_model(cls)


def test_every_publication_is_complete_and_used() -> None:
    root = Path(gonio.__file__).parent.parent
    texts = [path.read_text(encoding="utf-8") for path in (root / "gonio").rglob("*.py")]
    named = {p.key for text in texts for p in citations.named(text)}
    cited = "".join(
        path.read_text(encoding="utf-8")
        for path in [*(root / "tests").glob("anchors*.csv"), root / "docs" / "formulas.md"]
    )
    for key, publication in citations.bibliography().items():
        assert {"title"} < set(publication.fields), key
        assert {"author", "editor"} & set(publication.fields), key
        assert {"year", "url"} & set(publication.fields), key
        assert key in named or key in cited, f"{key} is cited nowhere"


def test_the_bibliography_is_read_to_its_last_entry() -> None:
    """Counted in the text of the file; every brace in it is closed."""
    text = (Path(citations.__file__).parent / "bibliography.bib").read_text(encoding="utf-8")
    assert len(citations.bibliography()) == len(re.findall(r"^@", text, re.MULTILINE))
    assert text.count("{") == text.count("}")
    fields = sum(len(p.fields) for p in citations.bibliography().values())
    assert fields == len(re.findall(r"^  \w+ = ", text, re.MULTILINE))


def test_bibtex_is_what_the_file_says() -> None:
    entry = citations.bibtex([gonio.EON()])
    assert entry.startswith("@article{portsmouth2025,\n  title = {{EON}: A Practical")
    assert "eprint = {2410.18026}" in entry
    assert "alias" not in entry
    assert entry.endswith("\n}\n")


def test_models_inside_a_model_are_cited_as_well() -> None:
    coated = gonio.model("weidlich_wilkie", base=gonio.EON())
    assert keys(coated) == ["elek2010", "weidlich2007", "portsmouth2025"]
    assert keys(coated.written) == ["elek2010", "weidlich2007"]


def test_parts_add_what_the_models_file_imports() -> None:
    own, with_parts = keys(gonio.models()["ue4"]), keys(gonio.models()["ue4"], parts=True)
    assert own == ["karis2013"]
    assert with_parts[:1] == own
    assert {"walter2007", "schlick1994"} < set(with_parts)


def test_several_models_share_entries() -> None:
    text = citations.bibtex([gonio.EON(), gonio.models()["qon"]])
    assert re.findall(r"^@\w+\{(\w+)", text, re.MULTILINE) == ["portsmouth2025", "oren1994"]


def test_a_model_file_is_cited_by_the_titles_it_names(tmp_path: Path) -> None:
    source = 'Source: Phong, "Illumination for computer generated pictures", 1975, p. 315.'
    assert keys(own_model(tmp_path, source)) == ["phong1975"]


def test_a_source_that_the_bibliography_lacks_keeps_its_own_words(tmp_path: Path) -> None:
    cls = own_model(tmp_path, 'Source: Thomas & Others, "On doubts", 33, Eq. 3.')
    (publication,) = citations.of_model(cls)
    assert publication.bibtex() == (
        "@misc{doubts_source,\n  title = {Doubts},\n"
        '  note = {Thomas \\& Others, "On doubts", 33, Eq. 3.}\n}'
    )


def test_a_model_without_a_source_is_an_error_that_says_so(tmp_path: Path) -> None:
    with pytest.raises(CitationError, match=r"doubts names no source.*begins with 'Source:'"):
        citations.of_model(own_model(tmp_path, "It came to us in a dream."))


# --- the command ------------------------------------------------------------------------------------


def cite(*arguments: str) -> Any:
    return CliRunner().invoke(main, ["cite", *arguments])


def cited(text: str) -> list[str]:
    return re.findall(r"^@\w+\{(\w+)", text, re.MULTILINE)


def test_the_command_prints_each_publication_once() -> None:
    result = cite("eon", "lacquered_walnut")
    assert result.exit_code == 0, result.output
    assert cited(result.output) == ["portsmouth2025", "elek2010", "weidlich2007"]


def test_the_command_takes_files_and_parts(tmp_path: Path) -> None:
    (tmp_path / "dull.toml").write_text('model = "ue4"\n', encoding="utf-8")
    assert cited(cite(str(tmp_path / "dull.toml")).output) == ["karis2013"]
    assert "walter2007" in cited(cite(str(tmp_path / "dull.toml"), "--parts").output)
    path = tmp_path / "sources.bib"
    assert cite("phong", "-o", str(path)).exit_code == 0
    assert cited(path.read_text(encoding="utf-8")) == ["phong1975", "lafortune1994"]


def test_the_command_says_what_is_wrong(tmp_path: Path) -> None:
    own_model(tmp_path, "It came to us in a dream.")
    for argument, reason in (("eom", "eon"), (str(tmp_path / "doubts.py"), "names no source")):
        result = cite(argument)
        assert result.exit_code == 1
        assert reason in result.output
        assert len(result.output.strip().splitlines()) == 1
