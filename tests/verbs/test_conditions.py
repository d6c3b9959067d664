"""`conditions` of an arm, and the code that computes them."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from rankdrop.kinematics import task_jacobian
from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions


def test_without_steps_nothing_is_said() -> None:
    found = conditions(open_robot("scara"), points=0)
    assert found.determinants is None
    assert found.to_dict()["determinants"] is None


def test_code_gives_the_same_numbers(tmp_path) -> None:
    """The Python module and the C header hold the determinants, with the letters as they are named there."""
    robot = open_robot("puma560")
    found = conditions(robot, coranks=1, points=0, steps=True)
    module: dict = {}
    exec(found.code("python"), module)
    q = np.array([0.1, -0.7, 0.4, 0.3, 1.2, -0.5])
    wanted = np.linalg.det(task_jacobian(robot, q, replace(found.task, length_scale=1.0)))
    assert module["DETERMINANTS"]["det_J"](q) == pytest.approx(wanted, abs=1e-12)
    assert module["det_J"](np.stack([q, q])).shape == (2,)
    assert r"$\det J_{22} = -s_5$" in found.latex()
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    (tmp_path / "arm.h").write_text(found.code("c"))
    numbers = ", ".join(repr(float(x)) for x in q)
    (tmp_path / "main.c").write_text(
        f'#include <stdio.h>\n#include "arm.h"\nint main(void) {{ double q[6] = {{{numbers}}};\n'
        'printf("%.17g\\n", rankdrop_puma560_det_J(q)); return 0; }\n'
    )
    subprocess.run(
        [compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "main.c", "-o", "main", "-lm"],
        cwd=tmp_path, check=True,
    )  # fmt: skip
    printed = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=True).stdout
    assert float(printed) == pytest.approx(wanted, abs=1e-12)
