"""The record of `conditions`: its words, its file, and what it answers in Python."""

from __future__ import annotations

import copy
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from closed_schema import closed
from jsonschema import Draft202012Validator
from printed import one_line

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
from rankdrop.text.conditions import condition_lines, special_sentence


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


def test_assumptions_are_told_in_words(pa10: Conditions) -> None:
    text = one_line(str(pa10))
    assert "d3 ≠ d5 (true here: 0.45 ≠ 0.5); if d3 = d5: θ4 = π alone loses two freedoms" in text
    assert "Coranks 4 to 6 no family" in text


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
def test_simple_angles_stand_on_one_line_long_conditions_on_their_own(puma2: Conditions, pa10: Conditions) -> None:
    assert condition_lines(pa10.families[1]) == ["θ2 = 0 or π; θ3 = ±π/2"]
    long = puma2.of_corank(2)[-1]
    assert len(condition_lines(long)) == 1 + len(exact_of(long).polynomials)


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


def test_a_disagreement_is_shown_and_ends_with_three(run, puma: Conditions, monkeypatch: pytest.MonkeyPatch) -> None:
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
