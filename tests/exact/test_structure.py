"""Structure read off exact lengths and twists, against the catalogue and against lines in space."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.structure import structure_of
from rankdrop.local.axes import Scene
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot

KNOWN = {
    "anthropomorphic": ([(4, 5, 6)], [(2, 3)]),
    "puma560": ([(4, 5, 6)], [(2, 3)]),
    "stanford": ([(4, 5, 6)], []),
    "ur5": ([], [(2, 3, 4)]),
    "scara": ([], [(1, 2, 4)]),
    "planar3r": ([], [(1, 2, 3)]),
    "pa10": ([(1, 2, 3), (3, 4, 5), (5, 6, 7)], []),
    "canadarm2": ([], [(3, 4, 5)]),
    "panda": ([(1, 2, 3)], []),
    "almarkhi4": ([], []),
}


@pytest.mark.parametrize("name", KNOWN)
def test_catalogue_arms_have_their_known_structure(name):
    structure = structure_of(exact_chain(open_robot(name)))
    assert (list(structure.points), list(structure.parallel)) == KNOWN[name]


@pytest.mark.parametrize("name", ["puma560", "ur5", "pa10", "canadarm2", "panda", "gen3", "rcrrrr", "fetch8", "xarm6"])
@pytest.mark.parametrize("lengths", ["letters", "numbers"])
def test_structure_is_what_lines_in_space_show(name, lengths, rng):
    robot = open_robot(name)
    structure = structure_of(exact_chain(robot, lengths=lengths))
    scene = Scene(robot, rng.uniform(-np.pi, np.pi, (5, robot.n)))
    axes = scene.axes
    triples = [t for t in zip(axes, axes[1:], axes[2:], strict=False) if t[2] == t[0] + 2]
    assert [tuple(j - 1 for j in t) for t in structure.points] == [t for t in triples if scene.common_point(t)[1].all()]
    pairs = [pair for pair in pairwise(axes) if pair[1] == pair[0] + 1]
    assert [tuple(j - 1 for j in t) for t in structure.meeting] == [t for t in pairs if scene.meeting(*t).all()]
    together = {pair for group in structure.parallel for pair in pairwise(group)}
    assert all(scene.parallel[i - 1, j - 1].all() for i, j in together)
    assert {(i + 1, j + 1) for i, j in pairs if scene.parallel[i, j].all()} <= together


def test_wrist_shoulder_and_srs():
    pa10 = structure_of(exact_chain(open_robot("pa10")))
    assert pa10.srs
    assert pa10.wrist == (5, 6, 7)
    assert pa10.shoulder == (1, 2, 3)
    panda = structure_of(exact_chain(open_robot("panda")))
    assert (panda.srs, panda.wrist, panda.shoulder) == (False, (), (1, 2, 3))


def test_a_slide_across_keeps_axes_parallel():
    robot = from_dh(
        [(0, "pi/2", 0, 0), (0, "-pi/2", 0.2, 0), (0.3, 0, 0, 0)], convention="standard", kinds="RPR", task="planar"
    )
    assert structure_of(exact_chain(robot)).parallel == ((1, 3),)


def test_axes_on_one_line_are_no_spherical_group():
    robot = from_dh([(0, 0, 0, 0), (0, "pi/2", 0, 0), (0.2, 0, 0, 0)], convention="standard", task="position")
    assert structure_of(exact_chain(robot, "pose")).points == ()


def test_an_offset_far_from_zero_is_no_near_structure():
    assert structure_of(exact_chain(open_robot("panda"))).near == ()
