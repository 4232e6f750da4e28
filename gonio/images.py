"""Picture files, read with care: numbers as they are stored, or one sentence on what is wrong.

OpenEXR's own library reads .exr, because channels, layers and windows are told apart there; Pillow reads
and checks the usual formats; Mitsuba reads Radiance's .hdr, .pfm, and .png of 16 bits, of which Pillow
keeps eight.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import struct
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.files import check_place, is_utf8, replacing

Pixels = NDArray[np.float32]
Matrix = NDArray[np.float64]

# What a picture may hold; above it a slip or an attack is likelier than a picture (16384 x 16384).
MAX_PIXELS = 1 << 28

LINEAR_FORMATS = (".exr", ".hdr", ".pfm")
CODED_FORMATS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".bmp", ".tga", ".ppm", ".pgm")
FORMATS = CODED_FORMATS + LINEAR_FORMATS


LUMINANCE = (0.2126, 0.7152, 0.0722)  # of linear sRGB, ITU-R BT.709


class ImageError(ValueError):
    """Why a picture file cannot be used; the caller knows which file it is and what it is for."""


@dataclass(frozen=True)
class Image:
    """A picture's numbers.

    pixels: (height, width, channels): 1 for grey, 3 for RGB, and one more where there is alpha.
    linear: whether colours are linear light, or (False) coded as sRGB, from 0 to 1.
    halves: whether numbers above 65504 were stored as infinite.
    rgb: linear sRGB where the file says that its numbers are of other primaries, (height, width, 3).
    """

    pixels: Pixels
    linear: bool
    halves: bool = False
    rgb: Pixels | None = None

    @property
    def colours(self) -> int:
        """1 for grey or 3 for RGB, without alpha."""
        return 1 if self.pixels.shape[2] <= 2 else 3

    def linear_rgb(self) -> Pixels:
        """Linear RGB of sRGB's primaries without alpha, (height, width, 3)."""
        if self.rgb is not None:
            return self.rgb
        rgb = self.pixels[..., : self.colours]
        if self.colours == 1:
            rgb = np.repeat(rgb, 3, axis=2)
        return rgb if self.linear else from_srgb(rgb)

    def channel(self, name: str) -> Pixels:
        """One channel ("r", "g", "b", "a"), or the "luminance" of the linear colours; (height, width).

        Raises:
            ImageError: the picture does not have it.
        """
        if name == "luminance":
            return np.asarray(self.linear_rgb() @ np.array(LUMINANCE, np.float32), np.float32)
        names = {1: "r", 2: "ra", 3: "rgb", 4: "rgba"}[self.pixels.shape[2]]
        if self.colours == 1 and name in "gb":
            raise ImageError(f"it is grey and has no channel {name}")
        if name not in names:
            raise ImageError(f"it has no channel {name}; it has {', '.join(names)}")
        return self.pixels[..., names.index(name)]


