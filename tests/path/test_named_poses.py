"""Poses of JSON and YAML with makers' names: read as the same columns of a CSV file are."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rankdrop.errors import OptionError
from rankdrop.path.read.poses import holds_poses, read_poses
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.path.read.written_poses import check_pose_target
from rankdrop.robot.open import open_robot

ARM = open_robot("kr6r900")
FORMS = {
    "KUKA": {"X": [500.0, 510.0], "Y": [0.0, 5.0], "Z": [600.0, 610.0], "A": [10.0, 20.0], "B": [90.0, 80.0],
             "C": [0.0, 3.0]},
    "FANUC": {"x": [500.0, 510.0], "y": [0.0, 5.0], "z": [600.0, 610.0], "w": [180.0, 170.0], "p": [0.0, 10.0],
              "r": [30.0, 40.0]},
    "UR": {"x": [0.5, 0.51], "y": [0.0, 0.1], "z": [0.6, 0.7], "rx": [0.0, 0.1], "ry": [3.0, 3.1], "rz": [0.1, 0.0]},
    "ABB": {"x": [500.0, 510.0], "y": [0.0, 5.0], "z": [600.0, 610.0], "q1": [0.0, 1.0], "q2": [1.0, 0.0],
            "q3": [0.0, 0.0], "q4": [0.0, 0.0]},
    "units": {"x [mm]": [500.0, 510.0], "y [mm]": [0.0, 5.0], "z [mm]": [600.0, 610.0], "roll [deg]": [10.0, 20.0],
              "pitch [deg]": [9.0, 8.0], "yaw [deg]": [0.0, 3.0], "time": [0.0, 1.5]},
}  # fmt: skip


def rows(form: str) -> list[dict[str, float]]:
    columns = FORMS[form]
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("wrap", ["list", "poses", "pose"])
def test_objects_with_makers_names_are_read_as_columns(form: str, wrap: str, tmp_path: Path) -> None:
    table, file = tmp_path / "a.csv", tmp_path / "a.json"
    lines = [",".join(FORMS[form]), *(",".join(map(repr, row.values())) for row in rows(form))]
    table.write_text("\n".join(lines) + "\n")
    value: object = {"list": rows(form), "poses": {"poses": rows(form)}, "pose": [{"pose": row} for row in rows(form)]}
    file.write_text(json.dumps(value[wrap] if isinstance(value, dict) else value))
    assert holds_poses(file, ARM)
    expected, found = read_poses(table, robot=ARM), read_poses(file, robot=ARM)
    np.testing.assert_array_equal(found.matrices, expected.matrices)
    assert found.notes == expected.notes
    assert (found.name, found.turned) == ("a.json", expected.turned)
    np.testing.assert_array_equal(found.times, expected.times)


def test_yaml_and_units_beside_the_poses(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("length: mm\nangle: rad\nposes:\n- {x: 1, y: 2, z: 3, a: 0.1, b: 0.2, c: 0.3, name: first}\n")
    found = read_poses(file, robot=ARM)
    np.testing.assert_allclose(found.matrices[0, :3, 3], [0.001, 0.002, 0.003])
    assert found.matrices[0, 2, 0] == pytest.approx(-np.sin(0.2))


def test_other_names_and_values_are_refused_with_the_pose(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text(json.dumps([*rows("KUKA"), {"X": 1.0, "Y": 2.0, "Z": 3.0}]))
    with pytest.raises(
        TrajectoryError, match=r"pose 3: the pose has other names than the first; fix: add A, B, C"
    ):
        read_poses(file)
    file.write_text(json.dumps([rows("KUKA")[0], rows("KUKA")[1] | {"A": "ten"}]))
    with pytest.raises(TrajectoryError, match=r"pose 2: a value is no finite number; got A"):
        read_poses(file)


def test_such_objects_are_not_written_again(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text(json.dumps(rows("KUKA")))
    with pytest.raises(OptionError, match="not written again"):
        check_pose_target(file, "out.json")
