"""Structure that holds but for noise: what is squared, what is kept, and how far anything moves."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, pi

import numpy as np
import pytest
from known.arms import KINDS
from reference.kinematics import exponential, pose

from rankdrop.exact.arm.geometry import sections
from rankdrop.results.known import known_analysis
from rankdrop.robot.arm_reach import extent
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Mimic, Robot
from rankdrop.robot.numbers import LinkNumbers, axis_lines, numbers_of
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.robot.square_up import meeting, square_up
from rankdrop.robot.transform import frame_on_axis
from rankdrop.robot.urdf import from_urdf
from rankdrop.task import resolve_task
from rankdrop.tolerances import MEETING, SQUARE
from robot.calibrated import noisy
from robot.urdf_text import joint, robot


@pytest.mark.spread(60)
@pytest.mark.slow
@pytest.mark.parametrize("name", robot_names())
def test_an_exact_arm_is_left_alone(name: str) -> None:
    arm = open_robot(name)
    found, changes = square_up(arm)
    assert found is arm
    assert changes == ()


@pytest.mark.spread(18)
@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_noise_is_taken_away_again(name: str, rng: np.random.Generator) -> None:
    arm = open_robot(name)
    found, changes = square_up(noisy(arm, rng))
    assert changes
    assert square_up(found)[0] is found
    for mine, true in zip(read(found), read(arm), strict=True):
        assert same_turn(mine.twist, true.twist, exact=is_fine(true.twist))
        assert same_turn(mine.phase, true.phase, exact=is_fine(true.phase))
        for one, other in ((mine.a, true.a), (mine.d, true.d)):
            assert (abs(one) < 1e-15) == (abs(other) < 1e-12), (mine, true)
            assert one == pytest.approx(other, abs=5e-6)


def read(arm: Robot) -> list[LinkNumbers]:
    return numbers_of(arm, angle=1e-6, length=1e-6)


def is_fine(angle: float) -> bool:
    return abs(angle / (pi / 12) - round(angle / (pi / 12))) < 1e-12


def same_turn(one: float, other: float, *, exact: bool) -> bool:
    return abs((one - other + pi) % (2 * pi) - pi) < (1e-14 if exact else 1e-4)


@pytest.mark.spread(24)
@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_the_arm_moves_by_no_more_than_its_noise_allows(name: str, rng: np.random.Generator) -> None:
    given = noisy(open_robot(name), rng)
    found, changes = square_up(given)
    limit = len(given.joints) * (2 * SQUARE * extent(given) + 3 * MEETING)
    for q in rng.uniform(-2, 2, (5, given.n)):
        assert np.abs(pose(found, q) - pose(given, q)).max() <= limit
    assert max(change.by for change in changes if change.turns) <= 2 * SQUARE


def test_all_else_is_kept(rng: np.random.Generator) -> None:
    arm = open_robot("panda")
    joints = (*arm.joints[:-1], replace(arm.joints[-1], mimic=Mimic("panda_joint5", 2.0, 0.1)))
    arm = replace(arm, joints=joints, notes=("a note",), lengths=(("b", 0.088),))
    found, changes = square_up(noisy(arm, rng))
    assert changes
    for one, other in zip(found.joints, arm.joints, strict=True):
        assert [getattr(one, key) for key in KEPT] == [getattr(other, key) for key in KEPT]
    keys = ("name", "task", "source", "base", "tip", "notes", "about", "lengths")
    assert [getattr(found, key) for key in keys] == [getattr(arm, key) for key in keys]


KEPT = ("name", "kind", "lower", "upper", "velocity", "mimic")


def test_axes_parallel_but_for_noise_are_parallel_to_the_bit(rng: np.random.Generator) -> None:
    found, _ = square_up(noisy(open_robot("ur5e"), rng))
    assert np.array_equal(found.joints[1].screw[3:], found.joints[2].screw[3:])
    assert np.array_equal(found.joints[1].screw[3:], found.joints[3].screw[3:])


def table(**changed: float) -> Robot:
    """An arm whose first two axes cross at right angles and whose last two are parallel, but for what is changed."""
    rows = {"alpha1": pi / 2, "a1": 0.0, "alpha2": 0.0, "d2": 0.0} | changed
    first = (rows["a1"], rows["alpha1"], 0.3, 0.0)
    return from_dh([first, (0.4, rows["alpha2"], rows["d2"], 0.0), (0.2, 0.0, 0.0, 0.0)], convention="standard")


@pytest.mark.parametrize(
    ("changed", "inside"),
    [
        ({"alpha1": pi / 2 + 1.99e-5}, True), ({"alpha1": pi / 2 - 2.01e-5}, False),
        ({"alpha2": -1.99e-5}, True), ({"alpha2": 2.01e-5}, False),
        ({"alpha2": pi / 3 + 1.9e-5}, True), ({"alpha2": pi / 3 + 2.1e-5}, False),
        ({"alpha2": pi / 12 - 1.9e-5}, True), ({"alpha2": 0.1}, False),
        ({"a1": 1.99e-6}, True), ({"a1": -2.01e-6}, False), ({"d2": 1.99e-6}, True), ({"d2": -2.01e-6}, False),
    ],
)  # fmt: skip
def test_the_tolerances_are_2e_5_rad_and_2_micrometres(changed: dict[str, float], inside: bool) -> None:
    arm = table(**changed)
    found, changes = square_up(arm)
    assert (found is not arm) is inside
    if inside:
        (key, value), (change,) = *changed.items(), changes
        kind = {"alpha": "twist", "a": "distance", "d": "offset"}[key[:-1]]
        assert (change.kind, change.joints[0]) == (kind, int(key[-1]))
        assert change.before == pytest.approx(value, abs=1e-12)
        assert change.after == pytest.approx(round(value / (pi / 12)) * pi / 12 if kind == "twist" else 0.0, abs=1e-15)
        assert change.by == pytest.approx(abs(value - change.after), abs=1e-12)


def test_wider_tolerances_are_the_callers() -> None:
    arm = table(alpha1=pi / 2 + 0.004, a1=8e-4)
    assert square_up(arm)[0] is arm
    assert [change.kind for change in square_up(arm, angle=0.005, length=1e-3)[1]] == ["distance", "twist"]


def test_axes_that_part_slowly_do_not_carry_the_tool_away() -> None:
    """Axes 1e-5 rad from parallel meet 40 km away: the normal stands where the links are."""
    arm = table(alpha2=1e-5)
    found, _ = square_up(arm)
    assert np.abs(found.home - arm.home).max() < 1e-5
    assert found.joints[2].screw == pytest.approx(arm.joints[2].screw, abs=1e-5)


def test_lengths_are_worked_out_about_the_axes_that_were_squared() -> None:
    """Axis 2 passes axis 1 at 4 µm, 0.4 m before its own link: noise of its direction, not a distance."""
    inside = '<origin xyz="0 0.4 0" rpy="-1.57080632679 0 0.00001"/><axis xyz="0 0 1"/>'
    arm = from_urdf(robot([joint("j1", "a", "b"), joint("j2", "b", "c", "continuous", inside)]), as_written=True)
    assert abs(numbers_of(arm, angle=1e-6, length=1e-9)[0].a) == pytest.approx(4e-6, rel=1e-3)
    found, changes = square_up(arm)
    assert numbers_of(found, angle=1e-6, length=1e-9)[0].a == 0.0
    assert {change.kind for change in changes} == {"distance", "twist"}
    assert found.joints[1].frame[:3, 3].tolist() == [0, 0.4, 0]


def test_offsets_that_cancel_along_parallel_axes_cancel_exactly() -> None:
    rows = [(0, pi / 2, 0.3, 0), (0.4, 0, 0.1, 0), (0.3, 0, -0.0999995, 0), (0, pi / 2, 0, 0), (0, 0, 0.2, 0)]
    found, (change,) = square_up(from_dh(rows, convention="standard"))
    assert (change.kind, change.joints, change.name) == ("offset", (2, 3, 4), "d2 + d3 + d4")
    assert (change.before, change.after) == (pytest.approx(5e-7), 0.0)
    given = numbers_of(found, angle=1e-6, length=1e-9)
    assert given[1].d + given[2].d == 0.0
    assert given[1].d == pytest.approx(0.1)


def test_lengths_lose_their_last_digits_of_noise() -> None:
    rows = [(0.240000000000178, "pi/2", 0, 0), (0.1234567891, 0, -1e-12, 0), (0.1, 0, 0, 0)]
    arm = from_dh(rows, convention="standard")
    found, changes = square_up(arm)
    assert changes == ()  # nothing to tell: less than a nanometre
    one, two, _ = numbers_of(found, angle=1e-6, length=1e-9)
    assert (one.a, two.a, two.d) == (0.24, pytest.approx(0.1234567891, abs=1e-16), 0.0)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3, 1e6], ids=["km", "m", "mm", "µm"])
@pytest.mark.parametrize("size", [0.05, 1.0, 25.0])
def test_two_micrometres_are_the_same_in_any_unit(unit: float, size: float) -> None:
    for noise, inside in ((1e-6, True), (0.99 * MEETING, True), (1.01 * MEETING, False)):
        rows = [(0, pi / 2, 0.3 * size, 0), (0.4 * size, 0, noise, 0), (0.2 * size, 0, 0, 0)]
        arm = from_dh([(a * unit, alpha, d * unit, 0) for a, alpha, d, _ in rows], convention="standard")
        assert meeting(arm) == pytest.approx(MEETING * unit)
        assert (square_up(arm)[0] is not arm) is inside


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3, 1e6], ids=["km", "m", "mm", "µm"])
def test_noise_of_less_than_a_nanometre_goes_in_any_unit(unit: float) -> None:
    rows = [(0.4 + 4e-10, pi / 2, 0, 0), (0.3, 0, 0, 0), (0.1, 0, 0, 0)]
    arm = from_dh([(a * unit, alpha, d * unit, 0) for a, alpha, d, _ in rows], convention="standard")
    assert numbers_of(square_up(arm)[0], angle=1e-6, length=1e-9 * unit)[0].a == 0.4 * unit


def test_an_arm_without_structure_is_left_alone(rng: np.random.Generator) -> None:
    rows = [(a, alpha, d, theta) for a, alpha, d, theta in rng.uniform(0.3, 0.4, (6, 4))]
    arm = from_dh(rows, convention="standard")
    assert square_up(arm)[0] is arm


def test_slides_and_screws_of_any_pitch_are_squared_too(rng: np.random.Generator) -> None:
    rows = [(0.2, "pi/2", 0.3, 0), (0, "-pi/2", 0.1, 0), (0, 0, 0.2, 0)]
    nut = from_dh([{"a": 0.1, "alpha": "pi/2", "kind": "helical", "pitch": 0.01}, *rows[1:]], convention="standard")
    slide = from_dh(rows, kinds="RPR", convention="standard")
    for arm, place in ((nut, 0), (slide, 1)):
        found, changes = square_up(noisy(arm, rng))
        one, other = found.joints[place].screw, arm.joints[place].screw
        assert changes
        assert one == pytest.approx(other, abs=1e-5)
        assert one[:3] @ one[3:] == pytest.approx(other[:3] @ other[3:], abs=1e-12)
        assert set(np.abs(found.joints[2].screw[3:])) == {0.0, 1.0}


def as_urdf(arm: Robot, digits: int) -> str:
    """The arm as a URDF with angles of so many places; every link's frame stands on its axis, z along it."""
    lines = axis_lines(arm, length=1e-6)
    frames = [frame_on_axis(*line) for line in lines] + [arm.home]
    texts, before = [], np.eye(4)
    for i, frame in enumerate(frames):
        local = np.linalg.inv(before) @ frame
        turn = local[:3, :3]
        roll, yaw = atan2(turn[2, 1], turn[2, 2]), atan2(turn[1, 0], turn[0, 0])
        pitch = atan2(-turn[2, 0], float(np.hypot(turn[0, 0], turn[1, 0])))
        if abs(turn[2, 0]) > 1 - 1e-9:
            roll, yaw = atan2(-turn[1, 2], turn[1, 1]), 0.0
        rpy = " ".join(f"{angle:.{digits}f}" for angle in (roll, pitch, yaw))
        xyz = " ".join(f"{round(x, 9):.9g}" for x in local[:3, 3])
        kind = str(arm.joints[i].kind) if i < len(lines) else "fixed"
        inside = f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/>'
        texts.append(joint(f"j{i}", f"l{i}", f"l{i + 1}", kind, inside))
        before = frame
    return robot(texts)


