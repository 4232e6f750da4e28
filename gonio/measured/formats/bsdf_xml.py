"""Window BSDF in XML: matrices over patches (Klems) and trees (TensorTree).

Source: the LBNL schema BSDF-v1.4, and Radiance's bsdf_m.c and bsdf_t.c. Azimuths of both directions
follow the light, so that what goes straight through, or is mirrored, has the same patch twice: gonio's
wi is half a turn away. Matrices are "Columns", [out][in], or "Rows", [in][out]. Values are averages over
patches, in 1/sr. Trees have the Shirley-Chiu square of the directions, isotropic ones (TensorTree3) 1/2
- sin(theta_i) / 2 in its place.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np

from gonio.measured.frames import Floats, spherical
from gonio.measured.measurement import DataError, Mask, Measurement, measurement
from gonio.measured.source import MOST_TEXT, Source

NAME, SUFFIX = "BSDF XML", ".xml"

# Bounds of the elevations in degrees, and patches in each ring.
KLEMS = {
    "LBNL/Klems Full": ((0, 5, 15, 25, 35, 45, 55, 65, 75, 90), (1, 8, 16, 20, 24, 24, 24, 16, 12)),
    "LBNL/Klems Half": ((0, 6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90), (1, 8, 12, 16, 20, 12, 4)),
    "LBNL/Klems Quarter": ((0, 9, 27, 46, 66, 90), (1, 8, 12, 12, 8)),
}

# Elements inside each other, elements, patches, leaves, and levels of a tree; far above real files.
DEEPEST, MOST_ELEMENTS, MOST_PATCHES, MOST_LEAVES, DEEPEST_TREE = 40, 200_000, 5000, 1 << 22, 16

PIECE = 1 << 16


def sniff(source: Source) -> bool:
    """By its outermost element."""
    head = source.head.lower()
    for marks in (b"\xff\xfe", b"\xfe\xff"):  # UTF-16
        if head.startswith(marks):
            head = head.replace(b"\0", b"")
    return b"<windowelement" in head or (head.lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"<?xml"))


def _parse(source: Source) -> ElementTree.Element:
    """The tree of elements, without the names' spaces. Entities are refused: they can grow without
    bound."""
    if source.size > MOST_TEXT:
        raise source.error(f"has {source.size >> 20} MiB; at most {MOST_TEXT >> 20} are read.")
    builder = ElementTree.TreeBuilder()
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    depth = elements = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth, elements
        depth, elements = depth + 1, elements + 1
        if depth > DEEPEST or elements > MOST_ELEMENTS:
            raise source.error(
                f"has more than {DEEPEST} elements inside each other, or {MOST_ELEMENTS} in all."
            )
        builder.start(name.rpartition(" ")[2], attributes)

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(name.rpartition(" ")[2])

    def doctype(*declared: Any) -> None:
        raise source.error("declares a document type or entities, which BSDF files do not have.")

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = doctype
    try:
        with source.path.open("rb") as file:
            while piece := file.read(PIECE):
                parser.Parse(piece, False)
            parser.Parse(b"", True)
        return builder.close()
    except expat.ExpatError as error:
        raise source.error(
            f"is no XML: {expat.errors.messages[error.code]}.", error.lineno
        ) from None
    except (ValueError, AssertionError, LookupError) as error:
        if isinstance(error, DataError):
            raise
        raise source.error(f"is no XML that can be read: {error}.") from None


def _text(element: ElementTree.Element | None) -> str:
    return "" if element is None or element.text is None else " ".join(element.text.split())


def read(source: Source) -> list[Measurement]:
    """Reflection and transmission of both sides, each for every spectrum."""
    root = _parse(source)
    layer = root.find(".//Layer")
    definition = root.find(".//DataDefinition")
    if root.tag != "WindowElement" or layer is None or definition is None:
        raise source.error("has no WindowElement with a Layer and a DataDefinition.")
    structure = _text(definition.find("IncidentDataStructure")).lower()
    if structure not in {"columns", "rows", "tensortree3", "tensortree4"}:
        raise source.error(
            f"its data are {structure[:40]!r}; Columns, Rows, TensorTree3 and TensorTree4 are read."
        )
    bases = dict(_bases(source, definition))
    material = layer.find("Material")
    metadata = {} if material is None else {e.tag: _text(e)[:300] for e in material if _text(e)}
    found = []
    for data in root.iter("WavelengthData"):
        spectrum = _text(data.find("Wavelength"))
        for block in data.iter("WavelengthDataBlock"):
            words = _text(block.find("WavelengthDataDirection")).lower().split()
            if len(words) != 2 or words[0] not in {"reflection", "transmission"}:
                raise source.error(
                    f"has a block of {' '.join(words)[:40] or 'no direction'!r}; Reflection Front and the "
                    "like are read."
                )
            more = {
                "part": f"{' '.join(words)} {spectrum.lower()[:20]}".strip(),
                "metadata": metadata | {"spectrum": spectrum[:40], "data structure": structure},
            }
            text = block.find("ScatteringData")
            content = "" if text is None or text.text is None else text.text
            if structure.startswith("tensor"):
                found.append(_tree(source, content, int(structure[-1]), words, more))
            else:
                found.append(
                    _matrix(source, block, content, structure == "rows", bases, words, more)
                )
    if not found:
        raise source.error("has no WavelengthDataBlock.")
    # Reflection of the front comes first: it is what most want
    return sorted(found, key=lambda m: (m.transmission, "back" in m.part))


# --- matrices ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Basis:
    """The patches of a hemisphere."""

    theta: Floats
    """Middle of each patch, in radians."""
    phi: Floats
    bounds: Floats
    """Of the rings, in radians."""
    counts: Any
    """Patches of each ring; the first is centred at azimuth 0."""

    def find(self, theta: Floats, phi: Floats) -> Any:
        """The patch that a direction is in."""
        ring = np.clip(np.searchsorted(self.bounds, theta, "right") - 1, 0, len(self.counts) - 1)
        count = self.counts[ring]
        first = np.concatenate([[0], np.cumsum(self.counts)[:-1]])[ring]
        return first + np.floor(phi / (2 * np.pi) * count + 0.5).astype(np.int64) % count


def _basis(source: Source, bounds: Any, counts: Any) -> Basis:
    bounds = np.radians(source.finite(bounds, "the bounds of patches"))
    counts = np.asarray(counts, np.int64)
    if (np.diff(bounds) <= 0).any() or bounds[0] < 0 or bounds[-1] > 0.5 * np.pi + 1e-6:
        raise source.error("its rings of patches do not go from 0 to 90 degrees.")
    if counts.sum() > MOST_PATCHES:
        raise source.error(f"has {counts.sum()} patches; at most {MOST_PATCHES} are read.")
    # The middle of a ring, by its projected area; the middle of the first is the pole
    middle = np.arcsin(np.sqrt(0.5 * (np.sin(bounds[1:]) ** 2 + np.sin(bounds[:-1]) ** 2)))
    if counts[0] == 1:
        middle[0] = 0
    theta = np.repeat(middle, counts)
    phi = np.concatenate([2 * np.pi * np.arange(n) / n for n in counts])
    return Basis(theta, phi, bounds, counts)


def _bases(source: Source, definition: ElementTree.Element) -> Any:
    for name, (bounds, counts) in KLEMS.items():
        yield name, _basis(source, bounds, counts)
    for element in definition.iter("AngleBasis"):
        blocks = element.findall("AngleBasisBlock")
        if not blocks:
            continue
        edges: list[float] = []
        rings: list[int] = []
        for block in blocks:
            low, high = (_text(block.find(f".//{n}Theta")) for n in ("Lower", "Upper"))
            if not edges:
                edges.append(source.number(low, 0, "a bound of a patch"))
            edges.append(source.number(high, 0, "a bound of a patch"))
            rings.append(source.count(_text(block.find("nPhis")), 0, "nPhis", MOST_PATCHES))
        yield _text(element.find("AngleBasisName")), _basis(source, edges, rings)


def _matrix(
    source: Source,
    block: ElementTree.Element,
    content: str,
    rows: bool,
    bases: dict[str, Basis],
    words: list[str],
    more: dict[str, Any],
) -> Measurement:
    names = _text(block.find("ColumnAngleBasis")), _text(block.find("RowAngleBasis"))
    for name in names:
        if name not in bases:
            raise source.error(
                f"names the basis {name[:40]!r} without defining it; known are {', '.join(KLEMS)}."
            )
    entering, leaving = (bases[name] for name in names)
    numbers = (
        source.numbers(re.split(r"[\s,;]+", content.strip(" \r\n\t,;")), 0)
        if content.strip()
        else []
    )
    n_i, n_o = len(entering.theta), len(leaving.theta)
    if len(numbers) != n_i * n_o:
        raise source.error(
            f"{' '.join(words)} has {len(numbers)} numbers; {n_o} x {n_i} patches are announced."
        )
    matrix = np.array(numbers).reshape((n_i, n_o) if rows else (n_o, n_i))
    values = matrix if rows else matrix.T  # [in][out]
    through = words[0] == "transmission"
    wi = spherical(entering.theta, entering.phi + np.pi)
    wo = spherical(leaving.theta, leaving.phi) * [1, 1, -1 if through else 1]
    i, o = np.repeat(np.arange(n_i), n_o), np.tile(np.arange(n_o), n_i)
    return measurement(
        NAME,
        source.title,
        wi[i],
        wo[o],
        values.reshape(-1, 1),
        channels=("value",),
        isotropic=False,
        notes=(
            "averages over patches",
            "azimuths followed the light: half a turn was added to wi's",
        ),
        grid={"patches in": n_i, "patches out": n_o},
        interpolator=_Patches(entering, leaving, values),
        **more,
    )


class _Patches:
    """The value of the patches that directions are in."""

    def __init__(self, entering: Basis, leaving: Basis, values: Floats) -> None:
        self.entering, self.leaving, self.values = entering, leaving, values

    def __call__(self, wi: Floats, wo: Floats) -> tuple[Floats, Mask]:
        i = self.entering.find(*_angles(wi, np.pi))
        o = self.leaving.find(*_angles(wo * [1, 1, 1], 0.0))
        found = self.values[i, o]
        good = np.isfinite(found)
        return np.where(good, found, 0)[:, None], good


def _angles(w: Floats, turn: float) -> tuple[Floats, Floats]:
    theta = np.arctan2(np.hypot(w[:, 0], w[:, 1]), np.abs(w[:, 2]))
    return theta, (np.arctan2(w[:, 1], w[:, 0]) + turn) % (2 * np.pi)


# --- trees ---------------------------------------------------------------------------------------


def _tree(
    source: Source, content: str, dimensions: int, words: list[str], more: dict[str, Any]
) -> Measurement:
    corners, sizes, values = _leaves(source, content, dimensions)
    through = words[0] == "transmission"
    if dimensions == 3:
        # Only the lower half of the first axis means something
        use = corners[:, 0] < 0.5
        corners, sizes, values = corners[use], sizes[use], values[use]
        top = np.minimum(corners[:, 0] + sizes, 0.5)
        theta_i = np.arcsin(np.clip(1 - (corners[:, 0] + top), 0, 1))
        wi = spherical(theta_i, np.pi)
        wo = _on_disk(corners[:, 1:] + 0.5 * sizes[:, None])
    else:
        middle = corners + 0.5 * sizes[:, None]
        wi = _on_disk(middle[:, :2]) * [-1, -1, 1]
        wo = _on_disk(middle[:, 2:])
    if through:
        wo = wo * [1, 1, -1]
    return measurement(
        NAME,
        source.title,
        wi,
        wo,
        values[:, None],
        channels=("value",),
        isotropic=dimensions == 3,
        notes=(f"averages over {len(values)} leaves of a tree",),
        **more,
    )


def _leaves(source: Source, content: str, dimensions: int) -> tuple[Floats, Floats, Floats]:
    """Lower corners (n, dimensions), sizes (n,) and values (n,) of all leaves."""
    branches = 1 << dimensions
    offsets = np.array([[(n >> d) & 1 for d in range(dimensions)] for n in range(branches)], float)
    corners: list[Floats] = []
    sizes: list[Floats] = []
    values: list[Floats] = []
    total = 0

    def leaf(texts: list[str], corner: Floats, size: float) -> None:
        nonlocal total
        numbers = source.numbers(texts, 0)
        side = round(len(numbers) ** (1 / dimensions))
        if side**dimensions != len(numbers) or side & (side - 1):
            raise source.error(
                f"has a leaf of {len(numbers)} numbers; a power of {branches} is needed."
            )
        total += len(numbers)
        if total > MOST_LEAVES:
            raise source.error(f"has more than {MOST_LEAVES} leaves.")
        steps = np.stack(np.meshgrid(*[np.arange(side)] * dimensions, indexing="ij"), -1)
        corners.append(corner + steps.reshape(-1, dimensions) * (size / side))
        sizes.append(np.full(len(numbers), size / side))
        values.append(np.array(numbers))

    # Each open brace: its lower corner, its size, and how many of its branches are done
    stack: list[tuple[Floats, float, list[int]]] = []
    root = np.zeros(dimensions)
    done = False
    for match in re.finditer(r"[{}]|[^{}]+", content):
        token = match[0]
        if done and token.strip(" \r\n\t,"):
            raise source.error("has data behind its tree.")
        if token == "{":
            if len(stack) > DEEPEST_TREE:
                raise source.error(f"has a tree of more than {DEEPEST_TREE} levels.")
            corner, size = _branch(source, stack, offsets, root, branches)
            stack.append((corner, size, [0]))
        elif token == "}":
            if not stack:
                raise source.error("has a closing brace too many.")
            _, _, count = stack.pop()
            if count[0] not in {0, branches}:
                raise source.error(f"has a branch with {count[0]} parts; it needs {branches}.")
            done = not stack
        elif texts := re.split(r"[\s,]+", token.strip(" \r\n\t,")):
            if texts == [""]:
                continue
            if not stack:
                leaf(texts, root, 1.0)
                done = True
            elif stack[-1][2][0]:
                raise source.error("has numbers between the branches of its tree.")
            else:
                leaf(texts, stack[-1][0], stack[-1][1])
    if stack or not values:
        raise source.error("its tree is truncated.")
    return np.concatenate(corners), np.concatenate(sizes), np.concatenate(values)


def _branch(
    source: Source, stack: Any, offsets: Floats, root: Floats, branches: int
) -> tuple[Floats, float]:
    """The place of the brace that opens now, counted in the one around it."""
    if not stack:
        return root, 1.0
    corner, size, count = stack[-1]
    if count[0] >= branches:
        raise source.error(f"has a branch with more than {branches} parts.")
    place = corner + offsets[count[0]] * (0.5 * size)
    count[0] += 1
    return place, 0.5 * size


def _on_disk(square: Floats) -> Floats:
    """Directions whose projection is Shirley and Chiu's disk for places of the unit square (n, 2)."""
    a, b = 2 * square[:, 0] - 1, 2 * square[:, 1] - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        wide = np.abs(a) > np.abs(b)
        r = np.where(wide, a, b)
        phi = np.where(wide, 0.25 * np.pi * b / a, 0.5 * np.pi - 0.25 * np.pi * a / b)
    phi = np.where(r == 0, 0, phi)
    x, y = r * np.cos(phi), r * np.sin(phi)
    return np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], -1)
