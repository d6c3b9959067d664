"""The catalogue's arms are those of the files they come from: pose and limits, held against the files' own numbers.

The files are in `data/`, reduced to joints and links; `data/catalogue.csv` says which arm is which, and whose file it
is. They are read here by a reader of its own: nothing is squared or rounded. A right angle written 1.5708 is 3.7e-6 rad
off, and so is all that follows it.
"""

from __future__ import annotations

import csv
import re
from itertools import pairwise
from math import cos, radians, sin
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray

from rankdrop.kinematics import pose
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.ideal import ideal, read_tolerance
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot, robot_names

DATA = Path(__file__).resolve().parents[1] / "data"
with (DATA / "catalogue.csv").open(encoding="utf-8", newline="") as stream:
    ROWS = {row["name"]: row for row in csv.DictReader(stream)}
SQUARED = 2e-5  # rad, and share of the reach: what the reader may square
TAKEN = re.compile(r"(\d+) angles? read as .*?, at most ([\d.e+-]+) rad")
Matrix = NDArray[np.float64]


def turn(axis: str, angle: float) -> Matrix:
    c, s = cos(angle), sin(angle)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis])


def numbers(element: ElementTree.Element | None, key: str, default: str) -> list[float]:
    text = default if element is None else element.get(key, default)
    return [float(word) for word in text.split()]


def written_pose(path: Path, base: str, tip: str, q: Matrix) -> Matrix:
    """(4, 4) pose of the tip, as the numbers of the file have it."""
    by_child = {joint.find("child").get("link"): joint for joint in ElementTree.parse(path).getroot().iter("joint")}
    chain, link = [], tip
    while link != base:
        chain.append(by_child[link])
        link = by_child[link].find("parent").get("link")
    result, place = np.eye(4), 0
    for joint in reversed(chain):
        roll, pitch, yaw = numbers(joint.find("origin"), "rpy", "0 0 0")
        step = np.eye(4)
        step[:3, :3] = turn("z", yaw) @ turn("y", pitch) @ turn("x", roll)
        step[:3, 3] = numbers(joint.find("origin"), "xyz", "0 0 0")
        result = result @ step
        if joint.get("type") == "fixed":
            continue
        axis = np.array(numbers(joint.find("axis"), "xyz", "1 0 0"))
        axis /= np.linalg.norm(axis)
        moved = np.eye(4)
        if joint.get("type") == "prismatic":
            moved[:3, 3] = q[place] * axis
        else:  # Rodrigues
            k = np.cross(np.eye(3), axis)
            moved[:3, :3] = np.eye(3) + sin(q[place]) * k + (1 - cos(q[place])) * k @ k
        result, place = result @ moved, place + 1
    assert place == len(q)
    return result


def test_every_arm_of_the_list_is_in_the_catalogue_and_every_file_is_used() -> None:
    assert set(ROWS) <= set(robot_names())
    files = {path.stem for path in (DATA / "catalogue").glob("*.urdf")}
    assert files == {Path(row["file"]).stem for row in ROWS.values() if row["file"].startswith("catalogue/")}


@pytest.mark.spread(35)
@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_the_tip_is_where_the_file_puts_it(name: str, rng: np.random.Generator) -> None:
    row, robot = ROWS[name], open_robot(name)
    path = DATA / row["file"]
    notes = " ".join(map(str, open_robot(path, base=row["base"], tip=row["tip"]).notes))
    taken = TAKEN.search(notes)  # as many angles as the file rounds, each off by so much
    allowed = SQUARED + (int(taken[1]) * float(taken[2]) if taken else 0.0)
    assert allowed < 2e-3  # 1.571
    moved = 1e-3 if row["ideal"] else 0.0
    for _ in range(8):
        q = rng.uniform(-3, 3, robot.n)
        off = np.abs(pose(robot, q) - written_pose(path, row["base"], row["tip"], q))
        assert off[:3, 3].max() < allowed * reach(robot) + moved
        assert off[:3, :3].max() < allowed


