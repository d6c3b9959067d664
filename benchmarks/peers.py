"""The other side: the same arm in other libraries, each at its quickest, checked against the same Jacobian first.

A library that is not installed is named with the command that installs it, and left out.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import measure  # noqa: F401  # first: sets the number of threads
import numpy as np
from reference import kinematics

from rankdrop.robot.model import Array, Robot

INSTALL = {
    "Pinocchio": ("pinocchio", "pip install pin"),
    "CasADi": ("casadi", "pip install casadi"),
    "JAX": ("jax", "pip install jax"),
    "MuJoCo": ("mujoco", "pip install mujoco"),
    "Robotics Toolbox": ("roboticstoolbox", "pip install roboticstoolbox-python"),
    "KDL": ("PyKDL", "pip install PyKDL"),
    "SciPy": ("scipy", "pip install scipy"),
    "SymPy": ("sympy", "pip install sympy"),
}
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"  # JAX: one thread


def missing(*names: str) -> dict[str, str]:
    """Those of the libraries that are not here, with the command that installs them."""
    return {name: INSTALL[name][1] for name in names if importlib.util.find_spec(INSTALL[name][0]) is None}


@dataclass
class Peer:
    """What one library does: functions of one configuration (n,) and of many (B, n), where it has them."""

    name: str
    one: dict[str, Callable[[Array], Any]] = field(default_factory=dict)
    many: dict[str, Callable[[Array], Any]] = field(default_factory=dict)


def all_of(robot: Robot, rows: int) -> Iterator[Peer]:
    """Every peer that is installed, for one arm of turning joints; `rows` configurations at a time in batches."""
    makers = {"Pinocchio": pinocchio, "CasADi": casadi, "JAX": jax, "MuJoCo": mujoco, "Robotics Toolbox": toolbox,
              "KDL": kdl}  # fmt: skip
    for name, make in makers.items():
        if not missing(name):
            yield make(robot, rows)
    yield numpy(robot, rows)


def numpy(robot: Robot, _rows: int) -> Peer:
    """Batched NumPy: the oracle of the tests, and `numpy.linalg.svd` on its Jacobians."""
    def jacobian(q: Array) -> Array:
        return kinematics.jacobian(robot, q)

    return Peer("NumPy", {"J": jacobian}, {
        "J": jacobian,
        "dJ": lambda q: kinematics.jacobian_derivative(robot, q),
        "σ": lambda q: np.linalg.svd(jacobian(q), compute_uv=False),
        "U, σ, V": lambda q: np.linalg.svd(jacobian(q)),
    })  # fmt: skip


def turning_about_z(robot: Robot) -> tuple[Any, int]:
    """The arm in Pinocchio with joints about z, its quickest kind, and the number of its tip."""
    import pinocchio as pin

    model, parent, placed = pin.Model(), 0, pin.SE3.Identity()
    for joint in robot.joints:
        axis = joint.screw[3:]
        turn = np.linalg.svd(axis[None])[2][[1, 2, 0]].T  # columns: two normals, then ± the axis
        turn[:, 2] = axis
        turn[:, 0] *= np.sign(np.linalg.det(turn))
        here = pin.SE3(turn, np.cross(axis, joint.screw[:3]))
        parent = model.addJoint(parent, pin.JointModelRZ(), placed.inverse() * here, joint.name)
        placed = here
    tip = placed.inverse() * pin.SE3(robot.home)
    return model, model.addFrame(pin.Frame("tip", parent, tip, pin.FrameType.OP_FRAME))


def pinocchio(robot: Robot, _rows: int) -> Peer:
    """`computeFrameJacobian` in the axes of the base; its derivative needs `computeJointKinematicHessians`."""
    import pinocchio as pin

    model, tip = turning_about_z(robot)
    data, frame, joint = model.createData(), pin.LOCAL_WORLD_ALIGNED, model.njoints - 1

    def derivative(q: Array) -> Any:
        pin.computeJointJacobians(model, data, q)
        pin.computeJointKinematicHessians(model, data)
        return pin.getJointKinematicHessian(model, data, joint, frame)

    return Peer("Pinocchio", {"J": lambda q: pin.computeFrameJacobian(model, data, q, tip, frame), "dJ": derivative})


def casadi(robot: Robot, rows: int) -> Peer:
    """Generated C, compiled with -O3 -march=native, called with memory that is there; batches by a loop in C."""
    import casadi as ca

    q = ca.SX.sym("q", robot.n)
    turn, place, columns = ca.SX.eye(3), ca.SX.zeros(3, 1), []
    for i, joint in enumerate(robot.joints):
        v, w = joint.screw[:3], joint.screw[3:]
        columns.append((turn @ v + ca.cross(place, turn @ w), turn @ w))
        hat = ca.DM(np.cross(np.eye(3), w))
        s, d = ca.sin(q[i]), 1 - ca.cos(q[i])
        step = s * hat + d * (hat @ hat)
        place = place + turn @ (-(step @ np.cross(w, v)))
        turn = turn @ (ca.SX.eye(3) + step)
    tip = turn @ robot.home[:3, 3] + place
    jacobian = ca.horzcat(*[ca.vertcat(v + ca.cross(w, tip), w) for v, w in columns])
    derivative = ca.densify(ca.jacobian(ca.vec(jacobian.T), q).T)  # column by column: [a, i, k] row by row
    functions = {"J": ca.densify(jacobian.T), "dJ": derivative}
    size = {"J": 6 * robot.n, "dJ": 6 * robot.n**2}
    peer, folder = Peer("CasADi C"), Path(tempfile.mkdtemp())
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        return peer
    for short, expression in functions.items():
        name = {"J": "columns", "dJ": "slopes"}[short]
        function = ca.Function(name, [q], [expression])
        source = folder / f"{name}.c"
        generator = ca.CodeGenerator(source.name, {"with_header": False})
        generator.add(function)
        generator.generate(f"{folder}/")
        loop = (f"void {name}_all(const double* q, double* out, long rows) {{ double w[{max(1, function.sz_w())}]; "
                f"for (long i = 0; i < rows; ++i) {{ const double* arg[] = {{q + {robot.n} * i, 0}}; "
                f"double* res[] = {{out + {size[short]} * i, 0}}; {name}(arg, res, 0, w, 0); }} }}\n")  # fmt: skip
        source.write_text(source.read_text() + loop)
        library = folder / f"{name}.so"
        flags = ["-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC"]
        subprocess.run([compiler, *flags, str(source), "-lm", "-o", str(library)], check=True)
        whole = getattr(ctypes.CDLL(str(library)), f"{name}_all")
        whole.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long]
        there = np.empty((rows, size[short]))
        peer.many[short] = _looped(whole, there)
        peer.one[short] = _buffered(ca.external(name, str(library)), robot.n, size[short])
    return peer


def _looped(function: Any, out: Array) -> Callable[[Array], Array]:
    def run(q: Array) -> Array:
        function(q.ctypes.data, out.ctypes.data, len(q))
        return out[: len(q)]

    return run


def _buffered(function: Any, n: int, size: int) -> Callable[[Array], Array]:
    """CasADi's own quickest way from Python: memory is told once, a call only triggers."""
    buffer, trigger = function.buffer()
    q, out = np.empty(n), np.empty(size)
    buffer.set_arg(0, memoryview(q))
    buffer.set_res(0, memoryview(out))

    def run(now: Array) -> Array:
        q[:] = now
        trigger()
        return out

    run.kept = buffer  # type: ignore[attr-defined]  # the trigger does not keep it
    return run


