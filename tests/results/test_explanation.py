"""Explanations of configurations whose answer is known."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.codec import json_text
from rankdrop.errors import OptionError
from rankdrop.kinematics import jacobian, pose
from rankdrop.local.block import joint_scale, sample, singular_values
from rankdrop.results.explanation import Explanation
from rankdrop.results.known import shipped
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, prismatic, revolute
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.verbs.analyze import analyze
from rankdrop.verbs.explain import explain

ARMS = ("pa10", "ur5", "puma560", "panda", "scara", "stanford", "planar3r", "rcrrrr", "gen3", "fetch8")


def record(found: Explanation) -> dict:  # type: ignore[type-arg]
    return json.loads(json_text(found.to_dict()))


def test_a_long_arm_has_its_rank_and_its_singular_values() -> None:
    """Sets of joints are listed for short arms alone; the arm was refused with them."""
    screws = [revolute([0.0, i % 2, 1.0 - i % 2], [0.1 * i, 0.0, 0.1 * i]) for i in range(33)]
    arm = from_screws(screws, order="linear-first")
    found = explain(arm, np.full(33, 0.3))
    assert (found.verdict, found.rank.rank, found.rank.nullity) == ("regular", 6, 27)
    assert np.allclose(found.rank.sigma, singular_values(arm, np.full(33, 0.3), found.task), atol=1e-12)
    assert found.blame.circuits == ()
    assert any("σ = " in line for section in found.sections(full=True) for line in section.lines)


def test_pa10_at_zero() -> None:
    found = explain(open_robot("pa10"), [0.0] * 7)
    assert (found.verdict, found.rank.rank, found.rank.corank, found.rank.nullity) == ("singular", 3, 3, 4)
    assert found.met[0].family.name.startswith("shoulder, elbow and wrist")
    assert found.met[0].source == "catalogue"
    assert [one.number for one in found.escape.single if one.order is not None] == []
    pair = found.escape.best_pair
    assert pair is not None
    assert pair.restores
    assert found.certified_radius == 0.0


def test_the_quoted_shoulder_of_the_ur5_is_regular() -> None:
    """[0, −135, 45, 90, −90, 0]° is often quoted as a shoulder singularity; the real one is elsewhere."""
    arm, q = open_robot("ur5"), np.radians([0, -135, 45, 90, -90, 0])
    found = explain(arm, q)
    assert (found.verdict, found.rank.corank) == ("regular", 0)
    nearest = found.far.nearest
    assert nearest is not None
    assert found.far.nearest_family is not None
    assert found.far.nearest_family.family.name.startswith("shoulder")
    assert nearest.distance == pytest.approx(0.4303, abs=1e-4)
    assert found.certified_radius is not None
    assert 0.9 * nearest.distance < found.certified_radius <= nearest.distance
    there = explain(arm, nearest.q)
    assert (there.verdict, there.rank.corank) == ("singular", 1)


def test_the_cylindrical_arm_of_gallardo_and_rico() -> None:
    found = record(explain(open_robot("rcrrrr"), [0.0] * 7, length_scale=1.0))
    assert found["circuits"] == [[1, 3, 4, 5], [3, 4, 6, 7], [1, 3, 5, 6, 7], [1, 4, 5, 6, 7]]
    ways = {one["number"]: one["rate"] for one in found["escape"]["single"] if one["order"] == 1}
    assert ways == {4: pytest.approx(2.07134, abs=1e-4), 3: pytest.approx(0.7036, abs=1e-4)}


@pytest.mark.parametrize("offset", [1e-7, 1e-4, 0.01])
def test_near_a_wrist(offset: float) -> None:
    found = explain(open_robot("puma560"), [0.1, 0.5, 0.4, 0.2, offset, 0.6])
    assert (found.verdict, found.rank.corank) == ("near", 0)
    assert found.met[0].family.name.startswith("wrist")
    assert found.far.nearest is not None
    assert found.far.nearest.distance == pytest.approx(offset, rel=1e-9)
    assert found.focus[4] == pytest.approx(0.0, abs=1e-12)
    assert len(found.lost.directions) == 1
    assert found.lost.words[0].startswith("can only move so that ")


@pytest.mark.slow
def test_a_near_miss_is_not_a_singularity() -> None:
    """Gen3's 12 mm offsets: where an arm without them would lose two freedoms σ stays at 4e-5 and above."""
    arm = open_robot("gen3")
    task = resolve_task(None, arm)
    from rankdrop.families.searching import Outcome, search

    cloud = search(arm, 2, task=task, starts=4000)
    missed = cloud.q[(cloud.outcome == Outcome.NEAR_MISS) & (cloud.sigma[:, 4] < 1e-3)]
    assert len(missed)
    found = explain(arm, missed[0])
    assert found.verdict in ("near", "singular")
    assert found.rank.corank < 2
    assert "nearly" in found.reason


