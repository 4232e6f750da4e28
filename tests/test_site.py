"""The site: built without a warning, with a page for every model, no lost link, and guides that work."""

from __future__ import annotations

import base64
import gzip
import json
import re
import shlex
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import click
import make_conventions_drawing
import make_site
import numpy as np
import pytest
from click.testing import CliRunner
from site_pages import docstrings, formulas, markdown, texts
from site_pages.pictures import shared_settings, steps
from site_pages.sources import Sources

import gonio
from gonio import cli, reproduce
from gonio.export.targets import TARGETS
from gonio.materials import library
from gonio.render.passes import ready_mitsuba
from gonio.render.picture import write_picture

ROOT = Path(__file__).parent.parent
GUIDES = sorted((ROOT / "docs" / "guides").glob("*.md"))


# --- the built site --------------------------------------------------------------------------------


class Page(HTMLParser):
    """What a page links to, what it loads, and the places that others can link to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.places: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if found.get("id"):
            self.places.add(str(found["id"]))
        if tag == "a" and found.get("href"):
            self.links.append(str(found["href"]))
        rel = str(found.get("rel"))
        if tag == "link" and rel in ("stylesheet", "icon", "preload"):
            self.loads.append(str(found["href"]))
        if tag in ("img", "script", "source", "iframe") and found.get("src"):
            self.loads.append(str(found["src"]))


def broken_links(root: Path) -> list[str]:
    """Links and loaded files of the pages below a folder that are not there."""
    pages = {path.resolve(): Page(path) for path in root.rglob("*.html")}
    broken = []
    for path, page in pages.items():
        for link in (*page.links, *page.loads):
            if re.match(r"(https?|mailto|data):", link):
                continue
            file, _, place = unquote(link).partition("#")
            target = (path.parent / file.partition("?")[0]).resolve() if file else path
            # The viewer reads what follows the mark; it is no place on the page
            lost = place and target in pages and target.name != "live.html"
            if not target.is_file() or (lost and place not in pages[target].places):
                broken.append(f"{path.relative_to(root)}: {link}")
    return broken


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site in its quick form. A warning of Sphinx would raise."""
    output = tmp_path_factory.mktemp("site")
    results = output / "results"
    results.mkdir()
    reproduce.write(reproduce.find("eon:tab1"), results)
    make_site.build(output, quick=True, results=results)
    return output / "html"


def test_every_model_and_material_has_its_page(site: Path) -> None:
    for name in gonio.models():
        text = (site / "models" / f"{name}.html").read_text(encoding="utf-8")
        for parameter in gonio.models()[name].fields:
            assert parameter in text, (name, parameter)
        for heading in ("Claims, as measured", "Sources", "Code"):
            assert heading in text, (name, heading)
    for name in library():
        assert (site / "materials" / f"{name}.html").is_file()


def test_the_live_page_opens_with_what_was_chosen_and_not_with_the_first_of_the_alphabet(
    site: Path,
) -> None:
    text = (site / "live.html").read_text(encoding="utf-8")
    packed = re.search(r'id="gonio-data">([^<]*)<', text)
    assert packed
    data = json.loads(gzip.decompress(base64.b64decode(packed[1])))
    assert data["show"] == list(make_site.LIVE_START)
    assert set(data["show"]) <= set(data["models"])
    assert f"<title>{make_site.LIVE_START[0]}" in text


def test_every_link_and_every_loaded_file_is_there(site: Path) -> None:
    assert len(list(site.rglob("*.html"))) > 100
    assert broken_links(site) == []


def loaded_from_the_network(root: Path) -> list[str]:
    """What pages below a folder, and their styles, load from elsewhere."""
    loads = [load for path in root.rglob("*.html") for load in Page(path).loads]
    styles = "".join(path.read_text(encoding="utf-8") for path in root.rglob("*.css"))
    loads += re.findall(r"(?:@import|url\()\s*['\"]?((?:https?:)?//[^'\")]*)", styles)
    return [load for load in loads if re.match(r"(https?:)?//", load)]


def test_nothing_is_loaded_from_the_network(site: Path) -> None:
    assert loaded_from_the_network(site) == []


def test_the_sites_own_theme_loads_nothing_that_is_not_there(tmp_path: Path) -> None:
    sources = Sources(tmp_path / "source")
    sources.write("index.md", "# A\n\n```{toctree}\nb.md\n```\n")
    sources.write("b.md", "# B\n\n[a](index.md)\n")
    make_site.run_sphinx(tmp_path)
    assert "furo" in (tmp_path / "html" / "b.html").read_text(encoding="utf-8")
    assert broken_links(tmp_path / "html") == []
    assert loaded_from_the_network(tmp_path / "html") == []


def test_a_style_from_the_network_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<script src="//x.org/a.js"></script>', encoding="utf-8")
    (tmp_path / "a.css").write_text("@import 'https://x.org/a.css';", encoding="utf-8")
    assert loaded_from_the_network(tmp_path) == ["//x.org/a.js", "https://x.org/a.css"]


