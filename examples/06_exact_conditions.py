"""Exact conditions for a paper, and for a controller.

The conditions of a PUMA 560 with its lengths as letters, derived over the rational numbers, as text, LaTeX and C.
Needs `pip install "rankdrop[exact]"`.
"""

import rankdrop
from rankdrop.exact.writing.code import Code

arm = rankdrop.open_robot("puma560")
found = rankdrop.conditions(arm, coranks=1, points=200)

print("lengths [m]:", {name: round(value, 4) for name, value in sorted(found.letters.items())})
print("method:", found.method, "-", found.reason)
for family in found.families:
    print(f"{family.name}")
    print("  text ", "; ".join(family.texts))
    print("  LaTeX", "; ".join(family.latex))
check = found.explained
print(f"singular configurations found numerically that lie on a family: {check.agree} of {check.tested}")

code = Code(arm.name, arm.n, found.families, found.letters, found.shifts)
print()
print(code.c())  # and code.python(), code.latex()
