from .record import CorankSummary as CorankSummary
from .record import Family as Family
from .which import Condition as Condition
