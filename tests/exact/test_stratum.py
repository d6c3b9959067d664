"""Strata: points obey their conditions, pieces fall apart at pinned joints, nothing is lost on the way."""

import random

import pytest

pytest.importorskip("flint")

from rankdrop.algebra.field import ModularPoint, P, holds, value_at
from rankdrop.algebra.polynomial import Equality
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.stratum import Stratum, atoms_on, vanishes


@pytest.fixture
def ring():
    return Ring([1, 2, 3], prismatic=[4], letters=["a", "b"])


def conditions(ring):
    s, c, q, a, b = ring.s, ring.c, ring.q[4], ring.letter["a"], ring.letter["b"]
    c12 = c[1] * c[2] - s[1] * s[2]
    return [s[1], c[3], 1 - c[2], a * c12 + b * c[3], q - a * s[3], s[1] * c[2] + s[3], a * s[2] - b * c[2]]


def test_points_obey_every_condition(ring):
    rng = random.Random(1)
    seen = 0
    for p in conditions(ring):
        for r in conditions(ring):
            stratum = Stratum.whole(ring).meet(Equality((), p))
            if r is p or any(vanishes(piece, r, rng) for piece in stratum.pieces):
                continue
            for piece in stratum.avoid(Equality((), r)).pieces:
                point = piece.point(rng)
                assert point is not None
                assert value_at(ring, p, point) == 0
                assert value_at(ring, r, point) != 0
                seen += 1
    assert seen > 30


def test_two_conditions_hold_together(ring):
    rng, seen = random.Random(2), 0
    for p in conditions(ring):
        for r in conditions(ring):
            for piece in Stratum.whole(ring).meet(Equality((), p)).meet(Equality((), r)).pieces:
                point = piece.point(rng)
                if point is not None:
                    seen += 1
                    assert value_at(ring, p, point) == value_at(ring, r, point) == 0
    assert seen > 40


def test_a_condition_falls_apart_at_a_pinned_joint(ring):
    """Nothing is lost on the way, zeros at θ = π included."""
    s, c = ring.s, ring.c
    p = (1 + c[1]) * (s[2] + s[3]) + s[1] * s[2] * (1 + c[3])  # at θ1 = π: everything; at θ1 = 0: s2 + s3 = 0
    pieces = Stratum.whole(ring).meet(Equality((), p)).meet(Equality((), s[1])).pieces
    told = {(tuple(sorted(piece.pins.items())), tuple(map(str, piece.equations))) for piece in pieces}
    assert told == {(((1, "pi"),), ()), (((1, "0"),), ("t2 + t3",)), (((1, "0"),), ("t2*t3 + 1",))}


def test_an_excluded_condition_empties_a_stratum(ring):
    condition = Equality((), conditions(ring)[3])
    assert not Stratum.whole(ring).avoid(condition).meet(condition).pieces
    assert not Stratum.whole(ring).meet(condition).avoid(condition).pieces


def test_siblings_are_told_apart(ring):
    one, two = (Equality((), p) for p in conditions(ring)[:2])
    whole = Stratum.whole(ring)
    left, right = whole.meet(one), whole.avoid(one).meet(two)
    assert left.separating_polynomial(right) == right.separating_polynomial(left) == one.whole
    assert left.separating_polynomial(whole) is None


def test_what_lengths_alone_decide_is_put_into_other_conditions(ring):
    a, b = ring.letter["a"], ring.letter["b"]
    wanted = a * ring.s[2] - b * (1 + ring.c[2])  # tan(θ2/2) = b/a, or θ2 = π
    pieces = Stratum.whole(ring).meet(Equality((), wanted)).pieces
    assert sorted(len(piece.solved) for piece in pieces) == [0, 1]
    (solved,) = [piece for piece in pieces if piece.solved]
    follows = (a**2 - b**2) * ring.s[2] - 2 * a * b * ring.c[2]
    assert vanishes(solved, follows, random.Random(0))
    other = atoms_on(solved, Equality((), ring.s[1] * ring.s[2] + ring.c[1] * ring.c[2]))
    assert other
    assert all(atom.joint != 2 for atom in other), "θ2 is where lengths put it, not at π"


def test_two_values_of_one_joint_contradict_each_other_and_the_lengths_are_noted(ring):
    a, b = ring.letter["a"], ring.letter["b"]
    assumed = {}
    stratum = Stratum.whole(ring, assumed)
    for ratio in (a, b):
        stratum = stratum.meet(Equality((), ring.s[2] - ratio * ring.c[2])).avoid(Equality((), 1 + ring.c[2]))
    assert not stratum.pieces
    assert "a - b" in assumed


def test_the_closed_conditions_hold_nothing_that_follows(ring):
    s, c = ring.s, ring.c
    stratum = Stratum.whole(ring).meet(Equality((), s[1] * s[3] + c[2])).meet(Equality((), s[1]))
    assert [str(p) for p in stratum.equations_with_pins] == ["s1", "c2"]


def test_a_piece_knows_what_is_positive(ring):
    f = ring.letter_half["a"] ** 2 * ring.t[1] ** 2 + ring.letter_half["b"] ** 2
    assert atoms_on(ZeroSet.whole(ring), Equality((ring.atom(f),))) == ()
    assert value_at(ring, f, ModularPoint(dict.fromkeys(ring.names, 2))) % P


def test_points_of_a_set_are_where_its_inequations_hold(ring):
    t, rng = ring.t, random.Random(3)
    one, other = ring.atom(t[1] - t[2]), ring.atom(t[1] - 3 * t[2])
    piece = ZeroSet(ring, {}, rest=(one.f * other.f,)).remove_zeros(one)
    points = piece.points(rng, 10)
    assert len(points) == 10
    assert not any(holds(ring, one, point) for point in points)
    assert all(holds(ring, other, point) for point in points)


def test_a_set_is_not_inside_one_that_leaves_it_out(ring):
    there = ZeroSet(ring, {1: "0"})
    assert there.lies_inside(ZeroSet.whole(ring))
    assert not there.lies_inside(ZeroSet.whole(ring).remove_zeros(ring.pin(1, "0")))
