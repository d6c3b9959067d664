"""`rankdrop path`: exit codes, files of every kind, folders, what is written, and errors of one line."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cli.path_files import FREE, saved
from jsonschema import Draft202012Validator
from patience import until

from rankdrop.cli import main
from rankdrop.schema import load_schema

CROSSING = [[0.3, 0.4, 0.1], [0.5, -0.2, 0.3]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    def once(*argv: object) -> tuple[int, str, str]:
        monkeypatch.setenv("COLUMNS", "120")
        capsys.readouterr()
        arm = [] if argv and argv[0] == "--status" else ["planar3r"]
        code = main.run(["path", *arm, *map(str, argv), "--quiet"])
        return (code, *capsys.readouterr())

    return once


@pytest.mark.by_hand
def test_crossings_take_fifteen_lines_and_the_whole_forty(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At 80 columns, for two crossings that are described, and for 40 that are listed; --full prints each of them."""
    turn = np.sin(np.linspace(0.0, 40.0 * np.pi, 2001))[:, None]
    base = np.array([0.3, -1.2, 1.4, -1.0, 0.0, 0.4])
    for rows, most in ((150, 2), (2001, 40)):
        file = saved(tmp_path, "q.npy", base + turn[40:rows] * [0.1, 0.1, 0.1, 0.1, 0.3, 0.1])
        outputs = {}
        for option in ((), ("--full",)):
            assert main.run(["path", "ur5e", str(file), "--quiet", *option]) == 3
            outputs[option] = capsys.readouterr().out
        lines = outputs[()].splitlines()
        title = lines.index("Singularities on the path")
        assert title <= 16  # the verdict, with a remedy or why there is none
        assert len(lines) - title - 1 <= 15
        assert len(lines) <= 40
        assert max(map(len, lines)) <= 80
        assert ("--full describes each" in outputs[()]) == (most > 2)
        assert outputs[("--full",)].count("how: ") >= most - 1


@pytest.mark.slow
def test_exit_codes_tell_free_from_crossing(tmp_path: Path, run) -> None:
    code, out, _ = run(saved(tmp_path, "free.npy", FREE))
    assert code == 0
    assert out.startswith("Free: proven for every point of the path")
    code, out, _ = run(saved(tmp_path, "bad.npy", CROSSING))
    assert code == 3
    assert out.startswith("Crosses a singularity once (proven), first elbow")
    code, out, _ = run(tmp_path / "free.npy", "--min-distance", "20deg")
    assert (code, "farther than 0.3491 rad (20°) from any" in " ".join(out.split())) == (0, True)
    code, out, _ = run(tmp_path / "free.npy", "--min-distance", "0.6")
    assert (code, out.startswith("Comes nearer than 0.6")) == (3, True)


@pytest.mark.by_hand_at("0.05-False")
@pytest.mark.slow
@pytest.mark.parametrize(("seconds", "says"), [(2.0, True), (0.05, False)])
def test_a_joint_path_that_crosses_within_its_rates_may_do_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], seconds: float, says: bool
) -> None:
    """Joint 5 of the IRB 120 turns by 0.8 rad through 0; at 0.4 rad/s it is 7 % of its limit of 5.59 rad/s."""
    rows = f"time,q1,q2,q3,q4,q5,q6\n0,0,0.3,0.2,0,-0.4,0\n{seconds},0,0.3,0.2,0,0.4,0\n"
    (tmp_path / "joints.csv").write_text(rows, encoding="utf-8")
    main.run(["path", "irb120", str(tmp_path / "joints.csv"), "--quiet"])
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("Crosses a singularity once (proven)")
    assert ("Next: as a joint move nothing needs to be done: it keeps its rates (largest: 7.2 %);" in told) is says


@pytest.mark.slow
def test_of_a_joint_path_without_times_the_rates_are_not_known(tmp_path: Path, run) -> None:
    _, out, _ = run(saved(tmp_path, "bad.npy", CROSSING))
    assert "Next: a joint move may cross; its rates are not known;" in " ".join(out.split())


@pytest.mark.slow
def test_what_is_written_satisfies_the_schemas(tmp_path: Path, run) -> None:
    one, two = saved(tmp_path, "a.npy", CROSSING), saved(tmp_path, "b.npy", FREE)
    code, out, _ = run(one, "--json", tmp_path / "one.json", "--figure", tmp_path / "one.svg")
    assert code == 3
    record = json.loads((tmp_path / "one.json").read_text())
    Draft202012Validator(load_schema("path")).validate(record)
    assert record["crossings"][0]["touching"] is False
    assert "<svg" in (tmp_path / "one.svg").read_text()[:1000]
    code, out, _ = run(two, one, "--json", "-")
    assert code == 3
    many = json.loads(out)
    Draft202012Validator(load_schema("paths")).validate(many)
    assert [part["verdict"] for part in many["paths"]] == ["crossing", "free"]


