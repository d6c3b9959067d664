"""The examples in the docstrings of the installed package are true."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import rankdrop

FOUND = (module.name for module in pkgutil.walk_packages(rankdrop.__path__, "rankdrop."))
MODULES = ["rankdrop", *(name for name in FOUND if name != "rankdrop._core")]
LONG = {"rankdrop.families.slices", "rankdrop.distance.tolerant", "rankdrop.path.mend.mend",
        "rankdrop.aspects.posture_paths", "rankdrop.verbs.ideal_vs_actual"}  # fmt: skip
"""Examples of half a second and more."""


def test_the_long_ones_are_there() -> None:
    assert set(MODULES) >= LONG


@pytest.mark.slow
@pytest.mark.parametrize("modules", [
    pytest.param([name for name in MODULES if name not in LONG], id="quick"),
    pytest.param(sorted(LONG), id="long"),
])  # fmt: skip
def test_what_the_examples_show_is_what_comes(modules: list[str]) -> None:
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE, verbose=False)
    finder, examples = doctest.DocTestFinder(), 0
    told: list[str] = []
    for name in modules:
        for test in finder.find(importlib.import_module(name)):
            examples += bool(test.examples)
            runner.run(test, out=told.append)
    assert examples >= len(LONG)
    assert not told, "".join(told)
