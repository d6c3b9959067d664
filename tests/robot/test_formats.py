"""Formats of robot files, and their readers."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot import formats
from rankdrop.robot import open as opening
from rankdrop.robot.dh import from_dh
from rankdrop.robot.model import Robot
from rankdrop.robot.open import open_robot


def test_sdf_is_named_with_the_way_to_convert(tmp_path: Path) -> None:
    path = tmp_path / "arm.sdf"
    path.write_text('<?xml version="1.0"?><!-- <robot> --><sdf version="1.9"><model name="a"/></sdf>', encoding="utf-8")
    with pytest.raises(RobotError, match=r"SDF is not read; got <sdf>; .*fix: convert it to MJCF with sdf2mjcf"):
        open_robot(path)


def test_a_pointer_of_git_lfs_is_told(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 5\n", encoding="utf-8")
    with pytest.raises(RobotError, match=r"a pointer of Git LFS, .*fix: fetch it: git lfs pull"):
        open_robot(path)


def test_a_new_format_is_a_reader_and_an_entry_of_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its module and `FORMATS`: two files; base, tip and arguments are refused where it has none."""

    def read(file: formats.RobotFile) -> Robot:
        return from_dh([(float(word), 0, 0, 0) for word in file.text.split()], convention="standard", name="links")

    entry = formats.Format("lengths", (".lengths",), lambda file: file.suffix == ".lengths", read, links=False)
    monkeypatch.setattr(formats, "FORMATS", (entry, *formats.FORMATS))
    path = tmp_path / "arm.lengths"
    path.write_text("0.4 0.3 0.2", encoding="utf-8")
    assert opening.open_robot(path).home[:3, 3].tolist() == pytest.approx([0.9, 0, 0])
    for given in ({"tip": "hand"}, {"base": "foot"}, {"args": {"a": 1}}):
        with pytest.raises(RobotError):
            opening.open_robot(path, **given)
    other, sdf = tmp_path / "arm.other", tmp_path / "arm.sdf"
    other.write_text("nothing known", encoding="utf-8")
    sdf.write_text("<sdf/>", encoding="utf-8")
    with pytest.raises(RobotError, match="give a file in lengths, xacro"):
        opening.open_robot(other)
    with pytest.raises(RobotError, match=r"SDF is not read.*lengths, xacro"):
        opening.open_robot(sdf)
