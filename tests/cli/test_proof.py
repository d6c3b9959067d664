"""`rankdrop verify` and --certificate: what holds ends with 0, what does not with 3, what is none with 2."""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator

from rankdrop.cli.main import run
from rankdrop.proof.record import with_hash
from rankdrop.schema import load_schema

NEAREST = ["nearest", "planar3r", "--q", "0.3,1.2,0.4", "--evaluations", "2000", "--quiet"]


@pytest.fixture
def ball(tmp_path, capsys):
    place = tmp_path / "ball.json"
    assert run([*NEAREST, "--certificate", str(place)]) == 0
    assert "certificate  no singularity within 1." in capsys.readouterr().out
    return place


def test_what_is_proven_holds(ball, tmp_path, capsys):
    assert run(["verify", str(ball), "--quiet"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Holds  ball of 'planar3r'")
    assert "has a rank below 3" in " ".join(out.split())
    assert run(["verify", str(ball), "--robot", "planar3r", "--json", str(tmp_path / "v.json")]) == 0
    record = json.loads((tmp_path / "v.json").read_text())
    Draft202012Validator(load_schema("verified")).validate(record)
    assert record["holds"]
    assert run(["verify", str(ball), "--robot", "ur5"]) == 3
    assert "another arm" in capsys.readouterr().out


def test_a_claim_is_compared_with_what_is_named(ball, tmp_path, capsys):
    asked = ["verify", str(ball), "--quiet", "--robot", "planar3r"]
    assert run([*asked, "--q", "0.3,1.2,0.4", "--task", "planar"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "q = (0.3, 1.2, 0.4)" in out
    assert "task 'planar': vx, vy, wz" in out
    for other in (["--q", "0.3,1.1,0.4"], ["--task", "planar-position"], ["--limits"]):
        assert run([*asked, *other]) == 3
        assert "another claim: the certificate is about" in " ".join(capsys.readouterr().out.split())
    assert run(["verify", str(ball), "--q", "0.3,1.2,0.4"]) == 2
    assert "--robot" in capsys.readouterr().err
    rows, place = tmp_path / "p.csv", str(tmp_path / "p.json")
    rows.write_text("0.1,0.9\n0.3,0.5\n")
    assert run(["path", "planar2r", str(rows), "--certificate", place, "--quiet"]) == 0
    about = ["verify", place, "--robot", "planar2r", "--quiet", "--path", str(rows)]
    assert run(about) == 0
    assert f"2 control points with {rows.name!r} (SHA-256" in " ".join(capsys.readouterr().out.split())
    rows.write_text("0.1,0.9\n0.3,0.4\n")
    assert run(about) == 3
    assert "a path through other rows than those of the file" in " ".join(capsys.readouterr().out.split())


def test_what_was_changed_does_not(ball, capsys):
    record = json.loads(ball.read_text())
    record["claim"]["radius"] *= 1.1
    ball.write_text(json.dumps(record))
    assert run(["verify", str(ball)]) == 3
    assert "hash" in capsys.readouterr().out
    ball.write_text(json.dumps(with_hash(record)))
    assert run(["verify", str(ball)]) == 3
    assert "do not reach" in capsys.readouterr().out
    ball.write_text(ball.read_text()[:-200])
    assert run(["verify", str(ball)]) == 3
    assert "cut off" in capsys.readouterr().out


def test_what_is_no_certificate_is_bad_input(tmp_path, capsys):
    (tmp_path / "other.json").write_text("{}")
    assert run(["verify", str(tmp_path / "other.json")]) == 2
    assert run(["verify", str(tmp_path / "missing.json")]) == 2
    assert run(["verify", str(tmp_path)]) == 2
    assert "no certificate" in capsys.readouterr().err


def test_a_singular_place_is_certified_to_exist(tmp_path, capsys):
    place = str(tmp_path / "there.json")
    assert run(["explain", "puma560", "--q", "0.1,0.5,0.4,0.2,0,0.6", "--certificate", place, "--json",
                str(tmp_path / "e.json")]) == 4  # fmt: skip
    capsys.readouterr()
    assert run(["verify", place]) == 0
    assert "a configuration of rank below 6 exists" in " ".join(capsys.readouterr().out.split())


@pytest.mark.by_hand
def test_a_path_and_a_covering_are_certified(tmp_path, capsys):
    rows, place = tmp_path / "p.csv", str(tmp_path / "p.json")
    rows.write_text("0.1,-0.9,1.0,0.4,-0.6,0.2\n0.3,-0.6,1.2,0.1,-0.9,0.0\n")
    assert run(["path", "ur5", str(rows), "--certificate", place, "--model-tolerance", "0.3mm,1mrad"]) == 0
    assert "1 mrad of this one, joint by joint: proven" in " ".join(capsys.readouterr().out.split())
    assert run(["verify", place, "--robot", "ur5", "--path", str(rows)]) == 0
    assert "every arm within 0.0003 m" in " ".join(capsys.readouterr().out.split())
    assert run(["path", "ur5", str(rows), "--model-tolerance", "80mrad", "--quiet"]) == 3
    cover, place = str(tmp_path / "c.cover"), str(tmp_path / "c.json")
    asked = ["cover", "planar3r", "--width", "0.2", "--no-explain", "--certificate", place]
    assert run(asked) == 2
    assert run([*asked, "--out", cover]) in (0, 3)
    assert run(["verify", place]) == 0
    assert run(["verify", place, "--sample", "2"]) == 3
    assert "not checked" in " ".join(capsys.readouterr().out.split())


def test_a_ball_for_near_arms_is_told(capsys):
    asked = ["nearest", "ur5", "--q", "0.3,-0.8,1.2,0.4,0.9,0.1", "--evaluations", "1000", "--quiet"]
    assert run([*asked, "--model-tolerance", "0.3mm,1mrad"]) == 0
    assert "for every arm within 0.3 mm and 1 mrad" in " ".join(capsys.readouterr().out.split())
    assert run([*asked, "--model-tolerance", "wide"]) == 2
    assert "--model-tolerance" in capsys.readouterr().err


@pytest.mark.slow
def test_exact_configurations_are_drawn(tmp_path, capsys):
    place = tmp_path / "x.csv"
    assert run(["find", "ur5", "--corank", "1", "--method", "reciprocal", "--starts", "100", "--out", str(place)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "100 exact singular configurations" in out
    assert "no covering" in out
    assert len(place.read_text().splitlines()) == 101
    assert run(["find", "ur5", "--corank", "2", "--method", "reciprocal", "--starts", "20"]) == 0
    assert "corank 2 or more" in " ".join(capsys.readouterr().out.split())
    assert run(["find", "ur5", "--corank", "1", "--method", "reciprocal", "--start", "5"]) == 2
