"""What people are shown by default: no sentence above 25 words but those listed here, no formula, no jargon.

The verdict is coloured, degrees are suspected before the verdict.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.robot.open import open_robot
from rankdrop.text.words import PROOF
from rankdrop.verbs.explain import explain

LONGEST = 25
UR5E = ("ur5e", "--deg", "--q", "0,-60,0,40,50,0")
OUTPUTS = {
    "elbow": ("explain", *UR5E),
    "regular": ("explain", "panda", "--q", "0,0.3,0,-1.8,0,1.9,0.7"),
    "corank 3": ("explain", "pa10", "--q", "0,0,0,0,0,0,0"),
    "near": ("explain", "ur5", "--deg", "--q", "0,-135,45,90,-0.5,0"),
    "nearly ideal": ("explain", "gen3", "--deg", "--q", "0,0,0,0,0,0,0"),
    "always": ("explain", "scara", "--q", "0,0,0.1,0", "--task", "pose"),
    "degrees": ("explain", "ur5", "--q", "0,-135,45,90,-90,0"),
    "escape": ("escape", "puma560", "--deg", "--q", "10,20,30,40,0,50"),
    "nearest": ("nearest", "ur5", "--deg", "--q", "0,-135,45,90,0,0"),
    "analyze": ("analyze", "planar3r", "--starts", "300"),
    "conditions": ("conditions", "pa10"),
    "remarks": ("conditions", "gen3"),
    "ideal": ("conditions", "anthropomorphic", "--ideal", "1mm"),
    "cover": ("cover", "planar3r", "--width", "0.4", "--corank", "1"),
    "robots": ("robots", "fanuc"),
    "jacobian": ("jacobian", "ur5"),
}
ALLOWED = {
    r"^joints( |$)": "a list of names",
    r" = 0( |$|;)": "a condition, not a sentence",
}
"""Sentences that may be longer, and why."""
JARGON = re.compile(r"\bmend:|\bsound\b|\bcompleteness\b|others (coupled|fixed)|\bspare\b|u · dJ|task freedom|Δ")


def sentences(text: str) -> list[str]:
    """The lines of an output that is not wrapped, cut at the ends of sentences."""
    return [one for line in text.splitlines() for one in re.split(r"(?<=[.!?]) +", line.strip()) if one]


def words_of(sentence: str) -> list[str]:
    """Tokens that are words: at least two letters in a row."""
    return [token for token in sentence.split() if re.search(r"[^\W\d_]{2}", token)]


def too_long(text: str) -> list[str]:
    """Sentences above the limit that nothing excuses."""
    return [
        one for one in sentences(text)
        if len(words_of(one)) > LONGEST and not any(re.search(pattern, one) for pattern in ALLOWED)
    ]  # fmt: skip


@pytest.fixture(scope="module")
def printed() -> dict[str, str]:
    """What has been printed by then, by the key of `OUTPUTS`."""
    return {}


@pytest.mark.slow
@pytest.mark.by_hand_at("remarks")
@pytest.mark.parametrize("key", OUTPUTS)
def test_no_sentence_of_a_default_output_is_longer_than_can_be_read(
    key: str, run: Any, printed: dict[str, str]
) -> None:
    printed[key] = run(*OUTPUTS[key], width=2000).out
    assert printed[key]
    assert too_long(printed[key]) == []
    assert [line for line in printed[key].splitlines() if JARGON.search(line)] == []


SIX = {
    "ur5e": "0,-60,0,40,50,0", "panda": "10,20,30,-26.76,0,50,0", "scara": "0,0,0.1m,0", "planar3r": "0,0,20",
    "sawyer": "0,0,0,0,0,0,0", "tiago": "0.1m,10,20,30,40,50,60,70",
}  # fmt: skip
"""Arms of six kinds, the last one on a slide, and a configuration of each [°, m]."""


@pytest.mark.slow
@pytest.mark.shipped
@pytest.mark.parametrize("arm", SIX)
def test_no_sentence_is_longer_on_any_of_six_arms(arm: str, run: Any) -> None:
    at = (arm, "--deg", f"--q={SIX[arm]}")
    lines = [(word, *at) for word in ("explain", "escape", "nearest", "jacobian")]
    lines += [("analyze", arm, "--starts", "300"), ("conditions", arm)]
    if arm == "scara":
        lines += [("cover", arm, "--width", "0.4"), ("compare", arm, "ur5e", "--task", "position", "--starts", "50")]
    for line in lines:
        out = run(*line, width=2000).out
        assert out
        assert too_long(out) == [], line
        assert [text for text in out.splitlines() if JARGON.search(text)] == [], line


DESIGNS = """
robot = "planar3r"
[parameters]
forearm = { sets = "3.a", values = [0.3, 0.4] }
tool = { sets = "tool.x", values = [0.0, 0.1] }
[families]
exact = true
starts = 60
fresh = 60
[near]
within = "5 deg"
samples = 2000
[region]
lower = [0.3, -0.2, 0.0]
upper = [0.6, 0.2, 0.0]
rpy = [0, 0, 0]
points = 3
"""
"""Variants of the smallest arm, with everything that is told of them."""


MOTION: dict[str, tuple[tuple[str, ...], ...]] = {
    "sweep": (("sweep", "designs.toml", "--workers", "1"), ("sweep", "designs.toml", "--workers", "1", "--all")),
    "monitor": (("monitor", "ur5e", "--header", "-"),),  # comments; lines of numbers have no words
    "path": (("path", "ur5e", "path.csv"),),
    "remedies": (("path", "ur5e", "path.csv", "--remedies"),),
    "verify": (
        ("nearest", "planar3r", "--q", "0.3,1.2,0.4", "--certificate", "ball.json"), ("verify", "ball.json"),
    ),
    "aspects": (("aspects", "ur5e", "--poses", "2"),),
    "through": (("through", "planar2r", "--q", "0,0", "--along", "-1,0"),),
    "tolerant": (("tolerant", "planar3r", "--starts", "30"),),
    "cover": (("cover", "planar3r", "--width", "0.4"),),
    "compare": (
        ("compare", "planar2r", "planar3r", "--task", "planar-position", "--starts", "50", "--workers", "1"),
    ),
}  # fmt: skip
"""Commands about motion and proofs, those of one key in turn in one folder."""


@pytest.mark.slow
@pytest.mark.parametrize("key", MOTION)
def test_no_sentence_about_motion_or_proofs_is_longer(
    key: str, run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    start, end = np.radians([0, -60, 60, -40, 50, 0]), np.radians([40, -100, -20, 10, -30, 60])
    rows = [start + share * (end - start) for share in np.linspace(0.0, 1.0, 20)]
    Path("path.csv").write_text("\n".join(",".join(f"{x:.6f}" for x in row) for row in rows), encoding="utf-8")
    Path("designs.toml").write_text(DESIGNS, encoding="utf-8")
    for line in MOTION[key]:
        out = run(*line, width=2000).out
        assert out, line
        assert too_long(out) == [], line
        assert [text for text in out.splitlines() if JARGON.search(text)] == [], line


def test_every_exception_is_met(printed: dict[str, str]) -> None:
    if len(printed) < len(OUTPUTS) - 1:  # one of them by hand
        pytest.skip("runs after the outputs above")
    whole = "\n".join(printed.values())
    unmet = [pattern for pattern in ALLOWED if not any(re.search(pattern, one) for one in sentences(whole))]
    assert unmet == []


def test_the_limit_is_one() -> None:
    assert too_long(f"{'word ' * 25}end.") == [f"{'word ' * 25}end."]
    assert too_long(f"{'word ' * 12}end. {'word ' * 12}end.") == []


def test_a_table_under_one_lost_freedom_calls_no_direction_impossible(run: Any) -> None:
    out = run("explain", *UR5E, "--full").out
    table = out[out.index("What motion costs") : out.index("If one joint fails")]
    assert "impossible" not in out
    assert "base axes" in table.splitlines()[0]
    rows = [line for line in table.splitlines() if re.match(r"  (along|about) [XYZ].*%", line)]
    assert len(rows) == 6
    assert all("%" in row for row in rows)
    found = explain(open_robot("ur5e"), np.radians([0, -60, 0, 40, 50, 0]), evaluations=0)
    told = next(one for one in found.sections(parts=("rates",)) if one.title == "What motion costs")
    assert all(re.fullmatch(r".*\d (m/s|rad/s)", row[3]) for row in told.rows[:6])
    along = {row[0].split()[1]: float(row[1].split()[0]) for row in told.rows if row[0].startswith("along")}
    assert along == {"X": 23.4, "Y": 3.75, "Z": 70.2}


@pytest.mark.slow
def test_lost_motion_is_told_in_base_and_tool_axes_first_and_links_by_name(run: Any) -> None:
    out = run("explain", *UR5E, "--full").out
    lost = out[out.index("What is lost") : out.index("How to get out")]
    axes = ("in base axes:", "in tool axes:", "in axes of the tool at the origin of link 5 (after wrist_2_joint)")
    places = [lost.index(word) for word in axes]
    assert places == sorted(places)
    assert "cannot" not in lost
    only = run("explain", *UR5E, "--frame", "tool", "--full").out
    assert "in tool axes:" in only
    assert "in base axes:" not in only
    assert "What motion costs  tool axes" in only


def test_the_proof_stands_in_the_full_output_alone(run: Any) -> None:
    plain, full = (run("explain", *UR5E, *more).out for more in ((), ("--full",)))
    for said in ("You cannot leave it with the tool held still.", "The tool is at an edge of its reach"):
        assert said in plain
        assert said in full
    assert "u · dJ(Δ)Δ is definite" in full
    assert "u · dJ" not in plain
    found = explain(open_robot("ur5e"), [0, -1.0, 0, 0.7, 0.9, 0], evaluations=0)
    assert found.escape.avoidable_reason in PROOF
    assert found.escape.boundary_reason in PROOF


def test_degrees_are_suspected_before_the_verdict(run: Any) -> None:
    out = run("explain", "ur5", "--q", "0,-135,45,90,-90,0").out
    assert 0 <= out.index("angles up to 135 look like degrees") < out.index("ur5 is regular")
    assert "Degrees?" not in run("explain", "ur5", "--deg", "--q", "0,-135,45,90,-90,0").out


def test_a_six_joint_arm_has_no_spare_joint_but_an_idle_motion(run: Any) -> None:
    out = run("explain", *UR5E, "--full").out
    assert "1 way to move the joints does not move the tool (nullity 1)" in " ".join(out.split())


def test_the_verdict_is_coloured_where_colours_are_wanted(run: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    assert "\x1b" not in run("explain", *UR5E).out
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    assert run("explain", *UR5E).out.startswith("\x1b[1;31mur5e is singular")
    assert "\x1b[1;32m" in run("explain", "panda", "--q", "0,0.3,0,-1.8,0,1.9,0.7").out
    monkeypatch.setenv("NO_COLOR", "1")
    assert re.search(r"\x1b\[[\d;]*3\d", run("explain", *UR5E).out) is None


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (("find", "pa10"), "--corank is missing: "),
        (("find", "pa10", "--corank"), "--corank needs a value: "),
        (("explain",), "ROBOT is missing: name in the catalogue"),
        (("explain", "ur5"), "--q: joint values are missing"),
        (("explain", *UR5E, "--tcp", "1,2"), "a tool point is three lengths, then three angles if the tool is turned"),
        (("explain", *UR5E, "--tcp", "1,2,x"), "--tcp: the unit is not one that fits here"),
    ],
)
def test_what_is_missing_is_called_missing(line: tuple[str, ...], said: str, run: Any) -> None:
    ended = run(*line)
    assert ended.code == 2
    assert said in ended.err


@pytest.mark.parametrize("command", ["explain", "escape"])
def test_a_tool_point_is_understood_in_millimetres_and_degrees(command: str, run: Any) -> None:
    one = run(command, *UR5E, "--tcp", "0,0,120mm,0,0,90", "--frame", "tool").out
    other = run(command, *UR5E, "--tcp", "0 0 0.12 0 0 pi/2rad", "--frame", "tool").out
    assert "0.63 vx + 0.333 vy + 0.702 vz" in " ".join(one.split())
    assert one == other


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (("ur5", "--deg", "--q", "0", "-60", "0", "10"), "Numbers of one option need commas or quotes: --q 0,-60,0"),
        (("planar2r", "--q", "0,5; 1,25"), "fix: write decimals with points: 0.5; 1.25"),
        (("ur5", "--q", "0,0,0,0,0,0", "--tcp", "0,0,120"), "--tcp: a tool point so far from the tip is a slip"),
        (("ur5", "--q", "0,0,0,0,0,0", "--tcp", "0,0,120"), "fix: in millimetres: --tcp=0mm,0mm,120mm"),
    ],
)
def test_slips_of_the_hand_are_recognised(line: tuple[str, ...], said: str, run: Any) -> None:
    ended = run("explain", *line)
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err


def test_radians_that_are_taken_as_degrees_are_noted(run: Any) -> None:
    words = ("explain", "planar2r", "--deg", "--evaluations", "0", "--q")
    assert "note: angles up to 1.571 look like radians" in run(*words, "0,1.5708").err
    assert run(*words, "0,90").err == run(*words, "0,3").err == ""
