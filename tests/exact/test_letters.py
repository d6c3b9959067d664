"""Letters for lengths: the robot's own, Denavit and Hartenberg's for the rest, and those of the tip."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from exact.lettered import arm
from reference.trig import value

pytest.importorskip("flint")

from rankdrop.errors import OptionError, RobotError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.remark import chain_remarks
from rankdrop.kinematics import jacobian
from rankdrop.results.analysis import robot_from_dict, robot_to_dict
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

KG = {"a": Fraction("0.635"), "c": Fraction("0.504"), "d": Fraction("6.85")}


def test_canadarm2_has_the_letters_of_kg():
    found = exact_chain(open_robot("canadarm2"))
    assert dict(found.letters) == KG
    given = exact_chain(open_robot("canadarm2"), lengths={"a": 0.635, "c": 0.504, "d": 6.85})
    assert found.written == given.written
    assert found.screws(5) == given.screws(5)
    assert chain_remarks(found) == ()


def test_lengths_without_a_letter_keep_the_names_of_the_table():
    found = exact_chain(arm({"L": 0.4}))
    assert dict(found.letters) == {"L": Fraction("0.4"), "a2": Fraction("0.5"), "d3": Fraction("0.5")}
    assert found.written[2, "a"] == (-1, "L")


def test_of_equal_letters_the_one_of_the_kind_is_taken():
    found = exact_chain(arm({"d9": 0.5, "a9": 0.5}))
    assert (found.written[1, "a"], found.written[2, "d"]) == ((1, "a9"), (1, "d9"))
    one = exact_chain(arm({"R": 0.5}))  # a letter stands for every length of its value
    assert (one.written[1, "a"], one.written[2, "d"]) == ((1, "R"), (1, "R"))


def test_a_letter_named_as_another_length_of_the_table_stays_with_its_value():
    found = exact_chain(arm({"a2": 0.4}))
    assert found.written[2, "a"] == (-1, "a2")
    assert found.written[1, "a"] == (1, "a2_")
    assert dict(found.letters) == {"a2": Fraction("0.4"), "a2_": Fraction("0.5"), "d3": Fraction("0.5")}


def test_the_caller_s_letters_replace_the_robot_s():
    found = exact_chain(arm({"L": 0.5}), lengths={"M": 0.4})
    assert dict(found.letters) == {"M": Fraction("0.4")}
    with pytest.raises(OptionError, match="no length of the arm has this value"):
        exact_chain(arm(), lengths={"M": 0.41})


def test_a_length_of_twelve_decimals_is_recognised():
    root = float(np.sqrt(2))
    robot = replace(open_robot("almarkhi4"), lengths=(("w", root),))
    written = exact_chain(robot).written
    assert [written[i, "a"] for i in range(3)] == [(1, "w")] * 3


def test_the_tip_has_letters_for_tasks_that_depend_on_it():
    found = exact_chain(arm(tool=0.05), "position")
    assert (found.written[4, "a"], found.written[4, "d"]) == ((1, "a4"), (1, "d4"))
    assert found.numbers["a4"] == 0.3
    assert found.numbers["d4"] == 0.2
    for task in ("pose", "orientation"):
        assert not {"a4", "d4"} & set(exact_chain(arm(tool=0.05), task).letters)
    assert exact_chain(arm({"e": 0.3}), "position").written[4, "a"] == (1, "e")
    assert exact_chain(open_robot("pa10"), "position").written[7, "d"] == (1, "d3")  # both are 0.45 m


@pytest.mark.parametrize("lengths", ["auto", "numbers"])
@pytest.mark.parametrize("task", ["position", "vx,vy,wz"])
def test_screws_at_the_tip_are_the_numeric_jacobian(task, lengths, rng):
    chain = exact_chain(arm({"L": 0.4}, tool=0.05), task, lengths=lengths)  # a3 = −L
    assert bool(chain.letters) is (lengths == "auto")
    q = rng.uniform(-np.pi, np.pi, chain.n)
    expected = jacobian(chain.robot, q)
    for k in range(1, chain.n + 1):
        found = np.array([[value(chain, x, q) for x in screw] for screw in chain.screws_at_tip(k)]).T
        assert found.T @ found == pytest.approx(expected.T @ expected, abs=1e-9)


def test_letters_survive_a_record_and_may_be_absent():
    robot = open_robot("canadarm2")
    record = robot_to_dict(robot, resolve_task(None, robot), 6)
    assert robot_from_dict(record).lengths == robot.lengths == (("a", 0.635), ("c", 0.504), ("d", 6.85))
    del record["lengths"]
    assert robot_from_dict(record).lengths == ()
    pa10 = open_robot("pa10")
    assert "lengths" not in robot_to_dict(pa10, resolve_task(None, pa10), 6)


def test_robots_refuse_letters_that_conditions_cannot_have():
    with pytest.raises(RobotError, match=r"length 's2': a length cannot have this name"):
        arm({"s2": 0.4})
    with pytest.raises(RobotError, match="positive"):
        arm({"L": -0.4})
    with pytest.raises(RobotError, match="same letter"):
        replace(arm(), lengths=(("L", 1.0), ("L", 2.0)))
