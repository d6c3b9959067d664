"""Cases that are not taken apart: the statement stays whole, is tested as families are, and says what it is."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("flint")

from rankdrop.algebra.halt import Halt, HaltKind
from rankdrop.algebra.work import OutOfTime, TooLong, Work
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.exact import families as real_families
from rankdrop.exact import tree as rank_trees
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.tree import rank_tree
from rankdrop.exact.undivided import _witness as undivided_witness
from rankdrop.families.unfinished import UnfinishedKind
from rankdrop.formula.equation import System
from rankdrop.formula.writing import AnglePin
from rankdrop.local.block import singular_values
from rankdrop.results.conditions import Conditions
from rankdrop.results.stored_conditions import shipped_conditions, to_stored
from rankdrop.robot.open import open_robot
from rankdrop.verbs import deriving
from rankdrop.verbs.analyze import derive
from rankdrop.verbs.conditions import conditions


def derived(name: str, task: str | None = None, points: int = 60) -> Conditions:
    return conditions(open_robot(name), task, method="tree", points=points, special=False)


@pytest.fixture
def undividable(monkeypatch: pytest.MonkeyPatch) -> None:
    """No set but the whole space can be cut."""
    cut = rank_trees._cut

    def too_long(columns, order, piece, bending, work):
        if piece.codimension:
            raise TooLong(Halt(HaltKind.FACTORING, terms=9))
        return cut(columns, order, piece, bending, work)

    monkeypatch.setattr(rank_trees, "_cut", too_long)


@pytest.mark.shipped
@pytest.mark.usefixtures("undividable")
def test_cases_hold_every_singularity_and_the_verdict_counts_them() -> None:
    whole = shipped_conditions("panda")
    found = derived("panda")
    number = len(found.undivided)
    assert number
    assert not found.families
    assert found.complete
    assert found.verified
    assert not found.in_families
    assert f"; {number} cases were not taken apart; coranks above 1 were not derived" in found.verdict.sentence
    assert found.answer.endswith(f"singular in {number} cases not taken apart into families.")
    systems = [System(one.equations) for one in found.undivided]
    for family in whole.families:
        assert any(system.zero(np.array([family.witness]))[0] for system in systems)
    for one in found.undivided:
        assert one.off == one.found > 0
        assert singular_values(found.robot, np.array(one.witness), found.task)[found.generic_rank - 1] < 1e-12


@pytest.mark.slow
@pytest.mark.usefixtures("undividable")
def test_a_case_that_is_missing_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    keep = deriving.undivided_sets
    monkeypatch.setattr(deriving, "undivided_sets", lambda *given: keep(*given)[1:])
    found = derived("planar3r", "vx")
    assert not found.verified
    assert not found.complete or found.disagreements


def test_no_set_is_lost_where_a_limit_ends_the_search_after_one_grew_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    cut, chain = rank_trees._cut, exact_chain(open_robot("panda"))
    ends: list[type[Exception]] = []

    def stop(columns, order, piece, bending, work):
        if not piece.codimension:
            return cut(columns, order, piece, bending, work)
        raise ends.pop() if ends else TooLong

    monkeypatch.setattr(rank_trees, "_cut", stop)
    every = {case.piece.key for case in rank_tree(chain, Work(60.0)).cases}
    ends += [OutOfTime, TooLong]
    tree = rank_tree(chain, Work(60.0))
    assert len(every) > 1
    assert {case.piece.key for case in tree.cases} == every
    assert tree.is_stated
    assert not tree.complete


def test_the_whole_space_is_no_case(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_long(*_given):
        raise TooLong(Halt(HaltKind.FACTORING, terms=9))

    monkeypatch.setattr(rank_trees, "_cut", too_long)
    found = derived("planar3r", "vx")
    assert not found.undivided
    assert not found.complete
    assert "1 sets were not derived to the end" in str(found.left[0])


@pytest.mark.usefixtures("undividable")
def test_cases_are_printed_and_stored() -> None:
    found = derived("planar3r")
    text = str(found)
    assert "corank 2 or more where θ2 = 0, and 9 minors vanish, of order 2 (degree at most 2 in sines" in text
    assert "no real configuration was found from 96 starts, which proves nothing" in text
    stored = found.to_dict()["undivided"]
    assert [one["pins"] for one in stored] == [{"2": ["0"]}, {"2": ["pi"]}]
    assert [one["witness"] for one in stored] == [None, None]


@pytest.mark.usefixtures("undividable")
def test_short_conditions_of_a_case_are_written_out_and_long_ones_by_size(monkeypatch: pytest.MonkeyPatch) -> None:
    found = derived("planar3r", "vx", points=0)
    text = str(found)
    assert "case 1: corank 1 or more where θ1 + θ2 + θ3 = π, and 3 minors vanish" in text
    assert "c_ij is cos(θi + θj)" in text
    assert [one["conditions"] for one in found.to_dict()["undivided"]] == [["θ1 + θ2 + θ3 = π"], ["θ1 + θ2 + θ3 = 0"]]
    monkeypatch.setattr("rankdrop.exact.undivided._READABLE", 1)
    found = derived("planar3r", "vx", points=0)
    assert "where 1 polynomial in joints 1, 2, 3 vanishes (degree 3" in str(found)
    assert [one["conditions"] for one in found.to_dict()["undivided"]] == [[], []]


@pytest.mark.usefixtures("undividable")
def test_whoever_needs_families_alone_refuses_cases() -> None:
    with pytest.raises(OptionError, match="cases were not taken apart"):
        derived("planar3r", "vx", points=0).test("s2 = 0")
    with pytest.raises(ResultFileError, match="cases were not taken apart"):
        to_stored(derived("planar3r", "vx", points=0))
    robot = open_robot("planar3r")
    task = derived("planar3r", "vx", points=0).task
    found, record = derive(robot, task, exact="auto", seed=0, fresh=True, progress=None)
    assert found is None
    assert record is not None
    assert "2 cases were not taken apart" in str(record.reason)


def one_set_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    """A limit ends the search for real points after the first set."""
    sharp, calls = real_families._sharp, []

    def limited(*given):
        calls.append(given)
        if len(calls) > 1:
            raise OutOfTime
        return sharp(*given)

    monkeypatch.setattr(real_families, "_sharp", limited)


def nothing_separates(monkeypatch: pytest.MonkeyPatch) -> None:
    """The conditions of every set hold at regular configurations, too."""
    monkeypatch.setattr(real_families, "_verdict", lambda *_: (UnfinishedKind.STRAYS, None))


def a_set_has_no_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest set has no point modulo any prime: its rank is not known."""

    def without(*given, **more):
        tree = rank_tree(*given, **more)
        drop = tree.drops.pop(0)
        tree.without_points.append((drop.piece, drop.rank + 1, False))
        return tree

    monkeypatch.setattr(deriving, "rank_tree", without)


