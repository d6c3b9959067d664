"""A user's condition against the singular set: verdicts known by hand, counter-examples checked by the Jacobian."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest

from rankdrop import jacobian, open_robot
from rankdrop.algebra.work import OutOfTime, Work
from rankdrop.algebra.zeroset import independent
from rankdrop.codec import plain
from rankdrop.errors import OptionError
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.exact.lint import lint, round_points, words
from rankdrop.exact.tree import rank_tree
from rankdrop.local.block import generic_rank

PUMA = "s5 (d4 c3 + a3 s3) (a2 c2 + a3 c23 − d4 s23)"
UR5 = "s3 s5 (a2 c2 + a3 c23 + d5 s234)"


@cache
def singular(name, lengths="auto"):
    """(chain, irreducible sets that make up the singular set)."""
    chain = exact_chain(open_robot(name), lengths=lengths)
    tree = rank_tree(chain, Work())
    assert tree.complete
    pieces = independent([drop.piece for drop in tree.drops])
    assert pieces
    return chain, pieces


def checked(text, name, lengths="auto"):
    chain, pieces = singular(name, lengths)
    result = lint(text, pieces, chain)
    for one in (*result.missing, *result.extra):
        sigma = np.linalg.svd(jacobian(chain.robot, one.example.q)[list(chain.task.rows)], compute_uv=False)
        rank = int((sigma > 1e-8 * sigma[0]).sum())
        assert (rank < generic_rank(chain.robot, chain.task)) == (one in result.missing)
        assert (abs(one.example.value) > 1e-6) == (one in result.missing)
    json.dumps(plain(result))
    assert result.sentences()
    return result


@pytest.mark.slow_at("ur5")
@pytest.mark.parametrize(
    ("robot", "text", "verdict"),
    [
        ("puma560", PUMA, "exact"),
        ("puma560", "sin(q5)*(d4*cos(q3)+a3*sin(q3))*(a2*cos(q2)+a3*cos(q2+q3)-d4*sin(q2+q3))", "exact"),
        ("puma560", f"-3 s5 ({PUMA}) = 0", "exact"),
        ("puma560", "s5", "too small"),
        ("puma560", f"s3 {PUMA}", "too large"),
        ("puma560", PUMA.replace("−", "+"), "both"),
        ("puma560", "s5; s3", "too small"),
        ("puma560", "0", "too large"),
        ("ur5", UR5, "exact"),
        ("ur5", "θ5 = 0 or π", "too small"),
        ("stanford", "q3 s5 s2", "exact"),
        ("stanford", "s5 s2", "too small"),
        ("stanford", "(q3 - 0.3) q3 s5 s2", "too large"),
        ("planar2r", "q2 = 0 or pi", "exact"),
        ("planar2r", "q2 = 0", "too small"),
        ("scara", "s2", "exact"),
    ],
)
def test_verdicts(robot, text, verdict):
    result = checked(text, robot)
    assert result.verdict == verdict
    assert result.real
    assert bool(result.missing) == (verdict in ("too small", "both"))
    assert bool(result.extra) == (verdict in ("too large", "both"))


def test_missing_and_extra_sets_are_named():
    result = checked(f"c1 {PUMA.replace('s5 ', '')}", "puma560")
    assert sorted(one.conditions for one in result.missing) == ["θ5 = 0 or π"]
    assert sorted(one.conditions for one in result.extra) == ["θ1 = ±π/2"]
    text = " ".join(result.sentences())
    assert "too small and too large" in text
    assert "θ5 = 0 or π" in text
    assert "°" in text


def test_a_joint_at_pi_satisfies_what_vanishes_there():
    result = checked("s2; cos(q2/2) = 0; 1 + c2", "planar2r")
    assert [one.conditions for one in result.missing] == ["θ2 = 0"]
    assert not result.extra
    assert [one.conditions for one in checked("s1; 1 + c1", "planar2r").extra] == ["θ1 = π"]


def test_a_condition_without_a_real_zero_is_told():
    result = checked("s5**2 + 1", "puma560")
    assert not result.real
    assert result.verdict == "too small"
    assert "no real zero" in result.sentences()[0]


@pytest.mark.slow
def test_numbers_in_place_of_letters_hold_for_this_arm_only():
    result = checked("s3 s5 (0.425 c2 + 0.39225 c23 - 0.09465 s234)", "ur5")
    assert result.verdict == "exact"
    assert result.any_lengths is False
    assert "not for all lengths" in " ".join(result.sentences())
    assert checked(UR5, "ur5").any_lengths is True
    assert checked("s3 s5 (0.425 c2 + 0.39225 c23 - 0.09466 s234)", "ur5").verdict == "both"


@pytest.mark.slow
def test_numeric_chains_take_numbers_alone():
    result = checked("s3 s5 (0.425 c2 + 0.39225 c23 - 0.09465 s234)", "ur5", "numbers")
    assert result.verdict == "exact"
    assert result.any_lengths is None
    with pytest.raises(OptionError, match="write numbers"):
        checked(UR5, "ur5", "numbers")


def test_special_lengths_for_which_a_condition_always_holds_are_told():
    result = checked(f"(a2 - d5) {UR5}", "ur5")
    assert result.verdict == "exact"
    assert any("a2 - d5 = 0" in remark for remark in result.remarks)


def test_components_without_a_real_point_do_not_count():
    result = checked(f"(s1 + s4 + 3) {UR5}", "ur5")
    assert result.verdict == "exact"
    assert any("No real configuration" in remark for remark in result.remarks)


@pytest.mark.by_hand
def test_shifted_joints_are_spoken_of_by_theta():
    chain, pieces = singular("z1")
    assert chain.shifts.any()
    result = checked("s3", "z1")
    assert result.missing
    assert max(abs(angle) for one in result.missing for angle in one.example.degrees) <= 180
    with pytest.raises(OptionError, match="θ3 = q3"):
        lint("sin(q3)", pieces, chain)


def test_what_is_derived_is_exact_by_its_own_words():
    chain, pieces = singular("irb140")
    product = " ".join(f"({condition})" for condition in {words(piece).removesuffix(" = 0") for piece in pieces
                       if "θ" not in words(piece)}) + " s5 c3"  # fmt: skip
    pinned = {words(piece) for piece in pieces if "θ" in words(piece)}
    assert pinned == {"θ5 = 0", "θ5 = π", "θ3 = π/2", "θ3 = −π/2"}
    assert lint(product, pieces, chain).verdict == "exact"


@pytest.mark.by_hand
def test_real_points_lie_on_their_set_and_have_round_free_angles():
    chain, pieces = singular("puma560")
    for piece in pieces:
        found = [point for point, _ in zip(round_points(piece, chain), range(5), strict=False)]
        assert len(found) == 5
        for theta in found:
            sigma = np.linalg.svd(jacobian(chain.robot, theta - chain.shifts), compute_uv=False)
            assert sigma[-1] < 1e-12
            steps = np.degrees(theta) / 5
            assert (np.abs(steps - np.round(steps)) < 1e-9).sum() >= 5


def test_what_could_not_be_decided_is_told():
    chain, pieces = singular("planar2r")
    work = Work()
    work.leave({1: "pi"}, [])
    result = lint("s2", pieces, chain, work=work)
    assert not result.complete
    assert result.sentences()[0].startswith("As far as could be decided")
    assert "Not decided: θ1 = pi." in result.sentences()
    assert checked("s2", "planar2r").complete


@pytest.mark.slow
def test_the_deadline_holds():
    chain, pieces = singular("puma560")
    with pytest.raises(OutOfTime):
        lint(PUMA, pieces, chain, work=Work(0.0))


@pytest.mark.by_hand_at("s4; s2-both", "s4; s6-both")
@pytest.mark.by_hand_at("s4-both")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "verdict"), [("s4", "both"), ("s4; s2", "both"), ("s4; s6", "both"), ("s2; s6", "too small")]
)
def test_redundant_arms(text, verdict):
    """KG: of two sines of the Canadarm2's joints 2, 4 and 6 only those of 2 and 6 make a singularity together."""
    result = checked(text, "canadarm2")
    assert result.verdict == verdict
