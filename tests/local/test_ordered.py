"""GR's procedures and their example: what is printed, what motion does, and where the two part."""

from __future__ import annotations

import doctest
from pathlib import Path

import numpy as np
import pytest
from local.gupta import GR, SCREWS
from reference import arms

from rankdrop.errors import OptionError, RobotError
from rankdrop.kinematics import jacobian
from rankdrop.local.instructions import session
from rankdrop.local.ordered import OrderedScrewSet, motion, ordered_subsets
from rankdrop.local.ordered_report import report
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws
from rankdrop.task import SPACE, resolve_task

DOC = Path(__file__).resolve().parents[2] / "docs" / "gallardo-rico.md"
RUNS = ((1, 5), (1, 6), (2, 7), (1, 7))


def dimensions(screws: OrderedScrewSet) -> list[int]:
    return [screws.dimension(*run) for run in RUNS]


def test_the_catalogue_holds_the_screws_of_the_document() -> None:
    assert np.allclose(OrderedScrewSet.of(open_robot("rcrrrr"), np.zeros(7)).screws, SCREWS, atol=1e-15)


def test_the_runs_of_the_example() -> None:
    found = {(s.first, s.last): (s.dimension, s.loss, s.msos, s.minimal) for s in GR.subsets()}
    assert found == {
        (1, 5): (4, 1, True, True), (3, 7): (4, 1, True, True), (1, 6): (5, 1, True, False),
        (2, 7): (5, 1, True, False), (1, 7): (5, 2, False, False),
    }  # fmt: skip
    robot = open_robot("rcrrrr")
    told = ordered_subsets(robot, np.zeros(7), resolve_task("pose", robot))
    assert {(s.first, s.last): (s.dimension, s.loss, s.msos, s.minimal) for s in told} == found
    assert not any(s.generic for s in told)
    for (first, last), (dimension, loss, msos, minimal) in found.items():
        one = GR.msos(first, last)
        assert (one.dimension, one.loss, one.msos, one.minimal) == (dimension, loss, msos, minimal)


def test_the_ten_products_and_the_two_actuators() -> None:
    found = GR.subspace(1, 5)
    inside = {(u, v) for u, v, told in found.entries if told}
    assert inside == {(1, 2), (1, 5), (2, 3), (2, 4), (2, 5)}
    assert len(found.entries) == 10
    assert found.actuators == (3, 4)


def test_the_printed_update() -> None:
    four, three = GR.newscrews(4, 5), GR.newscrews(3, 5)
    assert np.array_equal(four.readoss(5, 5), [[1, 0, -1, 0, 5, 0]])
    assert np.array_equal(three.readoss(4, 5), [[0, 1, 0, 5, 0, 5], [1, 0, -1, 0, 0, 0]])
    assert dimensions(four) == [5, 5, 5, 5]
    assert dimensions(three) == [5, 6, 6, 6]
    assert np.array_equal(four.screws[5:], SCREWS[5:]), "the printed update leaves screws 6 and 7 behind"


def test_motion_carried_to_the_end() -> None:
    assert dimensions(GR.propagated(3)) == [5, 6, 5, 6]
    assert dimensions(GR.propagated(4)) == [5, 6, 6, 6]
    for number in (1, 2, 5, 6, 7):
        assert dimensions(GR.propagated(number)) == dimensions(GR) == [4, 5, 5, 5]


def test_the_session_prints_what_gr_print() -> None:
    steps = session(GR)
    assert [instruction for instruction, _ in steps] == [
        "readoss(1, 7)", "msos(1, 5)", "subspace(1, 5)", "newscrews(4, 5)", "dimension(1, 5)", "dimension(1, 6)",
        "readoss(4, 5)", "newscrews(3, 5)", "dimension(1, 5)", "dimension(1, 6)", "dimension(2, 7)",
    ]  # fmt: skip
    lines = [lines for _, lines in steps]
    assert lines[0][0] == "[1, 0, 0, 0, 0, -1]"
    assert lines[0][5] == "[0, 0.707107, 0.707107, 0, -7.07107, 7.07107]"
    assert lines[1] == ("dimension = 4", "lost freedoms = 1", "a minimal singular ordered subset")
    printed = "yes no no yes yes yes yes no no no"
    assert [line.split("] ")[1] for line in lines[2][:10]] == printed.split()
    assert lines[2][10:] == ("actuating screw 3 can restore (1, 5)", "actuating screw 4 can restore (1, 5)")
    assert lines[3] == ("S(5) = [1, 0, -1, 0, 5, 0]",)
    assert [lines[4], lines[5]] == [("5",), ("5",)]
    assert lines[6] == ("[0, 1, 0, 0, 0, 5]", "[1, 0, 0, 0, 0, 0]")
    assert lines[7] == ("S(4) = [0, 1, 0, 5, 0, 5]", "S(5) = [1, 0, -1, 0, 0, 0]")
    assert lines[8:] == [("5",), ("6",), ("6",)]


