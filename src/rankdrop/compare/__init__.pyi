from .joined import AGREES as AGREES
from .joined import EXACTLY as EXACTLY
from .joined import NOT_DERIVED as NOT_DERIVED
from .joined import ExactRow as ExactRow
from .joined import Joined as Joined
from .joined import conditions_of as conditions_of
from .joined import exact_conditions as exact_conditions
from .joined import readable as readable
