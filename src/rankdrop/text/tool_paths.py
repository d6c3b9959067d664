"""Tool paths in words: the branch of the inverse kinematics that is followed, where it ends and why, internal turns."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, floor
from typing import Any

import numpy as np

from rankdrop.options import advise
from rankdrop.robot.model import Robot
from rankdrop.sections import Section
from rankdrop.text.places import joint_cells
from rankdrop.text.postures import posture_words
from rankdrop.text.words import plural, short

_TURNING = 1e-6  # a joint that turns less stands still [rad]
MOST_NAMED = 10  # crossings whose poses are noted

_FOLDS = "the branch folds back at a singularity"
_REASONS = {
    "singular": "the branch ends at a singularity",
    "stuck": "the solver does not converge there",
    "budget": "the steps and rows that one tool path may have are used up",
}

_ENDS = {"singular": "singularity", "few joints": "too few joints for the poses ahead",
         "stuck": "the solver does not converge", "budget": "the budget is spent", "start": "not reached"}  # fmt: skip


def branch_chosen(tool: Any) -> str:
    """Which branch of the inverse kinematics a tool path takes."""
    if tool.given_start:
        return "of the start that was given"
    if tool.more:
        return f"nearest to q = 0 (of {tool.solutions} found, and there are more)"
    count = f"one of {tool.solutions} found"
    if tool.solutions == 1:
        count = "the only one found"
    if tool.self_motions:
        curves = f"{tool.self_motions} {plural('self-motion', tool.self_motions)}"
        count = f"of {curves} found"
        if tool.solutions:
            count = f"of {curves} and {tool.solutions} isolated {plural('solution', tool.solutions)} found"
    return f"the posture that people use ({count})"


def why_ended(tool: Any, robot: Robot) -> str:
    """Why a tool path cannot be followed any further; "" where it can."""
    if tool.complete:
        return ""
    pose = f"at pose {tool.reached:.5g}"
    if tool.turn is not None:
        return turn_words(tool.turn, robot)
    if tool.folds:
        place = f"{pose} (σ = {tool.sigma:.1e}), and no configuration near it leads on"
        reason = f"{_FOLDS}, {place}"
        return f"{reason}; {_pose_after_end_words(tool)}"
    if tool.reason == "few joints":
        between = f"pose {floor(tool.reached)} and {floor(tool.reached) + 1}"
        return f"{robot.n} joints cannot take all poses between {between} in full"
    if tool.reason in _REASONS:
        reason = f"{_REASONS[tool.reason]}, {pose} (σ = {tool.sigma:.1e})"
    else:
        reason = f"{joint_label(robot, tool.joint)} reaches its limit {pose}"
    return f"{reason}; {_pose_after_end_words(tool)}"


def _pose_after_end_words(tool: Any) -> str:
    """Whether the pose after the end can be reached."""
    ahead = f"pose {int(min(np.floor(tool.reached + 1e-9) + 1, tool.poses))}"
    if tool.next_reachable:
        return f"{ahead} is within reach, by other configurations"
    return f"{ahead} is out of reach: no configuration within the joint limits was found for it"


def turn_words(turn: Any, robot: Robot, *, place: bool = True) -> str:
    """An internal turn: its joint that turns most, the others, and how far the path can be followed after it.

    Args:
        turn: the turn.
        robot: the arm.
        place: name the pose at which it is made, and how far the path can be followed after it.
    """
    first, *others = _turned_joints(turn, robot)
    with_it = ""
    if others:
        with_it = f", with {', '.join(_joint_turn(turn, robot, i) for i in sorted(others))}"
    words = f"turn {_joint_turn(turn, robot, first)} with the tool held still{with_it}"
    if not place:
        return words
    return f"{words}, at pose {turn.place:.5g}{_after_turn(turn)}"


def _turned_joints(turn: Any, robot: Robot) -> list[int]:
    """The joints that an internal turn turns, counted from 0, the one that turns most first; at least one joint."""
    moved = turn.to - turn.q
    turns = [i for i, joint in enumerate(robot.variables) if joint.unit == "rad" and abs(moved[i]) > _TURNING]
    if not turns:
        return [int(np.abs(moved).argmax())]
    return sorted(turns, key=lambda i: (-round(abs(moved[i]), 6), i))


def _joint_turn(turn: Any, robot: Robot, i: int) -> str:
    """Where a joint, counted from 0, begins and ends an internal turn."""
    unit = robot.variables[i].unit
    if unit == "rad":
        scale, sign = degrees(1.0), "°"
    else:
        scale, sign = 1.0, f" {unit}"
    ends = " to ".join(f"{short(round(scale * float(x), 6) + 0.0, 4)}{sign}" for x in (turn.q[i], turn.to[i]))
    return f"joint {i + 1} from {ends}"


def _after_turn(turn: Any) -> str:
    """How far the path can be followed after an internal turn; empty where nobody looked."""
    if turn.rest_complete is None:
        return ""
    if turn.rest_complete:
        return "; after it the path can be followed to its end"
    return f"; after it the path can be followed to pose {turn.rest_reached:.5g}"


def passing_words(passed: Sequence[Any]) -> str:
    """How the branch goes on at the singularities that it passes."""
    if all(not crossing.rest for crossing in passed):
        if len(passed) == 1:
            return "the branch goes on through it, at any speed"
        return "the branch goes on through each, at any speed"
    rests = list(dict.fromkeys(f"{crossing.place:.5g}" for crossing in passed if crossing.rest))
    if rests == ["1"]:
        return "the path leaves the singularity at its start, from rest"
    return f"the arm rests for an instant at pose {', '.join(rests[:MOST_NAMED])}, where the branch goes on"


def branches_words(check: Any) -> str:
    """Which branch the verdict is about, and how many of the others are free."""
    branches = check.tool.branches
    number = next(i for i, branch in enumerate(branches, start=1) if branch.chosen)
    posture = posture_words(branches[number - 1].posture, branches[number - 1].parts)
    others = [branch for branch in branches if not branch.chosen]
    free = sum(branch.free and branch.complete for branch in others)
    named = f" ({posture})" if posture != "–" else ""
    this = f"{number} of {len(branches)}{named}; the verdict is about this one"
    return this + _others_words(free, len(others))


def _others_words(free: int, count: int) -> str:
    """How many of the other branches are free to the end, of how many."""
    if count < 2:
        return ("", ". The other one is not free to the end", ". The other one is free to the end")[count + free]
    return {
        0: f". None of the {count} others is free to the end",
        1: f". Of the {count} others 1 is free to the end",
        count: f". All {count} others are free to the end",
    }.get(free, f". Of the {count} others {free} are free to the end")


def _branch_verdict(branch: Any, robot: Robot) -> str:
    """A branch: "free", or where it ends and why, or where it is not proven free."""
    if branch.free:
        met = ""
    elif branch.singular:
        met = f"meets a singularity at pose {branch.place:.5g}"
    else:
        met = f"not proven free at pose {branch.place:.5g}"
    if branch.complete:
        return met or "free"
    if branch.turn is not None:
        end = f"needs an internal turn at pose {branch.reached:.5g}"
    elif branch.reason == "limit":
        end = f"ends at pose {branch.reached:.5g}: limit of {joint_label(robot, branch.joint)}"
    else:
        if branch.folds:
            reason = "folds back"
        else:
            reason = _ENDS.get(branch.reason, branch.reason)
        end = f"ends at pose {branch.reached:.5g}: {reason}"
    if met and branch.place < branch.reached:
        return f"{end}; {met}"
    return end


def branches_section(check: Any, *, deg: bool) -> Section:
    """Table of the branches at pose 1, each with its verdict, posture and joint values."""
    robot = check.robot
    heads = tuple(
        f"{i} [{'°' if deg and joint.unit == 'rad' else joint.unit}]" for i, joint in enumerate(robot.variables, 1)
    )
    rows = []
    for number, branch in enumerate(check.tool.branches, start=1):
        values = joint_cells(robot, branch.start, deg=deg)
        if branch.chosen:
            taken = f"{number} (taken)"
        else:
            taken = str(number)
        rows.append((taken, _branch_verdict(branch, robot), posture_words(branch.posture, branch.parts), *values))
    other = f"by the configuration at pose 1, those first that people use; {advise('start', '…')} takes another"
    return Section("Branches", other,
                   columns=("", "verdict", "posture", *heads), rows=tuple(rows), texts=(0, 1, 2))  # fmt: skip


def first_free_branch(branches: Sequence[Any]) -> int | None:
    """The number of the first branch that is free to the end; None where there is none, or it is the one chosen."""
    free = [(number, branch) for number, branch in enumerate(branches, start=1) if branch.free and branch.complete]
    if not free or any(branch.chosen for _, branch in free):
        return None
    return free[0][0]


def half_turn_words(poses: Sequence[int]) -> str:
    """Poses from which the tool turns by exactly half a turn: which way it turns is a choice."""
    named = ", ".join(map(str, poses[:MOST_NAMED]))
    more = ", …" if len(poses) > MOST_NAMED else ""
    return (
        f"half a turn: from {plural('pose', len(poses))} {named}{more} the next one is 180° away, "
        "and the tool may turn either way round; one of the two was checked. "
        "A pose between them decides which one the controller takes"
    )


def joint_label(robot: Robot, number: int) -> str:
    """A joint, counted from 1, with its name: "joint 2 (shoulder)"."""
    return f"joint {number} ({robot.variables[number - 1].name})"
