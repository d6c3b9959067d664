"""What files up to version 0.2 hold as sentences only, or in another place: the one place where these are read.

Up to 0.2 the name of a family was stored in words alone, `name`; since then as facts too, `called`. Of an old
name the parts of the arm are read; its words are kept.

Up to 0.2 a family's lost motions were stored as sentences, `lost_words`; since then as facts, `lost_freedoms`, beside
them. Of an old sentence the frame is read, and whether it holds for the whole family; the directions are computed again
at the witness, to full precision.

Up to 0.2 the exact conditions of all families were listed in the entry `exact`; since then each family has its own.

Files of all versions hold as sentences when a family is real, `reality`, and what excludes real points, `proof`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import numpy as np

from rankdrop.codec import Record, restore
from rankdrop.errors import ResultFileError
from rankdrop.families.derivation import NOT_DERIVED
from rankdrop.families.lost import LostFreedom, freedoms_of
from rankdrop.families.name import ArmPart, FamilyName
from rankdrop.families.record import ExactConditions, Family, Pin, written_conditions
from rankdrop.local.directions import FramedDirections, every_frame, lost_in_frame, lost_over_family
from rankdrop.robot.model import Robot
from rankdrop.task import Task

_UNNAMED = "unnamed family"

_PARTS = frozenset(part.value for part in ArmPart)
_AT_WITNESS = " (at the witness)"
_TIE = "can only move so that "

_REAL = re.compile(r"real if and only if (.+) ≥ 0\Z")

_EXCLUDED = re.compile(r"(.+) ≥ 0 does not hold\Z")


def name_of_words(words: str) -> FamilyName:
    """The name of a family, from its words in a file up to version 0.2: the parts of the arm; the words stay.

    Example:
        >>> found = name_of_words("elbow and wrist: axes 2, 3, 4, 6 parallel (θ4 = 90.1°)")
        >>> found.short, str(found)
        ('elbow and wrist', 'elbow and wrist: axes 2, 3, 4, 6 parallel (θ4 = 90.1°)')
        >>> name_of_words("my own family").short
        'my own family'
    """
    if words == _UNNAMED:
        return FamilyName(unnamed=True)
    before = words.partition(" (")[0].partition(": ")[0]
    listed = before.replace(" and ", ", ").split(", ")
    parts = tuple(map(ArmPart, takewhile(_PARTS.__contains__, listed)))
    return FamilyName(parts=parts, given=words)


def freedoms_of_sentences(
    sentences: Sequence[str], robot: Robot, task: Task, corank: int, witness: Sequence[float]
) -> tuple[LostFreedom, ...]:
    """The freedoms that a family takes away, from the sentences of a file up to version 0.2.

    Args:
        sentences: one for each freedom, all in one frame.
        robot, task: the arm.
        corank, witness: of the family.

    Raises:
        ValueError: a sentence that no version has written.

    Example:
        >>> from rankdrop.robot.open import open_robot
        >>> from rankdrop.task import resolve_task
        >>> arm = open_robot("planar2r")
        >>> told = ["cannot translate along X of the tool"]
        >>> (one,) = freedoms_of_sentences(told, arm, resolve_task(None, arm), 1, [0.3, 0.0])
        >>> one.direction, one.frame.axes, one.everywhere
        ((1.0, 0.0, 0.0, 0.0, 0.0, 0.0), -1, True)
    """
    if not sentences:
        return ()
    everywhere = not sentences[0].endswith(_AT_WITNESS)
    name = _frame_told(sentences[0].removesuffix(_AT_WITNESS))
    every = every_frame(task.frame, len(robot.joints))
    frames = {FramedDirections(np.zeros((0, 6)), frame).name: frame for frame in every}
    if name not in frames:
        raise ValueError(f"no frame of the arm is called {name!r}")
    q = np.array(witness, dtype=np.float64)
    if everywhere:
        framed = lost_over_family(robot, q[None], task, corank, frames=[frames[name]])
        assert framed is not None  # one point: it stands still in every frame
    else:
        framed = lost_in_frame(robot, q, task, corank, frames[name])
    return freedoms_of(robot, framed, everywhere=everywhere)


def _frame_told(sentence: str) -> str:
    """ "link 5 at its origin" of "cannot translate along Y of link 5 at its origin"."""
    sentence = sentence.replace("the end effector", "the tool")  # as the tip was called first
    if sentence.startswith(_TIE):  # "can only move so that vy + 0.11 m·ωz = 0 in axes of the tool: nearly no motion …"
        return sentence.partition(" in axes of ")[2].partition(": ")[0]
    return sentence.partition(" of ")[2]


def exact_from_dict(record: Record) -> ExactConditions:
    """The exact conditions of a family of a file: their words.

    Raises:
        ResultFileError: another number of LaTeX texts than of conditions.
        ValueError: an entry is missing, or is something else.
    """
    texts: tuple[str, ...] = restore(tuple[str, ...], record["conditions"])
    latex: tuple[str, ...] = restore(tuple[str, ...], record["latex"])
    pinned: tuple[Pin, ...] = restore(tuple[Pin, ...], record["pinned"])
    return written_conditions(pinned, texts, latex, expressions_of_sentence(restore(str, record["reality"])))


def expressions_of_sentence(sentence: str) -> tuple[str, ...]:
    """The expressions that are not negative where a family is real, of the sentence that says when it is real.

    Raises:
        ResultFileError: another sentence.

    Example:
        >>> expressions_of_sentence("real if and only if a1 − a2 ≥ 0 and d3 + d5 ≥ 0")
        ('a1 − a2', 'd3 + d5')
    """
    if not sentence:
        return ()
    match = _REAL.match(sentence)
    if match is None:
        raise ResultFileError("this does not say when a family is real", where="reality", got=sentence[:80],
                              allowed="real if and only if … ≥ 0")  # fmt: skip
    expressions: str = match[1]
    return tuple(expressions.split(" ≥ 0 and "))


def negative_of_sentence(sentence: str) -> str:
    """The expression that is negative, of the sentence that excludes real points; "" of any other sentence.

    Example:
        >>> negative_of_sentence("a1 − a2 ≥ 0 does not hold")
        'a1 − a2'
    """
    match = _EXCLUDED.match(sentence)
    if match is None:
        return ""
    expression: str = match[1]
    return expression


def conditions_of_derivation(families: Sequence[Family], record: Record) -> tuple[Family, ...]:
    """Families with the exact conditions that a file up to version 0.2 lists in its entry `exact`.

    In files of 0.1 derived families were matched with fitted rows, `matches`, and might have their own numbers: the
    conditions of those that are not one whole row are left out.

    Args:
        families: of the file.
        record: the file; the families of a later one are returned as they are.

    Raises:
        ResultFileError: conditions of a family that is not listed.
        ValueError: an entry is missing, or is something else.
    """
    exact = record.get("exact", {})
    listed = exact.get("families", [])
    if exact.get("status") == NOT_DERIVED or not listed:
        return tuple(families)
    if "matches" in exact:
        same = {row["row"] for row in exact["matches"] if row["families"] == [row["row"]] and not row["parts"]}
        listed = [row for row in listed if row["id"] in same]
    conditions = {row["id"]: exact_from_dict(row) for row in listed}
    ids = [family.id for family in families]
    for unknown in conditions.keys() - set(ids):
        raise ResultFileError("there is no such family", got=unknown, allowed=", ".join(ids))
    return tuple(replace(family, exact=conditions.get(family.id, family.exact)) for family in families)
