"""Shader code that others wrote, as far as it has to be understood: functions, structs and uniforms.

No compiler: comments are blanked, brackets are counted, and what stands in front of a bracket is read. All
positions stay those of the file, so that compilers complain about the user's own lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from gonio.foreign.conditions import active
from gonio.foreign.declarations import (
    Constructor,
    Function,
    Variable,
    closing,
    constructors_in,
    depth,
    functions_in,
    members_in,
    plain_type,
    structs_in,
)
from gonio.foreign.sampled import NOTHING, replaced, unfolded
from gonio.messages import did_you_mean


class ForeignError(ValueError):
    """Foreign code that cannot be found, read, matched, compiled or run; the message says what to do."""


# By the ends of files' names. GLSL ES is told by its version line as well.
LANGUAGES = {
    "glsl": ("glsl", "frag", "vert", "comp", "fs", "vs", "fsh", "vsh"),
    "essl": ("essl",),
    "brdf": ("brdf",),
    "hlsl": ("hlsl", "hlsli", "fx", "fxh", "usf", "ush", "cginc"),
    "wgsl": ("wgsl",),
    "msl": ("metal", "msl"),
    "slang": ("slang",),
    "cpp": ("cpp", "cc", "cxx", "c", "h", "hh", "hpp", "inl"),
    "cuda": ("cu", "cuh"),
    "osl": ("osl",),
}

ENDINGS = {ending: language for language, endings in LANGUAGES.items() for ending in endings}


# Macros that compilers of a language have by themselves.
_PREDEFINED = {
    "essl": ("GL_ES=1", "__VERSION__=300"),
    "glsl": ("__VERSION__=450",),
    "brdf": ("__VERSION__=450",),
    "msl": ("__METAL__=1", "__METAL_VERSION__=320"),
    "cpp": ("__cplusplus=201703",),
    "osl": ("OSL_VERSION_MAJOR=1",),
}

# So many lines are left for each file in the numbers that #line gives.
FILE_LINES = 100_000

_SHORT = re.compile(
    r"\b(?:mediump|lowp|half[234]?|fixed[234]|min(?:16|10)float[234]?|f16|vec[234]h|float16_t)\b"
)

# Those that run as a fragment shader of gonio's own.
SHADERS = ("glsl", "essl", "brdf")


@dataclass(frozen=True)
class Source:
    """A file that has been read."""

    path: Path
    language: str
    text: str
    """As it is compiled: the file's text, line by line in its place, and for GLSL with its includes."""
    functions: tuple[Function, ...]
    structs: Mapping[str, tuple[Variable, ...]]
    uniforms: tuple[Variable, ...]
    """Values from outside which the code needs: uniforms, and the parameters of a .brdf file."""
    files: tuple[Path, ...]
    """In the order in which their lines are counted."""
    entry: str = ""
    """The function of generated text, which is in no file."""
    textures: tuple[str, ...] = ()
    """Names of its sampler2D, or of what it reads as a texture in other languages."""
    module: str = ""
    """Of Python, if it was named by its module."""
    headers: str = ""
    """What it includes, where compilers do that themselves."""
    globals: tuple[Variable, ...] = ()
    """Variables outside of all functions without a value, which entry points fill."""
    constructors: Mapping[str, Constructor] = field(default_factory=dict)
    """By the classes that have one that wants arguments."""
    closures: tuple[str, ...] = ()
    """Names of OSL's shaders and functions that give back closures, and are left out."""

    @property
    def short(self) -> bool:
        """Whether the file, or what it includes, declares half precision."""
        written = _text(self.path) if self.path.is_file() and not self.entry else self.text
        return _SHORT.search(blank_comments(written) + self.headers) is not None

    @property
    def macros(self) -> list[str]:
        """Macros, NAME=VALUE, by which half precision is float32 in what it includes as well."""
        words = {word: word for word in re.findall(r"[A-Za-z]\w*", self.headers)}
        for pattern, new in _HALF.get(self.language, ()):
            words = {word: re.sub(pattern, new, changed) for word, changed in words.items()}
        single = re.compile(r"float(?:[1-4](?:x[1-4])?)?")
        return [
            f"{word}={new}" for word, new in words.items() if word != new and single.fullmatch(new)
        ]

    def find(self, name: str | None) -> Function:
        """The function of a name such as "eval", "Eon.eval", "gonio_eon::eon_eval" or "eval(vec3, float)".

        Raises:
            ForeignError: there is none, or several might be meant.
        """
        own = [f for f in self.functions if f.name != "main"]
        if self.entry:
            return next(f for f in own if f.name == self.entry)
        if name is None:
            candidates = [
                f
                for f in own
                if re.fullmatch(r"BRDF|brdf|eval|.*_eval|.*[bB][rR][sS]?[dD][fF].*", f.name)
            ]
            if len(candidates) == 1 or (candidates and self.language == "brdf"):
                return candidates[0]
            shown = ", ".join(dict.fromkeys(f.name for f in own)) or "none"
            raise ForeignError(
                f"{self.path}: say which function, as {self.path}#NAME; it has {shown}."
            )
        bare, bracket, inside = name.partition("(")
        parts = re.split(r"::|\.", bare.strip())
        found = [
            f
            for f in own
            if f.name == parts[-1] and tuple(parts[:-1]) == f.scope[len(f.scope) - len(parts) + 1 :]
        ]
        if bracket and found:
            kinds = [plain_type(kind) for kind in inside.rstrip(") ").split(",")]
            chosen = [f for f in found if [a.type for a in f.arguments] == kinds]
            found = chosen or found
        if len({f.typed for f in found}) > 1:
            raise ForeignError(
                f"{self.path}: {name} is not one function; say which, as "
                f"{' or '.join(repr(f.typed) for f in found)}."
            )
        if found:
            return found[0]
        names = list(dict.fromkeys(f.name for f in own))
        if parts[-1] in self.closures:
            raise ForeignError(
                f"{self.path}: {parts[-1]} gives back a closure, which is no number: the renderer decides "
                "what it reflects; name a function that computes a colour of two directions."
            )
        if self.language == "python" and len(parts) > 1:
            raise ForeignError(
                f"{self.path}: {name} is a method, and objects are not made here; write a function of the "
                "directions and parameters that makes one and calls it."
            )
        if parts[-1] == "main" and self.language in SHADERS:
            raise ForeignError(
                f"{self.path}: main writes a pixel and is left out; move its shading into a function that "
                f"gives a colour back, and name that: {self.path}#NAME."
            )
        written = rf"\b{re.escape(parts[-1])}\s*\([^;{{]*\)\s*\{{"
        if parts[-1] not in names and re.search(written, self.text):
            raise ForeignError(
                f"{self.path}: {name} is left out by an #if; -D NAME turns on what it asks for."
            )
        raise ForeignError(
            f"{self.path} defines no function {name!r}; {did_you_mean(parts[-1], names)}"
            f"it has {', '.join(names) or 'none'}."
        )

    def called(self, function: Function) -> list[Function]:
        """A function and those that it may call."""
        by_name: dict[str, list[Function]] = {}
        for f in self.functions:
            by_name.setdefault(f.name, []).append(f)
        found: list[Function] = []
        waiting, seen = [function], set()
        while waiting:
            f = waiting.pop()
            if id(f) in seen:
                continue
            seen.add(id(f))
            found.append(f)
            for word in set(re.findall(r"[A-Za-z_]\w*", f.body)):
                waiting += by_name.get(word, [])
        return found

    def reached(self, function: Function) -> set[str]:
        """All words in a function and in those that it may call."""
        words: set[str] = set()
        for f in self.called(function):
            words |= set(re.findall(r"[A-Za-z_]\w*", f.body))
        # Macros may hold names of uniforms
        for macro, value in re.findall(r"^[ \t]*#[ \t]*define[ \t]+(\w+)(.*)$", self.text, re.M):
            if macro in words:
                words |= set(re.findall(r"[A-Za-z_]\w*", value))
        return words


