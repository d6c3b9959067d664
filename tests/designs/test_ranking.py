"""Winners out of noise: variants that are equal by construction are not ranked, a clear winner is found."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rankdrop
from rankdrop.designs.ranking import bits_to_text, rank, threshold
from rankdrop.errors import OptionError

SAMPLES = 2000


def record(hits: np.ndarray) -> dict[str, Any]:
    near = {"any": {"error": 0.0}, "samples": len(hits), "hits": bits_to_text(hits)}
    return {"error": None, "measures": {"near": float(hits.mean())}, "near": near}


def region(sigma: list[float | None], bounds: tuple[float, float | None] = (0.0, None)) -> dict[str, Any]:
    known = [value for value in sigma if value is not None]
    measures = {"sigma": min(known), "reached": len(known) / len(sigma)}
    entry = {"each": sigma, "sigma_lower": bounds[0], "sigma_upper": bounds[1]}
    return {"error": None, "measures": measures, "region": entry}


@pytest.mark.parametrize("seed", range(5))
def test_equal_variants_with_other_samples_are_not_ranked(seed: int) -> None:
    rng = np.random.default_rng(seed)
    records = [record(rng.random(SAMPLES) < 0.2) for _ in range(200)]
    shares = [one["measures"]["near"] for one in records]
    assert max(shares) - min(shares) > 4 * np.sqrt(0.2 * 0.8 / SAMPLES)  # two errors alone would rank them
    found = rank(records, {"near": "less"})
    assert found.best == list(range(200))
    assert not found.differ


def test_a_clear_winner_among_equals_is_found() -> None:
    rng = np.random.default_rng(1)
    records = [record(rng.random(SAMPLES) < (0.1 if number == 77 else 0.2)) for number in range(200)]
    assert rank(records, {"near": "less"}).best == [77]
    assert 77 not in rank(records, {"near": "more"}).best


def test_differences_are_paired() -> None:
    """Two shares that differ by a tenth of their own errors, at the same samples but for 30."""
    hits = np.random.default_rng(2).random(SAMPLES) < 0.5
    fewer = hits.copy()
    fewer[np.flatnonzero(hits)[:30]] = False
    gap = hits.mean() - fewer.mean()
    assert gap < 2 * np.sqrt(0.25 / SAMPLES)
    assert rank([record(hits), record(fewer)], {"near": "less"}).best == [1]


def test_sigma_over_a_region_excludes_only_what_is_proven_smaller() -> None:
    few = [region([0.3] * 40, bounds) for bounds in ((0.29, 0.33), (0.32, 0.36), (0.34, 0.4))]
    assert rank(few, {"sigma": "more"}) == ([1, 2], False)  # 0.33 < 0.34; 0.36 is not below 0.34
    assert rank(few, {"sigma": "less"}).best == [0, 1]
    spent = [region([0.1] * 40, (0.0, None)), region([0.9] * 40, (0.89, 0.91))]
    assert rank(spent, {"sigma": "more"}) == ([0, 1], False)


def test_poses_that_are_not_reached_have_an_error_too() -> None:
    few, many = [0.5] * 20 + [None] * 20, [0.5] * 22 + [None] * 18
    assert rank([region(few), region(many)], {"reached": "more"}).best == [0, 1]
    assert rank([region(few), region([0.5] * 40)], {"reached": "more"}).best == [1]


def test_more_variants_need_larger_differences() -> None:
    assert threshold(200) > threshold(20) > threshold(2) == pytest.approx(1.96, abs=0.01)
    assert threshold(200, 2) > threshold(200)


OFFSETS = {
    "robot": "planar3r", "task": "planar-position", "near": {"within": "20 deg", "samples": 500},
    "parameters": {"zero": {"sets": "2.theta", "values": ["0 deg", "25 deg", "50 deg", "75 deg", "100 deg"]}},
}  # fmt: skip


@pytest.mark.by_hand
def test_a_sweep_over_where_a_joint_counts_from_has_no_winner() -> None:
    """The zero of a joint moves the families in joint space and changes no share."""
    found = rankdrop.sweep(OFFSETS, workers=1)
    assert len(set(found.values("near"))) > 1
    assert found.pareto == [0, 1, 2, 3, 4]
    assert "cannot be distinguished by their measures" in found.sentence
    assert found.summary[1].startswith("One of 5: zero ")  # no winner out of noise
    assert found.to_dict()["pareto_differ"] is False


@pytest.mark.slow
def test_a_sweep_ranks_by_the_share_in_which_the_tool_is_slow() -> None:
    """A shorter UR5e moves more slowly at the same joint rates; the configurations are the same for both."""
    found = rankdrop.sweep({
        "robot": "ur5e", "slow": {"speed": "200 mm/s", "samples": 4000},
        "parameters": {"upper_arm": {"sets": "2.a", "values": [-0.425, -0.2]}},
    }, workers=1)  # fmt: skip
    shares = found.values("slow")
    assert shares[0] < shares[1]
    assert found.pareto == [0]
    assert found.sentence == "Variant 1 is the best of 2 variants of ur5e."


NOTHING = {key: one for key, one in OFFSETS.items() if key != "near"} | {"families": {"starts": 50}}


@pytest.mark.by_hand
def test_precision_spends_more_samples() -> None:
    found = rankdrop.sweep(OFFSETS, workers=1, precision=0.003)
    assert all(one["near"]["any"]["error"] < 0.0034 for one in found.records)
    assert all(one["near"]["samples"] > 3000 for one in found.records)
    for wrong in (0.0, -1.0, 1e-9, float("nan"), 0.7):
        with pytest.raises(OptionError, match="precision"):
            rankdrop.sweep(OFFSETS, workers=1, precision=wrong)
    with pytest.raises(OptionError, match="nothing is sampled"):
        rankdrop.sweep(NOTHING, workers=1, precision=0.01)
