"""Writing files so that nothing half-written stays behind, and seeing that they have changed."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

# What the system says when a place cannot be written to, in words that say what to do.
REFUSALS = {
    errno.ENOSPC: "the disk is full; make room, or choose another place",
    errno.EDQUOT: "your share of the disk is used up; make room, or choose another place",
    errno.EROFS: "the place is read-only; choose another one",
    errno.EACCES: "writing is not permitted there; choose another place",
    errno.EPERM: "writing is not permitted there; choose another place",
    errno.ENAMETOOLONG: "its name is too long",
}
LITTLE = 1 << 16  # bytes; where less is free, a failed write is the disk's fault


def _refused(path: Path, error: OSError) -> OSError:
    reason = REFUSALS.get(error.errno or 0, error.strerror or str(error))
    return OSError(error.errno, f"cannot be written: {reason}", str(path))


_unfinished: set[Path] = set()


def remove_unfinished() -> None:
    """Remove the files that `replacing` is at work on; for a process that is about to end in its midst."""
    for temporary in list(_unfinished):
        temporary.unlink(missing_ok=True)
        _unfinished.discard(temporary)


def check_place(path: str | Path) -> Path:
    """The path, when a file can be written there; before long work, of which nothing would be left.

    Raises:
        OSError: as `replacing`.
    """
    _temporary(Path(path).resolve()).unlink()
    return Path(path)


def _temporary(path: Path) -> Path:
    """An empty file beside the path, which may take its name."""
    if path.parent.exists() and not path.parent.is_dir():
        raise NotADirectoryError(f"{path.parent} is a file; {path.name} cannot be written into it.")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {path.parent}; create it first.")
    if path.exists() and not path.is_file():
        kind = "a folder" if path.is_dir() else "not an ordinary file"
        raise OSError(errno.EEXIST, f"cannot be written: it is {kind}", str(path))
    try:
        handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=".gonio-", dir=path.parent)
    except OSError as error:
        raise _refused(path, error) from error
    os.close(handle)
    return Path(name)


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; it takes the name `path` when the block succeeds.

    The temporary file keeps the suffix, by which writers choose the format. When the block fails or is
    interrupted, it is removed and an older file under `path` stays as it was.

    Raises:
        FileNotFoundError: the folder does not exist.
        OSError: something other than a file has that name, the place is read-only, or the disk is full.
    """
    path = Path(path).resolve()  # a link stays a link to the file that is replaced
    temporary = _temporary(path)
    _unfinished.add(temporary)
    try:
        try:
            yield temporary
        except OSError as error:
            if error.errno in REFUSALS:
                raise _refused(path, error) from error
            raise
        except Exception as error:
            # Writers outside of Python have errors of their own for a full disk.
            if shutil.disk_usage(path.parent).free < LITTLE:
                raise _refused(path, OSError(errno.ENOSPC, "")) from error
            raise
        # mkstemp makes files that only the owner can read; pictures are for everybody the umask allows.
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
        _unfinished.discard(temporary)


def is_utf8(path: Path) -> bool:
    """Whether libraries that want names in UTF-8 can open a file."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return False
    return True


Stamps = dict[Path, tuple[int, int] | None]


def stamps(paths: Iterable[Path]) -> Stamps:
    """When files changed last, in ns, and their sizes in bytes; None while an editor has one removed."""
    found: Stamps = {}
    for path in paths:
        try:
            stat = path.stat()
        except OSError:
            found[path] = None
        else:
            found[path] = stat.st_mtime_ns, stat.st_size
    return found
