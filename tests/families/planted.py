"""Rows whose conditions are planted, and the problem of an arm in its own unit of length."""

from __future__ import annotations

from dataclasses import replace
from math import pi

from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom
from rankdrop.families.inspection import Signature
from rankdrop.families.linear_conditions import Linear
from rankdrop.families.row import Row
from rankdrop.problem import Problem
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

PLANTED = FamilyEvidence(ObtainedFrom.VALUES)
STRAIGHT = (0.0, pi)


def problem(name: str, corank: int) -> Problem:
    """An arm of the catalogue with its own task, and the corank."""
    robot = open_robot(name)
    task = resolve_task(None, robot)
    return Problem(robot, replace(task, length_scale=task.scale(robot)), corank)


def pinned(problem: Problem, *joints: int, values: tuple[float, ...] = STRAIGHT) -> Row:
    """The row on which joints (from 0) stand at the values."""
    n = problem.robot.n
    linear = Linear.of(problem.robot, [tuple(int(i == j) for i in range(n)) for j in joints])
    free = tuple(j for j in range(n) if j not in joints)
    return Row(linear, (values,) * len(joints), (), Signature(len(joints), joints, free, ()), PLANTED)
