"""MaterialX: a document that declares a model as a BSDF node, and GLSL that implements it.

MaterialX puts node code into the shaders that it generates: as it stands for GLSL and GLSL ES, rewritten
word by word for Metal and Slang. The code is therefore written with what these languages share, in the
target `PORTABLE` below. MaterialX's OSL and MDL know only closures of their renderers, not code that
computes a BRDF; the node has no implementation there. docs/materialx.md says how to use the files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any
from xml.sax.saxutils import quoteattr

from gonio.description.about import summary
from gonio.export.comments import plain_text
from gonio.export.entry import Export
from gonio.export.names import legal
from gonio.export.print_expressions import number
from gonio.export.printer import INDENT, fold
from gonio.export.targets import ESSL, GLSL_WORDS, HLSL_WORDS, MSL_WORDS, SLANG_WORDS
from gonio.export.text import export
from gonio.export.tree import SELF, ExportError
from gonio.fields import Parameter
from gonio.model import Model
from gonio.version import __version__

NAME = "mtlx"

VERSION = "1.39"

# What a node needs of a model.
NEEDED = ("eval", "sample")

# A node's inputs and output besides the model's parameters.
TAKEN = ("weight", "normal", "tangent", "out")

# Words that MaterialX's shaders define as types or macros, or that its generators rewrite.
MATERIALX_WORDS = frozenset({"BSDF", "EDF", "VDF", "material", "mix", "fract", "vd"})

# Names that the function of a node uses, which a parameter of it must not hide.
LOCALS = frozenset({"closureData", "bsdf", SELF, "N", "X", "V", "T", "B", "wo"}) | frozenset(
    {"clamp", "cross", "dot", "max", "float"}
)

# Ranges that span more than this get a shorter slider.
WIDE = 100.0


def _compare(name: str, operator: str) -> str:
    parts = ", ".join(f"a.{c} {operator} b.{c}" for c in "xyz")
    return f"bvec3 {{p}}_{name}(vec3 a, vec3 b) {{\n    return bvec3({parts});\n}}\n"


_COMPARISONS = {
    "<": "less",
    "<=": "less_equal",
    ">": "greater",
    ">=": "greater_equal",
    "==": "equal",
    "!=": "not_equal",
}

# Metal has no struct(...), and neither Metal nor Slang has GLSL's functions on masks.
PORTABLE = replace(
    ESSL,
    name=NAME,
    title="GLSL for MaterialX",
    extension="glsl",
    reserved=GLSL_WORDS | HLSL_WORDS | MSL_WORDS | SLANG_WORDS | MATERIALX_WORDS,
    note="MaterialX puts it into the shaders that it generates for GLSL, GLSL ES, Metal and Slang.",
    record="",
    select_computed="",
    select3="{p}_select({0}, {1}, {2})",
    comparisons={op: f"{{p}}_{name}({{0}}, {{1}})" for op, name in _COMPARISONS.items()},
    helpers={name: _compare(name, op) for op, name in _COMPARISONS.items()}
    | {
        "select": "vec3 {p}_select(bvec3 mask, vec3 yes, vec3 no) {\n"
        "    return vec3(mask.x ? yes.x : no.x, mask.y ? yes.y : no.y, mask.z ? yes.z : no.z);\n}\n"
    },
)


def files(models: Mapping[str, Model]) -> dict[str, str]:
    """Texts by file name: for each model a document NAME.mtlx and the GLSL that it refers to.

    Raises:
        ExportError: what cannot be exported, with its place; a parameter that the node cannot have.
    """
    found = {}
    for name, model in models.items():
        node = _Node(name, model)
        found[f"{name}.mtlx"] = node.document()
        found[node.file] = node.source()
    return found


class _Node:
    """A model as a node of MaterialX."""

    def __init__(self, name: str, model: Model) -> None:
        self.name = name
        self.model = model
        self.function = f"gonio_{name}_bsdf"
        self.file = f"{self.function}.glsl"
        self.anisotropic = model.follows_tangents()
        self.inputs: dict[str, tuple[str, Parameter, Any]] = {}
        for path, declared, value in model.parameters():
            input_name = path.replace(".", "_")
            if input_name in TAKEN or input_name in self.inputs:
                raise ExportError(
                    f"{name}: a MaterialX node has another input {input_name!r}; rename {path}."
                )
            self.inputs[input_name] = (path, declared, value)

    @cached_property
    def export(self) -> Export:
        """The model's functions."""
        return export({self.name: self.model}, PORTABLE, only=NEEDED)[0]

    # --- the document ------------------------------------------------------------------------------

    def document(self) -> str:
        """The .mtlx file."""
        name, function = self.name, self.function
        definition = {
            "name": f"ND_{function}",
            "node": function,
            "bsdf": "R",
            "nodegroup": "pbr",
            "doc": summary(self.model.written),
        }
        implementation = {
            "name": f"IM_{function}_genglsl",
            "nodedef": f"ND_{function}",
            "file": self.file,
            "function": function,
            "target": "genglsl",
        }
        surface = {"name": f"gonio_{name}_surface", "type": "surfaceshader"}
        lobe = {"name": f"gonio_{name}_reflection", "type": "BSDF"}
        bsdf = _tag("input", {"name": "bsdf", "type": "BSDF", "nodename": lobe["name"]})
        shader = _tag(
            "input", {"name": "surfaceshader", "type": "surfaceshader", "nodename": surface["name"]}
        )
        values = [
            _tag("input", {"name": key, "type": _type(declared), "value": _value(declared, value)})
            for key, (_, declared, value) in self.inputs.items()
        ]
        lines = [
            '<?xml version="1.0"?>',
            f'<materialx version="{VERSION}" colorspace="lin_rec709">',
            f"  <!-- Made by gonio {__version__}. Keep {self.file} beside this file. -->",
            "",
            *_element("nodedef", definition, [*self._inputs(), _OUTPUT]),
            "",
            "  <!-- GLSL, and through it GLSL ES, Metal and Slang. -->",
            *_element("implementation", implementation, []),
            "",
            "  <!-- An example. -->",
            *_element(function, lobe, values),
            *_element("surface", surface, [bsdf]),
            *_element("surfacematerial", {"name": f"gonio_{name}", "type": "material"}, [shader]),
            "</materialx>",
        ]
        return "\n".join(lines) + "\n"

    def _inputs(self) -> Iterator[str]:
        """What the node takes, in the order in which MaterialX passes it to the function."""
        weight = Parameter(1.0, 0, 1, "how much of it there is")
        yield _tag("input", _parameter("weight", "weight", weight, 1.0))
        for name, (path, declared, value) in self.inputs.items():
            yield _tag("input", _parameter(name, path, declared, value))
        yield _tag("input", {"name": "normal", "type": "vector3", "defaultgeomprop": "Nworld"})
        if self.anisotropic:
            yield _tag("input", {"name": "tangent", "type": "vector3", "defaultgeomprop": "Tworld"})

    # --- the code ----------------------------------------------------------------------------------

    def source(self) -> str:
        """The .glsl file: the model's functions, and the node's."""
        entry = self.export.entry
        parameters = ["ClosureData closureData", "float weight"]
        fill = [f"{entry.struct} {SELF};"]
        places = {member.path: member.place for member in entry.members}
        for name, (path, declared, _) in self.inputs.items():
            local = legal(name, PORTABLE.reserved | LOCALS)
            kind = "vec3" if declared.width == 3 else "float"
            parameters.append(f"{kind} {local}")
            if path in places:
                fill.append(f"{SELF}.{places[path]} = {_limited(declared, local)};")
        parameters += ["vec3 N", *(["vec3 X"] if self.anisotropic else []), "inout BSDF bsdf"]
        frame = _TANGENT if self.anisotropic else _ANY_TANGENT
        wrapper = f"{frame}\n{_WRAPPER}".format(
            function=self.function,
            head=f"void {self.function}({', '.join(parameters)}) {{",
            fill="\n".join(INDENT + line for line in fill),
            arguments="N, X" if self.anisotropic else "N",
            prefix=entry.prefix,
            sample=entry.sample_struct,
        )
        lines = [
            line[: len(line) - len(line.lstrip())] + part
            for line in wrapper.splitlines()
            for part in ([line.lstrip()] if "//" in line else fold(line.lstrip()))
        ]
        return "\n".join([_INCLUDE, self.export.source, *lines]) + "\n"


