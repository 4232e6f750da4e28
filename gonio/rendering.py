"""Pictures of models: on the shader ball, on the user's mesh, or in the user's own Mitsuba scene."""

from __future__ import annotations

import dataclasses
import functools
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio import backend, scene
from gonio.diffusion import diffuse_on_screen
from gonio.files import replacing
from gonio.material import Material
from gonio.model import Model, Parameter

Pixels = NDArray[np.float32]
Progress = Callable[[int, int], None]
"""Called with (samples done, samples in all) after every pass."""

# Samples of one pass: small enough to show progress and to answer an interrupt within a second or two,
# large enough (4 M paths) to keep all cores busy.
PATHS_PER_PASS = 1 << 22

FORMATS = (".png", ".exr")


def render(
    material: Model | Material,
    *,
    environment: str | Path = "studio",
    mesh: str | Path | None = None,
    furnace: bool = False,
    diffusion: float = 0.0,
    size: tuple[int, int] = (512, 512),
    spp: int = 64,
    seed: int = 0,
    progress: Progress | None = None,
    **stage: Any,
) -> Pixels:
    """Render a model or material on the shader ball, or on a mesh of the user's.

    Args:
        material: what to show.
        environment: "studio", "sun", "front", "side", "white", "sunsky", or a path to .exr or .hdr.
        mesh: a path to .obj, .ply or .glb instead of the ball.
        furnace: put the object into radiance 1 from everywhere; what loses no energy disappears.
        diffusion: how long a millimetre is in the scene's units, to let the light in skin wander on the
            screen (see `gonio.diffusion`); 0 for other materials.
        size: width and height in pixels.
        spp: samples per pixel.
        seed: of the random numbers; the same seed gives the same picture.
        progress: called after each pass.
        stage: further arguments of `gonio.scene.shader_ball`, such as up="z".

    Returns:
        Linear RGB radiance, float32, shape (height, width, 3).

    Raises:
        ValueError, FileNotFoundError: one line on what was wrong with an argument or a file.
    """
    mi = _mitsuba()

    def load(shown: Model | Material) -> Any:
        node = scene.shader_ball(
            _bsdf(shown),
            environment=environment,
            mesh=mesh,
            size=size,
            furnace=furnace,
            spp=spp,
            **stage,
        )
        if isinstance(shown, Material) and shown.grows:
            _grow(node)
        # Mitsuba's optimizations leave lamps in an order that changes from run to run, and so the noise.
        return mi.load_dict(node, optimize=False)

    loaded = load(material)
    if not diffusion:
        return _integrate(loaded, spp, seed, progress)
    without = load(_without_diffuse(material))

    def half(first: int) -> Progress:
        def step(done: int, total: int) -> None:
            if progress is not None:
                progress(first * total + done, 2 * total)

        return step

    full = _integrate(loaded, spp, seed, half(0))
    glossy = _integrate(without, spp, seed, half(1))
    spread = diffuse_on_screen(full - glossy, *_seen(loaded), millimetre=diffusion)
    return np.asarray(glossy + spread, np.float32)


def _without_diffuse(material: Model | Material) -> Model | Material:
    """The same with black diffuse reflection."""
    model = material.model if isinstance(material, Material) else material
    black = [path for path, _, _ in model.parameters() if path.rpartition(".")[2] == "rho"]
    if not black:
        raise ValueError(
            f"{material.name} has no diffuse colour rho, whose light diffusion could spread."
        )
    model = model.replace(**dict.fromkeys(black, 0.0))
    if not isinstance(material, Material):
        return model
    textures = {path: file for path, file in material.textures.items() if path not in black}
    return dataclasses.replace(material, model=model, textures=textures)