def language_of(path: Path, text: str) -> str:
    """The language of a file, by its name and its version line.

    Raises:
        ForeignError: an unknown ending.
    """
    ending = path.suffix.lstrip(".").lower()
    if ending not in ENDINGS:
        known = ", ".join(f".{e}" for e in ENDINGS)
        raise ForeignError(
            f"{path}: no language has the ending {path.suffix!r}; known are {known}."
        )
    language = ENDINGS[ending]
    if language == "glsl" and re.search(r"^\s*#\s*version\s+(100|3[0-9]0\s+es)", text, re.M):
        return "essl"
    return language


def read(
    path: str | Path, include: Sequence[str | Path] = (), defines: Sequence[str] = ()
) -> Source:
    """Read a file of foreign code.

    Args:
        path: of a language that LANGUAGES has.
        include: folders in which #include is looked for, beside that of the file.
        defines: macros, NAME or NAME=VALUE, which decide what lies between #if and #endif.

    Raises:
        ForeignError: there is no such file, it is no text, or in no known language.
    """
    path = Path(path)
    text = _text(path)
    language = language_of(path, text)
    uniforms: list[Variable] = []
    files = [path]
    if language == "brdf":
        text, uniforms = _brdf(path, text)
    if language in (*SHADERS, "wgsl"):
        text = _included(text, path, [Path(p) for p in include], files, language)
    bare = blank_comments(text)
    if language in SHADERS:
        bare, text = _without_main(bare, text)
    bare = active(bare, [*defines, *_PREDEFINED.get(language, ())])
    closures: list[str] = []
    if language == "osl":
        text = bare = _osl(_without_closures(bare, closures))
    headers = ""
    if language not in (*SHADERS, "wgsl"):
        headers = "".join(_headers(bare, path, [Path(p) for p in include], set()))
    bare, text = unfolded(bare, text, language, headers)
    bare, text = _singles(bare, text, language)
    bare, text, read_from = replaced(bare, text, language)
    if language == "msl":
        text = swizzled(text)
    if language in (*SHADERS, "hlsl"):
        bare, text, found = _uniforms(bare, text, language)
        uniforms += found
    if language == "wgsl":
        bare, text, found = _wgsl_uniforms(bare, text)
        uniforms += found
    functions = tuple(functions_in(bare, language))
    structs = structs_in(bare + headers, language)
    return Source(
        path,
        language,
        text,
        functions,
        structs,
        tuple(uniforms),
        tuple(files),
        textures=_samplers(bare, language) or read_from,
        headers=headers,
        globals=tuple(_globals(bare, language, {u.name for u in uniforms})),
        constructors=constructors_in(bare + headers, structs, language),
        closures=tuple(closures),
    )


