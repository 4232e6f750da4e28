"""The interactive viewer: `gonio view`, pages that are one file, and a widget for notebooks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gonio.view.widget import Viewer

__all__ = ["Viewer"]


def __getattr__(name: str) -> Any:
    """The widget, which needs a package that nothing else here needs."""
    if name != "Viewer":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        from gonio.view.widget import Viewer
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("anywidget", "traitlets"):
            raise
        raise ModuleNotFoundError(
            "gonio.view.Viewer needs anywidget: pip install 'gonio[notebook]'.", name=error.name
        ) from None
    return Viewer
