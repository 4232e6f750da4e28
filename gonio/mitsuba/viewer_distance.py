"""How far away a point is seen from, as a Mitsuba texture: `gonio_viewer_distance`.

    {"type": "gonio_car_paint", "distance": {"type": "gonio_viewer_distance", "unit": 10}}

The value is the length of the ray that found the point, over `unit`. For what the camera sees directly
that is the viewer's distance; for what is seen in a mirror it is the distance from the mirror.
`import gonio.mitsuba` registers it.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: distance =
length(eye - fragment).
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

NAME = "gonio_viewer_distance"


def derive() -> Any:
    """The plug-in's class for Mitsuba's current variant."""
    types: Any = getattr(mi, mi.variant())

    class ViewerDistance(types.Texture):  # type: ignore[misc]
        """The ray's length over a unit."""

        def __init__(self, properties: Any) -> None:
            super().__init__(properties)
            self.unit = types.Float(properties.get("unit", 1.0))
            if not float(properties.get("unit", 1.0)) > 0:
                raise ValueError(
                    f"{NAME}: unit={properties['unit']} is out of range; allowed is above 0."
                )

        def eval_1(self, si: Any, active: Any = True) -> Any:
            return si.t / self.unit

        def eval(self, si: Any, active: Any = True) -> Any:
            return types.UnpolarizedSpectrum(self.eval_1(si, active))

        def is_spatially_varying(self) -> bool:
            return True

        def traverse(self, callback: Any) -> None:
            callback.put("unit", self.unit, mi.ParamFlags.Differentiable)

        def to_string(self) -> str:
            return f"{NAME}[unit = {self.unit}]"

    return ViewerDistance
