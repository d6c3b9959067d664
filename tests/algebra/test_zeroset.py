"""Planted components are found, and what is found satisfies the conditions."""

from __future__ import annotations

import random
from dataclasses import replace
from math import prod

import pytest

pytest.importorskip("flint")

from rankdrop.algebra import decompose as steps
from rankdrop.algebra.decompose import cut, cut_half, decompose
from rankdrop.algebra.field import PRIMES, ModularPoint, half_angle_value, value_at
from rankdrop.algebra.polynomial import variables_in
from rankdrop.algebra.ring import Form, Ring
from rankdrop.algebra.solving import (
    Solved,
    plainly_positive,
    substitute_into_form,
    without_real_root,
    without_real_zero,
)
from rankdrop.algebra.work import OutOfTime, Work, tick
from rankdrop.algebra.zeroset import ZeroSet, independent


@pytest.fixture(scope="module")
def ring() -> Ring:
    return Ring([1, 2, 3, 4])


def factor_on_stratum(ring: Ring, polynomials, most: int) -> list[ZeroSet]:
    return decompose(ring, {}, [ring.form(f) for f in polynomials], most, Work())


def is_there(ring: Ring, found: list[ZeroSet], pins: dict[int, str], *conditions) -> bool:
    """Whether exactly this set is among those found: each holds the conditions of the other."""
    codimension = len(pins) + len(conditions)
    for one in found:
        there = one.codimension == codimension and all(one.stands(j, value) for j, value in pins.items())
        if there and all(one.half_vanishes(f) for f in conditions):
            return True
    return False


def random_plane(ring: Ring, rng: random.Random, joints):
    return sum((rng.randint(1, 9) * ring.t[j] for j in joints), ring.half.constant(rng.randint(1, 9)))


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


def test_one_condition_cut_by_another_loses_one_dimension_each_time(ring: Ring) -> None:
    rng, work = random.Random(3), Work()
    for _ in range(4):
        one = ZeroSet.whole(ring)
        conditions = [random_plane(ring, rng, (1, 2, 3)) + ring.t[2] * ring.t[3], random_plane(ring, rng, (2, 3, 4))]
        for depth, f in enumerate(conditions, 1):
            parts = cut_half(one, f, work)
            assert parts
            assert {part.codimension for part in parts} == {depth}
            assert all(part.half_vanishes(f) for part in parts)
            one = max(parts, key=lambda part: len(part.equations))
        assert cut_half(one, conditions[0], work)[0] is one


def test_a_trigonometric_condition_has_its_angles(ring: Ring) -> None:
    found = cut(ZeroSet.whole(ring), ring.s[1] * (ring.c[2] + 1), Work())
    assert {tuple(piece.pins.items()) for piece in found} == {((1, "0"),), ((1, "pi"),), ((2, "pi"),)}


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


def test_random_points_lie_on_their_set_and_a_sum_of_squares_has_its_points_too(ring: Ring) -> None:
    f = ring.t[1] ** 2 + ring.t[2] ** 2 - ring.t[3] ** 3 * ring.t[4] - 2
    piece = ZeroSet(ring, {}, rest=(f,), equations=(f,))
    points = piece.points(random.Random(1), 20)
    assert len(points) == 20
    assert all(value_at(ring, f, point) == 0 for point in points)


def test_a_limit_on_work_ends_it(ring: Ring) -> None:
    work = Work(1.0)
    tick(1.1e6)
    with pytest.raises(OutOfTime, match="limit on work"):
        decompose(ring, {}, [ring.form(ring.t[1] + ring.t[2])], 1, work)


def test_a_set_cut_where_its_solution_has_no_denominator_keeps_both_components(ring: Ring) -> None:
    t = ring.t
    a, b = t[1] + 2 * t[2] + 3, t[2] * t[1] + 7
    one = ZeroSet(ring, {}, solved=(Solved(ring.index["t3"], -b, a),), equations=(a * t[3] + b,))
    parts = cut_half(one, a, Work())
    assert is_there(ring, parts, {}, a, b), "A = B = 0 with t3 free"
    assert is_there(ring, parts, {3: "pi"}, a), "A = 0 with θ3 = π"


