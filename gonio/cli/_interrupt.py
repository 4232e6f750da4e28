"""Ctrl-C or SIGTERM that ends a command soon, also while it computes in a library that heeds neither."""

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
    signal wakes a thread at once, though. SIGTERM, which batch systems and `timeout` send when time is up,
    is as Ctrl-C, unless the process handles it in another way.

    Args:
        tidy: called before the process ends, to remove what is half written.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # signals belong to the main thread
        return
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    left = threading.Event()
    ending = [signal.SIGINT]
    if signal.getsignal(signal.SIGTERM) == signal.SIG_DFL:
        ending.append(signal.SIGTERM)
        signal.signal(signal.SIGTERM, signal.default_int_handler)

    def watch() -> None:
        while signals := reader.recv(64):
            if any(s in signals for s in ending) and not left.wait(GRACE):
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
        if signal.SIGTERM in ending:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
        signal.set_wakeup_fd(before)
        writer.close()  # ends the thread
        thread.join()
        reader.close()
