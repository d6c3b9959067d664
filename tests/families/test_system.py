"""Several equations at once: solutions, distances, and places where gradients vanish."""

from __future__ import annotations

import pickle
from math import pi

import numpy as np
import pytest

from rankdrop import _core
from rankdrop.families.linear_conditions import vanishing_on
from rankdrop.formula.equation import SOLVED, Equation, System, Term
from rankdrop.results.known import shipped
from rankdrop.robot.files import MOST_JOINTS

ZERO = (0, 0, 0)
CURVED = Equation((Term(1.0, "cos", (2, 0, 0), ZERO), Term(-0.5, "cos", (0, 2, 0), ZERO)))
SQUARE = Equation((Term(0.5, "cos", ZERO, ZERO), Term(-0.5, "cos", (0, 0, 4), ZERO)))  # sin² θ3


def test_solutions_solve(rng):
    system = System((CURVED, vanishing_on((0, 0, 1), (0.0, pi), periodic=True)))
    q, solved = system.solve(rng.uniform(-pi, pi, (200, 3)))
    assert solved.mean() > 0.95
    np.testing.assert_allclose(system.values(q[solved]), 0, atol=1e-12)
    assert (np.linalg.matrix_rank(system.jacobian(q[solved]), tol=1e-5) == 2).mean() > 0.95


def feet(system, leading, q, target, columns, iterations, farthest=np.inf, returns=2):
    settings = _core.FootSettings(
        leading=leading, iterations=iterations, returns=returns, still=1e-12, longest=0.7, cut=1e-7, flattest=1e-2,
        farthest=farthest, target=target.tolist(), scale=[1.0] * len(target), periodic=[0] * len(target),
        columns=columns, limits=None,
    )  # fmt: skip
    return _core.feet(system.compiled, np.ascontiguousarray(q), settings)


@pytest.mark.parametrize("arm", ["xarm6", "puma560", "slides"])
def test_steps_to_the_nearest_point_converge_quadratically(arm, rng):
    """With second derivatives that were wrong, four steps from 0.03 rad away would not end where 40 end: of 33
    terms, of three, and of products of slides' powers and waves."""
    if arm == "slides":
        made = (1.0, "cos", (2, 0, 0), (0, 1, 2)), (0.7, "sin", (2, 0, 0), (0, 0, 1)), (0.4, "cos", ZERO, (0, 3, 0))
        system, target, leading = System((Equation(tuple(Term(*one) for one in made)),)), np.array([0.4, 1.1, 0.9]), 1
    else:
        family = next(one for one in shipped(arm).families if one.coupled and one.equations)
        system, leading = family.system, len(family.witness) - family.dimension
        target = np.array(family.witness) + 0.1 * rng.normal(size=len(family.witness))
    columns = sorted({number - 1 for equation in system.equations for number in equation.joints})
    end = feet(system, leading, target[None], target, columns, 40)
    np.testing.assert_allclose(system.values(end), 0, atol=1e-11)
    away = np.zeros((10, len(target)))
    away[:, columns] = rng.normal(size=(10, len(columns)))
    away *= 0.03 / np.linalg.norm(away, axis=1, keepdims=True)
    again = feet(system, leading, end + away, target, columns, 4)
    np.testing.assert_allclose(again, np.repeat(end, 10, axis=0), atol=1e-8)
    # what leads farther than wanted is left at once, what does not goes on
    length = np.linalg.norm(end[0] - target)
    np.testing.assert_array_equal(feet(system, leading, end + away, target, columns, 4, 1.001 * length), again)
    left = feet(system, leading, end + away, target, columns, 4, 0.5 * length)
    assert (np.abs(left - end).max(axis=1) > 1e-12).all()
    # the way is normal to the zero set
    slope, way = system.jacobian(end)[0], (target - end[0])
    across = np.linalg.lstsq(slope.T, way, rcond=1e-7)[0] @ slope
    np.testing.assert_allclose(across[columns], way[columns], atol=1e-8)


@pytest.mark.parametrize("leading", [1, 2, 3])
def test_steps_on_the_first_equations_do_not_know_the_others(leading, rng):
    """Waves and second derivatives are worked out for the first equations alone, of which the longest is the last."""
    family = next(one for one in shipped("sawyer").families if one.coupled and one.equations)
    target, columns = np.array(family.witness), [1, 2, 3, 4, 5]
    starts = target + 0.3 * rng.normal(size=(10, len(target)))
    whole = feet(family.system, leading, starts, target, columns, 4, returns=0)
    alone = feet(System(family.equations[:leading]), leading, starts, target, columns, 4, returns=0)
    np.testing.assert_array_equal(whole, alone)
    assert (np.abs(whole - starts).max(axis=1) > 1e-3).all()


