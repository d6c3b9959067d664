"""Arm and spherical wrist apart: conditions of each, and arms that have no such wrist."""

from __future__ import annotations

import pytest
from exact.chains import chain_of
from exact.strata import derived

from rankdrop.errors import OptionError
from rankdrop.exact.methods import derive


@pytest.mark.parametrize("name", ["ur5", "scara", "canadarm2"])
def test_decomposition_refuses_an_arm_without_a_spherical_wrist_and_says_why(name: str) -> None:
    with pytest.raises(OptionError, match=r"spherical wrist.*d[56] = |all six rows"):
        derive(chain_of(name), "decomposition")


def test_the_arm_and_the_wrist_of_the_pa10_come_apart() -> None:
    found = derived("pa10", "decomposition")
    keys = [[{atom.key for atom in equality.atoms} for equality in c.equal] for c in found.conditions]
    assert keys[:2] == [[{"θ4=0"}], [{"θ4=pi"}]]
    assert all({"θ6=0"} in c or {"θ6=pi"} in c for c in keys[3:])
