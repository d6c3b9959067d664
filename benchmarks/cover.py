"""Coverings of six turning joints: time and memory for boxes of 0.05 rad, and what known families explain of them."""

from __future__ import annotations

import resource
import time
from functools import partial

import measure  # before NumPy: sets the number of threads

from rankdrop.robot.open import open_robot
from rankdrop.verbs import cover


def main() -> None:
    """Two calls for each arm, boxes alone and with families; the largest memory is that of all so far."""
    width = 0.4 if measure.quick() else 0.05
    rows = []
    for name in ("ur5", "puma560"):
        robot = open_robot(name)
        for explain in (False, True):
            cpu = time.process_time()
            seconds, found = measure.once(partial(cover, robot, width=width, explain=explain))
            tree = found.covering.tree
            rows.append({
                "arm": name, "families": explain, "width": found.width, "boxes left": tree.leaves,
                "proven share": tree.proven_leaves / tree.leaves, "free share": found.covering.free_share,
                "places": len(found.account.spots) if found.account else None,
                "cpu s": time.process_time() - cpu, "seconds": seconds,
                "GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20, "claimed": True,
            })  # fmt: skip
    measure.report(
        "boxes of 0.05 rad that hold every singular configuration, with families: at most 30 s",
        rows, ratio="seconds", target=30.0, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    main()