@pytest.mark.parametrize("name", ["pa10", "puma560", "iiwa14", "ur5e", "panda", "irb140", "stanford", "gen3", "sawyer"])
def test_a_file_with_rounded_angles_is_recognised_as_the_arm_of_the_catalogue(name: str) -> None:
    text = as_urdf(open_robot(name), 4)
    task = resolve_task("pose", open_robot(name))
    assert "1.5708" in text
    arm = from_urdf(text)
    assert known_analysis(arm, task) is not None
    assert known_analysis(from_urdf(text, as_written=True), task) is None
    assert "angles read as the multiples of 15°" in str(arm.notes[-1])


def test_the_exact_side_sees_the_same_arm(rng: np.random.Generator) -> None:
    arm, _ = square_up(noisy(open_robot("iiwa14"), rng))
    found, remarks = sections(arm)
    assert all(abs(one.miss) < 1e-12 for one in remarks)  # lengths that are no short decimals
    assert all(abs(turn.error) < 1e-15 for one in found for turn in (one.twist, one.phase))
    assert [(one.a == 0, one.d == 0) for one in found] == [
        (one.a == 0, one.d == 0) for one in sections(open_robot("iiwa14"))[0]
    ]


def test_less_than_a_nanometre_is_no_length_of_the_exact_side_either() -> None:
    rows = [(0, "pi/2", 0.3, 0), (0, "-pi/2", -1e-12, 0), (0.2, 0, 0.4, 0), (0, 0, 0, 0)]
    assert sections(from_dh(rows, convention="standard"))[0][1].d == 0


