from .covering import cover as cover
from .covering import how_far as how_far
from .ideal_vs_actual import ideal_vs_actual_at as ideal_vs_actual_at
from .ideal_vs_actual import idealised as idealised
from .ideal_vs_actual import nearby as nearby
from .jacobian_in_frame import link_jacobian as link_jacobian
from .tolerant import most_tolerant as most_tolerant
