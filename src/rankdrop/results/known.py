"""What comes with the package: the arms of the catalogue need not be analysed again, nor their conditions derived.

An arm is recognised by its geometry (joint kinds, screws at q = 0, home pose), not by its name: the same arm read from
a URDF or a table of parameters is known too. Limits and names play no part: the families are those of the whole torus.

Exact conditions answer one question, that of `rankdrop conditions NAME` without options. What is asked about has to be
the same arm: screws, link frames (in which lost motions are told) and home pose, letters for lengths, and the same
task.

`known/ARM.jsonl` has two lines, and who asks for one reads no other: the analysis of an arm as docs/json.md has it, and
its conditions, null where they are not completely derived.

Conditions are the record of docs/json.md, and the polynomials beside it: what JSON says in words is kept in words, and
the polynomials from which those words were made are kept too, each as its terms. Read back, a derivation prints,
writes LaTeX, code and JSON as it did before. It no longer has the irreducible sets that its families were merged from:
`Conditions.test` derives them anew.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from fractions import Fraction
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from rankdrop.algebra.polynomial import Polynomial, flint, root_values, with_inner
from rankdrop.algebra.ring import Ring
from rankdrop.codec import Record, plain, restored
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.exact.arm.chain import ring_of
from rankdrop.exact.family import EVIDENCE, Assumption, UnrealSet, pins_in_q, slides_at_zero
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.remark import DerivationRemark
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.lost import LostFreedom, freedoms_at_witness
from rankdrop.families.record import Check, ExactConditions, Family, WrittenCondition, exact_of, family_from_metres
from rankdrop.formula.equation import Equation
from rankdrop.formula.notation import Step
from rankdrop.formula.writing import AnglePin, Condition
from rankdrop.lists import flat_map
from rankdrop.local.directions import lost_directions
from rankdrop.questions import ConditionsOptions
from rankdrop.results.aspect_summary import FILE as ASPECTS
from rankdrop.results.aspect_summary import AspectSummary
from rankdrop.results.conditions import SCHEMA, Conditions
from rankdrop.results.names import name_of
from rankdrop.results.old_files import freedoms_of_sentences
from rankdrop.results.old_sentences import contradictions_of_sentences, remarks_of_sentences
from rankdrop.robot.model import Robot, coarse_fingerprint, geometry
from rankdrop.robot.open import open_robot
from rankdrop.sections import words_of
from rankdrop.task import Frame, Task, resolve_task
from rankdrop.tolerances import Tolerances
from rankdrop.units import in_metres, metre_exponent, shifted
from rankdrop.version import VERSION

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

    from rankdrop.results.analysis import Analysis


STARTS = 10_000
"""Random starts for each corank of the atlases that are shipped."""
SEED = 0
"""Their seed."""
ANSWERS = 3
"""Number of what is answered: whoever changes what `analyze` or `conditions` find, or how they say it, raises it by
one, and every file that is shipped is stale. A release alone changes no answer."""
FOLDER = "known"
"""Folder of the files of the catalogue's arms."""
ANALYSIS, CONDITIONS = 0, 1
"""Lines of such a file."""
INDEX = "index.json"
"""File beside them: coarse fingerprint, with the tip and without -> names of the arms that have it."""
_names: WeakKeyDictionary[Robot, dict[tuple[tuple[int, ...], Frame, bool], str | None]] = WeakKeyDictionary()
"""Of arms met so far: the name that their analysis is shipped under, by rows, frame, and whether any tip will do."""
_SAME = 1e-12  # geometry that agrees to this is the same arm: σ ≤ 1e-9 holds for both


def known_analysis(robot: Robot, task: Task, *, any_tip: bool = False) -> Analysis | None:
    """The shipped analysis of an arm with this geometry and task, or None.

    The rows of the task have to be the same; unless the task has all six, so do its axes and its reference point. The
    analysis returned is of `robot` itself, with its names. Its task may be seen in another frame than `task` (the one
    its lost directions are written in), and its length scale is its own: neither changes a family of the full pose.

    Args:
        robot: any arm.
        task: from `resolve_task`.
        any_tip: an arm that differs in its end effector only is known too where the task has all six rows: a tool
            neither makes nor removes a singularity. Motions lost are told at the arm's own tip.

    Returns:
        The analysis, read once and then kept.

    Raises:
        ResultFileError: a shipped file is damaged.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("pa10")
        >>> len(known_analysis(arm, resolve_task(None, arm)).families)
        9
    """
    name = known_name(robot, task, any_tip=any_tip)
    if name is None:
        return None
    there = in_metres(robot)
    named = replace(_named_after(shipped(name), there), aspects=catalogue_aspects().get(name))
    if there is robot:
        return named
    return _out_of_metres(named, robot)


