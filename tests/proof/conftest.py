"""Shared by the tests of the checker: its precision."""

from __future__ import annotations

from collections.abc import Iterator

import flint
import pytest

from rankdrop.proof.arm import BITS


@pytest.fixture
def precise() -> Iterator[None]:
    """The precision in which the checker computes."""
    with flint.ctx.workprec(BITS):
        yield
