"""MaterialX: a BSDF node or a material as the code that MaterialX generates for a renderer.

MaterialX writes a whole pixel shader, which is lit here by one light whose direction is an argument. What
the document sets at the node becomes a parameter; everything inside of node graphs keeps its value.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from gonio.foreign.declarations import Variable
from gonio.foreign.source import ForeignError, Source, of_text, swizzled
from gonio.messages import did_you_mean

# The library of MaterialX itself, in place of a file: materialx#oren_nayar_diffuse_bsdf.
LIBRARY = "materialx"

# By target: the module and class that write the code, and the language that it is in.
TARGETS = {
    "glsl": ("PyMaterialXGenGlsl", "GlslShaderGenerator", "glsl"),
    "essl": ("PyMaterialXGenGlsl", "EsslShaderGenerator", "essl"),
    "slang": ("PyMaterialXGenSlang", "SlangShaderGenerator", "slang"),
    "msl": ("PyMaterialXGenMsl", "MslShaderGenerator", "msl"),
}

# What can be asked for its values, by the type of its output.
KINDS = ("BSDF", "surfaceshader", "material")

LIGHT = "directional_light"
LIGHT_NUMBER = 1

_WIDTHS = {
    "float": 1, "integer": 1, "boolean": 1, "vector2": 2, "color3": 3, "vector3": 3, "EDF": 3,
    "color4": 4, "vector4": 4,
}  # fmt: skip

# Words of the languages that nodes may be called.
_RESERVED = (
    "auto bool break case centroid class color const continue default discard do double else enum "
    "extern false fixed flat float float2 float3 float4 for fragment half if in inline inout input int "
    "interface layout main mat2 mat3 mat4 matrix namespace new noise operator out output precise "
    "private protected public register return sample sampler smooth static struct subroutine switch "
    "template texture this true typedef uint uniform union using var varying vec2 vec3 vec4 vector "
    "vertex void while"
)

# Words for vectors in GLSL, and in Slang.
_VECTORS = {2: ("vec2", "float2"), 3: ("vec3", "float3"), 4: ("vec4", "float4")}

_TWO_SIDED = (
    "const bool u_refractionTwoSided = false;\n",
    "static const bool u_refractionTwoSided = false;\n",
)

# Inputs that let light through or add some keep their values unless a range is given.
_NO_REFLECTION = (
    r"emi|opacity|alpha|transmission|occlusion|attenuation|dispersion|subsurface|scatter"
    r"|^thickness|^weight$"
)

# Ranges of inputs that have none: refraction is from 1 on, thicknesses of films are in nanometres.
_RANGES = (
    (r"thin_?film_?thickness", 0.0, 1000.0),
    (r"ior$|^ior|_IOR$", 1.0, 3.0),
    (r"extinction", 0.0, 8.0),
    (r"exponent", 1.0, 10.0),
)


def is_materialx(text: str) -> bool:
    """Whether a text names a MaterialX document, or its library."""
    file = text.partition("#")[0]
    return file == LIBRARY or file.lower().endswith(".mtlx")


def read(text: str) -> Source:
    """Generate the code of "FILE.mtlx#NODE@TARGET".

    Raises:
        ForeignError: no such file, node or target, or MaterialX refuses it.
    """
    if importlib.util.find_spec("MaterialX") is None:
        raise ForeignError(
            f"{text} needs MaterialX, which is not installed; pip install materialx."
        )
    file, _, rest = text.partition("#")
    name, _, target = rest.partition("@")
    target = target or "glsl"
    if target not in TARGETS:
        from gonio.export.targets import did_you_mean_language

        raise ForeignError(
            f"{text}: MaterialX has no target {target!r} here; "
            f"{did_you_mean_language(target, TARGETS)}there are {', '.join(TARGETS)}."
        )
    import MaterialX

    library, document, own = _documents(file)
    try:
        node = _named(file, document, library, name, own)
        own_name = name or node.getName()
        _rename(document)
        shader, context = _generated(document, node, target)
    except MaterialX.Exception as error:
        raise ForeignError(f"{text}: MaterialX refuses it: {str(error).strip()}") from None
    del context
    stage = shader.getStage("pixel")
    uniforms = list(_uniforms(document, stage, target))
    plain = re.sub(r"[^0-9A-Za-z]+", "_", own_name)
    made = f"node_{plain}".rstrip("_")
    text = shader.getSourceCode("pixel")
    made_callable = _callable_msl if target == "msl" else _callable
    code = made_callable(text, uniforms, made, target)
    language = TARGETS[target][2]
    title = f"{Path(file).name}#{own_name}@{target}"
    return of_text(Path(title), language, code, uniforms, entry=made)


def _documents(file: str) -> tuple[Any, Any, list[str]]:
    """The library, the document of a file (or an empty one), and the paths of its nodes that reflect."""
    import MaterialX

    library = MaterialX.createDocument()
    MaterialX.loadLibraries(
        MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), library
    )
    document = MaterialX.createDocument()
    if file != LIBRARY:
        if not Path(file).is_file():
            raise ForeignError(f"{file}: No such file or directory")
        try:
            MaterialX.readFromXmlFile(document, file)
        except MaterialX.Exception as error:
            raise ForeignError(f"{file} is no MaterialX document: {str(error).strip()}") from None
    own = [n.getNamePath() for n in _nodes(document) if n.getType() in KINDS]
    document.setDataLibrary(library)
    return library, document, own


def _named(file: str, document: Any, library: Any, name: str, own: list[str]) -> Any:
    """The shader node of what a name stands for; BSDFs get a surface around them."""
    if not name:
        reflecting = [document.getDescendant(path) for path in own]
        materials = [n for n in reflecting if n.getType() == "material"] or reflecting
        if len(materials) != 1:
            shown = ", ".join(own) or "none that reflects"
            raise ForeignError(f"{file}: say which node, as {file}#NODE; it has {shown}.")
        node = materials[0]
    else:
        node = document.getDescendant(name)
        if node is None or file == LIBRARY or not hasattr(node, "getCategory"):
            node = _of_library(file, document, library, name, own)
    if node.getType() == "material":
        import MaterialX

        shaders = MaterialX.getShaderNodes(node, "surfaceshader")
        if not shaders:
            raise ForeignError(f"{file}: {node.getNamePath()} has no surface shader.")
        node = shaders[0]
    if node.getType() not in KINDS:
        raise ForeignError(
            f"{file}: {node.getNamePath()} is a {node.getType()}; only a BSDF, a surface shader or a "
            "material reflects."
        )
    _publish(document, node)
    if node.getType() == "BSDF":
        parent = node.getParent()
        surface = parent.addNode(
            "surface", parent.createValidChildName("gonio_surface"), "surfaceshader"
        )
        surface.setConnectedNode("bsdf", node)
        return surface
    return node


def _rename(document: Any) -> None:
    """Give nodes names that are words of no language; MaterialX loses the inputs of others."""
    for node in list(_nodes(document)):
        old = node.getName()
        if re.fullmatch(r"[A-Za-z][0-9A-Za-z_]*", old) and old not in _RESERVED.split():
            continue
        parent = node.getParent()
        new = parent.createValidChildName("node_" + re.sub(r"[^0-9A-Za-z]+", "_", old).strip("_"))
        for element in parent.traverseTree():
            if (
                element.getAttribute("nodename") == old
                and element.getParent().getParent() == parent
            ):
                element.setAttribute("nodename", new)
        node.setName(new)


def _nodes(document: Any) -> Iterable[Any]:
    """Nodes of a document, and those of its node graphs."""
    yield from document.getNodes()
    for graph in document.getNodeGraphs():
        yield from graph.getNodes()


def _of_library(file: str, document: Any, library: Any, name: str, own: list[str]) -> Any:
    """A new node of a category that the library has."""
    known = {d.getNodeString(): d for d in library.getNodeDefs() if d.getType() in KINDS[:2]}
    found = known.get(name)
    if found is None or file != LIBRARY:
        names = sorted(known) if file == LIBRARY else own
        where = "MaterialX's library" if file == LIBRARY else file
        raise ForeignError(
            f"{where} has no node {name!r} that reflects; {did_you_mean(name, names)}"
            f"it has {', '.join(names) or 'none'}."
        )
    needed = [i for i in found.getActiveInputs() if i.getType() in ("BSDF", "EDF", "VDF")]
    if any(i.getType() == "BSDF" for i in needed):
        raise ForeignError(
            f"{name} combines BSDFs; give a document in which its inputs are connected."
        )
    return document.addNode(name, name, found.getType())


def _publish(document: Any, node: Any) -> None:
    """Give a node all its inputs, so that they become uniforms."""
    declared = node.getNodeDef()
    if declared is None:
        return
    for given in declared.getActiveInputs():
        plain = given.getType() in _WIDTHS and given.getType() != "EDF"
        if (
            plain
            and not given.hasDefaultGeomPropString()
            and node.getInput(given.getName()) is None
        ):
            node.addInputFromNodeDef(given.getName())


def _generated(document: Any, node: Any, target: str) -> tuple[Any, Any]:
    """The shader of a node, lit by one directional light without an environment."""
    import MaterialX
    from MaterialX import PyMaterialXGenShader

    module, name, _ = TARGETS[target]
    generator = getattr(importlib.import_module(f"MaterialX.{module}"), name).create()
    context = PyMaterialXGenShader.GenContext(generator)
    context.registerSourceCodeSearchPath(MaterialX.getDefaultDataSearchPath())
    options = context.getOptions()
    none = PyMaterialXGenShader.HwSpecularEnvironmentMethod.SPECULAR_ENVIRONMENT_NONE
    options.hwSpecularEnvironmentMethod = none
    options.hwMaxActiveLightSources = 1
    options.shaderInterfaceType = PyMaterialXGenShader.ShaderInterfaceType.SHADER_INTERFACE_COMPLETE
    generator.registerTypeDefs(document)
    light = document.getDataLibrary().getMatchingNodeDefs(LIGHT)[0]
    PyMaterialXGenShader.HwShaderGenerator.bindLightShader(light, LIGHT_NUMBER, context)
    return generator.generate("gonio", node, context), context


def _uniforms(document: Any, stage: Any, target: str) -> Iterable[Variable]:
    """The shader's numbers: those of the node itself are parameters."""
    block = stage.getUniformBlocks()["PublicUniforms"]
    ports = [block[k] for k in range(block.size())]
    own = Counter(
        p.getPath().rpartition("/")[2] for p in ports if _element(document, p) is not None
    )
    for port in ports:
        kind = port.getType().getName()
        width = _WIDTHS.get(kind, 0)
        if not width:
            continue
        default = _numbers(port.getValue(), width)
        element = _element(document, port)
        word = port.getPath().rpartition("/")[2]
        shown = "" if element is None else word if own[word] == 1 else port.getVariable()
        low, high = _range(word, default, element)
        words = {"integer": "int", "boolean": "bool", "float": "float"}
        yield Variable(
            port.getVariable(),
            words.get(kind) or _VECTORS[width][target in ("slang", "msl")],
            default=default,
            low=None if kind in ("integer", "boolean") else low,
            high=None if kind in ("integer", "boolean") else high,
            shown=shown,
            fixed=element is None or _kept(element, word),
        )


