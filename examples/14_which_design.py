"""Which of many designs is best?

`rankdrop sweep` varies lengths, angles, offsets, base or tool of an arm and measures every variant; here from Python.
The specification is `designs.toml` beside this file.
"""

from pathlib import Path

import rankdrop

found = rankdrop.sweep(Path(__file__).with_name("designs.toml"), workers=1)
print(found.sentence)

print("\nWhat no other variant beats:")
for i in found.pareto:
    record = found.records[i]
    values = ", ".join(f"{p.name} {x:.1f} m" for p, x in zip(found.parameters, record["values"], strict=True))
    near, sigma, reached = (record["measures"][name] for name in ("near", "sigma", "reached"))
    shown = "–" if sigma is None else f"{sigma:.3f}"
    print(f"  {values}: {near:.1%} near singularities, smallest σ {shown}, {reached:.0%} of the box reached")

print("\nA family that is not always there, and for which lengths it is:")
for one in found.exact[:1]:
    for family in one["families"]:
        if family["corank"] == 2 and family["real"]:
            print(f"  {', '.join(family['conditions'])}: {family['real']}")
