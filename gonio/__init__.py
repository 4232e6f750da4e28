"""gonio: shading models, each written once, for arrays, Mitsuba 3 and pictures.

    import gonio
    eon = gonio.EON(roughness=1)            # or gonio.load("eon:roughness=1"), gonio.load("clay.toml")
    f = eon.eval(wi, wo)                    # NumPy, PyTorch, JAX or Dr.Jit arrays, (..., 3)

`import gonio.mitsuba` registers every model as a Mitsuba 3 BSDF; `gonio --help` shows the command line.
"""

import importlib
import importlib.util
import pkgutil
from typing import Any

from gonio import backend

backend.prepare()  # before anything imports Dr.Jit

import gonio.models  # noqa: E402, F401  fills the registry
from gonio.backend import BackendError, use  # noqa: E402
from gonio.fields import ModelError  # noqa: E402
from gonio.lang import Sample  # noqa: E402

# `gonio.model` and `gonio.models` are functions for the user and modules for the import system. The
# functions win as attributes because they are bound after both modules have been imported.
from gonio.model import Model, child, model, models, option, param  # noqa: E402
from gonio.version import __version__  # noqa: E402

__all__ = [
    "BackendError",
    "Model",
    "ModelError",
    "Sample",
    "__version__",
    "child",
    "load",
    "model",
    "models",
    "option",
    "param",
    "render",
    "use",
]


def __getattr__(name: str) -> Any:
    """Model classes by name (`gonio.EON`), and modules (`gonio.check`), which load only when used."""
    if name == "load":
        from gonio.materials import load

        return load
    for cls in models().values():
        if cls.__name__ == name:
            return cls
    if not name.startswith("_") and importlib.util.find_spec(f"gonio.{name}") is not None:
        return importlib.import_module(f"gonio.{name}")
    raise AttributeError(f"module 'gonio' has no attribute {name!r}")


def __dir__() -> list[str]:
    modules = (info.name for info in pkgutil.iter_modules(__path__))
    classes = (cls.__name__ for cls in models().values())
    return sorted({*__all__, *modules, *classes})
