"""What the page knows of a model: its shaders, its manifest, its maps, its text; and the page itself."""

from __future__ import annotations

import base64
import functools
import gzip
import html
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.description.about import describe, summary
from gonio.export.buffer import WIDTH, Buffer
from gonio.export.manifest import loader, manifest, options, unused
from gonio.export.text import export
from gonio.fields import ModelError
from gonio.foreign import is_foreign
from gonio.foreign import load as load_code
from gonio.foreign.model import ForeignModel
from gonio.materials import Material, library, load, load_material, toml_file
from gonio.materials.model_file import is_model_file
from gonio.materials.notation import assign, split
from gonio.materials.texture_file import stored_values, texture_values
from gonio.mitsuba.textures import flake_map
from gonio.model import Model, models
from gonio.parts.dielectrics import INDICES
from gonio.parts.metals import metal, metals
from gonio.version import __version__
from gonio.view import foreign_code
from gonio.view.scene import environments, fade, packed, shapes

WEB = Path(__file__).parent / "web"

# The script that a page begins with, and what it loads: its styles at once, the others when wanted.
SCRIPT = "viewer.js"
FILES = {
    SCRIPT: "text/javascript",
    "viewer.css": "text/css",
    "more.js": "text/javascript",
    "webgl2.js": "text/javascript",
    "files.js": "text/javascript",
}

# Of what the page's two graphics interfaces understand.
SHADERS = ("wgsl", "essl")

# The name that the page's passes call a model by.
NAME = "model"

# Coats that a text may nest: more would only make shaders that no driver finishes.
DEPTH_MAX = 6

TEXT_MAX = 4096  # characters of a model's text

MAP_SIZE_MAX = 512  # pixels a side


class UnknownModelError(ModelError):
    """A text that names nothing that the page may show."""


class Names:
    """What a page may show: gonio's models and materials, and files that its user named."""

    def __init__(
        self,
        files: Iterable[str] = (),
        read: foreign_code.Loader = load_code,
        defines: Sequence[str] = (),
    ) -> None:
        """Files by the names that the page calls them by; others are never opened.

        Args:
            files: models, materials, and functions of code as FILE#FUNCTION.
            read: how such a function is read.
            defines: macros that it was read with, NAME or NAME=VALUE.
        """
        self.files = tuple(files)
        self.code = foreign_code.Code(read, defines)

    def start(self, text: str) -> Model | Material:
        """The model or material in front of a text's colon."""
        name, _ = split(text)
        if name not in self.files:
            return self._known(name)
        return self.code.model(name) if is_foreign(name) else load(name)

    def paths(self, name: str) -> tuple[Path, ...]:
        """What the page shows again when it changes."""
        return self.code.files(name) if is_foreign(name) else (Path(name),)

    def _known(self, name: str) -> Model | Material:
        """What comes with gonio: a name of anything else never opens a file, nor runs one."""
        if name not in models() and name not in library():
            is_file = is_model_file(name) or name.endswith(".toml") or is_foreign(name)
            if is_file or "/" in name or "\\" in name:
                raise UnknownModelError(
                    f"{name} was not named when 'gonio view' was started; start it with that file."
                )
            raise toml_file.unknown(name, library())
        return load(name)

    def find(self, text: str) -> Model | Material:
        """A model or material with its changes, such as "eon:roughness=1".

        Raises:
            ModelError: too long or too deep, an unknown name, or a value out of range.
        """
        if len(text) > TEXT_MAX:
            raise ModelError(f"the text of a model has at most {TEXT_MAX} characters.")
        name, pieces = split(text)
        if any(piece.partition("=")[0].count(".") > DEPTH_MAX for piece in pieces):
            raise ModelError(f"models can lie {DEPTH_MAX} deep here.")
        return assign(self.start(name), pieces, self._known)


def payload(names: Names, text: str, *, reasons: bool = False) -> dict[str, Any]:
    """All that the page needs to show a model.

    Args:
        names: what may be shown.
        text: the model.
        reasons: also why parameters are unused, which `choices` tells later.

    Raises:
        ModelError, ExportError: what cannot be shown; the message is for the page.
    """
    return payload_of(names, text, names.find(text), reasons=reasons)


def choices(names: Names, text: str) -> dict[str, Any]:
    """What takes the exporter a moment: options with what is refused and why, and unused parameters."""
    what = names.find(text)
    model = what.model if isinstance(what, Material) else what
    return {"options": list(options(model)), "unused": unused(model)}


