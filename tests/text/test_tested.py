"""Arms that are singular everywhere, as they are reported."""

from __future__ import annotations

SMALL = ("--starts", "200", "--quiet")


def test_an_arm_that_is_always_singular_is_told_so(run) -> None:
    text = " ".join(run("analyze", "planar3r", "--task", "position", "--full", *SMALL).out.split())
    assert "always singular for the task position: the rank is 2 at every configuration, 3 would be full" in text
    assert "corank is counted from rank 2" in text
    assert "planar-position" in text.split("tasks it can do in full:")[1]
    assert "Corank 1 (rank 1 of 2)" in text


def test_an_arm_with_too_few_joints_for_the_task_is_told_so(run) -> None:
    text = " ".join(run("analyze", "scara", "--task", "pose", "--full", *SMALL).out.split())
    assert "the task pose has 6 rows and the arm 4 joints: the rank is 4 at most" in text
    assert "scara" in text.split("tasks it can do in full:")[1]
    assert "Corank 1 (rank 3 of 4)" in text
