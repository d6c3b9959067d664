"""Sets without a point modulo a prime: √53 is real, and need not be a number there."""

from __future__ import annotations

from math import prod

import pytest

from rankdrop.exact.algebra import ring
from rankdrop.exact.algebra.decompose import with_points
from rankdrop.exact.algebra.field import PRIMES, P, roots
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.algebra.work import Work
from rankdrop.exact.algebra.zeroset import ZeroSet
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions

NOWHERE = prod(PRIMES) - 1  # ≡ −1, a square modulo none of the primes


def test_all_primes_have_the_small_roots_and_none_has_that_of_minus_one() -> None:
    assert len(set(PRIMES)) == len(PRIMES)
    for p in PRIMES:
        assert pow(2, p - 1, p) == 1
        assert p % 120 in (71, 119)
        assert all(pow(q, (p - 1) // 2, p) == 1 for q in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43))


def test_a_root_that_one_prime_has_not_exists_modulo_another() -> None:
    ring = Ring([1])
    number = next(n for n in range(2, 100) if not roots([-n, 0, 1]))
    f = ring.t[1] ** 2 - number
    for point in ZeroSet(ring, {}, rest=(f,), equations=(f,)).samples:
        assert point.prime != P
        assert point["t1"] ** 2 % point.prime == number
        assert (point["c1"] ** 2 + point["s1"] ** 2) % point.prime == 1


def test_two_conditions_are_asked_modulo_every_prime() -> None:
    """(t1² − 2)(t1² − n) and one more hold on two sets, of which only the first has points modulo the first prime."""
    ring = Ring([1, 2])
    number = next(n for n in range(2, 100) if not roots([-n, 0, 1]))
    x, y = ring.t[1], ring.t[2]
    f, g = (x**2 - 2) * (x**2 - number), y**2 - 3
    met = {point["t1"] ** 2 % point.prime for point in ZeroSet(ring, {}, rest=(f, g), equations=(f, g)).samples}
    assert met == {2, number}


@pytest.mark.by_hand
def test_numbers_hide_nothing_that_another_prime_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"lengths": "numbers", "method": "tree", "points": 0, "coranks": 2}
    found = conditions(open_robot("panda"), **options)
    assert found.complete
    assert len(found.families) == 7  # with letters 8: the parts of the elbow, θ5 = 0 or π and ±π/2, come as one set
    monkeypatch.setattr(ring, "primes_with", lambda roots: (P,))
    less = conditions(open_robot("panda"), **options)
    assert not less.complete
    assert any("could not be looked into" in one for one in less.left)


@pytest.mark.slow
def test_sets_that_families_hold_are_no_loss() -> None:
    found = conditions(open_robot("puma560"), lengths="numbers", method="tree", points=0)
    assert found.verified
    assert len(found.families) == 6


def test_a_root_that_is_real_alone_is_noted_and_one_that_is_not_real_is_not() -> None:
    number = NOWHERE
    assert all(pow(number, (p - 1) // 2, p) == p - 1 for p in PRIMES)
    ring = Ring([1, 2])
    t = ring.t[1]
    work = Work()
    real, unreal = (ZeroSet(ring, {}, rest=(f,), equations=(f,)) for f in (t**2 - number, t**2 + t + number))
    assert with_points([real], work) == []
    assert list(work.without_points) == [real.key]
    work.without_points.clear()
    assert with_points([unreal], work) in ([], [unreal])
    assert not work.without_points
