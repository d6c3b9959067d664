"""The singular set as common zeros of maximal minors: of a square arm, of a redundant one, factored or not."""

from __future__ import annotations

from itertools import combinations
from time import process_time

import numpy as np
import pytest
from exact.chains import SRS, chain_of
from exact.strata import derived, holds_modulo, strata

from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.conjunctions import values_of
from rankdrop.exact.methods import derive
from rankdrop.exact.vanishing_minors import zero_of
from rankdrop.families.points import cloud
from rankdrop.kinematics import task_jacobian
from rankdrop.local.block import sample, singular_values
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.text.by_hand import notes_of
from rankdrop.units import out_of_units


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("scara", {"θ2=0", "θ2=pi"}),
        ("planar3r", {"θ2=0", "θ2=pi"}),
        ("stanford", {"θ2=0", "θ2=pi", "θ5=0", "θ5=pi", "q3"}),
    ],
)
def test_known_determinants(name: str, expected: set[str]) -> None:
    keys = {atom.key for c in derived(name, "determinant").conditions for atom in c.equal[0].atoms}
    assert keys == expected


def test_puma_has_elbow_shoulder_and_wrist() -> None:
    found = derived("puma560", "determinant")
    parts = [equality for c in found.conditions for equality in c.equal]
    assert [len(part.atoms) for part in parts] == [1, 1, 1, 1]
    pins = {part.atoms[0].key for part in parts if part.atoms[0].is_pin}
    assert pins == {"θ5=0", "θ5=pi"}
    assert {str(f) for f in found.assumptions} == {"a2"}


def test_the_determinant_of_a_redundant_arm_is_its_minors_that_vanish_together() -> None:
    """det(J Jᵀ) is the sum of their squares: over the reals no more is needed, and nothing is left."""
    found = derived("canadarm2", "determinant")
    assert found.complete
    assert found.conditions == derived("canadarm2", "cofactors").conditions
    assert any("the sum of the squares of 7 minors" in note for note in notes_of(found))
    assert any("without a change of sign" in note for note in notes_of(found))


def test_a_redundant_arm_has_as_many_cofactors_as_choices_of_columns() -> None:
    found = derived("canadarm2", "cofactors")
    assert found.sizes["minors"] == 7
    assert len(found.conditions[-1].equal) == 7


def test_a_long_determinant_without_time_is_kept_whole_and_said_to_be_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rankdrop.algebra.ring.Ring.factors_within", lambda *_: None)
    found = derive(chain_of("puma560"), "determinant", 10.0)
    assert list(map(str, found.left)) == ["determinant: factors of 1 polynomial"]
    points, singular = strata("puma560")
    assert holds_modulo(found, points) == singular


@pytest.mark.slow
def test_minors_that_are_not_factored_are_conditions_with_a_zero_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """The set is complete without factors; what is open is said: terms, degree, and where a minor vanishes."""
    monkeypatch.setattr("rankdrop.algebra.ring.Ring.factors_within", lambda *_: None)
    chain = chain_of("canadarm2")
    found = derive(chain, "determinant", 10.0)
    points, singular = strata("canadarm2", 30)
    assert holds_modulo(found, points) == singular
    assert found.complete
    facts = [note for what, note in found.notes if what == "unfactored"]
    minors = {six: chain.ring.determinant([[chain.columns[j - 1][i] for j in six] for i in range(6)])
              for six in combinations(range(1, 8), 6)}  # fmt: skip
    assert [one["choice"][1] for one in facts] == [six for six, minor in minors.items() if minor != 0]
    for one in facts:
        columns = task_jacobian(chain.robot, np.array(one["zero"]), chain.task)[:, [j - 1 for j in one["choice"][1]]]
        assert abs(np.linalg.det(columns)) < 1e-9
        assert abs(np.linalg.det(columns / np.linalg.norm(columns, axis=0))) < 1e-9
    said = [line for line in notes_of(found) if "was not factored" in line]
    assert len(said) == len(facts)
    assert said[0].startswith(f"|$1 $2 $3 $4 $5 $6| = 0, of {facts[0]['terms']} terms and degree {facts[0]['degree']} ")


@pytest.mark.by_hand
def test_a_sum_of_squares_raises_no_false_alarm_near_singularities() -> None:
    """Of 20,000 random configurations some lie close to singular ones: det(J Jᵀ) is tiny there, and not zero."""
    rows = [*SRS[:4], (0, -np.pi / 2, 0.35, 0), *SRS[5:]]
    chain = exact_chain(from_dh(rows, convention="standard"))
    found = derive(chain, "determinant")
    assert found.complete
    q = out_of_units(chain.robot, sample(chain.own, chain.own_task, 20_000, 1))
    sigma = singular_values(chain.robot, q, chain.task)[:, 5]
    assert (sigma < 0.01).sum() > 100
    assert not found.holds(q[sigma > 1e-3]).any()
    met = cloud(chain.own, chain.own_task, 1, 100)
    assert found.holds(out_of_units(chain.robot, met.q)).all()


def general_7r(*twists: float) -> Robot:
    """Seven turning joints, every offset there; twists [°]."""
    rows = [(0.11 + 0.03 * i, np.deg2rad(twist), 0.2 + 0.07 * i, 0) for i, twist in enumerate(twists)]
    return from_dh(rows, convention="standard")


RIGHT = (-90, 90, -90, 90, -90, 90, -90)


@pytest.mark.slow
@pytest.mark.parametrize("twists", [RIGHT, (60, -45, 90, -30, 60, -90, 0)])
def test_the_determinant_of_a_general_7r_ends_with_seven_minors(twists: tuple[float, ...]) -> None:
    """Multiplied out it has 169,524 terms, and whether these have factors remained open."""
    before = process_time()
    found = derive(exact_chain(general_7r(*twists)), "determinant", 30.0)
    assert process_time() - before < 8.0
    assert found.complete
    assert [len(one.equal) for one in found.conditions] == [7]
    assert not any(what == "unfactored" for what, _ in found.notes)


def test_a_polynomial_of_one_sign_has_no_zero() -> None:
    chain = chain_of("puma560")
    p = chain.ring.determinant([[column[row] for column in chain.columns[3:]] for row in range(3, 6)])
    where = zero_of(chain, p)
    assert where is not None
    assert abs(values_of(chain, p, np.array([where]) + chain.shifts)[0]).max() < 1e-12
    assert zero_of(chain, p * p + 1) is None
    assert zero_of(chain, -p * p - 1) is None
