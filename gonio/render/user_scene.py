"""The user's own Mitsuba scene with some of its materials replaced."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gonio.materials import Material
from gonio.model import Model
from gonio.render.passes import Progress, integrate, ready_mitsuba
from gonio.render.picture import Picture


def render_scene(
    path: str | Path,
    assign: Mapping[str, Model | Material],
    *,
    size: tuple[int, int] | None = None,
    spp: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Picture:
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
    mi = ready_mitsuba()
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
    return integrate(loaded, spp, seed, progress).view(Picture)


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
            "hold; use --mesh, or write textures with gonio.mitsuba.textures and name them in the scene."
        )
    from gonio.mitsuba import node

    outer = ET.Element("bsdf", type="twosided")
    _fill(ET.SubElement(outer, "bsdf"), node(material))
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
