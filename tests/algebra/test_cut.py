"""Sets cut by one more condition: components of one dimension less, and what is known of them."""

from __future__ import annotations

import random

import pytest
from algebra.planted_sets import factor_on_stratum, is_there, random_plane

from rankdrop.algebra.cut import cut, cut_half
from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.field import value_at
from rankdrop.algebra.polynomial import variables_in
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.solving import Solved
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet


@pytest.fixture(scope="module")
def ring() -> Ring:
    return Ring([1, 2, 3, 4])


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
