"""--ideal on the command line, and the line that says that an ideal arm is near."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli.calibrated import CALIBRATED, TOLERANCE, Q
from printed import one_line

from rankdrop.cli import exits
from rankdrop.robot.ideal import intended_tolerance
from rankdrop.robot.model import Joint
from rankdrop.robot.open import open_robot


@pytest.mark.slow_at("command1")
@pytest.mark.parametrize(
    "command", [("conditions", "gen3_6dof", "--coranks", "1", "--points", "0", "--lengths", "numbers"),
                ("analyze", "gen3_6dof", "--starts", "100", "--exact", "off"),
                ("explain", "gen3_6dof", "--q", "0,1,1,0.3,0.4,0.5")],
)  # fmt: skip
def test_one_line_says_what_is_near_and_what_to_type(run, command: tuple[str, ...]) -> None:
    ended = run(*command, *(() if command[0] == "explain" else ("--quiet",)))
    line = "this arm is within 1 mm of one with a spherical wrist and no offset along axes 2 and 3: see --ideal 1.1mm"
    assert one_line(ended.out).count(line) == 1
    assert "The arm itself" not in ended.out


@pytest.mark.slow
def test_what_is_near_stands_in_every_file_too(run) -> None:
    near = {"text": "this arm is within 1 mm of one with a spherical wrist and no offset along axes 2 and 3",
            "length": pytest.approx(1e-3, rel=0.2), "angle": 0.0, "ideal": "1.1mm"}  # fmt: skip
    arm = ("gen3_6dof", "--json", "-")
    commands = [("analyze", *arm, "--starts", "100", "--exact", "off", "--quiet"),
                ("explain", *arm, "--q", "0,1,1,0.3,0.4,0.5")]  # fmt: skip
    for command in commands:
        assert json.loads(run(*command).out)["robot"]["near"] == near
    exact = ("explain", "puma560", "--q", "0,0.5,1,0.3,0.4,0.5", "--json", "-")
    assert "near" not in json.loads(run(*exact).out)["robot"]


@pytest.mark.slow
def test_an_exact_arm_is_told_nothing(run) -> None:
    assert "--ideal" not in run("explain", "puma560", "--q", "0,0.5,1,0.3,0.4,0.5").out
    assert "--ideal" not in run("conditions", "puma560", "--quiet").out


@pytest.mark.slow
def test_conditions_of_the_ideal_arm_with_what_the_arm_itself_does(run, tmp_path: Path) -> None:
    target = tmp_path / "found.json"
    ended = run("conditions", "gen3", "--ideal", "13mm", "--quiet", "--full", "--json", str(target))
    record = json.loads(target.read_text(encoding="utf-8"))
    assert ended.code == exits.FINE
    text = one_line(ended.out)
    assert text.count("All this is said of the ideal arm within 13mm, not of the arm itself.") == 2
    assert "Corank 1 rank 5 of 6: 4 families" in text
    assert "Corank 2 rank 4 of 6: 4 families" in text
    assert "Corank 3 rank 3 of 6: 1 family" in text
    assert "d2 2 −12 mm 0 11.8 mm" in text
    assert "k1.f3 shoulder and wrist:" in text.partition("The arm itself there")[2]
    assert "see --ideal" not in text
    made = record["ideal"]
    assert record["robot"]["name"] == "gen3_ideal"
    assert made["real"]["name"] == "gen3"
    assert made["tolerance"]["text"] == "13mm"
    assert [(one["name"], one["after"]) for one in made["moved"]] == [("d2", 0.0), ("d4", 0.0), ("d6", 0.0)]
    assert [one["id"] for one in made["families"]] == [one["id"] for one in record["families"]]
    assert all(0 <= one["sigma"]["least"] <= one["sigma"]["most"] < 0.03 for one in made["families"])
    assert record["sentence"].endswith("not of the arm itself.")


@pytest.mark.slow
def test_analyze_a_calibrated_arm_as_its_drawing(run) -> None:
    options = ("--starts", "500", "--exact", "off", "--quiet", "--json", "-")
    ended = run("analyze", CALIBRATED, "--ideal", TOLERANCE, *options)
    record = json.loads(ended.out)
    assert [row["corank"] for row in record["families"]].count(1) == 3
    assert len(record["ideal"]["families"]) == len(record["families"])
    first = record["ideal"]["families"][0]
    assert first["number"] == 6
    assert first["points"] > 100
    assert 1e-6 < first["sigma"]["median"] < 1e-3
    assert first["distance"]["median"] < 0.01


@pytest.mark.spread(18)
@pytest.mark.slow
@pytest.mark.parametrize("typed", ["1", "-1mm", "0mm", "1mm,2mm", "9deg", "1m"])
@pytest.mark.parametrize("command", [("analyze",), ("conditions",), ("explain", "--q", "0,0,0,0,0,0"), ("report",)])
def test_what_is_no_tolerance_is_refused(run, command: tuple[str, ...], typed: str) -> None:
    first, *rest = command
    ended = run(first, "puma560", *rest, "--ideal", typed)
    assert ended.code == exits.BAD_INPUT
    assert ended.err.count("\n") == 1


def test_snap_is_gone(run) -> None:
    assert run("conditions", "gen3", "--snap", "0.013").code == exits.BAD_INPUT


@pytest.mark.by_hand
@pytest.mark.parametrize("command", [("analyze",), ("conditions",), ("explain", "--q", Q)])
def test_a_calibrated_arm_as_it_is_ends_with_an_honest_verdict(run, command: tuple[str, ...]) -> None:
    first, *rest = command
    ended = run(first, CALIBRATED, *rest, *(() if rest else ("--ideal", "off")))
    text = one_line(ended.out)
    assert ended.code in ((exits.NEAR,) if first == "explain" else (exits.FINE, exits.UNEXPLAINED))
    assert ended.err.count("internal error") == 0
    assert "--ideal 0.46mm,0.095deg" in text
    assert rest or ("Verified by" in text) is (ended.code == exits.FINE)
    assert max(map(len, ended.out.splitlines())) <= 100
    assert len(ended.out.splitlines()) < 380


@pytest.mark.by_hand
def test_many_rows_of_a_calibrated_arm_are_folded_but_for_a_few(run) -> None:
    options = ("--starts", "1000", "--exact", "off", "--ideal", "off", "--quiet")
    short, long = (run("analyze", CALIBRATED, *options, more).out for more in ("--full", "--all"))
    rows = int(one_line(short).split("Corank 2 (rank 4 of 6): ")[1].split()[0])
    assert rows > 24
    assert f"and {rows - 3} more rows, all passed their test: " in one_line(short)
    assert "All of them: --all." in one_line(short)
    assert "more rows" not in one_line(long)
    assert len(short.splitlines()) < 80 < len(long.splitlines())


PIPER = str(Path(__file__).parents[1] / "data" / "arms" / "piper_description_2.urdf")
FEW = ("--starts", "60", "--exact", "off", "--quiet", "--full")


@pytest.mark.by_hand
def test_a_file_with_an_offset_of_a_cad_export_shows_the_intended_arm_first_and_its_own_below(run) -> None:
    """The wrist of this file misses a common point by 0.088 mm; its maker's table has none."""
    out = one_line(run("analyze", PIPER, *FEW).out)
    own = out.index("The arm with the file's own numbers (--ideal off analyses it alone)")
    assert out.index("piper_ideal") < out.index("wrist: axes 4 and 6 aligned") < out.index("The arm itself there") < own
    assert "Corank 1" in out[own:]


