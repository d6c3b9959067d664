"""Forged certificates: every entry of every kind is changed, hashes and all; none passes for the original.

What a forger can do: change any entry, hash the file and the arm anew, write another covering and name its hash. A
forgery is refused, or it holds and its printed claim differs from that of the original. Where to look from (`view`) and
how to cut (`proof`) claim nothing; the version and the units are for people.
"""

from __future__ import annotations

import contextlib
import copy
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reference import cuspidal, region
from reference.coverings import covering

from rankdrop.cover import ModelTolerance, asked_about, verify, write_certificate
from rankdrop.cover.certificates import Verified, ball_certificate, covering_certificate, existence_certificate
from rankdrop.cover.covering import Covering, write_covering
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.path.check.certificate import path_certificate
from rankdrop.path.check.check import check_path
from rankdrop.proof.boxes import BitTree, digest, load, plan_from_entries
from rankdrop.proof.record import Refused, _certificate, fingerprint, with_hash
from rankdrop.proof.record import _link as link_of
from rankdrop.robot.model import Joint, JointKind, Robot
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, resolve_task

Record = dict[str, Any]
NO_CLAIM = {"schema", "version", "units", "view", "proof", "sha256"}
WORK = 400  # enclosures of one check
WORDS = ("revolute", "prismatic", "helical", "free", "open", "crossing", "met", "path", "ball", "covering", "existence",
         "posture change", "sign proof", "axes 2, 3 parallel", "three parallel", "",
         "another", "planar", "0" * 64)  # fmt: skip


def slide_arm() -> Robot:
    """A turn, a slide and a turn in a plane."""
    joints = (
        Joint("a", JointKind.REVOLUTE, np.array([0, 0, 0, 0, 0, 1.0]), lower=-2.0, upper=2.0),
        Joint("b", JointKind.PRISMATIC, np.array([1.0, 0, 0, 0, 0, 0]), lower=0.1, upper=0.9),
        Joint("c", JointKind.REVOLUTE, np.array([0, -0.5, 0, 0, 0, 1.0]), lower=-1.0, upper=1.5),
    )
    home = np.eye(4)
    home[0, 3] = 0.8
    return Robot("slider", joints, home, task="planar")


def covering_of(folder: Path, name: str, robot: Robot, width: float, **how: Any) -> Record:
    found = covering(robot, width, **how)
    write_covering(folder / name, found)
    return covering_certificate(robot, found.plan, digest(found.plan, found.tree), name, resolve_task(None, robot))


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Record]]:
    """Small certificates of every kind."""
    folder = tmp_path_factory.mktemp("forged")
    planar, two, spatial, slider = open_robot("planar3r"), open_robot("planar2r"), open_robot("almarkhi4"), slide_arm()
    rows = [[0.1, 0.9], [0.3, 0.5], [0.4, 0.7]]
    source = folder / "rows.csv"
    source.write_text("\n".join(",".join(map(str, row)) for row in rows))
    point = resolve_task("position", spatial, frame=Frame(0, -1, (0.1, 0.0, 0.05)))
    return folder, {
        "ball": ball_certificate(planar, [0.3, 1.2, 0.4], radius=0.9),
        "ball of a point": ball_certificate(spatial, [0.3, 0.7, 0.9, 0.2], point, radius=0.05),
        "ball with a slide": ball_certificate(slider, [0.3, 0.5, 0.4], radius=0.2),
        "near arms": ball_certificate(spatial, [0.3, 0.7, 0.9, 0.2], radius=0.05, tolerance=ModelTolerance(1e-4, 1e-4)),
        "free path": path_certificate(check_path(two, rows, min_distance=0.2), file=source),
        "crossing path": path_certificate(check_path(two, [[0.1, 0.9], [0.3, -0.5]]), file=source),
        "covering": covering_of(folder, "a.cover", planar, 0.4),
        "covering within limits": covering_of(folder, "b.cover", slider, 0.4, limits=True),
        "covering of corank 2": covering_of(folder, "c.cover", planar, 0.8, corank=2),
        "existence": existence_certificate(planar, [0.3, 0.0, 0.2]),
    }


