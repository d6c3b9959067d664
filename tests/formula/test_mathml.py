"""Conditions in MathML."""

from __future__ import annotations

import re

import pytest

from rankdrop.formula.mathml import typeset


@pytest.mark.parametrize(
    ("latex", "parts"),
    [
        (r"\theta_4 \in \{0, \pi\}", ["<msub><mi>θ</mi><mn>4</mn></msub>", "∈", "<mi>π</mi>"]),
        (r"\theta_3 = \pm\frac{\pi}{2}", ["±", "<mfrac><mrow><mi>π</mi></mrow><mrow><mn>2</mn></mrow></mfrac>"]),
        (r"a_2 c_2 + a_3 c_{23} = 0", ["<mrow><mn>23</mn></mrow>", ">+<"]),
        (r"\cos^{2}(\tfrac{\theta_2}{2})", ["<msup>", "cos"]),
        (r"2.5 \cdot 10^{-13} \mathrm{upper}", ["<mn>2.5</mn>", "−", "<mtext>upper</mtext>"]),
    ],
)
def test_conditions_are_typeset(latex: str, parts: list[str]) -> None:
    found = typeset(latex)
    assert all(part in found for part in parts)
    for tag in ("mrow", "msub", "msup", "mfrac", "mi", "mn", "mo", "math"):
        assert len(re.findall(f"<{tag}[ >]", found)) == found.count(f"</{tag}>")
    assert "\\" not in found
