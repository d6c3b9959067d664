"""What is not finished, as facts."""

from __future__ import annotations

import pytest

from rankdrop.algebra.work import Work
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.unfinished import Unfinished
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions
from rankdrop.verbs.deriving import _cloud


@pytest.mark.slow
def test_what_time_left_out_of_the_numeric_check_is_told() -> None:
    found = conditions(open_robot("pa10"), points=0, special=False, coranks=2)
    late: list[Unfinished | Contradiction] = []
    check, over, _ = _cloud(found.chain, 6, 4, found.families, 20, Work(-0.1, 0), late)
    assert not late
    all_tested = check.tested
    check, over, _ = _cloud(found.chain, 6, 4, found.families, 20, Work(-10.0, 0), late)
    assert 0 < check.tested < all_tested
    assert not over
    assert list(map(str, late)) == ["numeric configurations of corank 2 and above: the processor's time ran out"]
