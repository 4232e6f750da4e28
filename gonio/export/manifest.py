"""What a host of an export has to know about it: names, parameters, choices; as JSON can hold it.

`manifest` describes the text that `export` writes for a model. `loader` writes one more function for that
text, which fills the struct of parameters from an array of four-component vectors, one for each
parameter: the layout that all graphics interfaces agree on.
"""

from __future__ import annotations

import functools
import inspect
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from gonio.description.about import module_notes, summary
from gonio.export.coded import Request, Tables
from gonio.export.entry import Entry, Export
from gonio.export.lit import export_lit
from gonio.export.printer import INDENT
from gonio.export.read import Reader
from gonio.export.targets import TARGETS, Target
from gonio.export.text import FUNCTIONS, export
from gonio.export.tree import Access, ExportError, Struct, walk
from gonio.fields import ModelError, Option, Parameter, is_array
from gonio.lights.catalogue import usual
from gonio.lights.lookups import LAST_LEVEL
from gonio.materials import Material
from gonio.model import Child, Model
from gonio.version import __version__

# What a lit export's function takes: of the point, and of its lights.
POINT: Mapping[str, str] = {
    "normal": "of the surface, in the world, need not be unit",
    "tangent": "the direction of growing u, in the world; (0, 0, 0) where there is none",
    "view": "towards the viewer, unit, in the world",
}
ARGUMENTS: Mapping[str, str] = {
    "light": "towards the light, unit, in the world",
    "irradiance": "what a surface that faces the light receives, linear RGB",
    "radiance": "of the uniform surrounding, linear RGB",
    "sky": "nine spherical harmonics of the environment's radiance; gonio bake harmonics prints them",
}
BINDS: Mapping[str, str] = {
    "environment_map": f"a cube map with {LAST_LEVEL + 1} levels, level k blurred by the GGX width "
    f"(k / {LAST_LEVEL})^2; gonio bake cube makes it",
    "split_sum_map": "a table of two channels over the viewer's cosine and the root of alpha; gonio bake "
    "split-sum makes it for the model",
    "fresnel_map": "the table of F, see tables",
    "distribution_map": "the table of D, see tables",
    "linear_clamp": "a sampler: linear between texels and levels, clamped",
}

# What a table's texels stand for.
AXES: Mapping[str, str] = {
    "fresnel": "to the right the cosine, from 0 to 1 in the middles of the first and last texel; a row for "
    "each surface of each material; linear numbers",
    "distribution": "to the right q / (1 + q) with q = (slope / width)^2 of the facet, down the width, "
    "both from 0 to 1 in the middles of texels; the root of pi alpha^2 D over its largest value",
}

# Bytes of a four-component vector of floats, which each parameter has for itself.
STRIDE = 16

# How the loader takes its array, by language: OSL and MaterialX have their parameters as inputs.
ARRAYS: Mapping[str, str] = {
    "glsl": "vec4 {name}[{count}]",
    "essl": "vec4 {name}[{count}]",
    "hlsl": "float4 {name}[{count}]",
    "slang": "float4 {name}[{count}]",
    "wgsl": "{name}: array<vec4f, {count}>",
    "msl": "constant float4* {name}",
    "cpp": "const float (*{name})[4]",
    "cuda": "const float4* {name}",
}


