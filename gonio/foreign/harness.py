"""The text around foreign code that calls it for each row of numbers, in each language.

The user's text keeps its lines, so that compilers complain about these. A row of inputs holds the numbers
of all leaves one after the other, a row of outputs holds three.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from gonio.foreign.declarations import Function, Variable
from gonio.foreign.loops import COUNTER, CUT, TURNS, counted
from gonio.foreign.python_code import job
from gonio.foreign.roles import (
    MADE_OF,
    MEMBERS,
    Leaf,
    Matched,
    constructor,
    direction_of,
    is_role,
    leaves_of,
)
from gonio.foreign.sampled import NOTHING
from gonio.foreign.source import FILE_LINES, SHADERS, ForeignError, Source

# Of a value the first three; of a sample its direction and density.
OUTPUTS = 4

# Lines of the harness itself are counted as those of this file: complaints are about the signature.
OWN = 999


@dataclass(frozen=True)
class Spelling:
    """How a language spells what the harness needs."""

    read: str
    write: str
    declaration: str = "{type} {name};"
    result: str = "{type} gonio_result = {call};"
    whole: str = "{type}({value})"
    flag: str = "({value} != 0.0)"


SPELLINGS = {
    "glsl": Spelling("gonio_texel{texel}.{component}", "gonio_made.{component} = {value};"),
    "slang": Spelling("x[i + {column}]", "y[o + {row}] = {value};", whole="({type})({value})"),
    "wgsl": Spelling(
        "gonio_x[i + {column}u]",
        "gonio_y[o + {row}u] = {value};",
        "var {name}: {type};",
        "let gonio_result = {call};",
    ),
    "cpp": Spelling("x[{column}]", "y[{row}] = {value};", whole="({type})({value})"),
}
_LIKE = {
    "essl": "glsl",
    "brdf": "glsl",
    "hlsl": "slang",
    "msl": "cpp",
    "cuda": "cpp",
    "library": "cpp",
    "osl": "cpp",
}


def statements(source: Source, function: Function, matched: Matched) -> list[str]:
    """Read one row, call the function, write one row.

    Raises:
        ForeignError: it returns something that is neither a number nor a colour.
    """
    language = source.language
    spelling = SPELLINGS[_LIKE.get(language, language)]
    lines: list[str] = []
    names = {}
    for k, argument in enumerate(function.arguments):
        names[argument.name] = f"gonio_a{k}"
        lines.append(_declare(source, argument, f"gonio_a{k}", spelling))
        if argument.written and not argument.array and not argument.pointer:
            lines += _zeroed(source, argument, f"gonio_a{k}", spelling)
    maker = constructor(source, function) if function.owner else None
    parts = [f"gonio_made_{a.name}" for a in maker.arguments] if maker else []
    for argument, part in zip(maker.arguments if maker else (), parts, strict=True):
        lines.append(_declare(source, argument, part, spelling))
    object_: list[str] = []
    if maker:
        form = (
            "{0} gonio_self = {0}({1});" if source.language == "slang" else "{0} gonio_self({1});"
        )
        object_.append(form.format(function.owner, ", ".join(parts)))
    elif function.owner:
        object_.append(
            _declare(source, Variable("gonio_self", function.owner), "gonio_self", spelling)
        )
    column = 0
    for leaf, _ in matched.leaves:
        root, dot, rest = leaf.place.partition(".")
        place = f"{names[root]}{dot}{rest}" if root in names else leaf.place
        if leaf.place.startswith(MADE_OF):
            place = f"gonio_made_{rest}"
        numbers = [
            spelling.read.format(column=c, texel=c // 4, component="xyzw"[c % 4])
            for c in range(column, column + leaf.width)
        ]
        own_member = leaf.place.startswith(MEMBERS)
        (object_ if own_member else lines).extend(_set(leaf, place, numbers, language, spelling))
        column += leaf.width
    lines += object_
    given = ", ".join(
        f"&{names[a.name]}" if a.address or (a.pointer and language == "wgsl") else names[a.name]
        for a in function.arguments
    )
    call = f"{function.name}({given})"
    if function.owner:
        # Named with its class, so that no table of virtual functions is needed
        own = f"{function.owner}::" if language in ("cpp", "cuda") else ""
        call = f"gonio_self.{own}{call}"
    if function.returns == "void":
        lines.append(f"{call};")
    else:
        lines.append(spelling.result.format(type=function.returns, call=call))
    found = _sampled if matched.kind == "sample" else _result
    return lines + [
        spelling.write.format(row=k, component="xyzw"[k], value=part)
        for k, part in enumerate(found(source, function, names))
    ]


def _zeroed(source: Source, argument: Variable, name: str, spelling: Spelling) -> Iterable[str]:
    """What a function adds to begins at 0."""
    try:
        leaves = list(leaves_of(source, argument))
    except ForeignError:
        return
    for leaf in leaves:
        place = name + leaf.place.removeprefix(argument.name)
        yield from _set(leaf, place, ["0.0"] * leaf.width, source.language, spelling)


# Objects of C++, whose constructors may want arguments: zeros then, and the harness sets the members.
MADE = """#include <new>
#include <type_traits>
template <class T, bool = std::is_default_constructible<T>::value> struct gonio_maker {
    static T& at(void* place) { return *new (place) T(); }
};
template <class T> struct gonio_maker<T, false> { static T& at(void* p) { return *static_cast<T*>(p); } };
"""


def _declare(source: Source, argument: Variable, name: str, spelling: Spelling) -> str:
    object_ = source.language in ("cpp", "cuda") and not argument.array and not argument.pointer
    if object_ and source.structs.get(argument.type.rpartition("::")[2]):
        kind = argument.type
        return (
            f"alignas({kind}) unsigned char {name}_bytes[sizeof({kind})] = {{}}; "
            f"{kind}& {name} = gonio_maker<{kind}>::at({name}_bytes);"
        )
    if argument.array or (argument.pointer and "wgsl" not in argument.type):
        kind = re.sub(r"^ptr<\w+,(.*)>$", r"\1", argument.type)
        if kind != argument.type:
            return spelling.declaration.format(type=kind, name=name)
        return f"{argument.type} {name}[{argument.array or 3}];"
    return spelling.declaration.format(type=argument.type, name=name)


def _components(leaf: Leaf) -> tuple[str, ...]:
    return leaf.components or tuple(f".{c}" for c in "xyzw"[: leaf.width])


def _set(
    leaf: Leaf, place: str, numbers: Sequence[str], language: str, spelling: Spelling
) -> Iterable[str]:
    if leaf.components:
        return [f"{place}{c} = {n};" for c, n in zip(leaf.components, numbers, strict=True)]
    if leaf.width == 1:
        pattern = spelling.flag if leaf.type.endswith("bool") else spelling.whole
        return [f"{place} = {pattern.format(type=leaf.type, value=numbers[0])};"]
    if language == "cuda" and re.fullmatch(r"float[234]", leaf.type):
        return [f"{place} = make_{leaf.type}({', '.join(numbers)});"]
    if language in ("cpp", "cuda", "library"):  # braces fill structs of templates as well
        return [f"{place} = {leaf.type}{{{', '.join(numbers)}}};"]
    return [f"{place} = {leaf.type}({', '.join(numbers)});"]


def _outputs(
    source: Source, function: Function, names: Mapping[str, str]
) -> list[tuple[Leaf, str]]:
    """The numbers that a function gives back, and where they are after the call."""
    found: list[tuple[Leaf, str]] = []
    if function.returns != "void":
        returned = Variable("gonio_result", function.returns)
        found = [(leaf, leaf.place) for leaf in leaves_of(source, returned)]
    for argument in function.arguments:
        if argument.written:
            for leaf in leaves_of(source, argument):
                found.append((leaf, names[argument.name] + leaf.place.removeprefix(argument.name)))
    return found


def judged(source: Source, function: Function) -> list[str]:
    """Names of the colours or numbers whose sum is a value, where there are several."""
    names = {a.name: a.name for a in function.arguments}
    try:
        lines = _result(source, function, names)
    except ForeignError:
        return []
    parts = [re.sub(r"(?:\.[xr]|\[0\]|\.\w+\[0\])$", "", p) for p in lines[0].split(" + ")]
    return [p.removeprefix("gonio_result.") for p in parts] if len(parts) > 1 else []


def _parts(leaf: Leaf, where: str) -> list[str]:
    return [where] if leaf.width == 1 else [where + c for c in _components(leaf)]


def _result(source: Source, function: Function, names: Mapping[str, str]) -> list[str]:
    """The three numbers of a value: what is returned, or written if nothing is."""
    try:
        found = _outputs(source, function, names)
    except ForeignError:
        found = []
    if function.returns != "void":
        found = [pair for pair in found if pair[1].startswith("gonio_result")]
    # Beside colours, numbers are widths and densities, and directions are those of samples
    colours = [p for p in found if p[0].width >= 3 and not direction_of(p[0])]
    numbers = [p for p in found if p[0].width == 1]
    summed = colours or (numbers if function.returns == "void" else [])
    if len(found) > 1 and summed:
        # Several colours are written, the diffuse and the specular one mostly: their sum
        each = [_parts(*pair)[:3] for pair in summed]
        return [" + ".join(c[k % len(c)] for c in each) for k in range(3)]
    if len(found) != 1 or found[0][0].width == 2:
        raise ForeignError(
            f"{source.path}: {function.signature} gives back {function.returns}, which is neither a number "
            "nor a colour, nor a struct with one; write a function that returns one of them."
        )
    parts = _parts(*found[0])
    return parts * 3 if len(parts) == 1 else parts[:3]


def _sampled(source: Source, function: Function, names: Mapping[str, str]) -> list[str]:
    """The direction of a sample, and its density if it gives one back.

    Raises:
        ForeignError: it gives back no direction.
    """
    found = _outputs(source, function, names)
    if len(found) == 1 and found[0][0].width == 4:
        return _parts(*found[0])
    vectors = [pair for pair in found if pair[0].width == 3]
    numbers = [pair for pair in found if pair[0].width == 1]
    named = [p for p in vectors if is_role(p[0].place, "wi")]
    returned = [p for p in vectors if p[1] == "gonio_result"]
    chosen = named or (returned if len(vectors) > 1 else []) or vectors
    if not chosen:
        raise ForeignError(f"{source.path}: {function.signature} gives back no direction.")
    densities = [p for p in numbers if re.search(r"pdf|dens|prob", p[0].place, re.I)]
    # What is whole says whether there is a sample, or which lobe it is of
    real = [p for p in numbers if not p[0].whole]
    densities = densities or (real if len(real) == 1 else [])
    return _parts(*chosen[0])[:3] + [p[1] for p in densities[:1]]


def text(source: Source, function: Function, matched: Matched, defines: Sequence[str]) -> str:
    """The whole text that is compiled."""
    if source.language == "python":
        return job(source, function, matched)
    lines = statements(source, function, matched)
    if source.language in SHADERS:
        return _fragment(source, matched, lines, defines)
    if source.language == "wgsl":
        return _wgsl(source, matched, lines, defines)
    if source.language in ("hlsl", "slang"):
        return (
            f'#line 1 "{source.path.name}"\n{source.text}\n#line 1 "harness"\n'
            "export __extern_cpp void gonio_run(float* x, float* y, int rows)\n{\n"
            "    for (int row = 0; row < rows; ++row)\n    {\n"
            f"        int i = row * {matched.columns};\n        int o = row * {OUTPUTS};\n"
            f"{_indented(lines, 8)}\n    }}\n}}\n"
        )
    scopes = [s for s in function.scope if s != function.owner]
    head = f'#include "{source.path.resolve()}"\n'
    if source.language == "msl" or NOTHING in source.text:
        head = f'#line 1 "{source.path.resolve()}"\n{source.text}\n'
    if source.language == "osl":
        place = f'#line 1 "{source.path.resolve()}"'
        head = f"namespace osl {{\n{place}\n{source.text}\n}}\nusing namespace osl;\n"
    return (
        f'{head if source.language != "library" else ""}#line 1 "harness"\n'
        f"{MADE if source.language in ('cpp', 'cuda') else ''}"
        f"{''.join(f'namespace {s} {{ ' for s in scopes)}\n"
        "static void gonio_call(const float* x, float* y) {\n"
        f"{_indented(lines, 4)}\n}}\n{'}' * len(scopes)}\n"
        'extern "C" void gonio_run(const float* x, float* y, int rows) {\n'
        f"    for (int row = 0; row < rows; ++row, x += {matched.columns}, y += {OUTPUTS}) {{\n"
        f"        {''.join(f'{s}::' for s in scopes)}gonio_call(x, y);\n    }}\n}}\n"
    )


def _indented(lines: Iterable[str], spaces: int) -> str:
    return "\n".join(" " * spaces + line for line in lines)


def _fragment(
    source: Source, matched: Matched, lines: Sequence[str], defines: Sequence[str]
) -> str:
    """A fragment shader whose pixel is one row, as in gonio.export.prove.opengl."""
    es = source.language == "essl"
    head = (
        "#version 300 es\nprecision highp float;\nprecision highp int;\n"
        if es
        else "#version 450\n"
    )
    if re.search(r"\btexture(2D|Cube)\b", source.text):
        head += "#define texture2D texture\n#define textureCube texture\n"
    for define in defines:
        name, _, value = define.partition("=")
        head += f"#define {name} {value or 1}\n"
    if source.language == "brdf":
        head += "".join(f"{u.type} {u.name};\n" for u in source.uniforms if u.default)
    texels = -(-matched.columns // 4)
    fetched = [
        f"vec4 gonio_texel{k} = "
        f"texelFetch(gonio_rows, gonio_pixel * ivec2({texels}, 1) + ivec2({k}, 0), 0);"
        for k in range(texels)
    ]
    body = [
        "ivec2 gonio_pixel = ivec2(gl_FragCoord.xy);",
        *fetched,
        "gonio_made = vec4(1.0, 1.0, 1.0, -1.0);",
        *lines,
        f"if ({COUNTER} > {TURNS}) {{ gonio_made.w = {CUT}; }}",
    ]
    return (
        f"{head}int {COUNTER} = 0;\n"
        f"#line 1\n{counted(source.text, source.language)}\n#line {OWN * FILE_LINES}\n"
        f"uniform highp sampler2D gonio_rows;\nlayout(location = 0) out vec4 gonio_made;\n"
        f"void main() {{\n{_indented(body, 4)}\n}}\n"
    )


def _wgsl(source: Source, matched: Matched, lines: Sequence[str], defines: Sequence[str]) -> str:
    if defines:
        raise ForeignError(f"{source.path}: WGSL has no preprocessor; -D means nothing to it.")
    return (
        f"{counted(source.text, source.language)}\n"
        f"var<private> {COUNTER}: i32;\n"
        "@group(0) @binding(0) var<storage, read> gonio_x: array<f32>;\n"
        "@group(0) @binding(1) var<storage, read_write> gonio_y: array<f32>;\n\n"
        "@compute @workgroup_size(64)\n"
        "fn gonio_main(@builtin(global_invocation_id) id: vec3u) {\n"
        f"    if (id.x >= arrayLength(&gonio_y) / {OUTPUTS}u) {{\n        return;\n    }}\n"
        f"    let i = id.x * {matched.columns}u;\n    let o = id.x * {OUTPUTS}u;\n"
        f"{_indented(lines, 4)}\n"
        f"    if ({COUNTER} > {TURNS}) {{\n        gonio_y[o + 3u] = {CUT};\n    }}\n}}\n"
    )
