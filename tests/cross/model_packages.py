"""Public packages of robot models, where they are installed."""

from __future__ import annotations

import warnings
from functools import cache
from types import ModuleType

import pytest

PACKAGES = {"pinocchio": "cross", "mujoco": "mujoco", "roboticstoolbox": "cross", "yourdfpy": "cross"}


@cache
def package(name: str) -> ModuleType:
    """The package; the test is skipped where it is missing."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # theirs, while they are imported
        module = pytest.importorskip(name, reason=f'the extra "{PACKAGES[name]}" is not installed')
    assert isinstance(module, ModuleType)
    return module
