"""Declarations in shader code, as far as they have to be understood: functions, arguments and structs.

No compiler: brackets are counted, and what stands in front of a bracket is read, in text whose comments are
blank.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Variable:
    """An argument of a function, a member of a struct, a uniform, or a parameter of a .brdf file."""

    name: str
    type: str
    """As it is written, without qualifiers and spaces."""
    written: bool = False
    """Whether the function writes to it (out, inout, a pointer or reference that is not const)."""
    array: str = ""
    """What stands between the brackets of an array."""
    pointer: bool = False
    """Whether it may be an array: a pointer to numbers."""
    address: bool = False
    """Whether the address of one value is given: a pointer to a vector, a struct or a density."""
    default: tuple[float, ...] = ()
    low: float | None = None
    high: float | None = None
    shown: str = ""
    """How users call it, where its own name was made by a generator."""
    fixed: bool = False
    """Whether it keeps its default: no parameter."""


@dataclass(frozen=True)
class Function:
    """The definition of a function."""

    name: str
    scope: tuple[str, ...]
    """Namespaces and the struct that it stands in, from the outside."""
    returns: str
    arguments: tuple[Variable, ...]
    line: int
    body: str
    owner: str = ""
    """The struct that it is a method of."""

    @property
    def signature(self) -> str:
        """In one line, for people."""
        inside = ", ".join(
            f"{a.type} {a.name}{f'[{a.array}]' if a.array else ''}" for a in self.arguments
        )
        return f"{self.returns} {'::'.join((*self.scope, self.name))}({inside})"

    @property
    def typed(self) -> str:
        """Its name with the types of its arguments, which tells overloads apart."""
        return f"{self.name}({', '.join(a.type for a in self.arguments)})"


@dataclass(frozen=True)
class Constructor:
    """The constructor of a class that computes its members from arguments."""

    arguments: tuple[Variable, ...]
    words: frozenset[str]
    """All words in it."""
    computes: bool
    """Whether it does more than to keep its arguments as members, which can be set as well."""


def depth(bare: str, position: int) -> int:
    """How many braces are open at a position."""
    return bare.count("{", 0, position) - bare.count("}", 0, position)


_HEAD = re.compile(
    r"(?P<type>[A-Za-z_][\w:]*(?:\s*<[^<>;{}()]*>)?(?:\s*[&*])?)\s+(?P<name>[A-Za-z_]\w*)\s*\("
)
_WORDS = {
    "return",
    "else",
    "if",
    "for",
    "while",
    "switch",
    "do",
    "new",
    "case",
    "define",
    "namespace",
}


def functions_in(bare: str, language: str) -> Iterable[Function]:
    """All definitions of functions, with the scopes that they stand in."""
    code = re.sub(
        r"^[ \t]*#(?:\\\n|[^\n])*", lambda m: re.sub(r"[^\n]", " ", m[0]), bare, flags=re.M
    )
    head = re.compile(r"\bfn\s+(?P<name>\w+)\s*\(") if language == "wgsl" else _HEAD
    position = 0
    scopes: list[tuple[str, str]] = []
    while position < len(code):
        brace = re.compile(r"[{}]").search(code, position)
        found = head.search(code, position)
        if found is not None and (brace is None or found.start() < brace.start()):
            end = closing(code, found.end() - 1, "(", ")")
            if scopes and scopes[-1] == ("struct", found["name"]):  # a constructor
                _, brace_at = _initials(code, end)
                position = closing(code, brace_at, "{", "}") if brace_at else end
                continue
            after = re.compile(
                r"\s*(?:->\s*(?P<to>[\w:<>, ]+?)"
                r"|(?:const|noexcept|override|:\s*\w+|\[\[[^\]]*\]\])\s*)*\s*\{"
            ).match(code, end)
            kind = found.groupdict().get("type", "")
            if after is None or kind in _WORDS:
                position = found.end()
                continue
            close = closing(code, after.end() - 1, "{", "}")
            inside = code[found.end() : end - 1]
            returns = after["to"] or kind or "void"
            owner = scopes[-1][1] if scopes and scopes[-1][0] == "struct" else ""
            yield Function(
                found["name"],
                tuple(name for _, name in scopes if name),
                plain_type(returns),
                tuple(
                    _argument(piece, language)
                    for piece in pieces(inside)
                    if piece.strip() not in ("", "void")
                ),
                code.count("\n", 0, found.start()) + 1,
                code[after.end() : close],
                owner,
            )
            position = close
        elif brace is None:
            return
        elif brace[0] == "}":
            if scopes:
                scopes.pop()
            position = brace.end()
        else:
            before = re.split(r"[;{}]", code[: brace.start()])[-1]
            before = re.sub(r"\btemplate\s*<[^<>]*>", " ", before)
            scope = re.search(r"\b(namespace|struct|class)\s+([\w:]*)", before)
            if scope or "extern" in before or re.search(r"\bnamespace\s*$", before):
                kind = "" if scope is None else "struct" if scope[1] != "namespace" else "namespace"
                scopes.append((kind, scope[2] if scope else ""))
                position = brace.end()
            else:
                position = closing(code, brace.start(), "{", "}")


def closing(text: str, position: int, open_: str, close: str) -> int:
    """The position behind the bracket that closes the one at `position`."""
    depth = 0
    for place in range(position, len(text)):
        if text[place] == open_:
            depth += 1
        elif text[place] == close:
            depth -= 1
            if depth == 0:
                return place + 1
    return len(text)


def pieces(text: str) -> list[str]:
    """Split at commas outside of brackets."""
    found, depth = [""], 0
    for letter in text:
        depth += (letter in "(<[{") - (letter in ")>]}")
        if letter == "," and depth == 0:
            found.append("")
        else:
            found[-1] += letter
    return found


_QUALIFIERS = {
    "const", "in", "highp", "mediump", "lowp", "precise", "thread", "device", "constant", "uniform",
    "restrict", "__restrict__", "static", "constexpr", "volatile", "struct", "nointerpolation", "inline",
}  # fmt: skip


def plain_type(text: str) -> str:
    """A type without spaces, and without what makes it a reference or pointer."""
    return re.sub(r"\s+", "", text).rstrip("&*")


# A pointer to these is an array mostly, but for densities of samples.
_NUMBERS = re.compile(
    r"(?:\w*::)?(?:float|double|half|int|unsigned|char|bool|void|real|Float|Real)\w*"
)
_DENSITY = re.compile(r"pdf|dens|prob", re.I)


def _argument(piece: str, language: str) -> Variable:
    """One argument as it is written."""
    piece = re.sub(r"\[\[.*?\]\]|@\w+(\([^)]*\))?", " ", piece, flags=re.S)
    if language == "wgsl":
        name, _, kind = piece.partition(":")
        return Variable(name.strip(), plain_type(kind), pointer="ptr<" in kind)
    given = piece.partition("=")[2].strip()
    piece = (
        re.sub(r":\s*\w+\s*$", " ", piece.partition("=")[0])
        if "::" not in piece
        else piece.partition("=")[0]
    )
    array = re.search(r"\[([^\]]*)\]", piece)
    piece = re.sub(r"\[[^\]]*\]", " ", piece)
    reference = "&" in piece
    pointer = "*" in piece
    words = re.findall(r"[A-Za-z_][\w:]*(?:\s*<[^<>]*>)?", piece)
    constant = "const" in words or "constant" in words
    written = "out" in words or "inout" in words or ((reference or pointer) and not constant)
    words = [w for w in words if w not in _QUALIFIERS and w not in ("out", "inout")]
    name = words[-1] if len(words) > 1 else ""
    kind = words[-2] if len(words) > 1 else words[0] if words else ""
    single = not _NUMBERS.fullmatch(kind) or _DENSITY.search(name)
    address = bool(pointer and single and not array and language in ("cpp", "cuda", "msl"))
    default = (
        (float(given.rstrip("fF")),) if re.fullmatch(r"[-+]?[\d.]+(e[-+]?\d+)?[fF]?", given) else ()
    )
    return Variable(
        name,
        plain_type(kind),
        written,
        array[1].strip() if array else "",
        pointer and not address,
        address,
        default,
    )


def structs_in(bare: str, language: str) -> dict[str, tuple[Variable, ...]]:
    """Members of all structs, by name."""
    bare = re.sub(r"^[ \t]*#[^\n]*", lambda m: " " * len(m[0]), bare, flags=re.M)
    found: dict[str, tuple[Variable, ...]] = {}
    for match in re.finditer(
        r"\b(?:struct|class)\s+(?:alignas\s*\([^)]*\)\s*)?(\w+)\s*(?:final\s*)?(?::[^{;]*)?\{", bare
    ):
        close = closing(bare, match.end() - 1, "{", "}")
        inside = _without_constructors(bare[match.end() : close - 1], match[1])
        while "{" in inside:  # methods, and constructors
            start = inside.index("{")
            end = closing(inside, start, "{", "}")
            inside = inside[:start] + ";" + inside[end:]
        found[match[1]] = tuple(members_in(inside, language))
    return found


_INITIAL = re.compile(r"\s*,?\s*(?P<name>[A-Za-z_][\w:]*(?:\s*<[^<>;{}()]*>)?)\s*(?P<open>[({])")


def constructors_in(
    bare: str, structs: Mapping[str, tuple[Variable, ...]], language: str
) -> dict[str, Constructor]:
    """Of each class the constructor with the most arguments that is defined here, if it has any."""
    found: dict[str, Constructor] = {}
    if language not in ("cpp", "cuda", "slang"):
        return found
    for name, members in structs.items():
        head = rf"(?<![\w~.]){name}\s*\("
        if language == "slang":
            inside = re.search(rf"\bstruct\s+{name}\b[^{{;]*\{{", bare)
            start = inside.end() - 1 if inside else 0
            places = (start, closing(bare, start, "{", "}"))
            head = r"\b__init\s*\("
        else:
            places = (0, len(bare))
        for match in re.compile(head).finditer(bare, *places):
            made = _constructor(bare, match.end() - 1, {m.name for m in members}, name, language)
            best = found.get(name)
            if made and (best is None or len(made.arguments) > len(best.arguments)):
                found[name] = made
    return found


def _initials(bare: str, end: int) -> tuple[dict[str, str], int]:
    """What a constructor makes of members behind its arguments, and its body's bracket; 0 if none."""
    initial: dict[str, str] = {}
    after = re.compile(r"\s*(?:noexcept\s*)?(:(?!:))?").match(bare, end)
    place = after.end() if after else end
    if after and after[1]:
        while one := _INITIAL.match(bare, place):
            open_ = one["open"]
            place = closing(bare, one.end() - 1, open_, {"(": ")", "{": "}"}[open_])
            initial[one["name"]] = bare[one.end() : place - 1].strip()
    body = re.compile(r"\s*\{").match(bare, place)
    return initial, body.end() - 1 if body else 0


