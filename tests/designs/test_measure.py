"""Families of a variant: conditions of the nominal arm are no more than a start."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import rankdrop
from rankdrop.designs.measure import families_of, nominal_conditions, with_lengths_of
from rankdrop.families.evidence import ObtainedFrom
from rankdrop.families.record import exact_of
from rankdrop.formula.writing import AnglePin
from rankdrop.robot.drawing import Drawing
from rankdrop.task import resolve_task


@pytest.mark.by_hand
def test_nominal_conditions_do_not_hide_a_family_that_appears() -> None:
    """The nominal arm has no shoulder's family: the variant that has it finds it."""
    drawing = Drawing.of("anthropomorphic")
    place = drawing.place("1.a", "here")
    effort: Any = {"starts": 100, "fresh": 100, "limits": False, "seed": 0}
    without, with_it, again = (drawing.robot({place: shift}) for shift in (1.2, 0.31, 0.35))
    task = resolve_task(None, without)
    nominal = nominal_conditions(without, task)
    first, second = (families_of(robot, task, nominal, **effort) for robot in (without, with_it))
    assert nominal is not None
    assert with_lengths_of(with_it, task, nominal) is not None
    assert not any(one.coupled for one in first.of_corank(1))
    assert any(one.coupled == (2, 3) for one in second.of_corank(1))
    assert second.verified
    third = families_of(again, task, nominal_conditions(with_it, task), **effort)
    assert third.verified
    assert any(one.evidence.kind is ObtainedFrom.EXACT for one in third.of_corank(1) if one.coupled)


@pytest.mark.by_hand
def test_nominal_conditions_that_do_not_hold_are_not_taken() -> None:
    """Conditions with joints pinned elsewhere are tried, refused, and cost nothing but time."""
    robot = rankdrop.open_robot("puma560")
    task = resolve_task(None, robot)
    effort: Any = {"starts": 200, "fresh": 200, "limits": False, "seed": 0}
    nominal = nominal_conditions(robot, task)
    assert nominal is not None
    wrong = []
    for one in nominal.families:
        exact = exact_of(one)
        pins = tuple(AnglePin(pin.joint, ("pi/2",)) for pin in exact.pins)
        wrong.append(replace(one, exact=replace(exact, stated=(*pins, *exact.polynomials))))
    again = families_of(robot, task, replace(nominal, families=tuple(wrong)), **effort)
    plain = families_of(robot, task, nominal, **effort)
    assert [one.dimension for one in again.families] == [one.dimension for one in plain.families]
    assert again.verified
    assert plain.verified
