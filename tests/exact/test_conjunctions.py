"""Polynomials that vanish together, and those that never vanish."""

from __future__ import annotations

import numpy as np
from exact.chains import SRS, chain_of

from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.conjunctions import SetDerivation, columns_on, values_of
from rankdrop.exact.methods import _choices, derive, zero_of
from rankdrop.robot.dh import from_dh


def test_what_is_said_to_vanish_does() -> None:
    """At θ4 = π, θ5 = π/2, θ6 = 0 every element of the screw is zero, and the other angles are free."""
    chain = chain_of("canadarm2")
    builder = SetDerivation(chain, "reciprocity", 30.0, frame=5, basic=(2, 3, 4, 5, 6, 7))
    joints, screw = _choices(builder, columns_on(ZeroSet(chain.ring, {4: "pi"}), builder.columns))[0]
    assert [j + 1 for j in joints] == [2, 3, 4, 6, 7]
    assert any(w != 0 for w in screw)
    assert all(chain.ring.at(w, {4: "pi", 5: "pi/2", 6: "0"}) == 0 for w in screw)
    assert any(chain.ring.at(w, {4: "pi", 5: "pi/2"}) != 0 for w in screw)


def test_a_polynomial_too_long_in_half_angles_is_not_factored_and_no_error() -> None:
    """Half-angle terms count, of which there are more."""
    rows = [(0.01, *SRS[0][1:]), (0, *SRS[1][1:2], 0, 0), (0.045, *SRS[2][1:]), (-0.045, *SRS[3][1:2], 0, 0), *SRS[4:]]
    chain = exact_chain(from_dh(rows, convention="standard"))
    found = derive(chain, "cofactors")
    assert found.complete
    builder = SetDerivation(chain, "determinant", 30.0)
    long = sum((minor**2 for minor in builder.minors(chain.columns, 6)), chain.ring.zero)
    assert chain.ring.factors_within(chain.ring.reduce(long), 30.0) is None


def test_a_polynomial_of_one_sign_has_no_zero() -> None:
    chain = chain_of("puma560")
    p = chain.ring.determinant([[column[row] for column in chain.columns[3:]] for row in range(3, 6)])
    where = zero_of(chain, p)
    assert where is not None
    assert abs(values_of(chain, p, np.array([where]) + chain.shifts)[0]).max() < 1e-12
    assert zero_of(chain, p * p + 1) is None
    assert zero_of(chain, -p * p - 1) is None