_families: WeakKeyDictionary[Robot, dict[str, tuple[Family, ...]]] = WeakKeyDictionary()
"""Of arms met so far: their shipped families, by the name of the catalogue; none refers to the arm."""


def shipped_families(robot: Robot, task: Task, *, any_tip: bool = False) -> tuple[Family, ...] | None:
    """The families of `known_analysis`, made once for each arm; None for an arm that is not known."""
    name = known_name(robot, task, any_tip=any_tip)
    if name is None:
        return None
    kept = _families.setdefault(robot, {})
    if name not in kept:
        known = known_analysis(robot, task, any_tip=any_tip)
        kept[name] = () if known is None else known.families
    return kept[name]


def known_families(
    robot: Robot, task: Task, analysis: Analysis | None, tolerances: Tolerances
) -> tuple[tuple[Family, ...], str]:
    """Known families and where they come from: the analysis given, else the atlas that is shipped, else nowhere.

    Raises:
        OptionError: the analysis is about another arm or other rows.
    """
    if analysis is None:
        known = shipped_families(robot, task, any_tip=True)
        if known is None:
            return ((), "on the spot")
        return (known, "catalogue")
    from rankdrop.results.analysis import Analysis  # who asks for conditions alone does without

    if not isinstance(analysis, Analysis):
        raise OptionError("an analysis is needed", got=repr(analysis)[:80], allowed="an Analysis, or None")
    mine, other = (geometry(one, tip=task.m < 6) for one in (robot, analysis.robot))
    if mine.shape != other.shape or np.abs(mine - other).max() > tolerances.value:
        raise OptionError("the analysis is about another arm", got=analysis.robot.name, allowed=robot.name)
    if analysis.task.rows != task.rows or analysis.task.frame != task.frame:
        raise OptionError("the analysis is about another task", got=analysis.task.name, allowed=task.name)
    return analysis.families, "analysis"


def known_name(robot: Robot, task: Task, *, any_tip: bool = False) -> str | None:
    """The name in the catalogue of an arm with this geometry and task, or None.

    Args:
        robot: any arm.
        task: from `resolve_task`.
        any_tip: as in `known_analysis`.
    """
    names = _names.setdefault(robot, {})
    key = (task.rows, task.frame, any_tip)
    if key not in names:
        names[key] = _known_name(in_metres(robot), task, any_tip=any_tip)
    return names[key]


def known_aspects(robot: Robot, task: Task) -> AspectSummary | None:
    """The stored number of aspects of an arm with this geometry and task, or None; joint limits play no part.

    An arm that differs from an arm of the catalogue in its end effector only is known where the task has all six rows:
    a tool neither makes nor removes a singularity.

    Args:
        robot: any arm.
        task: from `resolve_task`.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("ur5e")
        >>> known_aspects(arm, resolve_task(None, arm)).number
        8
    """
    there, tip = in_metres(robot), task.m < 6
    mine = geometry(there, tip=tip)
    for name in candidates(there, tip=tip):
        arm = open_robot(name)
        own = resolve_task(None, arm)
        same_task = own.rows == task.rows and (task.m == 6 or own.frame == task.frame)
        if same_task and np.abs(geometry(in_metres(arm), tip=tip) - mine).max() <= _SAME:
            return catalogue_aspects().get(name)
    return None


@cache
def catalogue_aspects() -> dict[str, AspectSummary]:
    """Name of an arm of the catalogue -> its number of aspects, for the task that the arm is made for."""
    return {name: AspectSummary(**entry) for name, entry in (_file("aspects", ASPECTS) or {}).items()}


