"""Programs, and the question that is asked of them."""

from __future__ import annotations

from pathlib import Path

from rankdrop.path.check.path_file import PathQuestion
from rankdrop.questions import PathOptions

DATA = Path(__file__).parents[1] / "data" / "programs"
ASK = PathQuestion(None, None, PathOptions())
