"""An analysis as its tables."""

from __future__ import annotations

import pytest
from text.bent import bent

from rankdrop import analyze


@pytest.mark.shipped
def test_an_analysis_is_printed_as_its_tables() -> None:
    said = str(analyze(bent(), "planar", starts=200))
    assert said.startswith("bent has 1 family of singularities: elbow (rank 2).\n  Verified by ")
    assert "elbow: axes 1, 2, 3 coplanar" in said
    assert "Analysis(" not in said
