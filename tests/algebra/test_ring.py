"""Both rings speak of the same functions, and what is factored is put together again."""

from __future__ import annotations

import random
from itertools import permutations

import pytest

pytest.importorskip("flint")

from rankdrop.algebra.field import ModularPoint, P, complete, modulo, value_at
from rankdrop.algebra.polynomial import COS_SIN, SIMPLE, flint, primitive
from rankdrop.algebra.ring import Form, Ring, polynomial_of
from rankdrop.algebra.solving import Solved, substitute_into_form
from rankdrop.algebra.work import work_spent


@pytest.fixture(scope="module")
def ring() -> Ring:
    return Ring([1, 2, 4], [3], ["a", "b"])


def random_point(ring: Ring, rng: random.Random, pins: dict[int, str] | None = None) -> dict[str, int]:
    point = complete(ring, ModularPoint({name: rng.randrange(2, P) for name in ring.names}), pins or {})
    assert point is not None
    return point


def random_polynomial(ring: Ring, rng: random.Random, terms: int = 5):
    generators = ring.trig.gens()
    total = ring.zero
    for _ in range(terms):
        term = ring.constant(rng.randint(-5, 5) or 1)
        for _ in range(rng.randint(0, 3)):
            term = term * rng.choice(generators)
        total = total + term
    return ring.reduce(total)


