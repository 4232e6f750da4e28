"""What all tests share. gonio comes first: it points Dr.Jit at a usable LLVM."""

import pytest

import gonio  # noqa: F401


def pytest_addoption(parser: pytest.Parser) -> None:
    """`pytest --long`: tests that search at random search for minutes, in every language."""
    parser.addoption("--long", action="store_true", help="search for minutes where it can be done")
