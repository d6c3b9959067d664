"""`analyze` beside the exact derivation: they agree on arms that are known, and a difference is told loudly."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli import exits, main
from rankdrop.errors import MissingExtraError, OptionError, RobotError
from rankdrop.exact.writing.condition import AnglePin
from rankdrop.families.linear import vanishing_on
from rankdrop.families.table import families
from rankdrop.results.analysis import Analysis
from rankdrop.results.codec import json_text
from rankdrop.results.conditions import Conditions
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


@pytest.mark.slow_at("canadarm2", "pa10", "ur5", "puma560", "anthropomorphic")
@pytest.mark.parametrize("name", ARMS)  # the Canadarm2 takes five seconds, the others one
def test_what_is_found_and_what_is_derived_agree(name: str) -> None:
    found = analyze(open_robot(name), starts=STARTS, exact="on")
    exact = found.exact
    assert exact is not None
    assert (exact.status, exact.disagreements) == ("agrees", ())
    assert found.verified
    counts = [sum(family.corank == k + 1 for family in exact.families) for k in range(len(ARMS[name]))]
    assert tuple(counts) == ARMS[name]
    assert all(one.families and not one.parts for one in exact.matches)
    assert {i for one in exact.matches for i in one.families} == {family.id for family in exact.families}
    assert exact.numeric.tested == exact.numeric.agree >= 250 * len(found.coranks[:-1])
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

    return with_change


@pytest.mark.slow
def test_an_exact_family_that_no_row_covers_is_told_and_ends_with_code_3(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(sys.modules["rankdrop.verbs.analyze"], "families", _without_the_wrist)
    path = tmp_path / "arm.json"
    line = ("analyze", "anthropomorphic", "--starts", "300", "--quiet", "--exact", "on", "--json", str(path))
    assert main.run(line) == exits.UNEXPLAINED
    printed = " ".join(capsys.readouterr().out.split())
    assert "The exact derivation and the numeric search DIFFER; at least one of them is wrong" in printed
    assert re.search(r"exact k1\.f3 \(wrist: axes 4 and 6 aligned\): 25\d of 257 of its points lie on no", printed)
    kept = Analysis.load(path)
    assert kept.exact is not None
    assert kept.exact.status == "differs"
    assert not kept.verified


def _without_the_wrist(cloud: Any, **options: Any) -> Any:
    found = families(cloud, **options)
    return replace(found, families=tuple(one for one in found.families if not one.name.startswith("wrist")))


def test_a_row_on_no_exact_family_is_told(meddle: Any, capsys: pytest.CaptureFixture[str]) -> None:
    meddle(lambda families: families[1:])
    assert main.run(["analyze", "planar3r", "--starts", "200", "--quiet"]) == exits.UNEXPLAINED
    assert "numeric k1.f1" in capsys.readouterr().out
    found = analyze(open_robot("planar3r"), starts=200)
    assert found.sound_and_complete
    assert not found.verified
    assert found.exact is not None
    assert [one.families for one in found.exact.matches] == [()]


def test_a_row_that_holds_at_regular_places_takes_the_exact_conditions_or_is_told_unsound(
    monkeypatch: pytest.MonkeyPatch, meddle: Any
) -> None:
    """Fitted equations of a Jaco's first row hold at a regular place that few random starts reach."""
    too_wide = vanishing_on([0, 1, 0], (0.0, 3.141592653589793, 1.0), periodic=True)

    def loosely(cloud: Any, **options: Any) -> Any:
        found = families(cloud, **options)
        return replace(found, families=tuple(replace(one, equations=(too_wide,)) for one in found.families))

    monkeypatch.setattr(sys.modules["rankdrop.verbs.analyze"], "families", loosely)
    by_exact = analyze(open_robot("planar3r"), starts=200)
    assert by_exact.verified
    assert [str(one) for one in by_exact.of_corank(1)[0].equations] != [str(too_wide)]
    meddle(lambda exact: [replace(one, pins=(AnglePin(2, ("0",)),)) for one in exact])
    half = analyze(open_robot("planar3r"), starts=200)
    share = half.coranks[0].completeness
    assert 0.2 * share.tested < share.agree < 0.8 * share.tested, "counted on the rows as they are now"
    meddle(lambda exact: [])
    row = analyze(open_robot("planar3r"), starts=200).of_corank(1)[0]
    assert [str(one) for one in row.equations] == [str(too_wide)]
    assert not row.soundness.holds


@pytest.mark.slow
def test_what_takes_too_long_is_not_derived_and_leaves_nothing_behind(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(analyze_module, "SECONDS", {"auto": 1e-3, "on": 1e-3})
    texts = [json_text(analyze(open_robot("puma560"), starts=100).to_dict()["exact"]) for _ in range(2)]
    assert texts[0] == texts[1]
    record = json.loads(texts[0])
    assert (record["status"], record["families"], record["matches"]) == ("not derived", [], [])
    assert "0.001 s" in record["reason"]
    assert main.run(["analyze", "puma560", "--starts", "100", "--quiet"]) == exits.FINE
    assert "Exact conditions: not derived; the derivation takes more than" in capsys.readouterr().out
    assert main.run(["analyze", "puma560", "--starts", "100", "--quiet", "--exact", "on"]) == exits.UNEXPLAINED


def test_without_the_engine_auto_says_so_and_on_names_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "flint", None)
    found = analyze(open_robot("scara"), starts=100)
    assert found.exact is not None
    assert found.exact.status == "not derived"
    assert "needs the package python-flint" in found.exact.reason
    assert found.verified
    with pytest.raises(MissingExtraError, match=r"s source: pip install \.$"):
        analyze(open_robot("scara"), starts=100, exact="on")


def test_an_arm_that_cannot_be_treated_is_not_derived() -> None:
    screws = [[0, 0, 0.1, 0, 0, 1], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]
    arm = from_screws(screws, order="linear-first", kinds=["helical", "revolute", "revolute"], name="with a thread")
    found = analyze(arm, starts=100)
    assert found.exact is not None
    assert found.exact.status == "not derived"
    assert "helical" in found.exact.reason
    with pytest.raises(RobotError, match="helical"):
        analyze(arm, starts=100, exact="on")


def test_ctrl_c_in_the_derivation_leaves_it_out_and_keeps_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupting(*arguments: Any, **options: Any) -> Conditions:
        raise KeyboardInterrupt

    monkeypatch.setattr(sys.modules["rankdrop.verbs.conditions"], "conditions", interrupting)
    found = analyze(open_robot("scara"), starts=100)
    assert (found.complete, len(found.families)) == (True, 1)
    assert found.exact is not None
    assert (found.exact.status, found.exact.reason) == ("not derived", "interrupted")


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
    assert main.run(["analyze", "anthropomorphic", "--starts", "300", "--quiet"]) == exits.FINE
    printed = capsys.readouterr().out
    assert "exactly a2 c2 + d4 c23 = 0" in printed
    assert "0.8 cos" not in printed
    assert "exactly θ" not in printed  # what the table says is not said again
    assert "a2 = 0.5 m, d4 = 0.4 m" in printed


@pytest.mark.slow
def test_joints_that_start_elsewhere_are_told(capsys: pytest.CaptureFixture[str], monkeypatch: Any) -> None:
    monkeypatch.setenv("COLUMNS", "140")
    assert main.run(["analyze", "z1", "--starts", "1500", "--quiet", "--exact", "on"]) == exits.FINE
    assert "there θ3 = q3 + 2.8" in " ".join(capsys.readouterr().out.split())
