"""The page as text: it stands alone, holds everything, and nothing in a robot's name can break it."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

from rankdrop.distance.share import NearShare, SlowShare
from rankdrop.families.record import Check
from rankdrop.kinematics import jacobian, link_poses
from rankdrop.local import skeleton
from rankdrop.report.content import content, page_data, standing
from rankdrop.report.page import page
from rankdrop.results.known import shipped
from rankdrop.robot.dh import from_dh
from rankdrop.text.lost import lost_sentences
from rankdrop.verbs.analyze import analyze
from report.pages import shown, text_of

from .lost import arrows

LARGEST = 15_000_000


@pytest.mark.by_hand_at("stanford")
@pytest.mark.slow_at("stanford")
@pytest.mark.parametrize("name", ["scara", "planar2r", "stanford"])
def test_the_page_asks_for_nothing_from_outside(name: str) -> None:
    text = text_of(name)
    assert not re.search(r"""(?:src|href|action|poster)\s*=\s*["'](?!#|data:)""", text)
    assert not re.search(r"url\((?!\s*['\"]?data:)|@import|\bfetch\(|XMLHttpRequest|WebSocket|importScripts", text)
    assert "default-src 'none'" in text
    assert len(text.encode()) < LARGEST


@pytest.mark.slow_at("stanford")
@pytest.mark.parametrize("name", ["scara", "stanford"])
def test_the_page_names_every_family_with_its_joints_and_losses(name: str) -> None:
    text = text_of(name)
    for family in shown(name).analysis.families:
        assert f'data-go="{family.id}"' in text
        assert family.name in text
        assert all(words in text for words in lost_sentences(family.lost_freedoms))


@pytest.mark.slow
def test_the_page_says_how_it_was_verified() -> None:
    text, analysis = text_of("stanford"), shipped("stanford")
    solved = sum(row.soundness.tested for row in analysis.families)
    for part in (f"{solved:,} of {solved:,} points solved", "seed 0", analysis.settings.version, "1e-09", "not proofs"):
        assert part in text


def test_the_head_has_the_share_of_slow_configurations_or_says_what_is_missing() -> None:
    found = shown("scara")
    assert "state `velocity`" in page(replace(found, slow=None)).split("<nav")[0]
    share = NearShare("", 300, 1000, bound=False)
    asked = replace(found.analysis, slow=SlowShare(0.25, share, 0))
    head = page(replace(found, analysis=asked, slow=share)).split("<nav")[0]
    assert "below 25 mm/s or 5°/s in some direction: 30 % of configurations inside limits (95 %: 27.2 … 32.9 %" in head
    assert "slower than 250 mm/s in its worst direction (95 %: 27.2 … 32.9 %): 1,000 random" in head


def test_what_is_not_verified_is_said() -> None:
    found = shown("scara")
    wrong = replace(found.analysis.families[0], soundness=Check(100, 99), explained=Check(10, 9))
    text = page(replace(found, analysis=replace(found.analysis, families=(wrong,)))).split("<script")[0]
    assert text.count("A test failed: k1.f1 also holds at 1 of 100 solutions") == 2
    assert "erified" not in text
    assert "99 %" in text


def test_an_interrupted_analysis_is_told() -> None:
    found = shown("scara")
    text = page(replace(found, analysis=replace(found.analysis, complete=False, unfinished=2)))
    assert "corank 2 is unfinished" in text


def test_a_name_cannot_break_the_page() -> None:
    found = shown("scara")
    evil = '</script><script>alert("x")</script><img src=x onerror=1>'
    robot = replace(found.analysis.robot, name=evil, about=evil, notes=(evil,))
    text = page(replace(found, analysis=replace(found.analysis, robot=robot)))
    assert "<img src=x" not in re.sub(r'<script type="application/json".*?</script>', "", text, flags=re.DOTALL)
    assert text.count("<script") == 2


def test_without_the_exact_conditions_the_section_says_why() -> None:
    text = page(shown("scara", exact=False))
    assert "Not derived" in text


@pytest.mark.slow
def test_conditions_that_the_analysis_holds_are_not_derived_again() -> None:
    from rankdrop.verbs.analyze import analyze

    analysis = analyze(shipped("scara").robot, starts=200)
    shown_of_it = content(analysis)
    assert analysis.exact is not None
    assert shown_of_it.exact is None
    assert "The families are derived exactly." in page(shown_of_it)


@pytest.mark.slow
def test_the_data_is_the_arm() -> None:
    found = shown("stanford")
    record = json.loads(json.dumps(page_data(found), allow_nan=False))
    robot = found.analysis.robot
    assert [one["screw"] for one in record["robot"]["chain"]] == [joint.screw.tolist() for joint in robot.joints]
    witnesses = [list(family.witness) for family in found.analysis.families]
    assert [one["witness"] for one in record["families"]] == witnesses


@pytest.mark.parametrize("name", ["pa10", "scara", "stanford", "ur5"])
def test_an_arrow_is_a_motion_that_no_joint_makes(name: str) -> None:
    """A lost direction, as wrench numbers, does no work on any column of the Jacobian in the base axes at the point."""
    analysis = shipped(name)
    for family in analysis.families:
        point, rows = arrows(analysis, family)
        columns = jacobian(analysis.robot, family.witness)
        assert np.abs(rows @ columns).max() < 1e-9
        assert np.allclose(point, link_poses(analysis.robot, family.witness)[-1, :3, 3])


