"""Robots from MJCF, as MuJoCo compiles it.

MuJoCo's own compiler reads MJCF (defaults, includes, frames, angles, joint limits), in a child process with limits: a
few characters may ask for gigabytes. Of its result the kinematics comes back as plain data. A body pose, then its
joints in order, each about its anchor in the body frame: with S_k the screw of joint k in the body frame and r_k its
`ref`, the body stands at T_parent · B · exp(S_1 (q_1 − r_1)) · exp(S_2 (q_2 − r_2)) …, so that q counts as MuJoCo's
qpos does.
"""

from __future__ import annotations

import shlex
import warnings
from importlib.util import find_spec
from math import inf
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from rankdrop.errors import MissingExtraError, RobotError
from rankdrop.jobs.limited import run_limited
from rankdrop.lists import flat_map
from rankdrop.robot.files import MOST_BODIES, RANGE, allowed_range, name_of_file, read_text, read_xml
from rankdrop.robot.model import Array, JointKind, Robot
from rankdrop.robot.note import NoteOn, RobotNote
from rankdrop.robot.quantities import Angles
from rankdrop.robot.transform import translation
from rankdrop.robot.tree import Motion, Tree, TreeJoint, chain_robot, choose_ends, connect_links

_KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}
_UNREAD = (
    "actuators", "sensors", "tendons", "equalities", "pairs", "excludes", "keys", "tuples", "skins", "flexes", "geoms",
    "cameras", "lights", "materials", "textures", "meshes", "hfields",
)  # fmt: skip
"""Taken out before compiling, users before what they use: mesh files are then neither needed nor opened."""


def from_mjcf(
    path: str | PathLike[str], *, base: str | None = None, tip: str | None = None, as_written: bool = False
) -> Robot:
    """A robot from an MJCF file.

    Only the chain from `base` to `tip` is read: bodies, hinge and slide joints, their axes, anchors, limits and `ref`.
    Geoms, meshes and actuators are ignored. Joint values are those of MuJoCo (qpos), in radians and metres.
    Rounded euler angles and structure that holds but for noise are taken as exact, with a note, as in `from_urdf`.

    Args:
        path: the file; files that it includes are read by MuJoCo.
        base, tip: names of bodies or sites; chosen where not given, and `Robot.notes` says how.
        as_written: take every number literally.

    Raises:
        MissingExtraError: mujoco is not installed.
        RobotError: MuJoCo cannot compile the file (in its words) or needs too much for it, a ball or free joint in the
            chain, names that are not there.
    """
    file = Path(path)
    root = read_xml(read_text(file), str(file), most=MOST_BODIES)  # limits on size and depth, no document types
    if find_spec("mujoco") is None:
        raise MissingExtraError("mujoco", "mujoco", "an MJCF file")
    name = root.attributes.get("model", name_of_file(file))
    model = run_limited(compile_file, str(file), as_written, file=file, parser="MuJoCo")
    return robot_of(model, name, str(file), base, tip, as_written=as_written)


def robot_of(
    model: dict[str, Any], name: str, place: str, base: str | None, tip: str | None, *, as_written: bool
) -> Robot:
    """The chain from `base` to `tip` of a compiled model.

    Args:
        model: from `plain_model`.
        name: of the robot.
        place: the file, for errors and `Robot.source`.
        base, tip: names of bodies or sites; None: chosen.
        as_written: take every number literally.

    Raises:
        RobotError: a ball or free joint in the chain, names that are not there.
    """
    links = dict.fromkeys(model["bodies"], 0)
    steps = {step["name"]: step for step in model["steps"]}
    joints = {key: TreeJoint(key, step["kind"], step["parent"], step["child"]) for key, step in steps.items()}
    links |= dict.fromkeys((joint.child for joint in joints.values()), 0)
    tree = connect_links(Tree(name, place, links, joints))
    _refuse_floating(tree, model["floating"], base, tip)
    ends = choose_ends(tree, base, tip)
    moving = {step.name for step in ends.path if step.moves}
    notes = [RobotNote(NoteOn.COUPLED, *pair) for pair in model["couplings"] if moving.issuperset(pair)]
    if ends.base in model["floating"]:
        notes.insert(0, RobotNote(NoteOn.FLOATS, ends.base))
    links_of_chain = {"", *flat_map(lambda step: (step.parent, step.child), ends.path)}
    angles = Angles(as_written, flat_map(lambda link: model["changes"].get(link, ()), links_of_chain))
    return chain_robot(tree, ends, "mjcf", lambda joint: _motion(tree, joint, steps[joint.name]), angles, notes)


