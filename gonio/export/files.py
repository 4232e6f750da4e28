"""Exports as files: which there are, what they are called, and how they are written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from gonio.export import materialx
from gonio.export.targets import TARGETS
from gonio.export.text import FUNCTIONS, SHARED, export
from gonio.export.tree import ExportError
from gonio.files import replacing
from gonio.model import Model


def texts(
    models: Mapping[str, Model],
    to: Sequence[str],
    *,
    together: bool = True,
    only: Sequence[str] = FUNCTIONS,
    prefix: str | None = None,
    embed: bool = False,
) -> dict[str, str]:
    """Source texts by file name: all models in one text per language, or a text for each of them."""
    files: dict[str, str] = {}
    if materialx.NAME in to and (tuple(only) != FUNCTIONS or prefix or embed):
        raise ExportError(
            "a MaterialX node is always the same functions, under the model's name; leave out --only, "
            "--embed and --prefix."
        )
    groups = [dict(models)] if together else [{name: model} for name, model in models.items()]
    for group in groups:
        stem = next(iter(group)) if len(group) == 1 else prefix or SHARED
        for language in to:
            if language == materialx.NAME:
                files |= materialx.files(group)
                continue
            made = export(group, language, only=only, prefix=prefix, embed=embed)
            files[f"{stem}.{TARGETS[language].extension}"] = made[0].source
    return files


def write(files: Mapping[str, str], output: str | None) -> list[Path]:
    """Write texts to a file, or under their own names to a folder ("shaders/", made if need be).

    Raises:
        ExportError: several texts for one file.
        FileNotFoundError: the file's folder does not exist.
    """
    if output is None:
        raise ExportError(f"{len(files)} files; give a folder for them: -o FOLDER/")
    folder = output.endswith("/") or Path(output).is_dir()
    if not folder and len(files) > 1:
        raise ExportError(f"{len(files)} files for one name, {output}; give a folder.")
    root = Path(output)
    if folder:
        root.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, text in files.items():
        path = root / name if folder else root
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        paths.append(path)
    return paths
