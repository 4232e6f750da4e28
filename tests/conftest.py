"""What all tests share. gonio comes first: it points Dr.Jit at a usable LLVM."""

import pytest
from hypothesis import HealthCheck, settings

import gonio  # noqa: F401

# How long an example takes says how busy the machine is, not whether the code is right
settings.register_profile("gonio", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("gonio")


def pytest_addoption(parser: pytest.Parser) -> None:
    """`pytest --long`: tests that search at random search for minutes, in every language."""
    parser.addoption("--long", action="store_true", help="search for minutes where it can be done")
