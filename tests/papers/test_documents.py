"""The five documents: nothing differs without a reason, the known errata are found, the page is what is computed."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("flint")

from papers import kg
from papers.am_method import pa10
from papers.am_robots import angle_between, printed_null_directions, row_configuration
from papers.run import DOCUMENTS, Reproduction, markdown, names, reproduce
from rankdrop.errors import OptionError
from rankdrop.local.directions import lost_directions

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reproduced.md"
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")
FAST = ("GR", "JL", "ML")
EVERY = [pytest.param(name, marks=() if name in FAST else pytest.mark.by_hand) for name in DOCUMENTS]


@cache
def found(name: str) -> Reproduction:
    return reproduce(name)


def row(name: str, item: str, words: str):
    met = [one for one in found(name).items if one.item.startswith(item) and words in one.about]
    assert len(met) == 1, [one.about for one in met]
    return met[0]


@pytest.mark.parametrize("name", EVERY)
def test_no_item_differs_and_every_other_verdict_has_its_reason(name):
    assert found(name).differs == ()
    assert found(name).complete
    for item in found(name).items:
        assert item.document == name
        assert item.item
        assert item.about
        assert item.printed
        assert item.ours
        assert item.reason or item.verdict in ("agrees", "rounding")
        assert "does not hold" not in item.reason


@pytest.mark.parametrize("name", EVERY)
def test_no_item_stands_there_twice(name):
    keys = [(item.item, item.about) for item in found(name).items]
    assert len(keys) == len(set(keys))


def rows_of(page: str, name: str) -> list[str]:
    """The lines of a document's items and notes."""
    part = page.split(f"\n## {name}\n")[1].split("\n## ")[0]
    return [line for line in part.splitlines() if line.startswith(("| ", "- "))]


@pytest.mark.parametrize("name", EVERY)
def test_the_page_is_what_is_computed(name):
    """Words and verdicts are the same; numbers within 5 %: long descents depend on the last bit of a library."""
    there, made = rows_of(PAGE.read_text(encoding="utf-8"), name), rows_of(markdown(found(name)), name)
    assert [NUMBER.sub("#", line) for line in there] == [NUMBER.sub("#", line) for line in made]
    for one, other in zip(there, made, strict=True):
        for x, y in zip(map(float, NUMBER.findall(one)), map(float, NUMBER.findall(other)), strict=True):
            assert abs(x - y) <= 0.05 * max(abs(x), abs(y)) + 1e-6, (one, other)


def test_the_page_counts_what_it_shows():
    text = PAGE.read_text(encoding="utf-8")
    for name in DOCUMENTS:
        counts = list(map(int, re.findall(rf"^\| \[{name}\]\(#\w+\) \| (.*) \|$", text, re.MULTILINE)[0].split(" | ")))
        lines = rows_of(text, name)
        words = [line.rsplit(" | ", 1)[1].split("**")[1] for line in lines if "| **" in line]
        words += ["agrees" for line in lines if line.startswith("- ") and not re.match(r"- \([a-z]\) ", line)]
        for verdict, count in zip(("agrees", "rounding", "erratum", "unreproducible", "differs"), counts, strict=True):
            assert words.count(verdict) == count, (name, verdict)


def test_a_sentence_of_many_reasons_stands_once():
    text = PAGE.read_text(encoding="utf-8")
    for sentence in ("The copy at hand is damaged here; restored.", "AM print no numbers of the arrows."):
        assert text.count(sentence.split("; ")[0]) == 1


def test_errata_of_gr():
    assert row("GR", "section 5", "lead out of the singularity").verdict == "erratum"
    assert row("GR", "section 5", "lead out of the singularity").ours.startswith("joints 3, 4; σ6 grows by 0.7036")
    assert row("GR", "section 5", "column 7 of J").verdict == "erratum"
    assert row("GR", "section 3, rule 4", "outside the span").verdict == "erratum"
    assert row("GR", "section 5", "subspace(1,5)").verdict == "agrees"
    assert row("GR", "section 5", "readoss(1,7)").verdict == "rounding"


def test_errata_of_the_lectures():
    assert {row("JL", item, "column 3").verdict for item in ("J11", "J̄11")} == {"erratum"}
    assert row("JL", "Elbow", "against z0").verdict == "erratum"
    assert row("ML", "Two-links", "size of the matrix").verdict == "erratum"
    assert row("ML", "Spherical wrist", "two collinear").verdict == "erratum"
    assert row("ML", "Shoulder", "of an arm with a shoulder offset").verdict == "erratum"
    assert row("ML", "¹J⁻¹", "inverse of ¹J").verdict == "agrees"


