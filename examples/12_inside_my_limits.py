"""Which singularities lie inside my joint limits?

A family of the whole joint space may lie outside the limits of a real arm, or partly. Random points of the limits are
asked how far it is to the nearest singularity that the arm can reach.
"""

import numpy as np

import rankdrop
from rankdrop.local.block import sample

arm = rankdrop.open_robot("panda")
everywhere = rankdrop.analyze(arm, starts=1000)
inside = rankdrop.analyze(arm, starts=1000, limits=True)
for title, found in (("whole joint space", everywhere), ("inside the limits", inside)):
    print(title)
    for summary in found.coranks:
        print(f"  corank {summary.corank}: {summary.converged} of {summary.starts} starts ended at a singularity")
    for family in found.families:
        print(f"    {family.id}  {family.name}")

task = inside.task
distances = []
for q in sample(arm, task, 40, seed=1, limits=True):
    near = rankdrop.nearest_singularity(arm, q, limits=True)
    assert near is None or near.within_limits
    distances.append(np.inf if near is None else near.distance)
print(f"nearest singularity inside the limits from 40 random places: median {np.median(distances):.2f} rad, "
      f"largest {np.max(distances):.2f} rad")  # fmt: skip