@pytest.mark.by_hand
def test_a_calibrated_arm_shows_the_few_families_of_the_ideal_arm_and_how_far_they_are(run) -> None:
    out = one_line(run("analyze", CALIBRATED, *FEW).out)
    assert "Corank 1 (rank 5 of 6): 3 families" in out
    assert "The arm itself there" in out
    assert "the file's own numbers" not in out


@pytest.mark.slow
@pytest.mark.parametrize("given", [("--ideal", "off"), pytest.param(("--as-written",), marks=pytest.mark.by_hand)])
def test_the_numbers_of_a_file_are_analysed_where_that_is_asked_for(run, given: tuple[str, ...]) -> None:
    out = run("analyze", PIPER, *FEW, *given).out
    assert "piper_ideal" not in out
    assert "All this is said of the ideal arm" not in one_line(out)


def test_an_arm_of_the_catalogue_is_what_it_is() -> None:
    assert intended_tolerance(open_robot("gen3_6dof")) is None
    assert intended_tolerance(open_robot("gen3")) is None
    arm = open_robot(PIPER)
    assert intended_tolerance(arm).length == pytest.approx(8.9e-5)
    with_large = replace(arm, home=arm.home, joints=tuple(replace(j, screw=scaled(j, 4.0)) for j in arm.joints))
    assert intended_tolerance(with_large) is None  # four times the arm: an offset of 0.35 mm


