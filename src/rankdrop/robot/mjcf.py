"""Robots from MJCF, compiled by the package mujoco (extra "mujoco"): the chain of bodies from a base to a tip.

MuJoCo's own compiler resolves defaults, includes, frames, angles and joint limits; of its result the kinematics is
read. A body pose, then its joints in order, each about its anchor in the body frame: with S_k the screw of joint k in
the body frame and r_k its `ref`, the body stands at T_parent · B · exp(S_1 (q_1 − r_1)) · exp(S_2 (q_2 − r_2)) …, so
that q counts as MuJoCo's qpos does.
"""

from __future__ import annotations

import shlex
import warnings
from dataclasses import dataclass
from math import inf
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError, visible
from rankdrop.robot.files import MOST_BODIES, RANGE, Element, allowed_range, read_text, read_xml
from rankdrop.robot.meant import as_meant
from rankdrop.robot.model import Array, Joint, JointKind, Robot, Source, check_joints
from rankdrop.robot.quantities import Angles
from rankdrop.robot.transform import about_axis, times, translation
from rankdrop.robot.urdf_tree import Tree, TreeJoint, choose_ends, connected

_KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}
_NOWHERE = Element("joint", {}, 0)  # the compiler keeps no lines
_UNREAD = (
    "actuators", "sensors", "tendons", "equalities", "pairs", "excludes", "keys", "tuples", "skins", "flexes", "geoms",
    "cameras", "lights", "materials", "textures", "meshes", "hfields",
)  # fmt: skip
"""Taken out before compiling, users before what they use: mesh files are then neither needed nor opened."""


@dataclass(frozen=True, slots=True)
class _Motion:
    """One step down the tree: the pose where it starts in the frame of its parent, and the joint there, if it moves."""

    origin: Array  # (4, 4)
    axis: Array  # (3,) in the frame at `origin`; zero where nothing moves
    anchor: Array  # (3,) a point of the axis in that frame
    ref: float  # value of the joint in the pose of the file
    lower: float
    upper: float


def from_mjcf(
    path: str | PathLike[str], *, base: str | None = None, tip: str | None = None, as_written: bool = False
) -> Robot:
    """A robot from an MJCF file.

    Only the chain from `base` to `tip` is read: bodies, hinge and slide joints, their axes, anchors, limits and `ref`.
    Geoms, meshes and actuators are not looked at. Joint values are those of MuJoCo (qpos), in radians and metres.
    Rounded euler angles and structure that holds but for noise are taken as exact, with a note, as in `from_urdf`.

    Args:
        path: the file; files that it includes are read by MuJoCo.
        base, tip: names of bodies or sites; chosen where not given, and `Robot.notes` says how.
        as_written: take every number literally.

    Raises:
        MissingExtraError: mujoco is not installed.
        RobotError: MuJoCo cannot compile the file (in its words), a ball or free joint in the chain, names that are
            not there.
    """
    file = Path(path)
    root = read_xml(read_text(file), str(file), most=MOST_BODIES)  # limits on size and depth, no document types
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError("mujoco", "mujoco", "an MJCF file") from None
    name = root.attributes.get("model", visible(file.stem))
    model, couplings, changes = _compiled(mujoco, file, as_written)
    return robot_of(mujoco, model, name, str(file), couplings, changes, base, tip, as_written=as_written)


def robot_of(
    mujoco: Any,
    model: Any,
    name: str,
    place: str,
    couplings: list[tuple[str, str]],
    changes: dict[str, list[float]],
    base: str | None,
    tip: str | None,
    *,
    as_written: bool,
) -> Robot:
    """The chain from `base` to `tip` of a compiled model.

    Args:
        mujoco: the package.
        model: its MjModel.
        name: of the robot.
        place: the file, for errors and `Robot.source`.
        couplings: pairs of joints that a constraint couples.
        changes: what was added to angles [rad], by body or site.
        base, tip: names of bodies or sites; None: chosen.
        as_written: take every number literally.

    Raises:
        RobotError: a ball or free joint in the chain, names that are not there.
    """
    motions: dict[str, _Motion] = {}
    tree, floating = _tree(mujoco, model, name, place, motions)
    _refuse_floating(tree, floating, base, tip)
    ends = choose_ends(tree, base, tip)
    joints, home = _chain(tree, ends.path, motions)
    names = {joint.name for joint in joints}
    notes = [f"joint {one!r} is coupled to {two!r} by a constraint: they are taken as independent"
             for one, two in couplings if {one, two} <= names]  # fmt: skip
    if ends.base in floating:
        notes.insert(0, f"body {ends.base!r} floats freely: its own motion is not counted")
    found = Robot(
        name, joints, home, source=Source("mjcf", place), base=ends.base, tip=ends.tip,
        notes=(*ends.notes, *notes), about=f"{ends.base} to {ends.tip}",
    )
    on_chain = {"", *(link for step in ends.path for link in (step.parent, step.child))}
    return as_meant(found, Angles(as_written, [x for link in on_chain for x in changes.get(link, ())]))


