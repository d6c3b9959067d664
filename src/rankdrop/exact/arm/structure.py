"""What holds between the axes of an arm at every configuration, and the block triangular Jacobian that follows from it.

Axes that meet in one point and parallel axes are read off the exact twists and lengths: a length is zero or it is not,
a letter never is. In the frame of link m (z along axis m) another axis passes through the origin when the linear part
of its screw is zero, and is parallel to axis m when its direction is (0, 0, ±1); both as polynomials, hence at every
configuration.

`frame_jacobian` is the Jacobian seen from a link (ML's ¹J, KG's screws in frame 5), `block_form` the frame in which a
square one is block triangular. The joints C of a subgroup of the motions (about a point, in a plane, along three
directions) leave the other rows at zero when point and axes are chosen for it. With as many rows G left to them as
there are joints, and G, C first,

    J = [[J_GC, *], [0, J_rest]],    det J = ± det J_GC · det J_rest.

The group's columns are zero as polynomials, hence at every configuration: it is a proof.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import acos

import numpy as np

from rankdrop.algebra.matrix import count_terms, entries, submatrix, with_rows
from rankdrop.algebra.polynomial import Polynomial
from rankdrop.errors import OptionError, TaskError
from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.geometry import Deviation, JointAndLink
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.model import JointKind
from rankdrop.task import BODY
from rankdrop.tolerances import ALIGNED
from rankdrop.units import counted_length

SMALL = 0.02
"""Lengths up to this share of the reach, and angles up to this [rad], are called small: 12 mm of a 1.2 m arm are."""

Columns = list[list[Polynomial]]
POSE, POSITION, ORIENTATION = (0, 1, 2, 3, 4, 5), (0, 1, 2), (3, 4, 5)
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
class ExactStructure:
    """What holds between the axes at every configuration. Joints are numbered from 1.

    Attributes:
        joints: how many there are.
        points: triples of consecutive axes that meet in one point.
        parallel: groups of two or more axes that are parallel.
        meeting: pairs of consecutive axes that meet in a point.
        near: what is missed by little.
    """

    joints: int
    points: tuple[tuple[int, int, int], ...]
    parallel: tuple[tuple[int, ...], ...]
    meeting: tuple[tuple[int, int], ...]
    near: tuple[Deviation, ...]

    @property
    def wrist(self) -> tuple[int, ...]:
        """The last three joints where their axes meet in one point, else empty."""
        last = (self.joints - 2, self.joints - 1, self.joints)
        return last if last in self.points else ()

    @property
    def shoulder(self) -> tuple[int, ...]:
        """The first three joints where their axes meet in one point, else empty."""
        if (1, 2, 3) in self.points:
            return (1, 2, 3)
        return ()

    @property
    def srs(self) -> bool:
        """Seven joints, spherical shoulder and spherical wrist: S-R-S."""
        return self.joints == 7 and bool(self.wrist and self.shoulder)


def structure_of(chain: Chain) -> ExactStructure:
    """Recognise the structure of an arm.

    Args:
        chain: from `exact_chain`; lengths and twists are judged as they stand there, letters are never zero.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> structure_of(exact_chain(open_robot("puma560"))).wrist
        (4, 5, 6)

    Where joints follow others it is empty: a variable may move several axes, which have no number of their own.
    """
    if chain.has_mimics:
        return ExactStructure(chain.n, (), (), (), ())
    revolute = [s.kind is JointKind.REVOLUTE for s in chain.sections]
    neighbours = [i for i in range(1, chain.n) if revolute[i - 1] and revolute[i]]
    triples = [(i, i + 1, i + 2) for i in neighbours if i + 1 in neighbours]
    return ExactStructure(
        joints=chain.n,
        points=tuple(triple for triple in triples if _meet_in_one(chain, triple)),
        parallel=_parallel(chain, revolute),
        meeting=tuple((i, i + 1) for i in neighbours if _meet(chain, i)),
        near=(*_nearly_in_one(chain, triples), *_nearly_parallel(chain, neighbours)),
    )


def triples(chain: Chain) -> list[tuple[tuple[int, int, int], str]]:
    """Three successive joints that are equivalent to a spherical or a planar joint.

    In the frame of the middle one (z along its axis) their screws have v = 0, or v_z = ω_x = ω_y = 0. None where joints
    follow others.
    """
    meeting = []
    for first in range(1, 0 if chain.has_mimics else chain.n - 1):
        three = chain.screws(first + 1)[first - 1 : first + 2]
        for name, rows in (("spherical", (0, 1, 2)), ("planar", (2, 3, 4))):
            if all(x == 0 for x in entries(with_rows(three, rows))):
                meeting.append(((first, first + 1, first + 2), name))
    return meeting


def check_basic(chain: Chain, basic: Sequence[int] | None, frame: int | None) -> None:
    """Raises OptionError unless `basic` is None or six different joints of the chain, and `frame` None or a link before
    the last one, for all six rows."""
    if frame is not None and (chain.task.rows != POSE or not 1 <= frame < chain.links):
        allowed = f"1 … {chain.links - 1}, for all six rows"
        raise OptionError("no such link frame", where="frame", got=frame, allowed=allowed)
    if basic is not None and (len(set(basic)) != 6 or len(basic) != 6 or not set(basic) <= set(range(1, chain.n + 1))):
        raise OptionError(
            "the basic screws are six different joints", where="basic", got=str(list(basic)), allowed=f"1 … {chain.n}"
        )


def joint_list(joints: tuple[int, ...]) -> str:
    """ "4, 5, 6"."""
    return ", ".join(str(joint) for joint in joints)


def _meet(chain: Chain, i: int) -> bool:
    return _is_twisted(chain.sections[i - 1]) and chain.length(i - 1, "a") == 0


def _is_twisted(section: JointAndLink) -> bool:
    """Whether the axes before and after a link are not parallel."""
    return section.twist.sin != 0


def _meet_in_one(chain: Chain, triple: tuple[int, int, int]) -> bool:
    """Both normals have no length and their feet on the middle axis coincide; no two of the axes are parallel."""
    first, middle, _ = triple
    apart = all(_is_twisted(chain.sections[j - 1]) for j in (first, middle))
    return apart and not any(x != 0 for x in entries(with_rows(chain.screws_near(middle, triple), range(3))))


def _parallel(chain: Chain, revolute: list[bool]) -> tuple[tuple[int, ...], ...]:
    groups: list[list[int]] = []
    for j in (j for j in range(1, chain.n + 1) if revolute[j - 1]):
        # a joint between that is not parallel to two others turns one about itself: those in a row are enough
        if groups:
            axis = chain.screws_near(groups[-1][-1], [j])[0][3:5]
        else:
            axis = None
        if axis is not None and not any(x != 0 for x in axis):
            groups[-1].append(j)
        else:
            groups.append([j])
    return tuple(tuple(group) for group in groups if len(group) > 1)


def _nearly_in_one(chain: Chain, triples: list[tuple[int, int, int]]) -> list[Deviation]:
    """Triples whose normals and offset are small, not all zero."""
    deviations = []
    for first, middle, last in triples:
        before, own = chain.sections[first - 1], chain.sections[middle - 1]
        if not (_is_twisted(before) and _is_twisted(own)):
            continue
        miss = max(abs(float(x)) for x in (before.a, own.d, own.a))
        if 0 < miss <= SMALL * reach(chain.robot):
            deviations.append(Deviation("point", (first, middle, last), miss, counted=counted_length(chain.robot)))
    return deviations


def _nearly_parallel(chain: Chain, neighbours: list[int]) -> list[Deviation]:
    deviations = []
    for i in neighbours:
        twist = chain.sections[i - 1].twist
        angle = acos(min(1.0, abs(float(twist.cos))))
        if twist.sin != 0 and angle <= SMALL:
            deviations.append(Deviation("parallel", (i, i + 1), angle))
    return deviations


@dataclass(frozen=True, slots=True)
class BlockForm:
    """A Jacobian made block triangular.

    Attributes:
        kind: of the group's motions, a key of `KINDS`.
        part: of the arm that the group is where it moves about a point: "wrist", "shoulder", or "".
        turns: whether no joint of the group slides.
        link, origin: numbers of the link whose axes are used, and of the one at whose origin the point is (0: the tip).
        columns: n columns, one entry per row of the task.
        group, group_rows: joints (from 1) and rows (0 … 5) of the first block.
        rest, rest_rows: those of the second.
        names: of the two blocks.
    """

    kind: str
    part: str
    turns: bool
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

    None where joints follow others: a block is named by the axes of its joints.

    Args:
        chain: as many joints as its task has rows.
        structure: of the chain.
    """
    if chain.has_mimics:
        forms = []
    else:
        forms = list(_candidates(chain, structure))
    if not forms:
        return None
    parts = {structure.wrist: 0, structure.shoulder: 1}
    kinds = list(KINDS)
    best = min(forms, key=lambda group: (kinds.index(group.kind), parts.get(group.group, 2), _terms(group.columns)))
    if best.kind == "point":
        return _best_axes(chain, best)
    return best


