from .record import AGREES as AGREES
from .record import NOT_DERIVED as NOT_DERIVED
from .record import CorankSummary as CorankSummary
from .record import Derivation as Derivation
from .record import ExactRow as ExactRow
from .record import Family as Family
from .record import short_name as short_name
