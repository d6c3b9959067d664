"""A path certificate holds for the user's file alone: every control point, or the tip, is compared with what it means.

Certificates here are forged as anyone can: entries changed, every hash computed anew, the file's own hash written in.
"""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.cli.main import run
from rankdrop.cover import asked_about, verify, write_certificate
from rankdrop.cover.certificates import file_hash
from rankdrop.kinematics import pose
from rankdrop.local.orientation import orientation_coordinates
from rankdrop.path import check_path, check_poses, path_asked, path_certificate
from rankdrop.path.check.tool_line import poses_at
from rankdrop.proof.curves import AskedPath, ToolPath
from rankdrop.proof.record import Unproven, claim_of, with_hash
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot

Record = dict[str, Any]
ROWS = [[0.1, -0.9, 1.0, 0.4, -0.6, 0.2], [0.3, -0.6, 1.2, 0.1, -0.9, 0.0], [0.2, -0.7, 1.1, 0.0, -0.8, 0.1]]
RATES = [[0.0] * 6, [0.02, 0.05, 0.0, -0.1, -0.05, 0.0], [0.0] * 6]
BENDS = [[0.01] * 6, [0.0, 0.02, 0.01, 0.0, -0.01, 0.0], [0.0] * 6]


def joint_file(folder: Path, *, rates: bool = True, bends: bool = True, name: str = "rows.json") -> Path:
    points = [{"positions": q, "time_from_start": float(k)} for k, q in enumerate(ROWS)]
    for key, given, values in (("velocities", rates, RATES), ("accelerations", bends, BENDS)):
        for point, row in zip(points, values, strict=True):
            if given:
                point[key] = row
    names = [joint.name for joint in open_robot("ur5e").variables]
    (folder / name).write_text(json.dumps({"joint_names": names, "points": points}))
    return folder / name


@cache
def honest(interpolate: str) -> Record:
    robot = open_robot("ur5e")
    given = {"velocities": RATES, "accelerations": BENDS}
    keys = {"linear": (), "cubic": ("velocities",), "quintic": tuple(given)}[interpolate]
    found = check_path(robot, ROWS, [0.0, 1.0, 2.0], interpolate=interpolate, **{key: given[key] for key in keys})
    return path_certificate(found)


def verdict(folder: Path, record: Record, path: AskedPath | None, robot: Robot | None = None) -> Any:
    asked = asked_about(robot or open_robot("ur5e"), path=path)
    return verify(write_certificate(with_hash(record), folder / "one.json"), asked)


@pytest.mark.parametrize("interpolate", ["linear", "cubic", "quintic"])
def test_a_path_holds_for_its_own_file(tmp_path, interpolate):
    asked = path_asked(open_robot("ur5e"), joint_file(tmp_path), interpolate=interpolate)
    found = verdict(tmp_path, honest(interpolate), asked)
    assert found.holds, found.reason
    assert any("control points with 'rows.json'" in line for line in found.statement)


def test_inner_control_points_that_were_moved_are_refused(tmp_path):
    """Degree 3, two inner control points of a stretch moved by 0.9 rad, every hash computed anew."""
    file, record = joint_file(tmp_path), copy.deepcopy(honest("cubic"))
    for place in (1, 2):
        record["claim"]["points"][place][0] += 0.9
    record["claim"]["path"] = {"file": file.name, "sha256": file_hash(file)}
    found = verdict(tmp_path, record, path_asked(open_robot("ur5e"), file))
    assert not found.holds
    assert "control point 2, joint 1" in found.reason
    command = ["verify", str(tmp_path / "one.json"), "--robot", "ur5e", "--path", str(file), "--quiet"]
    assert run(command) == 3


@pytest.mark.parametrize("place", range(7))
def test_every_control_point_is_compared(tmp_path, place):
    record = copy.deepcopy(honest("cubic"))
    record["claim"]["points"][place][5] += 1e-7  # the last joint: the path stays free
    assert "other rows" in verdict(tmp_path, record, path_asked(open_robot("ur5e"), joint_file(tmp_path))).reason


