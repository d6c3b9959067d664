"""States as links, sessions as path files, arms from a file, the tour, the handle and the ghost; without a browser."""

from __future__ import annotations

from collections.abc import Iterator
from http.client import HTTPConnection
from threading import Thread
from types import SimpleNamespace

import numpy as np
import pytest
from patience import until

from rankdrop.cli.opening import ArmOptions
from rankdrop.cli.view import _command
from rankdrop.errors import RobotError
from rankdrop.families.lost import LostFreedom
from rankdrop.kinematics import pose
from rankdrop.local.block import singular_values
from rankdrop.results.explanation import Explanation
from rankdrop.robot.open import open_robot
from rankdrop.task import Frame, resolve_task

pytest.importorskip("viser", reason="viser and trimesh are not installed")

from rankdrop.path.read.csv_file import parse_trajectory
from rankdrop.viewer.controls import pull_towards
from rankdrop.viewer.scene import Now
from rankdrop.viewer.server import Viewer, Wishes
from rankdrop.viewer.tab_families import sentence_of, stops_of
from rankdrop.viewer.tab_path import path_csv, state_of, state_text

ARM = open_robot("ur5e")
TASK = resolve_task(None, ARM)
START = np.radians([20.0, -70.0, 80.0, -100.0, -80.0, 10.0])
URDF = """<robot name="two"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    made = Viewer(ARM, TASK, Wishes(port=0, q=START))
    until(lambda: made.controls.found is not None)
    yield made
    made.close()


def test_a_state_goes_to_a_link_and_back() -> None:
    assert state_of(f"/?q={state_text(ARM, START)}", ARM) == pytest.approx(START, abs=1e-7)
    slides = open_robot("stanford")
    q = np.array([0.1, -0.2, 0.35, 0.4, 0.5, -0.6])
    assert state_of(f"/?token=x&q={state_text(slides, q)}", slides) == pytest.approx(q, abs=1e-6)


@pytest.mark.parametrize("path", ["/", "/?q=1,2", "/?q=1,2,3,4,5,nan", "/?q=a,b,c,d,e,f", "/?q=1,2,3,4,5,9e999"])
def test_a_link_that_says_nothing_moves_nothing(path: str) -> None:
    assert state_of(path, ARM) is None


@pytest.mark.slow
def test_who_opens_the_link_finds_the_arm_there(viewer: Viewer) -> None:
    target = np.radians([0.0, -90.0, 60.0, 0.0, 80.0, 0.0])
    port = viewer.server.get_port()
    connection = HTTPConnection("127.0.0.1", port, timeout=180)
    connection.request("GET", f"/?q={state_text(ARM, target)}", headers={"Host": f"127.0.0.1:{port}"})
    assert connection.getresponse().status == 200
    connection.close()
    until(lambda: bool(np.allclose(viewer.session.q, target, atol=1e-6)))
    until(lambda: state_text(ARM, target) in viewer.share.ui.link.value)
    until(lambda: viewer.share.ui.line.value == f"rankdrop view ur5e --deg --q={state_text(ARM, target)}")


@pytest.mark.slow
def test_a_recorded_session_is_a_path(viewer: Viewer) -> None:
    viewer.share.record()
    viewer.session.go(START)
    until(lambda: not viewer.session.moving and np.allclose(viewer.session.q, START))
    until(lambda: bool(np.allclose(viewer.share.rows[-1][1], START)))
    viewer.share.record()
    count = len(viewer.share.rows)
    read = parse_trajectory(path_csv(ARM, viewer.share.rows), "session.csv", ARM)
    assert count == len(read.q) > 5
    assert read.q[-1] == pytest.approx(START, abs=1e-7)
    assert read.timed
    assert (np.diff(read.times) >= 0).all()


@pytest.mark.slow
def test_an_arm_of_ones_own_opens_in_a_viewer_of_its_own(viewer: Viewer) -> None:
    viewer.share.open(SimpleNamespace(name="two.urdf", content=URDF.encode()))
    assert viewer._others[-1].session.live.robot.n == 2
    assert viewer._others[-1].url in viewer.share.ui.opened.content
    assert viewer._others[-1].share._command == "rankdrop view two.urdf"


def test_the_command_that_is_shared_opens_the_same_arm_with_its_tool() -> None:
    options = ArmOptions(tip="wrist 2", as_written=True, package=("a=b",), length_scale=0.5)
    told = _command("my arm.urdf", options, "tool", "-0.1,0,0")
    words = "rankdrop view 'my arm.urdf' --frame=tool --tcp=-0.1,0,0 '--tip=wrist 2' --length-scale=0.5 --as-written"
    assert told == f"{words} --package=a=b"
    assert _command("ur5e", ArmOptions(), None, None) == "rankdrop view ur5e"


@pytest.mark.slow
def test_sliders_end_at_numbers_that_can_be_read() -> None:
    arm = open_robot("panda")  # −166.003062° … 166.003062°
    made = Viewer(arm, resolve_task(None, arm), Wishes(port=0))
    try:
        assert [(one.min, one.max) for one in made.controls.sliders[:2]] == [(-166.0, 166.0), (-101.0, 101.0)]
        made.session.set(arm.lower)
        until(lambda: bool(made.controls.sliders[0].value == -166.0))
        assert made.controls.sliders[0].min == -166.0
    finally:
        made.close()


@pytest.mark.parametrize(("name", "content"), [("evil.xacro", b"<robot/>"), ("arm.urdf", b"no xml"), ("arm", b"")])
def test_what_is_no_robot_file_is_refused_under_its_own_name(viewer: Viewer, name: str, content: bytes) -> None:
    with pytest.raises(RobotError, match=name):
        viewer.share.open(SimpleNamespace(name=name, content=content))


def test_the_tip_follows_the_hand() -> None:
    target = pose(ARM, START)
    target[:3, 3] += [0.03, -0.02, 0.04]
    q, missing = pull_towards(ARM, TASK, START, target)
    assert missing < 1e-5
    assert pose(ARM, q) == pytest.approx(target, abs=1e-4)


def test_the_handle_moves_the_arm(viewer: Viewer) -> None:
    viewer.session.set(START)
    target = pose(ARM, START)
    target[:3, 3] += [0.0, 0.0, 0.05]
    viewer.controls.pull(target)
    until(lambda: abs(float(pose(ARM, viewer.session.q)[2, 3]) - target[2, 3]) < 1e-4)


def test_the_ghost_stands_at_the_nearest_singular_posture(viewer: Viewer) -> None:
    for q in (START + 0.1, START):  # what is told of START is new then
        viewer.session.set(q)
        until(lambda q=q: viewer.controls.found is not None and np.array_equal(viewer.controls.found.q, q))
    until(lambda: viewer.stage._ghost[-1].visible)
    nearest = viewer.controls.found.far.nearest
    at = pose(ARM, np.array(nearest.q))[:3, 3]
    until(lambda: bool(np.allclose(viewer.stage._ghost[-1].position, at)))  # drawn a moment after it is explained
    assert not viewer.stage._ghost[0].visible  # a link that stands there already
    viewer.stage.show_ghost(None)
    viewer.on_look(viewer.session.live.look(START), None)  # drawn later than explained, as when it opens
    assert viewer.stage._ghost[-1].visible
    viewer.session.set(np.array(nearest.q))
    until(lambda: not viewer.stage._ghost[-1].visible)


def test_status_and_details_are_of_one_configuration(viewer: Viewer) -> None:
    viewer.session.set(START)
    until(lambda: viewer.controls.found is not None and np.array_equal(viewer.controls.found.q, START))
    until(lambda: "Next:" in viewer.controls._details.content)
    until(lambda: f"{viewer.controls.found.verdict}" in viewer.controls._status.content)
    assert "opacity:0.4" not in viewer.controls._details.content


@pytest.mark.slow
def test_what_is_told_of_an_older_configuration_does_not_stay(
    viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An explanation that is told while the arm moves on: the panel ends with where the arm is."""
    controls, here, other = viewer.controls, START + 0.05, START + 0.1
    viewer.session.set(here)
    until(lambda: controls.now is not None and np.array_equal(controls.now.q, here))
    until(lambda: controls.found is not None and np.array_equal(controls.found.q, here))
    found, tell = controls.found, controls._tell
    assert found is not None
    looking = Thread(target=controls.on_look, args=(viewer.session.live.look(other), None))

    def slowly(now: Now, of: Explanation | None) -> None:
        if of is not None and not looking.ident:
            looking.start()
            looking.join(timeout=0.5)
        tell(now, of)

    monkeypatch.setattr(controls, "_tell", slowly)
    controls.on_explanation(found)
    looking.join(timeout=180)
    assert controls.now is not None
    assert np.array_equal(controls.now.q, other)
    assert "to the singular set" in controls._status.content
    assert "opacity:0.4" in controls._details.content


