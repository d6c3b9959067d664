"""A new time law: inside the limits at every instant, on the same path, nowhere faster, and not slower than it need be.

Derivatives are SciPy's own, of the polynomials through the rows that come out.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BPoly
from scipy.optimize import linprog

from rankdrop.path.curve import Curve, curve
from rankdrop.path.mend.retime import fastest, retime_path, usage
from rankdrop.path.read.trajectory import Trajectory

RATES = np.array([2.0, 1.5, 2.5, 3.0, np.inf, 3.0])
LIMITS = np.array([8.0, 6.0, 9.0, np.inf, 12.0, 12.0])
NONE = np.full(6, np.inf)
SCALE = np.ones(6)


def bow(rows: int, seconds: float, seed: int = 0) -> dict[str, np.ndarray]:
    """Six joints on sums of two sines, with derivatives."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, seconds, rows)
    w, phase = rng.uniform(1.0, 6.0, (2, 6)) / seconds, rng.uniform(0, 6, (2, 6))
    angle = t[:, None, None] * w + phase
    return {"q": np.sin(angle).sum(1), "t": t, "v": (w * np.cos(angle)).sum(1), "a": (-(w**2) * np.sin(angle)).sum(1)}


def path_of(one: dict[str, np.ndarray], how: str) -> Curve:
    return curve(one["q"], one["t"], one["v"], one["a"], how)


def polynomial(made: Trajectory, how: str) -> BPoly:
    parts = [made.q] + [part for part in (made.velocities, made.accelerations) if part is not None]
    return BPoly.from_derivatives(made.times, np.stack(parts[: {"linear": 1, "cubic": 2, "quintic": 3}[how]], axis=1))


def instants(times: np.ndarray, each: int = 41) -> np.ndarray:
    share = np.linspace(1e-9, 1 - 1e-9, each)
    return (times[:-1, None] + share * np.diff(times)[:, None]).reshape(-1)


@pytest.mark.spread(3)
@pytest.mark.slow
@pytest.mark.parametrize("how", ["cubic", "quintic"])
@pytest.mark.parametrize("seed", range(2))
def test_limits_hold_at_every_instant_and_the_bounds_are_tight(how: str, seed: int) -> None:
    one = bow(12, 0.9, seed)
    path = path_of(one, how)
    assert usage(path, RATES, LIMITS).slower > 1.3
    made = retime_path(path, RATES, LIMITS, SCALE)
    spline, at = polynomial(made, how), instants(made.times)
    most = (np.abs(spline.derivative()(at)) / RATES).max(), (np.abs(spline.derivative(2)(at)) / LIMITS).max()
    took = usage(curve(made.q, made.times, made.velocities, made.accelerations, how), RATES, LIMITS)
    for share, bound in zip(most, (took.rate, took.acceleration), strict=True):
        assert share * (1 - 1e-7) <= bound <= 1.0  # rounding of SciPy's second derivative
        assert share >= 0.9 * bound
    assert max(most) > 0.9  # not slower than it need be


@pytest.mark.parametrize("how", ["cubic", "quintic"])
@pytest.mark.parametrize("rows", [8])
def test_smooth_paths_stay_where_they_were_to_1e_9(how: str, rows: int) -> None:
    one = bow(rows, 1.0, 7)
    path = path_of(one, how)
    made = retime_path(path, RATES, LIMITS, SCALE)
    old, new = polynomial(Trajectory("", one["t"], one["q"], True, (), one["v"], one["a"]), how), polynomial(made, how)
    at = np.sort(np.random.default_rng(1).choice(instants(made.times, 7), 120, replace=False))
    q = new(at)
    tau = one["t"][0] + np.linspace(0, 1, 1001) * np.ptp(one["t"])
    near = tau[np.array([np.abs(old(tau) - point).max(axis=1).argmin() for point in q])]
    for _ in range(6):
        slope = old.derivative()(near)
        near = np.clip(near + ((q - old(near)) * slope).sum(1) / (slope**2).sum(1), tau[0], tau[-1])
    assert np.linalg.norm(q - old(near), axis=1).max() < 1e-9
    assert (np.diff(near) >= -1e-6).all()  # onwards
    assert (np.diff(near) <= np.diff(at) * (1 + 1e-6) + 1e-7).all()  # nowhere faster


