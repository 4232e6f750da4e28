"""A run folder: the results of tasks as files, each whole or not there, checked when they are read."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from gonio.files import check_place, replacing
from gonio.messages import notice

# What says that a folder is one of these, and that it may be filled and emptied.
MARKER = "gonio-run.txt"
TEXT = (
    "Results of a run of gonio. Starting the same command again goes on from here.\n"
    "Each file is named by the digest of what it was computed from; any of them may be deleted.\n"
)

HEAD = b"gonio result 1 "
_NAME = re.compile(r"[0-9a-f]{64}")


class RunFolder:
    """Results by the keys of their tasks."""

    def __init__(self, path: str | Path) -> None:
        """Take a folder; it is made with its first result.

        Raises:
            OSError: there is something else at that place, or nothing can be written there.
        """
        self.path = Path(path)
        if self.path.exists() and not self.path.is_dir():
            raise OSError(f"{path} is a file; a run folder is a folder. Give another --run-dir.")
        if self.path.is_dir() and not self._is_ours():
            raise OSError(
                f"{path} is a folder with other things in it; give --run-dir a new or empty one."
            )
        if not self.path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {self.path.parent}; create it first.")
        check_place(self.path / MARKER if self.path.is_dir() else self.path)

    def _is_ours(self) -> bool:
        return (self.path / MARKER).is_file() or not any(
            entry for entry in self.path.iterdir() if not entry.name.startswith(".gonio-")
        )

    def _file(self, key: str) -> Path:
        # Folders of a million files are slow on some systems
        return self.path / key[:2] / key

    def has(self, key: str) -> bool:
        """Whether a result is there; `get` says whether it is whole."""
        return self._file(key).is_file()

    def get(self, key: str) -> bytes | None:
        """A result; None if there is none, or if it is damaged, which a `Notice` says."""
        path = self._file(key)
        try:
            content = path.read_bytes()
        except OSError:
            return None
        head, _, data = content.partition(b"\n")
        if head == HEAD + hashlib.sha256(data).hexdigest().encode():
            return data
        notice(f"{path} is damaged; its task is done again.")
        path.unlink(missing_ok=True)
        return None

    def put(self, key: str, data: bytes) -> None:
        """Keep a result.

        Raises:
            OSError: it cannot be written, as when the disk is full.
        """
        path = self._file(key)
        for again in (True, False):
            path.parent.mkdir(parents=True, exist_ok=True)
            try:
                if not (self.path / MARKER).is_file():
                    with replacing(self.path / MARKER) as temporary:
                        temporary.write_text(TEXT, encoding="utf-8")
                with replacing(path) as temporary:
                    temporary.write_bytes(
                        HEAD + hashlib.sha256(data).hexdigest().encode() + b"\n" + data
                    )
                return
            except FileNotFoundError:
                # Another client has finished, and removed the folder, in this moment
                if not again:
                    raise

    def remove(self) -> None:
        """Remove all results, and the folder if nothing else is in it."""
        for folder in self.path.glob("[0-9a-f][0-9a-f]"):
            for path in folder.iterdir():
                if _NAME.fullmatch(path.name) or path.name.startswith(".gonio-"):
                    path.unlink(missing_ok=True)
            _remove_empty(folder)
        for path in (self.path / MARKER, *self.path.glob(".gonio-*")):
            path.unlink(missing_ok=True)
        _remove_empty(self.path)


def _remove_empty(folder: Path) -> None:
    try:
        folder.rmdir()
    except OSError:  # somebody has put something there
        return
