"""Equations: value, gradient, text, torus parity, and the conditions that hold on given values only."""

from __future__ import annotations

import pickle
from math import pi

import numpy as np
import pytest

from rankdrop import _core
from rankdrop.errors import ConfigurationError, OptionError
from rankdrop.families.linear_conditions import vanishing_on
from rankdrop.formula.equation import Equation, System, Term, normalised_equation, pretty_angle

N = 4


def random_equation(rng: np.random.Generator, *, powers: bool) -> Equation:
    terms = []
    for _ in range(rng.integers(1, 9)):
        harmonics = tuple(int(h) for h in rng.integers(-4, 5, N))
        p = tuple(int(x) for x in rng.integers(0, 3, N)) if powers else (0,) * N
        kind = "sin" if rng.integers(2) and any(harmonics) else "cos"
        terms.append(Term(float(rng.normal()), kind, harmonics, p, float(rng.choice([0.0, 0.7, -0.3]))))
    return Equation(tuple(terms))


def evaluated(text: str, q: np.ndarray) -> np.ndarray:
    names = {f"q{j + 1}": q[..., j] for j in range(q.shape[-1])}
    return np.broadcast_to(eval(text, {"sin": np.sin, "cos": np.cos, "pi": pi, **names}), q.shape[:-1])


def test_it_is_pickled_after_it_was_used(rng):
    equation = random_equation(rng, powers=True)
    equation.gradient(np.zeros((1, N)))
    assert equation.compiled is not None
    assert pickle.loads(pickle.dumps(equation)) == equation


@pytest.mark.parametrize("powers", [False, True])
def test_gradient_agrees_with_central_differences(rng, powers):
    for _ in range(30):
        equation = random_equation(rng, powers=powers)
        q = rng.uniform(-3, 3, (7, N))
        step = 1e-6 * np.eye(N)
        numeric = np.stack([(equation(q + s) - equation(q - s)) / 2e-6 for s in step], axis=-1)
        np.testing.assert_allclose(equation.gradient(q), numeric, atol=2e-6)


@pytest.mark.parametrize("powers", [False, True])
def test_every_instruction_set_gives_the_same_bits(rng, powers):
    equations = tuple(random_equation(rng, powers=powers) for _ in range(5))
    q, before, seen = rng.uniform(-3, 3, (37, N)), _core.instruction_set(), []
    try:
        for name in _core.instruction_sets():
            _core.choose_instruction_set(name)
            seen.append((*System(equations).linear(q), System(equations[:2]).solve(q)[0]))
    finally:
        _core.choose_instruction_set(before)
    for arrays in seen[1:]:
        for got, want in zip(arrays, seen[0], strict=True):
            np.testing.assert_array_equal(got, want)


@pytest.mark.parametrize("powers", [False, True])
def test_text_evaluates_to_the_same_value_for_arrays_and_numbers(rng, powers):
    for _ in range(60):
        equation = random_equation(rng, powers=powers)
        q = rng.uniform(-3, 3, (5, N))
        np.testing.assert_allclose(evaluated(equation.text(), q), equation(q), atol=1e-12)
        assert float(evaluated(equation.text(), q[0])) == pytest.approx(float(equation(q[0])), abs=1e-12)


def test_goes_to_a_dictionary_and_back_unchanged(rng):
    for _ in range(20):
        equation = random_equation(rng, powers=True)
        assert Equation.from_dict(equation.to_dict()) == equation


def test_leading_axes_and_empty_batches():
    equation = vanishing_on((0, 1, 0, 0), (0.0, pi), periodic=True)
    assert equation(np.zeros((2, 3, N))).shape == (2, 3)
    assert equation.gradient(np.zeros((2, 3, N))).shape == (2, 3, N)
    assert equation(np.zeros((0, N))).shape == (0,)