def test_every_item_of_every_text_is_on_its_page(site: Path) -> None:
    for name, text in reproduce.texts().items():
        page = re.sub("<[^>]+>", "", (site / "texts" / f"{name}.html").read_text(encoding="utf-8"))
        assert [i.id for i in text.items if f"gonio reproduce {i.id}" not in page] == []
        assert "::test_" in page, "errata have proofs"
    made = (site / "texts" / "eon.html").read_text(encoding="utf-8")
    assert made.count('class="verdict') == 2, "in the table of all, and with its numbers"


def test_a_text_s_page_shows_an_item_s_picture_without_the_numbers_below_it(tmp_path: Path) -> None:
    from PIL import Image

    class Red:
        def save(self, output: str | Path) -> Path:
            Image.new("RGB", (300, 200), "red").save(output, format="PNG")
            return Path(output)

    text = reproduce.Text("t", "A text")

    @text.item("1", "Figure 1", "something red")
    def red(sheet: reproduce.Sheet) -> Red:
        sheet.show("how red", 1)
        return Red()

    reproduce.write(text.items[0], tmp_path)
    result = texts._result(tmp_path, "t:1")
    assert result is not None
    sources = Sources(tmp_path / "source")
    with Image.open(tmp_path / "t-1.png") as page:
        assert len(page.getcolors(1 << 16) or ()) > 2, "the page itself has text"
    address = texts._put(sources, tmp_path / "t-1.png", result["picture"])
    with Image.open(sources.folder / "texts" / address) as shown:
        assert shown.size == (300, 200)
        assert np.ptp(np.asarray(shown), axis=(0, 1)).max() <= 2  # WebP's rounding


def test_columns_that_say_nothing_are_left_out() -> None:
    head, rows = texts._without_empty(("", "text", "gonio"), [("a", "", "1"), ("b", "", "2")])
    assert head == ["", "gonio"]
    assert rows == [["a", "1"], ["b", "2"]]


def test_every_public_module_has_a_page_of_reference(site: Path) -> None:
    for name in ("gonio", "gonio.plot", "gonio.render", "gonio.parts.fresnel", "gonio.reference"):
        text = (site / "api" / f"{name}.html").read_text(encoding="utf-8")
        assert 'class="py' in text, name
    assert "gonio export" in (site / "commands.html").read_text(encoding="utf-8")


def test_a_lost_page_a_lost_place_and_a_lost_picture_are_noticed(tmp_path: Path) -> None:
    (tmp_path / "b.html").write_text('<h2 id="here">B</h2>', encoding="utf-8")
    text = (
        '<a href="b.html#here"></a><a href="b.html#gone"></a><a href="c.html"></a><img src="d.png">'
    )
    (tmp_path / "a.html").write_text(text, encoding="utf-8")
    lost = [line.partition(": ")[2] for line in broken_links(tmp_path)]
    assert lost == ["b.html#gone", "c.html", "d.png"]


def test_a_page_with_a_link_to_nowhere_stops_the_build(tmp_path: Path) -> None:
    sources = Sources(tmp_path / "source")
    sources.write("index.md", "# A\n\n[b](b.md)\n")
    with pytest.raises(make_site.SiteError):
        make_site.run_sphinx(tmp_path)


# --- its parts -------------------------------------------------------------------------------------


def test_plain_text_is_never_taken_for_markup() -> None:
    assert markdown.plain("1 - <E_F> * [a] `x_y * z`") == "1 - \\<E\\_F\\> \\* \\[a\\] `x_y * z`"
    assert markdown.sentence("slope along x") == "Slope along x."
    assert markdown.sentence("f is f.") == "f is f."
    assert markdown.sentence("a map of the growth") == "A map of the growth."


def test_docstrings_become_markup_with_their_code() -> None:
    text = ["See `eval`; |f| and x_:", "", "    a * b", "", "Args:", "    wi: *unit*."]
    assert docstrings.convert(text) == [
        "See ``eval``; \\|f\\| and x\\_:",
        "",
        "::",
        "",
        "    a * b",
        "",
        "Args:",
        "    wi: \\*unit\\*.",
    ]


def test_every_model_has_its_equations_on_the_page_of_formulas() -> None:
    page = formulas.read(ROOT)
    for cls in gonio.models().values():
        assert formulas.of_class(page, cls.__name__), cls.name
    with pytest.raises(ValueError, match=r"the equations of `gonio\.NoSuchModel` are missing"):
        formulas.of_class(page, "NoSuchModel")
    assert len(formulas.errata(page)) == len(reproduce.texts())