def _seen(loaded: Any) -> tuple[Any, Any, Any]:
    """What each pixel's middle shows: the point, the area (up to a factor), the tested shape's number."""
    import mitsuba as mi

    sensor = loaded.sensors()[0]
    width, height = (int(n) for n in sensor.film().size())
    y, x = np.mgrid[0:height, 0:width]
    middle = mi.Point2f(
        ((x.ravel() + 0.5) / width).astype(np.float32),
        ((y.ravel() + 0.5) / height).astype(np.float32),
    )
    ray, _ = sensor.sample_ray(0.0, 0.5, middle, mi.Point2f(0.5))
    si = loaded.ray_intersect(ray)
    surface = np.zeros(width * height, int)
    for number, shape in enumerate(loaded.shapes(), 1):
        if shape.id() in scene.TESTED:
            surface[np.array(si.is_valid() & (si.shape == mi.ShapePtr(shape)))] = number
    # Flat pixels at the rim show much surface, but one sample of it says little.
    cosine = np.maximum(np.abs(np.array(si.wi.z)), 0.2)
    areas = np.where(surface > 0, np.array(si.t), 0) ** 2 / cosine
    points = np.where(surface > 0, np.array(si.p), 0).T
    return (
        points.reshape(height, width, 3),
        areas.reshape(height, width),
        surface.reshape(height, width),
    )


def _grow(node: dict[str, Any]) -> None:
    """Put growth on the meshes under test, for materials that grow in cavities."""
    import mitsuba as mi

    from gonio.textures import add_growth

    for name in scene.TESTED:
        if name in node:
            buffers = mi.traverse(node[name])
            positions, faces = (np.array(buffers[key]) for key in ("vertex_positions", "faces"))
            growth = _growth(positions.tobytes(), faces.tobytes(), positions.dtype, faces.dtype)
            add_growth(node[name], growth)


@functools.lru_cache(maxsize=8)  # a second or two each; the steps of a series have the same meshes
def _growth(positions: bytes, faces: bytes, real: Any, integer: Any) -> Any:
    from gonio.textures import growth_map

    return growth_map(
        np.frombuffer(positions, real).reshape(-1, 3), np.frombuffer(faces, integer).reshape(-1, 3)
    )


def render_scene(
    path: str | Path,
    assign: Mapping[str, Model | Material],
    *,
    size: tuple[int, int] | None = None,
    spp: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Pixels:
    """Render the user's own Mitsuba scene with some of its materials replaced.

    Args:
        path: the scene's XML file. It is read, never written.
        assign: models by the id of a shape or of a BSDF in the scene.
        size: width and height; the scene's own by default.
        spp: samples per pixel; the scene's own by default.
        seed: of the random numbers.
        progress: called after each pass.

    Returns:
        Linear RGB radiance, float32, shape (height, width, 3).

    Raises:
        FileNotFoundError: no such file.
        ValueError: not a Mitsuba scene, or an id that is not in it (with those that are).
    """
    mi = _mitsuba()
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no scene file {path}.")
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path} is not an XML file: {error}.") from None
    if root.tag != "scene":
        raise ValueError(f"{path} is not a Mitsuba scene: its root is <{root.tag}>, not <scene>.")
    _assign(root, assign, path)
    if size is not None:
        _resize(root, size)
    resolver = mi.file_resolver()
    resolver.append(str(path.parent.resolve()))
    try:
        loaded = mi.load_string(ET.tostring(root, encoding="unicode"))
    except RuntimeError as error:
        raise ValueError(f"{path} does not load: {str(error).splitlines()[-1]}") from error
    if spp is None:
        spp = int(loaded.sensors()[0].sampler().sample_count()) if loaded.sensors() else 0
    if not loaded.sensors():
        raise ValueError(f"{path} has no <sensor>; add one to say from where to look.")
    return _integrate(loaded, spp, seed, progress)


def _assign(root: ET.Element, assign: Mapping[str, Model | Material], path: Path) -> None:
    """Replace the BSDFs of an XML scene; the elements are found by the id of a shape or BSDF."""
    ids = {e.get("id"): e for e in root.iter() if e.tag in {"shape", "bsdf"} and e.get("id")}
    parents = {child: parent for parent in root.iter() for child in parent}
    for name, material in assign.items():
        if name not in ids:
            known = ", ".join(sorted(str(i) for i in ids)) or "none: give the shape an id"
            raise ValueError(f"{path} has no shape or bsdf with the id {name!r}; ids: {known}.")
        element = ids[name]
        plugin = _xml(material)
        if element.tag == "bsdf":
            plugin.set("id", name)
            parent = parents[element]
            parent[list(parent).index(element)] = plugin
            continue
        for child in list(element):
            target = ids.get(child.get("id")) if child.tag == "ref" else child
            if target is not None and target.tag == "bsdf":
                element.remove(child)
        element.append(plugin)


