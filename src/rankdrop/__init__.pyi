from .certify.proof.verifying import verify as verify
from .designs.sweeping import sweep as sweep
from .errors import RankdropError as RankdropError
from .families.monitor import Monitor as Monitor
from .families.searching import search as search
from .frames import Frame as Frame
from .kinematics import jacobian as jacobian
from .kinematics import jacobian_derivative as jacobian_derivative
from .kinematics import pose as pose
from .local.block import singular_values as singular_values
from .local.nearest import nearest_singularity as nearest_singularity
from .local.redundant import redundancy as redundancy
from .local.ways_out import escape as escape
from .motion.check import check_path as check_path
from .results.analysis import Analysis as Analysis
from .robot.model import Joint as Joint
from .robot.model import Robot as Robot
from .robot.open import open_robot as open_robot
from .task import Task as Task
from .tolerances import Tolerances as Tolerances
from .verbs.analyze import analyze as analyze
from .verbs.conditions import conditions as conditions
from .verbs.explain import explain as explain

__version__: str
