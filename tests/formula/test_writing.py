"""One condition in text, LaTeX, Python, C and as an equation: known ones word for word, all of them the same zeros."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rankdrop.algebra.ring import Ring
from rankdrop.exact.arm.chain import exact_chain
from rankdrop.formula.notation import Python
from rankdrop.formula.writing import Condition
from rankdrop.robot.open import open_robot

LETTERS = {"a": 0.635, "d": 6.85}


def atoms(name, **options):
    chain = exact_chain(open_robot(name), **options)
    rows = [[column[i] for column in chain.columns] for i in range(6)]
    found = chain.ring.factor(chain.ring.determinant(rows)).atoms
    return chain, [Condition(chain.ring, atom.f) for atom, _ in found if not atom.is_pin]


@pytest.mark.parametrize(
    ("robot", "texts"),
    [
        ("puma560", ["a3 s3 + d4 c3 = 0", "a2 c2 + a3 c23 − d4 s23 = 0"]),
        ("ur5", ["a2 c2 + a3 c23 + d5 s234 = 0"]),
        ("stanford", ["q3 = 0"]),
    ],
)
def test_known_determinants_read_as_in_textbooks(robot, texts):
    _, conditions = atoms(robot)
    assert [condition.text() for condition in conditions] == texts


def test_latex_of_a_known_determinant():
    _, conditions = atoms("puma560")
    assert conditions[1].latex() == "a_2 c_2 + a_3 c_{23} - d_4 s_{23} = 0"


def test_numeric_lengths_are_whole_numbers_or_six_digits():
    _, (condition,) = atoms("ur5", lengths="numbers")
    assert condition.text() == "8500 c2 + 7845 c23 − 1893 s234 = 0"  # a2, a3 < 0 < d5
    ring = Ring([1])
    f = ring.to_half(12345678901 * ring.c[1] + 7654321098).f
    assert Condition(ring, f).text() == "c1 + 0.62 = 0"
    assert "7654321098" in Condition(ring, f).code(Python())


@pytest.fixture(scope="module")
def ring():
    return Ring([3, 4, 5, 10], [2], ["a", "d"])


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda r: r.t[3] + r.t[5], "θ3 + θ5 = 0"),
        (lambda r: r.t[3] * r.t[5] + 1, "θ5 = θ3 + π"),
        (lambda r: r.t[3] - r.t[5], "θ5 = θ3"),
        (lambda r: r.t[3] * r.t[5] - 1, "θ3 + θ5 = π"),
        (lambda r: 1 + r.t[3] - r.t[5] + r.t[3] * r.t[5], "θ5 = θ3 + π/2"),
        (lambda r: 1 - r.t[3] - r.t[5] - r.t[3] * r.t[5], "θ3 + θ5 = π/2"),
        (lambda r: 4 * r.t[3] - 3, "θ3 = 1.287 rad (73.74°)"),
        (lambda r: r.t[3] - r.t[10], "θ10 = θ3"),
        (lambda r: r.t[3] + r.t[4] + r.t[5] - r.t[3] * r.t[4] * r.t[5], "θ3 + θ4 + θ5 = 0"),
        (lambda r: 5 * r.q_half[2] - 1, "q2 = 0.2 m"),
        (lambda r: r.q_half[2] + r.letter_half["a"], "a + q2 = 0"),
        (lambda r: r.letter_half["a"] * r.t[4] - r.letter_half["d"], "a sin(θ4/2) = d cos(θ4/2)"),
    ],
)
def test_short_conditions_read_as_relations(ring, make, text):
    condition = Condition(ring, make(ring))
    assert condition.text() == text
    assert_same_zeros(condition)


def test_joints_of_two_digits_are_not_ambiguous(ring):
    a, d = ring.letter["a"], ring.letter["d"]
    f = ring.to_half(a * ring.c[10] + d * (ring.c[3] * ring.c[10] - ring.s[3] * ring.s[10])).f
    condition = Condition(ring, f)
    assert condition.text() == "a c(θ10) + d c(θ3 + θ10) = 0"
    assert condition.latex() == r"a \cos(\theta_{10}) + d \cos(\theta_3 + \theta_{10}) = 0"
    assert condition.joints == (3, 10)


def test_kg_eq_26_stays_readable_with_half_angles(ring):
    """KG eq. 26: d cos(θ4/2) = a sin(θ3 + θ4/2)."""
    a, d = ring.letter_half["a"], ring.letter_half["d"]
    t3, t4 = ring.t[3], ring.t[4]
    f = d * (1 + t3**2) - a * (2 * t3 + t4 * (1 - t3**2))
    assert Condition(ring, f).text() == "a sin(θ3 + θ4/2) = d cos(θ4/2)"
    assert Condition(ring, f).latex() == r"a \sin(\theta_3 + \tfrac{\theta_4}{2}) = d \cos(\tfrac{\theta_4}{2})"


def assert_same_zeros(condition, shifts=(0.1, 0.0, 0.3, -0.7, 1.1, 0, 0, 0, 0, 2.0)):
    """Expression, equation and polynomial are proportional at random configurations, with shifts, as they should."""
    rng = np.random.default_rng(5)
    ring, ratios = condition.ring, []
    f = condition.polynomial
    terms = [([int(e) for e in powers], float(value.p) / float(value.q)) for powers, value in f.terms()]
    equation = condition.equation(LETTERS, 10, shifts)
    text = condition.code(Python(shifts=shifts))
    scope = {"sin": math.sin, "cos": math.cos, "pi": math.pi}
    for _ in range(8):
        q = rng.uniform(-3, 3, 10)
        theta = q + np.array(shifts)
        at = [math.tan(theta[j - 1] / 2) for j in ring.revolute]
        at += [q[j - 1] for j in ring.prismatic] + [LETTERS[name] for name in ring.letters]
        value = sum(c * math.prod(x**e for x, e in zip(at, powers, strict=True)) for powers, c in terms)
        for j, degree in zip(ring.revolute, f.degrees(), strict=False):
            value *= math.cos(theta[j - 1] / 2) ** int(degree)
        names = {f"q{j}": x for j, x in enumerate(q, 1)} | scope
        ratios.append((eval(text, names | LETTERS) / value, equation(q) / value))
    assert np.isfinite(ratios).all()
    assert np.array(ratios) == pytest.approx(np.broadcast_to(ratios[0], (8, 2)), rel=1e-7)


@pytest.mark.parametrize("robot", ["puma560", "ur5", "stanford"])
def test_expression_and_equation_have_the_zeros_of_the_polynomial(robot):
    chain, conditions = atoms(robot)
    assert conditions
    for condition in conditions:
        equation = condition.equation(chain.numbers, chain.n, chain.shifts)
        scope = {"sin": np.sin, "cos": np.cos, "pi": np.pi}
        q = np.random.default_rng(1).uniform(-3, 3, (20, chain.n))
        text = condition.code(Python(shifts=chain.shifts))
        values = eval(text, scope | chain.numbers | {f"q{j + 1}": q[:, j] for j in range(chain.n)})
        ratio = equation(q) / values
        assert ratio == pytest.approx(np.full(20, ratio[0]), rel=1e-9)


def test_letters_that_make_two_terms_one_are_added_up(ring):
    a, d = ring.letter["a"], ring.letter["d"]
    f = ring.to_half((a + d) * ring.c[3] + a * d).f
    equation = Condition(ring, f).equation({"a": 1.0, "d": 3.0}, 5)
    assert equation.pretty() == "cos θ3 + 0.75"
