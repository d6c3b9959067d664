"""Families in another unit of length: conditions hold at the same configurations, whose slides have other numbers."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.families.record import Pin
from rankdrop.families.rescaling import (
    family_from_metres,
    family_in_metres,
    family_in_units,
    family_out_of_units,
    rescale_equation,
    rescaled_pin,
    slides_of,
)
from rankdrop.formula.equation import Equation, Term
from rankdrop.local.block import singular_values
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.units import scale_lengths

SLIDE = Equation((Term(1.0, "cos", (0, 0), (0, 1)), Term(-0.3, "cos", (2, 0), (0, 0))))
"""q2 − 0.3 cos θ1."""


def test_only_joints_that_slide_are_lengths() -> None:
    assert slides_of(open_robot("stanford")) == (2,)
    assert slides_of(open_robot("puma560")) == ()


@pytest.mark.parametrize("power", [3, -3, 1])
def test_an_equation_has_the_same_zeros_in_another_unit(power: int, rng: np.random.Generator) -> None:
    theta = rng.uniform(-3, 3, 20)
    zeros = np.stack([theta, 0.3 * np.cos(theta)], axis=1)
    scaled = rescale_equation(SLIDE, [1], power)
    assert scaled(zeros * [1, 10.0**power]) == pytest.approx(np.zeros(20), abs=1e-12)
    beside = zeros + np.array([0.0, 0.1])
    assert np.abs(scaled(beside * [1, 10.0**power])).min() > 1e-5
    assert max(abs(term.coefficient) for term in scaled.terms) == 1.0


def test_an_equation_of_angles_is_itself() -> None:
    angles = Equation((Term(1.0, "sin", (2, 2), (0, 0)),))
    assert rescale_equation(angles, [1], 3) is angles
    assert rescaled_pin(Pin("j1", 1, (0.5,)), [1], 3) == Pin("j1", 1, (0.5,))
    assert rescaled_pin(Pin("j2", 2, (0.25, -0.25)), [1], 3).values == (250.0, -250.0)


def test_families_of_an_arm_in_millimetres_are_singular_where_those_in_metres_are() -> None:
    long = scale_lengths(open_robot("stanford"), 3)
    rank, moved = 6, 0
    for family in shipped("stanford").families:
        other = family_from_metres(family, long, 3)
        q = np.array(other.witness)
        moved += q.tolist() != list(family.witness)
        assert np.abs(other.system.values(q[None])).max(initial=0.0) < 1e-9
        sigma = singular_values(long, q, resolve_task(None, long))
        assert sigma[rank - family.corank] < 1e-9 * sigma[0]
        back = family_in_metres(other, long)
        assert back.witness == pytest.approx(family.witness)
        assert [pin.values for pin in back.pinned] == [pytest.approx(pin.values) for pin in family.pinned]
    assert moved > 0  # witnesses have a slide


def test_there_and_back_is_the_same_family() -> None:
    arm = scale_lengths(open_robot("stanford"), 3)
    for family in shipped("stanford").families:
        inside = family_in_units(family, arm)
        assert inside.witness[2] == 0.0 or inside.witness[2] != family.witness[2]
        assert family_out_of_units(inside, arm).witness == family.witness
