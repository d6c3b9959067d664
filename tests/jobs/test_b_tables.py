"""Job (b): a student. The tables of a paper, as Almarkhi and Maciejewski print them, in LaTeX.

What has to be known: --latex, and that the tables need the package amsmath; the file says so in its first line.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from jobs.shell import environment, run

pytestmark = pytest.mark.slow


def test_the_tables_of_the_pa10_in_a_paper(tmp_path: Path) -> None:
    done = run(tmp_path, "analyze", "pa10", "--starts", "1000", "--latex", "pa10.tex", "--quiet")
    assert done.returncode == 0, done.stderr
    tables = (tmp_path / "pa10.tex").read_text(encoding="utf-8")
    assert "amsmath" in tables.splitlines()[0]
    assert tables.count(r"\caption{") == 3  # coranks 1, 2, 3: AM's Tables 3 to 5
    latex = shutil.which("pdflatex")
    if latex is None:
        pytest.skip("no pdflatex is installed: apt-get install texlive-latex-base; the tables were written")
    paper = "\\documentclass{article}\\usepackage{amsmath}\\begin{document}\\input{pa10}\\end{document}"
    (tmp_path / "paper.tex").write_text(paper, encoding="utf-8")
    made = subprocess.run([latex, "-interaction=nonstopmode", "-halt-on-error", "paper.tex"], cwd=tmp_path,
                          env=environment(), capture_output=True, text=True, timeout=600, check=False)  # fmt: skip
    assert made.returncode == 0, made.stdout[-800:]
    assert (tmp_path / "paper.pdf").stat().st_size > 10_000
