"""Picture files: what they hold, or one sentence on what is wrong with them."""

from __future__ import annotations

import os
import struct
import sys
import zlib
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import OpenEXR
import pytest
from PIL import Image
from support.tolerances import SINGLE, SINGLE_LONG, decimals

from gonio.images import ImageError, read_image, write_linear


def exr(path: Path, channels: dict[str, Any], **header: Any) -> Path:
    start = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    # Arrays of their own: the library keeps names with arrays that it has written before.
    own = {name: values.copy() for name, values in channels.items()}
    OpenEXR.File({**start, **header}, own).write(str(path))
    return path


def plane(value: float, shape: tuple[int, int] = (2, 4), kind: Any = np.float32) -> Any:
    return np.full(shape, value, kind)


RGB = {"R": plane(0.25), "G": plane(0.5), "B": plane(0.75)}


# ---------------------------------------------------------------------------------------- OpenEXR


@pytest.mark.parametrize(
    "channels",
    [
        RGB,
        RGB | {"Z": plane(9), "id": np.ones((2, 4), np.uint32), "diffuse.R": plane(7)},
        {f"beauty.{c}": p for c, p in RGB.items()},
        {c.lower(): p for c, p in RGB.items()},
        {c: p.astype(np.float16) for c, p in RGB.items()},
    ],
    ids=["plain", "more channels", "one layer", "lower case", "half"],
)
def test_the_colours_are_found_among_all_channels(tmp_path: Path, channels: Any) -> None:
    image = read_image(exr(tmp_path / "a.exr", channels))
    np.testing.assert_array_equal(image.pixels, np.full((2, 4, 3), [0.25, 0.5, 0.75]))
    assert image.linear


def test_one_channel_is_grey_and_alpha_is_apart(tmp_path: Path) -> None:
    image = read_image(exr(tmp_path / "y.exr", {"Y": plane(0.5)}))
    np.testing.assert_array_equal(image.linear_rgb(), np.full((2, 4, 3), 0.5))
    image = read_image(exr(tmp_path / "a.exr", RGB | {"A": plane(0.125)}))
    assert image.colours == 3
    np.testing.assert_array_equal(image.channel("a"), 0.125)


def test_layers_among_which_a_choice_is_needed_are_named(tmp_path: Path) -> None:
    channels = {f"{layer}.{c}": p for layer in ("diffuse", "coat") for c, p in RGB.items()}
    with pytest.raises(ImageError, match="not clear: it has coat, diffuse"):
        read_image(exr(tmp_path / "a.exr", channels))
    with pytest.raises(ImageError, match="not clear: it has"):
        read_image(exr(tmp_path / "b.exr", {"N.X": plane(0), "N.Y": plane(0)}))


def test_a_data_window_is_placed_in_the_display_window(tmp_path: Path) -> None:
    low = np.array([1, 1], np.int32)
    window = {
        "dataWindow": (low, low + np.array([3, 1], np.int32)),
        "displayWindow": (np.zeros(2, np.int32), np.array([5, 2], np.int32)),
    }
    image = read_image(exr(tmp_path / "a.exr", RGB, **window))
    expected = np.zeros((3, 6, 3), np.float32)
    expected[1:3, 1:5] = [0.25, 0.5, 0.75]
    np.testing.assert_array_equal(image.pixels, expected)
    window["displayWindow"] = (np.array([2, 0], np.int32), np.array([3, 1], np.int32))
    image = read_image(exr(tmp_path / "b.exr", RGB, **window))  # data outside of what is shown
    assert image.pixels.shape == (2, 2, 3)
    np.testing.assert_array_equal(image.pixels[:, 0, 0], [0, 0.25])


# ---------------------------------------------------------------------------------- usual formats


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp", ".bmp", ".tga", ".ppm"])
def test_usual_formats_are_the_same_numbers(tmp_path: Path, suffix: str) -> None:
    codes = np.array([[[255, 128, 0], [10, 20, 30]]], np.uint8).repeat(4, axis=0)
    lossless = {"lossless": True} if suffix == ".webp" else {}
    Image.fromarray(codes).save(tmp_path / f"a{suffix}", **lossless)
    image = read_image(tmp_path / f"a{suffix}")
    assert not image.linear
    np.testing.assert_allclose(image.pixels, codes / 255, atol=SINGLE)
    # IEC 61966-2-1: code 128 is linear 0.21586
    assert image.linear_rgb()[0, 0, 1] == pytest.approx(0.21586, abs=SINGLE_LONG)


