"""The configuration by which a family is shown: one of round numbers, one that people would choose, one that stands.

`witness` is a readable configuration: zeros where nothing depends on a joint, round numbers elsewhere.

`pose_witness` chooses the witness of a table: a member that nothing speaks against (`rankdrop.local.fault`). In a
picture that is not enough: an arm that lies along the floor is a thin line in a wide frame. `upright` draws the member
that stands up, among those that are no worse in `fault`, and searches longer for one inside the joint limits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from rankdrop.families.linear_conditions import Linear
from rankdrop.families.naming import lost_motions
from rankdrop.families.record import Family
from rankdrop.families.rescaling import family_in_metres
from rankdrop.families.row import Row
from rankdrop.formula.equation import System
from rankdrop.local.block import generic_rank, sampling_box, singular_values
from rankdrop.local.posture import candidates, fault, spine, start_posture
from rankdrop.problem import Problem, into_limits, wrap_joints
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import Array, Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT
from rankdrop.units import in_metres, into_metres, out_of_metres, task_in_metres

VIEW = -0.9
"""Azimuth from which pictures are seen [rad]."""
TALL = 0.55
"""Height of the highest point of an arm over its base from which it counts as upright [reach]."""
_WIDE = 0.4  # seen narrower than this, an arm points at the reader [reach]
_ACROSS = np.array([-np.sin(VIEW), np.cos(VIEW), 0.0])
_CANDIDATES = 256
_LONGER = 2000  # further starts for a picture of an arm that would stand outside the joint limits
_WORTH = 0.15  # the witness stays unless another member is better by this much of `fault`
_SLACK = 0.15  # of `fault` that a taller posture may cost
_TALLER = 0.05  # of `_poor` that another member has to gain for a picture
_POINTS = 24  # members from which the frame of the words is chosen
_ROOM = 1e-3  # the singular value that is kept is at least this [1]: not on a more special family
_SHARED = 1.0  # added to `fault` of a member that lies on another family too: it is an example of both
_TRIES = 64  # round configurations that are looked at
_ROUND = 0.1  # free angles stand at multiples of this [rad], free lengths at multiples of a power of ten [m]


def witness(problem: Problem, row: Row, rng: np.random.Generator) -> Array | None:
    """(n,) a point of the row of corank exactly k, the next singular value as large as round numbers allow.

    Joints on which σ does not depend are 0, free ones at round numbers, pinned ones at the first of their values,
    and only as many coupled ones as there are residual equations are solved for. None when no try succeeds.
    """
    values = np.array([[joint_values[0] for joint_values in row.sets]] * _TRIES).reshape(_TRIES, -1)
    placed = row.linear.place(_round_configurations(problem, rng), values, rng)
    best: tuple[float, Array | None] = (0.0, None)
    for along in _solving_directions(row) if row.residual else [np.zeros((problem.n, 0))]:
        q, good = placed, np.ones(_TRIES, dtype=np.bool_)
        if row.residual:
            q, good = System(row.residual).solve(placed, along=along)
        q = _wrap_without_rounding(problem, q)
        good = good & problem.within_limits(q)
        sigma = problem.sigma(q)
        good &= sigma[:, problem.rank] <= problem.tolerances.singular
        gap = np.where(good, sigma[:, problem.rank - 1] if problem.rank else 1.0, 0.0)
        i = int(np.argmax(gap))
        if gap[i] > max(1e-6, 1.2 * best[0]):
            best = (float(gap[i]), q[i])
    return best[1]


def _round_configurations(problem: Problem, rng: np.random.Generator) -> Array:
    """(_TRIES, n) random configurations of round numbers."""
    low, high = problem.box
    periodic = problem.robot.periodic
    reach = np.where(periodic, 1.5, 0.5 * (high - low))
    middle = np.where(problem.limits | ~periodic, 0.5 * (low + high), 0.0)
    half = 0.5 * np.maximum(high - low, 1e-9)
    scale = np.where(periodic, _ROUND, 10.0 ** np.floor(np.log10(0.4 * half)))
    q = middle + rng.uniform(-1, 1, (_TRIES, problem.n)) * np.minimum(reach, half)
    q = np.round(q / scale) * scale
    q = np.where((q < low) | (q > high), middle, q)
    resting = problem.idle & (low <= 0) & (high >= 0)
    return np.asarray(np.round(np.where(resting, 0.0, q), 12), dtype=np.float64)


def _solving_directions(row: Row) -> list[Array]:
    """Directions in which the residual equations may be solved: as few coupled joints as there are equations."""
    need = row.signature.residual
    moves = _dragged_motions(row.linear)
    coupled = [j for j in row.signature.coupled if j not in row.linear.pivots]
    few = list(combinations(reversed(coupled), need))[:12]
    return [np.linalg.qr(moves[:, list(chosen)])[0] for chosen in few] + [row.linear.kept_motions]


def _dragged_motions(linear: Linear) -> Array:
    """(n, n) column j: what joint j drags along so that all covectors keep their values (zero for pivots)."""
    n = linear.covectors.shape[1]
    moves = np.eye(n)
    if len(linear):
        pivots = list(linear.pivots)
        moves[:, pivots] = 0.0
        moves[pivots] = -np.linalg.solve(linear.covectors[:, pivots].astype(np.float64), linear.covectors @ moves)
    return moves


def _wrap_without_rounding(problem: Problem, q: Array) -> Array:
    """Angles in (−π, π], or between the limits where they are set; rounding around zero taken off."""
    if problem.limits:
        q = into_limits(problem.robot, q)
    else:
        q = wrap_joints(problem.robot, q)
    return np.where(np.abs(q) < 1e-15, 0.0, q)


def pose_witness(robot: Robot, task: Task, family: Family, others: Sequence[Family] = ()) -> Family:
    """The family with its witness in a good posture: inside the limits, above the base, not self-folded.

    The equations are solved from round configurations inside the limits; of the members found, each checked in the
    Jacobian itself (σ ≤ 1e-9, of exactly the corank), the one with the least `fault` becomes the witness. Lost
    directions are computed there anew. Everything else stays, and so does the witness where no member is
    clearly better, or where the family has no equations.

    Args:
        robot, task: the arm.
        family: of this arm and task.
        others: all families of the arm; a member that lies on none of these of the same corank is preferred.

    Example:
        >>> from rankdrop.results.known import shipped
        >>> from rankdrop.local import fault
        >>> found = shipped("ur5")
        >>> before = found.families[0]
        >>> after = pose_witness(found.robot, found.task, before)
        >>> bool(fault(found.robot, [after.witness])[0] <= fault(found.robot, [before.witness])[0])
        True
    """
    choice = _Choice(robot, task, family, others)
    least = choice.against(choice.own[None])[0] - _WORTH
    if least < 0.0:
        return family
    members, gap = choice.members(candidates(choice.problem.robot, choice.problem.task, _CANDIDATES, 0))
    if not len(members):
        return family
    against = choice.against(members)
    best = int((against + _plainness(choice.problem.robot, members, gap)).argmin())
    if against[best] > least:
        return family
    return choice.with_witness(members, best)


def upright(robot: Robot, task: Task, family: Family, others: Sequence[Family] = ()) -> Family:
    """The family as `pose_witness` gives it, with its witness upright where a member is, not worse in any other way.

    A witness outside the joint limits is drawn only where 2,256 starts lead to no member inside them.

    Args:
        robot, task: the arm.
        family: of this arm and task.
        others: all families of the arm; a member that lies on another one of the same corank is no example.

    Returns:
        The family with its witness and the directions lost there.
    """
    family = pose_witness(robot, task, family, others)
    choice = _Choice(robot, task, family, others)
    arm, present = choice.problem.robot, choice.own[None]
    poor, outside = _poor(arm, present)[0], _count_joints_beyond_limits(arm, present)[0]
    if poor == 0.0 and not outside:
        return family
    members, gap = choice.members(candidates(arm, choice.problem.task, _CANDIDATES, 0))
    if outside and not (_count_joints_beyond_limits(arm, members) == 0).any():
        members, gap = choice.members(_random_inside_limits(choice.problem))
    better = choice.against(members) <= choice.against(present)[0] + _SLACK
    better &= (_poor(arm, members) < poor - _TALLER) | (_count_joints_beyond_limits(arm, members) < outside)
    members, gap = members[better], gap[better]
    if not len(members):
        return family
    cost = _poor(arm, members) + choice.against(members) + _plainness(arm, members, gap)
    return choice.with_witness(members, int(cost.argmin()))


def members_of(
    robot: Robot, task: Task, family: Family, count: int, held: tuple[int, float] | None = None
) -> Array:
    """Up to `count` members of a family of exactly its corank, each near a round configuration inside the limits.

    Args:
        robot, task, family: of this arm and task.
        count: of the configurations to start from.
        held: a joint, from 1, and the value at which it starts in all of them [rad, m].

    Returns:
        (M, n) lengths in metres [rad, m].
    """
    choice = _Choice(robot, task, family, ())
    starts = candidates(choice.problem.robot, choice.problem.task, count, 0)
    if held is not None:
        number, value = held
        starts = starts.copy()
        starts[:, number - 1] = value
    return choice.members(starts)[0]


def height(robot: Robot, q: Array) -> Array:
    """(N,) height of the highest point of the links over the base at configurations (N, n) [reach]."""
    return np.asarray(spine(robot, np.asarray(q))[:, :, 2].max(axis=1) / max(reach(robot), 1e-9))


def upright_start(robot: Robot, task: Task) -> Array:
    """(n,) where pictures begin: like `rankdrop.local.start_posture`, and upright where that costs nothing [rad, m]."""
    usual = start_posture(robot, task)
    if _poor(robot, usual[None])[0] == 0.0:
        return usual
    q = np.vstack([usual, candidates(robot, task, 2 * _CANDIDATES, 0)])
    rank = generic_rank(robot, task)
    sigma = singular_values(robot, q, task)[:, rank - 1] if rank else np.ones(len(q))
    turned = np.where(robot.periodic, np.abs(q) / np.pi, 0.0).mean(axis=1)
    cost = 2.0 * fault(robot, q) + _poor(robot, q) - sigma / max(float(sigma.max()), 1e-12) + 0.8 * turned
    return np.asarray(q[int(cost.argmin())])


class _Choice:
    """A family and the members that may stand for it, lengths in metres.

    Attributes:
        problem: the arm, and the corank of the family.
        own: (n,) its witness [rad, m].
    """

    def __init__(self, robot: Robot, task: Task, family: Family, others: Sequence[Family]) -> None:
        self._robot, self._family = robot, family
        self.problem = Problem(in_metres(robot), task_in_metres(task, robot), family.corank)
        self.own = np.asarray(into_metres(robot, family.witness))
        alike = (other for other in others if other.corank == family.corank and other.equations)
        rest = [other for other in alike if other.id != family.id]
        self._beside = [family_in_metres(other, robot).system for other in rest]

    def against(self, q: Array) -> Array:
        """(N,) what speaks against showing members (N, n): `fault`, and being on another family too."""
        return np.asarray(fault(self.problem.robot, q) + _SHARED * _mark_solutions(self._beside, q))

    def members(self, starts: Array) -> tuple[Array, Array]:
        """Members near starts (N, n), free joints exactly at these, turned into the limits.

        Returns:
            (M, n) members of exactly the corank, and (M,) the smallest singular value that is kept.
        """
        family, problem = self._family, self.problem
        if not family.named or not family.equations:
            return np.empty((0, problem.n)), np.empty(0)
        bound = {number - 1 for number in (*family.coupled, *(pin.number for pin in family.pinned))}
        system = family_in_metres(family, self._robot).system
        points, solved = system.solve(starts, along=np.eye(problem.n)[:, sorted(bound)])
        points = wrap_joints(problem.robot, points[solved])
        points = into_limits(problem.robot, points[problem.singular(points)])
        if problem.rank and len(points):
            gap = problem.sigma(points)[:, problem.rank - 1]
        else:
            gap = np.ones(len(points))
        return points[gap > _ROOM], gap[gap > _ROOM]

    def with_witness(self, members: Array, best: int) -> Family:
        """The family with one of its members (M, n) as the witness."""
        directions, lost = lost_motions(self.problem, members[best], members[:_POINTS])
        witness = tuple(float(x) for x in out_of_metres(self._robot, members[best]))
        return replace(self._family, witness=witness, lost_directions=directions, lost_freedoms=lost)


def _plainness(robot: Robot, q: Array, gap: Array) -> Array:
    """(N,) of members that are equally good otherwise: less for those far from other families and little turned."""
    return np.asarray(-0.3 * gap / gap.max() + 0.1 * _turned_share(robot, q))


def _mark_solutions(systems: Sequence[System], q: Array) -> Array:
    """(N,) 1 where a configuration solves one of the systems, else 0."""
    on = np.zeros(len(q))
    for system in systems:
        on[(np.abs(system.values(q)) <= DEFAULT.explained).all(axis=1)] = 1.0
    return on


def _turned_share(robot: Robot, q: Array) -> Array:
    """(N,) how far from zero the turning joints stand, as a share of half a turn, the first one twice."""
    away = np.where(robot.periodic, np.abs(q) / np.pi, 0.0)
    return np.asarray(away.sum(axis=1) + away[:, 0])


def _count_joints_beyond_limits(robot: Robot, q: Array) -> Array:
    """(N,) how many joints are beyond their limits at configurations (N, n)."""
    return np.asarray(((q < robot.lower - 1e-9) | (q > robot.upper + 1e-9)).sum(axis=1))


def _random_inside_limits(problem: Problem) -> Array:
    """(2000, n) random configurations inside the limits, a seed of their own."""
    low, high = sampling_box(problem.robot, problem.task, limits=True)
    return np.asarray(np.random.default_rng(1).uniform(low, high, (_LONGER, problem.n)))


def _poor(robot: Robot, q: Array) -> Array:
    """(N,) 0 … 2.6: how much of its height, and of its width as the reader sees it, an arm lacks at q (N, n)."""
    across = spine(robot, q) @ _ACROSS / max(reach(robot), 1e-9)
    lying = np.clip(TALL - height(robot, q), 0.0, None) / TALL
    thin = np.clip(_WIDE - np.ptp(across, axis=1), 0.0, None) / _WIDE
    return np.asarray(2.0 * lying + 0.6 * thin)