@pytest.mark.by_hand
def test_errata_of_am():
    assert [item.verdict for item in found("AM").items if item.item == "eq. 9"] == ["erratum", "agrees"]
    drawn = [item for item in found("AM").items if re.fullmatch(r"Figure [789]\([a-d]\)", item.item)]
    assert [item.verdict for item in drawn] == ["agrees"] * 10
    assert all(" 0° from the span" in item.ours for item in drawn)
    assert row("AM", "section 3.2", "optimally fault tolerant").verdict == "agrees"
    for corank, words in ((2, "57 converge with it only, 4 without"), (3, "56 converge with it only, 10 without")):
        assert words in row("AM", "section 2.2.3", f"gains, rank {corank}").ours
    left = {item.item for item in found("AM").items if item.verdict == "unreproducible"}
    assert left == {"Figure 1", "Figure 2", "Figure 3(b)", "section 2.2.3"}
    assert {row("AM", f"Figure 6({part})", "singular direction").verdict for part in "ab"} == {"erratum"}
    assert "14.4°" in row("AM", "Figure 6(a)", "singular direction").reason
    assert "9.2°" in row("AM", "Figure 6(b)", "singular direction").reason
    assert row("AM", "Table 5, row 1", "").ours == "× | ±π, 0 | ±π, 0 | ±π, 0 | ±π, 0 | ±π, 0 | ×"
    assert row("AM", "section 3.3.4", "aligning the axes").verdict == "erratum"
    assert row("AM", "section 2.3", "the three rotated").verdict == "rounding"
    assert row("AM", "section 2.3", "the same, PA-10 stretched").verdict == "agrees"
    tables = [item for item in found("AM").items if re.fullmatch(r"Table [34], row \d", item.item)]
    assert [item.verdict for item in tables] == ["agrees"] * 8
    assert row("AM", "section 1", "rank-2 singularities").verdict == "agrees"


def test_the_methods_are_those_that_kg_list():
    assert kg.listed_methods() == kg.LISTED


@pytest.mark.by_hand
def test_errata_of_kg():
    assert row("KG", "section 3.3.2", "into which s6 = 0").verdict == "erratum"
    assert row("KG", "section 3.3.3", "which is removed").verdict == "erratum"
    assert row("KG", "abstract", "do the printed families meet").verdict == "erratum"
    assert {row("KG", f"eq. {n}", "family").verdict for n in (15, 20, 21, 26, 27)} == {"agrees"}
    assert found("KG").count("unreproducible") == 0
    assert row("KG", "section 1", "reciprocal to five").ours.startswith("all six vanish, whichever five are taken")
    assert "suppression 5 sets" in row("KG", "section 4", "efficiency").ours


def test_documents_are_asked_for_by_name():
    assert names("gr") == ("GR",)
    assert names("all") == tuple(DOCUMENTS)
    with pytest.raises(OptionError, match="AM, ML, GR, KG, JL, all"):
        names("XX")


def test_progress_goes_from_none_to_all():
    told = []
    reproduce("GR", progress=lambda label, done, total: told.append((done, total)))
    assert told[0][0] == 0
    assert told[-1][0] == told[-1][1] == len(told) - 1


def test_ctrl_c_keeps_what_is_done():
    def stop(label, done, total):
        if done == 2:
            raise KeyboardInterrupt

    assert not reproduce("GR", progress=stop).complete


def test_a_direction_that_is_wrong_would_not_agree():
    """Figures 7 and 8 compare directions: one that is turned by a degree, or belongs to another row, is found out."""
    robot, task = pa10()
    for corank in (1, 2):
        q = row_configuration(corank, 1)
        ours = lost_directions(robot, q, task, corank)
        assert angle_between(ours, printed_null_directions(q, corank)) < 1e-6
        turned = ours.copy()
        other = np.linalg.svd(ours)[2][-1]
        turned[0] = np.cos(np.radians(1.0)) * ours[0] + np.sin(np.radians(1.0)) * other
        assert angle_between(turned, printed_null_directions(q, corank)) == pytest.approx(1.0, abs=1e-6)
        assert angle_between(ours, printed_null_directions(row_configuration(corank, 3), corank)) > 5.0


@pytest.mark.slow
def test_a_family_that_is_larger_or_smaller_than_the_printed_one_would_not_agree(monkeypatch):
    assert kg._same_family(20, 2)
    assert not kg._same_family(20, 1), "another family"
    larger, others = kg.kg.FAMILIES[20]
    for zeros in (("s6",), (*larger, "s2")):  # less, and more, than eq. 20 asks for
        monkeypatch.setitem(kg.kg.FAMILIES, 20, (zeros, others))
        assert not kg._same_family(20, 2)