def test_an_arm_that_is_always_singular() -> None:
    slides = [prismatic(axis) for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0])]
    turns = [revolute([0, 0, 1], [x, 0, 0]) for x in (0.0, 0.4)]
    arm = from_screws([*slides, *turns], order="linear-first", name="gantry")
    found = explain(arm, [0.1, 0.2, 0.3, 0.1, 0.5, 0.6], "pose")
    assert found.verdict == "always-singular"
    assert found.blame.always
    assert found.rank.generic_rank == 4
    assert len(found.lost.never) == 2
    assert found.certified_radius == 0.0


@pytest.mark.spread(4)
@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_records_are_valid_and_lost_motions_are_lost(name: str) -> None:
    arm = open_robot(name)
    task = resolve_task(None, arm)
    schema = Draft202012Validator(load_schema("explanation"))
    points = [*sample(arm, task, 2, seed=3)]
    known = explain(arm, points[0]).far.nearest
    assert known is not None
    points.append(np.array(known.q))
    for q in points:
        found = explain(arm, q)
        schema.validate(record(found))
        assert not found.disagreements
        if found.rank.corank:
            made = jacobian(arm, q, found.task.frame)
            assert np.abs(found.lost.directions[:, :] @ made).max() < 1e-6
            assert len(found.lost.directions) == len(found.lost.words) == found.rank.corank
            assert found.met
            assert found.met[0].family.corank == found.rank.corank
        else:
            assert found.far.nearest is not None
            radius = found.certified_radius
            assert radius is not None
            assert 0.0 < radius <= found.far.nearest.distance * (1 + 1e-8)
        for full in (False, True):
            sections = found.sections(full=full)
            assert sections[0].title.startswith(arm.name)
            assert all(len(row) == len(section.columns) for section in sections for row in section.rows)
        assert found._repr_html_().count("<table>") > 0


def test_the_last_point_of_each_arm_is_singular() -> None:
    """So that the branch above is not empty."""
    for name in ARMS:
        arm = open_robot(name)
        there = explain(arm, sample(arm, resolve_task(None, arm), 2, seed=3)[0]).far.nearest
        assert there is not None
        assert explain(arm, there.q).verdict == "singular"


def test_an_unknown_arm_is_named_on_the_spot() -> None:
    """PUMA with other lengths is in no atlas."""
    from rankdrop.robot.dh import from_dh

    right = np.pi / 2
    rows = [(0, right, 0), (0.5, 0, 0.1), (0.02, -right, 0), (0, right, 0.45), (0, -right, 0), (0, 0, 0)]
    arm = from_dh([{"a": a, "alpha": alpha, "d": d} for a, alpha, d in rows], convention="standard", name="mine")
    found = explain(arm, [0.3, 0.5, 0.4, 0.2, 0.0, 0.6])
    assert found.met[0].source == "on the spot"
    assert found.met[0].family.name.startswith("wrist")
    assert [one.number for one in found.met[0].family.pinned] == [5]


PARTS = ("far", "met", "relations", "lost", "blame", "escape", "rates", "failures", "ellipsoids", "redundancy",
         "representations", "disagreements", "certified_radius")  # fmt: skip