def test_the_example_judged_by_finite_motion() -> None:
    found = report(GR)
    assert (found.dimension, found.generic, found.lost, found.dependencies) == (5, 6, 1, 2)
    assert found.printed == (3,), "what GR conclude"
    assert found.escapes == (3, 4), "what the arm does"
    rates = {joint.number: joint.rate for joint in found.joints}
    assert rates[3] == pytest.approx(0.7036, abs=5e-5)
    assert rates[4] == pytest.approx(2.0713, abs=5e-5)
    assert [rates[j] for j in (1, 2, 5, 6, 7)] == [0.0] * 5
    carried = {j.number: {(a, b): d for a, b, d in j.dimensions} for j in found.joints}
    assert [carried[3][run] for run in RUNS] == [5, 6, 5, 6]
    assert [carried[4][run] for run in RUNS] == [5, 6, 6, 6]
    assert any(str(told).startswith("joint 4: escapes") for told in found.disagreements)
    assert any("(1–5: 3; 3–7: 4)" in str(told) for told in found.disagreements)


def test_a_single_product_outside_the_span_is_not_enough() -> None:
    """[S_1, S_3] leaves the span, and yet joint 1 gains nothing: the weighted sum is [S_1, −λ_1 S_1] = 0."""
    first = report(GR).joints[0]
    assert (1, 3, False) in GR.subspace(1, 5).entries
    assert 3 in first.outside
    assert first.weighted < 1e-9
    assert first.gain == 0
    assert first.remark.vanishes
    assert "Σ λ_i [S_1, S_i] vanishes" in str(first.remark)


def test_finite_motion_is_that_of_the_arm(rng: np.random.Generator) -> None:
    for kinds in ("rprhrrr", "hhprr"):
        robot = arms.random_chain(rng, kinds)
        q = rng.normal(size=robot.n)
        here = OrderedScrewSet.of(robot, q)
        for number in range(1, robot.n + 1):
            moved = q.copy()
            moved[number - 1] += 0.7
            expected = np.roll(jacobian(robot, moved, SPACE).T, 3, axis=1)
            assert np.abs(here.moved(number, 0.7).screws - expected).max() < 1e-12
            small = here.moved(number, 1e-6).screws - here.screws
            first = here.propagated(number).screws - here.screws
            assert np.abs(small / 1e-6 - first).max() < 1e-4


def test_a_screw_of_any_length_turns_by_its_own_rate() -> None:
    screw = np.array([0, 0, 2.0, 0, 0, 0.6])
    assert np.allclose(motion(screw, 0.3), motion(screw / 2, 0.6))
    back = motion(screw, 0.3) @ motion(screw, -0.3)
    assert np.allclose(back, np.eye(6))


@pytest.mark.parametrize("change", ["base", "unit", "sign", "slow"])
def test_what_is_told_does_not_depend_on_frame_unit_or_sign(change: str, rng: np.random.Generator) -> None:
    if change == "base":
        ad = arms.adjoint(arms.rigid(rng, 5.0))
        screws = np.roll((ad @ np.roll(SCREWS, 3, axis=1).T).T, 3, axis=1)
    elif change == "unit":
        screws = SCREWS * [1, 1, 1, 1e-3, 1e-3, 1e-3]
        screws[1] *= 1e3
    else:
        screws = SCREWS * rng.choice([-1.0, 1.0] if change == "sign" else [0.5, 3.0], 7)[:, None]
    found, expected = report(OrderedScrewSet(screws)), report(GR)
    assert found.subsets == expected.subsets
    assert found.escapes == expected.escapes
    assert [j.gain for j in found.joints] == [j.gain for j in expected.joints]
    assert OrderedScrewSet(screws).subspace(1, 5).entries == GR.subspace(1, 5).entries


