"""Which arms are cuspidal, decided exactly: known arms, an oracle that floods the torus, what must not matter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from reference import regional as oracle

from rankdrop.algebra.ring import Ring
from rankdrop.aspects.posture_paths import aspects_of
from rankdrop.exact import posture_changes
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.posture_changes import CUSPS, NO_CUSP, OPEN, SIGNS, Unbounded, common_zeros, decide_postures
from rankdrop.kinematics import task_jacobian
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.text.aspects import decision_text

H = np.pi / 2
WENGER = [[0, 1, -H], [1, 2, H], [0, 1.5, 0]]
"""The orthogonal 3R arm of Wenger's papers, d2 = 1, d3 = 2, d4 = 1.5, r2 = 1, r3 = 0 there: rows (d, a, α) here."""
QUIET = [[0, 1, -H], [0.2, 0.3, H], [0.1, 0.9, 0]]


def three(rows: Any) -> Robot:
    return from_dh([{"d": float(d), "a": float(a), "alpha": float(x)} for d, a, x in rows], convention="standard",
                   task="position", name="three")  # fmt: skip


def random_rows(rng: np.random.Generator, k: int) -> np.ndarray:
    alpha = rng.choice([-H, H], 2) if k % 2 else rng.uniform(0.4, 2.7, 2)
    a, d = rng.uniform(0.1, 1.5, 3).round(3), rng.uniform(0.0, 1.0, 3).round(3)
    return np.array([[0.0, a[0], alpha[0]], [d[1], a[1], alpha[1]], [d[2], a[2], 0.0]])


def test_wengers_arm_has_four_cusps_and_three_solutions_meet_at_each() -> None:
    arm = three(WENGER)
    found = decide_postures(exact_chain(arm))
    assert (found.kind, len(found.cusps), found.nodes) == (CUSPS, 4, ())
    task = resolve_task(None, arm)
    for cusp in found.cusps:
        q = np.array([0.3, *cusp])
        _, sigma, v = np.linalg.svd(task_jacobian(arm, q, task))
        assert sigma[2] < 1e-12
        steps = q + np.array([-1e-4, 1e-4])[:, None] * v[2]
        slope = np.diff(np.linalg.det(task_jacobian(arm, steps, task)))[0] / 2e-4
        across = [np.diff(np.linalg.det(task_jacobian(arm, q + np.array([-1e-4, 1e-4])[:, None] * e, task)))[0] / 2e-4
                  for e in np.eye(3)]  # fmt: skip
        assert abs(slope) < 1e-6 < 1e-2 < np.linalg.norm(across)


def test_the_same_arm_with_other_lengths_is_not_cuspidal() -> None:
    found = decide_postures(exact_chain(three(QUIET)))
    assert (found.kind, found.cusps, found.nodes) == (NO_CUSP, (), ())
    assert found.impossible


@pytest.mark.parametrize(("name", "words"), [
    ("puma560", "axes 1 and 2 meet; the wrist"), ("kr3r540", "axes 2 and 3 are parallel; the wrist"),
    ("ur5", "axes 2, 3 and 4 are parallel"), ("stanford", "axes 1 and 2 meet; the wrist"), ("planar2r", "elbow"),
    ("planar3r", "elbow"), ("scara", "elbow"), ("irb6640", "axes 2 and 3 are parallel; the wrist"),
])  # fmt: skip
def test_arms_of_known_structure_are_not_cuspidal(name: str, words: str) -> None:
    found = decide_postures(exact_chain(open_robot(name)))
    assert found.kind == SIGNS
    assert words in decision_text(found)


@pytest.mark.parametrize(("rows", "kind"), [
    ([[0, 0, H], [0.3, 0.7, 1.1], [0.2, 0.8, 0]], SIGNS),  # 1 and 2 meet
    ([[0, 0.4, 0], [0.3, 0.7, 1.1], [0.2, 0.8, 0]], SIGNS),  # 1 and 2 parallel
    ([[0, 0.4, 1.1], [0.3, 0.7, 0], [0.2, 0.8, 0]], SIGNS),  # 2 and 3 parallel
    ([[0, 0.4, 1.1], [0.3, 0, 0.9], [0.2, 0.8, 0]], SIGNS),  # 2 and 3 meet
    ([[0, 1, -H], [0, 2, H], [0, 1.5, 0]], SIGNS),  # orthogonal, without offsets
    ([[0, 0.9, -H], [0.5, 0.3, H], [0, 1.2, 0]], OPEN),  # the point comes to lie on axis 2
])  # fmt: skip
def test_every_condition_by_itself(rows: Any, kind: str) -> None:
    assert decide_postures(exact_chain(three(rows))).kind == kind


def cuspidal_by_flooding(rows: np.ndarray, places: np.ndarray, nodes: int = 240) -> bool:
    """Whether some place shares its aspect with another solution of its pose, on a grid."""
    labels = oracle.flooded(rows, nodes)
    for theta in places:
        f, g = (float(x) for x in oracle.image(rows, theta[0], theta[1]))
        found = oracle.inverse(rows, f, g)
        found = found[np.abs(oracle.determinant(rows, found[:, 0], found[:, 1])) > 1e-2]
        values = oracle.determinant(rows, found[:, 0], found[:, 1])
        at = oracle.node(nodes, found)  # a node beyond the singular curve would tell of another aspect
        found = found[oracle.determinant(rows, at[:, 0], at[:, 1]) * values > 0]
        met = oracle.aspect(labels, found)
        if len(set(met.tolist())) < len(met):
            return True
    return False


