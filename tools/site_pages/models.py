"""The gallery of models, and a page for each, from its file."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import gonio
from gonio.description import citations
from gonio.description.about import describe, summary, uses
from gonio.export.files import texts
from gonio.export.materialx import NAME as MATERIALX
from gonio.export.targets import TARGETS
from gonio.fields import shown
from site_pages import formulas
from site_pages.markdown import LEXERS, fence, page, plain, sentence, table, tabs
from site_pages.pictures import Pictures, shared_settings, steps
from site_pages.sources import Sources

FOLDER = "models"


def write(
    sources: Sources, pictures: Pictures, formulas_page: str, languages: Sequence[str]
) -> None:
    """The gallery and all pages, with code in some languages."""
    exports = _exports(languages)
    for name, cls in gonio.models().items():
        sources.write(f"{FOLDER}/{name}.md", _page(sources, pictures, cls, exports, formulas_page))
    sources.write(f"{FOLDER}/index.md", _gallery(sources, pictures, formulas_page))


def put(sources: Sources, picture: Path) -> str:
    """The address of a picture as seen from a page one folder deep."""
    sources.copy(picture, f"pictures/{picture.name}")
    return f"../pictures/{picture.name}"


def cards(rows: Iterable[tuple[str, str, str, str]]) -> str:
    """A grid of cards, each with its title, page, text and picture's address."""
    lines = ["::::{grid} 2 3 4 4", ":gutter: 2", ":class-container: gallery", ""]
    for title, document, text, address in rows:
        lines += [f":::{{grid-item-card}} {title}", f":link: {document}", ":link-type: doc"]
        lines += [f":img-top: {address}", f":img-alt: {title}", "", text, ":::"]
    return "\n".join([*lines, "::::"])


def _exports(languages: Sequence[str]) -> dict[str, str]:
    """Every model in some languages, by file name."""
    models = {name: gonio.model(name) for name in gonio.models()}
    return texts(models, languages, together=False)


# --- the gallery ---------------------------------------------------------------------------------------


def _gallery(sources: Sources, pictures: Pictures, formulas_page: str) -> str:
    """All models, in groups under the headings under which docs/formulas.md has their equations."""
    groups: dict[str, list[str]] = {}
    for passage in formulas.passages(formulas_page):
        groups.setdefault(passage.heading, [])
    for name, cls in gonio.models().items():
        groups[formulas.of_class(formulas_page, cls.__name__)[0].heading].append(name)
    blocks = [
        "# Models",
        "Each is one published model in one file. `gonio list` shows them in the shell; what a page says "
        "is read from the model's file.",
    ]
    for heading, names in groups.items():
        if names:
            blocks += [f"## {heading}", cards(_cards(sources, pictures, names))]
    hidden = "\n".join(["```{toctree}", ":hidden:", "", *gonio.models(), "```"])
    return page(*blocks, hidden)


def _cards(
    sources: Sources, pictures: Pictures, names: Iterable[str]
) -> Iterator[tuple[str, str, str, str]]:
    for name in names:
        cls = gonio.models()[name]
        address = put(sources, pictures.ball(name))
        yield name, name, plain(summary(cls)), address


# --- a page --------------------------------------------------------------------------------------------


def _page(
    sources: Sources,
    pictures: Pictures,
    cls: type[Any],
    exports: dict[str, str],
    formulas_page: str,
) -> str:
    about = describe(cls)
    return page(
        f"# {cls.name}",
        _head(about, put(sources, pictures.ball(cls.name))),
        *_notes(about),
        _plots(sources, pictures, cls),
        *_parameters(sources, pictures, cls, about),
        *_options(about),
        *_promises(about),
        _unlike(about),
        _equations(cls, formulas_page),
        _sources(cls),
        _use(about),
        _code(cls, exports),
    )


def _head(about: dict[str, Any], picture: str) -> str:
    told = [
        f"**{plain(about['title'])}**",
        *map(plain, about["description"].split("\n\n")),
        f'`gonio.{about["class"]}` · <a href="../live.html#a={about["name"]}">try it live</a>',
    ]
    lines = ["::::{grid} 1 2 2 2", ":gutter: 3", "", ":::{grid-item}", ":columns: 12 5 5 5", ""]
    lines += [f"![{about['name']} on the shader ball]({picture})", ":::", "", ":::{grid-item}"]
    lines += [":columns: 12 7 7 7", "", page(*told), ":::", "::::"]
    return "\n".join(lines)


def _notes(about: dict[str, Any]) -> Iterator[str]:
    """What the file's docstring says besides the source: deviations, what not to confuse it with."""
    for heading, text in about["notes"].items():
        if text:
            lead = "" if heading == "remarks" else f"**{heading.capitalize()}.** "
            yield f"{lead}{plain(sentence(text))}"


def _unlike(about: dict[str, Any]) -> str | None:
    rows = [f"- [{o}]({o}.md) {plain(difference)}" for o, difference in about["unlike"].items()]
    return page("## Not to be confused with", "\n".join(rows)) if rows else None