@pytest.mark.spread(41)
@pytest.mark.slow
@pytest.mark.parametrize("name", ROWS)
def test_it_is_the_arm_that_the_reader_makes_of_the_file(name: str, rng: np.random.Generator) -> None:
    row, robot = ROWS[name], open_robot(name)
    read = open_robot(DATA / row["file"], base=row["base"], tip=row["tip"])
    if row["ideal"]:
        read = ideal(read, length=read_tolerance(row["ideal"]).length)[0]
    q = rng.uniform(-3, 3, (50, robot.n))
    assert np.abs(pose(robot, q) - pose(read, q)).max() < 1e-8
    assert [joint.name for joint in robot.joints] == [joint.name for joint in read.joints]
    assert coarse_limits(robot, read)


def coarse_limits(robot: Robot, read: Robot) -> bool:
    """Limits are the file's, but for printed digits read as whole degrees, and figures that stand for "not known"."""
    for mine, other in zip(robot.joints, read.joints, strict=True):
        known = other.lower < other.upper
        for a, b in ((mine.lower, other.lower), (mine.upper, other.upper)):
            assert a == pytest.approx(b, abs=1e-3) if known else abs(a) == np.inf
        assert mine.velocity in (np.inf, pytest.approx(other.velocity, abs=1e-3))
    return True


@pytest.mark.parametrize("name", ROWS)
def test_its_source_names_the_file(name: str) -> None:
    row, robot = ROWS[name], open_robot(name)
    said = " ".join(robot.source.reference.split())
    assert f"github.com/{row['repository']}" in said
    assert f"{row['path']}, {row['base']} to {row['tip']}" in said
    assert row["because"] in said
    assert row["because"] or not row["ideal"]


def test_figures_that_makers_publish() -> None:
    """Reaches and limits from data sheets, that have nothing to do with the files."""
    wrist_reach = {"kr10r1420": 1.420, "kr6r900": 0.901, "irb120": 0.580, "irb6700": 2.65, "rx160": 1.600, "gp7": 0.927}
    for name, published in wrist_reach.items():
        robot = open_robot(name)
        points = [np.cross(joint.screw[3:], joint.screw[:3]) for joint in robot.joints]
        q = np.random.default_rng(2).uniform(robot.lower, robot.upper, (20_000, robot.n))
        wrist = meeting(points[3], robot.joints[3].screw[3:], points[4], robot.joints[4].screw[3:])
        local = np.linalg.inv(robot.home) @ [*wrist, 1]
        q[:, 3:] = 0.0
        across = np.hypot(*(pose(robot, q) @ local)[:, :2].T)
        assert across.max() == pytest.approx(published, rel=0.02), name
    assert open_robot("kr16").upper[0] == pytest.approx(radians(185))


def meeting(p: Matrix, u: Matrix, r: Matrix, v: Matrix) -> Matrix:
    """The point where two lines meet."""
    s = np.linalg.lstsq(np.stack([u, -v], axis=1), r - p, rcond=None)[0]
    return p + s[0] * u


def test_the_reader_of_this_test_knows_a_chain(tmp_path: Path) -> None:
    text = "".join(f'<link name="{name}"/>' for name in "abc") + "".join(
        f'<joint name="{one}{two}" type="{kind}"><origin xyz="1 0 0" rpy="0 0 0"/><parent link="{one}"/>'
        f'<child link="{two}"/><axis xyz="0 0 2"/></joint>'
        for (one, two), kind in zip(pairwise("abc"), ("revolute", "prismatic"), strict=True)
    )
    path = tmp_path / "arm.urdf"
    path.write_text(f"<robot name='r'>{text}</robot>")
    found = written_pose(path, "a", "c", np.array([np.pi / 2, 0.5]))
    assert found[:3, 3] == pytest.approx([1, 1, 0.5])
