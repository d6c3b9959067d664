"""The structure of an arm over the exact ring in words: its axes, what was rounded, how its Jacobian parts."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from rankdrop.exact.arm.chain import Chain
from rankdrop.exact.arm.structure import BlockForm, joint_list, structure_of
from rankdrop.exact.decoupling import BlockLoss, LostLine
from rankdrop.exact.method_reason import MethodReason, Parting, PartingKind
from rankdrop.exact.remark import chain_remarks, near_structure
from rankdrop.lists import flat_map
from rankdrop.tolerances import ALIGNED

_DOES_NOT_PART = {
    PartingKind.COUPLED: "joints follow others",
    PartingKind.NOT_SQUARE: "{n} joints for {m} freedoms: the Jacobian is not square, so that it has no two square "
    "blocks",
    PartingKind.ARM_NOT_SQUARE: "{n} joints for {m} freedoms: with a spherical {part} the Jacobian is block "
    "triangular, but the arm's block is 3 × {rest}. Where the {part} alone loses a freedom, null motions of the arm "
    "may make up for it",
    PartingKind.TOO_FEW_JOINTS: "{n} joints never reach the {m} freedoms of the task: the Jacobian has more rows than "
    "columns",
    PartingKind.ALWAYS_SINGULAR: "the arm is singular at every configuration",
}
"""Why a Jacobian does not part; an arm in one piece has more to say."""
_PLANAR = {2: "planar pair", 3: "planar triple"}
"""Parallel axes that move points in a plane, by their number."""


def structure_sentences(chain: Chain) -> tuple[str, ...]:
    """Relations of the axes, near misses, and last the roundings.

    Example:
        >>> from rankdrop.exact.arm.chain import exact_chain
        >>> from rankdrop.robot.open import open_robot
        >>> structure_sentences(exact_chain(open_robot("puma560")))[0]
        'the axes of joints 4, 5, 6 meet in one point (spherical wrist)'
    """
    structure = structure_of(chain)
    sentences = []
    if structure.srs:
        sentences.append("S-R-S: spherical shoulder, elbow, spherical wrist")
    for triple in structure.points:
        part = {structure.wrist: " (spherical wrist)", structure.shoulder: " (spherical shoulder)"}.get(triple, "")
        sentences.append(f"the axes of joints {joint_list(triple)} meet in one point{part}")
    within = set(flat_map(pairwise, structure.points))
    sentences += [f"axes {i} and {j} meet" for i, j in structure.meeting if (i, j) not in within]
    sentences += [f"the axes of joints {joint_list(group)} are parallel" for group in structure.parallel]
    sentences += [f"near-structural: {near}" for near in near_structure(chain)]
    remarks = chain_remarks(chain)
    if remarks:
        sentences.append(f"twists are multiples of 15° and 18° where they are that within {ALIGNED:g} rad")
        sentences += map(str, remarks)
    return tuple(sentences)


def form_sentence(form: BlockForm) -> str:
    """Reference point and axes of a block triangular Jacobian."""
    axes = f"those of link {form.link}: z along joint {form.link}, x along the common normal after it"
    return f"Reference point: {point_text(form)}. Axes: {axes}."


def point_text(form: BlockForm) -> str:
    """The reference point of a block triangular Jacobian."""
    if form.kind == "point":
        where = f"the point where axes {joint_list(form.group)} meet"
        if form.part:
            return f"the {form.part} centre, {where}"
        return where
    if form.origin:
        return f"the foot of the common normal after joint {form.origin}, on its axis"
    return "the tip"


def parting_text(parting: Parting) -> str:
    """How a Jacobian parts into two square blocks, or why it does not."""
    kind = parting.kind
    if kind is PartingKind.ONE_PIECE:
        if parting.rows == 6:
            return "no three axes meet in one point, are parallel or slide: the Jacobian stays in one piece"
        return "the Jacobian stays in one piece"
    if kind in _DOES_NOT_PART:
        n, m = parting.columns, parting.rows
        return _DOES_NOT_PART[kind].format(n=n, m=m, rest=n - 3, part=parting.part)
    return _group_text(parting)


def _group_text(parting: Parting) -> str:
    """Why the first block's joints leave the other rows at zero."""
    joints = joint_list(parting.joints)
    if parting.kind is PartingKind.POINT:
        part = f"spherical {parting.part or 'group'}"
        return f"{part}: axes {joints} meet in one point, and turning about them does not move it"
    if parting.kind is PartingKind.SLIDES:
        return f"three slides: joints {joints} do not turn the end effector"
    if parting.kind is PartingKind.LAST_AXIS:
        return f"planar arm: joint {joints} does not move the points of its own axis"
    if parting.kind is PartingKind.PLANE_AND_SLIDE:
        return f"joints {joints} turn the end effector about one direction only"
    if parting.turns:
        planar = _PLANAR[len(parting.joints)]
        return f"{planar}: axes {joints} are parallel, and turning about them moves every point in a plane across them"
    return f"planar group: joints {joints} move every point in one plane"


def loss_text(loss: BlockLoss) -> str:
    """The motion that a block loses, by the lines of the arm."""
    axes = joint_list(loss.joints)
    if loss.line is LostLine.ACROSS:
        return f"motions in the plane across axes {axes} have no part along the line that meets these axes"
    if loss.line is LostLine.ALONG:
        others = f"axis {joint_list(loss.others)}"
        if len(loss.others) > 1:
            others = f"axes {joint_list(loss.others)}"
        return f"the points of the line that is parallel to axes {axes} and meets {others} cannot move along it"
    centre = f"{loss.centre} centre".strip()
    first, last = loss.joints[0], loss.joints[-1]
    if loss.line is LostLine.ABOUT:
        where = f"the perpendicular to axes {first} and {last}"
        return f"with the {centre} at rest the end effector cannot rotate about {where}"
    return f"the {centre} cannot translate {_line_text(loss.line, first, last)}"


def _line_text(line: LostLine, first: int, last: int) -> str:
    """Where a centre cannot translate."""
    if line is LostLine.PARALLEL:
        return f"parallel to axis {first}"
    if line is LostLine.FROM_AXIS:
        return f"along the perpendicular from axis {first} to it"
    if line is LostLine.PERPENDICULAR:
        return f"perpendicular to axes {first} and {last}"
    shoulder = ""
    if (first, last) == (1, 2):
        shoulder = "the shoulder, "
    return f"along the line from {shoulder}where axes {first} and {last} meet, to it"


def reason_text(reason: MethodReason) -> str:
    """Why corank 1 was derived by its method, and which methods were not run."""
    return "; ".join(_reasons(reason))


def _reasons(reason: MethodReason) -> Iterator[str]:
    if reason.interrupted:
        yield "interrupted before another method was tried"
        return
    if reason.parting is None:
        yield "asked for"
    else:
        yield parting_text(reason.parting)
    if reason.terms:
        *others, last = reason.not_run
        if others:
            names = f"{', '.join(others)} and {last} were"
        else:
            names = f"{last} was"
        yield f"conditions have up to {reason.terms:,} terms: {names} not run; each can be asked for"
    if reason.unfactored:
        yield f"minors that were not factored in time, and stand as they are: {reason.unfactored}"
    if reason.unfinished:
        yield f"the method {reason.unfinished} was tried and did not finish"
