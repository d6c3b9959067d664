"""The data behind the figures, and the files."""

from __future__ import annotations

import json

import numpy as np
import pytest

pytest.importorskip("flint")

from papers import am_pictures, figures, other_pictures
from papers.am_descent import STEPPED, descend, run
from papers.am_method import BEFORE
from papers.am_robots import FIGURE_9, row_configuration
from papers.picture import RED
from rankdrop.errors import OptionError
from rankdrop.families.searching import Outcome
from rankdrop.kinematics import jacobian
from rankdrop.local.block import singular_values
from rankdrop.robot.open import open_robot
from rankdrop.task import SPACE, resolve_task


def test_figure_1_ties_and_is_stuck():
    picture = am_pictures.descent(1)
    values, angles, slow, turning = picture.panels
    assert [line.label for line in values.lines] == ["σ5", "σ6"]
    assert values.level == 1e-6
    five, six = (line.points for line in values.lines)
    assert run(1).first_tie() == 6
    assert five[-1, 1] == pytest.approx(5.1e-4, rel=0.02)
    assert six[-1, 1] == pytest.approx(five[-1, 1], rel=1e-3)
    assert np.all(five[:, 1] >= six[:, 1])
    assert len(angles.lines[0].points) == run(1).iterations
    treated = run(1, "almarkhi")
    assert treated.outcome is Outcome.CONVERGED
    assert treated.iterations == 20
    assert "stuck on the crease" in picture.caption
    assert slow.lines[0].points[-1, 1] < 1e-6
    assert len(slow.lines[0].points) > 2000, "AM's takes about 3000"
    assert descend(STEPPED[1]).first_tie() < 100
    assert np.nanmax(turning.lines[0].points[:, 1]) > 170.0


def test_figure_2_turns_back_and_forth_goes_up_and_never_converges():
    _, square, values, angles = am_pictures.descent(2).panels
    assert np.nanmax(np.abs(square.lines[0].points[1:, 1] - 90.0)) < 1.0, "an exact line search turns by right angles"
    assert np.nanmax(angles.lines[0].points[:, 1]) > 170.0
    four = values.lines[0].points[:, 1]
    assert (np.diff(four) > 0.0).any()
    assert four[-1] > 1e-3


def test_figure_3_turns_by_120_degrees_on_average_and_converges():
    *_, values, angles = am_pictures.descent(3).panels
    assert np.nanmean(angles.lines[0].points[:, 1]) == pytest.approx(120.0, abs=5.0)
    assert values.lines[0].points[-1, 1] < 1e-6


def test_figures_2_and_3_start_together_meet_a_tie_and_end_apart():
    stuck, through = run(2), run(3)
    assert np.array_equal(stuck.sigma[0], through.sigma[0])
    assert stuck.first_tie() == through.first_tie() == 3
    assert np.array_equal(stuck.sigma[:4], through.sigma[:4]), "the treatment begins at the tie"
    assert not np.array_equal(stuck.sigma[4], through.sigma[4])
    assert stuck.outcome is not Outcome.CONVERGED
    assert stuck.sigma[-1, 3] == pytest.approx(0.13, abs=0.005)
    assert through.outcome is Outcome.CONVERGED
    assert through.iterations == 34


@pytest.mark.slow
def test_figure_5_is_singular_and_stays_in_the_box():
    robot = open_robot("almarkhi4")
    flat, deep = am_pictures.figure_5().panels
    assert len(flat.lines) == len(deep.lines) == 4
    for line in deep.lines:
        points = line.points[~np.isnan(line.points[:, 0])]
        assert np.abs(points).max() <= np.pi + 1e-12
        q = np.concatenate([np.zeros((len(points), 1)), points], axis=1)
        assert singular_values(robot, q, resolve_task(None, robot))[:, 2].max() < 1e-9
        steps = np.linalg.norm(np.diff(line.points, axis=0), axis=1)
        assert np.nanmax(steps) < 0.1, "a jump across the box is drawn"
    assert [line.points.shape[1] for line in flat.lines] == [2] * 4


def test_figure_6_shows_both_directions():
    for panel, angle in zip(am_pictures.figure_6().panels, (14.4, 9.2), strict=True):
        ours, printed = (arrow.vector for arrow in panel.arrows)
        assert np.degrees(np.arccos(ours @ printed)) == pytest.approx(angle, abs=0.1)
        assert np.allclose(panel.arrows[0].start, panel.arms[0].drawn.links[-1])


