"""`gonio.view.Viewer`: the viewer in a notebook's cell, with values in both directions.

    viewer = gonio.view.Viewer("eon:roughness=0.8")
    viewer                      # the last line of a cell shows it
    viewer.a                    # what the sliders say now, as text
    viewer.model                # the same as a model
    viewer.a = "gold"           # and back

Needs the extra: pip install 'gonio[notebook]'.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import anywidget
import traitlets

from gonio.export.tree import ExportError
from gonio.fields import ModelError
from gonio.foreign import ForeignError, is_foreign
from gonio.materials import Material
from gonio.materials.notation import split
from gonio.model import Model
from gonio.view import page
from gonio.view.server import Refused, code

# What a cell has room for.
HEIGHT = 720


class Viewer(anywidget.AnyWidget):  # type: ignore[misc]
    """The viewer of one model, or of two that are compared.

    Args:
        a: a model, a material, or text as on the command line; files are read.
        b: the model to compare with, or nothing.
        height: of the cell in pixels.
        settings: of the page, as in its links: "env=sun&ev=0.5".
    """

    _esm = traitlets.Unicode(page.file()).tag(sync=True)
    a = traitlets.Unicode().tag(sync=True)
    b = traitlets.Unicode().tag(sync=True)
    link = traitlets.Unicode().tag(sync=True)
    settings = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(HEIGHT).tag(sync=True)

    def __init__(
        self,
        a: str | Model | Material = "eon",
        b: str | Model | Material = "",
        *,
        height: int = HEIGHT,
        settings: str = "",
    ) -> None:
        """Show a model; errors as `gonio.load` has them."""
        texts = [_text(a), _text(b) if b else ""]
        named = [split(text)[0] for text in texts]
        files = [name for name in named if name.endswith((".py", ".toml")) or is_foreign(name)]
        self.names = page.Names(files)
        for text in filter(None, texts):
            self.names.find(text)
        super().__init__(a=texts[0], b=texts[1], height=height, settings=settings)
        self.on_msg(self._answer)

    @property
    def model(self) -> Model | Material:
        """What A shows, with the sliders' values."""
        return self.names.find(self.a)

    def _answer(self, _: Any, message: Mapping[str, Any], buffers: Any) -> None:
        """A question of the page."""
        identity = message.get("id")
        try:
            answer = self._find(message.get("question"), message.get("body") or {})
        except (ModelError, ExportError, ForeignError, OSError, Refused) as error:
            self.send({"id": identity, "error": str(error).partition("\n")[0]})
        else:
            self.send({"id": identity, "answer": answer})

    def _find(self, question: Any, body: Mapping[str, Any]) -> Any:
        text = str(body.get("text", ""))
        if question == "start":
            return page.start(self.names, [t for t in (self.a, self.b) if t])
        if question == "file" and text in page.FILES:
            return {"text": page.file(text)}
        if question == "model":
            return page.payload(self.names, text)
        if question == "options":
            return page.choices(self.names, text)
        if question == "albedo":
            return {"albedo": page.albedo(self.names, text, body.get("wo"))}
        if question == "code":
            return {"text": code(self.names, text, str(body.get("language", "")))}
        raise ModelError(f"no question {question!r}.")


def _text(what: str | Model | Material) -> str:
    """A model as text; a material by its name and what was changed in it."""
    from gonio.materials.notation import model_text

    if isinstance(what, str):
        return what
    if isinstance(what, Model):
        return model_text(what)
    values = (
        f"{path}={'/'.join(f'{v:.9g}' for v in value) if isinstance(value, tuple) else value}"
        for path, value in what.changed.items()
    )
    return what.name + ":" * bool(what.changed) + ",".join(values)
