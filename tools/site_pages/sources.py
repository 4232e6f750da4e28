"""The folder of sources that Sphinx reads: only what has changed is written, what is gone is removed."""

from __future__ import annotations

import shutil
from pathlib import Path


class Sources:
    """A folder that holds exactly what was put into it since this object was made."""

    def __init__(self, folder: Path) -> None:
        """The folder is made if need be."""
        self.folder = folder
        self.put: set[Path] = set()
        folder.mkdir(parents=True, exist_ok=True)

    def write(self, name: str, text: str) -> None:
        """A text file, untouched if it is there already, so that Sphinx need not read it again."""
        path = self._path(name)
        content = text.encode()
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)

    def copy(self, source: Path, name: str) -> None:
        """A file as it is; one with the same content keeps its date."""
        path = self._path(name)
        if not path.is_file() or path.read_bytes() != source.read_bytes():
            shutil.copyfile(source, path)

    def clean(self) -> None:
        """Remove what was not put here this time."""
        for path in sorted(self.folder.rglob("*"), reverse=True):
            if path.is_dir():
                if not any(path.iterdir()):
                    path.rmdir()
            elif path not in self.put:
                path.unlink()

    def _path(self, name: str) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        self.put.add(path)
        return path
