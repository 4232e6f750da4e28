"""Compiled libraries as foreign code: a signature in C says how a function of libbrdf.so is called.

A few lines of C++ that call it are compiled and linked with the library.
"""

from __future__ import annotations

import re
from pathlib import Path

from gonio.foreign.source import ForeignError, Source, of_text

ENDINGS = (".so", ".dylib", ".dll")

_PLAIN = frozenset(
    [
        "float",
        "double",
        "int",
        "bool",
        "void",
        "const",
        "unsigned",
        "char",
        "short",
        "long",
        "struct",
        "restrict",
        "__restrict__",
    ]
)


def is_library(text: str) -> bool:
    """Whether a text names a compiled library."""
    file = text.partition("#")[0].lower()
    return file.endswith(ENDINGS) or re.search(r"\.so(\.\d+)+$", file) is not None


def read(text: str, name: str | None, signature: str | None) -> Source:
    """The declaration of a library's function as a source.

    Args:
        text: the library's file.
        name: of the function, if --function says it.
        signature: such as "float eval(const float wi[3], const float wo[3], float roughness)".

    Raises:
        ForeignError: no file, no signature, or one that is not C.
    """
    path = Path(text.partition("#")[0])
    if not path.is_file():
        raise ForeignError(f"{path}: No such file or directory")
    if not signature:
        raise ForeignError(
            f"{path} is compiled; say how its function is called, such as --signature "
            f'"float {name or "eval"}(const float wi[3], const float wo[3], float roughness)".'
        )
    declaration = signature.strip().rstrip(";")
    # The name may be left to --function: "float (const float wi[3], ...)"
    if name and not re.search(rf"\b{re.escape(name)}\s*\(", declaration):
        declaration = re.sub(r"\s*\(", f" {name}(", declaration, count=1)
    found = re.fullmatch(r"[\w\s*]+?[\s*](\w+)\s*\((.*)\)", declaration, re.S)
    if found is None or (name and found[1] != name):
        raise ForeignError(
            f"--signature {signature!r} is no declaration in C of {name or 'a function'}, such as "
            '"float eval(const float wi[3], const float wo[3], float roughness)".'
        )
    structs = "".join(_struct(word) for word in sorted(_words(declaration)))
    source = of_text(path, "library", f"{structs}{declaration} {{}}", (), found[1])
    return source if source.functions else _refuse(signature)


def _refuse(signature: str) -> Source:
    raise ForeignError(f"--signature {signature!r} is no declaration in C.")


def _words(declaration: str) -> set[str]:
    """Names of types that are not C's own."""
    result, _, inside = declaration.partition("(")
    found = {result.split()[0]} if len(result.split()) > 1 else set()
    for piece in inside.rstrip(")").split(","):
        words = re.findall(r"[A-Za-z_]\w*", piece)
        found |= set(words[:-1])
    return {w for w in found if w not in _PLAIN}


def _struct(name: str) -> str:
    """A vector by value: x, y, z, which C passes as any struct of so many numbers."""
    match = re.search(r"([234])?([fd])?$", name.lower())
    count = int(match[1]) if match is not None and match[1] else 3
    kind = "double" if name.lower().endswith("d") or "double" in name.lower() else "float"
    return f"struct {name} {{ {kind} {', '.join('xyzw'[:count])}; }};\n"


def wrapper(source: Source) -> tuple[str, str]:
    """The text in front of the calls: as a function of C, and as one of C++."""
    structs, _, declaration = source.text.rpartition("};\n")
    head = f"{structs}}};\n" if structs else ""
    declared = declaration.removesuffix(" {}") + ";\n"
    return f'{head}extern "C" {declared}', f"{head}{declared}"
