"""The families of `analyze` are derived exactly; numerical tests hold on known arms, and show what is wrong."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli import exits, main
from rankdrop.codec import json_text
from rankdrop.errors import MissingExtraError, OptionError, RobotError
from rankdrop.exact.family import pins_in_q
from rankdrop.families.not_derived import NotDerived, NotDerivedKind
from rankdrop.families.record import Family, exact_of
from rankdrop.formula.writing import AnglePin
from rankdrop.results.analysis import Analysis
from rankdrop.results.conditions import Conditions
from rankdrop.robot.dh import from_dh
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws
from rankdrop.schema import load_schema
from rankdrop.verbs import analyze as analyze_module
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions

ARMS = {  # exact families that the rows consist of, corank by corank
    "pa10": (4, 4, 1), "ur5": (3, 5, 1), "puma560": (3, 3), "canadarm2": (7, 4, 1), "stanford": (3, 3), "scara": (1,),
    "anthropomorphic": (3, 3, 1), "planar3r": (1,),
}  # fmt: skip
STARTS = 400


@pytest.mark.slow_at("stanford")
@pytest.mark.by_hand_at("canadarm2", "anthropomorphic", "pa10", "puma560", "ur5")
@pytest.mark.slow_at("canadarm2", "pa10", "ur5", "puma560", "anthropomorphic")
@pytest.mark.parametrize("name", ARMS)  # the Canadarm2 takes five seconds, the others one
def test_what_is_found_and_what_is_derived_agree(name: str) -> None:
    found = analyze(open_robot(name), starts=STARTS, exact="on")
    exact = found.exact
    assert exact is not None
    assert (exact.status, exact.disagreements) == ("agrees", ())
    assert found.verified
    counts = [sum(family.corank == k + 1 for family in found.families) for k in range(len(ARMS[name]))]
    assert tuple(counts) == ARMS[name]
    assert all(family.exact is not None for family in found.families)
    solved = [one.soundness for one in found.families]
    assert all(one.holds for one in solved)
    assert sum(one.tested for one in solved) >= 250 * len(found.coranks[:-1])
    record = json.loads(json_text(found.to_dict()))
    Draft202012Validator(load_schema("analysis")).validate(record)
    assert Analysis.from_dict(record) == found


@pytest.fixture
def meddle(monkeypatch: pytest.MonkeyPatch) -> Any:
    """meddle(change): the derivation hands over what `change` makes of its families."""

    def with_change(change: Any) -> None:
        def changed(*arguments: Any, **options: Any) -> Conditions:
            derived = conditions(*arguments, **options)
            return replace(derived, families=tuple(change(derived.families)))

        monkeypatch.setattr(sys.modules["rankdrop.verbs.conditions"], "conditions", changed)
        monkeypatch.setattr(sys.modules["rankdrop.verbs.analyze"], "known_conditions", lambda *given, **options: None)

    return with_change


def pinned_at(family: Family, angles: tuple[str, ...]) -> Family:
    """The family with joint 2 at other angles."""
    exact, pins = exact_of(family), (AnglePin(2, angles),)
    pinned = pins_in_q(open_robot("planar3r"), pins, exact.shifts)
    return replace(family, pinned=pinned, exact=replace(exact, pinned=pinned, stated=pins))


@pytest.mark.slow
def test_points_on_no_derived_family_are_listed_without_a_name_and_end_with_code_3(
    meddle: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    meddle(lambda families: families[1:])
    path = tmp_path / "arm.json"
    line = ("analyze", "planar3r", "--starts", "200", "--quiet", "--json", str(path))
    assert main.run(line) == exits.UNEXPLAINED
    assert "1,150 of 1,150 test points on no row" in " ".join(capsys.readouterr().out.split())
    kept = Analysis.load(path)
    assert [(one.id, one.named, one.dimension) for one in kept.families] == [("k1.f1", False, 2)]
    assert kept.families[0].exact is None
    assert not kept.verified


@pytest.mark.slow
def test_a_condition_with_a_value_too_few_leaves_points_over(meddle: Any) -> None:
    meddle(lambda derived: [pinned_at(one, ("0",)) for one in derived])
    half = analyze(open_robot("planar3r"), starts=200)
    share = half.coranks[0].completeness
    assert 0.2 * share.tested < share.agree < 0.8 * share.tested
    assert [one.named for one in half.families] == [True, False]
    assert not half.verified


def test_a_condition_with_a_value_too_many_is_not_sound(meddle: Any) -> None:
    meddle(lambda derived: [pinned_at(one, ("0", "pi", "pi/2")) for one in derived])
    found = analyze(open_robot("planar3r"), starts=200)
    (row,) = found.families
    assert 0 < row.soundness.agree < row.soundness.tested
    assert found.verdict.word == "unsound"


def test_a_derived_family_of_a_rank_that_is_never_lost_numerically_is_told(meddle: Any) -> None:
    """Of a wrong derivation: such a family has no table in which it could stand."""
    meddle(lambda exact: [*exact, replace(exact[0], id="k4.f1", corank=4)])
    found = analyze(open_robot("planar3r"), starts=100)
    assert [(one.id, one.exact is not None) for one in found.families] == [("k1.f1", True)]
    assert found.exact is not None
    (said,) = found.exact.disagreements
    name = found.families[0].name
    assert str(said) == f"derived k4.f1 ({name}) is not listed: its corank is 4, and the rank found is 3"
    assert found.verdict.word == "contradicted"
    assert Analysis.from_dict(json.loads(json_text(found.to_dict()))) == found


@pytest.mark.slow
def test_a_dimension_too_large_is_a_contradiction(meddle: Any) -> None:
    meddle(lambda exact: [replace(one, dimension=one.dimension + (one.id == "k2.f1")) for one in exact])
    found = analyze(open_robot("anthropomorphic"), starts=300)
    assert found.exact is not None
    (said,) = found.exact.disagreements
    assert str(said).startswith("derived k2.f1 ")
    assert "its dimension is at most 4" in str(said)
    assert found.verdict.word == "contradicted"


@pytest.mark.slow
def test_conditions_that_no_configuration_satisfies_are_a_contradiction(meddle: Any) -> None:
    meddle(lambda derived: [pinned_at(one, ("pi/2",)) for one in derived])
    found = analyze(open_robot("planar3r"), starts=200)
    assert found.exact is not None
    (said,) = found.exact.disagreements
    assert "no configuration that satisfies its conditions has its corank" in str(said)
    assert found.verdict.word == "contradicted"


@pytest.mark.slow
def test_what_takes_too_long_is_not_derived_and_leaves_nothing_behind(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(analyze_module, "SECONDS", {"auto": 1e-3, "on": 1e-3})
    texts = [json_text(analyze(open_robot("puma560"), starts=100).to_dict()["exact"]) for _ in range(2)]
    assert texts[0] == texts[1]
    record = json.loads(texts[0])
    assert record["status"] == "not derived"
    assert "0.001 s" in record["reason"]
    assert main.run(["analyze", "puma560", "--starts", "100", "--quiet", "--full"]) == exits.FINE
    assert "Exact conditions: not derived; the derivation takes more than" in capsys.readouterr().out
    assert main.run(["analyze", "puma560", "--starts", "100", "--quiet", "--exact", "on"]) == exits.UNEXPLAINED


@pytest.mark.slow
def test_corank_1_is_derived_where_higher_coranks_take_too_long(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The families of det J = 0 stay those derived, and the others are fitted; the answer says so."""
    too_long = NotDerived(NotDerivedKind.UNDIVIDED, number=2)
    monkeypatch.setattr(analyze_module, "_derive", lambda *arguments, **options: (None, too_long))
    found = analyze(open_robot("puma560"), starts=400)
    assert found.exact is not None
    assert (found.exact.status, found.exact.first_derived) == ("not derived", True)
    wanted = [family.name for family in conditions(open_robot("puma560"), coranks=1).families]
    assert sorted(family.name for family in found.families if family.corank == 1) == sorted(wanted)
    assert all(family.exact is None for family in found.families)
    assert "exact conditions of corank 1 alone were derived, 2 cases were not taken apart" in found.verdict.sentence
    found.save(tmp_path / "found.json")
    again = Analysis.load(tmp_path / "found.json").exact
    assert again is not None
    assert again.first_derived


