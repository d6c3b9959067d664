"""Write the catalogue's arms that come from URDF files: one TOML for each row of tests/data/catalogue.csv.

    .venv/bin/python tools/make_catalogue.py                # all of them
    .venv/bin/python tools/make_catalogue.py kr16 gp7       # these

The rows name kinematic skeletons in tests/data (the numbers of the makers' files, word for word) and where they come
from. Angles and axes are read as `open_robot` reads them, that is with rounded right angles taken for right angles.
A row with `ideal` names a tolerance, and in `because` why the ideal arm within it is taken (`rankdrop.robot.ideal`).
Nothing is written where the table does not put the tip where that arm puts it, to 1e-8 m at 50 random configurations.
"""

from __future__ import annotations

import csv
import re
import sys
from math import degrees, isfinite, pi, radians
from pathlib import Path

import numpy as np
from dh_table import angle_text, dh_table, joint_tables, number_text, pose_lines

from rankdrop.disk import replace_file
from rankdrop.kinematics import pose
from rankdrop.robot.ideal import ideal, read_tolerance
from rankdrop.robot.model import JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.toml_file import robot_from_toml

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT / "tests" / "data"
CATALOGUE = ROOT / "src" / "rankdrop" / "robot" / "catalog"
_MEET = 1e-6  # axes nearer than this meet [m]: what a drawing can say
_FASTEST = 12.0  # no joint of an arm turns faster [rad/s]; larger figures stand for "not known"
_FAST = 5.0  # [rad/s]; one figure above it for all joints does too
_DIGITS = 3  # decimals a limit must be printed with to be read as whole degrees


def toml_of(row: dict[str, str], robot: Robot, text: str) -> str:
    """The catalogue's TOML for one row; `text` is the skeleton, for limits as they are printed."""
    limits = [_limits(joint.name, text) for joint in robot.joints]
    if len({joint.velocity for joint in robot.joints}) == 1 and robot.joints[0].velocity > _FAST:
        limits = [[line for line in lines if not line.startswith("velocity")] for lines in limits]
    head = [f'name = "{row["name"]}"', f'maker = "{row["maker"]}"']
    if row["aliases"]:
        quoted = ", ".join(f'"{alias}"' for alias in row["aliases"].split())
        head.append(f"aliases = [{quoted}]")
    at = f" at {row['commit']}" if row["commit"] else ""
    to = " to 1 mm" if row["ideal"] else ""
    source = (
        f"github.com/{row['repository']}{at}, {row['path']}, {row['base']} to {row['tip']}. "
        f"Right angles are exact; the pose of the tip is that of the file{to} (tests/robot/test_sources.py)."
    )
    source += f" {row['because']}" if row["because"] else ""
    common = ['task = "pose"', f'about = "{row["about"]}, {form_of(robot)}"', *_wrapped(source), ""]
    if all(joint.kind is JointKind.REVOLUTE for joint in robot.joints):
        base, rows, tool = dh_table(robot)
        keys = [_dh_keys(*one) for one in rows]
        body = [*pose_lines("base", base), *pose_lines("tool", tool)]
        head.append('convention = "standard"')
    else:
        keys = [_screw_keys(robot, i) for i in range(len(robot.joints))]
        body = pose_lines("home", robot.home)
    return "\n".join([*head, *common, *body, *joint_tables(robot, keys, limits)]).rstrip() + "\n"


def _dh_keys(a: float, alpha: float, d: float, theta: float) -> list[str]:
    lines = [f"a = {number_text(a)}", f"alpha = {angle_text(alpha)}", f"d = {number_text(d)}"]
    return [*lines, f"theta = {angle_text(theta)}"] if angle_text(theta) != "0" else lines


def _screw_keys(robot: Robot, i: int) -> list[str]:
    joint = robot.joints[i]
    slides = joint.kind is JointKind.PRISMATIC
    axis = joint.screw[:3] if slides else joint.screw[3:]
    lines = [f"axis = [{', '.join(number_text(float(x)) for x in axis)}]"]
    if slides:
        return ['kind = "prismatic"', *lines]
    point = np.cross(joint.screw[3:], joint.screw[:3])
    return [*lines, f"point = [{', '.join(number_text(float(x)) for x in point)}]"]


