"""A Python file as text: its functions, its comments, and its named numbers with their comments."""

from __future__ import annotations

import ast
import functools
import io
import os
import tokenize
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType

from gonio.export.tree import ExportError

# Comments that speak to tools, not to readers.
PRAGMAS = ("# fmt:", "# noqa", "# type:", "# ruff:", "# mypy:", "# pyright:", "# pragma")


@dataclass(frozen=True)
class Comment:
    """A comment, and whether it has its line for itself."""

    text: str
    alone: bool


class Source:
    """A Python file, parsed."""

    def __init__(self, path: str) -> None:
        """Read a file.

        Raises:
            ExportError: it cannot be read, or is not Python.
        """
        self.path = path
        try:
            self.text = Path(path).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ExportError(
                f"{path}: the source cannot be read ({error}); models are exported from their files."
            ) from error
        try:
            self.tree = ast.parse(self.text)
        except SyntaxError as error:
            raise ExportError(f"{path}:{error.lineno}: {error.msg}.") from error
        self.lines = self.text.splitlines()
        self.comments: dict[int, Comment] = {}
        for token in tokenize.generate_tokens(io.StringIO(self.text).readline):
            if token.type == tokenize.COMMENT and not token.string.startswith(PRAGMAS):
                before = self.lines[token.start[0] - 1][: token.start[1]]
                text = token.string.removeprefix("#").removeprefix(" ").rstrip()
                self.comments[token.start[0]] = Comment(text, not before.strip())
        self._functions = {
            node.lineno: node
            for node in ast.walk(self.tree)
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
        }
        self._constants: dict[str, ast.stmt] = {}
        for node in self.tree.body:
            if isinstance(node, ast.Assign):
                for name in ast.walk(node):
                    if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store):
                        self._constants[name.id] = node

    def function(self, function: FunctionType) -> ast.FunctionDef:
        """The definition of a function of this file.

        Raises:
            ExportError: the file has changed since it was imported, or the function is not plain.
        """
        first = function.__code__.co_firstlineno
        node = self._functions.get(first)
        if node is None:  # decorated: the code begins with the decorator
            near = [n for line, n in self._functions.items() if line > first]
            node = min(near, key=lambda n: n.lineno, default=None)
        if not isinstance(node, ast.FunctionDef) or node.name != function.__name__:
            raise ExportError(
                f"{self.path}:{first}: no plain function {function.__name__!r} stands there; write it with "
                "'def', and start again if the file has changed."
            )
        return node

    def constant_comments(self, name: str) -> tuple[str, ...] | None:
        """The comment beside a named number of this file, or above it; None if it has no such name."""
        node = self._constants.get(name)
        if node is None:
            return None
        beside = self.comments.get(node.end_lineno or node.lineno)
        if beside is not None and not beside.alone:
            return (beside.text,)
        return self.above(node.lineno)

    def above(self, line: int) -> tuple[str, ...]:
        """The comment lines that end right above a line."""
        found: list[str] = []
        line -= 1
        while (comment := self.comments.get(line)) is not None and comment.alone:
            found.append(comment.text)
            line -= 1
        return tuple(reversed(found))

    def imported_from(self, name: str) -> str | None:
        """The module that a name comes from by 'from module import name'."""
        for node in self.tree.body:
            if isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    if (alias.asname or alias.name) == name and alias.name == name:
                        return node.module
        return None


def source(path: str) -> Source:
    """A file, parsed once; again when it has changed, as the files of people who try things do."""
    try:
        status = os.stat(path)
    except OSError:
        return Source(path)  # which says what is wrong
    return _parsed(path, status.st_mtime_ns, status.st_size)


@functools.lru_cache(maxsize=256)
def _parsed(path: str, changed: int, size: int) -> Source:
    return Source(path)