def _element(document: Any, port: Any) -> Any:
    """The input of the document that a port is; None inside of the library's graphs."""
    path = port.getPath()
    if not path or port.getType().getName() == "EDF":
        return None
    element = document.getDescendant(path)
    parent = None if element is None else element.getParent()
    if parent is None or not hasattr(parent, "getNodeDef"):
        return None
    return None if parent.getName().startswith("gonio_surface") else element


def _kept(element: Any, name: str) -> bool:
    """Whether an input keeps its value unless a range is given: what a document sets, and what lets light
    through or adds light.
    """
    given = element.getParent().getName() != element.getParent().getCategory()
    return given or re.search(_NO_REFLECTION, name) is not None


def _numbers(value: Any, width: int) -> tuple[float, ...]:
    data = None if value is None else value.getData()
    if data is None:
        return (0.0,) * width
    if isinstance(data, (bool, int, float)):
        return (float(data),)
    return tuple(float(data[k]) for k in range(width))


def _range(name: str, default: tuple[float, ...], element: Any) -> tuple[float, float]:
    """From the declaration of the input, else what its name suggests."""
    declared = None
    found = None if element is None else element.getParent().getNodeDef()
    if found is not None:
        declared = found.getActiveInput(element.getName())
    given = {}
    for end in ("min", "max"):
        for word in (f"ui{end}", f"uisoft{end}"):
            text = declared.getAttribute(word) if declared is not None else ""
            if text and end not in given:
                given[end] = float(text.split(",")[0])
    low, high = 0.0, 1.0
    for pattern, a, b in _RANGES:
        if re.search(pattern, name):
            low, high = a, b
    # Sliders of indices of refraction begin at 0, which is for nothing that exists
    low, high = max(given.get("min", low), low), given.get("max", high)
    numbers = [x for x in default if math.isfinite(x)]
    return min([low, *numbers]), max([high, *numbers])


