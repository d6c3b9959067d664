"""Joints under other names than the arm's: with a prefix that all of them have in common, or as a controller logs them.

A file of a cell with two robots says left_shoulder_pan_joint where the arm says shoulder_pan_joint, or the other way
round. Logs of Universal Robots' RTDE have actual_q_0 … actual_q_5, or target_q_0 … of the planned motion.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from rankdrop.path.read.trajectory import TrajectoryError
from rankdrop.text.path_files import AS_RTDE, PREFIX_OF_ARM, PREFIX_OF_FILE

_LOGGED = ("actual_q", "target_q")
_OTHER_QUANTITIES = ("vel", "eff", "torq", "tau", "acc", "curr", "err", "temp", "speed", "rate", "dot", "qd", "force",
                     "power", "volt", "load")  # fmt: skip
"""Words in prefixes of columns that are no joint values."""


@dataclass(frozen=True)
class OtherNames:
    """Names of a file that stand for the joints of an arm.

    Attributes:
        joints: name in the file -> name of the joint.
        note: what a reader should know of it.
    """

    joints: Mapping[str, str]
    note: str


def other_names(given: Collection[str], joints: Sequence[str], where: str) -> OtherNames | None:
    """The names of a file that stand for the joints, where the joints' own names are not there; None without any.

    Args:
        given: names of the file, without units.
        joints: names of the arm's joints, in order.
        where: the file, for errors.

    Raises:
        TrajectoryError: columns of several arms fit.

    Example:
        >>> other_names(["left_a", "left_b", "gripper"], ["a", "b"], "log.csv").joints
        {'left_a': 'a', 'left_b': 'b'}
    """
    given = frozenset(given)
    if given.issuperset(joints):
        return None
    return _logged(given, joints) or _with_prefix(given, joints, where) or _without_prefix(given, joints)


def notes_on(others: OtherNames | None) -> tuple[str, ...]:
    """The note on other names, where there are any."""
    if others is None:
        return ()
    return (others.note,)


def names_of_arm(names: list[str], joints: Sequence[str], where: str) -> tuple[list[str], tuple[str, ...]]:
    """Names with those of the arm's joints in place of others that stand for them; and the note on it.

    Raises:
        TrajectoryError: names of several arms fit.
    """
    others = other_names(names, joints, where)
    if others is None:
        return names, ()
    return [others.joints.get(name, name) for name in names], (others.note,)


def _logged(given: frozenset[str], joints: Sequence[str]) -> OtherNames | None:
    """Columns of RTDE, which counts joints from 0."""
    for word in _LOGGED:
        names = [f"{word}_{number}" for number in range(len(joints))]
        if given.issuperset(names) and f"{word}_{len(joints)}" not in given:
            return OtherNames(dict(zip(names, joints, strict=True)), AS_RTDE.format(names[0], names[-1]))
    return None


def _with_prefix(given: frozenset[str], joints: Sequence[str], where: str) -> OtherNames | None:
    """Names that are those of the joints behind one prefix."""
    first = joints[0]
    ends = sorted(name.removesuffix(first) for name in given if name.endswith(first) and name != first)
    prefixes = [prefix for prefix in ends if _is_prefix(prefix, given, joints)]
    if len(prefixes) > 1:
        raise TrajectoryError("columns of several arms fit", where=where, got=", ".join(f"{p}…" for p in prefixes),
                              allowed=", ".join(joints), mend="keep the columns of one arm")  # fmt: skip
    if not prefixes:
        return None
    return OtherNames({prefixes[0] + joint: joint for joint in joints}, PREFIX_OF_FILE.format(prefixes[0]))


def _is_prefix(prefix: str, given: frozenset[str], joints: Sequence[str]) -> bool:
    """Whether every joint has a name with a prefix that speaks of no other quantity."""
    plain = prefix.lower()
    return given.issuperset(prefix + joint for joint in joints) and not any(map(plain.__contains__, _OTHER_QUANTITIES))


def _without_prefix(given: frozenset[str], joints: Sequence[str]) -> OtherNames | None:
    """Names that are those of the joints without the prefix that all joints have."""
    for length in range(len(min(joints, key=len)) - 1, 0, -1):
        prefix = joints[0][:length]
        shorter = {joint.removeprefix(prefix): joint for joint in joints if joint.startswith(prefix)}
        if len(shorter) == len(joints) and given.issuperset(shorter) and all(name[0].isalpha() for name in shorter):
            return OtherNames(shorter, PREFIX_OF_ARM.format(prefix))
    return None
