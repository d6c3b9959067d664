"""An arm whose path ends at a joint limit."""

from __future__ import annotations

from rankdrop.local.rates import rate_limits
from rankdrop.robot.open import open_robot

ARM = open_robot("ur5")  # 180°/s
LIMIT = float(rate_limits(ARM)[3])
