"""Lost motions are facts; sentences are made of them, and those of old files lead back to the same facts."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from rankdrop.errors import ResultFileError
from rankdrop.families.lost import LostFreedom, MotionKind
from rankdrop.families.record import Family
from rankdrop.kinematics import jacobian
from rankdrop.results.analysis import Analysis
from rankdrop.results.known import known_names, shipped, shipped_record
from rankdrop.results.old_files import freedoms_of_sentences
from rankdrop.task import BODY, Frame
from rankdrop.text.lost import lost_line, lost_note, lost_sentence, lost_sentences

ARMS = ("ur5e", "pa10", "scara", "crx10ia", "tiago", "m430ia2f")
SAVED = sorted((Path(__file__).resolve().parents[1] / "data" / "saved").glob("*/analysis.json"))


def test_a_record_of_a_family_holds_no_sentence_on_what_is_lost() -> None:
    assert "lost_freedoms" in {one.name for one in fields(Family)}
    assert not hasattr(Family, "lost_words")


@pytest.mark.shipped
@pytest.mark.parametrize("name", ARMS)
def test_shipped_sentences_are_those_of_the_facts_and_lead_back_to_them(name: str) -> None:
    found, told = shipped(name), {one["id"]: one["lost_words"] for one in shipped_record(name)["families"]}
    for family in found.families:
        assert list(lost_sentences(family.lost_freedoms)) == told[family.id]
        again = freedoms_of_sentences(told[family.id], found.robot, found.task, family.corank, family.witness)
        for mine, other in zip(family.lost_freedoms, again, strict=True):
            assert (mine.frame, mine.everywhere, mine.length) == (other.frame, other.everywhere, other.length)
            assert mine.direction == pytest.approx(other.direction, abs=1e-9)


@pytest.mark.slow
@pytest.mark.shipped
def test_every_shipped_sentence_is_made_of_the_facts_of_today() -> None:
    for name in known_names():
        told = {one["id"]: one["lost_words"] for one in shipped_record(name)["families"]}
        assert {one.id: list(lost_sentences(one.lost_freedoms)) for one in shipped(name).families} == told, name


def test_a_half_is_rounded_alike_in_every_unit_of_length() -> None:
    """Fetch on its slide loses vy − 0.03265 m·ωx: a half of the last digit, which fell one way in m, another in km."""
    tied = LostFreedom((0.0, 0.9994674145, 0.0, -0.0326326111, 0.0, 0.0), Frame(4, 4), everywhere=True)
    for power in range(-9, 10):
        sentence = lost_sentence(replace(tied, length=10.0**power))
        number = sentence.split("− ")[1].split(" m·")[0].replace("−", "-")
        assert f"{float(number):.2e}".startswith("3.27"), sentence


@pytest.mark.shipped
@pytest.mark.parametrize("name", ARMS)
def test_no_joint_moves_along_a_lost_freedom_in_its_frame(name: str) -> None:
    found = shipped(name)
    for family in found.families:
        for one in family.lost_freedoms:
            columns = jacobian(found.robot, np.array(family.witness), one.frame)
            assert np.abs(np.array(one.direction) @ columns).max() < 1e-8


@pytest.mark.parametrize("path", SAVED, ids=lambda path: path.parent.name)
def test_a_file_that_has_sentences_only_is_read(path: Path) -> None:
    record = json.loads(path.read_text(encoding="utf-8"))
    assert all("lost_freedoms" not in one for one in record["families"])
    found = Analysis.from_dict(record)
    assert any(one.lost_freedoms for one in found.families)
    for family, old in zip(found.families, record["families"], strict=True):
        assert list(lost_sentences(family.lost_freedoms)) == old["lost_words"]


def test_a_lost_freedom_that_the_arm_does_not_lose_is_refused() -> None:
    record = shipped("scara").to_dict()
    record["families"][0]["lost_freedoms"][0]["direction"] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]  # the slide of joint 3
    with pytest.raises(ResultFileError, match=r"the motion is not lost at the witness"):
        Analysis.from_dict(record)


@pytest.mark.parametrize(
    ("direction", "kind", "nearly", "sentence", "line"),
    [
        ((0, 0, 0, 1, 0, 0), MotionKind.ROTATION, MotionKind.ROTATION,
         "cannot rotate about X of the tool", "lost: rotate about X of the tool"),
        ((0.6, 0, 0.8, 0, 0, 0), MotionKind.TRANSLATION, MotionKind.TRANSLATION,
         "cannot translate along (0.6, 0, 0.8) of the tool", "lost: translate along (0.6, 0, 0.8) of the tool"),
        ((0, -0.91, 0, 0, 0, -0.1), MotionKind.TIED, MotionKind.TRANSLATION,
         "can only move so that vy + 0.11 m·ωz = 0 in axes of the tool: nearly no motion along Y", None),
        ((0, 0.7, 0, 0, 0.7, 0), MotionKind.TIED, MotionKind.TIED,
         "can only move so that vy + 1 m·ωy = 0 in axes of the tool", None),
    ],
)  # fmt: skip
def test_sentences_are_made_of_the_facts(
    direction: tuple[float, ...], kind: MotionKind, nearly: MotionKind, sentence: str, line: str | None
) -> None:
    one = LostFreedom(direction, BODY, everywhere=True)  # type: ignore[arg-type]
    assert (one.kind, one.nearly) == (kind, nearly)
    assert lost_sentence(one) == sentence
    assert lost_line(one) == (sentence if line is None else line)
    at_witness = LostFreedom(direction, BODY, everywhere=False)  # type: ignore[arg-type]
    assert lost_sentence(at_witness) == f"{sentence} (at the witness)"


def test_in_millimetres_a_tie_has_the_numbers_of_millimetres() -> None:
    one = LostFreedom((0, -0.91, 0, 0, 0, -0.1), Frame(2, 3, (0.1, 0.0, 0.0)), everywhere=True).rescaled(3)
    assert "vy + 110 m·ωz = 0 in axes of link 2 at (100, 0, 0) m of link 3" in lost_sentence(one)


def test_a_note_explains_links_and_letters_that_the_sentences_use() -> None:
    arm = shipped("pa10").robot
    assert lost_note(arm, [LostFreedom((1, 0, 0, 0, 0, 0), BODY, everywhere=True)]) == ""
    tie = LostFreedom((0, -0.91, 0, 0, 0, -0.1), Frame(4), everywhere=True)
    note = lost_note(arm, [tie])
    assert note.startswith("v: velocity of the tool")
    assert "Link 4 moves with joint 4: " in note
    assert "origin" not in note.partition("Link 4")[2]