@pytest.mark.parametrize(("picture", "corank", "places"), [
    (am_pictures.figures_7_8(7), 1, [row_configuration(1, row) for row in range(1, 5)]),
    (am_pictures.figures_7_8(8), 2, [row_configuration(2, row) for row in range(1, 5)]),
    (am_pictures.figure_9(), 3, [np.array(theta) for theta in FIGURE_9.values()]),
])  # fmt: skip
def test_arrows_of_the_pa10_are_lost_motions(picture, corank, places):
    for panel, q in zip(picture.panels, places, strict=True):
        (arm,) = panel.arms
        assert (arm.robot, arm.drawn.numbers) == ("pa10", (1, 2, 3, 4, 5, 6, 7))
        assert np.array_equal(arm.q, q)
        assert all(np.allclose(arrow.start, arm.drawn.links[-1]) for arrow in panel.arrows)
        J = jacobian(open_robot("pa10"), q)
        names = {arrow.label for arrow in panel.arrows}
        assert len(names) == corank
        for name in names:
            twist = np.zeros(6)
            for arrow in panel.arrows:
                if arrow.label == name:
                    twist[3 * arrow.rotation :][:3] = arrow.vector
            assert np.abs(twist @ J).max() < 1e-12
            assert np.linalg.norm(twist) == pytest.approx(1.0)


def test_figure_4_has_the_printed_entries():
    rotated = am_pictures.figure_4().panels[1]
    green = [arrow for arrow in rotated.arrows if arrow.label == "u4"]
    assert [arrow.rotation for arrow in green] == [True]
    assert np.allclose(green[0].vector, [-1, 0, 0])
    sizes = sorted(round(float(np.linalg.norm(arrow.vector)), 2) for arrow in rotated.arrows)
    assert sizes == [0.41, 0.41, 0.91, 0.91, 1.0]


def twists(panel):
    """(6, 3) the directions that are drawn, u4, u5, u6, put together from their arrows."""
    found = np.zeros((6, 3))
    for arrow in panel.arrows:
        found[3 * arrow.rotation :, int(arrow.label[1]) - 4][:3] = arrow.vector
    return found


def test_figure_4_starts_from_the_printed_vectors_which_are_not_along_axes():
    before, after = (twists(panel) for panel in am_pictures.figure_4().panels)
    printed = np.array([float(word) for word in BEFORE.split()]).reshape(6, 3)
    assert np.abs(before - printed).max() < 0.011, "they are printed to two digits"
    assert np.allclose(before.T @ before, np.eye(3))
    assert np.allclose(after @ after.T @ before, before), "the same motions are lost"
    assert (np.abs(before[1:]) > 0.05).all()
    assert (np.abs(after) > 0.05).sum() == 5


def test_the_planar_arm_of_ml_cannot_move_along_link_1():
    for panel in other_pictures.planar_arm().panels:
        lost, left = panel.arrows
        J = jacobian(open_robot("planar2r"), panel.arms[0].q)[:3]
        assert np.abs(lost.vector @ J).max() < 1e-12
        assert np.abs(left.vector @ J).max() > 0.2
    x1, y1 = other_pictures.joint_rates().panels[0].arrows
    assert np.allclose(x1.vector[:2], [np.cos(0.5), np.sin(0.5)])
    assert np.allclose(y1.vector[:2], [-np.sin(0.5), np.cos(0.5)])


@pytest.mark.parametrize("document", ["ML", "JL"])
def test_the_wrist_loses_the_rotation_square_to_z3_and_z4(document):
    regular, zero, half_turn = other_pictures.spherical_wrist(document).panels
    assert [arrow.label for arrow in regular.arrows] == ["z3", "z4", "z5"]
    for panel, sense in ((zero, 1.0), (half_turn, -1.0)):
        z3, z4, z5, lost = (arrow.vector for arrow in panel.arrows)
        assert np.allclose(z5 / np.linalg.norm(z5), sense * z3)
        assert np.allclose([lost @ z3, lost @ z4], 0.0, atol=1e-12)
        assert panel.arrows[-1].rotation
        assert panel.arms[0].drawn.numbers == (4, 5, 6)
        assert np.allclose(panel.arrows[0].start, panel.arms[0].drawn.links[0])


def test_axes_of_the_elbow_arm_are_where_the_joints_are():
    panel = other_pictures.elbow_arm_figure("JL").panels[0]
    for arrow, axis, at in zip(panel.arrows, panel.arms[0].drawn.axes, panel.arms[0].drawn.middles, strict=True):
        assert np.allclose(np.cross(arrow.vector, axis), 0.0, atol=1e-12)
        assert np.allclose(np.cross(at - arrow.start, axis), 0.0, atol=1e-12)


