"""A plan for a sweep, to try and to change."""

from __future__ import annotations

EXAMPLE = """\
# How long should the upper arm be, and does the wrist need its offset?
robot = "ur5"            # a name, or a DH file or URDF next to this file
task = "pose"
seed = 0

[parameters]
upper_arm = { sets = "-shoulder_lift_joint.a", lower = "300 mm", upper = "550 mm", steps = 4 }
offset = { sets = "5.d", values = ["0 mm", "94.65 mm"] }

[families]               # which families every variant has
starts = 100
fresh = 100

[near]                   # share of the joint space within this distance of a family
within = "5 deg"
"""
"""Eight variants of a UR5; measured in ten seconds."""
