"""Real robot descriptions out of the packages `example-robot-data` and `rtb-data` (the extra "cross" installs both)."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

EXAMPLE, RTB = "example-robot-data", "rtb-data"


@dataclass(frozen=True)
class RealFile:
    """A file of a package: how its path ends, the tip to take, the number of joints up to it, package names it uses."""

    package: str
    ending: str
    tip: str
    n: int
    finds: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """Where the file is installed."""
        return located(self.package, self.ending)

    @property
    def packages(self) -> dict[str, Path]:
        """Folder of every package name in the file, for $(find …): the folder that holds urdf/."""
        return dict.fromkeys(self.finds, self.path.parent.parent)


FILES = {
    "ur5": RealFile(EXAMPLE, "ur_description/urdf/ur5_robot.urdf", "tool0", 6),
    "panda": RealFile(EXAMPLE, "panda_description/urdf/panda.urdf", "panda_hand_tcp", 7),
    "xarm7": RealFile(EXAMPLE, "xarm_description/urdf/xarm7.urdf", "link_eef", 7),
    "kinova": RealFile(EXAMPLE, "kinova_description/robots/kinova.urdf", "j2s6s200_end_effector", 6),
    "irb140": RealFile(RTB, "abb_irb140_description/urdf/irb140.urdf", "tool0", 6),
    "iiwa": RealFile(RTB, "kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf", "tool0", 7),
    "puma560": RealFile(RTB, "unimation_puma560_description/urdf/puma560_robot.urdf", "link7", 6),
}

XACROS = {
    "puma560": RealFile(RTB, "unimation_puma560_description/urdf/puma560_robot.urdf.xacro", "link7", 6),
    "irb140": RealFile(RTB, "abb_irb140_description/urdf/irb140.xacro", "tool0", 6, ("abb_irb140", "abb_resources")),
}


def located(package: str, ending: str) -> Path:
    """Installed path of the one file of a distribution whose path ends so."""
    distribution = metadata.distribution(package)
    found = [file for file in distribution.files or () if str(file).endswith(f"/{ending}")]
    if len(found) != 1:
        raise FileNotFoundError(f"{package}: {len(found)} files end in {ending}")
    return Path(str(distribution.locate_file(found[0]))).resolve()
