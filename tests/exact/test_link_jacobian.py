"""The Jacobian in link axes: ML's ¹J and its inverse, and a turn of the numeric Jacobian for every link."""

from __future__ import annotations

import numpy as np
import pytest
from reference.trig import value

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.structure import frame_jacobian
from rankdrop.kinematics import jacobian
from rankdrop.robot.open import open_robot


def test_planar_jacobian_in_link_axes_of_ml():
    chain = exact_chain(open_robot("planar2r"))
    ring = chain.ring
    a1, a2 = ring.letter["a1"], ring.letter["a2"]  # a2 is the way from the last axis to the tip
    s2, c2 = ring.s[2], ring.c[2]
    found = frame_jacobian(chain, 1)
    assert found == [[-a2 * s2, -a2 * s2], [a1 + a2 * c2, a2 * c2]]
    # the inverse with the factors a2 that the print lacks: J⁻¹ a1 a2 s2
    inverse = [[a2 * c2, a2 * s2], [-a1 - a2 * c2, -a2 * s2]]
    product = [[ring.reduce(sum((found[i][k] * inverse[k][j] for k in range(2)), ring.zero)) for j in range(2)]
               for i in range(2)]  # fmt: skip
    assert product == [[a1 * a2 * s2, 0], [0, a1 * a2 * s2]]
    assert ring.determinant(found) == a1 * a2 * s2


@pytest.mark.parametrize(("name", "task"), [("planar2r", None), ("planar3r", None), ("scara", None), ("ur5", None),
                                            ("ur5", "position"), ("ur5", "orientation")])  # fmt: skip
def test_link_jacobian_is_a_turn_of_the_numeric_one(name, task, rng):
    chain = exact_chain(open_robot(name), task)
    for k in range(1, chain.n + 1):
        q = rng.uniform(-np.pi, np.pi, chain.n)
        numeric = np.array([[value(chain, x, q) for x in row] for row in frame_jacobian(chain, k)])
        expected = jacobian(chain.robot, q)[list(chain.task.rows)]
        assert numeric.T @ numeric == pytest.approx(expected.T @ expected, abs=1e-9)


def test_link_jacobian_refuses_rows_that_would_change():
    with pytest.raises(TaskError, match="axes of a link"):
        frame_jacobian(exact_chain(open_robot("ur5"), "vx,vy,wz"), 2)
    with pytest.raises(OptionError, match="no such link"):
        frame_jacobian(exact_chain(open_robot("planar2r")), 3)
