"""Three and more conditions on the same joints: their common zeros are found modulo primes, or there are none."""

from __future__ import annotations

import random
from itertools import product
from math import prod

import pytest

pytest.importorskip("flint")

from rankdrop.algebra.decompose import decompose
from rankdrop.algebra.field import P, zeros_in_space
from rankdrop.algebra.polynomial import flint
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.solving import nowhere
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet


def in_space(terms: dict[tuple[int, int, int], int]):
    """A polynomial in x, y, z modulo P."""
    return flint().nmod_mpoly_ctx.get(list("xyz"), P, flint().Ordering.lex).from_dict(terms)


def dense(ring: Ring, rng: random.Random, degrees: tuple[int, ...]):
    """A random polynomial in t1, t2 … with every power up to these degrees."""
    powers = product(*(range(d + 1) for d in degrees))
    return sum((rng.randint(-9, 9) * prod(ring.t[j] ** e for j, e in enumerate(one, 1)) for one in powers),
               ring.half.constant(1))  # fmt: skip


def test_planted_zeros_are_met() -> None:
    rng = random.Random(3)
    planted = [tuple(rng.randrange(P) for _ in range(3)) for _ in range(3)]
    powers = list(product(range(2), range(3), range(2)))[1:]
    conditions = []
    for _ in range(3):
        columns = [[pow(x, a, P) * pow(y, b, P) * pow(z, c, P) % P for x, y, z in planted] for a, b, c in powers]
        free = [rng.randrange(P) for _ in powers[3:]]
        values = [-sum(f * column[k] for f, column in zip(free, columns[3:], strict=True)) % P for k in range(3)]
        matrix = flint().nmod_mat(3, 3, [columns[j][k] for k in range(3) for j in range(3)], P)
        first = matrix.solve(flint().nmod_mat(3, 1, values, P))
        conditions.append(in_space(dict(zip(powers, [*(int(first[k, 0]) for k in range(3)), *free], strict=True))))
    found = zeros_in_space(conditions)
    assert found is not None
    assert {*planted} <= {*found}
    assert all(int(f(*zero)) == 0 for f in conditions for zero in found)


def test_zeros_that_are_not_isolated_are_said_not_to_be() -> None:
    line = in_space({(1, 0, 0): 1, (0, 1, 0): 1, (0, 0, 0): 5})
    others = [in_space({(0, 0, 1): 1, (0, 1, 0): k, (1, 0, 0): k * k}) for k in (2, 3, 4)]
    assert zeros_in_space([line * one for one in others]) is None
    assert zeros_in_space(others) is not None


@pytest.mark.slow
def test_isolated_zeros_of_three_long_conditions_are_a_set() -> None:
    ring, rng = Ring([1, 2, 3]), random.Random(5)
    f, g, h = (dense(ring, rng, (3, 3, 2)) for _ in range(3))
    k = f * ring.t[1] + g * ring.t[2] + h * ring.t[3]
    work = Work()
    (found,) = decompose(ring, {}, [ring.form(one) for one in (f, g, h, k)], 3, work)
    assert not work.unresolved
    assert (found.codimension, len(found.rest)) == (3, 3)
    assert all(found.half_vanishes(one) for one in (f, g, h, k))
    assert not found.half_vanishes(ring.t[1] - 2)
    assert found.point(rng) in found.samples


def test_four_conditions_without_a_common_zero_are_proven_to_have_none() -> None:
    ring, rng = Ring([1, 2, 3]), random.Random(5)
    t = ring.t
    system = [dense(ring, rng, (2, 2, 1)) for _ in range(4)]
    assert nowhere(system, ring.moving, {})
    through = [f - f.subs({"t1": 2, "t2": 3, "t3": 5}) for f in system]
    assert not nowhere(through, ring.moving, {})
    assert not nowhere([(t[3] ** 2 - 7) * f for f in system], ring.moving, {})


def test_a_condition_on_a_variable_of_its_own_stands_on_two_and_the_others_tell_zeros_apart() -> None:
    """(t1² − 3)(t1² − 7) = 0, t2² = 11, t3² + t1 t3 − 5 = 0: a fourth condition keeps the zeros with t1² = 3."""
    ring = Ring([1, 2, 3])
    x, y, z = (ring.t[j] for j in (1, 2, 3))
    f, g, h = (x**2 - 3) * (x**2 - 7), y**2 - 11, z**2 + x * z - 5
    kept = ring.trig_zero_set((x**2 - 3) * (y**2 + 1))
    one = ZeroSet(ring, {}, rest=(f, g, h), zero=(kept,), equations=(f, g, h))
    assert {point["t1"] ** 2 % point.prime for point in one.samples} == {3}
