"""Every circuit at one configuration: against brute force, in any frame and unit, in words."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import pi

import numpy as np
import pytest
from reference import arms

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.kinematics import task_jacobian
from rankdrop.local import circuits
from rankdrop.local.circuits import LARGEST_CHAIN, MOST_LISTED, Circuit, blame, circuits_at, shared_circuits, to_blame
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, prismatic, revolute
from rankdrop.task import resolve_task
from rankdrop.verbs.explain import explain

Z = (0, 0, 1)


def brute(columns: Array) -> list[tuple[int, ...]]:
    """Minimal dependent sets by trying every set, with NumPy's rank of unit columns."""
    length = np.linalg.norm(columns, axis=0)
    unit = columns / np.where(length > 1e-9, length, 1.0)
    found: list[tuple[int, ...]] = []
    for size in range(1, columns.shape[1] + 1):
        for chosen in combinations(range(columns.shape[1]), size):
            inside = any(set(small) <= set(chosen) for small in found)
            if not inside and np.linalg.matrix_rank(unit[:, chosen], tol=1e-7) < size:
                found.append(chosen)
    return found


def sets(found: tuple[Circuit, ...]) -> list[tuple[int, ...]]:
    return [circuit.numbers for circuit in found]


def at_zero(screws: list[Array], task: str = "pose") -> tuple[Circuit, ...]:
    robot = from_screws(screws, order="linear-first")
    return circuits_at(robot, np.zeros(robot.n), resolve_task(task, robot))


def test_the_arm_of_gr_has_four_circuits_and_screw_2_is_in_none() -> None:
    robot = open_robot("rcrrrr")
    found = circuits_at(robot, np.zeros(7), resolve_task("pose", robot))
    assert sets(found) == [(1, 3, 4, 5), (3, 4, 6, 7), (1, 3, 5, 6, 7), (1, 4, 5, 6, 7)]
    assert found[0].words == "axes 1, 3, 4, 5 coplanar"
    assert not any(circuit.generic for circuit in found)


@pytest.mark.parametrize("rows", [2, 3, 6])
def test_planted_dependencies_are_found_as_brute_force_finds_them(rows: int, rng: np.random.Generator) -> None:
    met = set()
    for trial in range(60):
        n = int(rng.integers(2, 9))
        columns = rng.integers(-1, 2, (rows, n)).astype(float)  # small integers: dependencies of every size, zeros too
        if trial % 3 == 0:
            columns[:, -1] = columns[:, :-1] @ rng.normal(size=n - 1)
        found = shared_circuits(columns[None])
        assert found == brute(columns)
        met |= {len(chosen) for chosen in found}
    assert met == set(range(1, rows + 2))


@pytest.mark.parametrize("size", [2, 3, 4, 5, 6])
def test_the_smallest_singular_value_decides_on_both_sides_of_the_tolerance(
    size: int, rng: np.random.Generator
) -> None:
    """Columns of length 1 whose smallest σ is planted next to the tolerance, the others as large as they can be."""
    for share in (0.5, 0.99, 1.01, 2.0):
        tilted = rng.standard_normal(size)
        tilted /= np.linalg.norm(tilted)
        columns = np.linalg.qr(rng.standard_normal((6, size)))[0] @ (np.eye(size) - np.outer(tilted, tilted))
        columns /= np.linalg.norm(columns, axis=0)
        u, sigma, v = np.linalg.svd(columns, full_matrices=False)
        planted = u * [*sigma[:-1], share * 1e-7] @ v
        assert shared_circuits(planted[None], 1e-7) == brute(planted)
        assert (len(shared_circuits(planted[None], 1e-7)) == 1) is (share < 1)


