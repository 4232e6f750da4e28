"""Mitsuba's variant in tests of plug-ins."""

from __future__ import annotations

import mitsuba as mi
import pytest

import gonio.mitsuba  # noqa: F401  # before any variant is set


@pytest.fixture(autouse=True)
def variant(request: pytest.FixtureRequest) -> str:
    """The variant a test runs in; llvm_ad_rgb where it does not say."""
    mi.set_variant(getattr(request, "param", "llvm_ad_rgb"))
    return str(mi.variant())