def test_palettes_grey_alpha_and_sixteen_bits_are_read(tmp_path: Path) -> None:
    colour = Image.new("RGB", (3, 2), (255, 0, 51))
    colour.quantize().save(tmp_path / "p.png")
    np.testing.assert_allclose(
        read_image(tmp_path / "p.png").pixels[0, 0], [1, 0, 0.2], atol=SINGLE
    )
    Image.new("L", (3, 2), 51).save(tmp_path / "l.png")
    assert read_image(tmp_path / "l.png").pixels.shape == (2, 3, 1)
    Image.new("LA", (3, 2), (51, 102)).save(tmp_path / "la.png")
    assert read_image(tmp_path / "la.png").channel("a")[0, 0] == pytest.approx(0.4)
    values = np.array([[0, 1, 65535]], np.uint16)
    Image.fromarray(values).save(tmp_path / "g16.png")
    np.testing.assert_allclose(read_image(tmp_path / "g16.png").pixels[0, :, 0], values[0] / 65535)
    mi.Bitmap(values[..., None].repeat(3, axis=2)).write(str(tmp_path / "rgb16.png"))
    read = read_image(tmp_path / "rgb16.png")
    np.testing.assert_allclose(read.pixels[0, :, 1], values[0] / 65535, atol=SINGLE)
    assert not read.linear


def test_channels_are_taken_by_name_or_missed_by_name(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2), (0, 51, 102)).save(tmp_path / "a.png")
    image = read_image(tmp_path / "a.png")
    assert image.channel("g")[0, 0] == pytest.approx(0.2)
    # BT.709 luminance of the linear colours
    linear = [0, ((0.2 + 0.055) / 1.055) ** 2.4, ((0.4 + 0.055) / 1.055) ** 2.4]
    assert image.channel("luminance")[0, 0] == pytest.approx(
        np.dot([0.2126, 0.7152, 0.0722], linear), rel=SINGLE_LONG
    )
    with pytest.raises(ImageError, match="no channel a; it has r, g, b"):
        image.channel("a")
    Image.new("L", (2, 2)).save(tmp_path / "l.png")
    with pytest.raises(ImageError, match="it is grey"):
        read_image(tmp_path / "l.png").channel("g")


# ------------------------------------------------------------------------------------ what is wrong


def png(width: int, height: int, data: bytes) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    ("name", "make", "reason"),
    [
        ("none.png", None, "there is no such file"),
        ("empty.png", lambda: b"", "an empty file"),
        ("text.png", lambda: b"just some words", "not a picture"),
        (
            "bomb.png",
            lambda: png(100_000, 100_000, b""),
            "laims more pixels|laims 100000 x 100000",
        ),
        ("bomb.exr", "huge window", "laims 1000000 x 1000000"),
        ("text.exr", lambda: b"just some words", "not an OpenEXR file"),
        ("text.hdr", lambda: b"just some words", "it is no .hdr picture"),
        ("bomb.hdr", lambda: b"#?RADIANCE\n\n-Y 1000000 +X 2000000\n", "laims 2000000 x 1000000"),
        ("a.gif", lambda: b"GIF89a", "must end in"),
        ("cut.exr", "cut", "cut short or damaged|is it damaged"),
    ],
)
def test_what_is_wrong_is_one_sentence(tmp_path: Path, name: str, make: Any, reason: str) -> None:
    path = tmp_path / name
    if make == "cut":
        noise = np.random.default_rng(0).random((64, 64)).astype(np.float32)
        exr(path, dict.fromkeys("RGB", noise))
        path.write_bytes(path.read_bytes()[:-2000])
    elif make == "huge window":
        exr(path, RGB)
        size = struct.pack("<4i", 0, 0, 999_999, 999_999)
        path.write_bytes(path.read_bytes().replace(struct.pack("<4i", 0, 0, 3, 1), size))
    elif make is not None:
        path.write_bytes(make())
    with pytest.raises(ImageError, match=reason) as error:
        read_image(path)
    assert "\n" not in str(error.value)