@pytest.fixture(scope="module")
def honest_changes(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Record]]:
    """Certificates of cuspidal arms, and of others."""
    return tmp_path_factory.mktemp("changes"), cuspidal.certificates() | cuspidal.sign_proofs()


def printed(found: Verified) -> tuple[str, ...]:
    return (found.kind, found.arm, found.claim, *found.statement)


def judged(folder: Path, record: Record, rows: Any = None) -> Verified | None:
    """The verdict on a certificate, of a path compared with the user's rows; None where it is refused as malformed."""
    try:
        return verify(write_certificate(with_hash(record), folder / "one.json"), asked_about(None, rows=rows),
                      enclosures=WORK)  # fmt: skip
    except ResultFileError:
        return None


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every entry, containers included."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path] * bool(path) + [place for key, one in inner for place in places(one, (*path, key))]


def changed(value: Any, rng: np.random.Generator) -> Any:
    """Another value of an entry."""
    if isinstance(value, bool):
        return [not value, 1, None][rng.integers(3)]
    if isinstance(value, int | float):
        ways = [-value, value + 1, value - 1, value * 1.5, value * (1 + 1e-9) + 1e-12, 0, 1e300, None, "x", 2, 0.15,
                float(np.nextafter(value, 9.0)) if abs(value) < 1e9 else 0, value / 2, value + 0.5]  # fmt: skip
        return ways[rng.integers(len(ways))]
    if isinstance(value, str):
        return [*WORDS, value + "x", value[:-1]][rng.integers(len(WORDS) + 2)]
    if isinstance(value, list):
        ways = [value[:-1], value + value[-1:], value[::-1], [], value[1:], None]
        return copy.deepcopy(ways[rng.integers(len(ways))])
    if isinstance(value, dict):
        key = list(value)[rng.integers(len(value))] if value else "none"
        return [{k: v for k, v in value.items() if k != key}, value | {"extra": 1}, None][rng.integers(3)]
    return [0, {}, [], {"length": 0.1, "angle": 0.1, "points": [[0.0, 0.0, 0.0]]}][rng.integers(4)]


def put(record: Record, place: tuple[Any, ...], value: Any) -> None:
    for key in place[:-1]:
        record = record[key]
    record[place[-1]] = value


def get(record: Any, place: tuple[Any, ...]) -> Any:
    for key in place:
        record = record[key]
    return record


def hashed(record: Record) -> None:
    """The fingerprint of the arm made anew, where the arm can be read at all."""
    with contextlib.suppress(ValueError, KeyError, TypeError, AttributeError):
        arm = _certificate(record, "")["arm"]
        record["arm"]["fingerprint"] = fingerprint(arm, [link_of(joint) for joint in arm["joints"]])


def recovered(folder: Path, record: Record, rng: np.random.Generator) -> None:
    """A covering written anew to go with a forged claim: its plan follows the claim, and boxes may be gone."""
    plan, tree, tested, freed = load(folder / record["claim"]["file"])
    keys = ("variables", "lower", "upper", "turns", "limits", "corank")
    entries = plan.entries() | {key: record["claim"][key] for key in keys if key in record["claim"]}
    entries["fingerprint"], entries["rows"] = record["arm"]["fingerprint"], record["task"]["rows"]
    entries["rank"] = record["rank"] + entries.get("corank", 1) - 1
    if rng.integers(2):
        roots = tree.roots.copy()
        roots[:] = False
        tree = BitTree(tree.shape, tree.finished, roots, tuple(masks[:0] for masks in tree.masks), tree.proven[:0])
    forged = plan_from_entries(entries)
    write_covering(folder / "forged.cover", Covering(forged, tree, tested, freed))
    record["claim"] |= {"file": "forged.cover", "sha256": digest(forged, tree)}


