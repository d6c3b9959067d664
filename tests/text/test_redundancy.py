"""Bases of range and null space in words: every entry is that of the matrix, rounding is 0, and every ending has words.
"""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.local.redundant import redundancy
from rankdrop.local.self_motions import End, Ending
from rankdrop.robot.open import open_robot
from rankdrop.text.redundancy import end_sentence, redundancy_sections

Q = np.array([0.3, -0.6, 0.2, -1.9, 0.4, 1.6, 0.7])


def test_the_tables_are_the_matrices() -> None:
    found = redundancy(open_robot("panda"), Q)
    head, twists, rates, projector = redundancy_sections(found)
    assert head.summary == "rank 6, nullity 1, corank 0"
    for section, matrix in ((twists, found.range_basis), (rates, found.null_basis), (projector, found.projector)):
        shown = np.array([[float(cell) for cell in row] for row in section.rows])
        assert shown == pytest.approx(matrix, rel=1e-3, abs=1e-11)
    assert rates.columns == tuple(f"joint {k}" for k in range(1, 8))
    assert twists.columns == ("vx", "vy", "vz", "wx", "wy", "wz")


def test_rounding_is_no_entry() -> None:
    """Joint 1 of a planar arm turns the tool about z alone."""
    found = redundancy(open_robot("planar2r"), np.array([0.3, 0.5]))
    cells = {cell for section in redundancy_sections(found) for row in section.rows for cell in row}
    assert "0" in cells
    assert not any("e-" in cell or cell == "-0" for cell in cells)


@pytest.mark.parametrize("reason", Ending)
def test_every_ending_is_one_sentence_with_its_facts(reason: Ending) -> None:
    words = end_sentence(End(reason, number=2, joint="elbow", travelled=1.2345, bend=0.5678))
    assert "{" not in words
    assert ("joint 2 (elbow)" in words) == (reason in {Ending.STARTS_BEYOND, Ending.AT_LIMIT})
    assert ("1.23 rad" in words) == (reason in {Ending.LONG_ENOUGH, Ending.CLOSED})
    assert ("0.568 per rad²" in words) == (reason is Ending.BENDS_AWAY)


def test_no_two_endings_have_the_same_words() -> None:
    assert len({end_sentence(End(reason)) for reason in Ending}) == len(Ending)
