"""open_robot: names, files of every kind, and errors that help."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

from rankdrop.errors import RobotError, UnknownRobotError
from rankdrop.robot import files
from rankdrop.robot.arm_reach import reach
from rankdrop.robot.open import CatalogEntry, catalog_entries, open_robot, robot_names
from robot.urdf_text import chain, robot

DH = 'convention = "standard"\n[[joints]]\na = 1\n'


@pytest.mark.parametrize(
    ("name", "text", "n"),
    [
        ("two.toml", DH, 1), ("no_suffix", DH, 1), ("arm.urdf", robot(chain(3)), 3), ("arm.xml", robot(chain(2)), 2),
        ("arm", "\ufeff\n  " + robot(chain(2)), 2), ("arm.txt", robot(chain(2)), 2),
    ],
)  # fmt: skip
def test_files_are_known_by_what_they_hold(tmp_path: Path, name: str, text: str, n: int) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    assert open_robot(path).n == n
    assert open_robot(str(path)).source.origin == str(path)


def test_a_name_with_a_slash_finds_the_arm_before_it() -> None:
    with pytest.raises(UnknownRobotError, match=r"fix: give a file; the catalogue has other arms: lrmate200id"):
        open_robot("FANUC LR Mate 200iD/7L")
    with pytest.raises(UnknownRobotError, match=r"got 'robots/arm.urdf'$"):
        open_robot("robots/arm.urdf")


def test_a_toml_robot_without_a_name_has_the_name_of_its_file(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(DH, encoding="utf-8")
    assert open_robot(path).name == "two"


def test_a_name_of_the_catalogue_wins_over_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pa10").write_text(DH, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert open_robot("pa10").n == 7
    assert open_robot("./pa10").n == 1


def test_latin_1_is_read_where_it_is_declared(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_bytes(b'<?xml version="1.0" encoding="ISO-8859-1"?><!-- \xe9 -->' + robot(chain(1)).encode())
    assert open_robot(path).n == 1


def test_unknown_names_bring_close_ones_and_the_list() -> None:
    with pytest.raises(UnknownRobotError, match=r"got 'puma56'; allowed: .*; fix: did you mean puma560") as caught:
        open_robot("puma56")
    assert f"{len(robot_names())} names: rankdrop robots lists them" in str(caught.value)
    for name in ("", "nothing like it", "x" * 10_000, "a\0b"):
        with pytest.raises(UnknownRobotError):
            open_robot(name)


@pytest.mark.parametrize("name", ["UR5e", "ur_5e", "UR 5e", "ur-5E", "u r 5 e"])
def test_capitals_blanks_and_dashes_make_no_difference_to_a_name(name: str) -> None:
    assert open_robot(name) is open_robot("ur5e")


def spelled(text: str, rng: np.random.Generator) -> str:
    """The same name with other capitals, and with blanks in other places."""
    letters = [letter.upper() if rng.random() < 0.5 else letter.lower() for letter in text if letter != " "]
    return "".join(letter + " " * (rng.random() < 0.3) for letter in letters)


def printed_names(entry: CatalogEntry) -> list[str]:
    """The name of an arm, its line in `rankdrop robots`, what that line says before its first comma; with its maker."""
    names = [entry.name, entry.about, entry.maker + " " + entry.name, *entry.aliases]
    if entry.name in ("fetch", "fetch8"):  # two arms of one machine
        return names
    return [*names, entry.about.split(",")[0], entry.about.split(",")[0].removeprefix(entry.maker)]


def test_every_arm_is_found_by_the_names_that_are_printed(rng: np.random.Generator) -> None:
    for entry in catalog_entries():
        for name in printed_names(entry):
            assert open_robot(spelled(name, rng)) is open_robot(entry.name)


@pytest.mark.parametrize(
    "name", ["KUKA LBR iiwa 14 R820", "kuka iiwa14", "ABB IRB 120", "Universal Robots UR5e", "FANUC LR Mate 200iD",
             "staubli tx2-60l", "Motoman GP7"],
)  # fmt: skip
def test_names_with_the_maker_are_found(name: str) -> None:
    assert open_robot(name).n in (6, 7)


@pytest.mark.parametrize(
    ("name", "others"),
    [("LR Mate 200iD/7L", "lrmate200id"), ("GP8", "gp7, gp25, gp12"), ("nova5", "nova2"), ("UR8", "ur5, ur3, ur5e"),
     ("ur5ee", "ur5e, ur5, ur3e"), ("M-20iA/35M", "m20ia"), ("xarm 6 lite", "xarm6")],
)  # fmt: skip
def test_another_model_of_a_series_is_no_spelling_of_an_arm(name: str, others: str) -> None:
    with pytest.raises(UnknownRobotError, match=f"other arms: .*{others}") as refused:
        open_robot(name)
    assert "did you mean" not in str(refused.value)


def test_names_in_another_spelling_stay_unambiguous() -> None:
    plain = [re.sub(r"[-_\s]", "", name).lower() for name in robot_names()]
    assert len(set(plain)) == len(plain)


def test_a_file_of_that_very_name_comes_before_another_spelling(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "UR5e").write_text(DH, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert open_robot("UR5e").n == 1
    assert open_robot(Path("UR5e")).n == 1
    with pytest.raises(UnknownRobotError):
        open_robot(Path("UR3e"))  # a path is a file


def test_what_the_catalogue_says_of_an_arm_is_searched_for_suggestions() -> None:
    with pytest.raises(UnknownRobotError, match=r"fix: did you mean pa10\?"):
        open_robot("Mitsubishi PA")
    with pytest.raises(UnknownRobotError, match=r"fix: 1\d arms fit: rankdrop robots 'ABB IRB' lists them"):
        open_robot("ABB IRB")


@pytest.mark.parametrize(("length", "noted"), [(31.0, True), (29.0, False), (0.031, False), (0.029, True)])
def test_an_arm_of_unlikely_size_brings_the_question_of_millimetres(
    tmp_path: Path, length: float, noted: bool
) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(f'convention = "standard"\n[[joints]]\na = {length}\n', encoding="utf-8")
    asked = [str(note) for note in open_robot(path).notes if "are these numbers millimetres?" in str(note)]
    assert len(asked) == noted
    assert not noted or asked[0].startswith(f"the arm's reach is {length:.3g} m:")


def test_a_wrist_without_length_and_the_catalogue_are_of_likely_size(tmp_path: Path) -> None:
    path = tmp_path / "wrist.toml"
    path.write_text('convention = "standard"\n[[joints]]\nalpha = "pi/2"\n[[joints]]\n', encoding="utf-8")
    assert open_robot(path).notes == ()
    assert all(1e-9 < reach(open_robot(name)) < 30.0 for name in robot_names())


@pytest.mark.parametrize("name", ["robots/arm.urdf", "arm.toml", "./pa10", "arm.XACRO"])
def test_paths_that_are_not_there_are_called_files(name: str) -> None:
    with pytest.raises(UnknownRobotError, match="there is no such file; got"):
        open_robot(name)


def test_links_cannot_be_named_where_there_are_none(tmp_path: Path) -> None:
    path = tmp_path / "two.toml"
    path.write_text(DH, encoding="utf-8")
    for source in ("pa10", path):
        with pytest.raises(RobotError, match="no links to name as its tip; got 'tool0'"):
            open_robot(source, tip="tool0")
        with pytest.raises(RobotError, match="no links to name as its base"):
            open_robot(source, base="world")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "the file is empty"),
        (b"hello there\n", "neither TOML nor XML"),
        (b"\x7fELF\0\0\0", "not a text file"),
        (b"a\nb\n\xff\xfe", "line 3: this is not text in UTF-8; got byte 0xff"),
    ],
)
def test_files_that_are_nothing_we_read_are_refused(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "file.urdf"
    path.write_bytes(data)
    with pytest.raises(RobotError, match=words) as caught:
        open_robot(path)
    assert "\n" not in str(caught.value)


def test_folders_large_files_and_files_without_permission_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(RobotError, match="this is a folder"):
        open_robot(tmp_path)
    path = tmp_path / "large.toml"
    path.write_text(DH, encoding="utf-8")
    monkeypatch.setattr(files, "LARGEST_FILE", 10)
    with pytest.raises(RobotError, match="too large"):
        open_robot(path)
    monkeypatch.undo()
    path.chmod(0)
    if not os.access(path, os.R_OK):  # root may read everything
        with pytest.raises(RobotError, match="cannot be read: Permission denied"):
            open_robot(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.urdf")
    with pytest.raises(RobotError, match="this is not a file"):
        open_robot(tmp_path / "pipe.urdf")


GR = """# GR section 5: screws (s; s_o) in order
1 0 0  0 0 -1
0 0 0  0 1 0
0 1 0  0 0 0
0, 1, 0; 0, 0, 5
[1 0 0 0 0 0]