@pytest.mark.by_hand
def test_the_tour_begins_with_shoulder_elbow_and_wrist(viewer: Viewer) -> None:
    names = [family.name.split(":")[0] for family in stops_of(viewer.session.live.families)]
    assert names[:3] == ["shoulder", "elbow", "wrist"]
    viewer._tour.go(1)
    until(lambda: not viewer.session.moving)
    assert "1 of 3" in viewer._tour._told.content
    assert singular_values(ARM, viewer.session.q, TASK)[5] < 1e-9
    viewer._tour.go(-1)
    until(lambda: not viewer.session.moving)
    assert "3 of 3" in viewer._tour._told.content


def test_a_stop_of_the_tour_is_one_sentence_without_numbers(viewer: Viewer) -> None:
    told = [sentence_of(family.lost_freedoms[0]) for family in viewer.session.live.families if family.corank == 1]
    assert told == [
        "The tool cannot move along the red arrow.",
        "The tool can hardly move along the red arrow.",
        "Moving along the red arrow and turning are tied together: one freedom of the tool is lost.",
    ]
    turning = LostFreedom((0, 0, 0, 1, 0, 0), Frame(5), everywhere=True)
    assert sentence_of(turning) == "The tool cannot turn about the red arrow."
    viewer._tour.place = 0
    viewer._tour.go(1)
    assert told[1] in viewer._tour._told.content
    assert "0.553 vx" in viewer._tour._told.content.split(told[1])[1]  # below it, in plain type
