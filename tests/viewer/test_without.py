"""The plain install has no viewer: the command says what installs it, and all else goes on without."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rankdrop.cli import main
from rankdrop.errors import MissingExtraError
from rankdrop.robot.open import open_robot
from rankdrop.robot.shapes import meshes_of, visuals_of

BOX = """<robot name="r"><link name="a"/><link name="b"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("viser", "trimesh", "collada"):
        monkeypatch.setitem(sys.modules, name, None)


def test_the_command_says_what_installs_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["view", "planar2r", "--no-browser", "--port", "0"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "the viewer needs the package viser" in told
    assert 'pip install ".[viewer]"' in told


def test_meshes_name_the_same_extra(tmp_path: Path) -> None:
    file = tmp_path / "box.urdf"
    file.write_text(BOX)
    visuals, _ = visuals_of(open_robot(str(file)), {}, {})
    assert visuals
    with pytest.raises(MissingExtraError, match="drawing meshes needs the package trimesh") as caught:
        meshes_of(visuals)
    assert caught.value.extra == "viewer"


def test_a_report_is_written_without_meshes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box.urdf").write_text(BOX)
    assert main.run(["report", "box.urdf", "--out", "box.html", "--starts", "50"]) in (0, 1, 3)
    assert "not drawn: drawing meshes needs the package trimesh" in " ".join(capsys.readouterr().err.split())
    assert (tmp_path / "box.html").stat().st_size > 10_000
