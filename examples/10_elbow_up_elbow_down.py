"""Elbow up, elbow down: what parts two configurations?

The factors of the determinant are flags. Where one has opposite signs at two configurations, every path between them
crosses that family.
"""

import numpy as np

import rankdrop

found = rankdrop.conditions(rankdrop.open_robot("puma560"), coranks=1)

first = np.radians([0, -40, 60, 0, 30, 0])
second = np.radians([0, -40, 60, 180, -30, 0])  # the wrist flipped
third = np.radians([20, -40, 80, 10, 40, 0])
for q in (first, second, third):
    flags = found.flags(q)
    print(np.degrees(q).round().astype(int), "->", ", ".join(flag.label for flag in flags.flags))

for title, one, other in (("first to second", first, second), ("first to third", first, third)):
    print(title)
    for sentence in found.between(one, other).sentences():
        print("   ", sentence)
