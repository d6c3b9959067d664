"""The Jacobian seen from a link, exactly (ML's ¹J, KG's screws in frame 5), and where it is block triangular.

A square Jacobian is block triangular where a group of joints moves some of its rows only. The joints C of a subgroup of
the motions (about a point, in a plane, along three directions) leave the other rows at zero when point and axes are
chosen for it. With as many rows G left to them as there are joints, and G, C first,

    J = [[J_GC, *], [0, J_rest]],    det J = ± det J_GC · det J_rest.

The group's columns are zero as polynomials, hence at every configuration: it is a proof.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.algebra.polynomial import Polynomial
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import ExactStructure, listed
from rankdrop.robot.model import JointKind
from rankdrop.task import BODY
from rankdrop.tolerances import ALIGNED

Columns = list[list[Polynomial]]
POSE, POSITION = (0, 1, 2, 3, 4, 5), (0, 1, 2)
KINDS = {
    "point": (3, 4, 5),
    "slides": (0, 1, 2),
    "plane": (0, 1, 5),
    "plane and slide": (0, 1, 2, 5),
    "last axis": (5,),
}
"""The rows (out of vx vy vz wx wy wz, z along the axis of the link in use) that a group of each kind moves."""
_WHOLE = ("point", "slides", "plane and slide")  # they part whole poses only


@dataclass(frozen=True, slots=True)
class BlockForm:
    """A Jacobian made block triangular.

    Attributes:
        kind: of the group's motions, a key of `KINDS`.
        reason: why, in words.
        point, axes: reference point and axes, in words.
        link, origin: numbers of the link whose axes are used, and of the one at whose origin the point is (0: the tip).
        columns: n columns, one entry per row of the task.
        group, group_rows: joints (from 1) and rows (0 … 5) of the first block.
        rest, rest_rows: those of the second.
        names: of the two blocks.
    """

    kind: str
    reason: str
    point: str
    axes: str
    link: int
    origin: int
    columns: Columns
    group: tuple[int, ...]
    group_rows: tuple[int, ...]
    rest: tuple[int, ...]
    rest_rows: tuple[int, ...]
    names: tuple[str, str]


def block_form(chain: Chain, structure: ExactStructure) -> BlockForm | None:
    """The way to make a square Jacobian block triangular that says most: spherical wrist, shoulder, others, planes.

    Args:
        chain: as many joints as its task has rows.
        structure: of the chain.
    """
    found = list(_candidates(chain, structure))
    if not found:
        return None
    parts = {structure.wrist: 0, structure.shoulder: 1}
    kinds = list(KINDS)
    best = min(found, key=lambda one: (kinds.index(one.kind), parts.get(one.group, 2), _terms(one.columns)))
    return _best_axes(chain, best) if best.kind == "point" else best


def _candidates(chain: Chain, structure: ExactStructure) -> Iterator[BlockForm]:
    """Every frame and reference point, with every kind of group, in which the Jacobian is block triangular."""
    rows = chain.task.rows
    for link, origin, columns in _views(chain):
        for kind, moved in KINDS.items():
            own = tuple(r for r in rows if r in moved)
            others = tuple(r for r in rows if r not in moved)
            still = [rows.index(r) for r in others]
            group = tuple(j for j, column in enumerate(columns, 1) if not any(column[i] != 0 for i in still))
            fits = rows == POSE if kind in _WHOLE else kind == "plane" or rows == (0, 1, 5)
            if not (fits and own and others and len(group) == len(own)):
                continue
            yield BlockForm(
                kind=kind,
                reason=_reason(chain, structure, kind, group),
                point=_point(structure, kind, group, origin),
                axes=_axes(link),
                link=link,
                origin=origin,
                columns=columns,
                group=group,
                group_rows=own,
                rest=tuple(j for j in range(1, chain.n + 1) if j not in group),
                rest_rows=others,
                names=_names(structure, kind, group),
            )


def _views(chain: Chain) -> Iterator[tuple[int, int, Columns]]:
    """(link of the axes, link of the point, columns in the task's rows) that keep the span of the task's rows."""
    rows = chain.task.rows
    links = range(1, chain.n + 1)
    if rows == POSE:
        yield from ((k, k, chain.screws(k)) for k in links)
    elif rows == POSITION:
        yield from ((k, 0, [c[:3] for c in chain.screws_at_tip(k)]) for k in links)
    elif {0, 1, 5} <= set(rows) and flat(chain):  # of a motion in planes any point will do
        last = max(chain.ring.revolute)
        yield last, last, [[c[r] for r in rows] for c in chain.screws(last)]


def flat(chain: Chain) -> bool:
    """Every turn is about one direction, which is the z axis of the task's rows."""
    if not chain.ring.revolute or 3 in chain.task.rows or 4 in chain.task.rows:
        return False
    one = chain.ring.revolute[0]
    if any(column[3] != 0 or column[4] != 0 for column in chain.screws(one)):
        return False
    z = chain.robot.home[:3, 2] if chain.task.frame == BODY else np.array([0.0, 0.0, 1.0])
    axis = chain.robot.joints[one - 1].screw[3:]  # all others are parallel, so it never moves
    return bool(np.linalg.norm(np.cross(axis, z)) <= ALIGNED)


def _best_axes(chain: Chain, form: BlockForm) -> BlockForm:
    """The same form about the same point in the axes in which the screws are shortest."""
    views = ((k, chain.screws_about(k, form.origin)) for k in range(1, chain.n + 1))
    link, columns = min(views, key=lambda view: _terms(view[1]))
    return replace(form, link=link, columns=columns, axes=_axes(link))


def _terms(columns: Columns) -> int:
    return sum(len(x) for column in columns for x in column)


def _axes(link: int) -> str:
    return f"those of link {link}: z along joint {link}, x along the common normal after it"


def _point(structure: ExactStructure, kind: str, group: tuple[int, ...], origin: int) -> str:
    if kind == "point":
        where = f"the point where axes {listed(group)} meet"
        part = {structure.wrist: "the wrist centre", structure.shoulder: "the shoulder centre"}.get(group, "")
        return f"{part}, {where}" if part else where
    return f"the foot of the common normal after joint {origin}, on its axis" if origin else "the tip"


def _names(structure: ExactStructure, kind: str, group: tuple[int, ...]) -> tuple[str, str]:
    """Of the blocks: a wrist, a shoulder, and what is left of the arm."""
    if kind == "point":
        part = {structure.wrist: "wrist", structure.shoulder: "shoulder"}.get(group, f"joints {listed(group)}")
        return part, "arm"
    return {"slides": ("slides", "turns"), "last axis": ("last joint", "arm")}.get(kind, ("in plane", "out of plane"))


def _reason(chain: Chain, structure: ExactStructure, kind: str, group: tuple[int, ...]) -> str:
    joints = listed(group)
    if kind == "point":
        part = {structure.wrist: "spherical wrist", structure.shoulder: "spherical shoulder"}.get(group, "")
        part = part or "spherical group"
        return f"{part}: axes {joints} meet in one point, and turning about them does not move it"
    if kind == "slides":
        return f"three slides: joints {joints} do not turn the end effector"
    if kind == "last axis":
        return f"planar arm: joint {joints} does not move the points of its own axis"
    if kind == "plane and slide":
        return f"joints {joints} turn the end effector about one direction only"
    if all(chain.sections[j - 1].kind is JointKind.REVOLUTE for j in group):
        count = {2: "planar pair", 3: "planar triple"}[len(group)]
        return f"{count}: axes {joints} are parallel, and turning about them moves every point in a plane across them"
    return f"planar group: joints {joints} move every point in one plane"


ORIENTATION = (3, 4, 5)


def frame_jacobian(chain: Chain, k: int, at: int | None = None) -> list[list[Polynomial]]:
    """ᵏJ: the task's rows of the Jacobian in the axes of link k (z along axis k, x along the normal after it).

    ᵏJ = ᵏR₀ ⁰J, row by row (ML's ¹J of the planar arm). It has the same singularities.

    Args:
        chain: from `exact_chain`.
        k: link, 1 … n.
        at: the reference point is the origin of this link's frame, 1 … n, on axis `at` where the normal after it
            starts (KG: k itself); None for the tip (ML).

    Returns:
        One list of n trigonometric polynomials for each row of the task.

    Raises:
        OptionError: no such link, or another reference point than the tip for a task whose rows it changes.
        TaskError: the task's rows would be others in these axes.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> [str(x) for x in frame_jacobian(exact_chain(open_robot("planar2r")), 1)[1]]
        ['c2*a2 + a1', 'c2*a2']
    """
    check_frame(chain, k, at)
    screws = chain.screws_at_tip(k) if at is None else chain.screws_about(k, at)
    return [[column[r] for column in screws] for r in chain.task.rows]


def check_frame(chain: Chain, k: int, at: int | None) -> None:
    """Refuse axes and reference points that the task has no Jacobian for; raises as `frame_jacobian`."""
    for link, what in ((k, "frame"), (at, "at")):
        if link is not None and not 1 <= link <= chain.n:
            raise OptionError("there is no such link", where=what, got=link, allowed=f"1 … {chain.n}")
    rows = chain.task.rows
    paired = (0 in rows) == (1 in rows)
    if rows not in (POSE, POSITION, ORIENTATION) and not (paired and flat(chain)):
        raise TaskError(
            "in the axes of a link the rows of this task would be others",
            got=chain.task.name,
            allowed="pose, position, orientation, or rows of a plane that all axes are perpendicular to",
        )
    if at is not None and not moves(chain):
        raise OptionError(
            "the velocity of another point is another task", where="at", got=f"link {at}, task {chain.task.name}",
            allowed="the tip",
        )


def moves(chain: Chain) -> bool:
    """Whether the reference point may be another one than the tip: the rows know how the end effector turns."""
    rows = chain.task.rows
    return rows in (POSE, ORIENTATION) or (5 in rows and rows != POSITION)


def sizes(chain: Chain) -> list[tuple[int, int, int | None]]:
    """(terms, link of the axes, reference point) for all axes and reference points, the shortest first.

    Terms are those of all entries, multiplied out in sines and cosines of single joints.

    Raises:
        TaskError: as `frame_jacobian`.
    """
    check_frame(chain, 1, None)
    points: list[int | None] = [None, *(range(1, chain.n + 1) if moves(chain) else ())]
    found = [
        (sum(len(x) for row in frame_jacobian(chain, k, at) for x in row), k, at)
        for at in points
        for k in range(1, chain.n + 1)
    ]
    return sorted(found, key=lambda one: (one[0], one[2] is not None, one[2] or 0, one[1]))