@pytest.mark.parametrize("name", ["pa10", "puma", "scara", "planar3r"])
@pytest.mark.parametrize("task", ["pose", "position", "own"])
def test_circuits_at_singular_configurations(name: str, task: str, rng: np.random.Generator) -> None:
    robot, q = arms.singular_configurations(name, rng, 9)
    resolved = resolve_task(None if task == "own" else task, robot)
    for configuration in q:
        found = circuits_at(robot, configuration, resolved)
        columns = task_jacobian(robot, configuration, resolved)
        assert sorted(sets(found)) == sorted(tuple(i + 1 for i in chosen) for chosen in brute(columns))
        assert found or name in {"scara"}
        for circuit in found:
            rates = np.zeros(robot.n)
            rates[[number - 1 for number in circuit.numbers]] = circuit.coefficients
            assert np.abs(columns @ rates).max() < 1e-9
            assert max(map(abs, circuit.coefficients)) == pytest.approx(1.0)
            assert 1.0 in circuit.coefficients
            assert min(map(abs, circuit.coefficients)) > 1e-9


def turned_joint(robot: Robot, i: int) -> Robot:
    joints = list(robot.joints)
    joints[i] = replace(joints[i], screw=-joints[i].screw)
    return replace(robot, joints=tuple(joints))


@pytest.mark.parametrize(("name", "q"), [
    ("rcrrrr", [0.0] * 7), ("pa10", [0.3, 0, 0.2, 0, 0.1, 0.4, 1]), ("stanford", [0.1, 0.2, 0.3, 0.4, 0.0, 0.6]),
    ("fetch8", [0.0] * 8),
])  # fmt: skip
def test_circuits_do_not_depend_on_base_tool_sign_scale_or_side(
    name: str, q: list[float], rng: np.random.Generator
) -> None:
    robot = open_robot(name)
    task = resolve_task("pose", robot)
    expected = circuits_at(robot, q, task)
    assert expected
    other = arms.remade(robot, motion=arms.rigid(rng, 3.0))
    for changed in (other, replace(robot, home=robot.home @ arms.rigid(rng))):
        found = circuits_at(changed, q, resolve_task("pose", changed))
        assert [(c.numbers, c.words, c.generic) for c in found] == [(c.numbers, c.words, c.generic) for c in expected]
        for a, b in zip(found, expected, strict=True):
            assert np.allclose(a.coefficients, b.coefficients, atol=1e-9)
    scaled = circuits_at(robot, q, replace(task, length_scale=0.2))
    assert [c.numbers for c in scaled] == [c.numbers for c in expected]
    assert all(np.allclose(a.coefficients, b.coefficients) for a, b in zip(scaled, expected, strict=True))
    turned = circuits_at(turned_joint(robot, 2), np.where(np.arange(robot.n) == 2, -1, 1) * np.array(q), task)
    assert [(c.numbers, c.words) for c in turned] == [(c.numbers, c.words) for c in expected]
    back = from_screws(task_jacobian(robot, q, replace(task, length_scale=1.0)).T[::-1], order="linear-first")
    reverse = circuits_at(back, np.zeros(robot.n), resolve_task("pose", back))
    mirrored = {tuple(sorted(robot.n + 1 - i for i in c.numbers)) for c in reverse}
    assert mirrored == {c.numbers for c in expected}


@pytest.mark.parametrize(("kinds", "count", "size"), [("rrrrrr", 0, 0), ("rrrrrrr", 1, 7), ("rrprrrrr", 8, 7)])
def test_a_regular_configuration_has_generic_circuits_only(
    kinds: str, count: int, size: int, rng: np.random.Generator
) -> None:
    robot = arms.random_chain(rng, kinds)
    task = resolve_task("pose", robot)
    found = circuits_at(robot, rng.uniform(-pi, pi, robot.n), task)
    assert [len(circuit.numbers) for circuit in found] == [size] * count
    assert all(circuit.generic for circuit in found)
    assert blame(robot, rng.uniform(-pi, pi, robot.n), task) == ()


