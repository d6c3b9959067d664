"""Ways out of a singularity.

Which joints lead out, which never do? The seven-joint PA-10, stretched out straight, has lost three directions at once.
"""

import rankdrop

arm = rankdrop.open_robot("pa10")
for title, q in (("stretched out", [0.0] * 7), ("elbow straight", [0.1, 0.5, 0.3, 0.0, 0.9, 0.4, 0.2])):
    found = rankdrop.escape(arm, q)
    print(f"{title}: {found.corank} of 6 directions of the tool lost")
    for way in found.single:
        if way.order:
            words = f"restores the full rank, σ6 ≈ {way.rate:.3f} t^{way.order}"
        else:
            words = f"regains {way.gain} of {found.corank} alone" if way.gain else "alone regains nothing"
        print(f"  joint {way.number}: {words}")
    best = found.best_direction
    print(f"  all joints together, {best.step:.1f} rad: rank regained {best.measured_gain} of {found.corank}")
    print(f"  left with the tool at rest: {found.avoidable} ({found.avoidable_reason})")
