"""Factors with a sign on the torus: the values have the sign of the text, and the sign survives full turns."""

from __future__ import annotations

import re
from math import cos, sin

import numpy as np
import pytest

from rankdrop.algebra.ring import Ring
from rankdrop.exact.signs import signed_factors

RING = Ring([1, 2], [3], ["a"])
LETTERS = {"a": 0.7}
S, C = RING.s, RING.c
NO_SIGN = 1 - C[1]


def factors(p):
    return signed_factors(RING, [atom for atom, _ in RING.factor(p).atoms])


def test_pins_at_0_and_pi_are_a_sine_and_at_quarters_a_cosine():
    found = factors(S[1] * C[1] * S[2])
    assert [(factor.text, factor.periodic) for factor in found] == [("s1", True), ("c1", True), ("s2", True)]


@pytest.mark.parametrize(
    "p",
    [S[1], C[1], S[1] * C[2] + 2 * C[1] - RING.letter["a"], S[1] * RING.q[3] + C[2], S[1] - C[2],
     S[1] * (1 - S[1]), NO_SIGN * (1 - S[1]), (S[1] + S[2]) * (C[1] * C[2] - S[1] * S[2] + 1)],
)  # fmt: skip
def test_values_have_the_sign_of_the_text(p, rng):
    found = factors(p)
    assert found
    for factor in found:
        theta = rng.uniform(-3, 3, (40, 3))
        values = factor.values(theta, LETTERS)
        expected = [_evaluated(factor.text, point) for point in theta]
        assert np.array_equal(np.sign(values), np.sign(expected))


def _evaluated(text, theta):
    names = {"q3": theta[2], "a": 0.7, "sin": sin, "cos": cos, "π": np.pi}
    for j in (1, 2):
        x = theta[j - 1]
        names |= {f"s{j}": sin(x), f"c{j}": cos(x), f"θ{j}": x, f"t{j}": np.tan(x / 2)}
    python = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text.replace("·", "*").replace("−", "-"))  # blanks: factors
    python = re.sub(r"\b(\d+)(?=θ)", r"\1*", python)
    return eval(python, {}, names)


@pytest.mark.parametrize(
    "p", [S[1] * S[2], S[1] - C[2], NO_SIGN * (1 - S[1]) * S[2], S[1] * S[2] + 2 * C[1] + RING.letter["a"]]
)
def test_periodic_factors_keep_their_sign_over_a_full_turn(p, rng):
    theta = rng.uniform(-3, 3, (20, 3))
    for factor in factors(p):
        assert factor.periodic
        for joint in (0, 1):
            turned = theta.copy()
            turned[:, joint] += 2 * np.pi
            assert factor.values(turned, LETTERS) == pytest.approx(factor.values(theta, LETTERS))


def test_a_lone_half_angle_factor_has_no_sign_of_its_own(rng):
    (factor,) = factors(NO_SIGN)
    assert (factor.text, factor.periodic) == ("sin(θ1/2)", False)
    theta = rng.uniform(-3, 3, (5, 3))
    turn = np.array([2 * np.pi, 0, 0])
    assert factor.values(theta + turn, LETTERS) == pytest.approx(-factor.values(theta, LETTERS))


def test_half_angle_factors_whose_turns_cancel_are_joined():
    # s1 − c2 = 0 is θ1 + θ2 = π/2 or θ1 − θ2 = π/2: each alone changes sign over a turn
    (factor,) = factors(S[1] - C[2])
    assert factor.periodic
    assert len(factor.atoms) == 2


def test_three_zeros_of_one_joint_part_its_circle_in_three(rng):
    found = factors(S[1] * (1 - S[1]))
    theta = np.stack([np.linspace(-3.1, 3.1, 60), np.zeros(60), np.zeros(60)], axis=1)
    patterns = {tuple(row) for row in np.sign([factor.values(theta, LETTERS) for factor in found]).T}
    assert len(patterns) == 3


def test_a_sine_and_a_cosine_tell_all_four_quarters():
    assert [factor.text for factor in factors(S[1] * C[1])] == ["s1", "c1"]