@pytest.mark.parametrize("name", ["pa10", "scara", "stanford", "ur5", "canadarm2"])
def test_the_skeleton_lies_on_the_axes(name: str) -> None:
    robot = shipped(name).robot
    points, drawn = skeleton(robot)
    for joint, *places in zip(robot.joints, points, drawn, strict=True):
        axis = joint.screw[3:]
        for place in places if np.any(axis) else ():
            assert np.allclose(joint.screw[:3] + np.cross(axis, place), axis * (axis @ joint.screw[:3]), atol=1e-12)


@pytest.mark.slow
def test_what_is_taken_away_is_the_analysis() -> None:
    found = shown("stanford")
    record = page_data(found)["downloads"]
    rows = list(csv.DictReader(StringIO(record["csv"])))
    assert [row["id"] for row in rows] == [family.id for family in found.analysis.families]
    for row, family in zip(rows, found.analysis.families, strict=True):
        assert float(row["witness θ2 [deg]"]) == pytest.approx(np.degrees(family.witness[1]), abs=1e-3)
        assert float(row["witness q3 [m]"]) == pytest.approx(family.witness[2], abs=1e-5)
    assert json.loads(json.dumps(record["record"], allow_nan=False)) == found.analysis.to_dict()


@pytest.mark.slow
def test_families_stand_inside_the_limits_or_say_that_they_do_not() -> None:
    found = shown("ur5")
    for family in found.analysis.families:
        inside = (np.abs(family.witness) <= found.analysis.robot.upper + 1e-9).all()
        assert standing(found.analysis, family) == ("inside" if inside else "none found")
    robot = found.analysis.robot
    tight = replace(robot, joints=tuple(replace(one, lower=-0.5, upper=0.5) for one in robot.joints))
    wrist = found.analysis.families[2]
    turned = (replace(wrist.pinned[0], values=(np.pi,)),)
    wrist_at_pi = replace(wrist, pinned=turned, witness=(0.0, 0.0, 0.0, 0.0, np.pi, 0.0))
    assert standing(replace(found.analysis, robot=tight), wrist_at_pi) == "outside"
    elsewhere = replace(wrist, witness=(9.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert standing(found.analysis, elsewhere) == "none found"
    free = replace(robot, joints=tuple(replace(one, lower=-np.inf, upper=np.inf) for one in robot.joints))
    assert standing(replace(found.analysis, robot=free), wrist) == ""


@pytest.mark.slow
def test_every_way_out_that_is_offered_leads_out() -> None:
    from rankdrop.local import singular_values

    found = shown("ur5")
    rank = found.analysis.generic_rank
    offered = [way for ways in found.ways for way in ways]
    assert len(offered) >= len(found.analysis.families)
    for way in offered:
        assert singular_values(found.analysis.robot, way[2], found.analysis.task)[rank - 1] > 1e-4
        assert (np.abs(way[2]) <= found.analysis.robot.upper + 1e-9).all()


@pytest.mark.slow
def test_pictures_say_what_is_to_be_seen() -> None:
    text = text_of("ur5")
    for tag in re.findall(r"<(?:canvas|svg)[^>]*>", text):
        assert 'role="img"' in tag
        assert len(re.findall(r'aria-label="([^"]+)"', tag)[0]) >= len("The arm")
    found = shown("ur5")
    for family in found.analysis.families:
        lost = lost_sentences(family.lost_freedoms)[0]
        assert f'aria-label="The arm in {family.id}, {found.titles[family.id]}. Lost, an arrow each: {lost}' in text


def test_an_analysis_shows_itself_in_a_notebook() -> None:
    analysis = shipped("stanford")
    found = analysis._repr_html_()
    assert found.count("<table>") == len({family.corank for family in analysis.families})
    assert all(family.name in found for family in analysis.families)
    assert "http" not in found


def test_a_search_shows_itself_in_a_notebook() -> None:
    from rankdrop.families.searching import search

    found = search(shipped("scara").robot, 1, starts=20)
    assert "<td>converged</td><td>20</td>" in found._repr_html_()


def test_an_arm_without_a_family_has_no_empty_section() -> None:
    """Two slides at a right angle reach every point of the plane with the same two singular values."""
    rows = [(0.0, np.pi / 2, 0.0, theta) for theta in (0.0, np.pi / 2)]  # a, alpha, d, theta
    robot = from_dh(rows, convention="standard", kinds="PP", name="table")
    text = page(content(analyze(robot, "vy,vz", starts=50))).split("<script")[0]
    ids = re.findall(r'<section id="(\w+)"', text)
    assert ids == ["see", "tables", "exact", "checks"]
    assert re.findall(r'href="#(\w+)"', text) == ids
    assert "The arm at each witness" not in text
    assert "No family: the rank is 2 at every configuration." in text
    whole = text_of("scara")
    assert set(re.findall(r'href="#(\w+)"', whole)) == {*ids, "slices", "workspace", "lines"}