def test_units_tell_a_slide_from_a_turn() -> None:
    found = at_zero([revolute(Z, (0, 0, 0)), prismatic((0, 1, 0)), revolute(Z, (2, 0, 0))])
    assert found[0].units == ("rad", "m", "rad")
    assert np.allclose(np.array(found[0].coefficients), [-0.5, 1.0, 0.5])  # 0.5 rad/s about each of two axes 2 m apart
    assert found[0].words == "axes 1, 3 parallel, slide 2 normal to their plane"


@pytest.mark.parametrize(("screws", "words"), [
    ([revolute(Z, (1, 0, 0)), revolute(Z, (1, 0, 4))], "axes 1, 2 aligned"),
    ([prismatic(Z), prismatic(Z)], "slides 1, 2 parallel"),
    ([prismatic((1, x, 0)) for x in (0, 1, 2)], "slides 1, 2, 3 parallel to one plane"),
    ([prismatic((1, x, x * x)) for x in (0, 1, 2, 3)], "slides 1–4 are four translations of space"),
    ([*(revolute(Z, (x, x * x, 0)) for x in (0, 1, 2)), prismatic((1, 0.3, 0))],
     "axes 1, 2, 3 parallel, slide 4 normal to them"),
    ([revolute(Z, (0, 0, 0)), revolute(Z, (1, 0, 0)), prismatic((1, 0, 1)), prismatic((1, 1, 1))],
     "axes 1, 2 parallel, slides 3, 4 along what they translate"),
    ([revolute((x, 1, x * x), (0, 0, z)) for x, z in ((0, 0), (1, 1), (2, 3), (3, -1), (-1, 2), (-2, 5))],
     "axes 1–6 meet one line"),
    ([*(revolute((x, 1, x * x), (0, 0, z)) for x, z in ((0, 0), (1, 1), (2, 3), (3, -1), (-1, 2))),
      prismatic((1, 2, 0))], "axes 1–5 meet one line, slide 6 normal to it"),
    ([revolute(Z, (0, 0, 0)), revolute(Z, (1, 0, 0)), *(prismatic(a) for a in ((1, 0, 0), (1, 0, 1), (1, 1, 2)))],
     "axes 1, 2 parallel, slides 3, 4, 5 along what they translate"),
])  # fmt: skip
def test_patterns_of_dependent_screws_have_names(screws: list[Array], words: str) -> None:
    found = at_zero(screws)
    assert [circuit.words for circuit in found if len(circuit.numbers) == len(screws)] == [words]


def test_six_dependent_axes_that_meet_no_line_are_only_dependent(rng: np.random.Generator) -> None:
    """Reciprocal to the wrench (z; 0.3 z): v·z + 0.3 ω·z = 0."""
    screws = []
    for direction, point in zip(rng.normal(size=(6, 2)), rng.normal(size=(6, 3)), strict=True):
        moment = point[0] * direction[1] - point[1] * direction[0]
        screws.append(revolute((*direction, -moment / 0.3), point))
    assert [circuit.words for circuit in at_zero(screws)] == ["joints 1–6 dependent"]


def test_circuits_of_a_family_hold_at_every_point_of_it(rng: np.random.Generator) -> None:
    points = rng.normal(size=(3, 6, 5))
    points[:, :, 4] = points[:, :, 0] - points[:, :, 3]
    points[1, :, 2] = points[1, :, 1]
    assert shared_circuits(points) == [(0, 3, 4)]
    assert shared_circuits(points[1:2]) == [(1, 2), (0, 3, 4)]


def test_blame_passes_over_what_follows_from_smaller_circuits() -> None:
    """Axes 1, 3, 5 on one line bring two dependencies, not three; the third is that of 2, 4, 6."""
    across = [revolute((1, 0, 0), (0, 0, z)) for z in (1, 3, 4)]
    screws = [revolute(Z, (0, 0, 0)), across[0], revolute(Z, (0, 0, 0)), across[1], revolute(Z, (0, 0, 0)), across[2]]
    robot = from_screws(screws, order="linear-first")
    found = blame(robot, np.zeros(6), resolve_task("pose", robot))
    assert sets(found) == [(1, 3), (1, 5), (2, 4, 6)]


