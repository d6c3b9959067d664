"""Files of paths for the command."""

from __future__ import annotations

from pathlib import Path

import numpy as np

FREE = [[0.0, 0.5, 0.1], [0.2, 0.9, 0.3]]


def saved(folder: Path, name: str, q: object) -> Path:
    np.save(folder / name, np.array(q))
    return folder / name