def test_a_condition_that_was_solved_with_is_still_known_where_the_solution_does_not_exist() -> None:
    """t5 = √2 put into t6 (t4² − 1) + t4 t5 (t6² − 1) = 0, which is solved for t5: at t4 = t6 = 0 it says nothing."""
    ring = Ring([4, 5, 6])
    t4, t5, t6 = (ring.t[j] for j in (4, 5, 6))
    system = [ring.form(f) for f in (t5**2 - 2, t6 * (t4**2 - 1) + t4 * t5 * (t6**2 - 1))]
    (curve,) = decompose(ring, {}, system, 2, Work())
    met = {(piece.pins[4], piece.pins[6], str(piece.equations)) for piece in cut(curve, ring.s[4] * ring.s[6], Work())}
    wanted = str((t5**2 - 2,))
    assert met == {(one, two, wanted) for one in ("0", "pi") for two in ("0", "pi")}


def test_a_set_keeps_the_condition_that_cut_it_where_its_solution_has_no_denominator(ring: Ring) -> None:
    """At A = B = 0 the equations A t3 + B = 0 and B + 5 A = 0 say nothing of t3: only t3 = 5, the first cut does."""
    t = ring.t
    a, b = t[1] ** 2 + 2 * t[2] ** 2 + 3 * t[1] * t[2] - 7, t[2] ** 2 * t[1] ** 2 + 7 * t[1] - 5
    (solved,) = factor_on_stratum(ring, [a * t[3] + b], 1)
    (plane,) = cut_half(solved, t[3] - 5, Work())
    assert not plane.half_vanishes(a)
    (found,) = cut_half(plane, a * (t[4] ** 2 + 2 * t[4] + 3) + (t[3] - 5) * t[2], Work())
    assert found.codimension == 3
    assert all(found.half_vanishes(f) for f in (a, b, t[3] - 5))


def test_a_condition_on_a_variable_of_its_own_is_put_on_top_of_two_unsolved_ones(ring: Ring) -> None:
    """Three unsolved conditions: points solve one after the other, and where a coefficient vanishes is a set, too."""
    t = ring.t
    f, g = t[1] ** 2 + t[2] ** 2 - 7, t[1] ** 2 * t[2] ** 2 - 2 * t[1] - 5
    base = ZeroSet(ring, {}, rest=(f, g), equations=(f, g))
    h = t[1] * t[3] ** 2 - t[2] * t[3] - 3
    (one,) = cut_half(base, h, Work())
    assert one.rest == (f, g, h)
    assert one.codimension == 3
    assert len(one.samples) > 10
    assert all(value_at(ring, p, point) == 0 for p in (f, g, h) for point in one.samples)
    point = one.point(random.Random(0))
    assert point is not None
    assert all(value_at(ring, p, point) == 0 for p in (f, g, h))
    (linear,) = cut_half(base, t[1] * t[4] - t[2] - 1, Work())
    assert (linear.rest, len(linear.solved)) == ((f, g), 1)
    assert all(value_at(ring, t[1] * t[4] - t[2] - 1, point) == 0 for point in linear.samples)
    (both,) = cut_half(one, t[4] ** 2 * t[3] - t[1] - 1, Work())
    assert len(both.rest) == 4
    assert both.samples


def test_where_a_condition_on_top_always_holds_its_variable_is_free(ring: Ring) -> None:
    """On t1² + t2² = 7 the condition (t4² + t2² − 7) t3² + t4 − t1 = 0 holds for every t3 where t4 = t1."""
    t = ring.t
    f, g = t[1] ** 2 + t[2] ** 2 - 7, t[1] ** 2 * t[2] ** 2 - 2 * t[1] - 5
    base = ZeroSet(ring, {}, rest=(f, g), equations=(f, g))
    found = cut_half(base, (t[4] ** 2 + t[2] ** 2 - 7) * t[3] ** 2 + t[4] - t[1], Work())
    assert {one.codimension for one in found} == {3}
    assert [one.half_vanishes(t[4] - t[1]) for one in found].count(True) == 1
    assert any(not one.half_vanishes(t[4] - t[1]) for one in found)


