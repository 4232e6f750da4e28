"""Values that are no numbers: a finding names them, and gives no advice that fits numbers only."""

from __future__ import annotations

from typing import Any

import numpy as np


def said(*named: tuple[str, Any]) -> str:
    """Which of the values are NaN or infinite, each with its name; "" if none is."""
    words = []
    for name, values in named:
        found = np.asarray(values, np.float64)
        if np.isnan(found).any():
            words.append(f"{name} is NaN")
        elif not np.isfinite(found).all():
            words.append(f"{name} is infinite")
    return " and ".join(words)
