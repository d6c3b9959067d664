"""A failure of the derivation is told as incomplete, with its reason, and ends nothing else; limits bind in algebra."""

from __future__ import annotations

from typing import Any

import pytest

import rankdrop.algebra.polynomial as algebra
import rankdrop.exact.tree as tree_module
import rankdrop.verbs.deriving as deriving
from rankdrop.algebra.factoring import factor
from rankdrop.algebra.gcd import gcd, quotient
from rankdrop.algebra.halt import OutOfTime
from rankdrop.algebra.polynomial import calling_in_loops, norm
from rankdrop.algebra.ring import Ring
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions

PLACES = [
    (tree_module, "_explore"),
    (tree_module, "rank_on"),
    (deriving, "rank_tree"),
    (deriving, "real_sets"),
    (deriving, "families"),
    (deriving, "corank_one"),
    (deriving, "every_step"),
    (deriving, "assumptions"),
]


def failing(*_: Any, **__: Any) -> Any:
    raise ArithmeticError("a common divisor with long coefficients")


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.parametrize(("module", "name"), PLACES, ids=lambda x: x if isinstance(x, str) else "")
def test_an_error_in_the_derivation_is_an_incomplete_result(module, name, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, name, failing)
    found = conditions(open_robot("scara"), points=20, fresh=True, steps=True)
    assert not found.complete
    assert found.verdict.word == "incomplete"
    assert any("a common divisor with long coefficients" in str(one) for one in found.left)


def test_an_error_in_the_derivation_does_not_touch_the_sampled_result(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = analyze(open_robot("scara"), starts=200, exact="off")
    monkeypatch.setattr(deriving, "exact_chain", failing)
    found = analyze(open_robot("scara"), starts=200, fresh=True)
    assert found.verified
    assert found.verdict.claims == ("sampled",)
    assert [one.pinned for one in found.families] == [one.pinned for one in plain.families]
    assert "a common divisor with long coefficients" in str(found.exact.reason)


def polynomials():
    ring = Ring([1, 2, 3], letters=["sqrt2", "sqrt3"])
    t, two, three = ring.t, ring.letter_half["sqrt2"], ring.letter_half["sqrt3"]
    shared = t[1] + two * t[2] + three * t[3] + 1
    return shared * (t[1] * t[2] + two), shared * (t[3] + three), shared


@pytest.mark.parametrize(
    "operation",
    [lambda f, g, h: gcd(f, g), lambda f, g, h: norm(f), lambda f, g, h: factor(f), lambda f, g, h: quotient(f, h)],
    ids=["gcd", "norm", "factor", "quotient"],
)
def test_a_limit_that_has_passed_ends_the_algebra(operation) -> None:
    f, g, shared = (algebra.reduced_roots(x) for x in polynomials())

    def check() -> None:
        raise OutOfTime

    with calling_in_loops(check), pytest.raises(OutOfTime):
        operation(f, g, shared)
    operation(f, g, shared)  # and afterwards nobody looks
