"""The whole text of an export: head, structs, functions, and what a language wants around them."""

from __future__ import annotations

import difflib
import inspect
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from gonio.export import library
from gonio.export.entry import Entry, Export, Member
from gonio.export.printer import INDENT, WIDTH, Printer, comment, number, plain_text
from gonio.export.read import Reader, camel
from gonio.export.targets import TARGETS, Target
from gonio.export.tree import SELF, ExportError, Function, Struct, walk
from gonio.fields import Parameter
from gonio.model import Child, Model
from gonio.version import __version__

FUNCTIONS = ("eval", "sample", "pdf", "albedo")

# Prefix of what several models of one export share.
SHARED = "gonio"

# How exact the albedo of models without a closed form is, of white: see docs/language.md.
SAMPLED_ALBEDO = 5e-3


def export(
    models: Mapping[str, Model],
    to: str | Target,
    *,
    only: Sequence[str] = FUNCTIONS,
    prefix: str | None = None,
    embed: bool = False,
) -> list[Export]:
    """Source code of some models in one language, in one text that they share.

    Args:
        models: by the names that their functions begin with.
        to: the language, one of `gonio.export.targets.TARGETS`, or a table of your own.
        only: which of FUNCTIONS.
        prefix: of what the models share; by default the model's name, or "gonio" for several.
        embed: also write a function that gives the parameters these models have.

    Returns:
        One Export for each model, all with the same source.

    Raises:
        ExportError: what cannot be exported, with its place; an unknown language or function.
    """
    target = to if isinstance(to, Target) else _target(to)
    for name in only:
        if name not in FUNCTIONS:
            raise ExportError(f"no function {name!r}; there are {', '.join(FUNCTIONS)}.")
    if not models:
        raise ExportError("nothing to export; name a model.")
    if target.shader and len(models) > 1:
        raise ExportError(
            f"an {target.extension.upper()} file holds one shader; export one model at a time."
        )
    for name in [*models, *([prefix] if prefix else [])]:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) or "__" in name:
            raise ExportError(
                f"the prefix {name!r} cannot begin a name; use letters, digits and single underscores."
            )
    shared = prefix or (next(iter(models)) if len(models) == 1 else SHARED)
    reader = Reader(shared, target.library)
    roots = [reader.model(model, name, title=name) for name, model in models.items()]
    wanted = [reader.method(root, name) for root in roots for name in FUNCTIONS if name in only]
    text = _Text(target, shared, reader, roots, wanted, embed).write()
    return [
        Export(target.name, text, _entry(shared, reader, root, only), _albedo_error(root, only))
        for root in roots
    ]


def _target(name: str) -> Target:
    if name not in TARGETS:
        near = difflib.get_close_matches(name, TARGETS, n=1)
        did = f"did you mean {near[0]!r}? " if near else ""
        raise ExportError(f"no language {name!r}; {did}there are {', '.join(TARGETS)}.")
    return TARGETS[name]


def _entry(shared: str, reader: Reader, root: Struct, only: Sequence[str]) -> Entry:
    model = root.model
    assert model is not None
    members = tuple(Member(path, declared.width) for path, declared, _ in model.parameters())
    functions = tuple(f for f in FUNCTIONS if f in only)
    return Entry(root.prefix, root.name, reader.sample.name, _namespace(shared), members, functions)


def _namespace(shared: str) -> str:
    return SHARED if shared == SHARED else f"{SHARED}_{shared}"


def _albedo_error(root: Struct, only: Sequence[str]) -> float:
    assert root.model is not None
    closed = inspect.unwrap(type(root.model).albedo) is not inspect.unwrap(Model.albedo)
    return 0.0 if closed or "albedo" not in only else SAMPLED_ALBEDO


