from .derivation import AGREES as AGREES
from .derivation import NOT_DERIVED as NOT_DERIVED
from .derivation import Derivation as Derivation
from .derivation import ExactRow as ExactRow
from .record import CorankSummary as CorankSummary
from .record import Family as Family
