"""Conditions of a higher corank tried at configurations of a search: wrong and too wide ones are noticed."""

from __future__ import annotations

from copy import copy

import pytest
from exact.chains import chain_of

from rankdrop.exact.conjunctions import Conjunction, SetDerivation
from rankdrop.exact.higher_coranks import UNTRIED, HigherCorank
from rankdrop.exact.methods import derive
from rankdrop.verbs.found_coranks import tried_numerically


@pytest.fixture(scope="module", params=["anthropomorphic", "stanford"])
def corank_two(request: pytest.FixtureRequest) -> SetDerivation:
    """Configurations at which two freedoms are lost, by reciprocal screws."""
    return derive(chain_of(request.param), "reciprocity", corank=2)


def tried(derived: SetDerivation, conditions: list[Conjunction]) -> HigherCorank:
    other = copy(derived)
    other.conditions = conditions
    (found,) = tried_numerically([HigherCorank(other)], 3)
    return found


def test_right_conditions_hold_at_every_configuration_of_the_corank_and_at_none_below(corank_two) -> None:
    found = tried(corank_two, corank_two.conditions)
    assert found.singular.agree == found.singular.tested > 10
    assert found.regular.agree == found.regular.tested > 10


def test_a_missing_condition_is_noticed(corank_two) -> None:
    missing = [tried(corank_two, [*corank_two.conditions[:k], *corank_two.conditions[k + 1 :]])
               for k in range(len(corank_two.conditions))]  # fmt: skip
    assert any(found.singular.agree < found.singular.tested for found in missing)
    assert tried(corank_two, []).singular.agree == 0


def test_a_condition_that_always_holds_is_noticed(corank_two) -> None:
    found = tried(corank_two, [Conjunction(())])
    assert found.singular.agree == found.singular.tested
    assert found.regular.agree == 0


def test_a_derivation_that_did_not_finish_is_not_tried() -> None:
    derived = derive(chain_of("pa10"), "reciprocity", 0.0, corank=2)
    assert not derived.complete
    (found,) = tried_numerically([HigherCorank(derived)], 3)
    assert (found.singular, found.regular) == (UNTRIED, UNTRIED)
