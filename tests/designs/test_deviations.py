"""The error of the difference of two designs, by samples that are paired."""

from __future__ import annotations

import numpy as np
import pytest

from rankdrop.designs.deviations import deviations
from rankdrop.designs.ranking import bits_to_text

SAMPLES = 2000


def test_the_error_of_a_difference_is_that_of_paired_samples(rng: np.random.Generator) -> None:
    first, second = (rng.random(SAMPLES) < p for p in (0.3, 0.5))
    paired = (first.astype(float) - second).std() / np.sqrt(SAMPLES)
    for measure in ("near", "slow"):
        records = [{measure: {"samples": SAMPLES, "hits": bits_to_text(hits)}} for hits in (first, second)]
        z = [deviations(record, measure) for record in records]
        assert np.linalg.norm(z[0] - z[1]) == pytest.approx(paired, rel=1e-12)


def test_a_pose_that_is_not_reached_counts_as_one_that_is_missing() -> None:
    z = deviations({"region": {"each": [0.5] * 30 + [None] * 10}}, "reached")
    assert np.linalg.norm(z) == pytest.approx(np.sqrt(0.75 * 0.25 / 40), rel=1e-12)


def test_without_samples_there_is_no_error() -> None:
    assert deviations({}, "near").size == deviations({}, "reached").size == deviations({}, "sigma").size == 0
