"""How the end of a covering is worded."""

from __future__ import annotations

import pytest
from reference.coverings import covering

from rankdrop.cover.covering import (
    CoveringEnd,
)
from rankdrop.errors import OptionError
from rankdrop.robot.open import open_robot
from rankdrop.verbs import cover


@pytest.mark.slow
def test_a_budget_ends_the_work_and_says_so():
    found = covering(open_robot("almarkhi4"), 0.1, budget=15_000)
    assert (found.complete, found.stopped) == (False, CoveringEnd.BUDGET_SPENT)
    assert found.tree.finished.any()
    found = covering(open_robot("almarkhi4"), 0.1, budget=2000)
    assert (found.complete, found.stopped) == (False, CoveringEnd.BUDGET_TOO_SMALL)
    assert found.needed > 15_000
    labels: set[str] = set()
    cover(open_robot("almarkhi4"), width=0.1, budget=15_000, report=lambda label, *_: labels.add(label))
    assert labels == {f"parts covered (about {found.needed:,} enclosures in all)"}
    assert not found.tree.finished.any()
    with pytest.raises(OptionError, match="budget"):
        covering(open_robot("almarkhi4"), 0.3, budget=0)