def jax(robot: Robot, _rows: int) -> Peer:
    """`jit` of one configuration and of `vmap`, double precision, on the processor; what is compiled is not counted."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    screws, home = np.array([joint.screw for joint in robot.joints]), robot.home[:3, 3]
    hats = np.array([np.cross(np.eye(3), w) for w in screws[:, 3:]])
    moved = np.cross(screws[:, 3:], screws[:, :3])

    def jacobian(q: Any) -> Any:
        turn, place, v, w = jnp.eye(3), jnp.zeros(3), [], []
        for i in range(robot.n):
            axis = turn @ screws[i, 3:]
            v.append(turn @ screws[i, :3] + jnp.cross(place, axis))
            w.append(axis)
            step = jnp.sin(q[i]) * hats[i] + (1 - jnp.cos(q[i])) * (hats[i] @ hats[i])
            place = place - turn @ (step @ moved[i])
            turn = turn + turn @ step
        linear, angular = jnp.stack(v, 1), jnp.stack(w, 1)
        return jnp.concatenate([linear + jnp.cross(angular, (turn @ home + place)[:, None], axis=0), angular])

    functions = {
        "J": jacobian, "dJ": jax.jacfwd(jacobian),
        "σ": lambda q: jnp.linalg.svd(jacobian(q), compute_uv=False), "U, σ, V": lambda q: jnp.linalg.svd(jacobian(q)),
    }  # fmt: skip

    def ready(function: Any) -> Callable[[Array], Any]:
        return lambda q: jax.block_until_ready(function(q))

    return Peer("JAX", {name: ready(jax.jit(functions[name])) for name in ("J", "dJ")},
                {name: ready(jax.jit(jax.vmap(one))) for name, one in functions.items()})  # fmt: skip


def mujoco(robot: Robot, _rows: int) -> Peer:
    """`mj_kinematics`, `mj_comPos`, `mj_jacSite` into memory that is there."""
    import mujoco as mj

    from rankdrop.robot import to_mujoco

    model = to_mujoco(robot)
    data, out = mj.MjData(model), np.empty((6, robot.n))
    site = mj.mj_name2id(model, mj.mjtObj.mjOBJ_SITE, robot.tip)

    def jacobian(q: Array) -> Array:
        data.qpos[:] = q
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        mj.mj_jacSite(model, data, out[:3], out[3:], site)
        return out

    return Peer("MuJoCo", {"J": jacobian})


def toolbox(robot: Robot, _rows: int) -> Peer:
    """`jacob0` and `hessian0` of the elementary transforms, which its own C code runs through."""
    from rankdrop.robot import to_toolbox

    arm = to_toolbox(robot).ets()
    return Peer("Robotics Toolbox", {"J": arm.jacob0, "dJ": arm.hessian0})


def kdl(robot: Robot, _rows: int) -> Peer:
    """`ChainJntToJacSolver`, reference point at the tip, axes of the base."""
    import PyKDL

    chain, placed = PyKDL.Chain(), PyKDL.Frame.Identity()
    for joint, nearer in zip(robot.joints, [*robot.joints[1:], None], strict=True):
        w = joint.screw[3:]
        at = np.cross(w, joint.screw[:3])
        last = robot.home[:3, 3] if nearer is None else np.cross(nearer.screw[3:], nearer.screw[:3])
        here = PyKDL.Frame(PyKDL.Vector(*last))
        turning = PyKDL.Joint(joint.name, placed.Inverse() * PyKDL.Vector(*at), PyKDL.Vector(*w), PyKDL.Joint.RotAxis)
        chain.addSegment(PyKDL.Segment(joint.name, turning, placed.Inverse() * here))
        placed = here
    solver, out, there = PyKDL.ChainJntToJacSolver(chain), PyKDL.Jacobian(robot.n), PyKDL.JntArray(robot.n)

    def jacobian(q: Array) -> Any:
        for i in range(robot.n):
            there[i] = q[i]
        solver.JntToJac(there, out)
        return out

    return Peer("KDL", {"J": jacobian})
