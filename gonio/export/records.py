"""Classes of a user's own that become structs: NamedTuples, and dataclasses that are members alone."""

from __future__ import annotations

import dataclasses
import inspect
import types
from typing import Any, cast

# Methods that decide what members are.
DECIDING = ("__post_init__", "__getattr__", "__getattribute__", "__iter__", "__getitem__")


def members(cls: Any) -> tuple[str, ...] | None:
    """The names of a struct's members; None of a class that is neither of both kinds."""
    if not isinstance(cls, type):
        return None
    if issubclass(cls, tuple):
        return cast(tuple[str, ...] | None, getattr(cls, "_fields", None))
    return tuple(f.name for f in dataclasses.fields(cls)) if dataclasses.is_dataclass(cls) else None


def defect(cls: Any) -> str:
    """Why such a class is none that a shader can have; empty if it is one."""
    name, own = cls.__name__, vars(cls)
    if issubclass(cls, tuple):
        if tuple in cls.__bases__ and not any(n in own for n in DECIDING):
            return ""
        return (
            f"{name} derives from a NamedTuple, or has a method that may change what its members are; "
            "write one NamedTuple with all members."
        )
    fields = dataclasses.fields(cls)
    names = [f.name for f in fields]
    made = own.get("__dataclass_params__")
    plain = (
        cls.__bases__ == (object,)
        and made is not None
        and made.init
        and (made.frozen or "__setattr__" not in own)
        and all(f.init and f.default_factory is dataclasses.MISSING for f in fields)
        and list(inspect.signature(cls).parameters) == names
        and not any(n in own for n in ("__new__", *DECIDING))
        and not any(_stands_before(own.get(n)) for n in names)
    )
    if plain:
        return ""
    return (
        f"{name} is a dataclass that derives, or does more than hold what it is given; write a NamedTuple, "
        "or a dataclass of members and methods alone."
    )


def _stands_before(found: Any) -> bool:
    """Whether what a class has under a member's name is read in its place; __slots__ are its place."""
    return hasattr(found, "__get__") and not isinstance(found, types.MemberDescriptorType)


def maker(cls: Any) -> Any:
    """What is called with the members, after the class or the object itself."""
    return cls.__new__ if issubclass(cls, tuple) else cls.__init__


def of_method(function: types.FunctionType, cls: type) -> bool:
    """Whether a function is a method or a property of such a class."""
    return any(
        found is function or (isinstance(found, property) and found.fget is function)
        for found in vars(cls).values()
    )
