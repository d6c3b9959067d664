from .record import CorankSummary as CorankSummary
from .record import Family as Family