def _plots(sources: Sources, pictures: Pictures, cls: type[Any]) -> str:
    lobes = put(sources, pictures.plot("polar", cls.name))
    albedo = put(sources, pictures.plot("albedo", cls.name))
    return page(
        "## Lobes and albedo",
        f"![Slices through the lobes of {cls.name}]({lobes})",
        f"![Directional and mean albedo of {cls.name}]({albedo})",
        f"`gonio plot {cls.name} --kind polar`, `--kind albedo` and others make these with any parameters.",
    )


def _parameters(
    sources: Sources, pictures: Pictures, cls: type[Any], about: dict[str, Any]
) -> Iterator[str]:
    if not about["parameters"]:
        return
    yield "## Parameters"
    model = gonio.model(cls.name)
    for parameter in about["parameters"]:
        name = parameter["name"]
        declared = cls.fields[name]
        kind = "colour" if declared.width == 3 else "number"
        yield f"### {name}"
        default = shown(declared.default)
        yield (
            f"{plain(sentence(declared.doc))} A {kind}, {declared.range_text()}; the default is {default}."
        )
        strip, labels = steps(model, name)
        if strip:
            address = put(sources, pictures.strip(strip))
            lines = [f"![{name} at {', '.join(labels)}]({address}){{.strip}}", ""]
            columns = "".join(f"<span>{label}</span>" for label in labels)
            yield "\n".join([*lines, f'<div class="strip-labels">{columns}</div>'])
            if needed := shared_settings(strip):
                yield f"Shown with `{', '.join(needed)}`, without which it has no effect."


def _options(about: dict[str, Any]) -> Iterator[str]:
    if about["options"]:
        rows = []
        for option in about["options"]:
            values = [
                f"`{v}` (default)" if v == option["default"] else f"`{v}`" for v in option["values"]
            ]
            rows.append((f"`{option['name']}`", ", ".join(values), plain(option["meaning"])))
        yield "## Options"
        yield "Choices that change the code; an export has the chosen branch alone."
        yield table(("option", "values", "meaning"), rows)
    if about["models"]:
        yield "## Inner models"
        yield table(
            ("name", "default", "meaning"),
            [
                (f"`{m['name']}`", f"[{m['default']}]({m['default']}.md)", plain(m["meaning"]))
                for m in about["models"]
            ],
        )


def _promises(about: dict[str, Any]) -> Iterator[str]:
    yield "## Claims, as measured"
    yield (
        "`gonio check` searches all angles, parameters and options for the worst case. It fails where a "
        "promise is broken, and where a known size is exceeded or far too large; the tests run it on "
        "every model. [Checking a model](../docs/checking.md) says how."
    )
    for kind, heading in (("promised", "Promised"), ("known", "Known not to hold")):
        texts = [claim["text"] for claim in about["claims"] if claim["kind"] == kind]
        if texts:
            yield f"**{heading}**"
            yield "\n".join(f"- {plain(text)}" for text in texts)
    closed = about["closed_form"]
    words = {True: "has a closed form", False: "is a numeric quadrature"}
    yield (
        f"The directional albedo {words[closed['albedo']]}; the mean albedo {words[closed['mean_albedo']]}."
    )
    if about["caveats"]:
        yield "## Caveats"
        yield "\n".join(f"- {plain(text)}" for text in about["caveats"])


def _equations(cls: type[Any], formulas_page: str) -> str:
    found = formulas.of_class(formulas_page, cls.__name__)
    # The passages are written for the folder docs/
    body = [p.text.replace("](", "](../docs/") for p in found]
    return page(
        "## Equations",
        *body,
        "Notation, shared terms and errata: [Formulas and errata](../docs/formulas.md).",
    )


def _sources(cls: type[Any]) -> str:
    own = citations.of_model(cls)
    every = citations.of_model(cls, parts=True)
    parts = [publication for publication in every if publication not in own]
    rows = [plain(sentence(describe(cls)["source"] or ""))]
    blocks = ["## Sources", *rows, fence("\n\n".join(p.bibtex() for p in own), "bibtex")]
    if parts:
        blocks += [
            ":::{dropdown} Sources of the parts that it is made of",
            fence("\n\n".join(p.bibtex() for p in parts), "bibtex"),
            ":::",
        ]
    return page(*blocks)


def _use(about: dict[str, Any]) -> str:
    languages = {"Python": "python", "Mitsuba": "python", "XML": "xml"}
    items = [(k, fence(text, languages.get(k, "sh"))) for k, text in uses(about).items()]
    return page("## Use", tabs(items, "use"))


def _code(cls: type[Any], exports: dict[str, str]) -> str:
    """The model's own file and all exports, behind tabs."""
    python = Path(os.path.join(os.path.dirname(gonio.__file__), "models", f"{cls.name}.py"))
    items = [("Python", fence(python.read_text(encoding="utf-8"), "python"))]
    titles = {target.extension: target.title for target in TARGETS.values()} | {
        MATERIALX: "MaterialX"
    }
    for extension, title in titles.items():
        text = exports.get(f"{cls.name}.{extension}")
        if text is not None:
            items.append((title, fence(text, LEXERS[extension])))
    return page(
        "## Code",
        f"The model's file, and what `gonio export {cls.name}` makes of it; the tests compile and run each "
        "and compare it with the model.",
        tabs(items, "language"),
    )