def test_what_is_blamed_first_is_what_all_circuits_tell(rng: np.random.Generator) -> None:
    """Sets are looked at until enough are found: the same as of all of them."""
    for n, rank in ((7, 4), (9, 5), (10, 3)):
        columns = rng.standard_normal((6, rank)) @ rng.integers(-1, 2, (rank, n))
        usual = rng.standard_normal((8, 6, n))
        usual[:, :, 1] = usual[:, :, 0]  # dependent everywhere
        columns[:, 1] = columns[:, 0]
        every = [chosen for chosen in shared_circuits(columns[None]) if chosen != (0, 1) and not len(chosen) > 6]
        vectors: list[np.ndarray] = []
        wanted = []
        for chosen in every:
            vector = np.zeros(n)
            vector[list(chosen)] = np.linalg.svd(columns[:, chosen])[2][-1]
            if len(wanted) < 3 and np.linalg.matrix_rank([*vectors, vector], tol=1e-6) > len(vectors):
                vectors.append(vector)
                wanted.append(chosen)
        assert to_blame(columns[None], usual, 3) == wanted


def test_a_circuit_that_follows_from_smaller_ones_is_not_blamed(rng: np.random.Generator) -> None:
    """Four joints in a plane have four circuits of three and two dependencies."""
    columns = rng.standard_normal((6, 2)) @ rng.standard_normal((2, 4))
    assert len(shared_circuits(columns[None])) == 4
    assert to_blame(columns[None], rng.standard_normal((8, 6, 4)), 3) == [(0, 1, 2), (0, 1, 3)]


def test_a_circuit_of_several_points_holds_at_all_of_them(rng: np.random.Generator) -> None:
    first, second = rng.standard_normal((2, 6, 4))
    first[:, 1] = first[:, 0]
    first[:, 3] = second[:, 3] = 0.0
    assert shared_circuits(np.stack([first, second])) == [(3,)]
    assert shared_circuits(np.stack([second, first])) == [(3,)]


def test_what_a_task_of_fewer_rows_makes_dependent() -> None:
    planar = [revolute(Z, (0, 0, 0)), revolute(Z, (1, 0, 0))]
    home = np.eye(4)
    home[0, 3] = 2.0
    robot = from_screws(planar, order="linear-first", home=home)
    assert [c.words for c in circuits_at(robot, [0, 0], resolve_task("position", robot))] == [
        "axes 1, 2 and the tip in one plane"
    ]
    assert [c.words for c in circuits_at(robot, [0.3, 0.4], resolve_task("position", robot))] == []
    assert [c.words for c in circuits_at(robot, [0, 1], resolve_task("orientation", robot))] == ["axes 1, 2 parallel"]
    slide = from_screws([prismatic(Z), revolute(Z, (0, 0, 0))], order="linear-first", home=home)
    assert [c.words for c in circuits_at(slide, [0, 0], resolve_task("orientation", slide))] == [
        "joint 1 moves nothing"
    ]
    wrist = [revolute((1, x, 0), (x, 0, x)) for x in (0, 1, 2)]
    assert [c.words for c in at_zero(wrist, "orientation")] == ["axes 1, 2, 3 parallel to one plane"]


@pytest.mark.parametrize("name", ["pa10", "puma"])
def test_blame_brings_as_many_new_dependencies_as_rank_is_lost(name: str, rng: np.random.Generator) -> None:
    robot, q = arms.singular_configurations(name, rng, 18)
    task = resolve_task("pose", robot)
    told = 0
    for configuration in q:
        corank = 6 - np.linalg.matrix_rank(task_jacobian(robot, configuration, task), tol=1e-9)
        found = blame(robot, configuration, task)
        assert len(found) == corank
        assert not any(circuit.generic for circuit in found)
        told += len(found)
    assert told >= 18


