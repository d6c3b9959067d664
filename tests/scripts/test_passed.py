"""What a plain command passes through is little."""

from __future__ import annotations

import pytest

from scripts import tool

BOUNDS = {
    "analyze planar3r --starts 300 --quiet --threads 1": (72, 53),
    "conditions puma560 --quiet": (63, 40),
    "conditions puma560 --quiet --fresh --coranks 1 --points 100": (89, 71),
    "explain puma560 --q 0.1,0.2,0.3,0.4,0.5,0.6": (74, 51),
    "cover ur5 --width 0.4 --quiet": (53, 35),
}
"""Command line -> at most so many files of the package, at most so many types that instances are made of."""


@pytest.mark.slow
@pytest.mark.by_hand_at(
    "conditions puma560 --quiet", "conditions puma560 --quiet --fresh --coranks 1 --points 100",
    "cover ur5 --width 0.4 --quiet", "explain puma560 --q 0.1,0.2,0.3,0.4,0.5,0.6",
)  # fmt: skip
@pytest.mark.slow_at(
    "conditions puma560 --quiet",
    "conditions puma560 --quiet --fresh --coranks 1 --points 100",
    "cover ur5 --width 0.4 --quiet",
    "explain puma560 --q 0.1,0.2,0.3,0.4,0.5,0.6",
)
@pytest.mark.parametrize("line", BOUNDS)
def test_a_command_passes_no_more_files_and_types_than_before(line: str) -> None:
    found = tool("count_passed").counted(line)
    assert found["exit"] == ["0"]
    assert "cli/main.py" in found["files"]
    assert "rankdrop.robot.model.Robot" in found["types"]
    for kind, bound in zip(("files", "types"), BOUNDS[line], strict=True):
        passed = found[kind]
        assert len(passed) <= bound, f"{len(passed)} {kind}, {bound} are allowed:\n" + "\n".join(passed)