class _Text:
    """Puts the parts of one export in order."""

    def __init__(
        self,
        target: Target,
        prefix: str,
        reader: Reader,
        roots: Sequence[Struct],
        wanted: Sequence[Function],
        embed: bool,
    ) -> None:
        self.target = target
        self.prefix = prefix
        self.reader = reader
        self.roots = roots
        self.wanted = wanted
        self.embed = embed
        self.printer = Printer(target, prefix)

    def write(self) -> str:
        """The text."""
        used = self._used_structs()
        structs = [s for s in self.reader.structs if s in used]
        blocks: list[list[str]] = []
        free = list(self.reader.functions)
        if self.target.methods:
            blocks += self._with_methods(structs, free)
        else:
            blocks += [self.printer.struct(s) for s in structs]
            blocks += [self.printer.function(f) for f in free]
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
        namespace = _namespace(self.prefix)
        parts = [
            "\n".join(self._head()),
            *([self.target.head.format(namespace=namespace)] if self.target.head else []),
            *helpers,
            *("\n".join(block) + "\n" for block in blocks),
        ]
        text = "\n".join(part if part.endswith("\n") else part + "\n" for part in parts)
        return text + self.target.foot.format(namespace=namespace)

    def _used_structs(self) -> set[Struct]:
        used: set[Struct] = set(self.roots)
        for function in self.reader.functions:
            kinds = [kind for _, kind in function.parameters] + [function.result]
            kinds += [expr.type for expr in walk(function.body)]
            used |= {kind for kind in kinds if isinstance(kind, Struct)}
        for struct in list(used):
            used |= {m.type for m in _members(struct) if isinstance(m.type, Struct)}
        return used

    def _with_methods(self, structs: Sequence[Struct], free: list[Function]) -> list[list[str]]:
        """Structs with methods, and an interface for what a renderer calls."""
        interface = f"I{camel(self.prefix)}Brdf"
        plain = [s for s in structs if s.model is None]
        blocks = [self.printer.struct(s) for s in plain]
        lines = comment(("What a renderer asks of a model.",))
        lines.append(f"interface {interface} {{")
        for function in self.wanted[: len(self.wanted) // len(self.roots)]:
            result = self.printer.type(function.result)
            parameters = ", ".join(
                f"{self.printer.type(kind)} {name}" for name, kind in function.parameters[1:]
            )
            lines.append(f"{INDENT}{result} {function.method}({parameters});")
        blocks.append([*lines, "}"])
        blocks += [self.printer.function(f) for f in free if f.owner is None]
        for struct in structs:
            if struct.model is not None:
                methods = [f for f in free if f.owner is struct]
                bases = f" : {interface}" if struct in self.roots else ""
                blocks.append(self.printer.struct(struct, bases, methods))
        return blocks

    def _embedded(self, root: Struct) -> list[str]:
        """A function that gives the parameters of a material."""
        assert root.model is not None
        result, target = "material", self.target
        lines = comment((f"The parameters of {root.prefix}.",))
        lines.append(
            target.function.format(result=root.name, name=f"{root.prefix}_material", parameters="")
        )
        lines.append(INDENT + target.uninitialized.format(type=root.name, name=result))
        for path, declared, value in root.model.parameters():
            names = ".".join(self.printer.name(part) for part in path.split("."))
            lines.append(f"{INDENT}{result}.{names} = {self._value(declared, value)};")
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
        for path, declared, value in model.parameters():
            name = self.printer.name(path.replace(".", "_"))
            default = self._value(declared, value)
            kind = "float"
            given = name
            if declared.width == 3:
                kind, default = "color", default.replace("vector", "color", 1)
                given = f"vector({name}[0], {name}[1], {name}[2])"
            note = plain_text(f"{declared.doc}; {declared.range_text()}")
            inputs.append((f"{kind} {name} = {default}", note))
            names = ".".join(self.printer.name(part) for part in path.split("."))
            fill.append(f"{SELF}.{names} = {given};")
        inputs += [
            ("vector wi = vector(0, 0, 1)", "direction towards the light"),
            ("vector wo = vector(0, 0, 1)", "direction towards the viewer"),
            ("float u1 = 0.5", "uniform random number"),
            ("float u2 = 0.5", "uniform random number"),
        ]
        outputs, calls = [], []
        for function in self.wanted:
            name = function.name
            if function.method == "eval":
                outputs.append(("output color f = 0", "BRDF value in 1/sr, without the cosine"))
                calls += [
                    f"vector value = {name}({SELF}, wi, wo);",
                    "f = color(value[0], value[1], value[2]);",
                ]
            elif function.method == "sample":
                outputs += [
                    ("output vector sampled_wi = 0", "a sampled direction"),
                    ("output float sampled_pdf = 0", "its density in 1/sr"),
                ]
                kind = self.reader.sample.name
                calls += [
                    f"{kind} drawn = {name}({SELF}, wo, vector(u1, u2, 0.0));",
                    "sampled_wi = drawn.wi;",
                    "sampled_pdf = drawn.pdf;",
                ]
            elif function.method == "pdf":
                outputs.append(("output float pdf = 0", "density of wi in 1/sr"))
                calls.append(f"pdf = {name}({SELF}, wi, wo);")
            else:
                outputs.append(("output color albedo = 0", "directional albedo at wo"))
                # A sum over many samples, unless there is a closed form
                calls += [
                    "if (isconnected(albedo)) {",
                    f"{INDENT}vector reflected = {name}({SELF}, wo);",
                    f"{INDENT}albedo = color(reflected[0], reflected[1], reflected[2]);",
                    "}",
                ]
        ports = inputs + outputs
        lines = comment(("All values of the model, for the given directions.",))
        lines.append(f"shader {root.prefix}(")
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
                module = inspect.getmodule(type(model))
                doc = inspect.getdoc(module) if module is not None else None
                paragraph = (doc or f"{model.name}.").splitlines()
                if paragraph[0] not in lines:
                    lines += [*paragraph, ""]
        lines += [
            f"{self.target.title}, made by gonio {__version__} from {self._files()}.",
            "wi points towards the light and wo towards the viewer: unit vectors in the local frame, whose",
            "normal is +z. eval gives the BRDF in 1/sr without the cosine; all is 0 below the horizon.",
        ]
        if self.target.note:
            lines.append(self.target.note)
        if any(f.doc and f.method == "albedo" and _is_sampled(f) for f in self.wanted):
            lines.append(
                "albedo has no closed form here; it takes many evaluations, for tables and previews."
            )
        return comment(lines)

    def _files(self) -> str:
        names: dict[str, None] = {}
        for root in self.roots:
            assert root.model is not None
            for model in nested(root.model):
                names[_shown_path(inspect.getsourcefile(type(model)) or model.name)] = None
        return ", ".join(names)


def _members(struct: Struct) -> Iterator[Any]:
    for member in struct.members:
        yield member
        if isinstance(member.type, Struct):
            yield from _members(member.type)


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
