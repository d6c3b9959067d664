"""The monitor says what the slow parts say, one by one, to rounding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known.members import members
from reference import arms

from rankdrop.distance.many_distances import distances
from rankdrop.distance.monitor import Monitor, compile_families
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.record import Family
from rankdrop.formula.equation import Equation, Term
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import block, joint_scale, sample, singular_values
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array
from rankdrop.task import SPACE, resolve_task

ARMS = ["pa10", "canadarm2", "gen3", "stanford", "planar3r", "scara", "rcrrrr", "fetch8"]


def residuals(monitor: Monitor, q: Array, *, of_coupled: bool = False) -> Array:
    """(B, F) largest of min(|f|/|∇f|, √|f|) over each family's equations, from the equations themselves."""
    scale = joint_scale(monitor.robot, monitor.task)
    columns = []
    for family in monitor.families:
        worst = np.zeros(len(q))
        pinned = {one.number for one in family.pinned}
        for equation in family.equations:
            if of_coupled and set(equation.joints) <= pinned:
                continue
            f, slope = equation.with_gradient(q)
            f, slope = np.abs(f), np.linalg.norm(slope * scale, axis=1)
            worst = np.maximum(worst, np.minimum(f / np.maximum(slope, 1e-300), np.sqrt(f)))
        columns.append(worst)
    return np.stack(columns, axis=1)


def pinned_ways(monitor: Monitor, family: Family, q: Array) -> Array:
    """(B, n) the way from the nearest values of the pinned joints, zero for the others."""
    ways = np.zeros(q.shape)
    for one in family.pinned:
        j = one.number - 1
        gaps = q[:, j, None] - np.array(one.values)
        gaps = (gaps + np.pi) % (2 * np.pi) - np.pi if monitor.robot.periodic[j] else gaps
        ways[:, j] = np.take_along_axis(gaps, np.abs(gaps).argmin(axis=1)[:, None], axis=1)[:, 0]
    return ways


def first_order(monitor: Monitor, q: Array) -> Array:
    """(B, F) motion of the pinned joints to their nearest values, and that of the coupled ones to first order."""
    scale = joint_scale(monitor.robot, monitor.task)
    square = residuals(monitor, q, of_coupled=True) ** 2
    ways = [(pinned_ways(monitor, family, q) / scale) for family in monitor.families]
    return np.asarray(np.sqrt(square + np.stack([(way**2).sum(axis=1) for way in ways], axis=1)))


def walked(monitor: Monitor, family: Family, q: Array, first: float) -> float:
    """Newton's steps onto the tangent plane from one q, by least squares; `first` where they come to no rest."""
    scale, held = joint_scale(monitor.robot, monitor.task), {one.number for one in family.pinned}
    coupled = [one for one in family.equations if not held.issuperset(one.joints)]
    if not coupled or lengthy(family):
        return first
    free = np.array([number not in held for number in range(1, len(q) + 1)])
    foot = q - pinned_ways(monitor, family, q[None])[0]
    for _ in range(8):
        f, slopes = (np.array(part) for part in zip(*(one.with_gradient(foot) for one in coupled), strict=True))
        a, away = slopes * scale * free, (q - foot) / scale * free
        step = away - np.linalg.lstsq(a, f + a @ away, rcond=1e-7)[0]
        length = np.linalg.norm(step)
        foot = foot + step * min(1.0, 0.7 / max(length, 1e-300)) * scale
        far = float(np.linalg.norm((q - foot) / scale))
        if length <= 0.05 * far + 1e-9:
            return far
    return first


def lengthy(family: Family) -> bool:
    """Whether it is walked to by the kinematics: more than 100 terms, or with six joints 15."""
    held = {one.number for one in family.pinned}
    count = sum(len(one.terms) for one in family.equations if not held.issuperset(one.joints))
    return count > (100 if len(family.witness) > 6 else 15)


