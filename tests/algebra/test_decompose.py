"""Systems taken apart: planted components are found, and what is found satisfies the conditions."""

from __future__ import annotations

import random
from dataclasses import replace
from math import prod

import pytest
from algebra.planted_sets import factor_on_stratum, is_there, random_plane

from rankdrop.algebra import decompose as steps
from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.field import PRIMES
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.solving import plainly_positive, without_real_root, without_real_zero
from rankdrop.algebra.work import OutOfTime, Work, tick
from rankdrop.algebra.zeroset import ZeroSet, independent


def test_divisions_that_raise_one_anothers_degrees_end() -> None:
    """A third condition, divided in t2 by the first one, grows in t1, and divided in t1 by the second one in t2."""
    ring = Ring((1, 2, 3), (), ())
    t1, t2, t3 = (ring.t[joint] for joint in (1, 2, 3))
    first = (1 + t1**2) * t2**3 + 3 * t1**2 * t2 + 2 * t1 - 6
    second = (1 + t2**2) * t1**3 + 5 * t2**2 * t1 - 4 * t2 - 3
    third = t1**2 * t2**4 * t3**2 + t1 * t3 + t2 + 5
    work = Work(1.3)
    (found,) = decompose(ring, {}, [ring.form(f) for f in (first, second, third)], 3, work)
    assert not work.unresolved
    assert all(found.half_vanishes(f) for f in (first, second, third))


@pytest.fixture(scope="module")
def ring() -> Ring:
    return Ring([1, 2, 3, 4])


def test_products_of_irreducibles_fall_into_all_pairs(ring: Ring) -> None:
    rng = random.Random(1)
    for _ in range(5):
        one = [random_plane(ring, rng, (1, 2)), random_plane(ring, rng, (2, 3)) + ring.t[1] * ring.t[3]]
        two = [random_plane(ring, rng, (3, 4)), random_plane(ring, rng, (1, 4)) + ring.t[2] ** 2]
        system = [one[0] * one[1], two[0] * two[1]]
        found = factor_on_stratum(ring, system, 2)
        for f in one:
            for g in two:
                assert is_there(ring, found, {}, f, g)
        for piece in found:
            assert piece.samples
            assert all(piece.half_vanishes(f) for f in system)


def test_what_a_solution_leaves_out_is_found(ring: Ring) -> None:
    t = ring.t
    a, b = t[1] + 2 * t[2] + 3, t[2] * t[1] + 7
    f = a * t[3] + b
    g = a * t[4] + b * 7
    found = factor_on_stratum(ring, [f, g], 2)
    assert is_there(ring, found, {}, a, b), "A = B = 0 with t3 and t4 free"
    assert is_there(ring, found, {}, f, 7 * t[3] - t[4])


@pytest.mark.parametrize("joints", [(3,), (1, 2)])
def test_components_at_pi_are_found(ring: Ring, joints: tuple[int, ...]) -> None:
    t = ring.t
    if len(joints) == 1:  # the leading coefficients in t3 have the common factor t1 + t2
        system = [(t[1] + t[2]) * t[3] + t[4] + 1, (t[1] + t[2]) * t[3] * t[4] + t[4] - 5]
        assert is_there(ring, factor_on_stratum(ring, system, 2), {3: "pi"}, t[1] + t[2])
    else:
        system = [t[1] + t[2] + 2 * t[4], t[1] - t[2] + 3 * t[3]]
        found = factor_on_stratum(ring, system, 3)
        assert is_there(ring, found, {1: "pi", 2: "pi"})


def test_three_conditions_that_meet_at_pi_without_a_common_factor_are_found(ring: Ring) -> None:
    t = ring.t
    one, two = t[1] + 2 * t[2] - 3, t[1] * t[2] + 5
    # at t3 = ∞ the three leading coefficients vanish where one = two = 0, pairwise they have no common factor
    system = [one * t[3] + t[4] + 1, two * t[3] + 3 * t[4] - 7, (one + two * t[4]) * t[3] + t[4] ** 2 - 11]
    assert is_there(ring, factor_on_stratum(ring, system, 3), {3: "pi"}, one, two)


