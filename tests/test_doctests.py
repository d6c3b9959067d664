"""The examples in the docstrings of the installed package are true."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import rankdrop

FOUND = (module.name for module in pkgutil.walk_packages(rankdrop.__path__, "rankdrop."))
MODULES = ["rankdrop", *(name for name in FOUND if name != "rankdrop._core")]


def test_what_the_examples_show_is_what_comes() -> None:
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE, verbose=False)
    finder, examples = doctest.DocTestFinder(), 0
    told: list[str] = []
    for name in MODULES:
        for test in finder.find(importlib.import_module(name)):
            examples += bool(test.examples)
            runner.run(test, out=told.append)
    assert examples > 10
    assert not told, "".join(told)