def first_by_kinematics(monitor: Monitor, family: Family, q: Array) -> float:
    """|D⁺F|: to the tangent plane of F = 0 at q, seen from the base.

    F = left^T J V2: V2 spans the null space of U1^T J, and left^T J lies in it. The border splits the task as seen from
    the base: u is the direction that is weakest at q, taken there; U1 is its orthogonal complement.
    """
    robot, task, rank = monitor.robot, monitor.task, monitor.generic_rank - family.corank
    scale = joint_scale(robot, task)
    here = replace(task, length_scale=task.scale(robot), frame=SPACE)  # derivatives are taken there
    # u^T J of the task is (T^T u)^T J seen from the base
    shift = task_jacobian(robot, q, task) @ np.linalg.pinv(task_jacobian(robot, q, here))
    weakest, at = shift.T @ block(robot, q, task, 0).u2[:, rank], block(robot, q, here, 0)
    weakest = weakest / np.linalg.norm(weakest)
    u = np.column_stack([np.linalg.svd(weakest[None])[2][1:].T, weakest])
    jacobian, slopes = at.u2 @ at.f @ at.v2.T, np.einsum("ap,psk,js->ajk", at.u2, at.d, at.v2)
    strong, weak = (u.T @ jacobian)[:rank], (u.T @ jacobian)[rank]
    left = u[:, rank] - u[:, :rank] @ np.linalg.lstsq(strong.T, weak, rcond=None)[0]
    over = np.linalg.svd(strong)[2][rank:]
    f, d = over @ jacobian.T @ left, np.einsum("a,ajk,bj->bk", left, slopes, over) * scale
    return float(np.linalg.norm(np.linalg.lstsq(d, f, rcond=1e-7)[0]))


def measured(monitor: Monitor, q: Array) -> Array:
    """(B, F) what a monitor takes for the distance of each family."""
    far = first_order(monitor, q)
    regular = monitor.look(q).corank == 0
    for k in np.flatnonzero([lengthy(family) for family in monitor.families]):
        far[regular, k] = [monitor.nearby(one).distance[k] for one in q[regular]]  # held against the search below
    within = np.maximum(2 * far.min(axis=1), monitor.start)
    for row, k in np.argwhere(far <= within[:, None]):
        far[row, k] = walked(monitor, monitor.families[k], q[row], float(far[row, k]))
    return far


def watched(name: str) -> tuple[Monitor, Array]:
    """A monitor, and configurations of every kind: random, near a family, on it, at round numbers."""
    found = shipped(name)
    rng = np.random.default_rng(9)
    on = [members(found.robot, found.task, family, 4, seed=8) for family in found.families]
    random = rng.uniform(-3, 3, (37, found.robot.n))
    near = np.concatenate(on) + rng.normal(size=np.concatenate(on).shape) * 1e-5
    q = np.concatenate([random, near, *on, np.zeros((1, found.robot.n))])
    return Monitor(found.robot, found.task, found.families), q


@pytest.mark.slow_at("gen3")
@pytest.mark.parametrize("name", ARMS)
def test_rank_and_directions_are_those_of_the_decomposition(name):
    monitor, q = watched(name)
    seen = monitor.look(q)
    np.testing.assert_array_equal(seen.sigma, singular_values(monitor.robot, q, monitor.task))
    assert set(seen.corank) >= {0, 1}
    np.testing.assert_array_equal(seen.rank, (seen.sigma[:, : monitor.generic_rank] > 1e-9).sum(axis=1))
    np.testing.assert_array_equal(seen.corank, monitor.generic_rank - seen.rank)
    j = task_jacobian(monitor.robot, q, monitor.task)
    m = j.shape[1]
    assert monitor.generic_rank == m
    assert np.abs(seen.u.swapaxes(1, 2) @ seen.u - np.eye(m)).max() < 1e-13
    for row in range(len(q)):
        lost = seen.u[row][:, seen.rank[row] :]
        assert np.abs(lost.T @ j[row]).max(initial=0.0) < 2e-9
        still = seen.v[row][:, seen.rank[row] :]
        assert np.abs(j[row] @ still).max(initial=0.0) < 2e-9


