"""Lost directions in words, and twists as screws."""

from __future__ import annotations

import re

import numpy as np
import pytest

from rankdrop.errors import OptionError
from rankdrop.families.lost import LostFreedom
from rankdrop.kinematics import link_poses
from rankdrop.local.directions import blocked_words, rewrite_wrench, words
from rankdrop.local.posture import drawn_at
from rankdrop.local.screws import screw_of
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame
from rankdrop.text.lost import lost_note


@pytest.mark.parametrize(
    ("direction", "frame", "expected"),
    [
        ([0, 0, 0, 1, 0, 0], "the base", "cannot rotate about X of the base"),
        ([0, -1, 0, 0, 0, 0], "the tool", "cannot translate along Y of the tool"),
        ([0, 0, 0, -3.67e-6, 1, 0], "the base", "cannot rotate about Y of the base"),
        ([0.7071, 0, 0.7071, 0, 0, 0], "the base", "cannot translate along (0.707, 0, 0.707) of the base"),
        ([0, 0, 0, 0, 0.6, -0.8], "link 4", "cannot rotate about (0, −0.6, 0.8) of link 4"),
        ([0, -0.91, 0, 0, 0, -0.41], "link 1", "can only move so that vy + 0.451 m·ωz = 0 in axes of link 1"),
        ([0, 0, 0.91, 0, -0.41, 0], "link 1", "can only move so that vz − 0.451 m·ωy = 0 in axes of link 1"),
        ([0, 0.3, 0, 0.6, 0, 0], "link 1", "can only move so that ωx + 0.5 rad/m·vy = 0 in axes of link 1"),
    ],
)
def test_known_directions_in_words(direction: list[float], frame: str, expected: str) -> None:
    assert words(direction, frame) == expected
    assert words(-3.0 * np.array(direction), frame) == expected, "neither sign nor length of a direction matters"


def test_a_blocked_force_is_told_by_the_point_that_cannot_move() -> None:
    said = blocked_words([0, 0.91, 0, 0, 0, 0.41])
    assert said == "the point (0.451, 0, 0) m from the reference point cannot move along Y of the base"
    assert blocked_words([1, 0, 0, 0, 0, 0]) == "the reference point cannot move along X of the base"
    assert blocked_words([0, 0, 0, 0, 2, 0]) == "cannot rotate about Y of the base"
    said = blocked_words([0, 0, 1, 0, 0, 0.2], "link 2")
    assert said == "the reference point moves along Z of link 2 only by −0.2 m for every rad of rotation about it"


def test_a_change_of_frame_leaves_the_power_of_a_wrench_alone(rng: np.random.Generator) -> None:
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    offset, wrench, motion = rng.normal(size=3), rng.normal(size=6), rng.normal(size=6)
    moved = np.concatenate([turn.T @ (motion[:3] + np.cross(motion[3:], offset)), turn.T @ motion[3:]])
    assert rewrite_wrench(wrench, turn, offset) @ moved == pytest.approx(wrench @ motion)


@pytest.mark.parametrize("bad", [np.zeros(6), np.ones(5), np.full(6, np.inf)])
def test_what_is_not_a_direction_is_refused(bad: np.ndarray) -> None:
    for ask in (words, blocked_words, screw_of):
        with pytest.raises(OptionError):
            ask(bad)


@pytest.mark.parametrize("name", ["pa10", "ur5e", "panda", "gen3", "puma560", "stanford"])
def test_links_lie_where_it_is_told_at_every_configuration(name: str) -> None:
    arm = open_robot(name)
    links = range(1, arm.n + 1)
    freedoms = [LostFreedom(tuple(way), Frame(i, i), everywhere=True) for i in links for way in np.eye(6)[:3]]
    told = lost_note(arm, freedoms)
    assert told.count("Link ") == arm.n
    for number, said in re.findall(r"Link (\d+)[^.]*?: ([^.]*)\.", told):
        for q in np.random.default_rng(5).uniform(-2, 2, (4, arm.n)):
            frame, drawn = link_poses(arm, q)[int(number)], drawn_at(arm, q)
            for letter, axis in re.findall(r"([XYZ]) along axis (\d+)", said):
                way = frame[:3, "XYZ".index(letter)]
                assert np.abs(np.cross(way, drawn.axes[int(axis) - 1])).max() < 1e-9
            through = {int(axis) for axis in re.findall(r"\d+", said.partition("origin")[2])}
            off = np.abs(np.cross(frame[:3, 3] - drawn.middles, drawn.axes)).max(axis=1)
            near = {i + 1 for i in range(arm.n) if off[i] < 1e-9 and not drawn.slides[i]}
            assert through == near or (through < near and any(drawn.slides))  # axes beyond a slide may be left out
