"""Places that no known family explains."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rankdrop.cover.box_matching import FOUND, PROVEN
from rankdrop.local.block import singular_values
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs import cover

UR5 = open_robot("ur5")
TASK = resolve_task(None, UR5)


@pytest.mark.slow
def test_a_family_left_out_is_listed_as_places_that_are_singular() -> None:
    # every family that lies in the wrist's sheet goes: what is left of it is a place to look at
    known = known_analysis(UR5, TASK)
    gone = [one.id for one in known.families if any(pin.number == 5 for pin in one.pinned)]
    assert "k1.f3" in gone
    rest = replace(known, families=tuple(one for one in known.families if one.id not in gone))
    found = cover(UR5, width=0.4, analysis=rest)
    assert not found.holds
    assert "may hold a singular configuration" in found.sentence
    assert {one.kind for one in found.account.spots} <= {PROVEN, FOUND}
    for one in found.account.spots:
        assert one.sigma < 1e-9
        assert singular_values(UR5, one.q[None], TASK)[0, -1] < 1e-9
        assert (one.q[1:5] >= one.lower - 1.2).all()
    boxes = sum(one.boxes for one in found.account.spots)
    assert 0.1 < boxes / found.covering.tree.leaves < 0.5