def test_the_reversed_chain_escapes_by_the_mirrored_joints() -> None:
    back = report(OrderedScrewSet(SCREWS[::-1]))
    assert {8 - number for number in back.escapes} == set(report(GR).escapes)
    assert {(8 - s.last, 8 - s.first) for s in back.subsets} == {(s.first, s.last) for s in GR.subsets()}


def test_runs_against_numpy(rng: np.random.Generator) -> None:
    losses = 0
    for _ in range(80):
        screws = rng.integers(-1, 2, (int(rng.integers(2, 9)), 6)).astype(float)
        screws[~screws.any(axis=1), 0] = 1.0
        found = {(s.first, s.last): s for s in OrderedScrewSet(screws).subsets()}
        for first in range(1, len(screws) + 1):
            for last in range(first, len(screws) + 1):
                rank = np.linalg.matrix_rank(screws[first - 1 : last], tol=1e-9)
                told = found.get((first, last))
                assert (told.dimension if told else last - first + 1) == rank
                losses += told is not None
                inside = any((a, b) != (first, last) and first <= a and b <= last for a, b in found)
                assert told is None or told.minimal is not inside
    assert losses > 40


def test_runs_that_are_dependent_everywhere_are_called_generic() -> None:
    robot = open_robot("pa10")
    found = ordered_subsets(robot, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7], resolve_task("pose", robot))
    assert [(s.first, s.last, s.generic) for s in found] == [(1, 7, True)]


def test_a_list_of_numbers_is_read(tmp_path: Path) -> None:
    path = tmp_path / "S.txt"
    rows = ["# GR section 5", *(" ".join(map(str, row)) for row in SCREWS[:5]), ""]
    rows += ["[0, 1/sqrt(2), 1/sqrt(2), 0, -10/sqrt(2), 10/sqrt(2)]  # 6", "0 .707106 -.707106 0 7.07106 7.07106"]
    path.write_text("\n".join(rows))
    found = OrderedScrewSet.read(path)
    assert len(found) == 7
    assert np.allclose(found.screws, SCREWS, atol=1e-5)
    assert report(found).escapes == (3, 4)


def test_a_robot_file_is_read_as_ever(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    rows = "\n".join(f'[[joints]]\nname = "j{i}"\nscrew = {list(map(float, row))}' for i, row in enumerate(SCREWS[:5]))
    path.write_text(f'name = "five"\norder = "angular-first"\n[home]\nxyz = [0, 0, 0]\n{rows}\n')
    assert np.allclose(OrderedScrewSet.read(path).screws, SCREWS[:5])


@pytest.mark.parametrize(("text", "told"), [
    ("1 0 0 0 0\n", "line 1, column 10: a screw has six numbers"),
    ("# one\n1 0 0 0 0 0 7\n", "line 2, column 13: a screw has six numbers"),
    ("1 0 0 0 0 0\n1 0 x 0 0 0\n", "line 2, column 5"),
    ("1 0 0 nan 0 0\n", "line 1, column 7"),
    ("# nothing\n", "no screws"),
    ("0 0 0 0 0 0\n", "screw 1: a screw is zero"),
])  # fmt: skip
def test_what_is_no_screw_list_is_refused_with_its_place(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "S.txt"
    path.write_text(text)
    with pytest.raises(RobotError, match=told):
        OrderedScrewSet.read(path)


def test_the_set_is_an_arm_again() -> None:
    robot = GR.robot()
    assert np.allclose(OrderedScrewSet.of(robot, np.zeros(7)).screws, SCREWS)
    with pytest.raises(ValueError, match="read-only"):
        GR.screws[0, 0] = 2.0
    with pytest.raises(OptionError):
        GR.lie(0, 1)
    assert from_screws(SCREWS, order="angular-first").n == len(GR)


def test_the_examples_of_the_page_are_true() -> None:
    failed, tried = doctest.testfile(str(DOC), module_relative=False, optionflags=doctest.ELLIPSIS)
    assert failed == 0
    assert tried >= 5
