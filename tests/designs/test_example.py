"""The plan that `sweep --example` writes: it is read as it stands, and its variants are those that it names."""

from __future__ import annotations

import tomllib
from math import radians

import numpy as np

from rankdrop.designs.example import EXAMPLE
from rankdrop.designs.spec import spec_of
from rankdrop.designs.sweeping import variants_of

SPEC = spec_of(tomllib.loads(EXAMPLE))


def test_every_upper_arm_is_combined_with_every_offset() -> None:
    values = variants_of(SPEC)
    assert [parameter.name for parameter in SPEC.parameters] == ["upper_arm", "offset"]
    lengths = np.linspace(0.3, 0.55, 4)
    wanted = [(length, offset) for length in lengths for offset in (0.0, 0.09465)]
    np.testing.assert_allclose(sorted(map(tuple, values)), sorted(wanted), atol=1e-12)


def test_the_variants_differ_in_the_numbers_that_are_named() -> None:
    """The upper arm is written with a minus in the table of Denavit and Hartenberg, and stays a length here."""
    (upper_arm,), (offset,) = (parameter.places for parameter in SPEC.parameters)
    assert str(upper_arm) == "-shoulder_lift_joint.a"
    assert str(offset) == "wrist_2_joint.d"  # the fifth
    assert {parameter.unit for parameter in SPEC.parameters} == {"m"}


def test_families_and_the_share_near_them_are_measured() -> None:
    asks = SPEC.asks
    assert asks.families is not None
    assert asks.near is not None
    assert (asks.families["starts"], asks.families["fresh"]) == (100, 100)
    assert asks.near["within"] == radians(5.0)
    assert SPEC.task.name == "pose"
    assert "near" in asks.measures


def test_each_setting_that_needs_it_has_its_line_of_help() -> None:
    explained = [line for line in EXAMPLE.splitlines() if " #" in line]
    assert {line.split()[0] for line in explained} == {"robot", "[families]", "[near]"}
