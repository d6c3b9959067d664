"""The answer and how sure it is stand first and last, and the exit code goes with them."""

from __future__ import annotations

import importlib
import json
from dataclasses import replace
from math import pi

import pytest

import rankdrop
from rankdrop.cli import exits
from rankdrop.families.derivation import AGREES, DIFFERS, NOT_DERIVED
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.record import Check
from rankdrop.families.unfinished import Phase, Unfinished, UnfinishedKind
from rankdrop.results.analysis import Analysis
from rankdrop.results.old_sentences import contradictions_of_sentences
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze, derive
from rankdrop.verbs.conditions import conditions


@pytest.fixture(scope="module")
def sampled() -> Analysis:
    return analyze(open_robot("scara"), starts=200)


@pytest.fixture(scope="module")
def derived():
    return conditions(open_robot("scara"), points=100)


HAS = "scara has 1 family of singularities: elbow (rank 3)."


def first_and_last(text: str) -> tuple[str, str]:
    """The first and the last paragraph, unwrapped."""
    parts = text.strip().split("\n\n")
    return " ".join(parts[0].split()), " ".join(parts[-1].split())


def differs(found: Analysis) -> Analysis:
    said = ("exact k1.f1 (elbow): 3 of 257 of its points lie on no numeric family of this corank, q = (0, 1) is one",)
    return replace(found, exact=replace(found.exact, status=DIFFERS, disagreements=contradictions_of_sentences(said)))


def unsound(found: Analysis) -> Analysis:
    family = replace(found.families[0], soundness=Check(176, 141), explained=Check(1, 1))
    return replace(found, families=(family,))


def unexplained(found: Analysis) -> Analysis:
    summary = replace(found.coranks[0], completeness=Check(1150, 928))
    return replace(found, coranks=(summary, *found.coranks[1:]))


def not_derived(found: Analysis) -> Analysis:
    reason = NotDerived(NotDerivedKind.STORED, text="no time")
    return replace(found, exact=replace(found.exact, status=NOT_DERIVED, asked="on", reason=reason))


@pytest.mark.parametrize(
    ("change", "word", "begins"),
    [
        (differs, "contradicted", "Contradicted: a test contradicts the derivation, exact k1.f1"),
        (unsound, "unsound", "A test failed: k1.f1 also holds at 35 of 176 solutions that are regular."),
        (unexplained, "incomplete", "Incomplete: corank 1, 222 of 1,150 test points on no row."),
        (not_derived, "incomplete", "Incomplete: exact conditions were asked for and not derived, no time."),
    ],
)
def test_analyze_calls_nothing_verified_where_it_ends_with_three(
    run, sampled: Analysis, monkeypatch: pytest.MonkeyPatch, change, word: str, begins: str
) -> None:
    monkeypatch.setattr(rankdrop, "analyze", lambda *args, **options: change(sampled))
    ended = run("analyze", "scara", "--quiet", "--full")
    first, last = first_and_last(ended.out)
    assert first == last
    assert first.startswith(begins)
    assert ended.code == exits.UNEXPLAINED
    assert "erified" not in ended.out
    assert json.loads(run("analyze", "scara", "--quiet", "--json", "-").out)["verdict"] == word


