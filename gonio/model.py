"""The contract of a shading model, its parameters, and the registry that fills itself.

A model is a class with fields made by `param` and `option` and the methods `eval`, `sample`, `pdf` and
`albedo`, written in the vocabulary of `gonio.lang`. Deriving from `Model` registers it under the name
of its file. The base class does what models must not repeat: it checks and converts what users pass
in, keeps parameter values out of compiled kernels, and makes everything zero below the horizon.

What happens when `gonio.EON(roughness=1).eval(wi, wo)` is called: two objects take part, each of a class
of its own.

1. `EON(...)` makes what users hold: an instance of EON's variant on arrays, a class derived from EON and
   `OnArrays`. Its parameters are numbers or arrays as they were given, its `eval` is that of `OnArrays`.
2. `OnArrays.eval` hands over to `gonio.arrays.call`, which finds out whose arrays they are (NumPy's,
   PyTorch's ...), broadcasts and checks them, and makes Dr.Jit values of them.
3. `Model.bind` makes the bound model: an instance of EON as its file has it, whose parameters are Dr.Jit
   values of the kernel's `float_type`.
4. `eval` of the bound model is what the file says, between the guards of `gonio.horizon`. Whatever it
   calls, its own methods, those of a class above by `super()`, or those of models inside, is bound as well.

Renderers bind models themselves (`gonio.mitsuba.bsdf`), and exports read the file's text.
"""

from __future__ import annotations

import functools
import inspect
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import new_class
from typing import Any, ClassVar, Self

from gonio import arrays, class_body, notebook
from gonio.albedos import quadrature
from gonio.albedos.numeric import for_quadrature, mean_over_directions
from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims
from gonio.fields import ModelError, Option, Parameter, framework, shown
from gonio.horizon import GUARDS
from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.messages import did_you_mean
from gonio.parts.interface import gather, leave, pdf_leave, refract


@dataclass
class Child:
    """A model inside a model, such as the base under a coat."""

    default: str
    doc: str
    name: str = ""

    def check(self, parent: str, value: Any) -> Model:
        """Return a model, made from its name if need be, else raise."""
        if isinstance(value, str):
            try:
                return model(value)
            except RecursionError:
                raise ModelError(
                    f"{parent}: {self.name} has {parent} inside by default, which never ends; "
                    "give it another default."
                ) from None
            except ModelError as error:
                raise ModelError(f"{parent}: {self.name}: {error}") from None
        if not isinstance(value, Model):
            raise ModelError(
                f"{parent}: {self.name} takes a model or a model's name, got {value!r}."
            )
        return value

    def is_default(self, value: Model) -> bool:
        """Whether a value is the default model with its default parameters."""
        return value == model(self.default)

    def key(self, value: Model) -> Model:
        """What two values share if and only if they are the same."""
        return value

    def range_text(self) -> str:
        """What is allowed, for people."""
        return "a model or its name"

    def explained(self) -> str:
        """Meaning and default in one line."""
        return f"{self.doc}; {self.range_text()}, default {self.default!r}"


Field = Parameter | Option | Child


def param(
    default: Any,
    low: float,
    high: float,
    doc: str,
    *,
    rougher: Callable[[Any, Any], Any] | None = None,
    kind: str = "",
) -> Any:
    """Declare a number or colour: default, range and meaning. The annotation says which of the two.

    A parameter that is the width of a highlight says by a function of `gonio.parts.roughness` on which
    scale, so that a rough coat can widen it. `kind` says what a number is where its name does not, such as
    "index" (see `gonio.export.manifest.kind`): it decides how hosts show it.

    Raises:
        ModelError: ends that are no numbers, or in the wrong order, or a meaning that is no text.
    """
    numbers = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in (low, high))
    if not numbers or not low < high or not isinstance(doc, str):
        raise ModelError(
            'write param(default, low, high, "what it means") with low < high, '
            f"not param({default!r}, {low!r}, {high!r}, {doc!r})."
        )
    if not (rougher is None or callable(rougher)) or not isinstance(kind, str):
        raise ModelError(
            "rougher is a function of gonio.parts.roughness, and kind is text, "
            f"not rougher={rougher!r}, kind={kind!r}."
        )
    return Parameter(default, low, high, doc, rougher=rougher, kind=kind)


def option(*values: str, doc: str) -> Any:
    """Declare a choice that changes the code; the first value is the default.

    Raises:
        ModelError: no values, values that are no text, or one of them twice.
    """
    texts = [v for v in (*values, doc) if isinstance(v, str)]
    if not values or len(texts) <= len(values) or len(set(values)) < len(values):
        raise ModelError(
            'write option("first", "second", doc="what it means") with different texts, not '
            f"option({', '.join(map(repr, values))}, doc={doc!r})."
        )
    return Option(values, doc)