@pytest.mark.slow_at("gen3")
@pytest.mark.parametrize("name", ARMS)
def test_residuals_and_families_are_those_of_the_equations(name):
    monitor, q = watched(name)
    seen = monitor.look(q)
    want = residuals(monitor, q)
    nearest, far = want[np.arange(len(q)), seen.nearest], measured(monitor, q)
    # √|f| makes a difference of 1e-15 in f, a few hundred terms, one of 3e-8
    np.testing.assert_allclose(far[np.arange(len(q)), seen.nearest], far.min(axis=1), rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(seen.distance, far.min(axis=1), rtol=1e-6, atol=1e-7)
    named = seen.family >= 0
    assert named.sum() >= 4 * len(monitor.families)
    own = np.where(named, want[np.arange(len(q)), seen.family], nearest)
    for row in np.flatnonzero((seen.corank == 0) & [lengthy(monitor.families[k]) for k in seen.nearest]):
        own[row] = first_by_kinematics(monitor, monitor.families[seen.nearest[row]], q[row])
    np.testing.assert_allclose(own, seen.residual, rtol=1e-9, atol=1e-7)
    coranks = np.array([family.corank for family in monitor.families])
    assert (coranks[seen.family[named]] <= seen.corank[named]).all()
    assert (seen.corank[named] > 0).all()
    for row in np.flatnonzero(named):
        on = np.flatnonzero(want[row] <= 1e-5)
        held = [monitor.families[i] for i in on if coranks[i] <= seen.corank[row]]
        best = max(((f.corank, -f.dimension) for f in held), default=(0, 0))
        chosen = monitor.families[seen.family[row]]
        if seen.residual[row] <= 1e-5:
            assert (chosen.corank, -chosen.dimension) == best
        else:
            assert chosen.corank == seen.corank[row] > best[0]


@pytest.mark.slow_at("gen3")
@pytest.mark.parametrize("name", ARMS)
def test_without_conditions_the_distance_is_sigma_over_its_slope(name):
    known, q = watched(name)
    monitor = Monitor(known.robot, known.task, ())
    seen, r = monitor.look(q), monitor.generic_rank
    scale = joint_scale(monitor.robot, monitor.task)
    for row in np.flatnonzero(seen.corank == 0)[:20]:
        if r > 1 and seen.sigma[row, r - 2] - seen.sigma[row, r - 1] < 1e-3:
            continue  # next to a tie the slope is that of one of several
        d = block(monitor.robot, q[row], monitor.task, r - 1)
        slope = np.array([
            (singular_values(monitor.robot, q[row] + 1e-6 * e * scale, monitor.task)[r - 1]
             - singular_values(monitor.robot, q[row] - 1e-6 * e * scale, monitor.task)[r - 1]) / 2e-6
            for e in np.eye(len(scale))
        ])  # fmt: skip
        assert d.sigma[r - 1] == seen.sigma[row, r - 1]
        if seen.sigma[row, r - 1] > 1e-4:
            assert seen.distance[row] == pytest.approx(seen.sigma[row, r - 1] / np.linalg.norm(slope), rel=1e-4)
    assert (seen.distance[seen.corank > 0] == 0).all()


@pytest.mark.slow_at("gen3")
@pytest.mark.parametrize("name", ARMS)
def test_one_at_a_time_gives_the_same_bits(name):
    monitor, q = watched(name)
    seen = monitor.look(q)
    for row in range(0, len(q), 5):
        one = monitor.look_one(q[row])
        np.testing.assert_array_equal(one.sigma, seen.sigma[row])
        np.testing.assert_array_equal(one.u, seen.u[row])
        assert (one.rank, one.corank, one.family, one.nearest) == (
            seen.rank[row], seen.corank[row], seen.family[row], seen.nearest[row],
        )  # fmt: skip
        assert (one.residual, one.distance) == (seen.residual[row], seen.distance[row])
    assert monitor.look_one(q[0].tolist()).rank == seen.rank[0]


def test_powers_of_prismatic_joints_are_differentiated():
    """q3² sin θ2 + q3 q1 = 0 on an arm with three variables of all kinds."""
    robot = arms.random_chain(np.random.default_rng(1), "rpr")
    task = resolve_task("vx,vy,vz", robot)
    terms = (Term(1.0, "sin", (0, 2, 0), (0, 0, 2)), Term(0.7, "cos", (0, 0, 0), (1, 0, 1)),
             Term(0.3, "cos", (2, 0, -2), (0, 1, 0), 0.4))  # fmt: skip
    family = replace(shipped("planar3r").families[0], equations=(Equation(terms),))
    monitor = Monitor(robot, task, [family])
    q = np.random.default_rng(2).uniform(-1, 1, (23, 3))
    assert np.abs(monitor.look(q).residual - residuals(monitor, q)[:, 0]).max() < 1e-13


def test_without_families_nothing_is_named():
    found = shipped("pa10")
    seen = Monitor(found.robot, found.task, ()).look(np.zeros((2, 7)))
    assert (seen.family == -1).all()
    assert (seen.nearest == -1).all()
    assert np.isinf(seen.residual).all()
    assert (seen.corank == 3).all()
    unnamed = replace(found.families[0], equations=(), named=False)
    assert Monitor(found.robot, found.task, [unnamed]).look_one(np.zeros(7)).family == -1


def test_the_index_is_that_of_the_families_handed_in():
    found = shipped("pa10")
    q = members(found.robot, found.task, found.families[0], 3)
    for order in (found.families, found.families[::-1]):
        seen = Monitor(found.robot, found.task, order).look(q)
        assert [order[i].id for i in seen.family] == [found.families[0].id] * 3


def test_broken_input_is_refused():
    found = shipped("pa10")
    monitor = Monitor(found.robot, found.task, found.families)
    for bad in (np.zeros((2, 6)), np.full((1, 7), np.inf)):
        with pytest.raises(ConfigurationError):
            monitor.look(bad)
        with pytest.raises(ConfigurationError):
            monitor.look_one(bad[0])
    assert monitor.look(np.zeros((0, 7))).u.shape == (0, 6, 6)
    ur5 = shipped("ur5")
    with pytest.raises(OptionError, match="another number of joints"):
        compile_families(found.families, ur5.robot, ur5.task)


def test_the_nearest_family_of_an_arm_of_pinned_joints_is_the_nearest_there_is(rng: np.random.Generator) -> None:
    """Conditions of another length are no other measure: 139 of 1,000 were said to be nearest to a crossing of two."""
    found = shipped("pa10")
    q = rng.uniform(-np.pi, np.pi, (200, 7))
    far = distances(found.families, found.robot, q, found.task).distance
    seen = Monitor(found.robot, found.task, found.families).look(q)
    np.testing.assert_allclose(far[np.arange(len(q)), seen.nearest], far.min(axis=1), atol=1e-9)
    assert {found.families[i].corank for i in seen.nearest} == {1}


@pytest.mark.by_hand_at("canadarm2", "panda", "ur5", "xarm6")
@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5", "puma560", "pa10", "panda", "canadarm2", "stanford", "xarm6"])
def test_the_distance_does_not_contradict_the_search(name: str) -> None:
    """Within 5 % of the nearest singular configuration in 95 %, above it by over 20 % in 1 % at most."""
    found = shipped(name)
    monitor = Monitor(found.robot, found.task, found.families)
    q = sample(found.robot, found.task, 200, 78)
    far = monitor.distances(q)
    ratio = monitor.look(q).distance / far.nearest()[1]
    assert (np.abs(ratio - 1) < 0.05).mean() >= 0.95
    assert (ratio > 1.2).mean() <= 0.01
    for row in range(0, 200, 20):
        seen = monitor.step(q[row])
        assert 0.0 < seen.at_least == far.at_least[row] <= far.nearest()[1][row]


@pytest.mark.by_hand
@pytest.mark.slow_at("sawyer", "gen3", "rizon4")
@pytest.mark.parametrize("name", ["gen3", "sawyer", "rizon4"])
def test_where_conditions_are_long_the_distance_is_right_near_and_far(name: str) -> None:
    """By the kinematics, from points of the set: from q alone walks were right in four of five random ones."""
    found = shipped(name)
    monitor = Monitor(found.robot, found.task, found.families)
    family = next(one for one in found.families if lengthy(one))
    rng = np.random.default_rng(4)
    on = members(found.robot, found.task, family, 120, seed=3)
    beside = on + rng.normal(size=on.shape) * 10.0 ** rng.uniform(-4, -1.3, (len(on), 1))
    q = np.concatenate([beside, sample(found.robot, found.task, 300, 79)])
    truth = monitor.distances(q).nearest()[1]
    ratio = monitor.look(q).distance / truth
    near = truth < 0.2
    assert near.sum() >= 100
    assert (np.abs(ratio[near] - 1) < 0.05).mean() >= 0.95
    assert (ratio[near] > 1.2).mean() <= 0.03
    assert (np.abs(ratio[len(on) :] - 1) < 0.05).mean() >= 0.95
    assert (ratio[len(on) :] > 1.2).mean() <= 0.02


def test_a_monitor_without_families_says_what_it_needs() -> None:
    with pytest.raises(OptionError, match=r"families: a monitor needs the families that it watches.*analyze"):
        Monitor(shipped("scara").robot)
