"""Every arm of the catalogue: it opens, says where its numbers are from, and its limits are sane. Known poses."""

from __future__ import annotations

import re
from importlib import resources
from itertools import pairwise
from math import pi, sqrt

import numpy as np
import pytest
from reference.kinematics import pose

from rankdrop.robot.arm_reach import extent
from rankdrop.robot.ideal import ideal, what_holds
from rankdrop.robot.model import coarse_fingerprint
from rankdrop.robot.note import NoteOn
from rankdrop.robot.open import catalog_entries, open_robot, robot_names, search_catalog
from rankdrop.task import task_names

NAMES = robot_names()


def test_the_arms_that_are_promised_are_there() -> None:
    documents = {"planar2r", "anthropomorphic", "almarkhi4", "pa10", "rcrrrr", "canadarm2"}
    owned = {
        "planar3r", "scara", "stanford", "puma560", "ur3e", "ur5", "ur5e", "ur10e", "iiwa14", "panda", "gen3", "sawyer",
        "irb140", "xarm7", "fetch",
    }  # fmt: skip
    trade = {
        "ur3", "ur10", "ur16e", "ur20", "ur30", "kr3r540", "kr5arc", "kr6r900", "kr10r1420", "kr16", "kr120r2500",
        "kr150r3100", "kr210l150", "iiwa7", "med7", "lrmate200id", "m10ia", "m20ia", "m710ic50", "r2000ib210f",
        "crx10ia", "gp7", "gp12", "hc10", "sia5d", "sia20d", "tx2_60l", "tx2_90l", "rx160", "irb120", "irb1200",
        "irb1600", "irb2400", "irb4600", "irb6640", "irb6700", "crb15000", "a0509", "m0617", "m1013", "m1509", "h2515",
        "tm5_900", "tm14", "jaka_zu7", "jaka_a5", "jaka_c7", "jaka_pro12", "jaka_s5", "dobot_cr5", "dobot_cr10",
        "dobot_cr16", "nova2", "aubo_i5", "aubo_i10", "aubo_e3", "vs060", "cobotta", "rs007n", "j2n6s300", "j2n7s300",
        "gen3_lite", "m1n6s200", "xarm5", "xarm6", "lite6", "rizon4", "fr3", "meca500", "so101", "wx250s", "vx300s",
        "px150", "z1", "piper", "rm65", "mycobot280", "tiago", "reachy2", "openarm", "yam", "rizon10",
        "crx3ia", "crx30ia",
    }  # fmt: skip
    assert documents | owned | trade <= set(NAMES)


def test_entries_tell_name_joints_task_and_source() -> None:
    entries = {entry.name: entry for entry in catalog_entries()}
    assert tuple(entries) == NAMES
    assert (entries["pa10"].n, entries["pa10"].task) == (7, "pose")
    assert "Table 2" in entries["pa10"].source


