"""explain, escape, nearest on the command line: exit codes, text, JSON, refusals."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from rich.cells import cell_len

from rankdrop.cli import exits
from rankdrop.cli.explain import stopped_early
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.verbs.explain import explain

REGULAR = ("ur5", "--deg", "--q", "0,-135,45,90,-90,0")
SINGULAR = ("puma560", "--q", "0.3 0.5 0.4 0.2 0 0.6")
NEAR = ("puma560", "--q=0.3,0.5,0.4,0.2,0.001,0.6")


@pytest.mark.parametrize(("words", "code"), [(REGULAR, exits.FINE), (NEAR, exits.NEAR), (SINGULAR, exits.SINGULAR)])
def test_the_exit_code_tells_the_verdict(run, words: tuple[str, ...], code: int) -> None:
    ended = run("explain", *words)
    assert ended.code == code
    assert ended.err == ""


def test_what_is_printed_at_a_singularity(run) -> None:
    text = run("explain", *SINGULAR).out
    for part in ("puma560 is singular: wrist: joint 5 at 0°", "wrist: axes 4 and 6 aligned", "θ5 = 0 or π",
                 "What is lost", "can only move",
                 "How to get out", "5 joint5", "How"):  # fmt: skip
        assert part in text
    assert "Every circuit" not in text
    full = run("explain", *SINGULAR, "--full").out
    for part in ("Every circuit", "Ellipsoids", "rank 5 + nullity 1 = 6 joints: holds", "zyz", "Joints to blame",
                 "per rad", "What motion costs", "Numbers"):  # fmt: skip
        assert part in full


@pytest.mark.slow
def test_json_is_valid_and_alone(process) -> None:
    ended = process("explain", *SINGULAR, "--json", "-")
    assert ended.code == exits.SINGULAR
    record = json.loads(ended.out)
    Draft202012Validator(load_schema("explanation")).validate(record)
    assert record["verdict"] == "singular"
    assert [one["number"] for one in record["escape"]["single"] if one["order"]] == [5]


def test_json_in_a_file_beside_the_text(run, tmp_path: Path) -> None:
    target = tmp_path / "here.json"
    ended = run("explain", *REGULAR, "--json", str(target))
    assert "is regular" in ended.out
    assert json.loads(target.read_text())["verdict"] == "regular"


@pytest.mark.slow
def test_a_saved_analysis_names_the_family(run, tmp_path: Path) -> None:
    target = tmp_path / "scara.json"
    assert run("analyze", "scara", "--starts", "200", "--quiet", "--json", str(target)).code == exits.FINE
    ended = run("explain", "scara", "--q", "0.1,0,0.1,0.3", "--analysis", str(target), "--json", "-")
    assert json.loads(ended.out)["family"]["source"] == "analysis"
    refused = run("explain", *SINGULAR, "--analysis", str(target))
    assert refused.code == exits.BAD_INPUT
    assert "another arm" in refused.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("explain", "ur5", "--q", "0,1"), "6 joint values are needed"),
        (("explain", "ur5", "--q", "0,1,2,3,4,five"), "wrist_3_joint"),
        (("explain", "ur5", "--q", "0,1,2,3,4,inf"), "not finite"),
        (("explain", "ur5"), "--q"),
        (("explain", *REGULAR, "--near", "-1"), "near"),
        (("nearest", *REGULAR, "--evaluations", "-5"), "evaluations"),
        (("escape", *SINGULAR, "--step", "0"), "step"),
        (("explain", *SINGULAR, "--seed", "-1"), "seed"),
        (("explain", *SINGULAR, "--tolerance", "5"), "tolerance"),
        (("explain", *SINGULAR, "--tolerance", "nan"), "tolerance"),
    ],
)
def test_refusals_say_what_and_where(run, words: tuple[str, ...], told: str) -> None:
    ended = run(*words)
    assert ended.code == exits.BAD_INPUT
    assert told in ended.err
    assert len(ended.err.strip().splitlines()) == 1
    assert ended.out == ""


@pytest.mark.slow
@pytest.mark.parametrize("width", [60, 80, 140])
def test_no_number_is_broken_and_no_line_too_long(run, width: int) -> None:
    eight = ("fetch8", "--q", "0 0.1 0.2 0.3 0.4 0.5 0.6 0.7")
    for words in (REGULAR, SINGULAR, ("pa10", "--q", "0,0,0,0,0,0,0"), eight):
        text = run("explain", *words, "--full", width=width).out
        assert max(map(cell_len, text.splitlines())) <= width
        assert "…" not in text.replace(" … ", "")
        assert "\n\n\n" not in text
        assert "weakest direction" in text
        lost = "the share of this motion that cannot be made" in " ".join(text.split())
        assert lost == (words in (SINGULAR, ("pa10", "--q", "0,0,0,0,0,0,0")))


@pytest.mark.slow
def test_without_unicode_nothing_is_a_question_mark(process) -> None:
    ended = process("explain", "pa10", "--q", "0,0,0,0,0,0,0", "--full", PYTHONIOENCODING="ascii")
    assert ended.code == exits.SINGULAR
    assert ended.out.isascii()
    assert "?" not in ended.out
    assert "q2 = 0 or pi" in ended.out


def test_a_proof_that_was_interrupted_holds_and_is_said_to_be() -> None:
    found = explain(open_robot("ur5"), [0.0, -2.3, 0.8, 1.5, -1.5, 0.3], evaluations=0)
    assert not stopped_early(found)
    assert found.far.certificate is not None
    stopped = replace(found)
    stopped.__dict__["far"] = replace(found.far)  # worked out already
    stopped.far.__dict__["_certificate_and_reason"] = replace(found.far.certificate, complete=False), ""
    assert stopped_early(stopped)
    assert "interrupted" in str(stopped)


@pytest.mark.slow
def test_escape_says_first_which_joint_which_way_and_how_far(run) -> None:
    plain = run("escape", *SINGULAR).out
    assert re.match(r"puma560 is singular: wrist.*\n  Lost: .*\n  Get out: jog joint 5 by −4°; regular from", plain)
    assert "Hunt's cofactors next to" not in plain
    assert "carries out" not in plain
    full = run("escape", *SINGULAR, "--full").out
    assert "Hunt's cofactors next to" in full
    assert "carries out" in full
    farther = run("escape", "ur5e", "--deg", "--q", "0,-60,20,40,50,0").out
    assert "Get farther away: jog joint 3 by +5.7°; σ6 rises from 0.049 to 0.063." in farther
