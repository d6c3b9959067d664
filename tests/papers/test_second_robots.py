"""What the documents do, each on a robot that is in none of them: one law for every row of what they describe.

The documents' own robots are almarkhi4 and pa10 (AM), planar2r, puma560 and the elbow arm (ML, JL), rcrrrr (GR) and
canadarm2 (KG). A law holds for every robot, so that nothing here is tuned to one.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations
from math import comb

import numpy as np
import pytest

pytest.importorskip("flint")

from papers.am_method import mixture_falls
from papers.planar import planar_two_link
from rankdrop import (
    conditions,
    explain,
    jacobian,
    jacobian_derivative,
    open_robot,
    pose,
    redundancy,
    search,
    singular_values,
)
from rankdrop.exact import METHODS, ZeroDistances, decouple, derive, exact_chain, suppress
from rankdrop.families import Outcome, refine, singular_curves
from rankdrop.kinematics import task_jacobian
from rankdrop.local import (
    OrderedScrewSet,
    decompose,
    failures_at,
    generic_rank,
    gradient_tensor,
    hunt,
    lie_product,
    lost_directions,
    lost_in_sparsest_frame,
    motion,
    null_space_motion,
    plane_rotation,
    rate_growth,
    readable_basis,
    relations_at,
    report,
    representation_at,
    sample,
    self_motion,
    session,
    tied_gradients,
)
from rankdrop.local.orientation import analytical_jacobian
from rankdrop.results import known_analysis
from rankdrop.robot import from_dh
from rankdrop.robot.arm_reach import reach
from rankdrop.task import BODY, SPACE, Frame, Task, resolve_task
from rankdrop.verbs import link_jacobian, most_tolerant

H = 1e-6  # of central differences [rad]
SMALL = 1e-9


@cache
def seven():
    """(robot, task): a 7R arm with offsets between its axes."""
    robot = open_robot("panda")
    return robot, resolve_task("pose", robot)


@cache
def six():
    """(robot, task): a 6R arm with a spherical wrist and offsets."""
    robot = open_robot("irb140")
    return robot, resolve_task("pose", robot)


@cache
def regional():
    """(robot, task): a 4R arm for positions, its lengths and angles taken at will."""
    rows = [(0.3, "pi/2", 0.4, 0), (0.7, "pi/3", 0.1, 0), (0.5, "-pi/2", 0, 0), (0.6, 0, 0.2, 0)]
    robot = from_dh(rows, convention="standard", task="position", name="regional")
    return robot, resolve_task(None, robot)


@cache
def singular(corank=1):
    """(20, 7) singular configurations of the 7R arm."""
    robot, task = seven()
    return search(robot, corank, task=task, starts=60, seed=3).converged[:20]


@cache
def wrist_aligned():
    """(6,) the 6R arm with θ5 = 0, nothing else special."""
    return np.array([0.4, 0.3, -0.5, 0.9, 0.0, 0.7])


def minors(J):
    """The maximal minors of (6, n)."""
    return [float(np.linalg.det(J[:, list(joints)])) for joints in combinations(range(J.shape[1]), 6)]


# AM


def test_am_1_all_minors_vanish_and_a_reciprocal_wrench_does_no_work():
    robot, task = seven()
    for q in singular():
        J = jacobian(robot, q)
        found = minors(J)
        assert len(found) == comb(7, 6)
        assert max(map(abs, found)) < SMALL
        assert abs(np.linalg.det(J @ J.T)) < SMALL
        assert np.abs(lost_directions(robot, q, task, 1) @ J).max() < 1e-7


def test_am_eq_2_joint_rates_make_the_twist_and_stay_free_in_the_null_space():
    robot, task = seven()
    q, twist = sample(robot, task, 1, 1)[0], np.array([0.1, -0.2, 0.3, 0.2, 0.1, -0.1])
    made = [null_space_motion(robot, q, twist, rates, task) for rates in (np.zeros(7), np.arange(7.0))]
    assert np.abs(jacobian(robot, q) @ np.transpose(made) - twist[:, None]).max() < SMALL
    assert np.linalg.norm(made[0] - made[1]) > 0.1


@pytest.mark.parametrize("name", ["stanford", "fetch8", "panda"])
def test_am_eqs_5_to_10_gradients_of_singular_values_and_the_derivative_of_j(name):
    robot = open_robot(name)
    task = resolve_task("pose", robot)
    q = sample(robot, task, 1, 2)[0]
    steps = H * np.eye(robot.n)
    slope = [(jacobian(robot, q + e) - jacobian(robot, q - e)) / (2 * H) for e in steps]
    assert np.abs(jacobian_derivative(robot, q) - np.stack(slope, axis=-1)).max() < 1e-8
    tensor = gradient_tensor(robot, q, task, 3)[1]
    slope = [(singular_values(robot, q + e, task) - singular_values(robot, q - e, task)) / (2 * H) for e in steps]
    assert np.abs(np.einsum("aan->an", tensor) - np.transpose(slope)[3:]).max() < 1e-7
    parts = decompose(robot, q, task)
    assert np.abs(parts.u * parts.sigma @ parts.v[:, :6].T - task_jacobian(robot, q, task)).max() < SMALL


def test_am_eq_11_steepest_descent_finds_singular_configurations_and_never_goes_up():
    robot, task = six()
    found = search(robot, 1, task=task, starts=40, seed=0, method="gradient", history=True)
    assert found.count(Outcome.CONVERGED) > 35
    assert singular_values(robot, found.converged, task)[:, 5].max() < 1e-6
    assert np.nanmax(np.diff(found.history.sigma[:, :, 5], axis=1)) < 1e-12


def tie():
    """A configuration of the 7R arm where σ5 = σ6 > 0, by Newton's method, and the tensor of the two."""
    robot, task = seven()
    for start in sample(robot, task, 40, 4):
        q = start.copy()
        for _ in range(60):
            sigma, tensor = gradient_tensor(robot, q, task, 4)
            gap = sigma[4] - sigma[5]
            rows = np.array([tensor[0, 0] - tensor[1, 1], tensor[0, 1] + tensor[1, 0]])
            q = q - np.linalg.lstsq(rows, np.array([gap, 0.0]), rcond=None)[0] * min(1.0, 0.3 / max(gap, 1e-9))
            if gap < 1e-12:
                return q, gradient_tensor(robot, q, task, 4)
    raise AssertionError("no tie")