def agree(count: int, seed: int, targets: int) -> tuple[int, int]:
    rng = np.random.default_rng(seed)
    kinds = []
    for k in range(count):
        rows = random_rows(rng, k)
        found = decide_postures(exact_chain(three(rows)))
        places = rng.uniform(-np.pi, np.pi, (targets, 2))
        if found.cusps:
            ring = np.stack([np.cos(np.arange(6)), np.sin(np.arange(6))], axis=1)
            places = np.concatenate([place + r * ring for place in np.array(found.cusps) for r in (0.1, 0.2, 0.3)])
        assert found.kind in (CUSPS, NO_CUSP)
        flooded = cuspidal_by_flooding(rows, places)
        if found.kind == CUSPS and not flooded:  # a region too small for these places and the grid: a proof instead
            flooded = aspects_of(three(rows), poses=1, starts=100).change is not None
        assert flooded == (found.kind == CUSPS), rows
        kinds.append(found.kind)
    return kinds.count(CUSPS), kinds.count(NO_CUSP)


@pytest.mark.slow
def test_random_arms_agree_with_a_flooded_torus() -> None:
    assert agree(6, 1, 60)[0] >= 4
    assert not cuspidal_by_flooding(np.array(QUIET, dtype=float), np.random.default_rng(0).uniform(-3, 3, (60, 2)))


@pytest.mark.by_hand
def test_many_random_arms_agree_with_a_flooded_torus() -> None:
    cuspidal, quiet = agree(80, 5, 300)
    assert cuspidal >= 50
    assert quiet >= 3


def test_neither_base_nor_zero_nor_sense_nor_unit_matters() -> None:
    rows = np.array(WENGER, dtype=float)
    rows[2, 0] = 0.3
    kept = decide_postures(exact_chain(three(rows)))
    other = rows * [1000, 1000, 1]
    mirrored = rows * [-1, 1, -1]
    for changed in (other, mirrored):
        found = decide_postures(exact_chain(three(changed)))
        assert (found.kind, len(found.cusps)) == (kept.kind, len(kept.cusps))
    raised = rows.copy()
    raised[0, 0] = 0.7
    assert decide_postures(exact_chain(three(raised))).cusps == kept.cusps
    zeros = zip(rows.tolist(), (0.4, -1.1, 0.7), strict=True)
    moved = from_dh([{"d": d, "a": a, "alpha": x, "theta": y} for (d, a, x), y in zeros], convention="standard",
                    task="position", name="moved")  # fmt: skip
    there = np.array(decide_postures(exact_chain(moved)).cusps) + np.array([-1.1, 0.7])
    gap = (there[:, None] - np.array(kept.cusps)[None] + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(gap).max(axis=2).min(axis=1).max() < 1e-9


def test_where_angles_are_counted_from_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    chain = exact_chain(three(WENGER))
    kept = decide_postures(chain).cusps
    for turn in posture_changes._TURNS[1:]:
        monkeypatch.setattr(posture_changes, "_TURNS", (turn,))
        assert np.allclose(decide_postures(chain).cusps, kept, atol=1e-9)


def test_the_centre_of_a_wrist_behind_a_long_forearm_is_where_the_point_is() -> None:
    """Of an arm with its point at (a, −d sin α, d cos α) in the frame of link 3, and of one with a wrist there."""
    alpha, a, d = 1.1, 0.4, 1.3
    tool = np.eye(4)
    tool[:3, 3] = [0.0, -d * np.sin(alpha), d * np.cos(alpha)]
    first = [{"d": 0.0, "a": 0.9, "alpha": -1.2}, {"d": 0.5, "a": 0.7, "alpha": 0.8}]
    pointed = from_dh([*first, {"d": 0.3, "a": a, "alpha": 0.0}], convention="standard", task="position", tool=tool,
                      name="pointed")  # fmt: skip
    wrist = [{"d": d, "a": 0.0, "alpha": -H}, {"d": 0.0, "a": 0.0, "alpha": H}, {"d": 0.2, "a": 0.0, "alpha": 0.0}]
    whole = from_dh([*first, {"d": 0.3, "a": a, "alpha": alpha}, *wrist], convention="standard", name="whole")
    one, other = (decide_postures(exact_chain(robot)) for robot in (pointed, whole))
    assert one.kind == other.kind == CUSPS
    gap = np.array(one.cusps)[:, None] - np.array(other.cusps)[None]
    assert np.abs(gap).max(axis=2).min(axis=1).max() < 1e-6


def wristed(rows: Any) -> Robot:
    """A spherical wrist at the point that three joints move."""
    (_, a1, x1), (d2, a2, x2), (d3, a3, _) = rows
    full = [(0, a1, x1), (d2, a2, x2), (d3, a3, H), (0, 0, -H), (0, 0, H), (0.2, 0, 0)]
    return from_dh([{"d": d, "a": a, "alpha": x} for d, a, x in full], convention="standard", name="wristed")


@pytest.mark.parametrize("rows", [WENGER, QUIET])
def test_an_arm_with_a_spherical_wrist_is_what_its_first_three_joints_are(rows: Any) -> None:
    regional, whole = (decide_postures(exact_chain(arm)) for arm in (three(rows), wristed(rows)))
    assert (whole.kind, whole.cusps) == (regional.kind, regional.cusps)


def test_common_zeros_are_those_that_are_there() -> None:
    x, y = Ring([1, 2]).half.gens()
    found = common_zeros((x - y) * (x + 2 * y), x**2 + y**2 - 5, x * y + 2)
    assert np.allclose(found, [(-2, 1), (2, -1)])
    assert common_zeros(x**2 + y**2 + 1, x, y) == ()
    with pytest.raises(Unbounded):
        common_zeros((x - y) * (x + 1), (x - y) * y, (x - y) * (x + y))