def _known_name(robot: Robot, task: Task, *, any_tip: bool) -> str | None:
    for tip in (True, False)[: 1 + (any_tip and task.m == 6)]:
        mine = geometry(robot, tip=tip)
        for name in candidates(robot, tip=tip):
            found = shipped(name)
            if np.abs(geometry(found.robot, tip=tip) - mine).max() <= _SAME and (
                found.task.rows == task.rows and (task.m == 6 or found.task.frame == task.frame)
            ):
                return name
    return None


def _out_of_metres(analysis: Analysis, robot: Robot) -> Analysis:
    power = metre_exponent(robot)
    length = shifted(analysis.settings.length_scale, power)
    return replace(
        analysis, robot=robot, families=tuple(family_from_metres(family, robot, power) for family in analysis.families),
        task=replace(analysis.task, length_scale=length), settings=replace(analysis.settings, length_scale=length),
    )  # fmt: skip


def candidates(robot: Robot, *, tip: bool = True) -> tuple[str, ...]:
    """Names of the arms with a shipped analysis that may be this one: their coarse fingerprint is the same.

    Without the `tip`: this one but for its end effector.

    Makers build one geometry under several names: the robot's own name comes first.
    """
    found = _index().get(coarse_fingerprint(robot, tip=tip), ())
    return tuple(sorted(found, key=lambda name: (name != robot.name, name)))


def known_names() -> tuple[str, ...]:
    """Names of the arms that have a shipped analysis, sorted."""
    return tuple(sorted(set(flat_map(list, _index().values()))))


@cache
def shipped(name: str) -> Analysis:
    """The analysis that is shipped for one arm of the catalogue.

    Raises:
        ResultFileError: there is none, or it is damaged.
    """
    from rankdrop.results.analysis import Analysis  # who asks for conditions alone does without

    if name not in known_names():
        allowed = ", ".join(known_names())
        raise ResultFileError("there is no shipped analysis of this arm", got=repr(name), allowed=allowed)
    found = Analysis.from_dict(shipped_record(name), believe=True)  # tests/known/test_atlases.py does not
    return replace(found, settings=replace(found.settings, version=VERSION))  # which ships it, and answers the same


def shipped_record(name: str) -> Record:
    """The analysis of one arm of the catalogue as its file has it; its `answers` tell which code made it."""
    record: Record = part_of_file(_shipped_file(name), ANALYSIS)
    return record


def _named_after(analysis: Analysis, robot: Robot) -> Analysis:
    """The analysis with `robot` for its arm: pinned joints under its names, lost motions in its own link frames."""
    names = [joint.name for joint in robot.variables]
    families = analysis.families
    if names != [joint.name for joint in analysis.robot.variables]:
        families = tuple(
            replace(family, pinned=tuple(replace(one, joint=names[one.number - 1]) for one in family.pinned))
            for family in families
        )  # fmt: skip
    pairs = zip(robot.joints, analysis.robot.joints, strict=True)
    moved = np.abs(robot.home - analysis.robot.home).max() > _SAME
    if moved or any(np.abs(mine.frame - other.frame).max() > _SAME for mine, other in pairs):
        families = tuple(_lost_in_these_frames(family, robot, analysis.task) for family in families)
    return replace(analysis, robot=robot, families=families)


def _lost_in_these_frames(family: Family, robot: Robot, task: Task) -> Family:
    """The family with its lost motions for other link frames than those of the file."""
    at = np.array(family.witness)
    return replace(
        family, lost_freedoms=freedoms_at_witness(robot, at, task, family.corank),
        lost_directions=lost_directions(robot, at, task, family.corank),
    )  # fmt: skip


@cache
def _index() -> dict[str, list[str]]:
    record: dict[str, list[str]] = _file(FOLDER, INDEX)
    return record


def _file(folder: str, name: str) -> Any:
    """The data of a shipped file; None where there is none."""
    path = resources.files("rankdrop") / folder / name
    if path.is_file():
        return json.loads(path.read_text(encoding="utf-8"))
    return None


def _shipped_file(name: str) -> Traversable:
    return resources.files("rankdrop") / FOLDER / f"{name}.jsonl"


def part_of_file(path: Traversable, line: int) -> Any:
    """One line of the file of an arm, `ANALYSIS` or `CONDITIONS`; None where there is no file, or nothing in it."""
    if not path.is_file():
        return None
    with path.open("rb") as stream:
        for _ in range(line):
            stream.readline()
        return json.loads(stream.readline())