def scale(ring: Ring, degrees: tuple[int, ...], point: dict[str, int]) -> int:
    value = 1
    for j, power in zip(ring.revolute, degrees, strict=True):
        value = value * pow(1 + point[f"t{j}"] ** 2, power // 2, P) % P
    return value


def test_half_angle_form_is_the_function_times_its_denominators(ring: Ring) -> None:
    rng = random.Random(1)
    for _ in range(40):
        p = random_polynomial(ring, rng)
        form = ring.to_half(p)
        point = random_point(ring, rng)
        assert value_at(ring, form.f, point) == value_at(ring, p, point) * scale(ring, form.degrees, point) % P


def test_reduction_changes_no_value(ring: Ring) -> None:
    rng = random.Random(2)
    for _ in range(40):
        p = random_polynomial(ring, rng) * random_polynomial(ring, rng)
        point = random_point(ring, rng)
        assert value_at(ring, p, point) == value_at(ring, ring.reduce(p), point)


def test_factors_vanish_where_the_polynomial_does_and_nowhere_else(ring: Ring) -> None:
    rng = random.Random(3)
    seen_pins = set()
    for _ in range(30):
        s, c = ring.s, ring.c
        a, b = ring.letter["a"], ring.letter["b"]
        planted = [s[1], 1 + c[2], 1 - c[4], s[2] - 1, c[1] + c[2] * s[4] + a, ring.q[3] - b]
        chosen = rng.sample(planted, 3)
        p = ring.reduce(chosen[0] * chosen[1] * chosen[2])
        found = ring.factor(p)
        product = 1
        pins: dict[int, dict[str, int]] = {}
        point = random_point(ring, rng)
        for f, power in found.letters:
            product = product * pow(value_at(ring, f, point), power, P) % P
        for atom, power in found.atoms:
            if atom.is_pin:
                pins.setdefault(atom.joint, {})[atom.value] = power
                seen_pins.add(atom.value)
                root = {"0": 0, "pi/2": 1, "-pi/2": -1}.get(atom.value)
                value = 1 if root is None else point[f"t{atom.joint}"] - root
            else:
                value = value_at(ring, atom.f, point)
            product = product * pow(value, power, P) % P
        # what is left out is a number and a power of 1 + t², which has no real zero
        half = ring.to_half(p).f
        first = [half, *(f for f, _ in found.letters), *(atom.f for atom, _ in found.atoms if not atom.is_pin)]
        assert all(f.leading_coefficient() > 0 for f in first[1:])
        powers = [*(k for _, k in found.letters), *(k for atom, k in found.atoms if not atom.is_pin)]
        number = half.leading_coefficient()
        for f, power in zip(first[1:], powers, strict=True):
            number /= f.leading_coefficient() ** power
        product = product * modulo(number) % P
        left = value_at(ring, half, point) * pow(product, -1, P) % P
        units = {1}
        for j in ring.revolute:
            units |= {u * pow(1 + point[f"t{j}"] ** 2, k, P) % P for u in units for k in (1, 2, 3, 4)}
        assert left in units
        for joint, values in pins.items():
            for value in values:
                assert ring.at(p, {joint: value}) == 0
        assert len(found.atoms) >= 2
    assert seen_pins == {"0", "pi", "pi/2"}


def test_a_polynomial_comes_back_from_half_angles(ring: Ring) -> None:
    rng = random.Random(4)
    back = 0
    for _ in range(40):
        p = random_polynomial(ring, rng)
        if p == 0:
            continue
        form = ring.to_half(p)
        if form.at_pi:
            continue  # θ = π is a zero: half-angle polynomials do not show it
        assert ring.to_trig(form.f) in (primitive(p), -primitive(p))
        back += 1
    assert back > 10


def test_odd_half_angle_polynomials_have_a_square_with_their_zeros(ring: Ring) -> None:
    f = ring.t[1] + 2 * ring.t[2] - 1
    assert ring.to_trig(f) is None
    p = ring.trig_zero_set(f)
    rng = random.Random(5)
    point = random_point(ring, rng)
    assert value_at(ring, p, point) != 0
    point = complete(ring, point.replace_values({"t1": (1 - 2 * point["t2"]) % P}), {})
    assert point is not None
    assert value_at(ring, p, point) == 0


@pytest.mark.parametrize("pins", [{1: "pi", 2: "0"}, {1: "pi", 2: "pi", 4: "pi/2"}, {2: "-pi/2", 4: "pi", 1: "pi"}])
def test_pins_in_any_order_are_the_function_at_these_angles(ring: Ring, pins: dict[int, str]) -> None:
    rng = random.Random(6)
    for _ in range(30):
        p = random_polynomial(ring, rng, 7)
        form = ring.to_half(p)
        point = random_point(ring, rng, pins)
        assert len({str(form.at({j: pins[j] for j in order}).f) for order in permutations(pins)}) == 1
        value = value_at(ring, form.at(pins).f, point)
        expected = value_at(ring, p, point)
        for j, power in zip(ring.revolute, form.degrees, strict=True):
            if pins.get(j) != "pi":
                expected = expected * pow(1 + point[f"t{j}"] ** 2, power // 2, P) % P
            else:  # t^(2m) / (1 + t²)^m is 1 there
                expected = expected * pow(1, power)
        assert value == expected % P


def test_a_joint_at_pi_takes_the_degree_that_was_there_before_any_pin() -> None:
    ring = Ring([1, 2])
    form = ring.form(ring.t[1] * ring.t[2] - ring.t[2] ** 2 + 1)  # degree 2 in t2, and 1 in t1: at θ1 = π t2 is left
    assert form.at({1: "pi"}).f == ring.t[2]
    assert form.at({1: "pi", 2: "pi"}).f == 0
    assert form.at({2: "pi", 1: "pi"}).f == 0


def test_a_determinant_is_the_one_of_the_values(ring: Ring) -> None:
    rng = random.Random(7)
    for n in (1, 2, 3, 4):
        entries = [random_polynomial(ring, rng, 3) if rng.random() < 0.7 else ring.zero for _ in range(n * n)]
        rows = [entries[n * i : n * (i + 1)] for i in range(n)]
        point = random_point(ring, rng)
        values = [value_at(ring, x, point) for row in rows for x in row]
        assert value_at(ring, ring.determinant(rows), point) == int(flint().nmod_mat(n, n, values, P).det())


def test_units_are_without_a_real_zero() -> None:
    ring = Ring([1], (), ["a"])
    assert ring.is_unit(3 * ring.t[1] ** 2 + 3)
    assert not ring.is_unit(ring.t[1] ** 2 - 1)
    assert not ring.is_unit(ring.letter_half["a"] ** 2 + 1)
    assert SIMPLE[0] == "0"


def test_factoring_counts_as_work(ring: Ring) -> None:
    before = work_spent()
    ring.to_half(random_polynomial(ring, random.Random(4))).factors()
    assert work_spent() > before


def test_a_degree_that_is_told_counts_at_pi(ring: Ring) -> None:
    """t1 is infinite at π; as t1 of degree two, over (1 + t1²), it is zero there, and cos(θ1/2) is a factor."""
    own = ring.form(ring.t[1] * ring.t[2])
    assert own.at({1: "pi"}).f == ring.t[2]
    assert own.at_pi == ()
    counted = Form(ring, own.f, tuple(d + (j == 1) for j, d in zip(ring.revolute, own.degrees, strict=True)))
    assert counted.at({1: "pi"}).f == 0
    assert counted.at_pi == ((1, 1),)
    found = {atom.key: power for atom, power in counted.factors().atoms}
    assert found == {"θ1=pi": 1, "θ1=0": 1, "θ2=0": 1}


def test_a_zero_at_pi_stays_when_a_solution_is_put_in() -> None:
    """(1 + cos θ2) counts for degree 2 in t2, whatever t1 is put in: t1 = t2 adds its own."""
    ring = Ring([1, 2])
    solved = Solved(0, ring.t[2], ring.half.constant(1))
    form = substitute_into_form(ring.to_half((1 + ring.c[2]) * (1 - ring.c[1])), solved)
    assert form.at_pi == ((2, 2),)
    assert {atom.key for atom, _ in form.factors().atoms} == {"θ2=pi", "θ2=0"}


def test_a_zero_at_pi_of_a_solved_variable_is_where_its_denominator_vanishes() -> None:
    """t1 = 1 / (t2 − 2) is infinite at t2 = 2: a form with the factor cos(θ1/2) is zero there."""
    ring = Ring([1, 2])
    solved = Solved(0, ring.half.constant(1), ring.t[2] - 2)
    form = substitute_into_form(Form(ring, ring.t[2], (1, 1)), solved)
    assert {atom.key for atom, _ in form.factors().atoms} == {"θ2=0", "t2 - 2"}


@pytest.mark.parametrize("value", SIMPLE)
def test_the_polynomial_of_a_pinned_joint_vanishes_at_its_value_and_at_no_other(ring: Ring, value: str) -> None:
    found = polynomial_of(ring, next(atom for atom, _ in ring.factor(pinned(ring, value)).atoms if atom.value == value))
    assert {there for there in SIMPLE if found(*angles(ring, 2, there)) == 0} == {value}


def pinned(ring: Ring, value: str):
    """A trigonometric polynomial of θ2 that has the factor of a value."""
    cosine, sine = COS_SIN[value]
    return 1 - cosine * ring.c[2] - sine * ring.s[2]


def angles(ring: Ring, joint: int, value: str):
    """Values of all generators: one joint at a simple angle, everything else 3."""
    where = {str(ring.c[joint]): COS_SIN[value][0], str(ring.s[joint]): COS_SIN[value][1]}
    return [where.get(str(one), 3) for one in ring.trig.gens()]
