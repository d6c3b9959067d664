"""Your own arm, from a DH table or a URDF.

A made-up 6R arm with a spherical wrist, written down twice: as a Denavit-Hartenberg table and as a URDF. Both have the
same families; the URDF has joint limits as well.
"""

import tempfile
from pathlib import Path

import numpy as np

import rankdrop
from rankdrop.robot.dh import from_dh

#          a        alpha     d    theta: lengths in m, angles in rad, or texts with units
table = [(0, "pi/2", 0.4, 0), ("420 mm", 0, 0, 0), (0, "pi/2", 0, 0),
         (0, "-pi/2", 0.4, 0), (0, "pi/2", 0, 0), (0, 0, 0.1, 0)]  # fmt: skip
by_table = from_dh(table, convention="standard", name="by-table")

axes = [("0 0 0", "0 0 1"), ("0 0 0.4", "0 -1 0"), ("0.42 0 0", "0 -1 0"),
        ("0 0 0", "0 0 -1"), ("0 0 -0.4", "0 -1 0"), ("0 0 0", "0 0 -1")]  # fmt: skip
urdf = '<robot name="by-urdf"><link name="l0"/>'
for i, (xyz, axis) in enumerate(axes, start=1):
    urdf += (
        f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/><limit lower="-2.8" upper="2.8" effort="1" velocity="2"/></joint>'
    )

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder, "arm.urdf")
    path.write_text(urdf + "</robot>")
    by_urdf = rankdrop.open_robot(path, tip="l6")

for arm in (by_table, by_urdf):
    found = rankdrop.analyze(arm, starts=500, exact="off")
    print(f"{arm.name}: joints {', '.join(joint.name for joint in arm.joints)}")
    for family in found.of_corank(1):
        print(f"  {family.name}: {', '.join(f'{e} = 0' for e in family.equations)}")
print("limits of the second:", np.round(by_urdf.lower[0], 2), "to", np.round(by_urdf.upper[0], 2), "rad")
