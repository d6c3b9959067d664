"""Every way of writing a half-angle polynomial is equal to it, and the short one is short."""

from __future__ import annotations

import random
from fractions import Fraction

import pytest

from rankdrop.algebra.ring import Form, Ring
from rankdrop.formula.notation import Text
from rankdrop.formula.shortest import factor_out, length, shortest
from rankdrop.formula.sums import Product, Sum, Symbol, Wave, fourier, half_of, product, total, wave


def same(form, f, ring) -> bool:
    """Whether a form is f over Π (1 + t²)^(D/2), D the degrees of f, without rounding."""
    half = half_of(form, ring)
    back, degrees = half.f, half.degrees
    for j, have, own in zip(ring.revolute, degrees, f.degrees(), strict=False):
        assert (have - own) % 2 == 0
        assert have >= own
        f = f * (1 + ring.t[j] ** 2) ** ((have - int(own)) // 2)
    return back == f


def random_polynomial(ring, rng, terms, most):
    f = ring.half.constant(0)
    for _ in range(terms):
        powers = tuple(rng.randint(0, most) for _ in range(ring.angles)) + tuple(
            rng.randint(0, 1) for _ in range(len(ring.names) - ring.angles)
        )
        f += ring.half.from_dict({powers: rng.randint(-9, 9) or 1})
    return f


@pytest.mark.spread(3)
@pytest.mark.by_hand_at("8")
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_every_form_of_a_random_polynomial_is_equal_to_it(seed):
    rng = random.Random(seed)
    ring = Ring([1, 2, 11], [4], ["a", "b"])
    f = random_polynomial(ring, rng, 5, 1 + seed % 3)
    plain = fourier(ring.form(f))
    assert same(plain, f, ring)
    assert same(factor_out(plain), f, ring)
    short = shortest(f, ring)
    assert same(short, f, ring)
    assert length(short) <= length(plain)


def test_higher_degrees_than_the_polynomial_has_stand_for_zeros_at_pi():
    ring = Ring([1])
    form = fourier(Form(ring, ring.half.constant(1), (2,)))  # cos²(θ/2)
    assert Text().zero(form) == "c1 + 1"
    assert form.number == Fraction(1, 2)


def kg_eq15(ring, c4):
    """KG eq. 15 with s4 = 0 and c4 = ±1, as printed."""
    s, c = ring.s, ring.c
    a, cc, d = (ring.letter[name] for name in "acd")
    s35, c35 = s[3] * c[5] + c[3] * s[5], c[3] * c[5] - s[3] * s[5]
    first = -c[2] * s[6] * a * c[3] + 2 * cc * s[2] * s[3] * s[6] + s[2] * c35 * a * c[5] * c[6]
    second = a * s35 * c4 + d * c[3] * c4 + d * c[3]
    third = s[2] * (-a * c35 * c4 + d * s[3] * c4 + d * s[3] - a)
    return ring.reduce(first * second + third * (-2 * cc * c[3] * s[6] + a * s35 * c[5] * c[6]))


@pytest.mark.slow
def test_kg_eq_15_is_shorter_than_its_two_printed_products():
    ring = Ring([2, 3, 4, 5, 6], letters=["a", "c", "d"])
    (atom, power), = ring.factor(kg_eq15(ring, 1)).atoms
    short = shortest(atom.f, ring)
    assert power == 1
    assert same(short, atom.f, ring)
    printed = "(−c2 s6 a c3 + 2 c s2 s3 s6 + s2 c35 a c5 c6)(a s35 + 2 d c3) + s2 (−a c35 + 2 d s3 − a)"
    assert 0 < len(Text().zero(short)) < len(printed)
    assert Text().zero(short).count("(") <= 4


def test_kg_eq_15_at_pi_splits_off_a_plain_relation():
    ring = Ring([2, 3, 4, 5, 6], letters=["a", "c", "d"])
    texts = sorted(Text().zero(shortest(atom.f, ring)) for atom, _ in ring.factor(kg_eq15(ring, -1)).atoms)
    assert len(texts) == 2
    assert texts[1] == "sin((θ3 + θ5)/2)"
    assert "cos((θ3 + θ5)/2)" in texts[0]


def test_common_factors_go_before_brackets():
    ring = Ring([3, 4], letters=["a", "b"])
    a, b = ring.letter["a"], ring.letter["b"]
    f = ring.to_half(a * a * ring.s[4] - a * b * ring.c[4] - 2 * b * b * ring.s[4] + ring.s[3] * b * ring.c[4]).f
    assert same(shortest(f, ring), f, ring)
    assert length(shortest(f, ring)) < length(fourier(ring.form(f)))


def test_sums_are_primitive_with_the_first_sign_positive():
    one = total([Product(Fraction(-2, 3), ((Symbol("a"), 1),)), Product(Fraction(4, 9), ((Symbol("b"), 1),))])
    assert one.number == Fraction(-2, 9)
    assert [part.number for part in one.factors[0][0].parts] == [3, -2]
    assert total([]).number == 0


def test_sums_of_one_part_are_opened():
    inner = Sum((Product(Fraction(3), ((Symbol("a"), 1), (Wave("sin", ((1, 2),)), 2))),))
    opened = product(2, [(inner, 2), (Symbol("a"), 1)])
    assert opened == Product(Fraction(18), ((Symbol("a"), 3), (Wave("sin", ((1, 2),)), 4)))


def test_waves_start_with_a_positive_multiple():
    assert wave("sin", {2: -2, 5: 1}) == (-1, Wave("sin", ((2, 2), (5, -1))))
    assert wave("cos", {2: -2}) == (1, Wave("cos", ((2, 2),)))
    assert wave("sin", {2: 0}) == (0, None)
    assert wave("cos", {}) == (1, None)


def test_whole_and_half_angles_do_not_add_up():
    ring = Ring([1])
    mixed = total([Product(Fraction(1), ((Wave("sin", ((1, 1),)), 1),)), Product(Fraction(1))])
    with pytest.raises(ValueError, match="θ1/2"):
        half_of(mixed, ring)
