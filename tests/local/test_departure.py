"""The law of escape: the gain predicted from q alone is the gain that a finite motion measures, joint by joint."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from reference import arms

from rankdrop.configuration import Configuration, configuration_at
from rankdrop.errors import OptionError
from rankdrop.families.searching import search
from rankdrop.local.block import singular_values
from rankdrop.local.departure import departures, measured_gains, taylor
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT

SPECIAL = ("pa10", "canadarm2", "iiwa14", "ur5", "puma560", "anthropomorphic", "stanford", "scara", "gen3", "fetch8")
CHAINS = ("rrrrrrr", "rrrrrrrr", "rrprrr", "hrprhr", "rrmrrrr", "mrrhpmr")


def every_arm() -> dict[str, Robot]:
    rng = np.random.default_rng(3)
    return {name: open_robot(name) for name in SPECIAL} | {kinds: arms.random_chain(rng, kinds) for kinds in CHAINS}


def compare(robots: dict[str, Robot], count: int) -> tuple[Counter[str], list[str]]:
    """Every joint at `count` random singular configurations per arm and corank: what came out, and what disagreed."""
    seen: Counter[str] = Counter()
    wrong: list[str] = []
    for name, robot in robots.items():
        task = resolve_task(None, robot)
        for corank in (1, 2, 3):
            try:
                points = search(robot, corank, starts=2 * count, seed=5).converged[:count]
            except OptionError:  # this arm has no such corank
                continue
            seen[f"corank {corank}"] += len(points)
            for q in points:
                place = configuration_at(robot, q, task, DEFAULT)
                measured = measured_gains(place, np.eye(robot.n))
                found = departures(place, np.eye(robot.n))
                for number, ((made, order, _, _), gain) in enumerate(zip(found, measured, strict=True), 1):
                    seen[f"order {order}"] += 1
                    seen[f"gain {made}"] += 1
                    if made != gain:
                        wrong.append(f"{name} joint {number} predicted {made} measured {gain} at {q.tolist()}")
    return seen, wrong


@pytest.mark.slow
def test_predicted_gain_is_measured_gain() -> None:
    chosen = ("pa10", "ur5", "stanford", "canadarm2", "scara", "rrrrrrr", "hrprhr", "mrrhpmr")
    seen, wrong = compare({name: robot for name, robot in every_arm().items() if name in chosen}, 25)
    assert wrong == []
    assert seen["corank 1"] >= 150
    assert min(seen["corank 2"], seen["corank 3"]) >= 25
    assert min(seen["order 1"], seen["gain 1"], seen["gain 2"]) > 100


@pytest.mark.by_hand
def test_predicted_gain_is_measured_gain_at_thousands_of_configurations() -> None:
    seen, wrong = compare(every_arm(), 200)
    assert wrong == []
    assert sum(seen[f"corank {corank}"] for corank in (1, 2, 3)) >= 2000
    assert min(seen[f"corank {corank}"] for corank in (1, 2, 3)) >= 500
    assert seen["order 2"] >= 5  # met at random: where two families cross


ORDERS = [
    ("pa10", [0.1, 0, 0.7, 0, 0.9, 0.4, 0.2]),  # two families cross
    ("pa10", [0.1, 0, 0.7, 0.5, 0.9, 0, 0.2]),
    ("pa10", [0.1, 0.4, 0.7, 0, 0.9, 0, 0.2]),
    ("stanford", [0.1, 0, 0.6, 0.3, 0, 0.4]),
    ("puma560", [0.1, 0.5, 0.7, 0.3, 0, 0.4]),
    ("anthropomorphic", [0.1, 0.5, 0, 0.3, 0, 0.4]),
]


@pytest.mark.parametrize(("name", "q"), ORDERS)
def test_orders_and_rates_are_those_of_a_short_motion(name: str, q: list[float]) -> None:
    robot = open_robot(name)
    task = resolve_task(None, robot)
    rng = np.random.default_rng(2)
    directions = np.concatenate([np.eye(robot.n), np.linalg.qr(rng.normal(size=(robot.n, robot.n)))[0]])
    place = configuration_at(robot, q, task, DEFAULT)
    assert place.corank
    for (_, order, rate, _), direction in zip(departures(place, directions), directions, strict=True):
        t = np.array([2e-3, 1e-3])
        sigma = singular_values(robot, place.q + t[:, None] * direction * place.scale, task)[:, place.generic - 1]
        if order is None:
            assert sigma.max() < 1e-12
        else:
            assert np.log2(sigma[0] / sigma[1]) == pytest.approx(order, abs=0.05)
            assert sigma[1] / t[1] ** order == pytest.approx(rate, rel=0.05)


def test_second_order_cases_are_among_the_known_ones() -> None:
    orders: Counter[int | None] = Counter()
    for name, q in ORDERS:
        robot = open_robot(name)
        place = configuration_at(robot, q, resolve_task(None, robot), DEFAULT)
        measured = measured_gains(place, np.eye(robot.n))
        for (made, order, _, _), gain in zip(departures(place, np.eye(robot.n)), measured, strict=True):
            assert made == gain
            orders[order] += 1
    assert orders[2] >= 2
    assert orders[1] >= 2


def test_mixed_orders_are_reported_by_the_slowest() -> None:
    """Corank 2, D(Δ) of rank 1: one singular value leaves at order 1, the other at order 2."""
    rng = np.random.default_rng(4)
    robot = arms.random_chain(rng, "rrrrrr")
    task = resolve_task(None, robot)
    points = search(robot, 2, starts=60, seed=1).converged
    met = 0
    for q in points:
        place = configuration_at(robot, q, task, DEFAULT)
        low, high = rng.normal(size=(2, 6))

        def measure(direction: np.ndarray, place: Configuration = place) -> float:
            series = taylor(robot, place.q, task, direction[None], 1)
            return float(np.linalg.det(place.u2.T @ series[1, 0] @ place.v2))

        if measure(low) * measure(high) > 0:
            continue
        start = measure(low)
        for _ in range(100):
            middle = (low + high) / 2
            low, high = (middle, high) if measure(middle) * start > 0 else (low, middle)
        direction = low / np.linalg.norm(low)
        gain, order, rate, first = departures(place, direction[None])[0]
        assert (gain, order) == (2, 2)
        assert first[0] > 1e-3
        assert first[1] < 1e-9
        t = np.array([1e-3, -1e-3])
        sigma = singular_values(robot, place.q + t[:, None] * direction, task)[:, 5]
        assert sigma.mean() / 1e-6 == pytest.approx(rate, rel=0.05)
        met += 1
    assert met >= 5


@pytest.mark.by_hand
def test_gains_near_the_meeting_of_families_are_measured_gains() -> None:
    """Gen3's offsets put families 1e-3 apart: ranks of T_p hang on the cut there, and the summed series decides."""
    seen, wrong = compare({"gen3": open_robot("gen3")}, 150)
    assert wrong == []
    assert seen["corank 1"] == 150
