from .outcome import MEANINGS as MEANINGS
from .outcome import UNITS as UNITS
from .outcome import Designs as Designs
from .outcome import measure_text as measure_text
from .outcome import shown as shown
from .spec import Parameter as Parameter
from .spec import read_spec as read_spec
from .sweeping import sweep as sweep
