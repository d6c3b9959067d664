"""Certificates as files: honest ones hold, and every change that makes one claim more is told."""

from __future__ import annotations

import ast
import copy
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from reference import arms, region
from reference.kinematics import jacobian as reference_jacobian

from rankdrop.cover.ball import ModelTolerance
from rankdrop.cover.certificates import (
    asked_about,
    ball_certificate,
    covering_certificate,
    existence_certificate,
    record_of,
    verify,
    write_certificate,
)
from rankdrop.cover.covering import Covering, write_covering
from rankdrop.cover.setting import best_setting, settings_for, settings_for_near_arms
from rankdrop.errors import OptionError, ResultFileError
from rankdrop.families.searching import search
from rankdrop.kinematics import pose
from rankdrop.path.check.certificate import path_certificate
from rankdrop.path.check.check import check_path
from rankdrop.proof import check, minors
from rankdrop.proof.boxes import digest, load
from rankdrop.proof.record import claim_of, read_certificate, with_hash
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import JointKind, Mimic
from rankdrop.robot.open import open_robot
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.verbs.covering import cover

ROWS = [[0.0, -1.0, 0.8, 0.4, 0.5, 0.0], [0.1, -0.9, 1.0, 0.4, -0.4, 0.2], [0.3, -0.6, 1.2, 0.1, -0.9, 0.0]]
PATHS = {"crossing": ROWS, "free": ROWS[1:], "away": ROWS[1:]}
Q = {"ur5": [0.3, -0.8, 1.2, 0.4, 0.9, 0.1], "planar3r": [0.3, 1.2, 0.4]}


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """One honest certificate of each kind, and the folder of the covering."""
    folder = tmp_path_factory.mktemp("certificates")
    robot = open_robot("ur5")
    ball = ball_certificate(robot, Q["ur5"], radius=0.3)
    near = ball_certificate(robot, Q["ur5"], radius=0.25, tolerance=ModelTolerance(3e-4, 1e-3))
    crossing = path_certificate(check_path(robot, ROWS))
    free = path_certificate(check_path(robot, ROWS[1:]))
    away = path_certificate(check_path(robot, ROWS[1:], min_distance=0.3))  # the wrist is 0.4 rad away
    there = existence_certificate(open_robot("puma560"), [0.1, 0.5, 0.4, 0.2, 0.0, 0.6])
    small = open_robot("planar3r")
    found = cover(small, width=0.2, out=folder / "small.cover", explain=False)
    plan = load(folder / "small.cover")[0]
    covering = covering_certificate(small, plan, found.sha256, "small.cover", resolve_task(None, small))
    made = {"ball": ball, "near": near, "crossing": crossing, "free": free, "away": away, "existence": there}
    return made | {"covering": covering}, folder


def judged(records, name, change=None, *, robot=None, seal=True, compared=True):
    """The verdict on a certificate, changed and hashed anew; of a path compared with its honest rows, or proven alone.
    """
    record = copy.deepcopy(records[0][name])
    if change is not None:
        change(record)
    asked = asked_about(robot, rows=PATHS.get(name) if compared else None)
    return verify(write_certificate(with_hash(record) if seal else record, records[1] / "one.json"), asked)


@pytest.mark.by_hand
@pytest.mark.slow_at("near")
@pytest.mark.parametrize("name", ["ball", "near", "crossing", "free", "away", "existence", "covering"])
def test_honest_certificates_hold(records, name):
    found = judged(records, name)
    assert found.holds, found
    assert found.claim
    assert not found.reason
    arm = {"existence": "puma560", "covering": "planar3r"}.get(name, "ur5")
    assert judged(records, name, robot=open_robot(arm)).holds
    other = judged(records, name, robot=open_robot("panda"))
    assert not other.holds
    assert "another arm" in other.reason
    Draft202012Validator(load_schema("certificate")).validate(records[0][name])
    Draft202012Validator(load_schema("verified")).validate(found.to_dict())


def entry(record, *keys):
    for key in keys:
        record = record[key]
    return record