@pytest.mark.parametrize("q", [[0.1, 0.9, 0.4, 0.25, 0.7, 1.1, 0.2], [0.1, 0.9, 0.4, 0.0005, 0.7, 1.1, 0.2], [0.0] * 7])
def test_parts_are_the_same_in_whatever_order_they_are_asked_for(q: list[float]) -> None:
    arm = open_robot("pa10")
    one, other = explain(arm, q), pickle.loads(pickle.dumps(explain(arm, q)))
    for name in reversed(PARTS):
        assert getattr(other, name) is getattr(other, name)  # made once
    assert json_text(other.to_dict()) == json_text(one.to_dict())
    assert str(other) == str(one)


def test_what_was_not_asked_for_is_not_worked_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The verdict needs neither ways out nor a proof; bad options are told at once all the same."""

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("nobody asked for this")

    monkeypatch.setattr("rankdrop.results.explanation.escape", refused)
    monkeypatch.setattr("rankdrop.results.far.certified_radius", refused)
    found = explain(open_robot("pa10"), [0.1, 0.9, 0.4, 0.25, 0.7, 1.1, 0.2])
    assert found.far.nearest is not None
    assert (found.verdict, round(found.far.nearest.distance, 9)) == ("regular", 0.25)
    with pytest.raises(OptionError, match="step"):
        explain(open_robot("pa10"), [0.0] * 7, step=2.0)
    with pytest.raises(OptionError, match="evaluations"):
        explain(open_robot("pa10"), [0.0] * 7, evaluations=10**9)


def test_a_redundant_arm_is_blamed_for_all_it_takes() -> None:
    """Axes 1 and 3 aligned alone cost a PA-10 nothing: the family needs 5 and 7 aligned as well."""
    arm = open_robot("pa10")
    task = resolve_task(None, arm)
    assert explain(arm, [0.1, 0.0, 0.2, 0.7, 0.3, 0.9, 0.4]).rank.corank == 0
    found = explain(arm, [0.1, 0.0, 0.2, 0.7, 0.3, 0.0, 0.4])
    assert [one.words for one in found.blame.smallest] == ["axes 1, 3 aligned", "axes 5, 7 aligned"]
    whole = explain(arm, [0.0] * 7)
    made = np.zeros((4, 7))
    for row, one in zip(made, whole.blame.smallest, strict=True):
        row[np.array(one.numbers) - 1] = one.coefficients
    assert np.linalg.matrix_rank(made) == whole.rank.nullity == 4
    assert np.abs(jacobian(arm, whole.q, task.frame) @ made.T).max() < 1e-12


def test_a_joint_that_a_whole_turn_brings_inside_its_limits_is_said() -> None:
    """Kinova's interface counts joints from 0° to 360°, their limits from −180° to 180°."""
    arm = open_robot("gen3")
    counted = np.radians([17.72, 66.61, 299.37, 235.97, 292.97, 280.77, 296.12])
    found = explain(arm, counted, evaluations=0)
    assert found.outside_limits == (4, 6)
    assert [number for number, _ in found.same_inside] == [4, 6]
    moved = counted.copy()
    for number, value in found.same_inside:
        assert arm.lower[number - 1] <= value <= arm.upper[number - 1]
        moved[number - 1] = value
    np.testing.assert_allclose(pose(arm, moved), pose(arm, counted), atol=1e-12)
    assert "the same posture inside the limits: joint 4 at −124°, joint 6 at −79.2°" in " ".join(str(found).split())
    alone = explain(arm, np.radians([0, 20, 0, 236, 0, 20, 0]), evaluations=0)
    assert "is outside its limits, −152.4° … 152.4°; −124° is the same angle inside" in " ".join(str(alone).split())
    assert not explain(open_robot("scara"), [0.1, 0.2, 0.3, 0.0], evaluations=0).same_inside  # a slide makes no turns
    partly = str(explain(arm, np.radians([0, 140, 0, 236, 0, 200, 0]), evaluations=0))
    words = " ".join(partly.split())
    assert "the same angle inside the limits: joint 4 at −124°; none of joints 2, 6" in words
    assert "same posture inside" not in words


