"""Ctrl-C that ends a command soon, also while it computes in a library that does not look for it."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

GRACE = 1.0  # seconds that a command has to end by itself, which it does between two passes

CODE = 128 + 2  # of a program that SIGINT ends


@contextmanager
def prompt_interrupt(tidy: Callable[[], None]) -> Iterator[None]:
    """Within it, Ctrl-C ends the process after GRACE seconds, if KeyboardInterrupt has not by then.

    Python raises KeyboardInterrupt only between its own steps, and one step may render for a minute. The
    signal wakes a thread at once, though.

    Args:
        tidy: called before the process ends, to remove what is half written.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals belong to the main thread
        return
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    left = threading.Event()

    def watch() -> None:
        while signals := reader.recv(64):
            if signal.SIGINT in signals and not left.wait(GRACE):
                tidy()
                sys.stderr.write("\ngonio: interrupted\n")
                sys.stderr.flush()
                os._exit(CODE)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    before = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    try:
        yield
    finally:
        left.set()
        signal.set_wakeup_fd(before)
        writer.close()  # ends the thread
        thread.join()
        reader.close()
