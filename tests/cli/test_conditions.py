"""`rankdrop conditions`: what it prints, writes and refuses; its record against the schema; Ctrl-C, the time limit."""

from __future__ import annotations

import json
import math
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from closed_schema import closed
from jsonschema import Draft202012Validator
from printed import one_line

import rankdrop
from rankdrop.cli import exits
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task

FEW = ("--points", "20", "--quiet")
HELICAL = """
name = "screwed"
[[joints]]
screw = [0, 0, 0.1, 0, 0, 1]
[[joints]]
screw = [0, 0, 0, 0, 1, 0]
"""


# what is printed


def test_the_text_names_the_arm_its_lengths_and_every_condition(run) -> None:
    ended = run("conditions", "puma560", "--coranks", "1", "--full", *FEW)
    assert ended.code == exits.FINE
    assert ended.err == ""
    text = one_line(ended.out)
    for words in (
        "puma560: Unimation PUMA 560",
        "lengths a2 = 0.4318 m, d3 = 0.15005 m, a3 = 0.0203 m, d4 = 0.4318 m",
        "corank 1 also by decoupling reason spherical wrist",
        "Corank 1 rank 5 of 6: 3 families",
        "θ5 = 0 or π",
        "a3 s3 + d4 c3 = 0",
        "a2 c2 + a3 c23 − d4 s23 = 0",
        "s_i is sin θi",
        "nothing is said about coranks above 1",
        "corank 1 derived twice: rank tree and decoupling agree",
        "Verified by exact derivation",
    ):
        assert words in text, words


def test_an_angle_that_is_not_the_joint_variable_is_told(run) -> None:
    found = run("conditions", "z1", "--coranks", "1", "--points", "0", "--quiet", "--full")
    assert "\nangles        θ3 = q3 + 2.886, θ4 = q4 + 0.2557; else θ = q\n" in found.out


@pytest.mark.slow
def test_steps_are_printed_on_request(run) -> None:
    line = ("conditions", "puma560", "--coranks", "1", *FEW)
    assert "Decoupling" not in run(*line).out
    assert "Decoupling\n" in run(*line, "--steps").out


def test_given_letters_are_used(run) -> None:
    ended = run("conditions", "puma560", "--coranks", "1", "--lengths", "b=431.8mm,e=0.0203", "--full", *FEW)
    assert "lengths       b = 0.4318 m, e = 0.0203 m" in ended.out
    assert ended.code == exits.FINE


# the condition of a user, and aspects


@pytest.mark.parametrize(
    ("condition", "verdict", "code"),
    [
        ("sin(q5)*(a3*sin(q3)+d4*cos(q3))*(a2*cos(q2)+a3*cos(q2+q3)-d4*sin(q2+q3))", "exactly", exits.FINE),
        ("sin(q5)*(a3*sin(q3)+d4*cos(q3))", "too small", exits.UNEXPLAINED),
        ("s1 s5 (a3 s3 + d4 c3) (a2 c2 + a3 c23 - d4 s23) = 0", "too large", exits.UNEXPLAINED),
    ],
)
def test_a_condition_is_judged(run, condition: str, verdict: str, code: int) -> None:
    ended = run("conditions", "puma560", "--test", condition, *FEW)
    assert verdict in ended.out.split("Your condition")[1]
    assert ended.code == code


@pytest.mark.slow
def test_flags_and_what_parts_two_configurations(run) -> None:
    ended = run(
        "conditions", "puma560", "--deg", "--flags", "0,0,0,0,0,0", "--from", "0,-90,60,0,80,0", "--to",
        "0,-90,60,0,-80,0", "--json", "-", *FEW,
    )  # fmt: skip
    record = json.loads(ended.out)
    Draft202012Validator(closed(load_schema("conditions"))).validate(record)
    assert record["flags"]["flags"][0]["sign"] == 0
    assert [record["between"]["first"]["flags"][i]["factor"] for i in record["between"]["parting"]] == ["s5"]
    shown = run("conditions", "puma560", "--deg", "--flags", "0,90,0,0,80,0", *FEW).out
    assert "q = (0, 90, 0, 0, 80, 0) [°, m]" in shown


# files


def test_code_and_latex_are_written(run, tmp_path: Path) -> None:
    python, c, latex = tmp_path / "arm.py", tmp_path / "arm.h", tmp_path / "arm.tex"
    ended = run(
        "conditions", "puma560", "--coranks", "1", "--python", str(python), "--c", str(c), "--latex", str(latex), *FEW
    )
    assert ended.code == exits.FINE
    module: dict[str, Any] = {}
    exec(python.read_text(encoding="utf-8"), module)
    robot = rankdrop.open_robot("puma560")
    q = np.array([0.3, 0.5, math.atan2(-0.4318, 0.0203), 0.2, 0.9, 0.1])
    assert rankdrop.singular_values(robot, q, resolve_task(None, robot))[-1] < 1e-12
    zero = [name for name, family in module["FAMILIES"].items() if np.abs(family(q)).max() < 1e-12]
    assert zero == ["k1.f2"]
    assert "static inline void" in c.read_text(encoding="utf-8")
    assert r"\begin{tabular}" in latex.read_text(encoding="utf-8")


@pytest.mark.parametrize(("option", "begins"), [("--python", '"""Sing'), ("--c", "/* Sing"), ("--latex", r"\begin{")])
def test_code_on_stdout_is_alone(run, option: str, begins: str) -> None:
    ended = run("conditions", "planar2r", option, "-", *FEW)
    assert ended.out.startswith(begins)
    assert "Checks" not in ended.out


