"""Why a method does not do for an arm."""

from __future__ import annotations

import pytest

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.decoupling import decouple, parting_of
from rankdrop.exact.method_reason import PartingKind
from rankdrop.robot.open import open_robot


@pytest.mark.parametrize(
    ("name", "kind", "part"),
    [
        ("pa10", PartingKind.ARM_NOT_SQUARE, "wrist"), ("panda", PartingKind.ARM_NOT_SQUARE, "shoulder"),
        ("gen3", PartingKind.NOT_SQUARE, ""), ("canadarm2", PartingKind.NOT_SQUARE, ""),
        ("almarkhi4", PartingKind.NOT_SQUARE, ""),
    ],
)  # fmt: skip
def test_redundant_arms_are_not_decoupled_and_it_is_said_why(name, kind, part):
    chain = exact_chain(open_robot(name))
    assert decouple(chain) is None
    found = parting_of(chain)
    assert (found.kind, found.part, found.columns, found.rows) == (kind, part, chain.n, chain.task.m)


def test_too_few_joints_for_the_task():
    chain = exact_chain(open_robot("planar3r"), "pose")
    assert decouple(chain) is None
    assert parting_of(chain).kind is PartingKind.TOO_FEW_JOINTS