def test_wrong_number_of_joints_is_said():
    with pytest.raises(ConfigurationError, match=r"allowed: \(\.\.\., 4\)"):
        vanishing_on((0, 1, 0, 0), (0.0,), periodic=True)(np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ((0.0, pi), "sin(q2)"),
        ((pi / 2, -pi / 2), "cos(q2)"),
        ((0.0,), "sin(q2/2)"),
        ((pi,), "cos(q2/2)"),
        ((0.3,), "sin((q2-0.3)/2)"),
        ((0.3, 0.3 - pi), "sin(q2-0.3)"),
    ],
)
def test_simple_value_sets_have_the_short_form(values, text):
    assert vanishing_on((0, 1, 0, 0), values, periodic=True).text() == text


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_holds_exactly_at_the_values_and_nowhere_else(rng, count):
    values = np.sort(rng.uniform(-3, 3, count))
    equation = vanishing_on((0, 0, 1, 0), tuple(values), periodic=True)
    q = np.zeros((count, N))
    q[:, 2] = values
    np.testing.assert_allclose(equation(q), 0, atol=1e-13)
    fine = np.zeros((4001, N))
    fine[:, 2] = np.linspace(-pi, pi, 4001)
    assert np.count_nonzero(np.diff(np.sign(equation(fine)))) == count
    assert equation.parity is not None


def test_a_relation_holds_at_its_constant():
    equation = vanishing_on((0, 1, 0, -1), (pi,), periodic=True)
    assert equation.text() == "cos((q2-q4)/2)"
    assert float(equation([5.0, 0.4 + pi, 1.0, 0.4])) == pytest.approx(0, abs=1e-15)
    assert equation.joints == (2, 4)


def test_prismatic_values_give_a_polynomial():
    equation = vanishing_on((0, 0, 1, 0), (0.25, -0.5), periodic=False)
    assert equation.pretty() == "q3² + 0.25 q3 − 0.125"
    assert vanishing_on((0, 0, 1, 0), (0.0,), periodic=False).text() == "q3"


def test_zero_set_is_the_same_after_a_whole_turn(rng):
    """d·cos(θ4/2) = a·sin(θ3 + θ4/2): the sign changes with 2π in θ4, the zero set does not."""
    zero = (0,) * N
    equation = Equation((Term(1.0, "cos", (0, 0, 0, 1), zero), Term(-0.3, "sin", (0, 0, 2, 1), zero)))
    assert equation.parity == (0, 0, 0, 1)
    q = rng.uniform(-3, 3, (20, N))
    turned = q + 2 * pi * np.array([0, 0, 0, 1])
    np.testing.assert_allclose(equation(turned), -equation(q), atol=1e-12)
    mixed = Equation((*equation.terms, Term(1.0, "cos", (0, 0, 2, 0), zero)))
    assert mixed.parity is None


def test_pretty_is_short():
    zero = (0,) * 3
    terms = [Term(0.4318, "cos", (0, 2, 0), zero), Term(-1.0, "sin", (0, 2, 2), zero), Term(2.0, "cos", zero, zero)]
    assert Equation(tuple(terms)).pretty() == "0.4318 cos θ2 − sin(θ2+θ3) + 2"
    assert normalised_equation(terms).pretty() == "0.2159 cos θ2 − 0.5 sin(θ2+θ3) + 1"
    noise = Term(1e-14, "cos", (2, 2, 0), (0, 0, 0))
    assert Equation((noise, *terms)).pretty() == "0.4318 cos θ2 − sin(θ2+θ3) + 2"
    angles = [pretty_angle(x) for x in (0, pi, -pi / 2, 2 * pi / 3, pi / 12, 0.5)]
    assert angles == ["0", "π", "−π/2", "2π/3", "π/12", "0.5"]


@pytest.mark.parametrize(
    ("terms", "what"),
    [
        ((), "at least one term"),
        ((Term(1.0, "tan", (0,), (0,)),), "unknown kind"),
        ((Term(1.0, "sin", (0, 2), (0,)),), "different numbers"),
    ],
)
def test_bad_terms_are_refused(terms, what):
    with pytest.raises(OptionError, match=what):
        Equation(terms)
