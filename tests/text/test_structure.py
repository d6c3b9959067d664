"""How the structure of an arm and the methods that it allows are worded."""

from __future__ import annotations

import re

import numpy as np
import pytest

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.decoupling import decouple
from rankdrop.exact.method_reason import MethodReason, Parting, PartingKind
from rankdrop.exact.methods import derive
from rankdrop.kinematics import jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame
from rankdrop.text.structure import reason_text
from rankdrop.verbs.conditions import conditions


@pytest.mark.parametrize("name", ["ur5", "z1", "ur3e"])
def test_beside_a_planar_triple_a_line_is_lost(name):
    chain = exact_chain(open_robot(name))
    words = {part.roles[0]: part for part in decouple(chain).parts}
    line = "the points of the line that is parallel to axes 2, 3, 4 and meets axes {} cannot move along it"
    assert words["shoulder"].statement == line.format("1, 5, 6")
    assert words["wrist"].statement == line.format("1, 5")
    assert words["elbow"].statement == (
        "motions in the plane across axes 2, 3, 4 have no part along the line that meets these axes"
    )
    for role, met in (("shoulder", (0, 4, 5)), ("wrist", (0, 4))):
        q = np.array(words[role].witness)
        screws = jacobian(chain.robot, q, Frame(0, 0))
        lost = np.linalg.svd(screws)[0][:, -1]  # a wrench (f; τ) about the base origin
        assert abs(lost[:3] @ lost[3:]) < 1e-9  # a force along a line
        assert np.abs(np.cross(lost[:3], screws[3:, 1])).max() < 1e-9 < np.linalg.norm(lost[:3])
        point = np.cross(lost[:3], lost[3:]) / (lost[:3] @ lost[:3])
        for j in met:
            axis, on_axis = screws[3:, j], np.cross(screws[3:, j], screws[:3, j])
            assert abs((point - on_axis) @ np.cross(lost[:3], axis)) < 1e-9
            assert np.linalg.norm(np.cross(lost[:3], axis)) > 1e-3  # they meet, not parallel
    q = np.array(words["elbow"].witness)
    screws = jacobian(chain.robot, q, Frame(0, 0))
    feet = [np.cross(screws[3:, j], screws[:3, j]) for j in (1, 2, 3)]
    across = feet[2] - feet[0] - screws[3:, 1] * ((feet[2] - feet[0]) @ screws[3:, 1])
    z = screws[3:, 1]
    out_of_plane = np.vstack([z @ screws[:3], (np.eye(3) - np.outer(z, z)) @ screws[3:]])
    _, sigma, right = np.linalg.svd(out_of_plane)
    rates = right[np.array([*sigma, *[0.0] * (6 - len(sigma))]) < 1e-9]  # joint rates of motions in the plane
    assert len(rates) == 3
    along = np.array([*across, *np.cross(feet[0], across)])  # a force along the line, as a wrench about the base origin
    assert along @ screws @ rates.T == pytest.approx(0, abs=1e-9)
    assert np.abs(along @ screws).max() > 1e-3  # other motions have a part along it


@pytest.mark.slow
def test_auto_names_the_methods_that_it_does_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where conditions are long it compares the minors, which end, and claims nothing of the methods by cases."""
    arm = from_dh([(0, np.pi / 2, 0.3, 0), (0.4, 0, 0, 0), (0.3, 0, 0, 0), (0.2, 0, 0, 0)], convention="standard")
    monkeypatch.setattr("rankdrop.exact.derivation._LONG", 1)
    found = conditions(arm, "position", points=0, coranks=1)
    assert (found.method, found.complete) == ("determinant", True)
    assert re.search(
        r"; conditions have up to \d+ terms: reciprocity and singular-vector were not run; each can be asked for$",
        reason_text(found.reason),
    )
    assert derive(exact_chain(arm, "position"), "singular_vector").complete


def test_a_reason_says_what_is_open() -> None:
    parting = Parting(PartingKind.ALWAYS_SINGULAR)
    why = "the arm is singular at every configuration"
    assert reason_text(MethodReason()) == "asked for"
    assert reason_text(MethodReason(parting, 500, ("singular-vector",))) == (
        f"{why}; conditions have up to 500 terms: singular-vector was not run; each can be asked for"
    )
    assert reason_text(MethodReason(parting, unfactored=2)) == (
        f"{why}; minors that were not factored in time, and stand as they are: 2"
    )
    assert reason_text(MethodReason(parting, unfinished="suppression")) == (
        f"{why}; the method suppression was tried and did not finish"
    )
