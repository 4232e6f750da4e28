"""What of a model's methods is outside the language: read for exports, without making one."""

from __future__ import annotations

from gonio.export.read import Reader
from gonio.export.targets import TARGETS
from gonio.export.tree import METHODS, ExportError
from gonio.model import Model


def outside(model: Model) -> list[ExportError]:
    """The first thing in each method that no export could read, each place once.

    Of a model that cannot be exported for another reason, such as one without parameters, nothing.
    """
    library = next(iter(TARGETS.values())).library
    found: dict[tuple[str, int], ExportError] = {}
    for name in METHODS:
        if not model.writes(name):
            continue
        reader = Reader(model.name, library, (model.name,))  # what has failed leaves it half-way
        try:
            reader.method(reader.model(model, model.name, title=model.name), name)
        except ExportError as error:
            if error.place is not None:
                found.setdefault(error.place, error)
    return list(found.values())
