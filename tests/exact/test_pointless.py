"""Sets without a point modulo a prime: √53 is real, and need not be a number there."""

from __future__ import annotations

from math import prod
from pathlib import Path

import numpy as np
import pytest

from rankdrop.algebra import ring, zeroset
from rankdrop.algebra.cut import with_points
from rankdrop.algebra.field import PRIMES, P, roots
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import FURTHER
from rankdrop.algebra.work import Work
from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.families.record import exact_of
from rankdrop.formula.equation import System
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions

NOWHERE = prod(PRIMES) - 1  # ≡ −1, a square modulo none of the primes


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


def test_roots_that_no_prime_of_the_ring_has_are_met_modulo_a_further_one() -> None:
    """t1 = √n, n ≡ −1 modulo all primes of the ring and 4 modulo a further one."""
    ring, last = Ring([1, 2, 3]), FURTHER[0]
    whole = prod(PRIMES)
    number = -1 + whole * (5 * pow(whole, -1, last) % last)
    x, y, z = ring.t[1], ring.t[2], ring.t[3]
    for g in (y**2 - 3, y**2 - 3 * z**2):  # points, and curves
        f = x**2 - number
        met = ZeroSet(ring, {}, rest=(f, g), equations=(f, g)).samples
        assert met
        for point in met:
            assert point.prime in FURTHER
            assert (point["t1"] ** 2 - number) % point.prime == 0


@pytest.mark.slow
def test_a_set_that_one_plane_in_five_has_points_of_is_found() -> None:
    """Known answer: of rank 4 is θ5 = 0 or π (its own angle) together with three more conditions."""
    arm = open_robot(Path(__file__).resolve().parents[1] / "data" / "exact" / "roots_of_numbers.toml")
    found = conditions(arm, coranks=2, points=300)
    assert found.verified
    q = np.array([-2.51423, 2.69649, 2.94178, -1.81141, np.pi / 2, -2.77153])
    (family,) = (one for one in found.of_corank(2) if all(abs(f(q[None])) < 1e-4 for f in one.equations))
    assert exact_of(family).rank_check.holds


@pytest.mark.by_hand
def test_numbers_hide_nothing_that_another_prime_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"lengths": "numbers", "method": "tree", "points": 0, "coranks": 2}
    found = conditions(open_robot("panda"), **options)
    assert found.complete
    assert len(found.families) == 7  # with letters 8: the parts of the elbow, θ5 = 0 or π and ±π/2, come as one set
    monkeypatch.setattr(ring, "primes_with", lambda roots: (P,))
    monkeypatch.setattr(zeroset, "FURTHER", ())
    less = conditions(open_robot("panda"), **options)
    assert less.complete
    assert not less.in_families
    held = [System(one.equations) for one in (*less.families, *less.undivided)]
    for family in found.families:
        assert any(system.zero(np.array([family.witness]))[0] for system in held)


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
