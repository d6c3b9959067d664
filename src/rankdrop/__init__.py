"""Kinematic singularity analysis of robot arms: every family, of every corank, with its conditions.

    >>> import rankdrop
    >>> found = rankdrop.analyze(rankdrop.open_robot("scara"), starts=200)
    >>> [str(equation) for family in found.families for equation in family.equations]
    ['sin θ2']
"""

from rankdrop.analyze import analyze
from rankdrop.atlas.search import search
from rankdrop.conditions import conditions
from rankdrop.errors import RankdropError
from rankdrop.explain import explain
from rankdrop.frames import Frame
from rankdrop.kinematics import jacobian, jacobian_derivative, pose
from rankdrop.local.block import singular_values
from rankdrop.local.escape import escape
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.redundancy import redundancy
from rankdrop.motion.check import check_path
from rankdrop.result import Analysis
from rankdrop.robot.model import Joint, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Task
from rankdrop.tolerances import Tolerances
from rankdrop.version import VERSION as __version__

__all__ = [
    "Analysis",
    "Frame",
    "Joint",
    "RankdropError",
    "Robot",
    "Task",
    "Tolerances",
    "__version__",
    "analyze",
    "check_path",
    "conditions",
    "escape",
    "explain",
    "jacobian",
    "jacobian_derivative",
    "nearest_singularity",
    "open_robot",
    "pose",
    "redundancy",
    "search",
    "singular_values",
]