def test_a_tiff_of_twelve_bits_is_not_read_as_one_of_sixteen(tmp_path: Path) -> None:
    """Two white pixels of 12 bits are three bytes: 0xfff and 0xfff."""
    path = tiff(tmp_path / "a.tif", np.full((1, 3), 255, "u1"))
    content = bytearray(path.read_bytes())
    for tag, value in ((256, 2), (258, 12)):  # width, bits
        at = content.index(struct.pack("<HH", tag, 4)) + 8
        content[at : at + 4] = struct.pack("<I", value)
    path.write_bytes(content)
    with pytest.raises(ImageError, match="12 bits"):
        read_image(path)


@pytest.mark.parametrize(("kind", "suffix"), [("RGB", ".png"), ("RGB", ".jpg"), ("L", ".tif")])
@pytest.mark.parametrize("share", [0.3, 0.9])
def test_files_that_are_cut_short_are_found_out(
    tmp_path: Path, kind: str, suffix: str, share: float
) -> None:
    shape = (32, 32, 3) if kind == "RGB" else (32, 32)
    noise = np.random.default_rng(1).integers(0, 255, shape).astype(np.uint8)
    path = tmp_path / f"a{suffix}"
    Image.fromarray(noise).save(path)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with pytest.raises(ImageError, match=r"cut short or damaged|not a picture"):
        read_image(path)


def test_colours_for_print_are_refused(tmp_path: Path) -> None:
    Image.new("CMYK", (4, 4), (0, 99, 0, 0)).save(tmp_path / "a.jpg")
    with pytest.raises(ImageError, match=r"colours are CMYK.*save it in sRGB"):
        read_image(tmp_path / "a.jpg")


