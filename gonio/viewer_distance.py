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

NAME = "gonio_viewer_distance"

_registered: dict[str, Any] = {}


def register() -> None:
    """Make the texture known to Mitsuba's current variant, once."""
    import mitsuba as mi

    variant = mi.variant()
    if variant is not None and variant not in _registered:
        _registered[variant] = _derive(getattr(mi, variant))
        mi.register_texture(NAME, _registered[variant])


def _derive(types: Any) -> Any:
    import mitsuba as mi

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
