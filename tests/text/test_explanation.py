"""The sentences and tables of `explain`."""

from __future__ import annotations

import numpy as np

from rankdrop.codec import encode
from rankdrop.local.ellipsoids import ellipsoids
from rankdrop.robot.open import open_robot
from rankdrop.robot.screws import from_screws, revolute
from rankdrop.schema.explanation import SHAPES
from rankdrop.verbs.explain import explain


def test_unit_balls_are_named_in_words_and_in_files() -> None:
    """SCARA has a slide, which counts by the length scale; without slides no length is named."""
    scara = ellipsoids(open_robot("scara"), [0.3, 0.4, 0.1, 0.2])
    scale = scara.length_scale
    planar = ellipsoids(open_robot("planar2r"), [0.3, 0.4])
    assert planar.unit_rates.ball == "Σ q̇² ≤ (1 rad/s)²; Σ τ² ≤ (1 N m)²"
    assert scara.unit_rates.ball == f"Σ q̇² ≤ (1 rad/s)², slides in units of {scale:.4g} m; Σ τ² ≤ (1 N m)²"
    limits = ellipsoids(open_robot("fetch8"), np.zeros(8)).rate_limits
    assert limits is not None
    assert encode(SHAPES, limits)["ball"] == limits.ball == "Σ (q̇/limit)² ≤ 1; Σ (τ · limit)² ≤ (1 W)²"


def test_lengths_in_mm_are_suspected() -> None:
    arm = from_screws([revolute([0, 0, 1], [x, 0, 0]) for x in (0.0, 300.0, 600.0)], order="linear-first", name="mm")
    assert "in mm?" in str(explain(arm, [0.1, 0.2, 0.3], "planar"))


def test_explain_tells_what_each_failure_leaves(run) -> None:
    ended = run("explain", "pa10", "--q", "0.3,-0.4,1.1,0.9,-0.7,1.3,0.5", "--evaluations", "0", "--full")
    told = " ".join(ended.out.split())
    assert "If one joint fails" in told
    assert "4 joint4 0 0 5 of 6 can" in told
