"""Poses of the tip read from files, in every way of writing them, and by the command; and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.kinematics import pose
from rankdrop.path.read.poses import holds_poses, length_hint, read_poses
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema

ARM = open_robot("ur5")
Q = np.array([[0.3, -1.2, 1.4, -1.0, 1.2, 0.4], [0.6, -1.0, 1.2, -1.2, 1.0, 0.4], [0.5, -0.9, 1.1, -1.1, 0.9, 0.1]])
POSES = pose(ARM, Q)
T = np.array([0.0, 1.0, 3.0])


def quaternions(poses: np.ndarray) -> np.ndarray:
    """x, y, z, w of rotations none of which is a half turn."""
    r = poses[:, :3, :3]
    w = np.sqrt(1 + np.trace(r, axis1=1, axis2=2)) / 2
    axis = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    return np.concatenate([axis / (4 * w[:, None]), w[:, None]], axis=1)


def angles(poses: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw."""
    r = poses[:, :3, :3]
    return np.stack([np.arctan2(r[:, 2, 1], r[:, 2, 2]), -np.arcsin(r[:, 2, 0]), np.arctan2(r[:, 1, 0], r[:, 0, 0])], 1)


def table(names: str, *columns: np.ndarray) -> str:
    rows = np.concatenate([np.reshape(one, (len(T), -1)) for one in columns], axis=1)
    return "\n".join([names, *(",".join(map(repr, row)) for row in rows.tolist())])