def from_srgb(coded: Pixels) -> Pixels:
    """Linear light of sRGB codes from 0 to 1 (IEC 61966-2-1)."""
    low = coded / np.float32(12.92)
    high = ((np.maximum(coded, 0) + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.asarray(np.where(coded <= 0.04045, low, high), np.float32)


# x and y of red, green, blue and white, ITU-R BT.709.
SRGB_CHROMATICITIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)  # cone responses, Lam 1985


def to_srgb_primaries(chromaticities: Sequence[float]) -> Matrix | None:
    """What takes linear RGB of these primaries to linear sRGB; None where they are sRGB's.

    White stays white (Bradford's adaptation), as renderers of such pictures show it.

    Args:
        chromaticities: x and y of red, green, blue and white.

    Raises:
        ImageError: they do not span a triangle.
    """
    if np.allclose(chromaticities, SRGB_CHROMATICITIES, atol=1e-3):
        return None
    try:
        theirs, ours = _to_xyz(chromaticities), _to_xyz(SRGB_CHROMATICITIES)
        cones = _BRADFORD @ ours.sum(axis=1) / (_BRADFORD @ theirs.sum(axis=1))
        adapted = np.linalg.solve(_BRADFORD, cones[:, None] * _BRADFORD) @ theirs
        change = np.linalg.solve(ours, adapted)
    except np.linalg.LinAlgError:
        change = np.full((3, 3), np.nan)
    if not np.isfinite(change).all():
        raise ImageError(f"its chromaticities are none: {tuple(map(float, chromaticities))}")
    return np.asarray(change, np.float64)


def _to_xyz(chromaticities: Sequence[float]) -> Matrix:
    """Columns: XYZ of red, green and blue, which add up to the white of luminance 1."""
    x, y = np.reshape(np.asarray(chromaticities, np.float64), (4, 2)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = np.stack([x / y, np.ones(4), (1 - x - y) / y])
    return np.asarray(columns[:, :3] * np.linalg.solve(columns[:, :3], columns[:, 3]))


def read_image(path: Path) -> Image:
    """Read a picture by its suffix.

    Raises:
        ImageError: it is not there, cut short, not a picture, too large, or of a kind that is not read.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ImageError(f"the name must end in {', '.join(FORMATS)}")
    if not path.is_file():
        raise ImageError("there is no such file" if not path.exists() else "it is not a file")
    try:
        if path.stat().st_size == 0:
            raise ImageError("it is an empty file")
        if suffix == ".exr":
            return _read_exr(path)
        if suffix in LINEAR_FORMATS:
            return _read_mitsuba(path)
        return _read_pillow(path)
    except ImageError:
        raise
    except MemoryError:
        raise ImageError("is it damaged? It asks for more memory than there is") from None
    except OSError as error:
        raise ImageError(error.strerror or f"is it damaged? {_short(error)}") from None
    except Exception as error:  # readers raise many types for damaged files
        raise ImageError(f"is it damaged? The reader says: {_short(error)}") from None


def _short(error: Exception) -> str:
    """The part of a reader's message that tells something, on one line."""
    text = " ".join(str(error).split()) or type(error).__name__
    return re.sub(r".*(?:Error while loading|bitmap)[^:]*: ", "", text).rstrip("!. ")


# ------------------------------------------------------------------------------------ usual formats


def _read_pillow(path: Path) -> Image:
    import PIL.Image
    from PIL import UnidentifiedImageError

    try:
        with _quiet(), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with PIL.Image.open(path) as picture:
                _check_size(*picture.size)
                picture.verify()  # a .png that is cut short is only found out here
            with PIL.Image.open(path) as picture:
                picture.load()
                return _pillow_pixels(picture, path)
    except UnidentifiedImageError:
        if kind := _tiff_kind(path):
            raise ImageError(
                f"it is a TIFF with {kind}, which is not read; save it as .exr, or with 8 or 16 bits"
            ) from None
        raise ImageError("it is not a picture of any kind that is known") from None
    except PIL.Image.DecompressionBombError:
        raise ImageError("is it damaged? It claims more pixels than a picture has") from None
    except (OSError, SyntaxError, struct.error) as error:
        raise ImageError(f"it is cut short or damaged ({_short(error)})") from None


def _pillow_pixels(picture: Any, path: Path) -> Image:
    mode = picture.mode
    if mode in ("CMYK", "YCbCr", "LAB", "HSV"):
        raise ImageError(
            f"its colours are {mode}, which mean nothing without a profile; save it in sRGB"
        )
    inverted = picture.format == "TIFF" and _tiff_is_inverted(picture.tag_v2)
    if mode in ("I;16", "I;16B", "I;16L", "I"):  # .pgm of 16 bits comes as I
        codes = np.asarray(picture, np.float32)[..., None] / np.float32(65535)
        return Image(1 - codes if inverted else codes, False)
    if mode == "F":
        return Image(np.asarray(picture, np.float32)[..., None], True)
    if path.suffix.lower() == ".png" and _png_depth(path) == 16:
        return Image(_read_mitsuba(path).pixels, False)
    alpha = mode in ("LA", "La", "RGBA", "RGBa", "PA") or "transparency" in picture.info
    grey = mode in ("1", "L", "LA", "La")
    wanted = ("LA" if alpha else "L") if grey else ("RGBA" if alpha else "RGB")
    codes = np.asarray(picture.convert(wanted), np.float32) / np.float32(255)
    rgb = None if grey else _by_profile(picture)
    return Image(codes if codes.ndim == 3 else codes[..., None], False, rgb=rgb)


_BITS, _PHOTOMETRIC, _PLANAR, _SAMPLE_FORMAT = 258, 262, 284, 339  # tags of TIFF 6.0
_SIGNED = 2


def _tiff_kind(path: Path) -> str:
    """What kind of TIFF it is, for people; empty if it is none."""
    from PIL import TiffImagePlugin

    with path.open("rb") as stream:
        head = stream.read(8)
        if head[:4] not in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
            return ""
        if b"+" in head[:4]:
            head += stream.read(8)
        try:
            tags = TiffImagePlugin.ImageFileDirectory_v2(head)
            stream.seek(tags.next)
            tags.load(stream)
            bits, formats = tags.get(_BITS, (1,)), tags.get(_SAMPLE_FORMAT, (1,))
        except (OSError, SyntaxError, struct.error, ValueError, KeyError):
            return "no list of tags that could be read"
    numbers = {1: "unsigned whole", 2: "signed whole", 3: "floating-point"}
    kinds = {
        f"{b}-bit {numbers.get(f, 'other')}"
        for b, f in zip(bits, formats * len(bits), strict=False)
    }
    return f"{len(bits)} channel{'s' * (len(bits) > 1)} of {' and '.join(sorted(kinds))} numbers"


def _tiff_is_inverted(tags: Any) -> bool:
    """Whether 0 is white and Pillow leaves it so; what it would read wrongly is refused."""
    bits = max(tags.get(_BITS, (1,)))
    formats = tags.get(_SAMPLE_FORMAT, (1,))
    if _SIGNED in formats or (bits == 32 and 1 in formats):
        kind = "signed" if _SIGNED in formats else "32-bit"
        raise ImageError(f"its numbers are {kind} integers; save it with 8 or 16 bits, or as .exr")
    if bits not in (1, 2, 4, 8, 16, 32):  # Pillow gives codes of 12 bits as if they were of 16
        raise ImageError(f"its numbers have {bits} bits; save it with 8 or 16 bits, or as .exr")
    if bits == 16 and tags.get(_PLANAR, 1) == 2:
        raise ImageError(
            "its channels lie apart from each other; save them interleaved, or as .png"
        )
    return bool(bits == 16 and tags.get(_PHOTOMETRIC, 1) == 0)


def _by_profile(picture: Any) -> Pixels | None:
    """Linear sRGB of a picture whose ICC profile says that its colours are others; None for sRGB."""
    profile = picture.info.get("icc_profile")
    if not profile:
        return None
    from PIL import ImageCms

    coded = picture.convert("RGB")
    try:
        theirs = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        ours = ImageCms.profileToProfile(coded, theirs, ImageCms.createProfile("sRGB"))
    except (ImageCms.PyCMSError, OSError):  # a damaged profile, or one of grey or print
        return None
    before, after = np.asarray(coded, np.int16), np.asarray(ours, np.int16)
    if abs(after - before).max() <= PROFILE_ROUNDING:
        return None
    return from_srgb(after.astype(np.float32) / np.float32(255))


# Profiles that say sRGB in their own words differ by so many codes of 255.
PROFILE_ROUNDING = 2


def _png_depth(path: Path) -> int:
    with path.open("rb") as stream:
        head = stream.read(25)
    return head[24] if len(head) == 25 else 0


def _check_size(width: int, height: int) -> None:
    if width < 1 or height < 1 or width * height > MAX_PIXELS:
        raise ImageError(
            f"is it damaged? It claims {width} x {height} pixels, more than the {MAX_PIXELS} that are read"
        )


_BEGINNINGS = {".hdr": (b"#?",), ".pfm": (b"PF", b"Pf")}


def _read_mitsuba(path: Path) -> Image:
    import mitsuba as mi

    with path.open("rb") as stream:
        head = stream.read(4096)
    suffix = path.suffix.lower()
    if suffix in _BEGINNINGS and not head.startswith(_BEGINNINGS[suffix]):
        raise ImageError(f"it is no {suffix} picture, whatever its name says")
    if suffix == ".hdr" and b"32-bit_rle_xyze" in head:
        raise ImageError("its colours are XYZ, not RGB; convert it with 'ra_xyze -r'")
    if size := re.search(rb"\n([-+][XY]) (\d+) ([-+][XY]) (\d+)\r?\n", head):
        if (size[1], size[3]) != (b"-Y", b"+X"):
            order = f"{size[1].decode()} {size[3].decode()}"
            raise ImageError(
                f"its pixels run {order}, not -Y +X, from the top left; save it again so"
            )
        _check_size(int(size[4]), int(size[2]))
    if is_utf8(path):
        bitmap = mi.Bitmap(str(path))
    else:
        stored = mi.MemoryStream()
        stored.write(path.read_bytes())
        stored.seek(0)
        bitmap = mi.Bitmap(stored)
    codes = np.array(bitmap)
    if codes.ndim == 2:
        codes = codes[..., None]
    scale = np.float32(1 / np.iinfo(codes.dtype).max) if codes.dtype.kind == "u" else np.float32(1)
    pixels = codes.astype(np.float32) * scale
    return _by_header(pixels, head) if suffix == ".hdr" else Image(pixels, True)


def _by_header(pixels: Pixels, head: bytes) -> Image:
    """A Radiance picture as its header says: without what its numbers were multiplied by, in sRGB.

    Ward, "The RADIANCE picture file format": EXPOSURE and COLORCORR add up by multiplication.
    """
    lines = head.replace(b"\r", b"").partition(b"\n\n")[0].decode("latin-1").splitlines()
    factor = np.ones(3)
    change = None
    for name, _, value in (line.partition("=") for line in lines):
        count = {"EXPOSURE": 1, "COLORCORR": 3, "PRIMARIES": 8}.get(name.strip())
        if count is None:
            continue
        try:
            numbers = np.array(value.split(), np.float64)
        except ValueError:
            numbers = np.array([])
        good = len(numbers) == count and np.isfinite(numbers).all()
        if not good or (count < 8 and not (numbers > 0).all()):
            raise ImageError(f"its header says {name.strip()}={value.strip()}, which means nothing")
        if count == 8:
            change = to_srgb_primaries(tuple(numbers))
        else:
            factor = factor * numbers
    pixels = (pixels / factor).astype(np.float32)
    rgb = None if change is None else (pixels @ change.T).astype(np.float32)
    return Image(pixels, True, rgb=rgb)


# ------------------------------------------------------------------------------------------ OpenEXR


def _read_exr(path: Path) -> Image:
    import OpenEXR

    with path.open("rb") as stream:
        if stream.read(4) != b"\x76\x2f\x31\x01":
            raise ImageError("it is not an OpenEXR file")
    source = str(path) if is_utf8(path) else io.BytesIO(path.read_bytes())
    for part in OpenEXR.File(source, header_only=True).parts:
        for window in ("dataWindow", "displayWindow"):
            low, high = part.header[window]
            _check_size(*(int(b) - int(a) + 1 for a, b in zip(low, high, strict=True)))
    if isinstance(source, io.BytesIO):
        source.seek(0)
    with _quiet():
        opened = OpenEXR.File(source, separate_channels=True)
    with opened as file:
        found = []
        layers: list[str] = []
        for part in file.parts:
            if "deep" in str(part.header.get("type", "")):
                raise ImageError("it holds deep pixels; flatten it")
            if not part.channels:  # the library only warns
                raise ImageError("it is cut short or damaged: its pixels cannot be read")
            chosen, others = _colour_channels([str(name) for name in part.channels])
            layers += others
            if chosen:
                found.append((part, chosen))
        if not found:
            seen = ", ".join(sorted(layers)) or ", ".join(file.parts[0].channels)
            raise ImageError(
                f"which of its channels are the picture is not clear: it has {seen}; "
                "save the one that is meant as R, G, B"
            )
        part, chosen = found[0]  # further parts are layers, or the other eye
        channels = [part.channels[name] for name in chosen]
        if any(c.xSampling != 1 or c.ySampling != 1 for c in channels):
            raise ImageError("its colours have less pixels than its brightness; save it as R, G, B")
        halves = all(c.pixels.dtype == np.float16 for c in channels)
        pixels = np.stack([np.asarray(c.pixels, np.float32) for c in channels], axis=-1)
        placed = _placed(pixels, part.header)
        primaries = part.header.get("chromaticities")
        change = None if primaries is None or len(chosen) < 3 else to_srgb_primaries(primaries)
        rgb = None if change is None else (placed[..., :3] @ change.T).astype(np.float32)
        return Image(placed, True, halves, rgb)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep libraries from writing about a damaged file; what is wrong is told by an exception."""
    with open(os.devnull, "w") as nowhere:  # noqa: SIM117
        with contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
            try:
                kept = os.dup(2)
            except OSError:  # a program without a terminal may have closed it
                yield
                return
            os.dup2(nowhere.fileno(), 2)
            try:
                yield
            finally:
                os.dup2(kept, 2)
                os.close(kept)


def _colour_channels(names: list[str]) -> tuple[list[str], list[str]]:
    """The channels of the picture among all, and else the layers among which a choice is needed."""
    by_layer: dict[str, dict[str, str]] = {}
    for name in names:
        layer, _, channel = name.rpartition(".")
        by_layer.setdefault(layer, {})[channel.upper()] = name
    coloured = {
        layer: [channels[c] for c in "RGBA" if c in channels]
        for layer, channels in by_layer.items()
        if {"R", "G", "B"} <= set(channels)
    }
    if "" in coloured:
        return coloured[""], []
    if len(coloured) == 1:
        return next(iter(coloured.values())), []
    root = by_layer.get("", {})
    if not coloured and "Y" in root and not {"RY", "BY", "X", "Z"} & set(root):
        return [root["Y"]], []
    if len(names) == 1:
        return names, []
    return [], list(coloured) or names


def _placed(pixels: Pixels, header: dict[str, Any]) -> Pixels:
    """The picture in its display window: black where there are no data, without what lies outside."""
    (x0, y0), (x1, y1) = (map(int, corner) for corner in header["displayWindow"])
    (left, top), (right, bottom) = (map(int, corner) for corner in header["dataWindow"])
    if (left, top, right, bottom) == (x0, y0, x1, y1):
        return pixels
    result = np.zeros((y1 - y0 + 1, x1 - x0 + 1, pixels.shape[2]), np.float32)
    low_x, high_x = max(left, x0), min(right, x1) + 1
    low_y, high_y = max(top, y0), min(bottom, y1) + 1
    if low_x < high_x and low_y < high_y:
        result[low_y - y0 : high_y - y0, low_x - x0 : high_x - x0] = pixels[
            low_y - top : high_y - top, low_x - left : high_x - left
        ]
    return result


def write_linear(path: Path, pixels: NDArray[Any], *, half: bool = False) -> None:
    """Write numbers, (height, width) or (height, width, channels): .exr of float32 or `half`, or .hdr."""
    import mitsuba as mi

    # By way of memory: Mitsuba opens no files whose names are not UTF-8.
    stored = mi.MemoryStream()
    bitmap = mi.Bitmap(np.ascontiguousarray(pixels, np.float32))
    if half:
        bitmap = bitmap.convert(component_format=mi.Struct.Type.Float16)
    formats = {".exr": mi.Bitmap.FileFormat.OpenEXR, ".hdr": mi.Bitmap.FileFormat.RGBE}
    bitmap.write(stored, formats[path.suffix.lower()])
    path.write_bytes(stored.raw_buffer())


# How many the whole numbers of a picture of tables have.
BITS = (8, 16)


def codes_of(values: NDArray[Any], bits: int) -> NDArray[Any]:
    """Numbers from 0 to 1 as whole ones of 8 or 16 bits, the largest of which is 1."""
    kind = np.uint8 if bits == 8 else np.uint16
    return np.asarray(np.rint(np.clip(values, 0, 1) * np.iinfo(kind).max), kind)


def png_of_codes(codes: NDArray[Any]) -> bytes:
    """Whole numbers of 8 or 16 bits as a .png has them, grey (height, width) or RGB (height, width, 3)."""
    import mitsuba as mi

    kind = mi.Struct.Type.UInt8 if codes.dtype == np.uint8 else mi.Struct.Type.UInt16
    form = mi.Bitmap.PixelFormat.Y if codes.ndim == 2 else mi.Bitmap.PixelFormat.RGB
    picture = mi.Bitmap(np.ascontiguousarray(codes))
    picture.set_srgb_gamma(False)
    # By way of memory: Mitsuba opens no files whose names are not UTF-8.
    stored = mi.MemoryStream()
    picture.convert(form, kind, False).write(stored, mi.Bitmap.FileFormat.PNG)
    return bytes(stored.raw_buffer())


def write_codes(path: str | Path, codes: NDArray[Any]) -> None:
    """Write whole numbers of 8 or 16 bits as a .png, grey (height, width) or RGB (height, width, 3).

    Raises:
        ValueError: another suffix.
        FileNotFoundError: the folder does not exist.
    """
    path = Path(path)
    if path.suffix.lower() != ".png":
        raise ValueError(f"cannot write {path.name!r}; the suffix must be .png.")
    check_place(path)
    with replacing(path) as temporary:
        temporary.write_bytes(png_of_codes(codes))