def manifest(
    what: Model | Material,
    name: str | None = None,
    *,
    only: Sequence[str] = FUNCTIONS,
    prefix: str | None = None,
    refusals: bool = True,
    reasons: bool = True,
    lit: Sequence[str] | None = None,
    tables: Request | None = None,
    atlas: Tables | None = None,
    made: Export | None = None,
) -> dict[str, Any]:
    """All that a host has to know about the export of a model, as plain dicts and lists.

    Args:
        what: the model with its options and values, or a material, which adds its hooks.
        name: of the export; the model's own by default.
        only: the functions that are exported.
        prefix: of what several models of one export share.
        refusals: find out which values of options are refused; takes a second for three layers of models.
        reasons: say which options would use the parameters that nothing reads; takes as long.
        lit: names of lights, for a lit export (`gonio.export.lit`); none of them: the usual ones.
        tables: for an export that looks up F and D (`gonio.export.tabled`).
        atlas: the tables that this model shares with others of its text; its own by default.
        made: this export in WGSL, where it has been made already.

    Returns:
        Names of struct and functions; under "parameters" path, width, kind, value, default, range, soft
        range, scale and byte offset of each; under "options" each value with the reason why it is refused,
        if it is, and with the changes that would allow it; under "models" what lies inside; under "hooks"
        what a host gives per point; under "lit" what `shade` takes and what the host binds; under "buffer"
        the tables that it binds; under "tables" those of F and D: files, rows and errors; under "materials"
        those of a model with a row.
        docs/embedding.md explains every entry.

    Raises:
        ExportError: what cannot be exported.
    """
    model = what.model if isinstance(what, Material) else what
    own = name or model.name
    if made is None:
        if lit is None:
            made = export({own: model}, "wgsl", only=only, prefix=prefix, tables=tables)[0]
        else:
            lights = lit or usual(model)
            made = export_lit(model, own, lights, "wgsl", only=only, prefix=prefix, tables=tables)
    entry, buffer = made.entry, made.buffer
    module = inspect.getmodule(model.written)
    return {
        "gonio": __version__,
        "name": name or model.name,
        "model": model.name,
        "title": module_notes(inspect.getdoc(module) or "")["title"],
        "description": what.description if isinstance(what, Material) else summary(model.written),
        "prefix": entry.prefix,
        "struct": entry.struct,
        "sample_struct": entry.sample_struct,
        "functions": {f: f"{entry.prefix}_{f}" for f in entry.functions},
        "isotropic": not model.follows_tangents(),
        "stride": STRIDE,
        "parameters": list(_parameters(model, entry, made.tables, reasons)),
        "options": list(options(model, only, refusals=refusals)),
        "models": list(_models(model)),
        "hooks": _hooks(what) if isinstance(what, Material) else [],
        **({"lit": _lit(entry)} if lit is not None else {}),
        **({"buffer": buffer.described(entry.reading)} if buffer is not None else {}),
        **({"tables": _tables(atlas or made.tables)} if made.tables is not None else {}),
        **({"materials": _materials(tables)} if tables is not None and tables.materials else {}),
    }


def _tables(tables: Tables) -> list[dict[str, Any]]:
    """The files of tables, and what is in them."""
    return [
        {
            "kind": table.kind,
            "file": file,
            "texture": f"{tables.prefix}_{table.kind}_map",
            "bits": table.bits,
            "width": table.codes.shape[1],
            "height": table.codes.shape[0],
            "channels": 3 if table.codes.ndim == 3 else 1,
            "axes": AXES[table.kind],
            "rows": [
                {"row": row, "holds": name, "error": error}
                for row, name, error in zip(table.starts, table.rows, table.errors, strict=True)
            ],
        }
        for file, table in tables.files().items()
    ]


def _materials(tables: Request) -> list[dict[str, Any]]:
    """Those that the parameter row chooses among, with all that a host gives besides."""
    return [
        {
            "row": row,
            "name": name,
            "parameters": {
                path: _numbers(declared, value) for path, declared, value in material.parameters()
            },
        }
        for row, (name, material) in enumerate(tables.materials)
    ]


def _lit(entry: Entry) -> dict[str, Any]:
    """What a host gives to `shade`, and what it binds."""
    arguments: list[dict[str, Any]] = [
        {"name": name, "width": 3, "doc": doc} for name, doc in POINT.items()
    ]
    for given in entry.given:
        row: dict[str, Any] = {
            "name": given.name,
            "width": given.width,
            "doc": ARGUMENTS[given.name],
        }
        if given.struct:
            row |= {"struct": given.struct, "members": list(given.members)}
        arguments.append(row)
    return {
        "lights": list(entry.lights),
        "arguments": arguments,
        "lookups": list(entry.lookups),
        "binds": [{"name": name, "doc": BINDS[_ending(name, BINDS)]} for name in entry.binds],
    }


def _ending(name: str, known: Mapping[str, str]) -> str:
    return next(end for end in known if name.endswith(end))