def test_without_the_engine_auto_says_so_and_on_names_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    found = analyze(open_robot("scara"), starts=100)
    assert found.exact is not None
    assert found.exact.status == "not derived"
    assert "needs the package python-flint" in str(found.exact.reason)
    assert found.verified
    with pytest.raises(MissingExtraError, match=r"s source: pip install \.$"):
        analyze(open_robot("scara"), starts=100, exact="on")


def test_an_arm_that_cannot_be_treated_is_not_derived() -> None:
    screws = [[0, 0, 0.1, 0, 0, 1], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]
    arm = from_screws(screws, order="linear-first", kinds=["helical", "revolute", "revolute"], name="with a thread")
    found = analyze(arm, starts=100)
    assert found.exact is not None
    assert found.exact.status == "not derived"
    assert "helical" in str(found.exact.reason)
    with pytest.raises(RobotError, match="helical"):
        analyze(arm, starts=100, exact="on")


def test_ctrl_c_in_the_derivation_ends_the_analysis(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupting(*arguments: Any, **options: Any) -> Conditions:
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["rankdrop.verbs.conditions"], "conditions", interrupting)
    monkeypatch.setattr(sys.modules["rankdrop.verbs.analyze"], "known_conditions", lambda *arguments, **options: None)
    found = analyze(open_robot("scara"), starts=100)
    assert (found.complete, found.unfinished, found.families) == (False, 1, ())


