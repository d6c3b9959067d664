"""Notes on robot descriptions: facts with words, and texts of the description itself."""

from __future__ import annotations

import re

import pytest

from rankdrop.robot.dh import from_dh
from rankdrop.robot.note import Moved, NoteOn, RobotNote


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


def test_of_many_links_at_the_tip_eight_are_named() -> None:
    links = tuple("abcdefghi")
    assert "; fixed to it: a, b, c, d, e, f, g, h …" in str(RobotNote(NoteOn.TIP, "t", fixed=links))
    assert str(RobotNote(NoteOn.TIP, "t", fixed=links[:8])).endswith("; fixed to it: a, b, c, d, e, f, g, h")


@pytest.mark.parametrize("kind", NoteOn)
def test_a_kind_of_note_is_a_slug_and_its_words_are_made_elsewhere(kind: NoteOn) -> None:
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", kind)
    words = str(RobotNote(kind, "joint_a", "joint_b", text="as given"))
    assert kind.value not in words