def file_text(analysis: Record | None, conditions: Record | None) -> str:
    """The file of an arm: what `part_of_file` reads, in its order."""
    lines = [
        json.dumps(one, ensure_ascii=False, allow_nan=False, separators=(",", ":")) for one in (analysis, conditions)
    ]
    return "\n".join(lines) + "\n"


_AGAIN = ("robot", "equations", "lost_words", "determinants", "not_real", "undivided", "reason", "remarks",
          "disagreements", "left")  # fmt: skip
"""Entries of the record that are made again: from the robot asked about, from `terms`, `lost_freedoms`, `unreal`,
`why`, `noted`; determinants belong to steps, which are not stored, and a complete derivation that nothing contradicts
has no undivided cases, nothing left and no disagreements."""


def to_stored(conditions: Conditions) -> Record:
    """A complete derivation as plain data: `from_stored` is its inverse, given the same arm.

    Raises:
        ResultFileError: a derivation that is not complete, or that a check contradicts; nothing of it can be vouched
            for later. Or one in parts of joint angles, for which the record has no place.
    """
    _refuse_unfit(conditions)
    record = {key: value for key, value in conditions.to_dict().items() if key not in _AGAIN}
    record["answers"] = ANSWERS
    record["arm"] = _arm(conditions.robot) | {"task": _task(conditions.task)}
    record["generic_rank"] = conditions.generic_rank
    record["why"] = asdict(conditions.reason)
    record["noted"] = [_facts(remark) for remark in conditions.remarks]
    record["families"] = [
        {key: value for key, value in written.items() if key not in _AGAIN}
        | {"pins": [[pin.joint, list(pin.values)] for pin in exact.pins]}
        | {"polynomials": [_terms(one.polynomial) for one in exact.polynomials]}
        for written, exact in zip(record["families"], map(exact_of, conditions.families), strict=True)
    ]
    return record


def _refuse_unfit(conditions: Conditions) -> None:
    """An error that says why a derivation cannot be stored; nothing where it can."""
    if conditions.robot.turns.max() > 1:
        raise ResultFileError(
            "conditions in parts of joint angles are not stored", where=conditions.robot.name,
            mend="derive them anew",
        )  # fmt: skip
    if conditions.disagreements:
        raise ResultFileError(
            "a derivation that is contradicted is not stored", where=conditions.robot.name,
            got=str(conditions.disagreements[0]),
        )  # fmt: skip
    if not conditions.in_families or conditions.interrupted:
        raise ResultFileError(
            "only a complete derivation is stored", where=conditions.robot.name,
            got=words_of(conditions).unfinished_text(conditions),
        )  # fmt: skip


def is_of(record: Record, robot: Robot, task: Task, *, any_tip: bool = False) -> bool:
    """Whether a stored derivation is that of this arm and task: kinds, screws, frames and home pose, letters, rows.

    With `any_tip` frames and home pose may be others where the task has all six rows: conditions do not depend on them,
    sentences on lost motions do.
    """
    mine, own = _arm(robot), record["arm"]
    exact = all(mine[key] == own[key] for key in ("kinds", "lengths")) and _task(task) == own["task"]
    keys = ("screws",) if any_tip and task.m == 6 else ("screws", "frames", "home")
    return exact and all(np.abs(np.array(mine[key]) - own[key]).max() <= _SAME for key in keys)


def _arm(robot: Robot) -> Record:
    return {
        "kinds": [str(joint.kind) for joint in robot.joints],
        "lengths": dict(robot.lengths),
        "screws": [joint.screw.tolist() for joint in robot.joints],
        "frames": [joint.frame[:3].tolist() for joint in robot.joints],
        "home": robot.home.tolist(),
    }


def _task(task: Task) -> Record:
    frame = task.frame
    return {"name": task.name, "rows": list(task.rows), "axes": frame.axes, "origin": frame.origin,
            "point": list(frame.point)}  # fmt: skip