def test_frames_far_away_are_carried_along_as_they_are() -> None:
    """300 m along axes that are 1e-5 rad from parallel, and back: squared about frames there, 3 mm would be lost."""
    rows = [(0, pi / 2, 0.3, 0), (0.4, 1e-5, 300.0, 0), (0.3, 0, -300.0, 0), (0, pi / 2, 0, 0), (0, 0, 0.2, 0)]
    arm = from_dh(rows, convention="standard")
    found, changes = square_up(arm)
    assert max(change.by for change in changes if not change.turns) < 1e-6
    assert [change.name for change in changes if change.turns] == ["α2"]
    assert found.home[:3, 3] == pytest.approx(arm.home[:3, 3], abs=1e-4)
    assert found.joints[4].screw == pytest.approx(arm.joints[4].screw, abs=1e-4)


@pytest.mark.parametrize(
    ("kinds", "twists"),
    [("RRPRR", (pi / 2, 0, 0, pi / 2)), ("RRRRR", (0, 0, 0, pi / 2)), ("RRRRR", (pi / 2, 0, 0, 0))],
)
def test_offsets_cancel_only_between_two_normals(kinds: str, twists: tuple[float, ...]) -> None:
    """Not where a slide changes them, nor before the first axis or after the last, where no other axis is."""
    lengths = (0.0, 0.4, 0.3, 0.1)
    offsets = (0.0, 0.1, -0.0999995, 0.0)
    rows = [(a, twist, d, 0) for a, twist, d in zip(lengths, twists, offsets, strict=True)]
    arm = from_dh([*rows, (0.1, 0, 0, 0)], kinds=kinds, convention="standard")
    assert square_up(arm)[0] is arm