def child(default: str, doc: str) -> Any:
    """Declare a model inside the model, by the name of the default one.

    Raises:
        ModelError: what is no name.
    """
    if not isinstance(default, str) or not isinstance(doc, str):
        raise ModelError(
            f'write child("lambert", "what it means"), not child({default!r}, {doc!r}).'
        )
    return Child(default, doc)


_registry: dict[str, type[Model]] = {}

HEADS = ("parameter", "value", "allowed", "meaning")
"""What the columns of `Model.rows` are."""


class Model:
    """A reflection model (BRDF). Directions are unit vectors in the local frame, with the normal +z.

    `wi` points towards the light, `wo` towards the viewer. NumPy, PyTorch and JAX arrays have the
    component last, broadcast, and come back as what came in; Dr.Jit arrays pass straight through.
    Numbers and arrays alike can be given for every parameter.

    A subclass is the model as its file has it, and instances of it are bound, inside a kernel. Calling the
    class makes its variant on arrays instead, which users hold; see the module's description.
    """

    fields: ClassVar[Mapping[str, Field]] = {}
    name: ClassVar[str] = ""
    description: ClassVar[str] = ""
    """The docstring as the class has it; `__doc__` explains the parameters as well."""
    caveats: ClassVar[tuple[str, ...]] = ()
    """What is known to be wrong with the model, each with its size; for people."""
    unlike: ClassVar[tuple[tuple[str, str], ...]] = ()
    """Models that it should not be confused with, by name, and in what they differ."""
    claims: ClassVar[Claims] = Claims()
    """What the model promises, for `gonio check`; strict unless a model says otherwise."""
    numeric: NumericAlbedo = NumericAlbedo()
    """How albedos without a closed form are found."""
    isotropic: ClassVar[bool] = True
    """False if the model itself changes when both directions turn; see `follows_tangents`."""

    written: ClassVar[type[Any]]
    """The class as the model's file has it: of what users hold and of bound models alike."""

    float_type: Any
    """Number type of the kernel that a bound model lives in; what users hold has none."""

    _on_arrays: ClassVar[type[Any]]
    _bound: dict[Any, Any]

    def __init_subclass__(cls, *, register: bool = True) -> None:
        """Collect the fields, put the guards around the methods, and register the model.

        A model is named after its file; in a notebook or a script that is run, after its class.
        `class Variant(EON, register=False)` keeps a private variant out of the registry. Variants on arrays
        are the only classes that are not written.
        """
        super().__init_subclass__()
        if vars(cls).get("_of_arrays"):
            return
        if issubclass(cls, OnArrays):
            raise ModelError(
                f"{cls.__name__} derives from the type of a model; derive from model.written, its class."
            )
        class_body.check(cls, Model, Field)
        cls.written = cls
        cls.name = cls.__module__.rpartition(".")[2]
        if cls.name == "__main__" or not register:
            cls.name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()
        cls.fields = {
            name: declared
            for base in reversed(cls.__mro__[1:])
            for name, declared in vars(base).get("fields", {}).items()
        }
        for name, declared in list(vars(cls).items()):
            if isinstance(declared, Field):
                own = replace(declared, name=name)  # another name may have the same one
                if isinstance(own, Parameter):
                    own.width = class_body.width(cls, own)
                    own.default = class_body.default(cls, own)
                cls.fields[name] = own
                delattr(cls, name)
        class_body.check_fields(cls, cls.fields)
        class_body.check_claims(cls, cls.fields)
        if cls.__init__ is not Model.__init__:
            cls.__init__ = class_body.made_whole(cls)  # type: ignore[method-assign]
        quadrature.check_declared(cls, cls.writes)
        cls.description = inspect.cleandoc(vars(cls).get("__doc__") or cls.description)
        cls.__doc__ = "\n".join([cls.description, *class_body.explained(cls.fields)])
        for name, guard in GUARDS.items():
            if name in vars(cls):
                setattr(cls, name, _guarded(vars(cls)[name], guard))
        cls.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [
                inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=f.default)
                for name, f in cls.fields.items()
            ]
        )
        cls._on_arrays = _derive_on_arrays(cls)
        if not register:
            return
        known = _registry.get(cls.name)
        # Of one module it is the same one, defined again: a cell of a notebook that runs twice
        if known is not None and known.__module__ != cls.__module__ and _file(known) != _file(cls):
            raise ModelError(
                f"two models are called {cls.name!r}: {_file(known)} and {_file(cls)}; "
                "rename one file, or the class where it is defined in a script."
            )
        _registry[cls.name] = cls

    def __new__(cls, /, *_: Any, **__: Any) -> Self:
        """An instance of the variant on arrays, which users hold; `bind` makes the others."""
        if not hasattr(cls, "_on_arrays"):
            raise ModelError(f"{cls.__name__} is no model by itself; 'gonio list' shows all.")
        if "__dataclass_params__" in vars(cls.written):
            raise ModelError(
                f"{cls.__name__} is decorated by @dataclass, which replaces how models are made; leave it "
                "out."
            )
        made: Self = object.__new__(cls._on_arrays)
        return made

    def __init__(self, /, *nameless: Any, **given: Any) -> None:
        """Take parameters by name: numbers, triples, names of options, models, or arrays.

        A parameter of an inner model has its path for a name: `**{"base.roughness": 0.5}`.

        Raises:
            ModelError: an unknown name (with the nearest known one), or a number out of its range.
        """
        if nameless:
            raise ModelError(
                f"{self.name} takes what it is given by name, not {nameless[0]!r} alone; "
                f"known are {', '.join(self.fields)}."
            )
        inner: dict[str, dict[str, Any]] = {}
        for name in list(given):
            outer, dot, rest = name.partition(".")
            if not isinstance(self.fields.get(outer), Child if dot else Field):
                raise ModelError(f"{self.name} has no {name!r}{_suggest(name, self.fields)}.")
            if dot:
                inner.setdefault(outer, {})[rest] = given.pop(name)
        for name, declared in self.fields.items():
            value: Any = declared.check(self.name, given.get(name, declared.default))
            if name in inner:
                value = value.replace(**inner[name])
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_bound", {})
        self.check_together()

    def check_together(self) -> None:
        """Raise a ModelError where values do not go together: for models that have such values."""

    @classmethod
    def writes(cls, method: str) -> bool:
        """Whether this class, or a model above it, has a method of its own, beside what `Model` has."""
        return getattr(cls.written, method) is not vars(Model)[method]

    def __setattr__(self, name: str, value: Any) -> None:
        """Models do not change; a changed copy is made by `replace`."""
        if name not in self.fields:
            raise AttributeError(
                f"a model does not change, and {self.written.__name__} has no parameter {name}; declare it "
                "by param(...), or make it a name of the class."
            )
        raise AttributeError(
            f"a model does not change; use model.replace({name}={value!r}) for a changed copy."
        )

    def __delattr__(self, name: str) -> None:
        """Models do not change."""
        raise AttributeError(f"a model does not change, so its {name} stays.")

    def __repr__(self) -> str:
        """The call that makes this model, without the defaults."""
        given = (
            f"{name}={getattr(self, name)!r}"
            for name, declared in self.fields.items()
            if not declared.is_default(getattr(self, name))
        )
        return f"{self.written.__name__}({', '.join(given)})"

    def __eq__(self, other: object) -> bool:
        """Whether it is the same model with the same parameters; arrays have to be the same objects."""
        if not isinstance(other, Model):
            return NotImplemented
        return self.written is other.written and self._key() == other._key()

    def __hash__(self) -> int:
        """Equal models have equal hashes."""
        return hash((self.written, self._key()))

    def _key(self) -> tuple[Any, ...]:
        return tuple(f.key(getattr(self, name)) for name, f in self.fields.items())

    def _repr_html_(self) -> str:
        """A table of the parameters, for notebooks."""
        return notebook.table(self.written.__name__, self.description, HEADS, self.rows())

    def rows(self, prefix: str = "") -> Iterator[tuple[str, str, str, str]]:
        """Path, value, allowed values and meaning of all fields, those of inner models included."""
        for name, declared in self.fields.items():
            value = getattr(self, name)
            inside = isinstance(value, Model)
            text = value.written.__name__ if inside else shown(value)
            yield prefix + name, text, declared.range_text(), declared.doc
            if inside:
                yield from value.rows(f"{prefix}{name}.")

    def replace(self, /, **changed: Any) -> Self:
        """Return a copy with some parameters or options changed."""
        made: Self = _empty(self.written)
        # Not the model's own __init__, if it has one, which may take other arguments
        Model.__init__(made, **{name: getattr(self, name) for name in self.fields} | changed)
        return made

    def at_least_as_rough(self, alpha: Float) -> Self:
        """A copy inside a kernel whose highlights are at least as wide as facets of this alpha.

        For the base under a rough coat: Elek, "Layered materials in real-time rendering", CESCG 2010,
        section 3: m2 = max(m1, m2). A model says by `param(..., rougher=...)` what that means for its
        parameters.
        """
        wider = {
            name: declared.rougher(getattr(self, name), alpha)
            for name, declared in self.fields.items()
            if isinstance(declared, Parameter) and declared.rougher is not None
        }
        copy: Self = object.__new__(self.written)
        vars(copy).update(vars(self) | wider)
        return copy

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, WITHOUT the cosine; 0 at and below the horizon."""
        raise ModelError(f"{self.name} has no method eval.")

    def eval_above(self, wi: Vec3, wo: Vec3) -> Color:
        """`eval` inside a kernel, without the test for the horizon: for directions known to be above it."""
        return as_written(self.written.eval)(self, wi, wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Sample `wi` for a known `wo` from two uniform random numbers in [0, 1).

        A Monte Carlo weight is eval(wi, wo) · wi.z / pdf. A pdf of 0 marks a wasted sample.
        """
        raise ModelError(f"{self.name} has no method sample.")

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density in 1/sr with which `sample` returns `wi`; 0 below the horizon."""
        raise ModelError(f"{self.name} has no method pdf.")

    def sample_leaving(self, wo: Vec3, u: Vec2, excess: Float) -> Vec3:
        """`sample` inside a kernel for a base under layers: the direction in which the light leaves them.

        wo: inside the lowest layer. excess: the product of the layers' indices, minus 1. Layers over layers
        override it: each calls the next once, whose light refracts as if there were one layer.
        """
        return leave(self.sample(wo, u).wi, excess)

    def pdf_leaving(self, wi: Vec3, wo: Vec3, excess: Float) -> Float:
        """Density of `sample_leaving` at wi, which is outside all layers, in 1/sr."""
        wi_t = refract(wi, excess)
        return pdf_leave(self.pdf(wi_t, wo), self.pdf(gather(wi, excess), wo), wi, wi_t, excess)

    def albedo(self, wo: Vec3) -> Color:
        """Directional albedo ∫ f μi dωi: closed form if known, else by quadrature."""
        return quadrature.directional_albedo(self, wo)

    def mean_albedo(self) -> Color:
        """Mean albedo (1/π) ∫ albedo(wo) μo dωo: closed form or quadrature."""
        return quadrature.mean_albedo(self)

    def with_numeric(self, numeric: NumericAlbedo) -> Self:
        """A copy whose albedos without a closed form are found in another way."""
        copy = self.replace()
        object.__setattr__(copy, "numeric", numeric)
        return copy

    def slope_widths(self) -> Vec2:
        """Widths of a `stretched` highlight's slopes along x and y, up to a factor."""
        raise NotImplementedError

    def eval_round(self, wi: Vec3, wo: Vec3) -> Color:
        """The part of `eval` that is not stretched; for a numeric albedo with a `round_part`."""
        raise NotImplementedError

    def follows_tangents(self) -> bool:
        """Whether turning both directions about the normal changes the value, of this or a model inside."""
        inner = (getattr(self, n) for n, kind in self.fields.items() if isinstance(kind, Child))
        return not self.isotropic or any(model.follows_tangents() for model in inner)

    def parameters(self, prefix: str = "") -> Iterator[tuple[str, Parameter, Any]]:
        """Yield path, declaration and value of every parameter, those of inner models included."""
        for name, declared in self.fields.items():
            value = getattr(self, name)
            if isinstance(declared, Parameter):
                yield prefix + name, declared, value
            elif isinstance(declared, Child):
                yield from value.parameters(f"{prefix}{name}.")

    def bind(
        self,
        Float: Any,
        convert: Callable[[str, Parameter, Any], Any],
        *,
        keep: bool = False,
        prefix: str = "",
    ) -> Self:
        """The bound model: as written, with parameters that are Dr.Jit values, for use inside a kernel.

        Args:
            Float: the number type of the kernel (`float` for plain Python).
            convert: makes a parameter's Dr.Jit value from its path, declaration and stored value.
            keep: remember the copy for this Float, so that numbers become device memory only once.
            prefix: of the paths, for inner models.
        """
        if keep and Float in self._bound:
            kept: Self = self._bound[Float]
            return kept
        bound: Self = object.__new__(self.written)
        for name, declared in self.fields.items():
            value = getattr(self, name)
            if isinstance(declared, Parameter):
                value = convert(prefix + name, declared, value)
            elif isinstance(declared, Child):
                value = value.bind(Float, convert, prefix=f"{prefix}{name}.")
            object.__setattr__(bound, name, value)
        object.__setattr__(bound, "float_type", Float)
        object.__setattr__(bound, "numeric", self.numeric)
        if keep:
            self._bound[Float] = bound
        return bound