def _callable(code: str, uniforms: Iterable[Variable], name: str, target: str) -> str:
    """The shader with globals for what comes from outside, and a function that calls it."""
    del uniforms  # they are globals already
    slang = target == "slang"
    vec = _VECTORS[3][slang]
    members = [
        (m[2], m[1])
        for m in re.finditer(
            r"(\w+)\s+(\w+)\s*(?::\s*\w+)?;", _block(code, r"in\s+VertexData|struct\s+VertexData")
        )
    ]
    loose: list[str] = []
    if slang:
        code = re.sub(
            r"cbuffer\s+\w+\s*\{(.*?)\n\}",
            lambda m: re.sub(r"\buniform\s+", "static ", m[1]),
            code,
            flags=re.S,
        )
        code = re.sub(r"\[shader\(\"fragment\"\)\]", "", code)
        code = re.sub(r"\)\s*:\s*SV_Target", ")", code)
        call, result = "float4 gonio_pixel = fragmentMain(vd)", "gonio_pixel"
    else:
        code = re.sub(r"^#version[^\n]*", "", code, flags=re.M)
        code = re.sub(r"^in\s+VertexData(\s*\{.*?\})\s*(\w+);", r"struct VertexData\1;\nVertexData \2;",
                      code, flags=re.M | re.S)  # fmt: skip
        # GLSL ES has no blocks between stages
        single = re.findall(r"^in\s+(\w+)\s+(\w+);", code, re.M)
        code = re.sub(r"^(?:uniform|in)\s+(?!sampler)(?=\w+\s+\w+\s*[;=\[])", "", code, flags=re.M)
        code = re.sub(r"^out\s+(?=vec4\s)", "", code, flags=re.M)
        code = re.sub(r"^(precision\s+\w+\s+\w+;)", "", code, flags=re.M)
        code = re.sub(r"\bvoid\s+main\s*\(\s*\)", "void gonio_pixel()", code)
        output = re.search(r"^vec4\s+(\w+);", code, re.M)
        loose = [f"    {m} = {value};" for kind, m in single if (value := _vertex(m, kind, vec))]
        call, result = "gonio_pixel()", output[1] if output else "out1"
    lines = [f"    vd.{m} = {value};" for m, kind in members if (value := _vertex(m, kind, vec))]
    light = {
        "type": str(LIGHT_NUMBER),
        "direction": "-L",
        "color": f"{vec}(1.0)",
        "intensity": "1.0",
    }
    # Subsurface scattering divides by the change of the position from pixel to pixel
    place = (
        "vec3(mod(gl_FragCoord.xy, 2.0), 0.0) / 1024.0" if "fwidth" in code and not slang else ""
    )
    if place:
        lines = [line for line in lines if "positionWorld" not in line]
        loose = [line for line in loose if "positionWorld" not in line]
        where = "vd.positionWorld" if members else "positionWorld"
        lines += [f"    {where} = {place};"]
    lines += (
        [f"    u_viewPosition = V{f' + {place}' if place else ''};"]
        if "u_viewPosition" in code
        else []
    )
    if "u_lightData" in code:
        lines += ["    u_numActiveLightSources = 1;"]
        lines += [f"    u_lightData[0].{member} = {value};" for member, value in light.items()]
    body = "\n".join(["    VertexData vd;" * slang, *loose, *lines])
    # What transmission refers to and Python's options cannot turn on
    missing = "" if "uniform bool u_refractionTwoSided" in code else _TWO_SIDED[slang]
    return (
        f"{missing}{code}\n{vec} {name}({vec} L, {vec} V, {vec} N, {vec} X)\n{{\n{body}\n"
        f"    {call};\n    return {result}.xyz;\n}}\n"
    )