def payload_of(
    names: Names, text: str, what: Model | Material, *, reasons: bool = True
) -> dict[str, Any]:
    """The same for what a text means."""
    if isinstance(what, ForeignModel):
        return foreign_code.payload(text, split(text)[0], what, names.code.defines)
    model = what.model if isinstance(what, Material) else what
    reasons = reasons or not list(options(model, refusals=False))  # then they cost nothing
    made = {language: export({NAME: model}, language)[0] for language in SHADERS}
    about = manifest(what, NAME, refusals=False, reasons=reasons, made=made["wgsl"])
    start = names.start(text)
    return about | {
        "text": text,
        "name": split(text)[0],
        "plain": _is_plain(what),
        "code": {language: e.source for language, e in made.items()},
        "load": {language: loader(e) for language, e in made.items()},
        "members": [m.path for m in made["wgsl"].entry.members],
        "start": dict(_values(start.model if isinstance(start, Material) else start)),
        "hooks": _hooks(about, made),
        "maps": _maps(what) if isinstance(what, Material) else None,
        "tables": _tables(made["wgsl"].buffer),
        "sums": not describe(model.written)["closed_form"].get("albedo", True),
        "about": _about(model),
    }


def albedo(names: Names, text: str, wo: Any) -> list[float]:
    """The directional albedo that `gonio eval` has, for shaders that only sum over a few directions.

    Raises:
        ModelError: what cannot be shown, or no direction.
    """
    what = names.find(text)
    model = what.model if isinstance(what, Material) else what
    direction = np.array(wo if isinstance(wo, list) and len(wo) == 3 else [np.nan], np.float64)
    length = float(np.linalg.norm(direction))
    if not 0 < length < np.inf:
        raise ModelError("wo is no direction.")
    return [float(v) for v in np.ravel(model.albedo(direction / length))]