@pytest.mark.slow
@pytest.mark.shipped
@pytest.mark.parametrize("plant", [one_set_is_searched, nothing_separates, a_set_has_no_points])
def test_a_set_that_is_not_finished_is_a_case(plant, monkeypatch: pytest.MonkeyPatch) -> None:
    plant(monkeypatch)
    found = derived("anthropomorphic")
    assert found.left == ()
    assert found.complete
    assert found.verified, found.verdict.sentence
    assert found.undivided
    assert not found.in_families
    held = [(one.corank, System(one.equations)) for one in (*found.families, *found.undivided)]
    for family in shipped_conditions("anthropomorphic").families:
        witness = np.array([family.witness])
        assert any(system.zero(witness)[0] for corank, system in held if corank >= family.corank)


@pytest.mark.slow
@pytest.mark.shipped
def test_a_set_is_not_finished_where_the_tree_states_no_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    nothing_separates(monkeypatch)
    monkeypatch.setattr(rank_trees.RankTree, "is_stated", False)
    found = derived("anthropomorphic", points=0)
    assert not found.complete
    assert not found.undivided
    assert str(found.left[0]).startswith("the conditions of a set of rank 5 hold at configurations of higher rank, too")
    assert {one.kind for one in found.left} == {UnfinishedKind.STRAYS}


def test_a_witness_is_a_singular_configuration_on_its_set() -> None:
    """What a candidate leads to counts where the conditions of the set hold there; else the next one is tried."""
    chain = exact_chain(open_robot("planar3r"))
    system = System((AnglePin(2, ("0",)).equation({}, 3),))
    leads_to = {0.1: [0.3, 0.5, 0.2], 0.2: [0.3, 0.0, 0.2], 0.3: [0.9, 0.0, 0.9]}

    def followed(q: np.ndarray) -> np.ndarray:
        return np.array([leads_to[q[1]]])

    candidates = np.array([[0.0, 0.1, 0.0], [0.0, 0.2, 0.0], [0.0, 0.3, 0.0]])
    assert undivided_witness(chain, candidates, system, followed) == (0.3, 0.0, 0.2)
    nowhere = undivided_witness(chain, candidates, system, lambda q: np.empty((0, 3)))
    assert nowhere == (0.0, 0.1, 0.0)
    assert undivided_witness(chain, candidates[:0], system, followed) is None
