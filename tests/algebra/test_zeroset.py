"""Sets, their random points, and solutions that are put in."""

from __future__ import annotations

import random

import pytest

from rankdrop.algebra.field import PRIMES, ModularPoint, half_angle_value, value_at
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.solving import Solved, substitute_into_form, without_real_root
from rankdrop.algebra.zeroset import ZeroSet


@pytest.fixture(scope="module")
def ring() -> Ring:
    return Ring([1, 2, 3, 4])


def test_random_points_lie_on_their_set_and_a_sum_of_squares_has_its_points_too(ring: Ring) -> None:
    f = ring.t[1] ** 2 + ring.t[2] ** 2 - ring.t[3] ** 3 * ring.t[4] - 2
    piece = ZeroSet(ring, {}, rest=(f,), equations=(f,))
    points = piece.points(random.Random(1), 20)
    assert len(points) == 20
    assert all(value_at(ring, f, point) == 0 for point in points)


def test_a_long_solution_of_few_variables_is_put_in() -> None:
    """100 terms with 30 for a variable of degree 9: at most 271 · 10 products of powers, not 100 · 30⁹."""
    ring = Ring([1, 2])
    x, y = ring.t[1], ring.t[2]
    f = sum((x**i * y**j * (i + 2 * j + 1) for i in range(10) for j in range(10)), ring.half.constant(0))
    top = sum((y**k * (k + 3) for k in range(30)), ring.half.constant(0))
    form = substitute_into_form(ring.form(f), Solved(0, top, ring.half.constant(2)))
    at, value = 5, sum((k + 3) * 5**k for k in range(30))
    wanted = sum(value**i * at**j * (i + 2 * j + 1) * 2 ** (9 - i) for i in range(10) for j in range(10))
    assert form.f.subs({"t2": at}) == wanted


def test_a_condition_over_roots_is_real_where_one_of_its_conjugates_is() -> None:
    """t² − 2√2 t + 3 has the discriminant −4, t² − √2 is real, and its conjugate is not."""
    ring = Ring([1], letters=["sqrt2"])
    x, root = ring.half.gens()
    assert without_real_root(x**2 - 2 * root * x + 3)
    assert not without_real_root(x**2 - root)


def test_a_highest_coefficient_at_pi_is_made_once(ring: Ring, monkeypatch: pytest.MonkeyPatch) -> None:
    t1, t2 = ring.t[1], ring.t[2]
    f, other = (t2**2 + 3) * t1**2 + t1 * t2 + 5, (t2 - 4) * t1 + 1
    made = []
    monkeypatch.setattr(Form, "at", lambda form, pins, at=Form.at: made.append(pins) or at(form, pins))
    points = [ModularPoint({"t2": x}, PRIMES[0]) for x in (2, 4, 7)]
    assert [half_angle_value(ring, f, point) for point in points] == [7, 19, 52]
    assert [half_angle_value(ring, other, point) for point in points] == [PRIMES[0] - 2, 0, 3]
    assert made == [{1: "pi"}, {1: "pi"}]
