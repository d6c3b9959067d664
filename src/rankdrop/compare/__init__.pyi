from .comparison import AGREES as AGREES
from .comparison import NOT_DERIVED as NOT_DERIVED
from .comparison import Comparison as Comparison
from .comparison import ExactRow as ExactRow
from .comparison import Side as Side
