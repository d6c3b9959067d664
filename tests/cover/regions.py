"""Regions of joint values, and a family inside them."""

from __future__ import annotations

from rankdrop.cover.speed import SpeedRegion
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


def region_of(name: str, speed: float = 0.25, **given) -> SpeedRegion:
    arm = open_robot(name)
    return SpeedRegion(arm, resolve_task(None, arm), speed, **given)


def family_of(name: str, number: str):
    return next(one for one in shipped(name).families if one.id == number)