def test_off_leaves_no_entry_and_another_word_is_refused() -> None:
    assert "exact" not in analyze(open_robot("scara"), starts=100, exact="off").to_dict()
    with pytest.raises(OptionError, match="auto, on, off"):
        analyze(open_robot("scara"), starts=100, exact="yes")


@pytest.mark.slow
def test_the_same_settings_give_the_same_file() -> None:
    first, again = (json_text(analyze(open_robot("stanford"), starts=200).to_dict()) for _ in range(2))
    assert first == again
    assert '"agrees"' in first


@pytest.mark.slow
def test_exact_text_stands_in_place_of_decimals(capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    assert main.run(["analyze", "anthropomorphic", "--starts", "300", "--quiet", "--full"]) == exits.FINE
    printed = capsys.readouterr().out
    assert "exactly a2 c2 + d4 c23 = 0" in printed
    assert "0.8 cos" not in printed
    assert "exactly θ" not in printed  # what the table says is not said again
    assert "a2 = 0.5 m, d4 = 0.4 m" in printed


@pytest.mark.slow
def test_joints_that_start_elsewhere_are_told(capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    monkeypatch.setenv("COLUMNS", "140")
    assert main.run(["analyze", "z1", "--starts", "1500", "--quiet", "--full", "--exact", "on"]) == exits.FINE
    assert "there θ3 = q3 + 2.8" in " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
def test_a_family_on_which_the_rank_drops_twice_over_is_listed() -> None:
    """7R with θ2 = ±π/2, θ4 = v: σ is of first order in one combination of the errors and of second in the other."""
    q = pi / 2
    rows = [(0.0, -q, 0.0), (0.4, 0.0, 0.194), (0.0, -q, 0.0), (0.175, q, 0.0), (0.0, -q, 0.584), (0.0, -q, 0.0),
            (0.0, q, 0.488)]  # fmt: skip
    found = analyze(from_dh([(*row, 0.0) for row in rows], convention="standard", name="offset7r"), starts=500)
    assert found.verified
    first = found.of_corank(1)[0]
    assert [one.number for one in first.pinned] == [2, 4]
    assert sorted(first.pinned[0].values) == [-q, q]
    assert first.soundness.holds


@pytest.mark.slow
def test_fewer_starts_test_derived_conditions_than_make_fitted_ones() -> None:
    robot = open_robot("planar3r")
    asked = {"derived": {}, "fitted": {"exact": "off"}, "as asked": {"starts": 300}}
    starts = {}
    for name, options in asked.items():
        found = analyze(robot, **options)
        starts[name] = found.settings.starts
        assert {one.starts for one in found.coranks} == {starts[name]}
        assert ("derived exactly" in found.verdict.claims) is (name != "fitted")
    assert starts == {"derived": 2_000, "fitted": 10_000, "as asked": 300}