def test_rounding_outside_a_limit_is_zero_degrees() -> None:
    """Joint 6 of j2s7s300 turns from 65° to 295°: "joint 6 at −3.152e−16° is outside its limits"."""
    found = explain(open_robot("j2s7s300"), [0.1, np.pi, 0.3, 2.0, 0.2, -5.5e-18, 0.4], evaluations=0)
    assert "joint 6 at 0° is outside its limits" in " ".join(str(found).split())


def test_what_stands_beyond_or_at_a_limit_is_said() -> None:
    arm = open_robot("ur5")
    typed = explain(arm, [0, -135, 45, 90, -90, 0])  # degrees, forgotten to say so
    assert typed.outside_limits == (2, 3, 4, 5)
    assert not typed.same_inside
    assert str(typed).startswith("Degrees?\n  angles up to 135 look like degrees and are read as radians")
    panda = open_robot("panda")
    found = explain(panda, [0.0, 0.3, 0.0, panda.upper[3], 0.0, 1.9, 0.7])
    assert (found.outside_limits, found.at_limits) == ((), (4,))
    assert "joint 4 at −3.999° stands at a limit (−176° … −3.999°)" in " ".join(str(found).split())
    there = explain(arm, [0.0, np.radians(-400), 0.0, 0.0, 0.5, 0.0])
    assert "joint 2 at −400° is outside its limits, −360° … 360°" in " ".join(str(there).split())
    slides = open_robot("scara")
    assert "joint 3 at 0.3 m is outside its limits, 0 m … 0.21 m" in str(explain(slides, [0.1, 0.2, 0.3, 0.0]))
    assert record(found)["at_limits"] == [4]
    assert explain(panda, [0.0, 0.3, 0.0, -1.8, 0.0, 1.9, 0.7]).at_limits == ()


def test_how_it_shows_itself() -> None:
    found = explain(open_robot("scara"), [0.3, 0.0, 0.1, 0.2])
    assert repr(found) == "<Explanation of scara: singular, 1 of 4 directions of the tool is lost>"
    assert str(found).startswith("scara is singular: elbow")
    assert "--full" not in str(found) + found._repr_html_()
    assert "<p><b></b>" not in found._repr_html_()


@pytest.mark.parametrize("name", ["puma560", "ur5", "pa10", "panda", "scara", "canadarm2"])
def test_the_best_direction_is_not_beaten_by_random_ones(name: str, rng: np.random.Generator) -> None:
    found = shipped(name)
    arm, task = found.robot, found.task
    scale = joint_scale(arm, task)
    for family in found.families[:4]:
        told = explain(arm, family.witness, task)
        best, r = told.escape.best_direction, told.rank.generic_rank
        deltas = rng.normal(size=(1000, arm.n))
        deltas /= np.linalg.norm(deltas, axis=1, keepdims=True)
        tried = told.q + 0.1 * deltas * scale
        low, high = np.minimum(arm.lower, told.q), np.maximum(arm.upper, told.q)  # from outside the way back is free
        inside = ((tried >= low) & (tried <= high)).all(axis=1)
        assert inside.any()
        assert singular_values(arm, tried[inside], task)[:, r - 1].max() <= 1.03 * best.sigma_after
        reached = singular_values(arm, told.q + np.array(best.delta) * best.step, task)[r - 1]
        assert reached == pytest.approx(best.sigma_after, abs=1e-12)


def test_a_part_far_from_its_condition_gives_way_to_what_the_axes_have_in_common() -> None:
    """A leg with the axes of EVE R3 (hip z, x, y, knee y, ankle y, x): "wrist 45° from above axis 1" at θ2 = 90°."""
    x, y, z, hip, knee, ankle = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0), (0, 0, -0.4), (0, 0, -0.8)
    axes = [(z, hip), (x, hip), (y, hip), (y, knee), (y, ankle), (x, ankle)]
    leg = from_screws([revolute(axis, at) for axis, at in axes], order="linear-first")
    q = [0.3, np.pi / 2, 0.5, 0.7, 1.1, 0.2]
    found = explain(leg, q, analysis=analyze(leg, starts=200, exact="off"), evaluations=0)
    assert [round(np.degrees(special.off)) for special in found.summary.place] == [45]
    assert " is singular: shoulder: axis 1 parallel to 3, 4, 5." in str(found)
