"""Exact conditions that come with the package: those of the catalogue's arms need not be derived again.

They answer one question, that of `rankdrop conditions NAME` without options. What is asked about has to be the same
arm: screws, link frames (in which lost motions are told) and home pose, letters for lengths, and the same task.

Exact conditions as a file holds them, and back: the record of docs/json.md, and the polynomials beside it.

What JSON says in words is kept in words, and the polynomials from which those words were made are kept too, each as its
terms. Read back, a derivation prints, writes LaTeX, code and JSON as it did before. It no longer has the irreducible
sets that its families were merged from: `Conditions.test` derives them anew.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Any

import numpy as np

from rankdrop.errors import ResultFileError
from rankdrop.exact.algebra.polynomial import Polynomial, flint
from rankdrop.exact.algebra.ring import Ring
from rankdrop.exact.arm.chain import Chain, exact_chain
from rankdrop.exact.family import Assumption, ExactFamily
from rankdrop.exact.writing.condition import AnglePin, Condition
from rankdrop.exact.writing.notation import Step
from rankdrop.family.equation import Equation
from rankdrop.family.record import Check, Family
from rankdrop.results.codec import Record, restored
from rankdrop.results.conditions.conditions import SCHEMA, Conditions, ConditionSettings, conditions_to_dict
from rankdrop.results.conditions.text import values_in_degrees
from rankdrop.results.known import ANSWERS, candidates
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task, resolve_task
from rankdrop.version import VERSION

_SAME = 1e-12  # screws and frames that agree to this are the same arm, as for the shipped analyses
_AGAIN = ("robot", "equations", "determinants")
"""Entries of the record that are made again: from the robot asked about, and from `terms`; determinants belong to
steps, which are not stored."""


def to_stored(conditions: Conditions) -> Record:
    """A complete derivation as plain data: `from_stored` is its inverse, given the same arm.

    Raises:
        ResultFileError: a derivation that is not complete; nothing of it can be vouched for later.
    """
    if not conditions.complete or conditions.interrupted:
        raise ResultFileError(
            "only a complete derivation is stored", where=conditions.robot.name, got="; ".join(conditions.left)
        )
    record = {key: value for key, value in conditions_to_dict(conditions).items() if key not in _AGAIN}
    record["answers"] = ANSWERS
    record["arm"] = _arm(conditions.robot) | {"task": _task(conditions.task)}
    record["generic_rank"] = conditions.generic_rank
    record["families"] = [
        {key: value for key, value in written.items() if key not in _AGAIN}
        | {"pins": [[joint, list(values)] for joint, values in family.pins]}
        | {"polynomials": [_terms(one.polynomial) for one in family.conditions]}
        for written, family in zip(record["families"], conditions.families, strict=True)
    ]
    return record


def is_of(record: Record, robot: Robot, task: Task) -> bool:
    """Whether a stored derivation is that of this arm and task: kinds, screws, frames and home pose, letters, rows."""
    mine, own = _arm(robot), record["arm"]
    exact = all(mine[key] == own[key] for key in ("kinds", "lengths")) and _task(task) == own["task"]
    return exact and all(
        np.abs(np.array(mine[key]) - own[key]).max() <= _SAME for key in ("screws", "frames", "home")
    )


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
    record: Record, robot: Robot, task: Task, chain: Chain, *, anew: Callable[[], Conditions] | None = None
) -> Conditions:
    """The derivation of a record made by `to_stored`.

    Args:
        record: as it was stored.
        robot, task: the arm asked about: the same joints, lengths and frames as those it was derived for.
        chain: that arm made exact, with letters where it has them.
        anew: derives it once more, for what the record does not hold.

    Raises:
        ResultFileError: another schema, or entries that are missing or make no sense.
    """
    if record.get("schema") != SCHEMA:
        raise ResultFileError("these are not conditions that can be read", got=repr(record.get("schema")),
                              allowed=SCHEMA)  # fmt: skip
    try:
        return _read(record, robot, task, chain, anew)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        what = f"no entry {error}" if isinstance(error, KeyError) else str(error)
        raise ResultFileError("the stored conditions are damaged", where=robot.name, got=what) from error


def _read(
    record: Record, robot: Robot, task: Task, chain: Chain, anew: Callable[[], Conditions] | None
) -> Conditions:
    if not record["letters"]:
        chain = replace(chain, letters={}, written={})  # with letters it took longer than it might
    return Conditions(
        robot=robot,
        task=task,
        generic_rank=record["generic_rank"],
        letters=dict(record["letters"]),
        shifts=tuple(record["shifts"]),
        remarks=tuple(record["remarks"]),
        method=record["method"],
        reason=record["reason"],
        steps=restored(tuple[Step, ...], record["steps"]),
        families=tuple(_family(one, chain) for one in record["families"]),
        lowest=record["lowest"],
        assumptions=restored(tuple[Assumption, ...], record["assumptions"]),
        not_real=tuple(record["not_real"]),
        explained=Check(record["explained"]["tested"], record["explained"]["explained"]),
        disagreements=tuple(record["disagreements"]),
        complete=record["complete"],
        interrupted=record["interrupted"],
        left=tuple(record["left"]),
        seconds=0.0,
        settings=replace(restored(ConditionSettings, record["settings"]), version=VERSION),
        chain=chain,
        anew=anew,
    )


def _family(record: Record, chain: Chain) -> ExactFamily:
    """A family with what was written of it: it need not be put shortly once more, which takes the longest."""
    found = ExactFamily(
        id=record["id"],
        name=record["name"],
        corank=record["corank"],
        dimension=record["dimension"],
        codimension=record["codimension"],
        pins=tuple(AnglePin(joint, tuple(values)) for joint, values in record["pins"]),
        conditions=tuple(Condition(chain.ring, _polynomial(chain.ring, terms)) for terms in record["polynomials"]),
        free=tuple(record["free"]),
        coupled=tuple(record["coupled"]),
        reality=record["reality"],
        witness=tuple(record["witness"]),
        lost_words=tuple(record["lost_words"]),
        rank_check=restored(Check, record["rank_check"]),
        numbers=chain.numbers,
        shifts=tuple(float(x) for x in chain.shifts),
        pieces=(),
    )
    written: dict[str, Any] = {
        "texts": tuple(record["conditions"]),
        "latex": tuple(record["latex"]),
        "equations": tuple(Equation.from_dict({"terms": terms}) for terms in record["terms"]),
    }
    vars(found).update(written)  # where functools.cached_property keeps them
    return found


def _terms(f: Polynomial) -> list[list[Any]]:
    """[[variable, power, …], coefficient] per term, coefficients as whole numbers or "p/q"."""
    names = f.context().names()
    found = []
    for exponents, value in f.terms():
        powers = [part for name, power in zip(names, exponents, strict=True) if power for part in (name, int(power))]
        number = Fraction(int(value.p), int(value.q))
        found.append([powers, str(number)])
    return found


def _polynomial(ring: Ring, terms: Sequence[Sequence[Any]]) -> Polynomial:
    """The polynomial of the half-angle ring with these terms."""
    module, found = flint(), {}
    for powers, value in terms:
        exponents = [0] * len(ring.names)
        for name, power in zip(powers[::2], powers[1::2], strict=True):
            exponents[ring.index[name]] = power
        number = Fraction(value)
        found[tuple(exponents)] = module.fmpq(number.numerator, number.denominator)
    return ring.half.from_dict(found)


def shipped_record(robot: Robot, task: Task) -> Record | None:
    """The shipped conditions of this arm and task as they stand in their file, or None; see `known_conditions`."""
    for name in candidates(robot):
        record = _record(name)
        if record is not None and record.get("answers") == ANSWERS and is_of(record, robot, task):
            return record
    return None


def known_conditions(
    robot: Robot, task: str | Task | None = None, *, anew: Callable[[], Conditions] | None = None
) -> Conditions | None:
    """The shipped conditions of this arm, or None: another arm or task, or made by code with other `ANSWERS`.

    Args:
        robot: any arm.
        task: as in `resolve_task`; the length scale plays no part.
        anew: derives them once more, for `Conditions.test`.

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
    record = shipped_record(robot, resolved)
    return None if record is None else from_stored(record, robot, resolved, exact_chain(robot, resolved), anew=anew)


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
    chain = exact_chain(robot)
    return from_stored(record, robot, chain.task, chain)