def test_straight_paths_keep_their_rows_and_their_limits() -> None:
    one = bow(200, 0.8)
    path = path_of(one, "linear")
    made = retime_path(path, RATES, LIMITS, SCALE)
    np.testing.assert_array_equal(made.q[np.searchsorted(made.times, made.times)], made.q)
    rows = np.array([np.abs(made.q - point).max(axis=1).argmin() for point in one["q"]])
    np.testing.assert_allclose(made.q[rows], one["q"], atol=1e-15)
    assert (np.diff(made.times[rows]) >= np.diff(one["t"]) * (1 - 1e-12)).all()
    speed = np.diff(made.q, axis=0) / np.diff(made.times)[:, None]
    assert (np.abs(speed) <= RATES * (1 + 1e-9)).all()
    middle = np.concatenate([made.times[:1], (made.times[1:] + made.times[:-1]) / 2, made.times[-1:]])
    speed = np.concatenate([np.zeros((1, 6)), speed, np.zeros((1, 6))])
    gain = np.abs(np.diff(speed, axis=0) / np.diff(middle)[:, None])
    assert (gain <= LIMITS * (1 + 1e-9)).all()
    assert (gain / LIMITS).max() > 0.99


def test_only_what_is_too_fast_is_slowed_down() -> None:
    t = np.linspace(0.0, 4.0, 401)
    q = np.zeros((401, 6))
    q[:, 1] = np.cumsum(np.where(np.abs(t - 2.0) < 0.1, 6.0, 0.5)) * 0.01
    made = retime_path(curve(q, t), RATES, NONE, SCALE)
    new, old = np.diff(made.times), np.diff(t)
    quick = np.abs(np.diff(q[:, 1])) > 0.03
    np.testing.assert_allclose(new[~quick], old[~quick], rtol=1e-9)
    np.testing.assert_allclose(new[quick], 0.06 / 1.5, rtol=1e-9)


@pytest.mark.parametrize("how", ["linear", "cubic", "quintic"])
def test_a_path_inside_its_limits_takes_the_time_it_took(how: str) -> None:
    one = bow(40, 30.0)
    made = retime_path(path_of(one, how), RATES, NONE if how == "linear" else LIMITS, SCALE)
    assert np.ptp(made.times) == pytest.approx(30.0, rel=1e-9)


def test_a_straight_path_is_bounded_from_rest_to_rest() -> None:
    took = usage(curve(np.array([[0.0], [1.0], [3.0]]), np.array([0.0, 1.0, 2.0])), np.array([4.0]), np.array([2.0]))
    assert (took.rate, took.acceleration) == (0.5, 2.0)  # from 2 rad/s to rest in half a second


@pytest.mark.parametrize(("way", "rate", "limit"), [(1.0, 9.0, 4.0), (2.0, 1.0, 5.0), (0.3, np.inf, 2.0)])
def test_from_rest_to_rest_it_takes_the_time_of_the_closed_form(way: float, rate: float, limit: float) -> None:
    best = 2 * np.sqrt(way / limit) if way * limit < rate**2 else way / rate + rate / limit
    path = curve(np.array([[0.0], [way]]), None)
    took = np.ptp(retime_path(path, np.array([rate]), np.array([limit]), np.ones(1)).times)
    assert best <= took <= 1.03 * best


def test_a_corner_is_passed_slowly_and_a_rest_is_kept() -> None:
    q = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0], [0.0, 1.0]])
    rates, limits = np.array([3.0, 3.0]), np.array([5.0, 5.0])
    made = retime_path(curve(q, np.array([0.0, 1.0, 2.0, 2.5, 3.5])), rates, limits, np.ones(2))
    assert np.isfinite(made.times).all()
    took = usage(curve(made.q, made.times), rates, limits)
    assert took.slower <= 1 + 1e-9
    rest = [i for i in range(len(made.q) - 1) if (made.q[i] == made.q[i + 1]).all()]
    assert sum(np.diff(made.times)[rest]) >= 0.5 * (1 - 1e-12)
    assert np.ptp(made.times) < 12.0