def put(*keys, value=None, change=None):
    """A change of one entry."""

    def act(record):
        place = entry(record, *keys[:-1])
        place[keys[-1]] = value if change is None else change(place[keys[-1]])

    return act


def both(*acts):
    def act(record):
        for one in acts:
            one(record)

    return act


def free_span(record):
    span = record["claim"]["spans"][1]
    span["kind"] = "free"
    del span["bracket"]


def cut(record):
    record["proof"]["tree"] = record["proof"]["tree"][:-1]


LIES = {
    "ball: a radius beyond the boxes": ("ball", put("claim", "radius", change=lambda r: r * 1.001), "radius"),
    "ball: a larger ball altogether": (
        "ball", both(put("claim", "radius", value=1.6), put("proof", "side", value=1.6)), "proven"),
    "ball: another centre": ("ball", put("claim", "q", 4, value=0.2), "proven"),
    "ball: the tree is cut off": ("ball", cut, "cut off"),
    "ball: the tree goes on": ("ball", put("proof", "tree", change=lambda t: t + "."), "behind its end"),
    "ball: a box is called outside": ("ball", put("proof", "tree", change=lambda t: t.replace(".", "-", 1)), "outside"),
    "ball: a box is moved": ("ball", put("proof", "tree", change=lambda t: t.replace(".", "b", 1)), ""),
    "ball: cut along a joint that does not matter": (
        "ball", put("proof", "tree", change=lambda t: "a" + t + t), "means nothing"),
    "ball: slides and turns in another scale": ("ball", put("claim", "scale", 2, value=4.0), "another unit"),
    "ball: a tolerance that was not proven": (
        "ball", put("tolerance", value={"length": 0.05, "angle": 0.05, "points": [[0.0, 0.0, 0.0]] * 6}), ""),
    "near: a larger tolerance": ("near", put("tolerance", "angle", value=0.05), "proven"),
    "near: points beside the axes": ("near", put("tolerance", "points", 3, 0, value=5.0), "not on its axis"),
    "ball: an arm of other lengths": (
        "ball", put("arm", "joints", 2, "screw", 0, change=lambda x: x + 1e-9), "numbers of the arm"),
    "ball: a lower rank": ("ball", put("rank", value=5), "above 5"),
    "free: a segment is missing": ("free", put("claim", "spans", value=[]), "missing"),
    "crossing: a span is missing": (
        "crossing", put("claim", "spans", change=lambda spans: [spans[0], *spans[2:]]), "missing"),
    "crossing: the last span is missing": ("crossing", put("claim", "spans", change=lambda s: s[:-1]), "missing"),
    "crossing: a row is missing": ("crossing", put("claim", "points", change=lambda p: p[:-1]), "missing"),
    "crossing: told to be free": (
        "crossing", both(free_span, put("claim", "verdict", value="free")), "could not be proven free"),
    "crossing: free in the verdict": ("crossing", put("claim", "verdict", value="free"), "said to be free"),
    "away: a larger distance": ("away", put("claim", "min_distance", value=0.45), "distance"),
    "away: slides and turns in another scale": ("away", put("claim", "scale", 2, value=4.0), "another unit"),
    "free: a point of it moved": ("free", put("claim", "points", 1, 4, value=0.4), ""),
    "existence: a regular place": ("existence", put("claim", "q", 4, value=0.3), "away"),
    "existence: nearer than it is": (
        "existence", both(put("claim", "q", 4, value=1e-7), put("claim", "radius", value=1e-9)), "away"),
    "covering: other ranges": ("covering", put("claim", "lower", 0, value=-1.0), "other lower"),
    "covering: another hash": ("covering", put("claim", "sha256", value="0" * 64), "another covering"),
    "covering: another arm": ("covering", put("arm", "fingerprint", value="0" * 64), "fingerprint"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.by_hand_at("ball: a larger ball altogether", "away: a larger distance", "ball: a radius beyond the boxes")
@pytest.mark.parametrize("lie", LIES)
def test_a_certificate_that_was_changed_does_not_hold(records, lie):
    name, change, reason = LIES[lie]
    found = judged(records, name, change, compared=False)
    assert not found.holds, found
    assert reason in found.reason
    assert "alone" not in found.reason  # it is not even proven of its own control points
    assert not found.claim


@pytest.mark.slow
def test_a_distance_is_claimed_where_it_is_proven(records):
    claim = records[0]["away"]["claim"]
    assert claim["min_distance"] == 0.3
    found = judged(records, "away")
    assert "nearer to the path than 0.3 rad" in found.claim
    assert "nearer" not in judged(records, "free").claim
    robot = open_robot("ur5")
    rows = [[0.1, -0.9, 1.0, 0.4, -0.4, 0.2], [0.3, -0.6, 1.2, 0.1, -0.9, 0.0]]
    assert "min_distance" not in path_certificate(check_path(robot, rows, min_distance=0.5))["claim"]


@pytest.mark.slow
def test_a_bracket_needs_two_signs(records):
    def change(record):
        low, high = record["claim"]["spans"][1]["bracket"]
        record["claim"]["spans"][1]["bracket"] = [low, [low[0], (low[1] * 0.999 + high[1] * 0.001)]]

    found = judged(records, "crossing", change)
    assert not found.holds
    assert "two signs" in found.reason or "inside" in found.reason


@pytest.mark.parametrize("place", [("claim", "radius"), ("arm", "name"), ("arm", "joints", 1, "screw", 4), ("rank",)])
def test_whatever_is_changed_without_a_new_hash_is_told(records, place):
    found = judged(records, "ball", put(*place, change=lambda x: x * 2), seal=False)
    assert not found.holds
    assert "hash" in found.reason


def test_a_file_that_is_cut_off_does_not_hold(records):
    place = write_certificate(records[0]["ball"], records[1] / "whole.json")
    whole = place.read_bytes()
    for length in (200, len(whole) // 2, len(whole) - 3):
        (records[1] / "part.json").write_bytes(whole[:length])
        found = verify(records[1] / "part.json")
        assert not found.holds
        assert "cut off" in found.reason


MALFORMED = {
    "no list of joints": put("arm", "joints", value={}),
    "no joint": put("arm", "joints", value=[]),
    "a screw of five": put("arm", "joints", 0, "screw", value=[0.0] * 5),
    "an axis that is no unit vector": put("arm", "joints", 0, "screw", value=[0.0, 0.0, 0.0, 0.0, 0.0, 2.0]),
    "a turning joint with a pitch": put("arm", "joints", 0, "screw", value=[0.0, 0.0, 0.1, 0.0, 0.0, 1.0]),
    "a variable that is not there": put("arm", "joints", 0, "variable", value=9),
    "a turning joint with hardly a pitch": put("arm", "joints", 0, "screw", value=[0.0, 0.0, 1.5e-9, 0.0, 0.0, 1.0]),
    "a radius in words": put("claim", "radius", value="0.3"),
    "a radius that is true": put("claim", "radius", value=True),
    "no radius": lambda record: record["claim"].pop("radius"),
    "a configuration of five": put("claim", "q", value=[0.0] * 5),
    "a tree of numbers": put("proof", "tree", value=[1, 2]),
    "no claim": put("claim", value=None),
    "rows twice": put("task", "rows", value=[0, 0, 1]),
    "a link that is not there": put("view", "link", value=9),
    "a length of zero": put("view", "length", value=0.0),
    "a tip that is no rigid motion": put("arm", "home", 0, 0, value=3.0),
    "another kind": put("kind", value="guess"),
}


@pytest.mark.parametrize("what", MALFORMED)
def test_malformed_certificates_are_refused(records, what):
    with pytest.raises(ResultFileError, match="malformed"):
        judged(records, "ball", MALFORMED[what])


def test_a_singular_configuration_is_claimed_within_a_radian(records):
    with pytest.raises(ResultFileError, match=r"malformed.*radius"):
        judged(records, "existence", put("claim", "radius", value=1.5))


@pytest.mark.parametrize("content", [b"", b"[]", b"{", b"\xff\xfe", b'{"schema": "rankdrop/path/1"}', b"[" * 100_000])
def test_what_never_was_a_certificate_is_refused(tmp_path, content):
    (tmp_path / "other.json").write_bytes(content)
    with pytest.raises(ResultFileError, match="no certificate"):
        verify(tmp_path / "other.json")
    with pytest.raises(ResultFileError, match="cannot read"):
        verify(tmp_path / "nothing.json")


def test_numbers_that_are_none_are_refused(records):
    text = json.dumps(records[0]["ball"]).replace(str(records[0]["ball"]["claim"]["radius"]), "NaN", 1)
    (records[1] / "nan.json").write_text(text)
    assert not verify(records[1] / "nan.json").holds


def test_a_covering_that_lost_boxes_does_not_hold(records, tmp_path):
    """A covering written anew, hash and all, without the boxes around one family."""
    from dataclasses import replace

    plan, tree, tested, freed = load(records[1] / "small.cover")
    fewer = tuple(masks.copy() for masks in tree.masks)
    assert len(fewer[-1]) > 1
    fewer[-1][0] = fewer[-1][0] & (~fewer[-1][0] + 1) if bin(int(fewer[-1][0])).count("1") > 1 else fewer[-1][0]
    roots = tree.roots.copy()
    lost = replace(tree, masks=fewer, proven=tree.proven & fewer[-1])
    if (fewer[-1] == tree.masks[-1]).all():  # one leaf each: take away a whole tree
        roots[np.flatnonzero(roots)[0]] = False
        lost = replace(tree, roots=roots, masks=tuple(masks[1:] for masks in tree.masks), proven=tree.proven[1:])
    write_covering(tmp_path / "small.cover", Covering(plan, lost, tested, freed))
    told = digest(plan, lost)
    robot = open_robot("planar3r")
    record = covering_certificate(robot, plan, told, "small.cover", resolve_task(None, robot))
    found = verify(write_certificate(record, tmp_path / "c.json"), enclosures=20_000)
    assert not found.holds
    assert "could not be proven free" in found.reason


@pytest.mark.parametrize("name", ["../small.cover", "sub/small.cover", "sub\\small.cover", "", ".", ".."])
def test_a_covering_lies_beside_its_certificate(records, name):
    (records[1] / "sub").mkdir(exist_ok=True)
    place = records[1] / "sub" / "c.json"
    record = copy.deepcopy(records[0]["covering"])
    record["claim"]["file"] = name
    write_certificate(with_hash(record), place)
    with pytest.raises(ResultFileError, match="without a folder"):
        verify(place)


@pytest.mark.parametrize("tasks", [("position", "position"), ("position", "orientation")])
def test_the_covering_of_another_arm_or_task_does_not_hold(tmp_path, tasks):
    """Two honest coverings with as many joints and the same rank, each under the certificate of the other."""
    made = []
    lengths = (0.6, 1.6 if tasks[0] == tasks[1] else 0.6)
    for name, task, length in zip(("a.cover", "b.cover"), tasks, lengths, strict=True):
        rows = [(0.5, np.pi / 2, 0.2, 0.0), (length, -np.pi / 2, 0.1, 0.0), (0.4, 0.0, 0.0, 0.0)]
        robot = from_dh(rows, convention="standard", task=task)
        found = cover(robot, width=1.6, out=tmp_path / name, explain=False)
        made.append(covering_certificate(robot, found.covering.plan, found.sha256, name, resolve_task(None, robot)))
    assert made[0]["rank"] == made[1]["rank"] == 3
    for mine, other in (made, made[::-1]):
        swapped = copy.deepcopy(mine)
        swapped["claim"] |= {key: other["claim"][key] for key in ("file", "sha256")}
        told = verify(write_certificate(with_hash(swapped), tmp_path / "c.json"))
        assert not told.holds
        assert "another arm or task" in told.reason


def test_a_covering_of_a_higher_corank_holds_for_that_corank_alone(tmp_path):
    """A planar arm has no configuration of corank 2: none of its boxes is left."""
    robot = open_robot("planar3r")
    found = cover(robot, width=0.8, corank=2, out=tmp_path / "two.cover", explain=False)
    assert found.covering.tree.leaves == 0
    record = covering_certificate(robot, found.covering.plan, found.sha256, "two.cover", resolve_task(None, robot))
    Draft202012Validator(load_schema("certificate")).validate(record)
    told = verify(write_certificate(record, tmp_path / "c.json"), robot)
    assert told.holds
    assert "a rank below 2 is in one of the 0 boxes" in told.claim
    for corank, rank, words in ((1, 2, "almost everywhere"), (1, 3, "another arm or task"), (3, 2, "at most 3"),
                                (2, 3, "at most 3")):  # fmt: skip
        other = copy.deepcopy(record)
        other["claim"]["corank"], other["rank"] = corank, rank
        assert words in verify(write_certificate(with_hash(other), tmp_path / "c.json"), robot).reason
    ball = ball_certificate(robot, Q["planar3r"])  # of a ball no corank is told: the rank is the one almost everywhere
    ball["rank"] = 2
    assert "almost everywhere" in verify(write_certificate(with_hash(ball), tmp_path / "b.json"), robot).reason
    ball["claim"]["corank"] = 2
    with pytest.raises(ResultFileError, match="no entry 'corank'"):
        verify(write_certificate(with_hash(ball), tmp_path / "b.json"), robot)


def test_a_sample_of_a_covering_is_no_proof(records):
    place = write_certificate(records[0]["covering"], records[1] / "c.json")
    found = verify(place, sample=3)
    assert str(found).startswith("Not confirmed")  # nothing is refuted either
    assert not found.holds
    assert "3 of" in found.reason
    assert "not checked" in found.reason


def test_work_that_is_used_up_is_told(records):
    found = verify(write_certificate(records[0]["ball"], records[1] / "b.json"), enclosures=3)
    assert not found.holds
    assert "used up" in found.reason
    with pytest.raises(OptionError, match="whole number"):
        verify(records[1] / "b.json", enclosures=0)


ARMS = {
    **{name: (lambda name=name: open_robot(name)) for name in ("scara", "stanford", "almarkhi4", "planar3r")},
    "random screws": lambda: arms.random_chain(np.random.default_rng(5), "rhrphrr"),
    "mimics": lambda: region.coupled(np.random.default_rng(6), "r p r1:0.3 p1:-0.4 r h0:2.5 r p0:0.3 r"),
    "five joints": lambda: arms.random_chain(np.random.default_rng(7), "rrrrr"),
}


@pytest.mark.slow_at("mimics")
@pytest.mark.parametrize("name", ARMS)
def test_balls_of_every_kind_of_joint_hold(tmp_path, name):
    robot = ARMS[name]()
    q = np.random.default_rng(3).uniform(-1.5, 1.5, robot.n)
    radius = ball_certificate(robot, q, evaluations=2_000)["claim"]["radius"] * 0.6
    record = ball_certificate(robot, q, radius=radius)
    assert verify(write_certificate(record, tmp_path / "b.json"), robot).holds


@pytest.mark.spread(3)
@pytest.mark.by_hand_at("canadarm2-None", "fetch-vx,vy", "xarm5-None")
@pytest.mark.slow
@pytest.mark.parametrize(("name", "task"), [
    ("planar3r", None), ("planar2r", None), ("planar3r", "vx,vy"), ("scara", None), ("almarkhi4", None),
    ("stanford", None), ("canadarm2", None), ("puma560", "position"), ("puma560", "orientation"), ("ur5", "position"),
    ("xarm5", None), ("open_manipulator", None), ("panda", "orientation"), ("fetch", "vx,vy"),
])  # fmt: skip
def test_a_singular_configuration_of_every_task_exists(tmp_path, name, task):
    """Found by a search, proven by intervals or in rational numbers; and nowhere beside it."""
    robot = open_robot(name)
    held = 0
    for q in search(robot, 1, task=task, starts=12, seed=3).converged[:4]:
        record = existence_certificate(robot, q, task)
        found = verify(write_certificate(record, tmp_path / "e.json"), robot)
        held += found.holds
        record["claim"]["q"] = (np.array(q) + 1e-3).tolist()
        assert not verify(write_certificate(with_hash(record), tmp_path / "e.json"), robot).holds
    assert held >= (1 if name == "stanford" else 4)  # there some lie where no single joint, the others kept, leads to


@pytest.mark.parametrize(("name", "task"), [
    ("almarkhi4", None), ("puma560", None), ("stanford", None), ("scara", None), ("planar3r", "vx,vy"),
    ("panda", None), ("ur5", "vx,wz"),
])  # fmt: skip
def test_jacobians_in_rational_numbers_are_those_of_an_independent_model(tmp_path, name, task):
    """Columns are as long as axes in the file are, lengths in metres: the same rows to rounding."""
    robot = open_robot(name)
    resolved = resolve_task(task, robot)
    told = read_certificate(write_certificate(record_of(
        robot, resolved, "existence", replace(best_setting(robot, resolve_task("pose", robot)), rank=1),
        {"q": [0.0] * robot.n, "radius": 0.0}, {}), tmp_path / "e.json"))  # fmt: skip
    arm = minors._Exact(told)
    anywhere = np.random.default_rng(5).uniform(-1.5, 1.5, (3, robot.n))
    right = np.random.default_rng(6).integers(-4, 5, (6, robot.n)) * (np.pi / 2)  # of each quarter, put there exactly
    for q, snap in [*((one, False) for one in anywhere), *((one, True) for one in right)]:
        exact = arm.task_rows([arm.rational(k, x, snap=snap) for k, x in enumerate(q)])
        values = np.array([[float(x.p) / float(x.q) for x in row] for row in exact.tolist()])
        expected = reference_jacobian(robot, q)[list(resolved.rows)]
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-13)


def test_where_the_rank_is_lower_wherever_the_arm_stands_nothing_is_said_to_be_lost(tmp_path):
    """A SCARA has no rank of 6 to lose: a certificate that names it, by intervals or in rational numbers, fails."""
    for name, task, rank in (("scara", "pose", 5), ("planar3r", "pose", 4)):
        robot = open_robot(name)
        record = existence_certificate(robot, search(robot, 1, task=task, starts=12).converged[0], task)
        record["rank"] = rank
        assert not verify(write_certificate(with_hash(record), tmp_path / "e.json"), robot).holds


@pytest.mark.slow
def test_nothing_is_certified_at_a_singularity_and_nothing_singular_elsewhere():
    robot = open_robot("ur5")
    with pytest.raises(OptionError, match="singular"):
        ball_certificate(robot, [0.3, -0.8, 1.2, 0.4, 0.0, 0.1])
    with pytest.raises(OptionError, match="not singular"):
        existence_certificate(robot, Q["ur5"])
    with pytest.raises(OptionError, match="not proven"):
        ball_certificate(robot, Q["ur5"], radius=2.0)


def test_the_checker_imports_nothing_of_the_package():
    """NumPy and python-flint alone: what makes certificates takes no part in their proof."""
    folder = Path(check.__file__).parent
    outside = set()
    for file in folder.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0
                outside.add(node.module)
            elif isinstance(node, ast.Import):
                outside |= {name.name for name in node.names}
    foreign = {name for name in outside if name.split(".")[0] not in sys.stdlib_module_names}
    assert {name.split(".")[0] for name in foreign} == {"numpy", "flint", "rankdrop"}
    assert all(name.startswith("rankdrop.proof.") for name in foreign if name.startswith("rankdrop"))


def test_joints_about_axes_through_the_point_of_a_translation_are_free(tmp_path):
    """Only joints 2 and 3 matter to PUMA's wrist centre, and a link that does not carry the point is refused."""
    robot = open_robot("puma560")
    task = resolve_task("position", robot)
    (setting,) = settings_for(robot, task)
    (near,) = settings_for_near_arms(robot, task)
    assert (setting.link, near.link) == (3, 6)
    assert np.flatnonzero(setting.matters).tolist() == [1, 2]
    record = ball_certificate(robot, [0.1, 0.9, 0.4, -1.2, 0.7, 1.1], task)
    assert verify(write_certificate(record, tmp_path / "ball.json")).holds
    record["view"]["link"] = 2
    refused = verify(write_certificate(with_hash(record), tmp_path / "forged.json"))
    assert (refused.holds, refused.reason) == (False, "the point of the translation does not stand still in link 2")


FOUR = [(0.4, 0.9, 0.1, 0), (0.3, -0.7, 0.2, 0), (0.2, 0.5, 0.1, 0), (0.0, 0, 0.1, 0)]


def with_last(change):
    """A spatial 4R whose last axis goes through its tip, with another last joint."""
    robot = from_dh(FOUR, convention="standard", name="four")
    return replace(robot, joints=(*robot.joints[:3], change(robot.joints[3])))


OTHERS = {
    "an axis beside the point": from_dh([*FOUR[:3], (1e-3, 0, 0.1, 0)], convention="standard", name="four"),
    "a slide": from_dh(FOUR, convention="standard", kinds="RRRP", name="four"),
    "a screw": with_last(
        lambda joint: replace(
            joint, kind=JointKind.HELICAL, screw=joint.screw + 0.02 * np.append(joint.axis, np.zeros(3))
        )
    ),
    "a follower": with_last(lambda joint: replace(joint, mimic=Mimic("joint2", 1.0))),
}


@pytest.mark.parametrize("kind", OTHERS)
def test_a_point_that_a_joint_moves_does_not_stand_still(kind, tmp_path):
    """The last joint counts: for the certificate, and for the checker, which finds it out by itself."""
    robot = OTHERS[kind]
    (setting,) = settings_for(robot, resolve_task("position", robot))
    assert setting.link == 4
    record = ball_certificate(robot, [0.3, 0.8, 1.1, 0.2][: robot.n], "position")
    assert verify(write_certificate(record, tmp_path / "ball.json")).holds
    record["view"]["link"] = 3
    forged = verify(write_certificate(with_hash(record), tmp_path / "forged.json"))
    assert (forged.holds, forged.reason) == (False, "the point of the translation does not stand still in link 3")


def test_a_point_seen_from_an_earlier_link_is_not_proven_for_near_arms(tmp_path):
    """Their last axis goes beside the point."""
    robot = from_dh(FOUR, convention="standard", name="four")
    q = [0.3, 0.8, 1.1, 0.2]
    record = ball_certificate(robot, q, "position", radius=0.02, tolerance=ModelTolerance(1e-4, 1e-4))
    assert verify(write_certificate(record, tmp_path / "ball.json")).holds
    record["view"]["link"] = 3
    forged = verify(write_certificate(with_hash(record), tmp_path / "forged.json"))
    assert (forged.holds, forged.reason) == (False, "the point of the translation does not stand still in link 3")


def test_a_point_beside_an_axis_by_rounding_is_enclosed_wherever_the_joint_stands(tmp_path):
    """1e-10 aside: the checker lets it pass, with all of the circle."""
    robot = from_dh([*FOUR[:3], (1e-10, 0, 0.1, 0)], convention="standard", name="four")
    record = ball_certificate(robot, [0.3, 0.8, 1.1, 0.2], "position")
    record["view"]["link"] = 3
    claim = claim_of(with_hash(record), tmp_path)
    seen = check.arm_of(claim)
    home = pose(robot, np.zeros(4))[:3, 3]
    for turned in (0.5, np.pi):
        there = pose(robot, [0.0, 0.0, 0.0, turned])[:3, 3]
        for middle, end, start in zip(seen._point, there, home, strict=True):
            assert abs(float(middle.mid()) - start) < 1e-12
            assert abs(end - start) <= float(middle.rad()) + 1e-14
    assert max(float(x.rad()) for x in seen._point) > 1e-10
