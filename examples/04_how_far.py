"""How far is the next singularity?

Two numbers are told apart. The nearest singularity found is an upper bound, checked; one nearer may have been missed.
The certified radius is a lower bound, proven: nothing inside that ball is singular.
"""

import tempfile

import numpy as np

import rankdrop
from rankdrop.cover import ball_certificate, verify, write_certificate
from rankdrop.cover.ball import certified_radius
from rankdrop.distance.distance import family_distances
from rankdrop.results.known import known_analysis
from rankdrop.task import resolve_task

arm = rankdrop.open_robot("ur5")
task = resolve_task(None, arm)
q = np.radians([0, -135, 45, 90, -90, 0])

near = rankdrop.nearest_singularity(arm, q)
print(f"nearest found: {near.distance:.4f} rad away, at", np.round(np.degrees(near.q), 1), "deg")

for one in family_distances(known_analysis(arm, task).families, arm, q, task):
    print(f"  {one.family.name}: {one.distance:.4f} rad")

proven = certified_radius(arm, q, evaluations=20000)
share = proven.radius / near.distance
print(f"proven free: {np.floor(1e3 * proven.radius) / 1e3:.3f} rad, {100 * share:.1f} % of that distance")

with tempfile.TemporaryDirectory() as folder:
    place = write_certificate(ball_certificate(arm, q, radius=0.3), f"{folder}/ball.json")
    print("a ball of 0.3 rad, proven again by another program:", verify(place, arm).holds)