@pytest.mark.parametrize("name", NAMES)
def test_every_arm_opens_with_a_source_and_sane_limits(name: str) -> None:
    robot = open_robot(name)
    assert robot.name == name
    assert robot.about
    assert len(robot.source.reference) > 60
    assert robot.source.kind == "catalogue"
    assert robot.task in task_names()
    for joint in robot.joints:
        bound = 8.0 if joint.unit == "rad" else 2.0  # a GP12's flange turns by ±455°
        assert joint.lower == -np.inf or -bound <= joint.lower < joint.upper
        assert joint.upper == np.inf or joint.upper <= bound
        assert joint.velocity == np.inf or 0.05 < joint.velocity < 12.0
    assert robot.home[:3, :3] @ robot.home[:3, :3].T == pytest.approx(np.eye(3), abs=1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_consecutive_axes_are_exactly_parallel_and_at_right_angles_or_clearly_not(name: str) -> None:
    joints = open_robot(name).joints
    axes = [joint.screw[3:] if joint.screw[3:].any() else joint.screw[:3] for joint in joints]
    for one, other in pairwise(axes):
        for part in (abs(one @ other), np.linalg.norm(np.cross(one, other))):
            assert part < 1e-15 or part > 1e-2


REASONS = {"gen3": "The offsets d2 = -11.75 mm, d4 = -12.75 mm and d6 = -0.3501 mm are real", "gen3_6dof": "Table 95"}
"""Arms that miss structure by less than 1 mm -> words of their source that say why."""


@pytest.mark.spread(52)
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_an_arm_within_a_millimetre_of_more_structure_says_why(name: str) -> None:
    """CAD exports have offsets of 0.1 mm and less that no drawing shows."""
    robot = open_robot(name)
    made, _ = ideal(robot, length=min(1e-3, 1e-3 * extent(robot) / 0.3))
    if what_holds(made, robot):
        assert REASONS[name] in " ".join(robot.source.reference.split())
    else:
        assert name not in REASONS


@pytest.mark.parametrize("name", NAMES)
def test_no_number_of_the_catalogue_has_to_be_taken_for_another(name: str) -> None:
    assert not any(note.kind is NoteOn.SQUARED for note in open_robot(name).notes)


def test_an_arm_is_found_by_its_maker_its_form_and_its_other_names() -> None:
    assert {"m10ia", "lrmate200id"} <= {entry.name for entry in search_catalog("FANUC")}
    assert all(entry.maker == "FANUC" for entry in search_catalog("fanuc"))
    assert {"iiwa7", "iiwa14", "med7"} <= {entry.name for entry in search_catalog("kuka 7r spherical shoulder")}
    assert [entry.name for entry in search_catalog("gofa")] == ["crb15000"]
    assert search_catalog("") == catalog_entries()
    assert search_catalog("staubli") == search_catalog("Stäubli") != ()
    assert search_catalog("no such maker") == ()
    for name in ("UR 5e", "LBR_iiwa_7_R800", "GoFa", "irb6700_235_265"):
        assert open_robot(name).name in {"ur5e", "iiwa7", "crb15000", "irb6700"}


def test_arms_that_were_renamed_are_found() -> None:
    assert [open_robot(name).name for name in ("UR7e", "UR12e")] == ["ur5e", "ur10e"]


def test_no_two_arms_answer_to_one_name() -> None:
    called = [re.sub("[-_]", "", name) for entry in catalog_entries() for name in (entry.name, *entry.aliases)]
    assert len(called) == len(set(called))


def test_only_arms_that_makers_sell_under_several_names_are_the_same() -> None:
    groups: dict[str, set[str]] = {}
    for name in NAMES:
        groups.setdefault(coarse_fingerprint(open_robot(name)), set()).add(name)
    twins = {frozenset(group) for group in groups.values() if len(group) > 1}
    assert twins <= {
        frozenset(pair)
        for pair in (
            ("aubo_e3", "aubo_i3"), ("crx10ial", "crx20ial"), ("fr3", "panda"), ("iiwa7", "med7"), ("rs030n", "rs080n"),
        )
    }  # fmt: skip


def test_entries_count_the_variables_of_the_robot() -> None:
    assert {entry.name: entry.n for entry in catalog_entries()} == {name: open_robot(name).n for name in NAMES}


def test_files_hold_no_decimal_angles_for_right_angles() -> None:
    for item in (resources.files("rankdrop.robot") / "catalog").iterdir():
        if item.name.endswith(".toml"):
            assert "alpha = 1.57" not in item.read_text(encoding="utf-8")
            assert "alpha = -1.57" not in item.read_text(encoding="utf-8")


def test_planar_arms_have_their_closed_form() -> None:
    q = np.array([0.3, -1.1, 0.7])
    angles = np.cumsum(q)
    two, three = pose(open_robot("planar2r"), q[:2])[:2, 3], pose(open_robot("planar3r"), q)[:2, 3]
    lengths = np.array([1.0, 0.7, 0.4])
    assert two == pytest.approx([lengths[:2] @ np.cos(angles[:2]), lengths[:2] @ np.sin(angles[:2])])
    assert three == pytest.approx([lengths @ np.cos(angles), lengths @ np.sin(angles)])


def test_almarkhi4_stands_where_the_document_has_it() -> None:
    tip = pose(open_robot("almarkhi4"), [-3.11, 3.02, -1.53, 0.15])[:3, 3]
    assert tip == pytest.approx([-0.6236455424199617, 3.270950632724666, 0.9863255358147497], abs=1e-12)


def test_anthropomorphic_reaches_its_wrist_by_the_law_of_the_elbow() -> None:
    q1, q2, q3 = 0.4, 0.8, -1.2
    wrist = pose(open_robot("anthropomorphic"), [q1, q2, q3, 0.1, 0.0, 0.3]) @ [0, 0, -0.1, 1]
    out = 0.5 * np.cos(q2) + 0.4 * np.cos(q2 + q3)
    assert wrist[:3] == pytest.approx([out * np.cos(q1), out * np.sin(q1), 0.5 * np.sin(q2) + 0.4 * np.sin(q2 + q3)])


def test_puma560_stands_as_its_table_says() -> None:
    tip = pose(open_robot("puma560"), np.zeros(6))[:3, 3]
    assert tip == pytest.approx([0.4318 + 0.0203, -0.15005, 0.4318])


def test_rcrrrr_holds_the_printed_screws() -> None:
    columns = np.stack([np.roll(joint.screw, 3) for joint in open_robot("rcrrrr").joints])
    h = sqrt(0.5)
    printed = [
        [1, 0, 0, 0, 0, -1], [0, 0, 0, 0, 1, 0], [0, 1, 0, 0, 0, 0], [0, 1, 0, 0, 0, 5], [1, 0, 0, 0, 0, 0],
        [0, h, h, 0, -10 * h, 10 * h], [0, h, -h, 0, 10 * h, 10 * h],
    ]  # fmt: skip
    assert columns == pytest.approx(np.array(printed), abs=1e-14)
    assert np.linalg.matrix_rank(columns, tol=1e-12) == 5


def test_irb140_stands_in_the_calibration_pose() -> None:
    home = open_robot("irb140").home
    assert home[:3, 3] == pytest.approx([0.07 + 0.38 + 0.065, 0.0, 0.352 + 0.36])
    assert home[:3, 2] == pytest.approx([1.0, 0.0, 0.0])


def test_stanford_slides_by_its_third_joint() -> None:
    robot = open_robot("stanford")
    assert [str(joint.kind)[0] for joint in robot.joints] == list("rrprrr")
    near, far = (pose(robot, [0, 0, d, 0, 0, 0])[:3, 3] for d in (0.3, 0.9))
    assert far - near == pytest.approx([0, 0, 0.6], abs=1e-15)
    assert (robot.lower[2], robot.upper[2]) == (pytest.approx(0.3048), pytest.approx(1.27))


def test_scara_turns_about_the_vertical_and_its_tool_points_down() -> None:
    robot = open_robot("scara")
    tip = pose(robot, [0.2, 0.5, 0.1, -1.0])
    assert tip[:3, 2] == pytest.approx([0, 0, -1])
    assert tip[2, 3] == pytest.approx(0.387 - 0.1)


def test_iiwa14_and_panda_stand_upright_at_their_known_heights() -> None:
    assert open_robot("iiwa14").home[:3, 3] == pytest.approx([0, 0, 0.36 + 0.42 + 0.4 + 0.126])
    assert open_robot("panda").home[:3, 3] == pytest.approx([0.088, 0, 0.333 + 0.316 + 0.384 - 0.107])
    assert open_robot("gen3").home[:3, 3] == pytest.approx([0, -0.0248501, 0.28481 + 0.42076 + 0.31436 + 0.167455])


def test_limits_come_in_radians() -> None:
    robot = open_robot("iiwa14")
    assert robot.upper == pytest.approx(np.radians([170, 120, 170, 120, 170, 120, 175]))
    assert robot.joints[0].velocity == pytest.approx(85 * pi / 180)


def test_mycobot280_has_its_makers_table() -> None:
    """Joints as on the maker's page [mm, °]; the lengths of its ROS file differ by up to 20 mm."""
    table = [(131.22, 0, 90, 0), (0, -110.4, 0, -90), (0, -96, 0, 0), (63.4, 0, 90, -90), (75.05, 0, -90, 90),
             (45.6, 0, 0, 0)]  # fmt: skip
    q = np.array([0.3, -0.7, 1.1, 0.4, -0.9, 0.2])
    tip = np.eye(4)
    for (d, a, alpha, offset), angle in zip(table, q, strict=True):
        (c, s), (ca, sa) = ((np.cos(x), np.sin(x)) for x in (angle + np.radians(offset), np.radians(alpha)))
        tip = tip @ [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
    tip[:3, 3] *= 1e-3
    assert np.abs(pose(open_robot("mycobot280"), q) - tip).max() < 1e-12
