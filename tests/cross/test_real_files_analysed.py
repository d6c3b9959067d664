"""Real files out of packages run to the end: every arm gets a table in which nothing found is hidden."""

from __future__ import annotations

import pytest

from cross.real_files import FILES, XACROS, RealFile
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze

pytest.importorskip("pinocchio", reason='the extra "cross" is not installed')

CASES = [*FILES.items(), *((f"{name}.xacro", file) for name, file in XACROS.items())]


LATE = {"iiwa": pytest.mark.by_hand}  # offsets of 0.436 mm: a minute


@pytest.mark.spread(1)
@pytest.mark.by_hand_at("irb140.xacro", "puma560.xacro", "ur5", "irb140", "panda", "xarm7")
@pytest.mark.slow
@pytest.mark.slow_at("ur5", "xarm7", "panda", "puma560.xacro", "irb140.xacro")
@pytest.mark.parametrize("file", [pytest.param(file, id=name, marks=LATE.get(name, ())) for name, file in CASES])
def test_analysis_runs_to_the_end_and_hides_nothing(file: RealFile) -> None:
    robot = open_robot(str(file.path), tip=file.tip, packages=file.packages)
    analysis = analyze(robot, starts=500, seed=6, exact="off")
    assert analysis.complete
    assert analysis.generic_rank == 6
    assert analysis.coranks[0].converged >= 495  # rtb-data gives its iiwa offsets of 0.436 mm: a few starts are slow
    assert analysis.coranks[-1].converged == 0
    for summary in analysis.coranks:
        assert summary.starts == summary.converged + summary.near_misses + summary.slow == 500
        rows = [family for family in analysis.families if family.corank == summary.corank]
        assert bool(rows) == bool(summary.converged)
        assert all(row.soundness.holds for row in rows if row.named)
        left = summary.completeness.tested - summary.completeness.agree
        assert left == 0 or any(not row.named for row in rows)
