"""Links as the file draws them: so few triangles that the page stays small, and the shape stays."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rankdrop.cli import main
from rankdrop.report.content import MOST, meshes_data, simplify_meshes

trimesh = pytest.importorskip("trimesh", reason="viser and trimesh are not installed")

from rankdrop.robot.shapes import Mesh  # noqa: E402

URDF = """<robot name="two">
  <link name="a"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="b"><visual><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.1 0.1"/></geometry></visual></link>
  <link name="c"><visual><origin xyz="0.2 0 0"/><geometry><mesh filename="part.stl"/></geometry></visual></link>
  <link name="d"/>
  <joint name="j1" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
  <joint name="j2" type="continuous"><parent link="b"/><child link="c"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="j3" type="fixed"><parent link="c"/><child link="d"/><origin xyz="0.4 0 0"/></joint>
</robot>"""


def sphere(subdivisions: int, radius: float = 0.3, link: int = 1) -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(link, np.array(made.vertices), np.array(made.faces, dtype=np.uint32), (10, 20, 30))


@pytest.mark.slow
def test_large_meshes_become_few_triangles_near_the_shape() -> None:
    given = (sphere(7), sphere(6, 0.1, 2))  # 327,680 and 81,920 triangles
    few = simplify_meshes(given)
    assert MOST / 2 < sum(len(one.faces) for one in few) <= MOST
    assert [one.link for one in few] == [1, 2]
    for one, radius in zip(few, (0.3, 0.1), strict=True):
        off = np.abs(np.linalg.norm(one.vertices, axis=1) - radius)
        assert off.max() < 0.03 * radius / 0.3 + 0.005
        assert len(np.unique(one.faces)) == len(one.vertices)


def test_small_meshes_keep_every_triangle() -> None:
    (one,) = simplify_meshes((sphere(2),))
    assert len(one.faces) == 320
    assert simplify_meshes(()) == ()
    empty = replace(sphere(2), vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), dtype=np.uint32))
    assert simplify_meshes((empty,)) == ()
    assert len(simplify_meshes((empty, sphere(2)))) == 1


def test_whole_numbers_of_the_page_are_the_vertices_again() -> None:
    (one,) = simplify_meshes((sphere(4),))
    (data,) = meshes_data((one,))
    again = np.array(data["low"]) + data["step"] * np.array(data["points"]).reshape(-1, 3)
    assert np.abs(again - one.vertices).max() < 1e-4
    assert data["colour"] == "#0a141e"


def page(folder: Path, *more: str) -> dict[str, Any]:
    (folder / "two.urdf").write_text(URDF, encoding="utf-8")
    trimesh.creation.icosphere(subdivisions=3, radius=0.2).export(folder / "part.stl")
    out = folder / "two.html"
    line = ["report", str(folder / "two.urdf"), "--tip", "d", "--task", "planar-position", "--starts", "200"]
    assert main.run([*line, "--exact-seconds", "0", "--quiet", "--out", str(out), *more]) in (0, 3)
    text = out.read_text(encoding="utf-8")
    assert ('id="meshes"' in text) is not bool(more)
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    data: dict[str, Any] = json.loads(found[1])
    return data


@pytest.mark.slow
def test_the_report_of_a_file_with_shapes_draws_them_unless_told_not_to(tmp_path: Path) -> None:
    drawn = page(tmp_path)["meshes"]
    assert [one["link"] for one in drawn] == [0, 1, 2]
    assert len(drawn[2]["faces"]) == 3 * 1280
    assert page(tmp_path, "--no-meshes")["meshes"] == []


@pytest.mark.slow
def test_what_cannot_be_drawn_is_told_unless_it_is_to_be_quiet(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "two.urdf").write_text(URDF, encoding="utf-8")  # part.stl is not there
    line = ["report", str(tmp_path / "two.urdf"), "--tip", "d", "--task", "planar-position", "--starts", "100",
            "--exact-seconds", "0", "--out", str(tmp_path / "two.html")]  # fmt: skip
    assert main.run(line) in (0, 3)
    assert "not drawn: " in capsys.readouterr().err
    assert main.run([*line, "--quiet"]) in (0, 3)
    assert capsys.readouterr().err == ""
