"""What a redundant arm can do with its spare joint.

Range and null space of a Panda at one configuration, a self-motion around it, and an inverse that keeps joint rates
bounded where the elbow is almost straight.
"""

import numpy as np

import rankdrop
from rankdrop.local.inverses import pseudo_inverse, selective_inverse
from rankdrop.local.self_motions import self_motion

arm = rankdrop.open_robot("panda")
q = np.array([0.1, -0.5, 0.2, -1.9, 0.3, 1.7, 0.4])

found = rankdrop.redundancy(arm, q)
print(f"rank {found.check.rank} + nullity {found.check.nullity} = {arm.n} joints")

traced = self_motion(arm, q)  # the end effector stays where it is
print(f"self-motion: {traced.ended}; the end effector moved by less than 1e-9: {traced.task_error.max() < 1e-9}")
low, high = traced.q.min(axis=0), traced.q.max(axis=0)
for number, (a, b) in enumerate(zip(low, high, strict=True), start=1):
    print(f"  joint {number} from {a:+.2f} to {b:+.2f} rad")

pa10 = rankdrop.open_robot("pa10")
straight = np.array([0.3, 0.6, 0.2, 0.001, 0.5, 0.8, 0.1])
twist = np.array([0.1, 0, 0, 0, 0, 0])  # 0.1 m/s along X
for inverse in (pseudo_inverse, selective_inverse):
    rates = inverse(pa10, straight) @ twist
    print(f"PA-10, elbow almost straight, {inverse.__name__}: fastest joint {np.abs(rates).max():.2f} rad/s")
