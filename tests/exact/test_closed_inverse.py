"""The closed inverse of a square matrix of sines and cosines, against NumPy's; refusals where there is none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from rankdrop.algebra.polynomial import Polynomial
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.errors import OptionError
from rankdrop.exact import closed_inverse as module
from rankdrop.exact.closed_inverse import POINTS, closed_inverse
from rankdrop.formula.notation import Python

RING = Ring([1, 2, 3])
C, S, ONE = RING.c, RING.s, RING.one
ROWS = [
    [C[1] + 2, S[2] * C[3], -S[3]],
    [S[1] * S[2], C[2] * 3, C[1] * C[2] - S[1] * S[2]],
    [ONE, S[1], C[3] - 2],
]  # fmt: skip


def numbers(theta: np.ndarray) -> np.ndarray:
    """The same matrix at angles θ1, θ2, θ3."""
    (c1, c2, c3), (s1, s2, s3) = np.cos(theta), np.sin(theta)
    return np.array([[c1 + 2, s2 * c3, -s3], [s1 * s2, 3 * c2, c1 * c2 - s1 * s2], [1, s1, c3 - 2]])


def test_the_closed_inverse_is_that_of_numpy(rng: np.random.Generator) -> None:
    found = closed_inverse(RING, ROWS, Work())
    assert (found.agree, found.tested) == (POINTS, POINTS)
    for theta in rng.uniform(-3, 3, (10, 3)):
        matrix = numbers(theta)
        closed = [[entry.at(theta, {}) for entry in row] for row in found.entries]
        assert np.array(closed) == pytest.approx(np.linalg.inv(matrix), rel=1e-9)
        names = {f"q{j}": value for j, value in enumerate(theta, start=1)} | {"sin": np.sin, "cos": np.cos}
        determinant = eval(found.determinant.code(Python(shifts=(0.0,) * 3)), names)
        assert determinant == pytest.approx(np.linalg.det(matrix), rel=1e-9)


def test_a_wrong_cofactor_is_noticed_modulo_the_prime(monkeypatch: pytest.MonkeyPatch) -> None:
    right = module._cofactor

    def without_sign(
        ring: Ring, rows: Sequence[Sequence[Polynomial]], i: int, j: int, work: Work
    ) -> Polynomial:
        cofactor = right(ring, rows, i, j, work)
        return -cofactor if (i + j) % 2 else cofactor

    monkeypatch.setattr(module, "_cofactor", without_sign)
    assert closed_inverse(RING, ROWS, Work()).agree == 0


def test_a_matrix_without_an_inverse_is_refused() -> None:
    with pytest.raises(OptionError, match="only a square Jacobian has an inverse"):
        closed_inverse(RING, [row[:2] for row in ROWS], Work())
    with pytest.raises(OptionError, match="singular everywhere"):
        closed_inverse(RING, [ROWS[0], ROWS[1], [a + b for a, b in zip(ROWS[0], ROWS[1], strict=True)]], Work())


def test_a_limit_on_work_ends_it() -> None:
    with pytest.raises(OutOfTime):
        closed_inverse(RING, ROWS, Work(0.0))
