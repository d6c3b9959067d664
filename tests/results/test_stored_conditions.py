"""The exact conditions that come with the package are those of the catalogue's arms, and what a derivation gives.

One of each structure anew, and compared: `pytest -m slow tests/results/test_stored_conditions.py`; three by default.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from known.arms import STRUCTURES

from rankdrop.cli import exits, main
from rankdrop.codec import json_text
from rankdrop.errors import ResultFileError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.family import equations_of
from rankdrop.families.contradiction import Contradiction, ContradictionKind
from rankdrop.families.record import exact_of
from rankdrop.families.unfinished import Phase, Unfinished, UnfinishedKind
from rankdrop.results import known as shelf
from rankdrop.results.conditions import Conditions
from rankdrop.results.known import candidates
from rankdrop.results.stored_conditions import from_stored, known_conditions, shipped_conditions, to_stored
from rankdrop.robot.model import Joint, Mimic
from rankdrop.robot.open import open_robot, robot_names
from rankdrop.task import BODY, resolve_task
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.conditions import conditions
from rankdrop.version import VERSION

SHIPPED = shelf.conditions_names()
QUICK = ("planar3r", "puma560", "scara")
ANEW = [
    pytest.param(name, marks=() if name in QUICK else pytest.mark.by_hand) for name in STRUCTURES if name in SHIPPED
]


def through_json(found: Conditions) -> Any:
    """What a file gives back."""
    return json.loads(json.dumps(to_stored(found), allow_nan=False))


def printed(found: Conditions) -> list[str]:
    """All that is printed, less the line that tells the time or the source."""
    lines = str(found).splitlines()
    told = [line for line in lines if not line.startswith(("  Time taken: ", "  As shipped with "))]
    assert len(told) == len(lines) - 1
    return told


def same(one: Conditions, other: Conditions) -> None:
    """All outputs of two derivations are the same, letter by letter."""
    assert json_text(one.to_dict()) == json_text(other.to_dict())
    assert printed(one) == printed(other)
    assert one.latex() == other.latex()
    assert one.code("python") == other.code("python")
    assert one.code("c") == other.code("c")


@cache
def derived(name: str) -> Conditions:
    """A derivation, made once."""
    return conditions(open_robot(name), fresh=True)


@pytest.fixture
def stored(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Records of two arms in place of what is shipped."""
    records = {name: through_json(derived(name)) for name in ("scara", "stanford")}
    monkeypatch.setattr(shelf, "conditions_record", records.get)
    return records


@pytest.mark.by_hand_at("ur5e")
@pytest.mark.slow_at("ur5e", "rcrrrr")
@pytest.mark.parametrize("name", ["scara", "stanford", "ur5e", "rcrrrr"])
def test_what_is_read_back_is_what_was_derived(name: str) -> None:
    """With letters, with half angles and slides, with numbers and long polynomials."""
    robot, found = open_robot(name), derived(name)
    again = from_stored(through_json(found), robot, resolve_task(None, robot))
    assert (again.chain.letters, again.chain.written) == (found.chain.letters, found.chain.written)
    same(again, found)
    for mine, other in zip(again.families, found.families, strict=True):
        exact, derived_exact = exact_of(mine), exact_of(other)
        polynomials = [[str(one.polynomial) for one in side.polynomials] for side in (exact, derived_exact)]
        assert polynomials[0] == polynomials[1]
        afresh = replace(exact)  # without what was kept: written again from the polynomials
        assert (afresh.conditions, afresh.latex) == (other.texts, other.latex)
        stated = (*afresh.pins, *afresh.polynomials)
        assert equations_of(stated, afresh.numbers, afresh.shifts) == other.equations
        q = np.random.default_rng(3).uniform(-3, 3, (50, robot.n))
        for a, b in zip(mine.equations, other.equations, strict=True):
            assert np.array_equal(a(q), b(q))


