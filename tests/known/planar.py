"""A small arm, and its Jacobian."""

from __future__ import annotations

import rankdrop

ARM = rankdrop.open_robot("planar3r")
A = [0.1, 0.5, 0.3]