def from_stored(
    record: Record, robot: Robot, task: Task, *, anew: Callable[[], Conditions] | None = None
) -> Conditions:
    """The derivation of a record made by `to_stored`.

    Args:
        record: as it was stored.
        robot, task: the arm asked about: the same joints, lengths and frames as those it was derived for.
        anew: derives it once more, for what the record does not hold.

    Raises:
        ResultFileError: another schema, or entries that are missing or make no sense.
    """
    if record.get("schema") != SCHEMA:
        raise ResultFileError("these are not conditions that can be read", got=repr(record.get("schema")),
                              allowed=SCHEMA)  # fmt: skip
    try:
        return _read(record, robot, task, anew)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        if isinstance(error, KeyError):
            what = f"no entry {error}"
        else:
            what = str(error)
        raise ResultFileError("the stored conditions are damaged", where=robot.name, got=what) from error


def _read(record: Record, robot: Robot, task: Task, anew: Callable[[], Conditions] | None) -> Conditions:
    used: set[str] = set()
    for family in record["families"]:
        for polynomial in family["polynomials"]:
            for powers, _ in polynomial:
                used.update(powers[::2])
    roots = with_inner(used)
    ring = cache(lambda: ring_of(robot, (*record["letters"], *roots)))  # made for the first polynomial
    return Conditions(
        robot=robot,
        task=task,
        generic_rank=record["generic_rank"],
        letters=dict(record["letters"]),
        shifts=tuple(record["shifts"]),
        remarks=_remarks(record),
        method=record["method"],
        reason=restored(MethodReason, record["why"]),
        steps=restored(tuple[Step, ...], record["steps"]),
        families=tuple(_family(one, ring, record, root_values(roots), robot, task) for one in record["families"]),
        lowest=record["lowest"],
        assumptions=restored(tuple[Assumption, ...], record["assumptions"]),
        not_real=restored(tuple[UnrealSet, ...], record["unreal"]),
        explained=Check(record["explained"]["tested"], record["explained"]["explained"]),
        disagreements=_contradictions(record),
        complete=record["complete"],
        interrupted=record["interrupted"],
        left=(),  # of a complete derivation
        seconds=0.0,
        settings=restored(ConditionsOptions, record["settings"]),
        anew=anew,
    )


def _facts(remark: DerivationRemark) -> Record:
    """The fields of a remark that do not have their defaults, as plain data."""
    defaults = DerivationRemark(remark.kind)
    record: Record = plain(remark)
    given = [name for name in record if getattr(remark, name) != getattr(defaults, name)]
    return {name: record[name] for name in ("kind", *given)}


def _contradictions(record: Record) -> tuple[Contradiction, ...]:
    """What contradicts a stored derivation: nothing, but in files up to version 0.2, which have sentences."""
    if not record.get("disagreements"):
        return ()
    return contradictions_of_sentences(record["disagreements"])


def _remarks(record: Record) -> tuple[DerivationRemark, ...]:
    """The remarks of a stored derivation; up to version 0.2 they were sentences."""
    if "noted" in record:
        remarks: tuple[DerivationRemark, ...] = restored(tuple[DerivationRemark, ...], record["noted"])
        return remarks
    return remarks_of_sentences(record["remarks"])


def _freedoms(record: Record, robot: Robot, task: Task) -> tuple[LostFreedom, ...]:
    if "lost_freedoms" in record:
        freedoms: tuple[LostFreedom, ...] = restored(tuple[LostFreedom, ...], record["lost_freedoms"])
        return freedoms
    return freedoms_of_sentences(record["lost_words"], robot, task, record["corank"], record["witness"])


def _family(
    record: Record, ring: Callable[[], Ring], whole: Record, roots: Mapping[str, float], robot: Robot, task: Task
) -> Family:
    """A family with what was written of it: it need not be put shortly once more, which takes the longest."""
    pins = tuple(AnglePin(joint, tuple(values)) for joint, values in record["pins"])
    polynomials = tuple(Condition(ring(), _polynomial(ring(), terms)) for terms in record["polynomials"])
    shifts = tuple(whole["shifts"])
    pinned = pins_in_q(robot, pins, shifts)
    exact = ExactConditions(
        pinned=(*pinned, *slides_at_zero(robot, polynomials)),
        stated=(*pins, *polynomials),
        reality=record["reality"],
        rank_check=restored(Check, record["rank_check"]),
        numbers={**whole["letters"], **roots},
        shifts=shifts,
        written=tuple(map(WrittenCondition, record["conditions"], record["latex"])),
    )
    return Family(
        id=record["id"],
        called=name_of(record),
        corank=record["corank"],
        dimension=record["dimension"],
        pinned=pinned,
        free=tuple(record["free"]),
        coupled=tuple(record["coupled"]),
        equations=tuple(Equation.from_dict({"terms": terms}) for terms in record["terms"]),
        witness=tuple(record["witness"]),
        lost_directions=np.empty((0, 6)),
        lost_freedoms=_freedoms(record, robot, task),
        evidence=EVIDENCE,
        exact=exact,
    )