def test_am_eqs_12_and_13_at_a_tie_any_rotation_is_valid_and_a_mixture_descends_both():
    robot, task = seven()
    q, (sigma, tensor) = tie()
    assert sigma[5] > 0.01
    J, parts = task_jacobian(robot, q, task), decompose(robot, q, task)
    turned = plane_rotation(2, 0, 1, 0.7)
    each = np.einsum("ai,ab,bi->i", parts.u[:, 4:] @ turned, J, parts.v[:, 4:6] @ turned)
    assert np.abs(each - sigma[4:]).max() < 1e-8
    turns = [plane_rotation(2, 0, 1, phi) for phi in np.linspace(0.0, np.pi, 31)]
    ways = [
        gamma * one + (1 - gamma) * other
        for one, other in (tied_gradients(tensor, turn) for turn in turns)
        for gamma in np.linspace(0.0, 1.0, 11)
    ]
    down = -np.array([way / np.linalg.norm(way) for way in ways])
    assert (singular_values(robot, q + 1e-5 * down, task)[:, 4] < sigma[4]).any()
    assert mixture_falls(tensor)[1] > 0.0


@pytest.mark.slow
def test_am_2_2_3_ties_are_treated_on_the_way_to_higher_ranks():
    robot = open_robot("iiwa7")
    plain, treated = (search(robot, 2, starts=300, seed=2, method=method) for method in ("gradient", "almarkhi"))
    one, other = (found.outcome == Outcome.CONVERGED for found in (plain, treated))
    assert singular_values(robot, treated.converged, treated.task)[:, 4].max() < 1e-6
    stuck = plain.outcome == Outcome.CREASE
    sigma = singular_values(robot, plain.q[stuck], plain.task)
    assert (sigma[:, 4] - sigma[:, 5] < 0.05 * sigma[:, 4]).all(), "on a crease values tie"
    assert (other & ~one).sum() > 3 * (one & ~other).sum()


