"""Tables of families in files."""

from __future__ import annotations

from rankdrop.codec import encode
from rankdrop.families.name import ArmPart, FamilyName, JointValues, Shorter, Variable
from rankdrop.results.names import name_from_dict
from rankdrop.schema.families import CALLED


def test_a_name_holds_only_the_facts_that_it_has() -> None:
    facts = FamilyName((ArmPart.WRIST,), values=(JointValues(Variable(2), (-1.9722, 1.9722)),),
                       shorter=Shorter.PLUS_MINUS | Shorter.WHOLE_DEGREES)  # fmt: skip
    record = encode(CALLED, facts)
    assert sorted(record) == ["parts", "shorter", "values"]
    assert record["shorter"] == ["plus_minus", "whole_degrees"]
    assert str(name_from_dict(record)) == "wrist (θ2 = ±113°)"
