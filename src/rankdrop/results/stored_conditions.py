"""Exact conditions in files: as they are stored, and those that come with the package.

Conditions are the record of docs/json.md, and the polynomials beside it: what JSON says in words is kept in words, and
the polynomials from which those words were made are kept too, each as its terms. Read back, a derivation prints,
writes LaTeX, code and JSON as it did before. It no longer has the irreducible sets that its families were merged from:
`Conditions.test` derives them anew.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from rankdrop.algebra.polynomial import Polynomial, flint
from rankdrop.algebra.ring import Ring
from rankdrop.algebra.roots import root_values, with_inner
from rankdrop.codec import Record, plain, restore
from rankdrop.errors import ResultFileError
from rankdrop.exact.arm.chain import ring_of
from rankdrop.exact.family import EVIDENCE, Assumption, UnrealSet, pins_in_q, slides_at_zero
from rankdrop.exact.method_reason import MethodReason
from rankdrop.exact.remark import DerivationRemark
from rankdrop.families.contradiction import Contradiction
from rankdrop.families.lost import LostFreedom
from rankdrop.families.record import Check, ExactConditions, Family, WrittenCondition, exact_of
from rankdrop.formula.equation import Equation
from rankdrop.formula.notation import Step
from rankdrop.formula.writing import AnglePin, Condition
from rankdrop.questions import ConditionsOptions
from rankdrop.results.conditions import SCHEMA, Conditions
from rankdrop.results.known import ANSWERS, arm_and_task, conditions_names, conditions_record, shipped_conditions_record
from rankdrop.results.names import name_of
from rankdrop.results.old_files import expressions_of_sentence, freedoms_of_sentences, negative_of_sentence
from rankdrop.results.old_sentences import contradictions_of_sentences, remarks_of_sentences
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot
from rankdrop.sections import words_of
from rankdrop.task import Task, resolve_task

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
    record["arm"] = arm_and_task(conditions.robot, conditions.task)
    record["generic_rank"] = conditions.generic_rank
    record["why"] = asdict(conditions.reason)
    record["noted"] = [_facts(remark) for remark in conditions.remarks]
    record["families"] = [
        {key: value for key, value in written.items() if key not in _AGAIN}
        | {"pins": [[pin.joint, list(pin.values)] for pin in exact.pins]}
        | {"polynomials": [_terms(condition.polynomial) for condition in exact.polynomials]}
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
        return _conditions_of(record, robot, task, anew)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        if isinstance(error, KeyError):
            what = f"no entry {error}"
        else:
            what = str(error)
        raise ResultFileError("the stored conditions are damaged", where=robot.name, got=what) from error


def _conditions_of(record: Record, robot: Robot, task: Task, anew: Callable[[], Conditions] | None) -> Conditions:
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
        reason=restore(MethodReason, record["why"]),
        steps=restore(tuple[Step, ...], record["steps"]),
        families=tuple(_family(stored, ring, record, root_values(roots), robot, task) for stored in record["families"]),
        lowest=record["lowest"],
        assumptions=restore(tuple[Assumption, ...], record["assumptions"]),
        not_real=tuple(map(_unreal, record["unreal"])),
        explained=Check(record["explained"]["tested"], record["explained"]["explained"]),
        disagreements=_contradictions(record),
        complete=record["complete"],
        interrupted=record["interrupted"],
        left=(),  # of a complete derivation
        seconds=0.0,
        settings=restore(ConditionsOptions, record["settings"]),
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
        remarks: tuple[DerivationRemark, ...] = restore(tuple[DerivationRemark, ...], record["noted"])
        return remarks
    return remarks_of_sentences(record["remarks"])


def _unreal(record: Record) -> UnrealSet:
    """A set without a known real point; what excludes one is a sentence of the file."""
    facts = {name: value for name, value in record.items() if name != "proof"}
    unreal: UnrealSet = restore(UnrealSet, facts | {"negative": negative_of_sentence(record["proof"])})
    return unreal


def _freedoms(record: Record, robot: Robot, task: Task) -> tuple[LostFreedom, ...]:
    if "lost_freedoms" in record:
        freedoms: tuple[LostFreedom, ...] = restore(tuple[LostFreedom, ...], record["lost_freedoms"])
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
        not_negative=expressions_of_sentence(record["reality"]),
        rank_check=restore(Check, record["rank_check"]),
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
    terms = []
    for exponents, value in f.terms():
        powers: list[Any] = []
        for name, power in zip(names, exponents, strict=True):
            if power:
                powers += [name, int(power)]
        number = Fraction(int(value.p), int(value.q))
        terms.append([powers, str(number)])
    return terms


def _polynomial(ring: Ring, terms: Sequence[Sequence[Any]]) -> Polynomial:
    module, coefficients = flint(), {}
    for powers, value in terms:
        exponents = [0] * len(ring.names)
        for name, power in zip(powers[::2], powers[1::2], strict=True):
            exponents[ring.index[name]] = power
        number = Fraction(value)
        coefficients[tuple(exponents)] = module.fmpq(number.numerator, number.denominator)
    return ring.half.from_dict(coefficients)


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
    record = conditions_record(name)
    if record is None:
        allowed = ", ".join(conditions_names())
        raise ResultFileError("no conditions of this arm are shipped", got=repr(name), allowed=allowed)
    robot = open_robot(name)
    return from_stored(record, robot, resolve_task(None, robot))