def test_am_2_3_readable_directions_span_the_same_motions_with_fewer_entries():
    robot, task = seven()
    q = singular(2)[0]
    lost = lost_directions(robot, q, task, 2)
    mixed = lost.T @ plane_rotation(2, 0, 1, 0.6)
    readable = readable_basis(mixed)
    assert np.abs(readable @ readable.T @ mixed - mixed).max() < SMALL
    assert np.abs(readable).sum() <= np.abs(mixed).sum() + SMALL
    told = lost_in_sparsest_frame(robot, q, task, 2)
    assert (np.abs(told.directions) > 1e-6).sum() <= (np.abs(lost) > 1e-6).sum()


@pytest.mark.slow
def test_am_figure_5_the_singular_set_of_another_4r_arm_is_closed_curves():
    robot, task = regional()
    found = singular_curves(robot, (2, 3, 4), starts=60, step=0.05)
    assert found
    for curve in found:
        assert curve.closed
        assert singular_values(robot, curve.q, task)[:, 2].max() < SMALL
        assert np.ptp(np.linalg.norm(pose(robot, curve.q)[:, :3, 3], axis=1)) > 0.1, "it is no self-motion"
    points = np.concatenate([curve.q[:, 1:] for curve in found])
    for q in search(robot, 1, task=task, starts=60, seed=77).converged:
        off = (points - q[1:] + np.pi) % (2 * np.pi) - np.pi
        assert np.linalg.norm(off, axis=1).min() < 0.05


def test_am_3_2_no_failure_leaves_more_than_the_bound():
    robot, task = regional()
    found = most_tolerant(robot, task, relative=True, starts=20)
    best = found.places[0]
    assert 0.0 < best.value <= np.sqrt((4 - 3) / 4) + SMALL
    left = failures_at(robot, best.q, task)
    without = [np.linalg.svd(np.delete(task_jacobian(robot, best.q, task), j, axis=1))[1][2] for j in range(4)]
    assert [one.sigma_min for one in left.single] == pytest.approx(without)
    top = singular_values(robot, best.q, task)[0]
    assert best.value == pytest.approx(left.worst.sigma_min / top), "the search and the explanation agree"
    others = [failures_at(robot, q, task) for q in sample(robot, task, 50, 8)]
    sigma1 = singular_values(robot, sample(robot, task, 50, 8), task)[:, 0]
    assert max(one.worst.sigma_min / top for one, top in zip(others, sigma1, strict=True)) <= best.value + SMALL


def test_am_tables_3_to_5_every_row_is_a_family_of_its_rank():
    robot = open_robot("iiwa7")
    task = resolve_task(None, robot)
    analysis = known_analysis(robot, task)
    assert [summary.corank for summary in analysis.coranks if summary.converged] == [1, 2, 3]
    for family in analysis.families:
        q = np.array(family.witness)
        q[[number - 1 for number in family.free]] += 0.37
        assert (singular_values(robot, q, task) < 1e-9).sum() == family.corank


# ML


@pytest.mark.parametrize("name", ["panda", "irb140", "scara"])
def test_ml_the_rank_is_the_same_in_every_frame(name):
    robot = open_robot(name)
    q = sample(robot, resolve_task("pose", robot), 3, 3)
    q[1:, -2] = 0.0
    ranks = [
        [int((np.linalg.svd(jacobian(robot, one, frame))[1] > SMALL).sum()) for one in q]
        for frame in (SPACE, BODY, Frame(2, 2), Frame(3, 0, (0.1, 0.2, 0.3)))
    ]
    assert all(row == ranks[0] for row in ranks)


