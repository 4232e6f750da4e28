"""The user's own Mitsuba scene with some of its materials replaced."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gonio.materials import Material
from gonio.messages import notice
from gonio.model import Model
from gonio.render import denoise as denoising
from gonio.render.growth import add_to, has_triangles, textured
from gonio.render.passes import Progress, integrate, ready_mitsuba
from gonio.render.picture import Picture
from gonio.render.stage import check_size, for_both_sides


def render_scene(
    path: str | Path,
    assign: Mapping[str, Model | Material],
    *,
    define: Mapping[str, str] | None = None,
    size: tuple[int, int] | None = None,
    spp: int | None = None,
    denoise: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
) -> Picture:
    """Render the user's own Mitsuba scene with some of its materials replaced.

    Files that the scene names are looked for beside the file that names them, then beside the scene.

    Args:
        path: the scene's XML file. It is read, never written.
        assign: models by the id of a shape or of a BSDF in the scene or in what it includes.
        define: values of the scene's parameters, which it writes as $name.
        size: width and height; the scene's own by default.
        spp: samples per pixel; the scene's own by default.
        denoise: take the noise out of the finished picture, as `gonio.render.denoise` tells; its film gets
            the filter that this needs.
        seed: of the random numbers.
        progress: called after each pass.

    Returns:
        Linear RGB radiance, float32, shape (height, width, 3), whatever format the film has.

    Raises:
        FileNotFoundError: no such file.
        ValueError: not a Mitsuba scene, or an id that is not in it (with those that are).
    """
    if denoise:
        denoising.library()  # what is missing is said before the work
    ready_mitsuba()
    from gonio.mitsuba.xml_files import files_from, in_utf8, reason

    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no scene file {path}.")
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{path} is not an XML file: {error}.") from None
    if root.tag != "scene":
        raise ValueError(f"{path} is not a Mitsuba scene: its root is <{root.tag}>, not <scene>.")
    with in_utf8(path) as opened, files_from(opened.parent):
        rfilter = denoising.FILTER if denoise else None
        try:
            loaded = _Scene(path, opened, define or {}).loaded(assign, size, rfilter)
            if denoise:
                stand_ins = {name: denoising.stand_in(shown) for name, shown in assign.items()}
                seen = _Scene(path, opened, define or {}).loaded(stand_ins, size, rfilter)
        except RuntimeError as error:
            said = reason(error).replace(str(opened), str(path))
            raise ValueError(f"{path} does not load: {said}.") from error
        if not loaded.sensors():
            raise ValueError(f"{path} has no <sensor>; add one to say from where to look.")
        if loaded.integrator() is None:
            raise ValueError(f"{path} has no <integrator>; add one, such as path.")
        if (count := len(loaded.sensors())) > 1:
            notice(f"{path} has {count} sensors; what the first one sees is shown.")
        if spp is None:
            spp = int(loaded.sensors()[0].sampler().sample_count())
        try:
            pixels = integrate(loaded, spp, seed, progress)
            if denoise:
                pixels = denoising.denoised(pixels, *denoising.first_seen(seen))
            return pixels.view(Picture)
        except RuntimeError as error:
            raise ValueError(f"{path} cannot be rendered: {reason(error)}.") from error


class _Scene:
    """A scene as Mitsuba's parser has it: one node for each object, includes and parameters resolved."""

    def __init__(self, path: Path, opened: Path, define: Mapping[str, str]) -> None:
        """`opened` is the path by which Mitsuba reads the file, `path` that of the user."""
        import mitsuba as mi

        self.mi = mi
        self.path = path
        self.config = mi.parser.ParserConfig(mi.variant())
        # Merged shapes would lose their names, and change their order from run to run.
        self.config.merge_equivalent = self.config.merge_meshes = False
        if taken := {"config", "filename"} & set(define):
            raise ValueError(
                f"Mitsuba takes no parameter of the name {taken.pop()}; choose another."
            )
        self.state = mi.parser.parse_file(self.config, str(opened), **define)
        mi.parser.transform_all(self.config, self.state)

    def loaded(
        self,
        assign: Mapping[str, Model | Material],
        size: tuple[int, int] | None,
        rfilter: str | None,
    ) -> Any:
        """The scene with its materials, its size and the filter of its film replaced."""
        self._find_files()
        named = self._named(assign)
        # Shapes first: what they wore before is no longer looked for in them.
        shape = self.mi.ObjectType.Shape
        order = sorted(assign, key=lambda name: named[name].type != shape)
        made = {name: self._assign(named[name], assign[name]) for name in order}
        self._set_films(None if size is None else check_size(size), rfilter)
        found = self.mi.parser.instantiate(self.config, self.state)
        scene = found[0] if isinstance(found, list) else found
        for name, bsdf in made.items():
            self._complete(scene, assign[name], bsdf)
        return scene

    def _of(self, *types: str) -> list[Any]:
        wanted = [getattr(self.mi.ObjectType, name) for name in types]
        return [node for node in self.state.nodes if node.type in wanted]

    def _children(self, node: Any) -> dict[str, Any]:
        """Nodes that a node refers to, by the property that does."""
        reference = self.mi.Properties.Type.ResolvedReference
        return {
            name: self.state.nodes[node.props[name].index()]
            for name in list(node.props.keys())
            if node.props.type(name) == reference
        }

    def _find_files(self) -> None:
        """Make the names of files absolute that lie beside the file that names them."""
        text = self.mi.Properties.Type.String
        for node in self.state.nodes:
            if "filename" not in node.props or node.props.type("filename") != text:
                continue
            beside = Path(str(self.state.files[node.file_index])).parent / node.props["filename"]
            if beside.is_file():
                node.props["filename"] = str(beside.absolute())

    def _named(self, names: Iterable[str]) -> dict[str, Any]:
        """The shapes and BSDFs with these ids; an error where an assignment would change nothing."""
        shape = self.mi.ObjectType.Shape
        found = {n.props.id(): n for n in self._of("Shape", "BSDF") if n.props.id()}
        names = list(names)
        for name in names:
            if name not in found:
                own = sorted(i for i in found if not i.startswith("_"))
                known = ", ".join(own) or "none: give the shape an id"
                raise ValueError(
                    f"{self.path} has no shape or bsdf with the id {name!r}; ids: {known}."
                )
            if found[name].type == shape:
                continue
            wearers = [n for n in self._of("Shape") if self._wears(n, name)]
            if not wearers:
                raise ValueError(f"{self.path}: no shape wears the bsdf {name!r}.")
            if all(n.props.id() in names for n in wearers):
                others = " and ".join(str(n.props.id()) for n in wearers)
                raise ValueError(
                    f"{self.path}: only {others} wears the bsdf {name!r}, and gets another model itself."
                )
        return {name: found[name] for name in names}

    def _wears(self, node: Any, name: str) -> bool:
        """Whether the BSDF of this id is anywhere in a node."""
        bsdf = self.mi.ObjectType.BSDF
        below = [child for child in self._children(node).values() if child.type == bsdf]
        return any(child.props.id() == name or self._wears(child, name) for child in below)

    def _assign(self, target: Any, material: Model | Material) -> Any:
        """Put a material in the place of a BSDF, or of the BSDFs of a shape; the material's BSDF."""
        from gonio.mitsuba import node as as_dict

        name = target.props.id()
        bsdf = for_both_sides(self.mi.load_dict(as_dict(material)))
        if target.type == self.mi.ObjectType.Shape:
            if target.props.plugin_name() == "shapegroup":
                inside = sorted(c.props.id() for c in self._children(target).values())
                raise ValueError(
                    f"{self.path}: {name} is a group of shapes, which wears nothing itself; in it are "
                    f"{', '.join(inside)}."
                )
            for key, child in self._children(target).items():
                if child.type == self.mi.ObjectType.BSDF:
                    del target.props[key]
            target.props["bsdf"] = bsdf
        else:
            for node in self.state.nodes:
                for key, child in self._children(node).items():
                    if child.props.id() == name and child.type == self.mi.ObjectType.BSDF:
                        node.props[key] = bsdf
        return bsdf

    def _complete(self, scene: Any, material: Model | Material, bsdf: Any) -> None:
        """Growth for the meshes that wear a material which grows; an error where uvs are missing."""
        for shape in scene.shapes():
            if shape.bsdf() != bsdf:
                continue
            mesh = has_triangles(shape)
            if mesh and not shape.has_vertex_texcoords() and (what := textured(material)):
                raise ValueError(
                    f"{self.path}: a mesh has no texture coordinates, and {' and '.join(what)} of "
                    f"{material.name} needs them."
                )
            if isinstance(material, Material) and material.grows:
                if not mesh:
                    raise ValueError(
                        f"{self.path}: {material.name} grows in the cavities of meshes, and a shape "
                        "that wears it is none."
                    )
                add_to(shape)

    def _set_films(self, size: tuple[int, int] | None, rfilter: str | None) -> None:
        """Give the films a size and a filter, unless they are None."""
        for sensor in self._of("Sensor"):
            films = [
                n for n in self._children(sensor).values() if n.type == self.mi.ObjectType.Film
            ]
            for film in films:
                if size is not None:
                    self._resize(film, size)
                if rfilter is not None:
                    for key, child in self._children(film).items():
                        if child.type == self.mi.ObjectType.ReconstructionFilter:
                            del film.props[key]
                    film.props["rfilter"] = self.mi.load_dict({"type": rfilter})
            if not films and (size or rfilter):
                made: dict[str, Any] = {"type": "hdrfilm"}
                made |= dict(zip(_FILM_SIZE, size, strict=True)) if size else {}
                made |= {"rfilter": {"type": rfilter}} if rfilter else {}
                sensor.props["film"] = self.mi.load_dict(made)

    def _resize(self, film: Any, size: tuple[int, int]) -> None:
        before = [film.props.get(key, default) for key, default in _FILM_SIZE.items()]
        for corner in ("offset", "size"):
            for axis, (new, old) in enumerate(zip(size, before, strict=True)):
                key = f"crop_{corner}_{'xy'[axis]}" if corner == "offset" else _CROP[axis]
                if key in film.props:
                    film.props[key] = int(film.props[key]) * new // int(old)
        film.props["width"], film.props["height"] = size


_FILM_SIZE = {"width": 768, "height": 576}  # Mitsuba's own, where a film does not say
_CROP = ("crop_width", "crop_height")
