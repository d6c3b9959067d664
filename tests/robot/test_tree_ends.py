"""Base and tip of a URDF: named, chosen with a note, or refused with the candidates."""

from __future__ import annotations

import pytest

from rankdrop.errors import RobotError
from rankdrop.robot.urdf import from_urdf
from robot.urdf_text import chain, joint, robot


def fixed(parent: str, child: str) -> str:
    return joint(f"{parent}-{child}", parent, child, "fixed")


def finger(name: str, parent: str = "hand") -> str:
    return joint(name, parent, f"{name}_link", "prismatic")


ARM = chain(6)


def test_named_ends_are_taken_without_a_note() -> None:
    arm = from_urdf(robot(ARM), base="l1", tip="l4")
    assert (arm.base, arm.tip, arm.n, arm.notes) == ("l1", "l4", 3, ())


def test_chosen_ends_are_noted() -> None:
    arm = from_urdf(robot(ARM))
    assert (arm.base, arm.tip, arm.n) == ("base", "l6", 6)
    assert str(arm.notes[0]) == "base 'base' chosen: the root link"
    assert str(arm.notes[1]) == "tip 'l6' chosen: end of the longest chain, 6 moving joints"


def test_the_base_is_the_root_above_a_named_tip() -> None:
    two = robot([*ARM, *chain(2, "other_", "elsewhere")])
    assert from_urdf(two, tip="other_l2").base == "elsewhere"


@pytest.mark.parametrize(
    ("ends", "tip"),
    [
        (["flange", "tool0", "camera"], "tool0"), (["ee_link", "tool0"], "tool0"), (["camera", "arm_tcp"], "arm_tcp"),
        (["link_eef"], "link_eef"), (["end_effector", "camera"], "end_effector"), (["camera", "flange"], "flange"),
        (["camera", "attachment_site"], "attachment_site"), (["panda_hand", "camera"], "panda_hand"),
        (["stick"], "stick"), (["camera", "light"], "l6"),
    ],
)  # fmt: skip
def test_among_links_fixed_at_the_end_the_usual_name_decides(ends: list[str], tip: str) -> None:
    arm = from_urdf(robot([*ARM, *(fixed("l6", end) for end in ends)]))
    assert arm.tip == tip
    if len(ends) > 1:
        assert all(end in str(arm.notes[1]) for end in ends)


def test_the_farthest_of_fixed_links_in_a_row_is_the_tip() -> None:
    assert from_urdf(robot([*ARM, fixed("l6", "l7"), fixed("l7", "l8")])).tip == "l8"


def test_the_arm_ends_before_its_fingers() -> None:
    arm = from_urdf(robot([*ARM, fixed("l6", "hand"), fixed("hand", "hand_tcp"), finger("left"), finger("right")]))
    assert (arm.tip, arm.n) == ("hand_tcp", 6)
    assert "the gripper after it is left out (left, right)" in str(arm.notes[1])


def test_the_arm_ends_before_a_single_jaw() -> None:
    assert from_urdf(robot([*ARM, joint("jaw", "l6", "moving_jaw")])).n == 6
    assert from_urdf(robot([*ARM, joint("gripper_roll", "l6", "gripper_roll_link")])).n == 7


def test_a_short_side_branch_does_not_stop_the_chain() -> None:
    head = [joint("pan", "l1", "head1"), joint("tilt", "head1", "head2")]
    assert from_urdf(robot([*ARM, *head])).tip == "l6"


def test_equal_chains_are_refused_with_the_candidates() -> None:
    arms = [*chain(1), *chain(6, "left_", "l1"), *chain(6, "right_", "l1")]
    words = r"start at 'base'; got tips left_l6 \(7 joints\), right_l6 \(7 joints\); fix: name the tip: tip='left_l6'"
    with pytest.raises(RobotError, match=words) as caught:
        from_urdf(robot(arms), file="two.urdf")
    assert caught.value.on_command_line().endswith("fix: name the tip: --tip left_l6")
    assert from_urdf(robot(arms), tip="left_l6").n == 7


def hand(side: str, wrist: str, finger_length: int = 1) -> list[str]:
    """A palm with a tool frame on the wrist, and two fingers of some joints each."""
    fingers = [part for one in "ab" for part in chain(finger_length, f"{side}_{one}", f"{side}_palm")]
    return [fixed(wrist, f"{side}_palm"), fixed(f"{side}_palm", f"{side}_tool_link"), *fingers]


def test_two_hands_are_offered_by_their_tools_and_not_by_their_fingertips() -> None:
    torso, arms = chain(2, "torso_"), [*chain(7, "left_", "torso_l2"), *chain(7, "right_", "torso_l2")]
    two = [*torso, *arms, *hand("left", "left_l7", 3), *hand("right", "right_l7", 3)]
    tips = r"several limbs .* tips left_tool_link \(9 joints\), right_tool_link \(9 joints\);"
    with pytest.raises(RobotError, match=tips):
        from_urdf(robot(two))
    assert from_urdf(robot(two), tip="left_tool_link").n == 9