class OnArrays(Model):
    """What users hold: a model whose methods take arrays of any framework and return the same kind.

    Directions and random numbers have the component last and broadcast, with parameters that are arrays as
    well. Every written model has a variant of this kind, which calling its class makes.
    """

    _of_arrays = True

    def eval(self, wi: Any, wo: Any) -> Any:
        """BRDF value in 1/sr, WITHOUT the cosine, shape (..., 3); 0 at and below the horizon."""
        return arrays.call(self, "eval", (wi, wo))

    def sample(self, wo: Any, u: Any) -> Sample:
        """Sample `wi` for a known `wo` from two uniform random numbers in [0, 1), shape (..., 2).

        A Monte Carlo weight is eval(wi, wo) · wi.z / pdf. A pdf of 0 marks a wasted sample.
        """
        found: Sample = arrays.call(self, "sample", (wo, u))
        return found

    def pdf(self, wi: Any, wo: Any) -> Any:
        """Density in 1/sr with which `sample` returns `wi`, shape (...); 0 below the horizon."""
        return arrays.call(self, "pdf", (wi, wo))

    def albedo(self, wo: Any) -> Any:
        """Directional albedo ∫ f μi dωi, shape (..., 3): closed form if known, else by quadrature."""
        model: OnArrays = self
        if not self.writes("albedo") and framework(wo) != "drjit":
            model = for_quadrature(self, wo, self._bound)
        return arrays.call(model, "albedo", (wo,))

    def mean_albedo(self) -> Any:
        """Mean albedo (1/π) ∫ albedo(wo) μo dωo, shape (..., 3): closed form or quadrature."""
        if not self.writes("mean_albedo"):
            mean = mean_over_directions(self)
            if mean is not None:
                return mean
        return arrays.call(self, "mean_albedo", ())

    def __reduce__(self) -> Any:
        """For copies and pickles: the class as written, and the values; what was bound is left out."""
        return _empty, (self.written,), vars(self) | {"_bound": {}}