def _globals(bare: str, language: str, known: set[str]) -> Iterable[Variable]:
    """Variables that functions share: shading_normal and the like, without a value in their declaration."""
    pattern = {
        "wgsl": r"\bvar\s*<\s*private\s*>\s*(?P<name>\w+)\s*:\s*(?P<type>[\w<>, ]+?)\s*;",
        "hlsl": r"^[ \t]*static\s+(?P<type>\w+)\s+(?P<name>\w+)\s*;",
    }.get(
        language, r"(?:^|(?<=;))[ \t]*(?:(?:high|medium|low)p\s+)?(?P<type>\w+)\s+(?P<name>\w+)\s*;"
    )
    if language not in (*SHADERS, "hlsl", "wgsl"):
        return
    for m in re.finditer(pattern, bare, re.M):
        new = m["name"] not in known and m["type"] not in ("return", "precision", NOTHING)
        if new and depth(bare, m.start()) == 0:
            yield Variable(m["name"], plain_type(m["type"]))


# Half precision that cannot be run here, as float32: patterns and what stands for them.
_HALF = {
    "hlsl": (
        (r"\b(?:half|min16float|min10float|float16_t)(?=(?:[1-4](?:x[1-4])?)?\b)", "float"),
        (r"\bfixed(?=[1-4]\b|\s+[A-Za-z_]|\s*\()", "float"),
        (r"(?<=[\d.])[hH]\b", "f"),
    ),
    "slang": (
        (r"\b(?:half|float16_t)(?=(?:[1-4](?:x[1-4])?)?\b)", "float"),
        (r"(?<=[\d.])[hH][fF]?\b", "f"),
    ),
    "wgsl": (
        (r"\benable\s+f16\s*;", ""),
        (r"\bf16\b", "f32"),
        (r"\b(vec[234]|mat[234]x[234])h\b", r"\1f"),
        (r"(?<=[\d.])h\b", "f"),
    ),
}


