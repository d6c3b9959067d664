"""Exact conditions for a paper, and for a controller.

The conditions of a PUMA 560 with its lengths as letters, derived over the rational numbers, as text, LaTeX and C.
"""

import rankdrop

arm = rankdrop.open_robot("puma560")
found = rankdrop.conditions(arm, coranks=1, points=200)

print("lengths [m]:", ", ".join(f"{name} = {value:g}" for name, value in sorted(found.letters.items())))
print("derived by:", found.method)
for family in found.families:
    print(family.name)
    print("  text ", "; ".join(family.texts))
    print("  LaTeX", "; ".join(family.latex))
check = found.explained
print(f"found numerically, and on a family: {check.agree} of {check.tested}")
print("verified:", found.verified)

print()
print(found.code("c"))  # and found.code("python"), found.latex()
