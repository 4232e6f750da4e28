"""A task: a function of gonio's with its inputs, known by their content; and doing it."""

from __future__ import annotations

import hashlib
import importlib
import time
import traceback
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gonio.cluster.codec import Place, decode, encode
from gonio.cluster.identity import Identity
from gonio.messages import Notice


@dataclass(frozen=True)
class Task:
    """A piece of work that can be done anywhere, at any time, with the same result."""

    work: str
    """The function, "gonio.cluster.sweep:rows"; it takes the inputs by name."""
    title: str
    """Its inputs in words, for errors; changes nothing."""
    data: bytes
    """The inputs."""
    files: Mapping[str, Path] = field(default_factory=dict)
    """Files that the inputs name, by digest."""

    @staticmethod
    def of(work: str, title: str, **inputs: Any) -> Task:
        """Make a task.

        Raises:
            NotPortableError: an input that exists on this machine only.
        """
        data, files = encode(inputs)
        return Task(work, title, data, files)

    def key(self, where: Identity) -> str:
        """A digest of the inputs and of all else that decides the result."""
        found = hashlib.sha256()
        for part in (self.work.encode(), self.data, where.text().encode()):
            found.update(len(part).to_bytes(8, "big") + part)
        return found.hexdigest()


@dataclass(frozen=True)
class Done:
    """What a task has come to."""

    value: Any
    notes: tuple[str, ...] = ()
    """What the user should know though it worked."""
    seconds: float = 0.0


@dataclass(frozen=True)
class Failure:
    """Why a task has no result."""

    title: str
    reason: str
    """One line."""
    trace: str = ""
    """The traceback, if there is one."""


def do(work: str, title: str, data: bytes, place: Place | None) -> bytes | Failure:
    """Do a task here; its `Done` as bytes, or why there is none."""
    begin = time.perf_counter()
    module, _, name = work.partition(":")
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", Notice)
            value = getattr(importlib.import_module(module), name)(**decode(data, place))
        notes = dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, Notice))
        return encode(Done(value, tuple(notes), time.perf_counter() - begin))[0]
    except (Exception, SystemExit) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if not isinstance(error, (ValueError, OSError)):
            reason = f"{type(error).__name__}: {reason}"
        return Failure(title, reason, traceback.format_exc())
