"""Makes docs/images/conventions.svg: the directions, angles and frame of docs/conventions.md.

    python tools/make_conventions_drawing.py

The directions are real ones, seen by a parallel projection, so that angles and feet are where they belong.
"""

from __future__ import annotations

import math
from pathlib import Path

TARGET = Path(__file__).parents[1] / "docs" / "images" / "conventions.svg"

WIDTH, HEIGHT = 720, 460
ORIGIN = (350.0, 295.0)
SCALE = 235.0  # pixels of a unit vector

# The drawing's camera, in degrees: turned about the normal, and above the surface.
TURN, ABOVE = -62.0, 24.0

INK, FAINT, LIGHT, VIEWER, HALF = "#333333", "#888888", "#b26a00", "#0b5cad", "#5b3f99"
PAPER, GROUND = "#ffffff", "#e9ecef"

Vector = tuple[float, float, float]


def direction(theta: float, phi: float) -> Vector:
    """A unit vector by its polar angle and azimuth, in degrees."""
    t, p = math.radians(theta), math.radians(phi)
    return math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)


def place(v: Vector, size: float = 1.0) -> tuple[float, float]:
    """Pixels of a point in the local frame."""
    turn, above = math.radians(TURN), math.radians(ABOVE)
    x = v[0] * math.cos(turn) - v[1] * math.sin(turn)
    depth = v[0] * math.sin(turn) + v[1] * math.cos(turn)
    up = v[2] * math.cos(above) + depth * math.sin(above)
    return ORIGIN[0] + SCALE * size * x, ORIGIN[1] - SCALE * size * up


def path(points: list[tuple[float, float]], style: str, close: bool = False) -> str:
    """Lines between points."""
    joined = " L".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<path d="M{joined}{"Z" if close else ""}" {style}/>'


def arrow(v: Vector, colour: str, width: float = 2.5) -> list[str]:
    """From the origin to a point."""
    (x0, y0), (x1, y1) = ORIGIN, place(v)
    length = math.hypot(x1 - x0, y1 - y0)
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    neck = (x1 - 10 * ux, y1 - 10 * uy)
    head = [
        (x1, y1),
        (x1 - 14 * ux - 5 * uy, y1 - 14 * uy + 5 * ux),
        (x1 - 14 * ux + 5 * uy, y1 - 14 * uy - 5 * ux),
    ]
    return [
        path([(x0, y0), neck], f'stroke="{colour}" stroke-width="{width}" fill="none"'),
        path(head, f'fill="{colour}"', close=True),
    ]


def text(x: float, y: float, words: str, colour: str = INK, anchor: str = "start") -> str:
    """Words; an underscore lowers the letter behind it."""
    head, mark, rest = words.partition("_")
    inside = head
    if mark:
        inside += f'<tspan dy="5" font-size="12">{rest[0]}</tspan><tspan dy="-5">{rest[1:]}</tspan>'
    return f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">{inside}</text>'


def arc(start: Vector, end: Vector, size: float, colour: str) -> str:
    """Between two unit vectors, on the sphere."""
    cosine = sum(a * b for a, b in zip(start, end, strict=True))
    angle = math.acos(cosine)
    points = []
    for step in range(33):
        t = step / 32
        a, b = math.sin((1 - t) * angle), math.sin(t * angle)
        v = tuple((a * s + b * e) / math.sin(angle) for s, e in zip(start, end, strict=True))
        points.append(place(v, size))  # type: ignore[arg-type]
    return path(points, f'stroke="{colour}" fill="none" stroke-width="1.5"')


def drawing() -> str:
    """The whole picture."""
    normal, x_axis, y_axis = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    wi, wo = direction(48, 215), direction(36, 20)
    total = tuple(a + b for a, b in zip(wi, wo, strict=True))
    size = math.sqrt(sum(c * c for c in total))
    half: Vector = (total[0] / size, total[1] / size, total[2] / size)

    circle = [place(direction(90, a)) for a in range(0, 360, 4)]
    parts = [path(circle, f'fill="{GROUND}" stroke="{FAINT}"', close=True)]
    for axis, name in ((x_axis, "x (tangent)"), (y_axis, "y")):
        parts += arrow(axis, FAINT, 1.5)
        x, y = place(axis, 1.06)
        parts.append(text(x + 2, y + 6, name, FAINT))
    dashed = f'stroke="{FAINT}" stroke-dasharray="4 4" fill="none"'
    for v in (wi, wo):
        foot = place((v[0], v[1], 0.0))
        parts += [path([place(v), foot], dashed), path([ORIGIN, foot], dashed)]
    parts += [arc(normal, wi, 0.42, LIGHT), arc(normal, wo, 0.5, VIEWER)]
    parts.append(arc(x_axis, direction(90, 20), 0.6, VIEWER))
    for v, colour, width in (
        (normal, INK, 2.5),
        (half, HALF, 1.8),
        (wi, LIGHT, 3.0),
        (wo, VIEWER, 3.0),
    ):
        parts += arrow(v, colour, width)

    x, y = place(normal)
    parts.append(text(x, y - 10, "N = +z", INK, "middle"))
    x, y = place(half)
    parts.append(text(x - 6, y - 8, "wm", HALF, "end"))
    x, y = place(wi)
    parts += [
        text(x - 8, y - 24, "wi", LIGHT, "end"),
        text(x - 8, y - 6, "to the light", LIGHT, "end"),
    ]
    x, y = place(wo)
    parts += [text(x + 8, y - 8, "wo", VIEWER), text(x + 8, y + 10, "to the viewer", VIEWER)]
    x, y = place(direction(24, 215), 0.42)
    parts.append(text(x - 4, y - 6, "θ_i", LIGHT, "end"))
    x, y = place(direction(18, 20), 0.5)
    parts.append(text(x + 2, y - 6, "θ_o", VIEWER))
    x, y = place(direction(90, 10), 0.66)
    parts.append(text(x + 4, y + 6, "φ_o", VIEWER))
    parts += [
        text(14, HEIGHT - 34, "Both directions are unit vectors that leave the surface."),
        text(
            14, HEIGHT - 10, "eval(wi, wo): f in 1/sr, without cos θ_i. Known is wo, sampled is wi."
        ),
    ]
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
        f'height="{HEIGHT}" font-family="sans-serif" font-size="16">\n'
        f"<!-- made by tools/make_conventions_drawing.py -->\n"
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="{PAPER}"/>\n{body}\n</svg>\n'
    )


if __name__ == "__main__":
    TARGET.write_text(drawing(), encoding="utf-8")
    print(TARGET)