def test_a_folder_is_a_table_and_a_broken_file_does_not_stop_it(tmp_path: Path, run) -> None:
    saved(tmp_path, "a.npy", FREE)
    saved(tmp_path, "b.npy", CROSSING)
    code, out, _ = run(tmp_path)
    assert code == 3
    assert out.startswith("1 of 2 paths proven free")
    (tmp_path / "c.csv").write_text("q1,q2,q3\n0,nan,0\n")
    code, out, _ = run(tmp_path)
    assert code == 2
    assert "bad input" in out
    assert "c.csv, line 2, column 2 (q2): the value is not finite" in " ".join(out.split())


def programs(folder: Path, count: int = 12) -> Path:
    """Files of 2,000 rows, one of them broken, one with a column that is not used."""
    folder.mkdir()
    rng = np.random.default_rng(3)
    for k in range(count):
        q = rng.uniform(-2, 2, 3) + np.linspace(0, 1, 2000)[:, None] * rng.normal(size=3)
        head = "q1,q2,q3,gripper" if k == 1 else "q1,q2,q3"
        q = np.column_stack([q, q[:, 0]]) if k == 1 else q
        np.savetxt(folder / f"{k:02}.csv", q, delimiter=",", header=head, comments="")
    (folder / "00.csv").write_text("q1,q2,q3\n0,nan,0\n")
    return folder


@pytest.mark.by_hand
def test_many_paths_are_the_same_here_in_processes_and_after_a_kill(
    tmp_path: Path, run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    programs(tmp_path / "all")
    code, plain, err = run("all", "--json", "one.json")
    assert code == 2
    assert "01.csv: not used: gripper" in err
    assert run("all", "--json", "two.json", "--workers", "2", "--out", "judged")[:2] == (code, plain)
    wanted = (tmp_path / "one.json").read_bytes()
    assert (tmp_path / "two.json").read_bytes() == wanted
    parts = {part.name: part.read_bytes() for part in (tmp_path / "judged" / "parts").iterdir()}
    assert len(parts) == 12

    words = ("path", "planar3r", "all", "--json", "three.json", "--workers", "1", "--out", "killed", "--quiet")
    process = subprocess.Popen([sys.executable, "-m", "rankdrop", *words], stdout=subprocess.DEVNULL)
    journal = tmp_path / "killed" / "journal"
    until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 2)
    process.kill()
    process.wait()
    made = {part.name: part.stat().st_mtime_ns for part in (tmp_path / "killed" / "parts").iterdir()}
    done, told, _ = run("--status", "killed")
    assert done == 0
    assert " of 12 chunks of the paths (12 items in all)" in told
    assert run("all", "--json", "three.json", "--workers", "2", "--out", "killed")[:2] == (code, plain)
    assert (tmp_path / "three.json").read_bytes() == wanted
    killed = tmp_path / "killed" / "parts"
    assert {part.name: part.read_bytes() for part in killed.iterdir()} == parts
    kept = [name for name, when in made.items() if (killed / name).stat().st_mtime_ns == when]
    assert len(kept) >= 2, "finished paths were judged again"
    assert run("--status", "killed")[1] == "finished: 12 of 12 chunks of the paths (12 items in all)\n"

    (tmp_path / "all" / "03.csv").write_text("q1,q2,q3\n0,1,0\n")
    code, _, err = run("all", "--out", "killed")
    assert code == 2
    assert "killed: the folder holds another job" in err


@pytest.mark.slow
def test_a_cluster_judges_many_paths_alike(tmp_path: Path, run, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    programs(tmp_path / "all", 4)
    code, plain, _ = run("all")
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=":0") as cluster:
        assert run("all", "--scheduler", cluster.scheduler_address)[:2] == (code, plain)


def test_degrees_read_as_radians_are_refused_with_their_row(tmp_path: Path, run) -> None:
    file = tmp_path / "deg.csv"
    file.write_text("q1,q2,q3\n0,4,5\n10,60,5\n")
    code, out, err = run(file)
    assert (code, out) == (2, "")
    line = f'{file}, row 2: angles look like degrees; got 60; allowed: radians; fix: add --deg, or name the column "'
    assert err.startswith(f"rankdrop: error: {line}")
    assert len(err.splitlines()) == 1
    assert run(file, "--deg")[::2] == (0, "")