def test_what_is_dependent_everywhere_is_not_blamed_for_what_is_lost_here(rng: np.random.Generator) -> None:
    """Joints 1 and 2 on one line always; at q3 = 0 joint 4 is on that line as well: one loss, blamed once."""
    axis = [revolute(Z, (0, 0, 0)), revolute(Z, (0, 0, 1)), revolute((1, 0, 0), (0, 0, 2)), revolute(Z, (0, 0, 0))]
    skew = arms.random_chain(rng, "rr").joints
    far = [skew[0].screw, skew[1].screw, skew[0].screw]  # axes 5 and 7 on one line at q6 = 0
    robot = from_screws([*axis, *far], order="linear-first")
    task = resolve_task("pose", robot)
    found = circuits_at(robot, np.zeros(7), task)
    told = [((1, 2), True), ((1, 4), False), ((2, 4), False), ((5, 7), False)]
    assert [(c.numbers, c.generic) for c in found] == told
    assert [c.numbers for c in blame(robot, np.zeros(7), task)] == [(1, 4), (5, 7)]


def test_twelve_joints_are_listed_and_more_than_the_cap_are_refused(rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrrprrrrrrrr")
    assert len(circuits_at(robot, np.zeros(12), resolve_task("pose", robot))) == 792  # every seven of twelve
    few = circuits_at(robot, np.zeros(12), resolve_task("pose", robot), most=5)
    assert [circuit.numbers[-1] for circuit in few] == [7, 8, 9, 10, 11]
    long = arms.random_chain(rng, "r" * (LARGEST_CHAIN + 1))
    with pytest.raises(OptionError, match="too many joints"):
        circuits_at(long, np.zeros(long.n), resolve_task("pose", long))


@pytest.mark.parametrize(("n", "listed", "complete"), [(8, 8, True), (14, MOST_LISTED, False)])
def test_an_explanation_lists_a_thousand_circuits_at_most_and_says_so(
    n: int, listed: int, complete: bool, rng: np.random.Generator
) -> None:
    robot = arms.random_chain(rng, "r" * n)
    found = explain(robot, rng.uniform(-3, 3, n), "pose")
    assert (len(found.blame.circuits), found.blame.complete) == (listed, complete)
    titles = [section.title for section in found.sections(full=True)]
    assert ("Every circuit" in titles, "The first 1,000 circuits" in titles) == (complete, not complete)


@pytest.mark.parametrize("q", [[0.0] * 6, [np.nan] * 7, [[0.0] * 7] * 2])
def test_one_finite_configuration_is_needed(q: list[float]) -> None:
    robot = open_robot("rcrrrr")
    with pytest.raises(ConfigurationError):
        circuits_at(robot, q, resolve_task("pose", robot))


def test_a_follower_is_part_of_its_leader(rng: np.random.Generator) -> None:
    robot = arms.random_chain(rng, "rrmrrrr")
    q = rng.normal(size=robot.n)
    assert robot.n == 6
    assert circuits_at(robot, q, resolve_task("pose", robot)) == ()
    assert [joint.kind for joint in robot.variables] == [JointKind.REVOLUTE] * 6


def test_circuits_of_one_size_are_taken_apart_together(monkeypatch: pytest.MonkeyPatch) -> None:
    shapes: list[tuple[int, ...]] = []
    svd = circuits.svd

    def counted(matrices: Array) -> tuple[Array, Array, Array]:
        shapes.append(matrices.shape)
        return svd(matrices)

    monkeypatch.setattr(circuits, "svd", counted)
    arm = open_robot("pa10")
    found = circuits_at(arm, [0.0] * 7, resolve_task(None, arm))
    sizes = [len(circuit.numbers) for circuit in found]
    assert [(count, size) for count, _, size in shapes] == [(sizes.count(size), size) for size in sorted(set(sizes))]
    assert max(sizes.count(size) for size in sizes) > 1
