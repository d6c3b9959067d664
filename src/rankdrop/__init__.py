"""Kinematic singularity analysis of robot arms: every family, of every corank, with its conditions.

    >>> import rankdrop
    >>> found = rankdrop.analyze(rankdrop.open_robot("scara"), starts=200)
    >>> [str(equation) for family in found.families for equation in family.equations]
    ['sin θ2']
"""

from rankdrop.analyze import analyze
from rankdrop.atlas.family import Family
from rankdrop.atlas.search import Search, search
from rankdrop.errors import RankdropError
from rankdrop.frames import Frame
from rankdrop.kinematics import jacobian, jacobian_derivative, pose, task_jacobian
from rankdrop.local.block import generic_rank, singular_values
from rankdrop.result import Analysis
from rankdrop.robot.model import Joint, Robot
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances
from rankdrop.version import VERSION as __version__

__all__ = [
    "Analysis",
    "Family",
    "Frame",
    "Joint",
    "RankdropError",
    "Robot",
    "Search",
    "Task",
    "Tolerances",
    "__version__",
    "analyze",
    "generic_rank",
    "jacobian",
    "jacobian_derivative",
    "open_robot",
    "pose",
    "robot_names",
    "search",
    "singular_values",
    "task_jacobian",
]