def compile_file(file: str, as_written: bool) -> dict[str, Any]:
    """The compiled model of bodies, joints and sites as plain data; runs in a child process.

    Raises:
        RobotError: MuJoCo cannot compile the file, or it has too many bodies.
    """
    import mujoco

    try:
        spec = mujoco.MjSpec.from_file(file)
        if len(spec.bodies) > MOST_BODIES:
            raise RobotError("there are too many bodies", where=file, allowed=f"at most {MOST_BODIES}")
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
            return plain_model(mujoco, spec.compile(), couplings, changes)
    except (RobotError, MemoryError):
        raise
    except Exception as error:  # ValueError, RuntimeError, FatalError
        reason = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
        raise RobotError(f"MuJoCo cannot compile the file: {reason[:200]}", where=file) from None


def plain_model(
    mujoco: Any, model: Any, couplings: list[tuple[str, str]], changes: dict[str, list[float]]
) -> dict[str, Any]:
    """Bodies and named sites of an MjModel as steps down the tree, and the bodies that float: roots on no joint.

    Args:
        mujoco: the package.
        model: its MjModel.
        couplings: pairs of joints that a constraint couples.
        changes: what was added to angles [rad], by body or site.
    """
    bodies = [model.body(i).name or f"body{i}" for i in range(model.nbody)]
    links = set(bodies)
    floating: list[str] = []
    steps: list[dict[str, Any]] = []

    def add(name: str, kind: str, parent: str, child: str, pose: tuple[Any, Any], joint: int | None = None) -> None:
        moves = {} if joint is None else {
            "axis": model.jnt_axis[joint].tolist(), "anchor": model.jnt_pos[joint].tolist(),
            "ref": float(model.qpos0[model.jnt_qposadr[joint]]),
            "limits": model.jnt_range[joint].tolist() if model.jnt_limited[joint] else [-inf, inf],
        }  # fmt: skip
        place = {"position": list(map(float, pose[0])), "quaternion": list(map(float, pose[1]))}
        steps.append({"name": name, "kind": kind, "parent": parent, "child": child, **place, **moves})

    for i in range(1, model.nbody):
        parent, pose = bodies[model.body_parentid[i]], (model.body_pos[i], model.body_quat[i])
        first, count = int(model.body_jntadr[i]), int(model.body_jntnum[i])
        if count and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE:  # always alone in its body
            floating.append(bodies[i])
            continue
        if count == 0:
            add(f"{bodies[i]} (fixed)", "fixed", parent, bodies[i], pose)
        for part, j in enumerate(range(first, first + count), start=1):
            joint_name = model.joint(j).name or (f"{bodies[i]}_joint" if count == 1 else f"{bodies[i]}_joint{part}")
            if part == count:
                child = bodies[i]
            else:
                child = f"{bodies[i]} after {joint_name}"
            kind = mujoco.mjtJoint(model.jnt_type[j]).name.removeprefix("mjJNT_").lower()
            add(joint_name, kind, parent, child, pose, j)
            links.add(child)
            parent, pose = child, ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))
    for i in range(model.nsite):
        site = model.site(i).name
        if site:
            if site not in links:
                link = site
            else:
                link = f"{site} (site)"
            links.add(link)
            add(f"{site} (site, fixed)", "fixed", bodies[model.site_bodyid[i]], link,
                (model.site_pos[i], model.site_quat[i]))  # fmt: skip
    return {"bodies": bodies, "steps": steps, "floating": floating, "couplings": couplings, "changes": changes}


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


def _motion(tree: Tree, joint: TreeJoint, step: dict[str, Any]) -> Motion:
    origin = _pose(np.array(step["position"]), np.array(step["quaternion"]))
    if not joint.moves:
        return Motion(origin)
    if joint.kind not in _KINDS:
        raise RobotError(
            "a joint of the chain has several freedoms", where=tree.place_of(joint), got=f"a {joint.kind} joint",
            allowed="hinge, slide", mend=f"name a base below it: base={joint.child!r}",
            typed=f"name a base below it: --base {shlex.quote(joint.child)}",
        )
    kind, ref = _KINDS[joint.kind], step["ref"]
    if not abs(ref) <= RANGE[kind.measure]:  # MuJoCo takes NaN and infinities too
        raise RobotError("ref is too large, or no number", where=tree.place_of(joint), got=f"{ref:g}",
                         allowed=allowed_range(kind.measure))  # fmt: skip
    lower, upper = step["limits"]
    return Motion(origin, kind, _plain(np.array(step["axis"])), np.array(step["anchor"]), ref=ref, lower=lower,
                  upper=upper)  # fmt: skip


def _pose(position: Array, quaternion: Array) -> Array:
    w, x, y, z = quaternion
    pose = translation(*position)
    with np.errstate(invalid="ignore"):  # `chain_robot` refuses numbers that are not finite
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
