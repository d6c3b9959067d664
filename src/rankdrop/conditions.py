"""One verb: from a robot to its singularity conditions, exactly."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import monotonic

from rankdrop._handles import check_robot
from rankdrop.derived import Conditions, Step
from rankdrop.errors import OptionError
from rankdrop.exact.chain import Chain, exact_chain
from rankdrop.exact.check import Check
from rankdrop.exact.derivation import METHODS, Corank1, corank_one
from rankdrop.exact.describe import described
from rankdrop.exact.families import families, real_sets
from rankdrop.exact.family import Assumption, ExactFamily
from rankdrop.exact.special import assumptions
from rankdrop.exact.structure import structure_of
from rankdrop.exact.tree import Tree, rank_tree
from rankdrop.exact.verify import cloud, explained
from rankdrop.exact.work import OutOfTime, Work
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.version import VERSION

Progress = Callable[[str, int, int], None]
"""progress(label, done, total), label such as "sets looked into"."""
POINTS = 1000
"""Singular configurations found numerically that the families have to explain."""


def conditions(
    robot: Robot,
    task: str | Task | None = None,
    *,
    method: str = "auto",
    lengths: str | Mapping[str, float] = "auto",
    snap: float = 0.0,
    coranks: int | None = None,
    seconds: float = 60.0,
    seed: int = 0,
    points: int = POINTS,
    special: bool = True,
    progress: Progress | None = None,
) -> Conditions:
    """Derive the singularity conditions of an arm exactly, and check them.

    The Jacobian is written over the rational numbers in half-angle tangents, sines and cosines, and lengths. Its rank
    drops on closed sets; each is taken apart into irreducible ones, and those without real points are left out. Every
    family is checked twice, by means that know nothing of the derivation: the rank modulo a prime at random points of
    it, and `points` singular configurations found numerically, which all have to lie on one.

    Args:
        robot: revolute and prismatic joints, each a variable of its own.
        task: as in `resolve_task`; None is the one the arm is made for.
        method: for corank 1: "auto", or one of `METHODS`; the result says what was chosen and why. All give the same
            set. Every corank above comes from the rank tree.
        lengths: "auto", "letters", "numbers" or letters with values, see `exact_chain`.
        snap: lengths up to this are taken for zero [m].
        coranks: the highest corank to derive; None for all.
        seconds: time limit; what was derived by then is returned, and what is left is told.
        seed: of every random choice.
        points: how many singular configurations of corank 1 to try; a tenth for each corank above; 0 for none.
        special: also derive the arms whose lengths break an assumption.
        progress: called as progress(label, done, total).

    Returns:
        Conditions.

    Raises:
        RobotError: not a Robot, a helical joint, or a joint that follows another one.
        TaskError: the task does not exist.
        OptionError: an option outside what is allowed.
        MissingExtraError: python-flint is not installed.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> [family.texts for family in conditions(open_robot("scara"), points=0).families]
        [('θ2 = 0 or π',)]
    """
    check_robot(robot)
    _check(method, coranks, seconds, points)
    begun = monotonic()
    chain = exact_chain(robot, task, lengths=lengths, snap=snap)
    work = Work(seconds, seed, progress)
    full = min(chain.task.m, chain.n)
    lowest = 0 if coranks is None else max(full - coranks, 0)
    tree = rank_tree(chain, work, lowest=lowest)
    left = list(tree.left)
    found, not_real, extra = _families(chain, tree, work, seed, left)
    first = corank_one(chain, method, found, Work(max(work.left, 1.0), seed))
    left += [*first.left, *_unresolved(work)]
    assumed = _assumptions(chain, tree, lowest, work, left) if special else ()
    check, over = _cloud(chain, tree.generic_rank, lowest, found, seed, points, progress)
    return Conditions(
        robot=robot,
        task=chain.task,
        generic_rank=tree.generic_rank,
        letters=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        remarks=(*chain.remarks, *structure_of(chain).near),
        method=first.method,
        reason=first.reason,
        steps=tuple(Step(title, lines) for title, lines in first.steps),
        families=tuple(found),
        lowest=lowest,
        assumptions=tuple(assumed),
        not_real=tuple(not_real),
        explained=check,
        disagreements=(*first.disagreements, *extra, *over),
        complete=tree.complete and not left,
        left=tuple(left),
        seconds=monotonic() - begun,
        seed=seed,
        version=VERSION,
    )
