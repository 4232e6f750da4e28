"""Maps of roughness and colour are found from pictures by gradients."""

from __future__ import annotations

import importlib.util
from pathlib import Path

EXAMPLE = Path(__file__).parent.parent / "examples" / "maps_from_pictures.py"


def test_maps_are_found_from_pictures() -> None:
    spec = importlib.util.spec_from_file_location("maps_from_pictures", EXAMPLE)
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    start = example.made_up()
    errors = example.main(steps=25)
    # Nearer to the truth than the grey start by this factor, for each map
    for name, error in errors.items():
        assert error < 0.35 * abs(start[name] - 0.5).mean(), name
