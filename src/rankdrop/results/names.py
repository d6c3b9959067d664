"""Names of families in files: facts in the entry `called`, and their words in the entry `name`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, get_type_hints

from rankdrop.codec import Record, restore
from rankdrop.families.name import Detail, FamilyName, LowRank, Shorter, is_whole
from rankdrop.local.dependence import Dependence
from rankdrop.results.old_files import name_of_words

_KINDS: dict[str, Any] = {
    name: kind for name, kind in get_type_hints(FamilyName).items() if name not in ("details", "shorter", "meeting")
}
"""Entry that is a field of a name as it stands -> its type."""


def name_of(family: Record) -> FamilyName:
    """The name of a family of a file: from its entry `called`; from `name` in files up to version 0.2.

    Raises:
        ValueError: an entry that is no fact of a name.
    """
    called = family.get("called")
    if called is None:
        return name_of_words(family["name"])
    return name_from_dict(called)


def name_from_dict(record: Record) -> FamilyName:
    """The name of a record made by the table `CALLED`: entries that are missing have their defaults.

    Raises:
        ValueError: an entry that is no fact of a name, or a relation without the joints that it is about.

    Example:
        >>> str(name_from_dict({"parts": ["wrist"], "relations": [{"geometry": "on one line", "joints": [[4, 6]]}]}))
        'wrist: axes 4 and 6 aligned'
    """
    relations = restore(tuple[Detail, ...], record.get("relations", ()))
    dependent = restore(tuple[Dependence, ...], record.get("dependent", ()))
    for relation in relations:
        if not is_whole(relation):
            raise ValueError(f'relation "{relation.geometry}" lacks its joints, centre or plane, or has others')
    if not all(screws.joints for screws in dependent):
        raise ValueError("a dependent set of a name has no joints")
    details: tuple[Detail | Dependence | LowRank, ...] = (
        *(replace(relation, joints=tuple(map(_before, relation.joints))) for relation in relations),
        *(replace(screws, joints=_before(screws.joints), slides=_before(screws.slides)) for screws in dependent),
        *restore(tuple[LowRank, ...], record.get("low_rank", ())),
    )
    shorter = Shorter.NOTHING
    for word in record.get("shorter", ()):
        shorter |= Shorter[word.upper()]
    fields = {name: restore(kind, record[name]) for name, kind in _KINDS.items() if name in record}
    return FamilyName(**fields, details=details, shorter=shorter)


def joints_of_name(name: FamilyName) -> set[int]:
    """Numbers of the joints that a name is about, from 1.

    Example:
        >>> joints_of_name(name_from_dict({"relations": [{"geometry": "on one line", "joints": [[4, 6]]}]}))
        {4, 6}
    """
    joints = {variable.number for variable in name.bound} | {values.joint.number for values in name.values}
    joints.discard(0)  # "with a condition", of a name that leaves out on which joints
    for detail in name.details:
        if isinstance(detail, LowRank):
            joints.add(detail.joints)
            continue
        if isinstance(detail, Detail):
            members = sum(detail.joints, ())
        else:
            members = (*detail.joints, *detail.slides)
        joints.update(joint + 1 for joint in members)
    return joints


def _before(joints: Iterable[int]) -> tuple[int, ...]:
    """Joints counted from 0; files count from 1."""
    return tuple(joint - 1 for joint in joints)