def _compiled(
    mujoco: Any, file: Path, as_written: bool
) -> tuple[Any, list[tuple[str, str]], dict[str, list[float]]]:
    """The compiled model of bodies, joints and sites; pairs of joints that an equality couples; angles."""
    try:
        spec = mujoco.MjSpec.from_file(str(file))
        couplings = [(rule.name1, rule.name2) for rule in spec.equalities if rule.type == mujoco.mjtEq.mjEQ_JOINT]
        for kind in _UNREAD:
            for element in list(getattr(spec, kind)):
                _delete(spec, element)
        for site in spec.sites:
            site.material = ""
        changes = _take_angles(mujoco, spec, as_written)
        spec.compiler.fusestatic = False  # bodies without joints keep their names
        for body in spec.bodies[1:]:  # without geoms a body has no mass of its own, and MuJoCo wants one
            body.explicitinertial, body.mass, body.inertia = True, 1.0, [1.0, 1.0, 1.0]
            body.fullinertia = [np.nan] * 6
        with warnings.catch_warnings():  # of inertias that are none of the file's
            warnings.simplefilter("ignore", UserWarning)
            return spec.compile(), couplings, changes
    except (ValueError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
        raise RobotError(f"MuJoCo cannot compile the file: {reason[:300]}", where=str(file)) from None


def _delete(spec: Any, element: Any) -> None:
    if hasattr(spec, "delete"):
        spec.delete(element)
    else:  # MuJoCo before 3.3.4
        element.delete()


def _take_angles(mujoco: Any, spec: Any, as_written: bool) -> dict[str, list[float]]:
    """Let rounded decimals in radians be the angles they stand for (see `digits`), in euler and axisangle.

    Returns:
        what was added to each number that was changed [rad], by the name of the body or site; "" for frames.
    """
    changes: dict[str, list[float]] = {}
    if spec.compiler.degree:
        return changes
    kinds = mujoco.mjtOrientation
    for elements, framed in ((spec.bodies, False), (spec.sites, False), (spec.frames, True)):
        for element in elements:
            angles, alt = Angles(as_written), element.alt
            if alt.type == kinds.mjORIENTATION_EULER:
                alt.euler = [angles.take(repr(float(x))) for x in alt.euler]  # repr has the digits of the file
            elif alt.type == kinds.mjORIENTATION_AXISANGLE:
                alt.axisangle = [*alt.axisangle[:3], angles.take(repr(float(alt.axisangle[3])))]
            changes.setdefault("" if framed else element.name, []).extend(angles.changes)
    return changes


def _refuse_floating(tree: Tree, floating: list[str], base: str | None, tip: str | None) -> None:
    """Say clearly that no chain passes a free joint; what else is wrong with the names is for `choose_ends`."""
    if base not in tree.links or tip not in tree.links:
        return
    root = tree.root_of(str(tip))
    if root in floating and tree.root_of(str(base)) != root:
        raise RobotError(
            "the chain would pass a free joint, which has several freedoms", where=f"{tree.file}, body {root!r}",
            got=f"base {base!r}, tip {tip!r}", mend=f"base={root!r}", typed=f"--base {shlex.quote(root)}",
        )


def _tree(
    mujoco: Any, model: Any, name: str, file: str, motions: dict[str, _Motion]
) -> tuple[Tree, list[str]]:
    """Bodies and named sites as links, and the bodies that float: roots of their own, on no joint.

    `motions` is filled, by the names of the tree's joints.
    """
    bodies = [model.body(i).name or f"body{i}" for i in range(model.nbody)]
    links = dict.fromkeys(bodies, 0)
    joints: dict[str, TreeJoint] = {}
    floating: list[str] = []

    def add(name: str, kind: str, parent: str, child: str, motion: _Motion) -> None:
        links[child] = 0
        joints[name] = TreeJoint(name, kind, parent, child, _NOWHERE)
        motions[name] = motion

    for i in range(1, model.nbody):
        parent = bodies[model.body_parentid[i]]
        pose = _pose(model.body_pos[i], model.body_quat[i])
        count = model.body_jntnum[i]
        if count and model.jnt_type[model.body_jntadr[i]] == mujoco.mjtJoint.mjJNT_FREE:  # always alone in its body
            floating.append(bodies[i])
            continue
        if count == 0:
            add(f"{bodies[i]} (fixed)", "fixed", parent, bodies[i], _still(pose))
        for part, j in enumerate(range(model.body_jntadr[i], model.body_jntadr[i] + count), start=1):
            own = model.joint(j).name or (f"{bodies[i]}_joint" if count == 1 else f"{bodies[i]}_joint{part}")
            child = bodies[i] if part == count else f"{bodies[i]} after {own}"
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            add(own, kind, parent, child, _motion(model, j, pose))
            parent, pose = child, np.eye(4)
    for i in range(model.nsite):
        site = model.site(i).name
        if site:
            place = _still(_pose(model.site_pos[i], model.site_quat[i]))
            link = site if site not in links else f"{site} (site)"
            add(f"{site} (site, fixed)", "fixed", bodies[model.site_bodyid[i]], link, place)
    return connected(Tree(name, file, links, joints)), floating


def _still(pose: Array) -> _Motion:
    return _Motion(pose, np.zeros(3), np.zeros(3), 0.0, -inf, inf)


def _motion(model: Any, j: int, pose: Array) -> _Motion:
    lower, upper = model.jnt_range[j] if model.jnt_limited[j] else (-inf, inf)
    ref = float(model.qpos0[model.jnt_qposadr[j]])
    axis, anchor = _plain(np.array(model.jnt_axis[j])), np.array(model.jnt_pos[j])
    return _Motion(pose, axis, anchor, ref, float(lower), float(upper))


def _pose(position: Array, quaternion: Array) -> Array:
    """(4, 4) pose from a position [m] and a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    pose = translation(*position)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, :3] = _plain(pose[:3, :3])
    return pose


def _plain(values: Array) -> Array:
    """Entries of directions that are 0 or ±1 but for the rounding of a quaternion (a few 2e-16): so, exactly."""
    near = np.round(values)
    return np.where(np.abs(values - near) < 1e-15, near, values) + 0.0


def _chain(tree: Tree, path: list[TreeJoint], motions: dict[str, _Motion]) -> tuple[tuple[Joint, ...], Array]:
    """The joints of the chain and the pose of the tip at q = 0."""
    check_joints(sum(step.moves for step in path), tree.file, steps=len(path))
    pose = np.eye(4)
    joints = []
    for step in path:
        motion = motions[step.name]
        pose = times(pose, motion.origin)
        if not step.moves:
            continue
        if step.kind not in _KINDS:
            raise RobotError(
                "a joint of the chain has several freedoms", where=tree.where(step), got=f"a {step.kind} joint",
                allowed="hinge, slide", mend=f"name a base below it: base={step.child!r}",
                typed=f"name a base below it: --base {shlex.quote(step.child)}",
            )
        kind = _KINDS[step.kind]
        direction, point = times(pose[:3, :3], motion.axis), pose[:3, 3] + times(pose[:3, :3], motion.anchor)
        slides = kind is JointKind.PRISMATIC
        measure = "length" if slides else "angle"
        if not abs(motion.ref) <= RANGE[measure]:  # MuJoCo takes NaN and infinities too
            raise RobotError("ref is too large, or no number", where=tree.where(step), got=f"{motion.ref:g}",
                             allowed=allowed_range(measure))  # fmt: skip
        screw = np.concatenate([direction, np.zeros(3)] if slides else [np.cross(point, direction), direction]) + 0.0
        pose = times(pose, _back(motion, slides=slides))
        joints.append(Joint(step.name, kind, screw, motion.lower, motion.upper, inf, pose, link=step.child))
    return tuple(joints), pose


def _back(motion: _Motion, *, slides: bool) -> Array:
    """(4, 4) from where the file shows the joint, at q = ref, to q = 0, in the frame of its body."""
    if motion.ref == 0.0:
        return np.eye(4)
    if slides:
        return translation(*(-motion.ref * motion.axis))
    return times(translation(*motion.anchor), about_axis(motion.axis, -motion.ref), translation(*-motion.anchor))
