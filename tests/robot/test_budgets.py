"""What readers accept at most: refused before the work, with file and place; one range of numbers in all of them."""

from __future__ import annotations

import io
import json
import tomllib
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

from rankdrop.cli.values import parse_configuration
from rankdrop.errors import RankdropError, RobotError
from rankdrop.path.read import messages as message_file
from rankdrop.path.read.csv_file import parse_trajectory
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.messages import parse_message
from rankdrop.robot import files, formats, quantities
from rankdrop.robot import urdf as urdf_reader
from rankdrop.robot.ideal import read_tolerance
from rankdrop.robot.mesh_file import LARGEST_MESH, MOST_FACES, MOST_INSTANCES, MOST_MESHES, MOST_VERTICES
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.robot.quantities import Angles, quantity
from rankdrop.robot.shapes import MOST_VISUALS
from rankdrop.robot.toml_file import robot_from_toml
from rankdrop.robot.urdf import from_urdf, number
from robot.urdf_text import chain, joint, robot

ARM = open_robot("scara")
ROW = "[[joints]]\na = 1\n"
DH = 'convention = "standard"\n'


class Guard:
    """An expression whose time grows with the square of the length: it sees no long text."""

    def __init__(self, expression: Any) -> None:
        self.expression, self.longest = expression, 0

    def fullmatch(self, text: str) -> Any:
        self.longest = max(self.longest, len(text))
        assert self.longest <= files.LONGEST_TEXT
        return self.expression.fullmatch(text)


HOSTILE = ("1" + " " * 16_000 + "!", "9" * 16_000 + "x", "a" * 16_000, "1" * 500)


