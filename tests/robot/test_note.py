"""Notes on robot descriptions: facts with words, and texts of the description itself."""

from __future__ import annotations

import re

import pytest

from rankdrop.options import on_command_line
from rankdrop.robot.dh import from_dh
from rankdrop.robot.note import Moved, NoteOn, RobotNote
from rankdrop.text.robots import notes_words


def test_a_text_given_as_a_note_stays_as_it_is() -> None:
    arm = from_dh([{"a": 1.0}], convention="standard", notes=["{base} of steel"])
    assert arm.notes == (RobotNote(NoteOn.GIVEN, text="{base} of steel"),)
    assert str(arm.notes[0]) == "{base} of steel"


@pytest.mark.parametrize("kind", list(NoteOn))
def test_every_kind_has_words(kind: NoteOn) -> None:
    changed = Moved(1, 0.5)
    words = str(RobotNote(kind, "a", "b", number=3, rounded=changed, turned=changed, moved=changed, text="c"))
    assert words
    assert "{" not in words


def test_an_endless_limit_is_no_number_of_turns() -> None:
    words = str(RobotNote(NoteOn.TURNS, "a", limits=(float("-inf"), 180.0)))
    assert words.endswith('write "180 deg" for degrees')


def test_an_option_is_written_as_the_reader_writes_it() -> None:
    note = RobotNote(NoteOn.SQUARED, moved=Moved(2, 1e-6))
    assert str(note) == "2 lengths squared, at most 1 µm; as_written=True keeps the file's numbers"
    with on_command_line():
        assert str(note).endswith("; --as-written keeps the file's numbers")


def test_of_many_links_at_the_tip_eight_are_named() -> None:
    links = tuple("abcdefghi")
    assert "; fixed to it: a, b, c, d, e, f, g, h …" in str(RobotNote(NoteOn.TIP, "t", fixed=links))
    assert str(RobotNote(NoteOn.TIP, "t", fixed=links[:8])).endswith("; fixed to it: a, b, c, d, e, f, g, h")


@pytest.mark.parametrize("kind", NoteOn)
def test_a_kind_of_note_is_a_slug_and_its_words_are_made_elsewhere(kind: NoteOn) -> None:
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", kind)
    words = str(RobotNote(kind, "joint_a", "joint_b", text="as given"))
    assert kind.value not in words


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
