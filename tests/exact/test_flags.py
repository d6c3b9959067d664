"""Configuration flags agree with the numeric determinant; families that part two configurations are crossed."""

from __future__ import annotations

import json

import numpy as np
import pytest

from rankdrop.codec import plain
from rankdrop.errors import ConfigurationError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.decoupling import decouple
from rankdrop.exact.signs import configuration_flags, families_between, signs_of, zeros_between, zeros_of
from rankdrop.kinematics import jacobian, task_jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot

SIMPLE = ("anthropomorphic", "puma560", "ur5", "irb140", "z1", "scara", "planar2r", "planar3r", "xarm6")


@pytest.mark.slow_at("xarm6")
@pytest.mark.parametrize("name", SIMPLE)
def test_product_of_the_flags_is_the_sign_of_the_determinant(name, rng):
    chain = exact_chain(open_robot(name))
    signs = signs_of(chain)
    assert signs.factors
    q = rng.uniform(-np.pi, np.pi, (50, chain.n))
    determinant = np.linalg.det(jacobian(chain.robot, q)[:, list(chain.task.rows)])
    together = np.prod(np.sign(signs.values(q)), axis=1) * np.sign(determinant)
    assert abs(together.sum()) == len(q)  # the same sign everywhere


def test_a_squared_factor_keeps_its_own_sign(rng):
    # Stanford: det = q3² s2 s5 does not change sign where q3 does, the family q3 = 0 parts all the same
    chain = exact_chain(open_robot("stanford"))
    flags = {flag.factor: flag for flag in configuration_flags(chain, [0.1, 0.5, -0.4, 0.2, 0.6, 0]).flags}
    assert {factor: flag.sign for factor, flag in flags.items()} == {"s2": 1, "s5": 1, "q3": -1}


@pytest.mark.slow
def test_a_factor_not_of_a_part_gives_its_own_label():
    chain = exact_chain(open_robot("stanford"))
    assert [flag.label for flag in configuration_flags(chain, [0.1, 0.5, -0.4, 0.2, 0.6, 0]).flags][2] == "q3 −"
    (flag,) = configuration_flags(exact_chain(open_robot("xarm6")), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).flags
    assert len(flag.label) < 60 < len(flag.factor)


def test_coefficients_beyond_floating_point_are_scaled(rng):
    twists = ["89.9123456 deg", "0.0123456 deg", "0.0234567 deg", "90.0345678 deg", "-89.9456789 deg", 0]
    a = (0.0001234, -0.4251234, -0.3921234, 0.0012345, 0.0002345, 0)
    d = (0.0891234, 0.0011, 0.0012, 0.1091234, 0.0946, 0)
    robot = from_dh([(a[i], twists[i], d[i], 0) for i in range(6)], convention="standard")
    chain = exact_chain(robot)
    signs = signs_of(chain)
    q = rng.uniform(-np.pi, np.pi, (40, 6))
    together = np.sign(signs.values(q)).prod(axis=1) * np.sign(np.linalg.det(jacobian(robot, q)))
    assert abs(together.sum()) == len(q)


def test_flags_of_an_elbow_arm_are_named():
    chain = exact_chain(open_robot("anthropomorphic"))
    flags = configuration_flags(chain, [0, 0.4, 0.9, 0, -1, 0])
    assert [flag.label for flag in flags.flags] == ["elbow +", "wrist −", "shoulder −"]
    assert [flag.factor for flag in flags.flags][:2] == ["s3", "s5"]
    assert flags.sentences()[0] == "elbow +: s3 > 0"
    assert json.loads(json.dumps(plain(flags)))["flags"][1]["sign"] == -1


@pytest.mark.parametrize("name", ["puma560", "ur5", "z1"])
def test_a_configuration_on_a_family_has_flag_zero(name):
    chain = exact_chain(open_robot(name))
    signs = signs_of(chain)
    for k, factor in enumerate(signs.factors):
        points = zeros_of(chain, factor.atoms, 3)
        assert len(points) == 3
        for q in points:
            assert configuration_flags(chain, q, signs=signs).flags[k].sign == 0