def _xml(material: Model | Material) -> ET.Element:
    """A material as an XML <bsdf>, two-sided as most scenes expect."""
    if isinstance(material, Material) and (material.flakes or material.grows):
        raise ValueError(
            f"{material.name} has textures that are made for the mesh it is on, which a scene file cannot "
            "hold; use --mesh, or write the textures with gonio.textures and name them in the scene."
        )
    outer = ET.Element("bsdf", type="twosided")
    _fill(ET.SubElement(outer, "bsdf"), _bsdf(material))
    return outer


def _fill(inner: ET.Element, node: Mapping[str, Any]) -> None:
    """Write a plug-in's dict into an XML <bsdf>."""
    inner.set("type", node["type"])
    for name, value in node.items():
        if name == "type":
            continue
        if isinstance(value, dict) and value["type"].startswith("gonio_"):
            _fill(ET.SubElement(inner, "bsdf", name=name), value)
            continue
        if isinstance(value, dict) and value["type"] == "rgb":
            text = ", ".join(repr(float(v)) for v in value["value"])
            ET.SubElement(inner, "rgb", name=name, value=text)
        elif isinstance(value, dict):
            texture = ET.SubElement(inner, "texture", type=value["type"], name=name)
            filename = str(Path(value["filename"]).resolve())
            ET.SubElement(texture, "string", name="filename", value=filename)
            ET.SubElement(texture, "boolean", name="raw", value=str(value["raw"]).lower())
        elif isinstance(value, str):
            ET.SubElement(inner, "string", name=name, value=value)
        else:
            ET.SubElement(inner, "float", name=name, value=repr(value))


def _resize(root: ET.Element, size: tuple[int, int]) -> None:
    for film in root.iter("film"):
        for child in list(film):
            if child.get("name") in {"width", "height"}:
                film.remove(child)
        for name, value in zip(("width", "height"), size, strict=True):
            ET.SubElement(film, "integer", name=name, value=str(value))


def compare(
    rows: Sequence[Mapping[str, Any]], columns: Sequence[Model | Material], **common: Any
) -> Pixels:
    """Render several materials side by side, once for each row.

    Args:
        rows: arguments of `render` for each row, such as {"environment": "side"}.
        columns: the materials.
        common: arguments of `render` for all.

    Returns:
        Linear RGB radiance, float32, shape (rows * height, columns * width, 3).
    """
    progress = common.pop("progress", None)
    cells = len(rows) * len(columns)
    pictures = []
    for r, row in enumerate(rows):
        for c, material in enumerate(columns):
            done = r * len(columns) + c

            def step(n: int, total: int, done: int = done) -> None:
                if progress is not None:
                    progress(done * total + n, cells * total)

            pictures.append(render(material, progress=step, **{**common, **row}))
    width = len(columns)
    return np.concatenate(
        [np.concatenate(pictures[i : i + width], axis=1) for i in range(0, cells, width)]
    )


def describe(material: Model | Material) -> str:
    """A label: the name and what differs from the defaults."""
    if isinstance(material, Material):
        return material.name
    parts = []
    for name, declared in material.fields.items():
        value = getattr(material, name)
        if not declared.is_default(value):
            number = value if isinstance(value, tuple) else (value,)
            text = "/".join(f"{v:g}" if isinstance(v, float) else str(v) for v in number)
            parts.append(f"{name}={text}" if isinstance(declared, Parameter) else text)
    return " ".join([material.name, *parts])


def captions(materials: Sequence[Material]) -> list[str]:
    """Labels of materials of one model: the parameters in which they differ from each other."""
    values = [
        {path: value for path, _, value in material.model.parameters()} for material in materials
    ]
    differing = [path for path in values[0] if len({repr(v[path]) for v in values}) > 1]

    def text(value: Any) -> str:
        numbers = value if isinstance(value, tuple) else (value,)
        return "/".join(f"{v:g}".replace("-", "−") for v in numbers)

    return [", ".join(f"{path} {text(v[path])}" for path in differing) for v in values]


