"""`rankdrop conditions`: what it prints, writes and refuses; its record against the schema; Ctrl-C, the time limit."""

from __future__ import annotations

import copy
import json
import math
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import rankdrop
from rankdrop.cli import exits
from rankdrop.cli.terminal import formula
from rankdrop.codec import json_text
from rankdrop.errors import OptionError, ResultFileError, TaskError
from rankdrop.exact.family import Assumption, EqualLengths, SpecialFamily, Unreal, UnrealSet
from rankdrop.families.record import exact_of
from rankdrop.results.conditions import Conditions
from rankdrop.results.old_sentences import contradictions_of_sentences
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.schema import load_schema
from rankdrop.sections import Formula
from rankdrop.task import resolve_task
from rankdrop.text.conditions import condition_lines, special_sentence

from .test_schema import closed

FEW = ("--points", "20", "--quiet")
HELICAL = """
name = "screwed"
[[joints]]
screw = [0, 0, 0.1, 0, 0, 1]
[[joints]]
screw = [0, 0, 0, 0, 1, 0]
"""


@pytest.fixture(scope="module")
def puma() -> Conditions:
    """Corank 1 of an arm whose conditions are known: s5 (d4 c3 + a3 s3) (a2 c2 + a3 c23 − d4 s23)."""
    return rankdrop.conditions(rankdrop.open_robot("puma560"), coranks=1, points=20)


@pytest.fixture(scope="module")
def puma2() -> Conditions:
    """The same arm to corank 2, where conditions are long."""
    return rankdrop.conditions(rankdrop.open_robot("puma560"), coranks=2, points=0, special=False)


@pytest.fixture(scope="module")
def pa10() -> Conditions:
    """All coranks of an arm with an assumption on lengths, as shipped: what is tested here is what is told of them."""
    return shipped_conditions("pa10")


def one_line(text: str) -> str:
    return " ".join(text.split())


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


def test_assumptions_are_told_in_words(pa10: Conditions) -> None:
    text = one_line(str(pa10))
    assert "d3 ≠ d5 (true here: 0.45 ≠ 0.5); if d3 = d5: θ4 = π alone loses two freedoms" in text
    assert "Coranks 4 to 6 no family" in text


def test_an_angle_that_is_not_the_joint_variable_is_told(run) -> None:
    found = run("conditions", "z1", "--coranks", "1", "--points", "0", "--quiet", "--full")
    assert "\nangles        θ3 = q3 + 2.886, θ4 = q4 + 0.2557; else θ = q\n" in found.out


def test_a_printed_condition_can_be_pasted_back(z1: Conditions) -> None:
    (shoulder,) = (one.texts[0] for one in z1.families if not exact_of(one).pins)
    together = " ".join(f"({text.removesuffix(' = 0')})" for text in ("s3", "c5", shoulder))
    assert z1.test(together).verdict == "exact"


@pytest.mark.slow
def test_no_line_is_longer_than_the_window(puma2: Conditions) -> None:
    for width in (60, 80):
        formulas = [line for section in puma2.sections() for line in section.lines if isinstance(line, Formula)]
        broken = [piece for line in formulas for piece in formula(line, width)]
        assert max(map(len, broken)) <= width
        assert len(broken) > len(formulas)


@pytest.mark.slow
def test_steps_are_printed_on_request(run) -> None:
    line = ("conditions", "puma560", "--coranks", "1", *FEW)
    assert "Decoupling" not in run(*line).out
    assert "Decoupling\n" in run(*line, "--steps").out


def test_given_letters_are_used(run) -> None:
    ended = run("conditions", "puma560", "--coranks", "1", "--lengths", "b=431.8mm,e=0.0203", "--full", *FEW)
    assert "lengths       b = 0.4318 m, e = 0.0203 m" in ended.out
    assert ended.code == exits.FINE


@pytest.mark.slow
def test_simple_angles_stand_on_one_line_long_conditions_on_their_own(puma2: Conditions, pa10: Conditions) -> None:
    assert condition_lines(pa10.families[1]) == ["θ2 = 0 or π; θ3 = ±π/2"]
    long = puma2.of_corank(2)[-1]
    assert len(condition_lines(long)) == 1 + len(exact_of(long).polynomials)


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


