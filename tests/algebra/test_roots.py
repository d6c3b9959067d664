"""Twists of 15° and 18° and their multiples are exact: roots of numbers as variables, and what is rounded is said."""

from __future__ import annotations

import random
from fractions import Fraction
from math import cos, pi, prod, radians, sin
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rankdrop.algebra import factoring, field
from rankdrop.algebra.factoring import factor
from rankdrop.algebra.field import Point, roots_at, value_at
from rankdrop.algebra.gcd import _Images, gcd, image_modulo, quotient
from rankdrop.algebra.polynomial import Equality, flint, is_number, norm, primitive, reciprocal, reduced_roots
from rankdrop.algebra.ring import Ring, numeric_terms
from rankdrop.algebra.roots import ROOTS, embeddings, primes_with, root_values, roots_of, sums_over_roots, surd
from rankdrop.algebra.solving import Solved
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.arm.geometry import exact_cosine, turn
from rankdrop.exact.stratum import atoms_on
from rankdrop.families.record import exact_of
from rankdrop.formula.writing import Condition
from rankdrop.kinematics import jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.verbs.conditions import conditions

RING = Ring([1, 2], letters=["a", *ROOTS])


def b44(twist: float = pi / 4):
    """Six joints, four twists of 45°, modified convention."""
    rows = [(0.25, twist, 0.25), (0.0, 0.0, 0.0), (0.25, twist, 0.0), (0.0, twist, 0.0), (0.0, twist, 0.25),
            (0.0, pi / 2, 0.0)]  # fmt: skip
    return from_dh([{"a": a, "alpha": alpha, "d": d} for a, alpha, d in rows], convention="modified", name="b44")


@pytest.mark.slow
def test_the_family_at_45_degrees_is_found() -> None:
    """Known answer: at θ3 = −90°, θ4 = 0, θ5 = 45° the rank is 3 or less (σ4 = 9.8e-52 in 60 digits)."""
    q = np.radians([0.0, 0.0, -90.0, 0.0, 45.0, 0.0])
    assert np.linalg.svd(jacobian(b44(), q), compute_uv=False)[3] < 1e-15
    found = conditions(b44(), method="tree", points=0)
    (family,) = [one for one in found.of_corank(2) if all(abs(f(q[None])) < 1e-12 for f in one.equations)]
    assert (family.dimension, exact_of(family).rank_check.holds) == (3, True)
    assert found.verdict.claims == ("derived exactly",)


def test_a_rounded_twist_is_not_called_exact() -> None:
    """A twist of 44.9° has no short algebraic form: the verdict says which number was rounded, and by how much."""
    found = conditions(b44(radians(44.9)), method="tree", points=0, coranks=1)
    assert found.verdict.claims == ()
    assert "44.9° is rounded by" in found.verdict.sentence
    assert "exactly" not in found.verdict.sentence
    assert {one.kind for one in found.chain.effective_roundings} == {"twist"}
    assert all(0 < abs(one.miss) < 1e-11 for one in found.chain.effective_roundings)


def test_a_length_that_is_no_decimal_is_rounded_unless_it_is_a_letter() -> None:
    rows = [{"a": 0.1 * 2**0.5, "alpha": 0.0, "d": 0.0}, {"a": 0.2, "alpha": 0.0, "d": 0.0},
            {"a": 0.0, "alpha": 0.0, "d": 0.0}]  # fmt: skip
    arm = from_dh(rows, convention="standard")
    assert [one.kind for one in exact_chain(arm, "vx,vy,wz", lengths="numbers").effective_roundings] == ["a"]
    assert exact_chain(arm, "vx,vy,wz", lengths="letters").effective_roundings == ()


@pytest.mark.parametrize("angle", [*range(-180, 181, 15), *range(-180, 181, 18)])
def test_multiples_of_15_and_18_degrees_are_exact(angle: int) -> None:
    found = turn(radians(angle))
    assert float(found.cos) == pytest.approx(cos(radians(angle)), abs=1e-15)
    assert float(found.sin) == pytest.approx(sin(radians(angle)), abs=1e-15)
    assert abs(found.error) < 1e-14
    circle = RING.reduce(RING.constant(found.cos) ** 2 + RING.constant(found.sin) ** 2)
    assert circle == 1
    assert float(exact_cosine(cos(radians(angle)))) == pytest.approx(cos(radians(angle)), abs=1e-15)