def test_ml_rates_without_bound_wrenches_without_torque_poses_without_number():
    robot, task = six()
    q = wrist_aligned()
    assert rate_growth(robot, q, [0, 0, 0, 0, 1, 0], task).power == pytest.approx(1.0, abs=0.02)
    wrench = explain(robot, q).lost.directions[0]
    assert np.linalg.norm(wrench) > 0.5
    assert np.abs(jacobian(robot, q).T @ wrench).max() < 1e-8
    turned = [pose(robot, q + angle * np.array([0, 0, 0, 1, 0, -1])) for angle in (0.7, -1.9)]
    assert np.abs(np.array(turned) - pose(robot, q)).max() < SMALL
    around = self_motion(robot, q, task, length=0.5, direction=[0, 0, 0, 1, 0, -1], limits=False)
    assert np.abs(pose(robot, around.q) - pose(robot, q)).max() < 1e-8
    assert around.length > 0.4


def test_ml_the_stretched_arm_is_on_the_boundary_of_its_workspace():
    robot = open_robot("planar3r")
    task = resolve_task("planar-position", robot)
    q = np.array([0.4, 0.0, 0.0])
    tip = pose(robot, q)[:3, 3]
    assert np.linalg.norm(tip) == pytest.approx(reach(robot))
    lost = lost_directions(robot, q, task, 1)[0]
    assert np.abs(np.cross(lost[:3], tip)).max() < SMALL


def test_ml_singularities_of_coordinates_are_not_those_of_the_arm():
    robot, task = six()
    regular = sample(robot, task, 1, 5)[0]
    for one in representation_at(robot, regular).every:
        size = np.linalg.svd(analytical_jacobian(robot, regular, one.name))[1][5]
        assert one.singular == bool(size < SMALL), one.name
    at_wrist = representation_at(robot, wrist_aligned())
    assert at_wrist.arm.corank == 1
    assert not at_wrist.rotvec.singular


def test_ml_the_jacobian_in_a_link_and_its_inverse():
    robot = open_robot("planar3r")
    q, rows = np.array([0.3, 0.5, 0.9]), [0, 1, 5]
    found = link_jacobian(robot, 1, inverse=True, q=q)
    assert found.holds
    assert np.abs(found.numbers.matrix @ found.numbers.inverse - np.eye(3)).max() < SMALL
    assert np.abs(found.numbers.matrix - jacobian(robot, q, Frame(1, -1))[rows]).max() < SMALL
    assert found.numbers.determinant == pytest.approx(np.linalg.det(jacobian(robot, q)[rows]))


def test_ml_joint_rates_of_a_planar_arm_of_other_lengths():
    robot = from_dh([(0.4, 0, 0, 0), (1.1, 0, 0, 0)], convention="standard")
    for theta2 in (0.3, -1.2, 1e-3):
        J = jacobian(robot, [0.6, theta2], Frame(1, -1))[:2]
        found = planar_two_link(0.4, 1.1, theta2)
        assert np.abs(np.linalg.inv(J) @ J - found.inverse @ J).max() < 1e-6
        assert found.determinant == pytest.approx(np.linalg.det(J))
        assert np.transpose([found.rates_x, found.rates_y]) == pytest.approx(np.linalg.inv(J))


# ML and JL


def test_ml_jl_an_arm_with_a_spherical_wrist_comes_apart():
    robot, task = six()
    found = decouple(exact_chain(robot))
    arm, wrist = found.blocks
    assert wrist.parts[0].text == "θ5 = 0 or π"
    q = sample(robot, task, 10, 6)
    centre = jacobian(robot, q, Frame(0, 5))
    parts = np.linalg.det(centre[:, :3, :3]) * np.linalg.det(centre[:, 3:, 3:])
    assert np.abs(centre[:, :3, 3:]).max() < SMALL
    assert np.abs(np.linalg.det(jacobian(robot, q)) - parts).max() < SMALL
    assert len(arm.parts) == 2


def test_ml_jl_the_wrist_loses_the_rotation_square_to_axes_4_and_5():
    robot, _ = six()
    q = wrist_aligned()
    assert any(relation.words == "axes 4, 6 aligned" for relation in relations_at(robot, q))
    z = jacobian(robot, q)[3:]
    (lost,) = lost_directions(robot, q, Task("pose", (0, 1, 2, 3, 4, 5), Frame(0, 5), 1.0), 1)
    assert np.linalg.norm(lost[3:]) > 0.1
    assert np.abs(lost[3:] @ z[:, 3:5]).max() < SMALL


