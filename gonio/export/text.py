"""The whole text of an export: head, structs, functions, and what a language wants around them."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from gonio.export import library
from gonio.export.buffer import check as check_buffer
from gonio.export.buffer import placed
from gonio.export.coded import ARRAY_PLACES, DISTRIBUTION, Request, Tables, picture_file
from gonio.export.comments import comment, plain_text
from gonio.export.entry import Entry, Export, Member
from gonio.export.host import OBJECTS, HostPrinter, asking, with_host
from gonio.export.lookups import Supply, definitions, resources
from gonio.export.names import Names, legal
from gonio.export.print_expressions import number
from gonio.export.printer import INDENT, WIDTH, Printer, constants_of, in_order
from gonio.export.read import Reader, camel
from gonio.export.table_text import array
from gonio.export.tabled import with_tables
from gonio.export.targets import TARGETS, Target, did_you_mean_language
from gonio.export.tidy import members, tidy
from gonio.export.tree import CALLED, METHODS, SELF, Call, ExportError, Function, Struct, walk
from gonio.fields import Parameter
from gonio.model import Child, Model, as_written

FUNCTIONS = METHODS

# Where lookups come from.
LOOKUPS = ("textures", "array", "host")

# For proofs: tables are arrays, and the host supplies the light.
PROVABLE = "array and host"

# Prefix of what several models of one export share.
SHARED = "gonio"

# Exported code is the model's, and under the licence of gonio, which allows any use.
LICENCE = "SPDX-License-Identifier: Apache-2.0"

# What functions are for, by the method that asks for them.
PURPOSES = {"eval": "evaluation", "sample": "sampling", "pdf": "sampling", "albedo": "albedo"}

# What a shader of OSL calls its own inputs, outputs and variables.
SHADER_NAMES = frozenset(
    ("wi", "wo", "u1", "u2", "f", "sampled_wi", "sampled_pdf", "pdf", "albedo")
)

# How exact the albedo of models without a closed form is, of white: see docs/language.md.
SAMPLED_ALBEDO = 5e-3


def export(
    models: Mapping[str, Model],
    to: str | Target,
    *,
    only: Sequence[str] = FUNCTIONS,
    prefix: str | None = None,
    embed: bool = False,
    tables: Request | None = None,
    lookups: str = "textures",
) -> list[Export]:
    """Source code of some models in one language, in one text that they share.

    Args:
        models: by the names that their functions begin with.
        to: the language, one of `gonio.export.targets.TARGETS`, or a table of your own.
        only: which of FUNCTIONS.
        prefix: of what the models share; by default the model's name, or "gonio" for several.
        embed: also write a function that gives the parameters these models have.
        tables: which functions are looked up in tables (`gonio.export.tabled`).
        lookups: where tables are: "textures", "array" for arrays in the text, or "host", which defines the
            lookups. C++, CUDA and Metal have arrays.

    Returns:
        One Export for each model, all with the same source.

    Raises:
        ExportError: what cannot be exported, with its place; an unknown language or function.
    """
    target = to if isinstance(to, Target) else target_named(to)
    for name in only:
        if name not in FUNCTIONS:
            raise ExportError(f"no function {name!r}; there are {', '.join(FUNCTIONS)}.")
    if not models:
        raise ExportError("nothing to export; name a model.")
    if target.shader and len(models) > 1:
        raise ExportError(
            f"an {target.extension.upper()} file holds one shader; export one model at a time."
        )
    check_prefixes([*models, *([prefix] if prefix else [])])
    # Names that begin with gl_ belong to OpenGL
    models = {legal(name).rstrip("_"): model for name, model in models.items()}
    shared = legal(prefix or (next(iter(models)) if len(models) == 1 else SHARED)).rstrip("_")
    reader = Reader(shared, target.library, models, differentiable=bool(target.attribute))
    roots = [reader.model(model, name, title=name) for name, model in models.items()]
    wanted = [reader.method(root, name) for root in roots for name in FUNCTIONS if name in only]
    made = None
    if tables is not None:
        target = check_lookups(target, tables, lookups)
        made = with_tables(reader, roots, wanted, tables)
    functions = tidy(reader.functions, wanted, reader.sample, target.methods)
    supply = supply_of(lookups, made)
    text = Text(target, shared, reader, functions, roots, wanted, embed, supply)
    return [
        Export(
            target.name,
            text.source,
            replace(text.entry(root, only), **text.supplied()),
            _albedo_error(root, only),
            text.buffer,
            made,
        )
        for root in roots
    ]


def check_lookups(
    target: Target, tables: Request | None = None, lookups: str = "textures"
) -> Target:
    """A language as it is with lookups.

    Raises:
        ExportError: a renderer's shaders have none, or a table is too large for an array.
    """
    if target.shader:
        raise ExportError(
            f"{target.title} has no lookups here: its renderers run on processors, where tables save "
            "little; leave out --table."
        )
    if (
        tables is not None
        and "array" in lookups
        and DISTRIBUTION in tables.kinds
        and target.name not in OBJECTS
        and tables.places > ARRAY_PLACES
    ):
        raise ExportError(
            f"a table of D has {tables.places}² entries, too many for an array in {target.title}; leave it "
            "to textures, or give --table fresnel alone."
        )
    if target.attribute:  # pictures and tables have no derivatives
        return replace(target, attribute="", value="", note="")
    return target


def supply_of(lookups: str, made: Tables | None) -> Supply:
    """Where lookups come from."""
    if lookups not in (*LOOKUPS, PROVABLE):
        raise ExportError(f"no lookups {lookups!r}; there are {', '.join(LOOKUPS)}.")
    tables = {} if made is None else {f"{t.kind}_table": t for t in made.all}
    return Supply("host" not in lookups, tables, "array" in lookups)


def check_prefixes(names: Iterable[str]) -> None:
    """Refuse what cannot begin the name of a function."""
    for name in names:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or "__" in name:
            raise ExportError(
                f"the prefix {name!r} cannot begin a name; use letters, digits and single underscores."
            )


def target_named(name: str) -> Target:
    """The table of a language, or an ExportError that lists them."""
    if name not in TARGETS:
        did = did_you_mean_language(name, TARGETS)
        raise ExportError(f"no language {name!r}; {did}there are {', '.join(TARGETS)}.")
    return TARGETS[name]


def _namespace(shared: str) -> str:
    return SHARED if shared == SHARED else f"{SHARED}_{shared}"


def _albedo_error(root: Struct, only: Sequence[str]) -> float:
    assert root.model is not None
    return 0.0 if _closed(root.model) or "albedo" not in only else SAMPLED_ALBEDO


def _closed(model: Model) -> bool:
    """Whether a model's albedo is a formula, and of models inside it as well."""
    if not has_own_albedo(model):
        return False
    children = [n for n, declared in model.fields.items() if isinstance(declared, Child)]
    return all(_closed(getattr(model, name)) for name in children)


