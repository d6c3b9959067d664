"""Sets without a point modulo the prime: √2 is real, and need not be a number there."""

from __future__ import annotations

import pytest

from rankdrop.conditions import conditions
from rankdrop.exact.algebra.field import P, roots
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.split import with_points
from rankdrop.exact.algebra.variety import Variety
from rankdrop.exact.algebra.work import Work
from rankdrop.robot.open import open_robot


def test_what_numbers_hide_is_told_without_the_help_of_a_cloud() -> None:
    found = conditions(open_robot("panda"), lengths="numbers", method="tree", points=0, coranks=2)
    assert not found.complete
    assert any("no point modulo" in one for one in found.left)


def test_sets_that_families_hold_are_no_loss() -> None:
    found = conditions(open_robot("puma560"), lengths="numbers", method="tree", points=0)
    assert found.verified
    assert len(found.families) == 6


@pytest.mark.parametrize("number", [number for number in range(2, 30) if not roots([-number, 0, 1])][:3])
def test_a_root_that_is_real_alone_is_noted_and_one_that_is_not_real_is_not(number: int) -> None:
    assert pow(number, (P - 1) // 2, P) == P - 1
    ring = Ring([1, 2])
    t = ring.t[1]
    work = Work()
    real, unreal = (Variety(ring, {}, rest=(f,), equations=(f,)) for f in (t**2 - number, t**2 + t + number))
    assert with_points([real], work) == []
    assert list(work.pointless) == [real.key]
    work.pointless.clear()
    assert with_points([unreal], work) in ([], [unreal])
    assert not work.pointless