def test_a_damaged_picture_leaves_the_terminal_quiet(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    noise = np.random.default_rng(0).random((64, 64)).astype(np.float32)
    path = exr(tmp_path / "a.exr", dict.fromkeys("RGB", noise))
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(ImageError):
        read_image(path)
    assert capfd.readouterr() == ("", "")


# ------------------------------------------------------------------------- numbers that mean others


def tiff(path: Path, values: Any, photometric: int = 1, planar: int = 1) -> Path:
    """A TIFF of one strip (or one for each channel), as TIFF 6.0 describes it."""
    grey = values.ndim == 2
    samples = 1 if grey else values.shape[2]
    height, width = values.shape[:2]
    data = (values if planar == 1 else np.moveaxis(values, 2, 0)).tobytes()
    strips = samples if planar == 2 else 1
    form = {"u": 1, "i": 2, "f": 3}[values.dtype.kind]
    entries = [(256, width), (257, height), (258, [values.itemsize * 8] * samples), (259, 1)]
    entries += [(262, photometric), (273, None), (277, samples), (278, height)]
    entries += [(279, [len(data) // strips] * strips), (284, planar), (339, [form] * samples)]
    start = 8 + 2 + 12 * len(entries) + 4
    room = 4 * 8 * len(entries)
    entries[5] = (273, [start + room + k * (len(data) // strips) for k in range(strips)])
    table, extra = struct.pack("<H", len(entries)), b""
    for tag, value in entries:
        numbers = value if isinstance(value, list) else [value]
        packed = struct.pack(f"<{len(numbers)}I", *numbers)
        if len(packed) > 4:
            packed, extra = struct.pack("<I", start + len(extra)), extra + packed
        table += struct.pack("<HHI", tag, 4, len(numbers)) + packed
    head = b"II*\0" + struct.pack("<I", 8) + table + b"\0\0\0\0"
    path.write_bytes(head + extra.ljust(room, b"\0") + data)
    return path


RAMP = np.linspace(0, 1, 8).reshape(2, 4)


@pytest.mark.parametrize(
    ("values", "photometric", "expected"),
    [
        ((RAMP * 65535).astype("<u2"), 1, RAMP),
        ((RAMP * 65535).astype("<u2"), 0, 1 - RAMP),  # 0 is white
        ((RAMP * 255).astype("u1"), 0, 1 - RAMP),
        (RAMP.astype("<f4"), 1, RAMP),
    ],
)
def test_tiff_is_grey_from_black_to_white(tmp_path: Path, values, photometric, expected) -> None:
    image = read_image(tiff(tmp_path / "a.tif", values, photometric))
    # By 8 bits, cut and not rounded.
    np.testing.assert_allclose(image.pixels[..., 0], expected, atol=1 / 255)


@pytest.mark.parametrize(
    ("values", "planar", "reason"),
    [
        ((RAMP * 32767).astype("<i2"), 1, "signed integers"),
        ((RAMP * 2**31).astype("<u4"), 1, "32-bit integers"),
        ((RAMP * 2**30).astype("<i4"), 1, "signed integers"),
        ((np.stack([RAMP] * 3, -1) * 65535).astype("<u2"), 2, "lie apart"),
        (np.stack([RAMP] * 3, -1).astype("<f4"), 1, "3 channels of 32-bit floating-point numbers"),
        (np.stack([RAMP] * 4, -1).astype("<f8"), 1, "4 channels of 64-bit floating-point numbers"),
        (RAMP.astype("<u8"), 1, "1 channel of 64-bit unsigned whole numbers"),
    ],
)
def test_a_tiff_that_would_be_read_wrongly_is_refused(tmp_path, values, planar, reason) -> None:
    with pytest.raises(ImageError, match=reason):
        read_image(tiff(tmp_path / "a.tif", values, 1 if values.ndim == 2 else 2, planar))


def hdr(path: Path, *lines: str, end: str = "\n") -> Path:
    """A picture of 4 x 2 pixels of (1, 0.5, 0.25), without run lengths, and these lines of its header."""
    head = ["#?RADIANCE", "FORMAT=32-bit_rle_rgbe", *lines, "", "-Y 2 +X 4"]
    path.write_bytes(end.join(head).encode() + end.encode() + bytes([128, 64, 32, 129]) * 8)
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_what_a_radiance_picture_was_multiplied_by_is_taken_out(tmp_path: Path, end: str) -> None:
    lines = ("# EXPOSURE=7", "EXPOSURE=2", "SOFTWARE=none", "EXPOSURE= 0.25", "COLORCORR=1 2 4")
    image = read_image(hdr(tmp_path / "a.hdr", *lines, end=end))
    np.testing.assert_allclose(image.pixels, np.full((2, 4, 3), (2, 0.5, 0.125)), rtol=SINGLE)
    plain = read_image(hdr(tmp_path / "b.hdr"))
    np.testing.assert_allclose(plain.linear_rgb(), np.full((2, 4, 3), (1, 0.5, 0.25)), rtol=SINGLE)


def test_a_radiance_picture_of_other_primaries_becomes_srgb(tmp_path: Path) -> None:
    line = "PRIMARIES= 0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290"
    image = read_image(hdr(tmp_path / "a.hdr", line))
    expected = (1.6605 - 0.5876 / 2 - 0.0728 / 4, -0.1246 + 1.1329 / 2 - 0.0083 / 4)  # BT.2087-0
    np.testing.assert_allclose(image.linear_rgb()[0, 0, :2], expected, atol=2e-4)


@pytest.mark.parametrize(
    "line", ["EXPOSURE=0", "EXPOSURE=-1", "EXPOSURE=", "COLORCORR=1 2", "EXPOSURE=nan"]
)
def test_a_header_that_means_nothing_is_refused(tmp_path: Path, line: str) -> None:
    with pytest.raises(ImageError, match=f"its header says {line}, which means nothing"):
        read_image(hdr(tmp_path / "a.hdr", line))


def test_xyz_is_not_taken_for_grey(tmp_path: Path) -> None:
    channels = {"X": plane(0.1), "Y": plane(0.2), "Z": plane(0.3)}
    with pytest.raises(ImageError, match="X, Y, Z; save the one that is meant as R, G, B"):
        read_image(exr(tmp_path / "a.exr", channels))


REC_2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)
ACES_CG = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767)


@pytest.mark.parametrize(
    ("primaries", "expected"),
    [
        # ITU-R BT.2087-0, and what the Academy's transforms have for AP1 to BT.709 with D65.
        (
            REC_2020,
            [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]],
        ),
        (
            ACES_CG,
            [[1.7051, -0.6218, -0.0833], [-0.1303, 1.1408, -0.0105], [-0.0240, -0.1290, 1.1530]],
        ),
    ],
)
def test_colours_of_wider_primaries_become_those_of_srgb(tmp_path, primaries, expected) -> None:
    image = read_image(exr(tmp_path / "a.exr", RGB, chromaticities=primaries))
    wanted = np.array(expected) @ [0.25, 0.5, 0.75]
    np.testing.assert_allclose(image.linear_rgb()[0, 0], wanted, atol=1.5 * decimals(4))
    np.testing.assert_array_equal(image.channel("r"), 0.25)  # data stay as they are stored


def test_stated_srgb_primaries_change_nothing(tmp_path: Path) -> None:
    image = read_image(
        exr(
            tmp_path / "a.exr",
            RGB,
            chromaticities=(0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
        )
    )
    assert image.rgb is None
    with pytest.raises(ImageError, match="its chromaticities are none"):
        read_image(exr(tmp_path / "b.exr", RGB, chromaticities=(0.3,) * 8))


def test_a_colour_profile_is_honoured_for_colours_and_not_for_numbers(tmp_path: Path) -> None:
    from PIL import ImageCms

    own = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    # The same profile with red and green exchanged: tag names stand in its directory.
    swapped = own.replace(b"rXYZ", b"????").replace(b"gXYZ", b"rXYZ").replace(b"????", b"gXYZ")
    picture = Image.new("RGB", (4, 2), (200, 100, 20))
    picture.save(tmp_path / "own.png", icc_profile=own)
    picture.save(tmp_path / "swapped.png", icc_profile=swapped)
    picture.save(tmp_path / "none.png", icc_profile=b"nonsense")
    plain, other = read_image(tmp_path / "own.png"), read_image(tmp_path / "swapped.png")
    assert plain.rgb is None
    assert read_image(tmp_path / "none.png").rgb is None
    # Columns of a profile are numbers with 16 bits after the point: 1.5e-5 each, and they are inverted
    np.testing.assert_allclose(
        other.linear_rgb()[0, 0],
        plain.linear_rgb()[0, 0][[1, 0, 2]],
        atol=1e-3,
    )
    assert other.channel("r")[0, 0] == pytest.approx(200 / 255)


@pytest.mark.parametrize("name", ["photo.hdr", "photo.pfm", "photo.exr"])
def test_a_photograph_renamed_to_a_format_of_light_is_found_out(tmp_path: Path, name: str) -> None:
    Image.new("RGB", (4, 2)).save(tmp_path / name, format="JPEG")
    with pytest.raises(ImageError, match=r"whatever its name says|not an OpenEXR"):
        read_image(tmp_path / name)


@pytest.mark.parametrize("order", ["+Y 2 +X 4", "-Y 2 -X 4", "+X 4 -Y 2"])
def test_a_radiance_picture_in_another_order_is_refused_and_not_called_damaged(
    tmp_path, order
) -> None:
    path = tmp_path / "a.hdr"
    path.write_bytes(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{order}\n".encode() + b"\x80" * 32)
    with pytest.raises(ImageError, match=r"its pixels run .*, not -Y \+X"):
        read_image(path)


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes on Linux")
@pytest.mark.parametrize("suffix", [".exr", ".hdr", ".png"])
def test_names_that_are_not_utf8_are_read_and_written(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / os.fsdecode(b"caf\xe9" + suffix.encode())
    if suffix == ".png":
        Image.new("RGB", (4, 2), (51, 51, 51)).save(path)
    else:
        write_linear(path, np.full((2, 4, 3), 0.5, np.float32))
    expected = 0.2 if suffix == ".png" else 0.5
    np.testing.assert_allclose(read_image(path).pixels, expected, rtol=SINGLE)