# --- XML -------------------------------------------------------------------------------------------

_OUTPUT = '<output name="out" type="BSDF"/>'


def _attributes(values: Mapping[str, str]) -> str:
    return " ".join(f"{key}={quoteattr(plain_text(text))}" for key, text in values.items())


def _tag(tag: str, attributes: Mapping[str, str]) -> str:
    return f"<{tag} {_attributes(attributes)}/>"


def _element(tag: str, attributes: Mapping[str, str], children: list[str]) -> list[str]:
    """The lines of an element, inside the document."""
    start = f"  <{tag} {_attributes(attributes)}"
    if not children:
        return [f"{start}/>"]
    return [f"{start}>", *(f"    {child}" for child in children), f"  </{tag}>"]


def _type(declared: Parameter) -> str:
    return "color3" if declared.width == 3 else "float"


def _numbers(declared: Parameter, value: Any) -> tuple[float, ...]:
    if not isinstance(value, (int, float, tuple)):
        raise ExportError(f"{declared.name} is an array; give it one value.")
    return value if isinstance(value, tuple) else (value,) * declared.width


def _value(declared: Parameter, value: Any) -> str:
    return ", ".join(number(v, "") for v in _numbers(declared, value))


def _parameter(name: str, path: str, declared: Parameter, value: Any) -> dict[str, str]:
    """The attributes of an input."""
    found = {"name": name, "type": _type(declared), "value": _value(declared, value)}
    if declared.width == 3 and declared.high != 1:
        found["colorspace"] = "none"  # a physical quantity, such as an index of refraction
    found["uimin"] = _value(declared, declared.low)
    if math.isfinite(declared.high):
        found["uimax"] = _value(declared, declared.high)
    if declared.high - declared.low > WIDE:
        usual = 10 * max(declared.low, *_numbers(declared, value)) or 1.0
        found["uisoftmax"] = _value(declared, min(usual, declared.high))
    folder, _, last = path.rpartition(".")
    found["uiname"] = last.replace("_", " ").capitalize()
    if folder:
        found["uifolder"] = folder.replace(".", "/").replace("_", " ").title()
    return found | {"doc": f"{declared.doc}; {declared.range_text()}"}