def test_a_longer_hand_does_not_make_an_arm_the_longer_one() -> None:
    arms = [*chain(6, "left_"), *chain(6, "right_"), *hand("right", "right_l6", 3)]
    with pytest.raises(RobotError, match=r"several limbs .* tips right_tool_link \(6 joints\), left_l6 \(6 joints\);"):
        from_urdf(robot(arms))
    longer = [*chain(7, "left_"), *chain(6, "right_"), *hand("right", "right_l6", 3)]
    assert from_urdf(robot(longer)).tip == "left_l7"


@pytest.mark.slow
def test_a_chain_of_thousands_of_joints_and_branches_is_walked() -> None:
    comb = [*chain(3000), *(joint(f"side{i}", f"l{i}", f"side_l{i}") for i in range(1, 2990))]
    with pytest.raises(RobotError, match="too many moving joints; got 3000; allowed: at most 200"):
        from_urdf(robot(comb))


def test_several_roots_are_refused_with_the_candidates() -> None:
    with pytest.raises(RobotError, match="several root links; got base, elsewhere; fix: name the base: base='base'"):
        from_urdf(robot([*ARM, *chain(2, "other_", "elsewhere")]))
    assert from_urdf(robot(ARM, links=["world"])).base == "base"


@pytest.mark.parametrize(
    ("base", "tip", "words"),
    [
        ("Base", None, "no link for the base; got 'Base'; .*did you mean base"),
        (None, "l66", "no link for the tip; got 'l66'; allowed: base, l1.*did you mean l6"),
        ("l4", "l2", "tip 'l2' is not below the base 'l4'; allowed: a base among: l1, base"),
        ("l4", "l4", "no moving joint between 'l4' and 'l4'"),
    ],
)
def test_ends_that_do_not_fit_are_refused(base: str | None, tip: str | None, words: str) -> None:
    with pytest.raises(RobotError, match=words):
        from_urdf(robot(ARM), base=base, tip=tip, file="arm.urdf")


def test_a_file_without_moving_joints_is_refused() -> None:
    with pytest.raises(RobotError, match="no moving joint in the file"):
        from_urdf(robot([fixed("a", "b")]))


@pytest.mark.slow
def test_a_chain_of_thousands_of_links_is_read() -> None:
    assert from_urdf(robot([*ARM, *(fixed(f"l{i}", f"l{i + 1}") for i in range(6, 3000))])).tip == "l3000"


def test_every_limb_of_a_humanoid_is_listed_hands_first() -> None:
    limbs = [*chain(5, "l_leg_"), *chain(5, "r_leg_"), *chain(4, "l_hand_"), *chain(4, "r_hand_")]
    tips = r"l_hand_l4 \(4 joints\), r_hand_l4 \(4 joints\), l_leg_l5 \(5 joints\), r_leg_l5 \(5 joints\);"
    with pytest.raises(RobotError, match=tips) as caught:
        from_urdf(robot(limbs))
    assert caught.value.on_command_line().endswith("fix: name the tip: --tip l_hand_l4")


def test_a_broken_joint_beside_the_chain_is_left_out_where_the_tip_is_named() -> None:
    text = robot([*chain(6, "a_"), fixed("a_l6", "gone")]).replace('<link name="gone"/>', "")
    with pytest.raises(RobotError, match="the child link is not in the file; got 'gone'"):
        from_urdf(text)
    arm = from_urdf(text, tip="a_l6")
    assert arm.n == 6
    assert any("left out: its child link 'gone' is not in the file" in str(note) for note in arm.notes)
    with pytest.raises(RobotError, match="there is no link for the tip"):
        from_urdf(text, tip="gone")


def test_a_broken_joint_that_carries_the_chain_is_refused() -> None:
    text = robot([fixed("gone", "a_l0"), *chain(6, "a_", "a_l0")]).replace('<link name="gone"/>', "")
    with pytest.raises(RobotError, match="the parent link is not in the file; got 'gone'"):
        from_urdf(text, tip="a_l6")
    assert from_urdf(text, tip="a_l6", base="a_l0").n == 6


def test_a_missing_link_above_the_arm_is_mended_by_naming_the_base() -> None:
    text = robot([fixed("gone", "a_l0"), *chain(6, "a_", "a_l0")]).replace('<link name="gone"/>', "")
    for tip in (None, "a_l6"):
        with pytest.raises(RobotError, match="start at the link below: base='a_l0'") as caught:
            from_urdf(text, tip=tip)
        assert caught.value.on_command_line().endswith("start at the link below: --base a_l0")
    arm = from_urdf(text, base="a_l0")
    assert (arm.n, arm.tip) == (6, "a_l6")
    assert any("left out: its parent link 'gone' is not in the file" in str(note) for note in arm.notes)


def test_a_missing_link_inside_the_arm_is_not_passed_over_where_the_base_is_named() -> None:
    text = robot([*chain(3, "a_"), fixed("gone", "b_l0"), *chain(3, "b_", "b_l0")]).replace('<link name="gone"/>', "")
    with pytest.raises(RobotError, match="the parent link is not in the file; got 'gone'"):
        from_urdf(text, base="base")