def test_analyze_says_what_was_done(run, sampled: Analysis, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = {"both": sampled, "alone": replace(sampled, exact=None)}
    claims = {"both": ["sampled", "derived exactly"], "alone": ["sampled"]}
    for name, analysis in shown.items():
        monkeypatch.setattr(rankdrop, "analyze", lambda *args, **options: analysis)  # noqa: B023
        ended = run("analyze", "scara", "--quiet", "--full")
        first, last = first_and_last(ended.out)
        assert first == last
        sure = f"Verified by {'exact derivation and ' * (name == 'both')}1,150 random tests"
        assert first.startswith(f"{HAS} {sure}")
        assert ("exact conditions were not asked for" in first) == (name == "alone")
        assert ended.code == exits.FINE
        record = json.loads(run("analyze", "scara", "--quiet", "--json", "-").out)
        assert (record["verdict"], record["claims"], " ".join(record["summary"])) == ("verified", claims[name], first)
        assert record["summary"] == [HAS, record["sentence"]]


def test_an_arm_without_singular_configurations_has_not_been_proven_to_have_none(sampled: Analysis) -> None:
    none = replace(sampled, families=(), coranks=sampled.coranks[1:], exact=None)
    assert "no proof of absence" in none.verdict.sentence
    assert none.verdict.claims == ("sampled",)


@pytest.mark.parametrize(
    ("change", "word", "begins"),
    [
        ({"disagreements": contradictions_of_sentences(["the rank tree has a set …"])}, "contradicted",
         "Contradicted: the rank tree has a set"),
        ({"explained": Check(100, 97)}, "contradicted", "Contradicted: 3 configurations found numerically lie on no"),
        ({"complete": False, "left": (Unfinished(UnfinishedKind.NOT_RUN, phase=Phase.SPECIAL),)}, "incomplete",
         "Incomplete: arms of special lengths."),
    ],
)
def test_conditions_calls_nothing_verified_where_it_ends_with_three(
    run, derived, monkeypatch: pytest.MonkeyPatch, change, word: str, begins: str
) -> None:
    wrong = replace(derived, **change)
    monkeypatch.setattr(rankdrop, "conditions", lambda *args, **options: wrong)
    ended = run("conditions", "scara", "--quiet", "--full")
    first, last = first_and_last(ended.out)
    assert first == last
    assert first.startswith(begins)
    assert ended.code == exits.UNEXPLAINED
    assert "erified" not in ended.out
    assert "no family\n" not in ended.out  # nothing is said to be absent where something is wrong
    assert json.loads(run("conditions", "scara", "--quiet", "--json", "-").out)["verdict"] == word
    assert first.endswith(HAS)  # what speaks against the answer comes before it
    assert first_and_last(str(wrong))[0] == first


def test_a_condition_that_is_not_exact_ends_with_three_and_says_so_first_and_last(run) -> None:
    ended = run("conditions", "scara", "--test", "sin(q2/2)", "--quiet", "--full")
    first, last = first_and_last(ended.out)
    assert first == last == f"Not exact: the given condition is too small. {HAS}"
    assert ended.code == exits.UNEXPLAINED
    assert "erified" not in ended.out


def test_what_was_tried_on_no_configuration_does_not_claim_it(run) -> None:
    sentence = first_and_last(run("conditions", "scara", "--points", "0", "--quiet").out)[0]
    assert sentence.startswith(f"{HAS} Verified by exact derivation: the rank is as derived at 6 random points")
    assert "not tested on singular configurations found numerically" in sentence
    none = conditions(open_robot("planar2r"), points=0, coranks=1)
    bare = replace(none, families=())
    assert bare.verdict.word == "unchecked"
    assert "erified" not in bare.verdict.sentence


def test_an_arm_without_singularities_is_verified_by_a_search_that_finds_none() -> None:
    """Two slides at right angles: the Jacobian is constant."""
    arm = from_dh([[0.0, pi / 2, 0.3, 0.0], [0.0, 0.0, 0.2, 0.0]], convention="standard", kinds="PP", name="gantry")
    found = conditions(arm, "vy,vz")
    assert (found.families, found.verdict.word) == ((), "verified")
    assert "a search from random starts found no singular configuration either" in found.verdict.sentence


@pytest.mark.parametrize(("q", "code"), [("0,0,0,0", 4), ("0,0.01,0.1,0", 3), ("0,1.5,0.1,0", 0)])
def test_explain_begins_with_the_five_sentences_of_its_summary(run, q: str, code: int) -> None:
    ended = run("explain", "scara", "--q", q)
    word = {4: "singular", 3: "near a singularity", 0: "regular"}[code]
    record = json.loads(run("explain", "scara", "--q", q, "--json", "-").out)
    sentences = record["summary"]["text"]
    assert sentences[0].startswith(f"scara is {word}: ")
    assert " ".join(ended.out.split()).startswith(" ".join(" ".join(sentences).split()))
    assert ended.code == code
    assert record["sentence"].startswith(f"scara: {record['verdict'].upper()}, ")


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"complete": False, "left": ("one system",)}, "one system"),
        ({"complete": False, "left": ("one system", "another")}, "one system; another"),
        ({"complete": False, "left": ("one system",), "limited": True}, "the derivation takes more than 30 s"),
        ({"interrupted": True}, "interrupted"),
    ],
)
def test_a_derivation_that_is_not_complete_is_none(
    derived, monkeypatch: pytest.MonkeyPatch, change: dict[str, object], reason: str
) -> None:
    """Families of some coranks only are no source of families: sampling has to find all of them."""
    arm = open_robot("scara")
    deriving = importlib.import_module("rankdrop.verbs.conditions")
    whole = replace(derived, seconds=0.1)
    for made, used in ((whole, True), (replace(whole, **change), False)):
        monkeypatch.setattr(deriving, "conditions", lambda *_, made=made, **__: made)
        found, record = derive(arm, resolve_task(None, arm), exact="auto", seed=0, fresh=True, progress=None)
        assert record is not None
        assert (found is made) is used
        assert (found is None) is not used
        assert record.status == (AGREES if used else NOT_DERIVED)
        assert str(record.reason or "") == ("" if used else reason)
