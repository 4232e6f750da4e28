"""Making items and writing them to files."""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import gonio
from gonio.files import replacing
from gonio.reproduce.page import Box, write_page
from gonio.reproduce.sheet import Sheet, Verdict
from gonio.reproduce.table import table
from gonio.reproduce.text import Item, Made


class ReproduceError(RuntimeError):
    """Items that could not be made."""


Progress = Callable[[int, int, Item, str], None]
"""Called with (items done, items in all, the item, what became of it)."""


def make(item: Item) -> Made:
    """Compute an item's numbers; its picture is drawn when it is saved."""
    sheet = Sheet()
    picture = item.make(sheet)
    return Made(item, sheet, picture)


def write(item: Item, folder: str | Path) -> Made:
    """Write an item's page (.png, if it has a picture), its table (.md) and its numbers (.json).

    Raises:
        OSError: the folder does not exist or cannot be written to.
    """
    folder = Path(folder)
    made = make(item)
    stem = _stem(item)
    picture: Box | None = None
    if made.picture is not None:
        picture = write_page(made, folder / f"{stem}.png")  # first: it may add numbers
    with replacing(folder / f"{stem}.md") as temporary:
        temporary.write_text(table(made), encoding="utf-8")
    with replacing(folder / f"{stem}.json") as temporary:
        temporary.write_text(json.dumps(_data(made, picture), indent=1) + "\n", encoding="utf-8")
    return made


def write_all(
    items: Sequence[Item],
    folder: str | Path,
    *,
    again: bool = False,
    progress: Progress | None = None,
) -> dict[str, Verdict]:
    """Write many items and an index.md; what an earlier run of the same gonio wrote is kept.

    Args:
        items: what to write.
        folder: is created.
        again: make everything anew.
        progress: called after each item.

    Returns:
        The verdicts by id.

    Raises:
        ReproduceError: some could not be made; after all others are written.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    verdicts: dict[str, Verdict] = {}
    failed: dict[str, str] = {}
    for done, item in enumerate(items, 1):
        verdict = None if again else _kept(item, folder)
        told = f"kept, {verdict.value}" if verdict is not None else ""
        if verdict is None:
            try:
                verdict = write(item, folder).verdict
                told = verdict.value
            except Exception as error:  # one that fails does not take the others along
                failed[item.id] = told = f"failed: {error}"
        if verdict is not None:
            verdicts[item.id] = verdict
        if progress is not None:
            progress(done, len(items), item, told)
    with replacing(folder / "index.md") as temporary:
        made = [item for item in items if item.id in verdicts]
        temporary.write_text(_index(made, verdicts), encoding="utf-8")
    if failed:
        names = ", ".join(failed)
        raise ReproduceError(f"{len(failed)} of {len(items)} could not be made: {names}.")
    return verdicts


def _stem(item: Item) -> str:
    return item.id.replace(":", "-")


def _data(made: Made, picture: Box | None) -> dict[str, Any]:
    item = made.item
    return {
        "id": item.id,
        "covers": list(item.covers),
        "source": f"{item.text.title}, {item.source}",
        "states": item.states,
        "verdict": made.verdict.value,
        "picture": picture,
        "remarks": made.sheet.notes(),
        "lines": [
            {
                "what": line.what,
                "text": line.text,
                "relation": line.relation,
                "gonio": _number(line.ours),
                "difference": _number(line.difference),
                "right": None if line.proof is None else _number(line.proof),
                "state": line.state,
                "why": line.why,
            }
            for line in made.sheet.lines
        ],
        "fingerprint": fingerprint(),
    }


def _number(x: float) -> float | None:
    return x if math.isfinite(x) else None


def _kept(item: Item, folder: Path) -> Verdict | None:
    """The verdict that an earlier run of the same code wrote, if it wrote all its files."""
    try:
        data = json.loads((folder / f"{_stem(item)}.json").read_text(encoding="utf-8"))
        if data["fingerprint"] == fingerprint():
            return Verdict(data["verdict"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    return None


@functools.cache
def fingerprint() -> str:
    """Of gonio's own code: after any change, all items are made anew."""
    digest = hashlib.sha256()
    root = Path(gonio.__file__).parent
    for path in sorted(p for s in ("*.py", "*.toml", "*.cpp", "*.glsl") for p in root.rglob(s)):
        digest.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def counted(verdicts: Iterable[Verdict]) -> str:
    """How many there are of each."""
    found = list(verdicts)
    return ", ".join(f"{found.count(kind)} {kind.value}" for kind in Verdict if kind in found)


def _index(items: Sequence[Item], verdicts: dict[str, Verdict]) -> str:
    lines = [
        f"# {len(items)} items: {counted(verdicts.values())}",
        "",
        "| item | where | verdict |",
        "|---|---|---|",
    ]
    lines += [
        f"| [{item.id}]({_stem(item)}.md) | {item.source}: {item.states} | {verdicts[item.id].value} |"
        for item in items
    ]
    return "\n".join(lines) + "\n"
