"""Textures of languages that read no pictures here: every texture is one value.

GLSL reads pictures (gonio.foreign.textures). The text of HLSL, Slang, Metal, CUDA and WGSL is changed, line
by line in its place: textures and samplers become numbers that mean nothing, and calls that read them
become constants.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from gonio.foreign.declarations import closing, pieces

# The type that textures and samplers get.
NOTHING = "gonio_texture"

# Types of textures and samplers, by language; what stands in <> says how many components are read.
_TYPES = {
    "hlsl": r"(?:RW)?Texture(?:1D|2D|3D|Cube)(?:Array|MS)*|Sampler(?:Comparison)?State|"
    r"sampler(?:1D|2D|3D|CUBE)?",
    "msl": r"(?:texture|depth)(?:1d|2d|3d|cube)(?:_array|_ms)*|sampler",
    "cuda": r"cudaTextureObject_t",
    "wgsl": r"texture_(?:depth_)?(?:1d|2d|3d|cube)(?:_array)?|sampler(?:_comparison)?",
}
_CALLS = {
    "hlsl": (
        r"\b(?P<name>\w+)\s*\.\s*(?:Sample\w*|Load|Gather\w*)\s*\(",
        r"\btex(?:1D|2D|3D|CUBE)\w*\s*\(\s*(?P<name>\w+)\s*,",
    ),
    "msl": (r"\b(?P<name>\w+)\s*\.\s*(?:sample|read|gather)\w*\s*\(",),
    "cuda": (r"\btex(?:1D|2D|3D|Cubemap)\w*\s*<\s*(?P<type>\w+)\s*>\s*\(\s*(?P<name>\w+)\s*,",),
    "wgsl": (r"\btexture(?:Sample|Load|Gather)\w*\s*\(\s*(?P<name>\w+)\s*,",),
}
_LIKE = {"slang": "hlsl"}
_COMPONENTS = {"": "", "1": ".x", "2": ".xy", "3": ".xyz", "4": ""}


def unfolded(bare: str, text: str, language: str, headers: str = "") -> tuple[str, str]:
    """The text with macros written out that declare or read textures, or open constant buffers.

    Args:
        bare: with comments as spaces; each edit is made in both.
        text: as it is compiled.
        language: other languages than those above stay as they are.
        headers: what is included, whose macros count as well.
    """
    language = _LIKE.get(language, language)
    if language not in ("hlsl", "msl", "cuda"):
        return bare, text
    define = re.compile(
        r"^[ \t]*#[ \t]*define[ \t]+(?P<name>\w+)(?:\((?P<inside>[^)]*)\))?[ \t]+(?P<body>(?:\\\n|[^\n])+)",
        re.M,
    )
    own = rf"\b(?:{_TYPES[language]})\b|\bcbuffer\b|^\}}\s*;?$|{'|'.join(_CALLS[language])}"
    own = re.sub(r"\?P<\w+>", "?:", own)
    macros: dict[str, tuple[list[str] | None, str]] = {}
    all_ = [*define.finditer(headers), *define.finditer(bare)]
    for _ in range(4):  # macros that are made of such macros
        for m in all_:
            body = re.sub(r"\\\n", " ", m["body"]).strip()
            uses = any(re.search(rf"\b{name}\b", body) for name in macros)
            if uses or re.search(own, body):
                inside = m["inside"]
                names = None if inside is None else [n.strip() for n in inside.split(",")]
                macros[m["name"]] = (names, body)
    if not macros:
        return bare, text
    for m in reversed(list(define.finditer(bare))):
        if m["name"] in macros:
            empty = re.sub(r"[^\n]", " ", m[0])
            bare = bare[: m.start()] + empty + bare[m.end() :]
            text = text[: m.start()] + empty + text[m.end() :]
    words = re.compile(rf"\b(?:{'|'.join(map(re.escape, macros))})\b")
    for _ in range(_USES):
        found = next((m for m in words.finditer(bare) if _outside(bare, m.start())), None)
        if found is None:
            break
        names, body = macros[found[0]]
        end = found.end()
        if names is not None:
            end = closing(bare, bare.find("(", end), "(", ")")
            given = [g.strip() for g in pieces(bare[bare.find("(", found.end()) + 1 : end - 1])]
            values = dict(zip(names, given, strict=False))
            if names != [""]:
                body = re.sub(r"\w+", lambda w: values.get(w[0], w[0]), body)  # noqa: B023
        body = re.sub(r"\s*##\s*", "", body) + "\n" * bare.count("\n", found.start(), end)
        bare = bare[: found.start()] + body + bare[end:]
        text = text[: found.start()] + body + text[end:]
    return bare, text


# So many uses of macros at most are written out: those that name themselves have no end.
_USES = 2000


def _outside(bare: str, position: int) -> bool:
    """Whether a place is in no line of the preprocessor."""
    return not bare[bare.rfind("\n", 0, position) + 1 : position].lstrip().startswith("#")


def replaced(bare: str, text: str, language: str) -> tuple[str, str, tuple[str, ...]]:
    """The text without textures, and the names of those that it reads.

    Args:
        bare: with comments as spaces; each edit is made in both.
        text: as it is compiled.
        language: other languages than those above stay as they are.
    """
    language = _LIKE.get(language, language)
    if language not in _TYPES:
        return bare, text, ()
    kinds = rf"\b(?:{_TYPES[language]})\b(?:\s*<(?P<inside>[^<>;(){{}}]*)>)?"
    wide: dict[str, str] = {}
    edits: list[tuple[int, int, str]] = []
    if language == "wgsl":
        declared = rf"(?:@\w+\s*\([^)]*\)\s*)*(?P<var>\bvar\s+)?\b(?P<name>\w+)\s*:\s*{kinds}"
    else:
        declared = (
            rf"{kinds}\s+(?P<name>\w+)(?P<place>\s*:\s*register\s*\([^)]*\)|\s*\[\[[^\]]*\]\])?"
        )
    for m in re.finditer(declared, bare):
        width = re.search(r"[1-4]$", (m["inside"] or "").split(",")[0].strip())
        wide[m["name"]] = width[0] if width else "1" if m["inside"] in ("float", "half") else ""
        if language == "wgsl":
            new = f"{'var<private> ' if m['var'] else ''}{m['name']}: {NOTHING}"
        else:
            outside = bare.count("{", 0, m.start()) == bare.count("}", 0, m.start())
            alone = outside and re.match(r"\s*;", bare[m.end() :]) is not None
            new = f"{'static ' if alone else ''}{NOTHING} {m['name']}"
        edits.append((m.start(), m.end(), new))
    names = []
    for pattern in _CALLS[language]:
        for m in re.finditer(pattern, bare):
            name = m["name"]
            if name not in wide:
                continue
            names.append(name)
            end = closing(bare, bare.index("(", m.start()), "(", ")")
            width = re.search(r"[1-4]$", m.groupdict().get("type") or "")
            many = width[0] if width else "1" if m.groupdict().get("type") else wide[name]
            # Metal and WGSL read four components whatever the type
            many = "" if language in ("msl", "wgsl") else many
            edits.append((m.start(), end, constant(name) + _COMPONENTS[many]))
    for start, end, new in sorted(edits, reverse=True):
        kept = new + "\n" * text[start:end].count("\n")
        text = text[:start] + kept + text[end:]
        bare = bare[:start] + kept + bare[end:]
    return bare, text, tuple(dict.fromkeys(names))


def constant(name: str) -> str:
    """What stands where a texture is read."""
    return f"{NOTHING}_{name}"


def head(language: str, values: Mapping[str, Iterable[float]]) -> str:
    """Declarations of the type and of all values."""
    found = ["typedef int gonio_texture;" if language != "wgsl" else "alias gonio_texture = i32;"]
    if language == "msl":
        found.insert(0, "#include <metal_stdlib>\n")
    for name, numbers in values.items():
        inside = ", ".join(f"{float(x):.9g}" if x % 1 else f"{float(x):.1f}" for x in numbers)
        if language == "wgsl":
            found.append(f"const {constant(name)} = vec4f({inside});")
        elif language == "cuda":
            found.append(f"static const float4 {constant(name)} = {{{inside}}};")
        else:
            found.append(f"static const float4 {constant(name)} = float4({inside});")
    return " ".join(found)