def form_of(robot: Robot) -> str:
    """What can be seen of an arm: "6R, spherical wrist"."""
    letters = "".join(str(joint.kind)[0].upper() for joint in robot.joints)
    short = f"{len(letters)}R" if set(letters) == {"R"} else letters
    if set(letters[-3:]) != {"R"} or len(letters) < 6:
        return short
    lines = [(joint.screw[3:], np.cross(joint.screw[3:], joint.screw[:3])) for joint in robot.joints]
    turning = [i for i, letter in enumerate(letters) if letter == "R"]
    wrist = _meet(lines[-3:])
    shoulder = len(turning) == 7 and _meet([lines[i] for i in turning[:3]])
    if wrist and shoulder:
        return f"{short}, spherical shoulder and wrist"
    return f"{short}, {'spherical' if wrist else 'offset'} wrist" + (", spherical shoulder" if shoulder else "")


def _meet(lines: list[tuple[np.ndarray, np.ndarray]]) -> bool:
    """Whether lines (direction, point) meet in one point."""
    across = [np.eye(3) - np.outer(z, z) for z, _ in lines]
    matrix = np.concatenate(across)
    if np.linalg.matrix_rank(matrix, tol=1e-6) < 3:
        return False
    right = np.concatenate([one @ p for one, (_, p) in zip(across, lines, strict=True)])
    centre = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return bool(np.abs(matrix @ centre - right).max() < _MEET)


def _limits(name: str, text: str) -> list[str]:
    """The lines lower, upper and velocity of a joint, from the skeleton's own digits."""
    found = re.search(rf'<joint name="{re.escape(name)}" type="(\w+)">(.*?)</joint>', text, re.DOTALL)
    assert found is not None
    given = dict(re.findall(r'(lower|upper|velocity)="([^"]+)"', found[2]))
    slides = found[1] == "prismatic"
    if found[1] == "continuous" or float(given.get("lower", 0)) >= float(given.get("upper", 0)):
        given.pop("lower", None), given.pop("upper", None)
    velocity = float(given.get("velocity", 0))
    if not 0.05 < velocity <= _FASTEST:
        given.pop("velocity", None)
    keys = [key for key in ("lower", "upper", "velocity") if key in given]
    return [f"{key} = {_limit(given[key], slides, '/s' if key == 'velocity' else '')}" for key in keys]


def _limit(printed: str, slides: bool, rate: str) -> str:
    """A limit: whole degrees where its printed digits are theirs."""
    value = float(printed)
    whole = round(degrees(value))
    places = len(printed.partition(".")[2])
    near = abs(value - radians(whole)) < 10.0 ** -min(places, 12) and "e" not in printed
    if not slides and whole and places >= _DIGITS and near:
        return f'"{whole} deg{rate}"'
    return number_text(value)


def _wrapped(source: str) -> list[str]:
    words, lines = source.split(), [""]
    for word in words:
        if len(lines[-1]) + len(word) > 114:
            lines.append("")
        lines[-1] += f"{word} "
    return ['source = """\\', *[f"{line.rstrip()} \\" for line in lines[:-1]], f'{lines[-1].rstrip()}"""']


def difference(robot: Robot, other: Robot, count: int = 50) -> float:
    """The largest entry by which the poses of two tips differ [m, 1] at random configurations."""
    q = np.random.default_rng(1).uniform(-pi, pi, (count, robot.n))
    return float(np.abs(pose(robot, q) - pose(other, q)).max())


def rows() -> list[dict[str, str]]:
    """The rows of the list."""
    with (DATA / "catalogue.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def write(row: dict[str, str]) -> None:
    """Write one arm's file."""
    path = DATA / row["file"]
    robot = open_robot(path, base=row["base"], tip=row["tip"])
    if row["ideal"]:
        robot = ideal(robot, length=read_tolerance(row["ideal"]).length)[0]
    text = toml_of(row, robot, path.read_text(encoding="utf-8"))
    off = difference(robot, robot_from_toml(text, file=row["name"]))
    if not (isfinite(off) and off < 1e-8):
        raise SystemExit(f"{row['name']}: the table is {off:.2g} away from the file; nothing was written")
    replace_file(CATALOGUE / f"{row['name']}.toml", text.encode())


if __name__ == "__main__":
    for one in rows():
        if not sys.argv[1:] or one["name"] in sys.argv[1:]:
            write(one)
