"""Calls: of the vocabulary, of functions, of a model's methods, and of what makes structs."""

from __future__ import annotations

import ast
import inspect
import types
from collections.abc import Sequence
from typing import Any, cast

from gonio import lang
from gonio.export import library
from gonio.export.expressions import OF_ALL, SIGNATURES, UNTESTED, Expressions, simplified
from gonio.export.source import source
from gonio.export.tree import (
    SELF,
    Access,
    Builtin,
    Call,
    Constant,
    Construction,
    ExportError,
    Expr,
    Number,
    Operation,
    Splat,
    Struct,
    Type,
    Variable,
    inside,
)
from gonio.export.values import Changed, Method, Static, Value, exact, is_number, shown_kind, spoken
from gonio.export.vocabulary import RULES, widest
from gonio.fields import Parameter
from gonio.lights.lookups import Lookups
from gonio.model import Model
from gonio.parts.frame import half_vector
from gonio.polynomials import terms_in_single
from gonio.table import Table, fetch

# Whole powers up to this are products; beyond it, a power of the absolute value.
PRODUCT_MAX = 16

# polynomial(x, bound, c0, c1)
POLYNOMIAL_MIN = 4

# Ends the name of a method that takes a vector of any length in the place of a unit one.
ALONG = "_along"

# End the name of the function of gonio.parts that exports call in the place of another with the same value:
# of one whose operations are there for derivatives, or for what arrays share with another function, where
# no derivatives are taken; and everywhere of one whose digits the rearranging compilers of shaders lose.
VALUE, PLAIN = "_value", "_plain"
PARTS = "gonio.parts."

# What annotations of a NamedTuple's members mean.
ANNOTATED: dict[Any, Type] = {
    lang.Vec2: "vec2",
    lang.Vec3: "vec3",
    lang.Color: "vec3",
}