LONGEST = 120
"""Characters of a condition that is printed; of a longer one the joints are named."""
_SHIFTED = 1e-12  # an angle that conditions count from elsewhere than the joint does [rad]


def _written(robot: Robot, task: Task, family: Family) -> tuple[list[str], Record] | None:
    """Conditions, beyond pinned joints, and lengths shipped for this family; None for another arm or another family.

    Conditions that count an angle from elsewhere than the joint does are left out: they read as if they were of q.
    """
    record = shipped_record(robot, task)
    if record is None:
        return None
    for one in record["families"]:
        if (one["id"], one["name"], one["corank"]) == (family.id, family.name, family.corank):
            bound = {*one["coupled"], *(pin["number"] for pin in one["pinned"])}
            if any(abs(shift) > _SHIFTED for number, shift in enumerate(record["shifts"], 1) if number in bound):
                return None
            return one["conditions"][len(one["pinned"]) :], record["letters"]
    return None


def condition_sentences(robot: Robot, task: Task, family: Family) -> tuple[str, ...]:
    """What has to hold on a family, one sentence each.

    Joints at fixed values first: "θ4 = −26.76° or 153.24°". Then the exact conditions where they are shipped, with the
    lengths that stand in them; else the fitted ones. Long ones are not printed: they name their joints.

    Args:
        robot: the arm.
        task: its rows.
        family: of the catalogue, of an analysis, or found on the spot.
    """
    pins = [
        f"{_symbol(robot, one.number)} = {values_in_degrees(robot, one.number, one.values)}" for one in family.pinned
    ]
    fixed = {one.number for one in family.pinned}
    written = _written(robot, task, family)
    letters: Record = {}
    if written is not None:
        rest, letters = written
        rest = [text for text in rest if not {*_joints([text])} <= fixed]
    else:
        rest = [f"{one} = 0" for one in family.equations if not set(one.joints) <= fixed]
        if not family.equations:
            return family.words or ("no condition found",)
    short = [text for text in rest if len(text) <= LONGEST]
    long = [text for text in rest if len(text) > LONGEST]
    told = [*pins, *short]
    if long:
        joints = _joints(long)
        where = "in the JSON" if written is None else "`rankdrop conditions` prints it"
        count = "a long condition" if len(long) == 1 else f"{len(long)} long conditions"
        told.append(f"{count} on joints {', '.join(map(str, joints))} ({where})")
    there = [name for name in letters if any(re.search(rf"\b{re.escape(name)}\b", one) for one in short)]
    if there:
        values = ", ".join(f"{name} = {letters[name]:.6g} m".replace("-", "−") for name in there)
        told[-1 - bool(long)] += f", {values}"
    return tuple(told)


def _symbol(robot: Robot, number: int) -> str:
    return f"{'θ' if robot.variables[number - 1].unit == 'rad' else 'q'}{number}"


def _joints(texts: Sequence[str]) -> list[int]:
    """Joints that conditions are about: θ3, q2, s3, c23 for the sum of two."""
    found: set[int] = set()
    for text in texts:
        found |= {int(number) for number in re.findall(r"[θq](\d+)", text)}
        for digits in re.findall(r"\b[sc](\d+)\b", text):
            found |= {int(digit) for digit in digits}
    return sorted(found)


def conditions_names() -> tuple[str, ...]:
    """Names of the arms whose conditions are shipped, sorted."""
    if not _folder().is_dir():
        return ()
    return tuple(sorted(item.name.removesuffix(".json") for item in _folder().iterdir() if item.name.endswith(".json")))


@cache
def _record(name: str) -> Record | None:
    path = _folder() / f"{name}.json"
    if not path.is_file():
        return None
    record: Record = json.loads(path.read_text(encoding="utf-8"))
    return record


def _folder() -> Traversable:
    return resources.files("rankdrop") / "derivations"
