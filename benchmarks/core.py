"""Jacobian, derivative, σ and decomposition of the PA-10, one by one and in batches, beside other libraries."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import measure  # first: sets the number of threads
import numpy as np
import peers
from reference import arms

from rankdrop import _core
from rankdrop.kinematics import chain_of, frame_view, jacobian, jacobian_derivative
from rankdrop.robot.model import Array
from rankdrop.task import WORLD_ALIGNED

AT_LEAST = {("J", "one", "Pinocchio"): 1.0, ("dJ", "one", "CasADi C"): 1.0, ("dJ", "many", "CasADi C"): 1.0,
            ("U, σ, V", "many", "NumPy"): 5.0}  # fmt: skip
"""What is claimed: our time is at most that of the peer divided by this."""


def in_a_loop(function: Callable[[Array], Any], sample: list[Array]) -> Callable[[], None]:
    """A new configuration at every call."""
    def run() -> None:
        for q in sample:
            function(q)

    return run


def ours(robot: Any, rows: int) -> peers.Peer:
    """Free functions of Python for single configurations; the core with `out=` on one thread for batches."""
    chain, view = chain_of(robot), frame_view(robot, WORLD_ALIGNED)
    into = {name: np.empty((rows, *shape)) for name, shape in (("J", (6, 7)), ("dJ", (6, 7, 7)), ("σ", (6,)))}
    slopes = np.empty((6, 7, 7))
    return peers.Peer("rankdrop", {
        "J": lambda q: jacobian(robot, q), "dJ": lambda q: jacobian_derivative(robot, q, out=slopes),
    }, {
        "J": lambda q: _core.jacobian(chain, view, q, into["J"], threads=1),
        "dJ": lambda q: _core.derivative(chain, view, q, into["dJ"], threads=1),
        "σ": lambda q: _core.singular_values(chain, view, q, into["σ"], threads=1),
        "U, σ, V": lambda q: _core.decompose(chain, view, q, threads=1),
    })  # fmt: skip


def main() -> None:
    """Every pair is timed in turns: a busy machine is busy for both."""
    quick = measure.quick()
    calls, rows, repeats = (500, 500, 3) if quick else (10_000, 10_000, 15)
    robot = arms.pa10()
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (rows, 7))
    sample = list(q[:calls])
    mine, table, truth = ours(robot, rows), [], jacobian(robot, sample[0])
    for peer in peers.all_of(robot, rows):
        if "J" in peer.one and peer.name != "KDL":
            there = np.asarray(peer.one["J"](sample[0])).reshape(6, 7)
            if np.abs(there - truth).max() > 1e-12:
                raise SystemExit(f"the Jacobian of {peer.name} is another one")
        few = sample[: calls // (20 if peer.name in ("NumPy", "JAX", "Robotics Toolbox") else 1)]
        cases = [("one", name, in_a_loop(mine.one[name], few), in_a_loop(function, few), len(few))
                 for name, function in peer.one.items()]  # fmt: skip
        cases += [("many", name, lambda f=mine.many[name]: f(q), lambda f=function: f(q), rows)
                  for name, function in peer.many.items()]  # fmt: skip
        for how, name, first, second, count in cases:
            us, theirs = measure.in_turns(3 if peer.name in ("NumPy", "JAX") else repeats, first, second)
            least = AT_LEAST.get((name, how, peer.name))
            table.append({
                "what": name, "how": f"{how if how == 'one' else f'{rows} at a time'}", "peer": peer.name,
                "rankdrop us": 1e6 * us / count, "peer us": 1e6 * theirs / count, "peer / rankdrop": theirs / us,
                "of the target": theirs / us / (least or 1.0), "claimed": least is not None,
            })  # fmt: skip
    measure.report(
        f"PA-10, one thread, time per configuration ({_core.instruction_set()}); the derivative at least as quick as "
        "CasADi's C, one Jacobian from Python as Pinocchio's call, decompositions at least 5 times as quick as NumPy's",
        table, ratio="of the target", target=1.0, missing=peers.missing(*list(peers.INSTALL)[:6]),
    )  # fmt: skip


if __name__ == "__main__":
    main()