class Calls(Expressions):
    """Reads the calls of one function."""

    def _call(self, node: ast.Call) -> Value:
        above = self._above(node.func)
        if above is not None and self.owner is not None:
            return self._inherited_call(node, above, self.owner, node.args)
        callee = self.value(node.func)
        if isinstance(callee, Method):
            return self._method_call(node, callee)
        if not isinstance(callee, Static):
            self.refuse(node, "this cannot be called.")
        function = callee.value
        if isinstance(function, types.MethodType) and isinstance(function.__self__, Lookups):
            return self._lookup(node, function)
        if isinstance(function, type) and hasattr(function, "_fields"):
            return self._record(node, function)
        if function is fetch:
            return self._fetch(node)
        if isinstance(function, types.FunctionType):
            if function.__module__ == lang.__name__ and function.__name__ in RULES:
                return self._builtin(node, function.__name__)
            if self.owner is not None and self._is_method_of_a_class(node, function):
                return self._inherited_call(node, function, self.owner, node.args[1:])
            if self._is_ours(function):
                return self._function_call(node, function)
        self.refuse(
            node.func,
            f"{ast.unparse(node.func)} is not in the vocabulary; use the functions of gonio.lang, or "
            "your own functions made of them.",
        )

    # --- methods -----------------------------------------------------------------------------------

    def _above(self, node: ast.expr) -> types.FunctionType | None:
        """The method behind super().name, if that is what is called."""
        if not (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Call)
            and isinstance(node.value.func, ast.Name)
            and node.value.func.id == "super"
            and "super" not in self.scope
            and self.owner is not None
        ):
            return None
        if node.value.args or node.value.keywords:
            self.refuse(
                node, "super() takes nothing here; or name the class: EON.eval(self, wi, wo)."
            )
        assert self.owner.model is not None
        classes = self.owner.model.written.__mro__
        # The class whose body the method stands in, which may have other names for it in classes below
        cells = dict(
            zip(self.python.__code__.co_freevars, self.python.__closure__ or (), strict=True)
        )
        here = cells["__class__"].cell_contents
        if here not in classes:
            self.refuse(
                node, f"{self.owner.model.written.__name__} derives not from {here.__name__}."
            )
        for cls in classes[classes.index(here) + 1 :]:
            if cls is Model or node.attr not in vars(cls):
                continue
            found = vars(cls)[node.attr]
            if isinstance(found, types.FunctionType):
                return found
            self.refuse(
                node,
                f"{node.attr!r} of {cls.__name__} is a {type(found).__name__}, which super() cannot call "
                f"in a shader; write a method, or {cls.__name__}.{node.attr} for a static one.",
            )
        self.refuse(node, f"no class above this one has a method {node.attr!r}.")

    def _is_method_of_a_class(self, node: ast.Call, function: types.FunctionType) -> bool:
        """Whether a call is Class.method(self, ...), with a class that the model derives from."""
        first = node.args[0] if node.args else None
        if not (isinstance(first, ast.Name) and first.id == self.self_name):
            return False
        assert self.owner is not None
        assert self.owner.model is not None
        return any(
            found is function
            for cls in self.owner.model.written.__mro__
            for found in vars(cls).values()
        )

    def _inherited_call(
        self,
        node: ast.Call,
        function: types.FunctionType,
        owner: Struct,
        arguments: Sequence[ast.expr],
    ) -> Expr:
        """A method of a class above, for this model: its own function beside the one that replaces it."""
        name = function.__name__
        plain = self._plain_function(node, name, function)
        call = ast.copy_location(ast.Call(node.func, list(arguments), node.keywords), node)
        passed, kinds = self._typed(self._arguments(call, plain, 1))
        guarded = name in SIGNATURES and name not in (UNTESTED, "mean_albedo")
        if guarded:
            self._check_signature(node, name, passed)
        tested = self.tested | (self.upper if name == "albedo" else frozenset())
        same = all(isinstance(e, Variable) and e.name in tested for e in passed)
        made = self._made(node, plain, kinds, owner, name, guarded and not same, passed)
        return Call(made, (Variable(SELF, owner), *passed), made.result)

    def _method_call(self, node: ast.Call, method: Method) -> Value:
        owner = method.model.type
        assert isinstance(owner, Struct)
        if owner.model is None:
            return self._record_method(node, method)
        if method.name == "at_least_as_rough":
            return self._rougher(node, method.model, owner)
        name = "eval" if method.name == UNTESTED else method.name
        function = self._method_of(node, owner, name)
        passed, kinds = self._typed(self._arguments(node, function, 1))
        if method.name in SIGNATURES:
            self._check_signature(node, method.name, passed)
            given = tuple(kind for _, kind in SIGNATURES[method.name][0])
            made = self._made(node, function, given, owner, method.name, True, passed)
        else:
            made = self._made(node, function, kinds, owner, "", True, passed)
        return Call(made, (method.model, *passed), made.result)

    def _record_method(self, node: ast.Call, method: Method) -> Expr:
        """A method of a NamedTuple: a function that takes its struct first."""
        if not self._is_ours(method.function) or hasattr(method.function, "__wrapped__"):
            self.refuse(node, f"{method.name!r} is no plain method; write one, or a function.")
        passed, kinds = self._typed(self._arguments(node, method.function, 1))
        function = self._along(method)
        if function is not None and len(passed) == 1 and self._is_half_vector(passed[0]):
            wi, wo = cast(Call, passed[0]).arguments
            passed = [Operation("+", wi, wo, "vec3")]
        else:
            function = method.function
        given = (method.model, *passed)
        kinds = [method.model.type, *kinds]
        made = self._made(node, function, kinds, None, "", True, given)
        return Call(made, given, made.result)

    def _along(self, method: Method) -> types.FunctionType | None:
        """The method of the same name that takes a vector of any length: D_along for D.

        Not where derivatives are taken, which leave single precision on the way for the shortest vectors.
        """
        kind = method.model.type
        assert isinstance(kind, Struct)
        found = vars(kind.python).get(f"{method.name}{ALONG}") if kind.python else None
        plain = isinstance(found, types.FunctionType) and not self.reader.differentiable
        return found if plain else None

    def _is_half_vector(self, expr: Expr) -> bool:
        return isinstance(expr, Call) and self.reader.origin(expr.function) is half_vector

    def _check_signature(self, node: ast.Call, name: str, passed: Sequence[Expr]) -> None:
        expected = SIGNATURES[name][0]
        if len(passed) != len(expected):
            self.refuse(node, f"{name} takes {', '.join(n for n, _ in expected)}.")
        for (argument, kind), expr in zip(expected, passed, strict=True):
            if expr.type != kind:
                self.refuse(node, f"{argument} must be a {spoken(kind)}.")

    def _method_of(self, node: ast.AST, owner: Struct, name: str) -> types.FunctionType:
        try:
            return method_of(owner, name)
        except MissingMethodError as error:
            self.refuse(node, str(error))

    def _plain_function(self, node: ast.AST, name: str, found: Any) -> types.FunctionType:
        function = written(name, found)
        if function is None:
            self.refuse(node, f"{name!r} is no plain method.")
        return function

    def _property(self, node: ast.Attribute, model: Expr, found: property) -> Value:
        owner = model.type
        assert isinstance(owner, Struct)
        if not isinstance(found.fget, types.FunctionType):
            self.refuse(node, f"the property {node.attr!r} is no plain function; write a method.")
        made = self._made(node, found.fget, [], owner, "", True, ())
        return Call(made, (model,), made.result)

    def _rougher(self, node: ast.Call, model: Expr, owner: Struct) -> Expr:
        """A copy of a model with wider highlights, each parameter by the function that it declares."""
        assert owner.model is not None
        method = cast(types.FunctionType, Model.at_least_as_rough)
        if owner.model.written.at_least_as_rough is not method:
            self.refuse(node, "at_least_as_rough is gonio's own; give the method another name.")
        ((at, value),) = self._arguments(node, method, 1)
        alpha = self._expr(at, value)
        members: dict[str, Expr] = {}
        for name, declared in owner.model.fields.items():
            if isinstance(declared, Parameter) and declared.rougher is not None:
                own = Access(model, name, "float")
                function = cast(types.FunctionType, declared.rougher)
                made = self._made(node, function, ["float", "float"], None, "", True, (own, alpha))
                members[name] = Call(made, (own, alpha), made.result)
        return Changed(model, owner, members) if members else model

    # --- functions ---------------------------------------------------------------------------------

    def _made(
        self,
        node: ast.AST,
        function: types.FunctionType,
        kinds: Sequence[Type | Static],
        owner: Struct | None,
        method: str,
        guarded: bool,
        passed: Sequence[Expr],
    ) -> Any:
        """The exported function, unless it would call itself or takes its exponent from here."""
        if self.reader.is_open(function, kinds, owner):
            self.refuse(
                node,
                f"{function.__name__} calls itself, which shading languages do not allow; write a loop "
                "over a fixed number of steps.",
            )
        made = self.reader.function_for(function, kinds, owner, method, guarded)
        for i in made.exponents:
            self._exponent(node, passed[i])
        return made

    @staticmethod
    def _is_ours(function: types.FunctionType) -> bool:
        """Whether it is a function of gonio's parts, or of the model's own files."""
        package = function.__module__.partition(".")[0]
        path = function.__code__.co_filename
        if package == "gonio":
            return (
                ".parts." in function.__module__
                or ".models." in function.__module__
                or ".lights." in function.__module__
                or ".measured." in function.__module__
                or (function.__module__ == library.__name__)
            )
        return "site-packages" not in path and "/lib/python" not in path and "<frozen" not in path

    def _function_call(self, node: ast.Call, function: types.FunctionType) -> Expr:
        if hasattr(function, "__wrapped__"):
            self.refuse(
                node.func,
                f"{function.__name__} is wrapped by a decorator, which would be left out; write what the "
                "decorator does into the function.",
            )
        arguments = self._arguments(node, function, 0)
        passed, kinds = self._typed(arguments)
        self._check_pairs(arguments, function, kinds)
        function = self._stand_in(function)
        made = self._made(node, function, kinds, None, "", True, passed)
        return Call(made, tuple(passed), made.result)

    def _check_pairs(
        self,
        arguments: Sequence[tuple[ast.expr, Value]],
        function: types.FunctionType,
        kinds: Sequence[Type | Static],
    ) -> None:
        """Refuse a vector in the place of a pair of numbers, of which Python would take two components."""
        names = list(inspect.signature(function).parameters)
        for (node, _), name, kind in zip(arguments, names, kinds, strict=True):
            wanted = function.__annotations__.get(name)
            pair = wanted == "Vec2" or wanted is lang.Vec2
            if pair != (kind == "vec2") and (pair or wanted in ("Vec3", lang.Vec3)):
                self.refuse(
                    node, f"{name} of {function.__name__} must be a {'Vec2' if pair else 'Vec3'}."
                )

    def _stand_in(self, function: types.FunctionType) -> types.FunctionType:
        """What exports call in its place."""
        if not function.__module__.startswith(PARTS):
            return function
        for ending in (PLAIN,) if self.reader.differentiable else (PLAIN, VALUE):
            found = function.__globals__.get(f"{function.__name__}{ending}")
            if isinstance(found, types.FunctionType):
                return found
        return function

    def _lookup(self, node: ast.Call, method: types.MethodType) -> Expr:
        """A call of what the host supplies."""
        declared = vars(Lookups)[method.__name__]
        made = self.reader.lookup(declared)
        arguments = self._arguments(node, declared, 1)
        passed = tuple(
            self._coerce(at, self._expr(at, value), kind)
            for (at, value), (_, kind) in zip(arguments, made.parameters, strict=True)
        )
        return Call(made, passed, made.result)

    def _fetch(self, node: ast.Call) -> Expr:
        """A call that reads a table."""
        (at, found), (where, index) = self._arguments(node, fetch, 0)
        if not isinstance(found, Static) or not isinstance(found.value, Table):
            self.refuse(
                at, "fetch reads a gonio.table.Table; give one a name in the module or class."
            )
        model = self.owner.model if self.owner is not None else None
        owned = model is not None and any(
            value is found.value for cls in model.written.__mro__ for value in vars(cls).values()
        )
        made = self.reader.table(found.value, self.owner if owned else None)
        place = self._coerce(where, self._expr(where, index), "float")
        return Call(made, (place,), made.result)

    def _arguments(self, node: ast.Call, function: Any, skip: int) -> list[tuple[ast.expr, Value]]:
        """The arguments of a call in the order of the function's own; `skip` of them are given already."""
        for argument in node.args:
            if isinstance(argument, ast.Starred):
                self.refuse(argument, "name each argument.")
        for keyword in node.keywords:
            if keyword.arg is None:
                self.refuse(keyword.value, "name each argument.")
        signature = inspect.signature(function, follow_wrapped=False)
        parameters = list(signature.parameters.values())[skip:]
        names = ", ".join(p.name for p in parameters) or "none"
        if any(p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in parameters):
            self.refuse(node, "*args and **kwargs have no meaning in a shader; name each one.")
        if len(node.args) > sum(p.kind is not p.KEYWORD_ONLY for p in parameters):
            self.refuse(node, f"{len(parameters)} arguments are expected: {names}.")
        named = {str(k.arg): k.value for k in node.keywords}
        try:
            bound = signature.replace(parameters=parameters).bind(*node.args, **named).arguments
        except TypeError as error:
            text = str(error).removeprefix("missing a required argument: ")
            wrong = f"{text} missing" if text != str(error) else text
            self.refuse(node, f"{wrong}; the arguments are {names}.")
        found: list[tuple[ast.expr, Value]] = []
        for parameter in parameters:
            if parameter.name in bound:
                argument = bound[parameter.name]
                found.append((argument, self.value(argument)))
            elif is_number(parameter.default):
                found.append((node, self._number(node, parameter.default)))
            else:
                found.append((node, Static(parameter.default)))
        return found

    def _typed(
        self, arguments: list[tuple[ast.expr, Value]]
    ) -> tuple[list[Expr], list[Type | Static]]:
        """Arguments that are passed, and what a function is specialised for."""
        passed: list[Expr] = []
        kinds: list[Type | Static] = []
        for node, value in arguments:
            if isinstance(value, Static) and not is_number(value.value):
                try:
                    hash(value)
                except TypeError:
                    self.refuse(node, f"{shown_kind(value.value)} cannot be passed in a shader.")
                kinds.append(value)
                continue
            expr = self._expr(node, value)
            if isinstance(expr, Changed):
                self.refuse(node, "give the changed model a name first: rougher = ...")
            passed.append(expr)
            kinds.append(expr.type)
        return passed, kinds

    # --- structs -----------------------------------------------------------------------------------

    def _record(self, node: ast.Call, cls: Any) -> Expr:
        """A NamedTuple from its members."""
        if tuple not in cls.__bases__:
            self.refuse(
                node,
                f"{cls.__name__} derives from a NamedTuple and may change what its members are; write one "
                "NamedTuple with all members.",
            )
        for name in (cls.__name__, *cls._fields):
            self._check_spelling(node, name)
        arguments = self._arguments(node, cls.__new__, 1)
        hints = inspect.get_annotations(cls, eval_str=True)
        if cls is lang.Sample:
            (at_wi, wi), (at_pdf, pdf) = arguments
            wi, pdf = self._expr(at_wi, wi), self._expr(at_pdf, pdf)
            parts = (self._coerce(node, wi, "vec3"), self._coerce(node, pdf, "float"))
            return Construction(parts, self.reader.sample)
        values: list[Expr] = []
        given: list[Type | Static] = []
        for name, (at, value) in zip(cls._fields, arguments, strict=True):
            if isinstance(value, Static) and not is_number(value.value):
                given.append(value)
                continue
            expr = self._expr(at, value)
            wanted = ANNOTATED.get(hints.get(name))
            if wanted is not None:
                expr = self._coerce(at, expr, wanted)
            if isinstance(expr, Changed):
                self.refuse(at, "give the changed model a name first: rougher = ...")
            values.append(expr)
            given.append(expr.type)
        if not values:
            self.refuse(
                node, f"{cls.__name__} has no value in a shader; give it a number or vector."
            )
        return Construction(tuple(values), self.reader.record(cls, tuple(given)))

    # --- the vocabulary ----------------------------------------------------------------------------

    def _builtin(self, node: ast.Call, name: str) -> Expr:
        rule = RULES[name]
        if name == "polynomial":
            return self._polynomial(node)
        arguments = self._arguments(node, getattr(lang, name), 0)
        values = [self._expr(n, v) for n, v in arguments]
        if name in ("vec2", "vec3"):
            kind: Type = "vec2" if name == "vec2" else "vec3"
            if any(v.type != "float" for v in values):
                self.refuse(node, f"{name} takes {rule.count} numbers.")
            return Construction(tuple(values), kind)
        if name == "select":
            return self._select(node, *values)
        kinds = tuple(v.type for v in values)
        for kind in kinds:
            if kind not in rule.takes:
                self.refuse(node, f"{name} cannot take a {spoken(kind)}.")
        if name == "power":
            return self._power(node, *values)
        if name in self.reader.lacking:
            made = self.reader.function_for(getattr(library, name), kinds)
            return Call(made, tuple(values), made.result)
        if rule.splat:
            values = [self._coerce(node, v, widest(kinds)) for v in values]
        return Builtin(name, tuple(values), rule.result(kinds))

    def _polynomial(self, node: ast.Call) -> Expr:
        """The first terms of a polynomial, those that single precision can tell, by Horner's rule."""
        if node.keywords or len(node.args) < POLYNOMIAL_MIN:
            self.refuse(node, "write polynomial(x, bound, c0, c1, ...).")
        x = self.expr(node.args[0])
        if x.type != "float":
            self.refuse(node, f"polynomial cannot take a {spoken(x.type)}.")
        if not isinstance(x, (Variable, Access)):
            self.refuse(
                node.args[0], "x stands in the text once for each term; give it a name first."
            )
        given = [e for argument in node.args[1:] for e in self._numbers(argument)]
        values = [exact(e) for e in given]
        if any(value is None for value in values):
            self.refuse(node, "polynomial's bound and coefficients are numbers, not variables.")
        count = terms_in_single(values[0], values[1:])
        *below, found = given[1 : count + 1]
        for coefficient in reversed(below):
            found = simplified("+", coefficient, simplified("*", x, found, "float"), "float")
        return found

    def _numbers(self, node: ast.expr) -> list[Expr]:
        """A number, or those of a tuple with a name: *COEFFICIENTS."""
        if not isinstance(node, ast.Starred):
            return [self.expr(node)]
        value = self.value(node.value)
        if not isinstance(value, Static) or not isinstance(value.value, tuple):
            self.refuse(node, "a star is for numbers in a tuple that has a name.")
        return [self._expr(node, Static(number)) for number in value.value]

    def _power(self, node: ast.Call, base: Expr, exponent: Expr) -> Expr:
        """Whole powers by products: for any base, as in Python; a shader's pow knows positive ones."""
        kind = widest((base.type, exponent.type))
        number = exact(exponent)
        if number is None:
            self._exponent(node, exponent)
        if number is None or number != int(number):
            base, exponent = self._coerce(node, base, kind), self._coerce(node, exponent, kind)
            return Builtin("power", (base, exponent), kind)
        whole = int(number)
        if whole < 0:
            over = self._whole_power(base, -whole)
            return self._of_numbers(node, Operation("/", Number(1), over, base.type))
        return self._whole_power(base, whole)

    def _whole_power(self, base: Expr, whole: int) -> Expr:
        if whole == 0:
            return Number(1) if base.type == "float" else Splat(Number(1), base.type)
        if whole == 1:
            return base
        named = isinstance(base, (Variable, Access, Constant, Number))
        if whole == 2 and named:
            return Operation("*", base, base, base.type)
        made = self.reader.power(whole, base.type)
        return Call(made, (base,), base.type)

    def _exponent(self, node: ast.AST, exponent: Expr) -> None:
        """Take note of an exponent that may be a plain number in Python, for which it has products."""
        names = {e.name for e in inside(exponent) if isinstance(e, Variable)}
        arguments = {n for n in names if n in self.arguments}
        self.exponents |= arguments
        known = exact(exponent)
        plain = bool(names & self.plain) and not (names - self.plain)
        if plain or (known is not None and known == int(known)):
            self.refuse(
                node,
                "this exponent is a whole number in Python, which allows negative bases, and a variable in "
                "a shader, which does not; write it where power is called, or multiply in the loop.",
            )

    def _select(self, node: ast.Call, condition: Expr, yes: Expr, no: Expr) -> Expr:
        if condition.type not in ("bool", "bool3"):
            self.refuse(
                node, "select's condition is a comparison, or comparisons joined by & and |."
            )
        kinds = (yes.type, no.type)
        if kinds == ("bool", "bool"):
            self.refuse(node, "select between numbers or vectors; join masks with & and |.")
        if any(k not in ("float", "vec2", "vec3") for k in kinds):
            self.refuse(node, "select between numbers or vectors.")
        if condition.type == "bool3" and "vec2" in kinds:
            self.refuse(node, "a mask of a colour selects between colours or numbers.")
        kind: Type = "vec3" if condition.type == "bool3" else widest(kinds)
        yes, no = self._coerce(node, yes, kind), self._coerce(node, no, kind)
        return Builtin("select", (condition, yes, no), kind)


