"""The evidence of a family in words."""

from __future__ import annotations

from rankdrop.families.evidence import FamilyEvidence, ObtainedFrom


def test_evidence_without_a_clear_rank_bounds_the_dimension() -> None:
    assert str(FamilyEvidence(ObtainedFrom.CLOUD, cloud=12, fresh=3, clear_rank=False)) == (
        "12 points of the cloud and 3 fresh ones, no condition found; D has no clear rank there, so that the "
        "dimension is an upper bound"
    )
