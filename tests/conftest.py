"""Shared by all tests: hypothesis is deterministic, and `rng` gives every test the same numbers each run."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import settings

settings.register_profile("same-every-run", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("same-every-run")


@pytest.fixture
def rng() -> np.random.Generator:
    """A random generator with a fixed seed, fresh for every test."""
    return np.random.default_rng(20240229)
