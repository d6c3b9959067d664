"""A family has one id and one name for one arm and task, in every output, however it was found."""

from __future__ import annotations

import re

import numpy as np
import pytest

from known.arms import FEW
from rankdrop.families.evidence import ObtainedFrom
from rankdrop.families.naming import LONGEST
from rankdrop.report.content import content
from rankdrop.results.known import conditions_names, known_names, shipped
from rankdrop.results.stored_conditions import shipped_conditions
from rankdrop.robot.open import open_robot
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.explain import explain

STARTS = 1500
SIMPLE = {"π": 180.0, "π/2": 90.0, "−π/2": -90.0}
LONG = ("iiwa14", "canadarm2", "fetch8")
PLAIN = ("puma560", "ur5e")
pytestmark = pytest.mark.shipped


def named(families):
    return [(one.id, one.name, one.corank, one.dimension) for one in families]


@pytest.mark.spread(143)
@pytest.mark.slow
@pytest.mark.parametrize("name", conditions_names())
def test_shipped_atlas_and_shipped_conditions_list_the_same_families(name):
    found, derived = shipped(name), shipped_conditions(name)
    assert named(found.families) == named(derived.families)
    for corank in {one.corank for one in found.families}:
        names = [one.name for one in found.of_corank(corank)]
        assert len(set(names)) == len(names)


@pytest.mark.by_hand_at("ur5e", "puma560")
@pytest.mark.slow_at("ur5e", "puma560", "stanford")
@pytest.mark.parametrize("name", [pytest.param(x, marks=pytest.mark.by_hand if x in LONG else ()) for x in FEW])
def test_what_is_analysed_on_the_spot_has_the_ids_and_names_of_what_is_shipped(name):
    arm = open_robot(name)
    one = analyze(arm, starts=STARTS, seed=0)
    other = analyze(arm, starts=STARTS, seed=5)
    assert named(one.families) == named(other.families) == named(shipped(name).families)


@pytest.mark.by_hand_at("ur5e")
@pytest.mark.slow_at("ur5e", "puma560")
@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=() if x in PLAIN else pytest.mark.by_hand) for x in conditions_names()]
)
def test_every_face_calls_a_family_the_same(name):
    found, derived = shipped(name), shipped_conditions(name)
    expected = {one.id: one.name for one in found.families}
    scope: dict = {}
    exec(compile(derived.code("python"), "generated", "exec"), scope)
    assert scope["NAMES"] == expected
    header = derived.code("c")
    for mark, said in expected.items():
        assert f'_{mark.replace(".", "_").upper()}_NAME "{said}"' in header
    shown = content(found)
    assert {one.id: one.name for one in shown.analysis.families} == expected
    assert shown.exact is not None
    assert {one.id: one.name for one in shown.exact.families} == expected
    for family in found.families:
        met = explain(open_robot(name), family.witness).met[0].family
        assert (met.id, met.name) == (family.id, family.name)


@pytest.mark.by_hand
@pytest.mark.slow_at("ur5", "irb2600")
@pytest.mark.parametrize("name", ["irb2600", "ur5"])
def test_rows_are_cut_and_joined_as_the_exact_conditions_are(name):
    """Sampling alone lists an IRB 2600's elbow twice, by its two values; the families are the derived ones."""
    sampled = analyze(open_robot(name), starts=STARTS, exact="off").of_corank(2)
    both = analyze(open_robot(name), starts=STARTS).of_corank(2)
    assert (len(sampled) != len(both)) == (name == "irb2600")
    assert all(one.evidence.kind is ObtainedFrom.EXACT for one in both)
    assert named(both) == named(one for one in shipped_conditions(name).families if one.corank == 2)
    assert all(one.soundness.holds and one.explained.agree for one in both)


@pytest.mark.parametrize("name", known_names())
def test_no_two_families_of_an_arm_and_corank_share_a_name_and_every_name_says_what_is_open(name):
    found = shipped(name)
    for corank in {one.corank for one in found.families}:
        names = [one.name for one in found.of_corank(corank)]
        assert len(set(names)) == len(names)
    for one in found.families:
        assert len(one.name) <= LONGEST
        assert "others" not in one.name
        for joint, values in re.findall(r"θ(\d) = ([^,()]*°[^,()]*)", one.name):  # one of them is met at the witness
            at = np.degrees(one.witness[int(joint) - 1])
            both = values.replace("±", "−") + f" or {values[1:]}" * values.startswith("±")
            plain = [SIMPLE.get(x) or float(x.strip("°").replace("−", "-")) for x in both.split(" or ")]
            rounded = 0.06 if "." in values else 0.56  # to a tenth, then to a whole one
            assert min(abs((x - at + 180) % 360 - 180) for x in plain) < rounded, (one.name, at)
