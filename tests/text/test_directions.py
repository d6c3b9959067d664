"""How directions and their frames are worded."""

from __future__ import annotations

from rankdrop.task import BASE, BODY, SPACE, TIP, WORLD_ALIGNED, Frame
from rankdrop.text.directions import frame_name


def test_frames_have_names_that_end_a_sentence() -> None:
    assert frame_name(WORLD_ALIGNED) == "the base"
    assert frame_name(BODY) == "the tool"
    assert frame_name(SPACE) == "the base at its origin"
    assert frame_name(Frame(4, TIP)) == "link 4"
    assert frame_name(Frame(4, 4)) == "link 4 at its origin"
    assert frame_name(Frame(BASE, 3)) == "the base at the origin of link 3"
    assert frame_name(Frame(BASE, TIP, (0.0, 0.1, 0.0))) == "the base at (0, 0.1, 0) m of the tool"
