"""Relative moves of KRL: added to the target before, or not read, with the reason."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.path.read.krl import read

HEAD = "DEF a()\n$BASE = $NULLFRAME\n"
FIRST = "LIN {X 500, Y 100, Z 600, A 90, B 0, C 0}\n"


def reasons(text: str) -> list[str]:
    return [item.reason.value for item in read(HEAD + text, "a.src").skipped]


def last_pose(text: str) -> np.ndarray:
    program = read(HEAD + text, "a.src")
    assert not program.skipped
    made = program.moves[-1].target.pose
    assert made is not None
    return made


def test_a_shift_is_added_in_the_axes_of_the_base() -> None:
    np.testing.assert_allclose(last_pose(FIRST + "LIN_REL {X 50, Z -100} C_DIS")[:3, 3], [0.55, 0.1, 0.5], atol=1e-15)
    np.testing.assert_allclose(last_pose(FIRST + "PTP_REL {Y 10} #BASE\nSLIN_REL {Y 10}")[:3, 3], [0.5, 0.12, 0.6])
    turned = "$BASE = {X 0, Y 0, Z 0, A 90, B 0, C 0}\n" + FIRST + "LIN_REL {X 50}"
    np.testing.assert_allclose(last_pose(turned)[:3, 3], [-0.1, 0.55, 0.6], atol=1e-15)  # X of that base is Y


def test_with_tool_the_axes_are_those_of_the_tool() -> None:
    """A = 90° turns X of the tool along Y; then a quarter turn about that X."""
    made = last_pose(FIRST + "LIN_REL {X 50, C 90} #TOOL")
    np.testing.assert_allclose(made[:3, 3], [0.5, 0.15, 0.6], atol=1e-15)
    z, x = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    np.testing.assert_allclose(made[:3, :3], z @ x, atol=1e-15)


def test_joint_values_are_added_to_joint_values() -> None:
    start = "PTP {A1 10, A2 -90, A3 90, A4 0, A5 20, A6 0}\n"
    program = read(HEAD + start + "PTP_REL {A1 5, A5 -30}\n", "a.src")
    assert program.moves[1].target.joints == (15, -90, 90, 0, -10, 0)
    assert (program.moves[1].kind, program.skipped) == ("joint", ())


@pytest.mark.parametrize(("text", "reason"), [
    ("LIN_REL {X 50}\n", ["relative"]),
    ("PTP {A1 10, A2 -90, A3 90, A4 0, A5 20, A6 0}\nLIN_REL {X 50}\n", ["after joint values"]),
    (FIRST + "PTP_REL {A1 10}\n", ["after a pose"]),
    (FIRST + "LIN_REL {X 50, A 10}\n", ["relative turn"]),
    (FIRST + "LIN_REL {X dist}\n", ["expression"]),
    (FIRST + "LIN XP7\nLIN_REL {X 50}\n", ["variable", "relative"]),
    (FIRST + "FOR i=1 TO 3\nLIN_REL {X 50}\nENDFOR\n", ["loop", "relative", "loop"]),
    (FIRST + "BAS(#BASE, 3)\nLIN_REL {X 50}\n", ["base frame"]),
    (FIRST + "CIRC_REL {X 50}, {X 100}\n", ["relative"]),
])  # fmt: skip
def test_relative_moves_that_are_not_read_say_why(text: str, reason: list[str]) -> None:
    assert reasons(text) == reason
