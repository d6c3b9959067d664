"""Derive the exact conditions of an arm that has been analysed, and hold them against the families found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi, remainder

from rankdrop.atlas.family import Family, Pinned
from rankdrop.conditions import conditions
from rankdrop.derived.conditions import Conditions
from rankdrop.errors import OptionError, RankdropError
from rankdrop.exact.family import ExactFamily
from rankdrop.exact.match import match
from rankdrop.exact.writing.pins import RADIANS
from rankdrop.joined import AGREES, ASKED, DIFFERS, NOT_DERIVED, ExactRow, Joined
from rankdrop.known_conditions import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, task_in_units

SECONDS: Mapping[str, float] = {"auto": 30.0, "on": 120.0}
"""Time limits by the clock, three times those on work: most arms of the catalogue need 0.02 to 4 s."""


def check_exact(exact: str) -> None:
    """Refuse what cannot be asked for.

    Raises:
        OptionError: neither auto, on nor off.
    """
    if exact not in ASKED:
        raise OptionError("there is no such choice", where="exact", got=repr(exact), allowed=", ".join(ASKED))


def join(
    robot: Robot,
    task: Task,
    generic_rank: int,
    rows: Sequence[Family],
    *,
    exact: str = "auto",
    limits: bool = False,
    seed: int = 0,
    fresh: bool = False,
    progress: Callable[[str, int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Joined | None:
    """Derive the families of every corank by the rank tree, and match them with those found numerically.

    The families of the catalogue's arms are shipped, and then taken from there.

    Args:
        robot, task, generic_rank: of the analysis.
        rows: its families, of every corank that there is, in the arm's own unit of length (`family_in_units`).
        exact: "auto", where python-flint is installed, the arm can be treated, and time allows; "on", required; "off".
        limits: the rows are those within the joint limits.
        seed: of every random choice.
        fresh: derive them even where the conditions of this arm are shipped; those have the same families.
        progress: called as progress(label, done, total).
        tolerances: of the analysis.

    Returns:
        Joined, or None for "off". A derivation that was not finished leaves no families behind.

    Raises:
        OptionError: no such choice.
        MissingExtraError, RobotError: with "on", python-flint is not installed, or the arm cannot be treated.
    """
    check_exact(exact)
    if exact == "off":
        return None
    seconds = SECONDS[exact]
    try:
        shipped = None if fresh or seed else known_conditions(robot, task)
        derived = shipped or conditions(
            robot, task, method="tree", seconds=seconds, seed=seed, points=0, special=False, progress=progress
        )
    except RankdropError as error:
        if exact == "on":
            raise
        return Joined(NOT_DERIVED, exact, seconds, str(error))
    except KeyboardInterrupt:
        return Joined(NOT_DERIVED, exact, seconds, "interrupted")
    if not derived.complete:
        out_of_time = derived.seconds >= seconds
        reason = f"the derivation takes more than {seconds:g} s" if out_of_time else "; ".join(derived.left)
        return Joined(NOT_DERIVED, exact, seconds, reason)
    agreement = match(
        in_units(robot), task_in_units(task, robot), generic_rank, rows,
        [family.in_units(derived.chain) for family in derived.families], limits=limits, seed=seed,
        tolerances=tolerances,
    )
    disagreements = (*_ranks(derived, generic_rank), *agreement.disagreements)
    return Joined(
        status=DIFFERS if disagreements else AGREES,
        asked=exact,
        seconds=seconds,
        letters=dict(derived.letters),
        shifts=derived.shifts,
        families=tuple(_row(family, robot) for family in derived.families),
        matches=agreement.matches,
        numeric=agreement.numeric,
        exact=agreement.exact,
        disagreements=disagreements,
        wider=agreement.wider,
    )


def _ranks(derived: Conditions, generic_rank: int) -> list[str]:
    """What ranks modulo a prime say against the derivation, or σ at random configurations."""
    said = list(derived.disagreements)
    if derived.generic_rank != generic_rank:
        said.append(f"the rank is {derived.generic_rank} almost everywhere exactly, {generic_rank} numerically")
    return said


def _row(family: ExactFamily, robot: Robot) -> ExactRow:
    pinned = tuple(
        Pinned(robot.variables[joint - 1].name, joint, tuple(_angle(v, family.shifts[joint - 1]) for v in values))
        for joint, values in family.pins
    )
    return ExactRow(
        id=family.id,
        name=family.name,
        corank=family.corank,
        dimension=family.dimension,
        pinned=pinned,
        conditions=family.texts,
        latex=family.latex,
        reality=family.reality,
    )


def _angle(value: str, shift: float) -> float:
    """q in (−π, π] for a simple angle θ = q + shift."""
    angle = remainder(RADIANS[value] - shift, 2 * pi)
    return pi if angle <= -pi else angle
