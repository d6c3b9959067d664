"""Job (g): an integrator. An arm on a rail, described by a xacro file with an argument and a macro of his own.

What has to be known: a file stands in place of a name; `--arg NAME:=VALUE` is an argument of the xacro. Joints of the
file keep their names.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from jobs.shell import run

pytestmark = pytest.mark.slow
AXES = (
    ("rail", "prismatic", "0 0 0.2", "0 1 0"), ("a1", "revolute", "0 0 0.4", "0 0 1"),
    ("a2", "revolute", "0.15 0 0", "0 1 0"), ("a3", "revolute", "0 0 0.6", "0 1 0"),
    ("a4", "revolute", "0.5 0 0", "1 0 0"), ("a5", "revolute", "0 0 0", "0 1 0"),
    ("a6", "revolute", "0.1 0 0", "1 0 0"),
)  # fmt: skip
MACRO = """<xacro:macro name="axis" params="name parent type xyz axis low high">
  <link name="after_${name}"/>
  <joint name="${name}" type="${type}">
    <parent link="${parent}"/><child link="after_${name}"/><origin xyz="${xyz}"/><axis xyz="${axis}"/>
    <limit lower="${low}" upper="${high}" effort="100" velocity="2"/>
  </joint>
</xacro:macro>"""


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """The folder with the file of the cell."""
    pytest.importorskip("xacro")
    parents = ["floor", *(f"after_{name}" for name, *_ in AXES)]
    limits = {"rail": 'low="0" high="$(arg rail_length)"'}
    joints = "\n".join(
        f'<xacro:axis name="{name}" parent="{parent}" type="{kind}" xyz="{xyz}" axis="{axis}" '
        f'{limits.get(name, """low="-3" high="3" """)}/>'
        for parent, (name, kind, xyz, axis) in zip(parents, AXES, strict=False)
    )
    (tmp_path / "cell.xacro").write_text(
        f'<robot name="cell" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
        f'<xacro:arg name="rail_length" default="3"/>\n{MACRO}\n<link name="floor"/>\n{joints}\n</robot>\n',
        encoding="utf-8",
    )
    return tmp_path


@pytest.mark.by_hand
def test_the_families_of_the_cell_under_the_names_of_its_joints(cell: Path) -> None:
    ended = run(cell, "analyze", "cell.xacro", "--arg", "rail_length:=4", "--starts", "2000", "--json", "cell.json")
    assert ended.returncode == 0, ended.stderr
    assert "joints: q1 rail, θ2 a1, θ3 a2, θ4 a3, θ5 a4, θ6 a5, θ7 a6" in " ".join(ended.stdout.split())
    record = json.loads((cell / "cell.json").read_text(encoding="utf-8"))
    assert record["verdict"] == "verified"
    rail = next(joint for joint in record["robot"]["joints"] if joint["name"] == "rail")
    assert (rail["kind"], rail["upper"]) == ("prismatic", 4.0)
    assert all(1 not in [pin["number"] for pin in family["pinned"]] for family in record["families"])


def test_which_joint_to_jog_is_said_by_its_name(cell: Path) -> None:
    """Joint 4 of the chain is the maker's a3: a number alone would be taken for a4."""
    ended = run(cell, "explain", "cell.xacro", "--deg", "--q", "1500mm,0,0,90,0,0,0", "--analysis", "cell.json")
    assert ended.returncode == 2
    assert "cell.json" in ended.stderr
    ended = run(cell, "explain", "cell.xacro", "--deg", "--q", "1500mm,0,0,90,0,0,0")
    assert ended.returncode == 4, ended.stderr
    first = " ".join(ended.stdout.splitlines()[:6])
    assert "Get out: jog joint a3 by" in " ".join(first.split())
    assert "elbow and wrist: arm folded, joint a5 at 0°" in " ".join(first.split())


def test_a_mistyped_argument_is_named_with_those_that_there_are(cell: Path) -> None:
    ended = run(cell, "analyze", "cell.xacro", "--arg", "rail:=4")
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "the file has no such argument; got 'rail'; allowed: rail_length" in ended.stderr
