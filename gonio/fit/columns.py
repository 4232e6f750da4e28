"""The numbers that a fit may change: parameters, or channels of colours, fixed, tied or free."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from gonio.fields import ModelError, Parameter, is_array
from gonio.messages import did_you_mean
from gonio.model import Model

CHANNELS = "rgb"

Place = tuple[str, int]
"""The path of a parameter, such as "base.rho", and a channel of it."""


@dataclass(frozen=True)
class Column:
    """A number that is free: a parameter, or a channel of a colour, or several that are tied."""

    places: tuple[Place, ...]
    names: tuple[str, ...]
    """For people, one for each place."""
    low: float
    high: float

    @property
    def name(self) -> str:
        """For people: "base.roughness", "rho.r", or "alpha_x=alpha_y"."""
        return "=".join(self.names)

    @property
    def channel(self) -> int | None:
        """The one channel that it is of; None for a number, and for channels of several kinds."""
        found = {
            c if name.endswith(f".{CHANNELS[c]}") else None
            for name, (_, c) in zip(self.names, self.places, strict=True)
        }
        return found.pop() if len(found) == 1 else None


def columns(
    model: Model, fixed: Iterable[str] = (), tied: Iterable[Sequence[str]] = ()
) -> tuple[Column, ...]:
    """The free numbers of a model, those of inner models included.

    Args:
        model: any model.
        fixed: names that keep the model's values: parameters ("base.roughness"), or channels ("rho.r").
        tied: groups of names that are one number, such as ("alpha_x", "alpha_y"); colours are tied
            channel by channel.

    Raises:
        ModelError: a name that is no parameter, names that cannot be tied, a parameter that is an array,
            or nothing left free.
    """
    known = _names(model)
    kept = {place for name in fixed for place in _places(model, name, known, "fix")}
    group: dict[Place, list[Place]] = {}
    for names in tied:
        if len(names) < 2:
            raise ModelError(f"a tie needs two names at least, got {'='.join(names)!r}.")
        sides = [_places(model, name, known, "tie") for name in names]
        if len({len(side) for side in sides}) > 1:
            raise ModelError(f"{'='.join(names)}: a colour and a number cannot be tied.")
        for together in zip(*sides, strict=True):
            if any(place in kept for place in together):
                raise ModelError(f"{'='.join(names)}: what is fixed cannot be tied as well.")
            merged = list(dict.fromkeys(p for place in together for p in group.get(place, [place])))
            group |= dict.fromkeys(merged, merged)
    found: list[Column] = []
    for place in known:
        members = group.get(place, [place])
        if place in kept or members[0] != place:
            continue
        low = max(known[p][1].low for p in members)
        high = min(known[p][1].high for p in members)
        names_ = tuple(known[p][0] for p in members)
        if low > high:
            raise ModelError(f"{'='.join(names_)}: their ranges have nothing in common.")
        found.append(Column(tuple(members), names_, low, high))
    if not found:
        raise ModelError(
            f"{model.name} has no free parameter; leave one out of those that are fixed."
        )
    return tuple(found)


def has(model: Model, name: str) -> bool:
    """Whether a model has a parameter of this name, or a channel."""
    return any(name in (path, text) for (path, _), (text, _) in _names(model).items())


def _names(model: Model) -> dict[Place, tuple[str, Parameter]]:
    """Every number of a model: its name and what is declared about it."""
    found = {}
    for path, declared, value in model.parameters():
        if is_array(value):
            raise ModelError(f"{model.name}: {path} is an array; a fit takes numbers.")
        for c in range(declared.width):
            name = path if declared.width == 1 else f"{path}.{CHANNELS[c]}"
            found[path, c] = (name, declared)
    return found


def _places(
    model: Model, name: str, known: dict[Place, tuple[str, Parameter]], what: str
) -> list[Place]:
    found = [place for place, (text, _) in known.items() if name in (place[0], text)]
    if not found:
        paths = list(dict.fromkeys(path for path, _ in known))
        raise ModelError(
            f"{model.name} has no parameter {name!r} to {what}; {did_you_mean(name, paths)}"
            f"it has {', '.join(paths)}."
        )
    return found


__all__ = ["CHANNELS", "Column", "columns", "has"]