def test_other_angles_are_rational() -> None:
    assert roots_of([turn(0.3).cos, turn(0.3).sin]) == []
    assert 0 < abs(turn(0.3).error) < 1e-11


def test_a_ring_has_the_roots_in_the_squares_of_its_roots() -> None:
    assert Ring([1], letters=["b", "cos18"]).letters == ("b", "cos18", "sqrt5")


def numbers():
    return st.lists(st.integers(-3, 3), min_size=4, max_size=4).filter(any)


def number_of(values):
    h = RING.letter_half
    return sum(v * w for v, w in zip(values, [1, h["sqrt2"], h["sqrt3"], h["sqrt2"] * h["sqrt3"]], strict=True))


@given(numbers())
@settings(deadline=None, max_examples=30)
def test_a_number_times_its_reciprocal_is_1(values) -> None:
    x = RING.half.constant(0) + number_of(values)
    assert reduced_roots(x * reciprocal(x)) == 1
    assert norm(x)[0].is_constant()


@pytest.mark.slow
@given(st.lists(st.tuples(numbers(), numbers(), numbers()), min_size=1, max_size=3))
@settings(deadline=None, max_examples=25)
def test_factors_multiply_to_the_polynomial(parts) -> None:
    x, y, a = RING.t[1], RING.t[2], RING.letter_half["a"]
    f = prod((x * number_of(u) + a * y * number_of(v) + number_of(w) for u, v, w in parts), start=RING.half.constant(1))
    f = reduced_roots(f)
    whole = prod((one**power for one, power in factor(f)), start=RING.half.constant(1))
    left = quotient(f, reduced_roots(whole))
    assert left is not None
    assert is_number(left)
    assert sum(power for _, power in factor(f)) == len(parts)


@pytest.mark.parametrize(
    ("text", "count"),
    [("x**2 - 2", 2), ("x**2 - 7", 1), ("8*x**2 - 5 - sqrt5", 2), ("x**2 - 3*a**2", 2), ("x**2 + 2*y**2", 1),
     ("x**4 - 10*x**2 + 1", 4), ("(x - sqrt2)**2 * (x + sqrt2)", 2), ("x**2 - sqrt2*sqrt3", 1),
     ("x*y + sqrt2*x + sqrt3*y + sqrt2*sqrt3", 2), ("(x**2 + y**2 + sqrt2)**2", 1)],
)  # fmt: skip
def test_known_factors(text: str, count: int) -> None:
    names = {"x": RING.t[1], "y": RING.t[2], "a": RING.letter_half["a"], **{w: RING.letter_half[w] for w in ROOTS}}
    assert len(factor(reduced_roots(eval(text, {}, names)))) == count


def test_multiplicities_are_those_of_the_product() -> None:
    x, y, h = RING.t[1], RING.t[2], RING.letter_half
    f = (x * y + h["sqrt2"]) ** 3 * (x - h["sqrt3"] * y) ** 2 * (x + y + 1)
    assert sorted(power for _, power in factor(reduced_roots(f))) == [1, 2, 3]


@pytest.mark.parametrize("power", [8, 30, 120])
def test_coefficients_over_roots_keep_their_digits(power: int) -> None:
    """(2 − √3)^k = a − b √3 is 0.268^k with a and b some 3.7^k; in floats nothing is left of it at k = 30."""
    x, h = RING.t[1], RING.letter_half
    f = reduced_roots((2 - h["sqrt3"]) ** power * x - 3)
    numbers = {"a": 1.0, **root_values(ROOTS)}
    found = {powers[0]: number for number, powers in numeric_terms(f, numbers, unit=flint().fmpq(1))}
    assert found[0] == -3.0
    assert found[1] == pytest.approx((2 + np.sqrt(3)) ** -power, rel=1e-13)
    terms = [("none", Fraction(3), (("sqrt3", 0),)), ("none", Fraction(-1), (("sqrt3", 2),))]
    assert sums_over_roots(terms) == {"none": 0}
    equation = Condition(RING, f).equation({}, 2)
    angle = 2 * np.arctan(3 * (2 + np.sqrt(3)) ** power)
    assert abs(equation(np.array([[angle, 0.3]]))[0]) < 1e-12


