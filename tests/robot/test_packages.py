"""Where packages are looked for: near the file, in the ROS variables, and nowhere that anybody may write."""

from __future__ import annotations

from pathlib import Path

import pytest

from rankdrop.robot import xacro as packages
from rankdrop.robot.xacro import find_package


def package(folder: Path, name: str) -> Path:
    """A folder that says it is the package."""
    folder.mkdir(parents=True)
    text = f"<package format='2'><!-- <name>no</name> --><name> {name} </name></package>"
    (folder / "package.xml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A robot file of the package `own` in a workspace with other repositories."""
    own = package(tmp_path / "ws" / "src" / "repo" / "own_folder", "own_pkg")
    (own / "urdf" / "arms").mkdir(parents=True)
    return own / "urdf" / "arms" / "arm.xacro"


@pytest.fixture(autouse=True)
def no_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(variable, raising=False)


def test_a_folder_that_is_given_comes_first(file: Path, tmp_path: Path) -> None:
    assert find_package("own_pkg", file, {"own_pkg": str(tmp_path)}) == tmp_path


def test_the_package_of_the_file_is_known_by_its_package_xml_not_by_its_folder(file: Path) -> None:
    assert find_package("own_pkg", file, {}) == file.parents[2]
    assert find_package("no", file, {}) is None  # a name in a comment


@pytest.mark.parametrize("place", ["repo/beside", "repo/group/beside", "other/beside", "other/group/beside"])
def test_packages_of_the_checkout_and_of_the_workspace_are_found(file: Path, tmp_path: Path, place: str) -> None:
    folder = package(tmp_path / "ws" / "src" / place, "beside_pkg")
    assert find_package("beside_pkg", file, {}) == folder


def test_the_nearest_of_two_packages_is_taken(file: Path, tmp_path: Path) -> None:
    package(tmp_path / "ws" / "src" / "a_repo" / "twice", "twice_pkg")
    near = package(tmp_path / "ws" / "src" / "repo" / "z", "twice_pkg")
    assert find_package("twice_pkg", file, {}) == near


def test_packages_hold_no_packages_and_hidden_folders_are_not_looked_into(file: Path, tmp_path: Path) -> None:
    package(tmp_path / "ws" / "src" / "repo" / ".git" / "x", "hidden_pkg")
    package(package(tmp_path / "ws" / "src" / "repo" / "outer", "outer_pkg") / "inner", "inner_pkg")
    assert find_package("hidden_pkg", file, {}) is None
    assert find_package("inner_pkg", file, {}) is None


def test_the_variables_of_ros_1_and_2_are_asked(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one = package(tmp_path / "a" / "b" / "c" / "d" / "e" / "f" / "one", "one_pkg")
    two = package(tmp_path / "prefix" / "install" / "x" / "y" / "share" / "two_pkg", "two_pkg")
    assert find_package("one_pkg", file, {}) is None
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/no/such/folder:{one.parents[2]}")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/no/such/prefix:{two.parents[1]}")
    assert find_package("one_pkg", file, {}) == one
    assert find_package("two_pkg", file, {}) == two
    assert find_package("three_pkg", file, {}) is None


def test_old_packages_and_folders_of_that_very_name_are_taken(file: Path, tmp_path: Path) -> None:
    old = tmp_path / "ws" / "src" / "repo" / "old_pkg"
    old.mkdir()
    (old / "manifest.xml").write_text("<package/>", encoding="utf-8")
    assert find_package("old_pkg", file, {}) == old
    bare = tmp_path / "ws" / "src" / "bare_pkg"
    bare.mkdir()
    assert find_package("bare_pkg", file, {}) == bare
    named = package(tmp_path / "ws" / "src" / "zz", "bare_pkg")
    assert find_package("bare_pkg", file, {}) == named  # what says so comes before what is called so


@pytest.mark.parametrize("name", ["..", "../own_folder", "/etc", "", "a/b", "own_pkg\n"])
def test_what_is_no_name_is_not_looked_for(file: Path, name: str) -> None:
    assert find_package(name, file, {}) is None


def test_folders_where_anybody_may_leave_files_are_not_looked_into(file: Path, tmp_path: Path) -> None:
    package(tmp_path / "ws" / "left_by_somebody", "left_pkg")
    assert find_package("left_pkg", file, {}) is not None
    (tmp_path / "ws").chmod(0o1777)
    assert find_package("left_pkg", file, {}) is None
    assert find_package("own_pkg", file, {}) == file.parents[2]


def test_of_the_home_folder_only_its_own_subfolders_are_looked_at(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    beside = package(tmp_path / "beside_home", "at_home_pkg")
    package(tmp_path / "deep" / "below", "deep_pkg")
    assert find_package("at_home_pkg", file, {}) == beside
    assert find_package("deep_pkg", file, {}) is None
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "ws")
    assert find_package("at_home_pkg", file, {}) is None


def test_the_search_ends_after_so_many_folders(file: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    package(tmp_path / "ws" / "src" / "far" / "away", "far_pkg")
    assert find_package("far_pkg", file, {}) is not None
    monkeypatch.setattr(packages, "_MOST_FOLDERS", 3)
    assert find_package("far_pkg", file, {}) is None
