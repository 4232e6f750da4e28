"""Names that a language takes, each given once."""

from __future__ import annotations

import re
from collections.abc import Iterable

# Names with these beginnings belong to OpenGL and WebGL.
PREFIXES = ("gl_", "webgl_")

# Types and macros of shading languages and of C, in all their sizes.
TYPES = re.compile(
    r"[a-z]{0,2}(vec|mat)[2-4](x[2-4])?[a-z]?"
    r"|(float|half|double|bool|u?(int|short|char|long)|min16\w+)([1-4](x[1-4])?|\d\d(_t)?)"
    r"|[fiu](8|16|32|64)"
    r"|[iu]?(sampler|texture|image|Texture|Sampler)([123]D|Cube|Buffer|CUBE|State)\w*"
    r"|(M|HUGE|FLT|DBL|INT|UINT|CHAR|FP|SIG)_[A-Z0-9_]+"
)


def legal(name: str, reserved: frozenset[str] | set[str] = frozenset()) -> str:
    """The name, or another one where the language has a meaning of its own for it."""
    if name in reserved or TYPES.fullmatch(name):
        return f"{name.rstrip('_')}_"
    if f"{name}_".startswith(PREFIXES):
        return f"my_{name}"
    if re.match(r"_([A-Z_]|$)", name):  # reserved in C and C++
        return f"v{name}" if name.strip("_") else "unused"
    return name


def snake(name: str) -> str:
    """A name that a function may begin with, made of a class's: round_ggx of RoundGGX."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


class Names:
    """Gives every thing of one scope its name."""

    def __init__(self, reserved: Iterable[str]) -> None:
        """Begin a scope where these names are taken."""
        self.taken = set(reserved)

    def give(self, name: str) -> str:
        """A name like this one that nothing else has."""
        wanted = legal(name, self.taken)
        if wanted in self.taken:
            start = wanted.rstrip("_")
            wanted = next(n for i in range(2, 10_000) if (n := f"{start}_{i}") not in self.taken)
        self.taken.add(wanted)
        return wanted
