"""Specifications that cannot be used are refused in one line with file, line and what is allowed."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.cli import main
from rankdrop.designs import read_spec
from rankdrop.errors import RankdropError

GOOD = """robot = "ur5"
limits = true

[parameters]
upper_arm = { sets = "-2.a", lower = 0.3, upper = 0.5, steps = 5 }

[parameters.offset]
sets = "wrist_2_joint.d"
values = [0.05, 0.1]

[near]
within = "5 deg"
"""
BAD = {
    "robot = \"ur5\"": [
        ('robot = "ur6x"', "line 1, robot: there is no such robot in the catalogue and no such file"),
        ("", "line 1, robot: the robot is not said"),
        ("robot = 5", "line 1, robot: robot is a text; got 5"),
        ('robot = "ur5"\nrobbot = 1', "line 2, robbot: unknown key; got 'robbot'; allowed: robot, tip"),
        ('robot = "ur5"\ntask = "welding"', "line 2, task: "),
        ('robot = "ur5"\nseed = -1', "line 2, seed: seed is not a whole number that can be used; got -1; allowed: 0"),
    ],
    "limits = true": [("limits = 1", "line 2, limits: limits is true or false; got 1; allowed: true, false")],
    "steps = 5": [
        ("steps = 1", "line 5, parameters.upper_arm: steps is not a whole number that can be used; got 1; allowed: 2"),
        ("step = 5", "line 5, parameters.upper_arm: unknown key; got 'step'; allowed: sets, lower, upper, steps"),
        ("steps = 5, values = [1]", "line 5, parameters.upper_arm: lower does not go with values"),
    ],
    "lower = 0.3": [
        ("lower = 0.7", "line 5, parameters.upper_arm: lower is not below upper; got lower 0.7, upper 0.5"),
        ('lower = "3 deg"', "line 5, parameters.upper_arm: the unit is not one that fits here; got '3 deg'; allowed:"),
        ("steps = 2, lower = 0.3", "line 5, column"),
    ],
    "\"-2.a\"": [
        ('"-2.b"',
         "line 5, parameters.upper_arm: there is no such number; got '-2.b'; allowed: JOINT.KEY with JOINT one"),
        ('"9.a"', "line 5, parameters.upper_arm: there is no such number; got '9.a'"),
        ('"tool.w"', "line 5, parameters.upper_arm: there is no such number; got 'tool.w'; allowed: tool.x, tool.y"),
        ('"wrist_2_joint.d"',
         "parameters.offset: two parameters set the same number; got wrist_2_joint.d; fix: leave"),
        ('["2.a", "2.alpha"]', "line 5, parameters.upper_arm: a parameter is a length or an angle"),
    ],
    "values = [0.05, 0.1]": [
        ("values = []", "line 7, parameters.offset: values is a list; got []"),
        ("values = [0.1, 0.1]", "line 7, parameters.offset: a value is given twice"),
        ("lower = 0.1\nupper = 0.2", "line 7, parameters.offset: a grid needs the values; allowed: steps, or values"),
    ],
    "[near]": [
        ("[neer]", "line 11, neer: unknown key; got 'neer'; allowed: robot"),
        ('[sample]\nkind = "sobol"\nvariants = 4\n[near]',
         "line 5, parameters.upper_arm: a sobol sample draws from a range"),
        ('[sample]\nkind = "halton"\n[near]',
         "line 12, sample.kind: there is no such sample; got 'halton'; allowed: grid"),
        ('[[variants]]\nupper_arm = 1\n[near]',
         "line 11, variants: a variant gives every parameter; got upper_arm; allowed:"),
        ("[region]\nlower = [0, 0, 0]\nupper = [1, 1]\n[near]",
         "line 13, region.upper: upper is three numbers; got [1, 1]"),
        ('[paths]\nfiles = ["nowhere.csv"]\n[near]', "line 12, paths.files: "),
        ("[certified]\nwidth = 3\n[near]", "line 12, certified.width: width is out of range; got 3"),
        ('[pareto]\nless = ["cost"]\n[near]',
         "line 12, pareto.less: there is no such measure here; got 'cost'; allowed: near"),
        ("[families]\nstarts = 3\n[near]",
         "line 12, families.starts: starts is not a whole number that can be used; got 3"),
    ],
    "within = \"5 deg\"": [
        ('within = "5 mm"', "line 12, near.within: the unit is not one that fits here; got '5 mm'; allowed: a finite"),
        ("within = 9",
         "line 12, near.within: within is out of range; got 9.0; allowed: above 0, up to 1.5"),
        ("with = 9", "line 12, near.with: unknown key; got 'with'; allowed: within, samples"),
    ],
    "[near]\nwithin = \"5 deg\"": [("", "line 1: nothing is asked of the variants; allowed: [families], [aspects]")],
    GOOD: [
        ("robot = [", "this is not TOML: "),
        ('robot = "ur5"', "parameters: there are no parameters to vary; got 0"),
    ],
}  # fmt: skip
CASES = [(old, new, message) for old, cases in BAD.items() for new, message in cases]


@pytest.mark.parametrize(("old", "new", "message"), CASES)
def test_bad_specs_are_refused_with_file_and_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert GOOD.count(old) == 1
    file = tmp_path / "bad.toml"
    file.write_text(GOOD.replace(old, new))
    with pytest.raises(RankdropError) as caught:
        read_spec(file)
    text = str(caught.value)
    assert text.startswith(str(file))
    assert message in text
    assert "\n" not in text


def test_the_good_one_is_read(tmp_path: Path) -> None:
    file = tmp_path / "good.toml"
    file.write_text(GOOD)
    spec = read_spec(file)
    assert [one.name for one in spec.parameters] == ["upper_arm", "offset"]
    assert spec.parameters[0].values == pytest.approx((0.3, 0.35, 0.4, 0.45, 0.5))
    assert (spec.kind, spec.count, spec.limits) == ("grid", 10, True)
    assert str(spec.parameters[0].places[0]) == "-shoulder_lift_joint.a"


@pytest.mark.parametrize(("line", "message"), [
    ("sweep nothing.toml", "nothing.toml: "),
    ("sweep", "SPEC: no specification is named; allowed: a .toml file, or --status FOLDER"),
    ("sweep x.toml --parquet", "--parquet: the tables need a folder; fix: name one with --out"),
    ("sweep x.toml --figure x.gif", "--figure: the ending names no format; got x.gif; allowed: .svg, .png, .pdf"),
    ("sweep --status nowhere", "nowhere: there is no job in the folder"),
    ("compare ur5", "arms are compared side by side; got 1; allowed: 2 … 10 arms"),
    ("compare ur5 ur5e --lower 1,2", "--lower: it is three numbers; got 1,2; allowed: such as 0.3,-0.3,0.1"),
])  # fmt: skip
def test_bad_command_lines_are_one_line(
    line: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.run([*line.split(), "--quiet"]) == 2
    text = capsys.readouterr()[1]
    assert text.count("\n") == 1
    assert text.startswith("rankdrop: error: ")
    assert message in text
