"""`rankdrop cover`: what families explain and what they do not, exit codes, what is written, and errors of one line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli import main
from rankdrop.cover.box_matching import FamilyBoxes
from rankdrop.distance.many_distances import distances
from rankdrop.families.points import members
from rankdrop.families.searching import refine
from rankdrop.local.block import joint_scale
from rankdrop.results.known import known_analysis
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.verbs import cover

UR5 = open_robot("ur5")
TASK = resolve_task(None, UR5)


def without(*ids: str):
    known = known_analysis(UR5, TASK)
    return replace(known, families=tuple(one for one in known.families if one.id not in ids))


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    def once(*argv: object) -> tuple[int, str, str]:
        monkeypatch.setenv("COLUMNS", "120")
        capsys.readouterr()
        code = main.run(["cover", *map(str, argv), "--quiet"])
        return (code, *capsys.readouterr())

    return once


@pytest.mark.slow
def test_known_families_explain_every_box() -> None:
    for name in ("ur5", "puma560"):
        found = cover(open_robot(name), width=0.4)
        assert found.sentence.startswith(f"Every singular configuration of {found.robot.name} is within 0.785")
        assert (found.holds, found.account.spots) == (True, ())
        assert found.account.explained.sum() + found.account.freed == found.covering.tree.leaves
        assert (found.account.explained[:3] > 1000).all()


def test_how_far_a_covering_is_is_read_from_its_file(tmp_path: Path, run) -> None:
    file = tmp_path / "planar.cover"
    assert run("planar3r", "--width", "0.4", "--out", file)[0] == 0
    assert run("--status", file)[:2] == (0, f"finished: 2 boxes in {file}\n")
    code, _, err = run("--status", tmp_path / "none")
    assert code == 2
    assert "there is no job in the folder" in err
    assert run()[0] == 2


@pytest.mark.by_hand
def test_explained_means_that_a_point_of_the_family_is_near() -> None:
    found = cover(UR5, width=0.4, explain=False).covering
    scale, rng = joint_scale(UR5, TASK), np.random.default_rng(3)
    for family in known_analysis(UR5, TASK).families:
        if family.corank > 1 and not family.coupled:
            continue
        explainer = FamilyBoxes(found, UR5, (family,), scale)
        for cells, _ in found.tree.parts():
            by = explainer.families_of(cells[::7])
            q = np.zeros((len(by), 6))
            q[:, 1:5] = found.boxes(cells[::7])[0]
            near = q[by == 0]
            if family.corank > 1:  # walks with all of its conditions at once end far away: by descents from all around
                starts = near[:100, None] + rng.uniform(-1, 1, (len(near[:100]), 60, 6)) * explainer.radius
                ends = refine(UR5, starts.reshape(-1, 6), family.corank)
                gap = ((ends.q.reshape(starts.shape) - near[:100, None] + np.pi) % (2 * np.pi) - np.pi)[..., 1:5]
                far = np.where(ends.outcome.reshape(starts.shape[:2]) == 0, np.linalg.norm(gap, axis=2), np.inf)
                assert (far.min(axis=1) <= 1.1 * explainer.radius).mean() > 0.9
                continue
            # distance from the family by walking, independent of the change of sign
            far = distances([family], UR5, near[:400], TASK).distance[:, 0]
            assert (far <= explainer.radius * (1 + 1e-6)).mean() > 0.999
            other = distances([family], UR5, q[by < 0][:400], TASK).distance[:, 0]
            if family.corank == 1 and not family.coupled:
                assert (other > explainer.radius * (1 - 1e-6)).all()


def test_an_arm_that_is_not_shipped_is_analysed(tmp_path: Path) -> None:
    arm = open_robot("planar3r")
    longer = replace(arm, joints=tuple(replace(j, screw=j.screw * [1.25, 1.25, 1.25, 1, 1, 1]) for j in arm.joints))
    found = cover(longer, width=0.2)
    assert (found.account.source, found.holds) == ("made here", True)


@pytest.mark.by_hand
def test_a_higher_corank_is_explained_by_its_own_families(tmp_path: Path, run) -> None:
    file = tmp_path / "two.json"
    code, text, _ = run("ur5", "--width", 0.4, "--corank", 2, "--json", file)
    assert code == 0
    assert text.count("Every configuration of corank 2 or more of ur5 is within") == 2
    record = json.loads(file.read_text())
    Draft202012Validator(load_schema("cover")).validate(record)
    assert record["settings"]["corank"] == 2
    assert {one["id"][:2] for one in record["explained"]["families"]} == {"k2", "k3"}
    part, gone = without("k2.f1", "k2.f4", "k3.f1"), ("k2.f1", "k2.f4", "k3.f1")
    part.save(tmp_path / "part.json")
    code, text, _ = run("ur5", "--width", 0.4, "--corank", 2, "--analysis", tmp_path / "part.json", "--json", file)
    assert code == 3
    assert "singular, found" in text
    explained = json.loads(file.read_text())["explained"]
    assert {one["id"] for one in explained["families"]} == {"k2.f2", "k2.f3", "k2.f5"}  # those of the file alone
    # the families left out come within 1.53 rad of others: farther than a diagonal of these boxes, 0.79 rad, and
    # nearer than one of boxes twice as wide, which the others therefore explain
    higher = [one for one in part.families if one.corank == 2]
    for family in known_analysis(UR5, TASK).families:
        if family.id in gone:
            far = distances(higher, UR5, members(UR5, TASK, family, 200, 0), TASK).distance.min(axis=1)
            assert far.max() < 1.53
            assert (far.max() > 1.0) == (family.corank == 2)
    assert run("ur5", "--width", 0.8, "--corank", 2, "--analysis", tmp_path / "part.json")[0] == 0
    code, text, _ = run("planar3r", "--corank", 2)
    assert code == 0
    assert text.strip().startswith("There is no configuration of corank 2 or more of planar3r (proven).")
    assert "is in one" not in text
    assert "proven to hold one" not in text


@pytest.mark.slow
def test_exit_codes_and_what_is_written(tmp_path: Path, run) -> None:
    out, file = tmp_path / "arm.cover", tmp_path / "arm.json"
    code, text, _ = run("almarkhi4", "--width", "10deg", "--out", out, "--json", file)
    assert code == 0
    assert text.strip().splitlines()[0].strip().startswith("Every singular configuration of ")
    record = json.loads(file.read_text())
    Draft202012Validator(load_schema("cover")).validate(record)
    assert record["sha256"] in text
    first = out.read_bytes()
    code, text, _ = run("almarkhi4", "--width", "10deg", "--out", out, "--json", "-")
    assert (code, out.read_bytes()) == (0, first)
    assert json.loads(text) == record
    without("k1.f3", "k2.f4", "k2.f5", "k3.f1").save(tmp_path / "part.json")
    code, text, _ = run("ur5", "--width", 0.8, "--analysis", tmp_path / "part.json", "--json", file)
    assert code == 3
    assert "Places to look at" in text
    Draft202012Validator(load_schema("cover")).validate(json.loads(file.read_text()))
    code, text, _ = run("almarkhi4", "--budget", 3000, "--json", file)
    assert code == 3
    assert text.strip().startswith("Not complete (budget too small: about ")
    assert json.loads(file.read_text())["needed"] > 9000
    Draft202012Validator(load_schema("cover")).validate(json.loads(file.read_text()))
    code, text, _ = run("ur5", "--width", 0.8, "--no-explain")
    assert (code, "Every singular configuration" in text) == (0, True)


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("ur5", "--corank", 7), "no such corank"),
        (("ur5", "--width", "0.001"), "no such width"),
        (("ur5", "--width", "wide"), "--width"),
        (("fetch8",), "too many joints"),
        (("ur5", "--out=-"), "a covering is not printed"),
        (("ur5", "--out", "/no/such/folder/x"), "no such folder"),
        (("scara", "--task", "vx,vy"), "some rows of translation"),
    ],
)
def test_bad_input_is_one_line(run, argv, words) -> None:
    code, out, err = run(*argv)
    assert (code, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    assert words in err
