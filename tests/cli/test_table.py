"""The tables: what stands in them, and that they fit the window."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from rankdrop.cli.analyze import corank_section
from rankdrop.cli.terminal import screen, show
from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.record import written_conditions
from rankdrop.formula.equation import Equation, Term
from rankdrop.results.analysis import Analysis
from rankdrop.text.families import conditions_of, coupled_conditions, exact_conditions, joint_cell
from rankdrop.text.lost import lost_sentences


@pytest.fixture
def drawn(shapes: Analysis, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """drawn(width): the tables of every corank as text."""

    def draw(width: int) -> str:
        monkeypatch.setenv("COLUMNS", str(width))
        console = screen()
        for summary in shapes.coranks:
            show(console, corank_section(console, shapes, summary))
        return capsys.readouterr().out

    return draw


@pytest.mark.parametrize("width", [30, 50, 66, 72, 80, 100, 120, 140, 200])
def test_no_line_is_wider_than_the_window_and_nothing_is_cut(drawn, shapes: Analysis, width: int) -> None:
    text = drawn(width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text
    words = set(re.findall(r"[^\s,;:]+", text))
    for row in shapes.families:
        assert set(re.findall(r"[^\s,;:]+", " ".join((row.name, *lost_sentences(row.lost_freedoms))))) <= words
    for value in ("π", "±π/2", "±0.7731", "(±44.30°)"):
        assert value in words


def test_no_line_ends_in_a_blank(drawn) -> None:
    assert not [line for line in drawn(100).splitlines() if line != line.rstrip()]


def test_lost_directions_stand_in_the_row_of_a_wide_window_only(drawn) -> None:
    assert "lost direction" in drawn(140)
    assert "lost direction" not in drawn(80)
    assert "lost cannot translate" in drawn(80)


def test_a_window_too_narrow_for_columns_gets_a_list(drawn) -> None:
    text = " ".join(drawn(50).split())
    assert "θ4 = 0, π; θ1, θ2, θ3, θ5, θ6, θ7 free" in text
    assert "θ2, θ3 coupled" in text


def test_cells_say_pinned_free_coupled(shapes: Analysis) -> None:
    coupled = shapes.families[2]
    cells = [joint_cell(coupled, number, "revolute") for number in range(1, 8)]
    assert cells == ["×", "c", "c", ("±0.7731 (±44.30°)",), "×", "×", "×"]


def test_conditions_of_pinned_joints_are_not_said_twice(shapes: Analysis) -> None:
    assert len(shapes.families[2].equations) == 2
    assert coupled_conditions(shapes.families[2]) == ["0.9087 cos θ2 + cos(θ2+θ3) = 0"]


def test_a_family_without_conditions_says_so(shapes: Analysis) -> None:
    assert "no condition found" in coupled_conditions(shapes.families[3])[0]


def test_a_corank_that_was_not_found_is_no_proof(drawn) -> None:
    text = " ".join(drawn(100).split())
    assert "Corank 2 (rank 4 of 6): none found of 10,000 starts, smallest σ5 found 0.3273" in text
    assert "Not finding one proves nothing" in text


def test_a_near_miss_is_not_called_singular(drawn) -> None:
    assert "1 near miss, 0 slow. Smallest near miss: σ6 = 0.0053, not singular." in " ".join(drawn(140).split())


def test_an_exact_condition_stands_in_place_of_a_fitted_one(shapes: Analysis) -> None:
    row = shapes.families[2]
    long = Equation(tuple(Term(1.0 + i, "cos", (0, 2 * i, 2, 0, 0, 0, 0), (0,) * 7) for i in range(26)))
    fitted = replace(row, equations=(long,))
    exact = written_conditions((), ("a2 c2 + a3 c23 = 0", "s4 = 0"), ("", ""), ("a3 − a2",))
    derived = replace(fitted, exact=exact)
    real = "s4 = 0; real if and only if a3 − a2 ≥ 0"
    assert conditions_of(derived) == [("exactly", "a2 c2 + a3 c23 = 0"), ("exactly", real)]
    assert exact_conditions(derived) == "a2 c2 + a3 c23 = 0 and s4 = 0; real if and only if a3 − a2 ≥ 0"
    (label, text), = conditions_of(fitted)
    assert (label, text[:8]) == ("c", coupled_conditions(fitted)[0][:8])
    assert conditions_of(row) == [("c", "0.9087 cos θ2 + cos(θ2+θ3) = 0")]


def test_of_very_many_rows_three_are_shown_and_the_others_counted_by_their_kind(
    shapes: Analysis, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    one = shapes.families[1]
    console = screen()
    for count, told in ((24, 24), (30, 3)):
        shares = [replace(one.explained, agree=number) for number in range(count)]
        rows = tuple(
            replace(one, id=f"k1.f{i}", evidence=FamilyEvidence(ObtainedFrom.STORED, text="made up"), explained=share)
            for i, share in enumerate(shares)
        )
        show(console, corank_section(console, replace(shapes, families=rows), shapes.coranks[0]))
        text = capsys.readouterr().out
        shown = re.findall(r"^ *(\d+) +" + re.escape(one.name[:8]), text, re.MULTILINE)
        assert len(shown) == told
        assert ("and 27 more rows, all passed their test: 27 with" in " ".join(text.split())) == (count == 30)
    assert shown == ["28", "29", "30"], "those with the largest shares"
