"""Limits on a derivation, and what they leave."""

from __future__ import annotations

from typing import Any

import pytest

from rankdrop.algebra.work import tick
from rankdrop.exact.tree import RankTree
from rankdrop.robot.open import open_robot
from rankdrop.verbs import deriving
from rankdrop.verbs.conditions import conditions


def test_a_tree_that_takes_more_than_its_share_leaves_work_for_its_sets(monkeypatch: pytest.MonkeyPatch) -> None:
    """All sets of an arm became cases, which took no more than a tenth of a second: no work was left."""
    plain = deriving.rank_tree

    def long(*args: Any, **named: Any) -> RankTree:
        found = plain(*args, **named)
        tick(60e6)
        return found

    asked = {"points": 0, "special": False, "method": "tree", "seconds": 30.0, "coranks": 1}
    usual = conditions(open_robot("stanford"), **asked)
    monkeypatch.setattr(deriving, "rank_tree", long)
    found = conditions(open_robot("stanford"), **asked)
    assert [one.id for one in found.families] == [one.id for one in usual.families]
    assert not found.undivided