def test_ml_jl_elbow_and_shoulder_of_an_arm_with_offsets():
    robot, task = six()
    families = conditions(robot, coranks=1, points=0, special=False).families
    words = " ".join(family.name for family in families)
    assert len(families) == 3
    assert all(name in words for name in ("elbow", "shoulder", "wrist")), words
    for family in families:
        q = np.array(family.witness)
        assert (singular_values(robot, q, task) < SMALL).sum() == 1
        centre = jacobian(robot, q, Frame(0, 5))
        block = centre[3:, 3:] if family.name.startswith("wrist") else centre[:3, :3]
        assert abs(np.linalg.det(block)) < SMALL
        if family.name.startswith("shoulder"):  # parallel to axis 2
            (lost,) = lost_directions(robot, q, Task("wrist centre", (0, 1, 2), Frame(0, 5), 1.0), 1)
            assert np.abs(np.cross(lost[:3], centre[3:, 1])).max() < 1e-6


# GR


@cache
def ordered():
    """The screws of the 7R arm where it is singular."""
    robot, _ = seven()
    return OrderedScrewSet.of(robot, singular()[0])


def test_gr_the_lie_product_is_the_derivative_of_a_motion():
    A, B = ordered().screws[2], ordered().screws[4]
    assert np.abs((motion(A, H) @ B - motion(A, -H) @ B) / (2 * H) - lie_product(A, B)).max() < 1e-8
    assert np.abs(lie_product(A, B) + lie_product(B, A)).max() == 0.0
    assert np.abs(ordered().lie(3, 5) - lie_product(A, B)).max() < SMALL


def test_gr_runs_dimensions_and_the_session():
    screws = ordered()
    for run in screws.subsets():
        rows = screws.screws[run.first - 1 : run.last]
        assert screws.dimension(run.first, run.last) == np.linalg.matrix_rank(rows, tol=1e-7) < len(rows)
    first = next(run for run in screws.subsets() if run.minimal)
    rows = screws.screws[first.first - 1 : first.last]
    for u, v, inside in screws.subspace(first.first, first.last).entries:
        grown = np.vstack([rows, screws.lie(u, v)])
        assert inside == (np.linalg.matrix_rank(grown, tol=1e-7) == len(rows) - 1), (u, v)
    ((_, lines),) = session(screws, (("dimension", first.first, first.last),))
    assert lines == (str(len(rows) - 1),)


def test_gr_escapes_are_those_of_finite_motion():
    robot, task = seven()
    q, found = singular()[0], report(ordered())
    assert (found.generic, found.dimension, found.lost) == (6, 5, 1)
    for joint in found.joints:
        step = np.zeros(7)
        step[joint.number - 1] = 0.1
        gained = int((singular_values(robot, q + step, task) > 1e-6).sum()) - 5
        assert joint.gain == gained, joint.number
        assert joint.escapes == (joint.number in found.escapes) == (gained == 1)


def test_gr_hunt_s_cofactors_agree_with_finite_motion():
    robot, task = six()
    found = hunt(robot, wrist_aligned(), task)
    assert found.applies
    assert all(one.tells == one.escapes for one in found.joints)
    J = task_jacobian(robot, wrist_aligned(), task)
    entries = np.array(found.matrix)
    assert np.abs(entries.T @ J).max() < 1e-8, "columns of cofactors are reciprocal to every screw"


def test_gr_a_plain_file_of_screws_opens(tmp_path):
    robot, _ = seven()
    path = tmp_path / "screws.txt"
    np.savetxt(path, np.roll(jacobian(robot, np.zeros(7), SPACE).T, 3, axis=1), fmt="%.17g")
    read = open_robot(str(path))
    q = np.linspace(-0.6, 0.8, 7)
    sigma = [np.linalg.svd(jacobian(arm, q, SPACE))[1] for arm in (robot, read)]
    assert sigma[0] == pytest.approx(sigma[1], abs=1e-6)


# KG


ANOTHER = "iiwa7"


@cache
def chain():
    """A 7R arm that KG do not speak of."""
    return exact_chain(open_robot(ANOTHER))


