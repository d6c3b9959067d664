"""Verdicts are computed from what is printed and what is computed, and an erratum needs a reason and a computation."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

from papers.formula import matrix, value
from papers.item import Sheet, Shown, Verdict, half_unit, rounded
from rankdrop.errors import OptionError


def last(sheet):
    return sheet.items[-1]


@pytest.mark.parametrize(("printed", "ours", "verdict"), [
    ("0.27", 0.2749, "agrees"),
    ("0.27", 0.2751, "rounding"),
    ("0.27", 0.2999, "rounding"),
    ("0.27", 0.31, "differs"),
    ("-0.5 1.25", [-0.46, 1.251], "agrees"),
    ("-0.5 1.25", [-0.46, 1.26], "rounding"),
    ("−0.5, 1.25", [0.5, 1.25], "differs"),
    ("5", 5, "agrees"),
    ("5", 6, "differs"),
    ("0.5 0.5", [0.5], "differs"),
])  # fmt: skip
def test_numbers_agree_to_half_a_unit_of_the_last_digit(printed, ours, verdict):
    sheet = Sheet("AM", [])
    sheet.numbers("Table 1", "a number", printed, ours)
    assert last(sheet).verdict == verdict


def test_not_a_number_never_agrees():
    sheet = Sheet("AM", [])
    sheet.numbers("Table 1", "a number", "0.5", np.nan)
    sheet.identity("eq. 1", "a formula", "x", float("nan"))
    assert [item.verdict for item in sheet.items] == [Verdict.DIFFERS] * 2


def test_an_erratum_needs_a_reason_and_a_computation_that_holds():
    sheet = Sheet("AM", [])
    for reason, shown in (("", None), ("printed wrongly", None), ("", Shown("w", True)), ("r", Shown("w", False))):
        sheet.numbers("eq. 9", "a sign", "1", -1, reason=reason, shown=shown)
        assert last(sheet).verdict is Verdict.DIFFERS
    sheet.numbers("eq. 9", "a sign", "1", -1, reason="printed wrongly.", shown=Shown("It is −1.", True))
    assert last(sheet).verdict is Verdict.ERRATUM
    assert last(sheet).reason == "printed wrongly. It is −1."
    sheet.numbers("eq. 9", "a sign", "1", 1, reason="printed wrongly.", shown=Shown("It is −1.", True))
    assert last(sheet).verdict is Verdict.AGREES


def test_words_formulas_and_claims():
    sheet = Sheet("AM", [])
    sheet.same("a", "b", "θ4 =  0", "θ4 = 0")
    sheet.same("a", "b", "θ4 = 0", "θ4 = π")
    sheet.identity("a", "b", "f", 1e-12)
    sheet.identity("a", "b", "f", 1e-3)
    sheet.claim("a", "b", "c", "d", True)
    sheet.claim("a", "b", "c", "d", False)
    sheet.cannot("a", "b", "c", "", "the start is not printed")
    sheet.cannot("a", "b", "c", "", "")
    told = [str(item.verdict) for item in sheet.items]
    assert told == ["agrees", "differs"] * 3 + ["unreproducible", "differs"]


def test_half_a_unit_and_rounding_for_reading():
    assert [half_unit(word) for word in ("0.25", "-.7071", "3.", "3", "√2")] == [0.005, 5e-5, 1e-9, 1e-9, 1e-9]
    assert [rounded(x, 2) for x in (0.004, -0.004, 1.005, -2.0, 10.0)] == ["0", "0", "1", "−2", "10"]


def test_printed_formulas_are_evaluated_as_they_stand(rng):
    theta = rng.uniform(-3, 3, (5, 7))
    letters = {"a": 0.6, "c": 0.5, "d": 6.8}
    s, c = np.sin, np.cos
    ours = value("-d^2 s4 (a s345 + d c34) - 2 c c345/3 + s2", theta, letters)
    t345, t34 = theta[:, 2:5].sum(axis=1), theta[:, 2:4].sum(axis=1)
    expected = -(6.8**2) * s(theta[:, 3]) * (0.6 * s(t345) + 6.8 * c(t34)) - c(t345) / 3 + s(theta[:, 1])
    assert np.abs(ours - expected).max() < 1e-12
    assert matrix("s1 | 0\n1 | a", theta, letters).shape == (5, 2, 2)
    with pytest.raises(OptionError, match="name"):
        value("b s1", theta, letters)


def literal_results() -> list[str]:
    """Calls of the documents in which the side of this package is a text that nothing was put in."""
    found = []
    for path in sorted((Path(__file__).parents[2] / "papers").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
                continue
            given = {one.arg: one.value for one in node.keywords}
            if node.func.attr in ("claim", "same", "numbers") and len(node.args) > 3:
                given["ours"] = node.args[3]
            compares = node.func.attr in ("claim", "same", "numbers", "identity")
            if compares and isinstance(given.get("ours"), ast.Constant):
                found.append(f"{path.name}:{node.lineno}")
    return found


def test_what_is_compared_with_the_print_is_computed() -> None:
    assert literal_results() == []