@pytest.mark.by_hand
def test_the_same_settings_give_the_same_bytes(run, tmp_path: Path) -> None:
    texts = []
    for name in ("one", "two"):
        path = tmp_path / f"{name}.json"
        run("conditions", "pa10", "--coranks", "1", "--seed", "5", "--steps", "--json", str(path), *FEW)
        texts.append(path.read_bytes())
    assert texts[0] == texts[1]
    assert json.loads(texts[0])["settings"]["seed"] == 5


# what goes wrong


@pytest.mark.slow
@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("pa11",), "pa10"),
        (("puma560", "--method", "magic"), "suppression"),
        (("pa10", "--method", "decoupling"), "does not decouple"),
        (("puma560", "--test", "sin(q5"), "column 7"),
        (("puma560", "--test", "sin(q5)*foo(q3)"), "there is no function foo; got 'sin(q5)*▸foo(q3)'"),
        (("puma560", "--test", "sin(q9)"), "▸"),
        (("puma560", "--time-limit", "0"), "--time-limit: this value is not allowed; got 0.0"),
        (("puma560", "--coranks", "0"), "at least 1"),
        (("puma560", "--points", "-1"), "0 … 100000"),
        (("puma560", "--seed", "-1"), "--seed: this value is not allowed; got -1; allowed: a whole number, 0 … "),
        (("puma560", "--lengths", "x=3"), "a2 = 0.4318 m"),
        (("puma560", "--lengths", "a=0.4318,a=1"), "each letter once"),
        (("puma560", "--lengths", "a=long"), "the unit is not one that fits"),
        (("puma560", "--lengths", "some"), "auto, letters, numbers"),
        (("puma560", "--lengths", "s1=0.4318"), "cannot have this name"),
        (("puma560", "--flags", "0,0"), "6 joint values are needed"),
        (("puma560", "--from", "0,0,0,0,0,0"), "--from needs --to"),
        (("pa10", "--flags", "0,0,0,0,0,0,0"), "not square"),
        (("puma560", "--json", "-", "--c", "-"), "stdout is taken by"),
        (("puma560", "--json", "same.out", "--c", "same.out"), "it is the file of"),
        (("puma560", "--python", "/no/such/folder/a.py"), "no such folder"),
    ],
)
def test_bad_input_is_one_line(run, argv: tuple[str, ...], words: str) -> None:
    ended = run("conditions", *argv, "--quiet")
    assert ended.code == exits.BAD_INPUT
    assert ended.out == ""
    assert ended.err.startswith("rankdrop: error: ")
    assert ended.err.count("\n") == 1
    assert words in ended.err


def test_a_helical_joint_is_refused(run, tmp_path: Path) -> None:
    path = tmp_path / "helical.toml"
    path.write_text(HELICAL, encoding="utf-8")
    ended = run("conditions", str(path), "--quiet")
    assert ended.code == exits.BAD_INPUT
    assert "helical" in ended.err


def test_without_python_flint_the_mend_is_named(run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    ended = run("conditions", "scara", "--quiet")
    assert ended.code == exits.BAD_INPUT
    assert "in the folder of rankdrop's source: pip install ." in ended.err
    assert ended.err.count("\n") == 1


@pytest.mark.slow
def test_a_time_limit_leaves_what_was_done_and_says_what_is_left(run) -> None:
    ended = run("conditions", "canadarm2", "--time-limit", "0.001", "--points", "0", "--quiet", "--json", "-")
    record = json.loads(ended.out)
    assert ended.code == exits.UNEXPLAINED
    assert not record["complete"]
    assert not record["verified"]
    assert any("the limit on work was reached" in line for line in record["left"])
    shown = run("conditions", "canadarm2", "--time-limit", "0.001", "--points", "0", "--quiet")
    assert "no family of singularities was found so far" in shown.out
    assert "Not finished" in shown.out


def test_a_condition_is_not_tested_against_half_of_the_singular_set(run) -> None:
    ended = run("conditions", "canadarm2", "--time-limit", "0.001", "--test", "s4", "--points", "0", "--quiet")
    assert ended.code == exits.UNEXPLAINED
    assert "not tested: the singular set is not completely derived" in one_line(ended.out)


@pytest.mark.by_hand_at("rankdrop.verbs.deriving.corank_one")
@pytest.mark.slow
@pytest.mark.parametrize("where", ["rankdrop.exact.tree._explore", "rankdrop.verbs.deriving.corank_one"])
def test_an_interruption_keeps_what_was_done(run, monkeypatch: pytest.MonkeyPatch, where: str) -> None:
    place, _, name = where.rpartition(".")
    module = import_module(place)
    calls = {"left": 2 if name == "_explore" else 0}
    whole = getattr(module, name)

    def interrupting(*args: Any, **options: Any) -> Any:
        calls["left"] -= 1
        if calls["left"] < 0:
            raise KeyboardInterrupt
        return whole(*args, **options)

    monkeypatch.setattr(module, name, interrupting)
    ended = run("conditions", "pa10", "--points", "0", "--quiet", "--json", "-")
    assert ended.code == exits.INTERRUPTED
    record = json.loads(ended.out)
    assert record["interrupted"]
    assert not record["complete"]
    assert record["families"][0]["name"] == "elbow: arm stretched or folded"
    assert record["left"]


def test_an_arm_with_too_few_joints_for_the_task_is_told_so(run) -> None:
    text = one_line(run("conditions", "scara", "--task", "pose", "--full", *FEW).out)
    assert "rank 4 at most, for 6 rows of the task; coranks are counted from 4" in text


def test_help_shows_examples_and_exit_codes(run) -> None:
    ended = run("conditions", "--help")
    assert ended.code == exits.FINE
    for words in ("rankdrop conditions pa10", "--time-limit", "Exit code 0: complete and verified", "--from", "--to"):
        assert words in ended.out
