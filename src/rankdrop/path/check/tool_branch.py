"""Where does a branch of the inverse kinematics lead along a tool path: its joint values, and how and why they end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rankdrop.path.check.passing import Turn
from rankdrop.poses.arm_posture import ArmPosture
from rankdrop.robot.model import Array
from rankdrop.text.tool_paths import branch_chosen


@dataclass(frozen=True)
class Passed:
    """A singularity through which a branch goes on.

    Attributes:
        place: pose, from 1, with the share of the way to the next.
        rest: the arm has to rest there: at constant path speed joint rates have no bound. False: it may pass at any
            speed.
    """

    place: float
    rest: bool


@dataclass(frozen=True, eq=False)
class ToolBranch:
    """One branch of the inverse kinematics along a tool path, that of one configuration at the first pose.

    Attributes:
        start: (n,) the configuration at the first pose [rad, m].
        posture: signs of the parts of the arm there, such as "elbow +"; empty where none are known.
        parts: the same by parts of the arm.
        complete, reached, reason, joint, folds, turn: as of `Followed`.
        free: proven free of singularities up to where it ends.
        place: pose, from 1, where it is first not proven free; 0 where it is.
        singular: it is known to be singular there; False where that is not decided, or it is free.
        chosen: the path takes it.
    """

    start: Array
    posture: tuple[str, ...]
    parts: ArmPosture
    complete: bool
    reached: float
    reason: str
    joint: int
    folds: bool
    turn: Turn | None
    free: bool
    place: float
    singular: bool
    chosen: bool


@dataclass(frozen=True, eq=False)
class Followed:
    """Joint values along a tool path, and how they were found.

    Attributes:
        q: (K, n) configurations at the places [rad, m]; angles run on, they are not wrapped.
        place: (K,) poses reached, from 1; with a tolerance places between poses as well, as shares of the way.
        complete: every pose was reached.
        reached: number of the last pose reached, from 1, with the share of the way to the next.
        last: (n,) configuration there.
        reason: why it ended: "" where complete, else "start", "singular", "limit", "turn": the path goes on from here
            only after an internal turn, "few joints": the poses ahead are not all among those that the arm's rank
            allows, "stuck", or "budget": the steps or the rows that one path may have were used up.
        joint: number of the joint at its limit, from 1; 0 for other reasons.
        sigma: σ_r where it ended [1].
        poses: how many were given.
        solutions: how many isolated configurations at the first pose were found to choose it from; of a redundant arm
            how many points of its self-motions. 0 with `self_motions` 0: it was given.
        self_motions: how many self-motions at a singular first pose were found within the joint limits; 0 for a
            redundant arm.
        more: the arm is redundant, so that there are more.
        next_reachable: a configuration within the joint limits was found for the pose after the end.
        off: the tip stays within this distance of its curve, proven [m].
        turned: … and within this angle, as far as the task asks for orientations [rad].
        passed: singularities at which the branch goes on.
        folds: it ends because it folds back at a singularity: what is near was followed, and is behind.
        turn: the internal turn after which the path goes on, where that is why it ended.
        half_turns: numbers of the poses, from 1, from which the tool turns by half a turn to the next one: of the two
            ways round one was taken.
        branches: all branches that were found at the first pose and followed, those first that people use; empty for a
            redundant arm and a path of very many poses.
        moved: how far the start that was given is from the configuration at the first pose [rad; slides by the length
            scale].
    """

    q: Array
    place: Array
    complete: bool
    reached: float
    last: Array
    reason: str = ""
    joint: int = 0
    sigma: float = np.inf
    poses: int = 0
    solutions: int = 0
    self_motions: int = 0
    more: bool = False
    next_reachable: bool = False
    off: float = 0.0
    turned: float = 0.0
    passed: tuple[Passed, ...] = ()
    folds: bool = False
    turn: Turn | None = None
    half_turns: tuple[int, ...] = ()
    branches: tuple[ToolBranch, ...] = ()
    moved: float = 0.0

    @property
    def given_start(self) -> bool:
        """The configuration at the first pose was chosen by a start, not among the solutions found."""
        return self.solutions == 0 and self.self_motions == 0

    @property
    def start(self) -> list[float]:
        """(n,) configuration at the first pose."""
        return [float(x) for x in self.q[0]]

    @property
    def chosen(self) -> str:
        """Which branch of the inverse kinematics the path takes, in words."""
        return branch_chosen(self)
