"""The reference of the modules that users import, and of the commands; their docstrings are the text."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import click

import gonio
from gonio.cli import main
from gonio.model import Model
from site_pages import docstrings
from site_pages.markdown import fence, page, plain, table
from site_pages.sources import Sources

FOLDER = "api"

# Models have pages of their own, commands as well; a page for a program, and not for people who import it.
ELSEWHERE = {"gonio.models", "gonio.cli", "gonio.bench", "gonio.version", "gonio.messages"}


def write(sources: Sources) -> None:
    """A page for each module, and one for the commands."""
    rows, names = [], []
    documented: set[int] = set()
    for module in modules():
        members = public(module)
        if not members:
            continue
        title = (inspect.getdoc(module) or "").partition("\n")[0]
        sources.write(f"{FOLDER}/{module.__name__}.rst", _page(module, members, documented))
        rows.append((f"[{module.__name__}]({module.__name__}.rst)", plain(title)))
        names.append(module.__name__)
    hidden = "\n".join(["```{toctree}", ":hidden:", "", *names, "```"])
    head = (
        "Directions are unit vectors of shape (..., 3) in the local frame with the normal +z, values are "
        "BRDFs in 1/sr without the cosine: [Conventions](../docs/conventions.md). Errors are one line "
        "and say what is allowed."
    )
    sources.write(f"{FOLDER}/index.md", page("# API", head, table(("module", ""), rows), hidden))
    sources.write("commands.md", _commands())


def modules() -> Iterator[ModuleType]:
    """The package, its modules and folders, and what lies in folders that export nothing themselves."""
    yield gonio
    for info in pkgutil.iter_modules(gonio.__path__, "gonio."):
        if info.name in ELSEWHERE or info.name.rpartition(".")[2].startswith("_"):
            continue
        module = importlib.import_module(info.name)
        yield module
        if info.ispkg and not public(module):
            for inner in pkgutil.iter_modules(module.__path__, f"{info.name}."):
                yield importlib.import_module(inner.name)


def public(module: ModuleType) -> list[str]:
    """Names that a module offers: those of `__all__`, else its own functions and classes."""
    if hasattr(module, "__all__"):
        names = [n for n in module.__all__ if n.rpartition(".")[2] != "__version__"]
        return [n for n in names if _is_documented(getattr(module, n))]
    return [
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and _is_documented(value)
        and getattr(value, "__module__", "") == module.__name__
    ]


def _is_documented(value: Any) -> bool:
    if not (inspect.isfunction(value) or inspect.isclass(value)):
        return False
    return bool(inspect.getdoc(value))


def _page(module: ModuleType, names: list[str], documented: set[int]) -> str:
    name = module.__name__
    # Written out, since some modules have the name of a function, and Sphinx allows a name once
    told = docstrings.convert((inspect.getdoc(module) or "").splitlines())
    lines = [name, "=" * len(name), "", *told, ""]
    for member in names:
        value = getattr(module, member)
        lines.append(f".. auto{_kind(value)}:: {name}.{member}")
        if inspect.isclass(value) and not (issubclass(value, Model) and value is not Model):
            lines += ["   :members:", "   :undoc-members:"] if value is Model else ["   :members:"]
        if id(value) in documented:
            lines.append("   :no-index:")
        documented.add(id(value))
        lines.append("")
    return "\n".join(lines)


def _kind(value: Any) -> str:
    if inspect.isclass(value):
        return "exception" if issubclass(value, BaseException) else "class"
    return "function"


# --- commands ------------------------------------------------------------------------------------------


def _commands() -> str:
    blocks = [
        "# Commands",
        "`gonio COMMAND --help` says the same. A MODEL is a model's name, a ready material or a file, with "
        "parameters: [Materials](docs/materials.md).",
    ]
    for path, command in _all_commands(main, ("gonio",)):
        context = click.Context(command, info_name=path[-1], parent=_parents(path))
        # Narrow enough for a page, wide enough for the examples
        context.max_content_width = context.terminal_width = 100
        blocks += [f"{'#' * len(path)} {' '.join(path)}", fence(command.get_help(context), "text")]
    return page(*blocks)


def _all_commands(
    command: click.Command, path: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    if len(path) > 1:
        yield path, command
    if isinstance(command, click.Group):
        context = click.Context(command, info_name=path[-1])
        for name in command.list_commands(context):
            found = command.get_command(context, name)
            if found is not None and not found.hidden:
                yield from _all_commands(found, (*path, name))


def _parents(path: tuple[str, ...]) -> click.Context | None:
    context = None
    for name in path[:-1]:
        context = click.Context(click.Group(name), info_name=name, parent=context)
    return context
