"""Arms whose lengths agree by chance: upper arm as long as the forearm, a = d, offsets that cancel.

What holds for general lengths need not hold for them: conditions have factors there, or say nothing of a joint. Each
printed family is tested at its own real points and at configurations with joints at right angles; each singular
configuration that a search finds has to lie on a family.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rankdrop.families.points import cloud, count_explained
from rankdrop.families.record import exact_of
from rankdrop.formula.equation import System
from rankdrop.local.block import singular_values
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions

EQUAL_LINKS = [  # (a, alpha in degrees, d, theta in degrees): the form of a maker's arm of 2025, its numbers rounded
    (0, -90, 0.3, 0), (0.8, 0, -0.25, -90), (0, 90, 0.19, 90), (0, -90, 0.8, 0), (0, 90, 0, 0), (0, 0, 0.13, 0),
]  # fmt: skip
ARMS = {
    "equal links": EQUAL_LINKS,
    "opposite links": [(0, -90, 0.3, 0), (0.5, 0, 0, 0), (0, -90, 0, 0), (0, 90, 0.5, 0), (0, -90, 0.12, 0),
                       (0, 0, 0.1, 0)],
    "a1 = d4": [(0.3, -90, 0.4, 0), (0.5, 0, 0, 0), (0, 90, 0, 0), (0, -90, 0.3, 0), (0, 90, 0, 0), (0, 0, 0.1, 0)],
    "offsets cancel": [(0, -90, 0.3, 0), (0.5, 0, 0.2, 0), (0.4, 0, -0.2, 0), (0, 90, 0.2, 0), (0, -90, 0.1, 0),
                       (0, 0, 0.1, 0)],
    "three equal": [(0, 90, 0.2, 0), (0.4, 0, 0, 0), (0, 90, 0.4, 0), (0, -90, 0.4, 0), (0, 90, 0.1, 0),
                    (0, 0, 0.1, 0)],
}  # fmt: skip


def arm(name: str) -> Robot:
    rows = [(a, np.radians(alpha), d, np.radians(theta)) for a, alpha, d, theta in ARMS[name]]
    return from_dh(rows, convention="standard", name=name)


def starts(n: int, rng: np.random.Generator) -> list[tuple[np.ndarray, np.ndarray]]:
    """(configurations, directions in which they may move): anywhere, and with one or two joints at right angles."""
    right = (0.0, np.pi, np.pi / 2, -np.pi / 2)
    found = [(rng.uniform(-np.pi, np.pi, (60, n)), np.eye(n))]
    for one in range(1, n - 1):
        for two in range(one, n - 1):
            for values in product(right, repeat=2):
                q = rng.uniform(-np.pi, np.pi, (4, n))
                q[:, one], q[:, two] = values
                found.append((q, np.delete(np.eye(n), [one, two], axis=1)))
    return found


def false_points(found, rng):
    """Families whose conditions hold where the rank is higher than they claim, with such a configuration."""
    wrong = []
    for family in found.families:
        system = System(family.equations)
        for q, along in starts(found.robot.n, rng):
            end, solved = system.solve(q, along=along, iterations=60)
            sigma = singular_values(found.robot, end, found.task)[:, found.generic_rank - family.corank]
            if (solved & (sigma > 1e-3)).any():
                wrong.append((family.id, family.texts, end[int(np.argmax(solved * sigma))].round(4).tolist()))
                break
    return wrong


def unexplained(found, rng) -> int:
    met = cloud(found.robot, found.task, 1, 300, seed=int(rng.integers(1000)))
    return len(count_explained(met, [family.equations for family in found.families])[1])


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("a1 = d4", "offsets cancel")
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_conditions_hold_where_the_rank_drops_and_nowhere_else(name: str) -> None:
    found = conditions(arm(name), method="tree", points=0)
    rng = np.random.default_rng(3)
    assert found.verified
    assert all(one.holds for one in found.assumptions)
    assert false_points(found, rng) == []
    assert unexplained(found, rng) == 0


@pytest.mark.slow
def test_equal_links_have_the_family_of_their_own() -> None:
    """θ2 = −θ3/2, θ5 = 0 or π, 2 a2 c2 c4 s2 + (d2 + d3) s4 = 0 has corank 2, and nothing at θ4 = 0 besides."""
    found = conditions(arm("equal links"), method="tree", points=0)
    (family,) = [one for one in found.of_corank(2) if exact_of(one).polynomials]
    assert [(pin.joint, pin.values) for pin in exact_of(family).pins] == [(5, ("0", "pi"))]
    assert [one.text() for one in exact_of(family).polynomials] == ["2θ2 + θ3 = 0", "2 a2 c2 c4 s2 + d2 s4 + d3 s4 = 0"]
    regular = np.array([[0.2, -0.3, 0.6, 0.0, 0.0, 0.4]])  # θ = q but for quarter turns: below in θ
    q = regular - np.array(exact_of(found.families[0]).shifts)
    assert max(abs(float(one(q)[0])) for one in family.equations) > 1e-2


@pytest.mark.slow_at("crx10ia")
@pytest.mark.by_hand_at("crx3ia")
@pytest.mark.slow_at("crx3ia")
@pytest.mark.parametrize("name", ["crx10ia", "crx3ia"])
def test_a_forearm_as_long_as_the_upper_arm_is_singular_at_a_right_angle(name: str) -> None:
    """FANUC's CRX with a2 = −d4: θ3 = −90° alone lowers the rank, a family of dimension 5."""
    found = conditions(open_robot(name), method="tree", points=0, fresh=True)
    (family,) = [one for one in found.of_corank(1) if exact_of(one).pins]
    assert [(pin.joint, pin.values) for pin in exact_of(family).pins] == [(3, ("-pi/2",))]
    assert family.dimension == 5
    q = np.random.default_rng(0).uniform(-3, 3, (5, 6))
    q[:, 2] = -np.pi / 2 - exact_of(family).shifts[2]
    assert singular_values(found.robot, q, found.task)[:, 5].max() < 1e-12