def scaled(joint: Joint, factor: float) -> np.ndarray:
    return np.concatenate([factor * joint.screw[:3], joint.screw[3:]])


NEAR = Path(__file__).parents[1] / "data" / "near"
EXACTLY = ("conditions", "--coranks", "1", "--points", "0", "--method", "tree", "--quiet")
BY_ITSELF = "Ideal arm within 0.021mm (--ideal off: the arm as written): srs_2e-05_ideal has "


@pytest.mark.by_hand_at("command1")
@pytest.mark.slow
@pytest.mark.parametrize("command", [EXACTLY, pytest.param(("analyze", *FEW), marks=pytest.mark.slow)])
def test_both_verbs_take_the_ideal_arm_by_themselves_and_say_so_first(run, command: tuple[str, ...]) -> None:
    verb, *options = command
    assert one_line(run(verb, str(NEAR / "srs_2e-05.toml"), *options).out).startswith(BY_ITSELF)


@pytest.mark.by_hand_at("command1")
@pytest.mark.slow
@pytest.mark.parametrize("command", [EXACTLY, ("analyze", *FEW)])
def test_both_verbs_take_the_arm_as_written_where_that_is_asked_for_and_say_so_first(
    run, command: tuple[str, ...]
) -> None:
    verb, *options = command
    out = one_line(run(verb, str(NEAR / "srs_2e-05.toml"), *options, "--ideal", "off").out)
    assert out.startswith("Arm as written (--ideal 0.021mm: the ideal arm near it): ")
    assert "_ideal has" not in out


@pytest.mark.by_hand_at("given0")
@pytest.mark.slow
@pytest.mark.parametrize("given", [(), ("--ideal", "0.44mm")])
def test_an_arm_that_misses_structure_by_half_a_millimetre_is_verified_as_it_is_and_as_the_ideal_one(
    run, given: tuple[str, ...]
) -> None:
    """Configurations with a small σ are followed with 50 digits, and every root of a set belongs to its row."""
    ended = run("conditions", str(NEAR / "elbow_0mm44.toml"), "--quiet", *given)
    text = one_line(ended.out)
    assert ended.code == exits.FINE
    assert "Contradicted" not in text
    assert "smallest σ inf" not in text
    assert text.startswith("Ideal arm within 0.44mm" if given else "Arm as written (--ideal 0.44mm")


@pytest.mark.slow
def test_an_analysis_of_the_ideal_arm_is_refused_for_the_arm_itself_with_the_option_that_takes_it(
    run, tmp_path: Path
) -> None:
    """`analyze` takes the ideal arm of its own accord, `explain` does not: the error said "about another arm" alone."""
    arm, saved, q = str(NEAR / "srs_2e-05.toml"), str(tmp_path / "arm.json"), "0.1,1,0.2,1,0.3,0.4,0.5"
    run("analyze", arm, "--starts", "30", "--exact", "off", "--quiet", "--json", saved)
    ended = run("explain", arm, "--q", q, "--analysis", saved)
    assert ended.code == exits.BAD_INPUT
    assert "fix: --ideal 0.021mm, or analyze the arm as written: analyze --ideal off" in ended.err
    assert run("explain", arm, "--q", q, "--analysis", saved, "--ideal", "0.021mm").code != exits.BAD_INPUT
