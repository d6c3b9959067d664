"""Every family of an arm.

At which configurations does a Mitsubishi PA-10 lose a freedom, and which one? `analyze` searches every corank and
tells the families with their conditions; each row is tested both ways.
"""

import rankdrop
from rankdrop.text import lost_sentences

arm = rankdrop.open_robot("pa10")  # or a path to a URDF, xacro, DH or screw file
found = rankdrop.analyze(arm, starts=1000, seed=0, exact="off")  # exact conditions: number 6

for summary in found.coranks:
    print(f"corank {summary.corank}: {summary.converged} of {summary.starts} starts ended at a singularity")
    for family in found.of_corank(summary.corank):
        print(f"  {family.id}  {family.name}  (dimension {family.dimension})")
        print("         where", ",  ".join(f"{equation} = 0" for equation in family.equations))
        for words in lost_sentences(family.lost_freedoms):
            print("         there it", words)

# Nothing found at a corank is not a proof. What is tested: the rows' conditions are solved from random starts, and the
# rank is computed there; test points (singular, not used by any fit) are tried on the rows.
print("every row sound, every test point explained:", found.verified)
print(f"largest σ that should be zero, evaluated again: below 1e-9: {found.residual().sigma < 1e-9}")