0 1/sqrt(2) 1/sqrt(2)  0 -10/sqrt(2) 10/sqrt(2)
0 .707106 -.707106  0 7.07106 7.07106
"""


@pytest.mark.parametrize("name", ["S.txt", "S", "S.dat"])
def test_a_plain_file_of_six_numbers_a_line_opens(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(GR)
    robot, listed = open_robot(path), open_robot("rcrrrr")
    assert [str(joint.kind) for joint in robot.joints] == [str(joint.kind) for joint in listed.joints]
    for one, other in zip(robot.joints, listed.joints, strict=True):
        np.testing.assert_allclose(one.screw, other.screw, atol=1e-9)  # .707106 is meant to be a right angle halved
    assert any("six numbers a line" in str(note) for note in robot.notes)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("1 0 0 0 0 -1\n0 0 0 0 1\n", "line 2", "a screw has six numbers"),
        ("1 0 0 0 0 -1\n# one\n0 0 0 0 0 0\n", "line 3", "no length"),
        ("1 0 0 0 0 -1\n0 x 0 0 0 0\n", "line 2, column 3", "not one that fits"),
    ],
)
def test_what_is_wrong_in_a_plain_file_is_told_with_its_line(tmp_path: Path, text: str, line: str, words: str) -> None:
    path = tmp_path / "S.txt"
    path.write_text(text)
    with pytest.raises(RobotError, match=words) as caught:
        open_robot(path)
    assert f"{path}, {line}" in str(caught.value)
