"""Saved analyses are held against the schema, the arm and themselves: a file that was changed is refused, or harmless.

What passes has to work: its residual holds, and it goes to data, to words and to a page of a notebook.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text
from rankdrop.errors import ResultFileError
from rankdrop.families.record import Family
from rankdrop.formula.equation import Equation, Term
from rankdrop.results import validate
from rankdrop.results.analysis import Analysis, family_from_dict
from rankdrop.results.known import known_names, shipped
from rankdrop.robot.open import open_robot
from rankdrop.schema import check_record, load_schema
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze

JUNK = (None, True, -1, 0, 9, 2.5, 1e300, -1e-300, 10**400, "", "x", "\x1b[2J", [], {}, [0], [[]], {"a": 1}, [None] * 3)
Place = tuple[Any, ...]


@cache
def record(name: str) -> str:
    """The text of an analysis with everything that one can hold: exact conditions, shares, limits."""
    found = analyze(open_robot(name), starts=100, exact="on", within=0.1, limits=name == "scara")
    assert found.exact is not None
    assert found.near is not None
    return json_text(found.to_dict())


def places(value: Any, at: Place = ()) -> Iterator[Place]:
    yield at
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in items:
        yield from places(one, (*at, key))


def inside(value: Any, at: Place) -> Any:
    for key in at:
        value = value[key]
    return value


def mutate(whole: Any, dice: random.Random) -> str:
    """Change one element: taken out, doubled, replaced by junk, moved by a little or by much, exchanged."""
    at = dice.choice([one for one in places(whole) if one])
    holder, key = inside(whole, at[:-1]), at[-1]
    old = holder[key]
    what = dice.choice(("out", "junk", "junk", "nudge", "nudge", "swap", "twice"))
    if what == "out":
        del holder[key]
    elif what == "nudge" and isinstance(old, int | float) and not isinstance(old, bool):
        holder[key] = dice.choice((old + 1, old - 1, -old, 2 * old, old + 1e-3, old * 1e6, old / 2, 3))
    elif what == "swap" and isinstance(old, list) and len(old) > 1:
        old[0], old[-1] = old[-1], old[0]
    elif what == "twice" and isinstance(holder, list):
        holder.insert(key, copy.deepcopy(old))
    else:
        holder[key] = copy.deepcopy(dice.choice(JUNK))
    return f"{what} at {at}, was {str(old)[:60]}"


def judged(text: str, folder: Path, what: str) -> bool:
    """Whether a file is refused, with the path of an element; else it has to work."""
    path = folder / "a.json"
    path.write_text(text)
    try:
        found = Analysis.load(path)
    except ResultFileError as error:
        line = str(error)
        assert str(path) in line, what
        assert ("$" in line or "this is not an analysis" in line), f"{what}: {line}"
        assert line.isprintable(), what
        return True
    assert found.residual().holds(found.settings.tolerances), what
    assert found.verdict.sentence, what
    assert found._repr_html_(), what
    json.loads(json_text(found.to_dict()))
    return False


def refused_of(name: str, count: int, seed: int, folder: Path) -> int:
    dice, text = random.Random(seed), record(name)
    refused = 0
    for number in range(count):
        whole = json.loads(text)
        what = mutate(whole, dice)
        refused += judged(json.dumps(whole), folder, f"{name}, {seed}, {number}: {what}")
    return refused


@pytest.mark.slow
def test_a_changed_file_is_refused_or_harmless(tmp_path: Path) -> None:
    assert not judged(record("scara"), tmp_path, "as written")
    assert refused_of("scara", 150, 0, tmp_path) >= 75


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ["scara", "stanford", "anthropomorphic", "planar3r"])
def test_thousands_of_changed_files_are_refused_or_harmless(name: str, tmp_path: Path) -> None:
    assert refused_of(name, 500, 1, tmp_path) >= 250


def set_to(value: Any) -> Callable[[Any], Any]:
    return lambda _: value


FIRST, ROBOT = r"\$.families\[0\]", r"\$.robot."
LIES: dict[str, tuple[Place, Callable[[Any], Any], str]] = {
    "no rows": (("robot", "rows"), set_to([]), ROBOT + r"rows: .*Expected array of length >= 1; got a list of 0"),
    "corank 9": (("families", 0, "corank"), set_to(9), FIRST + r".corank: .*Expected int <= 6; got 9"),
    "another corank": (("families", 0, "corank"), lambda k: k + 1, FIRST),
    "a smaller generic rank": (("robot", "generic_rank"), lambda r: r - 1, ROBOT + r"generic_rank: .*got 3; .* 4"),
    "a home pose that is no rotation": (("robot", "home", 0, 0), set_to(0.5), ROBOT + r"home: .*rigid transform"),
    "a frame that is no rotation": (("robot", "chain", 1, "frame", 0, 0), set_to(0.5), ROBOT + r"chain\[1\].frame"),
    "a longer axis": (("robot", "chain", 0, "screw", 5), set_to(2.0), ROBOT + r"chain\[0\].screw: .*length than 1"),
    "a huge limit": (("robot", "chain", 0, "upper"), set_to(1e200), ROBOT + r"chain\[0\].upper: .*too large"),
    "a regular witness": (("families", 0, "witness", 1), set_to(0.7), FIRST + r".witness: .*equations; got"),
    "other lost directions": (("families", 0, "lost_directions", 0), set_to([0] * 5 + [1]), r"lost_directions"),
    "a value that is not pinned": (("families", 0, "pinned", 0, "values"), lambda v: [*v, 0.3], r"pinned\[0\].values"),
    "more dimensions": (("families", 0, "dimension"), lambda d: d + 1, FIRST + r".dimension: .*another dimension"),
    "more found than tested": (("families", 0, "soundness", "singular"), set_to(10**6), FIRST + r": .*more points"),
    "another joint": (("families", 0, "pinned", 0, "joint"), set_to("elbow"), r"pinned\[0\].joint: .*another name"),
    "a loose tolerance": (("settings", "tolerances", "singular"), set_to(10.0), r"\$.settings.tolerances.singular: "),
    "another task": (("robot", "task"), set_to("pose"), ROBOT + r"rows: "),
    "a link that is not there": (("robot", "frame", "axes"), set_to(40), ROBOT + r"frame.axes: .*no such link"),
    "a scale of kilometres": (("settings", "length_scale"), set_to(1e5), ROBOT + r"task: .*length scale"),
    "complete, and not": (("unfinished",), set_to(2), r"\$.unfinished: "),
    "near another family": (("near", "families", 0, "id"), set_to("k6.f9"), r"\$.near.families: "),
    "a relation of no axes": (
        ("families", 0, "called"), set_to({"relations": [{"geometry": "in one plane"}]}),
        FIRST + r": .*\"in one plane\" lacks its joints",
    ),
    "a relation without its centre": (
        ("families", 0, "called"), set_to({"relations": [{"geometry": "centre on an axis", "joints": [[1]]}]}),
        FIRST + r": .*\"centre on an axis\" lacks its joints, centre",
    ),
    "a name of a joint too many": (
        ("families", 0, "called"), set_to({"relations": [{"geometry": "parallel", "joints": [[1, 9]]}]}),
        FIRST + r".called: .*joint that the arm does not have; got 9; allowed: 1 … 4",
    ),
    "a verdict of its own": (("robot", "n"), set_to(7), ROBOT + r"n: .*got 7; allowed: 4"),
}  # fmt: skip


@pytest.mark.parametrize("lie", LIES)
def test_what_contradicts_the_arm_is_refused_with_its_path(lie: str, tmp_path: Path) -> None:
    at, change, words = LIES[lie]
    whole = json.loads(record("scara"))
    inside(whole, at[:-1])[at[-1]] = change(inside(whole, at))
    path = tmp_path / "a.json"
    path.write_text(json.dumps(whole))
    with pytest.raises(ResultFileError, match=words) as caught:
        Analysis.load(path)
    assert str(caught.value).startswith(f"{path}, $")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 200_000, "nested too deeply"),
        ('{"a":' * 200_000, "nested too deeply"),
        ("9" * 5000, "cannot be read as JSON"),
        ('{"schema": NaN}', "cannot be read as JSON"),
        ("[1e999]", "cannot be read as JSON; got Number out of range"),
        ('{"schema": "rankdrop/analysis/1"}', r"\$: .*missing required field robot"),
        ("\x00", "not a text file"),
    ],
)
def test_what_is_no_analysis_is_refused_in_one_line(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(ResultFileError, match=words) as caught:
        Analysis.load(path)
    assert len(str(caught.value)) < 500


def test_a_command_says_so_and_ends_with_2(tmp_path: Path, run: Any) -> None:
    whole = json.loads(record("scara"))
    whole["families"][0]["witness"][1] = 0.7
    path = tmp_path / "a.json"
    path.write_text(json.dumps(whole))
    for line in (("report", str(path), "--out", str(tmp_path / "a.html")),
                 ("explain", "scara", "--q", "0,0,0,0", "--analysis", str(path)),
                 ("nearest", "scara", "--q", "0,0,0,0", "--analysis", str(path))):  # fmt: skip
        ended = run(*line)
        assert ended.code == 2
        assert "$.families[0].witness" in ended.err
    path.write_text("[" * 200_000)
    assert run("report", str(path)).code == 2


def test_the_check_is_what_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = json.loads(record("scara"))
    whole["robot"]["generic_rank"] -= 1
    assert Analysis.from_dict(whole, believe=True).generic_rank == 3
    monkeypatch.setattr(validate, "generic_rank", lambda *_: 3)
    with pytest.raises(ResultFileError, match=r"\$.coranks\[0\]"):
        Analysis.from_dict(whole)


@pytest.mark.slow
def test_what_is_shipped_and_taken_as_it_is_stands_the_check() -> None:
    for name in known_names()[::10]:
        found = shipped(name)
        assert Analysis.from_dict(json.loads(json_text(found.to_dict()))) == found, name


@pytest.mark.by_hand
def test_all_that_is_shipped_stands_the_check() -> None:
    for name in known_names():
        Analysis.from_dict(json.loads(json_text(shipped(name).to_dict())))


@pytest.mark.slow
def test_interrupted_and_other_arms_stand_the_check() -> None:
    found = analyze(open_robot("fetch8"), starts=60)
    assert Analysis.from_dict(json.loads(json_text(found.to_dict()))) == found
    searched = tuple(replace(family, exact=None) for family in found.of_corank(1))
    part = replace(found, coranks=found.coranks[:1], families=searched, exact=None)
    part = replace(part, complete=False, unfinished=2)
    assert not Analysis.from_dict(json.loads(json_text(part.to_dict()))).complete


def refusal(record: Any) -> ResultFileError | None:
    try:
        check_record("analysis", record)
    except ResultFileError as error:
        return error
    return None


@pytest.mark.slow
def test_the_decoder_refuses_what_the_schema_refuses() -> None:
    """The same verdict as a validator of JSON Schema on mutated data.

    Whole numbers written with a point, and those beyond every double, are refused besides.
    """
    schema, dice = load_schema("analysis"), random.Random(3)
    check = Draft202012Validator(schema)
    refused = 0
    for _ in range(60):
        whole = json.loads(record("scara"))
        what = mutate(whole, dice)
        error = refusal(whole)
        if error is None:
            assert check.is_valid(whole), what
            continue
        besides = "got float" in error.what or "range" in error.what or "int" in error.what
        assert besides or not check.is_valid(whole), f"{what}: {error}"
        assert str(error.where).startswith("$"), f"{what}: {error}"
        refused += 1
    assert refused > 15

ELBOW = (0, 2, 0, 0)  # sin θ2 = 0 of a SCARA, whose other joints are free; harmonics in halves


def planted_family(*equations: Equation, **changes: Any) -> Family:
    """The elbow of a SCARA with other equations."""
    return replace(shipped("scara").families[0], equations=equations, **changes)


def of_harmonics(*harmonics: int, powers: tuple[int, ...] | None = None) -> Equation:
    return Equation((Term(1.0, "sin", harmonics, powers or (0,) * len(harmonics)),))


def test_terms_of_a_family_that_fit_its_arm_are_taken() -> None:
    for equation in (of_harmonics(*ELBOW), of_harmonics(0, 64, 0, 0)):
        validate._check_equations(planted_family(equation), 4, "here")


@pytest.mark.parametrize(
    ("equation", "words"),
    [
        (of_harmonics(0, 2, 0, 0, 0), r"terms\[0\]: .*another number of joints; got 5"),
        (of_harmonics(0, 65, 0, 0), r"terms\[0\]: .*a power or a harmonic is too high; got 65"),
        (of_harmonics(*ELBOW, powers=(0, -65, 0, 0)), r"terms\[0\]: .*a power or a harmonic is too high; got 65"),
        (of_harmonics(2, 2, 0, 0), r"terms\[0\]: .*the equation binds a free joint; got \[1, 2\]"),
        (of_harmonics(*ELBOW, powers=(0, 0, 1, 0)), r"terms\[0\]: .*the equation binds a free joint; got \[2, 3\]"),
    ],
)
def test_terms_of_a_family_that_do_not_fit_its_arm_are_refused(equation: Equation, words: str) -> None:
    with pytest.raises(ResultFileError, match=words):
        validate._check_equations(planted_family(equation), 4, "here")
    with pytest.raises(ResultFileError, match=words.replace("[0", "[1")):
        validate._check_equations(planted_family(of_harmonics(*ELBOW), equation), 4, "here")


def test_equations_that_leave_another_dimension_are_refused() -> None:
    twice = of_harmonics(*ELBOW), of_harmonics(0, 4, 0, 0)
    validate._check_equations(planted_family(*twice), 4, "here")  # the same set twice
    for dimension in (1, 4):
        with pytest.raises(ResultFileError, match="the equations leave another dimension"):
            validate._check_equations(planted_family(*twice, dimension=dimension), 4, "here")
    with pytest.raises(ResultFileError, match="a family has equations exactly where it is named"):
        validate._check_equations(planted_family(), 4, "here")


def test_terms_and_texts_of_a_file_say_the_same() -> None:
    whole = json.loads(record("scara"))["families"][0]
    arm = open_robot("scara")
    task = resolve_task(None, arm)
    assert family_from_dict(copy.deepcopy(whole), arm, task).name == whole["name"]
    whole["terms"][0][0]["kind"] = "cos"
    with pytest.raises(ResultFileError, match="equations and terms of a family disagree"):
        family_from_dict(whole, arm, task)
