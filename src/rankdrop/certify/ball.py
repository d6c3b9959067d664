"""A ball around a configuration that is proven free of singularities.

Two steps. One enclosure of the whole ball gives a radius at once (CERTIFY: local second derivatives and a third-order
remainder). Branch and bound then cuts the ball asked for into boxes. Of each its enclosure tells how far from the
centre it is free, as much as the ball leaves of it; the one that is free least far is cut next, until all are free or
the budget is spent. What is certified then is how far the least is free.
"""

from __future__ import annotations

import weakref
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rankdrop import _core
from rankdrop.certify.setting import Setting, settings_for
from rankdrop.errors import OptionError
from rankdrop.kinematics import chain_of, one_configuration
from rankdrop.robot.model import Array, Robot, fingerprint
from rankdrop.task import WORLD_ALIGNED, Frame, Task, resolve_task
from rankdrop.tolerances import MOST_EVALUATIONS
from rankdrop.version import VERSION

LARGEST = float(np.pi)  # no ball larger than half a turn is asked for
_SMALLEST = 1e-6  # boxes narrower than this are not divided: the singular set runs through them [rad]
_MARGIN = 1e-9  # off the radius of one enclosure, so that a checker that rounds otherwise comes to the same


@dataclass(frozen=True, eq=False)
class Certificate:
    """A ball ‖(q − q0)/scale‖ < radius in which the rank of the task Jacobian is the generic one, proven.

    Attributes:
        radius: certified [rad; slides divided by the length scale]; 0 where nothing could be proven. Variables that
            move no column against another (the first and the last turning joint, for the full pose) are free.
        single: radius from one enclosure alone, without branch and bound.
        at_most: radius asked for; `radius == at_most` means that all of it was proven.
        q: (n,) the centre [rad, m].
        task: name of the task.
        rank: the rank proven to hold.
        setting: link, point, length and reaches the bound was computed with.
        evaluations: enclosures computed.
        model: fingerprint of the arm.
        complete: False where it was interrupted; the radius holds all the same.
        version: of rankdrop.
        rows, frame: of the task.
    """

    radius: float
    single: float
    at_most: float
    q: Array
    task: str
    rank: int
    setting: Setting
    evaluations: int
    model: str
    complete: bool = True
    version: str = VERSION
    rows: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    frame: Frame = WORLD_ALIGNED


_settings: dict[tuple[int, Task], tuple[Setting, ...]] = {}


def settings_of(robot: Robot, task: Task) -> tuple[Setting, ...]:
    """Every setting worth trying for an arm and a task, made once and kept.

    Raises:
        OptionError: as `settings_for`.
    """
    key = (id(robot), task)
    if key not in _settings:
        _settings[key] = settings_for(robot, task)
        weakref.finalize(robot, _settings.pop, key, None)
    return _settings[key]


_looks: dict[tuple[int, Task], tuple[tuple[_core.View, _core.EnclosureSettings], ...]] = {}


def _singles(robot: Robot, task: Task, row: Array) -> list[float]:
    """The radius of one enclosure of each setting around one configuration (1, n); what the core is told is kept."""
    key = (id(robot), task)
    if key not in _looks:
        _looks[key] = tuple((one.view(robot), one.told(LARGEST)) for one in settings_of(robot, task))
        weakref.finalize(robot, _looks.pop, key, None)
    chain = chain_of(robot)
    return [float(_core.enclose(chain, view, row, None, told, threads=1)[1][0]) for view, told in _looks[key]]


def check_budget(evaluations: int) -> None:
    """Refuse what is no number of enclosures.

    Raises:
        OptionError: no whole number, or outside what is allowed.
    """
    whole = isinstance(evaluations, int | np.integer) and not isinstance(evaluations, bool)
    if not whole or not 0 <= evaluations <= MOST_EVALUATIONS:
        raise OptionError(
            "no such budget", where="evaluations", got=evaluations, allowed=f"a whole number, 0 … {MOST_EVALUATIONS}"
        )


def certified_radius(
    robot: Robot,
    q: ArrayLike,
    task: str | Task | None = None,
    *,
    at_most: float = LARGEST,
    enough: float = np.inf,
    evaluations: int = 20_000,
) -> Certificate:
    """A radius around q within which no configuration is singular: a proof up to the rounding allowance it states.

    U₁ᵀ J(q + δ) V₁ = Σ + E with |E_ij| ≤ Σ_k |g_ijk| |δ_k| + ½ Σ_kl |H_ijkl| |δ_k| |δ_l| + T_j, g and H exact at the
    centre of the box, T_j = ⅙ Σ_i |v_ij| (M_i t³ + 3 t² s), t and s the sums of |δ_k| over the turning joints and of
    |δ_k|/ℓ over the slides between joint i and the link, M_i = √(1 + (reach_i/ℓ)²) a bound on every derivative of
    column i by turns. Where a ball of radius ρ around q cuts the box, whose centre is c off, Σ g_ijk δ_k lies between
    −|g_ij| ρ − g_ij·c and |g_ij| ρ − g_ij·c as well, and the narrower of the two counts. Where the matrix
    Σ_ii − |E_ii|, −|E_ij| is an M-matrix, Σ + E is regular. Floating-point error is allowed for by 1e-12 · Σ M_i in
    every entry. Limits of the joints play no part.

    Args:
        robot: the arm.
        q: (n,) centre [rad, m].
        task: pose, position, orientation; other rows only where the arm moves no others.
        at_most: no larger radius is sought, e.g. the distance of a singularity that is known; in (0, π].
        enough: branch and bound ends once this radius is proven.
        evaluations: budget of branch and bound; 0: one enclosure only. About 2 µs each.

    Raises:
        ConfigurationError: q is not one configuration of this arm.
        OptionError: at_most or evaluations outside what is allowed, or a task that cannot be certified.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> arm = open_robot("planar3r")
        >>> round(certified_radius(arm, [0.3, 1.2, 0.4]).radius, 3)  # sin θ2 = 0 is 1.2 rad away
        1.2
    """
    centre = one_configuration(robot, q)
    if not 0.0 < at_most <= LARGEST:
        raise OptionError("no such radius", where="at_most", got=at_most, allowed="in (0, π]")
    check_budget(evaluations)
    resolved = resolve_task(task, robot)
    settings = settings_of(robot, resolved)
    singles = _singles(robot, resolved, centre[None, :])
    best = int(np.argmax(singles))
    setting, single = settings[best], min(singles[best], at_most)
    if single < at_most:
        single *= 1.0 - _MARGIN
    radius, used, complete = single, len(settings), True
    if evaluations and single < min(at_most, enough):
        smallest = min(_SMALLEST, single / 8) if single > 0.0 else _SMALLEST  # a small ball needs boxes smaller still
        radius, count, stopped, _, _ = _core.ball(
            chain_of(robot), setting.view(robot), centre, setting.matters, setting.told(at_most),
            inner=single, enough=float(enough), smallest=smallest, budget=int(evaluations), keep=False,
        )  # fmt: skip
        used, complete = used + count, not stopped
    return Certificate(
        float(radius), single, at_most, centre, resolved.name, setting.rank, setting, used, fingerprint(robot),
        complete, rows=resolved.rows, frame=resolved.frame,
    )  # fmt: skip
