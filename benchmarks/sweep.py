"""Variants of a UR5, from forms that are known and from nothing: CPU time of each, and of a thousand on two cores."""

from __future__ import annotations

import time

import measure  # before NumPy: sets the number of threads

from rankdrop.designs.measure import families_of, variants
from rankdrop.designs.spec import spec_of
from rankdrop.designs.sweeping import job_of, variants_of
from rankdrop.robot.drawing import Drawing, NumberPlace
from rankdrop.verbs.analyze import analyze

SPEC = {
    "robot": "ur5",
    "sample": {"kind": "sobol", "variants": 1000},
    "parameters": {"upper_arm": {"sets": "-2.a", "lower": 0.30, "upper": 0.55},
                   "forearm": {"sets": "-3.a", "lower": 0.30, "upper": 0.50},
                   "offset": {"sets": "5.d", "lower": 0.02, "upper": 0.14}},
}  # fmt: skip


def main() -> None:
    """Chunks of the thousand, families alone and with shares near them; and one variant from nothing, and analysed."""
    chunks = 1 if measure.quick() else 5
    rows = []
    for what, more in (("families", {"families": {}}), ("and shares", {"families": {}, "near": {}})):
        spec = spec_of({**SPEC, **more})
        job = job_of(spec, variants_of(spec))
        variants(job.plan, 0)  # what is known of the nominal arm comes once for each worker
        begun = time.process_time()
        for chunk in range(1, chunks + 1):
            variants(job.plan, 20 * chunk)
        each = (time.process_time() - begun) / (chunks * job.plan["size"])
        rows.append({"what": what, "cpu s each": each, "1000 on two cores, s": 500 * each, "claimed": True})
    drawing = Drawing(**job.plan["drawing"])
    values = dict(zip([NumberPlace(*one[0]) for one in job.plan["places"]], job.plan["variants"][500][1], strict=True))
    robot = drawing.robot(values)
    for what, run in (
        ("from nothing", lambda: families_of(robot, spec.task, None, starts=300, fresh=300, limits=False, seed=0)),
        ("rankdrop.analyze", lambda: analyze(robot, spec.task, starts=1000, exact="off", threads=1)),
    ):
        begun = time.process_time()
        run()
        each = time.process_time() - begun
        rows.append({"what": what, "cpu s each": each, "1000 on two cores, s": 500 * each, "claimed": False})
    measure.report("a thousand variants of the UR5 on two cores: under 120 s", rows, ratio="1000 on two cores, s",
                   target=120.0, at_most=True)  # fmt: skip


if __name__ == "__main__":
    main()