def test_a_strip_shows_the_useful_range_of_a_parameter() -> None:
    texts, labels = steps(gonio.model("eon"), "roughness")
    assert labels == ["0", "0.25", "0.5", "0.75", "1"]
    assert [gonio.load(t).roughness for t in texts] == [0, 0.25, 0.5, 0.75, 1]
    # f0 is read with Schlick's term only, which the strip chooses
    texts, _ = steps(gonio.model("torrance_sparrow"), "f0")
    assert shared_settings(texts) == ["fresnel=schlick"]
    assert shared_settings(["eon:roughness=0.0", "eon"]) == []


def test_sources_keep_what_is_the_same_and_remove_what_is_gone(tmp_path: Path) -> None:
    first = Sources(tmp_path)
    first.write("models/a.md", "a")
    first.write("models/b.md", "b")
    before = (tmp_path / "models" / "a.md").stat().st_mtime_ns
    again = Sources(tmp_path)
    again.write("models/a.md", "a")
    again.clean()
    assert (tmp_path / "models" / "a.md").stat().st_mtime_ns == before
    assert not (tmp_path / "models" / "b.md").exists()


def test_the_drawing_of_the_conventions_is_made_by_its_code() -> None:
    drawn = make_conventions_drawing.TARGET.read_text(encoding="utf-8")
    assert drawn == make_conventions_drawing.drawing()
    # The frame is right-handed as seen: x turns to y against the clock, and the normal points up
    (x, up), (_, up_y) = map(make_conventions_drawing.place, [(1, 0, 0), (0, 1, 0)])
    assert up > up_y, "y is further away"
    assert x > make_conventions_drawing.ORIGIN[0]
    assert make_conventions_drawing.place((0, 0, 1))[1] < make_conventions_drawing.ORIGIN[1]


# --- the guides ------------------------------------------------------------------------------------

# Pictures of guides, as small as they can be: what they look like is not what is tested here.
SMALL = {
    "render": ["--size", "16", "--spp", "1"],
    "scene": ["--size", "16", "--spp", "1"],
}

# Commands that other tests run and that take long or wait: here only what they are given is looked at.
ONLY_PARSED = ("view", "sheet", "doctor", "reproduce", "check", "data", "fit")


def blocks(guide: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", guide.read_text("utf-8"), re.S | re.M)


def commands(guide: Path) -> list[list[str]]:
    """Arguments of all commands of a guide, without "gonio"."""
    lines = [line for block in blocks(guide, "sh") for line in block.splitlines()]
    found = [shlex.split(line, comments=True) for line in lines]
    assert all(words[0] == "gonio" for words in found if words)
    return [words[1:] for words in found if words]


def write_files(guide: Path, folder: Path) -> None:
    """The files that a guide shows, each with its name in its first line, and those that readers have."""
    for language in ("toml", "python", "xml"):
        for block in blocks(guide, language):
            if name := re.match(r"(?:#|<!--) (\w+\.(?:toml|py|xml))", block):
                (folder / name[1]).write_text(block, encoding="utf-8")
    corners = ((-1, -1, 0), (1, -1, 0), (1, 1, 0.5), (-1, 1, 0.5))
    mesh = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "f 1 2 3\nf 1 3 4\n"
    (folder / "chair.obj").write_text(mesh, encoding="utf-8")
    ready_mitsuba()
    write_picture(folder / "studio.exr", np.full((8, 16, 3), 0.5, np.float32))


def parsed(words: list[str]) -> click.Context:
    """A command's context with all that it was given; nothing runs.

    Raises:
        click.UsageError: an unknown command, option or value.
    """
    context = click.Context(cli.main, info_name="gonio")
    name, command, rest = cli.main.resolve_command(context, list(words))
    if isinstance(command, click.Group):
        inner = click.Context(command, info_name=name, parent=context)
        name, command, rest = command.resolve_command(inner, rest)
    assert command is not None
    return command.make_context(name, rest, parent=context)


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.stem)
def test_the_commands_of_a_guide_work(
    guide: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_files(guide, tmp_path)
    found = commands(guide)
    assert found
    for words in found:
        parsed(words)
        if words[0] in ONLY_PARSED or "--prove" in words:
            continue
        result = CliRunner().invoke(cli.main, [*words, *SMALL.get(words[0], [])])
        assert result.exit_code == 0, (words, result.output, result.stderr)
        if "-o" in words:
            assert Path(words[words.index("-o") + 1]).exists()


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.stem)
def test_the_python_of_a_guide_works(
    guide: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_files(guide, tmp_path)
    names: dict[str, object] = {"__name__": "guide"}
    for block in blocks(guide, "python"):
        if not re.match(r"# \w+\.py", block):  # a file of its own
            exec(block, names)


def test_an_option_that_is_gone_is_noticed() -> None:
    with pytest.raises(click.UsageError):
        parsed(["render", "gold", "--no-such-option"])
    with pytest.raises(click.UsageError):
        parsed(["rendr", "gold"])


def test_the_guides_name_every_language() -> None:
    text = "".join(path.read_text("utf-8") for path in GUIDES)
    assert [name for name in TARGETS if not re.search(rf"\b{name}\b", text)] == []