def _without_constructors(inside: str, name: str) -> str:
    """The inside of a class without constructors that are defined there."""
    while match := re.search(rf"(?<![\w~.]){name}\s*\((?=.*\{{)", inside, re.S):
        end = closing(inside, match.end() - 1, "(", ")")
        _, brace = _initials(inside, end)
        end = closing(inside, brace, "{", "}") if brace else end
        inside = f"{inside[: match.start()]};{inside[end:]}"
    return inside


def _constructor(
    bare: str, bracket: int, members: set[str], name: str, language: str
) -> Constructor | None:
    """What stands at a bracket behind a class's name, if it defines a constructor that can be called."""
    end = closing(bare, bracket, "(", ")")
    arguments = tuple(
        _argument(piece, language)
        for piece in pieces(bare[bracket + 1 : end - 1])
        if piece.strip() not in ("", "void")
    )
    copies = len(arguments) == 1 and arguments[0].type == name
    if not arguments or copies or not all(a.name for a in arguments):
        return None
    initial, brace = _initials(bare, end)
    if not brace:
        return None
    inside = bare[brace + 1 : closing(bare, brace, "{", "}") - 1]
    kept = {a.name for a in arguments}
    plain = not inside.strip() and all(
        member in members and re.sub(r"^(?:std::)?move\s*\(|\)$", "", value) in kept
        for member, value in initial.items()
    )
    text = " ".join([inside, *initial, *initial.values()])
    return Constructor(arguments, frozenset(re.findall(r"[A-Za-z_]\w*", text)), not plain)


def members_in(inside: str, language: str) -> Iterable[Variable]:
    """The members that stand between the braces of a struct."""
    if language == "wgsl":
        for piece in pieces(inside):
            if ":" in piece:
                yield _argument(piece, language)
        return
    for statement in inside.split(";"):
        statement = re.sub(r"\b(public|private|protected)\s*:", " ", statement)
        if not statement.strip() or "(" in statement.partition("=")[0] or "operator" in statement:
            continue
        if re.match(r"\s*(static|using|typedef|typealias|friend)\b", statement):
            continue
        first, *others = pieces(statement)
        variable = _argument(first, language)
        if not variable.name:
            continue
        yield variable
        for other in others:
            yield _argument(f"{variable.type} {other}", language)