def write_picture(
    path: str | Path,
    pixels: Pixels,
    *,
    exposure: float = 0.0,
    labels: Sequence[str] = (),
    row_labels: Sequence[str] = (),
) -> None:
    """Write a picture: .png (8-bit sRGB, clipped) or .exr (linear float32, without labels).

    Args:
        path: the file; it appears only when it is complete.
        pixels: linear radiance, shape (height, width, 3).
        exposure: in stops, for .png.
        labels: one under each of that many columns, for .png.
        row_labels: one at the left edge of each of that many rows, for .png.

    Raises:
        ValueError: another suffix, or pixels that are not finite.
        FileNotFoundError: the folder does not exist.
    """
    import mitsuba as mi

    path = Path(path)
    check_format(path)
    if not np.isfinite(pixels).all():
        raise ValueError(f"{path}: the picture has pixels that are not finite.")
    if path.suffix.lower() == ".exr":
        with replacing(path) as temporary:
            mi.Bitmap(np.ascontiguousarray(pixels, np.float32)).write(str(temporary))
        return
    picture = _captioned(_to_srgb(pixels, exposure), labels, row_labels)
    with replacing(path) as temporary:
        picture.save(temporary, format="PNG")


def check_format(path: Path) -> None:
    """Raise a ValueError unless the suffix is one that `write_picture` can write."""
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"cannot write {path.name!r}; the suffix must be {' or '.join(FORMATS)}.")


BACKGROUND, INK = (24, 24, 24), (235, 235, 235)