def forge(folder: Path, original: Record, rng: np.random.Generator, place: tuple[Any, ...]) -> tuple[Record, bool]:
    """One forgery, and whether it changes the claim."""
    record = copy.deepcopy(original)
    put(record, place, changed(get(record, place), rng))
    if rng.integers(4) == 0:  # a second entry
        others = [one for one in places(record) if one[0] not in NO_CLAIM]
        second = others[rng.integers(len(others))]
        put(record, second, changed(get(record, second), rng))
    if rng.integers(4):
        hashed(record)
    if record.get("kind") == "covering" and rng.integers(2):
        with contextlib.suppress(ValueError, TypeError, KeyError, AttributeError, IndexError, Refused, OSError):
            recovered(folder, record, rng)
    claimed = [{key: one for key, one in each.items() if key not in NO_CLAIM} for each in (record, original)]
    return record, claimed[0] != claimed[1]


def hold(folder: Path, original: Record, count: int, seed: int) -> tuple[int, int]:
    """Judge forgeries: how many are refused, and how many hold under another claim."""
    rng = np.random.default_rng(seed)
    postures = original["kind"] in ("posture change", "sign proof")  # that hold without a file
    rows = None if postures else original["claim"].get("points")
    first = judged(folder, original, rows)
    assert first is not None
    assert first.holds, first.reason
    entries = [place for place in places(original) if place != ("sha256",)]
    order = rng.permutation(len(entries))
    refused, other = 0, 0
    for number in range(count):
        record, claims = forge(folder, original, rng, entries[order[number % len(entries)]])
        found = judged(folder, record, rows)
        if found is None or not found.holds:
            refused += 1
        elif claims:
            assert printed(found) != printed(first), json.dumps(record)
            assert not postures or cuspidal.true(record), json.dumps(record)
            other += 1
    return refused, other


KINDS = ("ball", "ball of a point", "ball with a slide", "near arms", "free path", "crossing path", "covering",
         "covering within limits", "covering of corank 2", "existence")  # fmt: skip
CHANGES = ("posture change", "posture change within limits", "sign proof", "sign proof with a wrist",
           "sign proof of a point", "sign proof in a plane")  # fmt: skip


@pytest.mark.spread(3)
@pytest.mark.slow_at("posture change")
@pytest.mark.slow_at("posture change within limits", "sign proof", "sign proof with a wrist")
@pytest.mark.parametrize("kind", CHANGES)
def test_a_forged_proof_about_postures_is_refused_or_true(honest_changes, kind):
    folder, records = honest_changes
    refused, _ = hold(folder, records[kind], 100, 1)
    assert refused > 50


@pytest.mark.by_hand
@pytest.mark.parametrize("kind", CHANGES)
def test_none_of_ten_thousand_forged_proofs_about_postures_passes(honest_changes, kind):
    folder, records = honest_changes
    refused, other = hold(folder, records[kind], 2000, 2)
    assert refused > 1000
    assert other > 50


@pytest.mark.spread(5)
@pytest.mark.by_hand_at("ball")
@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_forgery_is_refused_or_prints_another_claim(honest, kind):
    folder, records = honest
    refused, _ = hold(folder, records[kind], 60, 1)
    assert refused > 20


@pytest.mark.by_hand_at("near arms", "ball with a slide", "ball of a point")
@pytest.mark.by_hand_at("ball", "covering", "covering within limits", "crossing path")
@pytest.mark.by_hand_at("covering of corank 2", "existence")
@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_none_of_ten_thousand_forgeries_passes_for_the_original(honest, kind):
    folder, records = honest
    refused, other = hold(folder, records[kind], 1000, 2)
    assert refused > 400
    assert other > 10  # a smaller ball, another name: true claims, stated as what they are


