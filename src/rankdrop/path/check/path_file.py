"""Is the path in a file free, whether it holds joint values or poses of the tip?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rankdrop.errors import ConfigurationError, OptionError, TaskError
from rankdrop.path.check.check import check_path
from rankdrop.path.check.record import PathCheck
from rankdrop.path.check.tool_path import check_poses
from rankdrop.path.read.files import read_trajectory
from rankdrop.path.read.poses import Poses, holds_poses, length_hint, read_poses
from rankdrop.path.read.trajectory import Trajectory, refuse_degrees, unit_hint
from rankdrop.questions import PathOptions
from rankdrop.results.analysis import Analysis
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Robot
from rankdrop.task import Task, resolve_task
from rankdrop.text.path_files import degrees_advice, reading_remarks


@dataclass(frozen=True)
class PathQuestion:
    """What is asked of a path in a file.

    Attributes:
        task, analysis, options: as for `check_path`.
        deg: angles without a unit are in degrees.
        topic: of a bag in which several have joint values.
        start: configuration near the first pose, which decides the branch of the inverse kinematics.
        at_tool_point: the tip of the arm is the tool point already: the tool that a program states is not added to it.
    """

    task: Task | str | None
    analysis: Analysis | None
    options: PathOptions
    deg: bool = False
    topic: str | None = None
    start: tuple[float, ...] | None = None
    at_tool_point: bool = False


def check_file(
    robot: Robot,
    file: Path,
    question: PathQuestion,
    *,
    say: Callable[[str], None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> PathCheck:
    """Check one file: joint values, or poses of the tip.

    Args:
        robot: the arm.
        file: trajectory or poses.
        question: what is asked of it.
        say: called with what a reader of the file should know: columns that are ignored, angles in the wrong unit.
        progress: called with (stretches decided, stretches).

    Raises:
        RankdropError: the file cannot be read, with the place in it, or an option does not fit it.
    """
    wanted = resolve_task(question.task, robot)
    read, hint = _read_path(robot, file, question)
    if say is not None:
        for line in reading_remarks(read.name, hint, read.notes, read.unused):
            say(line)
    asked: dict[str, Any] = {
        "task": question.task, "analysis": question.analysis, "options": question.options, "progress": progress,
    }  # fmt: skip
    if isinstance(read, Trajectory):
        return check_path(robot, read.q, read.times if read.timed else None, velocities=read.velocities,
                          accelerations=read.accelerations, **asked)  # fmt: skip
    if not read.turned and max(wanted.rows) >= 3:
        raise TaskError("the file has positions alone, and the task wants orientations", got=wanted.name,
                        where=str(file),
                        mend="add qx, qy, qz, qw or roll, pitch, yaw, or use task='position'",
                        typed="add qx, qy, qz, qw or roll, pitch, yaw, or use --task position")  # fmt: skip
    try:
        return check_poses(robot, read.matrices, read.times, start=question.start, **asked)
    except ConfigurationError as error:
        raise ConfigurationError(**error.parts | {"where": f"{file}, {error.where}"}) from error


def _read_path(robot: Robot, file: Path, question: PathQuestion) -> tuple[Poses | Trajectory, str | None]:
    """The poses or joint values of a file, and a hint where their unit may be another one.

    Raises:
        RankdropError: the file cannot be read, or there is a start for joint values.
    """
    deg, start = question.deg, question.start
    if question.topic is None and holds_poses(file, robot):
        poses = read_poses(file, deg=deg, robot=robot)
        return poses, length_hint(poses, reach(robot))
    if start is not None:
        raise OptionError("a start is for poses of the tip, these are joint values", where="start",
                          got=", ".join(f"{x:.6g}" for x in start))  # fmt: skip
    trajectory = read_trajectory(file, robot, deg=deg, topic=question.topic)
    if not deg:
        refuse_degrees(trajectory, robot, file)
    hint = unit_hint(trajectory.q, robot, deg=deg)
    if hint is not None and not deg:
        hint = degrees_advice(hint)
    return trajectory, hint
