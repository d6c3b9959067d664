"""How lines are broken for the width of a terminal."""

from __future__ import annotations

from rankdrop.cli.terminal import formula


def test_formulas_are_broken_before_signs_outside_of_brackets() -> None:
    text = "a2² (2 d3 c2 c4 − c4² (a3² c2² + a3²)) + a2⁴ c2² c4² + (a3 c4 − d3 s4)² (a3² + d4²) = 0"
    broken = formula("  " + text, 50)
    assert len(broken) > 1
    assert " ".join(part.strip() for part in broken) == text
    assert all(len(part) <= 50 for part in broken)
    assert all(part.strip()[0] in "+−=" for part in broken[1:])
    assert formula(text, 200) == [text]