def _captioned(pixels: NDArray[np.uint8], labels: Sequence[str], rows: Sequence[str]) -> Any:
    """A Pillow image with labels under its columns and at the left of its rows."""
    from PIL import Image, ImageDraw

    picture = Image.fromarray(pixels)
    if not labels and not rows:
        return picture
    height, width = pixels.shape[:2]
    cell_height = height // max(len(rows), 1)
    cell_width = width // max(len(labels), 1)
    font_size = max(11, min(cell_width, cell_height) // 20)
    footer = 2 * font_size if labels else 0
    margin = 2 * font_size if rows else 0
    sheet = Image.new("RGB", (width + margin, height + footer), BACKGROUND)
    sheet.paste(picture, (margin, 0))
    draw = ImageDraw.Draw(sheet)
    for n, label in enumerate(labels):
        centre = (margin + cell_width * (n + 0.5), height + footer / 2)
        draw.text(
            centre, label, font=_font(label, font_size, cell_width - 4), fill=INK, anchor="mm"
        )
    for n, label in enumerate(rows):
        strip = Image.new("RGB", (cell_height, margin), BACKGROUND)
        ImageDraw.Draw(strip).text(
            (cell_height / 2, margin / 2),
            label,
            font=_font(label, font_size, cell_height - 4),
            fill=INK,
            anchor="mm",
        )
        sheet.paste(strip.rotate(90, expand=True), (0, n * cell_height))
    return sheet


def _font(text: str, size: int, width: int) -> Any:
    """A font in which the text is at most `width` pixels wide, if that is legible at all."""
    import matplotlib
    from PIL import ImageFont

    file = str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf")
    while size > 7 and ImageFont.truetype(file, size).getlength(text) > width:
        size -= 1
    return ImageFont.truetype(file, size)


def write_sheet(
    path: str | Path,
    materials: Sequence[Model | Material],
    *,
    columns: int = 6,
    cell: int = 256,
    progress: Progress | None = None,
    **common: Any,
) -> None:
    """Render a contact sheet of materials into a .png, each with its name.

    Args:
        path: the file; it appears only when it is complete.
        materials: what to show, row by row.
        columns: how many side by side.
        cell: pixels of one picture.
        progress: called after each pass.
        common: further arguments of `render`, such as environment="sunsky".

    Raises:
        ValueError: no materials, or a suffix other than .png.
    """
    from PIL import Image

    path = Path(path)
    if path.suffix.lower() != ".png":
        raise ValueError(f"cannot write a sheet to {path.name!r}; the suffix must be .png.")
    if not materials:
        raise ValueError("a sheet needs at least one material.")
    strips = []
    for first in range(0, len(materials), columns):
        shown = materials[first : first + columns]

        def step(done: int, total: int, first: int = first, count: int = len(shown)) -> None:
            if progress is not None:
                progress(first * total + done * count, len(materials) * total)

        pixels = compare([{}], shown, size=(cell, cell), progress=step, **common)
        strips.append(_captioned(_to_srgb(pixels, 0.0), [describe(m) for m in shown], []))
    width = max(strip.width for strip in strips)
    sheet = Image.new("RGB", (width, sum(strip.height for strip in strips)), BACKGROUND)
    top = 0
    for strip in strips:
        sheet.paste(strip, (0, top))
        top += strip.height
    with replacing(path) as temporary:
        sheet.save(temporary, format="PNG")


def _to_srgb(pixels: Pixels, exposure: float) -> NDArray[np.uint8]:
    """8-bit sRGB of linear pixels, clipped, after an exposure in stops."""
    import mitsuba as mi

    scaled = np.ascontiguousarray(pixels * np.float32(2.0**exposure))
    bitmap = mi.Bitmap(scaled).convert(
        mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True
    )
    return np.array(bitmap)


DEMO_ROWS = (("front-lit", {"environment": "front"}), ("side-lit", {"environment": "side"}))


def demo(
    folder: str | Path = "demo",
    *,
    cell: int = 320,
    spp: int = 64,
    progress: Progress | None = None,
) -> list[Path]:
    """Render Lambert, QON, FON and EON at full roughness: front-lit, side-lit, and in a white furnace.

    After Figures 1 and 4 of the EON paper. Writes demo.png into `folder` and returns its path.
    """
    from gonio.model import model

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    clay = (0.75, 0.41, 0.28)

    def materials(rho: Any) -> list[Model]:
        return [
            model("lambert", rho=rho),
            model("qon", rho=rho, sigma=math.pi / 2),
            model("fon", rho=rho, roughness=1),
            model("eon", rho=rho, roughness=1),
        ]

    rows = [row for _, row in DEMO_ROWS]
    height = len(rows) + 1

    def share(first: int, count: int) -> Progress:
        """Progress of `count` rows after `first` ones, as progress of the whole."""

        def step(done: int, total: int) -> None:
            if progress is not None:
                progress(first * total + done * count, height * total)

        return step

    lit = compare(rows, materials(clay), size=(cell, cell), spp=spp, progress=share(0, len(rows)))
    furnace = compare(
        [{"furnace": True}],
        materials(1.0),
        size=(cell, cell),
        spp=spp,
        progress=share(len(rows), 1),
    )
    target = folder / "demo.png"
    write_picture(
        target,
        np.concatenate([lit, furnace]),
        labels=["Lambert", "QON σ = π/2", "FON r = 1", "EON r = 1"],
        row_labels=[*(label for label, _ in DEMO_ROWS), "white furnace"],
    )
    return [target]


def _integrate(loaded: Any, spp: int, seed: int, progress: Progress | None) -> Pixels:
    """The mean of several passes, so that long work shows progress and can be interrupted."""
    import drjit as dr
    import mitsuba as mi

    if spp < 1:
        raise ValueError(f"spp={spp} is out of range; allowed is at least 1.")
    width, height = loaded.sensors()[0].film().size()
    limit = max(1, PATHS_PER_PASS // max(int(width) * int(height), 1))
    total: Any = 0
    done = 0
    for number, count in enumerate(_passes(spp, limit)):
        # Mitsuba derives a pass's random numbers from its seed; far-apart seeds never overlap.
        picture = mi.render(loaded, spp=count, seed=seed * 65536 + number)
        total = total + picture * (count / spp)
        dr.eval(total)
        done += count
        if progress is not None:
            dr.sync_thread()
            progress(done, spp)
    pixels = np.array(total, dtype=np.float32)[..., :3]
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels


# A stratified sampler wants square numbers of samples, and rounds others up with a warning.
SQUARES = (64, 36, 16, 4, 1)


def _passes(spp: int, limit: int) -> Iterator[int]:
    """Square numbers of samples, at most `limit` each, that add up to `spp`."""
    while spp > 0:
        count = next(n for n in SQUARES if n <= min(spp, limit))
        yield count
        spp -= count


def _bsdf(material: Model | Material) -> dict[str, Any]:
    if isinstance(material, Material):
        return material.bsdf()
    return Material(material.name, material).bsdf()


def _mitsuba() -> Any:
    """Mitsuba with a variant that fits the backend in force, unless the user chose one."""
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant(backend.mitsuba_variant())
    import gonio.mitsuba

    gonio.mitsuba.register()
    return mi
