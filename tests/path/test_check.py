"""What `check_path` says beside its verdict: places, names, distances, rates, limits, units; and what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from reference import region

import rankdrop
from rankdrop.codec import json_text
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.local.block import singular_values
from rankdrop.path.check.check import check_path
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.text.paths import free_words
from rankdrop.units import scale_lengths
from rankdrop.verbs.analyze import analyze

THROUGH = np.array([[0.3, 0.4, 0.1], [0.5, -0.2, 0.3], [0.5, -0.9, 0.3]])  # planar3r, singular at θ2 = 0


def test_it_is_a_public_name() -> None:
    assert rankdrop.check_path is check_path


def test_a_crossing_is_bracketed_named_and_told() -> None:
    found = check_path(open_robot("planar3r"), THROUGH, [0.0, 2.0, 3.0])
    (one,) = found.crossings
    assert (one.verdict, one.name[:5], one.family, one.corank) == ("crossing", "elbow", "k1.f1", 1)
    start, end = one.bracket
    assert start.row == end.row == 1
    assert start.share <= 2 / 3 <= end.share
    assert end.share - start.share < 1e-8
    assert one.closest.place.time == pytest.approx(4 / 3, abs=1e-9)
    np.testing.assert_allclose(one.closest.q, [0.3 + 0.4 / 3, 0.0, 0.1 + 0.4 / 3], atol=1e-9)
    assert one.closest.distance == 0.0
    assert one.closest.sigma < 1e-9
    assert one.lost[0].startswith("can only move so that ")
    assert one.evidence == "determinant"
    assert found.to_dict()["crossings"][0]["how"] == "the determinant changes its sign"


def test_a_path_that_lies_in_a_singularity_is_named_where_it_has_the_rank_of_most_of_it() -> None:
    """In the elbow of the UR5 all the time, and in the middle at its wrist as well."""
    rows = np.array([[0.0, -1.0, 0.0, 0.4, -0.8, 0.0], [0.1, -0.8, 0.0, 0.3, 0.8, 0.0]])
    (stretch,) = check_path(open_robot("ur5"), rows).crossings
    assert (stretch.lies, stretch.corank) == (True, 1)
    assert stretch.name.startswith("elbow: ")
    assert abs(stretch.closest.q[4]) > 0.1


@pytest.mark.parametrize("back", [-0.5, 0.5])
def test_a_stretch_in_a_singularity_is_one_whatever_changes_its_sign_on_it(back: float) -> None:
    """To the elbow, along it through the wrist, and off it on either side: the determinant changes its sign, or not."""
    rows = np.array([[0.0, -1.0, 0.5, 0.4, 0.8, 0.0], [0.0, -1.0, 0.0, 0.4, 0.8, 0.0],
                     [0.1, -0.8, 0.0, 0.3, -0.6, 0.0], [0.1, -0.8, back, 0.3, -0.6, 0.0]])  # fmt: skip
    (stretch,) = check_path(open_robot("ur5"), rows).crossings
    assert (stretch.lies, stretch.corank, stretch.name[:7]) == (True, 1, "elbow: ")
    low, high = stretch.bracket
    assert low.row - 1 + low.share == pytest.approx(1.0, abs=1e-6)
    assert high.row - 1 + high.share == pytest.approx(2.0, abs=1e-6)


def test_the_same_path_in_another_task_may_be_free() -> None:
    robot = open_robot("planar3r")
    assert check_path(robot, THROUGH).verdict == "crossing"
    assert check_path(robot, THROUGH, task="planar-position").verdict == "free"  # redundant: a joint to spare


@pytest.mark.by_hand_at("puma560")
@pytest.mark.slow_at("puma560")
@pytest.mark.parametrize("name", ["planar3r", "puma560", "stanford"])
def test_a_minimum_distance_is_proven_kept_or_found_violated(name: str) -> None:
    robot = open_robot(name)
    rng = np.random.default_rng(4)
    while True:
        start = rng.uniform(-1.5, 1.5, robot.n)
        path = np.stack([start, start + rng.normal(size=robot.n) * 0.05])
        free = check_path(robot, path)
        far = min(one.closest.distance for one in free.stretches)
        if free.verdict == "free" and 0.1 < far < 1.0:
            break
    kept = check_path(robot, path, min_distance=0.8 * far)
    assert (kept.verdict, kept.margin, kept.holds) == ("free", "kept", True)
    near = check_path(robot, path, min_distance=1.01 * far)
    assert (near.verdict, near.margin, near.holds) == ("too near", "violated", False)
    assert free.margin is None
    if name != "planar3r":  # one joint decides there, and a few enclosures are enough
        short = check_path(robot, path, min_distance=0.97 * far, evaluations=40)
        assert (short.verdict, short.margin) == ("undecided", "not proven")


@pytest.mark.slow
def test_an_arm_in_millimetres_gives_the_same_answer() -> None:
    robot = open_robot("stanford")
    other = scale_lengths(robot, 3)
    slide = [joint.unit for joint in robot.variables].index("m")
    rng = np.random.default_rng(6)
    q = np.cumsum(rng.normal(size=(40, 6)) * 0.2, axis=0)
    q[:, slide] = 0.4 + 0.1 * np.sin(np.arange(40))
    there = q.copy()
    there[:, slide] *= 1000
    one, two = check_path(robot, q, np.arange(40.0)), check_path(other, there, np.arange(40.0))
    assert one.verdict == two.verdict == "crossing"
    assert [s.name for s in one.crossings] == [s.name for s in two.crossings]
    for a, b in zip(one.crossings, two.crossings, strict=True):
        np.testing.assert_allclose(np.delete(a.closest.q, slide), np.delete(b.closest.q, slide), atol=1e-6)
        assert b.closest.q[slide] == pytest.approx(1000 * a.closest.q[slide], rel=1e-5)
        assert b.rates[slide] == pytest.approx(1000 * a.rates[slide])
    assert min(s.closest.distance for s in one.stretches) == pytest.approx(
        min(s.closest.distance for s in two.stretches), abs=1e-9
    )
    assert all(not len(s.rates) for s in check_path(other, there).stretches)  # without times there are none to turn


@pytest.mark.by_hand
def test_an_arm_without_an_atlas_is_judged_and_its_crossings_are_named() -> None:
    robot = region.coupled(np.random.default_rng(9), "r r r0:1 r1:-1 r r0:1 r r")  # mimic joints
    rng = np.random.default_rng(7)
    q = np.cumsum(rng.normal(size=(30, robot.n)) * 0.3, axis=0)
    found = check_path(robot, q)
    assert found.source == "on the spot"
    assert found.verdict in ("free", "crossing", "touching", "outside limits")  # the walk leaves the joint limits
    ur = open_robot("ur5")
    q = np.linspace([0, -1.2, 1.0, 0.5, -0.4, 0.1], [0.3, -1.0, 1.2, 0.4, 0.5, 0.3], 10)
    known = check_path(ur, q)
    moved = region.moved_base(ur, np.array([[0, -1, 0, 0.3], [1, 0, 0, 0.1], [0, 0, 1, 0.5], [0, 0, 0, 1.0]]))
    made = replace(moved, joints=tuple(
        replace(joint, screw=joint.screw + (1e-3 * (k == 2)) * np.eye(6)[0]) for k, joint in enumerate(moved.joints)
    ))  # fmt: skip
    unknown = check_path(made, q)
    assert (known.source, unknown.source) == ("catalogue", "on the spot")
    assert [one.verdict for one in unknown.crossings] == ["crossing"]
    assert unknown.crossings[0].name
    near = [one.closest.distance for one in unknown.stretches if one.verdict == "free"]
    assert np.isfinite(near).all()


def test_families_of_an_analysis_are_used() -> None:
    robot = open_robot("planar3r")
    found = check_path(robot, THROUGH, analysis=analyze(robot, starts=200))
    assert found.source == "analysis"
    assert found.crossings[0].family == "k1.f1"
    with pytest.raises(OptionError, match="another arm"):
        check_path(open_robot("ur5"), np.zeros((2, 6)), analysis=analyze(robot, starts=200))


def test_one_row_or_an_arm_that_stands_still() -> None:
    robot = open_robot("planar3r")
    for q in ([[0.3, 0.4, 0.1]], [[0.3, 0.4, 0.1]] * 4):
        found = check_path(robot, q)
        assert found.verdict == "free"
        assert found.free_share == 1.0
        assert found.stretches[0].closest.distance == pytest.approx(0.4)
    still = check_path(robot, [[0.3, 0.0, 0.1]] * 3)
    assert still.verdict == "touching"
    assert still.free_share < 1e-9


def test_hints_are_given() -> None:
    robot = open_robot("planar3r")
    assert "look like degrees" in " ".join(check_path(robot, np.array(THROUGH) * 57).notes)
    unused = check_path(robot, THROUGH, [0.0, 1.0, 2.0], velocities=np.zeros((3, 3)))
    assert "velocities are given and not used" in " ".join(unused.notes)


BAD = {
    "shape (2,)": (([0.0, 0.0],), {}),
    "expected q of shape": (([[0.0, 0.0]],), {}),
    "q, row 2, joint 'joint2': the value is not finite": (([[0.0] * 3, [0.0, np.nan, 0.0]],), {}),
    "t: there is one time for each row": ((THROUGH, [0.0, 1.0]), {}),
    "t, row 3: time does not go on": ((THROUGH, [0.0, 1.0, 0.5]), {}),
    "t, row 2: the time is not finite": ((THROUGH, [0.0, np.inf, 2.0]), {}),
    "velocities have the shape of q": ((THROUGH, [0.0, 1.0, 2.0]), {"velocities": [1.0]}),
    "velocities, row 1, joint 'joint3'": (
        (THROUGH, [0.0, 1.0, 2.0]), {"velocities": [[0, 0, np.nan], [0, 0, 0], [0, 0, 0]]}
    ),
    "cubic interpolation needs times and velocities": ((THROUGH,), {"interpolate": "cubic"}),
    "quintic interpolation needs accelerations": (
        (THROUGH, [0.0, 1.0, 2.0]), {"interpolate": "quintic", "velocities": np.zeros((3, 3))}
    ),
    "interpolate: this value is not allowed": ((THROUGH,), {"interpolate": "spline"}),
    "min_distance": ((THROUGH,), {"min_distance": -1.0}),
    "evaluations": ((THROUGH,), {"evaluations": 0}),
}  # fmt: skip


@pytest.mark.parametrize("said", BAD)
def test_bad_input_is_refused_with_its_row(said: str) -> None:
    arguments, options = BAD[said]
    with pytest.raises((ConfigurationError, OptionError)) as error:
        check_path(open_robot("planar3r"), *arguments, **options)
    assert said in str(error.value)


def closed(schema):
    if isinstance(schema, list):
        return [closed(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {key: closed(part) for key, part in schema.items()}
    closes = schema.get("type") == "object" and "properties" in schema
    return inner | {"additionalProperties": False} if closes else inner


@pytest.mark.by_hand
def test_the_record_is_that_of_the_schema_and_all_of_it_is_described() -> None:
    check = Draft202012Validator(closed(load_schema("path")))
    rng = np.random.default_rng(8)
    records = [
        check_path(open_robot("planar3r"), THROUGH, [0.0, 1.0, 2.0], min_distance=0.1),
        check_path(open_robot("planar3r"), THROUGH),
        check_path(open_robot("ur5e"), np.cumsum(rng.normal(size=(30, 6)) * 0.2, axis=0), np.arange(30.0)),
        check_path(open_robot("planar3r"), [[0.3, 0.0, 0.1]] * 3),
        check_path(open_robot("ur5e"), np.cumsum(rng.normal(size=(30, 6)) * 0.2, axis=0), evaluations=5),
    ]
    for found in records:
        record = json.loads(json_text(found.to_dict()))
        check.validate(record)
        for key in set(record) - {"units", "summary", "violations", "overruns"}:  # which older files do not have
            assert not check.is_valid({name: value for name, value in record.items() if name != key}), key
    broken = json.loads(json_text(records[0].to_dict()))
    for path, value in (
        (("verdict",), "fine"), (("crossings", 0, "rows", 0), 0), (("crossings", 0, "corank"), 0),
        (("stretches", 0, "closest", "distance_rad"), -1), (("stretches", 0, "verdict"), "regular"),
        (("min_distance",), "yes"), (("stretches", 0, "slowest"), 0),
    ):  # fmt: skip
        record = json.loads(json.dumps(broken))
        place = record
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value
        assert not check.is_valid(record), path


def test_the_text_says_the_verdict_first() -> None:
    text = str(check_path(open_robot("planar3r"), THROUGH, [0.0, 1.0, 2.0]))
    lines = text.splitlines()
    assert lines[0].startswith("Crosses a singularity once (proven), first elbow")
    assert "joint2 0°" in text


def test_a_path_that_crosses_is_never_free_on_the_whole_of_its_length() -> None:
    found = check_path(open_robot("planar3r"), [[0.3, 0.5, 0.4], [0.3, -0.5, 0.4]])
    assert [one.verdict for one in found.crossings] == ["crossing"]
    assert free_words(found) == "more than 99.9999 %"
    free = check_path(open_robot("planar3r"), [[0.3, 0.5, 0.4], [0.3, 0.6, 0.4]])
    assert (free.verdict, free_words(free)) == ("free", "100 %")


@pytest.mark.slow
def test_a_planned_path_that_halts_a_motoman_is_known_before_it_is_driven() -> None:
    """ros-industrial/motoman 556: the controller halts at singularities that a planner in joint space goes through.

    Twelve rows, as a planner gives them: each of them is regular, and a singularity is crossed between two.
    """
    arm = open_robot("hc10")
    start, end = np.array([0.3, 0.4, -0.5, 0.2, 0.7, 0.1]), np.array([-0.4, 0.1, -0.2, 0.3, -0.55, -0.6])
    q = start + np.linspace(0, 1, 12)[:, None] * (end - start)
    assert (singular_values(arm, q, resolve_task(None, arm))[:, -1] > 1e-4).all()
    found = check_path(arm, q, np.linspace(0, 2, 12))
    assert found.verdict == "crossing"
    (crossed,) = found.crossings
    assert (crossed.bracket[0].row, crossed.family) == (7, "k1.f1")
    assert crossed.closest.sigma < 1e-9
    np.testing.assert_allclose(crossed.closest.q, q[6] + crossed.bracket[0].share * (q[7] - q[6]), atol=1e-9)


def test_a_step_over_the_seam_of_a_turn_is_told() -> None:
    """An encoder that counts from 0° to 360° writes 20° and 340°; the rows say 320° through what lies between."""
    arm = open_robot("planar3r")
    rows = np.radians([[10.0, 40.0, 20.0], [20.0, 40.0, 20.0], [340.0, 40.0, 20.0], [330.0, 40.0, 20.0]])
    noted = " ".join(check_path(arm, rows).notes)
    assert "joint 1 turns by +320° from row 2 to row 3 (20° to 340°)" in noted
    assert "it went −40°" in noted
    back = " ".join(check_path(arm, rows[::-1]).notes)
    assert "joint 1 turns by −320° from row 2 to row 3 (340° to 20°)" in back
    assert "it went +40°" in back
    wound = np.radians([[0.0, 40.0, 20.0], [400.0, 40.0, 20.0]])
    assert not any("as the rows say" in note for note in check_path(arm, wound).notes)
    unwound = np.unwrap(rows, axis=0)
    assert not any("as the rows say" in note for note in check_path(arm, unwound).notes)