def test_the_mapping_of_jl_takes_what_is_moved_along_the_null_space_to_the_same_velocities():
    picture = other_pictures.mapping()
    for rates, velocities, place in zip(
        picture.panels[::2], picture.panels[1::2], picture.numbers["places"].values(), strict=True
    ):
        J = jacobian(open_robot("planar3r"), place["q"])[:2]
        assert place["rank"] == np.linalg.matrix_rank(J, tol=1e-9) == 3 - place["nullity"]
        inside, moved, back = (line.points for line in velocities.lines[:3])
        assert np.allclose(moved, inside)
        assert np.allclose(back, inside)
        assert np.linalg.norm(rates.lines[1].points - rates.lines[0].points, axis=1).min() > 0.5
        assert np.linalg.matrix_rank(inside, tol=1e-9) == place["rank"]
        null = np.concatenate([line.points for line in rates.lines if line.colour == RED])
        assert np.linalg.matrix_rank(null, tol=1e-9) == place["nullity"]
        assert np.allclose(J @ null.T, 0.0, atol=1e-12)


def test_screws_of_gr_figure_1_are_those_of_its_joints():
    (panel,) = other_pictures.typical_arm().panels
    screws = jacobian(open_robot("pa10"), panel.arms[0].q, SPACE).T
    assert len(panel.arrows) == 7
    for arrow, screw in zip(panel.arrows, screws, strict=True):
        assert np.allclose(arrow.vector / np.linalg.norm(arrow.vector), screw[3:])
        assert np.allclose(np.cross(arrow.start, screw[3:]), screw[:3])


def test_screw_axes_of_gr_are_where_the_screws_are():
    data = other_pictures.screw_axes().numbers["axes"]
    assert [axis["revolute"] for axis in data] == [True, False, True, True, True, True, True]
    assert data[0]["point"] == [0, 1, 0]
    assert data[3]["point"] == [5, 0, 0]
    assert np.allclose([axis["point"] for axis in data[5:]], np.array([10, 0, 0]))


def test_canadarm2_of_kg():
    numbers = other_pictures.canadarm2().numbers
    assert len(numbers["link_parameters"]) == 7
    assert numbers["link_parameters"][3]["a_{j-1}"] == "d"


def test_joint_rates_of_ml_blow_up_along_the_arm_only():
    along, _, across = (line.points for line in other_pictures.joint_rates().panels[1].lines)
    assert along[0, 1] > 1000.0
    assert np.allclose(across[:, 1], 1.0)


def test_lost_motions_of_jl():
    elbow, shoulder = other_pictures.arm_singularities("JL").panels
    third = other_pictures.forearm(elbow.arms[0].q)
    assert np.allclose(np.cross(elbow.arrows[0].vector, third), 0.0, atol=1e-12)
    assert np.allclose(shoulder.arrows[0].start[:2], 0.0, atol=1e-12)
    assert np.allclose(np.cross(shoulder.arrows[0].vector, shoulder.arms[0].drawn.axes[1]), 0.0, atol=1e-12)


@pytest.mark.by_hand
def test_files_are_written_and_hold_the_numbers(tmp_path):
    files = figures.save_figures(("GR", "JL"), str(tmp_path / "new"))
    assert [path.name for path in files] == [
        f"{name}.{ending}" for name in ("GR-figure-1", "GR-figure-2", "JL-anthropomorphic-arm", "JL-spherical-wrist",
                                        "JL-arm-singularities", "JL-joint-to-operation")
        for ending in ("svg", "png", "json")
    ]  # fmt: skip
    assert all(path.stat().st_size > 500 for path in files)
    data = json.loads(files[5].read_text())
    assert data["figure"] == "Figure 2"
    assert [joint["kind"] for joint in data["panels"][0]["arms"][0]["joints"]].count("prismatic") == 1
    assert len(data["panels"][0]["lines"]) == 7
    assert "http" not in files[0].read_text().replace("http://www.w3.org", "").replace("http://purl.org", "").replace(
        "http://creativecommons.org", ""
    ), "only the names of formats"


@pytest.mark.by_hand
def test_the_same_figure_is_the_same_file(tmp_path):
    one, other = (figures.save_figures(("GR",), str(tmp_path / name)) for name in "ab")
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in other]


def test_a_folder_that_cannot_be_is_refused_in_one_line(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "no" / "such"):
        with pytest.raises(OptionError, match="--figures"):
            figures.check_folder(str(folder))


@pytest.mark.by_hand
def test_every_document_has_its_figures(tmp_path):
    files = figures.save_figures(("AM", "ML", "GR", "KG", "JL"), str(tmp_path))
    assert {path.stem for path in files} >= {f"AM-figure-{n}" for n in range(1, 10)} | {"KG-figure-1", "GR-figure-2"}
