"""Singular values and both sets of singular vectors of many PA-10 Jacobians: the core, one thread, against NumPy."""

from __future__ import annotations

import measure  # first: sets the number of threads
import numpy as np
from reference import arms

from rankdrop import _core
from rankdrop.kinematics import jacobian


def main() -> None:
    """Both get the same Jacobians, already computed."""
    count = 2_000 if measure.quick() else 50_000
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (count, 7))
    batch = jacobian(arms.pa10(), q)
    rows = []
    numpy_time = {
        "full bases": measure.best_of(3, lambda: np.linalg.svd(batch, full_matrices=True)),
        "first six vectors": measure.best_of(3, lambda: np.linalg.svd(batch, full_matrices=False)),
    }
    for instructions in reversed(_core.instruction_sets()):
        _core.choose_instruction_set(instructions)
        core_time = measure.best_of(5, lambda: _core.svd(batch, threads=1))
        for compared, other in numpy_time.items():
            rows.append({
                "core": f"full bases, {instructions}", "NumPy": compared,
                "core us": 1e6 * core_time / count, "NumPy us": 1e6 * other / count, "ratio": other / core_time,
                "claimed": instructions == _core.instruction_sets()[-1],
            })  # fmt: skip
    measure.report(
        f"σ, U and V of {count} Jacobians of the PA-10, one thread, time per Jacobian: at least 5 times NumPy",
        rows, ratio="ratio", target=5.0,
    )  # fmt: skip


if __name__ == "__main__":
    main()
