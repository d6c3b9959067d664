"""One record of a family: what the derivation returns, an analysis lists, a file holds, and another process gets."""

from __future__ import annotations

import pickle
from typing import Any

import pytest

from rankdrop.errors import OptionError
from rankdrop.families.record import ExactConditions, exact_of
from rankdrop.results.analysis import Analysis
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions


def shown(exact: ExactConditions) -> tuple[Any, ...]:
    """What readers of exact conditions see."""
    return exact.pinned, exact.conditions, exact.latex, exact.not_negative


@pytest.mark.slow
@pytest.mark.parametrize("name", ["scara", "stanford"])
def test_a_family_of_an_analysis_is_the_derived_family(name: str) -> None:
    """Stanford has a slide at rest and a condition with letters; JSON and other processes have the words."""
    pytest.importorskip("flint")
    robot = open_robot(name)
    derived = conditions(robot, points=0, special=False, method="tree", fresh=True)
    found = analyze(robot, starts=50, fresh=True)
    read = Analysis.from_dict(found.to_dict())
    assert derived.families
    for one, listed, written in zip(derived.families, found.families, read.families, strict=True):
        exact, mine, words = exact_of(one), exact_of(listed), exact_of(written)
        assert shown(mine) == shown(exact)
        assert (mine.pins, mine.shifts, mine.numbers) == (exact.pins, exact.shifts, exact.numbers)
        assert mine.rank_check == exact.rank_check
        assert [str(x.polynomial) for x in mine.polynomials] == [str(x.polynomial) for x in exact.polynomials]
        assert (listed.id, listed.called) == (one.id, one.called)
        assert {*one.pinned} <= {*listed.pinned}  # which has slides at rest as well
        assert listed.texts == one.texts == written.texts == exact.conditions
        assert shown(words) == shown(exact)
        assert (words.pins, words.polynomials) == ((), ())
        assert shown(pickle.loads(pickle.dumps(mine))) == shown(exact)


def test_a_fitted_family_has_its_conditions_with_decimals() -> None:
    (family,) = analyze(open_robot("planar3r"), starts=100, exact="off").of_corank(1)
    assert family.texts == tuple(f"{equation} = 0" for equation in family.equations)
    assert len(family.latex) == len(family.equations) == 1
    with pytest.raises(OptionError, match="not derived exactly"):
        exact_of(family)
