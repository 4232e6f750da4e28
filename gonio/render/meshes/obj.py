"""Wavefront OBJ: polygons whose corners have their own uv and normal.

Read as "Object Files (.obj)" of the Advanced Visualizer manual says: lines may go on behind a
backslash and be indented, indices count from 1 or back from the last one, comments start with #.
Materials, groups, smoothing groups, points, lines and free-form surfaces are passed over.
"""

from __future__ import annotations

import numpy as np

from gonio.render.meshes.polygons import MISSING, Polygons
from gonio.render.triangles import Floats, Ints

_WIDTHS = {b"v": 3, b"vt": 2, b"vn": 3}
_KINDS = (b"v", b"vt", b"vn")


def read_obj(data: bytes) -> Polygons:
    """The polygons of an OBJ file.

    Raises:
        ValueError: a line that cannot be read, with its number.
    """
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n").removeprefix(b"\xef\xbb\xbf")
    values: dict[bytes, list[bytes]] = {kind: [] for kind in _KINDS}
    lines: dict[bytes, list[int]] = {kind: [] for kind in (*_KINDS, b"f")}
    faces: list[bytes] = []
    seen: list[tuple[int, int, int, int]] = []  # how many v, vt, vn there were from which face on
    begun = b""  # what stands before a backslash at the end of a line
    for number, end in enumerate(
        (*text.split(b"\n"), b""), 1
    ):  # what the last line begins is ended
        line = begun + end.partition(b"#")[0].rstrip() if b"#" in end else begun + end.rstrip()
        if line.endswith(b"\\") and _goes_on(line):
            begun = line[:-1] + b" "
            continue
        begun = b""
        word, _, rest = line.strip().partition(b" ")
        if b"\t" in word:
            word, rest = line.split(None, 1)
        if word in values:
            values[word].append(rest)
            lines[word].append(number)
        elif word in (b"f", b"fo"):
            counts = len(values[b"v"]), len(values[b"vt"]), len(values[b"vn"])
            if not seen or seen[-1][1:] != counts:
                seen.append((len(faces), *counts))
            faces.append(rest)
            lines[b"f"].append(number)
    tables = {kind: _table(kind, values[kind], lines[kind]) for kind in _KINDS}
    sizes, indices = _corners(faces, lines[b"f"], seen)
    indices = _checked(indices, sizes, lines[b"f"], [len(tables[kind]) for kind in _KINDS])
    uvs = tables[b"vt"] if (indices[:, 1] != MISSING).any() else None
    normals = tables[b"vn"] if (indices[:, 2] != MISSING).any() else None
    return Polygons(
        tables[b"v"],
        sizes,
        indices[:, 0],
        uvs,
        None if uvs is None else indices[:, 1],
        normals,
        None if normals is None else indices[:, 2],
    )


def _goes_on(line: bytes) -> bool:
    """Whether a backslash at the end of a line joins the next one to it.

    It does so for numbers only: comments, and names of files and groups, end in one for other reasons
    (C:\\models\\), and would swallow a vertex.
    """
    word = line.split(None, 1)[0].rstrip(b"\\")
    return word in _WIDTHS or word in (b"f", b"fo")


def _table(kind: bytes, rows: list[bytes], lines: list[int]) -> Floats:
    """The first numbers of each row; a colour or a weight behind them is passed over."""
    width = _WIDTHS[kind]
    tokens = b" ".join(rows).split()
    if len(tokens) == width * len(rows):
        try:
            table = np.array(tokens, dtype="S").astype(np.float64).reshape(-1, width)
        except ValueError:
            pass
        else:
            # Every row must have its own numbers, not only all rows together.
            if all(len(row.split()) == width for row in rows):
                return np.asarray(table)
    result = np.zeros((len(rows), width))
    for place, (row, number) in enumerate(zip(rows, lines, strict=True)):
        words = row.split()[:width]
        if kind == b"vt" and len(words) == 1:
            words.append(b"0")  # a picture along a curve
        try:
            if len(words) < width:
                raise ValueError
            result[place] = [float(word) for word in words]
        except ValueError:
            shown = (kind + b" " + row)[:40].decode("utf-8", "replace")
            raise ValueError(f"line {number}: could not read {shown!r}") from None
    return result