def test_a_system_goes_to_another_process():
    system = System((CURVED,))
    assert system.compiled is not None
    assert pickle.loads(pickle.dumps(system)).equations == system.equations


def test_distance_of_points_moved_off_the_set(rng):
    system = System((CURVED,))
    q, solved = system.solve(rng.uniform(-pi, pi, (100, 3)))
    gradient = CURVED.gradient(q)
    steep = solved & (np.linalg.norm(gradient, axis=1) > 0.2)
    off = q + 1e-5 * gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
    length, foot = system.nearest(off[steep])
    np.testing.assert_allclose(length, 1e-5, rtol=1e-3)
    np.testing.assert_allclose(foot, q[steep], atol=1e-8)


def test_distance_is_right_where_the_gradient_vanishes():
    q = np.array([[0.3, 0.4, 1e-5], [0.3, 0.4, pi + 2e-6], [0.3, 0.4, 0.5]])
    length, _ = System((SQUARE,)).nearest(q)
    np.testing.assert_allclose(length[:2], [1e-5, 2e-6], rtol=0.02)
    assert length[2] == np.inf


def test_nothing_to_solve_is_solved(rng):
    q = rng.uniform(-1, 1, (3, 3))
    assert System(()).solve(q)[1].all()
    assert (System(()).nearest(q)[0] == 0).all()
    assert len(System((CURVED,)).solve(q[:0])[0]) == 0


def gauss_newton(system: System, q: np.ndarray, along: np.ndarray) -> np.ndarray:
    """The same steps as the core's, one configuration at a time, with NumPy's pseudo-inverse."""
    ends = np.array(q)
    for end in ends:
        for _ in range(40):
            f, a = (array[0] for array in system.linear(end[None]))
            if np.abs(f).max() <= 1e-15:
                break
            delta = along @ (np.linalg.pinv(a @ along, rcond=1e-7) @ f)
            end -= delta * min(1.0, 0.5 / max(np.linalg.norm(delta), 1e-300))
            if np.linalg.norm(delta) <= 1e-14:
                break
    return ends


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("free", [1, 2, 3, 4])
def test_the_way_to_a_solution_is_gauss_newtons(rng, count, free):
    """Fewer equations than directions and more; the bits do not depend on neighbours in the batch."""
    equations = tuple(
        Equation(
            tuple(
                Term(
                    float(rng.normal()),
                    kind,
                    tuple(rng.integers(-2, 3, 4).tolist()),
                    (0, 0, 0, int(rng.integers(0, 2))),
                )
                for kind in ("sin", "cos", "cos")
            )
        )
        for _ in range(count)
    )
    system, along = System(equations), np.linalg.qr(rng.normal(size=(4, 4)))[0][:, :free]
    q = rng.uniform(-2, 2, (40, 4))
    ends, solved = system.solve(q, along=along)
    reference = gauss_newton(system, q, along)
    alike = np.linalg.norm(ends - reference, axis=1) < 1e-6
    assert alike[solved].mean() > 0.9 if solved.any() else count > free  # chaotic starts may part
    assert solved.any() or count > free
    np.testing.assert_allclose((ends - q) @ (np.eye(4) - along @ along.T), 0.0, atol=1e-12)
    np.testing.assert_array_equal(solved, np.abs(system.values(ends)).max(axis=1) <= SOLVED)
    one_by_one = np.concatenate([system.solve(row[None], along=along)[0] for row in q])
    np.testing.assert_array_equal(one_by_one, ends)


def test_no_direction_to_go_is_no_motion(rng):
    q = rng.uniform(-1, 1, (5, 3))
    ends, solved = System((CURVED,)).solve(q, along=np.zeros((3, 0)))
    np.testing.assert_array_equal(ends, q)
    assert not solved.any()


def test_many_pinned_joints_are_solved_together(rng):
    """A family of the longest arm that is read has an equation for each of its joints but one."""
    units = np.eye(MOST_JOINTS, dtype=int)
    pins = tuple(vanishing_on(tuple(unit), (0.0, pi), periodic=True) for unit in units[1:])
    ends, solved = System(pins).solve(rng.uniform(-0.9, 0.9, (3, MOST_JOINTS)))
    assert solved.all()
    np.testing.assert_allclose(ends[:, 1:], 0.0, atol=1e-12)
