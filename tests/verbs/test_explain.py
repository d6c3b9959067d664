"""What `explain` takes and refuses, and that it answers the same twice."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.local.block import sample
from rankdrop.local.nearest import nearest_singularity
from rankdrop.local.ways_out import escape
from rankdrop.robot.open import open_robot
from rankdrop.task import resolve_task
from rankdrop.tolerances import Tolerances
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.explain import explain


def test_families_of_an_analysis_given() -> None:
    arm = open_robot("scara")
    analysis = analyze(arm, starts=200, exact="off")
    found = explain(arm, [0.3, 0.0, 0.1, 0.2], analysis=analysis)
    assert found.met[0].source == "analysis"
    with pytest.raises(OptionError, match="another arm"):
        explain(open_robot("pa10"), [0.0] * 7, analysis=analysis)
    with pytest.raises(OptionError, match="an analysis is needed"):
        explain(arm, [0.3, 0.0, 0.1, 0.2], analysis="scara.json")  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="another task"):
        explain(arm, [0.3, 0.0, 0.1, 0.2], "position", analysis=analysis)


def test_bad_input() -> None:
    arm = open_robot("pa10")
    with pytest.raises(ConfigurationError):
        explain(arm, [0.0] * 6)
    with pytest.raises(ConfigurationError):
        explain(arm, [np.nan] + [0.0] * 6)
    with pytest.raises(OptionError):
        explain(arm, [0.0] * 7, near=-1.0)


def test_the_same_twice() -> None:
    arm = open_robot("panda")
    q = sample(arm, resolve_task(None, arm), 1, seed=9)[0]
    assert explain(arm, q).to_dict() == explain(arm, q).to_dict()


@pytest.mark.parametrize(
    "options",
    [{"seed": -1}, {"seed": 1.5}, {"near": float("nan")}, {"near": "0.1"}, {"evaluations": 1.5}, {"step": 0.0},
     {"small": None}, {"coranks": -1}, {"tolerances": Tolerances(singular=0.5)},
     {"tolerances": Tolerances(singular=-1.0)}, {"tolerances": Tolerances(singular=float("nan"))}],
)  # fmt: skip
def test_options_that_make_no_sense_are_refused(options: dict) -> None:  # type: ignore[type-arg]
    with pytest.raises(OptionError):
        explain(open_robot("ur5"), [0.0] * 6, **options)


@pytest.mark.parametrize("q", ["0,0,0,0,0,0", [1j] * 6, {}, [0, 0, 0, 0, 0, "x"], None, [[0.0] * 6]])
def test_what_is_no_configuration_is_refused(q: object) -> None:
    for ask in (explain, escape, nearest_singularity):
        with pytest.raises(ConfigurationError):
            ask(open_robot("ur5"), q)  # type: ignore[operator]
