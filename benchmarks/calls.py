"""One call from Python for one configuration: pose, Jacobian, singular values, decomposition of the PA-10."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import measure  # first: sets the number of threads
from reference import arms

from rankdrop.kinematics import jacobian, pose, task_jacobian
from rankdrop.local.block import decompose, sample, singular_values
from rankdrop.robot.model import Array
from rankdrop.task import resolve_task

TARGETS = {"pose": 1.1, "Jacobian": 1.0, "task Jacobian": 2.5, "σ": 5.0, "U, σ, V": 7.5}
"""Times of the Jacobian's call, which depend less on the machine than microseconds."""


def main() -> None:
    """Least processor time of many short rounds, every call in turn, each with a new configuration."""
    calls, rounds = (50, 20) if measure.quick() else (200, 500)
    arm = arms.pa10()
    task = resolve_task(None, arm)
    configurations = list(sample(arm, task, calls, seed=0))
    functions: dict[str, Callable[[Array], object]] = {
        "pose": partial(pose, arm), "Jacobian": partial(jacobian, arm),
        "task Jacobian": partial(task_jacobian, arm, task=task), "σ": partial(singular_values, arm),
        "U, σ, V": partial(decompose, arm),
    }  # fmt: skip
    least = dict.fromkeys(functions, float("inf"))
    for _ in range(rounds):
        for name, function in functions.items():
            least[name] = min(least[name], measure.least_cpu(1, partial(_every, function, configurations)))
    rows = []
    for name, seconds in least.items():
        ratio = seconds / least["Jacobian"]
        rows.append({"call": name, "us": 1e6 * seconds / calls, "of a Jacobian": ratio,
                     "of the target": ratio / TARGETS[name]})  # fmt: skip
    measure.report(
        "single calls from Python, PA-10, one thread, processor time", rows, ratio="of the target", target=1.0,
        at_most=True,
    )  # fmt: skip


def _every(function: Callable[[Array], object], configurations: list[Array]) -> None:
    for q in configurations:
        function(q)


if __name__ == "__main__":
    main()