def manifest_text(manifest: Mapping[str, Any]) -> str:
    """A manifest as the text of a JSON file."""
    return json.dumps(manifest, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


# --- parameters ----------------------------------------------------------------------------------------


def _parameters(
    model: Model, entry: Entry, tables: Tables | None, reasons: bool
) -> Iterator[dict[str, Any]]:
    places = {member.path: index for index, member in enumerate(entry.members)}
    functions = tuple(f for f in entry.functions if f in FUNCTIONS)
    plain = functions == entry.functions and tables is None
    read = used(model, functions) if plain else frozenset(places)
    fixed = tables.fixed if tables is not None else frozenset()
    for path, declared, value in model.parameters():
        if is_array(value):
            raise ExportError(f"{path} is an array; a manifest has one value for it.")
        low, high = soft_range(declared)
        row: dict[str, Any] = {
            "path": path,
            "width": declared.width,
            "kind": kind(declared),
            "value": _numbers(declared, value),
            "default": _numbers(declared, declared.default),
            "low": declared.low,
            "high": _finite(declared.high),
            "soft_low": low,
            "soft_high": high,
            "scale": scale(declared),
            "doc": declared.doc,
            "used": path in read,
            "offset": places[path] * STRIDE if path in places else None,
        }
        if path in fixed:
            row["tabled"] = True
        if path in fixed and path not in read:
            row["unused_because"] = "its value is in the table of F"
        elif reasons and path not in read:
            row["unused_because"] = _unused_because(model, path, functions)
        yield row


def _numbers(declared: Parameter, value: Any) -> list[float]:
    return [float(v) for v in (value if isinstance(value, tuple) else (value,) * declared.width)]


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None


def kind(declared: Parameter) -> str:
    """What a number is, which decides how it is shown and changed.

    "reflectance" (the only one for which a colour picker is right), "index" and "extinction" (of
    refraction), "absorption", "slope" (of facets), "exponent" (of a highlight), "angle" (radians),
    "length", "factor" (0 to 1) or "number". What a declaration does not say follows from the field's terms.
    """
    if declared.kind:
        return declared.kind
    name = declared.name
    words = name.split("_")  # an axis can stand behind: alpha_x, shininess_y
    last = words[-1]
    if "radians" in declared.doc:
        return "angle"
    if last in ("eta", "ior"):
        return "index"
    if last == "k":
        return "extinction"
    if name.endswith("sigma_a"):
        return "absorption"
    if "alpha" in words or declared.doc.startswith("slope"):
        return "slope"
    if "shininess" in words or "exponent" in words:
        return "exponent"
    if last in ("thickness", "distance"):
        return "length"
    if (declared.low, declared.high) == (0, 1):
        return "reflectance" if declared.width == 3 else "factor"
    return "number"


def scale(declared: Parameter) -> str:
    """ "log" where equal steps of a slider should be equal ratios, else "linear"."""
    what = kind(declared)
    if what in ("exponent", "length"):
        return "log"
    return "log" if what == "slope" and declared.low > 0 else "linear"


# The ends of a slider, where the range is wider than what materials have.
SOFT: Mapping[str, tuple[float, float]] = {
    "index": (0.05, 5),
    "extinction": (0, 10),
    "absorption": (0, 5),
    "exponent": (1, 1e4),
    "length": (1e-2, 100),
}


def soft_range(declared: Parameter) -> tuple[float, float]:
    """The range of a slider: values beyond it are allowed, and rare."""
    low, high = SOFT.get(kind(declared), (declared.low, declared.high))
    return max(low, declared.low), min(high, declared.high)


# --- what the chosen options read ----------------------------------------------------------------------


def used(model: Model, functions: Sequence[str] = FUNCTIONS) -> frozenset[str]:
    """Paths of the parameters that some functions read, with the model's options."""
    return _used(_Choice(model), tuple(functions))


class _Choice:
    """A model by its classes and options alone: what is read does not depend on values."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.key = tuple(_classes_and_options(model))

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Choice) and other.key == self.key


def _classes_and_options(model: Model) -> Iterator[Any]:
    yield model.written
    for name, declared in model.fields.items():
        if isinstance(declared, Option):
            yield getattr(model, name)
        elif isinstance(declared, Child):
            yield from _classes_and_options(getattr(model, name))


@functools.lru_cache(maxsize=4096)
def _used(choice: _Choice, functions: tuple[str, ...]) -> frozenset[str]:
    reader = Reader("x", TARGETS["wgsl"].library)
    root = reader.model(choice.model, "x", title="x")
    for name in functions:
        reader.method(root, name)
    read: set[tuple[Struct, str]] = set()
    for function in reader.functions:
        for expr in walk(function.body):
            if isinstance(expr, Access) and isinstance(expr.value.type, Struct):
                read.add((expr.value.type, expr.name))
    return frozenset(_paths(root, read, ""))


def _paths(struct: Struct, read: set[tuple[Struct, str]], prefix: str) -> Iterator[str]:
    for member in struct.members:
        if isinstance(member.type, Struct):
            yield from _paths(member.type, read, f"{prefix}{member.name}.")
        elif (struct, member.name) in read:
            yield prefix + member.name


def unused(model: Model, functions: Sequence[str] = FUNCTIONS) -> dict[str, str]:
    """Paths of the parameters that nothing reads, each with the options that would use it."""
    read = used(model, functions)
    paths = (path for path, _, _ in model.parameters())
    return {path: _unused_because(model, path, functions) for path in paths if path not in read}


def _unused_because(model: Model, path: str, functions: Sequence[str]) -> str:
    """The options that would use a parameter, in words."""
    around: list[tuple[str, Option, str]] = []
    others: list[tuple[str, Option, str]] = []
    for name, option, chosen in _option_paths(model):
        of_owner = path.startswith(name[: name.rfind(".") + 1])
        (around if of_owner else others).append((name, option, chosen))
    # What lies around a parameter decides in most cases, and there may be many options elsewhere
    for several in (around, others):
        wanted = [
            f"{name}={value}"
            for name, option, chosen in several
            for value in option.values
            if value != chosen and path in _used_with(model, {name: value}, functions)
        ]
        if wanted:
            return f"only with {' or '.join(wanted)}"
    return "no function reads it here"


def _used_with(
    model: Model, changes: Mapping[str, str], functions: Sequence[str]
) -> frozenset[str]:
    try:
        return used(model.replace(**changes), functions)
    except (ModelError, ExportError):
        return frozenset()


# --- options -------------------------------------------------------------------------------------------


def _option_paths(model: Model, prefix: str = "") -> Iterator[tuple[str, Option, str]]:
    """Path, declaration and value of every option, those of inner models included."""
    for name, declared in model.fields.items():
        value = getattr(model, name)
        if isinstance(declared, Option):
            yield prefix + name, declared, value
        elif isinstance(declared, Child):
            yield from _option_paths(value, f"{prefix}{name}.")


def options(
    model: Model, functions: Sequence[str] = FUNCTIONS, *, refusals: bool = True
) -> Iterator[dict[str, Any]]:
    """Every option with its values, and with why and how to help it where one is refused."""
    for path, declared, chosen in _option_paths(model):
        choices = []
        for value in declared.values:
            row: dict[str, Any] = {"value": value, "allowed": True}
            if refusals and value != chosen:
                reason = refusal(model, {path: value}, functions)
                if reason:
                    help_ = remedy(model, path, value, functions)
                    row |= {"allowed": False, "reason": reason, "remedy": help_}
            choices.append(row)
        yield {
            "path": path,
            "value": chosen,
            "default": declared.default,
            "values": choices,
            "doc": declared.doc,
        }


def refusal(model: Model, changes: Mapping[str, Any], functions: Sequence[str] = FUNCTIONS) -> str:
    """Why a model cannot be changed so, in the model's own words; empty if it can."""
    try:
        used(model.replace(**changes), functions)
    except (ModelError, ExportError) as error:
        return str(error).partition("\n")[0]
    return ""


def remedy(
    model: Model, path: str, value: str, functions: Sequence[str] = FUNCTIONS
) -> dict[str, str]:
    """The fewest other options whose change would allow a refused one; empty if two do not suffice."""
    others = [
        (name, other)
        for name, option, chosen in _option_paths(model)
        for other in option.values
        if name != path and other != chosen
    ]
    for count in (1, 2):
        for changes in itertools.combinations(others, count):
            wanted = dict(changes)
            if len(wanted) < count:
                continue
            try:
                model.replace(**{path: value, **wanted})
            except ModelError:
                continue
            # What a model allows can still be something that shading code cannot do.
            return wanted if not refusal(model, {path: value, **wanted}, functions) else {}
    return {}


# --- inner models and hooks ----------------------------------------------------------------------------


def _models(model: Model, prefix: str = "") -> Iterator[dict[str, Any]]:
    for name, declared in model.fields.items():
        if isinstance(declared, Child):
            inner = getattr(model, name)
            yield {
                "path": prefix + name,
                "value": inner.name,
                "default": declared.default,
                "doc": declared.doc,
            }
            yield from _models(inner, f"{prefix}{name}.")


def _hooks(material: Material) -> list[dict[str, Any]]:
    """What a host gives for each point, in place of a value of the struct."""
    widths = {path: declared.width for path, declared, _ in material.model.parameters()}
    hooks: list[dict[str, Any]] = [
        {
            "path": path,
            "source": "texture",
            "file": str(picture),
            # Numbers are stored as they are, colours in sRGB.
            "encoding": "linear" if widths[path] == 1 else "srgb",
            **({"channel": material.channels[path]} if path in material.channels else {}),
            "scale": list(material.texture_scale),
        }
        for path, picture in material.textures.items()
    ]
    if material.normal_map is not None:
        file = {"file": str(material.normal_map), "scale": list(material.texture_scale)}
        hooks.append({"path": "", "source": "normal_map", **file})
    if material.flakes:
        hooks += [
            {"path": path, "source": "flakes", "channel": channel, **material.flakes}
            for channel, path in enumerate(material.driven_by_maps())
        ]
    if material.grows:
        hooks += [{"path": path, "source": "mesh"} for path in material.driven_by_maps()]
    return hooks


# --- the loader ----------------------------------------------------------------------------------------


def loader(made: Export) -> str:
    """A function for the end of an export: the struct of parameters from an array of vectors.

    Vector i belongs to the i-th member of the export; its offset in bytes is in the manifest. Colours are
    in x, y, z and numbers in x. The array always has at least one vector.

    Raises:
        ExportError: a language whose parameters are inputs of a shader already.
    """
    if made.language not in ARRAYS:
        raise ExportError(
            f"{made.language} has its parameters as inputs of the shader; there is nothing to load. "
            f"--load is for {', '.join(ARRAYS)}."
        )
    target, entry = TARGETS[made.language], made.entry
    outside = f"{entry.namespace}::" if target.foot else ""
    struct, array, result = outside + entry.struct, "values", "loaded"
    count = max(len(entry.members), 1)
    given = ARRAYS[made.language].format(name=array, count=count)
    name = f"{entry.prefix}_load"
    lines = [
        f"// The parameters of {entry.prefix} from {count} vectors: "
        f"{', '.join(m.path for m in entry.members) or 'none is read'}.",
        target.function.format(result=struct, name=name, parameters=given),
        INDENT + target.uninitialized.format(type=struct, name=result),
        *(INDENT + line for line in _assignments(made, target, array, result, outside)),
        f"{INDENT}return {result};",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _assignments(
    made: Export, target: Target, array: str, result: str, outside: str
) -> Iterator[str]:
    for index, member in enumerate(made.entry.members):
        place = f"{result}.{member.place}"
        item = f"{array}[{index}]"
        if made.language == "cpp":
            x, y, z = (f"{item}[{c}]" for c in range(3))
        else:
            x, y, z = (f"{item}.{c}" for c in "xyz")
        if member.width == 1:
            yield f"{place} = {x};"
        elif target.foot:  # C++: its own vectors
            yield f"{place} = {outside}Vec3{{{x}, {y}, {z}}};"
        else:
            yield f"{place} = {item}.xyz;"