@pytest.mark.by_hand
def test_radians_stated_in_the_file_are_only_warned_of(tmp_path: Path, run) -> None:
    file = tmp_path / "rad.csv"
    file.write_text("q1 [rad],q2 [rad],q3 [rad]\n0,40,5\n10,60,5\n")
    code, _, err = run(file)
    assert code != 2
    assert "warning: rad.csv: angles up to 60 look like degrees" in err


@pytest.mark.by_hand
def test_remedies_are_printed_written_and_judged_again(tmp_path: Path, run) -> None:
    bad = saved(tmp_path, "bad.npy", [*CROSSING, [0.9, 0.5, 0.3]])
    code, out, err = run(bad, "--blend", "10mm", "--base-shift", "50mm", "--fixed", tmp_path / "good.csv",
                         "--json", tmp_path / "bad.json")  # fmt: skip
    assert code == 3  # of the path as it is
    assert "Remedies: detour, blend, base shift (checked again: free, proven)." in out
    assert "flip: 1 tried" in out
    assert "good.csv: mended by detour, checked again: free" in " ".join(err.split())
    record = json.loads((tmp_path / "bad.json").read_text())
    Draft202012Validator(load_schema("path")).validate(record)
    assert [one["kind"] for one in record["remedies"]["found"]] == ["detour", "blend", "base shift"]
    described = load_schema("path")["$defs"]
    assert set(record["remedies"]) == set(described["remedies"]["properties"])
    assert set(record["remedies"]["found"][0]) == set(described["found"]["properties"])
    np.testing.assert_array_equal(
        record["remedies"]["found"][0]["trajectory"]["q"],
        np.loadtxt(tmp_path / "good.csv", delimiter=",", skiprows=1, ndmin=2),
    )
    assert run(tmp_path / "good.csv", "--deg")[0] == 0  # units stand in the file
    code, out, err = run(tmp_path / "good.csv", "--remedies", "--fixed", tmp_path / "none.csv")
    assert code == 0
    assert "none is needed" in out
    assert "is not written" in err
    assert not (tmp_path / "none.csv").exists()


@pytest.mark.by_hand
def test_interrupted_remedies_keep_what_is_done(tmp_path: Path, run, monkeypatch: pytest.MonkeyPatch) -> None:
    bad = saved(tmp_path, "bad.npy", [*CROSSING, [0.9, 0.5, 0.3]])

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("rankdrop.path.mend.mend.shifts", stop)
    code, out, err = run(bad, "--blend", "10mm", "--base-shift", "50mm", "--fixed", tmp_path / "good.csv")
    assert code == 130
    assert "Remedies: detour, blend (checked again: free, proven), interrupted: not all kinds were tried." in out
    assert "interrupted: what was proven so far holds" in " ".join(err.split())
    assert (tmp_path / "good.csv").exists()


REFUSED = {
    "no file is named": (),
    "missing.csv": ("missing.csv",),
    "--interpolate linear": ("free.npy", "--interpolate", "cubic"),
    "the ending names no format": ("free.npy", "--figure", "a.gif"),
    "--figure: this option is for one path": ("free.npy", "free.npy", "--figure", "a.svg"),
    "--html: this option is for one path": ("free.npy", "--html", "a.html", "--out", "judged"),
    "nowhere: there is no job in the folder": ("--status", "nowhere"),
    "--min-distance": ("free.npy", "--min-distance", "-1"),
    "--remedies: this option is for one path": ("free.npy", "free.npy", "--remedies"),
    "--tool-tilt": ("free.npy", "--tool-tilt", "10mm"),
    "--base-shift": ("free.npy", "--base-shift", "-1mm"),
    "--acceleration": ("free.npy", "--acceleration", "0"),
    "--fixed: the ending": ("free.npy", "--fixed", "a.xls"),
}


@pytest.mark.spread(12)
@pytest.mark.slow
@pytest.mark.parametrize("said", REFUSED)
def test_bad_input_is_one_line(tmp_path: Path, run, said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    saved(tmp_path, "free.npy", FREE)
    code, out, err = run(*REFUSED[said])
    assert (code, out) == (2, "")
    assert said in err
    assert len(err.strip().splitlines()) == 1


def test_a_free_path_near_a_singularity_says_so_where_it_has_no_times(run, tmp_path: Path) -> None:
    """0.02° from the shoulder of an xArm 7 the first word was "Free" alone."""
    near, far = [[0.0, 0.01, 0.4], [0.1, 0.01, 0.4]], [[0.0, 0.6, 0.4], [0.1, 0.6, 0.4]]
    said = "but 0.01 rad (0.573°) from a singularity; without times joint rates are not checked"
    code, out, _ = run(saved(tmp_path, "near.npy", near))
    assert code == 0
    assert said in " ".join(out.split())
    _, out, _ = run(saved(tmp_path, "far.npy", far))
    assert "without times" not in out
