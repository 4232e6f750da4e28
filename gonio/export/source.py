"""A Python file as text: its functions, its comments, and its named numbers with their comments."""

from __future__ import annotations

import ast
import functools
import io
import linecache
import os
import re
import tokenize
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

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
            self.text = "".join(linecache.getlines(path))  # the cells of notebooks
            if not self.text:
                raise ExportError(
                    f"{path}: the source cannot be read ({error}); models are exported from their files."
                ) from error
        try:
            with warnings.catch_warnings(action="ignore"):  # Python has given them at the import
                self.tree = ast.parse(self.text)
                self._codes = dict(_codes(compile(self.text, path, "exec", dont_inherit=True)))
        except SyntaxError as error:
            raise ExportError(f"{path}:{error.lineno}: {error.msg}.") from error
        except (RecursionError, MemoryError) as error:
            raise ExportError(f"{path}: an expression is too deep for Python; split it.") from error
        # Not splitlines, which takes a form feed for the end of a line where Python does not
        self.lines = self.text.split("\n")
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
        self._places: dict[str, tuple[int, int]] = {}
        for node in self.tree.body:
            if isinstance(node, ast.Assign):
                for name in ast.walk(node):
                    if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store):
                        self._constants[name.id] = node
                        self._places[name.id] = (name.lineno, name.col_offset)
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                self._constants[node.target.id] = node
                self._places[node.target.id] = (node.lineno, node.col_offset)

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
            raise self.complaint(
                self._at(first),
                f"no plain function {function.__name__!r} stands here; write it with 'def', without a "
                "decorator that replaces it, and start again if the file has changed.",
            )
        known = self._codes.get((first, function.__name__))
        if known is None or _meaning(known) != _meaning(function.__code__):
            raise self.complaint(
                node,
                f"{function.__name__} is not what Python runs: the file has changed, or something has "
                "replaced the function; start again.",
            )
        return node

    def complaint(self, node: ast.AST, message: str) -> ExportError:
        """An error that shows its place in the file."""
        line, start = getattr(node, "lineno", 1), getattr(node, "col_offset", 0)
        text = self.lines[line - 1]
        # ast counts bytes
        column = len(text.encode()[:start].decode(errors="ignore"))
        end = getattr(node, "end_col_offset", start + 1)
        same = getattr(node, "end_lineno", line) == line
        width = len(text.encode()[start:end].decode(errors="ignore")) if same else 1
        # Both lines without what moves the eye: tabs and form feeds
        before = re.sub(r"\S", " ", text[:column])
        marked = f"{text.rstrip()}\n{before}{'^' * max(width, 1)}"
        error = ExportError(f"{self.path}:{line}:{column + 1}: {message}\n{marked}")
        error.place, error.reason = (str(self.path), line), message
        return error

    def _at(self, line: int) -> ast.AST:
        """What begins in a line, or the whole line where nothing does."""
        for node in ast.walk(self.tree):
            if isinstance(node, (ast.Lambda, ast.FunctionDef)) and node.lineno == line:
                return node
        text = self.lines[line - 1] if line <= len(self.lines) else ""
        start, end = len(text) - len(text.lstrip()), len(text.rstrip())
        line = min(line, len(self.lines))
        return ast.Pass(lineno=line, col_offset=start, end_lineno=line, end_col_offset=end)

    def constant_place(self, name: str) -> tuple[int, int]:
        """Line and column of a named number of this file."""
        return self._places.get(name, (0, 0))

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


def _codes(code: CodeType) -> Iterator[tuple[tuple[int, str], CodeType]]:
    """The code of every function of a file, by line and name."""
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield (part.co_firstlineno, part.co_name), part
            yield from _codes(part)


def _meaning(code: CodeType) -> tuple[Any, ...]:
    """What makes two codes do the same."""
    constants = [_meaning(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    return (code.co_code, constants, names, code.co_argcount, code.co_kwonlyargcount)


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