def _callable_msl(code: str, uniforms: Iterable[Variable], name: str, target: str) -> str:
    """Metal's shader, whose inputs are structs: they are filled from variables of the file."""
    del target
    members = re.findall(
        r"(\w+)\s+(\w+)\s*(?:\[\[\w+\]\])?\s*;", _block(code, r"struct\s+VertexData")
    )
    lines = [
        f"    vd.{m} = {value};" for kind, m in members if (value := _vertex(m, kind, "float3"))
    ]
    head = re.search(
        r"\bfragment\s+PixelOutputs\s+FragmentMain\s*\(((?:[^()]|\([^()]*\))*)\)", code
    )
    given = []
    for piece in (head[1] if head else "").split(","):
        words = re.findall(r"\w+", re.sub(r"\[\[.*", "", piece))
        if len(words) < 2 or words[-2] == "VertexData":
            given += ["vd"] * (len(words) >= 2)
            continue
        kind, variable = words[-2], f"gonio_{words[-1]}"
        given.append(variable)
        lines.append(f"    {kind if kind in code else 'auto'} {variable}{{}};")
        if kind == "PrivateUniforms":
            lines += [
                f"    {variable}.u_viewPosition = V;",
                f"    {variable}.u_numActiveLightSources = 1;",
            ]
        elif kind == "PublicUniforms":
            lines += [f"    {variable}.{u.name} = ::{u.name};" for u in uniforms]
        elif kind == "LightData_pixel":
            light = f"    {variable}.u_lightData[0]"
            lines += [f"{light}.type = {LIGHT_NUMBER};", f"{light}.direction = -L;"]
            lines += [f"{light}.color = float3(1.0);", f"{light}.intensity = 1.0;"]
    variables = "".join(f"static {u.type} {u.name};\n" for u in uniforms)
    body = "\n".join(lines)
    missing = "" if "bool u_refractionTwoSided" in code else _TWO_SIDED[1]
    return swizzled(
        f"{missing}{code}\n{variables}float3 {name}(float3 L, float3 V, float3 N, float3 X)\n{{\n"
        f"    VertexData vd{{}};\n{body}\n    return FragmentMain({', '.join(given)}).out1.xyz;\n}}\n"
    )


def _block(code: str, head: str) -> str:
    found = re.search(rf"\b(?:{head})\s*\{{(.*?)\}}", code, re.S)
    return found[1] if found else ""


def _vertex(member: str, kind: str, vec: str) -> str:
    """What a vertex would hand on, at the origin."""
    low = member.lower()
    directions: list[tuple[str, Callable[[], str]]] = [
        ("bitangent", lambda: "cross(N, X)"),
        ("tangent", lambda: "X"),
        ("normal", lambda: "N"),
    ]
    for word, value in directions:
        if word in low:
            return value()
    zero = {"float": "0.0", "int": "0"}
    return zero.get(kind, f"{kind}({'0.5' if 'texcoord' in low else '0.0'})")
