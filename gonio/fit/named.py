"""What is fitted, as text names it: parameters that a text gives stay, others are fixed, freed or tied."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from gonio import materials
from gonio.fields import ModelError
from gonio.fit.columns import CHANNELS, columns, has
from gonio.materials import notation
from gonio.model import Model


class Candidate(NamedTuple):
    """A model that is fitted."""

    model: Model
    fixed: tuple[str, ...]
    """Names that keep the model's values."""
    tied: tuple[tuple[str, ...], ...]
    """Groups of names that are one number."""


def candidates(
    named: Iterable[tuple[str, Model]],
    fix: Sequence[str] = (),
    free: Sequence[str] = (),
    tie: Sequence[str] = (),
) -> list[Candidate]:
    """Models, and what of them stays; with several, each takes the names that it has.

    Args:
        named: the texts of models, such as "disney:metallic=1", and the models.
        fix: parameters or channels of colours that stay, "name" or "name=value".
        free: what a text gives, but begins there instead of staying.
        tie: names that are one number, "alpha_x=alpha_y".

    Raises:
        ModelError: a name that no model has, a value that is none, or a number that is given twice.
    """
    found = [_candidate(text, model, fix, free, tie) for text, model in named]
    _check_names([one.model for one in found], fix, free, tie)
    return found


def _candidate(
    text: str, model: Model, fix: Sequence[str], free: Sequence[str], tie: Sequence[str]
) -> Candidate:
    fixed = [name for name in _given(text) if name not in free and has(model, name)]
    for name, _, value in (entry.partition("=") for entry in fix):
        if has(model, name):
            if value and name in fixed:
                raise ModelError(f"{name} is given twice, by --fix and in {text}; drop one")
            fixed.append(name)
            if value:
                model = _assigned(model, name, value)
    tied = [tuple(part.strip() for part in entry.split("=")) for entry in tie]
    return Candidate(
        model, tuple(fixed), tuple(t for t in tied if all(has(model, name) for name in t))
    )


def _assigned(model: Model, name: str, value: str) -> Model:
    """The model with a parameter, or a channel of a colour, at a value."""
    stored = {path: (declared, old) for path, declared, old in model.parameters()}
    if name in stored:
        inner = notation.assign(
            model, [f"{name}={value}"], lambda text: materials.load_model(text)[0]
        )
        assert not isinstance(inner, materials.Material)
        return inner
    path, _, channel = name.rpartition(".")
    _, old = stored[path]
    triple = list(old if isinstance(old, tuple) else (old,) * 3)
    try:
        triple[CHANNELS.index(channel)] = float(value)
    except ValueError:
        raise ModelError(f"--fix {name}={value}: {value!r} is not a number") from None
    return model.replace(**{path: tuple(triple)})


def _given(text: str) -> Iterator[str]:
    """The parameters that a text gives a model, those of a sum's terms with their paths."""
    one_file = Path(notation.split(text)[0]).exists()
    terms = [text] if one_file else notation.terms(text)
    for number, term in enumerate(terms):
        # Sums of two, one in the other's second
        path = "second." * number + ("first." if number < len(terms) - 1 else "")
        for piece in notation.split(term)[1]:
            yield path + piece.partition("=")[0].strip()


def _check_names(
    models: Sequence[Model], fix: Sequence[str], free: Sequence[str], tie: Sequence[str]
) -> None:
    """Raise the error of the first model for a name that none of them has."""
    for name in (*(entry.partition("=")[0] for entry in fix), *free):
        if not any(has(model, name) for model in models):
            columns(models[0], [name])
    for entry in tie:
        names = [part.strip() for part in entry.split("=")]
        if not any(all(has(model, name) for name in names) for model in models):
            columns(models[0], (), [names])
