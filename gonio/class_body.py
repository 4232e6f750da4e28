"""What may stand in a model's class: looked at when Python makes it, with one line about what is wrong."""

from __future__ import annotations

import builtins
import functools
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from gonio.claims import Claims
from gonio.fields import ModelError, Option, Parameter, is_array, wrong
from gonio.horizon import GUARDS
from gonio.lang import Color, Float

# What a class says about itself, and how that is written.
ABOUT: Mapping[str, tuple[Callable[[Any], bool], str]] = {
    "claims": (lambda v: isinstance(v, Claims), "Claims(...)"),
    "caveats": (lambda v: _is_texts(v), '("one", "two")'),
    "unlike": (
        lambda v: isinstance(v, tuple) and all(_is_texts(p) and len(p) == 2 for p in v),
        '(("model", "in what it differs"),)',
    ),
    "isotropic": (lambda v: isinstance(v, bool), "True or False"),
    "description": (lambda v: isinstance(v, str), "text"),
    "__doc__": (lambda v: v is None or isinstance(v, str), "text"),
}

# The functions that declare.
DECLARING = [("gonio.model", name) for name in ("param", "option", "child")]

# What `gonio.model` gives every class.
GIVEN = ("name", "fields", "written", "float_type", "_on_arrays", "_bound", "__new__")


def _is_texts(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(v, str) for v in value)


def check(cls: type, model: type, field: type | Any) -> None:
    """Whether a class derives from what models may, and has what they may have.

    Args:
        cls: the class as its file has it.
        model: `gonio.model.Model`.
        field: the types of declarations.

    Raises:
        ModelError: what is wrong, with the name that it is about.
    """
    _check_bases(cls, model, field)
    annotated = inspect.get_annotations(cls, eval_str=False)
    own = vars(cls)
    for name, value in own.items():
        if isinstance(value, field):
            if hasattr(model, name) or name in model.__annotations__:
                raise wrong(
                    name,
                    f"{cls.__name__}: every model has {name}; give the parameter another name.",
                )
            continue
        if inspect.isfunction(value) and (value.__module__, value.__name__) in DECLARING:
            raise wrong(
                name,
                f"{cls.__name__}: {name} is not called; write {name}: ... = {value.__name__}(...).",
            )
        if inspect.isfunction(value) and name in annotated:
            raise wrong(
                name,
                f"{cls.__name__}: {name} is a parameter and a method; give one of them another name.",
            )
        if name in GIVEN:
            raise wrong(name, f"{cls.__name__}: gonio gives every model its {name}; leave it out.")
        if name in ABOUT and not ABOUT[name][0](value):
            raise wrong(name, f"{cls.__name__}: {name} is {ABOUT[name][1]}, not {value!r}.")
        _check_method(cls, model, name, value)
    if "__init__" in own or _above(cls, model, "__init__"):
        _check_init(cls)


def _check_bases(cls: type, model: type, field: type | Any) -> None:
    for base in cls.__mro__:
        if base is not object and vars(builtins).get(base.__name__) is base:
            raise ModelError(
                f"{cls.__name__} derives from {base.__name__}, of which no model can be; derive it from "
                "Model, and from classes of your own."
            )
        if not issubclass(base, model):
            found = [n for n, v in vars(base).items() if n in GUARDS or isinstance(v, field)]
            if found:
                raise ModelError(
                    f"{cls.__name__}: {base.__name__} has {found[0]}, but is no model; write "
                    f"class {base.__name__}(Model, register=False)."
                )


def _check_method(cls: type, model: type, name: str, value: Any) -> None:
    known = vars(model).get(name)
    if name in GUARDS:
        wanted = list(inspect.signature(vars(model)[name]).parameters)
        plain = inspect.isfunction(value) and not inspect.iscoroutinefunction(value)
        given = list(inspect.signature(value).parameters) if plain else []
        swapped = given != wanted and sorted(given) == sorted(wanted)
        if len(given) != len(wanted) or swapped:
            raise wrong(name, f"{cls.__name__}: write def {name}({', '.join(wanted)}).")
    elif name[:2] != "__" and inspect.isroutine(known) and not inspect.isroutine(value):
        raise wrong(
            name,
            f"{cls.__name__}: {name} is a method of every model; give what is not one another name.",
        )


def _above(cls: type, model: type, name: str) -> bool:
    """Whether a class that is no model has a name, and comes before all models: a mixin."""
    first = next(base for base in cls.__mro__ if name in vars(base))
    return not issubclass(first, model)


def _check_init(cls: type) -> None:
    """A model is made by its name alone as well, so that nothing may be left to give."""
    _, *parameters = inspect.signature(cls.__init__).parameters.values()  # type: ignore[misc]
    for parameter in parameters:
        several = parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD)
        if parameter.default is parameter.empty and not several:
            raise wrong(
                "__init__",
                f"{cls.__name__}: __init__ cannot do without {parameter.name}; give it a default, as "
                "models are made by their names alone too.",
            )


def _is_of_protocol(cls: type) -> bool:
    """Whether a class is a typing.Protocol, whose __init__ gives way to that of the next class."""
    return bool(vars(cls).get("_is_protocol"))


