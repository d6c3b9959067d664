"""A text has a table in one of the written forms, or none; calls count before a heading, and a heading before lists."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.dh_rows import is_table, table_in

FORMS = {
    "calls": "RevoluteDH(a=1, d=0, alpha=90)\nRevoluteDH(a=1, d=0, alpha=90)\n",
    "a heading": "a, alpha, d, theta\n2, 90, 0, q1\n2, 90, 0, q2\n",
    "names in each row": "{'a': 3, 'd': 0, 'alpha': 90}\n{'a': 3, 'd': 0, 'alpha': 90}\n",
    "lists": "a = [4, 4]\nd = [0, 0]\nalpha = [90, 90]\n",
    "numbered names": "a1 = 5, d1 = 0, alpha1 = 90\na2 = 5, d2 = 0, alpha2 = 90\n",
}


def lengths(text: str) -> list[str]:
    """The entries a of the table of a text."""
    table = table_in(text, "t")
    assert table is not None
    return [row.entries["a"] for row in table.rows]


@pytest.mark.parametrize("first", range(len(FORMS)))
def test_the_first_form_of_a_text_counts(first: int) -> None:
    """Wherever it stands: the forms behind it are not read."""
    texts = list(FORMS.values())[first:]
    for text in (texts[0], "\n\n".join(texts), "\n\n".join(reversed(texts))):
        assert lengths(text) == [str(first + 1)] * 2


def test_greek_letters_and_latex_are_those_of_plain_text() -> None:
    plain = table_in("a & alpha & d & theta\n1 & -(pi)/(2) & 0 & theta_1 - 90°\n", "t")
    latex = table_in("$a$ & $\\alpha$ & $d$ & $\\theta$\n1 & $−\\frac{π}{2}$ & 0 & $\\theta_{1} - 90^\\circ$\n", "t")
    mixed = table_in("$a$ & $α$ & $d$ & $θ$\n$1$ & −(pi)/(2) & $0$ & $θ_1$ − 90°\n", "t")
    assert plain is not None
    assert latex == mixed == plain


def test_text_without_a_table_has_none() -> None:
    unequal = "a = [1, 2]\nalpha = [1]\nd = [1, 2]\n"
    for text in ("nothing known", "alpha, beta, gamma\n1, 2, 3\n", unequal, "Link", "a1 = 1"):
        assert not is_table(text)


def test_a_text_with_a_table_that_is_refused_has_a_table() -> None:
    text = "L1 = Link([0 1 0 0]); L1 = Link([0 2 0 0]);"
    with pytest.raises(RobotError, match="the file has two arms"):
        table_in(text, "t")
    assert is_table(text)