@cache
def singular_of_another():
    """(N, 7) its singular configurations from random starts."""
    return search(open_robot(ANOTHER), 1, starts=60, seed=4).converged


def satisfied(q, polynomials):
    """(N,) the distance from where all of some polynomials vanish, estimated."""
    distances = ZeroDistances(chain(), q)
    return np.max([distances.of(p) for p in polynomials], axis=0)


def test_kg_the_families_are_disjoint_and_hold_every_singular_configuration():
    found = suppress(chain())
    assert found.complete
    assert all(max(family.ranks) < 6 for family in found.families)
    assert all(f.stratum.separating_polynomial(g.stratum) is not None for f, g in combinations(found.families, 2))
    q = singular_of_another()
    assert len(q) > 50
    assert np.min([satisfied(q, family.equalities) for family in found.families], axis=0).max() < 1e-5


def test_kg_a_dependent_screw_is_a_combination_of_those_it_is_said_to_be_of():
    found = suppress(chain(), frame=5, basic=range(2, 8))
    q, seen = singular_of_another(), 0
    for case in found.start.cases:
        if case.dependence is None or not case.stratum.equalities:
            continue
        there = jacobian(open_robot(ANOTHER), q[satisfied(q, case.stratum.equalities) < 1e-6])
        named = [case.dependence.screw, *case.dependence.on]
        seen += len(there)
        assert np.abs(np.linalg.det(there[:, :, 1:])).max(initial=0.0) < 1e-7
        assert np.linalg.matrix_rank(there[:, :, [j - 1 for j in named]], tol=1e-6).max(initial=0) < len(named)
    assert seen > 10


@pytest.mark.parametrize("method", METHODS)
def test_kg_each_approach_holds_at_singular_configurations_and_at_no_regular_one(method):
    robot = open_robot("irb140")
    found = derive(exact_chain(robot), method, 30.0)
    assert found.complete
    assert found.holds(search(robot, 1, starts=60, seed=4).converged).all()
    regular = sample(robot, resolve_task("pose", robot), 100, 5)
    assert not found.holds(regular[singular_values(robot, regular, resolve_task("pose", robot))[:, 5] > 0.02]).any()


@pytest.mark.slow
def test_kg_the_reciprocal_screw_says_nothing_where_its_five_are_dependent():
    what, facts = derive(chain(), "reciprocity", 30.0).notes[0]
    five = [joint - 1 for joint in facts["joints"]]
    alone = [one.equal[0].atoms for one in facts["vanishes"] if len(one.equal) == 1]
    pinned = {atom.joint - 1 for atoms in alone for atom in atoms if atom.is_pin}
    assert what == "screw"
    assert len(five) == 5
    assert pinned
    robot = open_robot(ANOTHER)
    q = sample(robot, resolve_task("pose", robot), 20, 6)
    assert np.linalg.matrix_rank(jacobian(robot, q)[:, :, five], tol=1e-7).min() == 5
    for joint in pinned:
        at = q.copy()
        at[:, joint] = np.pi
        assert np.linalg.matrix_rank(jacobian(robot, at)[:, :, five], tol=1e-7).max() < 5


# JL


@pytest.mark.parametrize("name", ["panda", "fetch8", "planar3r"])
def test_jl_range_null_space_and_projector(name):
    robot = open_robot(name)
    task = resolve_task("planar-position" if name == "planar3r" else "pose", robot)
    place = refine(robot, sample(robot, task, 5, 1), 1, task=task).converged[0]
    generic = generic_rank(robot, task)
    for q, lost in ((sample(robot, task, 1, 2)[0], 0), (place, 1)):
        found = redundancy(robot, q, task)
        rows = list(task.rows)
        assert found.check.holds
        assert (found.check.rank, found.check.nullity) == (generic - lost, robot.n - generic + lost)
        assert np.abs(jacobian(robot, q)[rows] @ found.null_basis.T).max() < 1e-6
        assert np.abs(jacobian(robot, q)[rows] @ found.projector).max() < 1e-6
        assert found.idempotent < SMALL
        assert np.trace(found.projector) == pytest.approx(found.check.nullity, abs=1e-6)
