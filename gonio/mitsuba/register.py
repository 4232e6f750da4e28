"""Which plug-ins Mitsuba's variants know: all models, ground truth for layers, the viewer's distance."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

from gonio import backend
from gonio.mitsuba import layered, viewer_distance
from gonio.mitsuba.bsdf import derive
from gonio.mitsuba.properties import PLUGIN, PREFIX
from gonio.model import Model, models

_registered: dict[tuple[str, str], type[Model]] = {}
_tools: set[str] = set()


def register(*private: type[Model]) -> None:
    """Register every model for Mitsuba's current variant; what is known to it is left alone.

    Runs by itself on import and on every `mi.set_variant`. Call it after defining a model of your own.

    Args:
        private: models that are not in gonio's registry: of a file that `gonio.load` has read, such as
            `gonio.load("my_model.py").written`, or defined with `register=False`.

    Raises:
        BackendError: Dr.Jit has loaded an LLVM that would end the process; the message says what helps.
    """
    variant = mi.variant()
    if variant is None:
        return
    if variant.startswith("llvm") and (problem := llvm_problem()):
        raise backend.BackendError(problem)
    for cls in (*models().values(), *(one.written for one in private)):
        if _registered.get((variant, cls.name)) is not cls:
            mi.register_bsdf(PREFIX + cls.name, derive(cls))
            _registered[variant, cls.name] = cls
    if variant not in _tools:
        mi.register_bsdf(PLUGIN, layered.derive())
        mi.register_texture(viewer_distance.NAME, viewer_distance.derive())
        _tools.add(variant)


def is_registered(cls: type[Model]) -> bool:
    """Whether Mitsuba's current variant knows a model, and not another one of its name."""
    return _registered.get((mi.variant(), cls.name)) is cls


def llvm_problem() -> str | None:
    """What is wrong with the LLVM that Dr.Jit has loaded; it chooses alone if imported before gonio."""
    version = dr.detail.llvm_version()[0]
    if version >= backend.LLVM_MINIMUM:
        return None
    path = next(backend.usable_llvm(), None)
    remedy = (
        "import gonio.mitsuba before mitsuba and drjit, or set "
        f"DRJIT_LIBLLVM_PATH={path} before starting Python."
    )
    return (
        f"Dr.Jit has loaded {f'LLVM {version}' if version > 0 else 'no LLVM'}, and Mitsuba's llvm "
        f"variants need {backend.LLVM_MINIMUM} or newer: {remedy if path else backend.install_hint()}"
    )
