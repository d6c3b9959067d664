"""KG's claim that suppression is as efficient as reciprocity, measured: CPU time, cases and terms on redundant arms.

Both derive all singular configurations of corank 1, in processes of their own, with the same limit. Terms are those of
every equation that vanishes or must not vanish in the answer, as trigonometric polynomials where they were kept so,
else in half angles: how much there is to read.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from typing import Any

import measure  # first: sets the number of threads

ARMS = ("canadarm2", "pa10", "panda", "xarm7", "gen3")
SLOWER = ("gen3",)
"""Arms of which it is told that suppression takes longer."""
LIMIT = 60.0
"""Work that each may do [s of an idle machine]."""


def suppression(arm: str) -> dict[str, Any]:
    """Disjoint families."""
    from rankdrop.exact.arm.chain import exact_chain
    from rankdrop.exact.suppression import suppress
    from rankdrop.robot.open import open_robot

    suppress(exact_chain(open_robot("puma560")))  # what is imported on first use
    begin = time.process_time()
    found = suppress(exact_chain(open_robot(arm)), seconds=LIMIT)
    seconds = time.process_time() - begin
    terms = [len(p) for family in found.families for p in (*family.equalities, *family.inequalities)]
    return {"s": seconds, "cases": len(found.families), "terms": sum(terms), "longest": max(terms, default=0),
            "done": found.complete}  # fmt: skip


def reciprocity(arm: str) -> dict[str, Any]:
    """Cases, each with its reciprocal screw."""
    from rankdrop.exact.arm.chain import exact_chain
    from rankdrop.exact.methods import derive
    from rankdrop.robot.open import open_robot

    derive(exact_chain(open_robot("puma560")), "reciprocity")
    begin = time.process_time()
    found = derive(exact_chain(open_robot(arm)), "reciprocity", LIMIT)
    seconds = time.process_time() - begin
    groups = [(*one.equal, *(e for group in one.unequal for e in group)) for one in found.conditions]
    terms = [equality.terms for group in groups for equality in group]
    return {"s": seconds, "cases": len(found.conditions), "terms": sum(terms), "longest": max(terms, default=0),
            "done": found.complete}  # fmt: skip


JOBS = {"suppression": suppression, "reciprocity": reciprocity}


def alone(job: str, arm: str) -> dict[str, Any]:
    """One derivation in a process of its own."""
    command = [sys.executable, __file__, "--job", json.dumps([job, arm])]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


def main() -> None:
    """Both methods on each arm."""
    rows = []
    for arm in ARMS[:1] if measure.quick() else ARMS:
        one, two = alone("suppression", arm), alone("reciprocity", arm)
        for name, found in (("suppression", one), ("reciprocity", two)):
            rows.append({
                "arm": arm, "method": name, "s": found["s"], "conditions": found["cases"], "terms": found["terms"],
                "longest": found["longest"], "finished": found["done"], "MB": found["MB"],
                "of reciprocity": one["s"] / two["s"] if name == "suppression" else "",
                "claimed": name == "suppression" and one["done"] and two["done"] and arm not in SLOWER,
            })  # fmt: skip
    measure.report(
        "suppression against reciprocity, CPU time on one core, all of corank 1",
        rows, ratio="of reciprocity", target=1.0, at_most=True,
    )  # fmt: skip


if __name__ == "__main__":
    if "--job" in sys.argv:
        name, arm = json.loads(sys.argv[sys.argv.index("--job") + 1])
        answer = JOBS[name](arm)
        print(json.dumps(answer | {"MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))
    else:
        main()
