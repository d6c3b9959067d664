"""Mimic joints of a URDF chain: who leads, who follows, and what becomes of a leader outside the chain."""

from __future__ import annotations

from rankdrop.errors import RobotError
from rankdrop.robot.model import Mimic
from rankdrop.robot.urdf_numbers import number
from rankdrop.robot.urdf_tree import Tree, TreeJoint


def resolve_mimics(tree: Tree, chain: list[TreeJoint]) -> tuple[dict[str, Mimic], list[str]]:
    """How the followers among the moving joints of the chain depend on its variables.

    A follower of a follower is traced to the first leader. Where that leader is outside the chain, the first follower
    becomes a variable and leads the others: with q_j = m_j L + o_j, q_j = (m_j/m_1) q_1 + o_j − (m_j/m_1) o_1.

    Returns:
        follower's name -> Mimic with a leader in the chain, and notes.

    Raises:
        RobotError: a leader that is not in the file or fixed, a circle of leaders, a multiplier of zero.
    """
    inside = {joint.name for joint in chain}
    mimics: dict[str, Mimic] = {}
    outside: dict[str, tuple[str, Mimic]] = {}  # leader outside -> its first follower and how that one follows
    notes: list[str] = []
    away = "which is not in the chain"
    for joint in chain:
        if joint.element.first("mimic") is None:
            continue
        traced = _trace(tree, joint)
        leader = traced.leader
        if leader in inside:
            mimics[joint.name] = traced
            notes.append(f"joint {joint.name!r} follows joint {leader!r}")
        elif leader not in outside:
            outside[leader] = (joint.name, traced)
            notes.append(f"joint {joint.name!r} follows {leader!r}, {away}: it is taken as a variable")
        else:
            first, lead = outside[leader]
            ratio = traced.multiplier / lead.multiplier
            mimics[joint.name] = Mimic(first, ratio, traced.offset - ratio * lead.offset)
            notes.append(f"joint {joint.name!r} follows {leader!r}, {away}: it follows {first!r} instead")
    return mimics, notes


def _trace(tree: Tree, joint: TreeJoint) -> Mimic:
    multiplier, offset = 1.0, 0.0
    met = [joint.name]
    current = joint
    while (element := current.element.first("mimic")) is not None:
        where = tree.where(current, "mimic")
        name = element.attributes.get("joint", "")
        if name not in tree.joints:
            raise RobotError("the mimic joint follows a joint that is not in the file", where=where, got=repr(name))
        if name in met:
            raise RobotError("mimic joints follow one another in a circle", where=where, got=" -> ".join([*met, name]))
        factor = number(element.attributes.get("multiplier", "1"), where, "multiplier")
        measure = "length" if current.kind == "prismatic" else "angle"
        shift = number(element.attributes.get("offset", "0"), where, "offset", measure)
        if factor == 0.0:
            raise RobotError(
                "the multiplier of a mimic joint is zero", where=where, got=0, allowed="a number other than 0",
                mend='a joint that never moves has type "fixed"',
            )
        offset, multiplier = offset + multiplier * shift, multiplier * factor
        current = tree.joints[name]
        met.append(name)
        if not current.moves:
            raise RobotError("the mimic joint follows a fixed joint", where=where, got=repr(name))
    return Mimic(current.name, multiplier, offset)