def _corners(
    faces: list[bytes], lines: list[int], seen: list[tuple[int, int, int, int]]
) -> tuple[Ints, Ints]:
    """Corners of each face, and the indices (C, 3) of v, vt and vn, from 0; MISSING for none."""
    words = [face.split() for face in faces]
    sizes = np.array([len(w) for w in words], np.int64)
    tokens = [token for w in words for token in w]
    indices = np.full((len(tokens), 3), MISSING, np.int64)
    if not tokens:
        return sizes, indices
    face = np.repeat(np.arange(len(sizes)), sizes)
    given = np.zeros((len(tokens), 3), np.int64)  # 0 is never an index
    slashes, doubles = {t.count(b"/") for t in tokens}, {b"//" in t for t in tokens}
    columns = {0: [0], 1: [0, 1], 2: [0, 2] if doubles == {True} else [0, 1, 2]}
    try:
        if len(slashes) != 1 or len(doubles) != 1:
            raise ValueError
        chosen = columns[slashes.pop()]
        flat = b" ".join(tokens).replace(b"//", b" ").replace(b"/", b" ").split()
        numbers = np.array(flat, dtype="S").astype(np.int64).reshape(len(tokens), len(chosen))
        given[:, chosen] = numbers
        missing = np.ones(3, bool)
        missing[chosen] = False
        absent = np.broadcast_to(missing, given.shape)
    except (ValueError, KeyError, OverflowError):  # corners of different kinds, or a slip
        absent = np.ones(given.shape, bool)
        for place, token in enumerate(tokens):
            parts = token.split(b"/")
            try:
                if len(parts) > 3 or not parts[0]:
                    raise ValueError
                for column, part in enumerate(parts):
                    if part:
                        given[place, column] = int(part)
                        absent[place, column] = False
            except (ValueError, OverflowError):
                shown = token[:20].decode("utf-8", "replace")
                raise ValueError(
                    f"line {lines[face[place]]}: could not read the corner {shown!r} of a face"
                ) from None
    zero = (given == 0) & ~absent
    if zero.any():
        place = int(np.argmax(zero.any(axis=1)))
        raise ValueError(f"line {lines[face[place]]}: an index is 0; OBJ counts from 1")
    starts = np.array([row[0] for row in seen])
    counts = np.array([row[1:] for row in seen])
    there = counts[np.searchsorted(starts, face, side="right") - 1]
    from_zero = np.where(given > 0, given - 1, there + given)
    # An index that counts back past the first one stays out of bounds, and is not MISSING.
    from_zero = np.where((given < 0) & (from_zero < 0), np.iinfo(np.int64).max, from_zero)
    indices = np.where(absent, MISSING, from_zero)
    return sizes, indices


def _checked(indices: Ints, sizes: Ints, lines: list[int], counts: list[int]) -> Ints:
    """The indices, or an error with the line in which one is not there."""
    if not len(indices):
        return indices
    for column, what in ((1, "texture coordinate"), (2, "normal")):
        if counts[column] == 0:
            indices[:, column] = MISSING  # some programs write the index of what they leave out
            continue
        _check(indices[:, column], counts[column], what, sizes, lines)
    _check(indices[:, 0], counts[0], "vertex", sizes, lines)
    return indices


def _check(index: Ints, count: int, what: str, sizes: Ints, lines: list[int]) -> None:
    wrong = index >= count
    if wrong.any():
        place = int(np.argmax(wrong))
        face = int(np.repeat(np.arange(len(sizes)), sizes)[place])
        raise ValueError(
            f"line {lines[face]}: a face has a {what} that is not there (there are {count})"
        )
