"""Outcomes of sweeps and comparisons: arms in doubt, measures in their order, and the best beyond the error."""

from __future__ import annotations

from typing import Any

import pytest

import rankdrop
from rankdrop.designs import Designs
from rankdrop.designs.outcome import SideBySide, in_doubt, measures_of
from rankdrop.errors import OptionError
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task

ARM = open_robot("planar3r")


def record(number: int, error: str | None = None, verdict: str = "verified", **measures: float) -> dict[str, Any]:
    return {"number": number, "error": error, "verdict": verdict, "measures": measures}


def compared(*records: dict[str, Any]) -> SideBySide:
    names = tuple(f"arm {k}" for k in range(len(records)))
    return SideBySide(names, (ARM,) * len(records), resolve_task(None, ARM), False, 0, records)


@pytest.fixture(scope="module")
def swept() -> Designs:
    """Three lengths of the second link, families alone."""
    parameters = {"length": {"sets": "2.a", "values": [0.3, 0.5, 0.8]}}
    return rankdrop.sweep(
        {"robot": "planar3r", "parameters": parameters, "families": {"starts": 60, "fresh": 60}}, workers=1
    )


def test_an_arm_is_in_doubt_with_an_error_or_without_verified_families() -> None:
    assert not in_doubt(record(0))
    assert in_doubt(record(0, error="no arm"))
    assert in_doubt(record(0, verdict="contradicted"))
    assert not in_doubt({"error": None})  # its families were not asked for


def test_measures_are_in_their_order_and_those_of_any_record() -> None:
    records = [record(0, sigma=0.1), record(1, families=3, near=0.2)]
    assert measures_of(records) == ["families", "near", "sigma"]


def test_one_arm_in_doubt_is_named_and_the_comparison_does_not_hold() -> None:
    found = compared(record(0, families=3), record(1, verdict="contradicted", families=4))
    assert (found.holds, found.doubtful) == (False, ("arm 1",))
    assert compared(record(0, families=3), record(1, families=4)).holds


def test_numbers_that_make_no_arm_better_distinguish_none() -> None:
    found = compared(record(0, families=3, aspects=2), record(1, families=4, aspects=2))
    assert found.best("families") == (0,)
    assert found.best("aspects") == (0, 1)
    assert found.distinguished("families") == ()


@pytest.mark.slow
def test_a_sweep_has_one_value_of_a_measure_for_each_variant(swept: Designs) -> None:
    assert swept.holds
    assert (swept.failed, swept.unverified) == ((), ())
    assert swept.measures == ["families"]
    values = swept.values("families")
    assert len(values) == len(swept.records) == 3
    assert len(set(values)) == 1  # the elbow alone, whatever the length
    assert len(swept.structures) == 1
    assert swept.changes == []
    with pytest.raises(OptionError, match=r"no such measure; got sigma; allowed: families"):
        swept.values("sigma")