# --- GLSL ------------------------------------------------------------------------------------------


def _limited(declared: Parameter, name: str) -> str:
    """An input within the parameter's range: a picture may hold anything."""
    low, high = number(declared.low, ""), ""
    if math.isfinite(declared.high):
        high = number(declared.high, "")
    limits = [f"vec3({end})" if declared.width == 3 else end for end in (low, high) if end]
    return f"{'clamp' if high else 'max'}({', '.join([name, *limits])})"


# Where MaterialX declares what it passes to a node. Its own search begins at the folder of its libraries.
_INCLUDE = '#include "libraries/pbrlib/genglsl/lib/mx_closure_type.glsl"\n'

_ANY_TANGENT = """\
// Any unit vector perpendicular to N: Duff et al., "Building an Orthonormal Basis, Revisited", 2017.
vec3 {function}_tangent(vec3 N) {{
    float side = N.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (side + N.z);
    return vec3(1.0 + side * N.x * N.x * a, side * N.x * N.y * a, -side * N.x);
}}
"""

_TANGENT = (
    _ANY_TANGENT.replace("_tangent", "_any_tangent")
    + """
// X without its part along N, as a unit vector; where a mesh has no tangents, any perpendicular one.
vec3 {function}_tangent(vec3 N, vec3 X) {{
    vec3 along = X - dot(X, N) * N;
    float squared = dot(along, along);
    bool usable = squared > 1.0e-6 * dot(X, X);
    return usable ? along / sqrt(squared) : {function}_any_tangent(N);
}}
"""
)

# MaterialX knows the surroundings as a picture with smaller and smaller versions of itself; its own lobes
# look up the directions that they sample in the same way.
_WRAPPER = """\
// The node {function} of MaterialX.
{head}
    bsdf.throughput = vec3(0.0);  // nothing reaches what is below
    if (weight < M_FLOAT_EPS) {{
        return;
    }}
{fill}
    vec3 V = closureData.V;
    N = mx_forward_facing_normal(N, V);
    vec3 T = {function}_tangent({arguments});
    vec3 B = cross(N, T);
    vec3 wo = vec3(dot(V, T), dot(V, B), dot(V, N));
    if (closureData.closureType == CLOSURE_TYPE_REFLECTION) {{
        vec3 L = closureData.L;
        vec3 wi = vec3(dot(L, T), dot(L, B), dot(L, N));
        float cosine = max(wi.z, 0.0);
        bsdf.response = {prefix}_eval(params, wi, wo) * (cosine * closureData.occlusion * weight);
    }} else if (closureData.closureType == CLOSURE_TYPE_INDIRECT) {{
        // Light from the surroundings: the model's own samples, each with a blurred look. MaterialX
        // replaces the words with a dollar sign.
        int count = $envRadianceSamples;
        vec3 total = vec3(0.0);
        for (int i = 0; i < count; ++i) {{
            {sample} drawn = {prefix}_sample(params, wo, mx_spherical_fibonacci(i, count));
            if (drawn.pdf > 0.0) {{
                vec3 wi = drawn.wi;
                vec3 L = clamp(wi.x * T + wi.y * B + wi.z * N, vec3(-1.0), vec3(1.0));
                float lod = mx_latlong_compute_lod(L, drawn.pdf, float($envRadianceMips - 1), count);
                vec3 light = mx_latlong_map_lookup(L, $envMatrix, lod, $envRadiance);
                total += light * {prefix}_eval(params, wi, wo) * (wi.z / drawn.pdf);
            }}
        }}
        bsdf.response = total * ($envLightIntensity * weight / float(max(count, 1)));
    }}
}}
"""
