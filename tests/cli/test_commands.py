"""The commands: exit codes, what goes to stdout, what goes to stderr."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import rankdrop
from rankdrop.cli import exits
from rankdrop.results.analysis import Analysis
from rankdrop.robot.open import robot_names
from rankdrop.schema import load_schema

SMALL = ("--starts", "200", "--quiet")


def test_an_explained_arm_ends_with_zero_and_its_table(run) -> None:
    ended = run("analyze", "scara", "--full", *SMALL)
    assert ended.code == exits.FINE
    assert ended.err == ""
    assert re.search(r"Corank 1 \(rank 3 of 4\): 1 family, ([\d,]+) of \1 test points explained\n", ended.out)
    assert "are singular (σ ≤" in " ".join(ended.out.split())
    assert "Time taken:" in ended.out


def test_what_was_assumed_is_printed(run) -> None:
    for ended in (run("analyze", "scara", "--full", *SMALL), run("find", "scara", "--corank", "1", *SMALL)):
        text = " ".join(ended.out.split())
        assert "4 joints from base to tip" in text
        assert "task scara (4 rows), rank 4, redundancy 0" in text
        assert "length scale" in text
        assert "the arm's reach" in text
        assert "in the whole joint space (limits ignored), seed 0" in text


def test_options_reach_the_analysis(run) -> None:
    ended = run(
        "analyze", "scara", "--task", "position", "--length-scale", "1", "--seed", "7", "--limits", *SMALL,
        "--json", "-",
    )  # fmt: skip
    record = json.loads(ended.out)
    assert record["robot"]["task"] == "position"
    assert record["settings"]["length_scale"] == 1.0
    assert (record["settings"]["seed"], record["settings"]["starts"], record["settings"]["limits"]) == (7, 200, True)


@pytest.mark.slow
def test_json_on_stdout_is_valid_and_alone(process) -> None:
    ended = process("analyze", "scara", "--starts", "200", "--json", "-")
    assert ended.code == exits.FINE
    Draft202012Validator(load_schema("analysis")).validate(json.loads(ended.out))


def test_json_in_a_file_is_the_same_for_any_number_of_threads(run, tmp_path: Path) -> None:
    texts = []
    for threads in ("1", "2"):
        path = tmp_path / f"{threads}.json"
        out = run("analyze", "scara", "--threads", threads, "--json", str(path), *SMALL).out
        assert out.startswith("scara has 1 family of singularities: elbow (rank 3).\nVerified by ")
        texts.append(path.read_bytes())
    assert texts[0] == texts[1]
    assert Analysis.load(tmp_path / "1.json").robot.name == "scara"


def test_unexplained_points_end_with_three(run, shapes: Analysis, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rankdrop, "analyze", lambda *args, **options: shapes)
    ended = run("analyze", "pa10")
    assert ended.code == exits.UNEXPLAINED
    assert ended.out.startswith("Incomplete: ")


@pytest.mark.spread(19)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("analyze",), "ROBOT"),
        (("analyze", "pa11"), "pa10"),
        (("analyze", "nowhere.urdf"), "no such file"),
        (("analyze", "pa10", "--task", "flying"), "planar-position"),
        (("analyze", "pa10", "--starts", "0"), "1 … 10000000"),
        (("analyze", "pa10", "--starts", "many"), "--starts"),
        (("analyze", "pa10", "--length-scale", "-1"), "a length scale so far"),
        (("analyze", "pa10", "--colour", "red"), "--length-scale"),
        (("analyze", "pa10", "ur5"), "unexpected argument ur5"),
        (("analyze", "pa10", "--tip", "flange"), "tip"),
        (("analyze", "pa10", "--package", "arm"), "NAME=PATH"),
        (("analyze", "pa10", "--package", "arm=/no/such/folder"), "no such folder"),
        (("analyze", "pa10", "--json", "/no/such/folder/a.json"), "no such folder"),
        (("analyze", "pa10", "--json", "/"), "it is a folder"),
        (("find", "pa10"), "--corank"),
        (("find", "pa10", "--corank", "9"), "1 … 6"),
        (("find", "pa10", "--corank", "1", "--method", "magic"), "almarkhi"),
        (("find", "pa10", "--corank", "1", "--out", "a.xls"), ".csv, .json, .npz"),
        (("find", "pa10", "--corank", "1", "--history", "a.json"), ".csv, .npz"),
        (("find", "pa10", "--corank", "1", "--step", "0.5"), "gradient and almarkhi"),
        (("find", "pa10", "--corank", "1", "--method", "gradient", "--step", "2.5"), "0 … 2"),
        (("find", "pa10", "--corank", "1", "--start", "1,2"), "7 joint values are needed"),
        (("find", "pa10", "--corank", "1", "--start", "0"), "no random start has this number"),
        (("find", "pa10", "--corank", "1", "--tie", "2"), "0 … 1"),
        (("find", "pa10", "--corank", "1", "--iterations", "0"), "1 … 1000000"),
        (("fly",), "analyze, explain, path, report"),
    ],
)
def test_bad_input_is_one_line_that_names_what_is_allowed(run, argv: tuple[str, ...], words: str) -> None:
    ended = run(*argv)
    assert ended.code == exits.BAD_INPUT
    assert ended.out == ""
    assert ended.err.startswith("rankdrop: error: ")
    assert ended.err.count("\n") == 1
    assert words in ended.err


def test_version_is_the_installed_one(run) -> None:
    from importlib.metadata import version

    assert run("--version").out.strip() == run("version").out.strip() == version("rankdrop")


@pytest.mark.parametrize("argv", [(), ("analyze",), ("find",), ("robots",)])
def test_every_help_has_an_example(run, argv: tuple[str, ...]) -> None:
    ended = run(*argv, "--help")
    assert ended.code == exits.FINE
    assert "For example:" in ended.out
    assert f"rankdrop {' '.join(argv)}" in ended.out.split("For example:")[1]


def test_robots_lists_the_catalogue(run) -> None:
    text = run("robots").out
    assert all(name in text for name in robot_names())
    listed = json.loads(run("robots", "--json").out)
    assert [entry["name"] for entry in listed] == list(robot_names())
    assert all(entry["n"] > 0 and entry["source"] for entry in listed)
    makers = [line.strip() for line in text.splitlines() if line and not line.startswith(" ")]
    assert makers.index("ABB") < makers.index("KUKA") < makers.index("Yaskawa") < makers.index("Documents")


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_find_shows_and_saves_the_same_configurations(run, tmp_path: Path) -> None:
    paths = [tmp_path / f"found.{ending}" for ending in ("csv", "json", "npz")]
    for path in paths:
        ended = run("find", "ur5", "--corank", "1", "--out", str(path), "--starts", "50", "--quiet")
        assert ended.code == exits.FINE
        assert "Corank 1 (rank 5 of 6): 50 of 50 starts converged" in ended.out
    rows = table(paths[0])
    record = json.loads(paths[1].read_text(encoding="utf-8"))
    with np.load(paths[2]) as archive:
        arrays = dict(archive)
    Draft202012Validator(load_schema("find")).validate(record)
    q = np.array([one["q"] for one in record["configurations"]])
    assert q.shape == (50, 6)
    np.testing.assert_array_equal(q, arrays["q"])
    np.testing.assert_array_equal(q, [[float(row[f"q{j}"]) for j in range(1, 7)] for row in rows])
    assert max(float(row["sigma6"]) for row in rows) <= 1e-9
    assert record["counts"]["converged"] == 50


def test_history_holds_every_iteration(run, tmp_path: Path) -> None:
    for ending in ("csv", "npz"):
        ended = run(
            "find", "pa10", "--corank", "2", "--method", "almarkhi", "--starts", "8", "--quiet",
            "--history", str(tmp_path / f"history.{ending}"), "--out", str(tmp_path / "found.csv"),
        )  # fmt: skip
        assert ended.code == exits.FINE
    rows = table(tmp_path / "history.csv")
    found = table(tmp_path / "found.csv")
    for start in found:
        steps = [row for row in rows if row["start"] == start["start"]]
        assert len(steps) == int(start["iterations"]) + 1
        assert float(steps[-1]["sigma5"]) == pytest.approx(float(start["sigma5"]), abs=1e-12)
    with np.load(tmp_path / "history.npz") as history:
        assert history["sigma"].shape[0] == 8


def test_a_find_of_nothing_is_no_proof(run) -> None:
    ended = run("find", "pa10", "--corank", "4", "--starts", "50", "--quiet")
    assert ended.code == exits.FINE
    assert "0 of 50 starts converged" in ended.out
    assert "Not finding one proves nothing." in " ".join(ended.out.split())


def test_a_file_is_written_whole_or_not_at_all(run, tmp_path: Path) -> None:
    path = tmp_path / "kept.json"
    path.write_text("old", encoding="utf-8")
    assert run("find", "pa10", "--corank", "9", "--json", str(path)).code == exits.BAD_INPUT
    assert path.read_text(encoding="utf-8") == "old"
    assert run("find", "pa10", "--corank", "1", "--json", str(path), "--starts", "5", "--quiet").code == exits.FINE
    assert json.loads(path.read_text(encoding="utf-8"))["schema"] == "rankdrop/find/1"
    assert [item.name for item in tmp_path.iterdir()] == ["kept.json"]


@pytest.mark.slow
def test_output_is_plain_when_it_is_not_a_terminal(process) -> None:
    ended = process("find", "pa10", "--corank", "1", "--starts", "50")
    assert "\x1b" not in ended.out + ended.err
    assert ended.err == ""


@pytest.mark.slow
def test_a_terminal_without_unicode_gets_letters(process) -> None:
    ended = process("analyze", "scara", *SMALL, **{**os.environ, "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"})
    assert ended.code == exits.FINE
    assert ended.out.isascii()
    assert "q2" in ended.out
    assert "0, pi" in ended.out


@pytest.mark.slow
def test_a_reader_that_has_gone_is_no_error() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([sys.executable, "-m", "rankdrop.cli.main", "robots"], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert done.returncode == exits.BROKEN_PIPE
    assert done.stderr == b""


def test_a_start_can_be_given_in_degrees(run, tmp_path: Path) -> None:
    path = tmp_path / "one.csv"
    ended = run("find", "planar2r", "--corank", "1", "--deg", "--start", "-10, 170", "--out", str(path), "--quiet")
    assert ended.code == exits.FINE
    q = path.read_text(encoding="utf-8").splitlines()[1].split(",")[3:5]
    assert [float(value) for value in q] == pytest.approx([np.radians(-10), np.pi], abs=1e-6)


def test_stuck_on_a_crease_is_not_a_near_miss(run) -> None:
    ended = run("find", "pa10", "--corank", "2", "--length-scale", "1", "--seed", "2", "--start", "106", "--method",
                "gradient", "--step", "0", "--quiet")  # fmt: skip
    assert "0 near misses, 1 stuck on a crease (a tie, no minimum), 0 slow." in " ".join(ended.out.split())


@pytest.mark.slow
def test_tolerant_prints_the_known_optimum_and_saves_it(run, tmp_path: Path) -> None:
    path = tmp_path / "tolerant.json"
    ended = run("tolerant", "almarkhi4", "--relative", "--length-scale", "1", "--starts", "40", "--json", str(path),
                "--quiet")  # fmt: skip
    assert ended.code == exits.FINE
    assert "Best worst case: σ3 left / σ1 = 0.5" in ended.out
    assert "none is better" in " ".join(ended.out.split())
    record = json.loads(path.read_text(encoding="utf-8"))
    Draft202012Validator(load_schema("tolerant")).validate(record)
    assert record["optimal"] is True


def test_tolerant_ends_with_3_where_a_joint_is_always_needed(run) -> None:
    ended = run("tolerant", "pa10", "--quiet")
    assert ended.code == exits.UNEXPLAINED
    assert "without joint 4 the rank is below 6 at every configuration" in " ".join(ended.out.split())


@pytest.mark.slow
def test_analyze_within_limits_tells_values_inside_and_shares(run) -> None:
    ended = run("analyze", "panda", "--limits", "--starts", "1500", "--exact", "off", "--quiet", "--full")
    told = " ".join(ended.out.split())
    assert "3.3614" in told
    assert "2.9218" not in told
    assert "Within 5° of singularities share of the joint space inside the limits" in told
    small = ("--starts", "100", "--exact", "off", "--quiet", "--full")
    off = run("analyze", "planar2r", "--limits", "--within", "0", *small)
    assert "Within" not in off.out
    wide = run("analyze", "planar2r", "--within", "0.1", *small)
    assert "Within 5.73° of singularities share of the joint space, distance over all" in " ".join(wide.out.split())
    assert run("analyze", "planar2r", "--within", "2").code == exits.BAD_INPUT