def files(folder: Path) -> dict[str, Path]:
    p, quaternion, turn = POSES[:, :3, 3], quaternions(POSES), angles(POSES)
    entries = [{"position": list(a), "orientation": list(b), "time": c}
               for a, b, c in zip(p, quaternion, T, strict=True)]  # fmt: skip
    ros = [{"pose": {"position": dict(zip("xyz", a, strict=True)), "orientation": dict(zip("xyzw", b, strict=True))}}
           for a, b in zip(p, quaternion, strict=True)]  # fmt: skip
    millimetres = {"length": "mm", "angle": "deg", "poses": [
        {"position": list(1e3 * a), "rpy": list(np.degrees(b))} for a, b in zip(p, turn, strict=True)]}  # fmt: skip
    texts = {
        "q.csv": table("time,x,y,z,qx,qy,qz,qw", T, p, quaternion),
        "r.csv": table("qw,X [mm],y [mm],z [mm],qx,qy,qz,gripper", quaternion[:, 3], 1e3 * p, quaternion[:, :3], T),
        "a.csv": table("x,y,z,roll [deg],pitch [deg],yaw", p, np.degrees(turn[:, :2]), turn[:, 2]),
        "list.json": json.dumps(entries, default=float),
        "ros.json": json.dumps({"header": {}, "poses": ros}, default=float),
        "mm.json": json.dumps(millimetres, default=float),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return {name: folder / name for name in texts}


def test_every_way_of_writing_poses_gives_the_same(tmp_path: Path) -> None:
    for name, file in files(tmp_path).items():
        assert holds_poses(file, ARM), name
        read = read_poses(file)
        np.testing.assert_allclose(read.matrices, POSES, atol=1e-12, err_msg=name)
        assert read.turned
        assert (read.times is not None) == (name in ("q.csv", "list.json"))
        assert read.unused == (("gripper",) if name == "r.csv" else ())
    (tmp_path / "joints.csv").write_text("q1,q2,q3,q4,q5,q6\n0,0,0,0,0,0\n")
    assert not holds_poses(tmp_path / "joints.csv", ARM)
    assert not holds_poses(tmp_path / "missing.csv", ARM)


def test_names_of_messages_and_stated_angles_are_read(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    words = [f"field.pose.position.{axis}" for axis in "xyz"] + [f"/pose/orientation/{axis}" for axis in "xyzw"]
    file.write_text(",".join([*words, ""]) + "\n0,0,1,0,0,0,1,\n")
    read = read_poses(file)
    np.testing.assert_allclose(read.matrices[0, :3, 3], [0.0, 0.0, 1.0])
    assert (read.turned, read.unused) == (True, ())
    file.write_text("x,y,z,roll [rad],pitch,yaw\n0,0,0,90,0,0\n")
    assert read_poses(file).turned
    file.write_text("x,y,z,roll,pitch,yaw\n0,0,0,90,0,0\n")
    np.testing.assert_allclose(read_poses(file, deg=True).matrices[0, :3, 2], [0.0, -1.0, 0.0], atol=1e-15)


BROKEN = {
    "a.csv|x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,1\n0,0,0,0,0,0,2": r"a\.csv, line 3: the quaternion is not of length",
    "a.csv|x,y,z,qx,qy,qz,qw\n0,0,nan,0,0,0,1": r"a\.csv, line 2, column 3 \(z\): the value is not finite",
    "a.csv|x,y,z,qx,qy,qz,qw\n0,0,0,0,0,1": r"a\.csv, line 2, column 7 \(qw\): the row is too short",
    "a.csv|x,y,z,qx,qy,qz\n0,0,0,0,0,1": r"a\.csv, line 1: poses need other columns",
    "a.csv|x,y,z [deg]\n0,0,0": r"a\.csv, line 1, column 3: the unit does not fit the column; got z \[deg\]",
    "a.csv|x,y,z,X\n0,0,0,0": r"a\.csv, line 1, column 4: the column is given twice",
    "a.csv|x,y,z": r"a\.csv, line 1: there is no row below the names",
    "a.csv|t,x,y,z\n1,0,0,0\n0.5,0,0,0": r"a\.csv, line 3, column 't': time does not go on",
    'a.json|{"poses": [{"position": [0, 0]}]}': r"a\.json, pose 1: the position has not 3 numbers",
    'a.json|{"poses": [{"position": [0, 0, "1"]}]}': r"a\.json, pose 1: the position has a value that is no finite num",
    'a.json|[{"position": [0, 0, 1]}, {"position": [0, 0, 1], "rpy": [0, 0, 0]}]': r"a\.json, pose 2: the pose has ano",
    'a.json|[{"position": [0, 0, 1]}, {}]': r"a\.json, pose 2: there is no position",
    'a.json|{"length": "cm", "poses": [{"position": [0, 0, 1]}]}': r"a\.json: there is no such unit of length; got cm",
    "a.json|[": r"a\.json, line 1: this is not JSON",
    f"a.json|{'[' * 200_000}": r"a\.json: the objects are nested too deeply$",
    f'a.json|[{{"position": [0, 0, {"9" * 400}]}}]': r"a\.json, pose 1: the position has a value that is no finite num",
    f"a.json|[{'9' * 5000}]": r"a\.json: a number has too many digits",
    'a.json|[{"pose": {"pose": {"position": [0, 0, 1]}}}]': r"a\.json: there are no poses in it",
    'a.json|[{"position": [0, 0, 1e155]}]': r"a\.json, pose 1: the value is too large; got 1e[+]155; allowed: -1e[+]12",
    'a.json|[{"position": [0, 0, 1], "rpy": [0, 1e16, 0]}]': r"pose 1: the value is too large; .* 1e[+]06 rad",
    "a.csv|x,y,z\n0,1e155,0": r"a\.csv, line 2: the value is too large; got 1e[+]155; allowed: -1e[+]12 … 1e[+]12 m",
    "a.csv|x,y,z,roll,pitch,yaw\n0,0,0,0,0,0\n0,0,0,90,0,0": r"line 3: angles look like degrees; got roll 90; allowed",
    'a.json|[{"position": [0, 0, 1], "rpy": [0, 0, 45]}]': r"pose 1: angles look like degrees; got yaw 45; .*deg=True",
    "a.csv|x [cm],y [cm],z [cm]\n1,2,3": r"line 1, column 1: the unit does not fit the column; got x \[cm\]; allowed",
    "a.csv|x y z [mm]\n0 0 1\n0 1 1": r"line 2: the columns are separated by spaces; got 3 numbers; .*: separate",
    "a.yaml|" + "[" * 200: r"a\.yaml, line 1: the objects are nested too deeply; allowed: depth 100",
    "a.yaml|a: &a {b: 1}\nc: {<<: *a}": r"a\.yaml: merge keys are not read",
}


@pytest.mark.parametrize("case", BROKEN, ids=lambda case: case[:60])
def test_a_broken_file_is_named_with_its_row(tmp_path: Path, case: str) -> None:
    name, _, text = case.partition("|")
    (tmp_path / name).write_text(text)
    with pytest.raises(TrajectoryError, match=BROKEN[case]):
        read_poses(tmp_path / name)


@pytest.mark.by_hand
def test_the_command_follows_poses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from jsonschema import Draft202012Validator

    monkeypatch.setenv("COLUMNS", "160")
    made = files(tmp_path)

    def run(*argv: object) -> tuple[int, str, str]:
        code = main.run(["path", "ur5", *map(str, argv), "--quiet"])
        told = capsys.readouterr()
        return code, told.out, told.err

    code, out, err = run(made["q.csv"], "--json", tmp_path / "o.json")
    assert (code, err) == (0, "")
    assert "branch: the posture that people use (one of 8 found)" in out
    assert "of 8 (" in out
    record = json.loads((tmp_path / "o.json").read_text())
    Draft202012Validator(load_schema("path")).validate(record)
    assert record["tool"]["poses"] == 3
    start = ",".join(map(str, Q[0]))
    assert "branch: of the start that was given" in run(made["q.csv"], "--start", start)[1]
    (tmp_path / "mm.csv").write_text(table("x,y,z,qx,qy,qz,qw", 1e3 * POSES[:, :3, 3], quaternions(POSES)))
    code, _, err = run(tmp_path / "mm.csv")
    assert code == 2
    assert "mm.csv: positions up to" in err
    assert "mm.csv, poses: pose 1 is out of reach" in err
    (tmp_path / "p.csv").write_text(table("x,y,z", POSES[:, :3, 3]))
    assert run(tmp_path / "p.csv")[0] == 2
    assert run(tmp_path / "p.csv", "--task", "position")[0] == 0
    (tmp_path / "j.csv").write_text("q1,q2,q3,q4,q5,q6\n0,-1,1,0,1,0\n")
    code, _, err = run(tmp_path / "j.csv", "--start", start)
    assert (code, "--start: a start is for poses of the tip, these are joint values" in err) == (2, True)


def test_millimetres_taken_as_metres_are_warned_of(tmp_path: Path) -> None:
    read = read_poses(files(tmp_path)["q.csv"])
    assert length_hint(read, 1.1) is None
    assert "look like millimetres" in length_hint(read, 0.001)
