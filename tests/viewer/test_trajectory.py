"""Trajectories from CSV: what is understood, and what an error names."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

from rankdrop.distance.monitor import Monitor
from rankdrop.path.read.csv_file import parse_trajectory
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.viewer.tab_path import track_of

ARM = open_robot("scara")  # three joints that turn and, third, one that slides
NAMES = [joint.name for joint in ARM.variables]


def test_names_time_and_units() -> None:
    text = f"time,{NAMES[3]},q1 [deg],q2,{NAMES[2]} [mm],note\n0,1,90,pi/2,100,3\n# pause\n\n0.5,2,180,0.5,200,4\n"
    found = parse_trajectory(text, "a.csv", ARM)
    assert found.timed
    assert found.times.tolist() == [0.0, 0.5]
    assert found.unused == ("note",)
    assert np.allclose(found.q, [[pi / 2, pi / 2, 0.1, 1.0], [pi, 0.5, 0.2, 2.0]])
    assert np.allclose(found.at(0.25), (found.q[0] + found.q[1]) / 2)
    assert np.allclose(found.at(9.0), found.q[1])


def test_degrees_are_for_angles_only() -> None:
    found = parse_trajectory("q1;q2;q3;q4\n90;0;0.2;180\n", "a.csv", ARM, deg=True)
    assert np.allclose(found.q, [[pi / 2, 0, 0.2, pi]])
    assert not found.timed


def test_numbers_alone_need_one_column_for_each_joint() -> None:
    assert parse_trajectory("0,0,0.1,0\n1,0,0.1,0\n", "a.csv", ARM).times.tolist() == [0.0, 0.1]
    with pytest.raises(TrajectoryError, match=r"no names.*5 numbers"):
        parse_trajectory("0,0,0,0.1,0\n", "a.csv", ARM)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no row"),
        ("q1,q2,q3,q4\n", "no row below the names"),
        ("q1,q2,q3\n0,0,0\n", f"joints have no column.*add {NAMES[3]}"),
        ("q1,q2,q3,q9\n0,0,0,0\n", "line 1, column 4: there is no such joint; got 'q9'"),
        ("q1,q2,q3,q4,q2\n0,0,0,0,0\n", "column 5: the column is given twice"),
        ("q1,q2,q3,q4\n0,0,0,0\n0,x,0,0\n", r"a.csv, line 3, column 2 \(q2\): this is no number; got 'x'"),
        ("q1,q2,q3,q4\n0,0,0\n", r"line 2, column 4 \(q4\): the row is too short"),
        ("q1,q2,q3,q4\n0,nan,0,0\n", "line 2, column 2.*not finite"),
        ("q1,q2,q3 [deg],q4\n0,0,0,0\n", "column 3.*the unit does not fit"),
        ("t,q1,q2,q3,q4\n0,0,0,0,0\n1,0,0,0,0\n1,0,0,0,0\n", "line 4, column 't': time does not go on; got 1 after 1"),
    ],
)
def test_errors_name_file_line_and_column(text: str, said: str) -> None:
    with pytest.raises(TrajectoryError, match=said) as error:
        parse_trajectory(text, "a.csv", ARM)
    assert str(error.value).startswith("a.csv")


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match=r"missing\.csv"):
        read_trajectory(tmp_path / "missing.csv", ARM)
    (tmp_path / "bytes.csv").write_bytes(b"q1,\0\n")
    with pytest.raises(TrajectoryError, match=r"bytes.csv"):
        read_trajectory(tmp_path / "bytes.csv", ARM)


def test_the_track_finds_the_singular_row() -> None:
    text = "q1,q2,q3,q4\n0,0.5,0.1,0\n0,0,0.1,0\n0,-0.5,0.1,0\n"
    track = track_of(parse_trajectory(text, "a.csv", ARM), Monitor(ARM, resolve_task(None, ARM), ()))
    assert track.worst == 1
    assert track.singular == 1
    assert track.distance[1] == 0.0
    assert track.sigma[0] == pytest.approx(track.sigma[2])
