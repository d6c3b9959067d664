"""Polynomials that vanish together, and those that never vanish."""

from __future__ import annotations

from exact.chains import SRS

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.conjunctions import SetDerivation
from rankdrop.exact.methods import derive
from rankdrop.robot.dh import from_dh


def test_a_polynomial_too_long_in_half_angles_is_not_factored_and_no_error() -> None:
    """Half-angle terms count, of which there are more."""
    rows = [(0.01, *SRS[0][1:]), (0, *SRS[1][1:2], 0, 0), (0.045, *SRS[2][1:]), (-0.045, *SRS[3][1:2], 0, 0), *SRS[4:]]
    chain = exact_chain(from_dh(rows, convention="standard"))
    found = derive(chain, "cofactors")
    assert found.complete
    builder = SetDerivation(chain, "determinant", 30.0)
    long = sum((minor**2 for minor in builder.minors(chain.columns, 6)), chain.ring.zero)
    assert chain.ring.factors_within(chain.ring.reduce(long), 30.0) is None
