"""The examples in the docstrings of the installed package are true."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import rankdrop

FOUND = (module.name for module in pkgutil.walk_packages(rankdrop.__path__, "rankdrop."))
MODULES = ["rankdrop", *(name for name in FOUND if name != "rankdrop._core")]


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    module = importlib.import_module(name)
    failed, _ = doctest.testmod(module, optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    assert failed == 0


def test_there_are_examples() -> None:
    finder = doctest.DocTestFinder()
    examples = [test for name in MODULES for test in finder.find(importlib.import_module(name)) if test.examples]
    assert len(examples) > 10
