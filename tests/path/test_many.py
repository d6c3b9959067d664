"""Many paths, checked at once."""

from __future__ import annotations

from pathlib import Path

import pytest
from cli.path_files import FREE, saved

from rankdrop.errors import ResultFileError
from rankdrop.path.check.many import check_chunk
from rankdrop.results.analysis import robot_to_dict
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def test_a_file_that_changes_while_others_are_judged_is_told(tmp_path: Path) -> None:
    arm = open_robot("planar3r")
    task = resolve_task(None, arm)
    file = saved(tmp_path, "a.npy", FREE)
    plan = {"robot": robot_to_dict(arm, task, 3), "length_scale": 1.0, "analysis": None, "options": {}, "reading": {},
            "files": [["a.npy", str(file), "0" * 64]]}  # fmt: skip
    with pytest.raises(ResultFileError, match=r"a\.npy: the file is not what it was when the job began"):
        check_chunk(plan, 0)
