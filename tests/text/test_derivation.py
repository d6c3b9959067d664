"""Where families come from, in words: derived, fitted, or derived and contradicted by tests."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from rankdrop.families.derivation import AGREES, DIFFERS, NOT_DERIVED, Derivation
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.record import written_conditions
from rankdrop.results.known import shipped
from rankdrop.results.old_sentences import contradictions_of_sentences
from rankdrop.text.derivation import agreement, mistaken_text

PUMA = shipped("puma560")
WRITTEN = written_conditions((), ("a2 c2 + a3 c23 = 0",), ("",), ())
FAMILIES = (replace(PUMA.families[0], exact=WRITTEN), *PUMA.families[1:])
DERIVED = Derivation(AGREES, "auto", 30.0, letters={"a2": 0.4318}, shifts=(0.0, 0.0, -1.5, 0.0, 0.0, 0.0))


def words(derivation: Derivation | None) -> list[tuple[str, bool]]:
    return list(agreement(derivation, PUMA.robot, FAMILIES))


def test_nothing_is_said_of_a_derivation_that_was_not_asked_for() -> None:
    assert words(None) == []


def test_derived_families_explain_the_letters_and_shifts_of_their_conditions() -> None:
    ((line, contradicted),) = words(DERIVED)
    assert not contradicted
    assert line.startswith("The families are derived exactly; the searches only test them.")
    assert line.endswith("c23 cos(θ2+θ3), a2 = 0.4318 m; there θ3 = q3 − 1.5.")


def test_conditions_that_the_table_says_need_no_letters() -> None:
    """θ2 = 0 or π of a planar arm stands in the table itself."""
    planar = shipped("planar3r")
    ((line, _),) = agreement(DERIVED, planar.robot, planar.families)
    assert line == "The families are derived exactly; the searches only test them."


def test_each_contradiction_is_marked_as_one_and_comes_first() -> None:
    said = contradictions_of_sentences(["the rank tree has a set that no search met"])
    lines = words(replace(DERIVED, status=DIFFERS, disagreements=said))
    assert [contradicted for _, contradicted in lines] == [True, True, False]
    assert lines[0][0] == "Numerical tests CONTRADICT the exact derivation:"
    assert lines[1][0] == f"  {said[0]}"


def test_fitted_families_are_not_called_derived() -> None:
    open_still = replace(DERIVED, status=NOT_DERIVED, reason=NotDerived(NotDerivedKind.INTERRUPTED))
    ((fitted, _),) = words(open_still)
    ((first, _),) = words(replace(open_still, first_derived=True))
    assert fitted.startswith(f"Exact conditions: not derived; {open_still.reason}. ")
    assert fitted.endswith("The families are fitted to the points.")
    assert "Those of corank 1 are derived, the families of higher coranks are fitted" in first


def test_mistaken_points_say_how_many_were_followed_and_their_minimum() -> None:
    every, part = mistaken_text(1, 4, 4, 3e-7, 50), mistaken_text(2, 1_400, 64, inf, 50)
    assert every.startswith("corank 1: 4 points of the searches with σ ≤ ")
    assert "followed with 50 digits, σ does not vanish" in every
    assert every.endswith(", it has a minimum of 3e-07")
    assert "1,400 points" in part
    assert "digits (64 of them, spread over all their σ), σ does not vanish next to them" in part
    assert part.endswith("next to them")