def test_an_axis_that_leans_along_the_normal_is_told_as_a_twist() -> None:
    inside = '<origin xyz="0.4 0 0" rpy="0 0.0000123 0"/><axis xyz="0 0 1"/>'
    arm = from_urdf(robot([joint("j1", "a", "b"), joint("j2", "b", "c", "continuous", inside)]), as_written=True)
    found, (change,) = square_up(arm)
    assert (change.name, change.by) == ("α1", pytest.approx(1.23e-5))
    assert found.joints[1].screw[3:].tolist() == [0, 0, 1]


@pytest.mark.parametrize(("lean", "kept"), [(1e-5, False), (1e-3, True)])
def test_the_tip_is_straightened_of_noise_alone(lean: float, kept: bool) -> None:
    """Its axes are no structure: with a wider tolerance they stay what they are."""
    tool = np.eye(4)
    tool[:3, :3] = exponential(np.array([0, 0, 0, 1.0, 0, 0]), lean)[:3, :3]
    arm = from_dh([(0, pi / 2, 0.3, 0), (0.4, 0, 0, 0)], convention="standard", tool=tool)
    found, changes = square_up(arm, angle=0.01)
    assert (found is arm) is kept
    assert [(change.kind, change.joints) for change in changes] == ([] if kept else [("tip", (2,))])
    if not kept:
        assert changes[0].text == "tip turned by 0.00057°"
