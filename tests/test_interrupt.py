"""Ctrl-C, SIGTERM, full disks and read-only places: soon, in one sentence, with nothing left behind."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

from gonio.files import replacing

# A command in the midst of a file and of one step of a library, which does not end: a lock that is taken
# twice. Python would raise KeyboardInterrupt only after that step.
STUCK = """
import ctypes, sys, threading
from gonio.cli._interrupt import prompt_interrupt
from gonio.files import remove_unfinished, replacing
with prompt_interrupt(remove_unfinished), replacing(sys.argv[1]) as temporary:
    temporary.write_text("half")
    lock, lock_it = ctypes.create_string_buffer(256), ctypes.CDLL(None).pthread_mutex_lock
    lock_it(lock)
    # Said when the main thread has long been in the lock, where Python's own handler cannot run.
    threading.Timer(1.0, print, ("ready",), {"flush": True}).start()
    lock_it(lock)
"""

# One that notices by itself, and tidies up in its own way.
NOTICING = """
import sys, time
from gonio.cli._interrupt import prompt_interrupt
from gonio.files import remove_unfinished, replacing
try:
    with prompt_interrupt(remove_unfinished), replacing(sys.argv[1]) as temporary:
        print("ready", flush=True)
        time.sleep(60)
except KeyboardInterrupt:
    sys.exit("by itself")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="the lock is POSIX's")
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    ("program", "code", "said"),
    [(STUCK, 130, "gonio: interrupted"), (NOTICING, 1, "by itself")],
    ids=["stuck", "noticing"],
)
def test_an_interrupted_command_ends_and_leaves_nothing(
    tmp_path: Path, program: str, code: int, said: str, by: signal.Signals
) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(tmp_path / "a.png")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "ready"
    process.send_signal(by)
    try:
        _, error = process.communicate(timeout=30)
    finally:
        process.kill()
    assert (process.returncode, error.strip()) == (code, said)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="the lock is POSIX's")
def test_a_python_program_is_interrupted_while_a_picture_is_rendered() -> None:
    """The numbers of a picture that take their time: Python is interrupted before they are there."""
    program = """
import ctypes, threading
from gonio.render.passes import _numbers

class Late:
    def __array__(self, *_, **__):
        lock, libc = ctypes.create_string_buffer(256), ctypes.CDLL(None)

        def unlock():
            print("there", flush=True)
            libc.pthread_mutex_unlock(lock)

        libc.pthread_mutex_lock(lock)
        threading.Timer(0.5, print, ("ready",), {"flush": True}).start()
        threading.Timer(2.5, unlock).start()
        libc.pthread_mutex_lock(lock)
        raise ValueError

try:
    _numbers(Late())
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline().strip() == "ready"
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline().strip() == "interrupted"
        assert process.wait(60) == 0


def test_a_full_disk_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "a.png"
    target.write_text("old")
    with pytest.raises(OSError, match=r"the disk is full; make room") as caught:  # noqa: SIM117
        with replacing(target):
            raise OSError(errno.ENOSPC, "No space left on device")
    assert caught.value.filename == str(target)
    # A writer outside of Python says so in its own way.
    full = shutil._ntuple_diskusage(1 << 30, 1 << 30, 0)  # type: ignore[attr-defined]
    with monkeypatch.context() as patch:
        patch.setattr(shutil, "disk_usage", lambda path: full)
        with pytest.raises(OSError, match="the disk is full"), replacing(target):
            raise RuntimeError("write failed")
    with pytest.raises(RuntimeError, match="write failed"), replacing(target):  # there is room
        raise RuntimeError("write failed")
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]
    assert target.read_text() == "old"


@pytest.mark.parametrize(
    ("code", "said"),
    [(errno.EROFS, "the place is read-only"), (errno.EACCES, "writing is not permitted there")],
)
def test_a_place_that_cannot_be_written_to_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int, said: str
) -> None:
    def refuse(**_: Any) -> None:
        raise OSError(code, os.strerror(code), "/somewhere/.gonio-123.png")

    monkeypatch.setattr(tempfile, "mkstemp", refuse)
    with pytest.raises(OSError, match=said) as caught, replacing(tmp_path / "a.png"):
        pass
    assert caught.value.filename == str(tmp_path / "a.png")


def test_what_is_no_file_is_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="it is a folder"), replacing(tmp_path):
        pass
    if os.path.exists("/dev/null"):
        with pytest.raises(OSError, match="not an ordinary file"), replacing("/dev/null"):
            pass
