"""Every call of docs/howto/coming-from.md is made, in the libraries it belongs to, and says the same as rankdrop's.

Needs the extra "cross"; a package that is missing is skipped with the reason.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cross.model_packages import package
from rankdrop import analyze, conditions, explain, jacobian, jacobian_derivative, open_robot, pose
from rankdrop.task import TIP, Frame

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "howto" / "coming-from.md").read_text(encoding="utf-8")
FILE = str(ROOT / "tests" / "data" / "arms" / "tm5_900_nominal.urdf")
Q = np.radians([10, 20, 30, 40, 35, 50])


def calls(column: int) -> list[str]:
    """The code of one column of the table, in order; what has no parentheses names a constant or a function."""
    rows = [line.split("|") for line in PAGE.splitlines() if line.startswith("|")][2:]
    return [code for row in rows for code in re.findall(r"`([^`]+)`", row[column + 1])]


def block(title: str) -> str:
    """The code under one library's name in the second part."""
    found = re.search(rf"^{title}:\n\n```python\n(.*?)```", PAGE, re.DOTALL | re.MULTILINE)
    assert found
    return found[1]


def ours() -> Any:
    return open_robot(FILE, tip="flange", as_written=True)


@pytest.mark.by_hand
@pytest.mark.filterwarnings("ignore:Robot.URDF:DeprecationWarning")
def test_the_robotics_toolbox_says_what_the_page_says(capsys: pytest.CaptureFixture[str]) -> None:
    rtb = package("roboticstoolbox")
    arm = rtb.Robot.URDF(FILE)
    names = {"rtb": rtb, "arm": arm, "q": Q, "file": FILE, "J": arm.jacob0(Q)}
    values = {code: eval(code, names) for code in calls(1)}
    assert len(values) == 8
    mine = ours()
    assert np.allclose(values["arm.fkine(q)"].A, pose(mine, Q), atol=1e-9)
    assert np.allclose(values["arm.jacob0(q)"], jacobian(mine, Q), atol=1e-9)
    assert np.allclose(values["arm.jacobe(q)"], jacobian(mine, Q, Frame(axes=TIP)), atol=1e-9)
    derivative = jacobian_derivative(mine, Q)  # (6, n, n): [row, column, joint that moves]
    assert np.allclose(values["arm.hessian0(q)"], derivative.transpose(2, 0, 1), atol=1e-9)
    singular = {"rtb": rtb, "q": np.radians([10, 20, 30, 40, 0, 50])}
    capsys.readouterr()
    exec(block("Robotics Toolbox"), singular)
    first, told = capsys.readouterr().out.split("\n", 1)
    assert abs(float(first)) < 1e-15
    assert "column" in told


def test_pinocchio_says_what_the_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pin = package("pinocchio")
    model = pin.buildModelFromUrdf(FILE)
    names = {"pin": pin, "model": model, "data": model.createData(), "q": Q, "v": np.ones(6), "file": FILE,
             "frame": model.getFrameId("flange")}  # fmt: skip
    values = {code: eval(code, names) for code in calls(2)}
    mine = ours()
    assert np.allclose(values["data.oMf[frame]"].homogeneous, pose(mine, Q), atol=1e-9)
    local = "pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)"
    assert np.allclose(values[local], jacobian(mine, Q, Frame(axes=TIP)), atol=1e-9)
    aligned = eval(local.replace("LOCAL", "LOCAL_WORLD_ALIGNED"), names)
    assert "pin.LOCAL_WORLD_ALIGNED" in values
    assert np.allclose(aligned, jacobian(mine, Q), atol=1e-9)
    text = Path(FILE).read_text(encoding="utf-8")  # the page's block asks for a file of this name with a flange
    (tmp_path / "puma560.urdf").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    exec(block("Pinocchio"), {"pin": pin, "np": np, "q": np.radians([10, 20, 30, 40, 0, 50])})


def test_rankdrops_own_calls_are_those_of_the_page() -> None:
    names = {"open_robot": open_robot, "pose": pose, "jacobian": jacobian, "Frame": Frame, "explain": explain,
             "jacobian_derivative": jacobian_derivative, "q": Q, "arm": open_robot("puma560")}  # fmt: skip
    run = [code for code in calls(3) if "file" not in code and not code.startswith(("analyze", "conditions"))]
    assert len(run) >= 6
    for code in run:
        assert eval(code, names) is not None
    assert {"analyze(arm)", "conditions(arm)"} <= set(calls(3))
    assert callable(analyze)
    assert callable(conditions)
