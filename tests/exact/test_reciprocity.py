"""A screw reciprocal to five joint screws and the others, and the places at which it vanishes itself."""

from __future__ import annotations

import pytest
from exact.chains import chain_of
from exact.strata import derived, holds_at, strata

from rankdrop.algebra.zeroset import ZeroSet
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.conjunctions import SetDerivation, columns_on
from rankdrop.exact.methods import derive
from rankdrop.exact.reciprocity import reciprocal_choices
from rankdrop.robot.open import open_robot
from rankdrop.text.by_hand import notes_of


@pytest.mark.by_hand
def test_the_reciprocal_screw_of_canadarm2_vanishes_where_its_notes_say() -> None:
    """KG section 1: the expression of the screw is invalid where all of its elements vanish."""
    found = derived("canadarm2", "reciprocity")
    assert found.sizes["exceptional"] > 0
    notes = notes_of(found)
    place = next(i for i, note in enumerate(notes) if note.startswith("in general: the screw reciprocal to"))
    assert "all six elements vanish, and it says nothing, where θ4 = 0 or π, or where θ6 = 0" in notes[place + 1]
    assert found.sizes["choices"] > 1
    first = found.conditions[0]
    assert first.unequal, "the first choice holds only where its screw does not vanish"


@pytest.mark.by_hand
@pytest.mark.parametrize(("theta4", "singular"), [("0", ()), ("π", ("θ3 + θ5 = 0 and (θ6 = 0 or π)",))])
def test_the_screw_of_kg_vanishes_where_c5_and_s6_do(theta4: str, singular: tuple[str, ...]) -> None:
    """KG section 1, of the screw reciprocal to joints 2 to 7 where s4 = 0: invalid where s6 = 0 and c5 = 0."""
    found = derive(chain_of("canadarm2"), "reciprocity", frame=5, basic=(2, 3, 4, 5, 6, 7))
    notes = notes_of(found)
    place = next(i for i, note in enumerate(notes) if note.startswith(f"θ4 = {theta4}: the screw reciprocal to"))
    assert "joints 2, 3, 4, 6, 7" in notes[place]
    for said in ("θ5 = ±π/2 and (θ6 = 0 or π)", *singular):
        assert said in notes[place + 1]


def test_basic_screws_are_chosen_for_reciprocity_alone() -> None:
    with pytest.raises(OptionError, match="chosen for another method"):
        derive(chain_of("canadarm2"), "cofactors", basic=(2, 3, 4, 5, 6, 7))
    with pytest.raises(OptionError, match="six different joints"):
        derive(chain_of("canadarm2"), "reciprocity", basic=(2, 3, 4, 5, 6, 8))


@pytest.mark.slow
def test_without_the_exceptional_cases_reciprocity_misses_singularities() -> None:
    found = derived("canadarm2", "reciprocity")
    points, singular = strata("canadarm2")
    alone = [holds_at(found.conditions[0], found.ring, point) for point in points]
    assert sum(alone) < sum(singular)


def test_reciprocity_refuses_an_arm_of_fewer_joints_than_rows() -> None:
    chain = exact_chain(open_robot("planar2r"), "vx,vy,wz")
    with pytest.raises(OptionError, match=r"fewer joints"):
        derive(chain, "reciprocity")


@pytest.mark.parametrize(("task", "frame"), [("pose", 0), ("pose", 7), ("position", 2)])
def test_a_link_frame_that_is_none_or_of_some_rows_is_refused(task: str, frame: int) -> None:
    with pytest.raises(OptionError, match="no such link frame"):
        derive(exact_chain(open_robot("puma560"), task), "reciprocity", frame=frame)


def test_what_is_said_to_vanish_does() -> None:
    """At θ4 = π, θ5 = π/2, θ6 = 0 every element of the screw is zero, and the other angles are free."""
    chain = chain_of("canadarm2")
    builder = SetDerivation(chain, "reciprocity", 30.0, frame=5, basic=(2, 3, 4, 5, 6, 7))
    joints, screw = reciprocal_choices(builder, columns_on(ZeroSet(chain.ring, {4: "pi"}), builder.columns))[0]
    assert [j + 1 for j in joints] == [2, 3, 4, 6, 7]
    assert any(w != 0 for w in screw)
    assert all(chain.ring.at(w, {4: "pi", 5: "pi/2", 6: "0"}) == 0 for w in screw)
    assert any(chain.ring.at(w, {4: "pi", 5: "pi/2"}) != 0 for w in screw)
