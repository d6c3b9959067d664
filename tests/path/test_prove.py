"""No stretch that is called free holds a singular configuration, wherever it was put; and nothing is left undecided."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from reference import region

from path.slivers import dip, proven, singular
from rankdrop.cover.setting import settings_for
from rankdrop.formula.equation import System
from rankdrop.kinematics import jacobian
from rankdrop.local.block import block, generic_rank, singular_values
from rankdrop.path.check.check import check_path
from rankdrop.path.check.crossings import crossings, signs_at
from rankdrop.path.check.prove import Proof
from rankdrop.path.curve import curve
from rankdrop.results.known import known_analysis
from rankdrop.robot.dh import DHRow, from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import DEFAULT

ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("ur5", "puma560", "pa10", "panda", "scara", "stanford")},
    "almarkhi4": lambda: open_robot("almarkhi4"),
    "mimics": lambda: region.coupled(np.random.default_rng(9), "r r r0:1 r1:-1 r r0:1 r r"),
}


def outside(proof: Proof, places: np.ndarray) -> list[float]:
    """Places (stretches from 0, with fractions) that no sliver holds."""
    ends = np.array([[sum(start), sum(end)] for start, end, _ in proof.slivers])
    room = 1e-12 * (1 + places)
    held = ((ends[:, 0] <= (places + room)[:, None]) & ((places - room)[:, None] <= ends[:, 1])).any(axis=1)
    return places[~held].tolist()


def through(targets: np.ndarray, ways: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Samples of a path that meets each target inside every second stretch, along the given way, and where it does."""
    share = rng.uniform(0.05, 0.95, len(targets))
    share[: len(share) // 4] = rng.choice([0.5, 0.25, 0.75], len(share) // 4)
    start, end = targets - share[:, None] * ways, targets + (1 - share)[:, None] * ways
    return np.stack([start, end], axis=1).reshape(-1, targets.shape[1]), 2 * np.arange(len(targets)) + share


@pytest.mark.by_hand_at("pa10", "panda", "puma560", "stanford", "ur5")
@pytest.mark.slow_at("puma560", "stanford", "ur5", "pa10", "panda")
@pytest.mark.parametrize("name", ARMS)
def test_no_free_stretch_holds_a_singular_configuration_put_on_the_path(name: str) -> None:
    robot = ARMS[name]()
    task = resolve_task(None, robot)
    rng = np.random.default_rng(21)
    seen = 0
    for corank in (1, 2):
        targets = singular(robot, task, corank, 150)
        if len(targets) < 5:
            continue
        scale = settings_for(robot, task)[0].scale
        ways = rng.normal(size=targets.shape) * scale * 10.0 ** rng.uniform(-4, -0.5, (len(targets), 1))
        q, places = through(targets, ways, rng)
        proof = proven(robot, task, curve(q, None))
        assert proof.complete
        assert outside(proof, places) == []
        seen += len(places)
    assert seen >= 100


@pytest.mark.spread(2)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5", "puma560", "pa10", "panda"])
def test_no_free_stretch_holds_one_that_the_path_only_touches(name: str) -> None:
    """Ways inside the tangent space of the singular set: σ is of second order along them."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    rng = np.random.default_rng(22)
    targets = singular(robot, task, 1, 60)
    rank = generic_rank(robot, task) - 1
    slope = block(robot, targets, task, rank).d.reshape(len(targets), -1, robot.n)
    ways = rng.normal(size=targets.shape) * 0.05
    across = np.linalg.pinv(slope, rcond=1e-6) @ slope
    ways -= (across @ ways[..., None])[..., 0]
    q, places = through(targets, ways, rng)
    proof = proven(robot, task, curve(q, None))
    assert outside(proof, places) == []


@pytest.mark.slow
def test_no_free_piece_of_a_spline_holds_one() -> None:
    robot = open_robot("puma560")
    task = resolve_task(None, robot)
    rng = np.random.default_rng(23)
    for degree, powers in (("cubic", 4), ("quintic", 6)):
        targets = singular(robot, task, 1, 40)
        q, v, a, places = [], [], [], []
        for k, target in enumerate(targets):  # Σ c_j (s − s0)^j with c_0 the target
            at = rng.uniform(0.1, 0.9)
            c = rng.normal(size=(powers, 6)) * 0.2
            c[0] = target
            made = [np.polynomial.Polynomial(c[:, j], domain=[at, at + 1], window=[0, 1]) for j in range(6)]
            for end in (0.0, 1.0):
                q.append([one(end) for one in made])
                v.append([one.deriv()(end) for one in made])
                a.append([one.deriv(2)(end) for one in made])
            places.append(2 * k + at)
        path = curve(np.array(q), np.arange(len(q), dtype=float), np.array(v), np.array(a), degree)
        np.testing.assert_allclose(path.at(np.array([0]), np.array([places[0]]))[0], targets[0], atol=1e-12)
        assert outside(proven(robot, task, path), np.array(places)) == []


def smooth(rng: np.random.Generator, n: int, rows: int) -> np.ndarray:
    """A path of 5 s in every joint: five waves."""
    t = np.linspace(0, 1, rows)[:, None]
    waves = sum(rng.normal(size=n) * np.sin(2 * np.pi * k * t + rng.uniform(0, 6, n)) / k for k in range(1, 6))
    return np.asarray(rng.uniform(-2, 2, n) + waves)


@pytest.mark.by_hand_at("ur5-12", "puma560-12", "panda-8")
@pytest.mark.slow_at("panda-8", "ur5-12", "puma560-12", "pa10-8")
@pytest.mark.parametrize(("name", "count"), [("ur5", 12), ("puma560", 12), ("pa10", 8), ("panda", 8)])
def test_random_paths_end_with_nothing_undecided(name: str, count: int) -> None:
    robot = open_robot(name)
    rng = np.random.default_rng(24)
    for _ in range(count):
        q = smooth(rng, robot.n, 500)
        found = check_path(robot, q, np.linspace(0, 5, 500))
        assert found.undecided_share == 0.0
        if robot.n == 6:  # an odd number of crossings parts opposite signs of the determinant
            task = resolve_task(None, robot)
            sign = np.sign(np.linalg.det(jacobian(robot, q, task.frame)))
            seen = int((np.diff(sign) != 0).sum())
            crossed = [one for one in found.stretches if one.verdict == "crossing"]
            assert len(crossed) >= seen
            assert (len(crossed) - seen) % 2 == 0
            rows = np.array([one.start.row for one in crossed])
            assert set((np.flatnonzero(np.diff(sign)) + 1).tolist()) <= set(rows.tolist())


@pytest.mark.by_hand
@pytest.mark.parametrize(
    ("name", "count"), [("ur5", 100), ("puma560", 100), ("gp7", 100), ("pa10", 50), ("panda", 50)]
)
def test_hundreds_of_random_paths_end_with_nothing_undecided(name: str, count: int) -> None:
    """300 paths of 5 s of 6R arms and 100 of 7R arms, what `check_path` proves without what it tells."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    families = known_analysis(robot, task).families
    rng, kinds = np.random.default_rng(26), []
    for _ in range(count):
        path = curve(smooth(rng, robot.n, 500), np.linspace(0, 5, 500))
        proof = proven(robot, task, path)
        assert proof.complete
        kinds += [one.verdict for one in crossings(robot, task, path, proof.slivers, families, DEFAULT)]
    assert set(kinds) <= {"crossing"}
    assert robot.n > 6 or len(kinds) > 5 * count


def test_free_is_told_from_an_independent_look() -> None:
    """σ of dense samples of the free parts stays above zero: at 40 points a stretch, 1e-9 away from the slivers."""
    robot = open_robot("ur5")
    task = resolve_task(None, robot)
    q = smooth(np.random.default_rng(25), 6, 200)
    path = curve(q, None)
    proof = proven(robot, task, path)
    share = np.tile(np.linspace(0, 1, 40), 199)
    stretch = np.repeat(np.arange(199), 40)
    sigma = singular_values(robot, path.at(stretch, share), task)[:, -1]
    places = stretch + share
    free = np.isin(places, outside(proof, places))
    assert free.mean() > 0.99
    assert sigma[free].min() > 1e-9


@pytest.mark.slow
def test_two_crossings_a_thirtieth_of_a_millisecond_apart_are_found_between_two_samples() -> None:
    robot = open_robot("puma560")
    for apart in (1.0, 1e-2, 3.4e-5):
        q, v, t = dip(0.05 * (apart / 2) ** 2)
        found = check_path(robot, q, t, velocities=v, interpolate="cubic")
        assert [one.verdict for one in found.crossings] == ["crossing", "crossing"]
        times = [one.closest.place.time for one in found.crossings]
        assert times[1] - times[0] == pytest.approx(apart, rel=0.1)
        assert [one.name for one in found.crossings] == ["wrist: axes 4 and 6 aligned"] * 2


@pytest.mark.slow
def test_a_path_that_only_touches_is_told_so_and_one_that_passes_is_free() -> None:
    robot = open_robot("puma560")
    for depth in (0.0, 1e-14, -1e-14, -1e-11):
        q, v, t = dip(depth)
        found = check_path(robot, q, t, velocities=v, interpolate="cubic")
        assert found.verdict == "touching"
        assert not found.holds
        assert found.crossings[0].closest.place.time == pytest.approx(2.5, abs=1e-4)
    q, v, t = dip(-1e-7)
    found = check_path(robot, q, t, velocities=v, interpolate="cubic")
    assert found.clear
    assert found.stretches[0].closest.distance == pytest.approx(1e-7, rel=0.2)


@pytest.mark.parametrize(("last", "verb"), [(0.4, "Lies in"), (0.0, "Touches")])
def test_the_first_line_of_a_path_in_a_singularity_says_from_where_to_where(last: float, verb: str) -> None:
    """Joint 5 stays at 0 while joint 1 turns, or while all joints rest; one time within says too little."""
    robot = open_robot("irb120")
    rest = np.array([0.0, -0.3, 0.2, 0.0, 0.0, 0.0])
    q = np.stack([rest, rest + last * np.eye(6)[0]])
    first = check_path(robot, q, [0.0, 3.0]).sentence
    assert first == f"{verb} a singularity once, first wrist: joint 5 at 0°, between rows 1 and 2, 0 to 3 s."


@pytest.mark.by_hand_at("panda-k1.f1", "ur5-k1.f1")
@pytest.mark.slow_at("ur5-k1.f1", "ur5-k1.f3")
@pytest.mark.slow_at("panda-k1.f1")
@pytest.mark.parametrize(
    ("name", "number"), [("ur5", "k1.f1"), ("ur5", "k1.f3"), ("pa10", "k1.f1"), ("panda", "k1.f1")]
)
def test_a_path_tangent_to_a_family_is_told_to_touch_or_undecided_and_never_free(name: str, number: str) -> None:
    """q* + t s + w s², t in the tangent space of the family: its condition has a double zero at s = 0."""
    robot = open_robot(name)
    family = next(one for one in known_analysis(robot, resolve_task(None, robot)).families if one.id == number)
    rng, q0 = np.random.default_rng(27), np.array(family.witness)
    _, slopes = System(family.equations).linear(q0[None])
    _, size, rows = np.linalg.svd(slopes[0])
    normal = rows[: int((size > 1e-9).sum())]
    for s in (-0.37, -0.5):
        t, w = rng.normal(size=(2, robot.n)) * 0.2
        t = t - normal.T @ (normal @ t)
        ends = np.array([s, s + 1.0])
        q = q0 + ends[:, None] * t + ends[:, None] ** 2 * w
        found = check_path(robot, q, [0.0, 1.0], velocities=t + 2 * ends[:, None] * w, interpolate="cubic")
        met = [one for one in found.stretches if one.verdict != "free"]
        assert found.verdict in ("touching", "undecided")
        assert not found.holds
        assert any(one.start.time <= -s <= one.end.time for one in met)


@pytest.mark.slow
def test_an_arm_with_fewer_joints_than_rows_and_no_known_family_crosses_and_touches_its_elbow() -> None:
    """No determinant, and nobody has analysed it: the condition is found where the path is singular."""
    table = [DHRow(d=0.3, alpha=pi / 2), DHRow(a=0.25), DHRow(a=0.23), DHRow(a=0.02, alpha=pi / 2), DHRow(d=0.1)]
    robot = from_dh(table, convention="standard", name="five")
    start, end = np.array([0.1, -0.5, 0.6, 0.4, 0.2]), np.array([0.4, -0.8, -0.5, -0.3, 0.5])
    for bend, kind in ((1.0, "crossing"), (0.0, "touching")):  # to the stretched arm, and on or back
        elbow = start + (end - start) * 6 / 11
        found = check_path(robot, [start, elbow, bend * end + (1 - bend) * (start + 0.01)])
        (one,) = found.crossings
        assert (found.verdict, one.verdict, one.name) == (kind, kind, "elbow: axes 2, 3, 4 coplanar")
        assert one.closest.q[2] == pytest.approx(0.0, abs=1e-9)
    places = [np.array([0.1, -0.5, 0.0, 0.4, 0.2]), np.array([0.7, 0.9, 0.0, -1.1, 0.3])]
    assert len(signs_at(robot, resolve_task(None, robot), places, DEFAULT)) == 1  # else crossings are counted twice


@pytest.mark.slow
def test_every_crossing_of_many_turns_is_told_once() -> None:
    """The elbow turns 23.9 times: 48 times it stands at 0.3 or 0.3 − π."""
    table = [DHRow(d=0.3, alpha=pi / 2), DHRow(a=0.25), DHRow(a=0.23, theta=-0.3), DHRow(a=0.02, alpha=pi / 2)]
    robot = from_dh([*table, DHRow(d=0.1)], convention="standard", name="many")
    found = check_path(robot, [[10.0, -60.0, 70.0, -20.0, 60.0], [40.0, -70.0, -80.0, -30.0, 20.0]])
    assert [one.verdict for one in found.crossings] == ["crossing"] * len(found.crossings)
    assert sum(abs(np.sin(one.closest.q[2] - 0.3)) < 1e-9 for one in found.crossings) == 48


@pytest.mark.slow
def test_a_path_inside_the_singular_set_is_told_so_cheaply() -> None:
    robot = open_robot("puma560")
    q = np.linspace([0.1, -1.2, 1.0, 0.5, 0.0, 0.2], [0.5, -1.0, 1.3, 0.2, 0.0, 0.1], 300)
    found = check_path(robot, q, np.linspace(0, 3, 300))
    (one,) = found.stretches
    assert (found.verdict, one.verdict, one.lies) == ("touching", "touching", True)
    assert (one.start.row, one.end.row, one.end.share) == (1, 300, 0.0)
    assert found.free_share == pytest.approx(0.0, abs=1e-12)
    assert found.evaluations < 2_000
    leaves = check_path(robot, np.vstack([q, [0.5, -1.0, 1.3, 0.2, 0.4, 0.1]]))
    assert leaves.stretches[0].lies
    assert {one.verdict for one in leaves.stretches[1:]} == {"free"}


@pytest.mark.slow
def test_a_piece_singular_at_its_start_and_middle_is_halved_all_the_same() -> None:
    robot = open_robot("puma560")
    start, end = np.array([0.1, -1.2, 1.0, 0.5, 0.0, 0.2]), np.array([0.5, -1.0, 1.3, 0.2, 0.0, 0.1])
    q, v = np.stack([start, end]), np.stack([end - start, end - start])
    q[:, 4], v[:, 4] = [0.0, 0.5], [-0.5, 1.5]  # θ5 = s (s − 1/2)
    found = check_path(robot, q, [0.0, 1.0], velocities=v, interpolate="cubic")
    assert found.free_share > 0.9999
    assert [one.closest.place.share for one in found.crossings] == pytest.approx([0.0, 0.5], abs=1e-6)


def without_gaps(stretches) -> bool:
    """Whether the stretches follow one another without a gap or an overlap."""
    ends = sorted((one.start.row + one.start.share, one.end.row + one.end.share) for one in stretches)
    return all(one[1] == pytest.approx(two[0], abs=1e-9) for one, two in pairwise(ends))


@pytest.mark.slow
def test_work_that_ends_early_leaves_stretches_undecided_and_never_free() -> None:
    robot = open_robot("ur5")
    rng = np.random.default_rng(26)
    q, t = smooth(rng, 6, 400), np.linspace(0, 5, 400)
    whole = check_path(robot, q, t)
    assert whole.verdict == "crossing"
    for budget in (1, 20, 80):
        part = check_path(robot, q, t, evaluations=budget)
        assert part.verdict in ("crossing", "undecided")
        assert part.evaluations <= budget
        assert part.undecided_share > 0.0
        assert part.undecided_length > 0.0
        assert 0.0 < part.undecided_time <= 5.0
        assert part.free_share == pytest.approx(1.0 - part.undecided_share, abs=1e-6)
        assert not part.holds
        assert without_gaps(part.stretches)
        assert budget > 1 or {one.verdict for one in part.stretches} == {"crossing", "undecided"}  # all of it is open
        spans = [(s.start.row + s.start.share, s.end.row + s.end.share) for s in part.stretches if s.verdict == "free"]
        for one in whole.crossings:
            at = one.closest.place.row + one.closest.place.share
            assert not any(low < at < high for low, high in spans)


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_proven() -> None:
    robot = open_robot("ur5")
    q = smooth(np.random.default_rng(26), 6, 400)
    calls = []

    def press(done: int, total: int) -> None:
        calls.append((done, total))
        if len(calls) == 8:
            raise KeyboardInterrupt

    found = check_path(robot, q, progress=press)
    assert not found.complete
    assert not found.holds
    assert 0.0 < found.free_share < 1.0
    assert "interrupted" in found.sentence.lower()
    assert calls[-1][1] == 399


@pytest.mark.slow
def test_every_place_of_the_path_has_one_verdict() -> None:
    """The stretches follow one another without a gap from the first row to the last."""
    for name, seed in (("ur5", 27), ("pa10", 28)):
        robot = open_robot(name)
        found = check_path(robot, smooth(np.random.default_rng(seed), robot.n, 300))
        parts = sorted(found.stretches, key=lambda one: one.start.row + one.start.share)
        ends = [(one.start.row + one.start.share, one.end.row + one.end.share) for one in parts]
        assert ends[0][0] == 1.0
        assert ends[-1][1] == 300.0
        assert without_gaps(parts)
        assert len({one.verdict for one in parts}) > 1
