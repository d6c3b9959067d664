"""The computer algebra behind exact conditions: python-flint, asked for only where it is used."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from rankdrop.errors import MissingExtraError

Polynomial = Any
"""A `flint.fmpq_mpoly`; which ring it lives in is said where the name is used."""


def flint() -> ModuleType:
    """The module `flint`.

    Raises:
        MissingExtraError: python-flint is not installed.
    """
    try:
        import flint as module
    except ImportError as error:
        raise MissingExtraError("python-flint", None, "deriving exact conditions") from error
    return module
