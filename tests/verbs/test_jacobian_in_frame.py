"""`rankdrop jacobian`: ML's ¹J and its inverse, KG's screws in frame 5, numbers that agree, refusals that help."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli import exits
from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.formula.notation import Python
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.verbs import link_jacobian
from rankdrop.verbs.jacobian_in_frame import numeric

Q = [0.3, -0.8, 1.1, 0.4, 0.9, -0.6]


def test_ml_planar_arm_in_the_axes_of_link_1() -> None:
    """¹J and ¹J⁻¹ as the lecture prints them, entry by entry with what is common cancelled."""
    found = link_jacobian(open_robot("planar2r"), 1, inverse=True)
    assert found.texts() == (("−a2 s2", "−a2 s2"), ("a1 + a2 c2", "a2 c2"))
    assert found.inverse_texts() == (("c2 / (a1 s2)", "1 / a1"), ("−(a1 + a2 c2) / (a1 a2 s2)", "−1 / a1"))
    assert found.closed is not None
    assert found.closed.determinant.text() == "a1 a2 s2"
    assert r"\frac{c_2}{a_1 s_2}" in found.latex()
    assert found.holds
    assert len(found.checks) == 3


@pytest.mark.slow
def test_kg_screws_in_frame_5() -> None:
    """The print's columns 3 to 7, and the sixth row of column 2, from (ω; p × ω) to (v; ω)."""
    columns = list(zip(*link_jacobian(open_robot("canadarm2"), 5, at=5).texts(), strict=True))
    assert columns[2] == ("d s45 + d s5", "d c45 + d c5", "0", "0", "0", "1")
    assert columns[3] == ("d s5", "d c5", "0", "0", "0", "1")
    assert columns[4] == ("0", "0", "0", "0", "0", "1")
    assert columns[5] == ("0", "0", "0", "0", "−1", "0")
    assert columns[6] == ("−a c6", "0", "−a s6", "−s6", "0", "c6")
    assert columns[1] == ("−2 c c345", "2 c s345", "d c3 + d c34", "−s345", "−c345", "0")


@pytest.mark.by_hand
@pytest.mark.slow_at("puma560-5")
@pytest.mark.by_hand_at("ur5-3")
@pytest.mark.slow_at("ur5-3", "anthropomorphic-None")
@pytest.mark.parametrize(("name", "at"), [("anthropomorphic", None), ("puma560", 5), ("ur5", 3), ("stanford", 5)])
def test_the_closed_inverse_is_the_inverse(name: str, at: int | None) -> None:
    robot = open_robot(name)
    found = link_jacobian(robot, at=at, inverse=True, q=Q)
    assert found.holds
    assert found.closed is not None
    assert found.numbers is not None
    theta = np.array(Q) + found.chain.shifts
    closed = np.array([[x.at(theta, found.letters) for x in row] for row in found.closed.entries])
    np.testing.assert_allclose(closed, found.numbers.inverse, atol=1e-9 * np.abs(closed).max())
    names = {f"q{j}": value for j, value in enumerate(Q, 1)} | {"sin": np.sin, "cos": np.cos} | dict(found.letters)
    code = [[eval(x.code(Python(shifts=found.shifts)), {}, names) for x in row] for row in found.closed.entries]
    np.testing.assert_allclose(code, closed, atol=1e-12 * np.abs(closed).max())


@pytest.mark.slow
def test_the_frame_chosen_is_the_shortest() -> None:
    found = link_jacobian(open_robot("ur5"))
    terms = [sum(len(x) for row in link_jacobian(open_robot("ur5"), k).rows for x in row) for k in range(1, 7)]
    assert terms[found.frame - 1] == min(terms)
    assert next(one for one in found.shortest if one[2] is None) == (min(terms), found.frame, None)


@pytest.mark.parametrize("at", [None, 1, 4])
def test_numbers_are_the_core_jacobian_turned_and_moved(at: int | None) -> None:
    """A turn and another point leave the determinant; in the axes of link k its own screw is along z."""
    robot = open_robot("puma560")
    chain = exact_chain(robot)
    wanted = np.linalg.det(task_jacobian(robot, Q, replace(chain.task, length_scale=1.0)))
    for k in range(1, 7):
        found = numeric(chain, np.array(Q), k, at)
        assert np.linalg.det(found) == pytest.approx(wanted, abs=1e-12)
        np.testing.assert_allclose(found[3:, k - 1], [0, 0, 1], atol=1e-12)
        if at == k:
            np.testing.assert_allclose(found[:3, k - 1], 0, atol=1e-12)


def test_a_wrong_closed_form_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check is against the core's Jacobian, which knows nothing of the closed form."""
    import rankdrop.verbs.jacobian_in_frame as verb

    right = verb.frame_jacobian
    monkeypatch.setattr(verb, "frame_jacobian", lambda chain, k, at: [[-x for x in row] for row in right(chain, k, at)])
    found = link_jacobian(open_robot("planar2r"), 1)
    assert not found.holds
    assert "FAILS" in str(found)


def test_command_line(run, tmp_path) -> None:
    ended = run("jacobian", "planar2r", "--frame", "1", "--inverse", "--json", str(tmp_path / "j.json"))
    assert ended.code == exits.FINE
    assert "det J = a1 a2 s2" in ended.out
    record = json.loads((tmp_path / "j.json").read_text())
    Draft202012Validator(load_schema("jacobian")).validate(record)
    assert record["inverse"]["entries"][0][0]["text"] == "c2 / (a1 s2)"
    ended = run("jacobian", "ur5", "--deg", "--q", "0,-90,60,0,80,0", "--inverse", "--json", "-")
    record = json.loads(ended.out)
    Draft202012Validator(load_schema("jacobian")).validate(record)
    assert record["matrix"] == []
    assert len(record["numbers"]["inverse"]) == 6


def test_refusals() -> None:
    with pytest.raises(OptionError, match="only a square Jacobian has an inverse"):
        link_jacobian(open_robot("pa10"), inverse=True)
    with pytest.raises(OptionError, match="no such link"):
        link_jacobian(open_robot("planar2r"), 3)
    with pytest.raises(OptionError, match="another point is another task"):
        link_jacobian(open_robot("ur5"), 1, "position", at=2)
    with pytest.raises(OptionError, match="nothing is asked for"):
        link_jacobian(open_robot("ur5"), symbolic=False)
    with pytest.raises(TaskError, match="rows of this task would be others"):
        link_jacobian(open_robot("ur5"), 1, "vx,vy,wz")