@pytest.mark.slow
def test_real_points_are_singular_and_of_the_atom():
    chain = exact_chain(open_robot("xarm6"))
    for part in signs_of(chain).factors:
        points = zeros_of(chain, part.atoms, 6)
        assert len(points)
        sigma = np.linalg.svd(task_jacobian(chain.robot, points, chain.task), compute_uv=False)
        assert sigma[:, -1].max() < 1e-9


def test_a_condition_without_real_zeros_has_no_points_and_no_name():
    # upper arm shorter than the shoulder's offset: the wrist centre never reaches axis 1
    rows = [(1.5, "pi/2", 0, 0), (0.5, 0, 0, 0), (0, "pi/2", 0, "pi/2"), (0, "-pi/2", 0.4, 0), (0, "pi/2", 0, 0),
            (0, 0, 0.1, 0)]  # fmt: skip
    found = decouple(exact_chain(from_dh(rows, convention="standard")))
    unreal = [part for part in found.parts if part.witness is None]
    assert [(part.name, part.roles, part.lost) for part in unreal] == [("arm", (), ())]


@pytest.mark.parametrize("name", ["puma560", "ur5", "irb140"])
def test_parity_of_crossings_is_the_difference_of_signs(name, rng):
    chain = exact_chain(open_robot(name))
    signs = signs_of(chain)
    parted = 0
    for first, second in rng.uniform(-np.pi, np.pi, (12, 2, 6)):
        found = families_between(chain, first, second, signs=signs)
        assert sorted(found.parting + found.equal) == list(range(len(signs.factors)))
        assert not found.open
        parted += len(found.parting)
        for k, factor in enumerate(signs.factors):
            through = [one for one in found.crossings if one.factor == factor.text and one.kind == "crosses"]
            assert len(through) % 2 == (k in found.parting)
        for one in found.crossings:
            q = first + one.at * (second - first)
            assert abs(np.linalg.det(jacobian(chain.robot, q))) < 1e-9
    assert parted > 5


def test_every_path_between_opposite_signs_crosses_and_it_is_said():
    chain = exact_chain(open_robot("puma560"))
    first, second = [0, 0.3, 0.2, 0, 0.5, 0], [0, 0.3, 0.2, 0, -0.5, 0]
    found = families_between(chain, first, second)
    assert [found.first.flags[i].label for i in found.parting] == ["wrist +"]
    assert found.sentences()[0] == "Every path between them crosses wrist: axes 4 and 6 aligned (s5): its sign differs."
    (crossing,) = found.crossings
    assert (crossing.kind, crossing.at) == ("crosses", pytest.approx(0.5))
    assert json.dumps(plain(found))


def test_a_zero_at_one_end_decides_nothing():
    chain = exact_chain(open_robot("planar2r"))
    found = families_between(chain, [0, 0.0], [0, 0.5])
    assert found.open == (0,)
    assert [one.kind for one in found.crossings] == ["starts on"]
    assert "decides nothing: it is zero at one of the two" in " ".join(found.sentences())


def test_a_segment_within_a_family_is_told():
    chain = exact_chain(open_robot("planar2r"))
    assert [one.kind for one in families_between(chain, [0, 0], [1, 0]).crossings] == ["lies in"]


def test_zeros_between_finds_touches_and_none():
    assert zeros_between(lambda s: (s - 0.3141) ** 2, 1.0, 1e-12) == [(pytest.approx(0.3141, abs=1e-6), "touches")]
    assert zeros_between(lambda s: (s - 0.3141) ** 2 + 0.01, 1.0, 1e-9) == []
    assert zeros_between(lambda s: s - 1, 1.0, 1e-9) == [(1.0, "ends on")]


def test_shifted_angles_are_the_robots_own(rng):
    # z1's conditions speak of θ = q + shift
    chain = exact_chain(open_robot("z1"))
    assert np.abs(chain.shifts).max() > 0.1
    for part in decouple(chain).parts:
        sigma = np.linalg.svd(task_jacobian(chain.robot, np.array(part.witness), chain.task), compute_uv=False)
        assert sigma[-1] < 1e-9 < sigma[-2]


def test_what_cannot_be_asked_is_refused():
    with pytest.raises(TaskError, match="not square"):
        signs_of(exact_chain(open_robot("pa10")))
    chain = exact_chain(open_robot("planar2r"))
    with pytest.raises(ConfigurationError):
        configuration_flags(chain, [0, 0, 0])
