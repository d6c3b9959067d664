"""Derive the exact conditions of an arm that has been analysed, and hold them against the families found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from rankdrop.compare.joined import AGREES, ASKED, DIFFERS, INTERRUPTED, NOT_DERIVED, ExactRow, Joined
from rankdrop.compare.match import Match, match
from rankdrop.compare.partition import in_exact_terms
from rankdrop.errors import OptionError, RankdropError
from rankdrop.exact.family import ExactFamily
from rankdrop.families.sampling import Setting
from rankdrop.family.record import CorankFamilies
from rankdrop.results.conditions.conditions import Conditions
from rankdrop.results.conditions.known import known_conditions
from rankdrop.robot.model import Robot
from rankdrop.task import Task
from rankdrop.tolerances import DEFAULT, Tolerances
from rankdrop.units import in_units, task_in_units
from rankdrop.verbs.conditions import conditions

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
    found: Sequence[CorankFamilies],
    *,
    exact: str = "auto",
    limits: bool = False,
    seed: int = 0,
    fresh: bool = False,
    progress: Callable[[str, int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> tuple[list[CorankFamilies], Joined | None]:
    """Derive the families of every corank by the rank tree, and match them with those found numerically.

    Rows that go together with exact families take their partition, ids and names (`partition`). The families of the
    catalogue's arms are shipped, and then taken from there.

    Args:
        robot, task, generic_rank: of the analysis.
        found: its families, of every corank that there is, of `in_units(robot)`.
        exact: "auto", where python-flint is installed, the arm can be treated, and time allows; "on", required; "off".
        limits: the families are those within the joint limits.
        seed: of every random choice.
        fresh: derive them even where the conditions of this arm are shipped; those have the same families.
        progress: called as progress(label, done, total).
        tolerances: of the analysis.

    Returns:
        The families of every corank, and Joined, or None for "off". A derivation that was not finished leaves no
        families behind.

    Raises:
        OptionError: no such choice.
        MissingExtraError, RobotError: with "on", python-flint is not installed, or the arm cannot be treated.
    """
    check_exact(exact)
    rows = tuple(row for one in found for row in one.families)
    if exact == "off":
        return list(found), None
    seconds = SECONDS[exact]
    try:
        shipped = None if fresh or seed else known_conditions(robot, task)
        derived = shipped or conditions(
            robot, task, method="tree", seconds=seconds, seed=seed, points=0, special=False, progress=progress
        )
    except RankdropError as error:
        if exact == "on":
            raise
        return list(found), Joined(NOT_DERIVED, exact, seconds, str(error))
    except KeyboardInterrupt:
        return list(found), Joined(NOT_DERIVED, exact, seconds, INTERRUPTED)
    if not derived.complete:
        out_of_time = derived.seconds >= seconds
        reason = f"the derivation takes more than {seconds:g} s" if out_of_time else "; ".join(derived.left)
        return list(found), Joined(NOT_DERIVED, exact, seconds, reason)
    own, own_task = in_units(robot), task_in_units(task, robot)
    families = [family.in_units(derived.chain) for family in derived.families]
    agreement = match(own, own_task, generic_rank, rows, families, limits=limits, seed=seed, tolerances=tolerances)
    parted: list[CorankFamilies] = []
    matches: list[Match] = []
    now: dict[str, str] = {}
    for one in found:
        corank = one.summary.corank
        setting = Setting(own, own_task, corank, generic_rank - corank, tolerances, limits)
        exactly = [family for family in families if family.corank == corank]
        here, there, called = in_exact_terms(setting, one, exactly, agreement, seed)
        parted.append(here)
        matches += there
        now |= called
    differences = [
        str(replace(one, family=now[one.family]) if one.side == "numeric" else one) for one in agreement.differences
    ]
    disagreements = (*_ranks(derived, generic_rank), *differences)
    return parted, Joined(
        status=DIFFERS if disagreements else AGREES,
        asked=exact,
        seconds=seconds,
        letters=dict(derived.letters),
        shifts=derived.shifts,
        families=tuple(_row(family, robot) for family in derived.families),
        matches=tuple(matches),
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
    return ExactRow(
        id=family.id,
        name=family.name,
        corank=family.corank,
        dimension=family.dimension,
        pinned=family.pinned(robot),
        conditions=family.texts,
        latex=family.latex,
        reality=family.reality,
    )