def test_sets_without_a_real_point_for_a_plain_reason_are_left_out(ring: Ring) -> None:
    t = ring.t
    assert factor_on_stratum(ring, [(1 + t[1] ** 2) * (2 + t[2] ** 2 + t[3] ** 2), t[1] - t[2]], 2) == []
    assert plainly_positive(ring, 1 + t[1] ** 2 * t[2] ** 2)
    assert not plainly_positive(ring, t[1] ** 2 + t[2] ** 2)


def test_a_set_satisfies_conditions_without_lying_inside(ring: Ring) -> None:
    t = ring.t
    a, b = t[1] + 2 * t[2] + 3, t[2] * t[1] + 7
    other = (t[4] + 2) * a * t[3] + t[1] * b - b - a
    found = factor_on_stratum(ring, [a * t[3] + b, other], 2)
    both = next(piece for piece in found if piece.half_vanishes(a) and piece.half_vanishes(b))
    main = next(piece for piece in found if not piece.half_vanishes(a))
    main = replace(main, equations=(a * t[3] + b, other))
    assert both.satisfies(main), "A = B = 0 satisfies whatever is a combination of A and B"
    assert not both.lies_inside(main)
    assert len(independent([main, both])) == 2
    assert main.lies_inside(main)


def test_a_limit_on_work_ends_it(ring: Ring) -> None:
    work = Work(1.0)
    tick(1.1e6)
    with pytest.raises(OutOfTime, match="limit on work"):
        decompose(ring, {}, [ring.form(ring.t[1] + ring.t[2])], 1, work)


def test_a_condition_in_one_variable_without_a_real_root_ends_a_system(ring: Ring) -> None:
    x, y = ring.t[1], ring.t[2]
    never = x**4 + x + 1  # at least 0.52
    assert not plainly_positive(ring, never)
    assert without_real_root(never)
    assert not without_real_root(x**4 + x - 1)
    assert not without_real_root(x**4 + x * y + 1)
    assert factor_on_stratum(ring, [never, y**4 - y - 3], 2) == []
    (found,) = factor_on_stratum(ring, [x**4 + x - 1, y**4 - y - 3], 2)
    assert found.samples


def test_conditions_on_two_variables_have_no_real_zero_where_a_resultant_has_none(ring: Ring) -> None:
    """An ellipse, and others that meet it in complex points alone, or in real ones."""
    x, y, z = ring.t[1], ring.t[2], ring.t[3]
    ellipse, empty, other = x**2 + x * y + y**2 - 3, x**2 - x * y + 2 * y**2 + 4, x**2 - x * y + 2 * y**2 - 4
    system = [ellipse, empty, x * ellipse + (y + 1) * empty]
    assert without_real_zero(ring, system)
    work = Work()
    assert steps._several(ring, {}, system, 2, work) == []
    assert not work.unresolved
    assert not without_real_zero(ring, [ellipse, other, x * ellipse + (y + 1) * other])
    assert not without_real_zero(ring, [ellipse, empty + z])
    assert not without_real_zero(ring, [ellipse, ellipse * empty])  # no two of them without a common factor


def test_what_two_conditions_have_no_point_of_is_left_over_at_once(
    ring: Ring, monkeypatch: pytest.MonkeyPatch
) -> None:
    """√n is real, and a number modulo no prime: the zeros of all are among those of any two conditions."""
    number = prod(PRIMES) - 1
    x, y = ring.t[1], ring.t[2]
    f, g = x**2 - number, y**2 - number
    looked = []

    class Recorded(ZeroSet):
        @property
        def samples(self):
            looked.append(self.rest)
            return []

    monkeypatch.setattr(steps, "ZeroSet", Recorded)
    work = Work()
    assert steps._several(ring, {}, [f, g, x * y * (x + y) - 2 * number * x], 2, work) == []
    assert len(looked) == 1
    assert len(work.unresolved) == 1
