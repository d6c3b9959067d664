"""Fitting: planted varieties come back with their coefficients, and what is not there is not found."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from rankdrop.families.library import FitProblem, circuits, holds, hypersurface, library, size, vanishing
from rankdrop.formula.equation import Equation, System, Term
from rankdrop.tolerances import DEFAULT

N = 5


def term(c: float, kind: str, harmonics: dict[int, int], powers: dict[int, int] | None = None) -> Term:
    """Twice the harmonics, by joint number from 1."""
    wave = tuple(harmonics.get(j, 0) for j in range(1, N + 1))
    return Term(c, kind, wave, tuple((powers or {}).get(j, 0) for j in range(1, N + 1)))


SHOULDER = Equation((term(0.9, "cos", {2: 2}), term(0.7, "cos", {2: 2, 3: 2}), term(-1.0, "sin", {2: 2, 3: 2, 4: 2})))
HALF_ANGLE = Equation((term(1.0, "cos", {4: 1}), term(-0.31, "sin", {3: 2, 4: 1})))
ANGLES = ("angle",) * N
HELICAL = Equation((term(1.0, "sin", {2: 2, 5: 2}), term(0.3, "cos", {2: 2}, {5: 1})))
SLIDING = Equation((term(1.0, "sin", {2: 2}, {5: 1}), term(0.4, "cos", {3: 2}), term(-0.2, "cos", {}, {5: 2})))


def points_on(equations, rng, count, spread=pi):
    start = rng.uniform(-spread, spread, (3 * count, N))
    q, solved = System(tuple(equations)).solve(start)
    return q[solved][:count]


def fit(points, kinds=("angle",) * N, highest=4) -> FitProblem:
    return FitProblem(lambda count: points, N, kinds, highest, 1e10, DEFAULT)


def coefficients(equation: Equation) -> dict:
    return {(t.kind, t.harmonics, t.powers): t.coefficient for t in equation.terms}


@pytest.mark.parametrize(
    ("planted", "joints", "kinds"),
    [
        (SHOULDER, (1, 2, 3), ANGLES),
        (HALF_ANGLE, (2, 3), ANGLES),
        (SLIDING, (1, 2, 4), (*ANGLES[:4], "length")),
        (HELICAL, (1, 4), (*ANGLES[:4], "both")),
    ],
    ids=["shoulder", "half angle", "prismatic powers", "helical"],
)
def test_planted_equation_comes_back_to_1e_9(rng, planted, joints, kinds):
    points = points_on([planted], rng, 500, spread=2.0)
    found = hypersurface(fit(points, kinds), joints)
    assert found is not None
    want, got = coefficients(planted), coefficients(found)
    assert want.keys() == got.keys()
    ratio = np.array([got[key] / want[key] for key in want])
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)
    assert holds(found, points_on([planted], np.random.default_rng(5), 200), 1e-9)


def test_half_integer_parity_is_kept(rng):
    found = hypersurface(fit(points_on([HALF_ANGLE], rng, 300)), (2, 3))
    assert found is not None
    assert found.parity == (0, 0, 0, 1, 0)


def test_a_union_of_two_comes_back_as_their_product(rng):
    other = Equation((term(1.0, "sin", {2: 2, 3: -2}), term(0.5, "cos", {3: 2})))
    one = Equation((term(1.0, "cos", {2: 2}), term(0.6, "cos", {2: 2, 3: 2})))
    points = np.concatenate([points_on([one], rng, 200), points_on([other], rng, 200)])
    found = hypersurface(fit(rng.permutation(points)), (1, 2))
    assert found is not None
    assert holds(found, points_on([one], np.random.default_rng(6), 100), 1e-8)
    assert holds(found, points_on([other], np.random.default_rng(7), 100), 1e-8)


def test_a_generic_cloud_satisfies_nothing(rng):
    assert hypersurface(fit(rng.uniform(-pi, pi, (900, N))), (1, 2, 3)) is None


def test_too_few_points_are_not_fitted(rng):
    assert hypersurface(fit(points_on([SHOULDER], rng, 12)), (1, 2, 3)) is None


def test_points_that_do_not_belong_refute_the_fit(rng):
    points = points_on([SHOULDER], rng, 400)
    points[7::8] = rng.uniform(-pi, pi, points[7::8].shape)  # the held-out ones
    assert hypersurface(fit(points), (1, 2, 3)) is None


def test_used_up_work_ends_the_fit(rng):
    points = points_on([SHOULDER], rng, 400)
    poor = FitProblem(lambda count: points, N, ANGLES, 4, 10.0, DEFAULT)
    assert hypersurface(poor, (1, 2, 3)) is None


def test_circuits_are_the_minimal_bound_sets(rng):
    """sin θ1 = 0 pins a joint; HALF_ANGLE binds 3 and 4; joint 2 and 5 are free."""
    pin = Equation((term(1.0, "sin", {1: 2}),))
    q = points_on([pin, HALF_ANGLE], rng, 6)
    a = System((pin, HALF_ANGLE)).jacobian(q)
    conormal = np.linalg.pinv(a) @ a
    assert circuits(np.eye(N) - conormal, tuple(range(N))) == [(0,), (2, 3)]


def test_library_spans_what_it_says(rng):
    for degrees in [(1, 1), (2, 2), (3, 1), (4, 2)]:
        functions = library(degrees, ANGLES[:2])
        assert len(functions) == size(degrees, ANGLES[:2])
        assert np.linalg.matrix_rank(functions(rng.uniform(-pi, pi, (300, 2)))) == size(degrees, ANGLES[:2])
    sliding = library((2, 2), ("angle", "length"))
    assert len(sliding) == 9
    assert np.linalg.matrix_rank(sliding(rng.uniform(-1, 1, (100, 2)))) == 9


def test_null_space_has_the_dimension_of_the_multiples(rng):
    """Principal ideal: multidegree d leaves Π(d_j − deg_j + 1) multiples of the generator."""
    x = points_on([HALF_ANGLE], rng, 400)[:, (2, 3)]
    for degrees, dimension in [((2, 1), 1), ((2, 2), 2), ((4, 2), 6), ((4, 4), 12)]:
        assert vanishing(library(degrees, ANGLES[:2])(x), DEFAULT).shape[1] == dimension