def has_own_albedo(model: Model) -> bool:
    """Whether a model writes a method `albedo`, in place of the numeric one."""
    return model.writes("albedo")


class Text:
    """Puts the parts of one export in order."""

    def __init__(
        self,
        target: Target,
        prefix: str,
        reader: Reader,
        functions: Sequence[Function],
        roots: Sequence[Struct],
        wanted: Sequence[Function],
        embed: bool,
        supply: Supply | None = None,
    ) -> None:
        """Write some functions, callees before callers, of which `wanted` are those that users call.

        `supply`: where lookups come from.
        """
        self.target = target
        self.prefix = prefix
        self.reader = reader
        self.functions = functions
        self.roots = roots
        self.wanted = wanted
        self.embed = embed
        self.supply = supply or Supply()
        self.arrays = [f for f in functions if self.supply.as_array(f, target.name)]
        self.lookups = [f for f in functions if f.external and f not in self.arrays]
        self.buffer = placed(functions, prefix)
        check_buffer(self.buffer, target.name, target.title)
        self.asking = asking(functions, self.lookups)
        self.reading = asking(functions, [f for f in self.lookups if f.table is not None])
        if target.name in OBJECTS:
            with_host(functions, OBJECTS[target.name], self.lookups)
        used = self._used_structs()
        self.structs = [s for s in reader.structs if s in used]
        self.printer = self._printer()
        self.ports: dict[str, str] = {}  # what a shader calls its parameters, by path
        self.source = self._write()

    @property
    def namespace(self) -> str:
        """Of the C++ header."""
        return _namespace(self.prefix)

    def _printer(self) -> Printer:
        return HostPrinter(self.target, self.prefix, self.functions, self.structs)

    def entry(self, root: Struct, only: Sequence[str]) -> Entry:
        """The names of what a model's part of the text defines."""
        found = []
        for path, member in members(root):
            name = self.ports.get(path) or self.printer.path(root, path)
            found.append(Member(path, 3 if member.type == "vec3" else 1, name))
        own = [f for f in self.wanted if f.owner is root]
        hosted = own if self.target.name in OBJECTS else []
        return Entry(
            root.prefix,
            root.name,
            self.reader.sample.name,
            self.namespace,
            tuple(found),
            tuple(f for f in CALLED if f in only),
            hosted=tuple(f.method for f in hosted if f in self.asking),
            reading=tuple(f.method for f in own if f in self.reading),
        )

    def supplied(self) -> dict[str, Any]:
        """What an entry says of the pictures: those that the host defines or binds."""
        language = self.target.name
        pictures = [f for f in self.lookups if f.table is None]
        bound = resources(pictures, self.prefix, language) if self.supply.textures else []
        return {
            "lookups": tuple(f.plain if language in OBJECTS else f.name for f in pictures),
            "binds": tuple(bound),
        }

    def _write(self) -> str:
        blocks: list[list[str]] = []
        if self.target.constants_in_file:
            blocks += self._constants()
        if self.target.methods:
            blocks += self._with_methods()
        else:
            blocks += [self.printer.struct(s) for s in self.structs]
            blocks += self._under_headings(self.functions)
        if self.embed:
            blocks += [self._embedded(root) for root in self.roots]
        if self.target.shader:
            blocks.append(self._shader(self.roots[0]))
        qualifiers = self.target.function.partition("{result}")[0]
        helpers = [
            text.replace("{p}", self.prefix).replace("{q}", qualifiers)
            for name, text in self.target.helpers.items()
            if name in self.printer.helpers
        ]
        namespace = self.namespace
        parts = [
            "\n".join(self._head()),
            *([self.target.head.format(namespace=namespace)] if self.target.head else []),
            *helpers,
            *("\n".join(block) + "\n" for block in blocks),
        ]
        text = "\n".join(part if part.endswith("\n") else part + "\n" for part in parts)
        return text + self.target.foot.format(namespace=namespace)

    def _constants(self) -> list[list[str]]:
        """All named numbers, where the language has a namespace for them."""
        found = in_order(
            {(c.name, c.value): c for f in self.functions for c in constants_of(f.body)}.values()
        )
        names = Names(self.printer.reserved)
        self.printer.name_constants(found, names)
        return [self.printer.constants(found)] if found else []

    def _under_headings(self, functions: Sequence[Function]) -> list[list[str]]:
        """Functions, with a heading where those for another purpose begin."""
        purposes = self._purposes()
        order = list(dict.fromkeys([*PURPOSES.values(), *purposes.values()]))
        # What evaluation needs asks for nothing else, so that callees stay before their callers
        functions = sorted(functions, key=lambda f: order.index(purposes[id(f)]))
        blocks: list[list[str]] = []
        last = ""
        if self.lookups:
            blocks += definitions(self.printer, self.lookups, self.supply, self.buffer)
        tables = self.supply.tables
        blocks += [array(self.printer, f, tables[f.plain]) for f in self.arrays]
        for function in functions:
            if function.external:
                continue
            lines = self.printer.function(function)
            if (purpose := purposes[id(function)]) != last and len(set(purposes.values())) > 1:
                lines = [*_heading(purpose), *lines]
            last = purpose
            blocks.append(lines)
        return blocks

    def _purposes(self) -> dict[int, str]:
        """What each function is for: the first that asks for it says it."""
        found: dict[int, str] = {}
        for method, purpose in PURPOSES.items():
            todo = [f for f in self.wanted if f.method == method]
            while todo:
                function = todo.pop()
                if id(function) not in found:
                    found[id(function)] = purpose
                    todo += [e.function for e in walk(function.body) if isinstance(e, Call)]
        return found

    def _used_structs(self) -> set[Struct]:
        used: set[Struct] = set(self.roots)
        for function in self.functions:
            kinds = [kind for _, kind in function.parameters] + [function.result]
            kinds += [expr.type for expr in walk(function.body)]
            used |= {kind for kind in kinds if isinstance(kind, Struct)}
        for struct in list(used):
            used |= set(_inner(struct))
        return used - set(OBJECTS.values())

    def _with_methods(self) -> list[list[str]]:
        """Structs with methods, and an interface for what a renderer calls."""
        names = Names(self.printer.reserved)
        interface = names.give(f"I{camel(self.prefix)}Brdf")
        plain = [s for s in self.structs if s.model is None]
        blocks = [self.printer.struct(s) for s in plain]
        lines = comment(("What a renderer asks of a model.",))
        base = f" : {self.target.value}" if self.target.value else ""
        lines.append(f"interface {interface}{base} {{")
        for function in self.wanted:
            if function.owner is not self.roots[0]:
                continue
            result = self.printer.type(function.result)
            parameters = ", ".join(
                f"{self.printer.type(kind)} {legal(name, self.printer.reserved)}"
                for name, kind in function.parameters[1:]
            )
            if self.target.attribute:
                lines.append(INDENT + self.target.attribute)
            lines.append(f"{INDENT}{result} {function.method}({parameters});")
        blocks.append([*lines, "}"])
        blocks += self._under_headings([f for f in self.functions if f.owner is None])
        for struct in self.structs:
            if struct.model is not None:
                methods = [f for f in self.functions if f.owner is struct]
                bases = f" : {interface}" if struct in self.roots else ""
                blocks.append(self.printer.struct(struct, bases, methods))
        return blocks

    def _embedded(self, root: Struct) -> list[str]:
        """A function that gives the parameters of a material."""
        assert root.model is not None
        result, target = "material", self.target
        names = Names({f.name for f in self.functions})
        lines = comment((f"The parameters of {root.prefix}.",))
        name = names.give(f"{root.prefix}_material")
        lines.append(target.function.format(result=root.name, name=name, parameters=""))
        lines.append(INDENT + target.uninitialized.format(type=root.name, name=result))
        values = {path: (declared, value) for path, declared, value in root.model.parameters()}
        for path, _ in members(root):
            value = self._value(*values[path])
            lines.append(f"{INDENT}{result}.{self.printer.path(root, path)} = {value};")
        return [*lines, f"{INDENT}return {result};", "}"]

    def _value(self, declared: Parameter, value: Any) -> str:
        if not isinstance(value, (int, float, tuple)):
            raise ExportError(
                f"{declared.name} is an array; give it one value, or export without embedding."
            )
        numbers = value if isinstance(value, tuple) else (value,) * declared.width
        texts = [number(v, self.target.suffix) for v in numbers]
        if declared.width == 1:
            return texts[0]
        kind = self.printer.type("vec3")
        return self.target.vector.format(type=kind, arguments=", ".join(texts))

    def _shader(self, root: Struct) -> list[str]:
        """OSL's shader: parameters, directions and random numbers in, all values out."""
        model = root.model
        assert model is not None
        inputs, fill = [], []
        values = {path: (declared, value) for path, declared, value in model.parameters()}
        taken = Names(self.printer.reserved | SHADER_NAMES)
        for path, _ in members(root):
            declared, value = values[path]
            name = self.ports[path] = taken.give(path.replace(".", "_"))
            default = self._value(declared, value)
            kind = "float"
            given = name
            if declared.width == 3:
                kind, default = "color", default.replace("vector", "color", 1)
                given = f"vector({name}[0], {name}[1], {name}[2])"
            note = plain_text(f"{declared.doc}; {declared.range_text()}")
            inputs.append((f"{kind} {name} = {default}", note))
            fill.append(f"{SELF}.{self.printer.path(root, path)} = {given};")
        inputs += [
            ("vector wi = vector(0, 0, 1)", "direction towards the light"),
            ("vector wo = vector(0, 0, 1)", "direction towards the viewer"),
            ("float u1 = 0.5", "uniform random number"),
            ("float u2 = 0.5", "uniform random number"),
        ]
        outputs, calls = [], []
        # Parameters keep their names, as hosts set them
        value, drawn, reflected = map(taken.give, ("value", "drawn", "reflected"))
        for function in self.wanted:
            name = function.name
            if function.method == "eval":
                outputs.append(("output color f = 0", "BRDF value in 1/sr, without the cosine"))
                calls += [
                    f"vector {value} = {name}({SELF}, wi, wo);",
                    f"f = color({value}[0], {value}[1], {value}[2]);",
                ]
            elif function.method == "sample":
                outputs += [
                    ("output vector sampled_wi = 0", "a sampled direction"),
                    ("output float sampled_pdf = 0", "its density in 1/sr"),
                ]
                kind = self.reader.sample.name
                calls += [
                    f"{kind} {drawn} = {name}({SELF}, wo, vector(u1, u2, 0.0));",
                    f"sampled_wi = {drawn}.wi;",
                    f"sampled_pdf = {drawn}.pdf;",
                ]
            elif function.method == "pdf":
                outputs.append(("output float pdf = 0", "density of wi in 1/sr"))
                calls.append(f"pdf = {name}({SELF}, wi, wo);")
            else:
                outputs.append(("output color albedo = 0", "directional albedo at wo"))
                # A sum over many samples, unless there is a closed form
                calls += [
                    "if (isconnected(albedo)) {",
                    f"{INDENT}vector {reflected} = {name}({SELF}, wo);",
                    f"{INDENT}albedo = color({reflected}[0], {reflected}[1], {reflected}[2]);",
                    "}",
                ]
        ports = inputs + outputs
        lines = comment(("All values of the model, for the given directions.",))
        lines.append(f"shader {legal(root.prefix, self.printer.reserved)}(")
        for i, (text, note) in enumerate(ports):
            end = "," if i + 1 < len(ports) else ""
            line = f"{INDENT}{text}{end}  // {note}"
            if len(line) > WIDTH:
                lines += [INDENT + c for c in comment((note,))] + [f"{INDENT}{text}{end}"]
            else:
                lines.append(line)
        lines += [") {", f"{INDENT}{root.name} {SELF};"]
        return [*lines, *(INDENT + line for line in [*fill, *calls]), "}"]

    def _head(self) -> list[str]:
        """Where the text comes from, and the conventions."""
        lines: list[str] = []
        for root in self.roots:
            assert root.model is not None
            for model in nested(root.model):
                module = inspect.getmodule(model.written)
                doc = inspect.getdoc(module) if module is not None else None
                paragraph = (doc or f"{model.name}.").splitlines()
                if paragraph[0] not in lines:
                    lines += [*paragraph, ""]
        lines += [
            f"{self.target.title}, made by gonio from {self._files()}{self._permission()}.",
            *self._conventions(),
        ]
        if files := self._table_files():
            lines.append(f"The host binds the tables in {' and '.join(files)}.")
        if self.target.note:
            lines.append(self.target.note)
        if any(f.doc and f.method == "albedo" and _is_sampled(f) for f in self.wanted):
            lines.append(
                "albedo has no closed form here; it takes many evaluations, for tables and previews."
            )
        return [f"// {self._licence()}", *comment(lines), *self._usage()]

    def _table_files(self) -> list[str]:
        """What stands beside the text: the buffer of tables, and pictures of F and D."""
        found = [] if self.buffer is None else [self.buffer.file]
        asked = {f.plain for f in self.lookups}
        pictures = [table for plain, table in self.supply.tables.items() if plain in asked]
        return [*found, *(picture_file(self.prefix, table) for table in pictures)]

    def _conventions(self) -> list[str]:
        return [
            "wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose",
            "normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.",
        ]

    def _licence(self) -> str:
        return LICENCE if self._is_own() else f"{LICENCE}, as far as it is gonio's"

    def _permission(self) -> str:
        return "; free to use under Apache-2.0" if self._is_own() else ""

    def _is_own(self) -> bool:
        return all(
            m.written.__module__.startswith("gonio.") for r in self.roots for m in _nested(r)
        )

    def _usage(self) -> list[str]:
        """How the text is used, in a line or two."""
        root = self.roots[0]
        if self.target.shader:
            name = legal(root.prefix, self.printer.reserved)
            return [
                f"// Usage: give the shader {name} wi, wo and its parameters, and read its outputs."
            ]
        first = next((f for f in self.wanted if f.method == "eval"), self.wanted[0])
        arguments = ", ".join(n for n, _ in first.parameters[1:])
        made = self.target.uninitialized.format(type=root.name, name=SELF)
        path, _ = next(iter(members(root)))
        scope = f"{self.namespace}::" if self.target.constants_in_file else ""
        call = f"{scope}{first.name}({SELF}, {arguments})"
        if self.target.methods:
            call = f"{SELF}.{first.method}({arguments})"
        filled = f"{SELF}.{self.printer.path(root, path)} = ...;"
        return [f"// Usage: {scope}{made} {filled} ... {call}"]

    def _files(self) -> str:
        names: dict[str, None] = {}
        for root in self.roots:
            assert root.model is not None
            for model in nested(root.model):
                names[_shown_path(as_written(model.written.eval).__code__.co_filename)] = None
        return ", ".join(names)


def _inner(struct: Struct) -> Iterator[Struct]:
    for member in struct.members:
        if isinstance(member.type, Struct):
            yield member.type
            yield from _inner(member.type)


def _nested(root: Struct) -> Iterator[Model]:
    assert root.model is not None
    yield from nested(root.model)


def _heading(text: str) -> list[str]:
    return [f"// {f'---- {text} ':-<{WIDTH - 8}}", ""]


def _is_sampled(function: Function) -> bool:
    return function.doc[0] == (library.sampled_albedo.__doc__ or "").splitlines()[0]


def nested(model: Model) -> Iterator[Model]:
    """A model and those inside it."""
    yield model
    for name, declared in model.fields.items():
        if isinstance(declared, Child):
            yield from nested(getattr(model, name))


def _shown_path(path: str) -> str:
    """A file's name as gonio's own, or as the user calls it."""
    package = Path(__file__).parent.parent
    if Path(path).is_relative_to(package):
        return (Path("gonio") / Path(path).relative_to(package)).as_posix()
    return os.path.basename(path)
