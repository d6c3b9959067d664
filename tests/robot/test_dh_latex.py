"""LaTeX of tables becomes plain signs, and keeps its lines."""

from __future__ import annotations

from math import pi

import pytest

from rankdrop.robot.dh_latex import plain_latex, rows_of_line
from rankdrop.robot.quantities import quantity

ANGLES = {
    r"$\frac{\pi}{2}$": pi / 2, r"$-\dfrac{3\pi}{2}$": -1.5 * pi, r"\tfrac\pi2": pi / 2, r"$\frac12\pi$": pi / 2,
    r"$\frac{\frac{\pi}{2}}{3}$": pi / 6, r"$2\cdot\pi$": 2 * pi, r"$\left(\pi / 4\right)$": pi / 4,
    r"$90^\circ$": pi / 2, r"$-90^{\circ}$": -pi / 2, r"\ang{45}": pi / 4, r"90\textdegree{}": pi / 2,
    r"\SI{180}{\degree}": pi, r"$\text{90}^\circ$": pi / 2, r"$\frac{\sqrt{4}}{2}$": 1.0,
}  # fmt: skip


@pytest.mark.parametrize("text", ANGLES)
def test_an_angle_has_the_value_that_is_printed(text: str) -> None:
    assert quantity(plain_latex(text).strip(), "angle", where="") == pytest.approx(ANGLES[text])


@pytest.mark.parametrize(
    ("text", "plain"),
    [(r"$\theta_{12}^{*}$", "theta_12*"), (r"$q_1^\ast$", "q_1*"), (r"$\vartheta_1$", "theta_1"),
     (r"\textbf{$a_{i-1}$}", "a_i-1"), (r"$d_i$ $[\mathrm{m}]$", "d_i [ m]"), (r"1 & 0 \\[2pt] \hline", r"1 & 0 \\"),
     (r"\hline 1 & 0 \\", r"1 & 0 \\"), (r"\multicolumn{1}{|c|}{$\alpha$}", "alpha"), (r"\foo{2}", r"\foo{2}"),
     ("a = [1, 2]", "a = [1, 2]")],
)  # fmt: skip
def test_signs_take_the_place_of_commands(text: str, plain: str) -> None:
    assert plain_latex(text).strip() == plain


def test_lines_stay_where_they_are() -> None:
    text = "\\begin{tabular}{cc}\n\\toprule\n$a$ &\n$d$ \\\\\n\\end{tabular}\n"
    assert plain_latex(text).count("\n") == text.count("\n")


def test_rows_in_one_line_are_told_apart_by_their_ends() -> None:
    assert rows_of_line(r"1 & 2 \\ 3 & 4 \\ ") == ["1 & 2 ", " 3 & 4 "]
    assert rows_of_line(r"C:\\arm") == [r"C:\\arm"]
