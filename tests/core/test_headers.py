"""The headers for C and C++: the example is built, and says what Python says, bit for bit or nearly so."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rankdrop import Monitor
from rankdrop.cli.main import run
from rankdrop.distance.monitor import FORMAT
from rankdrop.headers import get_cmake_dir, get_include, main
from rankdrop.results.known import shipped
from rankdrop.robot.model import Array

ROOT = Path(__file__).resolve().parents[2]
ARMS = ("pa10", "ur5e", "open_manipulator")
COMPILER = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), None)
needs_compiler = pytest.mark.skipif(
    COMPILER is None or any(shutil.which(name) is None for name in ("cmake", "make", "cc")),
    reason="no C++ compiler, C compiler, make or CMake on the PATH",
)
SETTINGS = {"CC", "CXX", "HOME", "LANG", "PATH", "PYTHONPATH", "TMPDIR", "VIRTUAL_ENV"}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the example's programs."""
    folder = tmp_path_factory.mktemp("cpp")
    environment = {name: value for name, value in os.environ.items() if name in SETTINGS}
    configure = ["cmake", "-S", str(ROOT / "examples" / "cpp"), "-B", str(folder), f"-Drankdrop_DIR={get_cmake_dir()}",
                 f"-DPython_EXECUTABLE={sys.executable}", f"-DROBOTS={';'.join(ARMS)}", "-DCMAKE_BUILD_TYPE=Release",
                 "-DCMAKE_CXX_FLAGS_RELEASE=-O0", "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror"]  # fmt: skip
    for command in (configure, ["cmake", "--build", str(folder)]):
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stdout + done.stderr
    return folder


def rows_of(monitor: Monitor) -> Array:
    """100 rows of q and joint rates: on a family, near one, anywhere."""
    rng, n = np.random.default_rng(7), monitor.robot.n
    rows = rng.uniform(-3.0, 3.0, (100, 2 * n))
    witnesses = np.array([family.witness for family in monitor.watched_families])
    rows[:70, :n] = witnesses[np.arange(70) % len(witnesses)]
    rows[20:70, :n] += rng.normal(size=(50, n)) * 0.05
    return rows


def said_by(monitor: Monitor, q: Array, rates: Array) -> tuple[list[str], Array]:
    """What the example prints of one row, from Python."""
    seen, at = monitor.step(q, rates), monitor.nearby(q)
    of = {i: family.id for i, family in enumerate(monitor.families)} | {-1: "none"}
    each = np.concatenate([at.distance[:, None], at.residual[:, None], at.away], axis=1)
    numbers = [seen.residual, seen.distance, seen.approach, seen.scaling, seen.rate_scaling, seen.null_rate,
               seen.at_least]  # fmt: skip
    words = [of[seen.nearest], of[seen.family], str(seen.rank), str(seen.corank)]
    return words, np.concatenate([numbers, seen.sigma, seen.u.ravel(), seen.null_step, each.ravel()])


