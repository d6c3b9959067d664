"""Small files that ask a foreign parser for gigabytes or hours: each is one line of error, within the limits."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rankdrop.errors import RobotError
from rankdrop.jobs import limited
from rankdrop.robot.open import open_robot

resource = pytest.importorskip("resource")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the system has no limit of memory")

LINK = '<body name="{name}"><joint name="{name}_j"/><geom size="0.1"/>{inside}</body>'
XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{inside}<link name="a"/></robot>'


def nested_replicate(depth: int, count: int) -> str:
    inside = LINK.format(name="a", inside="")
    for _ in range(depth):
        inside = f'<replicate count="{count}" offset="1 0 0">{inside}</replicate>'
    return f"<mujoco><worldbody>{inside}</worldbody></mujoco>"


def with_asset(inside: str, more: str = "") -> str:
    return f"<mujoco>{inside}<worldbody>{LINK.format(name='a', inside=more)}</worldbody></mujoco>"


def nested_macros(depth: int) -> str:
    macros = ""
    for i in range(depth):
        inside = f'<xacro:m{i - 1} n="1"/>' * 10 if i else '<link name="l"/>'
        macros += f'<xacro:macro name="m{i}" params="n">{inside}</xacro:macro>'
    return XACRO.format(inside=f'{macros}<xacro:m{depth - 1} n="1"/>')


MJCF = {
    "replicate": nested_replicate(8, 30),
    "replicate once": nested_replicate(1, 2_000_000_000),
    "height field": with_asset('<asset><hfield name="h" nrow="20000" ncol="20000" size="1 1 1 1"/></asset>'),
    "cloth": with_asset(
        "", '<flexcomp name="f" type="grid" count="200 200 200" spacing="1 1 1" dim="3"/>'
    ),
    "keys": with_asset('<size nkey="1000000000"/>'),
    "user data": with_asset('<size nuser_body="2000000000"/>'),
    "memory": with_asset('<size memory="100G"/>'),
    "texture": with_asset('<asset><texture name="t" type="2d" builtin="flat" width="30000" height="30000"/></asset>'),
}
EXPANSIONS = {
    "macros": nested_macros(9),
    "power": XACRO.format(inside='<xacro:property name="p" value="${10**10**8 % 7}"/><link name="l${p}"/>'),
    "text": XACRO.format(inside='<link name="${\'a\' * 10**10}"/>'),
    "recursion": XACRO.format(inside='<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>'),
    "list": XACRO.format(inside='<link name="${len(list(range(10**10)))}"/>'),
}


MEASURE = """
import os, resource, subprocess, sys
code = subprocess.run(sys.argv[2:]).returncode
used = resource.getrusage(resource.RUSAGE_CHILDREN)
with open(sys.argv[1], "a") as file:
    print(used.ru_utime + used.ru_stime, used.ru_maxrss, file=file)
if code < 0:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.kill(os.getpid(), -code)
sys.exit(code)
"""


@pytest.fixture(autouse=True)
def _cost(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Shortens the limit of processor time, and holds what each child took.

    A small process begins the child: to the system, the peak of a child is at least that of the one that began it.
    """
    told = tmp_path_factory.mktemp("cost") / "told"
    told.touch()
    run = subprocess.run

    def measured(words: list[str], **more: Any) -> Any:
        return run([sys.executable, "-c", MEASURE, str(told), *words], **more)

    monkeypatch.setattr(limited, "CPU", 2)
    monkeypatch.setattr(limited.subprocess, "run", measured)
    yield
    lines = told.read_text().splitlines()
    assert lines
    for line in lines:
        seconds, peak = map(float, line.split())
        assert seconds < 4
        assert peak < 1.2 * 2**20  # [kB]


def refused(path: Path) -> str:
    """The line with which a file is refused; a file whose bomb is harmless may also open."""
    line = ""
    try:
        open_robot(path)
    except RobotError as error:
        line = str(error)
    assert "\n" not in line
    assert len(line) < 1000
    return line


@pytest.mark.spread(2)
@pytest.mark.by_hand_at("cloth", "keys", "replicate", "replicate once")
@pytest.mark.slow_at("height field", "memory", "user data")
@pytest.mark.slow_at("replicate once", "replicate", "cloth", "keys")
@pytest.mark.parametrize("kind", MJCF)
def test_a_small_mjcf_file_costs_little(tmp_path: Path, kind: str) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "bomb.xml"
    path.write_text(MJCF[kind], encoding="utf-8")
    line = refused(path)
    if kind in ("replicate", "replicate once"):
        assert line.startswith(str(path))
        assert "MuJoCo" in line or "too many bodies" in line


@pytest.mark.slow
def test_included_files_count(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    bodies = "".join(LINK.format(name=f"b{{i}}_{k}", inside="") for k in range(500))
    for i in range(60):
        (tmp_path / f"part{i}.xml").write_text(
            f"<mujoco><worldbody>{bodies.replace('{i}', str(i))}</worldbody></mujoco>", encoding="utf-8")  # fmt: skip
    path = tmp_path / "whole.xml"
    parts = "".join(f'<include file="part{i}.xml"/>' for i in range(60))
    path.write_text(f"<mujoco>{parts}</mujoco>", encoding="utf-8")
    line = refused(path)
    assert "too many bodies" in line or "processor time" in line


@pytest.mark.spread(2)
@pytest.mark.by_hand_at("macros", "power")
@pytest.mark.slow
@pytest.mark.parametrize("kind", EXPANSIONS)
def test_a_small_xacro_file_costs_little(tmp_path: Path, kind: str) -> None:
    pytest.importorskip("xacro")
    path = tmp_path / "bomb.xacro"
    path.write_text(EXPANSIONS[kind], encoding="utf-8")
    assert refused(path).startswith(str(path))


@pytest.mark.slow
def test_a_place_that_is_not_finite_is_refused_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    path = tmp_path / "far.xml"
    path.write_text(f"<mujoco><worldbody>{LINK.format(name='a', inside='')}</worldbody></mujoco>".replace(
        '<body name="a"', '<body name="a" pos="0 0 inf"'), encoding="utf-8")  # fmt: skip
    with pytest.raises(RobotError):
        open_robot(path)