def made_whole(cls: Any) -> Any:
    """A class's own __init__, after which all parameters have a value."""
    bases = (base for base in cls.__mro__ if not _is_of_protocol(base))
    init = next(base for base in bases if "__init__" in vars(base)).__init__

    @functools.wraps(init)
    def call(self: Any, /, *nameless: Any, **given: Any) -> None:
        init(self, *nameless, **given)
        missing = [name for name in self.fields if name not in vars(self)]
        if missing and self.written is cls:
            code = inspect.unwrap(init).__code__
            raise ModelError(
                f"{cls.__name__}: __init__ in {code.co_filename}, line {code.co_firstlineno}, leaves "
                f"{missing[0]} without a value; write super().__init__(**given) in it."
            )

    return call


def check_fields(cls: type, fields: Mapping[str, Any]) -> None:
    """Whether what a class declares or inherits is all that it has under these names.

    Raises:
        ModelError: a property, method or number over a parameter, or under it.
    """
    annotated = inspect.get_annotations(cls, eval_str=False)
    for name in fields:
        base = next((base for base in cls.__mro__ if name in vars(base)), None)
        if base is not None:
            kind = _kind(vars(base)[name])
            where = "" if base is cls else f" of {base.__name__}"
            raise wrong(
                name,
                f"{cls.__name__}: {name} is a {kind}{where} and a parameter; give one of them another "
                f"name, or declare {name} anew by param(...).",
            )
    for name in annotated:
        if not hasattr(cls, name) and name not in fields and _is_width(cls, name):
            raise wrong(
                name,
                f"{cls.__name__}: {name} has no value; write {name}: ... = param(default, low, high, "
                '"what it means").',
            )


def check_claims(cls: type, fields: Mapping[str, Any]) -> None:
    """Whether a class's own claims say something of what it has: what says nothing would be kept always.

    Raises:
        ModelError: what says nothing.
    """
    claims = vars(cls).get("claims")
    if not isinstance(claims, Claims):
        return
    options = {name: field.values for name, field in fields.items() if isinstance(field, Option)}

    def is_parameter(path: str) -> bool:
        name, _, inner = str(path).partition(".")
        declared = fields.get(name)
        of_another = declared is not None and not isinstance(declared, (Parameter, Option))
        return of_another if inner else isinstance(declared, Parameter)

    for fault in claims.faults(is_parameter, options):
        raise wrong("claims", f"{cls.__name__}: in its claims {fault}.")


def _kind(value: Any) -> str:
    """What a value is to people."""
    if isinstance(value, property):
        return "property"
    if inspect.isroutine(value) or isinstance(value, (staticmethod, classmethod)):
        return "method"
    return "place of __slots__" if inspect.ismemberdescriptor(value) else "name of the class"


def _hint(cls: type, name: str) -> Any:
    """What the annotation of a name means, of the class or of those above it; None without one.

    That of this name alone: others may be for checkers of types only.
    """
    for base in cls.__mro__:
        hint = inspect.get_annotations(base, eval_str=False).get(name)
        for _ in range(2):  # text of its own, and made text by 'from __future__ import annotations'
            if isinstance(hint, str):
                hint = eval(hint, _names(base), dict(vars(base)))
        if hint is not None:
            return hint
    return None


def _names(cls: type) -> dict[str, Any]:
    """The names of a class's module, or those that its methods see, where Python ran text of no module."""
    for value in vars(cls).values():
        function = inspect.unwrap(value) if inspect.isfunction(value) else None
        if function is not None and function.__module__ in (None, cls.__module__):
            names: dict[str, Any] = function.__globals__
            return names
    module = sys.modules.get(cls.__module__)
    return vars(module) if module else {}


def _is_width(cls: type, name: str) -> bool:
    """Whether a name is annotated as parameters are; not if that is known to checkers of types alone."""
    try:
        return _hint(cls, name) in (Float, Color)
    except Exception:  # whatever stops in what is written there
        return False


def width(cls: type, declared: Parameter) -> int:
    """How many numbers a parameter has, by its annotation."""
    name = declared.name
    try:
        hint = _hint(cls, name)
    except NameError as error:
        raise wrong(
            name,
            f"{cls.__name__}: the annotation {error.name} is not known; import it at the top of the file.",
        ) from None
    except Exception:  # whatever stops in what is written there
        hint = None
    if hint is not Color and hint is not Float:
        raise wrong(
            name, f"{cls.__name__}: write {name}: Float = param(...) or {name}: Color = param(...)."
        )
    return 3 if hint is Color else 1


def default(cls: type, declared: Parameter) -> Any:
    """A parameter's default, as it is checked for all values."""
    if is_array(declared.default):
        raise wrong(
            declared.name,
            f"{cls.__name__}: the default of {declared.name} is a number or three, not an array.",
        )
    try:
        return declared.check(cls.__name__, declared.default)
    except ModelError as error:
        error.about = declared.name
        raise


def explained(fields: Mapping[str, Any]) -> Iterator[str]:
    """Lines of a docstring that say what the parameters mean."""
    if fields:
        yield from ("", "Parameters:")
    for name, declared in fields.items():
        yield f"    {name}: {declared.explained()}"