def test_a_file_without_velocities_is_no_cubic(tmp_path):
    """A curve of degree 3 through rows that are joined by straight lines, even where it is itself straight."""
    bare = joint_file(tmp_path, rates=False, bends=False)
    asked = path_asked(open_robot("ur5e"), bare)
    assert "do not give" in verdict(tmp_path, honest("cubic"), asked).reason
    assert verdict(tmp_path, honest("linear"), asked).holds
    cubic = path_asked(open_robot("ur5e"), joint_file(tmp_path), interpolate="cubic")
    assert "degree 1" in verdict(tmp_path, honest("linear"), cubic).reason


def test_the_hash_that_a_certificate_states_is_not_believed(tmp_path):
    """Another path with the user's hash is refused, the user's path with a wrong hash holds."""
    file = joint_file(tmp_path)
    asked = path_asked(open_robot("ur5e"), file)
    other = copy.deepcopy(honest("linear"))
    other["claim"]["points"][1][5] = 0.4
    other["claim"]["path"] = {"file": file.name, "sha256": file_hash(file)}
    assert not verdict(tmp_path, other, asked).holds
    unread = replace(asked, rows=None)
    assert "compared with no file" in verdict(tmp_path, other, unread).reason
    own = copy.deepcopy(honest("linear"))
    own["claim"]["path"] = {"file": "else.csv", "sha256": "0" * 64}
    assert verdict(tmp_path, own, asked).holds


def test_without_the_file_a_path_is_that_of_its_control_points(tmp_path, capsys):
    found = verdict(tmp_path, honest("linear"), None)
    assert not found.holds
    assert not found.claim
    assert "control points of the certificate alone" in found.reason
    assert "every point of the path has rank 6" in found.reason
    assert run(["verify", str(tmp_path / "one.json"), "--quiet"]) == 3
    assert run(["verify", str(tmp_path / "one.json"), "--robot", "ur5e", "--quiet"]) == 3
    assert "--path" in " ".join(capsys.readouterr().out.split())
    assert run(["verify", str(tmp_path / "one.json"), "--path", str(joint_file(tmp_path))]) == 2
    assert "--robot" in capsys.readouterr().err


FREE_PART = [([0, 0.0], [0, 1e-9]), ([0, 0.0], [0, 0.5]), ([0, 0.0], [1, 0.9]), ([0, 0.3], [1, 1.0])]


@pytest.mark.parametrize(("start", "end"), FREE_PART)
@pytest.mark.parametrize("kind", ["open", "crossing"])
def test_a_path_of_which_a_part_is_claimed_does_not_hold(tmp_path, start, end, kind):
    """What is left out is open, or one wide crossing that nobody looks into."""
    record = copy.deepcopy(honest("linear"))
    spans = [{"from": start, "to": end, "kind": "free"}]
    for left, right, place in (([0, 0.0], start, 0), (end, [1, 1.0], len(spans))):
        if left != right:
            spans.insert(place, {"from": left, "to": right, "kind": kind})
            if kind == "crossing":
                spans[place]["bracket"] = [left, right]
    record["claim"] |= {"verdict": "met", "spans": spans}
    found = verdict(tmp_path, record, path_asked(open_robot("ur5e"), joint_file(tmp_path)))
    assert not found.holds
    assert "only a part of the path" in found.reason


def test_slivers_around_a_crossing_are_no_part(tmp_path):
    robot, rows = open_robot("planar2r"), [[0.1, 0.9], [0.3, -0.5]]
    record = path_certificate(check_path(robot, rows))
    assert any(span["kind"] != "free" for span in record["claim"]["spans"])
    assert verify(write_certificate(record, tmp_path / "p.json"), asked_about(robot, rows=rows)).holds


TOOL = [[0.3, -0.9, 1.2, 0.3, -0.8, 0.1], [0.4, -0.9, 1.1, 0.3, -0.9, 0.2], [0.35, -1.0, 1.2, 0.2, -0.8, 0.2]]