def _empty(cls: type[Model]) -> Any:
    """A model without values, for those of another."""
    return cls.__new__(cls)


def _derive_on_arrays(cls: type[Model]) -> type[Model]:
    """The variant on arrays of a written model, under the same name."""
    named = {key: getattr(cls, key) for key in ("__module__", "__qualname__", "__doc__")}
    named["_of_arrays"] = True  # not a keyword, which classes beside the model may not take
    return new_class(cls.__name__, (OnArrays, cls), {}, lambda space: space.update(named))


def _file(cls: type[Model]) -> str:
    """Where a model is written; the name of a notebook's cell if it is there."""
    own = (as_written(value) for value in vars(cls).values())
    files = [value.__code__.co_filename for value in own if inspect.isfunction(value)]
    module = sys.modules.get(cls.__module__)
    return str(files[0] if files else getattr(module, "__file__", cls.__module__))


def as_written(method: Any) -> Any:
    """The function that a model's file has, without the guard around it."""
    return getattr(method, "__wrapped__", method)


def _suggest(name: str, known: Mapping[str, Any]) -> str:
    return f"; {did_you_mean(name, known)}known are {', '.join(known)}" if known else ""


def _guarded(method: Any, guard: Any) -> Any:
    """A written method whose results are masked below the horizon."""
    signature = inspect.signature(method)
    count = len(signature.parameters) - 1

    @functools.wraps(method)
    def call(self: Model, *directions: Any, **named: Any) -> Any:
        if isinstance(self, OnArrays):
            raise ModelError(
                f"{method.__qualname__} is written for kernels; call {method.__name__} of the model itself."
            )
        if named or len(directions) != count:
            directions = signature.bind(self, *directions, **named).args[1:]
        return guard(method, self, *directions)

    return call


for _name, _guard in GUARDS.items():
    setattr(Model, _name, _guarded(vars(Model)[_name], _guard))


def models() -> dict[str, type[Model]]:
    """All registered models by name, sorted."""
    return dict(sorted(_registry.items()))


def model(name: str, **parameters: Any) -> Model:
    """Make a model from its name and parameters, such as model("eon", roughness=1).

    Raises:
        ModelError: an unknown model or parameter, or a value out of range.
    """
    if name not in _registry:
        did = did_you_mean(name, _registry)
        raise ModelError(f"no model {name!r}; {did}'gonio list' shows all.")
    return _registry[name](**parameters)