def test_zero_in_the_disguise_of_a_root_is_not_factored_for_ever() -> None:
    """(√3² − 3)(x² − 1)(y² − 1): every factor divides it again and again."""
    x, y, h = RING.t[1], RING.t[2], RING.letter_half
    with pytest.raises(ArithmeticError, match="zero"):
        factor((h["sqrt3"] ** 2 - 3) * (x**2 - 1) * (y**2 - 1))


def test_a_solution_with_a_root_put_in_is_reduced() -> None:
    """t1 = √3 makes t1² − 3 zero, and (t1² − 3) t2 + t2 − 5 a condition on θ2 alone."""
    x, y, root = RING.t[1], RING.t[2], RING.letter_half["sqrt3"]
    piece = ZeroSet(RING, {}, solved=(Solved(0, root, root**0),), equations=(x - root,))
    assert atoms_on(piece, Equality((RING.atom((x**2 - 3) * (y**2 - 1)),))) is None
    (left,) = atoms_on(piece, Equality((RING.atom((x**2 - 3) * y + y - 5),)))
    assert str(left.f) == "t2 - 5"


def long_polynomial(seed: int, terms: int = 60):
    """A random polynomial over √2 and √3 in three variables, irreducible but for chance."""
    rng = random.Random(seed)
    x, y, a, h = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half
    roots = (1, h["sqrt2"], h["sqrt3"], h["sqrt2"] * h["sqrt3"])
    parts = (rng.randrange(1, 99) * rng.choice(roots) * x ** rng.randrange(4) * y ** rng.randrange(4)
             * a ** rng.randrange(3) for _ in range(terms))  # fmt: skip
    return 1 + sum(parts, RING.half.constant(0))


def test_slices_prove_a_long_polynomial_irreducible(monkeypatch: pytest.MonkeyPatch) -> None:
    """No norm is factored for it: that takes some twenty times as long."""
    monkeypatch.setattr(factoring, "_split", None)
    f = long_polynomial(1)
    assert factor(f) == [(primitive(f), 1)]


@pytest.mark.parametrize("place", range(4))
def test_slices_find_no_product_irreducible(place: int) -> None:
    """Not even one with a factor in a single variable, which is a number on every slice without that variable."""
    x, y, a, w = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half["sqrt2"]
    factors = (x + w, y - 3 * w, a**2 + w, x * y + a * w)
    f = reduced_roots(long_polynomial(2, 20) * factors[place])
    assert not factoring._slices_irreducible(f)
    assert len(factor(f)) == 2


def test_a_long_polynomial_without_roots_is_irreducible_on_slices_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """The factors of one minor of a general arm of seven joints take flint 11 s; of one that is alike 0.1 s."""
    calls: list[int] = []
    slices = factoring._slices_irreducible

    def counted(f: Any) -> bool:
        calls.append(len(f))
        return slices(f)

    monkeypatch.setattr(factoring, "_slices_irreducible", counted)
    x, y, a = RING.t[1], RING.t[2], RING.letter_half["a"]
    f = (x + 2 * y + 3 * a + 1) ** 15 + x * y + 7
    assert factor(f) == [(primitive(f), 1)]
    assert calls == [len(f)]
    g = f * (x * y + a + 5)
    assert {str(one) for one, _ in factor(g)} == {str(primitive(one)) for one in (f, x * y + a + 5)}


def test_a_factor_that_is_a_number_modulo_the_primes_is_no_number() -> None:
    """Its slices have lower degrees than it, and are not taken."""
    x, y, a, w = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half["sqrt2"]
    large = prod(factoring._SMALL)
    f = reduced_roots((x * y + a * w + 1) * (large * (x + y + a) + 1))
    assert not factoring._slices_irreducible(f)
    assert len(factor(f)) == 2


