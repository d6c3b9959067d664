"""Is this path safe?

Points of a joint path are looked at: rank, nearest family, distance. Then balls around some of them are proven free, so
that nothing hides between the samples. Where the chain of balls has a gap, it is shown, and the path is not proven.
"""

import csv
import io

import numpy as np

import rankdrop
from rankdrop.cover.ball import certified_radius
from rankdrop.results.known import known_analysis
from rankdrop.task import resolve_task

CSV = """time,j1,j2,j3,j4,j5,j6
0,0,-60,70,-20,60,0
1,20,-75,95,-40,25,10
2,40,-70,80,-30,-25,20
3,60,-60,60,-20,-60,30
"""  # degrees; yours: open("path.csv")
rows = list(csv.DictReader(io.StringIO(CSV)))
time = np.array([float(row.pop("time")) for row in rows])
corners = np.radians([[float(x) for x in row.values()] for row in rows])
t = np.linspace(time[0], time[-1], 301)
path = np.stack([np.interp(t, time, column) for column in corners.T], axis=1)  # (301, 6)

arm = rankdrop.open_robot("ur5")
task = resolve_task(None, arm)
families = known_analysis(arm, task).families
seen = rankdrop.Monitor(arm, task, families).look(path)
for i in range(0, 301, 50):
    name = families[seen.nearest[i]].name
    print(f"t = {t[i]:.1f} s  σ6 = {seen.sigma[i, -1]:.4f}  {seen.distance[i]:.2f} rad from: {name}")
worst = int(seen.distance.argmin())
print(f"worst: t = {t[worst]:.2f} s, {seen.distance[worst]:.4f} rad from {families[seen.nearest[worst]].name}")

i, balls = 0, 0  # walk along the path from ball to ball
while i < 300:
    radius = certified_radius(arm, path[i], evaluations=300).radius
    inside = np.linalg.norm(path[i:] - path[i], axis=1) < radius  # between two inside samples: straight, so inside
    reach = int(np.argmin(inside)) - 1 if not inside.all() else 300 - i
    if reach < 1:
        print(f"proven free up to t = {t[i]:.2f} s by {balls} balls; the next one is too small to go on")
        break
    i, balls = i + reach, balls + 1
else:
    print(f"the whole path is proven free by {balls} balls")