def _candidates(chain: Chain, structure: ExactStructure) -> Iterator[BlockForm]:
    """Every frame and reference point, with every kind of group, in which the Jacobian is block triangular."""
    rows = chain.task.rows
    for link, origin, columns in _views(chain):
        for kind, moved in KINDS.items():
            own = tuple(r for r in rows if r in moved)
            others = tuple(r for r in rows if r not in moved)
            still = [rows.index(r) for r in others]
            group = tuple(j for j, column in enumerate(columns, 1) if not any(column[i] != 0 for i in still))
            if kind in _WHOLE:
                fits = rows == POSE
            else:
                fits = kind == "plane" or rows == (0, 1, 5)
            if not (fits and own and others and len(group) == len(own)):
                continue
            yield BlockForm(
                kind=kind,
                part=_part(structure, kind, group),
                turns=all(chain.sections[j - 1].kind is JointKind.REVOLUTE for j in group),
                link=link,
                origin=origin,
                columns=columns,
                group=group,
                group_rows=own,
                rest=tuple(j for j in range(1, chain.n + 1) if j not in group),
                rest_rows=others,
                names=_names(kind, group, _part(structure, kind, group)),
            )


def _views(chain: Chain) -> Iterator[tuple[int, int, Columns]]:
    """(link of the axes, link of the point, columns in the task's rows) that keep the span of the task's rows."""
    rows = chain.task.rows
    links = range(1, chain.n + 1)
    if rows == POSE:
        yield from ((k, k, chain.screws(k)) for k in links)
    elif rows == POSITION:
        yield from ((k, 0, with_rows(chain.screws_at_tip(k), POSITION)) for k in links)
    elif {0, 1, 5} <= set(rows) and flat(chain):  # of a motion in planes any point will do
        last = max(chain.ring.revolute)
        yield last, last, with_rows(chain.screws(last), rows)


