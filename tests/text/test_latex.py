"""The tables of an analysis as LaTeX: they say what the analysis says, and they compile."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from math import pi
from pathlib import Path

import pytest

from rankdrop.formula.equation import Equation, Term
from rankdrop.results.known import shipped
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.robot.open import open_robot
from rankdrop.robot.quantities import degrees_text
from rankdrop.text.latex import as_text
from rankdrop.text.lost import lost_sentences
from rankdrop.verbs.analyze import analyze

LATEX = shutil.which("pdflatex")
needs_latex = pytest.mark.skipif(LATEX is None, reason="no pdflatex is installed: apt-get install texlive-latex-base")


def compiled(text: str, folder: Path) -> str:
    """The log of pdfLaTeX over a document that holds the text; a document that stops at an error fails the test."""
    head = "\\documentclass{article}\n\\usepackage{amsmath,longtable}\n\\begin{document}\n"
    document = f"{head}{text}\n\\end{{document}}\n"
    (folder / "tables.tex").write_text(document, encoding="utf-8")
    command = [str(LATEX), "-interaction=nonstopmode", "-halt-on-error", "tables.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    for _ in range(2 * ("longtable" in text)):  # long tables learn the widths of their columns from the run before
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout[-1500:]
    return done.stdout


@pytest.mark.spread(2)
@pytest.mark.slow
@needs_latex
@pytest.mark.parametrize("name", ["pa10", "ur5", "stanford", "planar2r", "panda", "canadarm2"])
def test_the_tables_compile(name: str, tmp_path: Path) -> None:
    log = compiled(shipped(name).latex(), tmp_path)
    assert "Missing character" not in log
    widths = [float(one) for one in re.findall(r"Overfull \\hbox \(([\d.]+)pt too wide\)", log)]
    assert max(widths, default=0.0) < 25.0  # the page is 345 pt wide


@pytest.mark.spread(1)
@pytest.mark.slow
@pytest.mark.shipped
@needs_latex
@pytest.mark.parametrize("name", ["yumi", "crx10ial"])
@pytest.mark.parametrize("kind", ["analysis", "conditions"])
def test_long_tables_fit_their_pages(name: str, kind: str, tmp_path: Path) -> None:
    """A table of YuMi was 4000 pt too high for its page, and 49 pt too wide."""
    if kind == "analysis":
        text = shipped(name).latex()
    else:
        text = shipped_conditions(name).latex()
    log = compiled(text, tmp_path)
    sizes = [float(one) for one in re.findall(r"Overfull \\[hv]box \(([\d.]+)pt too", log)]
    assert max(sizes, default=0.0) < 10.0
    assert "Float too large" not in log


def test_a_table_of_many_rows_breaks_over_pages() -> None:
    assert r"\begin{longtable}" in shipped("yumi").latex()
    assert "longtable" in shipped("yumi").latex().splitlines()[0]
    assert "longtable" not in shipped("pa10").latex()


@pytest.mark.slow
@needs_latex
def test_exact_conditions_and_strange_names_compile(tmp_path: Path) -> None:
    found = analyze(open_robot("puma560"), starts=300, exact="on")
    strange = replace(found, robot=replace(found.robot, name=r"50%_of \input{x} #1 $ ^~ & Ünïcode 腕"))
    text = strange.latex()
    assert r"\input" not in text
    assert r"a_2 c_2" in text.replace("{", "").replace("}", "")
    compiled(text, tmp_path)


def test_a_table_for_each_corank_with_columns_dimension_and_loss() -> None:
    found = shipped("pa10")
    text = found.latex()
    coranks = sorted({family.corank for family in found.families})
    assert text.count(r"\begin{table}") == len(coranks)
    heads = "".join(f" & $\\theta_{{{i}}}$" for i in range(1, 8))
    rows = [line.removesuffix(r" \tabularnewline") for line in text.splitlines()]
    titles = [row.split(" & ") for row in rows if heads in row]
    assert len(titles) == len(coranks)
    for corank in coranks:
        assert f"singularities of corank {corank} " in text
    elbow = next(line for line in text.splitlines() if line.startswith("1 & \\raggedright elbow"))
    cells = [cell.strip() for cell in elbow.split(" & ")]
    assert cells[2:9] == [r"$\times$"] * 3 + [r"0, $\pi$"] + [r"$\times$"] * 3
    assert cells[titles[0].index("dim")] == str(found.families[0].dimension)
    assert as_text(lost_sentences(found.families[0].lost_freedoms)[0]) in cells[titles[0].index("lost direction")]
    assert text.isascii()


def test_no_families_are_told_as_no_proof() -> None:
    found = shipped("pa10")
    assert "no proof" in replace(found, families=()).latex()


def test_conditions_are_written_as_mathematics_from_their_terms() -> None:
    none, half = (0,) * 12, (0, 0, 0, -1, *(0,) * 8)
    both = (0, 4, *(0,) * 9, -2)
    squared = (0, 0, 2, *(0,) * 9)
    told = Equation((Term(0.5, "cos", both, none, 0.0), Term(-1.0, "sin", half, squared, pi / 2)))
    assert told.pretty() == "0.5 cos(2θ2−θ12) − sin((−θ4 − π)/2) q3²"
    assert told.latex() == r"0.5 \cos(2\theta_{2}-\theta_{12}) - \sin((-\theta_{4} - \pi)/2) q_{3}^{2}"


def test_a_loss_told_at_the_witness_has_the_witness_below_the_table() -> None:
    found = shipped("pa10")
    told = [one for one in found.families if not all(lost.everywhere for lost in one.lost_freedoms)]
    latex = found.latex()
    assert len(told) > 1
    assert latex.count("witness q = ") == len(told)
    for one in told:
        assert f"witness q = {as_text(degrees_text(one.witness, found.robot.units))}" in latex
