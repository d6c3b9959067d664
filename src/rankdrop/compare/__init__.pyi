from .comparison import AGREES as AGREES
from .comparison import EXACTLY as EXACTLY
from .comparison import NOT_DERIVED as NOT_DERIVED
from .comparison import Comparison as Comparison
from .comparison import ExactRow as ExactRow
from .comparison import conditions_of as conditions_of
from .comparison import exact_conditions as exact_conditions
from .comparison import readable as readable
