"""Lost directions of an explanation in words: their numbers annihilate the Jacobian in the axes that they name."""

from __future__ import annotations

import re

import numpy as np
import pytest
from reference.kinematics import jacobian, pose

import rankdrop
from rankdrop.local.directions import FramedDirections
from rankdrop.robot.open import open_robot
from rankdrop.sections import Section
from rankdrop.task import BASE, TIP, Frame
from rankdrop.text.lost_directions import axes_text, focus_words, lost_sections, never_sections

STRETCHED = np.array([0.3, 0.0])
TERMS = re.compile(r"(−?) ?([\d.e-]*) ?(?:m·)?([vω][xyz])")
TWIST = ("vx", "vy", "vz", "ωx", "ωy", "ωz")


def numbers(constraint: str) -> np.ndarray:
    """(6,) the coefficients of "0.955 vx + 0.296 vy = 0"; a factor that is not written is 1."""
    found = np.zeros(6)
    for sign, size, name in TERMS.findall(constraint.removesuffix("= 0")):
        found[TWIST.index(name)] = (-1.0 if sign else 1.0) * float(size or 1.0)
    return found


def lost(name: str, q: np.ndarray, full: bool = False) -> Section:
    (section,) = lost_sections(rankdrop.explain(open_robot(name), q, evaluations=0), full)
    return section


@pytest.mark.parametrize(("name", "q"), [
    ("planar2r", STRETCHED), ("puma560", np.array([0.3, 0.5, 0.4, 0.2, 0.0, 0.6])),
    ("ur5", np.array([0.1, -1.0, 0.0, 0.3, 0.8, 0.2])),
])  # fmt: skip
def test_no_joint_moves_the_tool_along_what_is_lost(name: str, q: np.ndarray) -> None:
    """In base axes the Jacobian of the tip; in tool axes the same, turned by the rotation of the tip."""
    robot = open_robot(name)
    section = lost(name, q)
    assert section.title == "What is lost"
    lines = dict(line.strip().removeprefix("in ").split(": ") for line in map(str, section.lines[1:]))
    assert list(lines) == ["base axes", "tool axes"]
    at_tip, turn = jacobian(robot, q), pose(robot, q)[:3, :3]
    for axes, rotation in (("base axes", np.eye(3)), ("tool axes", turn)):
        direction = numbers(lines[axes])
        assert np.linalg.norm(direction) > 0.9
        seen = np.concatenate([rotation.T @ at_tip[:3], rotation.T @ at_tip[3:]])
        assert np.abs(direction @ seen).max() < 2e-3  # three digits are printed


def test_a_full_answer_adds_what_it_comes_to_and_the_wrench_that_is_carried() -> None:
    short, full = (list(map(str, lost("planar2r", STRETCHED, full).lines)) for full in (False, True))
    assert [line for line in full if line in short] == short
    assert "      no motion along X" in full
    assert any("carried without joint torque: a force along (1, 0, 0)" in line for line in full)
    assert not any("carried" in line or "no motion" in line for line in short)
    assert short[0] == "The tool can only move so that"
    assert "In the axes of the tool, reference point at the tool:" in full
    assert not any("nearly" in note for note in lost("planar2r", STRETCHED, full=True).notes)  # purely a translation


def test_near_a_singularity_the_loss_is_that_of_the_nearest_one() -> None:
    near = rankdrop.explain(open_robot("planar2r"), STRETCHED + np.array([0.0, 1e-4]), evaluations=0)
    at = rankdrop.explain(open_robot("planar2r"), STRETCHED, evaluations=0)
    (section,) = lost_sections(near, False)
    assert (section.title, section.summary) == ("What is nearly lost", "at the nearest singular configuration")
    assert (focus_words(near), focus_words(at)) == ("at the nearest singular configuration", "")


def test_twists_that_an_arm_never_makes_are_none_of_any_configuration(rng: np.random.Generator) -> None:
    """A SCARA asked for a pose: it does not tilt its tool."""
    robot = open_robot("scara")
    (section,) = never_sections(rankdrop.explain(robot, np.array([0.3, 0.5, 0.1, 0.2]), "pose", evaluations=0), False)
    never = np.array(section.rows, dtype=float)
    assert never.shape == (2, 6)
    for q in rng.uniform(-1, 1, (20, robot.n)):
        assert np.abs(never @ jacobian(robot, q)).max() < 1e-3
    assert not list(never_sections(rankdrop.explain(open_robot("planar2r"), STRETCHED, evaluations=0), False))


@pytest.mark.parametrize(("frame", "words"), [
    (Frame(BASE, TIP), "base axes"), (Frame(TIP, TIP), "tool axes"),
    (Frame(5, 5), "axes of link 5 (after wrist_2_joint) at its origin"),
    (Frame(TIP, 5), "axes of the tool at the origin of link 5 (after wrist_2_joint)"),
])  # fmt: skip
def test_axes_have_the_name_of_their_link(frame: Frame, words: str) -> None:
    assert axes_text(open_robot("ur5"), FramedDirections(np.zeros((1, 6)), frame)) == words
