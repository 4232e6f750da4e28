"""The shaders of a saved page: one set for every choice of options, as blocks that they share."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from gonio.export.manifest import options
from gonio.export.tree import ExportError
from gonio.fields import ModelError
from gonio.foreign.model import ForeignModel
from gonio.materials import Material
from gonio.materials.notation import split
from gonio.model import Model
from gonio.view.page import SHADERS, Names, payload_of

# More combinations than these are saved one option at a time.
COMBINATIONS_MAX = 32

# Between the paragraphs of a shader.
SEPARATOR = "\n\n"

# What a variant has that its model's payload has already.
SHARED = ("about", "maps", "tables", "description", "title")


def pool(
    names: Names, texts: Iterable[str], progress: Callable[[str], None] = lambda text: None
) -> dict[str, Any]:
    """Variants of some models for `gonio.view.page.saved`.

    Every combination of a model's options where there are few; else each option changed alone. Inner models
    stay what they are. A shader is stored as the numbers of its paragraphs, most of which variants share.

    Returns:
        "pool": paragraphs by language; "variants": by text, the payload with paragraphs' numbers.
    """
    blocks: dict[str, dict[str, int]] = {language: {} for language in SHADERS}
    variants: dict[str, Any] = {}
    for text in texts:
        what = names.find(text)
        if isinstance(what, ForeignModel):
            continue  # it has no options
        progress(f"{text}: shaders for its options")
        for changed in _variants(what):
            key = choice(split(text)[0], changed)
            if key in variants or changed == what:
                continue
            try:
                made = payload_of(names, text, changed)
            except ExportError:
                continue
            code = made.pop("code")
            about = {k: v for k, v in made.items() if k not in SHARED}
            numbers = {
                language: [
                    blocks[language].setdefault(block, len(blocks[language]))
                    for block in code[language].split(SEPARATOR)
                ]
                for language in SHADERS
            }
            variants[key] = {"about": about, "of": text, **numbers}
    return {
        "variants": variants,
        "pool": {language: list(found) for language, found in blocks.items()},
    }


def choice(name: str, what: Model | Material) -> str:
    """What the page looks a variant up by: the name and every option's value."""
    model = what.model if isinstance(what, Material) else what
    chosen = (f"{o['path']}={o['value']}" for o in options(model, refusals=False))
    return f"{name}|{','.join(chosen)}"


def _variants(what: Model | Material) -> Iterator[Model | Material]:
    model = what.model if isinstance(what, Material) else what
    choices = {o["path"]: [v["value"] for v in o["values"]] for o in options(model, refusals=False)}
    count = 1
    for values in choices.values():
        count *= len(values)
    if count <= COMBINATIONS_MAX:
        wanted: Iterable[dict[str, str]] = (
            dict(zip(choices, values, strict=True))
            for values in itertools.product(*choices.values())
        )
    else:
        wanted = ({path: value} for path, values in choices.items() for value in values)
    for changes in wanted:
        try:
            yield what.replace(**changes)
        except ModelError:
            continue