class MissingMethodError(ExportError):
    """A method that is not there, or that Python integrates."""


def written(name: str, found: Any) -> types.FunctionType | None:
    """The function that a model's author wrote, without the contract around its own methods."""
    if isinstance(found, property):
        found = found.fget
    if name in SIGNATURES and isinstance(found, types.FunctionType):
        found = getattr(found, "__wrapped__", found)
    return found if isinstance(found, types.FunctionType) else None


def method_of(owner: Struct, name: str) -> types.FunctionType:
    """The function that a model's author wrote for a method, or the one that stands for Model's own.

    Raises:
        ExportError: there is none that could be exported.
    """
    model = owner.model
    assert model is not None
    found = inspect.getattr_static(model.written, name)
    function = written(name, found)
    if function is None:
        raise MissingMethodError(f"{model.written.__name__}.{name} is no plain method.")
    if name not in OF_ALL and function is written(name, vars(Model).get(name)):
        if name == "albedo":
            return cast(types.FunctionType, library.sampled_albedo)
        if name == "mean_albedo":
            raise MissingMethodError(
                f"{model.name} has no closed form of its mean albedo, which shading code cannot integrate; "
                "choose another base, or an option that does not need it."
            )
        raise MissingMethodError(
            f"{model.name} has no {name}; write the method, or leave it out: --only eval, for example."
        )
    if hasattr(function, "__wrapped__"):
        inner = cast(types.FunctionType, inspect.unwrap(function))
        file = source(inner.__code__.co_filename)
        raise file.complaint(
            file.function(inner),
            f"{name} is wrapped by a decorator, which would be left out; write what the decorator does "
            "into the method.",
        )
    return function


def usual_name(function: types.FunctionType) -> str:
    """What a function is called in an export: one that stands for another has the other's name."""
    found = function.__name__
    if function.__module__.startswith(PARTS):
        return found.removesuffix(VALUE).removesuffix(PLAIN)
    return found
