"""Code that others wrote, in the page: its own text, and around it what the page's passes call.

GLSL and .brdf files run as they stand in WebGL2, WGSL in WebGPU. The page samples them by a rule of its
own, for values are all that such code has. Other languages have no compiler in a browser.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gonio.export.manifest import kind, scale, soft_range
from gonio.export.print_expressions import number
from gonio.fields import Parameter
from gonio.files import Stamps, stamps
from gonio.foreign import Foreign, ForeignError, as_model, load
from gonio.foreign.expressions import CONSTANTS
from gonio.foreign.function import split
from gonio.foreign.harness import OWN, statements
from gonio.foreign.model import ForeignModel
from gonio.foreign.roles import COSINES, DIRECTIONS, Leaf
from gonio.foreign.source import ENDINGS, FILE_LINES
from gonio.model import Model

# What runs in a browser, by the language of a file: the page's name of it.
RUNS = {"glsl": "essl", "essl": "essl", "brdf": "essl", "wgsl": "wgsl"}

NAMES = {"essl": "GLSL", "wgsl": "WGSL"}

# Names that the passes call, which the code may have as well.
_TAKEN = re.compile(r"\b(Model(?:Sample)?|model_\w+)\b")

Loader = Callable[[str], Foreign]


def check_runs(text: str) -> None:
    """Refuse code that no browser can run.

    Raises:
        ForeignError: what to do instead.
    """
    file = split(text)[0]
    if ENDINGS.get(Path(file).suffix.lstrip(".").lower()) not in RUNS:
        raise ForeignError(
            f"{file} is in a language that no browser compiles; the page runs .glsl, .frag, .essl, .brdf "
            "and .wgsl as they stand, and 'gonio plot' draws the others."
        )


@dataclass
class Code:
    """Functions of files by the names that the page calls them by; read again when a file has changed."""

    read: Loader = load
    defines: Sequence[str] = ()
    """Macros of all of them, NAME or NAME=VALUE."""

    def __post_init__(self) -> None:
        """Nothing is read yet."""
        self._known: dict[str, tuple[Stamps, Model]] = {}

    def model(self, name: str) -> Model:
        """A function as a model.

        Raises:
            ForeignError: anything that does not work, in one line.
        """
        seen, model = self._known.get(name, ({}, None))
        if model is None or stamps(seen) != seen:
            check_runs(name)
            foreign = self.read(name)
            if foreign.source.textures:
                raise ForeignError(
                    f"{name} reads textures, which the page does not bind; 'gonio plot' and 'gonio check' "
                    "take --texture NAME=FILE."
                )
            model = as_model(foreign)
            self._known[name] = (stamps(foreign.source.files), model)
        return model

    def files(self, name: str) -> tuple[Path, ...]:
        """The files that a function is read from, as far as they are known."""
        return tuple(self._known[name][0]) if name in self._known else (Path(split(name)[0]),)


def payload(
    text: str, name: str, model: ForeignModel, defines: Sequence[str] = ()
) -> dict[str, Any]:
    """What the page needs to show a function, as `gonio.view.page.payload` has it for models."""
    foreign = model.foreign
    language = RUNS[foreign.source.language]
    rows = [_parameter(path, declared, value) for path, declared, value in model.parameters()]
    plain = model.written()
    return {
        "text": text,
        "name": name,
        "model": foreign.name,
        "title": f"{foreign.function.name}: {foreign.source.path.name}",
        "description": f"{NAMES[language]} that others wrote, as it stands in the file.",
        "plain": True,
        "parameters": rows,
        "options": [],
        "models": [],
        "hooks": [],
        "maps": None,
        "members": [row["path"] for row in rows],
        "start": {path: value for path, _, value in plain.parameters()},
        "code": {language: code(foreign, defines)},
        "load": {language: loader(foreign)},
        "foreign": {
            "language": NAMES[language],
            "text": foreign.source.path.read_text(encoding="utf-8", errors="replace"),
        },
        "about": [_about(foreign)],
    }


def _parameter(path: str, declared: Parameter, value: Any) -> dict[str, Any]:
    low, high = soft_range(declared)
    numbers = [
        [float(v) for v in (x if isinstance(x, tuple) else (x,) * declared.width)]
        for x in (value, declared.default)
    ]
    return {
        "path": path,
        "width": declared.width,
        "kind": kind(declared),
        "value": numbers[0],
        "default": numbers[1],
        "low": declared.low,
        "high": declared.high,
        "soft_low": low,
        "soft_high": high,
        "scale": scale(declared),
        "doc": declared.doc,
        "used": True,
    }


def _about(foreign: Foreign) -> dict[str, Any]:
    """What was taken for what, for people."""
    taken = foreign.matched.explained()
    return {
        "name": foreign.name,
        "title": foreign.name,
        "description": f"{foreign.function.signature}\n\n"
        f"It is called with {taken}, and its value is taken for {foreign.returns}.\n\n"
        "The page draws half of its directions around the normal by the cosine, and half by half vectors "
        "that crowd around it; pdf and weights are of these. What is no finite number is drawn as 0.",
        "source": "",
        "claims": [],
        "caveats": [
            "nothing is promised: 'gonio check' measures energy, reciprocity and finite values",
            *foreign.matched.notes,
        ],
    }


# --- text ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Spelling:
    """How one of the two languages spells what stands around the code."""

    number: str
    vector: str
    struct: str
    member: str
    value: str
    local: str
    load: str
    loaded: str


ESSL = _Spelling(
    number="float",
    vector="vec3",
    struct="struct Model {{ {members} }};",
    member="{type} {name};",
    value="vec3 model_value(Model gonio_m, vec3 gonio_wi, vec3 gonio_wo)",
    local="{type} {name} = {value};",
    load="Model model_load(vec4 values[{count}])",
    loaded="Model loaded;",
)
WGSL = _Spelling(
    number="f32",
    vector="vec3f",
    struct="struct Model {{ {members} }}",
    member="{name}: {type},",
    value="fn model_value(gonio_m: Model, gonio_wi: vec3f, gonio_wo: vec3f) -> vec3f",
    local="let {name}: {type} = {value};",
    load="fn model_load(values: array<vec4f, {count}>) -> Model",
    loaded="var loaded: Model;",
)
SPELLINGS = {"essl": ESSL, "wgsl": WGSL}


def code(foreign: Foreign, defines: Sequence[str] = ()) -> str:
    """The file's text, then a struct of its parameters and `model_value`, which calls the function."""
    macros = [(name, value or "1") for name, _, value in (d.partition("=") for d in defines)]
    source = foreign.source
    language = RUNS[source.language]
    spell = SPELLINGS[language]
    own = _TAKEN.sub(r"\1_user", source.text)
    types = [
        spell.member.format(type=_type(spell, p.width), name=f"p{k}")
        for k, p in enumerate(foreign.parameters.values())
    ]
    members = " ".join(types or [spell.member.format(type=spell.number, name="none")])
    numbers = list(_numbers(foreign, spell))
    calls = [
        _TAKEN.sub(r"\1_user", line)
        for line in statements(source, foreign.function, foreign.matched)
    ]
    returned = "gonio_found" + (
        "" if foreign.returns.factor == 1 else f" / {number(foreign.returns.factor, '')}"
    )
    if foreign.returns.cosine:
        returned += " / max(gonio_wi.z, 1.0e-12)"
    declared = " ".join(f"{u.type} {u.name};" for u in source.uniforms if u.default)
    text = [own]
    if language == "essl":
        text = [
            *(f"#define {name} {value}" for name, value in macros),
            # Parameters of a .brdf file are declared by what reads it
            declared if source.language == "brdf" else "",
            "#line 1",
            own,
            f"#line {OWN * FILE_LINES}",
        ]
    text += [
        spell.struct.format(members=members),
        spell.value + " {",
        *_roles(foreign, spell),
    ]
    if language == "essl":
        padded = numbers + ["0.0"] * (-len(numbers) % 4)
        text += [
            f"vec4 gonio_texel{k} = vec4({', '.join(padded[4 * k : 4 * k + 4])});"
            for k in range(len(padded) // 4)
        ]
        text += ["vec4 gonio_made = vec4(1.0);", *calls, "vec3 gonio_found = gonio_made.xyz;"]
    else:
        count = max(len(numbers), 1)
        text += [
            f"let gonio_x = array<f32, {count}>({', '.join(numbers) or '0.0'});",
            "var gonio_y: array<f32, 4>;",
            "let i = 0u;",
            "let o = 0u;",
            *calls,
            "let gonio_found = vec3f(gonio_y[0], gonio_y[1], gonio_y[2]);",
        ]
    text += [f"return {returned};", "}"]
    # Macros of the code end with it, and what it says of precisions
    if language == "essl":
        names = [name for name, _ in macros]
        names += re.findall(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", source.text, re.M)
        text += ["precision highp float;", "precision highp int;"]
        text += [f"#undef {name}" for name in dict.fromkeys(names)]
    return "\n".join(text) + "\n"


def loader(foreign: Foreign) -> str:
    """The parameters from an array of vectors, as `gonio.export.manifest.loader` has it."""
    spell = SPELLINGS[RUNS[foreign.source.language]]
    widths = [p.width for p in foreign.parameters.values()]
    lines = [
        f"    loaded.p{k} = values[{k}].{'xyz'[:width]};" for k, width in enumerate(widths)
    ] or ["    loaded.none = 0.0;"]
    head = spell.load.format(count=max(1, len(widths)))
    return "\n".join([f"{head} {{", f"    {spell.loaded}", *lines, "    return loaded;", "}", ""])


def _type(spell: _Spelling, width: int) -> str:
    return spell.vector if width == 3 else spell.number


_AXES = {"normal": "0.0, 0.0, 1.0", "tangent": "1.0, 0.0, 0.0", "bitangent": "0.0, 1.0, 0.0"}

# Cosines of names such as "cos_tangent_h", by the directions between which they are.
_BETWEEN = {"i": "wi", "o": "wo", "h": "half"}


def _roles(foreign: Foreign, spell: _Spelling) -> Iterable[str]:
    """Directions and cosines that the formulas name, as locals."""
    used = {n for _, e in foreign.matched.leaves for n in e.names}

    def local(name: str, kind: str, value: str) -> str:
        return spell.local.format(type=kind, name=f"gonio_{name}", value=value)

    for name, axis in _AXES.items():
        if name in used:
            yield local(name, spell.vector, f"{spell.vector}({axis})")
    if any(n == "half" or n == "cos_d" or n.endswith("_h") for n in used):
        yield local("half", spell.vector, "normalize(gonio_wi + gonio_wo)")
    for name in COSINES:
        if name not in used:
            continue
        last = name.rpartition("_")[2]
        axis = "xy"["bitangent" in name] if "tangent" in name else "z"
        value = f"gonio_{_BETWEEN[last]}.{axis}" if last in _BETWEEN else ""
        yield local(
            name,
            spell.number,
            {"cos_d": "dot(gonio_wi, gonio_half)", "cos_v": "dot(gonio_wi, gonio_wo)"}.get(
                name, value
            ),
        )


def _numbers(foreign: Foreign, spell: _Spelling) -> Iterable[str]:
    """The numbers of all leaves, one after the other, as `Foreign.rows` has them."""
    places = {name: f"gonio_m.p{k}" for k, name in enumerate(foreign.parameters)}
    widths = {name: p.width for name, p in foreign.parameters.items()}
    widths |= dict.fromkeys(DIRECTIONS, 3)
    for leaf, expression in foreign.matched.leaves:
        text, width = _spelled(expression.tree, spell, places, widths)
        yield from _spread(foreign, leaf, expression.text, text, width)


def _spread(foreign: Foreign, leaf: Leaf, formula: str, text: str, width: int) -> Iterable[str]:
    if leaf.width == 1:
        if width > 1:
            raise ForeignError(
                f"{foreign.name}: {leaf.place} is one number, but {formula!r} is a vector."
            )
        yield text
    elif width == 1:
        yield from [text] * leaf.width
    else:
        parts = [f"({text}).{c}" for c in "xyzw"[:width]]
        yield from [*parts, "1.0"][: leaf.width]


_SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


def _spelled(
    node: ast.expr, spell: _Spelling, places: Mapping[str, str], widths: Mapping[str, int]
) -> tuple[str, int]:
    """A formula of `gonio.foreign.expressions` in the language, and how many numbers it has."""
    if isinstance(node, ast.Constant):
        return number(float(node.value), ""), 1  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        if node.id in CONSTANTS:
            return number(CONSTANTS[node.id], ""), 1
        return places.get(node.id, f"gonio_{node.id}"), widths.get(node.id, 1)
    parts = [
        _spelled(child, spell, places, widths)
        for child in ast.iter_child_nodes(node)
        if isinstance(child, ast.expr) and not (isinstance(node, ast.Call) and child is node.func)
    ]
    texts, wide = [text for text, _ in parts], max((w for _, w in parts), default=1)
    if isinstance(node, ast.UnaryOp):
        return f"({'-' if isinstance(node.op, ast.USub) else ''}{texts[0]})", wide
    if isinstance(node, ast.Tuple):
        kind = {2: "vec2", 3: "vec3", 4: "vec4"}[len(texts)] + ("f" if spell is WGSL else "")
        return f"{kind}({', '.join(texts)})", len(texts)
    if isinstance(node, ast.Attribute):
        return f"({texts[0]}).{node.attr}", 1
    if isinstance(node, ast.BinOp) and type(node.op) in _SIGNS:
        return f"({texts[0]} {_SIGNS[type(node.op)]} {texts[1]})", wide
    if isinstance(node, ast.BinOp):  # a power; of a negative number too, where it is a whole one
        exponent = node.right
        for count in (2, 3, 4):
            if isinstance(exponent, ast.Constant) and exponent.value == count:
                return f"({' * '.join([texts[0]] * count)})", wide
        name = "pow"
    else:
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        name = node.func.id
    if name == "dot":
        return f"dot({', '.join(texts)})", 1
    if name in ("min", "max", "pow") and wide > 1:
        texts = [t if w == wide else f"{spell.vector}({t})" for t, w in parts]
    return f"{name}({', '.join(texts)})", wide