def _singles(bare: str, text: str, language: str) -> tuple[str, str]:
    """The text with float32 for half precision; lines stay where they are."""
    for pattern, new in _HALF.get(language, ()):
        for match in reversed(list(re.finditer(pattern, bare))):
            made = match.expand(new) + "\n" * match[0].count("\n")
            text = text[: match.start()] + made + text[match.end() :]
            bare = bare[: match.start()] + made + bare[match.end() :]
    return bare, text


def _samplers(bare: str, language: str) -> tuple[str, ...]:
    if language not in SHADERS:
        return ()
    found = re.findall(r"\buniform\s+(?:(?:high|medium|low)p\s+)?sampler2D\s+(\w+)\s*;", bare)
    return tuple(dict.fromkeys(found))


def of_text(
    path: Path, language: str, text: str, uniforms: Sequence[Variable], entry: str
) -> Source:
    """Generated code as a source; its uniforms are globals already."""
    bare = blank_comments(text)
    functions = tuple(functions_in(bare, language))
    structs = structs_in(bare, language)
    return Source(
        path,
        language,
        text,
        functions,
        structs,
        tuple(uniforms),
        (path,),
        entry,
        _samplers(bare, language),
    )


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        return path.read_text(encoding="latin-1").replace("\r\n", "\n")
    except OSError as error:
        raise ForeignError(f"{path}: {error.strerror or error}") from None