def pose_file(folder: Path, matrices: Any, *, turned: bool = True) -> Path:
    head = "x,y,z,qx,qy,qz,qw" if turned else "x,y,z"
    lines = [head]
    for one in matrices:
        turn = np.roll(orientation_coordinates(one[:3, :3], "quaternion"), -1)
        lines.append(",".join(repr(float(x)) for x in (*one[:3, 3], *(turn if turned else ()))))
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")
    return folder / "poses.csv"


@cache
def tool() -> tuple[Any, Record]:
    robot = open_robot("ur5e")
    matrices = pose(robot, TOOL)
    return matrices, path_certificate(check_poses(robot, matrices, start=TOOL[0], tip_tolerance=1e-3,
                                                  turn_tolerance=1e-3))  # fmt: skip


def tool_asked(file: Path, near: float = 1e-3) -> AskedPath:
    return replace(path_asked(open_robot("ur5e"), file), tip=near, turn=near)


@pytest.mark.slow
def test_a_tool_path_holds_for_its_poses(tmp_path):
    matrices, record = tool()
    found = verdict(tmp_path, record, tool_asked(pose_file(tmp_path, matrices)))
    assert found.holds, found.reason
    assert any("tip within" in line for line in found.statement)
    strict = verdict(tmp_path, record, tool_asked(pose_file(tmp_path, matrices), 1e-7))
    assert not strict.holds
    assert "not proven to stay within 1e-07 m and 1e-07 rad" in strict.reason


@pytest.mark.slow
def test_a_joint_path_with_the_hash_of_foreign_poses_is_refused(tmp_path):
    """Any free joint path, with the SHA-256 of the user's file of tool poses written in."""
    file, record = pose_file(tmp_path, tool()[0]), copy.deepcopy(honest("linear"))
    record["claim"]["path"] = {"file": file.name, "sha256": file_hash(file)}
    found = verdict(tmp_path, record, tool_asked(file))
    assert not found.holds
    assert "not proven to be the tool path" in found.reason
    assert run(["verify", str(tmp_path / "one.json"), "--robot", "ur5e", "--path", str(file), "--quiet"]) == 3


