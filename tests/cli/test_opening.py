"""How every command opens an arm: options for packages and xacro, and errors that name the option to type."""

from __future__ import annotations

import inspect
import json
from pathlib import Path

import pytest

from rankdrop.cli import exits
from rankdrop.cli.main import app
from rankdrop.cli.opening import ArmOptions
from rankdrop.options import hints

OPENING = {
    "analyze": (), "conditions": (), "find": ("--corank", "1"), "explain": ("--q", "0,0"), "report": (), "view": (),
}  # fmt: skip
"""Commands that open an arm, with what else they need."""
JOINT = """<joint name="j{0}" type="$(arg kind)"><parent link="l{0}"/><child link="l{1}"/><axis xyz="0 0 1"/>
<origin xyz="{0} 0 0"/></joint>"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A planar arm of two joints whose kind is an argument without a default."""
    path = tmp_path / "arm.urdf.xacro"
    links = "".join(f'<link name="l{i}"/>' for i in range(4))
    tip = '<joint name="t" type="fixed"><parent link="l2"/><child link="l3"/><origin xyz="1 0 0"/></joint>'
    path.write_text(
        f'<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro">{links}{JOINT.format(0, 1)}{JOINT.format(1, 2)}'
        f"{tip}</robot>", encoding="utf-8",
    )  # fmt: skip
    return path


def test_every_command_that_opens_an_arm_is_here() -> None:
    opening = set()
    for name in ("robots", *OPENING):
        function = app[name].default_command
        kinds = [p.annotation for p in inspect.signature(function).parameters.values()]
        if any(isinstance(kind, type) and issubclass(kind, ArmOptions) for kind in kinds):
            opening.add(name)
    assert opening == set(OPENING)


@pytest.mark.slow
@pytest.mark.parametrize("command", OPENING)
def test_a_missing_argument_is_named_as_the_option_to_type(run, command: str, arm: Path) -> None:
    pytest.importorskip("xacro")
    ended = run(command, str(arm), *OPENING[command])
    assert (ended.code, ended.out) == (exits.BAD_INPUT, "")
    assert ended.err.endswith("got no value of kind; fix: --arg kind:=VALUE\n")


@pytest.mark.slow
def test_arguments_reach_the_file(run, arm: Path) -> None:
    pytest.importorskip("xacro")
    ended = run("find", str(arm), "--arg", "kind:=continuous", "--task", "planar-position", "--corank", "1",
                "--starts", "50", "--quiet", "--json", "-")  # fmt: skip
    assert ended.code == exits.FINE
    assert json.loads(ended.out)["robot"]["name"] == "two"
    refused = run("find", str(arm), "--arg", "kind:=continuous", "--arg", "knd:=x", "--corank", "1")
    assert refused.err.endswith("the file has no such argument; got 'knd'; allowed: kind\n")


@pytest.mark.slow
def test_a_urdf_with_xacro_elements_is_expanded_with_the_option_alone(run, arm: Path) -> None:
    pytest.importorskip("xacro")
    plain = arm.with_name("arm.urdf")
    text = arm.read_text(encoding="utf-8").replace("$(arg kind)", "continuous")
    plain.write_text(text.replace("<link", '<xacro:property name="x" value="1"/><link', 1), encoding="utf-8")
    words = ("find", str(plain), "--task", "planar-position", "--corank", "1", "--starts", "50", "--quiet")
    refused = run(*words)
    assert refused.code == exits.BAD_INPUT
    assert refused.err.endswith("expanding it can run any command; fix: if you trust it: --xacro\n")
    assert run(*words, "--xacro").code == exits.FINE


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("kind=fixed",), "--arg: this is not of the form; got 'kind=fixed'; allowed: NAME:=VALUE"),
        ((":=x",), "--arg: this is not of the form"),
        (("a:=1", "a:=2"), "--arg: the name is given twice; got a"),
    ],
)
def test_arguments_that_are_none_are_refused(run, arm: Path, words: tuple[str, ...], said: str) -> None:
    ended = run("analyze", str(arm), *(part for word in words for part in ("--arg", word)))
    assert ended.code == exits.BAD_INPUT
    assert said in ended.err


def test_the_value_of_an_argument_may_be_empty_or_hold_the_sign_itself() -> None:
    assert ArmOptions(arg=("a:=", "b:=x:=y", "c:=-1")).arguments == {"a": "", "b": "x:=y", "c": "-1"}


def test_python_and_the_command_line_have_the_same_options() -> None:
    from rankdrop.robot.open import open_robot

    renamed = {"package": "packages", "arg": "args"}
    options = {renamed.get(name, name) for name in hints(ArmOptions)} - {"task", "length_scale", "ideal"}
    assert options <= set(inspect.signature(open_robot).parameters)


def test_a_note_on_the_size_is_shown(run, tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    joints = "".join(f"[[joints]]\na = {a}\n" for a in (400, 300))
    path.write_text(f'convention = "standard"\ntask = "planar-position"\n{joints}', encoding="utf-8")
    ended = run("find", str(path), "--corank", "1", "--starts", "50", "--quiet")
    assert "the arm's reach is 700 m: are these numbers millimetres?" in " ".join(ended.out.split())