def blank_comments(text: str) -> str:
    """The text with comments and strings as spaces, every character in its place."""

    def spaces(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    return re.sub(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', spaces, text, flags=re.S)


def _brdf(path: Path, text: str) -> tuple[str, list[Variable]]:
    """The shader of a BRDF Explorer file with everything else as empty lines, and its parameters."""
    kept: list[str] = []
    found: list[Variable] = []
    section = ""
    for number, line in enumerate(text.split("\n"), 1):
        if match := re.match(r"\s*::(begin|end)\s+(\w+)", line):
            section = match[2] if match[1] == "begin" else ""
            kept.append("")
            continue
        kept.append(line if section == "shader" else "")
        if section != "parameters" or not (words := line.split("#")[0].split()):
            continue
        try:
            kind, name, numbers = words[0], words[1], [float(w) for w in words[2:]]
            if kind == "float":
                low, high, default = numbers[:3]
                found.append(Variable(name, "float", default=(default,), low=low, high=high))
            elif kind == "bool":
                found.append(Variable(name, "bool", default=(numbers[0],)))
            elif kind == "color":
                colour = tuple(numbers[:3]) if len(numbers) >= 3 else (1.0, 1.0, 1.0)
                found.append(Variable(name, "vec3", default=colour, low=0.0, high=1.0))
            else:
                raise ValueError
        except (ValueError, IndexError):
            raise ForeignError(
                f"{path}:{number}: {line.strip()!r} is no parameter; write 'float name min max default', "
                "'bool name 0' or 'color name r g b'."
            ) from None
    if not any(kept):
        raise ForeignError(f"{path} has no '::begin shader'.")
    return "\n".join(kept), found


def swizzled(text: str) -> str:
    """MSL as C++: components that are read together are functions of the stand-in's vectors."""
    return re.sub(r"\.([xyzw]{2,4}|[rgba]{2,4})\b(?!\s*\()", r".\1()", text)


def _without_closures(bare: str, names: list[str]) -> str:
    """OSL without what gives back closures, whose names are added to the list."""
    heads = r"\b(?:shader|surface|displacement|volume|closure\s+color)\s+(?P<name>\w+)\s*(?=[\[(])"
    position = 0
    while match := re.compile(heads).search(bare, position):
        position = match.end()
        opened = bare.find("{", closing(bare, bare.find("(", position), "(", ")"))
        end = closing(bare, opened, "{", "}")
        whole = bare[match.start() : end]
        if opened > 0 and re.search(r"\bclosure\b|\bCi\b", whole):
            names.append(match["name"])
            bare = bare[: match.start()] + re.sub(r"[^\n]", " ", whole) + bare[end:]
            position = end
    return bare


def _osl(bare: str) -> str:
    """OSL as C++: metadata and headers of its own left out, outputs as references, shaders as functions."""

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    text = re.sub(r"\[\[.*?\]\]", blank, bare, flags=re.S)
    text = re.sub(r"^[ \t]*#[ \t]*include[^\n]*", blank, text, flags=re.M)
    # Defaults of shaders' parameters are metadata for renderers: all are given here
    position = 0
    while match := re.compile(r"\b(?:shader|surface|displacement|volume)(?=\s+\w+\s*\()").search(
        text, position
    ):
        close = closing(text, text.index("(", match.end()), "(", ")")
        inside = re.sub(r"=\s*(?:\w+\s*\([^()]*\)|[^,()]*)", blank, text[match.end() : close])
        text = f"{text[: match.start()]}void{inside}{text[close:]}"
        position = match.end()
    return re.sub(r"\boutput\s+(\w+)\s+(?=\w)", r"\1& ", text)


def _included(text: str, path: Path, folders: list[Path], files: list[Path], language: str) -> str:
    """GLSL with its #include lines replaced by the files.

    Lines of the k-th file are counted from k FILE_LINES on: not all drivers keep #line's second number.
    """
    found = []
    number = files.index(path)
    for n, line in enumerate(text.split("\n"), 1):
        match = re.match(r'\s*#\s*include\s*[<"]([^>"]+)[>"]', line)
        if match is None:
            version = re.match(r"\s*#\s*version", line)
            found.append("" if version else line)
            continue
        target = next(
            (f / match[1] for f in (path.parent, *folders) if (f / match[1]).is_file()), None
        )
        if target is None:
            raise ForeignError(
                f"{path}:{n}: there is no file {match[1]!r} to include; name its folder with -I FOLDER."
            )
        if target in files:
            found.append("")
            continue
        files.append(target)
        inner = _included(_text(target), target, folders, files, language)
        if language == "wgsl":
            found.append(inner)
        else:
            first = files.index(target) * FILE_LINES + 1
            found += [f"#line {first}", inner, f"#line {number * FILE_LINES + n + 1}"]
    return "\n".join(found)


def _headers(bare: str, path: Path, folders: list[Path], seen: set[Path]) -> Iterable[str]:
    """Texts of the files that C-like code includes, for their structs."""
    raw = _text(path)
    for name in re.findall(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', raw, re.M):
        target = next((f / name for f in (path.parent, *folders) if (f / name).is_file()), None)
        if target is not None and target not in seen:
            seen.add(target)
            text = blank_comments(_text(target))
            yield "\n" + text
            yield from _headers(text, target, folders, seen)


_DECLARED = r"(?:(?:highp|mediump|lowp|flat|smooth|const|static)\s+)*"


def _uniforms(bare: str, text: str, language: str) -> tuple[str, str, list[Variable]]:
    """Turn uniforms, inputs and outputs of a whole shader into globals that a harness can set."""
    found: list[Variable] = []
    edits: list[tuple[int, int, str]] = []
    layout = r"(?:layout\s*\([^)]*\)\s*)?"
    if language != "hlsl":
        pattern = (
            rf"(?:^|(?<=;))[ \t]*"
            rf"({layout}(?:flat\s+|smooth\s+|highp\s+)?(uniform|varying|in|out|attribute)\s+)"
            rf"{_DECLARED}(\w+)\s+(\w+)\s*(\[[^\]]*\])?\s*(=[^;]*)?;"
        )
        for m in re.finditer(pattern, bare, re.M):
            if m[3].startswith(("sampler", "isampler", "usampler", "image")):
                # Sets are Vulkan's; bindings mean nothing here
                if placed := re.match(layout, m[1]):
                    edits.append((m.start(1), m.start(1) + placed.end(), ""))
                continue
            if depth(bare, m.start()) == 0:
                edits.append((m.start(1), m.end(1), ""))
                if m[2] not in ("out",):
                    numbers = tuple(float(x) for x in re.findall(r"(?<!\w)-?\d+\.?\d*", m[6] or ""))
                    found.append(Variable(m[4], m[3], array=(m[5] or "")[1:-1], default=numbers))
        for m in re.finditer(rf"{layout}uniform\s+\w+\s*(\{{)([^}}]*)(\}})\s*;", bare):
            edits += [(m.start(), m.end(1), ""), (m.start(3), m.end(), "")]
            found += [v for v in members_in(m[2], language) if not v.array]
        # A block with a name of its own is a struct
        kind = r"(?:(?:readonly|restrict|coherent)\s+)*(?:uniform|buffer)"
        for m in re.finditer(rf"{layout}{kind}\s+(\w+)\s*\{{([^}}]*)\}}\s*(\w+)\s*;", bare):
            edits.append((m.start(), m.start(1), "struct "))
            edits.append((m.start(3), m.start(3), f"; {m[1]} "))
            found.append(Variable(m[3], m[1]))
    else:
        for m in re.finditer(
            r"\bcbuffer\s+\w+\s*(?::\s*register\s*\([^)]*\)\s*)?(\{)([^}]*)(\}\s*;?)", bare
        ):
            edits += [(m.start(), m.end(1), ""), (m.start(3), m.end(3), "")]
            for member in re.finditer(r"(\w+)\s+(\w+)\s*(?::[^;]*)?(\[[^\]]*\])?\s*;", m[2]):
                start = m.start(2) + member.start()
                edits.append((start, start, "static "))
                found.append(Variable(member[2], member[1], array=(member[3] or "")[1:-1]))
        for m in re.finditer(
            r"(?:^|(?<=;))[ \t]*((?:uniform\s+)?)((?:float|half|int|bool|uint)[1-4]?)\s+(\w+)\s*"
            r"(?::\s*register\s*\([^)]*\)\s*)?;",
            bare,
            re.M,
        ):
            if depth(bare, m.start()) == 0:
                edits.append((m.start(1), m.end(1), "static "))
                found.append(Variable(m[3], m[2]))
    for start, end, new in sorted(edits, reverse=True):
        kept = "\n" * text[start:end].count("\n")
        text = text[:start] + new + kept + text[end:]
        bare = bare[:start] + new + kept + bare[end:]
    return bare, text, found


def _wgsl_uniforms(bare: str, text: str) -> tuple[str, str, list[Variable]]:
    found: list[Variable] = []
    edits = []
    for m in re.finditer(
        r"(?:@group\s*\(\s*\d+\s*\)\s*|@binding\s*\(\s*\d+\s*\)\s*)*"
        r"var\s*<\s*uniform\s*>\s*(\w+)\s*:\s*([\w<>, ]+?)\s*;",
        bare,
    ):
        edits.append((m.start(), m.end(), f"var<private> {m[1]}: {m[2]};"))
        found.append(Variable(m[1], plain_type(m[2])))
    for start, end, new in sorted(edits, reverse=True):
        new += "\n" * text[start:end].count("\n")
        text = text[:start] + new + text[end:]
        bare = bare[:start] + new + bare[end:]
    return bare, text, found


def _without_main(bare: str, text: str) -> tuple[str, str]:
    """A shader without its entry, whose lines stay empty."""
    for match in re.finditer(r"\bvoid\s+main\s*\(\s*(?:void)?\s*\)\s*\{", bare):
        end = closing(bare, match.end() - 1, "{", "}")
        empty = re.sub(r"[^\n]", " ", text[match.start() : end])
        bare = bare[: match.start()] + empty + bare[end:]
        text = text[: match.start()] + empty + text[end:]
    return bare, text
