"""One conversion for what a caller hands in: whatever is no array of real numbers is refused in a sentence."""

from __future__ import annotations

import datetime
import decimal
import fractions
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import rankdrop
from known.planar import ARM, A
from rankdrop import path as paths
from rankdrop.errors import ConfigurationError
from rankdrop.poses.branches import self_motion_curves
from rankdrop.results.known import shipped

MASKED = np.ma.masked_array(A, [False, True, False])


@cache
def monitor() -> rankdrop.Monitor:
    """A monitor of the arm with its known families."""
    return rankdrop.Monitor(ARM, families=shipped("planar3r").families)


FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "pose": lambda q: rankdrop.pose(ARM, q), "jacobian": lambda q: rankdrop.jacobian(ARM, q),
    "jacobian_derivative": lambda q: rankdrop.jacobian_derivative(ARM, q),
    "singular_values": lambda q: rankdrop.singular_values(ARM, q),
    "nearest_singularity": lambda q: rankdrop.nearest_singularity(ARM, q),
    "redundancy": lambda q: rankdrop.redundancy(ARM, q), "escape": lambda q: rankdrop.escape(ARM, q),
    "explain": lambda q: rankdrop.explain(ARM, q), "check_path": lambda q: rankdrop.check_path(ARM, q),
    "row of check_path": lambda q: rankdrop.check_path(ARM, [A, q]),
    "times of check_path": lambda t: rankdrop.check_path(ARM, [A, A, A], t),
    "inverse": lambda pose: rankdrop.inverse(ARM, pose),
    "poses": lambda pose: paths.check_poses(ARM, [np.eye(4), pose]),
    "start of poses": lambda q: paths.check_poses(ARM, rankdrop.pose(ARM, [A]), start=q),
    "self-motions": lambda pose: self_motion_curves(ARM, pose),
    "look of a monitor": lambda q: monitor().look([A, q]), "monitor": lambda q: monitor().look_one(q),
    "step of a monitor": lambda q: monitor().step(q), "velocity of a monitor": lambda v: monitor().step(A, v),
    "distances of a monitor": lambda q: monitor().distances([A, q]), "nearby": lambda q: monitor().nearby(q),
}  # fmt: skip
BAD: dict[str, Any] = {
    "masked": MASKED, "masked in a list": [np.ma.masked, 0.1, 0.2], "masked row": [MASKED, A],
    "complex": np.array(A) + 0j, "complex in a list": [1j, 0, 0], "dates": np.array(["2020-01-01"] * 3, dtype="M8[D]"),
    "days": [datetime.date(2020, 1, 1)] * 3, "spans": np.array([1, 2, 3], dtype="m8[s]"), "texts": ["1", "2", "3"],
    "array of texts": np.array(["1", "2", "3"]), "objects of texts": np.array(["1", "2", "3"], dtype=object),
    "text": "0,0,0", "bytes": b"abc", "huge": [10**400, 0, 0], "long": [10**30, 0, 0],
    "huge and a float": [10**400, 0.5, 0],
    "beyond the digits": [10**5000, 0, 0], "nothing in it": [None] * 3, "dict": {"a": 1}, "set": {1.0, 2.0, 3.0},
    "object": object(), "ragged": [[1, 2], [3]], "function": len, "nan": [np.nan] * 3, "inf": [np.inf, 0, 0],
    "record": np.zeros(3, dtype=[("a", "f8")]), "raw": np.zeros(3, dtype="V8"), "empty": [], "number": 1.0,
    "booleans": [True] * 3, "array of booleans": np.array([True, False, True]), "mixed": [0.1, True, 0.3],
    "objects and a boolean": [fractions.Fraction(1, 2), True, 0.1], "boolean of NumPy": (0.1, np.bool_(True), 0.3),
    "array of a boolean": [np.array(True), 0.1, 0.3],
    "large decimal": [decimal.Decimal("1e999"), 0, 0], "range": range(1000),
}  # fmt: skip


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize("function", FUNCTIONS)
def test_what_is_no_configuration_is_refused_in_a_sentence(function: str, bad: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ConfigurationError) as caught:
            FUNCTIONS[function](BAD[bad])
    assert len(str(caught.value)) < 500


GOOD: dict[str, Any] = {
    "tuple": tuple(A), "nothing masked": np.ma.masked_array(A), "single": np.array(A, dtype=np.float32),
    "fractions": [fractions.Fraction(1, 2)] * 3, "decimals": [decimal.Decimal("0.5")] * 3, "integers": [1, 0, 2],
    "unsigned": np.array([2, 1, 0], dtype=np.uint8), "arrays": [np.float64(0.5), np.array(0.5), 0.5],
}  # fmt: skip


@pytest.mark.parametrize("good", GOOD)
def test_every_kind_of_real_numbers_is_a_configuration(good: str) -> None:
    q = np.array([float(one) for one in GOOD[good]])
    np.testing.assert_array_equal(rankdrop.pose(ARM, GOOD[good]), rankdrop.pose(ARM, q))
    np.testing.assert_array_equal(rankdrop.explain(ARM, GOOD[good]).q, q)