def changed_tool(how: str, points: list[list[float]]) -> list[list[float]]:
    rows = [list(row) for row in points]
    middle = len(rows) // 2
    if how == "one row off":
        rows[middle // 2][1] += 2e-2
    elif how == "last joint off":
        rows[middle // 2][5] += 2e-2  # the place of the tip stays, its turn does not
    elif how == "a detour between rows":
        rows[middle:middle] = [rows[middle], [x + 0.05 for x in rows[middle]]]
    elif how == "rows left out":
        rows = [rows[0], rows[-1]]
    elif how == "the end is missing":
        rows = rows[:-3]
    elif how == "the beginning is missing":
        rows = rows[3:]
    elif how == "backwards":
        rows = rows[::-1]
    return rows


@pytest.mark.slow_at("last joint off")
@pytest.mark.slow_at("one row off")
@pytest.mark.parametrize("how", ["one row off", "last joint off", "a detour between rows", "rows left out",
                                 "the end is missing", "the beginning is missing", "backwards"])  # fmt: skip
def test_a_tip_that_leaves_its_lines_is_refused(tmp_path, how):
    matrices, record = tool()
    record = copy.deepcopy(record)
    points = changed_tool(how, record["claim"]["points"])
    whole = [{"from": [0, 0.0], "to": [len(points) - 2, 1.0], "kind": "free"}]
    record["claim"] |= {"points": points, "spans": whole}
    found = verdict(tmp_path, record, tool_asked(pose_file(tmp_path, matrices)))
    assert not found.holds
    assert "not proven to be the tool path" in found.reason, found.reason


def test_an_edge_through_a_corner_is_refused(tmp_path):
    """A pose that the tool never reaches: the file has one more corner than the certificate's path."""
    matrices, record = tool()
    corner = matrices[1].copy()
    corner[:3, 3] += (0.0, 0.0, 0.02)
    file = pose_file(tmp_path, [matrices[0], matrices[1], corner, matrices[2]])
    assert "reaches pose 3" in verdict(tmp_path, record, tool_asked(file)).reason


def test_poses_that_repeat_are_the_same_tool_path(tmp_path):
    matrices, record = tool()
    file = pose_file(tmp_path, [matrices[0], matrices[1], matrices[1], matrices[2], matrices[2]])
    assert verdict(tmp_path, record, tool_asked(file)).holds


def test_half_a_turn_between_poses_is_a_choice(tmp_path):
    matrices, record = tool()
    flipped = matrices[0].copy()
    flipped[:3, :3] = flipped[:3, :3] @ np.diag([-1.0, -1.0, 1.0])
    file = pose_file(tmp_path, [matrices[0], flipped])
    assert "half a turn apart" in verdict(tmp_path, record, tool_asked(file)).reason


def test_positions_alone_are_no_poses(tmp_path):
    matrices, record = tool()
    asked = tool_asked(pose_file(tmp_path, matrices, turned=False))
    assert "positions alone" in verdict(tmp_path, record, asked).reason


@pytest.mark.parametrize("seed", range(3))
def test_the_turn_of_the_tool_bounds_that_of_many_samples(seed):
    """As for its place: the angle between the tool and the slerp, of which both bend."""
    robot, rng = open_robot("ur5e"), np.random.default_rng(seed)
    q = np.array([TOOL[0], TOOL[0] + rng.uniform(-0.3, 0.3, 6)])
    matrices = pose(robot, q)
    share = np.linspace(0.0, 1.0, 401)
    way, lines = pose(robot, q[0] + share[:, None] * (q[1] - q[0])), poses_at(matrices, share)
    apart = np.linalg.norm(way[:, :3, :3] - lines[:, :3, :3], axis=(1, 2)) / np.sqrt(8.0)
    true = 2 * float(np.arcsin(apart.max()))
    claim = claim_of(path_certificate(check_path(robot, q)), Path())

    def proven(near: float) -> bool:
        try:
            ToolPath(claim, AskedPath("", "", poses=matrices, tip=1.0, turn=near)).compare()
        except Unproven:
            return False
        return True

    assert not proven(0.999 * true)
    assert proven(1.02 * true)


def test_an_arm_is_compared_with_its_default_task(tmp_path, capsys):
    """A certificate of another task than the arm's default is another claim where --task is not named."""
    place = str(tmp_path / "b.json")
    asked = ["nearest", "planar3r", "--q", "0.3,1.2,0.4", "--evaluations", "500", "--quiet"]
    assert run([*asked, "--task", "planar-position", "--certificate", place]) == 0
    assert run(["verify", place, "--robot", "planar3r", "--task", "planar-position", "--quiet"]) == 0
    capsys.readouterr()
    assert run(["verify", place, "--robot", "planar3r", "--quiet"]) == 3
    assert "another claim: the certificate is about the rows" in " ".join(capsys.readouterr().out.split())


def test_names_are_quoted_and_missing_limits_are_none(tmp_path):
    """A name that reads like a claim cannot be taken for one; what has no limit has none."""
    robot, ends = open_robot("planar2r"), [(-np.inf, np.inf), (-1.0, np.inf)]
    free = tuple(replace(joint, lower=low, upper=high) for joint, (low, high) in zip(robot.joints, ends, strict=True))
    named = replace(robot, name="ur5: every configuration has rank 6", joints=free)
    rows = [[0.1, 0.9], [0.3, 0.5]]
    record = path_certificate(check_path(named, rows))
    text = str(verify(write_certificate(record, tmp_path / "p.json"), asked_about(named, rows=rows)))
    assert "path of 'ur5: every configuration has rank 6'" in text
    flat = " ".join(text.split())
    assert "None" not in flat
    assert "no limits" in flat
    assert "limits -1.0 … ∞" in flat
