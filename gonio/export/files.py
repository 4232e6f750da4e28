"""Exports as files: which there are, what they are called, and how they are written."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from gonio.export import materialx
from gonio.export.coded import Request, Tables
from gonio.export.lit import export_lit
from gonio.export.manifest import loader, manifest, manifest_text
from gonio.export.targets import TARGETS
from gonio.export.text import FUNCTIONS, SHARED, export
from gonio.export.tree import ExportError
from gonio.files import replacing
from gonio.images import png_of_codes
from gonio.lights.catalogue import usual
from gonio.materials import Material
from gonio.model import Model


@dataclass(frozen=True)
class Texts:
    """Texts, and the tables that they look up."""

    files: dict[str, str | bytes]
    """By file name; bytes are what a text reads from a buffer."""
    tables: dict[str, Tables]
    """By the name of the texts that look them up, without its extension."""

    def pictures(self) -> dict[str, bytes]:
        """Files of the tables of F and D, for texts that look them up in textures."""
        pictures = {name: t for its in self.tables.values() for name, t in its.files().items()}
        return {name: png_of_codes(table.codes) for name, table in pictures.items()}

    def notes(self) -> list[str]:
        """What the tables cost, and of what there are none."""
        found = []
        for its in self.tables.values():
            found += [line for table in its.all for line in table.said()]
            if its.left:
                found.append(f"no table for {', '.join(its.left)}, whose index varies.")
        return found


def texts(
    models: Mapping[str, Model], to: Sequence[str], *, together: bool = True
) -> dict[str, str | bytes]:
    """Source texts by file name: all models in one text per language, or a text for each of them."""
    return exports(models, to, together=together).files


def exports(
    models: Mapping[str, Model],
    to: Sequence[str],
    *,
    together: bool = True,
    only: Sequence[str] = FUNCTIONS,
    prefix: str | None = None,
    embed: bool = False,
    load: bool = False,
    lit: Sequence[str] | None = None,
    tables: Request | None = None,
    lookups: str = "textures",
) -> Texts:
    """The same with everything that `gonio export` can be asked for.

    What a text reads from a buffer is a file of bytes beside it (see `gonio.export.buffer`).

    `load` adds the function that fills the parameters from a buffer (see `gonio.export.manifest.loader`).
    With `lit`, names of lights, a text is a whole material function (see `gonio.export.lit`); with none of
    them, it has the usual ones. With `tables`, F and D are looked up (see `gonio.export.tabled`).
    """
    files: dict[str, str | bytes] = {}
    looked_up: dict[str, Tables] = {}
    if tables is not None and materialx.NAME in to:
        raise ExportError(
            "a MaterialX document has no tables of F and D; leave out --table, or name another language."
        )
    if lit is not None and materialx.NAME in to:
        raise ExportError(
            "a MaterialX document is lit by its renderer; leave out --lit, or name another language."
        )
    if materialx.NAME in to and (tuple(only) != FUNCTIONS or prefix or embed or load):
        raise ExportError(
            "a MaterialX node is always the same functions, under the model's name; leave out --only, "
            "--embed, --load and --prefix."
        )
    if lit is not None and together and len(models) > 1:
        raise ExportError("--lit makes a text of one model; export one at a time, or give --all.")
    groups = [dict(models)] if together else [{name: model} for name, model in models.items()]
    for group in groups:
        stem = next(iter(group)) if len(group) == 1 else prefix or SHARED
        for language in to:
            if language == materialx.NAME:
                files |= materialx.files(group)
                continue
            if lit is not None:
                ((name, model),) = group.items()
                made = [
                    export_lit(
                        model,
                        name,
                        lit or usual(model),
                        language,
                        only=only,
                        prefix=prefix,
                        embed=embed,
                        tables=tables,
                        lookups=lookups,
                    )
                ]
            else:
                made = export(
                    group,
                    language,
                    only=only,
                    prefix=prefix,
                    embed=embed,
                    tables=tables,
                    lookups=lookups,
                )
            loaders = [loader(one) for one in made] if load else []
            if (its := made[0].tables) is not None:
                looked_up[stem] = its
            text = "\n".join([made[0].source, *loaders])
            files[f"{stem}.{TARGETS[language].extension}"] = text
            if made[0].buffer is not None:
                files[made[0].buffer.file] = made[0].buffer.content()
    return Texts(files, looked_up)


def manifests(
    found: Mapping[str, Model | Material],
    *,
    together: bool = True,
    only: Sequence[str] = FUNCTIONS,
    prefix: str | None = None,
    lit: Sequence[str] | None = None,
    tables: Request | None = None,
) -> dict[str, str]:
    """What hosts have to know about the same exports, as JSON by file name."""
    shared = prefix or (SHARED if together and len(found) > 1 else None)
    atlas = None
    if tables is not None and together and len(found) > 1 and lit is None:
        models = {n: w.model if isinstance(w, Material) else w for n, w in found.items()}
        atlas = export(models, "wgsl", only=only, tables=tables)[0].tables
    return {
        f"{name}.json": manifest_text(
            manifest(what, name, only=only, prefix=shared, lit=lit, tables=tables, atlas=atlas)
        )
        for name, what in found.items()
    }


def write(files: Mapping[str, str | bytes], output: str | None) -> list[Path]:
    """Write texts to a file, or under their own names to a folder ("shaders/", made if need be).

    Bytes keep their own names, beside the text that reads them.

    Raises:
        ExportError: several texts for one file, bytes that another text in the folder reads, or a text of
            several models whose usual name another one of other models has.
        FileNotFoundError: the file's folder does not exist.
    """
    if output is None:
        raise ExportError(f"{len(files)} files; give a folder for them: -o FOLDER/")
    if not output:
        raise ExportError("the output has no name; give -o FILE or -o FOLDER/.")
    folder = output.endswith("/") or Path(output).is_dir()
    if not folder and sum(isinstance(content, str) for content in files.values()) > 1:
        raise ExportError(f"{len(files)} files for one name, {output}; give a folder.")
    root = Path(output)
    if folder:
        if root.is_file():
            raise ExportError(f"{root} is a file, no folder; give another name.")
        root.mkdir(parents=True, exist_ok=True)
    inside = root if folder else root.parent
    placed = {
        inside / name if folder or isinstance(content, bytes) else root: content
        for name, content in files.items()
    }
    _check_readers(placed)
    if folder:
        _check_shared(placed)
    for path, content in placed.items():
        with replacing(path) as temporary:
            if isinstance(content, bytes):
                temporary.write_bytes(content)
            else:
                temporary.write_text(content, encoding="utf-8")
    return list(placed)


# The functions of a model, and in languages with methods its struct.
ENTRIES = re.compile(
    r"\b(\w+)_(?:eval|sample|pdf|albedo)\(|^struct (\w+) : I\w+Brdf\b", re.MULTILINE
)


def _check_shared(placed: Mapping[Path, str | bytes]) -> None:
    """Refuse to lose models: texts of several, without a name of their own, are all called the same.

    Raises:
        ExportError: which models of an older text are not in the new one.
    """
    for path, content in placed.items():
        if path.stem != SHARED or not isinstance(content, str) or not path.is_file():
            continue
        older = _models_of(path.read_text(encoding="utf-8", errors="replace"))
        if lost := sorted(older - _models_of(content)):
            raise ExportError(
                f"{path} holds {', '.join(lost)}, which this export would lose; export all models "
                "together, or give another folder, or --prefix NAME for a name of its own, or remove "
                f"{path.name}."
            )


def _models_of(text: str) -> set[str]:
    """What the models of a text are called, without those inside others."""
    names = {function or struct for function, struct in ENTRIES.findall(text)}
    return {n for n in names if not any(n.startswith(f"{other}_") for other in names)}


# What gonio writes that says which tables it reads.
READERS = frozenset(f".{target.extension}" for target in TARGETS.values()) | {".json"}


def _check_readers(placed: Mapping[Path, str | bytes]) -> None:
    """Refuse to put other tables in the place of those that an older text in the folder reads.

    Raises:
        ExportError: which text that is.
    """
    for path, content in placed.items():
        if not isinstance(content, bytes) or not path.is_file() or path.read_bytes() == content:
            continue
        named = re.compile(rf"(?<!\w){re.escape(path.name)}")
        for other in sorted(path.parent.iterdir()):
            if other.suffix not in READERS or other in placed or not other.is_file():
                continue
            if named.search(other.read_text(encoding="utf-8", errors="replace")):
                raise ExportError(
                    f"{other} reads {path.name}, which this export would replace by other tables; give "
                    f"another folder, or --prefix NAME for a name of their own, or remove {other.name}."
                )