def test_variables_that_divide_a_polynomial_are_factors_and_roots_are_not() -> None:
    x, y, a, w = RING.t[1], RING.t[2], RING.letter_half["a"], RING.letter_half["sqrt2"]
    found = {str(one): power for one, power in factor(reduced_roots(w * a * x**3 * (x + w * y + 1)))}
    assert found == {str(a): 1, str(x): 3, str(primitive(x + w * y + 1)): 1}


def test_images_read_once_are_those_of_the_polynomial() -> None:
    f = long_polynomial(3) * flint().fmpq(2, 15)
    images = _Images(f)
    for prime in primes_with(ROOTS)[:2]:
        for roots in embeddings(ROOTS, prime):
            assert images.with_roots(roots, prime) == image_modulo(f, roots, prime)


def test_values_before_and_after_an_image_is_made_are_the_same() -> None:
    f = long_polynomial(4) * flint().fmpq(3, 7)
    for prime in primes_with(ROOTS)[:2]:
        point = Point({name: 5 + place for place, name in enumerate(RING.names)}, prime)
        point.update(roots_at(RING, prime))
        values = {value_at(RING, f, point) for _ in range(field._SEEN)}
        uses = RING.images[id(f), prime]
        assert isinstance(uses, field.Uses)
        assert uses.f is f  # an id is that of a polynomial that is kept
        image = image_modulo(f, point, prime)
        assert {*values, value_at(RING, f, point)} == {int(image(*[0] * len(RING.names)))}
        assert not isinstance(RING.images[id(f), prime], field.Uses)


def test_a_common_divisor_over_the_roots() -> None:
    x, w = RING.t[1], RING.letter_half["sqrt2"]
    assert gcd(x**2 - 2, reduced_roots((x - w) * (x + 3))) == primitive(x - w)
    assert is_number(gcd(x - w, x + w))


def test_a_polynomial_has_one_primitive_form() -> None:
    x, w = RING.t[1], RING.letter_half["sqrt2"]
    assert str(primitive(w * x - 2)) == str(primitive(x - w)) == str(primitive(reduced_roots((3 - w) * (x - w))))


def test_the_greatest_value_of_a_root_is_its_own() -> None:
    values = root_values(ROOTS)
    assert values == pytest.approx({"cos18": cos(pi / 10), "sqrt2": 2**0.5, "sqrt3": 3**0.5, "sqrt5": 5**0.5})
    assert float(surd(36)[0]) == pytest.approx(cos(pi / 5))


@pytest.mark.slow
def test_common_divisors_and_quotients_with_coefficients_of_thousands_of_bits() -> None:
    x, y, w = RING.t[1], RING.t[2], RING.letter_half["sqrt2"]
    long = x + (3**1500) * w * y + 7**1000
    f, g = reduced_roots(long * (x - w * y)), reduced_roots(long * (y + 3 * w))
    assert gcd(f, g) == primitive(long)
    assert quotient(f, primitive(long)) is not None
    assert quotient(f, x + y + w) is None


def test_factors_without_a_variable_are_split_off_and_counted() -> None:
    x, y, w = RING.t[1], RING.t[2], RING.letter_half["sqrt2"]
    whole = reduced_roots((x - w) ** 3 * (x * y + w * y + 1) * (y**2 + w))
    assert sorted(power for _, power in factor(whole)) == [1, 1, 3]


@pytest.mark.by_hand
def test_conditions_on_a_variable_each_are_no_system_left_over() -> None:
    """Half-angle tangents of three joints, roots of quadratics without a root modulo any of the primes."""
    table = [(0, 90, 0.2), (0.3, 30, 0.1), (0, 75, 0.42), (0, -15, 0), (0, 90, 0.1), (0.25, 0, 0)]
    rows = [(a, radians(twist), d, 0) for a, twist, d in table]
    found = conditions(from_dh(rows, convention="standard"), points=200)
    assert found.complete
    assert found.explained.agree == found.explained.tested
