"""Pictures and plots for the pages, kept by what they show: only what has changed is made again."""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gonio
from gonio import plot
from gonio.export.manifest import kind, scale, soft_range, used
from gonio.fields import ModelError, Option, Parameter
from gonio.files import replacing
from gonio.materials import Material, load
from gonio.materials.notation import model_text, split

PACKAGE = Path(gonio.__file__).parent

# Pixels and samples: a large picture, and one of a strip. Their noise is taken out afterwards.
BALL, BALL_SAMPLES = 320, 36
SMALL, SMALL_SAMPLES = 112, 16
FLAKES = 4  # times as many for what has flakes, which would go with the noise
STEPS = 5  # values of a strip

SMOOTH = 0.02  # slope of facets: below it, a ball this small does not change

QUALITY = 90  # of WebP: no blocks to be seen in smooth shading

# What the pictures depend on beside the model itself.
RENDERING = ("render", "mitsuba")
PLOTTING = ("plot", "albedos")


class Pictures:
    """Makes pictures into a folder; quick ones are grey and empty."""

    def __init__(self, folder: Path, *, quick: bool) -> None:
        """The folder keeps pictures from one build to the next."""
        self.folder = folder
        self.quick = quick
        self.used: set[Path] = set()
        folder.mkdir(parents=True, exist_ok=True)

    def ball(self, text: str) -> Path:
        """A model or material on the shader ball, by its text."""
        return self._kept(
            ("ball", text, BALL, BALL_SAMPLES, code_of(text), code(*RENDERING)),
            ".webp",
            lambda path: _save(_render(text, BALL, BALL_SAMPLES), path),
        )

    def strip(self, texts: Sequence[str]) -> Path:
        """Several small balls in a row."""
        key = ("strip", *texts, SMALL, SMALL_SAMPLES, code_of(texts[0]), code(*RENDERING))

        def make(path: Path) -> None:
            import numpy as np

            _save(np.concatenate([_render(t, SMALL, SMALL_SAMPLES) for t in texts], axis=1), path)

        return self._kept(key, ".webp", make)

    def plot(self, kind: str, text: str) -> Path:
        """A plot of `gonio.plot` of one model, as SVG."""

        def make(path: Path) -> None:
            plot.plot([load(text)], kind, path)

        return self._kept(("plot", kind, text, code_of(text), code(*PLOTTING)), ".svg", make)

    def clean(self) -> None:
        """Remove what no page shows any more."""
        for path in self.folder.iterdir():
            if path not in self.used:
                path.unlink()

    def _kept(self, key: Sequence[Any], suffix: str, make: Callable[[Path], None]) -> Path:
        if self.quick:
            key, make = ("empty",), EMPTY[suffix]
        digest = hashlib.sha256(repr(key).encode()).hexdigest()[:20]
        path = self.folder / f"{digest}{suffix}"
        self.used.add(path)
        if not path.is_file():
            make(path)
        return path


def _empty_picture(path: Path) -> None:
    import numpy as np

    _save(np.full((8, 8, 3), 0.2, np.float32), path)


def _empty_plot(path: Path) -> None:
    path.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"/>\n', "utf-8")


EMPTY = {".webp": _empty_picture, ".svg": _empty_plot}


def _render(text: str, size: int, spp: int) -> Any:
    shown = load(text)
    if isinstance(shown, Material) and shown.flakes:
        return gonio.render(shown, size=(size, size), spp=FLAKES * spp)
    return gonio.render(shown, size=(size, size), spp=spp, denoise=True)


def _save(pixels: Any, path: Path) -> None:
    from PIL import Image

    from gonio.render.tone import to_srgb

    with replacing(path) as temporary:
        Image.fromarray(to_srgb(pixels)).save(temporary, format="WEBP", quality=QUALITY)


# --- what a strip shows --------------------------------------------------------------------------------


def steps(model: Any, name: str) -> tuple[list[str], list[str]]:
    """Texts of models over a parameter's useful range, and a label for each; empty where nothing shows.

    Where the model's default options do not read the parameter, the first other choice that does is taken.
    """
    declared = model.fields[name]
    assert isinstance(declared, Parameter)
    model = _that_reads(model, name)
    if model is None:
        return [], []
    values = spread(declared)
    texts, labels = [], []
    for value in values:
        try:
            changed = model.replace(**{name: value})
        except ModelError:
            continue
        texts.append(model_text(changed))
        labels.append(f"{value:.3g}")
    return texts, labels


def shared_settings(texts: Sequence[str]) -> list[str]:
    """What all models of a strip have set: the choice without which its parameter is not read."""
    settings = [split(text)[1] for text in texts]
    return [piece for piece in settings[0] if all(piece in other for other in settings)]


def _that_reads(model: Any, name: str) -> Any:
    """The model, or the same with the option that makes it read a parameter; None if there is none."""
    if name in used(model):
        return model
    for path, option in model.fields.items():
        for value in option.values if isinstance(option, Option) else ():
            try:
                changed = model.replace(**{path: value})
            except ModelError:
                continue
            if name in used(changed):
                return changed
    return None


def spread(declared: Parameter) -> list[float]:
    """Values over the useful range, evenly spaced as a slider's are."""
    low, high = soft_range(declared)
    if kind(declared) == "slope":
        low = max(low, SMOOTH)
    if scale(declared) == "log" and low > 0:
        return [float(low * (high / low) ** (k / (STEPS - 1))) for k in range(STEPS)]
    return [low + (high - low) * k / (STEPS - 1) for k in range(STEPS)]


# --- fingerprints --------------------------------------------------------------------------------------


@functools.cache
def code(*names: str) -> str:
    """Of files and folders of the package."""
    digest = hashlib.sha256()
    for name in names:
        path = PACKAGE / name
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()


def code_of(text: str) -> str:
    """Of the files that say what a model or material is: its own, and the parts that they import."""
    found = load(text)
    digest = hashlib.sha256()
    if isinstance(found, Material):
        path = PACKAGE / "materials" / f"{found.name}.toml"
        if path.is_file():
            digest.update(path.read_bytes())
        digest.update(model_text(found.model).encode())
        found = found.model
    models = [found]
    while models:
        model = models.pop()
        models += [v for v in (getattr(model, n) for n in model.fields) if hasattr(v, "fields")]
        for module in sorted(_imported(model.written.__module__)):
            digest.update(_file(module).read_bytes())
    return digest.hexdigest()


@functools.cache
def _imported(module: str) -> frozenset[str]:
    """A module of models or parts, and those that it needs."""
    found = {module}
    for node in ast.walk(ast.parse(_file(module).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for name in (node.module, *(f"{node.module}.{a.name}" for a in node.names)):
                if name.startswith(("gonio.models.", "gonio.parts.")) and _file(name).is_file():
                    found |= _imported(name)
    return frozenset(found)


def _file(module: str) -> Path:
    return PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py")
