"""How the families of an arm were verified."""

from __future__ import annotations

from dataclasses import replace

from rankdrop.families.record import Check
from rankdrop.families.summary import Evidence
from rankdrop.results.known import shipped


def test_a_summary_says_how_the_families_were_verified() -> None:
    found = shipped("planar3r")
    assert (found.summary.evidence, found.summary.tests) == (Evidence.TESTED, 1150)  # shipped without a derivation
    family = replace(found.families[0], soundness=Check(10, 9))
    assert replace(found, families=(family,)).summary.evidence is Evidence.NONE
