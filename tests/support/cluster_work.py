"""Work for tests of gonio.cluster, where workers can import it."""

from __future__ import annotations

import time
import uuid
from pathlib import Path
from typing import Any

from gonio.messages import notice


def square(x: float, log: str = "", seconds: float = 0.0) -> float:
    """Its square; leaves a file in the folder `log` each time it is computed."""
    if log:
        (Path(log) / f"{x:g}-{uuid.uuid4().hex}").touch()
    time.sleep(seconds)
    return x * x


def unlucky(x: float, bad: float) -> float:
    """Its square, but for one number."""
    if x == bad:
        raise ValueError(f"{x:g} brings no luck.")
    notice("numbers may be odd.")
    return x * x


def text_of(file: Path) -> str:
    """What is in a file, and how it is called."""
    return f"{file.name}: {file.read_text(encoding='utf-8')}"


def same(value: Any) -> Any:
    """What came."""
    return value