def flat(chain: Chain) -> bool:
    """Every turn is about one direction, which is the z axis of the task's rows."""
    if not chain.ring.revolute or 3 in chain.task.rows or 4 in chain.task.rows:
        return False
    number = next(j for j, section in enumerate(chain.sections, 1) if section.kind is JointKind.REVOLUTE)
    if any(screw[3] != 0 or screw[4] != 0 for screw in chain.screws_near(number, range(1, chain.links + 1))):
        return False
    if chain.task.frame == BODY:
        z = chain.robot.home[:3, 2]
    else:
        z = np.array([0.0, 0.0, 1.0])
    axis = chain.robot.joints[number - 1].screw[3:]  # all others are parallel, so it never moves
    return bool(np.linalg.norm(np.cross(axis, z)) <= ALIGNED)


def _best_axes(chain: Chain, form: BlockForm) -> BlockForm:
    """The same form about the same point in the axes in which the screws are shortest."""
    views = ((k, chain.screws_about(k, form.origin)) for k in range(1, chain.n + 1))
    link, columns = min(views, key=lambda view: _terms(view[1]))
    return replace(form, link=link, columns=columns)


def _terms(columns: Columns) -> int:
    return count_terms(columns)


def _part(structure: ExactStructure, kind: str, group: tuple[int, ...]) -> str:
    """Of the arm: what a group that moves about a point is."""
    if kind != "point":
        return ""
    return {structure.wrist: "wrist", structure.shoulder: "shoulder"}.get(group, "")


def _names(kind: str, group: tuple[int, ...], part: str) -> tuple[str, str]:
    """Of the blocks: a wrist, a shoulder, and what is left of the arm."""
    if kind == "point":
        return part or f"joints {joint_list(group)}", "arm"
    return {"slides": ("slides", "turns"), "last axis": ("last joint", "arm")}.get(kind, ("in plane", "out of plane"))


def frame_jacobian(chain: Chain, k: int, at: int | None = None) -> list[list[Polynomial]]:
    """ᵏJ: the task's rows of the Jacobian in the axes of link k (z along axis k, x along the normal after it).

    ᵏJ = ᵏR₀ ⁰J, row by row (ML's ¹J of the planar arm). It has the same singularities.

    Args:
        chain: from `exact_chain`.
        k: link, 1 … N.
        at: the reference point is the origin of this link's frame, 1 … N, on axis `at` where the normal after it
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
    if at is None:
        screws = chain.screws_at_tip(k)
    else:
        screws = chain.screws_about(k, at)
    return submatrix(screws, range(len(screws)), chain.task.rows)


def check_frame(chain: Chain, k: int, at: int | None) -> None:
    """Refuse axes and reference points that the task has no Jacobian for; raises as `frame_jacobian`."""
    for link, what in ((k, "frame"), (at, "at")):
        if link is not None and not 1 <= link <= chain.links:
            raise OptionError("there is no such link", where=what, got=link, allowed=f"1 … {chain.links}")
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
    points: list[int | None] = [None, *(range(1, chain.links + 1) if moves(chain) else ())]
    block_sizes = [
        (count_terms(frame_jacobian(chain, k, at)), k, at)
        for at in points
        for k in range(1, chain.links + 1)
    ]
    return sorted(block_sizes, key=lambda key: (key[0], key[2] is not None, key[2] or 0, key[1]))
