"""Which singularities lie inside my joint limits?

A family of the whole joint space may lie outside the limits of a real arm, or partly. Of eleven families
of a Unitree Z1, one was found inside its limits.
"""

import numpy as np

import rankdrop
from rankdrop.distance.distance import family_distances
from rankdrop.local.block import sample

arm = rankdrop.open_robot("z1")  # or your URDF: its limits come with it
for joint in arm.joints:
    print(f"{joint.name}: {np.degrees(joint.lower):+.0f} to {np.degrees(joint.upper):+.0f} deg")

everywhere = rankdrop.analyze(arm, starts=1000, exact="off")
inside = rankdrop.analyze(arm, starts=1000, exact="off", limits=True)
for title, found in (("whole joint space", everywhere), ("inside the limits", inside)):
    print(title)
    for summary in found.coranks:
        names = [family.name for family in found.of_corank(summary.corank)]
        print(f"  corank {summary.corank}: {'; '.join(names) or 'none found'}")

# The other way round: how far is each family of corank 1, if the limits are kept on the way's end?
task = everywhere.task
places = sample(arm, task, 20, seed=1, limits=True)
best: dict[str, float] = {}
for q in places:
    for one in family_distances(everywhere.of_corank(1), arm, q, task, limits=True):
        best[one.family.name] = min(best.get(one.family.name, np.inf), one.distance)
print("nearest point inside the limits, from the best of 20 random places")
for name, distance in sorted(best.items(), key=lambda item: item[1]):
    print(f"  {name}: {'none found' if np.isinf(distance) else f'{distance:.2f} rad'}")
