"""Which arms have a picture of their aspects."""

from __future__ import annotations

import pytest

from rankdrop.aspects import aspect_maps, count_of_arm
from rankdrop.errors import OptionError
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task


@pytest.mark.parametrize(("name", "why"), [("almarkhi4", "no condition separates"), ("stanford", "a slide")])
def test_an_arm_without_such_a_picture_says_why(name: str, why: str) -> None:
    arm = open_robot(name)
    with pytest.raises(OptionError, match=why):
        aspect_maps(*count_of_arm(arm, resolve_task(None, arm)))
