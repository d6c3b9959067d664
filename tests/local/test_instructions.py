"""Instructions for the procedure."""

from __future__ import annotations

import numpy as np
import pytest
from local.gupta import GR
from reference import arms

from rankdrop.errors import RankdropError
from rankdrop.local.instructions import session
from rankdrop.local.ordered import OrderedScrewSet
from rankdrop.robot.open import open_robot


def test_what_is_read_again_is_restored_and_nothing_else() -> None:
    steps = session(GR, [("newscrews", 3, 5), ("readoss", 5, 5), ("newscrews", 2, 5)])
    assert steps[1][1] == ("[1, 0, 0, 0, 0, 0]",)
    assert steps[2][1][1] == "S(4) = [0, 1, 0, 5, 0, 5]", "screw 4 is still where newscrews put it"
    assert steps[2][1][2] == "S(5) = [1, 0, 0, 0, 0, -1]"


@pytest.mark.parametrize("call", [
    lambda: GR.dimension(3, 2), lambda: GR.msos(0, 2), lambda: GR.newscrews(4, 8), lambda: GR.moved(8, 0.1),
    lambda: session(GR, [("jump", 1, 2)]), lambda: OrderedScrewSet(np.zeros((0, 6))),
    lambda: OrderedScrewSet.of(arms.random_chain(np.random.default_rng(0), "rrm"), [0, 0]),
    lambda: OrderedScrewSet.of(open_robot("pa10"), np.zeros(7), length=0.0),
])  # fmt: skip
def test_what_does_not_exist_is_refused(call: object) -> None:
    with pytest.raises(RankdropError):
        call()  # type: ignore[operator]
