"""A witness holds where its equations vanish, and exactly the singular values that have to."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.results.settings import Residual
from rankdrop.tolerances import DEFAULT

GOOD = Residual(equation=DEFAULT.explained, sigma=DEFAULT.singular, kept=0.1)


def test_a_witness_on_its_thresholds_holds() -> None:
    assert GOOD.holds(DEFAULT)


def test_each_threshold_alone_refuses_a_witness() -> None:
    assert not replace(GOOD, equation=1.01 * DEFAULT.explained).holds(DEFAULT)
    assert not replace(GOOD, sigma=1.01 * DEFAULT.singular).holds(DEFAULT)
    assert not replace(GOOD, kept=DEFAULT.singular).holds(DEFAULT)  # of a higher corank
    assert replace(GOOD, sigma=1.01 * DEFAULT.singular).holds(replace(DEFAULT, singular=2 * DEFAULT.singular))