def test_a_covering_of_a_small_box_is_none_of_the_joint_space(tmp_path):
    """Ranges of ±0.15 rad around one regular configuration, an empty tree, and new hashes."""
    robot = open_robot("almarkhi4")
    record = covering_of(tmp_path, "a.cover", robot, 1.6)
    plan, tree, tested, freed = load(tmp_path / "a.cover")
    count = len(plan.variables)
    q = [0.7, 0.9, 0.2][:count]
    narrow = {"turns": (False,) * count, "lower": tuple(x - 0.02 for x in q), "upper": tuple(x + 0.02 for x in q)}
    empty = BitTree(tree.shape, tree.finished, np.zeros_like(tree.roots), tuple(one[:0] for one in tree.masks),
                    tree.proven[:0])  # fmt: skip
    for limits, words in ((False, "less than a turn"), (True, "less than its limits")):
        forged = replace(plan, **narrow, limits=limits)
        write_covering(tmp_path / "forged.cover", Covering(forged, empty, tested, freed))
        claim = {key: list(value) for key, value in narrow.items()} | {"limits": limits}
        record["claim"] |= claim | {"file": "forged.cover", "sha256": digest(forged, empty)}
        found = verify(write_certificate(with_hash(record), tmp_path / "c.json"), every=True)
        assert not found.holds
        assert words in found.reason


def test_a_covering_leaves_out_no_joint_that_decides(tmp_path):
    """Both the plan and the claim cover one joint less; every box of the others is free where that joint is at 0."""
    robot = open_robot("almarkhi4")
    record = covering_of(tmp_path, "a.cover", robot, 1.6)
    plan, tree, tested, freed = load(tmp_path / "a.cover")
    assert len(plan.variables) > 1
    fewer = {key: getattr(plan, key)[1:] for key in ("variables", "lower", "upper", "turns", "depth")}
    forged = replace(plan, **fewer)
    roots = np.zeros(forged.shape.trees, dtype=bool)
    empty = BitTree(forged.shape, ~roots, roots, (tree.masks[0][:0],) * len(tree.masks), tree.proven[:0])
    write_covering(tmp_path / "f.cover", Covering(forged, empty, tested, freed))
    record["claim"] |= {key: list(value) for key, value in fewer.items() if key != "depth"}
    record["claim"] |= {"file": "f.cover", "sha256": digest(forged, empty)}
    found = verify(write_certificate(with_hash(record), tmp_path / "c.json"), every=True)
    assert not found.holds
    assert "leaves out a joint that decides" in found.reason


def test_a_joint_that_others_follow_by_half_turns_has_no_whole_turn(tmp_path):
    """After a turn of joint a its follower has turned by half: the columns are others."""
    robot = region.coupled(np.random.default_rng(6), "r r r1:0.5 r")
    wide = replace(robot, task="position", joints=tuple(replace(one, lower=-3.3, upper=3.3) for one in robot.joints))
    assert covering(wide, 1.6).plan.turns == (False, True)
    record = covering_of(tmp_path, "a.cover", wide, 1.6)
    plan, tree, tested, freed = load(tmp_path / "a.cover")
    forged = replace(plan, turns=(True, True), lower=(-np.pi, plan.lower[1]), upper=(3.3, plan.upper[1]))
    write_covering(tmp_path / "f.cover", Covering(forged, tree, tested, freed))
    record["claim"] |= {"turns": [True, True], "lower": list(forged.lower), "upper": list(forged.upper)}
    record["claim"] |= {"file": "f.cover", "sha256": digest(forged, tree)}
    found = verify(write_certificate(with_hash(record), tmp_path / "c.json"), every=True)
    assert not found.holds
    assert "said to be a turn, and is none" in found.reason
    endless = replace(wide, joints=tuple(replace(one, lower=-np.inf, upper=np.inf) for one in robot.joints))
    with pytest.raises(OptionError, match="in whole turns"):
        covering(endless, 1.6)