@pytest.mark.by_hand_at("pa10-watch", "pa10-watch_c")
@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("program", ["watch", "watch_c"])
@pytest.mark.parametrize("name", ARMS)
def test_cpp_and_c_say_what_python_says(built: Path, name: str, program: str) -> None:
    """To 1e-12, on 100 rows; and no step in C++ allocates (the program would end with 3)."""
    found = shipped(name)
    monitor = Monitor(found.robot, found.task, found.families)
    rows = rows_of(monitor)
    text = "\n".join(" ".join(repr(float(value)) for value in row) for row in rows)
    done = subprocess.run([built / program, name], input=text, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 100
    n, slowed, proven = monitor.robot.n, 0, 0
    assert (
        monitor.watched_families != monitor.families or name == "open_manipulator"
    )  # numbers are not those of the kernels
    for row, line in zip(rows, lines, strict=True):
        words = line.split()
        want, numbers = said_by(monitor, row[:n], row[n:])
        assert words[:4] == want
        np.testing.assert_allclose(np.array(words[4:], dtype=float), numbers, rtol=1e-12, atol=1e-12)
        assert float(words[10]) == numbers[6] <= numbers[1] + 1e-9  # the proven bound: the same bits, never too large
        proven += float(words[10]) > 0.01
        slowed += float(words[7]) < 1.0
    assert slowed >= 10
    assert proven >= 10


@pytest.mark.slow
@needs_compiler
@pytest.mark.parametrize("name", ARMS)
def test_the_guard_of_the_how_to_scales_as_python_does(built: Path, name: str) -> None:
    """What a node of one's own puts around it: joints by name, nothing goes on before all of them were heard of."""
    found = shipped(name)
    monitor = Monitor(found.robot, found.task, found.families)
    rows, n, slowed = rows_of(monitor), monitor.robot.n, 0
    rows[-1, n] = np.nan
    text = "\n".join(" ".join(repr(float(value)) for value in row) for row in rows)
    done = subprocess.run([built / "guard", name], input=text, capture_output=True, text=True)
    first, *lines = done.stdout.splitlines()
    assert float(first) == 0.0
    assert len(lines) == 100
    assert [float(word) for word in lines[-1].split()[: n + 1]] == [0.0] * (n + 1)
    for row, line in zip(rows[:-1], lines, strict=False):
        seen, words = monitor.step(row[:n], row[n:]), line.split(maxsplit=n + 2)
        scale = min(seen.scaling, seen.rate_scaling)
        np.testing.assert_allclose([float(word) for word in words[: n + 2]], [scale, *scale * row[n:], seen.distance],
                                   rtol=1e-12, atol=1e-12)  # fmt: skip
        assert words[n + 2] == monitor.families[seen.nearest].name
        slowed += scale < 1.0
    assert slowed >= 10


@pytest.mark.slow
@needs_compiler
def test_an_unknown_arm_ends_with_2(built: Path) -> None:
    for program in ("watch", "watch_c", "guard"):
        assert subprocess.run([built / program, "nobody"], input="", capture_output=True, text=True).returncode == 2


@pytest.mark.slow
@needs_compiler
def test_a_number_that_is_not_finite_stops_the_motion(built: Path) -> None:
    for program in ("watch", "watch_c"):
        for row in ("nan 0 0 0 1 1 1 1", "0 0 0 0 1 inf 1 1"):
            done = subprocess.run([built / program, "open_manipulator"], input=row, capture_output=True, text=True)
            words = done.stdout.split()
            assert words[:4] == ["none", "none", "-1", "-1"]
            assert float(words[7]) == float(words[8]) == 0.0  # scaling, rate_scaling


def test_the_header_says_which_format_it_is_of() -> None:
    text = (Path(get_include()) / "rankdrop" / "monitor.h").read_text(encoding="utf-8")
    assert f"#define RANKDROP_ARM_FORMAT {FORMAT}\n" in text


def test_the_fields_of_an_arm_stand_in_the_order_of_the_header() -> None:
    """The constant is written without names of fields, so that C++17 reads it."""
    text = (Path(get_include()) / "rankdrop" / "monitor.h").read_text(encoding="utf-8")
    body = text[text.index("typedef struct rankdrop_arm {") : text.index("} rankdrop_arm;")]
    declared = []
    for line in body.splitlines()[1:]:
        line = line.split("/*")[0].strip().rstrip(";")
        line = line.removeprefix("const ").removeprefix("char").removeprefix("int").removeprefix("double")
        declared += [name.replace("const", "").strip(" *") for name in line.split(",") if name.strip(" *")]
    found = shipped("pa10")
    written = Monitor(found.robot, found.task, found.families).header()
    constant = written[written.index("static const rankdrop_arm ") :]
    names = [line.split("/*")[1].strip(" */") for line in constant.splitlines() if "/*" in line]
    assert names == declared


def entries(text: str, name: str) -> list[str]:
    """The entries of one array of a header."""
    body = text[text.index(f"_{name}[] = {{") :]
    return re.findall(r'"[^"]*"|[-\w.]+', body[body.index("{") + 1 : body.index("}")])


def test_families_are_numbered_as_in_python() -> None:
    """One without conditions, which the kernels do not know, keeps its number."""
    found = shipped("pa10")
    families = [replace(one, equations=()) if i == 1 else one for i, one in enumerate(found.families)]
    monitor = Monitor(found.robot, found.task, families)
    text = monitor.header()
    assert entries(text, "ids") == [f'"{one.id}"' for one in families]
    numbers = list(map(int, entries(text, "number")))
    assert [monitor.families[i] for i in numbers] == list(monitor.watched_families)
    assert sorted({1, *numbers}) == list(range(len(families)))
    assert len(numbers) == len(families) - 1


def test_folders_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--include-dir"]) == 0
    assert (Path(capsys.readouterr().out.strip()) / "rankdrop" / "monitor.hpp").is_file()
    assert main(["--cmake-dir"]) == 0
    assert (Path(capsys.readouterr().out.strip()) / "rankdropConfig.cmake").is_file()
    assert main([]) == 2
    assert "--cmake-dir" in capsys.readouterr().err


def test_the_command_writes_the_header(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "arm.h"
    words = ["monitor", "scara", "--header", str(target), "--start", "10deg", "--stop", "1deg", "--mark", "2nd arm"]
    assert run(words) == 0
    text = target.read_text(encoding="utf-8")
    assert "static const rankdrop_arm rankdrop_2nd_arm_arm = {" in text
    found = shipped("scara")
    written = Monitor(found.robot, found.task, found.families, start=np.radians(10), stop=np.radians(1))
    assert text == written.header("2nd arm")
    assert run(["monitor", "scara", "--header", str(target), "--start", "1deg", "--stop", "2deg"]) == 2
    assert "0 ≤ stop < start" in capsys.readouterr().err
    assert run(["monitor", "scara", "--header", str(target), "--stop", "2mm"]) == 2
    assert "--stop" in capsys.readouterr().err
    assert target.read_text(encoding="utf-8") == text


@pytest.mark.by_hand
@needs_compiler
def test_the_node_of_the_how_to_compiles_and_scales(tmp_path: Path) -> None:
    """Against a stand-in for the few parts of rclcpp that it uses (`tests/core/ros`): there is no ROS here."""
    page = (ROOT / "docs" / "howto" / "control-loop.md").read_text(encoding="utf-8")
    node = next(part.split("```")[0] for part in page.split("```cpp\n") if part.startswith("#include <rclcpp"))
    (tmp_path / "node.cpp").write_text(node, encoding="utf-8")
    found = shipped("ur5e")
    monitor = Monitor(found.robot, found.task, found.families, rates=np.full(6, 3.0))
    (tmp_path / "ur5e.h").write_text(monitor.header(), encoding="utf-8")
    assert COMPILER is not None
    command = [COMPILER, "-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-Wno-psabi", "-ffp-contract=off",
               *(f"-I{folder}" for folder in (get_include(), ROOT / "tests" / "core" / "ros", ROOT / "examples" / "cpp",
                                              tmp_path)), "node.cpp", "-o", "node"]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    q, rates = np.array([0.1, -1.2, 1.4, -0.7, 0.1, 0.3]), np.array([0.0, 0.1, -0.1, 0.0, -0.5, 0.2])
    names = [joint.name for joint in found.robot.variables]
    wish = " ".join(["~/commands", *map(repr, rates.tolist())])
    heard = " ".join(f"{name} {value!r}" for name, value in zip(names, q.tolist(), strict=True))
    lines = [wish, f"joint_states {heard}", wish]
    done = subprocess.run([tmp_path / "node"], input="\n".join(lines), capture_output=True, text=True)
    before, after = (line.split() for line in done.stdout.splitlines())
    assert before[0] == after[0] == "velocity_controller/commands"
    assert [float(word) for word in before[1:]] == [0.0] * 6  # nothing goes on before every joint was heard of
    seen = monitor.step(q, rates)
    assert 0.0 < seen.scaling < 1.0
    want = min(seen.scaling, seen.rate_scaling) * rates
    np.testing.assert_allclose([float(word) for word in after[1:]], want, rtol=1e-12)
    assert monitor.families[seen.nearest].name in done.stderr
