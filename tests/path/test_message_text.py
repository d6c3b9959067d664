"""A pose as ROS prints it."""

from __future__ import annotations

import json

import pytest

from rankdrop.errors import OptionError
from rankdrop.path.read.message_text import message_of_text
from rankdrop.path.read.pose_text import pose_of_text

PLACE, TURN = {"x": 0.4, "y": -0.1, "z": 3e-1}, {"x": 0.6, "y": 0.0, "z": 0.0, "w": 0.8}
WANTED = [0.4, -0.1, 0.3, 0.6, 0.0, 0.0, 0.8]
ECHO = """header:
  stamp:
    sec: 17
    nanosec: 250
  frame_id: base_link
pose:
  position:
    x: 0.4
    y: -0.1
    z: 0.3
  orientation:
    x: 0.6
    y: 0.0
    z: 0.0
    w: 0.8
---"""
TF2 = """At time 12.5
- Translation: [0.400, -0.100, 0.300]
- Rotation: in Quaternion (xyzw) [0.600, 0.000, 0.000, 0.800]
- Rotation: in RPY (radian) [1.287, -0.000, 0.000]
- Rotation: in RPY (degree) [73.740, -0.000, 0.000]"""


@pytest.mark.parametrize("text", [
    ECHO, TF2,
    json.dumps({"position": PLACE, "orientation": TURN}), json.dumps({"translation": PLACE, "rotation": TURN}),
    "position: {x: 0.4, y: -0.1, z: 0.3}, orientation: {w: 0.8, z: 0, y: 0, x: 0.6}",
    "Pose(position=Point(x=0.4, y=-0.1, z=0.3), orientation=Quaternion(x=0.6, y=0.0, z=0.0, w=0.8))",
])  # fmt: skip
def test_every_form_is_the_same_pose(text: str) -> None:
    assert message_of_text(text, "--pose") == pytest.approx(WANTED)
    made = pose_of_text(text, "--pose")
    assert made is not None
    assert made.numbers == pytest.approx(WANTED)


def test_a_position_alone_has_three_numbers() -> None:
    assert message_of_text("position: [0.4, -0.1, 0.3]", "--pose") == pytest.approx(WANTED[:3])


@pytest.mark.parametrize("text", [
    "position: {x: 0.4, y: 1}, orientation: {x: 1, y: 0, z: 0, w: 0}",
    "position: {x: 0.4, y: 1, z: 0}, orientation: [1]",
    "position: here", "position: {x: 1.2.3, y: 0, z: 0}",
])  # fmt: skip
def test_a_missing_number_is_named(text: str) -> None:
    with pytest.raises(OptionError, match="is missing"):
        message_of_text(text, "--pose")


@pytest.mark.parametrize("text", ["0.4,0,0.3,0,0,0", "{X 400, Y 0, Z 300, A 0, B 90, C 0}", ""])
def test_other_texts_are_none(text: str) -> None:
    assert message_of_text(text, "--pose") is None
