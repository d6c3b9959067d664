"""Both rings speak of the same functions, and what is factored is put together again."""

from __future__ import annotations

import random
from itertools import permutations

import pytest

pytest.importorskip("flint")

from rankdrop.exact.algebra.field import P, complete, half_evaluator, trig_evaluator
from rankdrop.exact.algebra.polynomial import SIMPLE, primitive
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import spent


@pytest.fixture(scope="module")
def ring() -> Ring:
    return Ring([1, 2, 4], [3], ["a", "b"])


def random_point(ring: Ring, rng: random.Random, pins: dict[int, str] | None = None) -> dict[str, int]:
    point = complete(ring, {name: rng.randrange(2, P) for name in ring.names}, pins or {})
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


def scale(ring: Ring, degree: tuple[int, ...], point: dict[str, int]) -> int:
    value = 1
    for j, power in zip(ring.revolute, degree, strict=True):
        value = value * pow(1 + point[f"t{j}"] ** 2, power, P) % P
    return value


def test_half_angle_form_is_the_function_times_its_denominators(ring: Ring) -> None:
    rng = random.Random(1)
    for _ in range(40):
        p = random_polynomial(ring, rng)
        f, degree = ring.to_half(p)
        point = random_point(ring, rng)
        assert half_evaluator(ring)(f, point) == trig_evaluator(ring)(p, point) * scale(ring, degree, point) % P


def test_reduction_changes_no_value(ring: Ring) -> None:
    rng = random.Random(2)
    for _ in range(40):
        p = random_polynomial(ring, rng) * random_polynomial(ring, rng)
        point = random_point(ring, rng)
        assert trig_evaluator(ring)(p, point) == trig_evaluator(ring)(ring.reduce(p), point)


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
        product = int(found.content.p) * pow(int(found.content.q), -1, P)
        pins: dict[int, dict[str, int]] = {}
        point = random_point(ring, rng)
        for f, power in found.letters:
            product = product * pow(half_evaluator(ring)(f, point), power, P) % P
        for atom, power in found.atoms:
            if atom.pinned:
                pins.setdefault(atom.joint, {})[atom.value] = power
                seen_pins.add(atom.value)
                root = {"0": 0, "pi/2": 1, "-pi/2": -1}.get(atom.value)
                value = 1 if root is None else point[f"t{atom.joint}"] - root
            else:
                value = half_evaluator(ring)(atom.f, point)
            product = product * pow(value, power, P) % P
        # what is left out is a power of 1 + t², which has no real zero
        _, _degree = ring.to_half(p)
        left = half_evaluator(ring)(ring.to_half(p)[0], point) * pow(product, -1, P) % P
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
        f, degree = ring.to_half(p)
        if tuple(2 * d for d in degree) != tuple(f.degrees()[: ring.angles]):
            continue  # θ = π is a zero: half-angle polynomials do not show it
        assert ring.to_trig(f) in (primitive(p), -primitive(p))
        back += 1
    assert back > 10


def test_odd_half_angle_polynomials_have_a_square_with_their_zeros(ring: Ring) -> None:
    f = ring.t[1] + 2 * ring.t[2] - 1
    assert ring.to_trig(f) is None
    p = ring.trig_zero_set(f)
    rng = random.Random(5)
    point = random_point(ring, rng)
    assert trig_evaluator(ring)(p, point) != 0
    point = complete(ring, {**point, "t1": (1 - 2 * point["t2"]) % P}, {})
    assert point is not None
    assert trig_evaluator(ring)(p, point) == 0


@pytest.mark.parametrize("pins", [{1: "pi", 2: "0"}, {1: "pi", 2: "pi", 4: "pi/2"}, {2: "-pi/2", 4: "pi", 1: "pi"}])
def test_pins_in_any_order_are_the_function_at_these_angles(ring: Ring, pins: dict[int, str]) -> None:
    rng = random.Random(6)
    for _ in range(30):
        p = random_polynomial(ring, rng, 7)
        f, degree = ring.to_half(p)
        whole = tuple(2 * d for d in degree)
        point = random_point(ring, rng, pins)
        values = {
            str(ring.half_at(f, {j: pins[j] for j in order}, whole)) for order in permutations(pins)
        }
        assert len(values) == 1
        value = half_evaluator(ring)(ring.half_at(f, pins, whole), point)
        expected = trig_evaluator(ring)(p, point)
        for j, power in zip(ring.revolute, degree, strict=True):
            if pins.get(j) != "pi":
                expected = expected * pow(1 + point[f"t{j}"] ** 2, power, P) % P
            else:  # t^(2m) / (1 + t²)^m is 1 there
                expected = expected * pow(1, power)
        assert value == expected % P


def test_a_joint_at_pi_takes_the_degree_that_was_there_before_any_pin() -> None:
    ring = Ring([1, 2])
    f = ring.t[1] * ring.t[2] - ring.t[2] ** 2 + 1  # degree 2 in t2, and 1 in t1: at θ1 = π only t2 is left
    assert ring.half_at(f, {1: "pi"}) == ring.t[2]
    assert ring.half_at(f, {1: "pi", 2: "pi"}) == 0
    assert ring.half_at(f, {2: "pi", 1: "pi"}) == 0


def test_a_determinant_is_the_one_of_the_values(ring: Ring) -> None:
    from rankdrop.exact.algebra.polynomial import flint

    rng = random.Random(7)
    for n in (1, 2, 3, 4):
        entries = [random_polynomial(ring, rng, 3) if rng.random() < 0.7 else ring.zero for _ in range(n * n)]
        rows = [entries[n * i : n * (i + 1)] for i in range(n)]
        point = random_point(ring, rng)
        values = [trig_evaluator(ring)(x, point) for row in rows for x in row]
        assert trig_evaluator(ring)(ring.determinant(rows), point) == int(flint().nmod_mat(n, n, values, P).det())


def test_units_are_without_a_real_zero() -> None:
    ring = Ring([1], (), ["a"])
    assert ring.is_unit(3 * ring.t[1] ** 2 + 3)
    assert not ring.is_unit(ring.t[1] ** 2 - 1)
    assert not ring.is_unit(ring.letter_half["a"] ** 2 + 1)
    assert SIMPLE[0] == "0"


def test_factoring_counts_as_work(ring: Ring) -> None:
    before = spent()
    ring.split(ring.to_half(random_polynomial(ring, random.Random(4)))[0])
    assert spent() > before


def test_a_degree_that_is_told_counts_at_pi(ring: Ring) -> None:
    """t1 is infinite at π; as t1 of degree two, over (1 + t1²), it is zero there."""
    f = ring.t[1] * ring.t[2]
    own = f.degrees()
    assert ring.half_at(f, {1: "pi"}, own) == ring.half_at(f, {1: "pi"}) == ring.t[2]
    place = ring.index["t1"]
    assert ring.half_at(f, {1: "pi"}, [d + (i == place) for i, d in enumerate(own)]) == 0