def test_a_path_of_which_nothing_is_claimed_does_not_hold(honest):
    folder, records = honest
    for kind in ("free path", "crossing path"):
        record = copy.deepcopy(records[kind])
        last = len(record["claim"]["points"]) - 2
        record["claim"] |= {"verdict": "met", "spans": [{"from": [0, 0.0], "to": [last, 1.0], "kind": "open"}]}
        record["claim"].pop("min_distance", None)
        record["claim"].pop("scale", None)
        found = judged(folder, record)
        assert not found.holds
        assert "nothing is claimed" in found.reason


def test_the_claim_is_compared_with_what_was_asked(honest):
    folder, records = honest
    planar, spatial, slider, two = open_robot("planar3r"), open_robot("almarkhi4"), slide_arm(), open_robot("planar2r")
    moved = resolve_task("position", spatial, frame=Frame(0, -1, (0.1, 0.0, 0.55)))
    point = resolve_task("position", spatial, frame=Frame(0, -1, (0.1, 0.0, 0.05)))
    source, other = folder / "rows.csv", folder / "other.csv"
    other.write_text("0.1,0.9\n")
    wider = Robot("slider", tuple(replace(one, upper=one.upper + 0.1) for one in slider.joints), slider.home)
    cases = [
        ("ball", asked_about(planar, None, q=[0.3, 1.2, 0.4]), ""),
        ("ball", asked_about(planar, None, q=[0.3, 1.3, 0.4]), "q = (0.3, 1.2, 0.4)"),
        ("ball", asked_about(planar, "vx,vy"), "rows vx, vy, wz, not vx, vy"),
        ("ball", asked_about(None, path=source), "not a path"),
        ("ball", asked_about(None, limits=True), "play no part"),
        ("ball of a point", asked_about(spatial, point), ""),
        ("ball of a point", asked_about(spatial, moved), "another frame: point"),
        ("ball with a slide", asked_about(slider, resolve_task(None, slider)), ""),
        ("ball with a slide", asked_about(slider, resolve_task(None, slider, length_scale=0.05)), "divided by"),
        ("free path", asked_about(two, path=source, rows=[[0.1, 0.9], [0.3, 0.5], [0.4, 0.7]]), ""),
        ("free path", asked_about(two, path=source, rows=[[0.1, 0.9], [0.3, 0.5], [0.4, 0.8]]), "other rows"),
        ("free path", asked_about(two, path=other, rows=[[0.1, 0.9]]), "another"),
        ("covering", asked_about(planar, limits=False), ""),
        ("covering", asked_about(planar, limits=True), "the whole joint space"),
        ("covering within limits", asked_about(slider, limits=True), ""),
        ("covering within limits", asked_about(wider), "limits of joint 'a' differ"),
        ("existence", asked_about(planar, None, q=[0.3, 0.0, 0.2]), ""),
        ("existence", asked_about(planar, None, q=[0.3, 0.0, 0.3]), "q = "),
    ]
    for kind, asked, words in cases:
        found = verify(write_certificate(records[kind], folder / "one.json"), asked)
        assert found.holds == (not words), (kind, words, found.reason)
        assert not words or (found.reason.startswith("another claim") and words in found.reason)
    with pytest.raises(OptionError, match="a task is that of an arm"):
        asked_about(None, "pose")


def test_the_whole_claim_is_printed(honest):
    folder, records = honest
    text = str(verify(write_certificate(records["ball with a slide"], folder / "one.json")))
    scale = records["ball with a slide"]["claim"]["scale"][1]
    for words in ("q = (0.3, 0.5, 0.4)", f"divided by {scale!r} m", "limits 0.1 … 0.9", "vx, vy, wz", "rank 3",
                  "of the tip", "SHA-256"):  # fmt: skip
        assert words in text
    text = str(verify(write_certificate(records["covering within limits"], folder / "one.json"), every=True))
    for words in ("the joint limits", "joint 2 from 0.1 to 0.9", "corank 1 or more", "b.cover"):
        assert words in text