def _terms(f: Polynomial) -> list[list[Any]]:
    """[[variable, power, …], coefficient] per term, coefficients as whole numbers or "p/q"."""
    names = f.context().names()
    found = []
    for exponents, value in f.terms():
        powers: list[Any] = []
        for name, power in zip(names, exponents, strict=True):
            if power:
                powers += [name, int(power)]
        number = Fraction(int(value.p), int(value.q))
        found.append([powers, str(number)])
    return found


def _polynomial(ring: Ring, terms: Sequence[Sequence[Any]]) -> Polynomial:
    module, found = flint(), {}
    for powers, value in terms:
        exponents = [0] * len(ring.names)
        for name, power in zip(powers[::2], powers[1::2], strict=True):
            exponents[ring.index[name]] = power
        number = Fraction(value)
        found[tuple(exponents)] = module.fmpq(number.numerator, number.denominator)
    return ring.half.from_dict(found)


def shipped_conditions_record(robot: Robot, task: Task, *, any_tip: bool = False) -> Record | None:
    """The shipped conditions of this arm and task as they stand in their file, or None; see `known_conditions`."""
    for name in candidates(robot, tip=not any_tip or task.m < 6):
        record = _record(name)
        if record is not None and record.get("answers") == ANSWERS and is_of(record, robot, task, any_tip=any_tip):
            return record
    return None


def known_conditions(
    robot: Robot, task: str | Task | None = None, *, anew: Callable[[], Conditions] | None = None,
    any_tip: bool = False,
) -> Conditions | None:  # fmt: skip
    """The shipped conditions of this arm, or None: another arm or task, or made by code with other `ANSWERS`.

    Args:
        robot: any arm.
        task: as in `resolve_task`; the length scale plays no part.
        anew: derives them once more, for `Conditions.test`.
        any_tip: an arm that differs in its tool and in its link frames only is known too where the task has all six
            rows; sentences on lost motions are then those of the shipped arm, for callers that make their own.

    Returns:
        Conditions of `robot` itself, with its names; equal in all else to what a derivation gives.

    Raises:
        MissingExtraError: python-flint is not installed.
        ResultFileError: a shipped file is damaged.

    Example:
        >>> found = known_conditions(open_robot("pa10"), "position")
        >>> found is None  # shipped are those of the task that the arm is made for
        True
    """
    resolved = resolve_task(task, robot)
    record = shipped_conditions_record(robot, resolved, any_tip=any_tip)
    if record is None:
        return None
    return from_stored(record, robot, resolved, anew=anew)


def shipped_conditions(name: str) -> Conditions:
    """The conditions that are shipped for one arm of the catalogue, whatever code made them.

    Raises:
        MissingExtraError: python-flint is not installed.
        ResultFileError: there are none, or the file is damaged.
    """
    record = _record(name)
    if record is None:
        allowed = ", ".join(conditions_names())
        raise ResultFileError("no conditions of this arm are shipped", got=repr(name), allowed=allowed)
    robot = open_robot(name)
    return from_stored(record, robot, resolve_task(None, robot))


@cache
def conditions_names() -> tuple[str, ...]:
    """Names of the arms whose conditions are shipped, sorted."""
    return tuple(name for name in known_names() if _has_conditions(_shipped_file(name)))


def _has_conditions(path: Traversable) -> bool:
    """Whether the second line of a file is not null; it is not read to its end."""
    with path.open("rb") as stream:
        stream.readline()
        return stream.read(4) != b"null"


@cache
def _record(name: str) -> Record | None:
    record: Record | None = part_of_file(_shipped_file(name), CONDITIONS)
    return record
