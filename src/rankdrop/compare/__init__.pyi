from .exactly import conditions_of as conditions_of
from .exactly import exact_conditions as exact_conditions
from .joined import AGREES as AGREES
from .joined import NOT_DERIVED as NOT_DERIVED
from .joined import ExactRow as ExactRow
from .joined import Joined as Joined