@pytest.mark.slow
def test_the_record_is_valid_and_every_entry_is_described(puma: Conditions, pa10: Conditions) -> None:
    for found in (puma, pa10, rankdrop.conditions(rankdrop.open_robot("scara"), points=0, steps=True)):
        record = json.loads(json_text(found.to_dict()))
        Draft202012Validator(closed(load_schema("conditions"))).validate(record)
        assert record["families"]


@pytest.fixture(scope="module")
def z1() -> Conditions:
    """An arm whose angles are not its joint variables: θ3 = q3 + 2.886."""
    return rankdrop.conditions(rankdrop.open_robot("z1"), coranks=1, points=0)


def test_equations_of_the_record_vanish_at_the_witness_and_say_what_an_analysis_says(
    pa10: Conditions, z1: Conditions
) -> None:
    for family in (*pa10.to_dict()["families"], *z1.to_dict()["families"]):
        names = {f"q{i}": value for i, value in enumerate(family["witness"], start=1)}
        for equation in family["equations"]:
            value = eval(equation, {"sin": math.sin, "cos": math.cos, "pi": math.pi}, names)
            assert abs(value) < 1e-9
        for pinned in family["pinned"]:
            q = family["witness"][pinned["number"] - 1]
            assert min(abs(math.remainder(q - value, 2 * math.pi)) for value in pinned["values"]) < 1e-9
    (elbow,) = (one for one in z1.to_dict()["families"] if [pin["number"] for pin in one["pinned"]] == [3])
    assert elbow["pinned"][0]["values"] == pytest.approx([-z1.shifts[2], np.pi - z1.shifts[2]])
    elbow = pa10.to_dict()["families"][0]
    assert (elbow["pinned"], elbow["free"]) == (
        [{"joint": "joint4", "number": 4, "values": [0.0, math.pi]}], [1, 2, 3, 5, 6, 7],
    )  # fmt: skip


@pytest.mark.by_hand
def test_the_same_settings_give_the_same_bytes(run, tmp_path: Path) -> None:
    texts = []
    for name in ("one", "two"):
        path = tmp_path / f"{name}.json"
        run("conditions", "pa10", "--coranks", "1", "--seed", "5", "--steps", "--json", str(path), *FEW)
        texts.append(path.read_bytes())
    assert texts[0] == texts[1]
    assert json.loads(texts[0])["settings"]["seed"] == 5