def by_half(joints: tuple[Joint, ...]) -> tuple[Joint, ...]:
    """The same joints, the second one following the first by half its angle."""
    return joints[0], replace(joints[1], mimic=Mimic(joints[0].name, 0.5)), *joints[2:]


def test_only_what_is_complete_is_stored() -> None:
    unfinished = (Unfinished(UnfinishedKind.NOT_RUN, phase=Phase.SPECIAL),)
    with pytest.raises(ResultFileError, match="only a complete derivation"):
        to_stored(replace(derived("scara"), complete=False, left=unfinished))
    contradicted = (Contradiction(ContradictionKind.REGULAR, method="cofactors", wrong=3),)
    with pytest.raises(ResultFileError, match=r"contradicted is not stored.*hold at 3 regular"):
        to_stored(replace(derived("scara"), disagreements=contradicted))
    halves = replace(open_robot("scara"), joints=by_half(open_robot("scara").joints))
    with pytest.raises(ResultFileError, match="in parts of joint angles are not stored"):
        to_stored(replace(derived("scara"), robot=halves))


@pytest.mark.parametrize("key", ["families", "letters", "explained", "settings"])
def test_a_damaged_record_is_refused(key: str) -> None:
    robot = open_robot("scara")
    task = resolve_task(None, robot)
    record = through_json(derived("scara"))
    del record[key]
    with pytest.raises(ResultFileError, match="damaged"):
        from_stored(record, robot, task)
    with pytest.raises(ResultFileError, match="not conditions that can be read"):
        from_stored({**record, "schema": "rankdrop/conditions/99"}, robot, task)


@pytest.mark.slow
@pytest.mark.usefixtures("stored")
def test_the_plain_question_is_answered_from_the_shelf_and_no_other() -> None:
    robot = open_robot("scara")
    assert conditions(robot).anew is not None
    assert conditions(robot, robot.task, seconds=7.0).settings.seconds == 7.0
    assert conditions(robot, seconds=7.0).anew is not None
    others: list[dict[str, Any]] = [
        {"fresh": True}, {"seed": 1}, {"points": 50}, {"coranks": 1}, {"method": "tree"}, {"lengths": "numbers"},
        {"steps": True}, {"task": "position"},
    ]  # fmt: skip
    for options in others:
        assert conditions(robot, **options).anew is None, options


@pytest.mark.by_hand
def test_another_arm_is_derived(stored: dict[str, Any]) -> None:
    robot = open_robot("ur5e")
    stored["ur5e"] = through_json(derived("ur5e"))
    assert "ur5e" in candidates(robot)
    assert known_conditions(robot) is not None
    assert known_conditions(robot, replace(exact_chain(robot).task, frame=BODY)) is None
    screw = robot.joints[3].screw.copy()
    screw[0] += 1e-11  # one fingerprint, but not the same numbers
    bent = (*robot.joints[:3], replace(robot.joints[3], screw=screw), *robot.joints[4:])
    turned = robot.joints[2].frame.copy()
    turned[:3, :2] *= -1
    frames = (*robot.joints[:2], replace(robot.joints[2], frame=turned), *robot.joints[3:])
    for other in (replace(robot, joints=bent), replace(robot, joints=frames), replace(robot, lengths=(("b", 0.425),))):
        assert "ur5e" in candidates(other)
        assert known_conditions(other) is None


@pytest.mark.usefixtures("stored")
def test_other_names_are_kept() -> None:
    robot = open_robot("scara")
    joints = tuple(replace(joint, name=f"axis_{i}") for i, joint in enumerate(robot.joints))
    found = conditions(replace(robot, name="mine", joints=joints))
    assert found.anew is not None
    record = found.to_dict()
    assert record["robot"]["name"] == "mine"
    assert record["families"][0]["pinned"][0]["joint"] == "axis_1"


@pytest.mark.usefixtures("stored")
def test_a_condition_is_tested_against_sets_derived_anew() -> None:
    found = conditions(open_robot("scara"))
    assert found.anew is not None
    assert found.test("sin(q2) = 0").verdict == "exact"
    assert found.test("q2 = 0").verdict != "exact"


