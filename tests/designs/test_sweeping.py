"""A sweep: what every variant has, what differs between neighbours, and the same result however it is run."""

from __future__ import annotations

import json
import re
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from closed_schema import closed
from jsonschema import Draft202012Validator

import rankdrop
from rankdrop.cli import main
from rankdrop.cli.design import CompareOptions
from rankdrop.codec import json_text
from rankdrop.designs import Designs, compare, write_tables
from rankdrop.designs.measure import families_of, measure_arm
from rankdrop.designs.ranking import APPEARS, JOIN, SPLITS, VANISHES, changes, key_of, keys_of, neighbours, rank
from rankdrop.designs.spec import question_of, spec_of
from rankdrop.designs.sweeping import order_of, variants_of
from rankdrop.distance.share import slower_than
from rankdrop.errors import OptionError
from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.problem import Problem
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.drawing import Drawing
from rankdrop.robot.model import JointKind
from rankdrop.schema import load_schema
from rankdrop.task import resolve_task
from rankdrop.text.designs import error_text, measure_cell

SHIFTS = [0.31, 0.6, 1.2]
SPEC: dict[str, Any] = {
    "robot": "anthropomorphic",
    "parameters": {"shift": {"sets": "1.a", "values": SHIFTS}},
    "families": {"starts": 100, "fresh": 100},
}
ELBOW = "k1, dim 5: θ3 = 0°, 180°"
SHOULDER = "k1, dim 5: joints 2, 3 coupled"


@pytest.fixture(scope="module")
def shifted() -> Designs:
    """The elbow arm whose shoulder is moved out: a1 + a2 c2 + d4 c23 = 0 is real while |a1| ≤ a2 + d4 = 0.9 m."""
    return rankdrop.sweep(SPEC, workers=1)


@pytest.mark.by_hand
def test_a_family_that_vanishes_is_told_with_the_place(shifted: Designs) -> None:
    assert shifted.holds
    keys = [keys_of(one) for one in shifted.records]
    assert [SHOULDER in one for one in keys] == [True, True, False]  # type: ignore[operator]
    assert all(ELBOW in one for one in keys)  # type: ignore[operator]
    told = [one for one in shifted.changes if one.kind == VANISHES and one.before == (SHOULDER,)]
    assert [(one.parameter, one.low, one.high) for one in told] == [("shift", 0.6, 1.2)]
    assert "shift: 0.6 m and 1.2 m" in str(shifted)


@pytest.mark.by_hand
def test_exact_conditions_tell_where_in_parameter_space(shifted: Designs) -> None:
    told = {one["variant"]: one for one in shifted.exact}
    assert told[1]["letters"] == pytest.approx({"a1": 0.31, "a2": 0.5, "d4": 0.4})
    real = {family["real"] for family in told[1]["families"]}
    assert "real if and only if −(a1 − a2 − d4) (a1 + a2 + d4) ≥ 0" in real
    assert any("does not hold" in text for text in told[3]["not_real"])


@pytest.mark.by_hand
def test_families_are_those_of_an_analysis_from_nothing(shifted: Designs) -> None:
    drawing = Drawing.of("anthropomorphic")
    place = drawing.place("1.a", "here")
    for shift, record in zip(SHIFTS, shifted.records, strict=True):
        robot = drawing.robot({place: shift})
        alone = rankdrop.analyze(robot, starts=300, exact="off", threads=1)
        mine = sorted((one["corank"], one["dimension"], one["name"]) for one in record["families"])
        assert mine == sorted((one.corank, one.dimension, one.name) for one in alone.families)
        for one in record["families"]:
            sigma = singular_values(robot, np.array(one["witness"]), resolve_task(None, robot))
            assert sigma[6 - one["corank"]] <= 1e-9
            assert one["sound"][0] == one["sound"][1] > 0