BROKEN = {
    "another version": lambda r: r.update(schema="rankdrop/conditions/2"),
    "no seed": lambda r: r["settings"].pop("seed"),
    "lengths of no kind": lambda r: r["settings"].update(lengths="short"),
    "a family of dimension −1": lambda r: r["families"][0].update(dimension=-1),
    "a family without a condition": lambda r: r["families"][0].update(conditions=[]),
    "no rank check": lambda r: r["families"][0].pop("rank_check"),
    "a letter as text": lambda r: r["letters"].update(a2="0.4318"),
    "verified in words": lambda r: r.update(verified="yes"),
    "a verdict of its own": lambda r: r.update(test={"verdict": "fine"}),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_record_is_refused(puma: Conditions, name: str) -> None:
    check = Draft202012Validator(load_schema("conditions"))
    record = copy.deepcopy(json.loads(json_text(puma.to_dict())))
    check.validate(record)
    BROKEN[name](record)
    assert not check.is_valid(record)


def test_save_writes_the_record_or_says_why_not(puma: Conditions, tmp_path: Path) -> None:
    puma.save(tmp_path / "puma.json")
    assert json.loads((tmp_path / "puma.json").read_text(encoding="utf-8")) == json.loads(json_text(puma.to_dict()))
    with pytest.raises(ResultFileError, match="cannot be written"):
        puma.save(tmp_path / "no" / "puma.json")


# Python


def test_the_record_answers_in_python(puma: Conditions) -> None:
    assert "decoupling" in puma._repr_html_()
    assert repr(puma) == "<Conditions of puma560: 3 families, verified>"
    assert puma.test("sin(q5)").verdict == "too small"
    assert puma.flags([0.0, 0.1, 0.2, 0.0, 1.0, 0.0]).flags[0].sign == 1
    assert puma.between([0.0, 0.1, 0.2, 0.0, 1.0, 0.0], [0.0, 0.1, 0.2, 0.0, -1.0, 0.0]).parting == (0,)
    assert "def k1_f1(" in puma.code("python")
    assert "#include <math.h>" in puma.code("c")
    with pytest.raises(OptionError, match="allowed: python, c"):
        puma.code("matlab")
    with pytest.raises(OptionError, match="time ran out"):
        puma.test("sin(q5)", seconds=1e-9)


def test_flags_of_a_redundant_arm_are_refused(pa10: Conditions) -> None:
    with pytest.raises(TaskError, match="not square"):
        pa10.flags([0.0] * 7)


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


def test_a_disagreement_is_shown_and_ends_with_three(
    run, puma: Conditions, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = replace(puma, disagreements=contradictions_of_sentences(["the rank tree has θ5 = 0, decoupling has not"]))
    monkeypatch.setattr(rankdrop, "conditions", lambda *args, **options: wrong)
    ended = run("conditions", "puma560", "--quiet", "--full")
    assert ended.code == exits.UNEXPLAINED
    assert "DISAGREEMENT: the rank tree has θ5 = 0, decoupling has not" in ended.out
    assert ended.out.startswith("Contradicted: the rank tree has")
    assert "no family\n" not in ended.out
    assert "derived twice" not in ended.out


def test_a_length_that_breaks_an_assumption_is_told(puma: Conditions) -> None:
    special = Assumption(
        "a2 ≠ d4", holds=False, derived=True, equal=EqualLengths("a2", 1, "d4"),
        families=(SpecialFamily(("θ3 = 0",), 2), SpecialFamily(("θ2 = 0", "θ5 = π"), 3)), more=2,
    )  # fmt: skip
    unknown = Assumption("a2² − d4² ≠ 0", holds=False, derived=False)
    text = str(replace(puma, assumptions=(special, unknown)))
    assert "a2 ≠ d4 (NOT true here: 0.4318 = 0.4318); if a2 = d4:" in text
    losses = ["θ3 = 0 alone loses two freedoms", "θ2 = 0, θ5 = π together lose three freedoms, and 2 more families"]
    assert [line.strip() for line in text.splitlines() if "lose" in line and "freedoms" in line][:2] == losses
    assert special_sentence(special) == f"if a2 = d4, {'; '.join(losses)}"
    assert special_sentence(unknown) == ""
    assert "a2² − d4² ≠ 0 (NOT true here); what this arm has besides was not derived" in text


def test_sets_that_are_not_real_are_counted_by_reason(puma: Conditions) -> None:
    sets = tuple(UnrealSet(f"θ{j} = 0", Unreal.NOT_FOUND, tried=96) for j in (1, 2, 3, 4))
    proven = UnrealSet("θ6 = 0", Unreal.PROVEN, negative="a2")
    found = replace(puma, not_real=(*sets, proven))
    text = str(found)
    assert found.to_dict()["not_real"][-1] == str(proven) == "θ6 = 0: not real, for a2 ≥ 0 does not hold"
    assert found.to_dict()["unreal"][0] == {
        "conditions": "θ1 = 0", "reason": "not found", "tried": 96, "proof": "",
    }  # fmt: skip
    modulo = UnrealSet("θ6 = 0", Unreal.NOR_MODULO_PRIMES, tried=32)
    assert str(modulo) == "θ6 = 0: no real point was found, nor one modulo 32 primes"
    assert text.count("no real point was found") == 1
    assert "and 2 more sets like these" in text
    assert "not real, for a2 ≥ 0 does not hold" in text


def test_an_arm_with_too_few_joints_for_the_task_is_told_so(run) -> None:
    text = one_line(run("conditions", "scara", "--task", "pose", "--full", *FEW).out)
    assert "rank 4 at most, for 6 rows of the task; coranks are counted from 4" in text


def test_help_shows_examples_and_exit_codes(run) -> None:
    ended = run("conditions", "--help")
    assert ended.code == exits.FINE
    for words in ("rankdrop conditions pa10", "--time-limit", "Exit code 0: complete and verified", "--from", "--to"):
        assert words in ended.out