@pytest.mark.slow
def test_analyze_says_the_same_with_and_without_the_shelf(stored: dict[str, Any]) -> None:
    robot = open_robot("stanford")
    asked: list[str] = []
    records = [json_text(analyze(robot, starts=300, fresh=fresh).to_dict()) for fresh in (False, True)]
    assert records[0] == records[1]
    stored["stanford"]["families"][0]["conditions"][0] = "from the shelf"
    found = analyze(robot, starts=300).families[0].exact
    assert found is not None
    asked += found.conditions
    assert "from the shelf" in asked


def test_what_other_code_made_is_derived_anew(stored: dict[str, Any]) -> None:
    """A release alone makes nothing stale, a change of what is answered does; the version told is of who ships."""
    robot = open_robot("scara")
    stored["scara"]["settings"]["version"] = "0.0.1"
    found = known_conditions(robot)
    assert found is not None
    assert found.to_dict()["settings"]["version"] == VERSION
    stored["scara"]["answers"] += 1
    assert known_conditions(robot) is None
    assert conditions(robot).anew is None
    del stored["scara"]["answers"]
    assert known_conditions(robot) is None


@pytest.mark.usefixtures("stored")
def test_the_command_says_where_it_has_them_from(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["conditions", "scara", "--quiet"]) == exits.FINE
    shown = " ".join(capsys.readouterr().out.split())
    assert f"As shipped with rankdrop {VERSION}; --fresh derives it anew." in shown
    assert main.run(["conditions", "scara", "--quiet", "--fresh"]) == exits.FINE
    shown = " ".join(capsys.readouterr().out.split())
    assert "Time taken:" in shown
    assert "As shipped" not in shown


def test_what_is_shipped_is_of_the_catalogue() -> None:
    assert len(SHIPPED) > 0.9 * len(robot_names())
    assert set(SHIPPED) <= set(robot_names())


@pytest.mark.spread(99)
@pytest.mark.slow
@pytest.mark.shipped
@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_file_is_of_this_version_and_arm_and_verified(name: str) -> None:
    found = known_conditions(open_robot(name))
    assert found is not None, "stale: run tools/make_known.py"
    assert found.verified
    assert found.lowest == 0


@pytest.mark.by_hand
@pytest.mark.slow_at("puma560")
@pytest.mark.shipped
@pytest.mark.parametrize("name", ANEW)
def test_derived_anew_it_is_the_same(name: str) -> None:
    same(shipped_conditions(name), conditions(open_robot(name), fresh=True, special=True))


@pytest.mark.slow
@pytest.mark.shipped
def test_an_arm_is_answered_with_its_families_and_ranks_before_how_sure_that_is() -> None:
    for name in SHIPPED[::4]:
        known = shipped_conditions(name)
        answer, (first, *_) = known.answer, known.sections()
        sure = known.verdict.sentence
        assert (first.title, *first.lines) == ((answer, sure) if known.verdict.holds else (sure, answer))
        if not known.families:
            assert answer == f"{name}: no family of singularities was found."
            continue
        ranks = Counter(known.generic_rank - one.corank for one in known.families)
        assert answer.startswith(f"{name} has {len(known.families)} famil")
        assert re.findall(r"\(rank (\d)\)", answer) == [str(rank) for rank in sorted(ranks, reverse=True)]
        for ranked in known.summary.ranks:
            assert ranked.families == ranks[ranked.rank] == sum(ranked.names.values())
        first_named = next(iter(known.summary.ranks[0].names))
        assert first_named in answer
        parts = known.families[0].called.parts
        assert all(part in first_named for part in parts)


@pytest.mark.usefixtures("stored")
def test_a_time_limit_that_is_typed_takes_what_is_shipped(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["conditions", "scara", "--time-limit", "30", "--quiet"]) == exits.FINE
    assert "As shipped with rankdrop" in capsys.readouterr().out