@pytest.mark.by_hand
def test_the_result_is_the_same_on_two_workers_and_from_a_folder(
    planar: tuple[Path, Designs], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, found = planar
    monkeypatch.setattr("rankdrop.designs.sweeping.SIZE", 2)
    out = tmp_path / "out"
    assert rankdrop.sweep(file, workers=2, out=out).to_dict() == found.to_dict()
    whole = {path.name: path.read_bytes() for path in (out / "parts").iterdir()}
    assert len(whole) == 2
    lines = (out / "journal").read_text().splitlines(keepends=True)
    (out / "journal").write_text(lines[0])
    assert rankdrop.sweep(file, workers=1, out=out).to_dict() == found.to_dict()
    assert {path.name: path.read_bytes() for path in (out / "parts").iterdir()} == whole


@pytest.mark.slow
def test_variants_of_every_kind_and_their_order() -> None:
    two = {"robot": "planar3r", "parameters": {"a": {"sets": "1.a", "lower": 0.5, "upper": 1.5},
                                               "b": {"sets": "2.a", "lower": "100 mm", "upper": 0.5}},
           "families": {}}  # fmt: skip
    for kind in ("latin-hypercube", "sobol"):
        spec = spec_of({**two, "sample": {"kind": kind, "variants": 13}, "seed": 4})
        values = variants_of(spec)
        assert values.shape == (13, 2)
        assert (values >= [0.5, 0.1]).all()
        assert (values <= [1.5, 0.5]).all()
        assert (variants_of(spec) == values).all()
        assert sorted(order_of(spec, values)) == list(range(13))
    grid = {name: {**one, "steps": 3} for name, one in two["parameters"].items()}  # type: ignore[attr-defined]
    spec = spec_of({**two, "parameters": grid})
    values = variants_of(spec)
    assert values[:4] == pytest.approx(np.array([[0.5, 0.1], [0.5, 0.3], [0.5, 0.5], [1.0, 0.1]]))
    walked = values[order_of(spec, values)]
    assert (np.count_nonzero(np.abs(np.diff(walked, axis=0)) > 1e-9, axis=1) == 1).all()
    assert len(neighbours(spec, [{"values": row} for row in values.tolist()])) == 12


def record(number: int, *forms: Any, value: float = 0.0) -> dict[str, Any]:
    return {"number": number, "values": [value], "verdict": "verified", "error": None,
            "families": [{"structure": form} for form in forms], "measures": {}}  # fmt: skip


def test_splits_and_joins_are_told_as_such() -> None:
    whole, left = (1, 5, (), (2, 3, 4)), (1, 5, (), (2, 3))
    right = (1, 5, ((4, False, (0.0, 180.0), 0),), ())
    names = [key_of(form) for form in (whole, left, right)]
    assert names == ["k1, dim 5: joints 2, 3, 4 coupled", "k1, dim 5: joints 2, 3 coupled", "k1, dim 5: θ4 = 0°, 180°"]
    found = changes([record(0, whole), record(1, left, right, value=1.0)], ["x"], [(0, 1)])
    assert [(one.kind, one.before, one.after) for one in found] == [(SPLITS, (names[0],), tuple(names[1:]))]
    found = changes([record(0, left, right), record(1, whole, value=1.0)], ["x"], [(0, 1)])
    assert [(one.kind, one.after) for one in found] == [(JOIN, (names[0],))]
    found = changes([record(0, right), record(1, left, value=1.0)], ["x"], [(0, 1)])
    assert sorted(one.kind for one in found) == [APPEARS, VANISHES]
    half, other, both = ((2, 3, ((3, False, values, 0),), ()) for values in ((0.0,), (180.0,), (0.0, 180.0)))
    pieces = record(0, half, other)
    assert keys_of(pieces) == ("k2, dim 3: θ3 = 0°, 180°",)
    assert changes([pieces, record(1, both, value=1.0)], ["x"], [(0, 1)]) == []
    assert changes([record(0, left) | {"verdict": "incomplete"}, record(1, right, value=1.0)], ["x"], [(0, 1)]) == []


def test_the_pareto_list_is_what_none_beats() -> None:
    rng = np.random.default_rng(3)
    values = rng.integers(0, 6, (60, 2)).tolist()
    records = [{"error": None, "measures": {"near": a, "path_sigma": b}} for a, b in values]
    records[7]["error"] = "no arm"  # type: ignore[assignment]
    records[9]["measures"]["path_sigma"] = None  # type: ignore[index]
    goals = {"near": "less", "path_sigma": "more"}
    there = [i for i in range(60) if i not in (7, 9)]

    def beats(a: list[int], b: list[int]) -> bool:
        return a[0] <= b[0] and a[1] >= b[1] and a != b

    expected = [i for i in there if not any(beats(values[j], values[i]) for j in there)]
    assert rank(records, goals).best == expected
    assert rank(records, {}).best == []


TOML = """robot = "planar3r"
task = "planar-position"

[parameters]
first = { sets = "1.a", lower = 0.5, upper = 1.0, steps = 2 }
second = { sets = ["2.a"], values = ["400 mm", 1.0] }

[families]
starts = 50
fresh = 50
exact = false

[near]
within = "20 deg"
samples = 400

[region]
lower = [0.2, -0.3, 0]
upper = [0.9, 0.3, 0]
points = 20
budget = 1000
"""


@pytest.fixture(scope="module")
def planar(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Designs]:
    file = tmp_path_factory.mktemp("sweep") / "planar.toml"
    file.write_text(TOML)
    return file, rankdrop.sweep(file, workers=1)


@pytest.mark.by_hand
def test_the_measures_are_right(planar: tuple[Path, Designs]) -> None:
    _, found = planar
    share = 4 * pi * 20.0**2 / 360.0**2  # θ2 and θ3 within 20° of 0 or π
    for value in found.values("near"):
        assert value == pytest.approx(share, abs=4 * (share / 400) ** 0.5)
    drawing = Drawing.of("planar3r")
    for one in found.records:
        values = zip((drawing.place("1.a", ""), drawing.place("2.a", "")), one["values"], strict=True)
        arm = drawing.robot(dict(values))
        region = one["region"]
        task = resolve_task("planar-position", arm, length_scale=found.spec.task.length_scale)
        assert singular_values(arm, np.array(region["q"]), task)[-1] == pytest.approx(region["sigma"])
        assert pose(arm, np.array(region["q"]))[:2, 3] == pytest.approx(region["at"][:2], abs=1e-8)
        assert region["sigma_lower"] <= region["sigma"] <= region["sigma_upper"]


@pytest.mark.by_hand
def test_command_page_figure_and_tables(
    planar: tuple[Path, Designs], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, found = planar
    out, result, page, figure = tmp_path / "out", tmp_path / "a.json", tmp_path / "a.html", tmp_path / "a.svg"
    files = ["--out", str(out), "--json", str(result), "--html", str(page), "--figure", str(figure)]
    code = main.run(["sweep", str(file), *files, "--over", "second,first", "--parquet", "--workers", "2", "--quiet"])
    text, errors = capsys.readouterr()
    assert code == 0, errors
    assert text.split() != []
    assert re.match(r"  (Variant \d is the best of|\d of) 4 variants of planar3r", text)
    written, here = json.loads(result.read_text()), json.loads(json.dumps(found.to_dict()))
    assert written.pop("summary")[:-1] == here.pop("summary")[:-1]  # the last line names an option, or a keyword
    assert written == here
    html = page.read_text()
    assert html.count("<circle") == 4 * len(found.measures)
    assert "http://" not in html.replace("http://www.w3.org", "")
    assert "https://" not in html
    assert figure.read_text().startswith("<?xml")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(out / "variants")
    assert table.column_names == ["variant", "first_m", "second_m", "families", "near", "sigma", "reached", "verdict",
                                  "error"]  # fmt: skip
    assert table["sigma"].to_pylist() == found.values("sigma")
    assert table.schema.field("near").metadata[b"meaning"].startswith(b"share of the joint space")
    rows = parquet.read_table(out / "families")
    assert rows.num_rows == sum(len(one["families"]) for one in found.records)
    assert main.run(["sweep", "--status", str(out)]) == 0
    assert capsys.readouterr()[0] == "finished: 1 of 1 chunks of the sweep (4 items in all)\n"


@pytest.mark.slow
def test_records_satisfy_their_schema_which_describes_all_of_it(shifted: Designs) -> None:
    asks = {"task": "planar-position", "families": {"starts": 50, "fresh": 50}, "near": {"within": 0.3, "samples": 100}}
    arms = compare(["planar2r", "planar3r"], asks, workers=1)
    for name, one in (("sweep", shifted), ("side-by-side", arms)):
        Draft202012Validator(closed(load_schema(name))).validate(json.loads(json_text(one.to_dict())))


@pytest.mark.by_hand
def test_tables_are_partitions(planar: tuple[Path, Designs], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.setattr("rankdrop.designs.tables.ROWS", 3)
    variants, _ = write_tables(planar[1], tmp_path)
    assert sorted(path.name for path in variants.iterdir()) == ["part-00000.parquet", "part-00001.parquet"]
    assert parquet.read_table(variants)["variant"].to_pylist() == [1, 2, 3, 4]


@pytest.mark.slow
def test_a_variant_that_is_no_arm_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    found = rankdrop.sweep({
        "robot": "scara", "parameters": {"upper": {"sets": "1.upper", "values": ["-200 deg", "90 deg"]}},
        "limits": True, "near": {"samples": 100},
    }, workers=1)  # fmt: skip
    assert not found.holds
    assert found.failed == (0,)
    assert "lower limit above upper limit" in found.records[0]["error"]
    assert found.sentence.startswith("Incomplete: 1 of 2 variants of scara could not be measured")
    assert found.pareto == [1]


@pytest.mark.by_hand
def test_arms_side_by_side(capsys: pytest.CaptureFixture[str]) -> None:
    asks = {"task": "planar-position", "families": {"starts": 50, "fresh": 50}, "near": {"within": 0.3, "samples": 500}}
    found = compare(["planar2r", "planar3r"], asks, workers=2)
    assert found.holds
    assert found.best("near") == (1,)
    assert found.task.length_scale == pytest.approx(max(map(reach, found.robots)))
    assert main.run(["compare", "planar2r", "planar3r", "--task", "planar-position", "--starts", "50", "--quiet",
                     "--json", "-"]) == 0  # fmt: skip
    record = json.loads(capsys.readouterr()[0])
    assert [one["name"] for one in record["arms"]] == ["planar2r", "planar3r"]
    assert record["schema"] == "rankdrop/side-by-side/1"
    with pytest.raises(OptionError, match=r"got 1; allowed: 2 … 10 arms"):
        compare(["ur5"], asks)
    with pytest.raises(OptionError, match="an arm is given twice"):
        compare(["ur5", "ur5"], asks)


@pytest.mark.by_hand
def test_slides_keep_their_lengths_out_of_the_key() -> None:
    found = rankdrop.sweep({"robot": "stanford", "parameters": {"d": {"sets": "2.d", "values": [0.1, 0.2]}},
                            "families": {"starts": 100, "fresh": 100, "exact": False}}, workers=1)  # fmt: skip
    arm = rankdrop.open_robot("stanford")
    slide = 1 + [joint.kind for joint in arm.variables].index(JointKind.PRISMATIC)
    keys = [key for one in found.records for key in keys_of(one) or ()]
    assert keys
    assert not any(f"θ{slide} =" in key for key in keys)
    assert len(found.structures) == 1


@pytest.mark.by_hand
def test_variants_of_the_ur5_have_the_families_of_an_analysis_from_nothing() -> None:
    """Warm and cold: the same families, of the same corank, dimension and joints, each sound and complete."""
    spec = {"robot": "ur5", "seed": 3, "sample": {"kind": "sobol", "variants": 8}, "families": {"exact": False},
            "parameters": {"upper_arm": {"sets": "-2.a", "lower": 0.3, "upper": 0.55},
                           "offset": {"sets": "5.d", "lower": 0.02, "upper": 0.14}}}  # fmt: skip
    found = rankdrop.sweep(spec)
    assert found.holds
    drawing = Drawing.of("ur5")
    places = [drawing.place("-2.a", ""), drawing.place("5.d", "")]
    for one in found.records[:3]:
        robot = drawing.robot(dict(zip(places, one["values"], strict=True)))
        cold = families_of(robot, resolve_task(None, robot), None, starts=1000, fresh=1000, limits=False, seed=9)
        assert cold.verified
        mine = sorted((row["corank"], row["dimension"], row["coupled"], len(row["pinned"])) for row in one["families"])
        assert mine == sorted((row.corank, row.dimension, list(row.coupled), len(row.pinned)) for row in cold.families)


PROVEN = """robot = "planar2r"
task = "planar-position"

[parameters]
forearm = { sets = "2.a", values = [0.4, 1.0] }

[paths]
files = ["out.csv"]

[certified]
width = 0.1
"""


@pytest.mark.by_hand
def test_paths_and_proven_shares_of_every_variant(tmp_path: Path) -> None:
    """A tool that moves from 0.9 m to 1.5 m: the arm with the short forearm is stretched out on the way, at 1.4 m."""
    rows = "\n".join(f"{x:.3f},0,0,0,0,0" for x in np.linspace(0.9, 1.5, 13))
    (tmp_path / "out.csv").write_text("x,y,z,roll,pitch,yaw\n" + rows + "\n")
    (tmp_path / "planar.toml").write_text(PROVEN)
    found = rankdrop.sweep(tmp_path / "planar.toml", workers=1)
    short, long = found.records
    assert [one["paths"][0]["verdict"] for one in found.records] == ["ends early", "free"]
    assert short["measures"]["path_sigma"] is None
    assert short["paths"][0]["why"]
    assert found.values("paths_free") == [0.0, 1.0]
    arm = Drawing.of("planar2r").robot({Drawing.of("planar2r").place("2.a", ""): 1.0})
    judged = rankdrop.path.check_poses(arm, *_poses(tmp_path / "out.csv"), task=resolve_task("planar-position", arm))
    assert judged.verdict == "free"
    assert long["measures"]["path_distance"] == pytest.approx(
        min(one.closest.distance for one in judged.stretches), abs=1e-6
    )
    folded = pi - 2 * np.arccos(0.9 / 2)  # of two links of 1 m at 0.9 m: nearer than stretched out at 1.5 m
    assert long["measures"]["path_distance"] == pytest.approx(folded, rel=1e-3)
    for one in found.records:  # singular where θ2 is 0 or π: at most two boxes on each side of both are not free
        assert one["certified"]["complete"]
        assert 1 - 8 * 0.1 / (2 * pi) <= one["measures"]["free"] < 1
    again = json_text(rankdrop.sweep(tmp_path / "planar.toml", workers=2).to_dict())
    assert again == json_text(found.to_dict())


def _poses(file: Path) -> tuple[np.ndarray, np.ndarray | None]:
    from rankdrop.path import read_poses

    read = read_poses(file)
    return read.matrices, read.times


def test_the_share_of_slow_configurations_is_that_of_analyze_with_its_interval() -> None:
    """The same record, interval and seed; the note names the speed and the widest interval, and no ± error."""
    arm = rankdrop.open_robot("irb120")
    task = resolve_task(None, arm)
    others = ("families", "aspects", "near", "region", "paths", "certified")
    asks = {"slow": {"speed": 0.25, "turn_speed": 0.0, "samples": 300}} | dict.fromkeys(others)
    record = measure_arm(arm, task, asks, None, limits=False, seed=5)
    expected = slower_than(Problem(arm, task), 0.25, samples=300, seed=5)
    assert expected is not None
    slow = record["slow"]
    assert (slow["share"], tuple(slow["interval"])) == (expected.share.share, expected.share.interval)
    assert (slow["tool_speed"], slow["turn_speed"], slow["seed"]) == (0.25, 0.0, 5)
    low, high = (100 * end for end in expected.share.interval)
    assert f"({low:.3g} … {high:.3g} %)" in measure_cell("slow", record)
    said = error_text([record], "slow")
    assert said == f" (slower than 250 mm/s); 95 % intervals up to {high - low:.2g} % wide"
    assert error_text([{**record, "slow": {**slow, "turn_speed": 0.5}}], "slow").startswith(
        " (slower than 250 mm/s or 28.6°/s); "
    )
    earlier = {key: slow[key] for key in ("share", "error", "bound", "samples", "hits")}
    assert error_text([{**record, "slow": earlier}], "slow") == f"; 95 % intervals up to {high - low:.2g} % wide"
    assert error_text([{**record, "slow": {**slow, "bound": True}}], "slow").endswith("; the shares may be larger")


def test_compare_by_speed_counts_translations_alone_as_analyze_does() -> None:
    _, asked = question_of(CompareOptions(speed="250mm/s").document())
    assert asked.slow is not None
    assert (asked.slow["speed"], asked.slow["turn_speed"]) == (0.25, 0.0)
    with pytest.raises(OptionError, match="0 or more"):
        question_of({"slow": {"turn_speed": -0.1}})