def test_a_condition_on_top_is_free_where_a_joint_of_its_coefficients_stands_at_pi(ring: Ring) -> None:
    """Frankie: on A(θ1, θ2) = 0 the condition sin θ2 (…) + t3 (…) holds for every θ3 where θ2 = 0, and where θ2 = π.

    The coefficient of t3 is of a lower degree in t2 than the condition: it vanishes at t2 = ∞ as well.
    """
    t = ring.t
    f = 165 * (t[1] ** 2 * t[2] ** 2 + t[1] ** 2 - t[2] ** 2 - 1) + 1264 * (t[1] * t[2] ** 2 - t[1])
    g = 7 * t[1] ** 2 * t[4] ** 2 - 3 * t[4] + t[1] + 5
    base = ZeroSet(ring, {}, rest=(f, g), equations=(f, g))
    # cos θ3 · (A at θ2 + …) and sin θ3 sin θ2: zero for every θ3 at θ2 = 0 and at θ2 = π
    h = (t[3] ** 2 - 1) * (165 * (t[1] ** 2 * t[2] ** 2 - t[1] ** 2 - t[2] ** 2 + 1)
                           + 1264 * (t[1] * t[2] ** 2 + t[1])) + 660 * t[3] * t[2] * (t[1] ** 2 + 1)  # fmt: skip
    found = cut_half(base, h, Work())
    assert {one.pins.get(2) for one in found} == {"0", "pi", None}


def test_what_is_known_of_a_set_speaks_of_its_free_joints_alone() -> None:
    """Cobotta: a condition kept in mind, with a joint in it that the set pins, bound that joint once more in a cut."""
    ring = Ring([1, 2, 3, 5], [], ["a2", "a3", "d4"])
    t, a2, a3, d4 = ring.t, *(ring.letter_half[name] for name in ("a2", "a3", "d4"))
    f = t[3] ** 2 * a3 + 2 * t[3] * d4 - a3
    g = t[2] ** 2 * f - 2 * t[2] * (t[3] ** 2 * (a2 - d4) + 2 * t[3] * a3 + a2 + d4) - f
    sets = decompose(ring, {}, [ring.form(h) for h in (f, g)], 2, Work())
    assert {one.pins.get(2) for one in sets} == {"0", "pi"}
    assert any(one.known for one in sets)
    for one in sets:
        assert not any(ring.index["t2"] in variables_in(h) for h in (*one.equations, *one.known))
        assert cut(one, ring.s[3] * ring.c[5] + ring.c[3] * ring.s[5], Work())


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


def test_a_condition_over_roots_is_real_where_one_of_its_conjugates_is() -> None:
    """t² − 2√2 t + 3 has the discriminant −4, t² − √2 is real, and its conjugate is not."""
    ring = Ring([1], letters=["sqrt2"])
    x, root = ring.half.gens()
    assert without_real_root(x**2 - 2 * root * x + 3)
    assert not without_real_root(x**2 - root)


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


def test_a_highest_coefficient_at_pi_is_made_once(ring: Ring, monkeypatch: pytest.MonkeyPatch) -> None:
    t1, t2 = ring.t[1], ring.t[2]
    f, other = (t2**2 + 3) * t1**2 + t1 * t2 + 5, (t2 - 4) * t1 + 1
    made = []
    monkeypatch.setattr(Form, "at", lambda form, pins, at=Form.at: made.append(pins) or at(form, pins))
    points = [ModularPoint({"t2": x}, PRIMES[0]) for x in (2, 4, 7)]
    assert [half_angle_value(ring, f, point) for point in points] == [7, 19, 52]
    assert [half_angle_value(ring, other, point) for point in points] == [PRIMES[0] - 2, 0, 3]
    assert made == [{1: "pi"}, {1: "pi"}]
