"""Families derived of an arm."""

from __future__ import annotations

from rankdrop.robot.open import open_robot
from rankdrop.verbs.conditions import conditions


def derived(arm: str, coranks: int = 2, **given):
    return conditions(open_robot(arm), method="reciprocity", coranks=coranks, points=20, **given)