def _values(model: Model, prefix: str = "") -> Iterable[tuple[str, Any]]:
    for name in model.fields:
        value = getattr(model, name)
        if isinstance(value, Model):
            yield prefix + name, value.name
            yield from _values(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _is_plain(what: Model | Material) -> bool:
    """Whether the material has the same values everywhere."""
    return isinstance(what, Model) or not _varies(what)


def _varies(material: Material) -> bool:
    return bool(material.textures or material.flakes or material.grows or material.normal_map)


def _about(model: Model) -> list[dict[str, Any]]:
    """Source, claims and caveats of a model and of those inside it."""
    found = []
    seen = set()
    while True:
        if model.name not in seen:
            seen.add(model.name)
            about = describe(model.written)
            found.append(
                {
                    k: about[k]
                    for k in ("name", "title", "description", "source", "claims", "caveats")
                }
            )
        inner = [getattr(model, name) for name in model.fields]
        below = [value for value in inner if isinstance(value, Model)]
        if not below:
            return found
        model = below[0]


# --- maps ----------------------------------------------------------------------------------------------


def _hooks(about: Mapping[str, Any], made: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The manifest's hooks with the layer of the map and the member's name in each language."""
    widths = {p["path"]: p["width"] for p in about["parameters"]}
    hooks: list[dict[str, Any]] = []
    textures = 0
    for hook in about["hooks"]:
        source = hook["source"]
        row = {"path": hook["path"], "source": source, "layer": 0, "channel": 0}
        if source == "flakes":
            row |= {
                "channel": hook["channel"],
                "tiles": float(hook.get("tiles", toml_file.FLAKE_SETTINGS["tiles"].default)),
            }
        elif source in ("texture", "normal_map"):
            # Behind the flakes' layer, if there is one
            row["layer"] = textures + any(h["source"] == "flakes" for h in about["hooks"])
            row["scale"] = hook["scale"]
            textures += 1
        hooks.append(row)
        if source == "flakes" and hook["channel"] == 0 and hook.get("fade"):
            outer = hook["path"].rpartition("flake_x")[0]
            unit = float(hook["fade"])
            hooks.append({"path": f"{outer}distance", "source": "viewer", "unit": unit})
    read = {m.path for m in made["wgsl"].entry.members}
    found = [
        hook | {"width": widths.get(hook["path"], 3)}
        for hook in hooks
        if hook["path"] in read or hook["source"] == "normal_map"
    ]
    for hook in found:
        hook["members"] = {
            language: next((m.place for m in of.entry.members if m.path == hook["path"]), "")
            for language, of in made.items()
        }
    return found


def _maps(material: Material) -> dict[str, Any] | None:
    """Maps of one size, in layers: flakes first, then one for each texture."""
    layers: list[Any] = []
    widths = {path: declared.width for path, declared, _ in material.model.parameters()}
    if material.flakes:
        settings = {k: v for k, v in material.flakes.items() if k not in ("tiles", "fade")}
        layers.append(_flakes(tuple(sorted(settings.items()))))
    for path, picture in material.textures.items():
        values = texture_values(picture, material.channels.get(path), widths[path])
        layers.append(_square(values))
    if material.normal_map is not None:
        layers.append(_square(stored_values(material.normal_map)))
    if not layers:
        return None
    size, channels = max(len(layer) for layer in layers), max(layer.shape[-1] for layer in layers)
    stacked = np.zeros((len(layers), size, size, channels))
    for place, layer in zip(stacked, layers, strict=True):
        at = (np.arange(size) * len(layer)) // size
        place[..., : layer.shape[-1]] = layer[np.ix_(at, at)]
    return {
        "size": size,
        "layers": len(layers),
        "channels": channels,
        "half": packed(stacked, "<f2"),
    }


@functools.lru_cache(8)
def _flakes(settings: tuple[tuple[str, Any], ...]) -> Any:
    """A flake map: every choice of a material's options asks for the same one."""
    return flake_map(**dict(settings))


def _tables(buffer: Buffer | None) -> dict[str, Any] | None:
    """The buffer that shaders read: three numbers of each entry, for the fourth is nothing."""
    if buffer is None:
        return None
    return {
        "name": f"{buffer.prefix}_tables",
        "width": WIDTH,
        "entries": buffer.entries,
        "rows": packed(buffer.rows()[:, :3], "<f4"),
    }


def _square(values: Any) -> Any:
    """A picture as a square of at most MAP_SIZE_MAX a side: averaged, or repeated."""
    size = min(max(values.shape[:2]), MAP_SIZE_MAX)
    for axis in (0, 1):
        count = values.shape[axis]
        if count <= size:
            values = np.take(values, (np.arange(size) * count) // size, axis)
        else:
            starts = (np.arange(size) * count) // size
            sums = np.add.reduceat(values, starts, axis)
            shape = [1, 1, 1]
            shape[axis] = size
            values = sums / np.diff(np.append(starts, count)).reshape(shape)
    return values


# --- the page ------------------------------------------------------------------------------------------


def catalogue(names: Names) -> list[dict[str, str]]:
    """What the page's lists show: files first, then models, then materials."""
    found = [{"name": name, "kind": "file", "summary": name} for name in names.files]
    found += [
        {"name": name, "kind": "model", "summary": summary(cls)} for name, cls in models().items()
    ]
    found += [
        {"name": name, "kind": "material", "summary": load_material(name).description}
        for name in library()
    ]
    return found


def start(names: Names, texts: Iterable[str]) -> dict[str, Any]:
    """What the page knows when it opens."""
    return {
        "gonio": __version__,
        "catalogue": catalogue(names),
        "shapes": shapes(),
        "environments": environments(),
        "fade": fade(),
        "metals": {word: {"symbol": symbol, **metal(symbol)} for symbol, word in metals().items()},
        "indices": INDICES,
        "show": list(texts),
        "models": {text: payload(names, text, reasons=True) for text in texts},
    }


def embedded(data: Mapping[str, Any]) -> str:
    """Data for the inside of a script element: base64 of gzip of JSON, which cannot end that element."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    coded = text.encode(errors="replace")  # names of files need not be UTF-8
    return base64.b64encode(gzip.compress(coded, 9, mtime=0)).decode("ascii")


def document(title: str, script: str, data: str = "") -> str:
    """The page: everything in it is made by its script."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width,initial-scale=1">'
        f'<link rel="icon" href="data:,"><title>{html.escape(title)}</title>{data}</head><body>{script}'
        "<noscript>This page needs JavaScript.</noscript></body></html>\n"
    )


def file(name: str = SCRIPT) -> str:
    """One of the built FILES."""
    return (WEB / name).read_text(encoding="utf-8")


def saved(
    names: Names,
    texts: Iterable[str],
    extra: Mapping[str, Any] | None = None,
    *,
    opens: Iterable[str] = (),
) -> str:
    """One file with everything in it, which works from file://.

    Args:
        names: what may be shown.
        texts: the models that it holds.
        extra: more data for the page, such as the pool of `variants`.
        opens: those of the texts, one or two, that it opens with; without any the first two.
    """
    held = list(texts)
    shown = list(opens) or held
    files = {name: file(name) for name in FILES if name != SCRIPT}
    data = start(names, held) | {"show": shown, "saved": True, "files": files} | dict(extra or {})
    viewer = file().replace("</script", "<\\/script")
    return document(
        f"{', '.join(shown)} – gonio view".encode(errors="replace").decode(),
        f'<script type="module">{viewer}</script>',
        f'<script type="application/octet-stream" id="gonio-data">{embedded(data)}</script>',
    )
