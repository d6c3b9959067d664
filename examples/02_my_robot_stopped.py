"""My robot stopped.

Was it a singularity, which one, what is lost, which joints are to blame? One configuration of a PUMA 560, explained.
"""

import numpy as np

import rankdrop

arm = rankdrop.open_robot("puma560")
q = np.radians([10, 20, 30, 40, 0, 50])  # as the controller reported it
found = rankdrop.explain(arm, q)

print(f"{found.verdict}: {found.reason}")
print("singular values:", np.round(found.rank.sigma, 4))
for member in found.met:
    print("family:", member.family.name, "-", ", ".join(f"{e} = 0" for e in member.family.equations))
for words in found.lost.words:  # in the axes in which the lost motion is simplest
    print("lost:", words)
for circuit in found.blame.smallest:
    print("to blame:", circuit.words)
for way in found.escape.single:
    if way.order:  # the power of its motion at which the lost direction comes back
        print(f"out by joint {way.number}: σ6 grows by {way.rate:.4f} per rad")

# The same as text, with everything else that is known: print(found). As JSON: found.save("here.json").