@pytest.mark.parametrize("seed", range(4))
def test_the_law_on_the_grid_is_the_best_there_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count, joints = 25, 3
    alpha, limits = rng.uniform(0.2, 1, (count, joints)), rng.uniform(0.5, 2, joints)
    cap = rng.uniform(0.5, 9, count + 1)
    beta = alpha * rng.uniform(0.3, 1.6, (count, joints))
    y = fastest(alpha, beta, limits, cap)
    rows, sides = [], []
    for k in range(count):
        for j in range(joints):
            row = np.zeros(count + 1)
            row[k + 1], row[k] = alpha[k, j], -beta[k, j]
            rows += [row, -row]
            sides += [limits[j], limits[j]]
        row = np.zeros(count + 1)
        row[k], row[k + 1] = 0.25, -1.0
        rows.append(row)
        sides.append(0.0)
    best = linprog(-np.ones(count + 1), np.array(rows), np.array(sides), bounds=[(0, c) for c in cap])
    np.testing.assert_allclose(y, best.x, atol=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_the_law_on_the_grid_holds_where_joints_turn_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    alpha, beta = rng.normal(size=(2, 60, 4))
    alpha[5], beta[9] = 0.0, 0.0
    limits, cap = rng.uniform(0.5, 2, 4), rng.uniform(0.5, 9, 61)
    y = fastest(alpha, beta, limits, cap)
    assert (y > 0).all()
    assert (y <= cap).all()
    flat = np.abs(alpha) < 1e-12
    assert (np.abs(alpha * y[1:, None] - beta * y[:-1, None]) <= limits * (1 + 1e-9))[~flat].all()


@pytest.mark.cross
def test_toppra_is_not_faster_by_much_nor_we_faster_than_it() -> None:
    toppra = pytest.importorskip("toppra", reason='the extra "cross" is not installed')
    one = bow(15, 0.2, 5)
    rates, limits = np.full(6, 2.0), np.full(6, 8.0)
    path = path_of(one, "cubic")
    made = retime_path(path, rates, limits, SCALE)
    spline = polynomial(Trajectory("", one["t"], one["q"], True, (), one["v"], one["a"]), "cubic")

    class Path(toppra.interpolator.AbstractGeometricPath):
        dof, path_interval, waypoints = 6, (0.0, 0.2), None

        def __call__(self, at, order=0):
            return spline(at) if order == 0 else spline.derivative(order)(np.clip(at, 1e-12, 0.2 - 1e-12))

    pairs = [np.stack([-one_, one_], axis=1) for one_ in (rates, limits)]
    law = toppra.algorithm.TOPPRA(
        [toppra.constraint.JointVelocityConstraint(pairs[0]), toppra.constraint.JointAccelerationConstraint(pairs[1])],
        Path(), gridpoints=np.linspace(0, 0.2, 2001),
    )  # fmt: skip
    speed = law.compute_parameterization(*(float(np.sqrt(x)) for x in _ends(made, path)))[1]
    step = np.diff(np.linspace(0, 0.2, 2001))
    theirs = float((2 * step / (speed[1:] + speed[:-1])).sum())
    assert 0.99 * theirs < np.ptp(made.times) < 1.05 * theirs


def _ends(made: Trajectory, path: Curve) -> tuple[float, float]:
    """Squares of the path's speed at its ends, as they came out."""
    assert made.velocities is not None
    slope = path.slope(np.array([0, len(path.control) - 1]), np.array([0.0, 1.0])) / np.diff(path.times)[0]
    return tuple((np.linalg.norm(made.velocities[[0, -1]], axis=1) / np.linalg.norm(slope, axis=1)) ** 2)
