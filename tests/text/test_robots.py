"""Notes on the arm that a file describes."""

from __future__ import annotations

from math import degrees, pi

import pytest

from rankdrop.options import on_command_line
from rankdrop.robot.dh import from_dh
from rankdrop.robot.ideal import Tolerance, ideal, near_ideal, what_holds
from rankdrop.robot.note import Moved, NoteOn, RobotNote
from rankdrop.robot.open import open_robot
from rankdrop.text.robots import near_line, near_text, notes_words


def test_a_long_arm_is_near_by_hundreds_of_millimetres() -> None:
    rows = [(20 * a, twist, 20 * d, 0) for a, twist, d, _ in ([0, pi / 2, 0.3, 0], [0.4, 0, 0, 0], [0, pi / 2, 0, 0],
            [0, -pi / 2, 0.4, 0], [0, pi / 2, 0.007, 0], [0, 0, 0.1, 0])]  # fmt: skip
    near = near_ideal(from_dh(rows, convention="standard"))
    assert near is not None
    assert near_text(near) == "this arm is within 140 mm of one with a spherical wrist"


def test_more_than_two_gains_are_counted() -> None:
    near = near_ideal(open_robot("gen3"))
    assert near is not None
    assert near_text(near) == "this arm is within 13 mm of one with a spherical wrist, a spherical shoulder and 1 more"
    assert near.tolerance == Tolerance(pytest.approx(13e-3))  # type: ignore[arg-type]
    assert degrees(near.angle) == 0.0


def test_the_line_on_an_ideal_arm_says_what_takes_it() -> None:
    """The function for whoever works in Python, as it is called; the option on the command line."""
    arm = open_robot("gen3")
    near = near_ideal(arm)
    assert near is not None
    call = near_line(near).removeprefix(f"{near_text(near)}: see rankdrop.robot.ideal.")
    assert call == "ideal(robot, length=0.013)"
    assert what_holds(ideal(arm, length=0.013)[0], arm) == near.gained
    with on_command_line():
        assert near_line(near) == f"{near_text(near)}: see --ideal 13mm"


def test_an_endless_limit_is_no_number_of_turns() -> None:
    words = str(RobotNote(NoteOn.TURNS, "a", limits=(float("-inf"), 180.0)))
    assert words.endswith('write "180 deg" for degrees')


def test_an_option_is_written_as_the_reader_writes_it() -> None:
    note = RobotNote(NoteOn.SQUARED, moved=Moved(2, 1e-6))
    assert str(note) == "2 lengths squared, at most 1 µm; as_written=True keeps the file's numbers"
    with on_command_line():
        assert str(note).endswith("; --as-written keeps the file's numbers")


def test_the_same_note_of_several_joints_is_one_line() -> None:
    """A leg of six joints without rates began with six lines that differ in the name."""
    kinds = [NoteOn.NO_RATE, NoteOn.NO_LIMITS]
    notes = [RobotNote(NoteOn.BASE, "hip"), *(RobotNote(kind, name) for name in "abc" for kind in kinds)]
    notes.append(RobotNote(NoteOn.NO_RATE, "d", value=-1.0))
    assert notes_words(notes) == (
        str(notes[0]),
        "joints 'a', 'b', 'c': velocity 0 is read as not known",
        "joints 'a', 'b', 'c' have no limits: they count as unlimited",
        "joint 'd': velocity -1 is read as not known",
    )