@pytest.mark.parametrize("text", HOSTILE)
def test_a_long_text_is_refused_before_any_expression_sees_it(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """16 kB took 27 s."""
    for module, name in ((quantities, "_WITH_UNIT"), (quantities, "_ARITHMETIC"), (urdf_reader, "_NUMBER")):
        monkeypatch.setattr(module, name, Guard(getattr(module, name)))
    with pytest.raises(RobotError, match=r"place: the text is too long for a quantity; got \d+ characters"):
        quantity(text, "angle", where="place")
    with pytest.raises(RobotError, match="xyz is not a finite number"):
        number(text, "place", "xyz")
    with pytest.raises(RankdropError):
        parse_configuration(f"{text.replace(' ', '_')},0,0,0", ARM, deg=False)
    with pytest.raises(RankdropError):
        parse_trajectory(f"q1,q2,q3,q4\n{text},0,0,0\n", "a.csv", ARM)
    assert quantity("1 mm", "length", where="x") == 0.001


def test_a_long_tolerance_or_name_of_a_column_is_refused() -> None:
    with pytest.raises(RankdropError, match="not a tolerance"):
        read_tolerance("1" * 16_000 + "x")
    with pytest.raises(RankdropError, match=r"a.csv, line 1, column 2: the name of the column is too long"):
        parse_trajectory(f"q1,q2{' ' * 100}{'(' * 300},q3,q4\n0,0,0,0\n", "a.csv", ARM)


@pytest.mark.slow
def test_keys_with_many_dots_never_reach_the_parser(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """40 kB of them took 1.6 GB."""
    path = tmp_path / "dots.toml"
    path.write_text("a = 1\n" + ".".join(["a"] * 20_000) + " = 1\n")

    def parsed(*_: Any, **__: Any) -> None:
        raise AssertionError("the parser was started")

    with monkeypatch.context() as patched:
        patched.setattr(tomllib, "loads", parsed)
        with pytest.raises(RobotError, match=r"dots.toml, line 2: the keys have too many dots; .*allowed: 2000 in one"):
            open_robot(path)
        with pytest.raises(RobotError, match="too large; allowed: at most 1 MB"):
            robot_from_toml("#" * (files.LARGEST_TABLE + 1), file="x")
    many = DH + "\n".join([f"{ROW}alpha = 1.5708\nlower = -3.1\nupper = 3.1"] * files.MOST_JOINTS)
    assert robot_from_toml(many, file="x").n == files.MOST_JOINTS
    with pytest.raises(RobotError, match=r"x, line \d+, joints: the chain has too many moving joints; got 201"):
        robot_from_toml(many + "\n" + ROW, file="x")


@pytest.mark.by_hand
def test_a_chain_longer_than_any_arm_is_refused_before_its_numbers_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """40,000 joints took 45 s."""
    read: list[str] = []
    take = Angles.take
    monkeypatch.setattr(Angles, "take", lambda self, text: read.append(text) or take(self, text))
    inside = '<origin xyz="0 0 1" rpy="1.57 0 0"/>'
    links = ["base", *(f"l{i}" for i in range(1, 40_001))]
    steps = [joint(f"j{i}", links[i - 1], links[i], "continuous", inside) for i in range(1, 20_001)]
    with pytest.raises(RobotError, match=r"a.urdf: the chain has too many moving joints; got 20000; allowed"):
        from_urdf(robot(steps), file="a.urdf")
    still = [joint(f"j{i}", links[i - 1], links[i], "fixed", inside) for i in range(2, files.MOST_STEPS + 2)]
    with pytest.raises(RobotError, match="too many joints; got 5001; allowed: at most 5000"):
        from_urdf(robot([*steps[:1], *still]))
    assert not read
    assert from_urdf(robot(chain(files.MOST_JOINTS))).n == files.MOST_JOINTS


def test_comments_before_the_root_are_passed_over_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each <!-- that never ends was looked through to the end of the file, once for every one of them."""
    class Text(str):
        looked = 0

        def find(self, *given: Any) -> int:
            Text.looked += 1
            return str.find(self, *given)

    assert formats._root_tag(Text("<!--" * 10_000)) == ""
    assert Text.looked <= 3
    assert formats._root_tag("<?xml?> < <!-- <sdf> --> <!----> <mujoco a='1'>") == "mujoco"
    assert formats._root_tag("<!-- <mujoco>") == ""


def urdf(origin: str = "", **changed: str) -> str:
    limit = {"lower": "-1", "upper": "1", "velocity": "2"} | changed
    words = " ".join(f'{key}="{value}"' for key, value in limit.items())
    return robot([joint("j", "base", "l", "revolute", f"<origin {origin}/><limit {words}/>")])


TOO_LARGE: dict[str, tuple[Callable[[], object], str]] = {
    "URDF length": (lambda: from_urdf(urdf('xyz="0 1e155 0"'), file="a.urdf"),
                    r"a.urdf, line 2, <origin> of joint 'j', xyz: .*got 1e155; allowed: -1e[+]12 … 1e[+]12 m"),
    "URDF angle": (lambda: from_urdf(urdf('rpy="0 1e17 0"'), file="a.urdf"),
                   r"line 2, <origin> of joint 'j', rpy: .*got 1e17; allowed: -1e[+]06 … 1e[+]06 rad"),
    "DH length": (lambda: robot_from_toml(f"{DH}{ROW}d = 1e13", file="a.toml"), r"a.toml, line 4, joint 1, d: .* m$"),
    "DH angle": (lambda: robot_from_toml(f"{DH}{ROW}theta = 1e17", file="a.toml"), r"line 4, joint 1, theta: .* rad$"),
    "DH limit": (lambda: robot_from_toml(f"{DH}{ROW}lower = -1e17", file="a.toml"), r"joint 1, lower: .* rad$"),
    "DH rate": (lambda: robot_from_toml(f"{DH}{ROW}velocity = 1e17", file="a.toml"), r"joint 1, velocity: .* rad/s$"),
    "screw": (lambda: robot_from_toml("[[joints]]\naxis=[0, 0, 1]\npoint=[0, 1e13, 0]", file="a.toml"),
              r"a.toml, line 3, joint 1, point: .* m$"),
    "--q": (lambda: parse_configuration("1e17,0,0,0", ARM, deg=False), r"^--q, joint .*got 1e17; allowed: .* rad$"),
    "--q, slide": (lambda: parse_configuration("0,0,1e13,0", ARM, deg=False), r"^--q, joint .*allowed: .* m$"),
    "CSV": (lambda: parse_trajectory("q1,q2,q3,q4\n0,0,0,0\n0,1e7,0,0\n", "a.csv", ARM),
            r"a.csv, line 3, column 2 \(q2\): .*got 1e[+]07; allowed: .* rad"),
    "CSV, slide": (lambda: parse_trajectory("q1,q2,q3 [mm],q4\n0,0,1e16,0\n", "a.csv", ARM),
                   r"column 3 .*got 1e[+]16.* m$"),
    "CSV, time": (lambda: parse_trajectory("t,q1,q2,q3,q4\n0,0,0,0,0\n1e300,0,0,0,0\n", "a.csv", ARM),
                  r"line 3, column 't': the time is too large; got 1e[+]300; allowed: .* s$"),
}  # fmt: skip


@pytest.mark.parametrize("name", TOO_LARGE)
def test_one_range_for_lengths_and_angles_in_every_reader(name: str) -> None:
    read, words = TOO_LARGE[name]
    with pytest.raises(RankdropError, match=words) as caught:
        read()
    assert "too large" in str(caught.value)


def test_the_ends_of_the_range_are_read() -> None:
    assert from_urdf(urdf('xyz="0 1e12 0" rpy="0 1e6 0"'), as_written=True).joints[0].frame[1, 3] == 1e12
    assert parse_configuration("1e6,-1e6,1e12,0", ARM, deg=False) == [1e6, -1e6, 1e12, 0.0]
    assert quantity("1e12 m", "length", where="x") == 1e12


@pytest.mark.slow
def test_mjcf_has_the_same_range(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "a.xml"
    body = '<body name="b" pos="{} 0 0"><joint name="j" axis="0 0 1"/><geom size="1"/></body>'
    path.write_text(f"<mujoco><worldbody>{body.format('1e13')}</worldbody></mujoco>")
    with pytest.raises(RobotError, match=r"joint 'j': the (moment|place).* is too large; .*allowed: -1e[+]12"):
        open_robot(path)
    for ref in ("nan", "inf", "1e30"):
        turned = body.format("1").replace('axis="0 0 1"', f'axis="0 0 1" ref="{ref}"')
        path.write_text(f'<mujoco><compiler angle="radian"/><worldbody>{turned}</worldbody></mujoco>')
        with pytest.raises(RobotError, match=r"joint 'j': ref is too large, or no number; .*allowed: -1e[+]06"):
            open_robot(path)
    bodies = "".join(f'<site name="s{i}"/>' for i in range(files.MOST_BODIES))
    path.write_text(f"<mujoco><worldbody>{body.format('1')}{bodies}</worldbody></mujoco>")
    with pytest.raises(RobotError, match="there are too many elements; allowed: at most 20000"):
        open_robot(path)


@pytest.mark.parametrize("huge", ["1e16", "1.7976931348623157e308"])
def test_exporters_numbers_for_no_limit_are_none(huge: str) -> None:
    found = from_urdf(urdf(lower=f"-{huge}", upper=huge, velocity=huge))
    assert (found.joints[0].lower, found.joints[0].upper, found.joints[0].velocity) == (-inf, inf, inf)
    assert sum("is read as no limit" in str(note) for note in found.notes) == 3
    with pytest.raises(RobotError, match="lower limit above upper limit"):
        from_urdf(urdf(lower=huge, upper=huge))


def test_arms_made_in_python_have_the_range_too() -> None:
    far = np.eye(4)
    far[0, 3] = 1e13
    hinge = np.array([0.0, 0, 0, 0, 0, 1])
    with pytest.raises(RobotError, match="joint 'j': the place of the joint is too large"):
        Joint("j", JointKind.REVOLUTE, hinge, frame=far)
    with pytest.raises(RobotError, match="the place of the tip is too large"):
        Robot("r", (Joint("j", JointKind.REVOLUTE, hinge),), home=far)


def message(**changed: Any) -> str:
    names = [joint.name for joint in ARM.variables]
    return json.dumps({"joint_names": names, "points": [{"positions": [0.0] * 4}]} | changed)


@pytest.mark.parametrize(
    ("text", "yaml", "words"),
    [
        ("[" * 200_000, False, "nested too deeply"),
        (message(points=[{"positions": [10**4000, 0, 0, 0]}]), False, "no number"),
        ('{"joint_names": [' + "9" * 5000 + "]}", False, "too many digits"),
        (message(joint_names=[[["a"]]]), False, "no list of texts"),
        (message(points=[{"positions": [1e7, 0, 0, 0]}]), False, r"row 1, joint .*too large"),
        ("[" * 101, True, "a, line 1: the objects are nested too deeply; allowed: depth 100"),
        ("[" * 1_000_000, True, ""),  # who refuses it, and how it says so, is the reader's
        ("a: &a {b: 1}\nc: {<<: *a}", True, "merge keys are not read"),
        ("a: 2026-13-45", True, "not YAML"),
        ("trajectory: &a {trajectory: *a}", True, "no JointTrajectory"),
        ("joint_names: &a [*a]\npoints: [1]", True, "no list of texts"),
    ],
)
def test_hostile_messages_are_refused_in_one_line(text: str, yaml: bool, words: str) -> None:
    if yaml:
        pytest.importorskip("yaml")
    with pytest.raises(RankdropError, match=words or None) as caught:
        parse_message(text, "a", ARM, yaml=yaml)
    assert len(str(caught.value)) < 300
    assert str(caught.value).isprintable()


def test_yaml_has_a_size_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("yaml")
    monkeypatch.setattr(message_file, "LARGEST_YAML", 2**20)
    with pytest.raises(RankdropError, match="too large; allowed: at most 1 MB of YAML"):
        parse_message(message() + " " * 2**20, "a", ARM, yaml=True)


def test_an_archive_tells_its_size_before_it_is_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "bomb.npz"
    np.savez_compressed(path, q=np.zeros((20_000, 4)), other=np.zeros(10))
    assert read_trajectory(path, ARM).q.shape == (20_000, 4)
    monkeypatch.setattr("rankdrop.path.read.arrays.LARGEST_ARRAY", 100_000)
    monkeypatch.setattr("rankdrop.path.read.arrays.read_array", lambda *_, **__: pytest.fail("it was unpacked"))
    with pytest.raises(RankdropError, match=r"bomb.npz, q: the array is too large"):
        read_trajectory(path, ARM)


def test_an_archive_with_two_arrays_of_one_name_is_refused(tmp_path: Path) -> None:
    """The size of one was checked and the other one was read: a file of 3 MB cost 6.2 GB."""
    small, large = io.BytesIO(), io.BytesIO()
    np.save(small, np.zeros((2, 4)))
    np.save(large, np.zeros((20_000, 4)))
    with ZipFile(tmp_path / "twice.npz", "w", ZIP_DEFLATED) as archive:
        archive.writestr("q", small.getvalue())
        archive.writestr("q.npy", large.getvalue())
    with pytest.raises(RankdropError, match=r"twice.npz, q: two arrays of the archive have the same name"):
        read_trajectory(tmp_path / "twice.npz", ARM)


def test_small_numbers_of_an_archive_do_not_become_large_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """480 MB of bytes, 0.5 MB packed, became 3.8 GB of doubles before their rows were counted."""
    path = tmp_path / "bytes.npz"
    np.savez_compressed(path, q=np.zeros((20_000, 4), dtype=np.int8))
    assert read_trajectory(path, ARM).q.shape == (20_000, 4)
    monkeypatch.setattr("rankdrop.path.read.arrays.LARGEST_ARRAY", 100_000)
    with pytest.raises(RankdropError, match=r"bytes.npz, q: the array is too large; got 80000 numbers"):
        read_trajectory(path, ARM)


def test_errors_are_short_and_printable_whatever_the_file_says() -> None:
    names = [joint(f"j{i}", "base", f"l{i}{'x' * 500}") for i in range(100)]
    with pytest.raises(RobotError, match=" … ") as caught:
        from_urdf(robot(names))
    assert len(str(caught.value)) < 6000
    error = RobotError("a\x1bb", where="\x9bx", got="\u202e", allowed="\r", mend="\x00")
    assert str(error).isprintable()


def test_the_page_of_limits_is_what_the_code_has() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "limits.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if line[:2] == "| "]
    told = {row[0]: row[1] for row in rows}
    mb = 2**20
    for start, value in {
        "XML (URDF": f"{files.LARGEST_FILE // mb} MB", "TOML, lists": f"{files.LARGEST_TABLE // mb} MB",
        "YAML": f"{files.LARGEST_YAML // mb} MB;", "array in": f"{files.LARGEST_ARRAY // mb} MB,",
        "mesh file of": f"{LARGEST_MESH // mb} MB", "mesh files": f"{MOST_MESHES}", "shapes": f"{MOST_VISUALS:,}",
        "triangles": f"{MOST_FACES:,}", "vertices": f"{MOST_VERTICES:,}", "copies": f"{MOST_INSTANCES:,}",
        "moving joints": f"{files.MOST_JOINTS:,}",
        "joints of a chain": f"{files.MOST_STEPS:,}", "elements of an XML file": f"{files.MOST_ELEMENTS:,}",
        "elements of an MJCF": f"{files.MOST_BODIES:,}", "elements of XML, lists": f"{files.DEEPEST}",
        "dots in": f"{files.DOTS**0.5:,.0f}; over all lines the sum of their squares up to {files.DOTS:,}",
        "rows of": f"{files.MOST_ROWS:,}", "arrays of": f"{files.MOST_MEMBERS:,}",
        "characters of": f"{files.LONGEST_HEAD}",
        "length, place": f"−{files.LARGEST_LENGTH:g} … {files.LARGEST_LENGTH:g} m".replace("e+", "e"),
        "angle, joint": f"−{files.LARGEST_ANGLE:g} … {files.LARGEST_ANGLE:g} rad".replace("e+06", "e6"),
        "entry of": f"−{files.LARGEST_NUMBER:g} … {files.LARGEST_NUMBER:g}".replace("e+", "e"),
        "time of": f"−{files.LARGEST_TIME:g} … {files.LARGEST_TIME:g} s".replace("e+", "e"),
        "number written": f"at most {files.LONGEST_TEXT} characters",
    }.items():  # fmt: skip
        found = [cell for name, cell in told.items() if name.startswith(start)]
        assert len(found) == 1, start
        assert found[0].startswith(value), f"{start}: {found[0]}, the code has {value}"


def test_an_error_repeats_at_most_200_characters_of_a_value() -> None:
    with pytest.raises(RobotError) as caught:
        quantity("1" + "+1" * 5000, "angle", where="here")
    assert len(str(caught.value)) < 400
    assert len(str(RobotError("wrong", got="x" * 5000))) < 250


@pytest.mark.parametrize("name", ["a" * 201, "\u3042" * 70])
def test_a_name_too_long_for_a_file_is_refused(name: str) -> None:
    with pytest.raises(RobotError, match=r"the name is too long; got .*allowed: at most 200 bytes"):
        robot_from_toml(f'name = "{name}"\n{DH}{ROW}', file="a.toml")
    assert robot_from_toml(f'name = "{name[:60]}"\n{DH}{ROW}', file="a.toml").name == name[:60]


def test_a_long_row_of_followers_is_walked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each one traced its leaders to the first: 484 kB took a minute, before joints were counted."""
    joints = []
    for i in range(150):
        leader = f'<mimic joint="j{i - 1}" multiplier="-1" offset="0.01"/>' if i else ""
        joints.append(
            f'<link name="l{i + 1}"/><joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>{leader}</joint>'
        )
    calls = []
    whole = urdf_reader.number
    monkeypatch.setattr(urdf_reader, "number", lambda *given: calls.append(given[2]) or whole(*given))
    arm = from_urdf(f'<robot name="r"><link name="l0"/>{"".join(joints)}</robot>')
    assert calls.count("multiplier") == 149
    mimics = [joint.mimic for joint in arm.joints if joint.mimic is not None]
    assert {mimic.leader for mimic in mimics} == {"j0"}
    assert [mimic.multiplier for mimic in mimics[:3]] == [-1.0, 1.0, -1.0]
    assert [round(mimic.offset, 12) for mimic in mimics[:3]] == [0.01, 0.0, 0.01]  # o_j = o − o_(j−1)
